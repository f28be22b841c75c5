//! What a frequency response came to.

use super::{ResponseJob, page};
use crate::frequency_response;
use crate::outcome::{Outcome, section};
use crate::record::Record;
use crate::required_density::JudgedDensity;
use crate::trouble::Result;
use proofmass_documents::{AnyCalibration, StatedQuantity};
use proofmass_dynamic::input_noise::InputNoise;
use proofmass_dynamic::measured::ResponsePower;
use proofmass_dynamic::model::{ModelFit, ResponseFigures};
use proofmass_dynamic::modes::Resonance;
use proofmass_io::Unit;
use proofmass_report::Report;
use proofmass_signal::transfer::ResponseEstimate;
use proofmass_uncertainty::{Estimate, Finding};
use serde::{Deserialize, Serialize};

/// Lines that a calibration file holds; of more, every n-th.
const MOST_LINES: usize = 400;

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseOutcome {
    pub(super) request: ResponseJob,
    pub(super) channels: [(String, String); 2],
    pub(super) unit: String,
    pub(super) independent: f64,
    pub(super) response: ResponseEstimate,
    pub(super) judged: Option<JudgedDensity>,
    pub(super) input_noise: Option<InputNoise>,
    pub(super) power: Option<ResponsePower>,
    pub(super) modes: Vec<Resonance>,
    pub(super) figures: Option<ResponseFigures>,
    pub(super) fit: Option<ModelFit>,
    pub(super) findings: Vec<Finding>,
}

/// The fitted model, which other jobs read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StoredModel {
    pub(crate) unit: String,
    pub(crate) fit: ModelFit,
}

impl StoredModel {
    /// Section of result.json.
    pub(crate) const SECTION: &'static str = "fitted_model";
}

impl ResponseOutcome {
    /// The frequency response by lines.
    pub fn response(&self) -> &ResponseEstimate {
        &self.response
    }

    /// Unit of the response.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Resonances, the lowest first.
    pub fn modes(&self) -> &[Resonance] {
        &self.modes
    }

    /// The fitted model, where one was asked for.
    pub fn fit(&self) -> Option<&ModelFit> {
        self.fit.as_ref()
    }

    /// Bandwidths, resonance, dampings.
    pub fn figures(&self) -> Option<&ResponseFigures> {
        self.figures.as_ref()
    }
}

impl Outcome for ResponseOutcome {
    const KIND: &'static str = "frequency-response-test";

    fn title(&self, record: &Record) -> String {
        record.title("Frequency response of", "Frequency response")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        match &self.fit {
            Some(fit) => StatedQuantity::list(&fit.estimate.quantities(), 0.95),
            None => self.read_off(),
        }
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        self.fit.as_ref().map(|f| &f.estimate)
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            section("modes", &self.modes)?,
            section("figures", &self.figures)?,
            section("required_spectrum", &self.judged)?,
            section(
                StoredModel::SECTION,
                &self.fit.as_ref().map(|fit| StoredModel {
                    unit: self.unit.clone(),
                    fit: fit.clone(),
                }),
            )?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        let [(_, input), (_, output)] = &self.channels;
        let (Some(unit), "m/s²") = (Unit::recognise(output), input.as_str()) else {
            return Ok(None);
        };
        let input = self.request.input(self.input_noise.as_ref());
        let Some(response) = input.frequency_response(&self.response, &self.unit, MOST_LINES)?
        else {
            return Ok(None);
        };
        let file = frequency_response::to_file(&response, "frequency response test", unit, record);
        Ok(Some(file.into()))
    }
}

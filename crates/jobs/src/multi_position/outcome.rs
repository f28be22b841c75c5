//! What a multi-position calibration found.

use super::{MultiPositionData, MultiPositionJob, page};
use crate::campaign::MethodModel;
use crate::outcome::{Outcome, section};
use crate::record::{Record, gravity_quantity};
use crate::trouble::Result;
use proofmass_documents::{
    AnyCalibration, CalibrationFile, CurvatureBlock, StatedQuantity, ThermalBlock,
};
use proofmass_io::{ColumnRef, Unit};
use proofmass_report::Report;
use proofmass_signal::Trace;
use proofmass_static::{
    CompensatedReading, DirectionCoverage, Ferraris, FormWeight, Misfit, Model, ModelEvidence,
    NextAttitude, StandstillCalibration, WindowedVariance,
};
use proofmass_uncertainty::{Estimate, Finding};
use serde::Serialize;

/// A multi-position calibration: the model with its joint covariance, the standstills, what there is to doubt.
#[derive(Clone, Debug, PartialEq)]
pub struct MultiPositionOutcome {
    pub(super) method: MethodModel,
    pub(super) planned: bool,
    pub(super) probability: f64,
    pub(super) unit: Unit,
    pub(super) quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    pub(super) calibration: StandstillCalibration,
    temperature_range: Option<[f64; 2]>,
    columns: Option<[ColumnRef; 3]>,
    pub(super) figures: Figures,
    /// What a compensated reading is worth over the sphere.
    pub(super) reading: CompensatedReading,
    /// Where to hold the sensor next.
    pub(super) next_attitudes: Vec<NextAttitude>,
    /// Shortest hold that the search needs at the rate of the recording, and that rate: s, Hz. Where standstills were searched.
    pub(super) shortest_hold: Option<[f64; 2]>,
    /// Other models of the same standstills, with the evidence for each.
    models: Vec<ModelEvidence>,
}

/// Attitudes told in advance.
const NEXT: usize = 4;

/// What is drawn of the recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// Outputs x, y, z over time, s.
    pub(crate) outputs: [Trace; 3],
    /// Windowed variance over its floor against time, where standstills were searched.
    pub(crate) windowed: Option<Trace>,
    /// Beginning and end of each standstill, s.
    pub(crate) standstills: Vec<(f64, f64)>,
}

impl Figures {
    pub(super) fn new(
        data: &MultiPositionData<'_>,
        windowed: Option<&WindowedVariance>,
        calibration: &StandstillCalibration,
    ) -> Self {
        let steady: Vec<f64>;
        let time = match data.time {
            Some(time) => time,
            None => {
                steady = (0..data.outputs[0].len())
                    .map(|i| i as f64 / data.rate)
                    .collect();
                &steady
            }
        };
        let trace = |values: &[f64]| Trace::new(time, values, Trace::RUNS);
        let at = |sample: usize| time[sample.min(time.len() - 1)];
        let segments = calibration.sweep.segments.iter();
        Self {
            outputs: data.outputs.map(trace),
            windowed: windowed.map(|w| {
                let statistic: Vec<f64> = w.statistic().iter().map(|v| v.max(1e-3)).collect();
                trace(&statistic)
            }),
            standstills: match data.tumble {
                true => Vec::new(),
                false => segments.map(|s| (at(s.start), at(s.end - 1))).collect(),
            },
        }
    }
}

impl MultiPositionOutcome {
    pub(super) fn new(
        job: &MultiPositionJob,
        data: &MultiPositionData<'_>,
        calibration: StandstillCalibration,
        findings: Vec<Finding>,
        figures: Figures,
        models: Vec<ModelEvidence>,
    ) -> Self {
        let fit = &calibration.fit;
        let gravity = gravity_quantity(fit.gravity());
        let quantities = fit.quantities();
        Self {
            method: job.method,
            planned: job.plan,
            probability: job.probability,
            unit: data.unit,
            quantities: StatedQuantity::list(quantities.iter().chain([&gravity]), job.probability),
            findings,
            temperature_range: temperature_range(data, &calibration)
                .or(job.temperature.map(|t| [t, t])),
            columns: data.columns.clone(),
            shortest_hold: figures
                .windowed
                .as_ref()
                .map(|_| [job.search.shortest_hold(data.rate), data.rate]),
            figures,
            reading: fit.compensated_reading(),
            next_attitudes: fit.next_attitudes(NEXT),
            calibration,
            models,
        }
    }

    /// The models that could be fitted, with the evidence for each.
    pub fn models(&self) -> &[ModelEvidence] {
        &self.models
    }

    /// The calibration with everything it went through.
    pub fn calibration(&self) -> &StandstillCalibration {
        &self.calibration
    }
}

fn temperature_range(
    data: &MultiPositionData<'_>,
    calibration: &StandstillCalibration,
) -> Option<[f64; 2]> {
    let temperature = data.temperature?;
    let segments = calibration.sweep.segments.iter();
    let used = segments.flat_map(|s| &temperature[s.start..s.end]).copied();
    let low = used.clone().fold(f64::INFINITY, f64::min);
    let high = used.fold(f64::NEG_INFINITY, f64::max);
    (low <= high).then_some([low, high])
}

/// Section `fit` of result.json.
#[derive(Serialize)]
struct Fit<'a> {
    #[serde(rename = "K")]
    k: [[f64; 3]; 3],
    #[serde(rename = "K_inverse")]
    k_inverse: [[f64; 3]; 3],
    b: [f64; 3],
    /// "given", or the convention by which the model chooses it.
    frame: &'static str,
    misfits: &'a [Misfit],
    compensated_reading_m_per_s2: &'a CompensatedReading,
    chi_square: Option<f64>,
    degrees_of_freedom: usize,
    birge_ratio: Option<f64>,
    excess_m_per_s2: f64,
    #[serde(skip_serializing_if = "<[FormWeight]>::is_empty")]
    scatter_forms: &'a [FormWeight],
    condition_number: f64,
    iterations: usize,
    residual_rms_m_per_s2: f64,
    ferraris: Option<Ferraris>,
    direction_coverage: &'a DirectionCoverage,
}

impl Outcome for MultiPositionOutcome {
    const KIND: &'static str = "multi-position";
    const PRINCIPAL_TABLE: &'static str = "parameters.csv";

    fn title(&self, record: &Record) -> String {
        record.title("Calibration of", "Calibration of a triaxial accelerometer")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        Some(self.calibration.fit.estimate())
    }

    fn model(&self) -> Option<String> {
        Some(self.method.name().to_owned())
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        let fit = &self.calibration.fit;
        let sensor = fit.model();
        let summary = Fit {
            k: sensor.k().0,
            k_inverse: sensor.k_inverse().0,
            b: sensor.bias(),
            frame: match (fit.attitudes_given(), fit.form()) {
                (true, _) => "given",
                (false, Model::Symmetric) => "symmetric K",
                (false, _) => "upper-triangular K",
            },
            misfits: fit.misfits(),
            compensated_reading_m_per_s2: &self.reading,
            chi_square: fit.chi_square(),
            degrees_of_freedom: fit.degrees_of_freedom(),
            birge_ratio: fit.birge_ratio(),
            excess_m_per_s2: fit.excess(),
            scatter_forms: fit.scatter_forms(),
            condition_number: fit.condition(),
            iterations: fit.iterations(),
            residual_rms_m_per_s2: fit.residual_rms(),
            ferraris: (self.method == MethodModel::Ferraris).then(|| Ferraris::of(&sensor.k().0)),
            direction_coverage: fit.coverage(),
        };
        let sweep = &self.calibration.sweep;
        Ok(vec![
            section("fit", &summary)?,
            section("standstills", &fit.residuals())?,
            section("models", &self.models)?,
            section("threshold", &sweep.threshold)?,
            section("threshold_sweep", &sweep.candidates)?,
        ])
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        let fit = &self.calibration.fit;
        let sensor = fit.model();
        let mut file = CalibrationFile::new(
            self.method.name(),
            self.unit,
            sensor.k().0,
            sensor.bias(),
            fit.estimate().clone(),
        );
        file.software = record.software.clone();
        file.columns = self.columns.as_ref().map(|c| c.to_vec());
        file.device = record.device.clone();
        file.gravity = Some(gravity_quantity(fit.gravity()));
        file.repeatability = Some(fit.excess());
        file.temperature_range = self.temperature_range;
        let reached = fit.residuals().iter().flat_map(|r| r.acceleration);
        let low = reached.clone().fold(f64::INFINITY, f64::min);
        let high = reached.fold(f64::NEG_INFINITY, f64::max);
        file.acceleration_range = Some([low, high]);
        if let Some(beyond) = fit.beyond() {
            if let (Some(thermal), Some(range)) = (beyond.thermal, beyond.range) {
                file.temperature = Some(ThermalBlock {
                    reference: thermal.reference,
                    bias: thermal.bias.to_vec(),
                    scale: thermal.scale.to_vec(),
                    range,
                    hysteresis: None,
                });
                file.temperature_range = Some(range);
            }
            file.curvature = beyond.curvature.map(|c| CurvatureBlock {
                quadratic: c.quadratic.to_vec(),
                cubic: c.cubic.to_vec(),
                reach: low.abs().max(high.abs()),
            });
        }
        file.inputs = record.inputs.clone();
        Ok(Some(file.into()))
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}

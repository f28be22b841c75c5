//! What a triaxial calibration on a shaker found.

use super::{ShakerTriaxialData, ShakerTriaxialJob, page, tables};
use crate::frequency_response;
use crate::measured_within::MeasuredWithin;
use crate::outcome::Outcome;
use crate::record::Record;
use crate::sensor_clock::SensorClock;
use crate::trouble::Result;
use proofmass_documents::{AnyCalibration, StatedQuantity};
use proofmass_dynamic::FrequencyResponse;
use proofmass_io::Unit;
use proofmass_report::Report;
use proofmass_shaker::datasheet::Datasheet;
use proofmass_shaker::recording::RunInput;
use proofmass_shaker::sample_clock::SampleClock;
use proofmass_shaker::{
    AppliedAcceleration, Budget, FrequencyCheck, OutputUnit, ShakerCalibration,
};
use proofmass_uncertainty::Finding;

/// Sensitivity matrices at every frequency with their joint covariances, every method and correction side by side; the
/// first is the result.
#[derive(Clone, Debug, PartialEq)]
pub struct ShakerTriaxialOutcome {
    quantities: Vec<StatedQuantity>,
    pub(super) findings: Vec<Finding>,
    pub(super) calibration: ShakerCalibration,
    pub(super) monte_carlo: Vec<FrequencyCheck>,
    pub(super) budget: Budget,
    pub(super) datasheet: Option<Datasheet>,
    pub(super) reference: Option<String>,
    /// Whether the runs carry accelerations of the reference, not volts.
    pub(super) acceleration: bool,
    /// Recordings among the inputs, which are the last of them.
    pub(super) recordings: usize,
    pub(super) runs: Vec<RunInput>,
    pub(super) clock: Option<SensorClock>,
    /// Whether nobody read the phases of the outputs.
    moduli: bool,
    /// Accelerations that the runs applied.
    pub(super) applied: Vec<AppliedAcceleration>,
    within: MeasuredWithin,
}

impl ShakerTriaxialOutcome {
    /// The first result as a response over frequency. Phases that nobody read, or that count from another one at every frequency, make
    /// none.
    pub(super) fn response(&self) -> Result<Option<FrequencyResponse>> {
        let own = self.clock.is_some_and(|c| c.clock == SampleClock::Own);
        match self.calibration.results.first() {
            Some(principal) if !self.moduli && !own => Ok(principal.frequency_response()?),
            _ => Ok(None),
        }
    }

    pub(super) fn new(
        job: &ShakerTriaxialJob,
        data: &ShakerTriaxialData<'_>,
        calibration: ShakerCalibration,
        monte_carlo: Vec<FrequencyCheck>,
        clock: Option<SensorClock>,
        findings: Vec<Finding>,
    ) -> Self {
        let principal = calibration.results.first();
        Self {
            quantities: principal
                .iter()
                .flat_map(|r| &r.frequencies)
                .flat_map(tables::quantities)
                .chain(clock.iter().flat_map(SensorClock::quantities))
                .collect(),
            findings,
            calibration,
            monte_carlo,
            budget: job.budget.clone(),
            datasheet: job.datasheet.clone(),
            reference: job.reference_description.clone(),
            acceleration: job.reference.is_none(),
            recordings: data.recordings,
            runs: data.runs.to_vec(),
            clock,
            moduli: job.moduli,
            applied: Vec::new(),
            within: MeasuredWithin::runs(
                job.reference.as_ref(),
                data.runs.iter().map(|r| (r.frequency, r.reference)),
            ),
        }
    }

    pub(super) fn with_applied(self, applied: Vec<AppliedAcceleration>) -> Self {
        Self { applied, ..self }
    }

    /// What each run applied along the axes of the device.
    pub fn applied(&self) -> &[AppliedAcceleration] {
        &self.applied
    }

    /// Methods and corrections side by side, suspects, differences.
    pub fn calibration(&self) -> &ShakerCalibration {
        &self.calibration
    }

    /// The stated intervals against Monte Carlo; empty when it was not asked for.
    pub fn monte_carlo(&self) -> &[FrequencyCheck] {
        &self.monte_carlo
    }
}

impl Outcome for ShakerTriaxialOutcome {
    const KIND: &'static str = "shaker-triaxial";
    const PRINCIPAL_TABLE: &'static str = "sensitivity.csv";

    fn title(&self, record: &Record) -> String {
        record.title(
            "Calibration of",
            "Calibration of a triaxial accelerometer on a shaker",
        )
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn model(&self) -> Option<String> {
        let principal = self.calibration.results.first()?;
        Some(tables::word(principal.method).to_owned())
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![self.within.section()?])
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        let Some(principal) = self.calibration.results.first() else {
            return Ok(None);
        };
        let unit = match self.budget.output {
            OutputUnit::Volt => Unit::Volt,
            OutputUnit::Acceleration => Unit::MetrePerSecondSquared,
            OutputUnit::Count => Unit::Count,
        };
        Ok(self.response()?.map(|response| {
            let model = tables::word(principal.method);
            frequency_response::to_file(&response, model, unit, record).into()
        }))
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}

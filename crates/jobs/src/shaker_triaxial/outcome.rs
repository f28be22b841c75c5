//! What a triaxial calibration on a shaker found.

use super::page::ShakerReport;
use super::{ShakerTriaxialData, ShakerTriaxialJob, tables};
use crate::frequency_response;
use crate::observed::listed;
use crate::outcome::Outcome;
use crate::record::Record;
use crate::sensor_clock::SensorClock;
use crate::trouble::Result;
use proofmass_io::{AnyCalibration, StatedQuantity, Table, Unit};
use proofmass_report::Report;
use proofmass_shaker::published::MagnitudeBudget;
use proofmass_shaker::recording::RunInput;
use proofmass_shaker::sample_clock::SampleClock;
use proofmass_shaker::{Budget, FrequencyCheck, OutputUnit, ShakerCalibration};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// Sensitivity matrices at every frequency with their joint covariances, every method and correction side by side; the
/// first is the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShakerTriaxialOutcome {
    quantities: Vec<StatedQuantity>,
    findings: Vec<Finding>,
    calibration: ShakerCalibration,
    monte_carlo: Vec<FrequencyCheck>,
    budget: Budget,
    published_budget: MagnitudeBudget,
    excluded: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    datasheet: Option<(f64, f64)>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reference: Option<String>,
    /// Whether the runs carry accelerations of the reference, not volts.
    acceleration: bool,
    /// Recordings among the inputs, which are the last of them.
    recordings: usize,
    runs: Vec<RunInput>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    clock: Option<SensorClock>,
}

impl ShakerTriaxialOutcome {
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
            published_budget: job.magnitude_budget,
            excluded: job.excluded.clone(),
            datasheet: job.datasheet,
            reference: job.reference_description.clone(),
            acceleration: job.reference.is_none(),
            recordings: data.recordings,
            runs: data.runs.to_vec(),
            clock,
        }
    }

    /// Methods and corrections side by side, suspects, differences.
    pub fn calibration(&self) -> &ShakerCalibration {
        &self.calibration
    }

    /// The stated intervals against Monte Carlo; empty when it was not asked for.
    pub fn monte_carlo(&self) -> &[FrequencyCheck] {
        &self.monte_carlo
    }

    fn page(&self, record: &Record) -> ShakerReport<'_> {
        let mut head = record.head(self.title(record), &self.findings);
        head.inputs = listed(record, self.recordings);
        if let Some(reference) = &self.reference {
            head.meta.push(("Reference".to_owned(), reference.clone()));
        }
        head.meta
            .extend(self.clock.iter().flat_map(SensorClock::lines));
        head.meta
            .push(("Runs".to_owned(), self.runs.len().to_string()));
        ShakerReport {
            head,
            datasheet: self.datasheet,
            checks: &self.monte_carlo,
        }
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

    fn tables(&self) -> Result<Vec<(String, Table)>> {
        let mut list = tables::tables(&self.calibration, self.budget.output)?;
        list.push((
            "phasors.csv".to_owned(),
            tables::phasors(&self.runs, self.acceleration, self.budget.output)?,
        ));
        if !self.monte_carlo.is_empty() {
            list.push((
                "monte-carlo.csv".to_owned(),
                tables::monte_carlo(&self.monte_carlo, self.budget.output)?,
            ));
        }
        if self.recordings > 0 {
            list.push(("recordings.csv".to_owned(), tables::recordings(&self.runs)?));
        }
        Ok(list)
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        let Some(principal) = self.calibration.results.first() else {
            return Ok(None);
        };
        // Phases that count from another one at every frequency are no response over frequency.
        if self.clock.is_some_and(|c| c.clock == SampleClock::Own) {
            return Ok(None);
        }
        let unit = match self.budget.output {
            OutputUnit::Volt => Unit::Volt,
            OutputUnit::Acceleration => Unit::MetrePerSecondSquared,
            OutputUnit::Count => Unit::Count,
        };
        Ok(principal.frequency_response()?.map(|response| {
            let model = tables::word(principal.method);
            frequency_response::to_file(&response, model, unit, record).into()
        }))
    }

    fn summary(&self, record: &Record) -> Report {
        self.page(record).summary(&self.calibration)
    }

    fn report(&self, record: &Record) -> Report {
        self.page(record).full(&self.calibration)
    }
}

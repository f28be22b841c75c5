//! `proofmass compare`: two calibrations over frequency, held against each other.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock, console};
use proofmass::io::Source;
use proofmass::jobs::comparison::{ComparisonData, ComparisonJob, ComparisonOutcome};
use proofmass::jobs::{Filed, Job, Outcome as _, Record, frequency_response};
use std::path::{Path, PathBuf};

/// Compare two calibrations of one device over frequency: E_n point by point, χ² of the whole.
///
/// Each is a calibration.json of kind frequency-response, the result.json of a test or calibration that gives one, or the table of a
/// laboratory (.csv: frequency, sensitivity, phase, uncertainties).
#[derive(clap::Args)]
pub(crate) struct Compare {
    /// The one
    first: PathBuf,
    /// The other; differences are the first less the second
    second: PathBuf,
    /// Probability of the expanded uncertainties
    #[arg(long, default_value_t = 0.95)]
    probability: f64,
    /// Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory
    #[arg(long, value_name = "K")]
    coverage: Option<f64>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Compare {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let paths: [&Path; 2] = [&self.first, &self.second];
        let folder = self.delivery.begin(ComparisonOutcome::KIND, &paths)?;
        let read = |path: &Path| -> Result<_, Failure> {
            Ok(frequency_response::read_document(
                Source::open(path)?,
                self.coverage,
            )?)
        };
        let (first, second) = (read(&self.first)?, read(&self.second)?);
        let findings = [&first.findings[..], &second.findings].concat();
        let names = paths.map(|p| p.display().to_string());
        let data = ComparisonData {
            responses: [&first.response, &second.response],
            names: [&names[0], &names[1]],
            findings: &findings,
        };
        let mut job = ComparisonJob::default();
        job.probability = self.probability;
        let outcome = job.evaluate(&data, &Progress::new())?;
        console::note(format!(
            "{} points compared",
            outcome.comparison().points.len()
        ));
        let record = Record {
            date: Some(clock::today()),
            inputs: vec![first.input, second.input],
            ..Record::default()
        };
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }
}

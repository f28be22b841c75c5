//! `proofmass compare`: two calibrations over frequency, held against each other.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock, console};
use proofmass::calibration::FrequencyResponse;
use proofmass::io::{AnyCalibration, Input, LARGEST_DOCUMENT, Source};
use proofmass::jobs::comparison::{ComparisonData, ComparisonJob, ComparisonOutcome};
use proofmass::jobs::{
    CALIBRATION, Filed, Job, Outcome as _, Record, frequency_response, read_result,
};
use proofmass::uncertainty::Finding;
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
        let (first, one, mut findings) = read(&self.first, self.coverage)?;
        let (second, other, more) = read(&self.second, self.coverage)?;
        findings.extend(more);
        let names = paths.map(|p| p.display().to_string());
        let data = ComparisonData {
            responses: [&first, &second],
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
            inputs: vec![one, other],
            ..Record::default()
        };
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }
}

fn read(
    path: &Path,
    coverage: Option<f64>,
) -> Result<(FrequencyResponse, Input, Vec<Finding>), Failure> {
    let result = path
        .file_name()
        .is_some_and(|n| n == proofmass::jobs::RESULT);
    let (calibration, input, findings) = if result {
        let (bytes, input) = Source::open(path)?.into_bytes(LARGEST_DOCUMENT)?;
        let files = read_result(&bytes)
            .and_then(|filed| filed.files())
            .map_err(|e| Failure::from(e).detail(path.display().to_string()))?;
        let Some((_, bytes)) = files.into_iter().find(|(name, _)| name == CALIBRATION) else {
            return Err(
                Failure::new(format!("{} gives no calibration", path.display())).hint(
                    "an input in m/s² and an output in a known unit make a frequency response a calibration",
                ),
            );
        };
        (AnyCalibration::from_json(&bytes)?, input, Vec::new())
    } else {
        frequency_response::read_calibration(Source::open(path)?, coverage)?
    };
    let AnyCalibration::FrequencyResponse(file) = calibration else {
        return Err(
            Failure::new(format!("{} is no frequency response", path.display())).hint(
                "give a calibration.json of kind frequency-response, its result.json, or a certificate (.csv)",
            ),
        );
    };
    Ok((frequency_response::of_file(&file)?, input, findings))
}

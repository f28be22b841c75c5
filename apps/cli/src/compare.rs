//! `proofmass compare`: calibrations over frequency, held against each other.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock, console};
use proofmass::io::{Input, Source};
use proofmass::jobs::comparison::{ComparisonData, ComparisonJob, ComparisonOutcome};
use proofmass::jobs::{Job, Outcome as _, Record, StoredResult, frequency_response};
use std::path::{Path, PathBuf};

/// Compare calibrations of one device over frequency (E_n, reference value).
///
/// Of two, E_n at each point and χ² of the whole. Of three or more, the reference value is the weighted mean of all; the median
/// and the deviation of each laboratory from both are stated. Each is a calibration.json of kind frequency-response, the result.json of a test or calibration that gives one, the folder of either, or the table of a
/// laboratory (.csv: frequency_Hz, sensitivity_V/(m/s2) or another unit, phase_deg, u_relative_% or U_relative_% with --coverage,
/// u_phase_deg).
#[derive(clap::Args)]
pub(crate) struct Compare {
    /// Two calibrations or more; of two, differences are the first less the second
    #[arg(required = true, num_args = 2.., value_name = "CALIBRATION")]
    calibrations: Vec<PathBuf>,
    /// Probability of the expanded uncertainties
    #[arg(long, value_name = "P", default_value_t = 0.95, value_parser = crate::number_arguments::probability)]
    probability: f64,
    /// Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory
    #[arg(
        short = 'k',
        long = "coverage-factor",
        alias = "coverage",
        value_name = "K",
        value_parser = crate::number_arguments::coverage_factor
    )]
    coverage: Option<f64>,
    /// Of two: entries of their budgets that are one error of both, such as reference where one standard with one calibration is behind both
    #[arg(long, value_name = "ENTRY", value_delimiter = ',')]
    common: Vec<String>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Compare {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let named: Vec<&Path> = self.calibrations.iter().map(PathBuf::as_path).collect();
        let places: Vec<PathBuf> = named
            .iter()
            .map(|path| StoredResult::calibration_place(path))
            .collect();
        let paths: Vec<&Path> = places.iter().map(PathBuf::as_path).collect();
        let folder = self.delivery.begin(ComparisonOutcome::KIND, &paths)?;
        let mut documents = Vec::with_capacity(paths.len());
        for path in &paths {
            documents.push(frequency_response::read_document(
                Source::open(path)?,
                self.coverage,
            )?);
        }
        for (i, document) in documents.iter().enumerate() {
            let digest = &document.input.sha256;
            if let Some(first) = documents[..i]
                .iter()
                .position(|d| d.input.sha256 == *digest)
            {
                let [one, other] = [first, i].map(|k| paths[k].display());
                return Err(Failure::new(format!("{one} and {other} are the same file"))
                    .hint("give each calibration once: one that counts twice makes the others look worse"));
            }
        }
        let names = distinct_endings(&named);
        let mut findings: Vec<_> = documents.iter().flat_map(|d| d.findings.clone()).collect();
        findings.extend(frequency_response::devices_apart(&documents, &names));
        if self.common.is_empty() {
            findings.extend(frequency_response::files_of_both(&documents));
        }
        let data = ComparisonData {
            responses: &documents.iter().map(|d| &d.response).collect::<Vec<_>>(),
            names: &names.iter().map(String::as_str).collect::<Vec<_>>(),
            findings: &findings,
        };
        let mut job = ComparisonJob::default();
        job.probability = self.probability;
        job.common = self.common;
        let inputs: Vec<Input> = documents.iter().map(|d| d.input.clone()).collect();
        let outcome = job.answer(&data, &inputs, &Progress::new())?;
        console::note(format!("{} points compared", outcome.points()));
        let record = Record {
            date: Some(clock::today()),
            inputs,
            ..Record::default()
        };
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

/// The shortest endings of paths that tell them apart.
fn distinct_endings(paths: &[&Path]) -> Vec<String> {
    let ending = |path: &Path, parts: usize| -> PathBuf {
        let all: Vec<_> = path.components().collect();
        all[all.len().saturating_sub(parts)..].iter().collect()
    };
    let whole = |path: &Path| path.components().count();
    paths
        .iter()
        .enumerate()
        .map(|(i, path)| {
            let alone = |parts: &usize| {
                let own = ending(path, *parts);
                let mut others = paths.iter().enumerate().filter(|(k, _)| *k != i);
                others.all(|(_, other)| ending(other, *parts) != own)
            };
            let parts = (1..=whole(path)).find(alone).unwrap_or(whole(path));
            ending(path, parts).display().to_string()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_shortest_endings() {
        let of = |paths: &[&str]| {
            let paths: Vec<&Path> = paths.iter().map(Path::new).collect();
            distinct_endings(&paths)
        };
        assert_eq!(
            of(&["/a/b/ours.csv", "/a/b/theirs.csv"]),
            ["ours.csv", "theirs.csv"]
        );
        assert_eq!(
            of(&[
                "/lab/2024/calibration.json",
                "/lab/2025/calibration.json",
                "x.csv"
            ]),
            ["2024/calibration.json", "2025/calibration.json", "x.csv"]
        );
        assert_eq!(
            of(&["calibration.json", "a/calibration.json"]),
            ["calibration.json", "a/calibration.json"]
        );
    }
}

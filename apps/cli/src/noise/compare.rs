//! `proofmass noise compare`: units or runs beside each other and against limits.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::false_alarm_rate;
use crate::{Failure, Outcome, clock, console};
use proofmass::io::Source;
use proofmass::jobs::noise_comparison::{
    NoiseComparisonData, NoiseComparisonJob, NoiseComparisonOutcome, NoiseDocument, read_limits,
};
use proofmass::jobs::{Job, Outcome as _, Record, StoredResult};
use std::path::{Path, PathBuf};

/// Compare the noise of units or runs, or a batch with the limits of a data sheet.
///
/// It reads what `proofmass noise RECORDING -o FOLDER` wrote for each of them. Channels of the same name are compared. With --limits
/// a unit passes when its whole interval lies within a limit, fails when all of it lies beyond, and is undecided in between.
#[derive(clap::Args)]
pub(crate) struct Compare {
    /// Folders (or result.json) of `proofmass noise`: two or more, or one with --limits
    #[arg(required = true, num_args = 1.., value_name = "RESULT")]
    results: Vec<PathBuf>,
    /// Limits (TOML): [[limit]] with term = "N", most = 30.0, unit = "µg/√Hz", and where wanted meaning and channels
    #[arg(long, value_name = "FILE")]
    limits: Option<PathBuf>,
    /// Probability at which equal units are called different in any coefficient
    #[arg(long, value_name = "P", default_value_t = NoiseComparisonJob::default().false_alarm_rate, value_parser = false_alarm_rate, allow_negative_numbers = true)]
    false_alarm_rate: f64,
    /// Temperature of each result in °C, in their order, of one sensor: the coefficients over the temperature, each with a slope and its
    /// interval
    #[arg(
        long,
        value_name = "T,T,…",
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true
    )]
    temperatures: Vec<f64>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Compare {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let places: Vec<PathBuf> = self
            .results
            .iter()
            .map(|r| StoredResult::place(r))
            .collect();
        let mut inputs: Vec<&Path> = places.iter().map(PathBuf::as_path).collect();
        inputs.extend(self.limits.as_deref());
        let folder = self.delivery.begin(NoiseComparisonOutcome::KIND, &inputs)?;
        let mut job = NoiseComparisonJob::default();
        job.false_alarm_rate = self.false_alarm_rate;
        job.temperatures.clone_from(&self.temperatures);
        let mut files = Vec::with_capacity(inputs.len());
        if let Some(path) = &self.limits {
            let (limits, input) = read_limits(Source::open(path)?)?;
            job.limits = limits;
            files.push(input);
        }
        let documents = places
            .iter()
            .map(|place| NoiseDocument::read(Source::open(place)?))
            .collect::<Result<Vec<_>, _>>()?;
        NoiseDocument::distinct(&documents)?;
        let names: Vec<String> = self
            .results
            .iter()
            .map(|p| p.display().to_string().trim_end_matches('/').to_owned())
            .collect();
        let data = NoiseComparisonData {
            results: &documents.iter().map(|d| &d.analysis).collect::<Vec<_>>(),
            names: &names.iter().map(String::as_str).collect::<Vec<_>>(),
        };
        files.extend(documents.iter().map(|d| d.input.clone()));
        let outcome = job.answer(&data, &files, &Progress::new())?;
        console::note(format!("{} noise results compared", documents.len()));
        let record = Record {
            date: Some(clock::today()),
            inputs: files,
            ..Record::default()
        };
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

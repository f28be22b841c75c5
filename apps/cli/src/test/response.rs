//! `proofmass test random`, `impact`, `sweep`, `steps`.

use super::channel_arguments::StandardArguments;
use crate::clock::{named, record};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::{band, not_negative, positive, two_columns, two_units};
use crate::{Failure, Outcome};
use proofmass::dynamic::model::ModelStructure;
use proofmass::io::{ColumnRef, Input, Source, Unit};
use proofmass::jobs::required_density::required_density;
use proofmass::jobs::response::{Excitation, ResponseJob, ResponseOutcome, ResponseRecordings};
use proofmass::jobs::{ChannelReading, Job, Outcome as _, StoredResult, WantedChannel};
use proofmass::signal::transfer::Estimator;
use std::path::{Path, PathBuf};

/// Channels, estimator, model: what all excitations have in common.
#[derive(clap::Args)]
pub(super) struct Common {
    /// Column of the input (reference acceleration, force; volts with --standard), by name or number (from 1) [default: the first of
    /// two beside the time]
    #[arg(long, value_name = "COLUMN")]
    input: Option<ColumnRef>,
    /// Unit of the input, where the heading does not say it: m/s², g, N, …
    #[arg(long, value_name = "UNIT")]
    input_unit: Option<Unit>,
    /// Relative standard uncertainty of the input, in per cent, common to all frequencies
    #[arg(long, value_name = "PERCENT", value_parser = not_negative, default_value = "0")]
    input_uncertainty: f64,
    /// Column of the device [default: the other one]
    #[arg(long, value_name = "COLUMN", alias = "column")]
    output_column: Option<ColumnRef>,
    /// Unit of the output, where the heading does not say it
    #[arg(long, value_name = "UNIT")]
    output_unit: Option<Unit>,
    /// Columns of input and output in one: --input and --output-column
    #[arg(long, value_name = "INPUT,OUTPUT", value_parser = two_columns, conflicts_with_all = ["input", "output_column"])]
    columns: Option<[ColumnRef; 2]>,
    /// Unit of both columns, or one of each as UNIT,UNIT, where the headings do not say it
    #[arg(long, value_name = "UNIT", value_parser = two_units, conflicts_with_all = ["input_unit", "output_unit"])]
    unit: Option<[Unit; 2]>,
    /// Lowest and highest frequency in hertz
    #[arg(long, value_name = "LOW,HIGH", value_parser = band)]
    band: Option<[f64; 2]>,
    /// Frequency in hertz to whose modulus bandwidths refer [default: the lowest]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    reference_frequency: Option<f64>,
    /// Model to fit: elements of 1mode … 4modes, high-pass, delay, low-pass=ORDER, joined by +
    #[arg(long, value_name = "ELEMENTS")]
    model: Option<ModelStructure>,
    #[command(flatten)]
    standard: StandardArguments,
    #[command(flatten)]
    clock: ChannelReading,
    #[command(flatten)]
    delivery: Delivery,
}

/// Frequency response (FRF) from random excitation: H1, H2 or Hv.
///
/// With coherence, 95 % intervals, resonances, bandwidths and a fitted model.
#[derive(clap::Args)]
pub(super) struct Random {
    /// Recording of input and output
    recording: PathBuf,
    /// Samples per segment [default: by the record]
    #[arg(long, value_name = "SAMPLES")]
    segment: Option<usize>,
    /// Where the noise is: on the output (h1), on the input (h2), on both (hv) [default: h1, with U for noise on either]
    #[arg(long, value_enum)]
    estimator: Option<Choice>,
    /// Ratio of the densities of output noise to input noise, for hv, in the square of the unit of the response
    #[arg(long, value_name = "RATIO", value_parser = positive, required_if_eq("estimator", "hv"))]
    noise_ratio: Option<f64>,
    /// Spectrum that is required of the input: a table (.csv, .toml) or the word of a published one, as of `test motion`
    #[arg(long, value_name = "PROFILE")]
    required: Option<String>,
    /// Distance of the lines of that spectrum in hertz [default: 5, or half of its lowest frequency]
    #[arg(long, value_name = "HZ", value_parser = positive, requires = "required")]
    resolution: Option<f64>,
    #[command(flatten)]
    common: Common,
}

/// Frequency response (FRF) from impacts of a hammer.
///
/// One or several impacts to a recording; double and incomplete ones are left out.
#[derive(clap::Args)]
pub(super) struct Impact {
    /// Recordings of force and response
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// Samples of each impact [default: up to the next one]
    #[arg(long, value_name = "SAMPLES")]
    segment: Option<usize>,
    /// Samples to either side of the greatest force that are kept of the force [default: all]
    #[arg(long, value_name = "SAMPLES")]
    force_window: Option<usize>,
    /// Where the noise is: on the output (h1), on the input (h2), on both (hv) [default: h1, with U for noise on either]
    #[arg(long, value_enum)]
    estimator: Option<Choice>,
    /// Ratio of the densities of output noise to input noise, for hv
    #[arg(long, value_name = "RATIO", value_parser = positive, required_if_eq("estimator", "hv"))]
    noise_ratio: Option<f64>,
    #[command(flatten)]
    common: Common,
}

/// Frequency response (FRF) from a swept sine, linear or logarithmic.
///
/// By local polynomials over the whole record.
#[derive(clap::Args)]
pub(super) struct Sweep {
    /// Recording of input and output
    recording: PathBuf,
    /// Lines of the record joined to one of the result
    #[arg(long, value_name = "LINES")]
    smoothing: Option<usize>,
    #[command(flatten)]
    common: Common,
}

/// Frequency response (FRF) from a stepped sine.
///
/// The steps are found, and a sine is fitted to both channels in each. One recording with all steps, or one for each frequency.
/// A step holds at least twelve periods; its first three tenths are left out while the device settles.
#[derive(clap::Args)]
pub(super) struct Steps {
    /// Recordings of input and output
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    common: Common,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Choice {
    H1,
    H2,
    Hv,
}

fn estimator(choice: Option<Choice>, noise_ratio: Option<f64>) -> Option<Estimator> {
    choice.map(|choice| match (choice, noise_ratio) {
        (Choice::H2, _) => Estimator::H2,
        (Choice::Hv, Some(noise_ratio)) => Estimator::Hv { noise_ratio },
        _ => Estimator::H1,
    })
}

impl Random {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut job = ResponseJob::new(Excitation::Random);
        job.segment = self.segment;
        job.estimator = estimator(self.estimator, self.noise_ratio);
        job.resolution = self.resolution;
        let mut files = vec![];
        if let Some(word) = &self.required {
            let (profile, input) = required_density(word)?;
            job.required = Some(profile);
            files.extend(input.map(|input| (PathBuf::from(word), input)));
        }
        self.common.run_with(job, &[self.recording], files)
    }
}

impl Impact {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut job = ResponseJob::new(Excitation::Impact);
        job.segment = self.segment;
        job.force_window = self.force_window;
        job.estimator = estimator(self.estimator, self.noise_ratio);
        self.common.run(job, &self.recordings)
    }
}

impl Sweep {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut job = ResponseJob::new(Excitation::Sweep);
        job.segment = self.smoothing;
        self.common.run(job, &[self.recording])
    }
}

impl Steps {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        self.common
            .run(ResponseJob::new(Excitation::Steps), &self.recordings)
    }
}

impl Common {
    fn run(self, job: ResponseJob, paths: &[PathBuf]) -> Result<Outcome, Failure> {
        self.run_with(job, paths, Vec::new())
    }

    /// `others` were read already.
    fn run_with(
        self,
        mut job: ResponseJob,
        paths: &[PathBuf],
        others: Vec<(PathBuf, Input)>,
    ) -> Result<Outcome, Failure> {
        let mut inputs: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
        inputs.extend(others.iter().map(|(path, _)| path.as_path()));
        inputs.extend(self.standard.standard.as_deref());
        let folder = self.delivery.begin(ResponseOutcome::KIND, &inputs)?;
        job.band = self.band;
        job.model = self.model;
        job.reference_frequency = self.reference_frequency;
        job.input_uncertainty = 1e-2 * self.input_uncertainty;
        let certificate = self.standard.read()?;
        job.standard = certificate.as_ref().map(|c| c.table.clone());
        let sources = paths.iter().map(Source::open);
        let mut sources = sources.collect::<Result<Vec<_>, _>>()?;
        let [input, output] = match self.columns {
            Some(both) => both.map(Some),
            None => [self.input, self.output_column],
        };
        let roles = [
            ("--input", input.as_ref()),
            ("--output-column", output.as_ref()),
        ];
        let [input_unit, output_unit] = match self.unit {
            Some(both) => both.map(Some),
            None => [self.input_unit, self.output_unit],
        };
        let Some(first) = sources.first_mut() else {
            return Err(Failure::new("no recording was given"));
        };
        let chosen = self.clock.columns(first, &roles)?;
        let [input, output] = <[ColumnRef; 2]>::try_from(chosen)
            .map_err(|_| Failure::new("input and output are two columns"))?;
        let columns = [
            WantedChannel::new(input, input_unit, "--input-unit"),
            WantedChannel::new(output, output_unit, "--output-unit"),
        ];
        let recordings = ResponseRecordings::read(sources, &self.clock, &columns)?;
        let mut data = recordings.data();
        let mut findings = data.findings.to_vec();
        findings.extend(certificate.iter().flat_map(|c| c.findings.clone()));
        data.findings = &findings;
        let mut files = recordings.inputs();
        files.extend(certificate.as_ref().map(|c| c.input.clone()));
        files.extend(others.into_iter().map(|(_, input)| input));
        let outcome = job.answer(&data, &files, &Progress::new())?;
        let title = match paths {
            [first, _, ..] => format!(
                "Frequency response, {} and {} more",
                named(first),
                paths.len() - 1
            ),
            _ => format!(
                "Frequency response, {}",
                named(Path::new(recordings.name()))
            ),
        };
        let record = record(title, files);
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

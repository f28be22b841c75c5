//! `proofmass test deconvolve`.

use super::channel_arguments::ChannelArguments;
use crate::clock::{named, record};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::{not_negative, positive};
use crate::{Failure, Outcome};
use proofmass::dynamic::model::ModelStructure;
use proofmass::io::Source;
use proofmass::jobs::deconvolution::{DeconvolutionJob, DeconvolutionOutcome, FittedModel};
use proofmass::jobs::{Outcome as _, StoredResult};
use std::path::PathBuf;

/// Acceleration behind an output, each sample with its uncertainty.
///
/// The model is that of `proofmass test random|impact|sweep --model …` or `proofmass test model`, with its covariance; `proofmass apply
/// --dynamic` writes the same values as a recording.
#[derive(clap::Args)]
pub(super) struct Deconvolve {
    /// result.json with a fitted model, or its folder; or a calibration over frequency (calibration.json, table of a laboratory)
    result: PathBuf,
    /// Recording of the device
    recording: PathBuf,
    #[command(flatten)]
    channel: ChannelArguments,
    /// Model to fit to a calibration over frequency: 1mode … 4modes, delay, low-pass=ORDER, joined by + [default: 1mode]
    #[arg(long, value_name = "ELEMENTS")]
    model: Option<ModelStructure>,
    /// Corner of the low-pass in hertz [default: where noise and bias together are least]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    corner: Option<f64>,
    /// Seconds at the beginning in which nothing happens [default: up to the pulse]
    #[arg(long, value_name = "SECONDS", value_parser = not_negative)]
    quiet: Option<f64>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Deconvolve {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let folder = self
            .delivery
            .begin(DeconvolutionOutcome::KIND, &[&self.result, &self.recording])?;
        let model = FittedModel::read(
            Source::open(StoredResult::place(&self.result))?,
            self.model,
            None,
        )?;
        let recording = self.channel.read(&self.recording)?;
        let mut job = DeconvolutionJob::default();
        job.corner = self.corner;
        job.quiet = self.quiet;
        let outcome = job.evaluate_recording(&model, &recording, &Progress::new())?;
        let mut record = record(
            format!("Input behind {}", named(&self.recording)),
            vec![model.input.clone(), recording.input.clone()],
        );
        record.device = model.device.clone();
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

//! `proofmass test deconvolve`.

use super::channel_arguments::{ClockArguments, not_negative, positive, unit, wanted};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock};
use proofmass::io::{Input, Source, Unit};
use proofmass::jobs::deconvolution::{DeconvolutionData, DeconvolutionJob, DeconvolutionOutcome};
use proofmass::jobs::response::ResponseOutcome;
use proofmass::jobs::{Filed, Job, Outcome as _, Record};
use std::path::PathBuf;

/// The acceleration behind a device's output, from its fitted model, with the uncertainty of every sample.
///
/// The model is that of `proofmass test random|impact|sweep --model …` or `proofmass test model`, with its covariance.
#[derive(clap::Args)]
pub(super) struct Deconvolve {
    /// result.json with a fitted model
    result: PathBuf,
    /// Recording of the device
    recording: PathBuf,
    /// Column of the device, by name or number (from 1)
    #[arg(long, value_name = "COLUMN")]
    column: String,
    /// Its unit, where the heading does not say it
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    unit: Option<Unit>,
    /// Corner of the low-pass in hertz [default: where noise and bias together are least]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    corner: Option<f64>,
    /// Seconds at the beginning in which nothing happens [default: up to the pulse]
    #[arg(long, value_name = "SECONDS", value_parser = not_negative)]
    quiet: Option<f64>,
    #[command(flatten)]
    clock: ClockArguments,
    #[command(flatten)]
    delivery: Delivery,
}

impl Deconvolve {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let folder = self
            .delivery
            .begin(DeconvolutionOutcome::KIND, &[&self.result, &self.recording])?;
        let bytes = std::fs::read(&self.result)
            .map_err(|e| Failure::new(format!("{} cannot be read: {e}", self.result.display())))?;
        let filed = Filed::<ResponseOutcome>::from_json(&bytes)
            .map_err(|e| Failure::from(e).detail(self.result.display().to_string()))?;
        let Some(fit) = filed.outcome.fit() else {
            return Err(
                Failure::new(format!("{} holds no fitted model", self.result.display()))
                    .hint("evaluate it again with --model 1mode"),
            );
        };
        let recording = self.clock.reading().read(
            Source::open(&self.recording)?,
            &[wanted(&self.column, self.unit)],
        )?;
        let Some(channel) = recording.channels.first() else {
            return Err(Failure::new("no column was chosen"));
        };
        let sensitivity = filed.outcome.unit();
        if sensitivity != "1" && !sensitivity.starts_with(&format!("{}/", channel.unit)) {
            return Err(Failure::new(format!(
                "column {:?} is in {}, the model's sensitivity in {sensitivity}",
                channel.name, channel.unit
            ))
            .hint("state the unit of the column with --unit"));
        }
        let mut job = DeconvolutionJob::default();
        job.corner = self.corner;
        job.quiet = self.quiet;
        let data = DeconvolutionData {
            fit,
            unit: sensitivity,
            channel: channel.view(),
            rate: recording.rate,
            findings: &recording.findings,
            name: &recording.name,
        };
        let outcome = job.evaluate(&data, &Progress::new())?;
        let record = Record {
            title: Some(format!("Input behind {}", self.recording.display())),
            device: filed.record.device.clone(),
            date: Some(clock::today()),
            inputs: vec![Input::of(&self.result)?, recording.input.clone()],
            ..Record::default()
        };
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }
}

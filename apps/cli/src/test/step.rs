//! `proofmass test step`.

use super::channel_arguments::{ClockArguments, unit, wanted};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock};
use proofmass::io::{Source, Unit};
use proofmass::jobs::step::{StepData, StepJob, StepOutcome};
use proofmass::jobs::{Filed, Job, Outcome as _, Record};
use std::path::PathBuf;

/// A recorded step response: natural frequency and damping fitted, rise, overshoot, settling.
#[derive(clap::Args)]
pub(super) struct Step {
    /// Recording of the step, from before it until the device has settled
    recording: PathBuf,
    /// Column of the device, by name or number (from 1)
    #[arg(long, value_name = "COLUMN")]
    column: String,
    /// Its unit, where the heading does not say it
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    unit: Option<Unit>,
    #[command(flatten)]
    clock: ClockArguments,
    #[command(flatten)]
    delivery: Delivery,
}

impl Step {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let folder = self.delivery.begin(StepOutcome::KIND, &[&self.recording])?;
        let recording = self.clock.reading().read(
            Source::open(&self.recording)?,
            &[wanted(&self.column, self.unit)],
        )?;
        let Some(channel) = recording.channels.first() else {
            return Err(Failure::new("no column was chosen"));
        };
        let data = StepData {
            channel: channel.view(),
            rate: recording.rate,
            findings: &recording.findings,
            name: &recording.name,
        };
        let outcome = StepJob::default().evaluate(&data, &Progress::new())?;
        let record = Record {
            title: Some(format!("Step response, {}", self.recording.display())),
            date: Some(clock::today()),
            inputs: vec![recording.input.clone()],
            ..Record::default()
        };
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }
}

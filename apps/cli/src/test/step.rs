//! `proofmass test step`.

use super::channel_arguments::{ChannelArguments, SensitivityArguments};
use crate::clock::{named, record};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome};
use proofmass::jobs::step::{StepData, StepJob, StepOutcome};
use proofmass::jobs::{Job, Outcome as _, StoredResult};
use std::path::PathBuf;

/// Step response: natural frequency, damping, rise time, overshoot, settling.
#[derive(clap::Args)]
pub(super) struct Step {
    /// Recording of the step, from before it until the device has settled
    recording: PathBuf,
    #[command(flatten)]
    channel: ChannelArguments,
    #[command(flatten)]
    by: SensitivityArguments,
    #[command(flatten)]
    delivery: Delivery,
}

impl Step {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let folder = self.delivery.begin(StepOutcome::KIND, &[&self.recording])?;
        let recording = self.channel.read_by(&self.recording, &self.by)?;
        let Some(channel) = recording.channels.first() else {
            return Err(Failure::new("no column was chosen").hint("add --column COLUMN"));
        };
        let data = StepData {
            channel: channel.view(),
            rate: recording.rate,
            findings: &recording.findings,
            name: &recording.name,
        };
        let mut job = StepJob::default();
        job.relative_uncertainty = self.by.relative_uncertainty();
        let inputs = vec![recording.input.clone()];
        let outcome = job.answer(&data, &inputs, &Progress::new())?;
        let record = record(format!("Step response, {}", named(&self.recording)), inputs);
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

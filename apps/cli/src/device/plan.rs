//! `proofmass device plan`: what to measure for a data sheet, and for how long.

use super::check::read_sheet_file;
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock};
use proofmass::documents::Device;
use proofmass::io::Source;
use proofmass::jobs::device_plan::{DevicePlanJob, DevicePlanOutcome, PlanConditions, SensorNoise};
use proofmass::jobs::{Job, Outcome as _, Record, StoredResult};
use std::path::{Path, PathBuf};

/// Say what to measure and for how long, so that a device with its typical values is decided by its data sheet.
///
/// Of every limit it says which command shows it, which expanded uncertainty decides it by the rule of the sheet, and what that takes:
/// the length of a recording of noise, attitudes and rests, temperatures and soak, levels, frequencies. What has to be known for that is
/// asked for at once.
#[derive(clap::Args)]
pub(crate) struct Plan {
    /// Data sheet (TOML), with a [[limit]] for each promise
    #[arg(long, value_name = "FILE", default_value = "device.toml")]
    sheet: PathBuf,
    /// result.json of `proofmass noise` of such a sensor [default: the typical values of N, B and K in the sheet]
    #[arg(long, value_name = "FILE")]
    noise_result: Option<PathBuf>,
    #[command(flatten)]
    given: PlanConditions,
    #[command(flatten)]
    delivery: Delivery,
}

impl Plan {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let mut files: Vec<&Path> = vec![&self.sheet];
        files.extend(self.noise_result.as_deref());
        let folder = self.delivery.begin(DevicePlanOutcome::KIND, &files)?;
        let (sheet, input) = read_sheet_file(&self.sheet)?;
        let mut inputs = vec![input];
        let mut job = DevicePlanJob::default();
        let mut device = sheet.device.clone();
        job.sheet = sheet;
        job.given = self.given;
        if let Some(file) = &self.noise_result {
            let (noise, input, of) = SensorNoise::of_result(Source::open(file)?)?;
            job.noise = Some(noise);
            inputs.push(input);
            if device == Device::default() {
                device = of;
            }
        }
        let outcome = job.evaluate(&(), &Progress::new())?;
        let record = Record {
            device,
            date: Some(clock::today()),
            inputs,
            ..Record::default()
        };
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

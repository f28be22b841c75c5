//! `proofmass test motion`.

use super::channel_arguments::{ChannelArguments, SensitivityArguments};
use crate::clock::{named, record};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::{band, not_negative, positive};
use crate::{Failure, Outcome};
use proofmass::jobs::motion::{MotionData, MotionJob, MotionOutcome};
use proofmass::jobs::required_density::required_density;
use proofmass::jobs::{Job, Outcome as _, StoredResult};
use proofmass::signal::Baseline;
use std::path::{Path, PathBuf};

/// Velocity, displacement, response spectrum, machine vibration of a record.
#[derive(clap::Args)]
pub(super) struct Motion {
    /// Recording with the acceleration
    recording: PathBuf,
    #[command(flatten)]
    channel: ChannelArguments,
    #[command(flatten)]
    by: SensitivityArguments,
    /// Relative standard uncertainty of the acceleration, in per cent, from the sensor's calibration
    #[arg(long, value_name = "PERCENT", value_parser = not_negative, default_value = "0")]
    uncertainty: f64,
    /// What is removed before integration: none, mean, before=SECONDS, velocity=DEGREE
    #[arg(long, value_name = "CORRECTION", default_value = "none", value_parser = baseline)]
    baseline: Baseline,
    /// Gravity of intensity and bracketed duration in m/s²
    #[arg(long, value_name = "M_PER_S2", value_parser = positive, default_value = "9.80665")]
    gravity: f64,
    /// Damping ratio of the response spectrum, in per cent
    #[arg(long, value_name = "PERCENT", value_parser = not_negative, default_value = "5")]
    damping: f64,
    /// Periods of the response spectrum in seconds [default: a hundred]
    #[arg(long, value_name = "S,S,…", value_delimiter = ',', value_parser = positive)]
    periods: Vec<f64>,
    /// Spectrum that is required: a table (.csv, .toml) or navmat-p-9492, gevs-qualification, gevs-acceptance,
    /// mil-std-810-minimum-integrity
    #[arg(long, value_name = "PROFILE")]
    required: Option<String>,
    /// Distance of the lines of that spectrum in hertz [default: 5, or half of its lowest frequency]
    #[arg(long, value_name = "HZ", value_parser = positive, requires = "required")]
    resolution: Option<f64>,
    /// Full scale of the sensor to either side in m/s², or in g as 2g: samples there are cut off
    #[arg(long, value_name = "VALUE", value_parser = full_scale)]
    full_scale: Option<f64>,
    /// Band of the vibration velocity in hertz
    #[arg(long, value_name = "LOW,HIGH", value_parser = band, default_value = "10,1000")]
    vibration_band: [f64; 2],
    #[command(flatten)]
    delivery: Delivery,
}

impl Motion {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let required = self.required.as_deref().map(required_density).transpose()?;
        let mut named_files: Vec<&Path> = vec![&self.recording];
        if let (Some(word), Some((_, Some(_)))) = (self.required.as_deref(), &required) {
            named_files.push(Path::new(word));
        }
        let folder = self.delivery.begin(MotionOutcome::KIND, &named_files)?;
        let recording = self.channel.read_by(&self.recording, &self.by)?;
        let Some(channel) = recording.channels.first() else {
            return Err(Failure::new("no column was chosen").hint("add --column COLUMN"));
        };
        let mut job = MotionJob::default();
        job.relative_uncertainty = (1e-2 * self.uncertainty).hypot(self.by.relative_uncertainty());
        job.baseline = self.baseline;
        job.gravity = self.gravity;
        job.damping = 1e-2 * self.damping;
        job.periods = self.periods;
        job.vibration_band = self.vibration_band;
        job.resolution = self.resolution;
        job.full_scale = self.full_scale;
        let mut inputs = vec![recording.input.clone()];
        if let Some((profile, input)) = required {
            job.required = Some(profile);
            inputs.extend(input);
        }
        let data = MotionData {
            channel: channel.view(),
            rate: recording.rate,
            findings: &recording.findings,
            name: &recording.name,
        };
        let outcome = job.answer(&data, &inputs, &Progress::new())?;
        let record = record(format!("Motion, {}", named(&self.recording)), inputs);
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

fn full_scale(text: &str) -> Result<f64, String> {
    let (number, factor) = match text.trim().strip_suffix('g') {
        Some(number) => (number, 9.80665),
        None => (text.trim(), 1.0),
    };
    positive(number.trim())
        .map(|v| factor * v)
        .map_err(|_| format!("{text:?} is no full scale such as 19.6 or 2g"))
}

fn baseline(text: &str) -> Result<Baseline, String> {
    let refused = || format!("{text:?} is not one of none, mean, before=SECONDS, velocity=DEGREE");
    match text.split_once('=') {
        None if text == "none" => Ok(Baseline::None),
        None if text == "mean" => Ok(Baseline::Mean),
        Some(("before", seconds)) => Ok(Baseline::BeforeMotion {
            seconds: positive(seconds).map_err(|_| refused())?,
        }),
        Some(("velocity", degree)) => Ok(Baseline::Velocity {
            degree: degree.parse().map_err(|_| refused())?,
        }),
        _ => Err(refused()),
    }
}

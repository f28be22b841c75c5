//! `proofmass bias`: the bias of a sensor over a recording with rests.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::gravity_arguments::GravityArguments;
use crate::number_arguments::{not_negative, positive};
use crate::{Failure, Outcome, clock, console};
use proofmass::io::{GivenAttitude, Source};
use proofmass::jobs::bias::{AxisNoise, BiasJob, BiasOutcome, BiasRecording};
use proofmass::jobs::{Job, Outcome as _, RecordingReading, StoredResult};
use std::path::{Path, PathBuf};

/// Track the bias over a recording from its rests (known gravity, zero velocity).
///
/// It is the filter that runs on the chip, with the noise of a `proofmass noise` result, and a smoother over the whole
/// recording. The innovations are tested against that noise.
#[derive(clap::Args)]
pub(crate) struct Bias {
    /// Recording in g or m/s² (compensate it with `proofmass apply` first)
    recording: PathBuf,
    /// result.json of `proofmass noise` of the same sensor
    #[arg(long, value_name = "FILE", required_unless_present = "white")]
    noise: Option<PathBuf>,
    /// White noise in (m/s²)/√Hz (two-sided, the Allan deviation at 1 s), in place of a noise result
    #[arg(long, value_name = "N", value_parser = positive, conflicts_with = "noise", requires = "motion")]
    white: Option<f64>,
    /// Random walk of the bias in (m/s²)·√Hz; 0 for a constant
    #[arg(long, value_name = "K", value_parser = not_negative, requires = "white", group = "motion")]
    walk: Option<f64>,
    /// Gauss–Markov bias: standard deviation in m/s² and correlation time in s
    #[arg(long, value_name = "SIGMA,TAU", value_parser = pair, requires = "white", group = "motion")]
    markov: Option<[f64; 2]>,
    /// Standard uncertainty of the bias before the first rest, in m/s²
    #[arg(long, value_name = "M_PER_S2", value_parser = positive, default_value_t = AxisNoise::INITIAL)]
    initial: f64,
    /// Direction that points up at rest: +x … -z, X,Y,Z in the frame of the sensor, or `none` for readings free of
    /// gravity [default: from the table of segments]
    #[arg(long, value_name = "DIRECTION", value_parser = up, allow_hyphen_values = true)]
    up: Option<Up>,
    /// Standard uncertainty of that direction, in degrees
    #[arg(long, value_name = "DEG", value_parser = not_negative, default_value_t = 0.0)]
    levelling: f64,
    #[command(flatten)]
    gravity: GravityArguments,
    /// Table of rests (columns start, end; up_x, up_y, up_z or direction) instead of searching for them
    #[arg(long, value_name = "FILE")]
    segments: Option<PathBuf>,
    /// Largest windowed variance of a rest, in multiples of the noise floor
    #[arg(long, default_value_t = 6.0, allow_negative_numbers = true)]
    threshold: f64,
    /// Length of the means that the filter uses, in seconds
    #[arg(long, value_name = "S", value_parser = positive, default_value_t = 0.5)]
    mean: f64,
    #[command(flatten)]
    reading: RecordingReading,
    #[command(flatten)]
    delivery: Delivery,
}

#[derive(Clone, Copy)]
enum Up {
    Along([f64; 3]),
    None,
}

fn up(text: &str) -> Result<Up, String> {
    let refused =
        || format!("{text:?} is not one of +x, -x, +y, -y, +z, -z, three numbers X,Y,Z, none");
    if text == "none" {
        return Ok(Up::None);
    }
    if let Ok(attitude) = GivenAttitude::word(text) {
        return Ok(Up::Along(attitude.direction));
    }
    let numbers: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse::<f64>().ok().filter(|v| v.is_finite()))
        .collect::<Option<_>>()
        .ok_or_else(refused)?;
    match <[f64; 3]>::try_from(numbers) {
        Ok(up) if up.iter().any(|v| *v != 0.0) => Ok(Up::Along(up)),
        _ => Err(refused()),
    }
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    let refused = || format!("{text:?} is no pair of positive numbers such as 0.002,300");
    let (deviation, time) = text.split_once(',').ok_or_else(refused)?;
    Ok([
        positive(deviation.trim()).map_err(|_| refused())?,
        positive(time.trim()).map_err(|_| refused())?,
    ])
}

impl Bias {
    fn stated_noise(&self) -> Result<[AxisNoise; 3], Failure> {
        let noise = match (self.white, self.markov, self.walk) {
            (Some(white), Some([deviation, time]), _) => AxisNoise::markov(white, deviation, time),
            (Some(white), None, Some(walk)) => AxisNoise::walk(white, walk),
            _ => {
                return Err(Failure::new("the noise of the sensor is not known")
                    .hint("name a result of `proofmass noise` with --noise, or give --white and --walk or --markov"));
            }
        };
        Ok([noise.clone(), noise.clone(), noise])
    }

    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let mut inputs: Vec<&Path> = vec![&self.recording];
        inputs.extend(self.segments.as_deref());
        inputs.extend(self.noise.as_deref());
        let folder = self.delivery.begin(BiasOutcome::KIND, &inputs)?;
        let gravity = match self.up {
            Some(Up::None) => None,
            _ => Some(self.gravity.value()?),
        };
        let watch = Progress::new();
        let recording = BiasRecording::read(
            Source::open(&self.recording)?,
            &self.reading,
            self.segments.as_deref().map(Source::open).transpose()?,
            self.noise.as_deref().map(Source::open).transpose()?,
        )?;
        let mut noise = match recording.noise() {
            Some(noise) => noise.clone(),
            None => self.stated_noise()?,
        };
        noise
            .iter_mut()
            .for_each(|axis| axis.initial = self.initial);
        let mut job = BiasJob::new(noise);
        job.gravity = gravity;
        job.standard_gravity = gravity.is_some() && self.gravity.is_standard();
        job.place = self.gravity.place();
        if let Some(Up::Along(up)) = self.up {
            job.up = Some(up);
        }
        job.levelling = self.levelling.to_radians();
        job.threshold = self.threshold;
        job.mean = self.mean;
        let record = recording.record(Some(clock::today()));
        let outcome = job.answer(&recording.data(), &record.inputs, &watch)?;
        let rests = outcome.rests().len();
        let ending = if rests == 1 { "" } else { "s" };
        console::note(format!("{rests} rest{ending}"));
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

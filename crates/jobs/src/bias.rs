//! How does the bias of an accelerometer move over a recording with rests in known attitudes?

mod noise;
mod outcome;
mod page;
mod recording;
mod tracked;

pub use noise::AxisNoise;
pub(crate) use outcome::OnChip;
pub use outcome::{BiasOutcome, BiasRest};
pub use recording::BiasRecording;
pub use tracked::TrackedBias;

use crate::findings;
use crate::outcome::Job;
use crate::standstills::found;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, Gravity, Watch};
use proofmass_static::{BiasObservations, BiasTracking, RestMean, Samples, Segment, Standstill};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// What is known of the sensor at rest, and its noise.
///
/// ```
/// use proofmass_core::Gravity;
/// use proofmass_jobs::bias::{AxisNoise, BiasData, BiasJob};
/// use proofmass_jobs::{Job, Outcome, Unwatched};
///
/// // At rest with z up, 5 mm/s² too much on x, a hundred samples a second.
/// let wave = |i: u32, k: f64| 2e-3 * (k * f64::from(i)).sin();
/// let column = |level: f64, k: f64| (0..6000).map(|i| level + wave(i, k)).collect::<Vec<f64>>();
/// let (x, y, z) = (column(5e-3, 7.1), column(0.0, 3.3), column(9.80665, 5.7));
/// let time: Vec<f64> = (0..6000).map(|i| f64::from(i) / 100.0).collect();
/// let data = BiasData {
///     outputs: [&x, &y, &z], time: &time, rate: 100.0, breaks: &[], segments: None, findings: &[], name: "at rest",
/// };
/// let noise = AxisNoise::walk(2e-4, 1e-6);
/// let mut job = BiasJob::new([noise.clone(), noise.clone(), noise]);
/// job.gravity = Some(Gravity::given(9.80665, 1e-4)?);
/// job.up = Some([0.0, 0.0, 1.0]);
/// let outcome = job.evaluate(&data, &Unwatched)?;
/// let x = &outcome.quantities()[0];
/// assert!((x.value - 5e-3).abs() < x.expanded && x.expanded < 2e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct BiasJob {
    /// Noise of x, y, z.
    pub noise: [AxisNoise; 3],
    /// Local gravity; `None` where the readings are free of it, so that the sensor reads zero at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
    /// Whether nobody stated it: standard gravity stands for it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub standard_gravity: bool,
    /// Latitude in degrees and height in metres, where the gravity is the normal one of a place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 2]>,
    /// Direction that points up, in the frame of the sensor, at every rest that does not state its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Standard uncertainty of that direction, common to all rests, rad.
    #[serde(default)]
    pub levelling: f64,
    /// Length of the means that the filter takes, s. Means become longer where there were more than five thousand, but never
    /// longer than a tenth of the time in which the bias moves.
    #[serde(default = "default_mean")]
    pub mean: f64,
    /// Largest windowed variance of a rest in multiples of the noise floor, where rests are looked for.
    #[serde(default = "default_threshold")]
    pub threshold: f64,
    /// How rests are looked for.
    #[serde(default)]
    pub search: Standstill,
    /// Coverage probability.
    #[serde(default = "default_probability")]
    pub probability: f64,
}

fn default_mean() -> f64 {
    0.5
}

fn default_threshold() -> f64 {
    6.0
}

fn default_probability() -> f64 {
    0.95
}

/// Means above which they are made longer.
const MOST_MEANS: f64 = 5000.0;

impl BiasJob {
    /// With this noise, for readings free of gravity.
    pub fn new(noise: [AxisNoise; 3]) -> Self {
        Self {
            noise,
            gravity: None,
            standard_gravity: false,
            place: None,
            up: None,
            levelling: 0.0,
            mean: default_mean(),
            threshold: default_threshold(),
            search: Standstill::default(),
            probability: default_probability(),
        }
    }

    fn rests(&self, data: &BiasData<'_>) -> Result<Vec<Segment>> {
        let samples = Samples::new(data.outputs[0], data.outputs[1], data.outputs[2])
            .map_err(|e| Trouble::from(e).detail(data.name))?;
        match data.segments {
            Some(given) => Ok(given.to_vec()),
            None => found(
                &samples,
                (data.rate, data.breaks),
                (&self.search, self.threshold),
                data.name,
            ),
        }
    }

    /// What a sensor without bias reads in a rest, and its common standard uncertainty.
    fn known(&self, rest: &Segment, number: usize) -> Result<([f64; 3], [f64; 3])> {
        let Some(gravity) = self.gravity else {
            return Ok(([0.0; 3], [0.0; 3]));
        };
        let up = rest.attitude.or(self.up).ok_or_else(|| {
            Trouble::request(format!("the attitude of rest {} is not known", number + 1)).with_hint(
                "add --up +z (or another axis that points up in all of it), or --segments FILE with a column `direction` for each rest",
            )
        })?;
        let length = up.iter().map(|v| v * v).sum::<f64>().sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return Err(Trouble::request(
                "the direction that points up has no length",
            ));
        }
        let up = up.map(|v| v / length);
        let g = gravity.value();
        let u = up.map(|c| {
            let across = (1.0 - c * c).max(0.0).sqrt();
            (c * gravity.standard_uncertainty()).hypot(g * self.levelling * across)
        });
        Ok((up.map(|c| c * g), u))
    }

    fn check(&self, data: &BiasData<'_>) -> Result<()> {
        let n = data.outputs[0].len();
        let lengths = [
            data.outputs[1].len(),
            data.outputs[2].len(),
            data.time.len(),
        ];
        if lengths.iter().any(|l| *l != n) {
            return Err(
                Trouble::data("the columns x, y, z and the time are not equally long")
                    .detail(data.name),
            );
        }
        let positive = [
            ("the sampling rate", data.rate),
            ("the length of a mean", self.mean),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Trouble::request(format!(
                    "{name} must be positive, not {value}"
                )));
            }
        }
        if !(0.0..=std::f64::consts::FRAC_PI_2).contains(&self.levelling) {
            return Err(Trouble::request(format!(
                "the uncertainty of the attitude cannot be {}",
                self.levelling
            )));
        }
        Ok(())
    }

    /// The rests as means of about `length` seconds.
    fn means(
        &self,
        data: &BiasData<'_>,
        rests: &[Segment],
        length: f64,
    ) -> Result<(Vec<RestMean>, [f64; 3])> {
        let mut means = Vec::new();
        let mut uncertainty = [0.0f64; 3];
        for (number, rest) in rests.iter().enumerate() {
            let (known, u) = self.known(rest, number)?;
            for (worst, u) in uncertainty.iter_mut().zip(u) {
                *worst = worst.max(u);
            }
            let n = rest.end.saturating_sub(rest.start);
            if n == 0 || rest.end > data.time.len() {
                return Err(Trouble::data(format!(
                    "rest {} has no samples in the recording",
                    number + 1
                ))
                .detail(data.name));
            }
            let parts = ((n as f64 / data.rate / length).round() as usize).clamp(1, n);
            for part in 0..parts {
                let range = rest.start + part * n / parts..rest.start + (part + 1) * n / parts;
                let count = range.len() as f64;
                let mean = |values: &[f64]| {
                    let first = values[range.start];
                    first + values[range.clone()].iter().map(|v| v - first).sum::<f64>() / count
                };
                means.push(RestMean {
                    time: mean(data.time),
                    duration: count / data.rate,
                    mean: data.outputs.map(mean),
                    known,
                    rest: number,
                });
            }
        }
        Ok((means, uncertainty))
    }
}

/// A recording with rests, in m/s².
#[derive(Clone, Copy, Debug)]
pub struct BiasData<'a> {
    /// Outputs x, y, z, m/s².
    pub outputs: [&'a [f64]; 3],
    /// Time of every sample, s.
    pub time: &'a [f64],
    /// Samples per second while it ran.
    pub rate: f64,
    /// Samples before which time pauses, in increasing order.
    pub breaks: &'a [usize],
    /// Rests that are given, perhaps with attitudes; without them they are found.
    pub segments: Option<&'a [Segment]>,
    /// What reading the data found.
    pub findings: &'a [Finding],
    /// What the recording is called in messages.
    pub name: &'a str,
}

impl Job for BiasJob {
    type Data<'a> = BiasData<'a>;
    type Outcome = BiasOutcome;

    fn evaluate(&self, data: &BiasData<'_>, watch: &dyn Watch) -> Result<BiasOutcome> {
        watch.step("bias", 0, 3)?;
        self.check(data)?;
        for noise in &self.noise {
            noise.check()?;
        }
        let rests = self.rests(data)?;
        watch.step("bias", 1, 3)?;
        let rested: usize = rests.iter().map(|r| r.end.saturating_sub(r.start)).sum();
        let still = rested as f64 / data.rate;
        let middle = |rest: &Segment| data.time[rest.start + (rest.end - rest.start) / 2];
        let spacing = match rests.as_slice() {
            [first, .., last] if first.end > first.start && last.end <= data.time.len() => {
                (middle(last) - middle(first)) / (rests.len() - 1) as f64
            }
            _ => 0.0,
        };
        let noise = self
            .noise
            .each_ref()
            .map(|noise| noise.model(spacing, data.rate));
        let moving = self
            .noise
            .iter()
            .map(|n| n.moves_in(spacing, data.rate))
            .fold(f64::INFINITY, f64::min);
        let length = self.mean.max((still / MOST_MEANS).min(0.1 * moving));
        let (means, known_uncertainty) = self.means(data, &rests, length)?;
        let mut tracking = BiasTracking::new(noise);
        tracking.known_uncertainty = known_uncertainty;
        tracking.motion_uncertainty = self.noise.each_ref().map(|noise| noise.uncertainty);
        tracking.probability = self.probability;
        let span = [
            data.time.first().copied().unwrap_or(0.0),
            data.time.last().copied().unwrap_or(0.0),
        ];
        let track = tracking
            .track(&BiasObservations { span, means })
            .map_err(|error| refusal(error, data))?;
        watch.step("bias", 2, 3)?;
        let mut findings = data.findings.to_vec();
        findings.extend(track.findings.iter().cloned());
        findings.extend(self.limits());
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        watch.step("bias", 3, 3)?;
        BiasOutcome::new(self, data, &rests, track, findings)
    }
}

impl BiasJob {
    /// Axes whose walk is a limit and no value.
    fn limits(&self) -> Option<Finding> {
        let axes = ["x", "y", "z"].into_iter().zip(&self.noise);
        let limited: Vec<&str> = axes
            .filter(|(_, n)| n.walk_is_limit && n.markov.is_empty())
            .map(|(name, _)| name)
            .collect();
        (!limited.is_empty()).then(|| findings::walk_is_a_limit(&limited.join(", ")))
    }
}

fn refusal(error: Error, data: &BiasData<'_>) -> Trouble {
    let trouble = Trouble::from(error).detail(data.name);
    match error {
        Error::TooFew { .. } => trouble.with_hint(
            "let the sensor rest for a second or more now and then, or name its rests in a table of segments",
        ),
        Error::NotIncreasing { .. } => {
            trouble.with_hint("look for a restart of the clock or doubled rows in the recording")
        }
        _ => trouble,
    }
}

//! The bias of an accelerometer over a recording, tracked from the stretches in which its acceleration is known.

mod axis;
mod consistency;
mod findings;

pub use axis::{AxisTrack, BiasEstimate};
pub use consistency::{Consistency, DeviatingRest};

use crate::Triple;
use proofmass_core::velocity::BiasModel;
use proofmass_core::{Error, check};
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity};

/// Noise of one axis and how its bias moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasNoise {
    /// White noise N, two-sided root density, (m/s²)/√Hz: a mean over T seconds has the variance N²/T.
    pub white: f64,
    /// How the bias moves.
    pub model: BiasModel,
    /// Standard uncertainty of a constant part beside a Gauss–Markov process, which by itself wanders about zero: what the
    /// bias is when the sensor is switched on. A random walk has it in its `initial`, and 0 here.
    pub offset: f64,
}

impl BiasNoise {
    /// The same with a bias that moves by this factor more.
    fn moving(&self, factor: f64) -> Self {
        let model = match self.model {
            BiasModel::RandomWalk { density, initial } => BiasModel::RandomWalk {
                density: density * factor * factor,
                initial,
            },
            BiasModel::GaussMarkov { deviation, time } => BiasModel::GaussMarkov {
                deviation: deviation * factor,
                time,
            },
        };
        Self { model, ..*self }
    }
}

/// Mean of a part of a rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestMean {
    /// Its middle, s.
    pub time: f64,
    /// Time its samples stand for, s.
    pub duration: f64,
    /// Mean accelerations as measured, m/s².
    pub mean: Triple,
    /// Accelerations that a sensor without bias would read: gravity in a known attitude, or zero, m/s².
    pub known: Triple,
    /// Which rest it belongs to.
    pub rest: usize,
}

/// What a recording says of the bias.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BiasObservations {
    /// When the recording begins and ends, s.
    pub span: [f64; 2],
    /// Means of the rests in the order of time.
    pub means: Vec<RestMean>,
}

/// Tracks the bias of three axes forwards (as on line) and smoothed over the whole recording.
///
/// ```text
/// ḃ = −b/τ + w  or  ḃ = w,  z_k = ã_k − a_k = b(t_k) + c + v_k,  var v_k = N²/T_k
/// ```
///
/// The filter is [`proofmass_core::BiasFilter`], the one that runs on the chip. The constant c beside a Gauss–Markov process
/// is estimated with it: the filter runs on the data and on ones, and c is the regression of the innovations of the one on
/// those of the other (the augmented filter). Back from the end runs the fixed-interval smoother.
///
/// **Assumes** that the noise is that of the noise analysis, and that the known accelerations are wrong by one common error
/// at most ([`BiasTracking::known_uncertainty`]).
/// **Errors** those of a noise or time without meaning; no rest; times that do not increase.
/// **Accuracy** 95 % intervals of filter and smoother hold the truth in 95 % of simulated recordings for both models, the
/// normalised squared errors average one; a healthy recording gets a finding in less than one of a hundred
/// (`crates/static/tests/bias_tracking.rs`).
/// **Source** `[BarShalom01]` ch. 5 (filter, consistency), `[DeJong91]` (the constant), `[RauchTungStriebel65]` (smoother).
///
/// ```
/// use proofmass_static::{BiasNoise, BiasObservations, BiasTracking, RestMean};
/// use proofmass_core::velocity::BiasModel;
///
/// let noise = BiasNoise {
///     white: 1e-3,
///     model: BiasModel::RandomWalk { density: 1e-12, initial: 1.0 },
///     offset: 0.0,
/// };
/// // 20 mm/s² too much along z, read in sixty rests of a second.
/// let means = (0..60)
///     .map(|k| RestMean {
///         time: 10.0 * f64::from(k), duration: 1.0, mean: [0.0, 0.0, 9.82665 + 1e-3 * (0.9 * f64::from(k)).sin()],
///         known: [0.0, 0.0, 9.80665], rest: k as usize,
///     })
///     .collect();
/// let track = BiasTracking::new([noise; 3]).track(&BiasObservations { span: [0.0, 600.0], means })?;
/// let end = track.axes[2].end();
/// assert!((end.bias - 0.02).abs() < 2.0 * end.u && end.u < 2e-4);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias(
    "EKF",
    "Gauss-Markov",
    "random walk",
    "ZUPT",
    "zero-velocity update",
    "smoother"
))]
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BiasTracking {
    /// Noise of x, y, z.
    pub noise: [BiasNoise; 3],
    /// Standard uncertainty of the known accelerations, common to all rests, m/s²: gravity, levelling.
    pub known_uncertainty: Triple,
    /// Relative standard uncertainty of how much the bias of x, y, z moves (of √density, or of the standard deviation): it
    /// becomes the degrees of freedom of the result.
    pub motion_uncertainty: Triple,
    /// Coverage probability.
    pub probability: f64,
}

/// The bias over a recording.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BiasTrack {
    /// Times at which the bias is given, s: the means of the rests, and points between them.
    pub time: Vec<f64>,
    /// Which rest a time belongs to; `None` between rests.
    pub rest: Vec<Option<usize>>,
    /// x, y, z.
    pub axes: [AxisTrack; 3],
    /// Bias at the end of the recording.
    pub quantities: Vec<Quantity>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Points between two rests at which the bias is given.
const BETWEEN: usize = 8;

impl BiasTracking {
    /// With this noise, known accelerations without uncertainty, 95 %.
    pub fn new(noise: [BiasNoise; 3]) -> Self {
        Self {
            noise,
            known_uncertainty: [0.0; 3],
            motion_uncertainty: [0.0; 3],
            probability: 0.95,
        }
    }

    /// The bias over the recording.
    ///
    /// # Errors
    /// As in the description of the type.
    pub fn track(&self, observations: &BiasObservations) -> Result<BiasTrack, Error> {
        self.check(observations)?;
        let (time, mean) = times(observations);
        let means = &observations.means;
        let rest = mean.iter().map(|m| m.map(|m| means[m].rest)).collect();
        let of = |axis: usize, noise: &BiasNoise| {
            AxisTrack::new(
                noise,
                self.known_uncertainty[axis],
                &time,
                &mean,
                axis,
                means,
            )
        };
        let [x, y, z] = &self.noise;
        let axes = [of(0, x)?, of(1, y)?, of(2, z)?];
        let findings = findings::findings(&axes, means);
        let mut quantities = Vec::with_capacity(3);
        for (k, name) in ["bias.x", "bias.y", "bias.z"].into_iter().enumerate() {
            let end = axes[k].end();
            let relative = self.motion_uncertainty[k];
            let dof = if relative > 0.0 {
                // What u becomes where the bias moves by one standard uncertainty more: ν = ½ (u/Δu)².
                let more = of(k, &self.noise[k].moving(1.0 + relative))?.end().u / end.u - 1.0;
                DegreesOfFreedom::new((0.5 / (more * more)).max(1.0))
                    .unwrap_or(DegreesOfFreedom::INFINITE)
            } else {
                DegreesOfFreedom::INFINITE
            };
            quantities.push(Quantity {
                name: name.to_owned(),
                unit: "m/s²".to_owned(),
                value: end.bias,
                standard_uncertainty: end.u,
                dof,
            });
        }
        Ok(BiasTrack {
            time,
            rest,
            axes,
            quantities,
            findings,
        })
    }

    fn check(&self, observations: &BiasObservations) -> Result<(), Error> {
        let means = &observations.means;
        if means.is_empty() {
            return Err(Error::TooFew {
                name: "rests with a known acceleration",
                needed: 1,
                got: 0,
            });
        }
        for (axis, noise) in self.noise.iter().enumerate() {
            for (name, value) in [
                ("constant part of the bias", noise.offset),
                (
                    "relative uncertainty of the motion of the bias",
                    self.motion_uncertainty[axis],
                ),
                (
                    "uncertainty of the known acceleration",
                    self.known_uncertainty[axis],
                ),
            ] {
                check::not_negative(name, value)?;
            }
        }
        if !(self.probability > 0.0 && self.probability < 1.0) {
            return Err(Error::OutOfRange {
                name: "coverage probability",
                value: self.probability,
                min: 0.0,
                max: 1.0,
            });
        }
        let every = |f: fn(&RestMean) -> f64| means.iter().map(f).collect::<Vec<f64>>();
        check::finite("span of the recording", &observations.span)?;
        check::finite("time of the rests", &every(|m| m.time))?;
        for axis in 0..3 {
            let of = |part: fn(&RestMean) -> &Triple| -> Vec<f64> {
                means.iter().map(|m| part(m)[axis]).collect()
            };
            check::finite("mean of a rest", &of(|m| &m.mean))?;
            check::finite("known acceleration", &of(|m| &m.known))?;
        }
        if let Some(m) = means
            .iter()
            .find(|m| !(m.duration > 0.0 && m.duration.is_finite()))
        {
            return Err(Error::OutOfRange {
                name: "duration of a rest",
                value: m.duration,
                min: 0.0,
                max: f64::MAX,
            });
        }
        let order = means.windows(2).position(|m| m[1].time <= m[0].time);
        if let Some(index) = order {
            return Err(Error::NotIncreasing {
                name: "time of the rests",
                index: index + 1,
            });
        }
        let [start, end] = observations.span;
        if start > means[0].time || means[means.len() - 1].time > end {
            return Err(Error::OutOfRange {
                name: "time of a rest outside the recording",
                value: if start > means[0].time {
                    means[0].time
                } else {
                    means[means.len() - 1].time
                },
                min: start,
                max: end,
            });
        }
        Ok(())
    }
}

/// The times of the means, of points between rests that lie apart, and of both ends; with the mean of each.
fn times(observations: &BiasObservations) -> (Vec<f64>, Vec<Option<usize>>) {
    let means = &observations.means;
    let [start, end] = observations.span;
    let mut time = Vec::with_capacity(means.len() + 2 * BETWEEN);
    let mut mean = Vec::with_capacity(time.capacity());
    let mut last = start;
    if means[0].time > start {
        time.push(start);
        mean.push(None);
    }
    for (index, m) in means.iter().enumerate() {
        if index > 0 && m.rest != means[index - 1].rest {
            for k in 1..=BETWEEN {
                let at = last + (m.time - last) * k as f64 / (BETWEEN + 1) as f64;
                if at > last && at < m.time && time.last().is_none_or(|t| at > *t) {
                    time.push(at);
                    mean.push(None);
                }
            }
        }
        time.push(m.time);
        mean.push(Some(index));
        last = m.time;
    }
    if end > last {
        for k in 1..=BETWEEN {
            let at = last + (end - last) * k as f64 / BETWEEN as f64;
            if time.last().is_none_or(|t| at > *t) {
                time.push(at);
                mean.push(None);
            }
        }
    }
    (time, mean)
}

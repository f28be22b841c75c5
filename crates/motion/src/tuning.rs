//! Noise parameters by maximum likelihood of the innovations.

use crate::filtering::{Interpolation, innovation_sums, steps};
use crate::whiteness::autocorrelation;
use crate::{Bias, KalmanModel, MotionRecord, NoiseForm, Whiteness};
use proofmass_core::Error;
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// Whether R is known or found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "reading-noise")]
pub enum ReadingNoise {
    /// Known: δ²/12, or from a still period.
    Known {
        /// Variance.
        variance: f64,
    },
    /// Found with q.
    Free,
}

/// Whether the accelerometer's offset is a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BiasChoice {
    /// No.
    None,
    /// A random walk whose density is found too.
    RandomWalk,
    /// The one with the smaller Bayesian criterion, (number of parameters) ln n − 2 ln L.
    Automatic,
}

/// What is tuned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuning {
    /// R.
    pub reading_noise: ReadingNoise,
    /// Offset.
    pub bias: BiasChoice,
    /// Form of q.
    pub noise_form: NoiseForm,
    /// Acceleration between samples.
    pub interpolation: Interpolation,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            reading_noise: ReadingNoise::Free,
            bias: BiasChoice::Automatic,
            noise_form: NoiseForm::SampleConstant,
            interpolation: Interpolation::Curve,
        }
    }
}

/// The model that makes the readings most probable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tuned {
    /// The model.
    pub model: KalmanModel,
    /// ln L, up to a constant.
    pub log_likelihood: f64,
    /// ln L of the best model without an offset state, when both were tried.
    pub log_likelihood_without_bias: Option<f64>,
    /// Half width of ln q at which ln L has fallen by 1.92 (95 %), below and above; `None` at a bound.
    pub log_q_interval: Option<(f64, f64)>,
    /// Profile of the likelihood: q, and ln L below its maximum there.
    pub profile: Vec<(f64, f64)>,
    /// Test of the innovations.
    pub whiteness: Whiteness,
    /// Correlation of the innovations at lags 0, 1, …
    pub autocorrelation: Vec<f64>,
    /// Number of passes over the record.
    pub passes: usize,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// Innovations of the first readings that belong to the unknown start.
const SKIP: usize = 4;

/// Range of log₁₀(q T⁴/R): from a filter that forgets in 10⁵ samples to one that follows every reading.
const RATIO: (f64, f64) = (-20.0, 5.0);

impl Tuning {
    /// Finds (q, R, offset) for a record.
    ///
    /// With R free, only the ratio q/R shapes the filter; the scale follows in closed form, R̂ = mean ν²/S at
    /// R = 1. The ratio is searched on a grid and refined by the golden section, the walk's density likewise.
    ///
    /// **Assumes** white noise of both sensors: quantisation of a slow axis is not, and the findings say so.
    ///
    /// # Errors
    /// Of the record; [`Error::TooFew`] below 24 readings; [`Error::OutOfRange`] for a known variance that is
    /// not positive.
    pub fn run(&self, record: &MotionRecord) -> Result<Tuned, Error> {
        record.check()?;
        let readings = record.reading.iter().flatten().count();
        if readings < SKIP + 20 {
            return Err(Error::TooFew {
                name: "readings",
                needed: SKIP + 20,
                got: readings,
            });
        }
        if let ReadingNoise::Known { variance } = self.reading_noise
            && !(variance.is_finite() && variance > 0.0)
        {
            return Err(Error::OutOfRange {
                name: "reading noise",
                value: variance,
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            });
        }
        let mut search = Search {
            tuning: self,
            record,
            scale: scale(record),
            steps: steps(
                record,
                &KalmanModel {
                    interpolation: self.interpolation,
                    ..KalmanModel::new(0.0, 1.0)
                },
            ),
            passes: 0,
        };
        let plain = match self.bias {
            BiasChoice::RandomWalk => None,
            _ => Some(search.best_ratio(None)?),
        };
        let walk = match self.bias {
            BiasChoice::None => None,
            _ => Some(search.best_walk()?),
        };
        let without = plain.map(|p| p.value);
        // The offset and its walk are two parameters more, ½ ln n each.
        let price = (readings as f64).ln();
        let (ratio, density, best) = match (plain, walk) {
            (Some(p), Some((w, s))) if w.value > p.value + price => (w, Some(s), w.value),
            (Some(p), _) => (p, None, p.value),
            (None, Some((w, s))) => (w, Some(s), w.value),
            (None, None) => {
                return Err(Error::NotConverged {
                    name: "likelihood",
                    iterations: 0,
                    step: 0.0,
                });
            }
        };
        let (model, _) = search.model(ratio.at, density)?;
        let run = model.smooth(record)?;
        if let (ReadingNoise::Free, Some(increment)) = (self.reading_noise, record.increment) {
            let rounding = increment * increment / 12.0;
            if model.reading_noise < 0.5 * rounding {
                return self.with_rounding(record, rounding, model.reading_noise);
            }
        }
        let innovations: Vec<f64> = run
            .innovations
            .iter()
            .flatten()
            .skip(SKIP)
            .copied()
            .collect();
        let whiteness = Whiteness::test(&innovations)?;
        let interval = search.interval(ratio.at, density, best)?;
        let profile = search.profile(ratio.at, density, best)?;
        let mut findings = Vec::new();
        if ratio.at <= RATIO.0 + 0.1 || ratio.at >= RATIO.1 - 0.1 {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "likelihood-at-bound",
                    "one sensor is ignored: the likelihood has no maximum inside the searched range",
                )
                .evidence(format!("log10(q T^4/R) = {:.1} of {:?}", ratio.at, RATIO))
                .advice("check that both sensors move and share unit and sense"),
            );
        }
        let resting = resting_share(record);
        if resting > 0.3 {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "slow-quantised-readings",
                    "the readings rest on one value for long stretches: quantisation is not noise there",
                )
                .evidence(format!(
                    "{:.0} % of the readings lie in runs of {LONG_RUN} and more equal ones",
                    100.0 * resting
                ))
                .advice("tune on a stretch in motion, give the reading noise as increment squared over twelve, or time the edges (M/T)"),
            );
        }
        if whiteness.p_white < 1e-3 {
            let (lag, rho) = whiteness.largest_correlation;
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "innovations-not-white",
                    "the innovations are correlated: the model does not describe both sensors",
                )
                .evidence(format!(
                    "Ljung-Box Q = {:.1} with {} lags (p = {:.1e}); correlation {rho:.3} at lag {lag}",
                    whiteness.ljung_box, whiteness.lags, whiteness.p_white
                ))
                .advice("look for slip, quantisation in slow motion, latency, a gain error or an offset; the stated uncertainty is then a lower bound"),
            );
        }
        Ok(Tuned {
            model,
            log_likelihood: best,
            log_likelihood_without_bias: without.filter(|_| density.is_some()),
            log_q_interval: interval,
            profile,
            whiteness,
            autocorrelation: autocorrelation(&innovations, whiteness.lags),
            passes: search.passes,
            findings,
        })
    }
}

impl Tuning {
    /// The same search with R at what the increment alone makes.
    ///
    /// Rounding that repeats with the motion (whole samples per period, or an axis that rests) passes for motion:
    /// the readings then fit better than their increment allows.
    fn with_rounding(
        &self,
        record: &MotionRecord,
        rounding: f64,
        found: f64,
    ) -> Result<Tuned, Error> {
        let known = Self {
            reading_noise: ReadingNoise::Known { variance: rounding },
            ..*self
        };
        let mut tuned = known.run(record)?;
        tuned.findings.insert(
            0,
            Finding::new(
                Severity::Note,
                "rounding-repeats",
                "the readings seem better than their increment: its rounding repeats with the motion, and the noise of a reading was set to it",
            )
            .evidence(format!(
                "found {:.2e}, increment over the root of twelve {:.2e}",
                found.sqrt(),
                rounding.sqrt()
            ))
            .advice("a sample rate that is no multiple of the motion's frequency lets the rounding average"),
        );
        Ok(tuned)
    }
}

/// Equal readings in a row that count as resting.
const LONG_RUN: usize = 20;

/// Share of the readings in long runs of equal ones.
fn resting_share(record: &MotionRecord) -> f64 {
    let readings: Vec<f64> = record.reading.iter().flatten().copied().collect();
    let resting: usize = readings
        .chunk_by(|a, b| a == b)
        .map(<[f64]>::len)
        .filter(|&n| n >= LONG_RUN)
        .sum();
    resting as f64 / readings.len().max(1) as f64
}

/// Variance of the offset at the start: three times the mean acceleration, and three per cent of its size.
///
/// Far wider, it would cost the first steps their digits; an offset of that size is found all the same, within a few
/// samples.
fn scale(record: &MotionRecord) -> f64 {
    let n = record.acceleration.len() as f64;
    let mean = record.acceleration.iter().sum::<f64>() / n;
    let square = record.acceleration.iter().map(|a| a * a).sum::<f64>() / n;
    (9.0 * mean * mean + 9e-4 * square).max(f64::MIN_POSITIVE)
}

#[derive(Clone, Copy)]
struct Maximum {
    at: f64,
    value: f64,
}

struct Search<'a> {
    tuning: &'a Tuning,
    record: &'a MotionRecord,
    scale: f64,
    steps: Option<Vec<[f64; 2]>>,
    passes: usize,
}

impl Search<'_> {
    /// Model and ln L at a ratio; `density` is log₁₀ of the walk's density over q.
    fn model(&mut self, ratio: f64, density: Option<f64>) -> Result<(KalmanModel, f64), Error> {
        let dt = self.record.sample_time;
        let unit = match self.tuning.noise_form {
            NoiseForm::SampleConstant => dt.powi(4),
            NoiseForm::Continuous => dt.powi(3),
        };
        // A speed has one integration less.
        let unit = match self.record.source {
            crate::Source::Position => unit,
            crate::Source::Speed => unit / (dt * dt),
        };
        let q_of = |r: f64| 10f64.powf(ratio) * r / unit;
        let with = |r: f64, initial: f64| KalmanModel {
            acceleration_noise: q_of(r),
            noise_form: self.tuning.noise_form,
            reading_noise: r,
            bias: density.map_or(Bias::None, |d| Bias::RandomWalk {
                density: 10f64.powf(d) * q_of(r),
                initial,
            }),
            interpolation: self.tuning.interpolation,
        };
        let initial = self.scale.sqrt();
        self.passes += 1;
        match self.tuning.reading_noise {
            ReadingNoise::Known { variance } => {
                let model = with(variance, initial);
                let (_, logs, squares) = self.sums(&model)?;
                Ok((model, -0.5 * (logs + squares)))
            }
            ReadingNoise::Free => {
                // The start is given in absolute terms; its innovations are skipped, so a first scale from the
                // readings is enough, and one correction of it.
                let mut r = 1.0;
                let mut value = 0.0;
                for _ in 0..2 {
                    let (n, logs, squares) = self.sums(&with(r, initial))?;
                    let factor = (squares / n as f64).max(f64::MIN_POSITIVE);
                    value = -0.5 * (logs + n as f64 * (factor.ln() + 1.0));
                    r *= factor;
                }
                Ok((with(r, initial), value))
            }
        }
    }

    fn sums(&self, model: &KalmanModel) -> Result<(usize, f64, f64), Error> {
        let dt = self.record.sample_time;
        let sums = match model.bias {
            Bias::None => {
                let steps = self.steps.as_deref();
                innovation_sums(&model.two(dt)?, self.record, 0.0, steps, SKIP)
            }
            _ => {
                let (kalman, variance) = model.three(dt)?;
                innovation_sums(&kalman, self.record, variance, self.steps.as_deref(), SKIP)
            }
        };
        if sums.1.is_finite() && sums.2.is_finite() {
            Ok(sums)
        } else {
            // A corner of the search that overflows is improbable, not an error of the caller.
            Ok((sums.0, f64::MAX.sqrt(), f64::MAX.sqrt()))
        }
    }

    fn value(&mut self, ratio: f64, density: Option<f64>) -> Result<f64, Error> {
        Ok(self.model(ratio, density)?.1)
    }

    fn best_ratio(&mut self, density: Option<f64>) -> Result<Maximum, Error> {
        let (low, high) = RATIO;
        self.maximise(low, high, 1.0, 0.005, |search, at| {
            search.value(at, density)
        })
    }

    /// Best ratio and walk density. The density is searched over q: 10⁻¹²…10² (1/s).
    fn best_walk(&mut self) -> Result<(Maximum, f64), Error> {
        // Without an offset state q may have swallowed the offset, so that its maximum lies decades away: coarse
        // over the whole plane, then one after the other.
        let mut best = (
            Maximum {
                at: RATIO.0,
                value: f64::NEG_INFINITY,
            },
            -6.0,
        );
        for d in [-12.0, -9.0, -6.0, -3.0, 0.0, 3.0] {
            for step in 0..=(RATIO.1 - RATIO.0) as i32 {
                let at = RATIO.0 + f64::from(step);
                let value = self.value(at, Some(d))?;
                if value > best.0.value {
                    best = (Maximum { at, value }, d);
                }
            }
        }
        for _ in 0..2 {
            let d = best.1;
            let (low, high) = (
                (best.0.at - 1.5).max(RATIO.0),
                (best.0.at + 1.5).min(RATIO.1),
            );
            let ratio = self.maximise(low, high, 0.75, 0.01, |s, at| s.value(at, Some(d)))?;
            let density = self.maximise(d - 3.0, d + 3.0, 1.0, 0.02, |s, d| {
                s.value(ratio.at, Some(d))
            })?;
            best = (
                Maximum {
                    at: ratio.at,
                    value: density.value,
                },
                density.at,
            );
        }
        Ok(best)
    }

    /// Grid, then golden section around its best point.
    fn maximise(
        &mut self,
        low: f64,
        high: f64,
        step: f64,
        tolerance: f64,
        mut value: impl FnMut(&mut Self, f64) -> Result<f64, Error>,
    ) -> Result<Maximum, Error> {
        let n = ((high - low) / step).round().max(1.0) as usize;
        let mut best = Maximum {
            at: low,
            value: f64::NEG_INFINITY,
        };
        for k in 0..=n {
            let at = low + (high - low) * k as f64 / n as f64;
            let v = value(self, at)?;
            if v > best.value {
                best = Maximum { at, value: v };
            }
        }
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let (mut a, mut b) = ((best.at - step).max(low), (best.at + step).min(high));
        let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
        let (mut vc, mut vd) = (value(self, c)?, value(self, d)?);
        while b - a > tolerance {
            if vc > vd {
                (b, d, vd) = (d, c, vc);
                c = b - golden * (b - a);
                vc = value(self, c)?;
            } else {
                (a, c, vc) = (c, d, vd);
                d = a + golden * (b - a);
                vd = value(self, d)?;
            }
        }
        for (at, v) in [(c, vc), (d, vd)] {
            if v > best.value {
                best = Maximum { at, value: v };
            }
        }
        Ok(best)
    }

    /// ln L below its maximum over two decades of q either way.
    fn profile(
        &mut self,
        at: f64,
        density: Option<f64>,
        best: f64,
    ) -> Result<Vec<(f64, f64)>, Error> {
        (-16..=16)
            .map(|k| {
                let (model, value) = self.model(at + 0.125 * f64::from(k), density)?;
                Ok((model.acceleration_noise, value - best))
            })
            .collect()
    }

    /// Where ln L has fallen by half the 95 % point of χ²(1).
    fn interval(
        &mut self,
        at: f64,
        density: Option<f64>,
        best: f64,
    ) -> Result<Option<(f64, f64)>, Error> {
        let mut half = [0.0; 2];
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let (mut inside, mut outside) = (0.0, 0.02);
            while best - self.value(at + sign * outside, density)? < 1.92 {
                inside = outside;
                outside *= 2.0;
                if outside > 4.0 {
                    return Ok(None);
                }
            }
            for _ in 0..12 {
                let middle = 0.5 * (inside + outside);
                if best - self.value(at + sign * middle, density)? < 1.92 {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            half[side] = outside * std::f64::consts::LN_10;
        }
        Ok(Some((half[0], half[1])))
    }
}

//! Which integration rule and which high-pass, for a band, a bias and a noise.

use crate::{HighPass, Method};
use proofmass_core::check::{not_negative, positive, within};
use proofmass_core::{Error, velocity::IntegratorRule};
use proofmass_signal::fourier::Complex;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// What a velocity is integrated for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct IntegratorTask {
    /// Lowest and highest frequency of the motion, Hz.
    pub band: [f64; 2],
    /// Samples per second.
    pub rate: f64,
    /// Bias of the accelerometer that was not taken off, m/s²: its size or its standard uncertainty.
    pub bias: f64,
    /// Standard deviation of the white noise of a sample, m/s².
    pub noise: f64,
    /// Amplitude of the velocity in the band, m/s, on which the errors of gain and phase act.
    pub speed: f64,
    /// Length of the record, s.
    pub duration: f64,
}

/// The high-pass behind a rule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FittedHighPass {
    /// Order of the Butterworth filter; of one that is run forward and backward that of one run.
    pub order: usize,
    /// Its corner, Hz.
    pub corner: f64,
    /// Whether it is run forward and backward, which only a whole record allows.
    pub zero_phase: bool,
}

/// A rule by itself, or with the high-pass that fits it best.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct IntegratorDesign {
    /// The rule.
    pub rule: IntegratorRule,
    /// The high-pass behind it; none where the integral is taken as it is.
    pub high_pass: Option<FittedHighPass>,
    /// Gain of the velocity less one, where it is furthest from zero in the band.
    pub gain_error: f64,
    /// Phase of the velocity, where it is furthest from zero in the band, rad.
    pub phase_error: f64,
    /// Largest |H jω − 1| in the band: gain and phase together.
    pub band_error: f64,
    /// Standard deviation of the velocity at the end, by the white noise, m/s.
    pub noise: f64,
    /// Root mean square of what the bias leaves in the velocity over the record, m/s.
    pub bias: f64,
    /// Speed times band error, noise and bias together, root of the sum of squares, m/s.
    pub total: f64,
}

/// Samples of a period of the corner in what is computed once for each kind of high-pass.
const PER_PERIOD: usize = 400;
/// Periods of the corner after which a high-pass has settled.
const SETTLED: usize = 12;
/// Corners and frequencies that are tried.
const CORNERS: usize = 241;
const FREQUENCIES: usize = 121;

impl IntegratorDesign {
    /// The method that runs it.
    pub fn method(&self) -> Method {
        let rule = self.rule;
        match self.high_pass {
            None => Method::Integration { rule, offset: 0.0 },
            Some(FittedHighPass {
                order,
                corner,
                zero_phase,
            }) => Method::HighPass {
                rule,
                order,
                corner,
                zero_phase,
            },
        }
    }

    /// Whether only a whole record allows it.
    pub fn off_line(&self) -> bool {
        self.high_pass.is_some_and(|h| h.zero_phase)
    }
}

/// What a kind of high-pass leaves of a step and of a ramp of the integral, in units of its period.
struct Kind {
    order: usize,
    zero_phase: bool,
    /// ∫₀ᵘ of the squared answers to a step and to a ramp.
    squares: Vec<[f64; 2]>,
}

impl Kind {
    fn new(order: usize, zero_phase: bool) -> Result<Self, Error> {
        let step = 1.0 / PER_PERIOD as f64;
        let filter = HighPass::butterworth(order, 1.0, step)?;
        let n = SETTLED * PER_PERIOD;
        // A sample of noise leaves a step, a bias a ramp. Run backward as well, a bias that lasts leaves nothing.
        let (rise, ramp) = match zero_phase {
            false => {
                // The filter starts as if its first value had lasted, so that a step begins at the second.
                let x: Vec<f64> = (0..=n).map(|k| f64::from(u8::from(k > 0))).collect();
                let ramp: Vec<f64> = (0..=n).map(|k| step * k as f64).collect();
                (filter.filter(&x), filter.filter(&ramp))
            }
            true => {
                let x: Vec<f64> = (0..=2 * n).map(|k| f64::from(u8::from(k > n))).collect();
                let both = filter.zero_phase(&x, 0);
                // Both sides of the step folded onto one.
                let folded =
                    (0..=n).map(|k| both[n + k].hypot(if k > 0 { both[n - k] } else { 0.0 }));
                (folded.collect(), vec![0.0; n + 1])
            }
        };
        let mut sums = [0.0; 2];
        let squares = rise
            .iter()
            .zip(&ramp)
            .map(|(a, b)| {
                sums = [sums[0] + step * a * a, sums[1] + step * b * b];
                sums
            })
            .collect();
        Ok(Self {
            order,
            zero_phase,
            squares,
        })
    }

    /// After so many periods of the corner.
    fn after(&self, periods: f64) -> [f64; 2] {
        let at = (periods * PER_PERIOD as f64) as usize;
        self.squares[at.min(self.squares.len() - 1)]
    }
}

impl IntegratorTask {
    /// Refuses a task that is none.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::OutOfRange`]: a band outside zero to half of the rate, a record shorter than four periods of its lowest
    /// frequency.
    pub fn check(&self) -> Result<(), Error> {
        positive("sampling rate, Hz", self.rate)?;
        positive("amplitude of the velocity, m/s", self.speed)?;
        not_negative("bias, m/s²", self.bias)?;
        not_negative("noise of a sample, m/s²", self.noise)?;
        let [low, high] = self.band;
        within(
            "highest frequency of the band, Hz",
            high,
            f64::MIN_POSITIVE,
            0.49 * self.rate,
        )?;
        within("lowest frequency of the band, Hz", low, 1e-9 * high, high)?;
        within("length of the record, s", self.duration, 4.0 / low, 1e9)
    }

    /// Every rule by itself, with a high-pass that is run on line, and with one that is run forward and backward, the one with the smallest
    /// total first.
    ///
    /// The corner is that of the smallest total: a lower one leaves more of bias and noise, a higher one errs more at the low end of the
    /// band. Without one the bias grows with the time, b t. A rule whose poles lie in the band is left out.
    ///
    /// ```text
    /// total² = (speed · max |H jω − 1|)² + u²(noise) + rms²(bias)
    /// ```
    ///
    /// **Assumes** a bias that lasts and white noise; the corner far below the rate. **Accuracy** `crosscheck_designs_by_running_them`.
    ///
    /// ```
    /// use proofmass_motion::{IntegratorRule, IntegratorTask};
    /// let task = IntegratorTask { band: [2.0, 40.0], rate: 200.0, bias: 0.02, noise: 1e-3, speed: 0.5, duration: 60.0 };
    /// let ranked = task.ranked()?;
    /// assert!(ranked.windows(2).all(|w| w[0].total <= w[1].total));
    /// // Five samples to a period: the trapezoid loses 14 % of the velocity, Tick's rule less than 1 %.
    /// let of = |rule| ranked.iter().find(|d| d.rule == rule && d.off_line()).unwrap();
    /// assert!((of(IntegratorRule::Trapezoid).gain_error + 0.135).abs() < 2e-3);
    /// assert!(of(IntegratorRule::Tick).gain_error.abs() < 0.01);
    /// # Ok::<(), proofmass_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn ranked(&self) -> Result<Vec<IntegratorDesign>, Error> {
        self.check()?;
        let [low, high] = self.band;
        let frequencies = steps([low, high], FREQUENCIES);
        let all = vec![Complex::from(1.0); FREQUENCIES];
        let plain = |rule| self.design(rule, None, &frequencies, &all);
        let mut ranked: Vec<_> = IntegratorRule::ALL.into_iter().filter_map(plain).collect();
        for zero_phase in [false, true] {
            let kinds = [2, 4].map(|order| Kind::new(order, zero_phase));
            let mut best = IntegratorRule::ALL.map(|_| None::<IntegratorDesign>);
            for kind in kinds {
                let kind = kind?;
                // Four periods of the corner, so that it settles within the record.
                for corner in steps([4.0 / self.duration, low], CORNERS) {
                    let filter = HighPass::butterworth(kind.order, corner, 1.0 / self.rate)?;
                    let passed: Vec<Complex<f64>> = frequencies
                        .iter()
                        .map(|f| filter.response(TAU * f / self.rate))
                        .map(|h| match zero_phase {
                            true => Complex::from(h.norm_sqr()),
                            false => h,
                        })
                        .collect();
                    for (best, rule) in best.iter_mut().zip(IntegratorRule::ALL) {
                        let behind = Some((&kind, corner));
                        let design = self.design(rule, behind, &frequencies, &passed);
                        if let Some(design) = design
                            && best.as_ref().is_none_or(|b| design.total < b.total)
                        {
                            *best = Some(design);
                        }
                    }
                }
            }
            ranked.extend(best.into_iter().flatten());
        }
        ranked.sort_by(|a, b| a.total.total_cmp(&b.total));
        Ok(ranked)
    }

    fn design(
        &self,
        rule: IntegratorRule,
        behind: Option<(&Kind, f64)>,
        frequencies: &[f64],
        passed: &[Complex<f64>],
    ) -> Option<IntegratorDesign> {
        let (lag, _) = rule.weights();
        // Between two poles of a rule no gain is that of an integral.
        if lag > 1 && self.band[1] * lag as f64 >= 0.999 * self.rate {
            return None;
        }
        let (mut gain, mut phase, mut off) = (0.0f64, 0.0f64, 0.0f64);
        for (f, passed) in frequencies.iter().zip(passed) {
            let theta = TAU * f / self.rate;
            let (re, im) = rule.transfer(theta);
            let h = Complex::new(-theta * im, theta * re) * passed;
            off = off.max((h - 1.0).norm());
            if (h.norm() - 1.0).abs() > gain.abs() {
                gain = h.norm() - 1.0;
            }
            if h.arg().abs() > phase.abs() {
                phase = h.arg();
            }
        }
        // Squares of the answers to a step of one and to a ramp of one per second, summed over the record.
        let [step, ramp] = match behind {
            None => [self.duration, self.duration.powi(3) / 3.0],
            Some((kind, corner)) => {
                let [step, ramp] = kind.after(self.duration * corner);
                [step / corner, ramp / corner.powi(3)]
            }
        };
        let per_second = self.noise * self.noise / self.rate;
        // What the poles beside z = 1 sum is no slow error, and passes the high-pass.
        let beside = (rule.noise_walk().powi(2) - 1.0).max(0.0) * self.duration;
        let noise = (per_second * (step + beside)).sqrt();
        let bias = self.bias * (ramp / self.duration).sqrt();
        let total = (self.speed * off).hypot(noise).hypot(bias);
        total.is_finite().then_some(IntegratorDesign {
            rule,
            high_pass: behind.map(|(kind, corner)| FittedHighPass {
                order: kind.order,
                corner,
                zero_phase: kind.zero_phase,
            }),
            gain_error: gain,
            phase_error: phase,
            band_error: off,
            noise,
            bias,
            total,
        })
    }
}

/// Even steps of the logarithm.
fn steps([from, to]: [f64; 2], count: usize) -> Vec<f64> {
    let ratio = (to / from).ln();
    let last = (count - 1) as f64;
    (0..count)
        .map(|k| from * (ratio * k as f64 / last).exp())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MotionRecord, ReadingSource};
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const TASK: IntegratorTask = IntegratorTask {
        band: [2.0, 30.0],
        rate: 200.0,
        bias: 0.02,
        noise: 0.05,
        speed: 0.1,
        duration: 40.0,
    };

    fn run(design: &IntegratorDesign, a: &[f64]) -> Vec<f64> {
        // The readings only say where it begins.
        let mut readings = vec![None; a.len()];
        readings[..2].fill(Some(0.0));
        let source = ReadingSource::Position;
        let mut record = MotionRecord::new(1.0 / TASK.rate, source, readings, a.to_vec()).unwrap();
        record.initial_velocity = Some(0.0);
        design.method().run(&record).unwrap().velocity
    }

    /// Sines at both ends of the band, a bias, and noise, each by itself through the filter that is run.
    #[test]
    fn crosscheck_designs_by_running_them() {
        let n = (TASK.duration * TASK.rate) as usize;
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        for design in TASK.ranked().unwrap() {
            // Half a second from the ends, where a filter that is run backward begins.
            let inner = n / 4..3 * n / 4;
            let worst = TASK.band.map(|f| {
                let w = TAU * f;
                let a: Vec<f64> = (0..n)
                    .map(|k| w * (w * k as f64 / TASK.rate).cos())
                    .collect();
                let v = run(&design, &a);
                // Projected on sine and cosine: what other poles began at the start is at other frequencies.
                let (mut s, mut c) = (0.0, 0.0);
                for k in inner.clone() {
                    let angle = w * k as f64 / TASK.rate;
                    s += v[k] * angle.sin();
                    c += v[k] * angle.cos();
                }
                let scale = 2.0 / inner.len() as f64;
                (scale * s - 1.0).hypot(scale * c)
            });
            let worst = worst[0].max(worst[1]);
            assert!(
                (worst - design.band_error).abs() < 0.01 * design.band_error + 2e-3,
                "{design:?}: {worst}"
            );
            let v = run(&design, &vec![TASK.bias; n]);
            let rms = (v.iter().map(|v| v * v).sum::<f64>() / n as f64).sqrt();
            assert!(
                (rms - design.bias).abs() < 0.02 * design.bias + 2e-5,
                "{design:?}: {rms}"
            );
            // At the end on line, in the middle off line.
            let (mut squares, runs) = (0.0, 200);
            for _ in 0..runs {
                let a: Vec<f64> = (0..n)
                    .map(|_| TASK.noise * Distribution::<f64>::sample(&StandardNormal, &mut rng))
                    .collect();
                let v = run(&design, &a);
                squares += if design.off_line() {
                    v[n / 2]
                } else {
                    v[n - 1]
                }
                .powi(2);
            }
            let deviation = (squares / f64::from(runs)).sqrt();
            // Of a standard deviation from 200: 5 %; four of them. Off line the middle has half of what other poles sum.
            let stated = match design.off_line() {
                false => design.noise,
                true => {
                    let all = design.rule.noise_walk().powi(2) - 1.0;
                    let half = 0.5 * all.max(0.0) * TASK.duration * TASK.noise.powi(2) / TASK.rate;
                    (design.noise.powi(2) - half).sqrt()
                }
            };
            assert!(
                (deviation / stated - 1.0).abs() < 0.2,
                "{design:?}: {deviation} {stated}"
            );
        }
    }

    /// Without bias and noise the corner goes down as far as the record allows; a larger bias raises it.
    #[test]
    fn law_a_bias_raises_the_corner() {
        let corner = |bias| {
            let task = IntegratorTask {
                bias,
                noise: 0.0,
                ..TASK
            };
            let ranked = task.ranked().unwrap();
            let on_line = |d: &&IntegratorDesign| {
                d.high_pass.is_some_and(|h| !h.zero_phase) && d.rule == IntegratorRule::Trapezoid
            };
            let best = ranked.iter().find(on_line).unwrap();
            best.high_pass.unwrap().corner
        };
        let corners = [0.0, 0.01, 0.1, 1.0].map(corner);
        assert_eq!(corners[0], 4.0 / TASK.duration);
        assert!(corners.windows(2).all(|w| w[0] < w[1]), "{corners:?}");
    }

    /// A short record of a small bias needs no high-pass, which would err at the low end of the band; a long one does.
    #[test]
    fn known_a_short_record_needs_no_high_pass() {
        let best = |duration| {
            let task = IntegratorTask {
                bias: 1e-4,
                noise: 1e-3,
                duration,
                band: [2.0, 10.0],
                ..TASK
            };
            task.ranked().unwrap()[0]
        };
        let short = best(3.0);
        assert!(short.high_pass.is_none(), "{short:?}");
        // 1e-4 m/s² for three seconds.
        assert!((short.bias - 1e-4 * 3.0 / 3f64.sqrt()).abs() < 1e-12);
        assert!(best(600.0).high_pass.is_some());
    }

    #[test]
    fn refuses_bands_that_are_none() {
        for (band, duration) in [
            ([2.0, 110.0], 40.0),
            ([0.0, 10.0], 40.0),
            ([5.0, 2.0], 40.0),
            ([0.05, 10.0], 40.0),
            ([f64::NAN, 10.0], 40.0),
        ] {
            let task = IntegratorTask {
                band,
                duration,
                ..TASK
            };
            assert!(task.ranked().is_err(), "{band:?}");
        }
        assert!(IntegratorTask { bias: -1.0, ..TASK }.ranked().is_err());
    }
}

//! The drift one has to expect of a velocity from an accelerometer alone.

use proofmass_core::check::{finite, within};
use proofmass_core::{Error, STANDARD_GRAVITY};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// What integration alone does to a velocity, m/s, or to a place, m, after a time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DriftBudget {
    /// Time, s.
    pub time: f64,
    /// From a known offset: b t, of a place b t²/2.
    pub offset: f64,
    /// From a known inclination of the axis: g sin θ t.
    pub orientation: f64,
    /// From a known error of the gain: ε Δv, of a place ε Δv t/2.
    pub gain: f64,
    /// Standard uncertainty from that of the offset.
    pub offset_uncertainty: f64,
    /// Standard uncertainty from that of the inclination: g cos θ u(θ) t.
    pub orientation_uncertainty: f64,
    /// Standard uncertainty from that of the gain: u(ε) |Δv|.
    pub gain_uncertainty: f64,
    /// Standard uncertainty from white noise: σ √(T t).
    pub noise: f64,
    /// Standard uncertainty from flicker noise.
    pub flicker: f64,
    /// Standard uncertainty from an offset that walks: s √(t³/3).
    pub walk: f64,
    /// Standard uncertainty from Gauss–Markov processes.
    pub markov: f64,
    /// Combined standard uncertainty.
    pub combined: f64,
}

impl DriftBudget {
    /// What is known of the drift: offset, inclination and gain together.
    pub fn known(&self) -> f64 {
        self.offset + self.orientation + self.gain
    }
}

/// What is known about the accelerometer when it is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct DriftSources {
    /// Offset, m/s².
    pub offset: f64,
    /// Its standard uncertainty, m/s².
    pub offset_uncertainty: f64,
    /// Inclination of the axis, rad.
    pub orientation: f64,
    /// Its standard uncertainty, rad.
    pub orientation_uncertainty: f64,
    /// Relative error of the gain.
    pub gain: f64,
    /// Its standard uncertainty.
    pub gain_uncertainty: f64,
    /// By how much the velocity has changed since the integration began, m/s: what the gain acts on.
    pub speed: f64,
    /// Standard deviation of a sample, m/s².
    pub noise: f64,
    /// Sample time, s.
    pub sample_time: f64,
    /// Walk of the offset, (m/s²)/√s: the K of an Allan deviation.
    pub walk: f64,
    /// Flicker noise, m/s²: the B of an Allan deviation, whose floor is 0.664 B.
    pub flicker: f64,
    /// Gauss–Markov processes, each by its standard deviation, m/s², and its correlation time, s; zeros for none.
    pub markov: [[f64; 2]; 4],
    /// Correlation of the errors of offset and gain, as a common calibration has it.
    pub offset_gain_correlation: f64,
    /// Rest just before the start whose mean is taken off, s: offset and inclination go with it. Zero without one.
    pub rest: f64,
}

/// What is integrated for.
#[derive(Clone, Copy, PartialEq)]
enum Integral {
    Velocity,
    Place,
}

impl DriftSources {
    /// Refuses what no accelerometer is.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for an uncertainty below zero or an inclination beyond a right angle.
    pub fn check(&self) -> Result<(), Error> {
        finite("offset", &[self.offset])?;
        finite("gain", &[self.gain])?;
        finite("speed", &[self.speed])?;
        within("inclination", self.orientation, -FRAC_PI_2, FRAC_PI_2)?;
        for (name, value) in [
            ("uncertainty of the offset", self.offset_uncertainty),
            (
                "uncertainty of the inclination",
                self.orientation_uncertainty,
            ),
            ("uncertainty of the gain", self.gain_uncertainty),
            ("noise", self.noise),
            ("sample time", self.sample_time),
            ("walk of the offset", self.walk),
            ("flicker noise", self.flicker),
            ("rest before the start", self.rest),
        ] {
            within(name, value, 0.0, f64::MAX)?;
        }
        for [deviation, time] in self.markov {
            within(
                "deviation of a Gauss–Markov process",
                deviation,
                0.0,
                f64::MAX,
            )?;
            within(
                "correlation time of a Gauss–Markov process",
                time,
                0.0,
                f64::MAX,
            )?;
            if deviation > 0.0 && time == 0.0 {
                return Err(Error::OutOfRange {
                    name: "correlation time of a Gauss–Markov process",
                    value: time,
                    min: f64::MIN_POSITIVE,
                    max: f64::MAX,
                });
            }
        }
        within(
            "correlation of offset and gain",
            self.offset_gain_correlation,
            -1.0,
            1.0,
        )?;
        Ok(())
    }

    /// Drift of the velocity after a time.
    ///
    /// With white noise N, flicker B, walk K and the residual offset b, without a rest: b t, N √t, K √(t³/3), and for flicker
    /// t √(4 ln 2/π) B, the mean over t less that over as long before: since the offset was found no less. With a rest of T
    /// its mean is taken off: N √(t + t²/T), K √(t³/3 + t² T/3), and for flicker the same difference of means over t and over T.
    ///
    /// **Assumes** the inclination of the rest; an acceleration that is even where the gain acts on a place.
    ///
    /// ```
    /// use proofmass_motion::DriftSources;
    /// let tilt = DriftSources { orientation: 1f64.to_radians(), ..DriftSources::default() };
    /// assert!((tilt.after(10.0).orientation - 1.7115).abs() < 1e-4); // one degree, ten seconds
    /// ```
    pub fn after(&self, time: f64) -> DriftBudget {
        self.budget(time, Integral::Velocity)
    }

    /// Drift of the place after a time, the second integral: b t²/2, N √(t³/3), K √(t⁵/20).
    ///
    /// ```
    /// use proofmass_motion::DriftSources;
    /// let walk = DriftSources { walk: 1e-3, ..DriftSources::default() };
    /// assert!((walk.place_after(10.0).walk - 1e-3 * 5000f64.sqrt()).abs() < 1e-12);
    /// ```
    pub fn place_after(&self, time: f64) -> DriftBudget {
        self.budget(time, Integral::Place)
    }

    fn budget(&self, time: f64, of: Integral) -> DriftBudget {
        // Integral of a constant, of white noise of unit density, of a walk.
        let (lever, white, walked, moved) = match of {
            Integral::Velocity => (time, time, time.powi(3) / 3.0, 1.0),
            Integral::Place => (
                0.5 * time * time,
                time.powi(3) / 3.0,
                time.powi(5) / 20.0,
                0.5 * time,
            ),
        };
        let rested = self.rest > 0.0;
        // What the rest takes off is no error any more; its own mean errs by noise.
        let left = if rested { 0.0 } else { lever };
        let (by_rest, walk_of_rest) = match rested {
            true => (lever * lever / self.rest, lever * lever * self.rest / 3.0),
            false => (0.0, 0.0),
        };
        let since = if rested { self.rest } else { time };
        let density = self.noise * self.sample_time.sqrt();
        let noise = density * (white + by_rest).sqrt();
        let walk = self.walk * (walked + walk_of_rest).sqrt();
        let flicker = self.flicker * lever * flicker_between(time, since, of).sqrt();
        let markov = self.markov.iter().filter(|m| m[0] > 0.0);
        let markov: f64 = markov
            .map(|m| m[0] * m[0] * markov_variance(time, self.rest, m[1], lever, of))
            .sum();
        let offset_uncertainty = self.offset_uncertainty * left;
        let orientation_uncertainty =
            STANDARD_GRAVITY * self.orientation.cos() * self.orientation_uncertainty * left;
        let gain_uncertainty = self.gain_uncertainty * (self.speed * moved).abs();
        let common = 2.0
            * self.offset_gain_correlation
            * offset_uncertainty
            * self.gain_uncertainty
            * self.speed
            * moved;
        let independent = [orientation_uncertainty, noise, flicker, walk, markov.sqrt()]
            .into_iter()
            .fold(0.0, f64::hypot);
        // (u_a, u_b) with their correlation: never below zero but for rounding.
        let calibrated = offset_uncertainty.hypot(gain_uncertainty);
        let calibrated = match common {
            0.0 => calibrated,
            common => (calibrated * calibrated + common).max(0.0).sqrt(),
        };
        DriftBudget {
            time,
            offset: self.offset * left,
            orientation: STANDARD_GRAVITY * self.orientation.sin() * left,
            gain: self.gain * self.speed * moved,
            offset_uncertainty,
            orientation_uncertainty,
            gain_uncertainty,
            noise,
            flicker,
            walk,
            markov: markov.sqrt(),
            combined: independent.hypot(calibrated),
        }
    }
}

/// Variance of the mean of flicker noise of B = 1 over t, weighted as the integral weighs it, less its mean over T before.
///
/// S = B²/(2π|f|) has the generalised autocovariance −(B²/π) ln |τ|: of weights that sum to zero every other constant falls out.
fn flicker_between(t: f64, before: f64, of: Integral) -> f64 {
    // In units of the shorter of the two, so that no digit is lost in a logarithm of seconds.
    let unit = t.min(before);
    let (t, before) = (t / unit, before / unit);
    // Primitives of ln x, twice and three times.
    let second = |x: f64| 0.5 * x * x * x.ln() - 0.75 * x * x;
    let third = |x: f64| x.powi(3) * (x.ln() / 6.0 - 11.0 / 36.0);
    let (own, cross) = match of {
        Integral::Velocity => (
            t.ln() - 1.5,
            (second(t + before) - second(t) - second(before)) / (t * before),
        ),
        Integral::Place => (
            t.ln() - 1.75,
            2.0 * (third(t + before) - third(before) - t * second(before) - third(t))
                / (t * t * before),
        ),
    };
    let variance = (2.0 * cross - own - (before.ln() - 1.5)) / std::f64::consts::PI;
    variance.max(0.0)
}

/// Variance that a Gauss–Markov process of unit variance and correlation time τ leaves in the integral.
fn markov_variance(t: f64, rest: f64, tau: f64, lever: f64, of: Integral) -> f64 {
    let x = t / tau;
    // x − 1 + e⁻ˣ
    let settled = |x: f64| {
        if x < 1e-5 {
            0.5 * x * x
        } else {
            x + (-x).exp_m1()
        }
    };
    let own = match of {
        Integral::Velocity => 2.0 * tau * tau * settled(x),
        Integral::Place if x < 0.05 => {
            t.powi(4) * (0.25 - x / 15.0 + x * x / 72.0 - x.powi(3) / 420.0)
        }
        Integral::Place => {
            tau.powi(4) * (2.0 / 3.0 * x.powi(3) - x * x + 2.0 - 2.0 * (1.0 + x) * (-x).exp())
        }
    };
    if rest == 0.0 {
        return own;
    }
    let y = rest / tau;
    let of_mean = if y < 1e-5 {
        1.0
    } else {
        2.0 * settled(y) / (y * y)
    };
    // Covariance of the mean of the rest with the integral.
    let fades = if y < 1e-12 { 1.0 } else { -(-y).exp_m1() / y };
    let with_mean = match of {
        Integral::Velocity => tau * -(-x).exp_m1(),
        Integral::Place => tau * tau * settled(x),
    };
    (own + lever * lever * of_mean - 2.0 * lever * fades * with_mean).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_core::velocity::{Integrator, IntegratorRule, IntegratorState};
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Every source at once, its error drawn anew each time, against the budget.
    #[test]
    fn law_velocities_scatter_as_the_budget_says() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let sources = DriftSources {
            offset: 0.02,
            offset_uncertainty: 0.005,
            orientation: 0.01,
            orientation_uncertainty: 5e-4,
            gain: 0.01,
            gain_uncertainty: 0.02,
            speed: 2.0,
            noise: 0.1,
            sample_time: 0.01,
            walk: 0.002,
            ..DriftSources::default()
        };
        let trapezoid = Integrator::<f64>::new(IntegratorRule::Trapezoid, 0.01).unwrap();
        let runs = 2000;
        let ends: Vec<f64> = (0..runs)
            .map(|_| {
                let mut offset = sources.offset + sources.offset_uncertainty * normal();
                let tilt = sources.orientation + sources.orientation_uncertainty * normal();
                let gain = 1.0 + sources.gain + sources.gain_uncertainty * normal();
                let mut state = IntegratorState::new(0.0);
                let mut v = 0.0;
                for _ in 0..=1000 {
                    offset += sources.walk * 0.1 * normal();
                    // 0.2 m/s² for ten seconds.
                    let a = gain * 0.2 + STANDARD_GRAVITY * tilt.sin() + offset;
                    v = trapezoid.step(&mut state, a + sources.noise * normal());
                }
                v - 2.0
            })
            .collect();
        let budget = sources.after(10.0);
        let mean = ends.iter().sum::<f64>() / f64::from(runs);
        let spread = ends.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / f64::from(runs);
        let spread = spread.sqrt();
        // Four standard deviations of a mean of 2000; of their standard deviation (1.6 %) three.
        assert!(
            (mean - budget.known()).abs() < 4.0 * budget.combined / f64::from(runs).sqrt(),
            "{mean} {budget:?}"
        );
        assert!(
            (spread / budget.combined - 1.0).abs() < 0.05,
            "{spread} {budget:?}"
        );
    }

    #[test]
    fn law_noise_walks_as_the_budget_says() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
        let sources = DriftSources {
            noise: 0.1,
            sample_time: 0.01,
            ..DriftSources::default()
        };
        let trapezoid = Integrator::<f64>::new(IntegratorRule::Trapezoid, 0.01).unwrap();
        let ends: Vec<f64> = (0..2000)
            .map(|_| {
                let mut s = IntegratorState::new(0.0);
                (0..=1000)
                    .map(|_| {
                        let e: f64 = StandardNormal.sample(&mut rng);
                        trapezoid.step(&mut s, 0.1 * e)
                    })
                    .last()
                    .unwrap_or(0.0)
            })
            .collect();
        let rms = (ends.iter().map(|e| e * e).sum::<f64>() / 2000.0).sqrt();
        // Standard deviation of a standard deviation from 2000: 1.6 %; three of them.
        assert!(
            (rms / sources.after(10.0).noise - 1.0).abs() < 0.05,
            "{rms}"
        );
    }

    #[test]
    fn refuses_what_no_accelerometer_is() {
        assert!(DriftSources::default().check().is_ok());
        for bad in [
            DriftSources {
                offset: f64::NAN,
                ..DriftSources::default()
            },
            DriftSources {
                noise: -1.0,
                ..DriftSources::default()
            },
            DriftSources {
                orientation: 2.0,
                ..DriftSources::default()
            },
            DriftSources {
                walk: f64::INFINITY,
                ..DriftSources::default()
            },
        ] {
            assert!(bad.check().is_err(), "{bad:?}");
        }
    }
}

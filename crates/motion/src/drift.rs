//! The drift one has to expect of a velocity from an accelerometer alone.

use proofmass_core::check::{finite, within};
use proofmass_core::{Error, STANDARD_GRAVITY};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// What integration alone does to a velocity after a time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DriftBudget {
    /// Time, s.
    pub time: f64,
    /// From a known offset: b t, m/s.
    pub offset: f64,
    /// From a known inclination of the axis: g sin θ t, m/s.
    pub orientation: f64,
    /// From a known error of the gain: ε Δv, m/s.
    pub gain: f64,
    /// Standard uncertainty from that of the offset, m/s.
    pub offset_uncertainty: f64,
    /// Standard uncertainty from that of the inclination: g cos θ u(θ) t, m/s.
    pub orientation_uncertainty: f64,
    /// Standard uncertainty from that of the gain: u(ε) |Δv|, m/s.
    pub gain_uncertainty: f64,
    /// Standard uncertainty from white noise: σ √(T t), m/s.
    pub noise: f64,
    /// Standard uncertainty from an offset that walks: s √(t³/3), m/s.
    pub walk: f64,
    /// Combined standard uncertainty, m/s.
    pub combined: f64,
}

impl DriftBudget {
    /// What is known of the drift: offset, inclination and gain together, m/s.
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
        ] {
            within(name, value, 0.0, f64::MAX)?;
        }
        Ok(())
    }

    /// Drift after a time.
    ///
    /// ```
    /// use proofmass_motion::DriftSources;
    /// let tilt = DriftSources { orientation: 1f64.to_radians(), ..DriftSources::default() };
    /// assert!((tilt.after(10.0).orientation - 1.7115).abs() < 1e-4); // one degree, ten seconds
    /// ```
    pub fn after(&self, time: f64) -> DriftBudget {
        let offset_uncertainty = self.offset_uncertainty * time;
        let orientation_uncertainty =
            STANDARD_GRAVITY * self.orientation.cos() * self.orientation_uncertainty * time;
        let gain_uncertainty = self.gain_uncertainty * self.speed.abs();
        let noise = self.noise * (self.sample_time * time).sqrt();
        let walk = self.walk * (time.powi(3) / 3.0).sqrt();
        DriftBudget {
            time,
            offset: self.offset * time,
            orientation: STANDARD_GRAVITY * self.orientation.sin() * time,
            gain: self.gain * self.speed,
            offset_uncertainty,
            orientation_uncertainty,
            gain_uncertainty,
            noise,
            walk,
            combined: [orientation_uncertainty, gain_uncertainty, noise, walk]
                .into_iter()
                .fold(offset_uncertainty, f64::hypot),
        }
    }
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

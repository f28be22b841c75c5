//! The drift that an encoder beside the accelerometer leaves: bounded in the velocity, and in the place by what its own errors add up to.

use crate::DriftSources;
use proofmass_core::check::{not_negative, positive};
use proofmass_core::velocity::{BiasModel, Hold, Kalman, KalmanState, MotionNoise, ProcessNoise};
use proofmass_core::{Error, STANDARD_GRAVITY};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// An encoder beside the accelerometer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct EncoderAiding {
    /// Length of one count, m.
    pub increment: f64,
    /// Readings per second.
    pub rate: f64,
    /// Relative standard uncertainty of the length of a count: of the radius of a wheel, of the lines of a scale.
    #[serde(default)]
    pub scale_uncertainty: f64,
    /// What errors of single counts and slip add up to, m/√m: its standard deviation after a metre.
    #[serde(default)]
    pub walk: f64,
}

/// What is off after a time with the encoder's aiding: standard uncertainties of velocity, m/s, and place, m.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct AidedDrift {
    /// Time, s.
    pub time: f64,
    /// Of the Kalman filter of both sensors: noise of the accelerometer, its offset, and the increment.
    pub filter: [f64; 2],
    /// From the length of a count: it grows with velocity and way.
    pub scale: [f64; 2],
    /// From what single counts add up to, of the place alone.
    pub walk: f64,
    /// Combined.
    pub combined: [f64; 2],
}

/// Steps of the filter before it is taken for settled, and those that are run at most.
const MOST: usize = 2_000_000;

impl EncoderAiding {
    /// Refuses what no encoder is.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::OutOfRange`].
    pub fn check(&self) -> Result<(), Error> {
        positive("length of a count", self.increment)?;
        positive("readings per second", self.rate)?;
        not_negative(
            "uncertainty of the length of a count",
            self.scale_uncertainty,
        )?;
        not_negative("walk of the counts", self.walk)?;
        Ok(())
    }

    /// After times that do not fall, from a known velocity on.
    ///
    /// The filter is that of [`Kalman`] with the offset as a state: δ²/12 of a count, N of the noise and K of the walk; flicker noise and
    /// Gauss–Markov processes count as white noise of their density at the crossover of both sensors, where they weigh most. Offset and
    /// inclination, known or not, are what the offset may be at the start. With the scale uncertainty ε, ε Δv and ε of the way (half of Δv t,
    /// as of an even acceleration) come on top, and the walk by √way: the place drifts as the counts do, whatever the accelerometer is.
    ///
    /// **Assumes** a count and more between readings: an axis that rests within a count is known better. **Accuracy**
    /// `law_aided_velocities_scatter_as_stated`.
    ///
    /// ```
    /// use proofmass_motion::{DriftSources, EncoderAiding};
    /// let alone = DriftSources { noise: 0.02, sample_time: 1e-3, offset_uncertainty: 0.05, ..DriftSources::default() };
    /// let encoder = EncoderAiding { increment: 1e-3, rate: 1000.0, scale_uncertainty: 0.0, walk: 0.0 };
    /// let aided = encoder.beside(&alone, &[1.0, 60.0])?;
    /// // Alone the velocity is off by 3 m/s after a minute, with the encoder by half a millimetre per second.
    /// assert!(alone.after(60.0).combined > 2.9);
    /// assert!(aided[1].combined[0] < 1e-3);
    /// # Ok::<(), proofmass_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::check`] and [`DriftSources::check`].
    pub fn beside(&self, sources: &DriftSources, times: &[f64]) -> Result<Vec<AidedDrift>, Error> {
        self.check()?;
        sources.check()?;
        let reading = self.increment * self.increment / 12.0;
        let density = sources.noise * sources.noise * sources.sample_time;
        // Crossover of a filter of white acceleration beside readings of this density: ω⁴ = q/r.
        let read_density = reading / self.rate;
        let mut q = density.max(f64::MIN_POSITIVE);
        for _ in 0..8 {
            let f = ((q / read_density).sqrt().sqrt() / TAU).max(1e-4);
            let markov = sources.markov.iter().filter(|m| m[0] > 0.0);
            let markov: f64 = markov
                .map(|m| 2.0 * m[0] * m[0] * m[1] / (1.0 + (TAU * f * m[1]).powi(2)))
                .sum();
            q = density + sources.flicker * sources.flicker / (2.0 * PI * f) + markov;
        }
        let noise = MotionNoise {
            // Below it the filter would trust the integral without end.
            acceleration: q.max(1e-12 * reading * self.rate.powi(3)),
            form: ProcessNoise::Continuous,
            position: reading,
        };
        let bias = BiasModel::RandomWalk {
            density: sources.walk * sources.walk,
            initial: 0.0,
        };
        let filter = Kalman::<f64, 3>::with_bias(&noise, bias, Hold::First, 1.0 / self.rate)?;
        let tilt = STANDARD_GRAVITY * sources.orientation.cos() * sources.orientation_uncertainty;
        let known = sources.offset + STANDARD_GRAVITY * sources.orientation.sin();
        let offset = sources.offset_uncertainty.hypot(tilt).hypot(known);
        let mut state = KalmanState::new([0.0; 3], [reading, 0.0, offset * offset], 0.0);
        let mut step = 0;
        let aided = times.iter().map(|time| {
            // Before the first reading as after it: nothing is known better.
            let first = if *time > 0.0 { 1.0 } else { 0.0 };
            let due = (time * self.rate).round().clamp(first, MOST as f64) as usize;
            while step < due {
                let before = state.p;
                filter.step(&mut state, Some(0.0), 0.0);
                step += 1;
                let still =
                    |i: usize| (state.p[i][i] - before[i][i]).abs() <= 1e-13 * state.p[i][i];
                if (0..3).all(still) {
                    step = MOST;
                }
            }
            let [x, v] = [0, 1].map(|i: usize| state.p[i][i].max(0.0).sqrt());
            let way = (0.5 * sources.speed * time).abs();
            let scale = [sources.speed.abs(), way].map(|s| self.scale_uncertainty * s);
            let walk = self.walk * way.sqrt();
            AidedDrift {
                time: *time,
                filter: [v, x],
                scale,
                walk,
                combined: [v.hypot(scale[0]), x.hypot(scale[1]).hypot(walk)],
            }
        });
        Ok(aided.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Axes that move under white noise, their counts rounded, the offset and the scale drawn: the filter's error against what is stated.
    #[test]
    fn law_aided_velocities_scatter_as_stated() {
        let sources = DriftSources {
            noise: 0.02,
            sample_time: 2e-3,
            offset_uncertainty: 0.05,
            orientation_uncertainty: 0.5f64.to_radians(),
            walk: 1e-3,
            speed: 1.0,
            ..DriftSources::default()
        };
        let encoder = EncoderAiding {
            increment: 2e-3,
            rate: 500.0,
            scale_uncertainty: 2e-3,
            walk: 0.0,
        };
        let times = [0.5, 4.0];
        let stated = encoder.beside(&sources, &times).unwrap();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        let mut uniform = Xoshiro256PlusPlus::seed_from_u64(6);
        let dt = 1.0 / encoder.rate;
        let noise = MotionNoise {
            acceleration: (sources.noise * sources.noise) * dt,
            form: ProcessNoise::Continuous,
            position: encoder.increment.powi(2) / 12.0,
        };
        let walk = BiasModel::RandomWalk {
            density: sources.walk.powi(2),
            initial: 0.0,
        };
        let filter = Kalman::<f64, 3>::with_bias(&noise, walk, Hold::First, dt).unwrap();
        let tilt = STANDARD_GRAVITY * sources.orientation_uncertainty;
        let u_offset = sources.offset_uncertainty.hypot(tilt);
        let runs = 600;
        let mut squares = [[0.0; 2]; 2];
        for _ in 0..runs {
            let mut offset = u_offset * normal();
            let scale = 1.0 + encoder.scale_uncertainty * normal();
            let phase: f64 = uniform.random();
            // Even acceleration from rest to the speed at the time that is asked for.
            for (which, end) in times.iter().enumerate() {
                let a = sources.speed / end;
                let variances = [noise.position, 0.0, u_offset * u_offset];
                let mut state = KalmanState::new([0.0; 3], variances, a);
                let n = (end / dt).round() as usize;
                for k in 1..=n {
                    let t = k as f64 * dt;
                    offset += sources.walk * dt.sqrt() * normal();
                    let way = scale * 0.5 * a * t * t / encoder.increment + phase;
                    let read = (way.floor() + 0.5 - phase) * encoder.increment;
                    filter.step(
                        &mut state,
                        Some(read),
                        a + offset + sources.noise * normal(),
                    );
                }
                let off = [state.x[1] - sources.speed, state.x[0] - 0.5 * a * end * end];
                for (s, o) in squares[which].iter_mut().zip(off) {
                    *s += o * o;
                }
            }
        }
        for (which, stated) in stated.iter().enumerate() {
            for part in 0..2 {
                let found = (squares[which][part] / f64::from(runs)).sqrt();
                // Of a deviation from 600: 2.9 %, four of them; the first samples move less than a count.
                let ratio = found / stated.combined[part];
                assert!(
                    (ratio - 1.0).abs() < 0.15,
                    "{which} {part}: {found} {stated:?}"
                );
            }
        }
    }

    #[test]
    fn law_the_place_drifts_with_the_counts_alone() {
        let sources = DriftSources {
            noise: 0.02,
            sample_time: 1e-3,
            speed: 2.0,
            ..DriftSources::default()
        };
        let encoder = EncoderAiding {
            increment: 1e-3,
            rate: 1000.0,
            scale_uncertainty: 1e-3,
            walk: 2e-3,
        };
        let aided = encoder.beside(&sources, &[1.0, 100.0]).unwrap();
        assert!((aided[1].scale[1] - 0.1).abs() < 1e-12);
        assert!((aided[1].walk - 0.02).abs() < 1e-12);
        // The filter has settled long before.
        assert!((aided[0].filter[0] / aided[1].filter[0] - 1.0).abs() < 1e-3);
        assert!(
            EncoderAiding {
                increment: 0.0,
                ..encoder
            }
            .check()
            .is_err()
        );
        assert!(
            EncoderAiding {
                walk: f64::NAN,
                ..encoder
            }
            .check()
            .is_err()
        );
    }
}

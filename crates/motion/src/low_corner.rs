//! Low-frequency corner of an accelerometer: what a charge amplifier, an AC coupling or a piezoelectric element loses of slow
//! accelerations, and how it is given back.

use crate::{KalmanModel, MotionRecord};
use proofmass_core::Error;
use proofmass_core::velocity::{Kalman, ProcessNoise};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Stages below which the output of an accelerometer falls: each a high-pass of first order, s/(s + 2πf).
///
/// Of second order are two stages of one frequency, as of a charge amplifier before an AC coupling of the same corner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LowCorner {
    /// Frequency f at which a stage has lost 3 dB, Hz.
    pub frequency: f64,
    /// Its standard uncertainty, Hz.
    pub uncertainty: f64,
    /// Stages: one or two.
    pub order: u8,
}

impl LowCorner {
    /// A corner of first or second order.
    ///
    /// # Errors
    /// [`Error::OutOfRange`]: a frequency that is not above zero, a negative uncertainty or one of half the frequency and more, another order.
    pub fn new(frequency: f64, uncertainty: f64, order: u8) -> Result<Self, Error> {
        for (name, value, min, max) in [
            ("low corner", frequency, f64::MIN_POSITIVE, f64::MAX),
            (
                "uncertainty of the low corner",
                uncertainty,
                0.0,
                0.5 * frequency,
            ),
            ("order of the low corner", f64::from(order), 1.0, 2.0),
        ] {
            if !(value.is_finite() && (min..=max).contains(&value)) {
                return Err(Error::OutOfRange {
                    name,
                    value,
                    min,
                    max,
                });
            }
        }
        Ok(Self {
            frequency,
            uncertainty,
            order,
        })
    }

    /// The highest corner beside samples of this time, Hz: a twentieth of their rate. What lies above is no slow acceleration, and a corner
    /// is not known by its samples there.
    pub fn highest(sample_time: f64) -> f64 {
        0.05 / sample_time
    }

    /// 2πf.
    pub(crate) fn rate(&self) -> f64 {
        TAU * self.frequency
    }

    /// The same of all stages together.
    pub(crate) fn total_rate(&self) -> f64 {
        f64::from(self.order) * self.rate()
    }

    /// What an offset of one behind the corner becomes of an acceleration that is given back, of its highest power of the time: ω t, or of
    /// two stages ω² as the bend.
    pub(crate) fn of_offset(&self) -> f64 {
        self.rate().powi(i32::from(self.order))
    }

    /// Density of the walk of the slope behind two stages, of that of the offset: noise w makes 2 ω w of the one and ω² w of the other.
    pub(crate) fn slope_of_walk(&self, walk: f64) -> f64 {
        0.25 * self.rate() * self.rate() * walk
    }
}

/// How fast the offset behind a corner may walk, over the walk of an acceleration that is given back: little enough to cost nothing, and
/// enough that the gain does not fall to zero.
const OFFSET_WALK: f64 = 0.1;

/// Filters of an accelerometer with a low corner, of which every stage is a state.
///
/// The noise of the accelerometer enters velocity and shown velocity alike, so that the offset of what is given back walks by (2πf)² q of
/// itself, for one stage; the offset behind the corner walks by a hundredth of that.
impl KalmanModel {
    fn offset_walk(&self, corner: &LowCorner, sample_time: f64) -> f64 {
        let density = match self.noise_form {
            ProcessNoise::SampleConstant => self.acceleration_noise * sample_time,
            ProcessNoise::Continuous => self.acceleration_noise,
        };
        (OFFSET_WALK * corner.total_rate()).powi(2) * density
    }

    /// Of one stage: position, velocity, shown velocity and offset.
    ///
    /// # Errors
    /// As [`Kalman::with_low_corner`].
    pub fn behind_one_stage(
        &self,
        corner: &LowCorner,
        sample_time: f64,
    ) -> Result<Kalman<f64, 4>, Error> {
        let walk = self.offset_walk(corner, sample_time);
        let (noise, hold) = (self.noise(), self.interpolation);
        Kalman::<f64, 4>::with_low_corner(&noise, walk, corner.frequency, hold, sample_time)
    }

    /// Of two stages: position, velocity, what each has shown of it, and offset.
    ///
    /// # Errors
    /// As [`Kalman::with_second_order_corner`].
    pub fn behind_two_stages(
        &self,
        corner: &LowCorner,
        sample_time: f64,
    ) -> Result<Kalman<f64, 5>, Error> {
        let walk = self.offset_walk(corner, sample_time);
        let (noise, hold) = (self.noise(), self.interpolation);
        Kalman::<f64, 5>::with_second_order_corner(
            &noise,
            walk,
            corner.frequency,
            hold,
            sample_time,
        )
    }
}

impl MotionRecord {
    /// The record with the slow accelerations that a corner took given back: a = y + ω ∫ y dt for each stage.
    ///
    /// Less an offset that is added behind the corner, and would become a ramp. The acceleration before the first sample is not known and
    /// becomes an offset; the noise of the accelerometer is integrated with the rest, and its offset walks by that.
    #[must_use]
    pub(crate) fn given_back(&self, corner: &LowCorner, offset: f64) -> Self {
        let half = 0.5 * self.sample_time * corner.rate();
        let mut acceleration: Vec<f64> = self.acceleration.iter().map(|a| a - offset).collect();
        for _ in 0..corner.order {
            let (mut sum, mut last) = (0.0, None::<f64>);
            for a in &mut acceleration {
                let y = *a;
                sum += last.map_or(0.0, |before| half * (before + y));
                *a = y + sum;
                last = Some(y);
            }
        }
        Self {
            low_corner: None,
            given_back: Some(*corner),
            ..self.beside(acceleration)
        }
    }

    /// The corner of two stages whose slow accelerations were given back: the noise was integrated twice.
    pub(crate) fn behind_two_stages(&self) -> Option<LowCorner> {
        self.given_back.filter(|corner| corner.order > 1)
    }

    /// The accelerations as they were before those that this corner took were given back.
    pub(crate) fn taken_again(&self, corner: &LowCorner) -> Self {
        let half = 0.5 * self.sample_time * corner.rate();
        let mut acceleration = self.acceleration.clone();
        for _ in 0..corner.order {
            let (mut sum, mut last) = (0.0, None::<f64>);
            for y in &mut acceleration {
                let a = *y;
                *y = match last {
                    None => a,
                    Some(before) => (a - sum - half * before) / (1.0 + half),
                };
                sum += last.map_or(0.0, |before| half * (before + *y));
                last = Some(*y);
            }
        }
        Self {
            given_back: None,
            ..self.beside(acceleration)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReadingSource;

    /// A step of acceleration through s²/(s + ω)² is (1 − ω t) e^(−ω t), through one stage e^(−ω t): given back it is the step.
    #[test]
    fn law_a_step_is_given_back() {
        let (f, dt) = (0.5, 1e-3);
        let w = TAU * f;
        for order in [1, 2] {
            let y = |k: usize| {
                let t = dt * k as f64;
                let stage = (-w * t).exp();
                2.0 * if order == 1 {
                    stage
                } else {
                    (1.0 - w * t) * stage
                }
            };
            let record = MotionRecord::new(
                dt,
                ReadingSource::Position,
                vec![Some(0.0); 4000],
                (0..4000).map(y).collect(),
            )
            .unwrap();
            let corner = LowCorner::new(f, 0.0, order).unwrap();
            let back = record.given_back(&corner, 0.0);
            // The trapezoid errs by ω² dt²/12 of the second derivative, which is up to 3 · 2 of two stages, and a second stage sums that.
            for (k, a) in back.acceleration.iter().enumerate() {
                let most = 6.0 * (w * dt).powi(2) / 12.0 * (1.0 + w * dt * k as f64);
                assert!((a - 2.0).abs() < most, "order {order}, sample {k}: {a}");
            }
            assert!(back.low_corner.is_none());
            let again = back.taken_again(&corner);
            for (ours, y) in again.acceleration.iter().zip(&record.acceleration) {
                assert!((ours - y).abs() < 1e-9, "order {order}: {ours} {y}");
            }
        }
    }

    #[test]
    fn refuses_a_corner_that_is_none() {
        for (f, u, order) in [
            (0.0, 0.0, 1),
            (f64::NAN, 0.0, 1),
            (1.0, 0.6, 1),
            (1.0, -0.1, 1),
            (1.0, 0.0, 3),
        ] {
            assert!(LowCorner::new(f, u, order).is_err(), "{f} {u} {order}");
        }
    }
}

//! Low-frequency corner of an accelerometer: what a charge amplifier, an AC coupling or a piezoelectric element loses of slow
//! accelerations, and how it is given back.

use crate::MotionRecord;
use proofmass_core::Error;
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

    /// 2πf.
    pub(crate) fn rate(&self) -> f64 {
        TAU * self.frequency
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
        let rate = f64::from(corner.order) * corner.rate();
        Self {
            acceleration,
            reading: self.reading.clone(),
            edges: self.edges.clone(),
            blows: self.blows.clone(),
            low_corner: None,
            noise_walk: rate * rate,
            ..*self
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

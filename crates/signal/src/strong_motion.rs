//! What seismologists and vehicle engineers read from a record of acceleration: intensity, velocity, displacement.

use proofmass_core::check::positive;
use proofmass_core::{Error, STANDARD_GRAVITY};
use proofmass_uncertainty::algebra::least_squares;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// What is taken from a record before it is integrated. Nothing is removed unless it is named here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Baseline {
    /// Nothing.
    #[default]
    None,
    /// The mean of the whole record: velocity ends where it began.
    Mean,
    /// The mean of the first seconds, before anything moves.
    BeforeMotion {
        /// How many seconds.
        seconds: f64,
    },
    /// The derivative of v = c₁t + … + c_d t^d, fitted to the velocity.
    Velocity {
        /// d, from 1 to 6.
        degree: usize,
    },
}

/// Velocity and displacement from rest, by the trapezoidal rule and the exact integral of straight lines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Motion {
    /// Acceleration after the correction, m/s².
    pub acceleration: Vec<f64>,
    /// m/s.
    pub velocity: Vec<f64>,
    /// m.
    pub displacement: Vec<f64>,
}

/// Figures of one record.
///
/// Arias intensity π/(2g) ∫a² dt and cumulative absolute velocity ∫|a| dt by the trapezoidal rule, with standard gravity
/// 9.80665 m/s² where none is given; durations between 5 % and 75 %, 5 % and 95 % of the intensity, and the longest
/// time between excursions beyond a level.
///
/// **Units** record in m/s², rate in Hz.
///
/// **Errors** [`Error::TooFew`] below two samples, [`Error::NotFinite`], [`Error::OutOfRange`] for rate or gravity.
///
/// **Source** `[Arias1970]`, `[EPRI1988]`, `[TrifunacBrady1975]`.
///
/// ```
/// use proofmass_signal::StrongMotion;
/// // 1 m/s² for one second.
/// let record = vec![1.0; 101];
/// let figures = StrongMotion::of(&record, 100.0, 9.81).unwrap();
/// assert!((figures.cumulative_absolute_velocity - 1.0).abs() < 1e-12);
/// assert!((figures.arias_intensity - std::f64::consts::PI / (2.0 * 9.81)).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StrongMotion {
    /// Greatest |a|, m/s².
    pub peak_acceleration: f64,
    /// m/s.
    pub arias_intensity: f64,
    /// m/s.
    pub cumulative_absolute_velocity: f64,
    /// From 5 % to 75 % of the Arias intensity, s.
    pub duration_5_75: f64,
    /// From 5 % to 95 %, s.
    pub duration_5_95: f64,
    /// Between the first and the last excursion beyond 0.05 of gravity, s; `None` without one.
    pub bracketed_duration: Option<f64>,
}

impl StrongMotion {
    /// Figures of a record with this gravity in m/s².
    ///
    /// # Errors
    /// Those of the type.
    pub fn of(record: &[f64], rate: f64, gravity: f64) -> Result<Self, Error> {
        check(record, rate)?;
        positive("gravity", gravity)?;
        let step = 1.0 / rate;
        let mut energy = Vec::with_capacity(record.len());
        let (mut sum, mut absolute) = (0.0, 0.0);
        energy.push(0.0);
        for pair in record.windows(2) {
            sum += 0.5 * step * (pair[0] * pair[0] + pair[1] * pair[1]);
            absolute += 0.5 * step * (pair[0].abs() + pair[1].abs());
            energy.push(sum);
        }
        let at = |share: f64| crossing(&energy, share * sum) * step;
        let beyond = |a: &f64| a.abs() > 0.05 * gravity;
        let bracket = record
            .iter()
            .position(beyond)
            .zip(record.iter().rposition(beyond));
        Ok(Self {
            peak_acceleration: record.iter().fold(0.0, |m, a| a.abs().max(m)),
            arias_intensity: 0.5 * PI / gravity * sum,
            cumulative_absolute_velocity: absolute,
            duration_5_75: at(0.75) - at(0.05),
            duration_5_95: at(0.95) - at(0.05),
            bracketed_duration: bracket.map(|(first, last)| (last - first) as f64 * step),
        })
    }

    /// [`StrongMotion::of`] with standard gravity.
    ///
    /// # Errors
    /// Those of the type.
    pub fn standard(record: &[f64], rate: f64) -> Result<Self, Error> {
        Self::of(record, rate, STANDARD_GRAVITY)
    }
}

/// Where a rising series reaches a value, in steps, between points by a straight line.
fn crossing(rising: &[f64], value: f64) -> f64 {
    let after = rising.partition_point(|v| *v < value);
    if after == 0 || after == rising.len() {
        return after.min(rising.len() - 1) as f64;
    }
    let (low, high) = (rising[after - 1], rising[after]);
    (after - 1) as f64 + (value - low) / (high - low)
}

fn check(record: &[f64], rate: f64) -> Result<(), Error> {
    positive("sample rate", rate)?;
    if record.len() < 2 {
        return Err(Error::TooFew {
            name: "samples",
            needed: 2,
            got: record.len(),
        });
    }
    match record.iter().position(|a| !a.is_finite()) {
        Some(index) => Err(Error::NotFinite {
            name: "record",
            index,
        }),
        None => Ok(()),
    }
}

impl Baseline {
    /// Corrects a record and integrates it twice.
    ///
    /// # Errors
    /// [`Error::TooFew`] below two samples, or below d + 2 for a fitted velocity; [`Error::NotFinite`];
    /// [`Error::OutOfRange`] for a rate, a time or a degree that makes no sense.
    pub fn integrate(self, record: &[f64], rate: f64) -> Result<Motion, Error> {
        check(record, rate)?;
        let mut acceleration = record.to_vec();
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        match self {
            Self::None => {}
            Self::Mean => {
                let offset = mean(record);
                acceleration.iter_mut().for_each(|a| *a -= offset);
            }
            Self::BeforeMotion { seconds } => {
                let length = record.len() as f64 / rate;
                if !(seconds * rate >= 1.0 && seconds <= length) {
                    return Err(Error::OutOfRange {
                        name: "time before the motion",
                        value: seconds,
                        min: 1.0 / rate,
                        max: length,
                    });
                }
                let count = ((seconds * rate) as usize).clamp(1, record.len());
                let offset = mean(&record[..count]);
                acceleration.iter_mut().for_each(|a| *a -= offset);
            }
            Self::Velocity { degree } => {
                if !(1..=6).contains(&degree) {
                    return Err(Error::OutOfRange {
                        name: "degree of the velocity",
                        value: degree as f64,
                        min: 1.0,
                        max: 6.0,
                    });
                }
                subtract_fitted(&mut acceleration, rate, degree)?;
            }
        }
        Ok(integrated(acceleration, rate))
    }
}

fn integrated(acceleration: Vec<f64>, rate: f64) -> Motion {
    let step = 1.0 / rate;
    let (mut v, mut x) = (0.0, 0.0);
    let mut velocity = vec![0.0];
    let mut displacement = vec![0.0];
    for pair in acceleration.windows(2) {
        x += step * (v + step * (2.0 * pair[0] + pair[1]) / 6.0);
        v += 0.5 * step * (pair[0] + pair[1]);
        velocity.push(v);
        displacement.push(x);
    }
    Motion {
        acceleration,
        velocity,
        displacement,
    }
}

/// Least squares of the velocity on τ, τ², …, τ = t/length, by orthogonal columns.
fn subtract_fitted(acceleration: &mut [f64], rate: f64, degree: usize) -> Result<(), Error> {
    let n = acceleration.len();
    if n < degree + 2 {
        return Err(Error::TooFew {
            name: "samples",
            needed: degree + 2,
            got: n,
        });
    }
    let velocity = integrated(acceleration.to_vec(), rate).velocity;
    let tau = |k: usize| k as f64 / (n - 1) as f64;
    let matrix = faer::Mat::from_fn(n, degree, |k, d| tau(k).powi(d as i32 + 1));
    let right = faer::Mat::from_fn(n, 1, |k, _| velocity[k]);
    let solution = least_squares(&matrix, &right);
    let length = (n - 1) as f64 / rate;
    for (k, a) in acceleration.iter_mut().enumerate() {
        let slope: f64 = (0..degree)
            .map(|d| solution[(d, 0)] * (d + 1) as f64 * tau(k).powi(d as i32))
            .sum();
        *a -= slope / length;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_a_drifting_record_is_freed_from_the_drift() {
        // v = 1 − cos t + t² + t³/3 over ten periods: the fitted cubic takes the drift and leaves the oscillation.
        let rate = 200.0;
        let record: Vec<f64> = (0..12_567)
            .map(|k| f64::from(k) / rate)
            .map(|t| t.sin() + 2e-3 * t + 1e-4 * t * t)
            .collect();
        let motion = Baseline::Velocity { degree: 3 }
            .integrate(&record, rate)
            .unwrap();
        // Over whole periods sin t correlates with τᵏ by 2π/ωT at most: 3/62.8 of its amplitude.
        let residual: f64 = motion
            .acceleration
            .iter()
            .enumerate()
            .map(|(k, a)| (a - (k as f64 / rate).sin()).abs())
            .fold(0.0, f64::max);
        assert!(residual < 0.35, "{residual}");
        let mean = Baseline::Mean.integrate(&record, rate).unwrap();
        assert!(mean.velocity[12_566].abs() < 0.01);
    }

    #[test]
    fn refuses_what_cannot_be_integrated() {
        let record = [0.0, 1.0, 2.0];
        for baseline in [
            Baseline::BeforeMotion { seconds: 9.0 },
            Baseline::BeforeMotion { seconds: f64::NAN },
            Baseline::Velocity { degree: 0 },
            Baseline::Velocity { degree: 9 },
            Baseline::Velocity { degree: 5 },
        ] {
            assert!(baseline.integrate(&record, 10.0).is_err(), "{baseline:?}");
        }
        assert!(StrongMotion::standard(&[1.0, f64::NAN], 10.0).is_err());
        assert!(StrongMotion::standard(&[1.0, 1.0], -1.0).is_err());
    }
}

//! Coefficients in the units that data sheets, filters and other programs use.

use crate::{CoefficientFit, Term, Verdict};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Standard acceleration of free fall, m/s² (exact by definition).
const STANDARD_GRAVITY: f64 = 9.80665;

/// What the rate is, in SI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// Acceleration in m/s².
    Accelerometer,
    /// Angular rate in rad/s.
    Gyroscope,
}

impl Sensor {
    /// The sensor whose rate has this SI unit.
    pub fn of_unit(unit: &str) -> Option<Self> {
        let all = [Self::Accelerometer, Self::Gyroscope];
        all.into_iter().find(|sensor| sensor.unit() == unit)
    }

    /// SI unit of the rate.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Accelerometer => "m/s²",
            Self::Gyroscope => "rad/s",
        }
    }
}

/// A value with its unit and, where it matters, its definition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct InUnit {
    /// Number in that unit.
    pub value: f64,
    /// The unit.
    pub unit: String,
    /// What exactly is meant.
    pub meaning: String,
}

/// A coefficient in every unit in use.
///
/// N appears both as the Allan (two-sided) density and as the one-sided amplitude density √2 N of data sheets; B as
/// coefficient and as floor of the curve, √(2 ln 2/π) B = 0.664 B.
///
/// ```
/// use proofmass_noise::{Sensor, Term, in_units};
/// // 25 µg/√Hz of a data sheet is one-sided.
/// let n = 25e-6 * 9.80665 / 2.0_f64.sqrt();
/// let units = in_units(Term::White, n, Sensor::Accelerometer, 100.0);
/// let sheet = units.iter().find(|u| u.meaning.contains("one-sided") && u.unit == "µg/√Hz").unwrap();
/// assert!((sheet.value - 25.0).abs() < 1e-12);
/// let walk = units.iter().find(|u| u.unit == "m/s/√h").unwrap();
/// assert!((walk.value - n * 60.0).abs() < 1e-15);
/// ```
pub fn in_units(term: Term, value: f64, sensor: Sensor, sample_rate: f64) -> Vec<InUnit> {
    let entry = |value: f64, unit: &str, meaning: &str| InUnit {
        value,
        unit: unit.to_owned(),
        meaning: meaning.to_owned(),
    };
    let micro_g = 1e6 / STANDARD_GRAVITY;
    let degrees = 180.0 / std::f64::consts::PI;
    let root_two = std::f64::consts::SQRT_2;
    let floor = crate::model::FLICKER.sqrt();
    let mut units = vec![entry(
        value,
        &term.unit(sensor.unit()),
        "coefficient of the model",
    )];
    let discrete = (value * sample_rate.sqrt(), sensor.unit());
    match (term, sensor) {
        (Term::White, Sensor::Accelerometer) => units.extend([
            entry(
                value * micro_g,
                "µg/√Hz",
                "two-sided root density, Allan deviation at 1 s",
            ),
            entry(
                root_two * value * micro_g,
                "µg/√Hz",
                "one-sided amplitude density",
            ),
            entry(
                root_two * value * 1e-3 * micro_g,
                "mg/√Hz",
                "one-sided amplitude density",
            ),
            entry(
                root_two * value,
                "(m/s²)/√Hz",
                "one-sided amplitude density",
            ),
            entry(value * 60.0, "m/s/√h", "velocity random walk"),
            entry(discrete.0, discrete.1, "standard deviation of one sample"),
        ]),
        (Term::White, Sensor::Gyroscope) => units.extend([
            entry(
                value * degrees,
                "(°/s)/√Hz",
                "two-sided root density, Allan deviation at 1 s",
            ),
            entry(
                root_two * value * degrees,
                "(°/s)/√Hz",
                "one-sided amplitude density",
            ),
            entry(value * degrees * 60.0, "°/√h", "angle random walk"),
            entry(discrete.0, discrete.1, "standard deviation of one sample"),
        ]),
        (Term::Flicker, Sensor::Accelerometer) => units.extend([
            entry(value * micro_g, "µg", "coefficient B"),
            entry(
                floor * value * micro_g,
                "µg",
                "floor of the Allan deviation, 0.664 B",
            ),
        ]),
        (Term::Flicker, Sensor::Gyroscope) => units.extend([
            entry(value * degrees * 3600.0, "°/h", "coefficient B"),
            entry(
                floor * value * degrees * 3600.0,
                "°/h",
                "floor of the Allan deviation, 0.664 B",
            ),
        ]),
        (Term::RandomWalk, Sensor::Accelerometer) => units.extend([
            entry(value * micro_g, "µg/√s", "growth of the bias"),
            entry(
                value * 3600.0_f64.powf(1.5),
                "m/s/h^(3/2)",
                "rate random walk",
            ),
            entry(
                value / sample_rate.sqrt(),
                sensor.unit(),
                "step of the bias per sample",
            ),
        ]),
        (Term::RandomWalk, Sensor::Gyroscope) => units.extend([
            entry(
                value * degrees * 3600.0 * 60.0,
                "°/h/√h",
                "rate random walk",
            ),
            entry(
                value / sample_rate.sqrt(),
                sensor.unit(),
                "step of the bias per sample",
            ),
        ]),
        (Term::Quantisation, Sensor::Accelerometer) => {
            units.push(entry(value, "m/s", "velocity error of one sample"));
        }
        (Term::Quantisation, Sensor::Gyroscope) => {
            units.push(entry(
                value * degrees * 3600.0,
                "″",
                "angle error of one sample",
            ));
        }
        (Term::Ramp, Sensor::Accelerometer) => {
            units.push(entry(value * micro_g * 3600.0, "µg/h", "drift"));
        }
        (Term::Ramp, Sensor::Gyroscope) => {
            units.push(entry(value * degrees * 3600.0 * 3600.0, "°/h²", "drift"));
        }
        (Term::GaussMarkov | Term::Sinusoid, Sensor::Accelerometer) => {
            units.push(entry(
                value * micro_g,
                "µg",
                "standard deviation or amplitude",
            ));
        }
        (Term::GaussMarkov | Term::Sinusoid, Sensor::Gyroscope) => {
            units.push(entry(
                value * degrees * 3600.0,
                "°/h",
                "standard deviation or amplitude",
            ));
        }
    }
    units
}

/// Noise matrices of a Kalman filter that integrates the rate once and carries its bias.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct KalmanNoise {
    /// R: variance of one rate sample used as a measurement, N²·rate, U².
    pub measurement_variance: f64,
    /// Q for the state (integral of the rate, bias) over one step:
    /// [[N² Δt + K² Δt³/3, −K² Δt²/2], [−K² Δt²/2, K² Δt]], in (U·s)², U²·s, U².
    pub process: [[f64; 2]; 2],
    /// K that was used, U·√Hz.
    pub random_walk: f64,
    /// Whether that is the upper limit, because the most likely value is zero: a bias that cannot move is never right.
    pub random_walk_is_limit: bool,
}

/// Kalman noise of a fit at a sample rate.
///
/// The most likely values are used, identified or not; where that of K is zero, its upper limit. The bias is subtracted from
/// the rate, hence the negative covariance. Flicker, quantisation and ramp have no exact counterpart in this filter and
/// are left out; a Gauss–Markov process needs a state of its own.
///
/// **Errors** [`Error::OutOfRange`] for a sample rate that is not positive.
pub fn kalman_noise(fit: &CoefficientFit, sample_rate: f64) -> Result<KalmanNoise, Error> {
    crate::record::check_sample_rate(sample_rate)?;
    let dt = 1.0 / sample_rate;
    let (random_walk, random_walk_is_limit) = fit.random_walk_or_limit();
    let (n2, k2) = (fit.model.white.powi(2), random_walk * random_walk);
    let cross = -0.5 * k2 * dt * dt;
    Ok(KalmanNoise {
        measurement_variance: n2 * sample_rate,
        process: [[n2 * dt + k2 * dt.powi(3) / 3.0, cross], [cross, k2 * dt]],
        random_walk,
        random_walk_is_limit,
    })
}

/// A coefficient for a filter that must not trust a sensor of several axes too much.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Conservative {
    /// The number.
    pub value: f64,
    /// Whether it is the limit of an axis whose most likely value is zero.
    pub is_limit: bool,
    /// Why it is this.
    pub reason: String,
}

/// What a filter should take for all axes: of each its most likely value, or its upper limit where that is zero, so that no filter is told
/// that a bias cannot move; and the largest of these.
///
/// `None` without an axis that has either.
pub fn conservative(term: Term, axes: &[&CoefficientFit]) -> Option<Conservative> {
    let of_axes: Vec<(Verdict, f64, bool)> = axes
        .iter()
        .filter_map(|fit| {
            let verdict = fit.get(term)?.verdict;
            let (value, is_limit) = verdict.for_filters()?;
            Some((verdict, value, is_limit))
        })
        .collect();
    let percent = 100.0 * axes.first()?.probability;
    let (verdict, value, is_limit) = *of_axes.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let what = match (is_limit, verdict.interval(), verdict.upper()) {
        (true, ..) => format!("upper limit ({percent:.0} %), since its most likely value is zero"),
        (_, Some((low, high)), _) => {
            format!("most likely value; {percent:.0} % interval {low:.3e} to {high:.3e}")
        }
        (_, None, Some(limit)) => {
            format!("most likely value; not identifiable, below {limit:.3e} ({percent:.0} %)")
        }
        (_, None, None) => "most likely value".to_owned(),
    };
    let off = axes.iter().filter(|f| f.slow_misfit.is_some()).count();
    let doubt = match (term, off, axes.len()) {
        (Term::RandomWalk, 1.., 1) => {
            "; doubtful: the slowest cycles do not follow the fit (slow-noise-misfit)".to_owned()
        }
        (Term::RandomWalk, 1.., all) => format!(
            "; doubtful: the slowest cycles of {off} of {all} axes do not follow the fit (slow-noise-misfit)"
        ),
        _ => String::new(),
    };
    Some(Conservative {
        value,
        is_limit,
        reason: match of_axes.len() {
            1 => format!("{what}{doubt}"),
            count => format!("largest of {count} axes: {what}{doubt}"),
        },
    })
}

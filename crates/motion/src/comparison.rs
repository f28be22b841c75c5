//! Any set of methods on one record, at several sample rates, against a truth or a reference.

use crate::{Family, Method, MotionRecord};
use proofmass_core::Error;

/// What one estimate did against the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Agreement {
    /// Root of the mean square error.
    pub rms: f64,
    /// Mean error.
    pub bias: f64,
    /// Largest error.
    pub max: f64,
    /// Delay at the maximum of the cross-correlation, s; a drift of the estimate pulls it. `None` when the reference
    /// does not move or the maximum lies at the end of the searched range.
    pub delay: Option<f64>,
    /// Standard deviation of the sample-to-sample noise of the error: √(Σ (second difference)²/6).
    pub noise_floor: f64,
    /// Slope of a line through the error, per s.
    pub drift: f64,
}

/// Agreement of an estimate with a reference over all samples from `skip` on.
///
/// # Errors
/// [`Error::Length`], [`Error::TooFew`] when fewer than eight samples remain, [`Error::NotFinite`].
pub fn agreement(
    estimate: &[f64],
    reference: &[f64],
    sample_time: f64,
    skip: usize,
) -> Result<Agreement, Error> {
    if estimate.len() != reference.len() {
        return Err(Error::Length {
            name: "reference",
            expected: estimate.len(),
            got: reference.len(),
        });
    }
    let n = estimate.len().saturating_sub(skip);
    if n < 8 {
        return Err(Error::TooFew {
            name: "samples to compare",
            needed: 8,
            got: n,
        });
    }
    let (v, r) = (&estimate[skip..], &reference[skip..]);
    let e: Vec<f64> = v.iter().zip(r).map(|(v, r)| v - r).collect();
    if let Some(index) = e.iter().position(|e| !e.is_finite()) {
        return Err(Error::NotFinite {
            name: "error",
            index: index + skip,
        });
    }
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let second: Vec<f64> = e
        .windows(3)
        .map(|w| (w[2] - 2.0 * w[1] + w[0]).powi(2) / 6.0)
        .collect();
    let (middle, level) = (0.5 * (n - 1) as f64, mean(&e));
    let (mut top, mut bottom) = (0.0, 0.0);
    for (k, e) in e.iter().enumerate() {
        let t = k as f64 - middle;
        top += t * (e - level);
        bottom += t * t;
    }
    Ok(Agreement {
        rms: mean(&e.iter().map(|e| e * e).collect::<Vec<_>>()).sqrt(),
        bias: level,
        max: e.iter().fold(0.0f64, |m, e| m.max(e.abs())),
        delay: delay(v, r).map(|d| d * sample_time),
        noise_floor: mean(&second).sqrt(),
        drift: top / bottom / sample_time,
    })
}

/// Lag in samples at the maximum of the normalised cross-correlation, refined by a parabola: the maximum nearest
/// to no delay.
fn delay(v: &[f64], r: &[f64]) -> Option<f64> {
    let n = v.len();
    let reach = (n / 4).min(200);
    let centre = |x: &[f64]| {
        let m = x.iter().sum::<f64>() / x.len() as f64;
        x.iter().map(|x| x - m).collect::<Vec<f64>>()
    };
    let (v, r) = (centre(v), centre(r));
    if r.iter().all(|r| r.abs() < 1e-300) || v.iter().all(|v| v.abs() < 1e-300) {
        return None;
    }
    // The reference shifted later by `lag` over the samples that all lags share: the same samples of v for each,
    // so that the ends do not pull the maximum.
    let score = |lag: i64| {
        let (mut vr, mut rr) = (0.0, 0.0);
        for k in reach..n - reach {
            let r = r[(k as i64 - lag) as usize];
            vr += v[k] * r;
            rr += r * r;
        }
        if rr > 0.0 {
            vr / rr.sqrt()
        } else {
            f64::NEG_INFINITY
        }
    };
    // Uphill from no delay: a periodic motion has other maxima a period away.
    let reach = reach as i64;
    let mut best = 0i64;
    let mut height = score(0);
    let step = if score(1) > height { 1 } else { -1 };
    while best.abs() < reach {
        let next = score(best + step);
        if next <= height {
            break;
        }
        (best, height) = (best + step, next);
    }
    if best.abs() >= reach {
        return None;
    }
    let (a, b, c) = (score(best - 1), score(best), score(best + 1));
    let curvature = a - 2.0 * b + c;
    Some(
        best as f64
            + if curvature < 0.0 {
                0.5 * (a - c) / curvature
            } else {
                0.0
            },
    )
}

/// One method at one rate.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MethodRow {
    /// Method with its settings.
    pub method: Method,
    /// Short text.
    pub label: String,
    /// Sensors it uses.
    pub family: Family,
    /// Sample rate, Hz.
    pub rate: f64,
    /// Delay the method states.
    pub stated_delay: f64,
    /// How it agrees with the reference.
    pub agreement: Agreement,
    /// Velocity per sample at this rate.
    pub velocity: Vec<f64>,
}

/// Runs methods on a record at several decimations against a reference velocity per sample of the record.
///
/// `skip` seconds at the start are run but not compared: filters settle there.
///
/// # Errors
/// Of the record, of each method, and of [`agreement`].
pub fn compare_methods(
    record: &MotionRecord,
    reference: &[f64],
    methods: &[Method],
    decimations: &[usize],
    skip: f64,
) -> Result<Vec<MethodRow>, Error> {
    if reference.len() != record.reading.len() {
        return Err(Error::Length {
            name: "reference",
            expected: record.reading.len(),
            got: reference.len(),
        });
    }
    let mut rows = Vec::new();
    for &n in decimations {
        let slow = record.decimated(n)?;
        let truth: Vec<f64> = reference.iter().step_by(n).copied().collect();
        let first = (skip / slow.sample_time).ceil().max(0.0) as usize;
        for method in methods {
            let trace = method.run(&slow)?;
            rows.push(MethodRow {
                method: *method,
                label: trace.label,
                family: method.family(),
                rate: 1.0 / slow.sample_time,
                stated_delay: trace.stated_delay,
                agreement: agreement(&trace.velocity, &truth, slow.sample_time, first)?,
                velocity: trace.velocity,
            });
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_delay_noise_and_drift_are_found() {
        let n = 4000;
        let dt = 1e-3;
        let v = |t: f64| (12.0 * t).sin() + 0.3 * (31.0 * t).cos();
        let r: Vec<f64> = (0..n).map(|k| v(dt * k as f64)).collect();
        let e: Vec<f64> = (0..n).map(|k| v(dt * k as f64 - 0.0073)).collect();
        let a = agreement(&e, &r, dt, 0).unwrap();
        assert!((a.delay.unwrap() - 0.0073).abs() < 5e-5, "{a:?}");
        let clean: Vec<f64> = (0..n).map(|k| r[k] + 0.02 * dt * k as f64).collect();
        let a = agreement(&clean, &r, dt, 0).unwrap();
        assert!((a.drift - 0.02).abs() < 1e-12);
        let noisy: Vec<f64> = (0..n)
            .map(|k| r[k] + if k * 7919 % 101 > 50 { 0.1 } else { -0.1 })
            .collect();
        let a = agreement(&noisy, &r, dt, 0).unwrap();
        assert!((a.rms - 0.1).abs() < 1e-3, "{a:?}");
        assert!(agreement(&r, &vec![0.0; n], dt, 0).unwrap().delay.is_none());
    }
}

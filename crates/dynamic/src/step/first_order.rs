//! A first-order element fitted to a step: what is left of a resonance that damping, a low-pass or the noise hides.

use super::fit::{P, Samples, cost, settled};
use super::{StepFit, checked, starts};
use proofmass_core::Error;
use proofmass_uncertainty::adjustment::Equations;

/// A step that one pole describes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FirstOrderStep {
    /// Time constant, s; the corner is 1/(2πτ).
    pub time_constant: f64,
    /// Root mean square of its residuals over that of the oscillator, where one was found.
    pub beside_oscillator: Option<f64>,
    /// Whether an oscillator describes the record no better, so that neither natural frequency nor damping is in it.
    pub as_good: bool,
    /// Samples from a tenth to nine tenths of the step.
    pub rise_samples: f64,
}

/// Growth of the squares, in units of their variance, that one parameter more explains by chance once in two thousand.
const BY_CHANCE: f64 = 12.0;

/// 1 − e^{−t/τ} behind a straight rise about t = 0 of the variance v.
fn response(t: f64, tau: f64, variance: f64) -> f64 {
    let rise = (12.0 * variance.max(0.0)).sqrt();
    // ∫₀ᵗ of it.
    let integral = |t: f64| {
        if t <= 0.0 {
            0.0
        } else {
            t + tau * (-t / tau).exp_m1()
        }
    };
    if rise < 1e-6 * tau {
        return if t <= 0.0 { 0.0 } else { -(-t / tau).exp_m1() };
    }
    (integral(t + 0.5 * rise) - integral(t - 0.5 * rise)) / rise
}

impl FirstOrderStep {
    /// Of a record, sampled at `rate`.
    ///
    /// ```
    /// use proofmass_dynamic::step::FirstOrderStep;
    /// let record: Vec<f64> = (0..400)
    ///     .map(|k| (f64::from(k) - 50.3) / 1000.0)
    ///     .map(|t| if t > 0.0 { 1.0 - (-t / 0.02f64).exp() } else { 0.0 })
    ///     .collect();
    /// let found = FirstOrderStep::of(&record, 1000.0)?;
    /// assert!((found.time_constant - 0.02).abs() < 1e-8);
    /// # Ok::<(), proofmass_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`StepFit::of`] for the record; [`Error::NotConverged`].
    pub fn of(record: &[f64], rate: f64) -> Result<Self, Error> {
        let height = checked(record, rate)?;
        let samples = Samples {
            values: record.iter().map(|v| v / height).collect(),
            rate,
            begin: 0.0,
        };
        let n = samples.values.len();
        let early = samples.values[..4].iter().sum::<f64>() / 4.0;
        let onset = starts::onset(&samples.values, early);
        let at = |k: usize| k as f64 / rate;
        let mut best: Option<(f64, f64, Vec<f64>)> = None;
        let mut tau = 1.0 / rate;
        while tau < 0.5 * at(n) {
            let unit = [at(onset) - 0.4 * tau, tau];
            let begin = [early, 1.0 - early, 0.0, 0.0, 1e-3, 0.0];
            let fit = settled(&begin, 60, |p| equations(&samples, unit, p));
            if let Some((p, e, true)) = fit
                && best.as_ref().is_none_or(|b| cost(&e) < b.0)
            {
                best = Some((cost(&e), tau * p[3].exp(), p));
            }
            tau *= 3.0;
        }
        let Some((squares, time_constant, p)) = best else {
            return Err(Error::NotConverged {
                name: "first-order fit of a step",
                iterations: 60,
                step: f64::INFINITY,
            });
        };
        let oscillator = StepFit::least(&samples);
        let freedom = n.saturating_sub(P).max(1) as f64;
        let as_good = p[1].abs() > 0.0
            && oscillator.is_none_or(|least| squares <= least * (1.0 + BY_CHANCE / freedom));
        Ok(Self {
            time_constant,
            beside_oscillator: oscillator
                .filter(|least| *least > 0.0)
                .map(|least| (squares / least).sqrt()),
            as_good,
            rise_samples: 2.197 * time_constant * rate,
        })
    }
}

/// Baseline, height, instant and variance of the rise by the first guess of the time constant, its logarithm; the last is not used.
fn equations(samples: &Samples, [instant, unit]: [f64; 2], p: &[f64]) -> Result<Equations, Error> {
    const STEP: [f64; P] = [0.0, 0.0, 1e-6, 1e-6, 1e-6, 0.0];
    let allowed = p.iter().all(|v| v.is_finite())
        && p[2].abs() < 20.0
        && p[3].abs() < 4.0
        && (0.0..4.0).contains(&p[4]);
    if !allowed {
        return Err(Error::NotConverged {
            name: "first-order fit of a step",
            iterations: 0,
            step: f64::INFINITY,
        });
    }
    let n = samples.values.len();
    let share = |k: usize, p: &[f64]| {
        let t = samples.begin + k as f64 / samples.rate - instant - p[2] * unit;
        response(t, unit * p[3].exp(), p[4] * unit * unit)
    };
    let mut equations = Equations {
        residual: Vec::with_capacity(n),
        jacobian: vec![0.0; P * n],
    };
    let moved: Vec<[Vec<f64>; 2]> = (2..5)
        .map(|j| {
            [-STEP[j], STEP[j]].map(|h| {
                let mut q = p.to_vec();
                q[j] += h;
                q
            })
        })
        .collect();
    for k in 0..n {
        let s = share(k, p);
        equations.residual.push(p[0] + p[1] * s - samples.values[k]);
        let row = &mut equations.jacobian[P * k..P * (k + 1)];
        row[0] = 1.0;
        row[1] = s;
        for (j, [low, high]) in moved.iter().enumerate() {
            row[j + 2] = p[1] * (share(k, high) - share(k, low)) / (2.0 * STEP[j + 2]);
        }
    }
    Ok(equations)
}

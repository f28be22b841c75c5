//! Verdicts that need more than a profile, and the covariance of the coefficients given.

use crate::coefficients::Limits;
use crate::effects::Effects;
use crate::fit_family::{Family, SLACK};
use crate::profile::{Fitted, slope_level};
use crate::variance_fit::solve;
use crate::{FitOptions, NoiseModel, Reason, Term, Verdict};
use proofmass_core::Error;
use proofmass_uncertainty::Covariance;

/// A coefficient that is given: where its square stands in the fit, its value and standard uncertainty.
pub(crate) struct Kept {
    pub(crate) position: Option<usize>,
    pub(crate) value: f64,
    pub(crate) u: f64,
}

/// What is said of the ramp; its value, where there is one, goes to the model.
pub(crate) fn ramp_verdict(
    family: &Family,
    options: &FitOptions,
    model: &mut NoiseModel,
    kept: &mut Vec<Kept>,
) -> Verdict {
    let level = slope_level(options.probability);
    let limits = Limits {
        needed: slope_level(1.0 - options.false_alarm_rate),
        excludes_zero: level,
        forced: options.forced.contains(&Term::Ramp),
        probability: options.probability,
    };
    let Some(profile) = family.form(0, level, SLACK).map(|p| p.up_to(f64::INFINITY)) else {
        return Verdict::NotIdentifiable {
            reason: Reason::OtherTermsSuffice,
            estimate: None,
            upper_limit: None,
        };
    };
    let verdict = limits.verdict(&profile);
    if let Some(value) = verdict.value() {
        model.ramp = value;
        kept.push(Kept {
            position: None,
            value,
            u: limits.standard_uncertainty(&profile),
        });
    }
    verdict
}

/// Covariance of the coefficients given: their uncertainties, with the correlation of the expected information.
pub(crate) fn covariance(fitted: &Fitted, kept: &[Kept]) -> Result<Covariance, Error> {
    let free: Vec<usize> = (0..fitted.likelihood.terms())
        .filter(|t| fitted.held[*t].is_none() && fitted.best.squares[*t] > 0.0)
        .collect();
    let q = free.len();
    let p = fitted.likelihood.terms();
    let inverse: Option<Vec<Vec<f64>>> = fitted
        .likelihood
        .information(&fitted.best.squares, Effects::Restricted)
        .and_then(|h| {
            let matrix: Vec<f64> = (0..q * q)
                .map(|k| h[free[k / q] * p + free[k % q]])
                .collect();
            (0..q)
                .map(|i| {
                    let unit: Vec<f64> = (0..q).map(|j| f64::from(u8::from(i == j))).collect();
                    solve(&matrix, &unit)
                })
                .collect()
        });
    let correlation = |a: &Kept, b: &Kept| -> f64 {
        let place = |k: &Kept| k.position.and_then(|p| free.iter().position(|f| *f == p));
        match (place(a), place(b), &inverse) {
            (Some(i), Some(j), Some(v)) => {
                (v[i][j] / (v[i][i] * v[j][j]).sqrt()).clamp(-0.999, 0.999)
            }
            _ => 0.0,
        }
    };
    let n = kept.len();
    let rows: Vec<f64> = (0..n * n)
        .map(|k| {
            let (a, b) = (&kept[k / n], &kept[k % n]);
            let r = if k / n == k % n {
                1.0
            } else {
                0.5 * (correlation(a, b) + correlation(b, a))
            };
            r * a.u * b.u
        })
        .collect();
    debug_assert!(kept.iter().all(|k| k.value.is_finite()));
    Covariance::try_from_rows(n, &rows)
}

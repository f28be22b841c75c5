//! Models side by side: what each leaves unexplained, and how well it predicts standstills it has not seen.

use super::problem::Problem;
use super::terms::Terms;
use super::{Model, MultiPosition, MultiPositionFit};
use crate::Pose;
use proofmass_core::Error;
use serde::Serialize;
use std::fmt;

/// One model fitted to the same standstills.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ModelEvidence {
    /// The matrix.
    pub model: Model,
    /// What is beyond it.
    pub terms: Terms,
    /// Free parameters.
    pub parameters: usize,
    /// Akaike's criterion, corrected for the number of equations, less that of the best model.
    pub aicc: f64,
    /// Weight by it among the models.
    pub weight: f64,
    /// RMS error of standstills that were left out of the fit, m/s²; `None` where the rest does not determine the model.
    pub cross_validation: Option<f64>,
    /// Whether it is the model of the result.
    pub stated: bool,
}

impl fmt::Display for ModelEvidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.model.fmt(f)?;
        let Terms {
            bias,
            scale,
            curvature,
            ..
        } = self.terms;
        let power = |n: u8| ["", "", "²", "³"][usize::from(n.min(3))];
        if bias > 0 {
            write!(f, ", b(T{})", power(bias))?;
        }
        if scale > 0 {
            write!(f, ", K(T{})", power(scale))?;
        }
        match curvature {
            0 | 1 => Ok(()),
            2 => f.write_str(", a²"),
            _ => f.write_str(", a³"),
        }
    }
}

/// Folds of the cross-validation; with fewer standstills each is left out alone.
const FOLDS: usize = 10;
/// Standstills beyond which the models are not compared: what they say is then clear from the residuals.
const MOST: usize = 400;
/// A change of the temperature from which its terms are tried, K.
const WARMED: f64 = 1.0;

impl MultiPositionFit {
    /// The models that could be fitted to the same standstills, smallest first, with the evidence for each.
    ///
    /// Nothing is chosen by it: the result is that of the model that was asked for. Each is weighted as that fit, residuals
    /// beyond the noise included. Cross-validation leaves out every tenth standstill in turn. Empty where there are more than
    /// four hundred, or readings of one motion.
    ///
    /// **Source** `[BurnhamAnderson2002]` ch. 2.
    pub fn models(&self, settings: &MultiPosition) -> Vec<ModelEvidence> {
        if self.poses.len() > MOST || self.effective.is_some() {
            return Vec::new();
        }
        let excess = (self.excess / self.gravity.value()).powi(2);
        let mut all: Vec<ModelEvidence> = candidates(settings, &self.poses)
            .into_iter()
            .filter_map(|(model, terms)| {
                let asked = settings.clone().model(model).terms(terms);
                let mut evidence = evidence(&asked, &self.poses, excess).ok()?;
                evidence.stated = (model, terms) == (settings.model, settings.terms);
                Some(evidence)
            })
            .collect();
        let best = all.iter().map(|e| e.aicc).fold(f64::INFINITY, f64::min);
        let total: f64 = all.iter().map(|e| (0.5 * (best - e.aicc)).exp()).sum();
        for one in &mut all {
            one.aicc -= best;
            one.weight = (-0.5 * one.aicc).exp() / total;
        }
        all
    }
}

fn candidates(settings: &MultiPosition, poses: &[Pose]) -> Vec<(Model, Terms)> {
    let asked = (settings.model, settings.terms);
    let none = Terms {
        reference: settings.terms.reference,
        ..Terms::default()
    };
    // Upper-triangular and symmetric differ by a rotation that is none of the evidence.
    let smaller = Model::ALL.into_iter().filter(|m| {
        *m == asked.0
            || (m.parameters() < asked.0.parameters()
                && *m != Model::Symmetric
                && (*m != Model::Bias || settings.nominal_sensitivity.is_some()))
    });
    let mut all: Vec<(Model, Terms)> = smaller.map(|m| (m, none)).collect();
    let orders = |bias: u8, scale: u8, curvature: u8| Terms {
        bias,
        scale,
        curvature,
        ..none
    };
    let temperatures: Vec<f64> = poses.iter().filter_map(|p| p.temperature).collect();
    let span = temperatures
        .iter()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max)
        - temperatures.iter().copied().fold(f64::INFINITY, f64::min);
    let mut terms = vec![orders(0, 0, 2), orders(0, 0, 3)];
    if temperatures.len() == poses.len() && span > WARMED {
        let t = asked.1;
        terms
            .extend([(1, 0), (2, 0), (3, 0), (1, 1), (2, 1), (2, 2)].map(|(b, s)| orders(b, s, 0)));
        terms.extend([
            orders(t.bias, t.scale, 0),
            t,
            orders((t.bias + 1).min(3), t.scale, t.curvature),
            orders(t.bias, (t.scale + 1).min(3), t.curvature),
            orders(t.bias, t.scale, (t.curvature + 1).clamp(2, 3)),
        ]);
    }
    terms.push(asked.1);
    all.extend(terms.into_iter().map(|t| (asked.0, t)));
    let mut unique: Vec<(Model, Terms)> = Vec::with_capacity(all.len());
    for one in all {
        if !unique.contains(&one) {
            unique.push(one);
        }
    }
    unique.sort_by_key(|(m, t)| m.parameters() + t.list().len());
    unique
}

/// One model, its criterion not yet relative to the best.
fn evidence(settings: &MultiPosition, poses: &[Pose], excess: f64) -> Result<ModelEvidence, Error> {
    let problem = Problem::new(settings, poses)?;
    let (first, weighting) = problem.first()?;
    let known = problem.noise_is_known();
    let variance = |v: &f64| if known { v + excess } else { 1.0 };
    let weights: Vec<f64> = weighting
        .variances
        .iter()
        .map(|v| 1.0 / variance(v))
        .collect();
    let fit = problem.adjust(&first.parameters, &weighting, &weights)?;
    let squares: f64 = fit
        .equations
        .residual
        .iter()
        .zip(&weights)
        .map(|(r, w)| w * r * r)
        .sum();
    let (n, p) = (problem.rows(), problem.parameters());
    let k = (p + 1) as f64;
    if n < p + 3 {
        return Err(Error::TooFew {
            name: "standstills",
            needed: p + 3,
            got: n,
        });
    }
    let each = problem.each();
    let folds = poses.len().min(FOLDS);
    let mut left_out = 0.0;
    let mut predicted = true;
    for fold in 0..folds {
        let mut without = weights.clone();
        let rows = (0..poses.len())
            .filter(|i| i % folds == fold)
            .flat_map(|i| i * each..(i + 1) * each);
        for row in rows.clone() {
            without[row] = 0.0;
        }
        match problem.adjust(&fit.parameters, &weighting, &without) {
            Ok(rest) => {
                let residual = &rest.equations.residual;
                left_out += rows.map(|row| residual[row].powi(2)).sum::<f64>();
            }
            Err(_) => predicted = false,
        }
    }
    let rms = problem.gravity * (left_out / n as f64).sqrt();
    Ok(ModelEvidence {
        model: settings.model,
        terms: settings.terms,
        parameters: p,
        aicc: n as f64 * (squares / n as f64).max(1e-300).ln()
            + 2.0 * k
            + 2.0 * k * (k + 1.0) / (n as f64 - k - 1.0).max(1.0),
        weight: 0.0,
        cross_validation: (predicted && rms.is_finite()).then_some(rms),
        stated: false,
    })
}

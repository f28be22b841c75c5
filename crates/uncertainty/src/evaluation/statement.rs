//! The one place where the result of an output is decided.

use super::{Evaluate, LinearOutput};
use crate::{DegreesOfFreedom, Interval, OutputEntry, SampledOutput, Validation, Verdict};
use serde::{Deserialize, Serialize};

/// By which road a result is stated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum StatementMethod {
    /// Law of propagation: y ± U with U = k u.
    LawOfPropagation,
    /// Monte Carlo: the probabilistically symmetric interval.
    MonteCarlo,
}

/// The result of one output, decided once: what every document, page and machine repeats.
///
/// The law of propagation states it, unless Monte Carlo contradicts it or it has no value there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Statement {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value: the estimate, the mean of the trials, or their median where they have no standard deviation.
    pub value: f64,
    /// Standard uncertainty; absent where the distribution has none.
    pub standard_uncertainty: Option<f64>,
    /// Coverage interval.
    pub interval: Interval,
    /// Its probability.
    pub probability: f64,
    /// Expanded uncertainty: half the interval about the value; by Monte Carlo the longer side of it.
    pub expanded_uncertainty: f64,
    /// U/u, where there is a u above zero.
    pub coverage_factor: Option<f64>,
    /// Effective degrees of freedom, by the law of propagation.
    pub dof: Option<DegreesOfFreedom>,
    /// Road.
    pub method: StatementMethod,
}

/// Below this share of what lies outside the interval, trials that gave no number cannot move its ends visibly.
const VISIBLE: f64 = 0.01;

impl Statement {
    pub(super) fn decide(
        entry: &OutputEntry,
        linear: Option<&LinearOutput>,
        sampled: Option<&SampledOutput>,
        validation: Option<&Validation>,
        trials: usize,
        options: &Evaluate,
    ) -> Option<Self> {
        let whole = |s: &&SampledOutput| {
            let lost = s.invalid as f64 / trials.max(1) as f64;
            lost <= VISIBLE * (1.0 - options.probability)
        };
        let contradicted = validation.is_some_and(|v| v.verdict == Verdict::NotValidated);
        // Events so rare that no trial had one: what does not vary is no distribution of what does.
        let silent = |s: &&SampledOutput| s.standard_uncertainty == Some(0.0);
        let varies = linear.is_some_and(|l| l.quantity.standard_uncertainty > 0.0);
        match (linear, sampled) {
            // Trials that lost a visible share are no distribution of the measurand: they contradict nothing.
            (Some(_), Some(sampled))
                if contradicted && whole(&sampled) && !(varies && silent(&sampled)) =>
            {
                Some(Self::of_trials(entry, sampled, options))
            }
            (Some(linear), _) => Some(Self::of_law(entry, linear, options)),
            (None, Some(sampled)) => Some(Self::of_trials(entry, sampled, options)),
            (None, None) => None,
        }
    }

    fn of_law(entry: &OutputEntry, linear: &LinearOutput, options: &Evaluate) -> Self {
        let q = &linear.quantity;
        let (k, probability) = match options.coverage_factor {
            // The probability that a stated factor has at these degrees of freedom.
            Some(k) => (k, crate::student::two_sided_probability(k, q.dof.get())),
            None => (linear.coverage_factor, options.probability),
        };
        let expanded = k * q.standard_uncertainty;
        Self {
            name: entry.name.clone(),
            unit: entry.unit.clone(),
            value: q.value,
            standard_uncertainty: Some(q.standard_uncertainty),
            interval: Interval {
                lower: q.value - expanded,
                upper: q.value + expanded,
            },
            probability,
            expanded_uncertainty: expanded,
            coverage_factor: Some(k),
            dof: Some(q.dof),
            method: StatementMethod::LawOfPropagation,
        }
    }

    fn of_trials(entry: &OutputEntry, sampled: &SampledOutput, options: &Evaluate) -> Self {
        let u = sampled.standard_uncertainty;
        let value = if u.is_some() {
            sampled.mean
        } else {
            sampled.median
        };
        let interval = sampled.symmetric;
        let expanded = (interval.upper - value).max(value - interval.lower);
        Self {
            name: entry.name.clone(),
            unit: entry.unit.clone(),
            value,
            standard_uncertainty: u,
            interval,
            probability: options.probability,
            expanded_uncertainty: expanded,
            coverage_factor: u.filter(|u| *u > 0.0).map(|u| expanded / u),
            dof: None,
            method: StatementMethod::MonteCarlo,
        }
    }
}

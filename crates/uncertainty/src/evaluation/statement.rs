//! The one place where the result of an output is decided.

use super::{Evaluate, LinearOutput};
use crate::{DegreesOfFreedom, Interval, OutputEntry, SampledOutput, Validation};
use serde::{Deserialize, Serialize};

/// By which road results are to be stated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Method {
    /// The law of propagation, unless Monte Carlo contradicts the model's linearity or it has no value there.
    #[default]
    Auto,
    /// The law of propagation.
    Linear,
    /// The law of propagation with its terms of second order.
    SecondOrder,
    /// Monte Carlo.
    MonteCarlo,
}

/// By which road a result is stated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum StatementMethod {
    /// Law of propagation: y ± U with U = k u.
    LawOfPropagation,
    /// Law of propagation with the terms of second order: y ± U with U = k u.
    SecondOrder,
    /// Monte Carlo: the probabilistically symmetric interval, or mean ± k u where a factor is asked for.
    MonteCarlo,
}

impl StatementMethod {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::LawOfPropagation => "law of propagation",
            Self::SecondOrder => "law of propagation with terms of second order",
            Self::MonteCarlo => "Monte Carlo",
        }
    }
}

/// The result of one output, decided once: what every document, page and machine repeats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Expanded uncertainty, where the interval is value ± k u.
    pub expanded_uncertainty: Option<f64>,
    /// k, where the interval is value ± k u.
    pub coverage_factor: Option<f64>,
    /// Effective degrees of freedom, where k rests on them.
    pub dof: Option<DegreesOfFreedom>,
    /// Road.
    pub method: StatementMethod,
}

/// Below this share of what lies outside the interval, trials that gave no number cannot move its ends visibly.
const VISIBLE: f64 = 0.01;

/// What every road found of one output.
pub(super) struct Roads<'a> {
    pub linear: Option<&'a LinearOutput>,
    pub sampled: Option<&'a SampledOutput>,
    pub validation: Option<&'a Validation>,
    pub trials: usize,
}

impl Roads<'_> {
    /// Whether Monte Carlo refutes the linear result.
    pub fn contradicted(&self, probability: f64) -> bool {
        // Trials that lost a visible share are no distribution of the measurand: they contradict nothing.
        let whole = |s: &&SampledOutput| {
            let lost = s.invalid as f64 / self.trials.max(1) as f64;
            lost <= VISIBLE * (1.0 - probability)
        };
        // Events so rare that no trial had one: what does not vary is no distribution of what does.
        let varies = |l: &LinearOutput| l.quantity.standard_uncertainty > 0.0;
        let silent = |s: &&SampledOutput| {
            s.standard_uncertainty == Some(0.0) && self.linear.is_some_and(varies)
        };
        self.validation.is_some_and(Validation::refutes)
            && self.sampled.filter(whole).is_some_and(|s| !silent(&s))
    }

    /// The result; absent where no road has one, or not the one that is asked for.
    pub fn decide(&self, entry: &OutputEntry, options: &Evaluate) -> Option<Statement> {
        let linear = self.linear;
        let sampled = self.sampled;
        match options.method.unwrap_or_default() {
            Method::Linear => Some(Statement::of_law(entry, linear?, options)),
            Method::SecondOrder => Statement::to_second_order(entry, linear?, options),
            Method::MonteCarlo => Some(Statement::of_trials(entry, sampled?, options)),
            Method::Auto => match (linear, sampled) {
                (Some(_), Some(sampled)) if self.contradicted(options.probability) => {
                    Some(Statement::of_trials(entry, sampled, options))
                }
                (Some(linear), _) => Some(Statement::of_law(entry, linear, options)),
                (None, sampled) => Some(Statement::of_trials(entry, sampled?, options)),
            },
        }
    }
}

impl Statement {
    fn of_law(entry: &OutputEntry, linear: &LinearOutput, options: &Evaluate) -> Self {
        let q = &linear.quantity;
        let method = StatementMethod::LawOfPropagation;
        Self::with_factor(
            entry,
            (q.value, q.standard_uncertainty),
            linear,
            options,
            method,
        )
    }

    fn to_second_order(
        entry: &OutputEntry,
        linear: &LinearOutput,
        options: &Evaluate,
    ) -> Option<Self> {
        let second = linear.second_order?;
        let value = linear.quantity.value + second.shift;
        let known = (value, second.standard_uncertainty);
        let method = StatementMethod::SecondOrder;
        Some(Self::with_factor(entry, known, linear, options, method))
    }

    fn with_factor(
        entry: &OutputEntry,
        (value, u): (f64, f64),
        linear: &LinearOutput,
        options: &Evaluate,
        method: StatementMethod,
    ) -> Self {
        let dof = linear.quantity.dof;
        let (k, probability) = match options.coverage_factor {
            // The probability that a stated factor has at these degrees of freedom.
            Some(k) => (k, crate::student::two_sided_probability(k, dof.get())),
            None => (linear.coverage_factor, options.probability),
        };
        let expanded = k * u;
        Self {
            name: entry.name.clone(),
            unit: entry.unit.clone(),
            value,
            standard_uncertainty: Some(u),
            interval: Interval {
                lower: value - expanded,
                upper: value + expanded,
            },
            probability,
            expanded_uncertainty: Some(expanded),
            coverage_factor: Some(k),
            dof: Some(dof),
            method,
        }
    }

    fn of_trials(entry: &OutputEntry, sampled: &SampledOutput, options: &Evaluate) -> Self {
        let u = sampled.standard_uncertainty;
        let value = if u.is_some() {
            sampled.mean
        } else {
            sampled.median
        };
        let mut result = Self {
            name: entry.name.clone(),
            unit: entry.unit.clone(),
            value,
            standard_uncertainty: u,
            interval: sampled.symmetric,
            probability: options.probability,
            expanded_uncertainty: None,
            coverage_factor: None,
            dof: None,
            method: StatementMethod::MonteCarlo,
        };
        // A factor that is asked for; its probability is that of the trials, which is counted where the trials are.
        if let (Some(k), Some(u)) = (options.coverage_factor, u) {
            result.expanded_uncertainty = Some(k * u);
            result.coverage_factor = Some(k);
            result.interval = Interval {
                lower: value - k * u,
                upper: value + k * u,
            };
        }
        result
    }

    /// U, or the longer side of the interval where there is none.
    pub fn reach(&self) -> f64 {
        let longer = (self.interval.upper - self.value).max(self.value - self.interval.lower);
        self.expanded_uncertainty.unwrap_or(longer)
    }
}

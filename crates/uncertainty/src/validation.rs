//! Does the law of propagation hold? The answer of Monte Carlo.

use crate::numerical_tolerance;
use crate::{Linear, Quantity, Sampled};
use serde::{Deserialize, Serialize};

/// Part of the half-width beyond which the ends of a linear result that stands are too far from those of the trials for another
/// calculation to add to them: half a unit of one digit is anything from 3 to 25 % of it, as u begins with a 9 or a 1.
pub const ENDS: f64 = 0.02;

/// Whether the law of propagation may be used for this output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Both ends agree within the tolerance.
    Validated,
    /// Use the Monte Carlo interval.
    NotValidated,
    /// The ends of the Monte Carlo interval scatter too much to tell: more trials are needed.
    Undecided,
}

/// Comparison of the linear with the Monte Carlo interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Validation {
    /// Output.
    pub name: String,
    /// δ.
    pub tolerance: f64,
    /// |y − U − y_low|
    pub lower: f64,
    /// |y + U − y_high|
    pub upper: f64,
    /// Standard uncertainty of both from the number of trials.
    pub scatter: f64,
    /// The larger difference over the half-width of the Monte Carlo interval: what the linear result would be wrong by.
    pub relative: f64,
    /// Verdict.
    pub verdict: Verdict,
    /// Whether the intervals differ for few degrees of freedom alone: with the standard uncertainties taken as known both roads
    /// agree. The model is linear enough; Monte Carlo draws Student's t where the law of propagation has ν_eff.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub few_degrees_of_freedom: bool,
    /// `relative` with the standard uncertainties taken as known, where degrees of freedom are few: what the curvature of the model
    /// alone does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curvature: Option<f64>,
}

impl Validation {
    /// Whether the linear result may stand.
    pub fn holds(&self) -> bool {
        self.verdict == Verdict::Validated || self.few_degrees_of_freedom
    }

    /// Whether the ends are near enough to those of the trials for another calculation to build on them; what the number of trials
    /// makes of the difference speaks neither way.
    pub(crate) fn passes_on(&self) -> bool {
        let largest = self.lower.max(self.upper);
        let by_chance = 2.0 * self.scatter * self.relative / largest;
        // Ends that agree exactly, or are not finite, are not far.
        !(self.curvature.unwrap_or(self.relative) - by_chance > ENDS)
    }

    /// Whether Monte Carlo refutes the linearity of the model.
    pub fn refutes(&self) -> bool {
        self.verdict == Verdict::NotValidated && !self.few_degrees_of_freedom
    }
}

impl Sampled {
    /// Judges the linear result by this one: do y ± U and the symmetric interval agree to half a unit of the last
    /// digit of u that counts? Twice the scatter of the ends must not matter to the
    /// answer. An output without a Monte Carlo result is absent. **Source** `[S1] 8.1`, `[S2] 8`.
    pub fn validate(&self, linear: &Linear, digits: u32) -> Vec<Validation> {
        let quantities: Vec<Quantity> = self
            .outputs
            .iter()
            .filter_map(|sampled| linear.get(&sampled.name))
            .collect();
        self.validate_quantities(&quantities, digits)
    }

    /// As [`Sampled::validate`] by the digits alone, for quantities y ± U however they were found; those without an output of their name
    /// are passed over.
    pub fn validate_quantities(&self, quantities: &[Quantity], digits: u32) -> Vec<Validation> {
        self.outputs
            .iter()
            .filter_map(|sampled| {
                let q = quantities.iter().find(|q| q.name == sampled.name)?;
                let width = 0.5 * sampled.symmetric.width();
                // A linear u of zero sets no tolerance; that of the trials does.
                let spread = sampled.standard_uncertainty.unwrap_or(0.5 * width);
                let tolerance = if q.standard_uncertainty > 1e-9 * spread {
                    numerical_tolerance(q.standard_uncertainty, digits)
                } else {
                    numerical_tolerance(spread, digits)
                };
                let expanded = q.expanded(self.probability);
                let lower = (q.value - expanded - sampled.symmetric.lower).abs();
                let upper = (q.value + expanded - sampled.symmetric.upper).abs();
                let (largest, doubt) = (lower.max(upper), 2.0 * sampled.symmetric_scatter);
                Some(Validation {
                    name: sampled.name.clone(),
                    tolerance,
                    lower,
                    upper,
                    scatter: sampled.symmetric_scatter,
                    few_degrees_of_freedom: false,
                    curvature: None,
                    relative: if width > 0.0 { largest / width } else { 0.0 },
                    verdict: if largest + doubt <= tolerance {
                        Verdict::Validated
                    } else if largest - doubt > tolerance {
                        Verdict::NotValidated
                    } else {
                        Verdict::Undecided
                    },
                })
            })
            .collect()
    }
}

//! What a Monte Carlo calculation found.

use crate::region::Region;
use crate::{Covariance, Finding, Histogram};
use serde::{Deserialize, Serialize};

/// Two ends of a coverage interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Interval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Interval {
    /// Upper minus lower end.
    pub fn width(&self) -> f64 {
        self.upper - self.lower
    }
}

/// One output of a Monte Carlo calculation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SampledOutput {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Trials in which it was not a finite number; everything below is of the others.
    pub invalid: usize,
    /// Mean of the trials; without meaning where there is no standard uncertainty.
    pub mean: f64,
    /// Value that half of the trials exceed.
    pub median: f64,
    /// Standard deviation of the trials; absent where their tails are so heavy that it does not settle however many
    /// are made.
    pub standard_uncertainty: Option<f64>,
    /// Probabilistically symmetric interval.
    pub symmetric: Interval,
    /// Standard uncertainty of its ends from the number of trials, the larger of the two.
    pub symmetric_scatter: f64,
    /// Shortest interval.
    pub shortest: Interval,
    /// The distribution, for drawing.
    pub histogram: Histogram,
}

/// Result of a Monte Carlo calculation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Sampled {
    /// Trials made.
    pub trials: usize,
    /// Coverage probability of intervals and region.
    pub probability: f64,
    /// Outputs in the order of the model; one that is finite in too few trials to have an interval is absent.
    pub outputs: Vec<SampledOutput>,
    /// Joint covariance of these outputs, over the trials in which all are finite.
    pub covariance: Covariance,
    /// Joint region; absent for one output, or when the covariance is singular.
    pub region: Option<Region>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl Sampled {
    /// Of no trials.
    #[cfg(feature = "model")]
    pub(crate) fn none(probability: f64) -> Self {
        Self {
            trials: 0,
            probability,
            outputs: Vec::new(),
            covariance: Covariance::zeros(0),
            region: None,
            findings: Vec::new(),
        }
    }

    /// One output by name.
    pub fn get(&self, name: &str) -> Option<&SampledOutput> {
        self.outputs.iter().find(|o| o.name == name)
    }
}

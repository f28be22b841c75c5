//! The tables of a model file beside its inputs: parts, equations to solve, fits, outputs.

use serde::{Deserialize, Serialize};

/// One `[[intermediate]]`: a part of the equations with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct IntermediateEntry {
    /// Name.
    pub name: String,
    /// Formula.
    pub expression: String,
}

/// One `[[output]]`. A complex quantity becomes two outputs, `re(name)` and `im(name)`; a vector one per member,
/// `name[1]` and so on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct OutputEntry {
    /// Name.
    pub name: String,
    /// Unit.
    pub(crate) unit: String,
    /// Formula; without one the quantity that has this name already.
    #[serde(default)]
    pub expression: String,
}

/// One `[[solve]]`: as many equations as unknowns, solved at the estimates and in every trial.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct SolveEntry {
    /// Names of the unknowns.
    pub unknown: Vec<String>,
    /// Where the search begins, one number per unknown.
    pub(crate) start: Vec<f64>,
    /// `left = right`, or an expression that is to be 0.
    pub equations: Vec<String>,
}

/// One `[[fit]]`: a polynomial y = p₀ + p₁x + …, or a curve, through points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct FitEntry {
    /// What it is called in the budget and in findings.
    #[serde(default = "fit")]
    pub name: String,
    /// Formula of the abscissae, a vector.
    pub x: String,
    /// Formula of the ordinates, a vector of the same length.
    pub y: String,
    /// Degree; one less than there are parameters when not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) degree: Option<usize>,
    /// Names of the parameters; those of a polynomial with the constant first.
    pub parameters: Vec<String>,
    /// Formula of a curve, of the parameters and the abscissa of a point: by its name where `x` is one, else as `x`.
    /// Vectors with a member per point count for each point by theirs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<String>,
    /// Where the search for the parameters of a curve begins, one number each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<Vec<f64>>,
    /// How the points are weighed.
    #[serde(default)]
    pub weights: FitWeights,
    /// Whether the residuals tell the scatter of the points.
    #[serde(default)]
    pub scatter: FitScatter,
}

fn fit() -> String {
    "fit".to_owned()
}

/// How the points of a fit are weighed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum FitWeights {
    /// All alike.
    #[default]
    Equal,
    /// By the covariance of the ordinates.
    Y,
    /// By the covariance of ordinates and abscissae: errors in variables, for straight lines.
    Both,
}

/// What the residuals of a fit say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum FitScatter {
    /// Nothing: the uncertainty of the points is that of the inputs.
    #[default]
    None,
    /// Their standard deviation s, with n − p degrees of freedom, is a cause of its own: one draw per point.
    Residuals,
}

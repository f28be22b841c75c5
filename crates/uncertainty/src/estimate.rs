//! Named quantities with one joint covariance, and where every share of it comes from.

use crate::{Covariance, DegreesOfFreedom, Evaluation, Quantity, welch_satterthwaite};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// One quantity of an [`Estimate`]: its stable dotted name, its unit and its value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Component {
    /// Stable documented name, such as `bias.x`.
    pub name: String,
    /// Unit as printed, such as `m/s²`; `1` for a pure number.
    pub unit: String,
    /// The estimate.
    pub value: f64,
}

impl Component {
    /// A named value with its unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, value: f64) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            value,
        }
    }
}

/// One cause of uncertainty, independent of every other cause in the same estimate.
#[doc(alias("uncertainty component", "contribution", "error source"))]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Influence {
    /// Stable name of the cause, such as `gravity`. Two estimates that name the same key of the same
    /// measurement share the draw.
    pub key: String,
    /// What it is, for a reader of the budget.
    pub description: String,
    /// Type A or type B.
    pub evaluation: Evaluation,
    /// Distribution as a word (`normal`, `rectangular`, …).
    pub distribution: String,
    /// Degrees of freedom of its standard uncertainty.
    pub dof: DegreesOfFreedom,
    /// How it appears in the components.
    pub effect: Effect,
}

/// How one cause appears in the components of an estimate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "form")]
pub enum Effect {
    /// One scalar input with its sensitivity coefficients.
    Scalar {
        /// Estimate of the input.
        value: f64,
        /// Unit of the input.
        unit: String,
        /// Standard uncertainty of the input.
        standard_uncertainty: f64,
        /// ∂(component)/∂(input), one per component.
        sensitivity: Vec<f64>,
    },
    /// Many inputs that act together; their covariance as seen in the components.
    Joint {
        /// Covariance of the components from this cause alone.
        covariance: Covariance,
    },
}

impl Effect {
    /// Covariance of the components from this cause alone.
    pub fn covariance(&self, n: usize) -> Result<Covariance, Error> {
        match self {
            Self::Scalar {
                standard_uncertainty: u,
                sensitivity,
                ..
            } => {
                if sensitivity.len() != n {
                    return Err(Error::Length {
                        name: "sensitivity",
                        expected: n,
                        got: sensitivity.len(),
                    });
                }
                Covariance::from_standard_uncertainties(&[*u])?.propagate(sensitivity)
            }
            Self::Joint { covariance } if covariance.dimension() == n => Ok(covariance.clone()),
            Self::Joint { covariance } => Err(Error::Length {
                name: "covariance of an influence",
                expected: n,
                got: covariance.dimension(),
            }),
        }
    }

    fn standard_uncertainty(&self, i: usize) -> f64 {
        match self {
            Self::Scalar {
                standard_uncertainty: u,
                sensitivity,
                ..
            } => (sensitivity[i] * u).abs(),
            Self::Joint { covariance } => covariance.standard_uncertainty(i),
        }
    }

    fn propagate(&self, jacobian: &[f64], n: usize) -> Result<Self, Error> {
        Ok(match self {
            Self::Scalar {
                value,
                unit,
                standard_uncertainty,
                sensitivity,
            } => Self::Scalar {
                value: *value,
                unit: unit.clone(),
                standard_uncertainty: *standard_uncertainty,
                sensitivity: jacobian
                    .chunks(n)
                    .map(|row| row.iter().zip(sensitivity).map(|(j, c)| j * c).sum())
                    .collect(),
            },
            Self::Joint { covariance } => Self::Joint {
                covariance: covariance.propagate(jacobian)?,
            },
        })
    }
}

/// Named components, one joint covariance, and the independent influences that make it up.
///
/// The joint covariance is the sum over the influences, so the budget of any component sums to its variance by
/// construction. Components are views: they are read one by one with [`Estimate::get`], combined with their
/// correlation through [`Estimate::propagate`].
#[doc(alias("measurement result", "uncertain number"))]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parts", into = "Parts")]
pub struct Estimate {
    components: Vec<Component>,
    influences: Vec<Influence>,
    covariance: Covariance,
}

#[derive(Serialize, Deserialize)]
struct Parts {
    components: Vec<Component>,
    covariance: Covariance,
    influences: Vec<Influence>,
}

impl From<Estimate> for Parts {
    fn from(estimate: Estimate) -> Self {
        Self {
            components: estimate.components,
            covariance: estimate.covariance,
            influences: estimate.influences,
        }
    }
}

impl TryFrom<Parts> for Estimate {
    type Error = Error;
    fn try_from(parts: Parts) -> Result<Self, Error> {
        Self::new(parts.components, parts.influences)
    }
}

impl Estimate {
    /// Components and the independent causes of their uncertainty.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a component that is NaN or infinite, [`Error::Length`] for an influence of
    /// another size.
    pub fn new(components: Vec<Component>, influences: Vec<Influence>) -> Result<Self, Error> {
        if let Some(index) = components.iter().position(|c| !c.value.is_finite()) {
            return Err(Error::NotFinite {
                name: "component",
                index,
            });
        }
        let n = components.len();
        let mut covariance = Covariance::zeros(n);
        for influence in &influences {
            covariance = covariance.plus(&influence.effect.covariance(n)?)?;
        }
        if let Some(index) = covariance.elements().iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite {
                name: "covariance",
                index,
            });
        }
        Ok(Self {
            components,
            influences,
            covariance,
        })
    }

    /// The components in order.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// The independent causes.
    pub fn influences(&self) -> &[Influence] {
        &self.influences
    }

    /// The joint covariance of the components.
    pub fn covariance(&self) -> &Covariance {
        &self.covariance
    }

    /// Position of a component by its dotted name.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.components.iter().position(|c| c.name == name)
    }

    /// One component as a quantity with its own standard uncertainty and effective degrees of freedom.
    pub fn get(&self, name: &str) -> Option<Quantity> {
        self.index_of(name).map(|i| self.quantity(i))
    }

    /// All components as quantities.
    pub fn quantities(&self) -> Vec<Quantity> {
        (0..self.components.len())
            .map(|i| self.quantity(i))
            .collect()
    }

    fn quantity(&self, i: usize) -> Quantity {
        let Component { name, unit, value } = self.components[i].clone();
        let shares: Vec<_> = self
            .influences
            .iter()
            .map(|influence| (influence.effect.standard_uncertainty(i), influence.dof))
            .collect();
        Quantity {
            name,
            unit,
            value,
            standard_uncertainty: self.covariance.standard_uncertainty(i),
            dof: welch_satterthwaite(&shares),
        }
    }

    /// The budget of one component, largest contribution first; the squares sum to its variance.
    pub fn budget(&self, name: &str) -> Option<Vec<BudgetLine>> {
        let i = self.index_of(name)?;
        let variance = self.covariance[(i, i)];
        let mut lines: Vec<BudgetLine> = self
            .influences
            .iter()
            .map(|influence| {
                let contribution = influence.effect.standard_uncertainty(i);
                let input = match &influence.effect {
                    Effect::Scalar {
                        value,
                        unit,
                        standard_uncertainty,
                        sensitivity,
                    } => Some(BudgetInput {
                        value: *value,
                        unit: unit.clone(),
                        standard_uncertainty: *standard_uncertainty,
                        sensitivity: sensitivity[i],
                    }),
                    Effect::Joint { .. } => None,
                };
                BudgetLine {
                    key: influence.key.clone(),
                    description: influence.description.clone(),
                    evaluation: influence.evaluation,
                    distribution: influence.distribution.clone(),
                    dof: influence.dof,
                    input,
                    contribution,
                    share: if variance > 0.0 {
                        contribution * contribution / variance
                    } else {
                        0.0
                    },
                }
            })
            .collect();
        lines.sort_by(|a, b| b.contribution.total_cmp(&a.contribution));
        Some(lines)
    }

    /// New components that are functions of these, with the Jacobian by rows (one row per new component).
    ///
    /// Every influence is carried over, so budgets and correlations survive.
    ///
    /// **Shapes** `jacobian.len() == components.len() * self.components().len()`.
    pub fn propagate(&self, components: Vec<Component>, jacobian: &[f64]) -> Result<Self, Error> {
        let n = self.components.len();
        if jacobian.len() != n * components.len() {
            return Err(Error::Length {
                name: "Jacobian",
                expected: n * components.len(),
                got: jacobian.len(),
            });
        }
        let influences = self
            .influences
            .iter()
            .map(|influence| {
                Ok(Influence {
                    effect: influence.effect.propagate(jacobian, n)?,
                    ..influence.clone()
                })
            })
            .collect::<Result<Vec<_>, Error>>()?;
        Self::new(components, influences)
    }
}

/// One line of a budget.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BudgetLine {
    /// Stable name of the cause.
    pub key: String,
    /// What it is.
    pub description: String,
    /// Type A or type B.
    pub evaluation: Evaluation,
    /// Distribution as a word.
    pub distribution: String,
    /// Degrees of freedom.
    pub dof: DegreesOfFreedom,
    /// The scalar input, where the cause is one.
    pub input: Option<BudgetInput>,
    /// Contribution to the standard uncertainty of the component, in its unit.
    pub contribution: f64,
    /// Share of the variance, 0 to 1.
    pub share: f64,
}

/// The scalar input behind a budget line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BudgetInput {
    /// Estimate.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Standard uncertainty.
    pub standard_uncertainty: f64,
    /// Sensitivity coefficient, unit of the component per unit of the input.
    pub sensitivity: f64,
}

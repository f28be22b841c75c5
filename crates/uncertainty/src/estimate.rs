//! Named quantities with one joint covariance, and where every share of it comes from.

mod combined;

#[cfg(feature = "model")]
pub(crate) use combined::same;

use crate::{Covariance, DegreesOfFreedom, Evaluation, Quantity};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// One quantity of an [`Estimate`]: its stable dotted name, its unit and its value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

impl Influence {
    /// A cause of type B whose standard uncertainty is known and whose distribution is normal: what a certificate states.
    pub fn normal(key: impl Into<String>, description: impl Into<String>, effect: Effect) -> Self {
        Self {
            key: key.into(),
            description: description.into(),
            evaluation: Evaluation::B,
            distribution: "normal".to_owned(),
            dof: DegreesOfFreedom::INFINITE,
            effect,
        }
    }
}

/// How one cause appears in the components of an estimate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Correlated scalar inputs that keep their own sensitivities and degrees of freedom.
    Correlated {
        /// The inputs.
        members: Vec<Member>,
        /// Their correlation matrix.
        correlation: Covariance,
    },
}

impl Effect {
    /// Of an input that is zero but for its standard uncertainty, and the change of each component with it.
    pub fn of_zero(
        unit: impl Into<String>,
        standard_uncertainty: f64,
        sensitivity: Vec<f64>,
    ) -> Self {
        Self::Scalar {
            value: 0.0,
            unit: unit.into(),
            standard_uncertainty,
            sensitivity,
        }
    }
}

/// One of several correlated inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Member {
    /// Stable name.
    pub(crate) key: String,
    /// What it is.
    pub(crate) description: String,
    /// Type A or type B.
    pub(crate) evaluation: Evaluation,
    /// Distribution as a word.
    pub(crate) distribution: String,
    /// Degrees of freedom of its standard uncertainty.
    pub(crate) dof: DegreesOfFreedom,
    /// Members with the same number here share one estimate of σ: their variance counts as a whole.
    pub(crate) estimate_of_scatter: usize,
    /// Estimate of the input.
    pub(crate) value: f64,
    /// Unit of the input.
    pub(crate) unit: String,
    /// Standard uncertainty of the input.
    pub(crate) standard_uncertainty: f64,
    /// ∂(component)/∂(input), one per component.
    pub(crate) sensitivity: Vec<f64>,
}

/// Per member of a correlated effect, seen in component `i`: contribution c u with its sign, and that times all that
/// is correlated with it, c_a u_a Σ_b r_ab c_b u_b.
fn member_shares(members: &[Member], correlation: &Covariance, i: usize) -> Vec<(f64, f64)> {
    let own: Vec<f64> = members
        .iter()
        .map(|m| m.sensitivity[i] * m.standard_uncertainty)
        .collect();
    (0..own.len())
        .map(|a| {
            let joint: f64 = (0..own.len()).map(|b| correlation[(a, b)] * own[b]).sum();
            (own[a], own[a] * joint)
        })
        .collect()
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
            Self::Correlated {
                members,
                correlation,
            } => {
                let short = members.iter().find(|m| m.sensitivity.len() != n);
                let got = short.map(|m| m.sensitivity.len());
                if let Some(got) = got.or_else(|| {
                    (correlation.dimension() != members.len()).then(|| correlation.dimension())
                }) {
                    return Err(Error::Length {
                        name: "sensitivity or correlation of an influence",
                        expected: n,
                        got,
                    });
                }
                let rows: Vec<f64> = (0..n)
                    .flat_map(|i| {
                        members
                            .iter()
                            .map(move |m| m.sensitivity[i] * m.standard_uncertainty)
                    })
                    .collect();
                if members.is_empty() {
                    return Ok(Covariance::zeros(n));
                }
                correlation.propagate(&rows)
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
            Self::Correlated {
                members,
                correlation,
            } => {
                let shares = member_shares(members, correlation, i);
                shares.iter().map(|(_, v)| v).sum::<f64>().max(0.0).sqrt()
            }
        }
    }

    /// (u, ν) of the estimates of σ behind this effect in component `i`, by Willink: the squares of u are shares of the
    /// variance, which may be negative and then carry their sign on u. **Source** `[Willink2007]`.
    fn contributions(&self, i: usize, dof: DegreesOfFreedom) -> Vec<(f64, DegreesOfFreedom)> {
        let Self::Correlated {
            members,
            correlation,
        } = self
        else {
            return vec![(self.standard_uncertainty(i), dof)];
        };
        let shares = member_shares(members, correlation, i);
        let mut groups: Vec<(usize, f64, DegreesOfFreedom)> = Vec::new();
        for (member, (_, v)) in members.iter().zip(shares) {
            let group = groups
                .iter_mut()
                .find(|g| g.0 == member.estimate_of_scatter);
            match group {
                Some(group) => group.1 += v,
                None => groups.push((member.estimate_of_scatter, v, member.dof)),
            }
        }
        groups
            .into_iter()
            .map(|(_, v, nu)| (v.abs().sqrt(), nu))
            .collect()
    }

    pub(crate) fn propagate(&self, jacobian: &[f64], n: usize) -> Result<Self, Error> {
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
            Self::Correlated {
                members,
                correlation,
            } => Self::Correlated {
                members: members
                    .iter()
                    .map(|member| Member {
                        sensitivity: jacobian
                            .chunks(n)
                            .map(|row| {
                                row.iter()
                                    .zip(&member.sensitivity)
                                    .map(|(j, c)| j * c)
                                    .sum()
                            })
                            .collect(),
                        ..member.clone()
                    })
                    .collect(),
                correlation: correlation.clone(),
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "Parts", into = "Parts")]
pub struct Estimate {
    components: Vec<Component>,
    influences: Vec<Influence>,
    covariance: Covariance,
}

#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Parts {
    /// Components in order: what is estimated.
    components: Vec<Component>,
    /// Their joint covariance.
    covariance: Covariance,
    /// The causes of the uncertainty, each with its effect on every component.
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
            .flat_map(|influence| influence.effect.contributions(i, influence.dof))
            .collect();
        let u = self.covariance.standard_uncertainty(i);
        Quantity {
            name,
            unit,
            value,
            standard_uncertainty: u,
            dof: effective(u, &shares),
        }
    }

    /// The budget of one component, largest contribution first; the shares sum to one.
    ///
    /// The share of a correlated input holds half of each of its covariance terms and may be negative.
    pub fn budget(&self, name: &str) -> Option<Vec<BudgetLine>> {
        let i = self.index_of(name)?;
        let variance = self.covariance[(i, i)];
        let share = |v: f64| if variance > 0.0 { v / variance } else { 0.0 };
        let mut lines: Vec<BudgetLine> = Vec::with_capacity(self.influences.len());
        for influence in &self.influences {
            if let Effect::Correlated {
                members,
                correlation,
            } = &influence.effect
            {
                let shares = member_shares(members, correlation, i);
                lines.extend(members.iter().zip(shares).map(|(m, (own, v))| BudgetLine {
                    key: m.key.clone(),
                    description: m.description.clone(),
                    evaluation: m.evaluation,
                    distribution: m.distribution.clone(),
                    dof: m.dof,
                    input: Some(BudgetInput {
                        value: m.value,
                        unit: m.unit.clone(),
                        standard_uncertainty: m.standard_uncertainty,
                        sensitivity: m.sensitivity[i],
                    }),
                    contribution: own.abs(),
                    share: share(v),
                }));
                continue;
            }
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
                _ => None,
            };
            lines.push(BudgetLine {
                key: influence.key.clone(),
                description: influence.description.clone(),
                evaluation: influence.evaluation,
                distribution: influence.distribution.clone(),
                dof: influence.dof,
                input,
                contribution,
                share: share(contribution * contribution),
            });
        }
        let value = self.components[i].value;
        lines
            .iter_mut()
            .for_each(|line| line.clear_rounding(value, variance.sqrt()));
        lines.sort_by(|a, b| b.contribution.total_cmp(&a.contribution));
        Some(lines)
    }

    /// Effective degrees of freedom of a complex quantity whose real and imaginary parts are two of these components,
    /// also when its causes are correlated groups: each influence counts with its 2 × 2 covariance.
    ///
    /// `None` when a name is unknown. **Source** `[WillinkHall2002]`.
    pub fn complex_dof(&self, real: &str, imaginary: &str) -> Option<DegreesOfFreedom> {
        let (i, j) = (self.index_of(real)?, self.index_of(imaginary)?);
        let n = self.components.len();
        let parts = self.influences.iter().map(|influence| {
            let c = influence.effect.covariance(n).ok()?;
            let rows = [c[(i, i)], c[(i, j)], c[(j, i)], c[(j, j)]];
            Some((Covariance::try_from_rows(2, &rows).ok()?, influence.dof))
        });
        crate::willink_hall(&parts.collect::<Option<Vec<_>>>()?).ok()
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

/// u⁴ / Σ u_i⁴/ν_i, with a total that need not be the sum of the parts, for correlated parts cancel.
fn effective(u: f64, parts: &[(f64, DegreesOfFreedom)]) -> DegreesOfFreedom {
    // Scaled by u, so that u⁴ neither overflows nor underflows for any unit.
    let spread: f64 = parts
        .iter()
        .map(|(part, nu)| (part / u).powi(4) / nu.get())
        .sum();
    DegreesOfFreedom::new(1.0 / spread).unwrap_or(DegreesOfFreedom::INFINITE)
}

/// One line of a budget.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
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

impl BudgetLine {
    /// Sets to zero a sensitivity that is what rounding left of zero: by it the whole input, or its uncertainty where that is
    /// larger, changes the component by less than a double tells, and its contribution is nothing beside the whole.
    pub(crate) fn clear_rounding(&mut self, value: f64, standard_uncertainty: f64) {
        let least = 16.0 * f64::EPSILON * value.abs().max(standard_uncertainty);
        let nothing = self.contribution <= 1e-9 * standard_uncertainty;
        if let Some(input) = &mut self.input {
            let whole = input.value.abs().max(input.standard_uncertainty);
            if nothing && whole > 0.0 && (input.sensitivity * whole).abs() <= least {
                input.sensitivity = 0.0;
                self.contribution = 0.0;
                self.share = 0.0;
            }
        }
    }
}

/// The scalar input behind a budget line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
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

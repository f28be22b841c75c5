//! Intervals of a fit whose residuals may hold more scatter than the noise explains: one rule, without a pre-test.
//!
//! n equations are fitted with p parameters. The variance σ_i² of each is known, an unknown variance τ² ≥ 0 between
//! them is common to all. To add τ² only when χ² is significant leaves "95 %" intervals that cover far less where τ is near
//! σ; here nothing is decided, and the interval is a continuous function of the data.

mod combination;
mod projection;
mod repeats;

pub use combination::{CommonErrors, WithCommonErrors};
pub use repeats::{MeanOfRepeats, Repeats};

use crate::findings;
use crate::quantile::{chi_squared_quantile, dof_of_coverage_factor, f_quantile};
use crate::{DegreesOfFreedom, Finding};
use projection::Projection;
use proofmass_core::{Error, check};
use serde::{Deserialize, Serialize};

/// The equations of a fit at its solution.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Linearised {
    /// Derivatives of the n model values with respect to the p parameters, by rows, n × p. Scale the parameters so
    /// that they are comparable numbers (dimensionless); the result for each does not depend on it.
    pub jacobian: Vec<f64>,
    /// Observed minus modelled, n.
    pub residuals: Vec<f64>,
}

/// What is known about the variances σ_i² themselves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum NoiseDof {
    /// They are exact.
    #[default]
    Known,
    /// Each was estimated by itself with these degrees of freedom, n.
    Each(Vec<DegreesOfFreedom>),
    /// Their ratios are exact, one common factor was estimated with these degrees of freedom.
    Pooled(DegreesOfFreedom),
}

impl NoiseDof {
    /// Degrees of freedom of the noise as a whole: of single ones the least, which is on the safe side.
    fn of_the_noise(&self) -> DegreesOfFreedom {
        match self {
            Self::Known => DegreesOfFreedom::INFINITE,
            Self::Pooled(nu) => *nu,
            Self::Each(each) => each
                .iter()
                .copied()
                .fold(DegreesOfFreedom::INFINITE, |a, b| if b < a { b } else { a }),
        }
    }
}

/// The scatter of the parameters of a fit: noise within the equations and scatter between them.
///
/// ```text
/// w_i = 1/(σ_i² + τ²),  C = (JᵀWJ)⁻¹,  G = C JᵀW,  P = W − WJCJᵀW,  Q(τ²) = Σ w_i r_i²,  ν = n − p
/// τ̂²: Q(τ̂²) = ν, else 0          S = C(τ̂²) = GΣGᵀ + τ̂² GGᵀ          q = min(1, Q(τ̂²)/ν)
/// m_c = 2 S_cc² / [2 A_c²/T + var(noise)],  A_c = Σ_i G_ci²,  T = tr P²
/// ν_s = harmonic mean of m_c, within [max(1, 2ν/3), ν]
/// k   = max( t(ν_noise), t(ν_s) √q ),   ν*: t(ν*) = k
/// ```
///
/// The interval is the larger of what the residuals say (Student t) and what the noise says. Noise and between part
/// add to S exactly, but the residuals fix only their sum: they are one influence with one ν*.
///
/// **Accuracy** 94.6 to 99.4 % coverage of nominal 95 % intervals over n = 10 … 40 with p = 9, τ/σ = 0 … 10, variances
/// 1:5 with 20 degrees of freedom each; the table is in docs/uncertainty.md.
/// **Assumes** scatter that is independent between equations and of one variance. Errors common to the equations do
/// not show in residuals: they are added with [`BetweenScatter::with_common`].
/// **Source** τ² of `[PauleMandel1982]`, `[DerSimonianKacker2007]`; q of `[HartungKnapp2001]`; degrees of freedom
/// after `[Satterthwaite1946]` with the information of `[KenwardRoger1997]`.
///
/// ```
/// use proofmass_uncertainty::*;
/// // The mean of four values, each with σ = 0.2.
/// let y = [10.1, 9.8, 10.4, 10.3];
/// let (mean, scatter) = BetweenScatter::linear(&[1.0; 4], &y, &[0.04; 4], NoiseDof::Known, 0.95)?;
/// assert!((mean[0] - 10.15).abs() < 1e-12);
/// assert!((scatter.excess_variance - 0.03).abs() < 1e-9);
/// assert!((scatter.standard_uncertainty(0) - 0.132_288).abs() < 1e-6);
/// assert!((scatter.expanded(0) - 0.420_998).abs() < 1e-6);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BetweenScatter {
    /// p.
    pub(crate) parameters: usize,
    /// n − p.
    pub(crate) residual_dof: f64,
    /// Coverage probability of every factor below.
    pub probability: f64,
    /// Q(0): weighted sum of squared residuals against the noise alone.
    pub chi_squared: f64,
    /// √(Q(0)/ν).
    pub birge_ratio: f64,
    /// Where the Birge ratio lies in 95 % of cases without excess.
    pub birge_range: [f64; 2],
    /// τ̂².
    pub excess_variance: f64,
    /// Interval of τ at the coverage probability, from the profile of Q. **Source** `[Viechtbauer2007]`.
    pub excess_interval: [f64; 2],
    /// q: 1 where τ̂² > 0, else Q(0)/ν.
    pub(crate) residual_factor: f64,
    /// T = tr P², the information on τ² times two.
    pub(crate) information: f64,
    /// S, p × p by rows.
    pub covariance: Vec<f64>,
    /// GΣGᵀ, the part of the noise.
    pub(crate) noise: Vec<f64>,
    /// τ̂² GGᵀ, the part of the scatter between the equations.
    pub(crate) between: Vec<f64>,
    /// m_c, one per parameter, before the harmonic mean and its limits.
    pub(crate) component_dof: Vec<f64>,
    /// ν_s.
    pub(crate) scatter_dof: f64,
    /// Degrees of freedom of the noise.
    pub(crate) noise_dof: DegreesOfFreedom,
    /// k: U = k u for each parameter.
    pub coverage_factor: f64,
    /// ν*, at which Student's t has the factor k; with it every later step is the ordinary one.
    pub dof: DegreesOfFreedom,
    /// G, p × n: what a unit error of each equation does to each parameter.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gain: Vec<f64>,
}

/// Steps of the iteration for τ²; Newton's need three.
const STEPS: usize = 60;

impl BetweenScatter {
    /// From the variances of the equations and a fit that can be repeated with other weights.
    ///
    /// `refit` gets the n weights w_i = 1/(σ_i² + τ²) and returns Jacobian and residuals at the solution; a fit that
    /// is linear need not move its Jacobian. The last call has the weights at τ̂², so that the state the closure
    /// leaves behind is the solution to which the result belongs.
    ///
    /// # Errors
    /// [`Error::TooFew`] unless n > p, [`Error::Length`], [`Error::OutOfRange`] for a variance or probability that
    /// is not positive, [`Error::NotFinite`], [`Error::Singular`] when the equations do not determine a parameter,
    /// and whatever `refit` returns.
    pub fn evaluate<E: From<Error>>(
        variances: &[f64],
        dof: NoiseDof,
        probability: f64,
        mut refit: impl FnMut(&[f64]) -> Result<Linearised, E>,
    ) -> Result<Self, E> {
        check(variances, &dof, probability)?;
        let n = variances.len();
        let mut at = |excess: f64| -> Result<(Linearised, f64, f64), E> {
            let weights: Vec<f64> = variances.iter().map(|v| 1.0 / (v + excess)).collect();
            let fit = refit(&weights)?;
            if fit.residuals.len() != n {
                return Err(Error::Length {
                    name: "residuals",
                    expected: n,
                    got: fit.residuals.len(),
                }
                .into());
            }
            if let Some(index) = fit.residuals.iter().position(|r| !r.is_finite()) {
                return Err(Error::NotFinite {
                    name: "residuals",
                    index,
                }
                .into());
            }
            let squares = weights.iter().zip(&fit.residuals);
            let q: f64 = squares.clone().map(|(w, r)| w * r * r).sum();
            let slope: f64 = squares.map(|(w, r)| (w * r).powi(2)).sum();
            Ok((fit, q, slope))
        };
        let first = at(0.0)?;
        let p = first.0.jacobian.len() / n;
        if p >= n {
            return Err(Error::TooFew {
                name: "equations",
                needed: p + 1,
                got: n,
            }
            .into());
        }
        let nu = (n - p) as f64;
        let chi_squared = first.1;
        // The interval of τ first, so that the last fit is the one at τ̂².
        let tail = 0.5 * (1.0 - probability);
        let mut ends = [0.0; 2];
        for (end, level) in ends.iter_mut().zip([1.0 - tail, tail]) {
            *end = solve(
                &mut at,
                (chi_squared, first.2),
                chi_squared_quantile(level, nu),
            )?
            .sqrt();
        }
        let excess = solve(&mut at, (chi_squared, first.2), nu)?;
        let (fit, q, _) = at(excess)?;
        let projection = Projection::new(&fit.jacobian, variances, excess)?;
        let factor = if excess > 0.0 { 1.0 } else { (q / nu).min(1.0) };
        let component_dof = projection.component_dof(variances, excess, &dof);
        let harmonic = p as f64 / component_dof.iter().map(|m| 1.0 / m).sum::<f64>();
        let scatter_dof = harmonic.clamp((2.0 * nu / 3.0).max(1.0), nu);
        let noise_dof = dof.of_the_noise();
        let t = |nu: f64| crate::student::two_sided_quantile(probability, nu);
        let coverage_factor = t(noise_dof.get()).max(t(scatter_dof) * factor.sqrt());
        let (noise, between) = projection.parts(variances, excess);
        let covariance: Vec<f64> = noise.iter().zip(&between).map(|(a, b)| a + b).collect();
        Ok(Self {
            parameters: p,
            residual_dof: nu,
            probability,
            chi_squared,
            birge_ratio: (chi_squared / nu).sqrt(),
            birge_range: [0.025, 0.975].map(|p| (chi_squared_quantile(p, nu) / nu).sqrt()),
            excess_variance: excess,
            excess_interval: ends,
            residual_factor: factor,
            information: projection.information,
            covariance,
            noise,
            between,
            component_dof,
            scatter_dof,
            noise_dof,
            coverage_factor,
            dof: DegreesOfFreedom::new(dof_of_coverage_factor(coverage_factor, probability))
                .unwrap_or(DegreesOfFreedom::INFINITE),
            gain: projection.gain,
        })
    }

    /// A linear model y = J x: the estimates as well.
    ///
    /// **Shapes** `jacobian` n × p by rows, `observations` and `variances` n.
    ///
    /// # Errors
    /// As [`BetweenScatter::evaluate`].
    pub fn linear(
        jacobian: &[f64],
        observations: &[f64],
        variances: &[f64],
        dof: NoiseDof,
        probability: f64,
    ) -> Result<(Vec<f64>, Self), Error> {
        if observations.len() != variances.len() {
            return Err(Error::Length {
                name: "observations",
                expected: variances.len(),
                got: observations.len(),
            });
        }
        let mut x = Vec::new();
        let result = Self::evaluate(variances, dof, probability, |weights| {
            let variances: Vec<f64> = weights.iter().map(|w| 1.0 / w).collect();
            let projection = Projection::new(jacobian, &variances, 0.0)?;
            x = projection.estimates(observations);
            let p = x.len();
            let residuals = observations.iter().enumerate().map(|(i, y)| {
                let model: f64 = (0..p).map(|c| jacobian[i * p + c] * x[c]).sum();
                y - model
            });
            Ok::<_, Error>(Linearised {
                residuals: residuals.collect(),
                jacobian: jacobian.to_vec(),
            })
        })?;
        Ok((x, result))
    }

    /// u_c = √S_cc, never below that of the noise alone at the same weights.
    pub fn standard_uncertainty(&self, c: usize) -> f64 {
        self.covariance[c * (self.parameters + 1)].sqrt()
    }

    /// U_c = k u_c.
    pub fn expanded(&self, c: usize) -> f64 {
        self.coverage_factor * self.standard_uncertainty(c)
    }

    /// Limit on βᵀS⁻¹β of the joint region of all p parameters: max( χ²(p), q p F(p, ν_s) ).
    pub fn joint_limit(&self) -> f64 {
        let p = self.parameters as f64;
        let noise = if self.noise_dof.is_infinite() {
            chi_squared_quantile(self.probability, p)
        } else {
            p * f_quantile(self.probability, p, self.noise_dof.get())
        };
        noise.max(self.residual_factor * p * f_quantile(self.probability, p, self.scatter_dof))
    }

    /// Sensitivity of the parameters to an error common to the equations: s = −G ∂r/∂x.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is one derivative per equation.
    pub fn sensitivity(&self, residual_derivatives: &[f64]) -> Result<Vec<f64>, Error> {
        let n = self.gain.len() / self.parameters.max(1);
        if residual_derivatives.len() != n {
            return Err(Error::Length {
                name: "derivatives of the residuals",
                expected: n,
                got: residual_derivatives.len(),
            });
        }
        let rows = self.gain.chunks(n.max(1));
        Ok(rows
            .map(|row| {
                -row.iter()
                    .zip(residual_derivatives)
                    .map(|(g, d)| g * d)
                    .sum::<f64>()
            })
            .collect())
    }

    /// Scatter of parameter `c` together with errors common to all equations, which no residual shows.
    pub fn with_common(&self, c: usize, common: &CommonErrors) -> WithCommonErrors {
        common.with_scatter(
            self.standard_uncertainty(c),
            self.dof,
            self.residual_dof,
            self.probability,
        )
    }

    /// A finding when the Birge ratio lies above its range without excess; it never changes the interval.
    ///
    /// On healthy data it appears in 2.5 % of cases.
    pub fn finding(&self) -> Option<Finding> {
        (self.birge_ratio > self.birge_range[1]).then(|| {
            findings::excess_residuals(
                "between the observations",
                &format!(
                    "Birge ratio {:.2}, up to {:.2} without excess; τ = {} ({} to {})",
                    self.birge_ratio,
                    self.birge_range[1],
                    crate::scientific(self.excess_variance.sqrt(), 2),
                    crate::scientific(self.excess_interval[0], 2),
                    crate::scientific(self.excess_interval[1], 2),
                ),
                "look for its cause",
            )
        })
    }
}

fn check(variances: &[f64], dof: &NoiseDof, probability: f64) -> Result<(), Error> {
    if variances.is_empty() {
        return Err(Error::TooFew {
            name: "equations",
            needed: 2,
            got: 0,
        });
    }
    for &value in variances {
        proofmass_core::check::positive("variance of an equation", value)?;
    }
    if let NoiseDof::Each(each) = dof
        && each.len() != variances.len()
    {
        return Err(Error::Length {
            name: "degrees of freedom of the variances",
            expected: variances.len(),
            got: each.len(),
        });
    }
    check::probability(probability)?;
    Ok(())
}

/// τ² ≥ 0 with Q(τ²) = target by Newton's steps on 1/Q inside a bracket; 0 when Q(0) is not above it.
fn solve<E: From<Error>>(
    at: &mut impl FnMut(f64) -> Result<(Linearised, f64, f64), E>,
    zero: (f64, f64),
    target: f64,
) -> Result<f64, E> {
    let (mut q, mut slope) = zero;
    if !(q > target) {
        return Ok(0.0);
    }
    let (mut low, mut high) = (0.0, f64::INFINITY);
    let mut excess = 0.0;
    for _ in 0..STEPS {
        let newton = excess + (q / target) * (q - target) / slope;
        let next = if newton > low && newton < high {
            newton
        } else if high.is_finite() {
            0.5 * (low + high)
        } else {
            4.0 * low
        };
        let still = (next - excess).abs() <= 1e-12 * next;
        excess = next;
        (_, q, slope) = at(excess)?;
        if (q / target - 1.0).abs() < 1e-5 || still {
            // One more of Newton's steps leaves 1e-10, and needs no fit to tell.
            return Ok((excess + (q / target) * (q - target) / slope).max(low));
        }
        if q > target {
            low = excess;
        } else {
            high = excess;
        }
    }
    Err(Error::NotConverged {
        name: "variance between the equations",
        iterations: STEPS,
        step: (q / target - 1.0).abs(),
    }
    .into())
}

#[cfg(all(test, feature = "monte-carlo"))]
mod tests;

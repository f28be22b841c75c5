//! The method as it was published: least squares on magnitudes, uncertainties element by element.
//!
//! Kept for comparison. It takes absolute values of every acceleration and output, so the sign of a cross term
//! is lost; it treats every configuration as independent, so common errors are averaged away; and it divides by
//! cross terms, so a small one gets an absurd uncertainty.

use super::Configuration;
use faer::Mat;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::{self, product, thin_svd};
use proofmass_uncertainty::{DegreesOfFreedom, welch_satterthwaite};
use serde::{Deserialize, Serialize};

/// Spurious motion as magnitude and phase relative to the reference acceleration, along x′, y′, z′.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpuriousMagnitude {
    /// Modulus relative to the reference acceleration.
    pub(crate) modulus: [f64; 3],
    /// Standard uncertainty of the modulus.
    pub(crate) modulus_uncertainty: [f64; 3],
    /// Phase in radians.
    pub(crate) phase: [f64; 3],
    /// Standard uncertainty of the phase in radians.
    pub(crate) phase_uncertainty: [f64; 3],
}

/// Standard uncertainties of the published budget.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MagnitudeBudget {
    /// Relative standard uncertainty of the reference acceleration.
    pub reference: f64,
    /// Standard uncertainty of the inclination in radians.
    pub inclination: f64,
    /// Standard uncertainty of the rotation in radians.
    pub rotation: f64,
    /// Relative standard uncertainty of an output, u_S.
    pub output: f64,
    /// Degrees of freedom given to every input.
    pub dof: f64,
}

impl MagnitudeBudget {
    /// The published inputs: 0.4 % (k = 2) on the reference, ±0.1° and ±1° rectangular, 100 degrees of freedom.
    ///
    /// u_S is an argument because the printed contributions and the printed tables disagree on it by a factor
    /// of ten.
    ///
    /// **Source** `[Murgia2022]` 3.4.
    pub fn published(output: f64) -> Self {
        Self {
            reference: 0.002,
            inclination: 0.1f64.to_radians() / 3f64.sqrt(),
            rotation: 1f64.to_radians() / 3f64.sqrt(),
            output,
            dof: 100.0,
        }
    }
}

/// One line of the budget of an applied acceleration.
#[derive(Clone, Debug, PartialEq)]
pub struct AppliedLine {
    /// Input: `reference`, `inclination`, `rotation`, `modulus.x′` … `phase.z′`.
    pub(crate) input: String,
    /// Sensitivity coefficient.
    pub(crate) sensitivity: f64,
    /// Contribution to the standard uncertainty, m/s².
    pub(crate) contribution: f64,
}

/// Magnitude of the acceleration along one axis of the device, with its budget.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Applied {
    /// Magnitude in m/s².
    pub value: f64,
    /// Standard uncertainty in m/s².
    pub standard_uncertainty: f64,
    /// Effective degrees of freedom over all inputs.
    pub dof: f64,
    /// Budget in the order of the published spreadsheet.
    pub(crate) budget: Vec<AppliedLine>,
}

/// Magnitudes of the acceleration along x, y, z of the device in one configuration.
///
/// a_x = |a_th + |a_x′ cos α cos ω| e^{jφ_x′} + |a_y′ sin ω| e^{jφ_y′} + |a_z′ sin α cos ω| e^{jφ_z′}|, and alike for y
/// and z: the absolute values lose the signs that the rotation has.
///
/// **Units** `reference` in m/s², angles in radians.
///
/// **Source** `[Murgia2022]` 3.2, figure 3.7.
///
/// ```
/// use proofmass_shaker::Configuration;
/// use proofmass_shaker::published::{applied, MagnitudeBudget};
/// let a = applied(10.0, &Configuration::degrees(90.0, 180.0), None, &MagnitudeBudget::published(0.041));
/// assert!((a[0].value - 10.0).abs() < 1e-12); // the sign is gone
/// ```
pub fn applied(
    reference: f64,
    configuration: &Configuration,
    spurious: Option<&SpuriousMagnitude>,
    budget: &MagnitudeBudget,
) -> [Applied; 3] {
    const MODULUS: [&str; 3] = ["modulus.x′", "modulus.y′", "modulus.z′"];
    const PHASE: [&str; 3] = ["phase.x′", "phase.y′", "phase.z′"];
    let r = configuration.matrix();
    let (da, dw) = (
        configuration.inclination_derivative(),
        configuration.rotation_derivative(),
    );
    std::array::from_fn(|axis| {
        // Theoretical part and the three spurious ones, all with their geometric factor made positive.
        let theoretical = Complex64::new(reference * r[axis][2].abs(), 0.0);
        let e = |k: usize| {
            spurious.map_or(Complex64::new(0.0, 0.0), |s| {
                Complex64::from_polar(s.modulus[k], s.phase[k]) * reference
            })
        };
        let sum = theoretical + (0..3).map(|k| e(k) * r[axis][k].abs()).sum::<Complex64>();
        let value = sum.norm();
        // d|P| = Re(dP P̄)/|P|; where P vanishes only its own size is known.
        let along = |d: Complex64| {
            if value > 0.0 {
                (d * sum.conj()).re / value
            } else {
                d.norm()
            }
        };
        let turned = |derivative: &[[f64; 3]; 3]| {
            let slope = |k: usize| derivative[axis][k] * r[axis][k].signum();
            along(
                Complex64::new(reference * slope(2), 0.0)
                    + (0..3).map(|k| e(k) * slope(k)).sum::<Complex64>(),
            )
        };
        let mut inputs = vec![
            ("reference", value / reference, budget.reference * reference),
            ("inclination", turned(&da), budget.inclination),
            ("rotation", turned(&dw), budget.rotation),
        ];
        if let Some(s) = spurious {
            for k in 0..3 {
                let unit = Complex64::from_polar(reference * r[axis][k].abs(), s.phase[k]);
                inputs.push((MODULUS[k], along(unit), s.modulus_uncertainty[k]));
            }
            for k in 0..3 {
                let d = Complex64::new(0.0, 1.0) * e(k) * r[axis][k].abs();
                inputs.push((PHASE[k], along(d), s.phase_uncertainty[k]));
            }
        }
        let budget_lines: Vec<AppliedLine> = inputs
            .iter()
            .map(|&(input, sensitivity, u)| AppliedLine {
                input: input.to_owned(),
                sensitivity,
                contribution: (sensitivity * u).abs(),
            })
            .collect();
        let nu = DegreesOfFreedom::new(budget.dof).unwrap_or(DegreesOfFreedom::INFINITE);
        let shares: Vec<_> = budget_lines.iter().map(|l| (l.contribution, nu)).collect();
        Applied {
            value,
            standard_uncertainty: shares.iter().map(|(u, _)| u * u).sum::<f64>().sqrt(),
            dof: welch_satterthwaite(&shares).get(),
            budget: budget_lines,
        }
    })
}

/// One configuration for [`fit`]: reference amplitude, mounting, magnitudes of the outputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagnitudeRow {
    /// Reference acceleration amplitude in m/s².
    pub reference: f64,
    /// Mounting.
    pub configuration: Configuration,
    /// Output amplitudes in V; their absolute values are used.
    pub outputs: [f64; 3],
    /// Spurious motion, where a correction is wanted.
    pub spurious: Option<SpuriousMagnitude>,
}

/// Matrices and expanded uncertainties (k = 2) as published.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PublishedFit {
    /// Exploitation matrix in (m/s²)/V.
    pub exploitation: [[f64; 3]; 3],
    /// U(A), k = 2; `None` where S_ji is zero.
    pub exploitation_expanded: [[Option<f64>; 3]; 3],
    /// Sensitivity matrix in V/(m/s²).
    pub sensitivity: [[f64; 3]; 3],
    /// U(S), k = 2; `None` where A_ji is zero.
    pub sensitivity_expanded: [[Option<f64>; 3]; 3],
}

/// A = (oᵀo)⁻¹oᵀa and S = (aᵀa)⁻¹aᵀo on magnitudes, with the published propagation.
///
/// u²(S) = h u²(o), h the squares of (aᵀa)⁻¹aᵀ, u²(o) = u_S² o²; u²(A)′ = c u²(a), c the squares of (oᵀo)⁻¹oᵀ;
/// u²(A_ij) = u²(A_ij)′ + u²(S_ji) A_ij²/S_ji²; U(S_ij) = 2 √(u²(A_ji) S_ij²/A_ji²).
///
/// **Assumes** every configuration independent, and that signs do not matter: they do.
///
/// **Source** `[Murgia2022]` 3.3, 3.4.
///
/// # Errors
/// [`Error::TooFew`] below three rows, [`Error::NotFinite`], [`Error::Unobservable`] for regressors that do not
/// span three dimensions.
pub fn fit(rows: &[MagnitudeRow], budget: &MagnitudeBudget) -> Result<PublishedFit, Error> {
    let n = rows.len();
    if n < 3 {
        return Err(Error::TooFew {
            name: "configurations",
            needed: 3,
            got: n,
        });
    }
    let applied: Vec<[Applied; 3]> = rows
        .iter()
        .map(|r| applied(r.reference, &r.configuration, r.spurious.as_ref(), budget))
        .collect();
    let a = Mat::from_fn(n, 3, |i, j| applied[i][j].value);
    let o = Mat::from_fn(n, 3, |i, j| rows[i].outputs[j].abs());
    for i in 0..n {
        if (0..3).any(|j| !(a[(i, j)].is_finite() && o[(i, j)].is_finite())) {
            return Err(Error::NotFinite {
                name: "phasor table",
                index: i,
            });
        }
    }
    let to_a = pseudo_inverse(&o, "exploitation matrix")?;
    let to_s = pseudo_inverse(&a, "sensitivity matrix")?;
    let (exploitation, sensitivity) = (
        product([to_a.as_ref(), a.as_ref()]),
        product([to_s.as_ref(), o.as_ref()]),
    );
    let weighted = |gain: &Mat<f64>, i: usize, variance: &dyn Fn(usize) -> f64| -> f64 {
        (0..n).map(|k| gain[(i, k)].powi(2) * variance(k)).sum()
    };
    // u²(S_ij) from the outputs alone, u²(A_ij) from both.
    let u2_s: [[f64; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| weighted(&to_s, i, &|k| (budget.output * o[(k, j)]).powi(2)))
    });
    let u2_a: [[f64; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            weighted(&to_a, i, &|k| applied[k][j].standard_uncertainty.powi(2))
                + u2_s[j][i] * (exploitation[(i, j)] / sensitivity[(j, i)]).powi(2)
        })
    });
    let array = |f: &dyn Fn(usize, usize) -> f64| -> [[f64; 3]; 3] {
        std::array::from_fn(|i| std::array::from_fn(|j| f(i, j)))
    };
    // The division by a cross term of zero has no result.
    let known = |f: &dyn Fn(usize, usize) -> f64| -> [[Option<f64>; 3]; 3] {
        std::array::from_fn(|i| std::array::from_fn(|j| Some(f(i, j)).filter(|u| u.is_finite())))
    };
    Ok(PublishedFit {
        exploitation: array(&|i, j| exploitation[(i, j)]),
        exploitation_expanded: known(&|i, j| 2.0 * u2_a[i][j].sqrt()),
        sensitivity: array(&|i, j| sensitivity[(i, j)]),
        sensitivity_expanded: known(&|i, j| {
            2.0 * (u2_a[j][i].sqrt() * sensitivity[(i, j)] / exploitation[(j, i)]).abs()
        }),
    })
}

/// (MᵀM)⁻¹Mᵀ of an n × 3 matrix.
fn pseudo_inverse(m: &Mat<f64>, name: &'static str) -> Result<Mat<f64>, Error> {
    let svd = thin_svd(m, name).map_err(|_| Error::Singular {
        name,
        condition: f64::INFINITY,
    })?;
    let singular = svd.S().column_vector();
    let condition = singular[0] / singular[2];
    if !(condition < 1e8) {
        return Err(Error::Unobservable {
            parameter: name,
            condition,
        });
    }
    Ok(algebra::pseudo_inverse(&svd))
}

#[cfg(test)]
mod tests;

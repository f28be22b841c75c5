//! Angles between the sensitive axes of a calibrated sensor.

use super::StaticFit;
use crate::Triple;
use crate::findings;
use proofmass_core::{Error, dot, norm};
use proofmass_uncertainty::{Component, Estimate};
use serde::{Deserialize, Serialize};

/// How far each pair of sensitive axes is from a right angle, and what that costs.
///
/// The rows of K point along the sensitive axes: cos α_ij = k_i·k_j/(|k_i||k_j|), δ_ij = 90° − α_ij, the error is g sin δ.
/// Angles between rows do not depend on the frame K is stated in.
///
/// **Source** `[IEEE1293]`; 1° is 17 mg.
///
/// ```
/// use proofmass_static::static_test::Orthogonality;
/// use proofmass_uncertainty::{Component, Estimate};
///
/// let tilt = 1f64.to_radians().tan();
/// let k = [[1.0, tilt, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let estimate = Estimate::new(vec![Component::new("misalignment.xy", "rad", tilt)], vec![])?;
/// let fit = Orthogonality::default().fit(&k, &estimate)?;
/// let error = fit.estimate.get("cross_axis.xy").unwrap().value;
/// assert!((error / 9.80665e-3 - 17.45).abs() < 0.01); // mg
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Orthogonality {
    /// Acceleration at which the error is stated, m/s².
    pub acceleration: f64,
    /// Largest error that needs no word, m/s².
    pub tolerance: f64,
}

impl Default for Orthogonality {
    /// At 1 g; 1 mg, which is 0.057°.
    fn default() -> Self {
        Self {
            acceleration: proofmass_core::STANDARD_GRAVITY,
            tolerance: 1e-3 * proofmass_core::STANDARD_GRAVITY,
        }
    }
}

const PAIRS: [(usize, usize, &str); 3] = [(0, 1, "xy"), (0, 2, "xz"), (1, 2, "yz")];

impl Orthogonality {
    /// `estimate` is that of the calibration: its misalignments carry the uncertainty.
    ///
    /// # Errors
    /// [`Error::Singular`] for a row of zeros, [`Error::NotFinite`].
    pub fn fit(&self, k: &[Triple; 3], estimate: &Estimate) -> Result<StaticFit, Error> {
        if let Some(index) = k.as_flattened().iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite { name: "K", index });
        }
        if k.iter().any(|row| norm(*row) == 0.0) || (0..3).any(|i| k[i][i] == 0.0) {
            return Err(Error::Singular {
                name: "K",
                condition: f64::INFINITY,
            });
        }
        // Rows by their own scale: row i is e_i plus its misalignments.
        let rows: [Triple; 3] = std::array::from_fn(|i| k[i].map(|v| v / k[i][i]));
        let n = estimate.components().len();
        let mut components = Vec::new();
        let mut jacobian = Vec::new();
        for cross in [false, true] {
            for (i, j, name) in PAIRS {
                let (delta, gradient) = departure(rows[i], rows[j]);
                let factor = if cross {
                    self.acceleration * delta.cos()
                } else {
                    1.0
                };
                components.push(if cross {
                    Component::new(
                        format!("cross_axis.{name}"),
                        "m/s²",
                        self.acceleration * delta.sin(),
                    )
                } else {
                    Component::new(format!("orthogonality.{name}"), "rad", delta)
                });
                let mut row = vec![0.0; n];
                for (axis, derivative) in [(i, gradient[0]), (j, gradient[1])] {
                    for other in (0..3).filter(|o| *o != axis) {
                        let key = format!(
                            "misalignment.{}{}",
                            ["x", "y", "z"][axis],
                            ["x", "y", "z"][other]
                        );
                        if let Some(at) = estimate.index_of(&key) {
                            row[at] += factor * derivative[other];
                        }
                    }
                }
                jacobian.extend(row);
            }
        }
        let result = estimate.propagate(components, &jacobian)?;
        let mut findings = Vec::new();
        for (_, _, name) in PAIRS {
            let Some(error) = result.get(&format!("cross_axis.{name}")) else {
                continue;
            };
            if error.value.abs() > self.tolerance {
                findings.push(findings::not_orthogonal(
                    name,
                    error.value / 9.80665e-3,
                    self.acceleration,
                ));
            }
        }
        Ok(StaticFit {
            estimate: result,
            readings: Vec::new(),
            input: String::new(),
            unit: "rad".to_owned(),
            scatter: None,
            nonlinearity: None,
            orders: Vec::new(),
            departures: Vec::new(),
            harmonics: Vec::new(),
            findings,
        })
    }
}

/// 90° less the angle of two rows, and its derivatives with respect to their elements.
fn departure(a: Triple, b: Triple) -> (f64, [Triple; 2]) {
    let (la, lb) = (norm(a), norm(b));
    let sine = dot(a, b) / (la * lb);
    let cosine = (1.0 - sine * sine).max(1e-12).sqrt();
    let derivative = |own: Triple, length: f64, other: Triple, l: f64| -> Triple {
        std::array::from_fn(|e| {
            (other[e] / (length * l) - sine * own[e] / (length * length)) / cosine
        })
    };
    (
        sine.asin(),
        [derivative(a, la, b, lb), derivative(b, lb, a, la)],
    )
}

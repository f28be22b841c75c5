//! What a reader of the result asks for beside S: modulus and phase, normalised matrices, transverse
//! sensitivity, misalignment, intrinsic properties.

mod expanded;

pub use expanded::{Expanded, PROBABILITY};

use super::matrix::{AXES, Matrix, inverse, to_real};
use super::near_zero::{Kind, size};
use faer::Mat;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::symmetric_eigenvalues;
use proofmass_uncertainty::{
    BudgetLine, Complex, Component, DegreesOfFreedom, Estimate, Model, Number, jacobian,
};
use serde::Serialize;

/// One term of a matrix.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SensitivityTerm {
    /// Row and column as letters, such as `xy`.
    pub name: String,
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Modulus.
    pub modulus: Expanded,
    /// Phase in radians; `None` unless the covariance of the complex number says that it is not zero (χ² with two
    /// degrees of freedom above its 99.73 % quantile): nearer to zero a phase would be one of the noise.
    pub phase: Option<Expanded>,
    /// Signed real part with its uncertainty: what a cross term should be judged by.
    pub real: Expanded,
    /// Budget of the modulus.
    pub budget: Vec<BudgetLine>,
}

/// New quantities as functions of the 18 reals of an estimate, with every influence carried over by the exact
/// derivatives of the model.
///
/// # Errors
/// [`Error::NotFinite`] when a quantity or a derivative is not finite.
pub fn propagate<M: Model>(estimate: &Estimate, model: &M) -> Result<Estimate, Error> {
    let x: Vec<f64> = estimate.components().iter().map(|c| c.value).collect();
    let (values, derivatives) = jacobian(model, &x)?;
    let components = model
        .outputs()
        .into_iter()
        .zip(values)
        .map(|((name, unit), value)| Component::new(name, unit, value))
        .collect();
    estimate.propagate(components, &derivatives)
}

/// Element (i, j) of the matrix behind the 18 reals.
fn element<T: Number>(x: &[T], i: usize, j: usize) -> Complex<T> {
    Complex::new(x[2 * (3 * i + j)], x[2 * (3 * i + j) + 1])
}

/// Every component of an estimate with its expanded uncertainty.
pub fn expanded(estimate: &Estimate) -> Vec<Expanded> {
    estimate
        .quantities()
        .into_iter()
        .map(Expanded::from)
        .collect()
}

/// χ²₂ at 99.73 %, what three standard deviations are for one number: a complex number below it has no phase.
const HAS_A_PHASE: f64 = 11.829;

/// Eigenvalues of a symmetric 2 × 2 matrix and the direction of the larger one.
fn principal([rr, ri, ii]: [f64; 3]) -> (f64, f64, [f64; 2]) {
    let (mean, difference) = (0.5 * (rr + ii), 0.5 * (rr - ii));
    let root = difference.hypot(ri);
    let angle = 0.5 * ri.atan2(difference);
    (
        mean + root,
        (mean - root).max(0.0),
        [angle.cos(), angle.sin()],
    )
}

/// The nine terms of S (or of A, from its estimate) with modulus, phase and budget.
///
/// Modulus and phase have the gradients z/|z| and j z/|z|². A modulus near zero has the interval of its own that the
/// law of propagation does not give, and no phase.
pub fn terms(symbol: &str, m: &Matrix, estimate: &Estimate) -> Result<Vec<SensitivityTerm>, Error> {
    let mut result = Vec::with_capacity(9);
    let covariance = estimate.covariance();
    let unit = unit_of(estimate);
    for i in 0..3 {
        for j in 0..3 {
            let z = m[i][j];
            let base = format!("{symbol}.{}{}", AXES[i], AXES[j]);
            let p = 2 * (3 * i + j);
            let v = [
                covariance[(p, p)],
                covariance[(p, p + 1)],
                covariance[(p + 1, p + 1)],
            ];
            let (larger, smaller, axis) = principal(v);
            let norm = z.norm();
            // Nothing at all has no direction: the one in which it is known worst.
            let along = if norm > 0.0 {
                [z.re / norm, z.im / norm]
            } else {
                axis
            };
            let mut derivatives = vec![0.0; 2 * 18];
            derivatives[p..p + 2].copy_from_slice(&along);
            if norm > 0.0 {
                derivatives[18 + p] = -along[1] / norm;
                derivatives[18 + p + 1] = along[0] / norm;
            }
            let names = [format!("{base}.modulus"), format!("{base}.phase")];
            let polar = estimate.propagate(
                vec![
                    Component::new(&names[0], unit, norm),
                    Component::new(&names[1], "rad", z.arg()),
                ],
                &derivatives,
            )?;
            let (Some(linear), Some(phase), Some(real)) = (
                polar.get(&names[0]),
                polar.get(&names[1]),
                estimate.get(&format!("{base}.re")),
            ) else {
                continue;
            };
            let factor = linear.coverage_factor(PROBABILITY)
                / DegreesOfFreedom::INFINITE.coverage_factor(PROBABILITY);
            // Mahalanobis distance of zero, in the axes of the covariance.
            let (a, b) = (
                z.re * axis[0] + z.im * axis[1],
                z.im * axis[0] - z.re * axis[1],
            );
            let beyond = |d: f64, variance: f64| {
                if variance > 0.0 {
                    d * d / variance
                } else if d == 0.0 {
                    0.0
                } else {
                    f64::INFINITY
                }
            };
            let distance = beyond(a, larger) + beyond(b, smaller);
            let modulus = size(
                Kind::Modulus,
                (linear.name, linear.unit),
                norm,
                linear.standard_uncertainty,
                larger.sqrt(),
                linear.dof,
            );
            result.push(SensitivityTerm {
                name: format!("{}{}", AXES[i], AXES[j]),
                re: z.re,
                im: z.im,
                budget: polar.budget(&names[0]).unwrap_or_default(),
                modulus,
                phase: (distance > HAS_A_PHASE * factor * factor).then(|| Expanded::from(phase)),
                real: Expanded::from(real),
            });
        }
    }
    Ok(result)
}

/// Unit of the reals of a matrix.
fn unit_of(estimate: &Estimate) -> &str {
    estimate
        .components()
        .first()
        .map_or("", |c| c.unit.as_str())
}

/// Real parts of S*_ij = S_ij/S_ii (or of A* from A): each row over its diagonal.
pub fn normalised(symbol: &str, estimate: &Estimate) -> Result<Estimate, Error> {
    struct Normalised<'a>(&'a str);
    impl Model for Normalised<'_> {
        fn outputs(&self) -> Vec<(String, String)> {
            let name = |k: usize| format!("{}*.{}{}", self.0, AXES[k / 3], AXES[k % 3]);
            (0..9).map(|k| (name(k), "1".to_owned())).collect()
        }
        fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
            for k in 0..9 {
                y[k] = if k % 4 == 0 {
                    T::from(1.0)
                } else {
                    (element(x, k / 3, k % 3) / element(x, k / 3, k / 3)).re
                };
            }
        }
    }
    propagate(estimate, &Normalised(symbol))
}

/// max_θ |z cos θ + w sin θ|, the root of the larger eigenvalue of Re(v vᴴ) with v = (z, w), and the angle θ where it is
/// reached, modulo π.
pub(super) fn largest_response<T: Number>(z: Complex<T>, w: Complex<T>) -> (T, T) {
    let (half, zero) = (T::from(0.5), T::from(0.0));
    let (a, b, c) = (z.norm_squared(), w.norm_squared(), (z * w.conj()).re);
    let (sum, difference) = (half * (a + b), half * (a - b));
    let square = difference * difference + c * c;
    // Without a direction the two eigenvalues are one, and without a response there is nothing to differentiate.
    let (root, angle) = if square.value() > 0.0 {
        (square.sqrt(), half * c.atan2(difference))
    } else {
        (zero, zero)
    };
    let largest = sum + root;
    let response = if largest.value() > 0.0 {
        largest.sqrt()
    } else {
        zero
    };
    (response, angle)
}

/// Transverse sensitivity of the three outputs: `transverse.x` relative to the main sensitivity, and
/// `transverse.x.angle`, the direction of the largest response in the plane of the other two axes, which is left out
/// where the transverse sensitivity does not exceed its expanded uncertainty.
///
/// T_j = max_θ |S_kj cos θ + S_lj sin θ|/|S_jj| with (j, k, l) cyclic: the root of the larger eigenvalue of
/// Re(z zᴴ), z = (S_kj, S_lj).
///
/// **Units** relative; angle in radians from axis k towards axis l, modulo π.
///
/// **Accuracy** near zero the interval is that of the module `near_zero`. Two cross terms of one size in
/// quadrature have no direction of the largest response; there the interval covers 89 % instead of 95 %.
///
/// **Source** `[ISO16063-31]` 3 and annex.
pub fn transverse(estimate: &Estimate) -> Result<Vec<Expanded>, Error> {
    struct Transverse;
    impl Model for Transverse {
        fn outputs(&self) -> Vec<(String, String)> {
            let of = |a: &str| {
                [
                    (format!("transverse.{a}"), "1".to_owned()),
                    (format!("transverse.{a}.angle"), "rad".to_owned()),
                ]
            };
            AXES.into_iter().flat_map(of).collect()
        }
        fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
            for j in 0..3 {
                let (z, w) = (element(x, (j + 1) % 3, j), element(x, (j + 2) % 3, j));
                let (largest, angle) = largest_response(z, w);
                y[2 * j] = largest / element(x, j, j).abs();
                y[2 * j + 1] = angle;
            }
        }
    }
    let linear = propagate(estimate, &Transverse)?;
    let covariance = estimate.covariance();
    let x: Vec<f64> = estimate.components().iter().map(|c| c.value).collect();
    let mut result = vec![];
    for j in 0..3 {
        // The four reals of the two cross terms of output j, over its main sensitivity.
        let four: Vec<usize> = [(j + 1) % 3, (j + 2) % 3]
            .into_iter()
            .flat_map(|i| [2 * (3 * i + j), 2 * (3 * i + j) + 1])
            .collect();
        let largest = symmetric_eigenvalues(
            &Mat::from_fn(4, 4, |a, b| covariance[(four[a], four[b])]),
            "eigenvalues of the covariance of the cross terms",
        )?[3];
        let main = element::<f64>(&x, j, j).abs();
        let (Some(value), Some(angle)) = (
            linear.get(&format!("transverse.{}", AXES[j])),
            linear.get(&format!("transverse.{}.angle", AXES[j])),
        ) else {
            continue;
        };
        let value = size(
            Kind::Transverse,
            (value.name, value.unit),
            value.value,
            value.standard_uncertainty,
            largest.max(0.0).sqrt() / main,
            value.dof,
        );
        let known = value.value > value.expanded;
        result.push(value);
        if known {
            result.push(Expanded::from(angle));
        }
    }
    Ok(result)
}

/// Misalignment of each sensitive axis: `tilt.x.y` is the angle by which the axis of output x leans towards y,
/// radians, after the common phase of the output is taken out.
pub fn misalignment(estimate: &Estimate) -> Result<Estimate, Error> {
    struct Misalignment;
    fn pairs() -> impl Iterator<Item = (usize, usize)> {
        (0..3).flat_map(|j| [(j, (j + 1) % 3), (j, (j + 2) % 3)])
    }
    impl Model for Misalignment {
        fn outputs(&self) -> Vec<(String, String)> {
            pairs()
                .map(|(j, i)| (format!("tilt.{}.{}", AXES[j], AXES[i]), "rad".to_owned()))
                .collect()
        }
        fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
            for (y, (j, i)) in y.iter_mut().zip(pairs()) {
                *y = (element(x, i, j) / element(x, j, j)).re.atan();
            }
        }
    }
    propagate(estimate, &Misalignment)
}

/// Intrinsic properties, which no rotation of the device against the bench can change: the length of each
/// sensitivity vector `length.x` … (the column of S that belongs to an output) and the angles between them.
///
/// |s_j| = √(Σ_i |S_ij|²); γ_jk = 90° − asin Re(ŝ_jᴴ ŝ_k) with each vector turned to the phase of its main term.
///
/// **Source** `[Gaitan2021]`.
pub fn intrinsic(estimate: &Estimate) -> Result<Estimate, Error> {
    const PAIRS: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];
    struct Intrinsic<'a>(&'a str);
    impl Model for Intrinsic<'_> {
        fn outputs(&self) -> Vec<(String, String)> {
            let lengths = AXES.map(|a| (format!("length.{a}"), self.0.to_owned()));
            let angles =
                PAIRS.map(|(j, k)| (format!("angle.{}{}", AXES[j], AXES[k]), "rad".to_owned()));
            lengths.into_iter().chain(angles).collect()
        }
        fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
            let zero = Complex::new(T::from(0.0), T::from(0.0));
            for j in 0..3 {
                let square = (0..3)
                    .map(|i| element(x, i, j).norm_squared())
                    .fold(T::from(0.0), |s, v| s + v);
                y[j] = square.sqrt();
            }
            for (p, (j, k)) in PAIRS.into_iter().enumerate() {
                let turn = element(x, j, j) * element(x, k, k).conj();
                let dot = (0..3)
                    .map(|i| element(x, i, j).conj() * element(x, i, k))
                    .fold(zero, |s, v| s + v);
                let cosine = (dot * turn).re / (turn.abs() * y[j] * y[k]);
                y[3 + p] = T::from(std::f64::consts::FRAC_PI_2) - cosine.asin();
            }
        }
    }
    propagate(estimate, &Intrinsic(unit_of(estimate)))
}

/// Largest element of S A − 1: how far the two published regressions are from being inverse to each other.
pub fn inconsistency(s: &Matrix, a: &Matrix) -> Result<f64, Error> {
    let exact = inverse(s)?;
    let scale = to_real(&exact).iter().fold(0.0f64, |m, v| m.max(v.abs()));
    Ok(to_real(&exact)
        .iter()
        .zip(to_real(a))
        .map(|(x, y)| (x - y).abs() / scale)
        .fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex64;
    use proofmass_uncertainty::{Covariance, Effect, Influence};

    fn estimate(m: &Matrix, u: f64) -> Estimate {
        let components = to_real(m)
            .iter()
            .enumerate()
            .map(|(p, &v)| {
                let part = if p % 2 == 0 { "re" } else { "im" };
                Component::new(
                    format!("S.{}{}.{part}", AXES[p / 6], AXES[p / 2 % 3]),
                    "V/(m/s²)",
                    v,
                )
            })
            .collect();
        let influence = Influence::normal(
            "all",
            "all",
            Effect::Joint {
                covariance: Covariance::from_standard_uncertainties(&[u; 18]).unwrap(),
            },
        );
        Estimate::new(components, vec![influence]).unwrap()
    }

    fn turned(angle: f64) -> Matrix {
        // Diagonal sensitivities seen from a device that is turned about z, with a common phase.
        let (s, c) = angle.sin_cos();
        let r = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
        let main = [10.0, 11.0, 12.0];
        let phase = Complex64::from_polar(1.0, 0.3);
        std::array::from_fn(|i| std::array::from_fn(|j| phase * (r[i][j] * main[j])))
    }

    #[test]
    fn law_intrinsic_properties_do_not_turn() {
        for angle in [0.0, 0.01, 0.2] {
            let e = intrinsic(&estimate(&turned(angle), 0.01)).unwrap();
            assert!((e.get("length.y").unwrap().value - 11.0).abs() < 1e-12);
            let right = e.get("angle.xy").unwrap().value;
            assert!((right - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        }
    }

    #[test]
    fn law_transverse_sensitivity_of_a_tilt() {
        // The axis of x leans by 0.01 towards y: T = tan 0.01, along the first transverse axis (y).
        let e = estimate(&turned(0.01), 0.001);
        let t = transverse(&e).unwrap();
        let get = |name: &str| t.iter().find(|q| q.name == name).unwrap();
        assert!((get("transverse.x").value - 0.01f64.tan()).abs() < 1e-12);
        assert!(get("transverse.x.angle").value.abs() < 1e-9);
        let m = misalignment(&e).unwrap();
        assert!((m.get("tilt.x.y").unwrap().value - 0.01).abs() < 1e-12);
        // u(T) = u/|S_xx| to first order in the tilt.
        let u = get("transverse.x").standard_uncertainty;
        assert!((u - 0.001 / 10.0).abs() < 1e-3 * u);
    }

    #[test]
    fn law_the_budget_of_a_term_sums_to_its_variance() {
        let m = turned(0.1);
        let terms = terms("S", &m, &estimate(&m, 0.01)).unwrap();
        assert_eq!(terms.len(), 9);
        let sum: f64 = terms[0].budget.iter().map(|l| l.contribution.powi(2)).sum();
        assert!((sum.sqrt() / terms[0].modulus.standard_uncertainty - 1.0).abs() < 1e-12);
        assert!((terms[0].phase.as_ref().unwrap().value - 0.3).abs() < 1e-12);
        // A term that is zero has no phase.
        assert!(terms[2].phase.is_none());
    }
}

//! What a reader of the result asks for beside S: modulus and phase, normalised matrices, transverse
//! sensitivity, misalignment, intrinsic properties.

use super::fit::FrequencyFit;
use super::matrix::{AXES, Matrix, from_real, inverse, to_real};
use faer::c64;
use proofmass_core::Error;
use proofmass_uncertainty::{BudgetLine, Component, Estimate};
use serde::Serialize;

/// Probability of every expanded uncertainty.
pub const PROBABILITY: f64 = 0.95;

/// A real quantity with its expanded uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expanded {
    /// Dotted name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Standard uncertainty.
    pub standard_uncertainty: f64,
    /// Expanded uncertainty U = k u at 95 %.
    pub expanded: f64,
    /// Coverage factor.
    pub coverage_factor: f64,
    /// Effective degrees of freedom; `None` when infinite.
    pub dof: Option<f64>,
}

/// One term of a matrix.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Term {
    /// Row and column as letters, such as `xy`.
    pub name: String,
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Modulus.
    pub modulus: Expanded,
    /// Phase in radians; `None` when the modulus does not exceed its expanded uncertainty, for then every phase
    /// is compatible.
    pub phase: Option<Expanded>,
    /// Signed real part with its uncertainty: what a cross term should be judged by.
    pub real: Expanded,
    /// Budget of the modulus.
    pub budget: Vec<BudgetLine>,
}

/// New quantities as functions of the 18 reals of an estimate, with every influence carried over.
///
/// The Jacobian is by central differences with a step of 1e-5 of the largest real, so its relative error is
/// 1e-10 times the curvature.
///
/// # Errors
/// [`Error::NotFinite`] when a quantity is not finite.
pub fn propagate(
    estimate: &Estimate,
    names: &[(String, &str)],
    f: impl Fn(&[f64]) -> Vec<f64>,
) -> Result<Estimate, Error> {
    let x: Vec<f64> = estimate.components().iter().map(|c| c.value).collect();
    let n = x.len();
    let step = 1e-5
        * x.iter()
            .fold(0.0f64, |m, v| m.max(v.abs()))
            .max(f64::MIN_POSITIVE);
    let values = f(&x);
    let mut jacobian = vec![0.0; names.len() * n];
    for k in 0..n {
        let (mut up, mut down) = (x.clone(), x.clone());
        up[k] += step;
        down[k] -= step;
        for (m, (u, d)) in f(&up).iter().zip(f(&down)).enumerate() {
            jacobian[m * n + k] = (u - d) / (2.0 * step);
        }
    }
    if let Some(index) = jacobian.iter().position(|v| !v.is_finite()) {
        return Err(Error::NotFinite {
            name: "derivative of a derived quantity",
            index,
        });
    }
    let components = names
        .iter()
        .zip(&values)
        .map(|((name, unit), &v)| Component::new(name.clone(), *unit, v))
        .collect();
    estimate.propagate(components, &jacobian)
}

/// Every component of an estimate with its expanded uncertainty.
pub fn expanded(estimate: &Estimate) -> Vec<Expanded> {
    estimate
        .quantities()
        .into_iter()
        .map(|q| Expanded {
            coverage_factor: q.coverage_factor(PROBABILITY),
            expanded: q.expanded(PROBABILITY),
            dof: (!q.dof.is_infinite()).then(|| q.dof.get()),
            value: q.value,
            standard_uncertainty: q.standard_uncertainty,
            name: q.name,
            unit: q.unit,
        })
        .collect()
}

/// Difference of two angles, in (−π, π].
fn wrap(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let a = angle.rem_euclid(turn);
    if a > 0.5 * turn { a - turn } else { a }
}

fn named(list: impl IntoIterator<Item = (String, &'static str)>) -> Vec<(String, &'static str)> {
    list.into_iter().collect()
}

/// The nine terms of S (or of A, from its estimate) with modulus, phase and budget.
pub fn terms(
    symbol: &str,
    unit: &'static str,
    m: &Matrix,
    estimate: &Estimate,
) -> Result<Vec<Term>, Error> {
    let mut result = Vec::with_capacity(9);
    for i in 0..3 {
        for j in 0..3 {
            let value = m[i][j];
            let base = format!("{symbol}.{}{}", AXES[i], AXES[j]);
            let p = 2 * (3 * i + j);
            let polar = propagate(
                estimate,
                &named([
                    (format!("{base}.modulus"), unit),
                    (format!("{base}.phase"), "rad"),
                ]),
                |x| {
                    let z = c64::new(x[p], x[p + 1]);
                    // The phase about its own value, so that the cut at π is never near.
                    vec![z.norm(), value.arg() + wrap(z.arg() - value.arg())]
                },
            )?;
            let mut two = expanded(&polar).into_iter();
            let (Some(modulus), Some(phase)) = (two.next(), two.next()) else {
                continue;
            };
            let Some(real) = estimate.get(&format!("{base}.re")) else {
                continue;
            };
            let phase = (modulus.value > modulus.expanded).then_some(phase);
            result.push(Term {
                name: format!("{}{}", AXES[i], AXES[j]),
                re: value.re,
                im: value.im,
                budget: polar.budget(&format!("{base}.modulus")).unwrap_or_default(),
                modulus,
                phase,
                real: Expanded {
                    coverage_factor: real.coverage_factor(PROBABILITY),
                    expanded: real.expanded(PROBABILITY),
                    dof: (!real.dof.is_infinite()).then(|| real.dof.get()),
                    value: real.value,
                    standard_uncertainty: real.standard_uncertainty,
                    name: real.name,
                    unit: real.unit,
                },
            });
        }
    }
    Ok(result)
}

/// Real parts of S*_ij = S_ij/S_ii (or of A* from A): each row over its diagonal.
pub fn normalised(symbol: &str, estimate: &Estimate) -> Result<Estimate, Error> {
    let names = named((0..9).map(|k| (format!("{symbol}*.{}{}", AXES[k / 3], AXES[k % 3]), "1")));
    propagate(estimate, &names, |x| {
        let m = from_real(x);
        (0..9)
            .map(|k| (m[k / 3][k % 3] / m[k / 3][k / 3]).re)
            .collect()
    })
}

/// Transverse sensitivity of the three outputs: `transverse.x` relative to the main sensitivity, and
/// `transverse.x.angle`, the direction of the largest response in the plane of the other two axes.
///
/// T_j = max_θ |S_kj cos θ + S_lj sin θ|/|S_jj| with (j, k, l) cyclic: the root of the larger eigenvalue of
/// Re(z zᴴ), z = (S_kj, S_lj).
///
/// **Units** relative; angle in radians from axis k towards axis l, modulo π.
///
/// **Source** `[ISO16063-31]` 3 and annex.
pub fn transverse(estimate: &Estimate) -> Result<Estimate, Error> {
    let names = named((0..3).flat_map(|j| {
        [
            (format!("transverse.{}", AXES[j]), "1"),
            (format!("transverse.{}.angle", AXES[j]), "rad"),
        ]
    }));
    let x0: Vec<f64> = estimate.components().iter().map(|c| c.value).collect();
    let raw = |x: &[f64]| -> Vec<f64> {
        let s = from_real(x);
        (0..3)
            .flat_map(|j| {
                let (z, w) = (s[(j + 1) % 3][j], s[(j + 2) % 3][j]);
                let (a, b, c) = (z.norm_sqr(), w.norm_sqr(), (z * w.conj()).re);
                let largest = 0.5 * (a + b) + (0.25 * (a - b).powi(2) + c * c).sqrt();
                let angle = 0.5 * (2.0 * c).atan2(a - b);
                [largest.sqrt() / s[j][j].norm(), angle]
            })
            .collect()
    };
    let centre = raw(&x0);
    propagate(estimate, &names, |x| {
        let mut v = raw(x);
        for j in 0..3 {
            // Directions modulo π, about the estimate.
            let d = v[2 * j + 1] - centre[2 * j + 1];
            v[2 * j + 1] = centre[2 * j + 1] + 0.5 * wrap(2.0 * d);
        }
        v
    })
}

/// Misalignment of each sensitive axis: `tilt.x.y` is the angle by which the axis of output x leans towards y,
/// radians, after the common phase of the output is taken out.
pub fn misalignment(estimate: &Estimate) -> Result<Estimate, Error> {
    let pairs: Vec<(usize, usize)> = (0..3)
        .flat_map(|j| [(j, (j + 1) % 3), (j, (j + 2) % 3)])
        .collect();
    let names = named(
        pairs
            .iter()
            .map(|&(j, i)| (format!("tilt.{}.{}", AXES[j], AXES[i]), "rad")),
    );
    propagate(estimate, &names, |x| {
        let s = from_real(x);
        pairs
            .iter()
            .map(|&(j, i)| (s[i][j] / s[j][j]).re.atan())
            .collect()
    })
}

/// Intrinsic properties, which no rotation of the device against the bench can change: the length of each
/// sensitivity vector `length.x` … (the column of S that belongs to an output) and the angles between them.
///
/// |s_j| = √(Σ_i |S_ij|²); cos γ_jk = Re(ŝ_jᴴ ŝ_k) with each vector turned to the phase of its main term.
///
/// **Source** `[Gaitan2021]`.
pub fn intrinsic(estimate: &Estimate) -> Result<Estimate, Error> {
    let mut names = named((0..3).map(|j| (format!("length.{}", AXES[j]), "V/(m/s²)")));
    let pairs = [(0, 1), (1, 2), (2, 0)];
    names.extend(pairs.map(|(j, k)| (format!("angle.{}{}", AXES[j], AXES[k]), "rad")));
    propagate(estimate, &names, |x| {
        let s = from_real(x);
        let lengths: Vec<f64> = (0..3)
            .map(|j| (0..3).map(|i| s[i][j].norm_sqr()).sum::<f64>().sqrt())
            .collect();
        let mut v = lengths.clone();
        for (j, k) in pairs {
            let turn = (s[j][j] / s[j][j].norm()) * (s[k][k] / s[k][k].norm()).conj();
            let dot: c64 = (0..3).map(|i| s[i][j].conj() * s[i][k]).sum();
            v.push(
                ((dot * turn).re / (lengths[j] * lengths[k]))
                    .clamp(-1.0, 1.0)
                    .acos(),
            );
        }
        v
    })
}

/// Departure of a main sensitivity from the one on the datasheet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DatasheetDeviation {
    /// Axis.
    pub axis: &'static str,
    /// |S_jj| over the datasheet value, less one.
    pub relative: f64,
    /// E_n = (|S_jj| − S_p)/√(U² + U_p²).
    pub e_n: f64,
}

/// |S_jj| against a datasheet value with its expanded uncertainty, both in V/(m/s²).
pub fn against_datasheet(
    fit: &FrequencyFit,
    value: f64,
    expanded_uncertainty: f64,
) -> Result<Vec<DatasheetDeviation>, Error> {
    Ok(terms("S", "V/(m/s²)", &fit.sensitivity, &fit.estimate)?
        .into_iter()
        .filter(|t| t.name.as_bytes()[0] == t.name.as_bytes()[1])
        .zip(AXES)
        .map(|(t, axis)| DatasheetDeviation {
            axis,
            relative: t.modulus.value / value - 1.0,
            e_n: (t.modulus.value - value) / t.modulus.expanded.hypot(expanded_uncertainty),
        })
        .collect())
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
    use proofmass_uncertainty::{Covariance, DegreesOfFreedom, Effect, Evaluation, Influence};

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
        let influence = Influence {
            key: "all".into(),
            description: "all".into(),
            evaluation: Evaluation::B,
            distribution: "normal".into(),
            dof: DegreesOfFreedom::INFINITE,
            effect: Effect::Joint {
                covariance: Covariance::from_standard_uncertainties(&[u; 18]).unwrap(),
            },
        };
        Estimate::new(components, vec![influence]).unwrap()
    }

    fn turned(angle: f64) -> Matrix {
        // Diagonal sensitivities seen from a device that is turned about z, with a common phase.
        let (s, c) = angle.sin_cos();
        let r = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
        let main = [10.0, 11.0, 12.0];
        let phase = c64::from_polar(1.0, 0.3);
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
        assert!((t.get("transverse.x").unwrap().value - 0.01f64.tan()).abs() < 1e-12);
        assert!(t.get("transverse.x.angle").unwrap().value.abs() < 1e-9);
        let m = misalignment(&e).unwrap();
        assert!((m.get("tilt.x.y").unwrap().value - 0.01).abs() < 1e-12);
        // u(T) = u/|S_xx| to first order in the tilt.
        let u = t.get("transverse.x").unwrap().standard_uncertainty;
        assert!((u - 0.001 / 10.0).abs() < 1e-3 * u);
    }

    #[test]
    fn law_the_budget_of_a_term_sums_to_its_variance() {
        let m = turned(0.1);
        let terms = terms("S", "V/(m/s²)", &m, &estimate(&m, 0.01)).unwrap();
        assert_eq!(terms.len(), 9);
        let sum: f64 = terms[0].budget.iter().map(|l| l.contribution.powi(2)).sum();
        assert!((sum.sqrt() / terms[0].modulus.standard_uncertainty - 1.0).abs() < 1e-12);
        assert!((terms[0].phase.as_ref().unwrap().value - 0.3).abs() < 1e-12);
        // A term that is zero has no phase.
        assert!(terms[2].phase.is_none());
    }
}

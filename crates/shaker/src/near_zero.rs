//! Size of a vector near zero: a modulus, a transverse sensitivity.
//!
//! A size cannot be negative, and the noise of all components adds to it: near zero the law of propagation covers the
//! true modulus of a complex number in 86 % of cases instead of 95 %, and a transverse sensitivity in 64 %. The
//! interval here is the set of sizes ρ that the measured size r does not contradict,
//!
//! ```text
//! |r − ρ| ≤ h(ρ),   h² = (k u)² + (q_d − q_1) (k/k_∞)² σ² exp(−(ρ/bσ)²)
//! ```
//!
//! with u by the law of propagation, σ² the largest eigenvalue of the covariance of the d components, and q_d the 95 %
//! quantile of χ² with d degrees of freedom. At ρ = 0 it is the exact limit of round noise, from ρ = 3 bσ on the law of
//! propagation; there is no switch between the two.

use super::derived::{Expanded, PROBABILITY};
use proofmass_uncertainty::DegreesOfFreedom;

/// How many real components a size is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Two: the modulus of a complex number.
    Modulus,
    /// Four: the largest singular value of a real 2 × 2 matrix.
    Transverse,
}

impl Kind {
    /// q_d − q_1 at 95 %, and b. With these b the coverage is 94.5 % or more for noise of any shape
    /// (`coverage_of_sizes_near_zero`).
    fn shape(self) -> (f64, f64) {
        match self {
            Self::Modulus => (5.991_465 - 3.841_459, 4.0),
            Self::Transverse => (9.487_729 - 3.841_459, 2.5),
        }
    }
}

/// A size with its interval.
///
/// `u` is that of the law of propagation, `sigma` the root of the largest eigenvalue of the covariance of the components.
/// The interval is stated where it is not value ± U, and U is the farther of its ends; the standard uncertainty is U/k.
pub(crate) fn size(
    kind: Kind,
    (name, unit): (String, String),
    value: f64,
    u: f64,
    sigma: f64,
    dof: DegreesOfFreedom,
) -> Expanded {
    let k = dof.coverage_factor(PROBABILITY);
    let factor = k / DegreesOfFreedom::INFINITE.coverage_factor(PROBABILITY);
    let (more, b) = kind.shape();
    let half = |rho: f64| -> f64 {
        let fade = if sigma > 0.0 {
            (-(rho / (b * sigma)).powi(2)).exp()
        } else {
            0.0
        };
        ((k * u).powi(2) + more * (factor * sigma).powi(2) * fade).sqrt()
    };
    // Both differences rise with the distance from the value, so bisection finds where they vanish.
    let root = |mut inside: f64, mut outside: f64| {
        for _ in 0..60 {
            let middle = 0.5 * (inside + outside);
            if (value - middle).abs() <= half(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    };
    let linear = k * u;
    let expanded = if half((value - linear).max(0.0)) <= linear * (1.0 + 1e-12) {
        linear
    } else {
        let lower = if half(0.0) >= value {
            0.0
        } else {
            root(value, 0.0)
        };
        let upper = root(value, value + half(value));
        (upper - value).max(value - lower)
    };
    Expanded {
        name,
        unit,
        value,
        standard_uncertainty: expanded / k,
        expanded,
        coverage_factor: k,
        probability: PROBABILITY,
        dof: (!dof.is_infinite()).then(|| dof.get()),
        interval: (value < expanded).then_some([0.0, value + expanded]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn known_limits_far_from_zero_and_at_zero() {
        let infinite = DegreesOfFreedom::INFINITE;
        let at = |value: f64| {
            size(
                Kind::Modulus,
                ("a".into(), "1".into()),
                value,
                0.5,
                1.0,
                infinite,
            )
        };
        // Thirteen σ away: 1.96 u.
        let far = at(20.0);
        assert!((far.expanded - 0.979_982).abs() < 1e-6 && far.interval.is_none());
        // Nothing measured, noise of u = σ = 1: Rayleigh's 95 % quantile.
        let zero = size(
            Kind::Modulus,
            ("a".into(), "1".into()),
            0.0,
            1.0,
            1.0,
            infinite,
        );
        // 0 ± 2.36: the limit 2.448 of ρ = 0, less what the interval has lost at ρ itself.
        assert!((2.2..2.45).contains(&zero.expanded), "{}", zero.expanded);
        assert_eq!(zero.interval.map(|i| i[0]), Some(0.0));
    }

    /// The largest singular value and its gradient.
    fn singular(z: &[f64; 4]) -> (f64, [f64; 4]) {
        let [a, b, c, d] = *z;
        let (p, q, r) = (a * a + b * b, c * c + d * d, a * c + b * d);
        let root = (0.25 * (p - q).powi(2) + r * r).sqrt();
        let largest = (0.5 * (p + q) + root).sqrt();
        // v: eigenvector of [[p, r], [r, q]].
        let angle = 0.5 * (2.0 * r).atan2(p - q);
        let (s, c2) = angle.sin_cos();
        let u = [a * c2 + c * s, b * c2 + d * s];
        (
            largest,
            [
                u[0] * c2 / largest,
                u[1] * c2 / largest,
                u[0] * s / largest,
                u[1] * s / largest,
            ],
        )
    }

    #[test]
    fn coverage_of_sizes_near_zero() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        let trials = 4000;
        // 95 % of 4000, four standard deviations below; the exact values are 94.5 % and more.
        let least = (0.945 * trials as f64 - 4.0 * (trials as f64 * 0.95 * 0.05).sqrt()) as usize;
        let mut lowest = [trials; 2];
        for noise in [
            [1.0, 1.0, 1.0, 1.0],
            [1.0, 0.3, 1.0, 0.3],
            [0.1, 1.0, 0.1, 1.0],
            [1.0, 1.0, 0.2, 0.2],
        ] {
            for direction in [
                [1.0, 0.0, 0.0, 0.0],
                [0.6, 0.8, 0.0, 0.0],
                [0.6, 0.0, 0.8, 0.0],
                [0.0, 0.7, 0.0, 0.7],
            ] {
                for far in [0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 15.0] {
                    let truth: [f64; 4] = std::array::from_fn(|k| far * direction[k]);
                    let (rho2, rho4) = (
                        truth[0].hypot(truth[1]),
                        if far > 0.0 { singular(&truth).0 } else { 0.0 },
                    );
                    let mut hits = [0usize; 2];
                    for _ in 0..trials {
                        let z: [f64; 4] = std::array::from_fn(|k| {
                            let n: f64 = StandardNormal.sample(&mut rng);
                            truth[k] + noise[k] * n
                        });
                        let along = |g: &[f64]| {
                            g.iter()
                                .zip(&noise)
                                .map(|(g, s)| (g * s).powi(2))
                                .sum::<f64>()
                                .sqrt()
                        };
                        let modulus = z[0].hypot(z[1]);
                        let (t, gradient) = singular(&z);
                        for (kind, (value, rho, u, sigma)) in [
                            (
                                Kind::Modulus,
                                (
                                    modulus,
                                    rho2,
                                    along(&[z[0] / modulus, z[1] / modulus]),
                                    noise[0].max(noise[1]),
                                ),
                            ),
                            (Kind::Transverse, (t, rho4, along(&gradient), 1.0)),
                        ] {
                            let e = size(
                                kind,
                                ("a".into(), "1".into()),
                                value,
                                u,
                                sigma,
                                DegreesOfFreedom::INFINITE,
                            );
                            hits[kind as usize] += usize::from((value - rho).abs() <= e.expanded);
                        }
                    }
                    for k in 0..2 {
                        lowest[k] = lowest[k].min(hits[k]);
                    }
                    assert!(
                        hits.iter().all(|h| *h >= least),
                        "{noise:?} {truth:?}: {hits:?} of {trials}"
                    );
                }
            }
        }
        println!("lowest {lowest:?} of {trials}");
    }
}

//! Offsets, gains and phase error of quadrature signals, by the ellipse that they draw.

use super::Unusable;
use faer::Mat;
use num_complex::Complex64;
use proofmass_uncertainty::algebra::cholesky;
use std::f64::consts::TAU;

/// What a pair of quadrature signals does to the phase φ: u₁ = p + a cos φ, u₂ = q + b sin(φ + δ).
///
/// **Source** `[Heydemann]`.
///
/// ```
/// use proofmass_shaker::interferometer::Quadrature;
/// let pair = Quadrature { offset: [0.1, -0.05], amplitude: [1.0, 0.9], phase: 0.08 };
/// let u = [0.1 + 0.7f64.cos(), -0.05 + 0.9 * 0.78f64.sin()];
/// assert!((pair.phase_of(u) - 0.7).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadrature {
    /// p and q, V.
    pub offset: [f64; 2],
    /// a and b, V.
    pub amplitude: [f64; 2],
    /// δ, rad.
    pub phase: f64,
}

/// A [`Quadrature`] as samples show it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct QuadratureFit {
    /// The ellipse.
    pub quadrature: Quadrature,
    /// Covariance of p, q, a, b, δ by rows, with the residuals as white noise.
    pub covariance: [[f64; 5]; 5],
    /// Root mean square of the distance of the samples from the circle, relative to its radius.
    pub residual: f64,
    /// Part of the turn on which the samples lie, degrees, in steps of ten.
    pub arc: f64,
    /// Complex amplitudes of the third and the fourth harmonic of the radius over the phase, relative: what no ellipse explains.
    pub shape: [Complex64; 2],
}

/// Parts of the turn by which the arc is told.
const PARTS: usize = 36;
/// Parts in a row without a sample from which on the turn is not full.
const GAP: usize = 6;
/// Distance from the circle from which on the pair is none.
const NO_CIRCLE: f64 = 0.2;
/// Radius below which the light is lost.
const DARK: f64 = 0.3;
const ITERATIONS: usize = 20;

impl Quadrature {
    /// Cosine and sine of φ, corrected: on a circle of radius one but for noise.
    pub fn corrected(&self, u: [f64; 2]) -> [f64; 2] {
        let c = (u[0] - self.offset[0]) / self.amplitude[0];
        let s = (u[1] - self.offset[1]) / self.amplitude[1];
        [c, (s - c * self.phase.sin()) / self.phase.cos()]
    }

    /// φ, rad, within half a turn of zero.
    pub fn phase_of(&self, u: [f64; 2]) -> f64 {
        let [c, s] = self.corrected(u);
        s.atan2(c)
    }

    /// Derivatives of the corrected cosine and sine with respect to p, q, a, b, δ.
    fn derivatives(&self, [c, s]: [f64; 2]) -> [[f64; 5]; 2] {
        let ([a, b], (sin, cos)) = (self.amplitude, self.phase.sin_cos());
        let tan = sin / cos;
        let raw = s * cos + c * sin;
        [
            [-1.0 / a, 0.0, -c / a, 0.0, 0.0],
            [
                tan / a,
                -1.0 / (b * cos),
                c * tan / a,
                -raw / (b * cos),
                -c + s * tan,
            ],
        ]
    }

    /// Derivatives of φ with respect to p, q, a, b, δ.
    pub(super) fn phase_derivatives(&self, u: [f64; 2]) -> [f64; 5] {
        let [c, s] = self.corrected(u);
        let [dc, ds] = self.derivatives([c, s]);
        let square = c * c + s * s;
        std::array::from_fn(|k| (c * ds[k] - s * dc[k]) / square)
    }

    /// Distance of a point from the ellipse in volts, to first order of the distance, and its derivatives with respect to p, q, a, b, δ.
    ///
    /// Volts and not parts of the radius: these would grow smaller with the ellipse, and on a part of the turn it would grow.
    fn distance(&self, u: [f64; 2]) -> (f64, [f64; 5]) {
        let ([a, b], (sin, cos)) = (self.amplitude, self.phase.sin_cos());
        let (x, y) = ((u[0] - self.offset[0]) / a, (u[1] - self.offset[1]) / b);
        let (square, tan) = (cos * cos, sin / cos);
        let f = ((x * x - 2.0 * sin * x * y + y * y) / square).max(1e-6);
        let r = f.sqrt();
        // Half the gradient of f over the voltages, but for cos² δ.
        let along = [(x - sin * y) / a, (y - sin * x) / b];
        let slope = along[0].hypot(along[1]).max(1e-12);
        let scale = square / slope;
        let distance = (f - r) * scale;
        let f_of = [
            -2.0 * along[0] / square,
            -2.0 * along[1] / square,
            -2.0 * along[0] * x / square,
            -2.0 * along[1] * y / square,
            2.0 * f * tan - 2.0 * x * y / cos,
        ];
        // Of x and y: p, q, a, b; of the rest: a, b, δ.
        let (dx, dy) = ([-1.0 / a, -x / a], [-1.0 / b, -y / b]);
        let along_of = [
            [dx[0] / a, -sin * dx[0] / b],
            [-sin * dy[0] / a, dy[0] / b],
            [dx[1] / a - along[0] / a, -sin * dx[1] / b],
            [-sin * dy[1] / a, dy[1] / b - along[1] / b],
            [-cos * y / a, -cos * x / b],
        ];
        let g = std::array::from_fn(|k| {
            let steeper = (along[0] * along_of[k][0] + along[1] * along_of[k][1]) / slope;
            let turned = if k == 4 { 2.0 * tan } else { 0.0 };
            (1.0 - 0.5 / r) * f_of[k] * scale - distance * (steeper / slope + turned)
        });
        (distance, g)
    }

    /// The ellipse through samples: a conic by least squares, then least squares of the distance by
    /// Gauss–Newton.
    ///
    /// **Accuracy** exact without noise; with noise σ relative to the radius the estimate is unbiased to σ² times the inequality
    /// of the gains (`law_the_ellipse_is_found_on_a_part_of_a_turn`).
    ///
    /// **Assumes** noise that is alike in both channels and white.
    ///
    /// # Errors
    /// [`Unusable::Constant`], [`Unusable::NoCircle`], [`Unusable::Dropout`], [`Unusable::Arc`] where the samples determine no
    /// ellipse at all.
    pub fn fit(u1: &[f64], u2: &[f64]) -> Result<QuadratureFit, Unusable> {
        let mut pair = conic(u1, u2)?;
        let pairs = || u1.iter().zip(u2).map(|(a, b)| [*a, *b]);
        let n = u1.len() as f64;
        let mut normal = [[0.0; 5]; 5];
        let mut squares = f64::INFINITY;
        for _ in 0..ITERATIONS {
            normal = [[0.0; 5]; 5];
            let mut right = [0.0; 5];
            let before = squares;
            squares = 0.0;
            for u in pairs() {
                let (distance, g) = pair.distance(u);
                squares += distance * distance;
                for i in 0..5 {
                    right[i] -= g[i] * distance;
                    for j in 0..=i {
                        normal[i][j] += g[i] * g[j];
                    }
                }
            }
            let step = solve(&normal, &right).ok_or(Unusable::Arc(0.0, f64::INFINITY))?;
            let next = Self {
                offset: [pair.offset[0] + step[0], pair.offset[1] + step[1]],
                amplitude: [pair.amplitude[0] + step[2], pair.amplitude[1] + step[3]],
                phase: pair.phase + step[4],
            };
            if !next.sound() {
                let scale = (pair.amplitude[0] * pair.amplitude[1]).sqrt();
                return Err(Unusable::NoCircle((squares / n).sqrt() / scale));
            }
            pair = next;
            let scale = pair.amplitude[0].max(pair.amplitude[1]);
            let small = |k: usize| step[k].abs() < 1e-13 * if k == 4 { 1.0 } else { scale };
            if (0..5).all(small) || (squares - before).abs() <= 1e-13 * before {
                break;
            }
        }
        let radius = |u: [f64; 2]| {
            let [c, s] = pair.corrected(u);
            c.hypot(s)
        };
        // Where the light is there it has to draw a circle; two signals that are no pair fill the plane.
        let (mut lit, mut lost) = (0.0, 0usize);
        for r in pairs().map(radius) {
            match r < DARK {
                true => lost += 1,
                false => lit += (r - 1.0).powi(2),
            }
        }
        let bright = (lit / (n - lost as f64).max(1.0)).sqrt();
        if bright > NO_CIRCLE {
            return Err(Unusable::NoCircle(bright));
        }
        if let Some(first) = pairs().position(|u| radius(u) < DARK) {
            return Err(Unusable::Dropout(lost, first));
        }
        let (arc, shape) = pair.around(u1, u2);
        let variance = squares / (n - 5.0).max(1.0);
        let mut covariance = [[0.0; 5]; 5];
        for j in 0..5 {
            let mut unit = [0.0; 5];
            unit[j] = variance;
            let column = solve(&normal, &unit).ok_or(Unusable::Arc(arc, f64::INFINITY))?;
            for i in 0..5 {
                covariance[i][j] = column[i];
            }
        }
        Ok(QuadratureFit {
            quadrature: pair,
            covariance,
            residual: bright,
            arc,
            shape,
        })
    }

    fn sound(&self) -> bool {
        let [a, b] = self.amplitude;
        self.offset.iter().all(|o| o.is_finite())
            && a > 0.0
            && b > 0.0
            && a.is_finite()
            && b.is_finite()
            && self.phase.abs() < 1.4
    }

    /// Part of the turn with samples, and the third and fourth harmonic of the radius over it.
    fn around(&self, u1: &[f64], u2: &[f64]) -> (f64, [Complex64; 2]) {
        let mut parts = [(0usize, 0.0); PARTS];
        for (a, b) in u1.iter().zip(u2) {
            let [c, s] = self.corrected([*a, *b]);
            let turn = (s.atan2(c) / TAU).rem_euclid(1.0);
            let part = &mut parts[((turn * PARTS as f64) as usize).min(PARTS - 1)];
            part.0 += 1;
            part.1 += c.hypot(s) - 1.0;
        }
        let filled = parts.iter().filter(|p| p.0 > 0).count();
        // The longest gap; samples in step with the drive leave small ones on a full turn.
        let (mut gap, mut here) = (0, 0);
        for k in 0..2 * PARTS {
            here = if parts[k % PARTS].0 == 0 { here + 1 } else { 0 };
            gap = gap.max(here.min(PARTS));
        }
        let seen = if gap >= GAP { PARTS - gap } else { PARTS };
        let arc = 360.0 * seen as f64 / PARTS as f64;
        // Harmonics of a part of a turn are not orthogonal, and are not told.
        let shape = [3.0, 4.0].map(|order| {
            if filled < PARTS {
                return Complex64::ZERO;
            }
            let terms = parts.iter().enumerate().map(|(k, (count, sum))| {
                let at = TAU * (k as f64 + 0.5) / PARTS as f64;
                Complex64::from_polar(sum / *count as f64, -order * at)
            });
            2.0 * terms.sum::<Complex64>() / PARTS as f64
        });
        (arc, shape)
    }
}

/// A x² + B xy + C y² + D x + E y = 1 by least squares, in units of the spread of each channel.
fn conic(u1: &[f64], u2: &[f64]) -> Result<Quadrature, Unusable> {
    let n = u1.len() as f64;
    let moments = |u: &[f64]| {
        let mean = u.iter().sum::<f64>() / n;
        let spread = (u.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        (mean, spread)
    };
    let [first, second] = [moments(u1), moments(u2)];
    for (k, (mean, spread)) in [first, second].into_iter().enumerate() {
        if spread <= 1e-9 * mean.abs() || !spread.is_finite() || spread == 0.0 {
            return Err(Unusable::Constant(k));
        }
    }
    let mut normal = [[0.0; 5]; 5];
    let mut right = [0.0; 5];
    for (a, b) in u1.iter().zip(u2) {
        let (x, y) = ((a - first.0) / first.1, (b - second.0) / second.1);
        let row = [x * x, x * y, y * y, x, y];
        for i in 0..5 {
            right[i] += row[i];
            for j in 0..=i {
                normal[i][j] += row[i] * row[j];
            }
        }
    }
    let undetermined = Unusable::Arc(0.0, f64::INFINITY);
    let [a, b, c, d, e] = solve(&normal, &right).ok_or(undetermined)?;
    let determinant = 4.0 * a * c - b * b;
    if !(determinant > 0.0) {
        // A hyperbola or a line: no part of a circle is seen.
        return Err(Unusable::NoCircle(1.0));
    }
    let x = (b * e - 2.0 * c * d) / determinant;
    let y = (b * d - 2.0 * a * e) / determinant;
    // About its centre A x² + B xy + C y² = g, and (x/a)² − 2 (x/a)(y/b) sin δ + (y/b)² = cos² δ.
    let level = 1.0 + a * x * x + b * x * y + c * y * y;
    let sin = -b / (2.0 * (a * c).sqrt());
    let cos_square = 1.0 - sin * sin;
    let amplitude = [
        (level / (a * cos_square)).sqrt(),
        (level / (c * cos_square)).sqrt(),
    ];
    let pair = Quadrature {
        offset: [first.0 + first.1 * x, second.0 + second.1 * y],
        amplitude: [first.1 * amplitude[0], second.1 * amplitude[1]],
        phase: sin.asin(),
    };
    match pair.sound() {
        true => Ok(pair),
        false => Err(Unusable::NoCircle(1.0)),
    }
}

/// Solution of symmetric equations given by their lower half, scaled; `None` where they are singular.
fn solve(normal: &[[f64; 5]; 5], right: &[f64; 5]) -> Option<[f64; 5]> {
    let scale: [f64; 5] = std::array::from_fn(|i| normal[i][i].sqrt());
    if scale.iter().any(|s| !(*s > 0.0)) {
        return None;
    }
    let matrix = Mat::from_fn(5, 5, |i, j| {
        normal[i.max(j)][i.min(j)] / (scale[i] * scale[j])
    });
    let factor = cholesky(&matrix).ok()?;
    let solution = factor.solve(&Mat::from_fn(5, 1, |i, _| right[i] / scale[i]));
    let found: [f64; 5] = std::array::from_fn(|i| solution[(i, 0)] / scale[i]);
    found.iter().all(|v| v.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const TRUTH: Quadrature = Quadrature {
        offset: [0.12, -0.07],
        amplitude: [1.0, 0.85],
        phase: 0.15,
    };

    fn samples(n: usize, turns: f64, noise: f64) -> [Vec<f64>; 2] {
        samples_of(1, n, turns, noise)
    }

    fn samples_of(seed: u64, n: usize, turns: f64, noise: f64) -> [Vec<f64>; 2] {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let phase = |i: usize| TAU * turns * i as f64 / n as f64 - 0.4;
        let mut pair = [vec![], vec![]];
        for i in 0..n {
            let f = phase(i);
            pair[0].push(TRUTH.offset[0] + TRUTH.amplitude[0] * f.cos() + noise * normal());
            let sine = (f + TRUTH.phase).sin();
            pair[1].push(TRUTH.offset[1] + TRUTH.amplitude[1] * sine + noise * normal());
        }
        pair
    }

    fn parameters(q: &Quadrature) -> [f64; 5] {
        [
            q.offset[0],
            q.offset[1],
            q.amplitude[0],
            q.amplitude[1],
            q.phase,
        ]
    }

    #[test]
    fn law_the_ellipse_is_found_on_a_part_of_a_turn() {
        for turns in [0.6, 1.0, 7.3] {
            let [a, b] = samples(2000, turns, 0.0);
            let fit = Quadrature::fit(&a, &b).unwrap();
            let found = parameters(&fit.quadrature);
            for (f, t) in found.iter().zip(parameters(&TRUTH)) {
                assert!((f - t).abs() < 1e-9, "{turns}: {f} {t}");
            }
            assert!(fit.residual < 1e-9);
            let expected = if turns < 1.0 { 360.0 * turns } else { 360.0 };
            assert!((fit.arc - expected).abs() <= 20.0, "{}", fit.arc);
        }
        // With noise the errors are those of the covariance: none beyond four standard uncertainties.
        let [a, b] = samples(20_000, 7.3, 0.01);
        let fit = Quadrature::fit(&a, &b).unwrap();
        let found = parameters(&fit.quadrature);
        for (k, t) in parameters(&TRUTH).into_iter().enumerate() {
            let u = fit.covariance[k][k].sqrt();
            assert!(u < 3e-4 && (found[k] - t).abs() < 4.0 * u, "{k}");
        }
    }

    #[test]
    fn refuses_what_is_no_pair() {
        let [a, b] = samples(500, 3.0, 0.0);
        let flat = vec![0.3; 500];
        assert_eq!(Quadrature::fit(&a, &flat), Err(Unusable::Constant(1)));
        // A line.
        let line: Vec<f64> = a.iter().map(|v| 0.5 * v).collect();
        assert!(Quadrature::fit(&a, &line).is_err());
        let mut dark = [a, b];
        for v in &mut dark[0][100..110] {
            *v = TRUTH.offset[0];
        }
        for v in &mut dark[1][100..110] {
            *v = TRUTH.offset[1];
        }
        let lost = Quadrature::fit(&dark[0], &dark[1]);
        assert!(matches!(lost, Err(Unusable::Dropout(10, 100))), "{lost:?}");
    }

    #[test]
    fn law_the_derivatives_of_the_distance_are_its_differences() {
        let of = |p: [f64; 5]| Quadrature {
            offset: [p[0], p[1]],
            amplitude: [p[2], p[3]],
            phase: p[4],
        };
        let at = parameters(&TRUTH);
        for u in [[1.0, 0.2], [-0.5, 0.9], [0.3, -0.7]] {
            let (_, g) = TRUTH.distance(u);
            for k in 0..5 {
                let [mut low, mut high] = [at, at];
                (low[k], high[k]) = (at[k] - 1e-6, at[k] + 1e-6);
                let difference = (of(high).distance(u).0 - of(low).distance(u).0) / 2e-6;
                assert!(
                    (g[k] - difference).abs() < 1e-8,
                    "{k}: {} {difference}",
                    g[k]
                );
            }
        }
    }

    /// The intervals of the five parameters hold on a part of the turn too, where they are wide.
    #[test]
    fn coverage_of_the_ellipse_on_a_part_of_a_turn() {
        for turns in [0.4, 0.6, 3.0] {
            let (mut held, mut all) = (0, 0);
            for seed in 0..200 {
                let [a, b] = samples_of(seed, 2000, turns, 5e-3);
                let fit = Quadrature::fit(&a, &b).unwrap();
                let found = parameters(&fit.quadrature);
                for (k, t) in parameters(&TRUTH).into_iter().enumerate() {
                    all += 1;
                    held += usize::from((found[k] - t).abs() < 1.96 * fit.covariance[k][k].sqrt());
                }
            }
            let share = 100.0 * held as f64 / all as f64;
            // The five of one record are correlated: 200 records, three standard deviations.
            println!("{turns}: {share} %");
            assert!((90.0..=99.0).contains(&share), "{turns}: {share} %");
        }
    }
}

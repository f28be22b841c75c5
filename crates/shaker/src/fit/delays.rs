//! Channels of a front end that are not sampled together, as the phases of the outputs show it.

use super::super::matrix::AXES;
use super::Fit;
use crate::findings;
use faer::Mat;
use num_complex::Complex64;
use proofmass_uncertainty::Finding;
use proofmass_uncertainty::algebra::cholesky;
use std::f64::consts::{PI, TAU};

/// Departure in standard uncertainties, beyond what a device explains, from which a delay is told: three pairs at 0.13 % each.
const SEEN: f64 = 3.0;
/// Least quality factor of a resonance that is taken for the device.
const QUALITY: f64 = 10.0;
/// Share of the delay that all outputs have by which the axes of one device may differ: a filter or a strong damping delays all, and
/// with corner and damping within ±10 % the delays 2ζ/ω₀ are within a factor of 1.5.
const ALIKE: f64 = 0.5;
/// Largest f/f₀ at which a resonance is still one of the lines.
const NEAREST: f64 = 0.9;
/// Share of the largest term of an output that its main term must have.
const FAINT: f64 = 0.3;
/// U = k u of 95 %.
const K: f64 = 1.96;

/// By how much one output comes later than another.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct OutputDelay {
    /// The later output and the earlier one.
    pub outputs: [usize; 2],
    /// Delay in s.
    pub value: f64,
    /// Its standard uncertainty.
    pub standard_uncertainty: f64,
    /// What a device with these moduli may explain of it, s.
    pub allowed: f64,
    /// Whether phases in proportion to frequency describe the difference better than equal ones.
    pub proportional: bool,
}

impl OutputDelay {
    /// What no device explains, in standard uncertainties.
    pub fn size(&self) -> f64 {
        (self.value - self.allowed) / self.standard_uncertainty
    }
}

/// Delays between the outputs, the later one first: arg S_kk − arg S_jj = 2πf τ by generalised least squares with the covariance of
/// all frequencies. Empty below three frequencies.
pub(super) fn delays(fit: &Fit) -> Vec<OutputDelay> {
    let main = |k: usize| fit.frequencies.iter().map(move |f| f.sensitivity[k][k]);
    let faint = fit.frequencies.iter().any(|f| {
        (0..3).any(|j| {
            let largest = (0..3)
                .map(|i| f.sensitivity[i][j].norm())
                .fold(0.0, f64::max);
            !(f.sensitivity[j][j].norm() > FAINT * largest)
        })
    });
    if fit.frequencies.len() < 3 || faint {
        return vec![];
    }
    let at: Vec<f64> = fit.frequencies.iter().map(|f| f.frequency).collect();
    let lags: Vec<Option<Lag>> = (0..3)
        .map(|k| {
            Lag::of(
                fit,
                &[(k, -1.0)],
                &unwrapped(&at, main(k).map(|s| -s.arg())),
            )
        })
        .collect();
    let of_all = lags
        .iter()
        .flatten()
        .map(|l| l.delay)
        .fold(f64::INFINITY, f64::min);
    let alike = if of_all.is_finite() {
        ALIKE * of_all.max(0.0)
    } else {
        0.0
    };
    let mut found = vec![];
    for [j, k] in [[0, 1], [0, 2], [1, 2]] {
        let apart = main(j).zip(main(k)).map(|(a, b)| (b * a.conj()).arg());
        let lag = unwrapped(&at, apart);
        let Some(seen) = Lag::of(fit, &[(j, -1.0), (k, 1.0)], &lag) else {
            continue;
        };
        let outputs = if seen.delay > 0.0 { [j, k] } else { [k, j] };
        let resonance = resonance(fit, outputs[0]);
        let turn: Vec<f64> = at
            .iter()
            .map(|f| {
                let x = (f * resonance).min(NEAREST);
                (x / QUALITY / (1.0 - x * x)).atan()
            })
            .collect();
        found.push(OutputDelay {
            outputs,
            value: seen.delay.abs(),
            standard_uncertainty: seen.u,
            allowed: seen.weigh(&turn) + alike,
            proportional: seen.left <= seen.left_by_constant,
        });
    }
    found
}

/// The clearest one, where it is one.
pub(super) fn finding(fit: &Fit) -> Option<Finding> {
    let told = |d: &&OutputDelay| d.proportional && d.size() > SEEN;
    let clearest = fit
        .delays
        .iter()
        .filter(told)
        .max_by(|a, b| a.size().total_cmp(&b.size()))?;
    let highest = fit.frequencies.last()?.frequency;
    let [late, early] = clearest.outputs.map(|k| AXES[k]);
    Some(findings::channel_delays(
        late,
        early,
        1e6 * clearest.value,
        1e6 * K * clearest.standard_uncertainty,
        360.0 * highest * clearest.value,
        highest,
        1e6 * clearest.allowed,
    ))
}

/// Phases that are near zero, or half a turn, at the lowest frequency and grow in proportion to it: without the half turn, and without
/// jumps of whole turns.
fn unwrapped(at: &[f64], phases: impl Iterator<Item = f64>) -> Vec<f64> {
    /// Below it a phase says nothing of those at higher frequencies, rad.
    const SMALL: f64 = 0.02;
    let mut turned: Vec<f64> = vec![];
    let mut sign = 0.0;
    for (i, phase) in phases.enumerate() {
        let expected = match i.checked_sub(1) {
            None => {
                sign = PI * (phase / PI).round();
                0.0
            }
            Some(last) if turned[last].abs() > SMALL => turned[last] * at[i] / at[last],
            Some(_) => 0.0,
        };
        let phase = phase - sign;
        turned.push(phase - TAU * ((phase - expected) / TAU).round());
    }
    turned
}

/// A phase in proportion to frequency.
struct Lag {
    delay: f64,
    u: f64,
    /// χ² about it, and about a constant.
    left: f64,
    left_by_constant: f64,
    /// Weights that read the delay from phases.
    weights: Vec<f64>,
}

impl Lag {
    /// Of the sum of the phases of some main terms, each with its factor.
    fn of(fit: &Fit, terms: &[(usize, f64)], lag: &[f64]) -> Option<Self> {
        let n = lag.len();
        // ∂ arg S/∂(re, im) = (−im, re)/|S|².
        let gradient: Vec<Vec<(usize, f64)>> = fit
            .frequencies
            .iter()
            .map(|f| {
                let of = |(k, factor): &(usize, f64)| {
                    let s: Complex64 = f.sensitivity[*k][*k];
                    let over = factor / s.norm_sqr();
                    [(8 * k, -s.im * over), (8 * k + 1, s.re * over)]
                };
                terms.iter().flat_map(of).collect()
            })
            .collect();
        let along = |f: usize, v: &[f64]| gradient[f].iter().map(|(p, g)| g * v[*p]).sum::<f64>();
        let shared = fit.shared.as_deref().unwrap_or(&[]);
        let own = |f: usize| -> f64 {
            let c = fit.frequencies[f].estimate.covariance();
            let pairs = gradient[f]
                .iter()
                .flat_map(|a| gradient[f].iter().map(move |b| (a, b)));
            pairs
                .map(|((p, a), (q, b))| a * b * c.elements()[18 * p + q])
                .sum()
        };
        let covariance = Mat::from_fn(n, n, |a, b| match a == b {
            true => own(a),
            false => shared
                .iter()
                .map(|s| along(a, &s.effects[a]) * along(b, &s.effects[b]))
                .sum(),
        });
        let llt = cholesky(&covariance).ok()?;
        let column = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let solved = llt.solve(&Mat::from_fn(n, 1, |i, _| of(i)));
            (0..n).map(|i| solved[(i, 0)]).collect()
        };
        let turn = |i: usize| TAU * fit.frequencies[i].frequency;
        let fitted = |of: &dyn Fn(usize) -> f64| -> (f64, f64, f64, Vec<f64>) {
            let weighted = column(of);
            let square: f64 = (0..n).map(|i| weighted[i] * of(i)).sum();
            let weights: Vec<f64> = weighted.iter().map(|w| w / square).collect();
            let value: f64 = weights.iter().zip(lag).map(|(w, l)| w * l).sum();
            let rest = |i: usize| lag[i] - value * of(i);
            let whitened = column(&rest);
            let left = (0..n).map(|i| whitened[i] * rest(i)).sum();
            (value, square.recip().sqrt(), left, weights)
        };
        let (delay, u, left, weights) = fitted(&turn);
        let (_, _, left_by_constant, _) = fitted(&|_| 1.0);
        Some(Self {
            delay,
            u,
            left,
            left_by_constant,
            weights,
        })
    }

    /// The delay that it would read from other phases.
    fn weigh(&self, phases: &[f64]) -> f64 {
        let sum: f64 = self.weights.iter().zip(phases).map(|(w, p)| w * p).sum();
        sum.max(0.0)
    }
}

/// 1/f₀ of the lowest resonance that the moduli of an output allow, s: 1/|S| = (1 − f²/f₀²)/S₀ far from it.
fn resonance(fit: &Fit, k: usize) -> f64 {
    let points = fit.frequencies.iter().map(|f| {
        let s = f.sensitivity[k][k];
        let c = f.estimate.covariance();
        let c = |p: usize, q: usize| c.elements()[18 * p + q];
        let (re, im) = (8 * k, 8 * k + 1);
        let size = s.norm();
        let variance =
            (s.re * s.re * c(re, re) + 2.0 * s.re * s.im * c(re, im) + s.im * s.im * c(im, im))
                / (size * size);
        // 1/|S| and the weight of it.
        (f.frequency.powi(2), 1.0 / size, size.powi(4) / variance)
    });
    let points: Vec<(f64, f64, f64)> = points.collect();
    let sum =
        |of: &dyn Fn(&(f64, f64, f64)) -> f64| points.iter().map(|p| p.2 * of(p)).sum::<f64>();
    let weight = sum(&|_| 1.0);
    let (x, y) = (sum(&|p| p.0) / weight, sum(&|p| p.1) / weight);
    let spread = sum(&|p| (p.0 - x).powi(2));
    if !(spread > 0.0) {
        return f64::INFINITY;
    }
    let slope = sum(&|p| (p.0 - x) * (p.1 - y)) / spread;
    let start = y - slope * x;
    let (rise, u) = (-slope / start, spread.recip().sqrt() / start);
    (rise.max(0.0) + K * u).sqrt()
}

#[cfg(test)]
mod tests {
    use super::unwrapped;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn known_phases_of_a_delay_of_several_turns() {
        let at = [10.0, 40.0, 160.0, 500.0, 1000.0];
        for (tau, sign) in [(2e-3, 0.0), (-1.5e-3, PI), (3e-6, PI)] {
            let phases = at.iter().map(|f| {
                let phase: f64 = TAU * f * tau + sign;
                phase - TAU * (phase / TAU).round()
            });
            for (f, phase) in at.iter().zip(unwrapped(&at, phases)) {
                assert!((phase - TAU * f * tau).abs() < 1e-9, "{f} Hz, {tau} s");
            }
        }
    }
}

//! A state that is known to lie in a cell: moments of the normal distribution cut at both edges.

use super::Read;
use proofmass_core::state_space::{Gain, Reading};
use proofmass_core::velocity::CountingState;
use std::f64::consts::PI;

/// Mills' ratio (1 − Φ)/φ for x ≥ 0, to 9e-7.
fn mills(x: f64) -> f64 {
    if x > 12.0 {
        // 1/x − 1/x³ + 3/x⁵.
        let s = 1.0 / (x * x);
        return (1.0 - s * (1.0 - 3.0 * s)) / x;
    }
    let top = 1.253_313_0 + x * (0.898_608_46 + x * (0.294_837_31 + x * 0.041_683_536));
    let bottom =
        1.0 + x * (1.514_845_9 + x * (0.944_079_73 + x * (0.294_594_62 + x * 0.041_690_084)));
    top / bottom
}

/// Mean and variance of a standard normal variable that is known to lie between two bounds.
///
/// Bounds closer than half a standard deviation are taken as a uniform distribution.
pub(super) fn truncated(alpha: f64, beta: f64) -> (f64, f64) {
    if alpha + beta < 0.0 {
        let (mean, variance) = truncated(-beta, -alpha);
        return (-mean, variance);
    }
    let width = beta - alpha;
    if width < 0.5 {
        return (0.5 * (alpha + beta), width * width / 12.0);
    }
    let (scale, g) = if alpha >= 0.0 {
        let g = (-0.5 * (beta * beta - alpha * alpha)).exp();
        (mills(alpha) - g * mills(beta), g)
    } else {
        let g = (-0.5 * (beta * beta - alpha * alpha)).exp();
        let all = (2.0 * PI).sqrt() * (0.5 * alpha * alpha).exp();
        (all - mills(-alpha) - g * mills(beta), g)
    };
    let mean = (1.0 - g) / scale;
    let tail = if g > 0.0 { g * beta } else { 0.0 };
    let variance = 1.0 + (alpha - tail) / scale - mean * mean;
    (mean, variance.clamp(0.0, 1.0))
}

/// The state is somewhere in its cell: moments of the normal distribution cut at both edges, which are those of a reading.
/// Its gain and innovation; innovation and variance of the cell's middle.
pub(super) fn cell<const N: usize>(
    state: &mut CountingState<f64, N>,
    edge: f64,
) -> (Read<N>, (f64, f64)) {
    let (x, p) = (state.x[0], state.p[0][0]);
    let middle = (0.5 - x, p + 1.0 / 12.0 + edge);
    let s = (p + edge).sqrt();
    let (mean, rest) = truncated(-x / s, (1.0 - x) / s);
    // What the cut takes off the variance; where it cuts nothing the reading has no weight.
    let cut = (1.0 - rest).max(1e-12);
    let gain = Gain::new(Reading::State(0), &state.p, (edge + p * (1.0 - cut)) / cut);
    let innovation = s * mean / cut;
    gain.correct(&mut state.x, innovation);
    gain.reduce(&mut state.p);
    ((gain, innovation), middle)
}

/// Velocity and uncertainty of a state that is known to lie in its cell, counts per sample; nothing of it is fed back.
pub(super) fn shown<const N: usize>(state: &CountingState<f64, N>, seen: bool) -> (f64, f64) {
    let (x, v) = (state.x[0], state.x[1]);
    let (xx, xv) = (state.p[0][0], state.p[0][1]);
    let vv = state.p[1][1];
    let s = xx.sqrt();
    let (alpha, beta) = (-x / s, (1.0 - x) / s);
    if !seen || !(s > 0.0) || (alpha < -3.0 && beta > 3.0) {
        return (v, vv.max(0.0).sqrt());
    }
    let (mean, rest) = truncated(alpha, beta);
    let value = v + xv / xx * s * mean;
    let variance = vv - xv * xv / xx * (1.0 - rest);
    (value, variance.max(1e-9 * vv).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_moments_of_a_truncated_normal_variable() {
        for (a, b, mean, variance) in [
            (-1.0, 1.0, 0.0, 0.291125095),
            (-0.5, 2.0, 0.445743778, 0.376593836),
            (0.5, 3.0, 1.13166492, 0.249099034),
            (2.0, 6.0, 2.37321537, 0.114278483),
            (4.0, 9.0, 4.22560714, 0.0466728384),
            (-0.1, 0.1, 0.0, 0.00332889101),
        ] {
            // The ratio is right to 9e-7, its differences to 3e-4 for half a deviation.
            let (m, v) = truncated(a, b);
            assert!(
                (m - mean).abs() < 3e-4 && (v - variance).abs() < 3e-4,
                "{a} {b} {m} {v}"
            );
            let (m, v) = truncated(-b, -a);
            assert!((m + mean).abs() < 3e-4 && (v - variance).abs() < 3e-4);
        }
    }

    #[test]
    fn crosscheck_velocity_in_the_present_cell() {
        for (x, v, xx, xv, vv, value, variance) in [
            (0.9, 0.004, 0.04, 2e-4, 2e-6, 0.00349086018, 1.48609115e-6),
            (1.2, 0.006, 0.01, 1e-4, 4e-6, 0.00362678447, 3.11427910e-6),
        ] {
            let mut p = [[0.0; 3]; 3];
            (p[0][0], p[0][1], p[1][0], p[1][1]) = (xx, xv, xv, vv);
            let state = CountingState {
                x: [x, v, 0.0],
                p,
                acceleration: 0.0,
                count: 0,
            };
            let (ours, u) = shown(&state, true);
            assert!(
                (ours - value).abs() < 1e-7 && (u * u - variance).abs() < 1e-10,
                "{ours} {u}"
            );
        }
    }
}

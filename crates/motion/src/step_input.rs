//! What the acceleration does to position and velocity from sample to sample, and how much of it is not seen.

use crate::floor::noise_floor;
use crate::{KalmanModel, MotionRecord};
use proofmass_core::velocity::Hold;
use std::collections::BTreeMap;

/// Steps of a record.
pub(crate) struct Curve {
    /// Change of position and of velocity in the step to each sample.
    pub(crate) steps: Vec<[f64; 2]>,
    /// Variances of what the steps do not have of the changes: of position, both, velocity.
    pub(crate) unseen: Vec<[f64; 3]>,
}

/// Steps over which a curve at an end is held against that of all samples.
const NEAR: usize = 64;

/// Samples that the curve off line goes through.
const NODES: usize = 6;
/// The same where six do not follow the motion: with five samples to a period they lose 1.2 % of the velocity, twelve 0.05 %.
const MANY: usize = 12;

/// Change of position and velocity that the acceleration makes over the step to each sample, by the polynomial of
/// fifth degree through the three samples before and after the middle of the step, at the ends through the six
/// nearest; `None` for models that take the acceleration otherwise, and for fewer samples.
///
/// Where the motion is so fast that twelve samples tell more than the noise of the accelerometer does, as many as there
/// are on both sides, up to six.
pub(crate) fn curve(record: &MotionRecord, model: &KalmanModel) -> Option<Curve> {
    let n = record.acceleration.len();
    if model.interpolation != Hold::Second || n < NODES {
        return None;
    }
    let few = steps_through(record, NODES);
    let unseen = not_seen(record);
    // Of a short record the floor is not known; its curve is that of any record.
    let Some(floor) = noise_floor(&record.acceleration) else {
        let steps = few;
        return Some(Curve { steps, unseen });
    };
    let many = steps_through(record, MANY);
    let (_, six) = step_weights(NODES / 2 - 1, NODES);
    let (_, twelve) = step_weights(MANY / 2 - 1, MANY);
    let margin = (MANY - NODES) / 2;
    let apart = |i: usize| {
        let inner = i.checked_sub(margin).and_then(|j| six.get(j));
        twelve[i] - inner.copied().unwrap_or(0.0)
    };
    let noise = floor * (0..MANY).map(|i| apart(i) * apart(i)).sum::<f64>();
    let dt = record.sample_time;
    let pairs = few.iter().zip(&many);
    let square = pairs
        .map(|(a, b)| ((a[1] - b[1]) / dt).powi(2))
        .sum::<f64>();
    if square <= 9.0 * noise * n as f64 {
        let steps = few;
        return Some(Curve { steps, unseen });
    }
    let mut curve = Curve {
        steps: many,
        unseen,
    };
    curve.doubt_ends(record);
    Some(curve)
}

/// The polynomial through up to as many samples as are named, half of them on either side of the step, and at least [`NODES`].
fn steps_through(record: &MotionRecord, most: usize) -> Vec<[f64; 2]> {
    let (a, dt) = (&record.acceleration, record.sample_time);
    let n = a.len();
    let rules: BTreeMap<_, _> = (1..n.min(most + 1))
        .chain(n.saturating_sub(most).max(1)..n)
        .map(|k| place(k, n, most))
        .map(|(before, nodes)| ((before, nodes), step_weights(before - 1, nodes)))
        .collect();
    let change = |k: usize| {
        let (before, nodes) = place(k, n, most);
        let (position, velocity) = &rules[&(before, nodes)];
        let sum = |w: &[f64]| -> f64 { w.iter().zip(&a[k - before..]).map(|(w, a)| w * a).sum() };
        [dt * dt * sum(position), dt * sum(velocity)]
    };
    let first = std::iter::once([0.0; 2]);
    first.chain((1..n).map(change)).collect()
}

/// Samples of the curve before the one at which a step ends, and all of them.
fn place(k: usize, n: usize, most: usize) -> (usize, usize) {
    let half = k.min(n - k).min(most / 2);
    if half >= NODES / 2 {
        return (half, 2 * half);
    }
    let from = k.saturating_sub(NODES / 2).min(n - NODES);
    (k - from, NODES)
}

impl Curve {
    /// Near the ends there are fewer samples on one side: what their curve does elsewhere, beside that of all samples, is doubtful here.
    fn doubt_ends(&mut self, record: &MotionRecord) {
        let (a, dt) = (&record.acceleration, record.sample_time);
        let n = a.len();
        let half = MANY / 2;
        let inner = |k: &usize| *k >= half && k + half <= n;
        for k in (1..half).chain(n - half + 1..n) {
            let (before, nodes) = place(k, n, MANY);
            let (position, velocity) = step_weights(before - 1, nodes);
            let near: Vec<usize> = match k < half {
                true => (half..half + NEAR).filter(inner).collect(),
                false => (n.saturating_sub(half + NEAR)..n).filter(inner).collect(),
            };
            for k_near in &near {
                let part = &a[k_near - before..];
                let sum = |w: &[f64]| -> f64 { w.iter().zip(part).map(|(w, a)| w * a).sum() };
                let [x, v] = self.steps[*k_near];
                let (x, v) = (dt * dt * sum(&position) - x, dt * sum(&velocity) - v);
                for (total, square) in self.unseen[k].iter_mut().zip([x * x, x * v, v * v]) {
                    *total += square / near.len() as f64;
                }
            }
        }
    }
}

/// Variances of what the accelerometer does not see of the changes in the step to each sample: blows and holes, even over the step.
pub(crate) fn not_seen(record: &MotionRecord) -> Vec<[f64; 3]> {
    let n = record.acceleration.len();
    let half = 0.5 * record.sample_time;
    let mut unseen = vec![[0.0; 3]; n];
    let blows = record.blows.iter().map(|b| (b.from..b.to, b.velocity));
    let holes = record.holes.iter().map(|h| (h.steps(), h.velocity));
    for (steps, velocity) in blows.chain(holes) {
        let steps = steps.start.min(n)..steps.end.min(n);
        let share = velocity * velocity / steps.len().max(1) as f64;
        for total in &mut unseen[steps] {
            total[0] += half * half * share;
            total[1] += half * share;
            total[2] += share;
        }
    }
    unseen
}

/// Adds what was not seen of a step to a covariance of position, velocity and more.
pub(crate) fn shake<const N: usize>(p: &mut [[f64; N]; N], [xx, xv, vv]: [f64; 3]) {
    p[0][0] += xx;
    p[0][1] += xv;
    p[1][0] += xv;
    p[1][1] += vv;
}

/// The same for every model: where it takes no curve, the straight line, or the older sample.
pub(crate) fn step_inputs(record: &MotionRecord, model: &KalmanModel) -> Curve {
    if let Some(curve) = curve(record, model) {
        return curve;
    }
    let (a, dt) = (&record.acceleration, record.sample_time);
    let step = |w: &[f64]| match model.interpolation {
        Hold::Zero => [0.5 * dt * dt * w[0], dt * w[0]],
        _ => [
            dt * dt * (w[0] / 3.0 + w[1] / 6.0),
            0.5 * dt * (w[0] + w[1]),
        ],
    };
    let first = std::iter::once([0.0; 2]);
    Curve {
        steps: first.chain(a.windows(2).map(step)).collect(),
        unseen: not_seen(record),
    }
}

/// ∫(1 − s) L_i and ∫ L_i over 0 < s < 1 for Lagrange's polynomials over 0 … nodes − 1, s counted from node `from`.
///
/// Gauss's rule of four points in each quarter of the step: exact up to degree seven, and to rounding for twelve nodes.
fn step_weights(from: usize, nodes: usize) -> (Vec<f64>, Vec<f64>) {
    const PARTS: usize = 4;
    let root = (1.2f64).sqrt();
    let (near, far) = ((3.0 - 2.0 * root) / 7.0, (3.0 + 2.0 * root) / 7.0);
    let (heavy, light) = ((18.0 + 30f64.sqrt()) / 72.0, (18.0 - 30f64.sqrt()) / 72.0);
    let rule = [
        (-far.sqrt(), light),
        (-near.sqrt(), heavy),
        (near.sqrt(), heavy),
        (far.sqrt(), light),
    ];
    let (mut position, mut velocity) = (vec![0.0; nodes], vec![0.0; nodes]);
    for (part, (at, weight)) in (0..PARTS).flat_map(|p| rule.map(|r| (p, r))) {
        let s = (part as f64 + 0.5 * (1.0 + at)) / PARTS as f64;
        let weight = weight / PARTS as f64;
        for i in 0..nodes {
            let others = (0..nodes).filter(|j| *j != i).map(|j| j as f64);
            let lagrange: f64 = others
                .map(|j| (from as f64 + s - j) / (i as f64 - j))
                .product();
            position[i] += weight * (1.0 - s) * lagrange;
            velocity[i] += weight * lagrange;
        }
    }
    (position, velocity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReadingSource;

    #[test]
    fn law_a_fifth_degree_is_integrated_exactly_up_to_both_ends() {
        let dt = 0.1;
        let t = |k: usize| dt * k as f64 - 0.7;
        let n = 20;
        let record = MotionRecord::new(
            dt,
            ReadingSource::Position,
            vec![Some(0.0); n],
            (0..n).map(|k| 42.0 * t(k).powi(5)).collect(),
        )
        .unwrap();
        let steps = curve(&record, &KalmanModel::new(1.0, 1.0)).unwrap().steps;
        // v = 7 t⁶, x = t⁷.
        for k in 1..n {
            let (a, b) = (t(k - 1), t(k));
            let v = 7.0 * (b.powi(6) - a.powi(6));
            let x = b.powi(7) - a.powi(7) - 7.0 * a.powi(6) * dt;
            assert!((steps[k][1] - v).abs() < 1e-13, "{k}");
            assert!((steps[k][0] - x).abs() < 1e-13, "{k}");
        }
    }

    /// Five samples to a period: a sine of 4 Hz and 1 m/s at 20 Hz, against its own velocity; √(2/3) of the
    /// error constant of six nodes 191/60480 · (ωT)⁶ and of twelve, 1.2 % and 0.05 %.
    #[test]
    fn law_fast_motion_is_followed_by_twelve_samples() {
        let (dt, w) = (0.05, std::f64::consts::TAU * 4.0);
        let n = 400;
        let a = (0..n).map(|k| w * (w * dt * k as f64).cos()).collect();
        let record = MotionRecord::new(dt, ReadingSource::Position, vec![Some(0.0); n], a).unwrap();
        let worst = |steps: &[[f64; 2]]| {
            let error = |k: usize| {
                let v = (w * dt * k as f64).sin() - (w * dt * (k - 1) as f64).sin();
                (steps[k][1] - v).abs()
            };
            (MANY / 2..n - MANY / 2).map(error).fold(0.0, f64::max)
        };
        let step = 2.0 * (0.5 * w * dt).sin();
        let few = worst(&steps_through(&record, NODES)) / step;
        let chosen = worst(&curve(&record, &KalmanModel::new(1.0, 1.0)).unwrap().steps) / step;
        assert!((0.010..0.014).contains(&few), "{few}");
        assert!((2e-4..8e-4).contains(&chosen), "{chosen}");
    }

    #[test]
    fn law_twelve_nodes_integrate_a_polynomial_of_their_degree() {
        let (position, velocity) = step_weights(5, 12);
        // ∫ xᵐ and ∫ (6 − x) xᵐ from 5 to 6.
        for m in 0..12 {
            let power = |p: i32| (6f64.powi(p) - 5f64.powi(p)) / f64::from(p);
            let sum = |w: &[f64]| -> f64 {
                let pairs = w.iter().enumerate();
                pairs.map(|(i, w)| w * (i as f64).powi(m)).sum()
            };
            let exact = [6.0 * power(m + 1) - power(m + 2), power(m + 1)];
            assert!((sum(&position) / exact[0] - 1.0).abs() < 1e-9, "{m}");
            assert!((sum(&velocity) / exact[1] - 1.0).abs() < 1e-9, "{m}");
        }
    }
}

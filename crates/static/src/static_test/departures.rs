//! Departures from a straight line after the definitions of the field, and what differs between rising and falling.

use super::readings::{Solved, weighed_least_squares};
use proofmass_uncertainty::{f_quantile, student_quantile};
use serde::Serialize;

/// Largest departure of the fitted curve from one kind of straight line, as a share of the full scale.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Departure {
    /// Which line: `end point` through both ends of the curve, `best fit` by least squares over the readings, `zero based` through
    /// the output at zero with the slope of the best fit through it.
    pub line: String,
    /// Largest departure.
    pub share: f64,
    /// What holds it with 95 % wherever the largest departure lies: Scheffé's band over the range.
    pub expanded: f64,
    /// Acceleration at which it is largest, m/s².
    pub acceleration: f64,
}

/// The fitted powers z, z², … of the acceleration over its largest, from the column `first` on.
pub(super) struct Polynomial<'a> {
    pub(super) first: usize,
    pub(super) reach: f64,
    pub(super) solved: &'a Solved,
    pub(super) scatter: f64,
}

/// Places at which the curve is held against a line.
const PLACES: usize = 200;

impl Polynomial<'_> {
    /// The three kinds over the readings at `z`; `full_scale` in output units.
    pub(super) fn departures(&self, z: &[f64], full_scale: f64) -> Vec<Departure> {
        let size = self.solved.parameters.len();
        let top = size - self.first;
        let low = z.iter().copied().fold(f64::INFINITY, f64::min);
        let high = z.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // Of each power the line that is taken off: level and slope.
        type Line = fn(&[f64], [f64; 2], i32) -> [f64; 2];
        let lines: [(&str, Line); 3] = [
            ("end point", |_, [low, high], k| {
                let slope = (high.powi(k) - low.powi(k)) / (high - low);
                [low.powi(k) - slope * low, slope]
            }),
            ("best fit", |z, _, k| {
                let n = z.len() as f64;
                let mean = z.iter().sum::<f64>() / n;
                let level = z.iter().map(|v| v.powi(k)).sum::<f64>() / n;
                let xx: f64 = z.iter().map(|v| (v - mean).powi(2)).sum();
                let xy: f64 = z.iter().map(|v| (v - mean) * v.powi(k)).sum();
                [level - xy / xx * mean, xy / xx]
            }),
            ("zero based", |z, _, k| {
                let xx: f64 = z.iter().map(|v| v * v).sum();
                [0.0, z.iter().map(|v| v.powi(k + 1)).sum::<f64>() / xx]
            }),
        ];
        // Powers beyond the first: a line takes the first off whole.
        let curved = top.saturating_sub(1).max(1) as f64;
        let scheffe = (curved * f_quantile(0.95, curved, self.solved.dof as f64)).sqrt();
        let of = |(name, line): (&str, Line)| {
            let off: Vec<[f64; 2]> = (1..=top as i32).map(|k| line(z, [low, high], k)).collect();
            let at = |v: f64| {
                let weights: Vec<f64> = (0..top)
                    .map(|i| v.powi(i as i32 + 1) - off[i][0] - off[i][1] * v)
                    .collect();
                let (mut value, mut variance) = (0.0, 0.0);
                for (i, w) in weights.iter().enumerate() {
                    let row = self.first + i;
                    value += w * self.solved.parameters[row];
                    for (j, other) in weights.iter().enumerate() {
                        variance += w * other * self.solved.inverse[row * size + self.first + j];
                    }
                }
                [value, variance.max(0.0).sqrt() * self.scatter, v]
            };
            let places: Vec<[f64; 3]> = (0..=PLACES)
                .map(|i| at(low + (high - low) * i as f64 / PLACES as f64))
                .collect();
            let largest =
                places.iter().fold(
                    places[0],
                    |m, p| if p[0].abs() > m[0].abs() { *p } else { m },
                );
            let widest = places.iter().map(|p| p[1]).fold(0.0, f64::max);
            Departure {
                line: name.to_owned(),
                share: largest[0].abs() / full_scale,
                expanded: scheffe * widest / full_scale,
                acceleration: largest[2] * self.reach,
            }
        };
        lines.into_iter().map(of).collect()
    }
}

/// What rising and falling readings differ by, as a share of the full scale.
pub(super) struct Branches {
    /// Rising less falling.
    pub(super) difference: f64,
    /// Its U with 95 %.
    pub(super) expanded: f64,
    /// In standard uncertainties, and what one healthy test in a hundred exceeds.
    t: [f64; 2],
}

impl Branches {
    /// Whether the difference is no chance.
    pub(super) fn seen(&self) -> bool {
        self.t[0].abs() > self.t[1]
    }
}

/// Fewest readings of each direction.
const FEWEST: usize = 3;

/// A difference between rising and falling beside the model; `None` where the readings went one way only.
pub(super) fn branches(
    columns: &[Vec<f64>],
    y: &[f64],
    weights: &[f64],
    acceleration: &[f64],
    full_scale: f64,
) -> Option<Branches> {
    let mut last = 0.0;
    let mut direction: Vec<f64> = Vec::with_capacity(y.len());
    for (i, a) in acceleration.iter().enumerate() {
        let change = if i == 0 { 0.0 } else { a - acceleration[i - 1] };
        if change != 0.0 {
            last = f64::signum(change);
        }
        direction.push(0.5 * last);
    }
    // Sweeps: a direction that turns with every other reading is a random order, which has no branches.
    let turns = direction.windows(2).filter(|w| w[0] * w[1] < 0.0).count();
    let count = |sign: f64| direction.iter().filter(|d| **d * sign > 0.0).count();
    if count(1.0).min(count(-1.0)) < FEWEST || 4 * turns > y.len() {
        return None;
    }
    let mut columns = columns.to_vec();
    columns.push(direction);
    let solved = weighed_least_squares(&columns, y, weights.to_vec(), "rising and falling").ok()?;
    let last = columns.len() - 1;
    let nu = solved.dof as f64;
    let variance = solved.squares / nu * solved.inverse[last * columns.len() + last];
    let (difference, u) = (solved.parameters[last], variance.sqrt());
    (solved.dof > 1 && u > 0.0).then(|| Branches {
        difference: difference / full_scale,
        expanded: student_quantile(0.975, nu) * u / full_scale,
        t: [difference / u, student_quantile(0.995, nu)],
    })
}

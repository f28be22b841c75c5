//! Heating and cooling: which block belongs to which, and what differs between them.

use super::Blocks;
use serde::Serialize;

/// What heating and cooling do differently on one axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Hysteresis {
    /// Largest difference of the branches within their common range, heating minus cooling, m/s².
    pub difference: f64,
    /// Its standard uncertainty, m/s².
    pub standard_uncertainty: f64,
    /// Temperature at which it is largest, °C.
    pub temperature: f64,
    /// Heating minus cooling at points of the common range: temperature in °C, difference, standard uncertainty.
    pub curve: Vec<[f64; 3]>,
}

impl Hysteresis {
    /// Standard uncertainty of a reading whose branch is not known: half the difference as half-width of a rectangle.
    pub fn of_a_reading(&self) -> f64 {
        0.5 * self.difference.abs() / 3f64.sqrt()
    }
}

/// Direction and rate of the temperature at every block.
pub(super) struct Branches {
    /// +1 heating, −1 cooling; a block at rest keeps the direction it came from.
    pub(crate) sign: Vec<f64>,
    /// Ṫ, K/s.
    pub(crate) rate: Vec<f64>,
    /// Temperatures that both branches went through in one attitude, where both are there.
    pub(crate) common: Option<[f64; 2]>,
    /// Whether Ṫ varies enough within the branches to tell lag from hysteresis.
    pub(crate) lag: bool,
}

/// Blocks a branch must hold.
const FEWEST: usize = 12;
/// Share of the whole range that both branches must have in common.
const COMMON: f64 = 0.5;
/// Scatter of |Ṫ| within the branches relative to its mean.
const VARIED: f64 = 0.3;

impl Branches {
    pub fn of(blocks: &Blocks) -> Self {
        let n = blocks.len();
        let half = (n / 40).max(1);
        let rate: Vec<f64> = (0..n)
            .map(|i| {
                let (a, b) = (i.saturating_sub(half), (i + half).min(n - 1));
                (blocks.temperature[b] - blocks.temperature[a])
                    / (blocks.time[b] - blocks.time[a]).max(f64::MIN_POSITIVE)
            })
            .collect();
        let fastest = rate.iter().map(|r| r.abs()).fold(0.0, f64::max);
        // The noise of the thermometer is no direction.
        let noise = (2.0 * blocks.temperature_noise).sqrt() / (2.0 * half as f64 * blocks.duration);
        let moving = (0.1 * fastest).max(4.0 * noise);
        let first = rate
            .iter()
            .find(|r| r.abs() > moving)
            .map_or(1.0, |r| r.signum());
        let mut last = first;
        let sign: Vec<f64> = rate
            .iter()
            .map(|r| {
                if r.abs() > moving {
                    last = r.signum();
                }
                last
            })
            .collect();
        let span = |attitude: usize, wanted: f64| {
            let of = |i: &usize| {
                blocks.attitude[*i] == attitude && sign[*i] == wanted && rate[*i].abs() > moving
            };
            let t: Vec<f64> = (0..n).filter(of).map(|i| blocks.temperature[i]).collect();
            let ends = t
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| {
                    [a.min(*v), b.max(*v)]
                });
            (t.len() >= FEWEST).then_some(ends)
        };
        // Both ways in one attitude: heating in one and cooling in another differ by the attitude as well.
        let [low, high] = blocks.range();
        let common = (0..blocks.attitudes.len())
            .filter_map(|s| Some((span(s, 1.0)?, span(s, -1.0)?)))
            .map(|(up, down)| [up[0].max(down[0]), up[1].min(down[1])])
            .filter(|[a, b]| b - a > COMMON * (high - low))
            .max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
        let speeds: Vec<f64> = rate
            .iter()
            .map(|r| r.abs())
            .filter(|r| *r > moving)
            .collect();
        let mean = speeds.iter().sum::<f64>() / speeds.len().max(1) as f64;
        let scatter = (speeds.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
            / speeds.len().max(1) as f64)
            .sqrt();
        Self {
            sign,
            rate,
            common,
            lag: common.is_some() && scatter > VARIED * mean,
        }
    }
}

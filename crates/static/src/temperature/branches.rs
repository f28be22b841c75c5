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
    /// The same without a model: means of the outputs of one attitude where both branches went through a temperature, with the
    /// standard uncertainty from their scatter alone.
    pub raw: Vec<[f64; 3]>,
    /// Where the raw difference and the model's disagree most beyond what noise explains: temperature, raw difference, model's.
    pub disagreement: Option<[f64; 3]>,
}

impl Hysteresis {
    /// Standard uncertainty of a reading whose branch is not known: half the difference as half-width of a rectangle. The raw
    /// difference counts where it disagrees with the model's and is larger.
    pub fn of_a_reading(&self) -> f64 {
        let raw = self.disagreement.map_or(0.0, |[_, raw, _]| raw.abs());
        0.5 * raw.max(self.difference.abs()) / 3f64.sqrt()
    }

    /// The curve of the model beside the raw differences, which are held against that of noise without a walk.
    pub(super) fn new(curve: Vec<[f64; 3]>, without_walk: &[[f64; 3]], raw: Vec<[f64; 3]>) -> Self {
        let worst = curve.iter().fold(
            curve[0],
            |m, p| if p[1].abs() > m[1].abs() { *p } else { m },
        );
        let nearest = |t: f64| {
            let points = without_walk.iter();
            points.min_by(|a, b| (a[0] - t).abs().total_cmp(&(b[0] - t).abs()))
        };
        let off = raw.iter().filter_map(|[t, difference, u]| {
            let [_, model, u_model] = nearest(*t)?;
            let off = (difference - model).abs() - (MODEL * u_model + RAW * u);
            (off > 0.0).then_some((off, [*t, *difference, *model]))
        });
        let disagreement = off.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, d)| d);
        Self {
            difference: worst[1],
            standard_uncertainty: worst[2],
            temperature: worst[0],
            curve,
            raw,
            disagreement,
        }
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

/// How far raw and modelled difference may be apart in standard uncertainties of each: a hundredth of healthy recordings is
/// beyond that at one of a dozen temperatures on three axes. The model has two, for it counts a form that it lacks as noise.
const MODEL: f64 = 2.0;
const RAW: f64 = 3.6;
/// Temperatures at which the raw difference is taken, over the common range.
const BINS: usize = 12;
/// Blocks of each branch that a raw difference needs.
const FEWEST_RAW: usize = 3;

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

    /// Heating less cooling of one axis by the outputs alone: temperature, difference, standard uncertainty. In each of a dozen
    /// stretches of the common range both branches of one attitude share a slope.
    pub fn raw(&self, blocks: &Blocks, axis: usize) -> Vec<[f64; 3]> {
        let Some([low, high]) = self.common else {
            return Vec::new();
        };
        let width = (high - low) / BINS as f64;
        (0..BINS)
            .filter_map(|bin| {
                let from = low + width * bin as f64;
                let within = |i: usize| (from..from + width).contains(&blocks.temperature[i]);
                (0..blocks.attitudes.len())
                    .filter_map(|attitude| {
                        let of = |sign: f64| -> Vec<[f64; 2]> {
                            (0..blocks.len())
                                .filter(|i| {
                                    within(*i)
                                        && blocks.attitude[*i] == attitude
                                        && self.sign[*i] == sign
                                })
                                .map(|i| [blocks.temperature[i], blocks.output[i][axis]])
                                .collect()
                        };
                        let (heating, cooling) = (of(1.0), of(-1.0));
                        let found = offset(&heating, &cooling)?;
                        Some((heating.len() + cooling.len(), found))
                    })
                    .max_by_key(|(count, _)| *count)
                    .map(|(_, [difference, u])| [from + 0.5 * width, difference, u])
            })
            .collect()
    }
}

/// Distance of two lines of one slope, first less second, with its standard uncertainty from the scatter about them.
fn offset(first: &[[f64; 2]], second: &[[f64; 2]]) -> Option<[f64; 2]> {
    if first.len().min(second.len()) < FEWEST_RAW {
        return None;
    }
    let mean = |p: &[[f64; 2]], k: usize| p.iter().map(|v| v[k]).sum::<f64>() / p.len() as f64;
    let groups = [first, second].map(|p| (p, mean(p, 0), mean(p, 1)));
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        let parts = groups.iter();
        parts
            .flat_map(|(p, t, y)| p.iter().map(move |v| f(v[0] - t, v[1] - y)))
            .sum()
    };
    let (xx, xy) = (sum(&|t, _| t * t), sum(&|t, y| t * y));
    let slope = if xx > 0.0 { xy / xx } else { 0.0 };
    let freedom = (first.len() + second.len()) as f64 - 3.0;
    let variance = sum(&|t, y| (y - slope * t).powi(2)) / freedom;
    let apart = groups[0].1 - groups[1].1;
    let share = 1.0 / first.len() as f64
        + 1.0 / second.len() as f64
        + if xx > 0.0 { apart * apart / xx } else { 0.0 };
    let difference = groups[0].2 - groups[1].2 - slope * apart;
    Some([difference, (variance * share).sqrt()])
}

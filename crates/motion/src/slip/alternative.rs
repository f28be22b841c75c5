//! Gain and latency of the accelerometer, and errors of the encoder that repeat, in the place of slip.

use super::{SlipSearch, changes, felt, judged};
use crate::MotionRecord;
use crate::episode::{held, quiet};
use crate::threshold::speed_increment;
use proofmass_uncertainty::adjustment::ScaledRoot;

/// Constants beside which less of a record is slip.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Alternative {
    /// The accelerometer reads this times the acceleration.
    pub(crate) gain: f64,
    /// Time by which it is later than the readings, s.
    pub(crate) latency: f64,
    /// Coefficients of what may be in the readings beside the position.
    pub(crate) regressors: Vec<f64>,
    /// ln L less the price of the constants, above that of slip beside a gain of one and nothing else.
    pub(crate) gained: f64,
}

/// Gains that are looked at: beyond them it is a unit, or an axis.
const GAINS: std::ops::Range<f64> = 0.5..2.0;
/// What a constant has to bring: half the point of χ²(1) that one in a thousand passes.
const PRICE: f64 = 0.5 * 10.83;
/// Latencies in a window either way.
const STEPS: usize = 25;
/// Columns before the regressors: a constant, and the accelerometer.
const BEFORE: usize = 2;

impl SlipSearch {
    /// The gain, the latency and the coefficients of `regressors` (one value per sample) that leave the least unexplained.
    ///
    /// The velocity changes of the readings are those of the accelerometer over its gain, later by its latency, plus those of the
    /// regressors, plus a constant of its offset. What is off by more than the threshold is slip and counts as the threshold
    /// does, so that a part of the record that slips does not pull the constants: least squares of what lies within a bound that
    /// shrinks to the threshold. Windows overlap; one in the length of a window is new. `None` where the motion does not tell a
    /// gain to 5 %.
    ///
    /// **Source** `[BlakeZisserman87]` for the bound that shrinks.
    pub(crate) fn alternative(
        &self,
        record: &MotionRecord,
        regressors: &[Vec<f64>],
    ) -> Option<Alternative> {
        let dt = record.sample_time;
        let w = (self.window / dt).round() as usize;
        let n = record.reading.len();
        if w < 4 || n < 8 * w {
            return None;
        }
        let positions = held(&record.positions());
        let read = changes(&positions, w, dt);
        let felt = changes(&felt(record), w, dt);
        let judged = judged(record, w, read.len());
        let stride = (w / 8).max(1);
        // A latency of up to a window either way.
        let places: Vec<usize> = (w..read.len().saturating_sub(w))
            .step_by(stride)
            .filter(|k| judged[*k])
            .collect();
        if places.len() < 8 * (8 + regressors.len()) {
            return None;
        }
        let increment = record.increment.or_else(|| speed_increment(&positions));
        let width = (w as f64).powi(3);
        let rounding = increment.unwrap_or(0.0) * (2.0 / width).sqrt() / dt;
        let further = regressors.iter().map(|r| {
            let all = changes(r, w, dt);
            places.iter().map(|&k| all[k]).collect()
        });
        let search = Fit {
            read: places.iter().map(|&k| read[k]).collect(),
            further: further.collect(),
            felt: &felt,
            places: &places,
            threshold: self.threshold,
            window: w as f64,
            share: stride as f64 / w as f64,
        };
        let plain = search.read.iter().zip(&places).map(|(r, &k)| r - felt[k]);
        let plain: Vec<f64> = plain.collect();
        let mut size = quiet(&plain).1.max(rounding);
        let mut best = search.best(size)?;
        for _ in 0..2 {
            let own = quiet(&best.left).1.max(rounding);
            if own > 0.9 * size {
                break;
            }
            size = own;
            best = search.best(size)?;
        }
        let (centre, _) = quiet(&plain);
        let beside: Vec<f64> = plain.iter().map(|d| d - centre).collect();
        let before = search.cost(&beside, size);
        let told = best.spread > 0.0 && size / (best.spread * search.share).sqrt() < 0.05;
        let gain = 1.0 / best.coefficients[1];
        let constants = (BEFORE + regressors.len()) as f64;
        (told && GAINS.contains(&gain)).then(|| Alternative {
            gain,
            latency: best.shift * dt,
            regressors: best.coefficients[BEFORE..].to_vec(),
            gained: before - best.cost - PRICE * constants,
        })
    }
}

/// Velocity changes of the readings on those of the accelerometer.
struct Fit<'a> {
    /// At the places.
    read: Vec<f64>,
    /// Those of the regressors, at the places.
    further: Vec<Vec<f64>>,
    /// At every sample.
    felt: &'a [f64],
    places: &'a [usize],
    threshold: f64,
    /// Samples of a window.
    window: f64,
    /// Share of the places that is new.
    share: f64,
}

/// Least squares at one latency.
struct Line {
    /// Of the constant, the accelerometer and the regressors.
    coefficients: Vec<f64>,
    /// Samples by which the accelerometer is late.
    shift: f64,
    /// Sum of squares of the accelerometer's changes it was fitted on.
    spread: f64,
    /// What it leaves.
    left: Vec<f64>,
    /// −ln L.
    cost: f64,
}

impl Fit<'_> {
    fn felt_at(&self, k: usize, shift: f64) -> f64 {
        let (whole, part) = (shift.floor(), shift - shift.floor());
        let last = self.felt.len() as i64 - 1;
        let at = |i: i64| self.felt[(k as i64 + whole as i64 + i).clamp(0, last) as usize];
        at(0) * (1.0 - part) + at(1) * part
    }

    /// −ln L of what is left: half the squares, those beyond the threshold at the threshold.
    fn cost(&self, left: &[f64], size: f64) -> f64 {
        let most = self.threshold * self.threshold;
        let squares = left.iter().map(|r| (r / size).powi(2).min(most));
        0.5 * self.share * squares.sum::<f64>()
    }

    /// The best over latencies of a window either way.
    fn best(&self, size: f64) -> Option<Line> {
        let step = self.window / STEPS as f64;
        let mut best: Option<Line> = None;
        for i in -(STEPS as i32)..=STEPS as i32 {
            let Some(line) = self.line(step * f64::from(i), size) else {
                continue;
            };
            // Of latencies that are as likely the least: a periodic motion has many.
            let better = |b: &Line| {
                let nearer = line.shift.abs() < b.shift.abs();
                line.cost < b.cost - 3.0 || (nearer && line.cost < b.cost + 3.0)
            };
            if best.as_ref().is_none_or(better) {
                best = Some(line);
            }
        }
        let mut best = best?;
        // The cost is a parabola near its least.
        let mut half = step;
        for _ in 0..8 {
            for shift in [best.shift - half, best.shift + half] {
                if let Some(line) = self.line(shift, size).filter(|l| l.cost < best.cost) {
                    best = line;
                }
            }
            half *= 0.5;
        }
        Some(best)
    }

    fn line(&self, shift: f64, size: f64) -> Option<Line> {
        let felt: Vec<f64> = self
            .places
            .iter()
            .map(|&k| self.felt_at(k, shift))
            .collect();
        let one = vec![1.0; felt.len()];
        let columns: Vec<&[f64]> = [one.as_slice(), &felt]
            .into_iter()
            .chain(self.further.iter().map(Vec::as_slice))
            .collect();
        let m = columns.len();
        let narrow = self.threshold * size;
        let mut bound = f64::INFINITY;
        let mut left = self.read.clone();
        let (mut coefficients, mut spread) = (vec![0.0; m], 0.0);
        for _ in 0..40 {
            let (mut a, mut y) = (vec![vec![0.0; m]; m], vec![0.0; m]);
            for k in (0..left.len()).filter(|k| left[*k].abs() <= bound) {
                for i in 0..m {
                    y[i] += columns[i][k] * self.read[k];
                    for j in 0..=i {
                        a[i][j] += columns[i][k] * columns[j][k];
                    }
                }
            }
            let root = ScaledRoot::new(m, |i, j| a[i.max(j)][i.min(j)])?;
            spread = a[1][1] - a[1][0] * a[1][0] / a[0][0];
            let mut x: Vec<f64> = y.iter().zip(&root.scale).map(|(y, s)| y * s).collect();
            root.forward(&mut x);
            root.backward(&mut x);
            coefficients = x.iter().zip(&root.scale).map(|(x, s)| x * s).collect();
            for (k, left) in left.iter_mut().enumerate() {
                let fitted = columns.iter().zip(&coefficients).map(|(c, b)| c[k] * b);
                *left = self.read[k] - fitted.sum::<f64>();
            }
            if bound <= narrow {
                break;
            }
            let most = left.iter().fold(0.0f64, |m, r| m.max(r.abs()));
            bound = (0.7 * bound.min(most)).max(narrow);
        }
        let cost = self.cost(&left, size);
        (cost.is_finite() && spread > 0.0).then_some(Line {
            coefficients,
            shift,
            spread,
            left,
            cost,
        })
    }
}

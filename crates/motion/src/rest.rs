//! An accelerometer alone: what is known is that the axis rests for a while.

use crate::counting::{LONG_RUN, counts};
use crate::findings;
use crate::floor::{noise_floor, variance};
use crate::{BiasModel, KalmanModel, MotionRecord, ReadingSource};
use proofmass_uncertainty::Finding;

/// Standard deviation of a rest, m/s: none that matters, and none that rounding could not carry.
const REST: f64 = 1e-7;

/// Batches of a stretch at rest.
const BATCHES: usize = 10;

impl MotionRecord {
    /// Whether the readings are nothing but rests: a speed of zero in some samples, none in others.
    pub fn rests_only(&self) -> bool {
        self.source == ReadingSource::Speed
            && self.accelerometer
            && self.reading.iter().any(Option::is_none)
            && self.reading.iter().flatten().all(|v| *v == 0.0)
    }
}

/// Counts that were put on another clock and are no counts any more: of the equal ones of a rest one in twenty.
///
/// While a count does not change its error is the same; on a grid of increments the filter of counts knows that.
pub(crate) fn rests_once(record: &MotionRecord) -> MotionRecord {
    let mut record = record.clone();
    let positions = record.source == ReadingSource::Position && record.edges.is_none();
    if !positions || record.increment.is_none() || counts(&record).is_some() {
        return record;
    }
    let known: Vec<(usize, f64)> = record
        .reading
        .iter()
        .enumerate()
        .filter_map(|(k, r)| r.map(|r| (k, r)))
        .collect();
    for run in known.chunk_by(|a, b| a.1 == b.1) {
        if run.len() >= LONG_RUN {
            let last = run.len() - 1;
            for (i, (k, _)) in run.iter().enumerate() {
                if i % LONG_RUN != 0 && i != last {
                    record.reading[*k] = None;
                }
            }
        }
    }
    record
}

/// The model of an accelerometer whose axis rests for a while: noise and offset as the rest shows them.
///
/// The noise of a sample is that of the rest, or the floor of the whole record where that is higher; the offset is an
/// unknown constant.
pub(crate) fn model_at_rest(record: &MotionRecord) -> KalmanModel {
    let still = at_rest(record);
    let mean = still.iter().sum::<f64>() / still.len().max(1) as f64;
    let spread = if still.is_empty() {
        0.0
    } else {
        variance(&still)
    };
    let q = spread.max(noise_floor(&record.acceleration).unwrap_or(0.0));
    KalmanModel {
        bias: Some(BiasModel::RandomWalk {
            density: 0.0,
            initial: 3.0 * mean.abs() + 3.0 * q.sqrt().max(1e-9),
        }),
        ..KalmanModel::new(q.max(1e-18), REST * REST)
    }
}

fn at_rest(record: &MotionRecord) -> Vec<f64> {
    let pairs = record.reading.iter().zip(&record.acceleration);
    pairs.filter_map(|(r, a)| r.map(|_| *a)).collect()
}

/// A stretch that is called still although the acceleration changes within it by more than its noise.
///
/// Ten batches; the variance of their means against what noise from sample to sample would give them. White noise exceeds
/// ten times that in 2·10⁻⁴ of the stretches (F, 9 degrees of freedom), and what it means is told: the uncertainty of the
/// offset, and the velocity that this makes in a second.
///
/// `None` for a stretch at rest, or too short to tell (below 40 samples).
pub fn moves_while_still(acceleration: &[f64]) -> Option<Finding> {
    let length = acceleration.len() / BATCHES;
    if length < 4 {
        return None;
    }
    let means: Vec<f64> = acceleration
        .chunks_exact(length)
        .take(BATCHES)
        .map(|b| b.iter().sum::<f64>() / length as f64)
        .collect();
    let among = variance(&means) * BATCHES as f64 / (BATCHES - 1) as f64;
    // Half the mean square of the differences is the variance of white noise, whatever the mean does.
    let steps = acceleration.windows(2).map(|w| (w[1] - w[0]).powi(2));
    let white = 0.5 * steps.sum::<f64>() / (acceleration.len() - 1) as f64 / length as f64;
    let offset = (among / BATCHES as f64).sqrt();
    (among > 10.0 * white && among > 0.0).then(|| {
        findings::still_stretch_moves(
            among.sqrt(),
            (among / white.max(f64::MIN_POSITIVE)).sqrt().min(9999.0),
            offset,
        )
    })
}

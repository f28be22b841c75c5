//! What a record lacks before anything is computed from it: dead channels, missing and repeated readings, a start in
//! motion.

use crate::{MotionRecord, ReadingSource};
use proofmass_uncertainty::{Finding, Severity};

/// Findings on the record itself.
pub fn conditions(record: &MotionRecord) -> Vec<Finding> {
    if record.rests_only() {
        return dead(record).into_iter().collect();
    }
    [
        dead(record),
        still(record),
        missing(record),
        repeated(record),
        start(record),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// An accelerometer that never changes is disconnected or saturated: noise would move it.
fn dead(record: &MotionRecord) -> Option<Finding> {
    let first = *record
        .acceleration
        .first()
        .filter(|_| record.accelerometer)?;
    record.acceleration.iter().all(|a| *a == first).then(|| {
        Finding::new(
            Severity::Decision,
            "constant-channel",
            "the accelerometer never changes",
        )
        .evidence(format!(
            "{first} in all {} samples",
            record.acceleration.len()
        ))
        .advice("check column, cable and range: a working sensor shows at least its noise")
    })
}

fn still(record: &MotionRecord) -> Option<Finding> {
    let first = record.reading.iter().flatten().next()?;
    let same = record.reading.iter().flatten().all(|r| r == first);
    same.then(|| {
        Finding::new(
            Severity::Decision,
            "readings-never-change",
            "the axis never leaves one increment, or the channel is dead",
        )
        .evidence(format!(
            "{first} in all {} readings",
            record.reading.iter().flatten().count()
        ))
        .advice("nothing can be tuned on a standstill; check the column if the axis moved")
    })
}

fn missing(record: &MotionRecord) -> Option<Finding> {
    let stride = record.reading_stride();
    let mut at = (0..record.reading.len()).filter(|&k| record.reading[k].is_some());
    let first = at.next()?;
    let last = at.next_back().unwrap_or(first);
    let due = (last - first) / stride + 1;
    let got = record.reading.iter().flatten().count();
    (got < due).then(|| {
        Finding::new(Severity::Note, "missing-readings", "readings are missing")
            .evidence(format!("{} of {due} readings missing", due - got))
            .advice("fused methods coast on the acceleration there; the uncertainty grows with it")
    })
}

/// A slower sensor that was logged with the faster one repeats each value: n − 1 of n readings are no readings.
fn repeated(record: &MotionRecord) -> Option<Finding> {
    // A count stands as long as the axis stays in its increment.
    if record.increment.is_some() {
        return None;
    }
    let n = repetition(record)?;
    Some(
        Finding::new(
            Severity::Warning,
            "repeated-readings",
            "each reading stands several times: a slower sensor was logged with the faster one",
        )
        .evidence(format!(
            "most values stand {n} times in a row, at {:.4} Hz of {:.4} Hz",
            1.0 / (n as f64 * record.sample_time),
            1.0 / record.sample_time
        ))
        .advice("take only the first of each: repeated values look like independent ones and make the uncertainty too small"),
    )
}

/// How often each reading stands in a row, when nearly all that change stand equally often and more than once.
///
/// Only runs of at most 200 samples between two changes are counted; a quantised axis of varying speed has runs of
/// all lengths and gives `None`.
pub fn repetition(record: &MotionRecord) -> Option<usize> {
    if record.reading.iter().any(Option::is_none) {
        return None;
    }
    let readings: Vec<f64> = record.reading.iter().flatten().copied().collect();
    let runs: Vec<usize> = readings.chunk_by(|a, b| a == b).map(<[f64]>::len).collect();
    // The ends are cut off anywhere.
    let inner = runs.get(1..runs.len().checked_sub(1)?)?;
    if inner.len() < 20 {
        return None;
    }
    let mut count = [0usize; 201];
    for &run in inner {
        count[run.min(200)] += 1;
    }
    let (n, _) = count[..200].iter().enumerate().max_by_key(|(_, c)| **c)?;
    // A clock a little off makes a run one longer or shorter now and then.
    let near = count[n - usize::from(n > 0)..=(n + 1).min(199)]
        .iter()
        .sum::<usize>();
    (n > 1 && count[1] == 0 && near * 10 > inner.len() * 7).then_some(n)
}

/// A start that is stated to be slower or faster than it is.
fn start(record: &MotionRecord) -> Option<Finding> {
    let v0 = record.initial_velocity?;
    let early: Vec<(usize, f64)> = record
        .reading
        .iter()
        .enumerate()
        .filter_map(|(k, r)| r.map(|r| (k, r)))
        .take(20)
        .collect();
    let (&(k, x), &(l, y)) = (early.first()?, early.get(19)?);
    let span = (l - k) as f64 * record.sample_time;
    // Slope of the first readings against the claim, in units of what quantisation and acceleration explain.
    let mean = match record.source {
        ReadingSource::Position => (y - x) / span,
        ReadingSource::Speed => early.iter().map(|(_, r)| r).sum::<f64>() / 20.0,
    };
    let fastest = record.acceleration[..=l]
        .iter()
        .fold(0.0f64, |m, a| m.max(a.abs()));
    let explained = record.increment.unwrap_or(0.0) / span + fastest * span;
    ((mean - v0).abs() > 3.0 * explained).then(|| {
        Finding::new(
            Severity::Warning,
            "start-in-motion",
            "the record does not start at the stated velocity",
        )
        .evidence(format!(
            "{mean:.4} over the first {span:.3} s, stated {v0:.4}"
        ))
        .advice("leave the initial velocity unknown")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(reading: impl Fn(usize) -> Option<f64>, a: impl Fn(usize) -> f64) -> MotionRecord {
        let n = 2000;
        MotionRecord::new(
            1e-2,
            ReadingSource::Speed,
            (0..n).map(reading).collect(),
            (0..n).map(a).collect(),
        )
        .unwrap()
    }

    fn codes(record: &MotionRecord) -> Vec<String> {
        let found = conditions(record);
        found.iter().map(|f| f.code().to_owned()).collect()
    }

    #[test]
    fn law_a_held_slow_sensor_is_known() {
        let wave = |k: usize| (0.01 * k as f64).sin();
        let noise = |k: usize| (k * 7919 % 101) as f64;
        let held = record(|k| Some(wave(k / 10 * 10)), noise);
        assert_eq!(repetition(&held), Some(10));
        assert_eq!(codes(&held), ["repeated-readings"]);
        assert!(codes(&record(|k| Some(wave(k)), noise)).is_empty());
        // A quantised axis rests on a value as long as it takes.
        let quantised = record(|k| Some((20.0 * wave(k)).round()), noise);
        assert_eq!(repetition(&quantised), None);
    }

    #[test]
    fn law_dead_channels_and_missing_readings_are_said() {
        let wave = |k: usize| Some((0.01 * k as f64).sin());
        assert_eq!(codes(&record(wave, |_| 0.5)), ["constant-channel"]);
        let noise = |k: usize| (k * 7919 % 101) as f64;
        assert_eq!(
            codes(&record(|_| Some(1.0), noise)),
            ["readings-never-change"]
        );
        let gaps = record(|k| wave(k).filter(|_| k % 7 != 3), noise);
        assert_eq!(codes(&gaps), ["missing-readings"]);
        let mut moving = record(|k| Some(5.0 + wave(k).unwrap_or(0.0)), |k| 0.01 * noise(k));
        moving.initial_velocity = Some(0.0);
        assert_eq!(codes(&moving), ["start-in-motion"]);
    }
}

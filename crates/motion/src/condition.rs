//! What a record lacks before anything is computed from it: dead channels, missing and repeated readings, a start in
//! motion.

use crate::findings;
use crate::{MotionRecord, ReadingSource, held};
use proofmass_uncertainty::Finding;
use proofmass_uncertainty::findings::repeated_samples;

/// Findings on the record itself.
pub fn conditions(record: &MotionRecord) -> Vec<Finding> {
    if record.rests_only() {
        return dead(record).into_iter().chain(unmoved(record)).collect();
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
pub(crate) fn dead(record: &MotionRecord) -> Option<Finding> {
    let first = *record
        .acceleration
        .first()
        .filter(|_| record.accelerometer)?;
    record.acceleration.iter().all(|a| *a == first).then(|| {
        let evidence = format!("{first} in all {} samples", record.acceleration.len());
        proofmass_uncertainty::findings::constant_channel("the accelerometer", &evidence, "")
    })
}

/// Seconds over which an acceleration is averaged where it is asked whether the axis moves.
const AVERAGE: f64 = 1.0;
/// Scatter of such means, m/s², that no standing axis has: people who get in and out, and settling, stay below.
const MOVES: f64 = 0.02;
/// Share of a record above which its rests are no stretch that somebody stated.
const STATED: f64 = 0.9;

/// A speed of zero in all its readings while the accelerometer moves: a slower sensor that is dead.
///
/// Means over a second, each against the next, so that a drift of the offset does not count: beyond ten times what noise
/// from sample to sample makes of them (in variance), and beyond 0.02 m/s².
fn unmoved(record: &MotionRecord) -> Option<Finding> {
    let known = || (0..record.reading.len()).filter(|&k| record.reading[k].is_some());
    let (first, count) = (known().next()?, known().count());
    let last = known().next_back()?;
    let stated = count == last - first + 1;
    if stated && (count as f64) < STATED * record.reading.len() as f64 {
        return None;
    }
    let a = &record.acceleration[first..=last];
    let length = ((AVERAGE / record.sample_time) as usize)
        .min(a.len() / 10)
        .max(4);
    let means: Vec<f64> = a
        .chunks_exact(length)
        .map(|b| b.iter().sum::<f64>() / length as f64)
        .collect();
    if means.len() < 8 {
        return None;
    }
    // Half the mean square of the differences is the variance of white noise, whatever the mean does.
    let variance = |x: &[f64]| {
        let squares: f64 = x.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
        0.5 * squares / (x.len() - 1) as f64
    };
    let (among, white) = (variance(&means), variance(a) / length as f64);
    (among > 10.0 * white && among.sqrt() > MOVES).then(|| {
        findings::readings_never_change(
            "the speed reads zero throughout while the accelerometer moves, so that its channel is dead",
            0.0,
            count,
            &format!(
                "; means of the acceleration over {:.2} s scatter by {:.3} m/s²",
                length as f64 * record.sample_time,
                among.sqrt()
            ),
        )
    })
}

fn still(record: &MotionRecord) -> Option<Finding> {
    let first = record.reading.iter().flatten().next()?;
    let same = record.reading.iter().flatten().all(|r| r == first);
    same.then(|| {
        findings::readings_never_change(
            "the axis stays within one increment, or the channel is dead",
            *first,
            record.reading.iter().flatten().count(),
            "",
        )
    })
}

fn missing(record: &MotionRecord) -> Option<Finding> {
    let stride = record.reading_stride();
    let mut at = (0..record.reading.len()).filter(|&k| record.reading[k].is_some());
    let first = at.next()?;
    let last = at.next_back().unwrap_or(first);
    let due = (last - first) / stride + 1;
    let got = record.reading.iter().flatten().count();
    (got < due).then(|| findings::missing_readings(due - got, due))
}

/// A slower sensor that was logged with the faster one repeats each value: n − 1 of n readings are no readings.
fn repeated(record: &MotionRecord) -> Option<Finding> {
    // A count stands as long as the axis stays in its increment.
    if record.increment.is_some() && record.source == ReadingSource::Position {
        return None;
    }
    let n = repetition(record)?;
    Some(repeated_samples("", &often(record, n)))
}

/// How often each reading stands, in words.
pub(crate) fn often(record: &MotionRecord, n: usize) -> String {
    let rate = 1.0 / record.sample_time;
    format!(
        "most readings stand {n} times in a row, at {:.4} Hz of {rate:.4} Hz",
        rate / n as f64
    )
}

/// Rows in which each value of a slower sensor stands, when nearly all that change stand equally often and more than once.
///
/// Only runs of at most 200 samples between two changes are counted; a quantised axis of varying speed has runs of
/// all lengths and gives `None`. So does one whose slowness alone makes its runs alike (see `by_rounding`).
pub fn repetition(record: &MotionRecord) -> Option<usize> {
    if record.reading.iter().any(Option::is_none) {
        return None;
    }
    let readings: Vec<f64> = record.reading.iter().flatten().copied().collect();
    // Changes that all come in step, however many steps lie between two.
    if let Some(steady) = held(&readings) {
        return Some(steady.rows);
    }
    let runs: Vec<&[f64]> = readings.chunk_by(|a, b| a == b).collect();
    // The ends are cut off anywhere.
    let inner: Vec<usize> = runs
        .get(1..runs.len().checked_sub(1)?)?
        .iter()
        .map(|run| run.len())
        .collect();
    if inner.len() < 20 {
        return None;
    }
    let mut count = [0usize; 201];
    for &run in &inner {
        count[run.min(200)] += 1;
    }
    let (n, _) = count[..200].iter().enumerate().max_by_key(|(_, c)| **c)?;
    // A clock a little off makes a run one longer or shorter now and then.
    let near = count[n - usize::from(n > 0)..=(n + 1).min(199)]
        .iter()
        .sum::<usize>();
    let alike = n > 1 && count[1] == 0 && near * 10 > inner.len() * 7;
    let changes: Vec<f64> = runs.windows(2).map(|w| w[1][0] - w[0][0]).collect();
    (alike && !by_rounding(&changes, &inner, n)).then_some(n)
}

/// Share of the changes that are one digit where rounding makes them.
const ONE_DIGIT: f64 = 0.9;
/// Longer runs from which it is told whether they are multiples, and the share of them that are.
const LONGER: usize = 20;
const MULTIPLES: f64 = 0.95;

/// Whether rounding makes the runs: a value that is read in every row and changes by less than a digit from one to the next.
///
/// Each change then is one digit, and comes when the motion has gone so far. A slower sensor changes at a steady spacing of rows, by
/// as much as the motion has gone until then; where that is a digit or less, its longer runs are multiples of the spacing. Runs at which
/// the motion turns back tell nothing: there a digit lasts up to twice as long.
fn by_rounding(changes: &[f64], runs: &[usize], n: usize) -> bool {
    let least = changes.iter().fold(f64::INFINITY, |m, c| m.min(c.abs()));
    let single = changes.iter().filter(|c| c.abs() < 1.5 * least).count();
    if (single as f64) < ONE_DIGIT * changes.len() as f64 {
        return false;
    }
    let exact = runs.iter().filter(|run| **run == n).count() as f64;
    let near = runs.iter().filter(|run| run.abs_diff(n) <= 1).count() as f64;
    let slack = usize::from(exact < MULTIPLES * near);
    let onward = runs.iter().zip(changes.windows(2));
    let longer: Vec<usize> = onward
        .filter(|(run, beside)| **run > n + 1 && beside[0] * beside[1] > 0.0)
        .map(|(run, _)| *run)
        .collect();
    let off = |run: usize| (run % n).min(n - run % n);
    let multiples = longer.iter().filter(|run| off(**run) <= slack).count() as f64;
    // Of three rows and fewer every run is one from a multiple.
    let steady = longer.len() >= LONGER
        && multiples >= MULTIPLES * longer.len() as f64
        && (slack == 0 || n > 3);
    !steady
}

/// Standard uncertainties by which a stated start may differ from that of the first readings: one in 16 000 by chance.
const BEYOND: f64 = 4.0;

/// A start that is stated to be slower or faster than it is.
fn start(record: &MotionRecord) -> Option<Finding> {
    let v0 = record.initial_velocity?;
    if record.accelerometer {
        let (found, u) = record.start_of_readings();
        let both = u.hypot(record.initial_velocity_uncertainty);
        return (u > 0.0 && (found - v0).abs() > BEYOND * both)
            .then(|| findings::start_in_motion(found, both, v0));
    }
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
    let explained = record.increment.unwrap_or(0.0) / span
        + fastest * span
        + record.initial_velocity_uncertainty;
    ((mean - v0).abs() > 3.0 * explained).then(|| findings::start_in_motion(mean, explained, v0))
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
        assert_eq!(codes(&held), ["repeated-samples"]);
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
        // A slower wheel that is dead, beside a drive and beside a standstill; a rest that was stated is none.
        let tenth = |k: usize| k.is_multiple_of(10).then_some(0.0);
        let drive = |k: usize| 2.0 * (0.005 * k as f64).sin() + 0.001 * noise(k);
        assert_eq!(codes(&record(tenth, drive)), ["readings-never-change"]);
        assert!(codes(&record(tenth, noise)).is_empty());
        assert!(codes(&record(tenth, |k| 0.001 * noise(k) + 1e-5 * k as f64)).is_empty());
        assert!(codes(&record(|k| (k < 500).then_some(0.0), drive)).is_empty());
        let gaps = record(|k| wave(k).filter(|_| k % 7 != 3), noise);
        assert_eq!(codes(&gaps), ["missing-readings"]);
        let mut moving = record(|k| Some(5.0 + wave(k).unwrap_or(0.0)), |k| 0.01 * noise(k));
        moving.initial_velocity = Some(0.0);
        assert_eq!(codes(&moving), ["start-in-motion"]);
    }
}

//! Stamped samples of one sensor before they share a time base with another: clock, gaps, stretches.

use crate::condition::often;
use crate::condition::repetition;
use crate::{HoledClock, MotionRecord, out_of_order};
use proofmass_core::numeric::upper_median;
use proofmass_uncertainty::findings::{gaps_in_record, repeated_samples};
use proofmass_uncertainty::{Finding, Severity};
use std::ops::Range;

/// Times of an even clock of this step whose rounded stamps have this mean.
pub fn even_times(stamps: &[f64], step: f64) -> Vec<f64> {
    let n = stamps.len();
    let middle = 0.5 * n.saturating_sub(1) as f64;
    let mean = stamps.iter().sum::<f64>() / n.max(1) as f64;
    (0..n).map(|k| mean + step * (k as f64 - middle)).collect()
}

/// Mean of the values at times between two; `None` where there is none.
pub fn mean_between(time: &[f64], value: &[f64], from: f64, to: f64) -> Option<f64> {
    let inside = time
        .iter()
        .zip(value)
        .filter(|(t, _)| **t >= from && **t <= to);
    let (n, sum) = inside.fold((0usize, 0.0), |(n, sum), (_, v)| (n + 1, sum + v));
    (n > 0).then(|| sum / n as f64)
}

/// The longest stretch of samples without a gap, and what is to be said about it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ungapped {
    /// Samples of the stretch.
    pub used: Range<usize>,
    /// That there are gaps.
    pub finding: Finding,
}

/// The longest stretch without a gap of three median steps and more; `None` where there is no gap.
pub fn longest_stretch(time: &[f64]) -> Option<Ungapped> {
    if out_of_order(time).is_some() {
        return None;
    }
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let limit = 3.0 * upper_median(&mut steps)?;
    let mut cuts: Vec<usize> = vec![0];
    cuts.extend((1..time.len()).filter(|&k| time[k] - time[k - 1] >= limit));
    cuts.push(time.len());
    if cuts.len() == 2 {
        return None;
    }
    let (from, to) = cuts
        .windows(2)
        .map(|w| (w[0], w[1]))
        .max_by_key(|(from, to)| to - from)?;
    Some(Ungapped {
        used: from..to,
        finding: stretch_finding(
            &format!("{} gaps of more than three steps", cuts.len() - 2),
            time,
            &(from..to),
        ),
    })
}

/// The same on a clock of which samples are missing: gaps are none where they are short enough for a record at all of its ticks.
pub fn ungapped(clock: &HoledClock, time: &[f64]) -> Option<Ungapped> {
    let used = clock.worthwhile();
    (used.len() < time.len()).then(|| Ungapped {
        finding: stretch_finding("more samples are missing than can be bridged", time, &used),
        used,
    })
}

fn stretch_finding(gaps: &str, time: &[f64], used: &Range<usize>) -> Finding {
    gaps_in_record(
        ": only the longest stretch without a gap is used",
        &format!(
            "{gaps}; used {:.3} s to {:.3} s after the start",
            time[used.start],
            time[used.end - 1]
        ),
        "choose another part of the recording",
    )
}

/// Of a slower sensor whose value stands in several rows, keeps the row in which it is new.
pub fn thin(record: &mut MotionRecord) -> Option<Finding> {
    let n = repetition(record)?;
    let runs: Vec<usize> = record
        .reading
        .chunk_by(|a, b| a == b)
        .map(<[_]>::len)
        .collect();
    let near = || runs.iter().filter(|run| run.abs_diff(n) <= 1);
    let period = near().sum::<usize>() as f64 / near().count() as f64;
    let mut from = 0;
    for run in runs {
        // A value that stays (a wheel at rest) is new again after as many rows.
        let times = (run as f64 / period).round().max(1.0);
        let mut kept = 0.0;
        for k in 0..run {
            if k as f64 >= (kept * run as f64 / times).round() && kept < times {
                kept += 1.0;
            } else {
                record.reading[from + k] = None;
            }
        }
        from += run;
    }
    Some(repeated_samples("; only the first of each is used", &often(record, n)).at(Severity::Note))
}

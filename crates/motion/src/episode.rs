//! Stretches of a record that stand out: from values per sample to episodes, and how they are told.

use serde::{Deserialize, Serialize};

/// A stretch of the record that is not one common motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// First sample.
    pub from: usize,
    /// Sample after the last.
    pub to: usize,
    /// Largest velocity change the reading has beyond the accelerometer's over one window, signed.
    pub velocity: f64,
    /// The same in standard deviations of the quiet part.
    pub deviations: f64,
}

/// Missing positions filled by straight lines, the ends held.
pub fn held(positions: &[Option<f64>]) -> Vec<f64> {
    let known: Vec<(usize, f64)> = positions
        .iter()
        .enumerate()
        .filter_map(|(k, p)| p.map(|p| (k, p)))
        .collect();
    (0..positions.len())
        .map(|k| {
            let after = known.partition_point(|&(j, _)| j < k);
            match (after.checked_sub(1).map(|i| known[i]), known.get(after)) {
                (_, Some(&(j, p))) if j == k => p,
                (Some((i, a)), Some(&(j, b))) => a + (b - a) * (k - i) as f64 / (j - i) as f64,
                (Some((_, a)), None) => a,
                (None, Some(&(_, b))) => b,
                (None, None) => 0.0,
            }
        })
        .collect()
}

/// Slope of the least-squares line.
pub fn slope(x: &[f64], dt: f64) -> f64 {
    let n = x.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let top: f64 = x
        .iter()
        .enumerate()
        .map(|(k, v)| (k as f64 - middle) * (v - x[0]))
        .sum();
    top / (n * (n * n - 1.0) / 12.0) / dt
}

/// Centre and standard deviation from the shortest interval that holds 30 % of the values.
///
/// The central 30 % of a normal distribution are 2 · 0.38532 σ wide.
pub fn quiet(values: &[f64]) -> (f64, f64) {
    shortest(values, 0.3, 0.385_320_466)
}

/// The same from another share, of which the normal distribution has this half width.
pub(crate) fn shortest(values: &[f64], share: f64, half: f64) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let h = (share * sorted.len() as f64) as usize;
    let best = (0..sorted.len() - h)
        .min_by(|&i, &j| (sorted[i + h] - sorted[i]).total_cmp(&(sorted[j + h] - sorted[j])))
        .unwrap_or(0);
    let (a, b) = (sorted[best], sorted[best + h]);
    // Identical values (a simulated standstill) have no width: then anything else stands out.
    (
        0.5 * (a + b),
        ((b - a) / (2.0 * half)).max(f64::MIN_POSITIVE),
    )
}

/// Runs of values that are out; runs closer than `merge` are one. `shift` is the sample of value zero.
pub fn episodes(
    values: &[f64],
    out: impl Fn(f64) -> bool,
    shift: usize,
    merge: usize,
    n: usize,
    size: impl Fn(f64) -> (f64, f64),
) -> Vec<Episode> {
    let mut found: Vec<Episode> = Vec::new();
    for (k, &d) in values.iter().enumerate() {
        if !out(d) {
            continue;
        }
        let (velocity, deviations) = size(d);
        let sample = k + shift;
        match found.last_mut() {
            Some(e) if sample < e.to + merge => {
                e.to = sample + 1;
                if deviations.abs() > e.deviations.abs() {
                    (e.velocity, e.deviations) = (velocity, deviations);
                }
            }
            _ => found.push(Episode {
                from: sample,
                to: (sample + 1).min(n),
                velocity,
                deviations,
            }),
        }
    }
    found
}

/// Episodes that are told one by one: all of up to five, of more only the largest.
pub fn largest(episodes: &[Episode]) -> Vec<Episode> {
    if episodes.len() <= 5 {
        return episodes.to_vec();
    }
    let size = |e: &&Episode| e.deviations.abs();
    let most = episodes.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
    most.into_iter().copied().collect()
}

/// Words after the one episode that is told of many.
pub fn others(episodes: &[Episode]) -> String {
    match episodes.len() {
        0..=5 => String::new(),
        n => format!("; the largest of {n} episodes"),
    }
}

//! Single readings and accelerations that belong to no motion: a flipped bit, a torn word.

use crate::MotionRecord;
use crate::findings;
use crate::slip::{changes, residual};
use crate::velocity::ground::margin;
use proofmass_uncertainty::Finding;

/// Values off the line between their neighbours.
struct Outliers {
    /// Which, and by how much.
    list: Vec<(usize, f64)>,
    /// Least distance that counts.
    least: f64,
}

impl Outliers {
    /// Values that lie far off the line between their neighbours while these lie on one with theirs.
    ///
    /// Off by more than six times what the neighbours are off theirs, four increments, and eight robust standard deviations of the
    /// whole record together. `even` tells whether the values around one come at even steps.
    fn of(values: &[f64], increment: f64, even: impl Fn(usize) -> bool) -> Self {
        let n = values.len();
        let off = |j: usize| values[j] - 0.5 * (values[j - 1] + values[j + 1]);
        let mut sizes: Vec<f64> = (1..n - 1).map(|j| off(j).abs()).collect();
        let middle = sizes.len() / 2;
        let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
        let spread = 1.4826 * *median;
        let least = 4.0 * increment + 8.0 * spread;
        let mut list: Vec<(usize, f64)> = Vec::new();
        for j in 4..n - 4 {
            let size = off(j).abs();
            if size <= least || list.last().is_some_and(|(last, _)| j - last < 4) {
                continue;
            }
            let around = [j - 3, j - 2, j + 2, j + 3]
                .into_iter()
                .fold(0.0f64, |m, i| m.max(off(i).abs()));
            // The neighbours must lie on one line without it, in even steps of time.
            let across = (values[j + 1] - values[j - 1]) / 2.0;
            let before = values[j - 1] - values[j - 2];
            let after = values[j + 2] - values[j + 1];
            let straight = (across - before).abs().max((across - after).abs());
            if even(j) && size > 6.0 * around + least && size > 6.0 * straight {
                list.push((j, off(j)));
            }
        }
        Self { list, least }
    }

    /// The finding, where there are any.
    fn finding(
        &self,
        (which, treatment): (&str, &str),
        all: usize,
        place: impl Fn(usize) -> usize,
    ) -> Option<Finding> {
        let &(first, _) = self.list.first()?;
        let largest = self.list.iter().fold(0.0f64, |m, d| m.max(d.1.abs()));
        Some(findings::glitches(
            which,
            treatment,
            self.list.len(),
            all,
            place(first),
            largest,
            (largest / self.least.max(f64::MIN_POSITIVE) * 8.0).min(99999.0),
        ))
    }
}

/// Fewest values among which one is told for an outlier.
const FEWEST: usize = 20;

/// Puts the line between its neighbours in the place of a single acceleration that lies far off it, where the readings do not show the
/// change of velocity that it would be. A blow of one sample is none: the axis is faster or slower behind it.
///
/// **Accuracy** none in 5·10⁵ healthy samples (`law_healthy_accelerations_are_not_wild`).
pub fn drop_wild_accelerations(record: &mut MotionRecord) -> Option<Finding> {
    let n = record.acceleration.len();
    if n < FEWEST || !record.accelerometer || record.rests_only() {
        return None;
    }
    let mut found = Outliers::of(&record.acceleration, 0.0, |_| true);
    if found.list.is_empty() {
        return None;
    }
    let mut other = record.acceleration.clone();
    for (j, _) in &found.list {
        other[*j] = 0.5 * (other[j - 1] + other[j + 1]);
    }
    let without = record.beside(other);
    let (w, dt) = (margin(record), record.sample_time);
    if n < 2 * w + 1 {
        return None;
    }
    let shown = changes(&residual(&without), w, dt);
    found.list.retain(|(j, off)| {
        let at = j.saturating_sub(w).min(shown.len() - 1);
        shown[at].abs() < 0.5 * off.abs() * dt
    });
    for (j, _) in &found.list {
        record.acceleration[*j] = without.acceleration[*j];
    }
    found.finding(
        (
            "samples of the accelerometer",
            "; the line between their neighbours stands in their place",
        ),
        n,
        |j| j,
    )
}

/// Takes single readings away that lie far off the line between their neighbours while these lie on one with theirs.
///
/// A step or a stretch of wrong readings is no glitch.
/// **Accuracy** none in 5·10⁵ healthy readings of noise, rounding, motion and stops (`law_healthy_records_have_no_glitches`).
pub fn drop_glitches(record: &mut MotionRecord) -> Option<Finding> {
    let places: Vec<usize> = (0..record.reading.len())
        .filter(|&k| record.reading[k].is_some())
        .collect();
    let values: Vec<f64> = record.reading.iter().flatten().copied().collect();
    let n = values.len();
    if n < FEWEST {
        return None;
    }
    let stride = record.reading_stride();
    let even = |j: usize| places[j + 4] - places[j - 4] == 8 * stride;
    let found = Outliers::of(&values, record.increment.unwrap_or(0.0), even);
    for (j, _) in &found.list {
        record.reading[places[*j]] = None;
    }
    found.finding(("readings", ""), n, |j| places[j])
}

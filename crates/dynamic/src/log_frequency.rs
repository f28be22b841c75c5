//! A frequency among those of a table, in whose logarithm numbers are linear from one to the next.

/// Relative difference below which two frequencies are one.
const SAME: f64 = 1e-9;

/// The point at or below a frequency, and how far it lies on the way to the next one in log f, from 0 (on the point itself) to less than 1.
/// `None` beyond the ends. The points ascend.
///
/// ```
/// use proofmass_dynamic::log_frequency::place;
/// let table = [(10.0, "a"), (40.0, "b")];
/// let (point, share) = place(&table, |p| p.0, 20.0).unwrap();
/// assert!(point == 0 && (share - 0.5).abs() < 1e-12);
/// assert_eq!(place(&table, |p| p.0, 40.0), Some((1, 0.0)));
/// assert_eq!(place(&table, |p| p.0, 41.0), None);
/// ```
pub fn place<T>(points: &[T], of: impl Fn(&T) -> f64, frequency: f64) -> Option<(usize, f64)> {
    let same = |p: &T| (of(p) / frequency - 1.0).abs() < SAME;
    if let Some(point) = points.iter().position(same) {
        return Some((point, 0.0));
    }
    let above = points.partition_point(|p| of(p) < frequency);
    let below = above.checked_sub(1)?;
    let (a, b) = (of(points.get(below)?), of(points.get(above)?));
    Some((below, (frequency / a).ln() / (b / a).ln()))
}

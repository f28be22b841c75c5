//! The smallest and the largest of some values.

/// A range with further values in it; none of no value.
pub(crate) fn widened(
    range: Option<[f64; 2]>,
    values: impl IntoIterator<Item = f64>,
) -> Option<[f64; 2]> {
    values.into_iter().fold(range, |range, v| {
        let [low, high] = range.unwrap_or([v; 2]);
        Some([low.min(v), high.max(v)])
    })
}

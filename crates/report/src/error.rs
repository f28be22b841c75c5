//! What cannot be laid out.

/// Why a report or a plot is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A point is NaN, infinite, or so large (beyond 1e300) that axis arithmetic would overflow.
    #[error("{series}: element {index} is {value:?}, which cannot be drawn")]
    NotFinite {
        /// Name of the series, table column or quantity.
        series: String,
        /// Index of the first offending element.
        index: usize,
        /// The value that came.
        value: f64,
    },
    /// A point on a logarithmic axis is zero or negative.
    #[error("{series}: element {index} is {value:?}, a logarithmic axis needs positive numbers")]
    NotPositive {
        /// Name of the series.
        series: String,
        /// Index of the first offending element.
        index: usize,
        /// The value that came.
        value: f64,
    },
    /// Two lists that belong together differ in length.
    #[error("{name} has {got} elements, {expected} are needed")]
    Length {
        /// What has the wrong length.
        name: String,
        /// Number of elements that was needed.
        expected: usize,
        /// Number of elements that came.
        got: usize,
    },
    /// A direction has no length.
    #[error("{series}: direction {index} is the zero vector")]
    NoDirection {
        /// Name of the plot.
        series: String,
        /// Index of the first offending point.
        index: usize,
    },
    /// A range is empty or reversed.
    #[error("{name}: the range {low} to {high} is empty")]
    EmptyRange {
        /// What the range belongs to.
        name: String,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
}

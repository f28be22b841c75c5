//! An error of one sign of which a limit is known, as a standard uncertainty.

/// The limit over its u. An interval of 1.96 u reaches 1.6 times as far, so that one with the noise of the estimate in it, added in squares, holds
/// a truth at the limit in 93.9 % at least.
const OVER_U: f64 = 1.2;

/// Standard uncertainty whose 95 % interval holds an error of this size.
pub(crate) fn standard_uncertainty(limit: f64) -> f64 {
    limit / OVER_U
}

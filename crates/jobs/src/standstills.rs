//! Standstills at one threshold.

use crate::trouble::{Result, Trouble};
use proofmass_static::{Samples, Segment, Standstill, WindowedVariance};

/// Those of samples with their rate and the places where time pauses, by a search at a threshold; `name` is that of the
/// recording.
///
/// # Errors
/// A threshold that is not above the noise floor; a recording too short to search.
pub(crate) fn found(
    samples: &Samples<'_>,
    (rate, breaks): (f64, &[usize]),
    (search, threshold): (&Standstill, f64),
    name: &str,
) -> Result<Vec<Segment>> {
    if !(threshold > 1.0 && threshold.is_finite()) {
        return Err(Trouble::request(format!(
            "a threshold of {threshold} times the noise floor must be larger than 1"
        )));
    }
    let windowed = WindowedVariance::new(samples, rate, breaks, search)
        .map_err(|e| Trouble::from(e).detail(name))?;
    Ok(windowed.holds(samples, threshold))
}

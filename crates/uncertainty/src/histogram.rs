//! Trials counted in bins.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Counts of equal bins, for drawing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Histogram {
    /// Lower edge of the first bin.
    pub start: f64,
    /// Width of a bin.
    pub width: f64,
    /// Trials in each bin.
    pub counts: Vec<u64>,
    /// Trials below the first and above the last bin.
    pub outside: (u64, u64),
}

impl Histogram {
    /// 100 bins over mean ± 5 u, counted by threads that take `chunk` values at a time.
    pub(crate) fn count(values: &[f64], mean: f64, u: f64, chunk: usize) -> Self {
        let bins = 100;
        let (start, width) = (mean - 5.0 * u, 10.0 * u / bins as f64);
        // Bins beyond the range of numbers are none.
        let (start, width) = match start.is_finite() && (mean + 5.0 * u).is_finite() {
            true => (start, width),
            false => (mean, 0.0),
        };
        let empty = || vec![0u64; bins + 2];
        // The first place is below all bins, the last above.
        let places = if width > 0.0 {
            let per_width = width.recip();
            values
                .par_chunks(chunk)
                .fold(empty, |mut places, chunk| {
                    for v in chunk {
                        let place = ((v - start) * per_width + 1.0).clamp(0.0, bins as f64 + 1.0);
                        places[place as usize] += 1;
                    }
                    places
                })
                .reduce(empty, |mut a, b| {
                    a.iter_mut().zip(&b).for_each(|(a, b)| *a += b);
                    a
                })
        } else {
            empty()
        };
        Self {
            start,
            width,
            counts: places[1..=bins].to_vec(),
            outside: (places[0], places[bins + 1]),
        }
    }
}

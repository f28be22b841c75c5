//! Trials counted in bins.

use serde::{Deserialize, Serialize};

/// Counts of equal bins, for drawing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// 100 bins over mean ± 5 u.
    pub(crate) fn count(values: &[f64], mean: f64, u: f64) -> Self {
        let bins = 100;
        let (start, width) = (mean - 5.0 * u, 10.0 * u / bins as f64);
        let mut counts = vec![0; bins];
        let mut outside = (0, 0);
        if width > 0.0 {
            let per_width = width.recip();
            for v in values {
                let place = (v - start) * per_width;
                if place < 0.0 {
                    outside.0 += 1;
                } else if let Some(count) = counts.get_mut(place as usize) {
                    *count += 1;
                } else {
                    outside.1 += 1;
                }
            }
        }
        Self {
            start,
            width,
            counts,
            outside,
        }
    }
}

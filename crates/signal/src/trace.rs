//! A long series reduced to what a figure can show.

use serde::{Deserialize, Serialize};

/// A series with few enough points to be filed and drawn: of every run of samples the first, the lowest, the
/// highest and the last are kept, so no peak is lost.
///
/// ```
/// use proofmass_signal::Trace;
///
/// let x: Vec<f64> = (0..100_000).map(|i| i as f64).collect();
/// let y: Vec<f64> = x.iter().map(|&x| if x == 31_415.0 { 9.0 } else { (x * 1e-3).sin() }).collect();
/// let trace = Trace::new(&x, &y, 1000);
/// assert!(trace.x.len() <= 4 * 1000);
/// assert!(trace.y.contains(&9.0));
/// ```
#[doc(alias("decimation", "downsampling"))]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Trace {
    /// Abscissae, in their order.
    pub x: Vec<f64>,
    /// Values.
    pub y: Vec<f64>,
}

impl Trace {
    /// Runs that hold a figure as wide as a page, with a reserve for a closer look.
    pub const RUNS: usize = 1200;

    /// Keeps at most four points for each of `runs` runs of samples; the shorter series ends it.
    pub fn new(x: &[f64], y: &[f64], runs: usize) -> Self {
        let n = x.len().min(y.len());
        let runs = runs.max(1);
        if n <= 4 * runs {
            return Self {
                x: x[..n].to_vec(),
                y: y[..n].to_vec(),
            };
        }
        let mut trace = Self::default();
        for run in 0..runs {
            let (start, end) = (run * n / runs, (run + 1) * n / runs);
            let (mut low, mut high) = (start, start);
            for i in start..end {
                if y[i] < y[low] {
                    low = i;
                }
                if y[i] > y[high] {
                    high = i;
                }
            }
            let mut kept = [start, low, high, end - 1];
            kept.sort_unstable();
            let mut last = None;
            for i in kept {
                if last != Some(i) {
                    trace.x.push(x[i]);
                    trace.y.push(y[i]);
                }
                last = Some(i);
            }
        }
        trace
    }
}

//! The Allan deviation over time: one curve of each of several windows.

use crate::deviation::curve_of;
use crate::steps::Steps;
use crate::{DeviationCurve, DeviationOptions, NoiseRecord, Statistic, Taus};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Fewest samples of a window.
const FEWEST: usize = 10;

/// Most windows.
const MOST: usize = 1000;

/// The curve of one window of a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DynamicWindow {
    /// First sample of the window in s, from the first of the record.
    pub from: f64,
    /// Its end in s.
    pub to: f64,
    /// Overlapping Allan deviation at octaves of the samples within.
    pub curve: DeviationCurve,
}

/// Dynamic Allan deviation: the overlapping Allan deviation of `windows` equal parts of a record, one after the other.
///
/// A sensor whose noise is the same throughout has curves that agree within their intervals; one that warms up, or is disturbed
/// for a while, has not.
///
/// **Units** as [`deviation`](crate::deviation). **Errors** as there; [`Error::TooFew`] for windows of fewer than ten samples,
/// [`Error::TooMany`] for more than a thousand. **Source** `[Galleani2009]`.
///
/// ```
/// use proofmass_noise::{DeviationOptions, dynamic_deviation};
/// // Twice as loud in the second half.
/// let y: Vec<f64> = (0..2000).map(|k| f64::from(k * 7919 % 1009) * if k < 1000 { 1.0 } else { 2.0 }).collect();
/// let windows = dynamic_deviation(&y, 10.0, 2, &DeviationOptions::default()).unwrap();
/// assert_eq!((windows[1].from, windows[1].to), (100.0, 200.0));
/// let at = |k: usize| windows[k].curve.points[0].deviation;
/// assert!((at(1) / at(0) - 2.0).abs() < 0.1);
/// ```
pub fn dynamic_deviation(
    rate: &[f64],
    sample_rate: f64,
    windows: usize,
    options: &DeviationOptions,
) -> Result<Vec<DynamicWindow>, Error> {
    windows_of(
        &[rate],
        &[0],
        sample_rate,
        windows,
        options,
        &Steps::unwatched(),
    )
}

/// [`dynamic_deviation`] of stretches that begin at `starts` on the sampling clock; a window that holds too little of them is left out.
pub(crate) fn windows_of(
    stretches: &[&[f64]],
    starts: &[usize],
    sample_rate: f64,
    windows: usize,
    options: &DeviationOptions,
    steps: &Steps<'_>,
) -> Result<Vec<DynamicWindow>, Error> {
    crate::record::check_sample_rate(sample_rate)?;
    if windows > MOST {
        return Err(Error::TooMany {
            name: "windows",
            most: MOST,
            got: windows,
        });
    }
    let begin = starts.first().copied().unwrap_or(0);
    let end = stretches
        .iter()
        .zip(starts)
        .map(|(s, start)| start + s.len())
        .max()
        .unwrap_or(begin);
    let windows = windows.max(1);
    crate::record::check_count("rate samples in a window", (end - begin) / windows, FEWEST)?;
    let options = DeviationOptions {
        taus: Taus::Octave,
        ..options.clone()
    };
    let edge = |w: usize| begin + (end - begin) * w / windows;
    let mut all = Vec::new();
    for w in 0..windows {
        let (from, to) = (edge(w), edge(w + 1));
        let parts: Vec<NoiseRecord<'_>> = stretches
            .iter()
            .zip(starts)
            .filter_map(|(stretch, &start)| {
                let first = from.clamp(start, start + stretch.len()) - start;
                let last = to.clamp(start, start + stretch.len()) - start;
                (last - first >= FEWEST).then(|| NoiseRecord::Rate(&stretch[first..last]))
            })
            .collect();
        if parts.is_empty() {
            continue;
        }
        let curve = curve_of(
            &parts,
            sample_rate,
            Statistic::OverlappingAllan,
            &options,
            None,
            steps,
        )?;
        all.push(DynamicWindow {
            from: (from - begin) as f64 / sample_rate,
            to: (to - begin) as f64 / sample_rate,
            curve,
        });
    }
    Ok(all)
}

//! A conditioner that drifts while the campaign goes on.

use super::super::adjustment::Adjustment;
use super::super::matrix::AXES;
use crate::findings;
use proofmass_uncertainty::Finding;

/// Departure in standard uncertainties from which a drift is told.
const SEEN: f64 = 4.0;
/// Least drift that is worth a word: a fifth of the usual stability of a conditioner.
const WORTH: f64 = 1e-3;

/// The gain of one output, or of all, that changes steadily in the order of the runs.
///
/// A column t m of the adjustment, t from −½ to ½ over the campaign or over the runs of each frequency, with everything
/// else projected out: β = kᵀN⁻¹r/(kᵀN⁻¹k − kᵀN⁻¹X C XᵀN⁻¹k).
pub(super) fn finding(adjustment: &Adjustment) -> Option<Finding> {
    let n = adjustment.of_row.len();
    if n < 12 {
        return None;
    }
    let over_all: Vec<f64> = (0..n).map(|i| i as f64 / (n - 1) as f64 - 0.5).collect();
    let within: Vec<f64> = (0..n)
        .map(|i| {
            let same = |k: &usize| adjustment.of_row[*k] == adjustment.of_row[i];
            let (place, count) = ((0..i).filter(same).count(), (0..n).filter(same).count());
            place as f64 / (count.max(2) - 1) as f64 - 0.5
        })
        .collect();
    let scatter = (adjustment.chi_squared / adjustment.dof().max(1) as f64).max(1.0);
    let mut largest: Option<(f64, f64, f64, &str, Option<usize>)> = None;
    for (time, over) in [(&over_all, "the campaign"), (&within, "each frequency")] {
        for channel in [None, Some(0), Some(1), Some(2)] {
            let Some((slope, variance)) = adjustment.trend(time, channel) else {
                continue;
            };
            let u = (variance * scatter).sqrt();
            if largest.is_none_or(|l| (slope / u).abs() > l.0) {
                largest = Some(((slope / u).abs(), slope, u, over, channel));
            }
        }
    }
    let (size, slope, u, over, channel) = largest?;
    (size > SEEN && slope.abs() > WORTH).then(|| {
        let what = channel.map_or("all outputs".to_owned(), |k| format!("output {}", AXES[k]));
        findings::gain_drift(&what, 100.0 * slope, over, 100.0 * u)
    })
}

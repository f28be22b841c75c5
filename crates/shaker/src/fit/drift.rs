//! A conditioner or a reference that drifts while the campaign goes on.

use super::super::adjustment::Adjustment;
use super::super::matrix::AXES;
use crate::findings;
use proofmass_uncertainty::Finding;

/// Departure in standard uncertainties from which a drift is told: eight slopes are tried, each at a level of 0.13 %, so that
/// one healthy campaign in a hundred would have one at most.
const SEEN: f64 = 3.2;
/// Least drift that is worth a word: a fifth of the usual stability of a conditioner.
const WORTH: f64 = 1e-3;
/// U = k u of 95 %.
const K: f64 = 1.96;

/// Steady change of a gain in the order of the runs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct GainDrift {
    /// The output; `None` for all of them against the reference.
    pub output: Option<usize>,
    /// Whether it begins anew at every frequency, or goes on over the whole campaign.
    pub each_frequency: bool,
    /// Change from the first run to the last, relative.
    pub value: f64,
    /// Its standard uncertainty, with the scatter of the runs where that is larger than declared.
    pub standard_uncertainty: f64,
}

impl GainDrift {
    /// Its size in standard uncertainties.
    pub fn size(&self) -> f64 {
        (self.value / self.standard_uncertainty).abs()
    }
}

/// The gain of each output, and of all, that changes steadily in the order of the runs: over the campaign, or over the runs of each
/// frequency.
///
/// A column t m of the adjustment, t from −½ to ½, with everything else projected out:
/// β = kᵀN⁻¹r/(kᵀN⁻¹k − kᵀN⁻¹X C XᵀN⁻¹k).
pub(super) fn drifts(adjustment: &Adjustment) -> Vec<GainDrift> {
    let n = adjustment.of_row.len();
    if n < 12 {
        return vec![];
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
    let mut drifts = vec![];
    for (time, each_frequency) in [(&over_all, false), (&within, true)] {
        for output in [None, Some(0), Some(1), Some(2)] {
            if let Some((value, variance)) = adjustment.trend(time, output) {
                drifts.push(GainDrift {
                    output,
                    each_frequency,
                    value,
                    standard_uncertainty: (variance * scatter).sqrt(),
                });
            }
        }
    }
    drifts
}

/// The clearest drift, where it is one.
pub(super) fn finding(drifts: &[GainDrift]) -> Option<Finding> {
    let clearest = drifts
        .iter()
        .max_by(|a, b| a.size().total_cmp(&b.size()))
        .filter(|d| d.size() > SEEN && d.value.abs() > WORTH)?;
    let what = clearest
        .output
        .map_or("all outputs".to_owned(), |k| format!("output {}", AXES[k]));
    let over = match clearest.each_frequency {
        true => "each frequency",
        false => "the campaign",
    };
    let expanded = 100.0 * K * clearest.standard_uncertainty;
    Some(findings::gain_drift(
        &what,
        100.0 * clearest.value,
        over,
        expanded,
    ))
}

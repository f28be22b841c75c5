//! Causes of an uncertainty with their shares of the variance.

use proofmass_report::BarPlot;

/// Bars of the shares, the largest first; those of one cause are added up.
pub(crate) fn shares(list: impl IntoIterator<Item = (String, f64)>) -> BarPlot {
    let mut causes: Vec<(String, f64)> = Vec::new();
    for (cause, share) in list {
        match causes.iter_mut().find(|c| c.0 == cause) {
            Some(c) => c.1 += share,
            None => causes.push((cause, share)),
        }
    }
    causes.sort_by(|a, b| b.1.total_cmp(&a.1));
    let bars = BarPlot::shares("share of the variance");
    causes
        .into_iter()
        .fold(bars, |bars, (cause, share)| bars.bar(cause, share, ""))
}

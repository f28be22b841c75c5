//! Curves of stability in figures.

use proofmass_noise::DeviationCurve;
use proofmass_report::Series;

/// The deviations above zero over averaging time, with their intervals.
pub(crate) fn stability(name: &str, curve: &DeviationCurve) -> Series {
    let points: Vec<_> = curve.points.iter().filter(|p| p.deviation > 0.0).collect();
    let tau: Vec<f64> = points.iter().map(|p| p.tau).collect();
    let value: Vec<f64> = points.iter().map(|p| p.deviation).collect();
    let interval = points
        .iter()
        .map(|p| p.interval.unwrap_or((p.deviation, p.deviation)));
    let (low, high): (Vec<f64>, Vec<f64>) = interval.unzip();
    Series::line(name, &tau, &value).bars(&low, &high)
}

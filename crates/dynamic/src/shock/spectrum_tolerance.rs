//! A required shock response spectrum and how far a measured one may depart from it.

use serde::{Deserialize, Serialize};

/// A tolerance of the maximax: a band about what is required, which most frequencies keep, and a wider one for the rest.
///
/// The default is that of MIL-STD-810, method 516: −1.5 dB to +3 dB over nine tenths of the frequencies, −3 dB to +6 dB over the
/// rest, for frequencies at equal ratios.
///
/// **Source** `[MIL-STD-810H]` method 516.8.
///
/// ```
/// use proofmass_dynamic::shock::SpectrumTolerance;
/// let required = [100.0; 20];
/// let mut measured = [110.0; 20];
/// measured[0] = 150.0;
/// measured[1] = 150.0;
/// // Two of twenty at +3.5 dB: nine tenths are within.
/// assert!(SpectrumTolerance::default().judge(&required, &measured, &[0.0; 20]).unwrap().kept);
/// measured[2] = 150.0;
/// assert!(!SpectrumTolerance::default().judge(&required, &measured, &[0.0; 20]).unwrap().kept);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SpectrumTolerance {
    /// Lower and upper limit of the band, dB.
    pub band: [f64; 2],
    /// Share of the frequencies that keep it.
    pub share: f64,
    /// Lower and upper limit for the rest, dB.
    pub rest: [f64; 2],
}

impl Default for SpectrumTolerance {
    fn default() -> Self {
        Self {
            band: [-1.5, 3.0],
            share: 0.9,
            rest: [-3.0, 6.0],
        }
    }
}

/// Whether a spectrum keeps its tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SpectrumToleranceResult {
    /// What was asked.
    pub tolerance: SpectrumTolerance,
    /// Frequencies that were compared.
    pub compared: usize,
    /// Those within the band.
    pub within: usize,
    /// Those whose expanded uncertainty (95 %) reaches over a limit of the band, on whichever side they are.
    pub close: usize,
    /// Least and greatest departure, dB.
    pub departure: [f64; 2],
    /// Enough within the band, the rest within the wider one.
    pub kept: bool,
}

impl SpectrumTolerance {
    /// Holds a measured maximax with its standard uncertainty (empty where it is not known) against what is required at the same
    /// frequencies. `None` without a frequency at which both are positive.
    pub fn judge(
        &self,
        required: &[f64],
        measured: &[f64],
        uncertainty: &[f64],
    ) -> Option<SpectrumToleranceResult> {
        let decibels = |ratio: f64| 20.0 * ratio.log10();
        let (mut within, mut beyond, mut close, mut compared) = (0, 0, 0, 0);
        let mut departure = [f64::INFINITY, f64::NEG_INFINITY];
        for (k, (r, m)) in required.iter().zip(measured).enumerate() {
            if !(*r > 0.0 && *m > 0.0 && r.is_finite() && m.is_finite()) {
                continue;
            }
            compared += 1;
            let d = decibels(m / r);
            departure = [departure[0].min(d), departure[1].max(d)];
            within += usize::from((self.band[0]..=self.band[1]).contains(&d));
            beyond += usize::from(!(self.rest[0]..=self.rest[1]).contains(&d));
            let expanded = 1.96 * uncertainty.get(k).copied().unwrap_or(0.0);
            let near = |limit: f64| (m - r * 10f64.powf(limit / 20.0)).abs() <= expanded;
            close += usize::from(expanded > 0.0 && self.band.into_iter().any(near));
        }
        (compared > 0).then_some(SpectrumToleranceResult {
            tolerance: *self,
            compared,
            within,
            close,
            departure,
            kept: beyond == 0 && within as f64 >= self.share * compared as f64 * (1.0 - 1e-12),
        })
    }
}

/// A required spectrum between its points, straight in the logarithms; `None` beyond them.
pub fn required_at(points: &[(f64, f64)], frequency: f64) -> Option<f64> {
    let k = points.partition_point(|p| p.0 <= frequency);
    match (k.checked_sub(1).and_then(|i| points.get(i)), points.get(k)) {
        (Some(a), _) if a.0 == frequency => Some(a.1),
        (Some(a), Some(b)) => {
            let t = (frequency / a.0).ln() / (b.0 / a.0).ln();
            Some(a.1 * (b.1 / a.1).powf(t))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_limits_of_the_band() {
        let tolerance = SpectrumTolerance::default();
        let judged = |ratio: f64| {
            let result = tolerance.judge(&[1.0; 10], &[ratio; 10], &[]).unwrap();
            (result.kept, result.within)
        };
        // −1.5 dB = 0.8414, +3 dB = 1.4125.
        assert_eq!(judged(0.842), (true, 10));
        assert_eq!(judged(0.841), (false, 0));
        assert_eq!(judged(1.412), (true, 10));
        assert_eq!(judged(1.413), (false, 0));
        // One of ten beyond the wider band spoils it, one within it does not.
        let mut measured = [1.0; 10];
        for (value, kept) in [(1.9, true), (2.1, false), (0.72, true), (0.70, false)] {
            measured[4] = value;
            let result = tolerance.judge(&[1.0; 10], &measured, &[]).unwrap();
            assert_eq!((result.kept, result.within), (kept, 9), "{value}");
        }
        let result = tolerance
            .judge(&[1.0; 10], &[1.4; 10], &[0.01; 10])
            .unwrap();
        assert_eq!((result.close, result.kept), (10, true));
        assert!(tolerance.judge(&[0.0], &[1.0], &[]).is_none());
    }

    #[test]
    fn known_required_spectrum_between_its_points() {
        // 9 dB to the octave would be a factor 10^{0.45} for each doubling.
        let points = [(10.0, 9.0), (100.0, 90.0), (2000.0, 90.0)];
        assert!((required_at(&points, 10f64.powf(1.5)).unwrap() - 28.46).abs() < 0.01);
        assert_eq!(required_at(&points, 500.0).map(f64::round), Some(90.0));
        assert_eq!(required_at(&points, 2000.0), Some(90.0));
        assert_eq!(required_at(&points, 10.0), Some(9.0));
        assert!(required_at(&points, 9.9).is_none() && required_at(&points, 2001.0).is_none());
    }
}

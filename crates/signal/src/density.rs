//! A one-sided power spectral density with its confidence.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// One-sided power spectral density.
///
/// **Units** for a signal in U: density in U²/Hz over 0 ≤ f ≤ rate/2, scaled so that its sum times the bin width is
/// the mean square of the (detrended, windowed) signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Density {
    /// Frequencies in Hz, from 0, evenly spaced.
    pub frequency: Vec<f64>,
    /// Density in U²/Hz.
    pub density: Vec<f64>,
    /// Equivalent degrees of freedom per bin (2 for one periodogram, 1 at zero and at the Nyquist frequency).
    pub dof: Vec<f64>,
    /// Distance between bins in Hz.
    pub bin_width: f64,
    /// Equivalent noise bandwidth of the window in Hz: what one bin collects from a broad density.
    pub noise_bandwidth: f64,
    /// Segments, or segments times tapers, that were averaged.
    pub averages: usize,
}

impl Density {
    /// Amplitude density √S in U/√Hz.
    pub fn amplitude(&self) -> Vec<f64> {
        self.density.iter().map(|s| s.sqrt()).collect()
    }

    /// Mean square over a band, Σ S Δf for low ≤ f ≤ high.
    pub fn mean_square(&self, low: f64, high: f64) -> f64 {
        self.frequency
            .iter()
            .zip(&self.density)
            .filter(|(f, _)| (low..=high).contains(*f))
            .map(|(_, s)| s * self.bin_width)
            .sum()
    }

    /// Confidence band of the density at each bin: S ν/χ²_{(1±p)/2}(ν). `None` for a probability outside (0, 1).
    ///
    /// **Assumes** a density that is flat over the noise bandwidth and a Gaussian signal.
    pub fn confidence(&self, probability: f64) -> Option<Vec<(f64, f64)>> {
        if !(probability > 0.0 && probability < 1.0) {
            return None;
        }
        let mut known: Option<(f64, (f64, f64))> = None;
        self.density
            .iter()
            .zip(&self.dof)
            .map(|(&s, &nu)| {
                // Neighbouring bins share their degrees of freedom: the quantiles are found once.
                let (low, high) = match known {
                    Some((nu_known, factors)) if nu_known == nu => factors,
                    _ => {
                        let factors = confidence_factors(nu, probability)?;
                        known = Some((nu, factors));
                        factors
                    }
                };
                Some((s * low, s * high))
            })
            .collect()
    }
}

/// Factors ν/χ²_{(1+p)/2} and ν/χ²_{(1−p)/2}.
pub(crate) fn confidence_factors(nu: f64, probability: f64) -> Option<(f64, f64)> {
    let quantile = |p: f64| {
        if nu > 1e4 {
            // Wilson and Hilferty, relative error below 1e-6 here.
            let a = 2.0 / (9.0 * nu);
            let z = proofmass_uncertainty::normal_quantile(p);
            Some(nu * (1.0 - a + z * a.sqrt()).powi(3))
        } else {
            Some(ChiSquared::new(nu).ok()?.inverse_cdf(p))
        }
    };
    Some((
        nu / quantile(0.5 * (1.0 + probability))?,
        nu / quantile(0.5 * (1.0 - probability))?,
    ))
}

//! What machine monitoring reads from a vibration.

use crate::{Density, Welch};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Figures of a vibration about its mean.
///
/// Crest factor is peak over root mean square; kurtosis the fourth moment over the square of the second, 3 for normal noise.
/// The velocity is the root of ∫ G_a/(2πf)² df over the band of ISO 20816, 10 Hz to 1 kHz for most machines.
///
/// **Units** acceleration in m/s², rate in Hz.
///
/// **Errors** [`Error::TooFew`] below 64 samples, [`Error::NotFinite`], [`Error::Constant`], [`Error::OutOfRange`] for a band
/// that does not lie between twice the line width and half the rate.
///
/// **Source** `[ISO20816-1]`.
///
/// ```
/// use proofmass_signal::Vibration;
/// // 10 m/s² at 100 Hz: 7.07 m/s², √2, 1.5, 11.25 mm/s.
/// let record: Vec<f64> = (0..40_000)
///     .map(|k| 10.0 * (std::f64::consts::TAU * 100.0 * f64::from(k) / 4000.0).sin())
///     .collect();
/// let v = Vibration::of(&record, 4000.0, [10.0, 1000.0]).unwrap();
/// assert!((v.crest_factor - 2f64.sqrt()).abs() < 1e-3 && (v.kurtosis - 1.5).abs() < 1e-6);
/// assert!((1e3 * v.velocity_rms - 11.254).abs() < 0.02);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Vibration {
    /// Root mean square of the acceleration, m/s².
    pub rms: f64,
    /// Greatest |a|, m/s².
    pub peak: f64,
    /// peak/rms.
    pub crest_factor: f64,
    /// Fourth moment over the square of the second.
    pub kurtosis: f64,
    /// Root mean square of the velocity within the band, m/s.
    pub velocity_rms: f64,
    /// Its relative standard uncertainty from the length of the record, were the vibration noise.
    pub velocity_scatter: f64,
    /// Band of the velocity, Hz.
    pub band: [f64; 2],
}

impl Vibration {
    /// Figures of a record.
    ///
    /// # Errors
    /// Those of the type.
    pub fn of(record: &[f64], rate: f64, band: [f64; 2]) -> Result<Self, Error> {
        let n = record.len();
        if n < 64 {
            return Err(Error::TooFew {
                name: "samples",
                needed: 64,
                got: n,
            });
        }
        // Lines a tenth of the lower edge apart, so that the edge is where it is said to be.
        proofmass_core::check::positive("sample rate", rate)?;
        let [low, high] = band;
        if !(low > 0.0 && high > low && high <= 0.5 * rate) {
            return Err(Error::OutOfRange {
                name: "upper edge of the band",
                value: high,
                min: low.max(0.0),
                max: 0.5 * rate,
            });
        }
        let segment = ((10.0 * rate / low) as usize).clamp(64, n);
        let density: Density = Welch::new(segment).density(record, rate)?;
        if density.bin_width > 0.5 * low {
            return Err(Error::TooFew {
                name: "samples for the lower edge of the band",
                needed: (2.0 * rate / low).ceil() as usize,
                got: n,
            });
        }
        let mean = record.iter().sum::<f64>() / n as f64;
        let (mut second, mut fourth, mut peak) = (0.0, 0.0, 0.0f64);
        for a in record {
            let d = (a - mean) * (a - mean);
            second += d;
            fourth += d * d;
            peak = peak.max(d);
        }
        let variance = second / n as f64;
        if !(variance > 0.0) {
            return Err(Error::Constant {
                name: "record",
                value: record[0],
            });
        }
        let (mut square, mut scatter) = (0.0f64, 0.0f64);
        for (k, f) in density.frequency.iter().enumerate() {
            // What of the line's width lies within the band; the mean of 1/f² from a to b is 1/(ab).
            let half = 0.5 * density.bin_width;
            let (a, b) = ((f - half).max(low), (f + half).min(high));
            if b > a {
                let v = density.density[k] * (b - a) / (TAU * TAU * a * b);
                square += v;
                // Neighbours under a Hann window share: the noise bandwidth counts, squared in the covariance (35/18).
                scatter += 35.0 / 18.0 * v * v * 2.0 / density.dof[k];
            }
        }
        Ok(Self {
            rms: variance.sqrt(),
            peak: peak.sqrt(),
            crest_factor: (peak / variance).sqrt(),
            kurtosis: fourth / n as f64 / (variance * variance),
            velocity_rms: square.sqrt(),
            velocity_scatter: if square > 0.0 {
                0.5 * scatter.sqrt() / square
            } else {
                0.0
            },
            band,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn coverage_velocity_of_white_acceleration() {
        // One-sided density 2/f_s: ∫ G/(2πf)² df = G/(4π²)(1/f₁ − 1/f₂).
        let rate = 1000.0;
        let truth = (2.0 / rate / (TAU * TAU) * (0.1 - 1.0 / 400.0)).sqrt();
        let inside = (0..200)
            .filter(|seed| {
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(*seed);
                let record: Vec<f64> = (0..50_000)
                    .map(|_| StandardNormal.sample(&mut rng))
                    .collect();
                let v = Vibration::of(&record, rate, [10.0, 400.0]).unwrap();
                (v.velocity_rms / truth - 1.0).abs() < 1.96 * v.velocity_scatter
            })
            .count();
        // 95 % of 200 at 0.1 %: 179 to 199.
        assert!((179..=199).contains(&inside), "{inside}");
    }

    #[test]
    fn refuses_bands_it_cannot_see() {
        let record: Vec<f64> = (0..1000).map(|k| f64::from(k % 7)).collect();
        assert!(Vibration::of(&record, 1000.0, [10.0, 600.0]).is_err());
        assert!(Vibration::of(&record, 1000.0, [0.5, 100.0]).is_err());
        assert!(Vibration::of(&[1.0; 1000], 1000.0, [10.0, 100.0]).is_err());
        assert!(Vibration::of(&record[..10], 1000.0, [10.0, 100.0]).is_err());
    }
}

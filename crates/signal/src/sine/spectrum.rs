//! Where the strongest line of a record lies: a start for the fit, and a check of what a table claims.

use proofmass_core::Error;
use realfft::RealFftPlanner;
use std::f64::consts::TAU;

/// Frequency in Hz of the strongest line of a record, apart from its mean.
///
/// Hann window, largest bin k, and the exact interpolation of that window between the two largest bins:
/// δ = (2r − 1)/(r + 1) with r the ratio of the larger neighbour to the peak.
///
/// **Accuracy** a few hundredths of a bin for a lone sine; no uncertainty is claimed.
///
/// **Source** `[Grandke1983]`.
///
/// # Errors
/// [`Error::TooFew`] below 16 samples, [`Error::NotFinite`] for a NaN.
///
/// ```
/// use proofmass_signal::sine::dominant_frequency;
/// let x: Vec<f64> = (0..4096).map(|n| (0.3 * n as f64).sin() + 5.0).collect();
/// let f = dominant_frequency(1000.0, &x).unwrap();
/// assert!((f - 0.3 * 1000.0 / std::f64::consts::TAU).abs() < 0.01);
/// ```
pub fn dominant_frequency(sampling_frequency: f64, x: &[f64]) -> Result<f64, Error> {
    let n = x.len();
    if n < 16 {
        return Err(Error::TooFew {
            name: "samples",
            needed: 16,
            got: n,
        });
    }
    if let Some(index) = x.iter().position(|v| !v.is_finite()) {
        return Err(Error::NotFinite {
            name: "samples",
            index,
        });
    }
    let mean = x.iter().sum::<f64>() / n as f64;
    let mut windowed: Vec<f64> = x
        .iter()
        .enumerate()
        .map(|(i, v)| (v - mean) * (0.5 - 0.5 * (TAU * i as f64 / n as f64).cos()))
        .collect();
    let transform = RealFftPlanner::new().plan_fft_forward(n);
    let mut spectrum = transform.make_output_vec();
    transform
        .process(&mut windowed, &mut spectrum)
        .map_err(|_| Error::Length {
            name: "samples",
            expected: n,
            got: n,
        })?;
    let modulus: Vec<f64> = spectrum.iter().map(|z| z.norm()).collect();
    let last = modulus.len() - 1;
    let k = (1..last)
        .max_by(|&a, &b| modulus[a].total_cmp(&modulus[b]))
        .unwrap_or(1);
    let (side, neighbour) = if modulus[k + 1] > modulus[k - 1] {
        (1.0, modulus[k + 1])
    } else {
        (-1.0, modulus[k - 1])
    };
    let ratio = if modulus[k] > 0.0 {
        neighbour / modulus[k]
    } else {
        0.0
    };
    let delta = ((2.0 * ratio - 1.0) / (ratio + 1.0)).clamp(0.0, 0.5);
    Ok((k as f64 + side * delta) * sampling_frequency / n as f64)
}

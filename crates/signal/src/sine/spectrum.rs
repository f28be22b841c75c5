//! Where the strongest line of a record lies: a start for the fit, and a check of what a table claims.

use crate::Window;
use crate::fourier::forward_owned;
use proofmass_core::Error;

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
    proofmass_core::check::finite("samples", x)?;
    let mean = x.iter().sum::<f64>() / n as f64;
    let window = Window::Hann.weights(n);
    let windowed = x.iter().zip(window).map(|(v, w)| (v - mean) * w);
    let spectrum = forward_owned(windowed.collect());
    let last = spectrum.len() - 1;
    let power = |k: usize| spectrum[k].norm_sqr();
    let k = (1..last)
        .max_by(|&a, &b| power(a).total_cmp(&power(b)))
        .unwrap_or(1);
    let modulus = |k: usize| spectrum[k].norm();
    let (side, neighbour) = if modulus(k + 1) > modulus(k - 1) {
        (1.0, modulus(k + 1))
    } else {
        (-1.0, modulus(k - 1))
    };
    let ratio = if modulus(k) > 0.0 {
        neighbour / modulus(k)
    } else {
        0.0
    };
    let delta = ((2.0 * ratio - 1.0) / (ratio + 1.0)).clamp(0.0, 0.5);
    Ok((k as f64 + side * delta) * sampling_frequency / n as f64)
}

//! Welch's density: averaged periodograms of overlapping windowed segments.

use crate::power_sum::{PowerSum, Segments, mean};
use crate::{Density, Detrend, Window, window::equivalent_noise_bandwidth};
use proofmass_core::Error;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How a signal is cut and windowed.
#[doc(alias("PSD", "power spectral density"))]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Welch {
    /// Samples per segment.
    pub segment: usize,
    /// Samples shared by neighbouring segments.
    pub overlap: usize,
    /// Window.
    pub window: Window,
    /// Trend removed from every segment.
    pub detrend: Detrend,
}

impl Welch {
    /// Segments of this length with half overlap, Hann window, mean removed.
    pub fn new(segment: usize) -> Self {
        Self {
            segment,
            overlap: segment / 2,
            window: Window::Hann,
            detrend: Detrend::Constant,
        }
    }

    /// One-sided density of an evenly sampled signal.
    ///
    /// S(f_k) = 2/(rate Σw²) · mean over segments of |Σ_n w_n x_n e^{−2πikn/L}|², without the 2 at zero and at the
    /// Nyquist frequency.
    ///
    /// **Units** signal in U, rate in Hz, density in U²/Hz.
    ///
    /// **Confidence** ν = 2K/(1 + 2 Σ_j (1 − j/K) ρ_j), ρ_j = (Σ w_n w_{n+jD}/Σ w²)² for segments D apart; half of
    /// it at zero and at the Nyquist frequency.
    ///
    /// **Errors** [`Error::NotFinite`], [`Error::TooFew`] when there is no whole segment, [`Error::OutOfRange`] for
    /// segments below 4 samples or an overlap that is not smaller than the segment.
    ///
    /// **Accuracy** 1e-13 relative to SciPy (`crosscheck_scipy_welch`).
    ///
    /// **Source** `[Welch1967]`, `[Percival1993] 6.17`.
    ///
    /// ```
    /// use proofmass_signal::Welch;
    /// // A sinusoid of amplitude 2 holds the mean square 2.
    /// let signal: Vec<f64> = (0..4096).map(|k| 2.0 * (0.3 * f64::from(k)).sin()).collect();
    /// let density = Welch::new(512).density(&signal, 100.0).unwrap();
    /// assert!((density.mean_square(0.0, 50.0) - 2.0).abs() < 0.01);
    /// ```
    pub fn density(&self, signal: &[f64], rate: f64) -> Result<Density, Error> {
        let l = self.segment;
        check_shape(signal, rate, l)?;
        let (weights, step, count) = self.segments(signal.len())?;
        let powers = segment_powers(signal, &weights, step, count, self.detrend, rate);
        // What is not finite in any segment shows in the power at zero: no reading of its own looks for it.
        let read = (count - 1) * step + l;
        if !powers[0].is_finite() || signal[read..].iter().any(|v| !v.is_finite()) {
            proofmass_core::check::finite("signal", signal)?;
        }
        let squares: f64 = weights.iter().map(|w| w * w).sum();
        let nu = degrees_of_freedom(&weights, step, count);
        Ok(one_sided(
            powers,
            l,
            rate,
            1.0 / (squares * count as f64),
            nu,
            equivalent_noise_bandwidth(&weights),
            count,
        ))
    }
}

impl Welch {
    /// Weights of a segment, samples from one to the next, and how many there are in a record that holds one.
    pub(crate) fn segments(&self, samples: usize) -> Result<(Vec<f64>, usize, usize), Error> {
        let l = self.segment;
        if self.overlap >= l {
            return Err(Error::OutOfRange {
                name: "overlap",
                value: self.overlap as f64,
                min: 0.0,
                max: l as f64 - 1.0,
            });
        }
        let step = l - self.overlap;
        Ok((self.window.weights(l), step, (samples - l) / step + 1))
    }
}

/// A signal of finite samples that holds a segment.
pub(crate) fn check(signal: &[f64], rate: f64, segment: usize) -> Result<(), Error> {
    check_shape(signal, rate, segment)?;
    proofmass_core::check::finite("signal", signal)
}

fn check_shape(signal: &[f64], rate: f64, segment: usize) -> Result<(), Error> {
    proofmass_core::check::positive("sample rate", rate)?;
    if segment < 4 {
        return Err(Error::OutOfRange {
            name: "segment",
            value: segment as f64,
            min: 4.0,
            max: signal.len() as f64,
        });
    }
    if signal.len() < segment {
        return Err(Error::TooFew {
            name: "samples",
            needed: segment,
            got: signal.len(),
        });
    }
    Ok(())
}

/// Segments handled by one task; fixed, so that the order of summation does not depend on the threads.
const BATCH: usize = 64;

/// Σ over segments of |DFT of the windowed, detrended segment|².
pub(crate) fn segment_powers(
    signal: &[f64],
    weights: &[f64],
    step: usize,
    count: usize,
    detrend: Detrend,
    rate: f64,
) -> Vec<f64> {
    let l = weights.len();
    if count == 1 {
        // Alone, half a transform serves: it may be a whole record.
        let mut segment = vec![0.0; l];
        window_segment(&signal[..l], weights, detrend, rate, &mut segment);
        let spectrum = crate::fourier::forward_owned(segment);
        return spectrum.iter().map(|x| x.norm_sqr()).collect();
    }
    let segments = Segments {
        signal,
        weights,
        step,
        detrend,
        rate,
    };
    let fft = rustfft::FftPlanner::new().plan_fft_forward(l);
    let partial: Vec<Vec<f64>> = (0..count.div_ceil(BATCH))
        .into_par_iter()
        .map_init(
            || PowerSum::new(&fft),
            |sum, batch| {
                sum.add(&segments, batch * BATCH..((batch + 1) * BATCH).min(count));
                sum.take()
            },
        )
        .collect();
    let mut sums = vec![0.0; l / 2 + 1];
    for part in &partial {
        for (sum, value) in sums.iter_mut().zip(part) {
            *sum += value;
        }
    }
    sums
}

/// Writes the part without its trend, times the weights.
pub(crate) fn window_segment(
    part: &[f64],
    weights: &[f64],
    detrend: Detrend,
    rate: f64,
    out: &mut [f64],
) {
    let mean = match detrend {
        Detrend::None => 0.0,
        Detrend::Constant => mean(part),
        _ => {
            out.copy_from_slice(part);
            detrend.subtract(out, rate);
            out.iter_mut().zip(weights).for_each(|(o, w)| *o *= w);
            return;
        }
    };
    for ((o, v), w) in out.iter_mut().zip(part).zip(weights) {
        *o = (v - mean) * w;
    }
}

/// Equivalent degrees of freedom of the average of overlapping segments of white noise.
pub(crate) fn degrees_of_freedom(weights: &[f64], step: usize, count: usize) -> f64 {
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let k = count as f64;
    let mut sum = 1.0;
    for (j, shift) in (step..weights.len()).step_by(step).enumerate() {
        let lag = (j + 1) as f64;
        if lag >= k {
            break;
        }
        let shared: f64 = weights
            .iter()
            .zip(&weights[shift..])
            .map(|(a, b)| a * b)
            .sum();
        sum += 2.0 * (1.0 - lag / k) * (shared / squares).powi(2);
    }
    2.0 * k / sum
}

/// Powers of the non-negative bins to a one-sided density.
pub(crate) fn one_sided(
    mut powers: Vec<f64>,
    l: usize,
    rate: f64,
    scale: f64,
    nu: f64,
    noise_bins: f64,
    averages: usize,
) -> Density {
    let bin_width = rate / l as f64;
    let mut dof = vec![nu; powers.len()];
    for (k, power) in powers.iter_mut().enumerate() {
        let own_mirror = k == 0 || 2 * k == l;
        *power *= scale / rate * if own_mirror { 1.0 } else { 2.0 };
        if own_mirror {
            dof[k] = 0.5 * nu;
        }
    }
    Density {
        frequency: (0..powers.len()).map(|k| k as f64 * bin_width).collect(),
        density: powers,
        dof,
        bin_width,
        noise_bandwidth: noise_bins * bin_width,
        averages,
    }
}

//! Sums over segments of the squared magnitudes of their transforms.

use crate::Detrend;
use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};
use rustfft::Fft;
use std::sync::Arc;

/// Windowed segments of a signal.
pub(crate) struct Segments<'a> {
    pub(crate) signal: &'a [f64],
    pub(crate) weights: &'a [f64],
    /// Samples from one to the next.
    pub(crate) step: usize,
    pub(crate) detrend: Detrend,
    /// Sample rate in Hz.
    pub(crate) rate: f64,
}

/// Σ |X_k|² over segments, with what their transforms need to work in.
///
/// Two segments a and b go through one complex transform, as z = a + ib. Of its magnitudes only
/// |Z_k|² + |Z_{N−k}|² = 2 |A_k|² + 2 |B_k|² is needed: the two need not be told apart.
pub(crate) struct PowerSum {
    fft: Arc<dyn Fft<f64>>,
    /// Σ |Z_k|² for 0 ≤ k < N.
    sums: Vec<f64>,
    without_trend: [Vec<f64>; 2],
    packed: Vec<Complex64>,
    spectrum: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl PowerSum {
    pub(crate) fn new(fft: &Arc<dyn Fft<f64>>) -> Self {
        let samples = fft.len();
        let zeros = |count| vec![Complex64::default(); count];
        Self {
            sums: vec![0.0; samples],
            without_trend: [vec![0.0; samples], vec![0.0; samples]],
            packed: zeros(samples),
            spectrum: zeros(samples),
            scratch: zeros(fft.get_outofplace_scratch_len()),
            fft: fft.clone(),
        }
    }

    /// Adds the segments of these numbers.
    pub(crate) fn add(&mut self, segments: &Segments<'_>, numbers: std::ops::Range<usize>) {
        for first in numbers.clone().step_by(2) {
            let second = Some(first + 1).filter(|k| *k < numbers.end);
            self.pack(segments, first, second);
            self.fft.process_outofplace_with_scratch(
                &mut self.packed,
                &mut self.spectrum,
                &mut self.scratch,
            );
            Arch::new().dispatch(AddSquares {
                sums: &mut self.sums,
                spectrum: &self.spectrum,
            });
        }
    }

    /// Writes a segment as the real and another, or zeros, as the imaginary parts.
    fn pack(&mut self, segments: &Segments<'_>, first: usize, second: Option<usize>) {
        let part = |k: usize| &segments.signal[k * segments.step..][..self.packed.len()];
        let [a, b] = &mut self.without_trend;
        let mut means = [0.0; 2];
        let (real, imaginary): (&[f64], &[f64]) = match segments.detrend {
            Detrend::None | Detrend::Constant => {
                if second.is_none() {
                    b.fill(0.0);
                }
                let parts = (part(first), second.map_or(&b[..], part));
                if segments.detrend == Detrend::Constant {
                    means = [mean(parts.0), mean(parts.1)];
                }
                parts
            }
            trend => {
                a.copy_from_slice(part(first));
                trend.subtract(a, segments.rate);
                match second {
                    Some(second) => {
                        b.copy_from_slice(part(second));
                        trend.subtract(b, segments.rate);
                    }
                    None => b.fill(0.0),
                }
                (a, b)
            }
        };
        Arch::new().dispatch(Pack {
            real,
            imaginary,
            means,
            weights: segments.weights,
            packed: &mut self.packed,
        });
    }

    /// Σ |X_k|² for 0 ≤ k ≤ N/2 since the last time.
    pub(crate) fn take(&mut self) -> Vec<f64> {
        let n = self.sums.len();
        let powers = (0..=n / 2)
            .map(|k| 0.5 * (self.sums[k] + self.sums[(n - k) % n]))
            .collect();
        self.sums.fill(0.0);
        powers
    }
}

/// The mean of samples, from sums side by side: one running sum would wait for every addition.
pub(crate) fn mean(samples: &[f64]) -> f64 {
    Arch::new().dispatch(Mean(samples))
}

struct Mean<'a>(&'a [f64]);

impl WithSimd for Mean<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let (chunks, rest) = self.0.as_chunks::<32>();
        let mut sums = [0.0; 32];
        for chunk in chunks {
            for (sum, v) in sums.iter_mut().zip(chunk) {
                *sum += v;
            }
        }
        (sums.iter().sum::<f64>() + rest.iter().sum::<f64>()) / self.0.len() as f64
    }
}

/// Samples less their mean, times the weights.
struct Pack<'a> {
    real: &'a [f64],
    imaginary: &'a [f64],
    means: [f64; 2],
    weights: &'a [f64],
    packed: &'a mut [Complex64],
}

impl WithSimd for Pack<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [a, b] = self.means;
        for (((z, x), y), w) in self
            .packed
            .iter_mut()
            .zip(self.real)
            .zip(self.imaginary)
            .zip(self.weights)
        {
            *z = Complex64::new((x - a) * w, (y - b) * w);
        }
    }
}

struct AddSquares<'a> {
    sums: &'a mut [f64],
    spectrum: &'a [Complex64],
}

impl WithSimd for AddSquares<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (sum, z) in self.sums.iter_mut().zip(self.spectrum) {
            *sum += z.re * z.re + z.im * z.im;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Even and odd lengths, an even and an odd number of segments: the squares of the plain transform.
    #[test]
    fn law_powers_are_those_of_the_transform() {
        for samples in [4_usize, 7, 30, 64] {
            for count in [1, 2, 5] {
                let signal: Vec<f64> = (0..count * samples)
                    .map(|n| (n as f64 * 0.7).sin() + 1e-3 * (n * n % 17) as f64)
                    .collect();
                let weights: Vec<f64> = (0..samples).map(|n| 1.0 + n as f64).collect();
                let segments = Segments {
                    signal: &signal,
                    weights: &weights,
                    step: samples,
                    detrend: Detrend::None,
                    rate: 1.0,
                };
                let mut sum = PowerSum::new(&rustfft::FftPlanner::new().plan_fft_forward(samples));
                sum.add(&segments, 0..count);
                for (k, found) in sum.take().into_iter().enumerate() {
                    let power = |segment: &[f64]| {
                        (0..samples)
                            .map(|n| {
                                let turns = (k * n % samples) as f64 / samples as f64;
                                weights[n] * segment[n] * Complex64::cis(-TAU * turns)
                            })
                            .sum::<Complex64>()
                            .norm_sqr()
                    };
                    let expected: f64 = signal.chunks(samples).map(power).sum();
                    // Rounding of a sum of that many terms of that size.
                    let scale = count as f64 * (samples as f64).powi(4);
                    assert!(
                        (found - expected).abs() < 1e-15 * scale,
                        "{samples}, {count}, {k}: {found}, {expected}"
                    );
                }
            }
        }
    }
}

//! The multitaper spectrum of a whole record, in which lines are sought.

use crate::NoiseModel;
use proofmass_signal::fourier;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Gamma};

/// Sine tapers averaged per frequency.
const TAPERS: usize = 3;

/// Neighbours on either side that a line must stand out of.
const BESIDE: usize = 40;

/// Multitaper spectrum at the Fourier frequencies, and its averages over bins of growing width.
pub(crate) struct SpectrumBins {
    /// Multitaper density at k/T.
    pub(crate) density: Vec<f64>,
    /// Samples.
    pub(crate) n: usize,
    /// Samples per second.
    pub(crate) sample_rate: f64,
    /// The bins, lowest frequency first.
    pub(crate) bins: Vec<Bin>,
}

/// Fourier indices whose density is compared with its own median.
pub(crate) struct Bin {
    /// First and one past the last Fourier index.
    pub(crate) range: (usize, usize),
}

impl SpectrumBins {
    /// From a record freed from its straight line, in place of which nothing below three cycles per record is used.
    ///
    /// With the record padded to twice its length the k-th sine taper's spectrum at f is
    /// |X(f + k/2T) − X(f − k/2T)|²/(2N): one transform serves all tapers. **Source** `[Riedel1995]`.
    pub(crate) fn new(detrended: Vec<f64>, sample_rate: f64) -> Self {
        let n = detrended.len();
        let mut padded = detrended;
        padded.resize(2 * n, 0.0);
        let x = fourier::forward_owned(padded);
        let scale = 2.0 / (2.0 * n as f64 * sample_rate * TAPERS as f64);
        let half = n / 2;
        let density: Vec<f64> = (0..half + 1)
            .into_par_iter()
            .with_min_len(4096)
            .map(|j| {
                if j < TAPERS || 2 * j + TAPERS > n {
                    return 0.0;
                }
                (1..=TAPERS)
                    .map(|k| (x[2 * j + k] - x[2 * j - k]).norm_sqr())
                    .sum::<f64>()
                    * scale
            })
            .collect();
        let last = half - TAPERS.min(half);
        let mut bins = Vec::new();
        let mut start = TAPERS;
        while start < last {
            // Bins narrower than the tapers' bandwidth would repeat one another.
            let width = (TAPERS + 1).max(start / 10);
            let mut end = (start + width).min(last);
            if last - end < width / 2 {
                end = last;
            }
            bins.push(Bin {
                range: (start, end),
            });
            start = end;
        }
        Self {
            density,
            n,
            sample_rate,
            bins,
        }
    }

    /// Typical density of the [`BESIDE`] neighbours on either side of a Fourier index, as far as there are so many, without what a line
    /// there spoils.
    fn beside(&self, k: usize) -> f64 {
        let spoilt = 2 * (TAPERS + 1);
        let first = k.saturating_sub(BESIDE).max(TAPERS);
        let last = (k + BESIDE).min(self.density.len() - 1 - TAPERS);
        let below = self.density.get(first..(k + 1).saturating_sub(spoilt));
        let above = self.density.get(k + spoilt..=last);
        let mut near = [below.unwrap_or_default(), above.unwrap_or_default()].concat();
        near.sort_by(f64::total_cmp);
        near.get(near.len() / 2).map_or(0.0, |v| v / 0.891)
    }

    pub(crate) fn frequency(&self, index: f64) -> f64 {
        index * self.sample_rate / self.n as f64
    }

    /// Fourier indices of lines: maxima of density over model that chance exceeds with `false_alarm_rate` in the
    /// whole spectrum. At most eight, strongest first.
    pub(crate) fn lines(&self, model: &NoiseModel, false_alarm_rate: f64) -> Vec<usize> {
        let shape = TAPERS as f64;
        let Ok(gamma) = Gamma::new(shape, shape) else {
            return Vec::new();
        };
        let threshold = gamma.inverse_cdf(1.0 - false_alarm_rate / self.density.len() as f64);
        let mut above: Vec<(usize, f64)> = Vec::new();
        for bin in &self.bins {
            // A line in a bin must also stand out from its own neighbourhood, where the model may be wrong.
            let mut sorted: Vec<f64> = self.density[bin.range.0..bin.range.1].to_vec();
            sorted.sort_by(f64::total_cmp);
            // The median of a gamma of shape 3 lies at 0.891 of its mean.
            let median = sorted[sorted.len() / 2] / 0.891;
            for k in bin.range.0..bin.range.1 {
                let expected = model.density(self.frequency(k as f64), self.sample_rate);
                let local = if sorted.len() >= 32 {
                    median.max(expected)
                } else {
                    expected
                };
                let ratio = self.density[k] / local;
                // Within a resonance narrower than the bin the neighbours are as high.
                if ratio > threshold && self.density[k] > threshold * self.beside(k) {
                    above.push((k, ratio));
                }
            }
        }
        above.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut lines: Vec<usize> = Vec::new();
        for (k, _) in above {
            if lines.len() < 8 && lines.iter().all(|l| l.abs_diff(k) > 2 * (TAPERS + 1)) {
                lines.push(k);
            }
        }
        lines
    }
}

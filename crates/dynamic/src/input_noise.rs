//! Noise that may be on the input of a frequency response: by how much H₁ may be too small where nobody knows.

use crate::limit;
use proofmass_signal::transfer::CrossSpectra;

/// Lines over which a density of noise is averaged.
const WIDE: usize = 16;
/// Standard deviations of that average by which the noise may be larger.
const MARGIN: f64 = 2.0;
/// Largest share, by lines, by which noise on the input may make the modulus by H₁ too small.
///
/// What the coherence leaves is noise of the output or of the input: E Ĥ₁ = H/(1 + N/X) with noise N beside the input X, and
/// N ≤ (1 − γ²) Gxx at every line; H₂ is what all of it would make. The line where that is least limits the noise at all others, as far as
/// its density is known to be even, or to fall with frequency no faster than 1/f.
///
/// **Assumes** that the noise of the input is white or that of flicker: not hum, and not that of a differentiated signal, which rises.
///
/// **Accuracy** `coverage_noise_on_the_input` of proofmass-jobs.
///
/// **Source** `[BendatPiersol2010] 6.1, 9.2`.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct InputNoise {
    /// Hz, rising.
    pub frequency: Vec<f64>,
    /// Noise over signal at the input, at most.
    pub share: Vec<f64>,
}

impl InputNoise {
    /// What the spectra of one output allow from a lowest frequency on.
    pub fn allowed(spectra: &CrossSpectra, output: usize, lowest: f64) -> Self {
        let Some(channel) = spectra.outputs.get(output) else {
            return Self::default();
        };
        let k = spectra.independent;
        // (frequency, input, noise if all of what is not coherent is on the input).
        let lines: Vec<(f64, f64, f64)> = (0..spectra.frequency.len())
            .filter(|i| spectra.frequency[*i] >= lowest && spectra.frequency[*i] > 0.0)
            .filter_map(|i| {
                let (x, y) = (spectra.input[i], channel.auto[i]);
                let coherent = channel.cross[i].norm_sqr() / (x * y);
                let left = (1.0 - coherent).max(0.0) * k / (k - 1.0);
                (x > 0.0 && y > 0.0).then(|| (spectra.frequency[i], x, left.min(1.0) * x))
            })
            .collect();
        // Windows join neighbours: half as many are independent.
        let blocks: Vec<(f64, f64)> = lines
            .chunks(WIDE)
            .map(|some| {
                let n = some.len() as f64;
                let mean = some.iter().map(|l| l.2).sum::<f64>() / n;
                let margin = 1.0 + MARGIN / (0.5 * n * (k - 1.0)).sqrt();
                (some[0].0, mean * margin)
            })
            .collect();
        let share = |&(f, x, _): &(f64, f64, f64)| {
            let limits = blocks.iter().map(|(at, noise)| noise * (at / f).max(1.0));
            let noise = limits.fold(f64::INFINITY, f64::min);
            // Of an input that is nothing but noise nothing is known.
            noise / (x - noise).max(1e-3 * x)
        };
        Self {
            share: lines.iter().map(share).collect(),
            frequency: lines.iter().map(|l| l.0).collect(),
        }
    }

    /// The share at the nearest line; zero without lines.
    pub fn at(&self, frequency: f64) -> f64 {
        let above = self.frequency.partition_point(|f| *f < frequency);
        let near = [above.checked_sub(1), Some(above)];
        let near = near.into_iter().flatten().filter(|k| *k < self.share.len());
        let apart = |k: &usize| (self.frequency[*k] - frequency).abs();
        near.min_by(|a, b| apart(a).total_cmp(&apart(b)))
            .map_or(0.0, |k| self.share[k])
    }

    /// Relative standard uncertainty whose 95 % interval holds the larger response: the error is of one sign, and its limit is what is
    /// known.
    pub fn standard_uncertainty(&self, frequency: f64) -> f64 {
        limit::standard_uncertainty(self.at(frequency))
    }
}

//! A filter that undoes K over the whole calibrated range.

use super::FrequencyResponse;
use super::compensation_error::{CompensationError, Judge};
use super::complex_matrix::regularised_inverse;
use num_complex::Complex64;
use proofmass_core::{Error, Watch};
use proofmass_signal::fourier;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// What to do with frequencies that were never calibrated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Beyond {
    /// They are filtered out: gain zero from an octave below the lowest and an octave above the highest frequency.
    #[default]
    Reject,
    /// K is taken as that of the nearest calibrated frequency, down to zero and nearly up to half the sampling rate; no
    /// error is stated there.
    Hold,
}

/// How a compensation filter is to be designed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct FilterDesign {
    /// Lowest and highest frequency to be compensated, Hz; all that was calibrated and can be sampled when `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<[f64; 2]>,
    /// What to do beyond the band.
    pub beyond: Beyond,
    /// Largest departure from the inverse of K at which the filter is long enough, relative.
    pub tolerance: f64,
    /// Longest filter that is tried, samples.
    pub longest: usize,
}

impl Default for FilterDesign {
    fn default() -> Self {
        Self {
            band: None,
            beyond: Beyond::Reject,
            tolerance: 1e-3,
            longest: (1 << 16) + 1,
        }
    }
}

/// A filter with finite impulse response for every pair of axis and output: `a_i[n] = Σ_o Σ_m h_io[m] õ_o[n − m]`.
///
/// Its spectrum approximates (KᴴK + λ²)⁻¹ Kᴴ, delayed by half its length, with λ a tenth of the root mean square
/// of the uncertainties of the elements: where K sinks below that, nothing is amplified further.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CompensationFilter {
    /// Sampling rate it was made for, Hz.
    pub rate: f64,
    /// Impulse responses, axes × outputs row by row, all of one odd length.
    pub taps: Vec<Vec<f64>>,
    /// Samples by which the filtered signal comes late: half the length. The delay of the sensor is taken out.
    pub half: usize,
    /// Whether the departure is within the tolerance that was asked for.
    pub within_tolerance: bool,
    /// What the filter states about itself once the half length is taken out of the time.
    pub error: CompensationError,
}

/// Highest frequency that is compensated, in units of the sampling rate.
const HIGHEST: f64 = 0.45;
/// Longest filters that may be asked for, samples.
const LIMITS_OF_LONGEST: std::ops::RangeInclusive<usize> = 65..=(1 << 20) + 1;

impl FrequencyResponse {
    /// A filter that undoes this response for signals of a sampling rate in Hz, as long as its tolerance needs.
    ///
    /// **Accuracy** the departure is computed from the finished taps at eight frequencies per resolution of the filter;
    /// `coverage_of_the_stated_error_of_a_filter`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a rate at which nothing of the calibrated range can be sampled, or a band beyond
    /// it; [`Error::Length`] unless there are as many outputs as axes (one to three); [`Error::Singular`] where K has
    /// no inverse; [`Error::Cancelled`].
    pub fn compensation_filter(
        &self,
        rate: f64,
        design: &FilterDesign,
        watch: &dyn Watch,
    ) -> Result<CompensationFilter, Error> {
        if !LIMITS_OF_LONGEST.contains(&design.longest) {
            return Err(Error::OutOfRange {
                name: "longest filter, samples",
                value: design.longest as f64,
                min: *LIMITS_OF_LONGEST.start() as f64,
                max: *LIMITS_OF_LONGEST.end() as f64,
            });
        }
        let [first, last] = self.range();
        if !(rate.is_finite() && HIGHEST * rate > first) {
            return Err(Error::OutOfRange {
                name: "sampling rate for the calibrated range, Hz",
                value: rate,
                min: first / HIGHEST,
                max: f64::MAX,
            });
        }
        let band = match design.band {
            Some([low, high]) if high > HIGHEST * rate => {
                return Err(Error::OutOfRange {
                    name: "upper end of the band at this sampling rate, Hz",
                    value: high,
                    min: low,
                    max: HIGHEST * rate,
                });
            }
            Some(band) => band,
            None => [first, last.min(HIGHEST * rate)],
        };
        self.check_band(band)?;
        let judge = Judge::new(self)?;
        // Narrowest passage between gain one and gain zero.
        let passage = match design.beyond {
            Beyond::Reject => (0.5 * band[0]).min(band[1].min(0.5 * rate - band[1])),
            Beyond::Hold => 0.5 * rate - HIGHEST * rate,
        };
        let mut half = ((2.0 * rate / passage).ceil() as usize).clamp(16, design.longest / 2);
        loop {
            let filter = self.of_length(rate, band, half, design, &judge, watch)?;
            let next = 2 * half;
            if filter.within_tolerance || 2 * next + 1 > design.longest {
                return Ok(filter);
            }
            half = next;
        }
    }

    fn of_length(
        &self,
        rate: f64,
        band: [f64; 2],
        half: usize,
        design: &FilterDesign,
        judge: &Judge<'_>,
        watch: &dyn Watch,
    ) -> Result<CompensationFilter, Error> {
        let n = judge.axes();
        // Eight times the length: the impulse response of the wanted spectrum is not folded into the taps.
        let length = fourier::fast_length(8 * (2 * half + 1)).next_multiple_of(2);
        let step = rate / length as f64;
        let mut spectra = vec![Vec::with_capacity(length / 2 + 1); n * n];
        for bin in 0..=length / 2 {
            if bin % 4096 == 0 {
                watch.step("filter", bin as u64, (length / 2) as u64)?;
            }
            let f = bin as f64 * step;
            let gain = gain(f, rate, band, design.beyond);
            if gain == 0.0 {
                spectra
                    .iter_mut()
                    .for_each(|s| s.push(Complex64::default()));
                continue;
            }
            let k = held(judge, f, band);
            let inverse =
                regularised_inverse(&k, n, judge.regularisation(f)).ok_or(Error::Singular {
                    name: "sensitivity matrix",
                    condition: f64::INFINITY,
                })?;
            let late = Complex64::cis(-TAU * (bin * half % length) as f64 / length as f64) * gain;
            for (s, v) in spectra.iter_mut().zip(inverse) {
                s.push(v * late);
            }
        }
        let taps: Vec<Vec<f64>> = spectra
            .into_iter()
            .map(|s| {
                let mut signal = fourier::inverse(s, length).unwrap_or_default();
                signal.truncate(2 * half + 1);
                signal
            })
            .collect();
        // The finished taps, at eight frequencies per resolution of their length.
        let response: Vec<Vec<Complex64>> = taps
            .iter()
            .map(|t| {
                let mut padded = t.clone();
                padded.resize(length, 0.0);
                fourier::forward_owned(padded)
            })
            .collect();
        let bins: Vec<usize> = (0..=length / 2)
            .filter(|b| (band[0]..=band[1]).contains(&(*b as f64 * step)))
            .collect();
        let frequencies: Vec<f64> = bins.iter().map(|b| *b as f64 * step).collect();
        if frequencies.is_empty() {
            return Err(Error::OutOfRange {
                name: "width of the band in Hz",
                value: band[1] - band[0],
                min: step,
                max: rate,
            });
        }
        watch.step("filter", (length / 2) as u64, (length / 2) as u64)?;
        let at = |i: usize| response.iter().map(|r| r[bins[i]]).collect();
        let mut error = judge.over(band, half as f64 / rate, &frequencies, at)?;
        // The half length is taken out of the time by whoever applies the filter.
        error.delay = 0.0;
        error.departure_with_delay = error.departure;
        error.stated_with_delay = error.stated;
        Ok(CompensationFilter {
            rate,
            taps,
            half,
            within_tolerance: error.departure <= design.tolerance,
            error,
        })
    }
}

/// K, beyond the band that of its ends: with a phase that goes to zero at zero frequency, as that of any real system.
fn held(judge: &Judge<'_>, f: f64, [low, high]: [f64; 2]) -> Vec<Complex64> {
    if f < low {
        let k = judge.interpolation.matrix(low);
        return k
            .iter()
            .map(|k| {
                // The nearer of the two real axes: a negative element keeps its sign.
                let sign = if k.re < 0.0 { -1.0 } else { 1.0 };
                let angle = (k * sign).arg();
                Complex64::from_polar(sign * k.norm(), angle * f / low)
            })
            .collect();
    }
    judge.interpolation.matrix(f.min(high))
}

/// One in the band, falling as a raised cosine beyond it.
fn gain(f: f64, rate: f64, [low, high]: [f64; 2], beyond: Beyond) -> f64 {
    let raised = |x: f64| 0.5 - 0.5 * (PI * x.clamp(0.0, 1.0)).cos();
    let top = match beyond {
        Beyond::Reject => {
            let end = (2.0 * high).min(0.5 * rate);
            raised((end - f) / (end - high))
        }
        Beyond::Hold => {
            let begin = high.max(HIGHEST * rate);
            raised((0.5 * rate - f) / (0.5 * rate - begin))
        }
    };
    let bottom = match beyond {
        Beyond::Reject => raised((f - 0.5 * low) / (0.5 * low)),
        Beyond::Hold => 1.0,
    };
    top * bottom
}

/// A filter at work: samples in, compensated samples out, half the length of the filter late.
///
/// Convolution by blocks in the frequency domain; the result does not depend on how the samples are cut into blocks.
#[derive(Clone, Debug)]
pub struct FilterStream {
    outputs: usize,
    half: usize,
    length: usize,
    spectra: Vec<Vec<Complex64>>,
    /// Samples of every output that are still needed.
    kept: Vec<Vec<f64>>,
}

impl CompensationFilter {
    /// The filter ready to work on samples in order.
    pub fn stream(&self) -> FilterStream {
        let taps = 2 * self.half + 1;
        let length = fourier::fast_length((4 * taps).max(4096)).next_multiple_of(2);
        let spectra = self
            .taps
            .iter()
            .map(|t| {
                let mut padded = t.clone();
                padded.resize(length, 0.0);
                fourier::forward_owned(padded)
            })
            .collect();
        let outputs = (self.taps.len() as f64).sqrt().round() as usize;
        FilterStream {
            outputs,
            half: self.half,
            length,
            spectra,
            kept: vec![Vec::new(); outputs],
        }
    }
}

impl FilterStream {
    /// Takes samples of every output and gives those of every axis that they complete, in order: the first belongs to
    /// the sample of index `half`, for only from there on the filter has all it needs.
    ///
    /// **Shapes** one slice per output, of one length.
    pub fn push(&mut self, outputs: &[&[f64]]) -> Vec<Vec<f64>> {
        for (kept, new) in self.kept.iter_mut().zip(outputs) {
            kept.extend_from_slice(new);
        }
        let mut done = vec![Vec::new(); self.outputs];
        while self.kept[0].len() >= self.length {
            self.block(self.length, &mut done);
        }
        done
    }

    /// The rest, when no more samples follow, or none that belong to the same stretch; ready for the next stretch.
    ///
    /// The last `half` samples have no result.
    pub fn finish(&mut self) -> Vec<Vec<f64>> {
        let mut done = vec![Vec::new(); self.outputs];
        let here = self.kept[0].len();
        if here > 2 * self.half {
            self.block(here, &mut done);
        }
        self.kept.iter_mut().for_each(Vec::clear);
        done
    }

    /// Filters the first `here` kept samples and forgets those that no later result needs.
    fn block(&mut self, here: usize, done: &mut [Vec<f64>]) {
        let overlap = 2 * self.half;
        let spectra: Vec<Vec<Complex64>> = self
            .kept
            .iter()
            .map(|kept| {
                let mut padded = kept[..here].to_vec();
                padded.resize(self.length, 0.0);
                fourier::forward_owned(padded)
            })
            .collect();
        for (axis, done) in done.iter_mut().enumerate() {
            let mut sum = vec![Complex64::default(); self.length / 2 + 1];
            for (output, x) in spectra.iter().enumerate() {
                let h = &self.spectra[axis * self.outputs + output];
                for ((s, h), x) in sum.iter_mut().zip(h).zip(x) {
                    *s += h * x;
                }
            }
            let signal = fourier::inverse(sum, self.length).unwrap_or_default();
            // The first `overlap` results mix the end of the block into its beginning.
            done.extend_from_slice(&signal[overlap..here]);
        }
        for kept in &mut self.kept {
            kept.drain(..here - overlap);
        }
    }
}

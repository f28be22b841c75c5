//! Auto- and cross-spectra of one input and several outputs.

use super::Estimator;
use super::smearing::{Smearing, weights as smearing_weights};
use crate::welch::check;
use crate::{Detrend, Welch, fourier};
use num_complex::Complex64;
use proofmass_core::{Error, Watch};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// Spectra of one output.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OutputSpectra {
    /// One-sided density of the output.
    pub auto: Vec<f64>,
    /// One-sided cross-density E[X* Y].
    pub cross: Vec<Complex64>,
}

/// One-sided auto- and cross-densities, averaged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CrossSpectra {
    /// Hz.
    pub frequency: Vec<f64>,
    /// Density of the input.
    pub input: Vec<f64>,
    /// One per output.
    pub outputs: Vec<OutputSpectra>,
    /// Segments or hits averaged.
    pub averages: usize,
    /// Independent averages they are worth.
    pub independent: f64,
    /// Bias by smoothing in units of the second difference between neighbouring lines; 1/6 for a Hann window.
    pub(crate) smoothing: f64,
    /// Weights of a response at its own line and at quarters of lines to either side, by which a window smooths it; empty without one.
    pub(crate) kernel: Vec<f64>,
}

/// Where a hit lies in its record, and how it is windowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<'a> {
    /// The force (or other input) from the first sample to the last of this hit.
    pub input: &'a [f64],
    /// The outputs over the same samples.
    pub outputs: &'a [&'a [f64]],
}

/// Segments handled by one task; fixed, so that sums do not depend on the threads.
const BATCH: usize = 16;

impl CrossSpectra {
    /// Averages of overlapping windowed segments, for inputs that go on: noise, sweeps.
    ///
    /// **Units** densities in the products of the units per Hz.
    ///
    /// **Errors** those of [`Welch::density`]; [`Error::Length`] for an output of another length.
    pub fn welch(
        input: &[f64],
        outputs: &[&[f64]],
        rate: f64,
        welch: &Welch,
        watch: &dyn Watch,
    ) -> Result<Self, Error> {
        let l = welch.segment;
        for output in outputs {
            if output.len() != input.len() {
                return Err(Error::Length {
                    name: "output",
                    expected: input.len(),
                    got: output.len(),
                });
            }
            check(output, rate, l)?;
        }
        check(input, rate, l)?;
        let (weights, step, count) = welch.segments(input.len())?;
        let bins = l / 2 + 1;
        let plan = crate::fourier::plan(l);
        let done = Mutex::new(0);
        let batches = count.div_ceil(BATCH);
        let partial: Vec<Sums> = (0..batches)
            .into_par_iter()
            .map(|batch| {
                let mut sums = Sums::new(bins, outputs.len());
                let mut segment = vec![0.0; l];
                let mut scratch = plan.make_scratch_vec();
                let mut x = vec![Complex64::default(); bins];
                let mut y = vec![Complex64::default(); bins];
                for k in batch * BATCH..((batch + 1) * BATCH).min(count) {
                    let range = k * step..k * step + l;
                    let mut transform = |signal: &[f64], spectrum: &mut [Complex64]| {
                        crate::welch::window_segment(
                            &signal[range.clone()],
                            &weights,
                            welch.detrend,
                            rate,
                            &mut segment,
                        );
                        // Lengths are those the plan was made for: nothing can fail.
                        plan.process_with_scratch(&mut segment, spectrum, &mut scratch)
                            .is_ok()
                    };
                    if !transform(input, &mut x) {
                        continue;
                    }
                    sums.add_input(&x);
                    for (c, output) in outputs.iter().enumerate() {
                        if transform(output, &mut y) {
                            sums.add_output(c, &x, &y);
                        }
                    }
                }
                let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                *done += 1;
                watch.step("cross-spectra", *done, batches as u64)?;
                Ok(sums)
            })
            .collect::<Result<_, Error>>()?;
        let mut sums = Sums::new(bins, outputs.len());
        for part in &partial {
            sums.merge(part);
        }
        let squares: f64 = weights.iter().map(|w| w * w).sum();
        let nu = crate::welch::degrees_of_freedom(&weights, step, count);
        let mut spectra = sums.scaled(
            l,
            rate,
            1.0 / (squares * count as f64),
            count,
            0.5 * nu,
            smoothing(&weights),
        );
        spectra.kernel = smearing_weights(&weights);
        Ok(spectra)
    }

    /// What window and estimator make of a response.
    pub fn smearing(&self, estimator: Estimator) -> Smearing {
        Smearing {
            estimator,
            line: self.frequency.get(1).copied().unwrap_or(0.0),
            weights: if self.kernel.is_empty() {
                vec![1.0]
            } else {
                self.kernel.clone()
            },
        }
    }

    /// Averages over hits that each decay within their own stretch of `length` samples; shorter ones are padded with zeros.
    ///
    /// `force_window` samples after the hit's greatest input (and as many before) keep the input, beyond it is set to its
    /// mean there: between hits a force is zero, and what is recorded is noise. `decay`, in s, multiplies input and outputs
    /// with e^{−t/decay}, which adds 1/decay to every decay rate.
    ///
    /// **Errors** [`Error::TooFew`] below two hits or four samples; [`Error::Length`]; [`Error::NotFinite`].
    pub fn hits(
        hits: &[Hit<'_>],
        rate: f64,
        length: usize,
        force_window: Option<usize>,
        decay: Option<f64>,
    ) -> Result<Self, Error> {
        if hits.len() < 2 {
            return Err(Error::TooFew {
                name: "hits",
                needed: 2,
                got: hits.len(),
            });
        }
        proofmass_core::check::positive("sample rate", rate)?;
        let bins = length / 2 + 1;
        let outputs = hits[0].outputs.len();
        let mut sums = Sums::new(bins, outputs);
        for hit in hits {
            let n = hit.input.len().min(length);
            if n < 4 {
                return Err(Error::TooFew {
                    name: "samples of a hit",
                    needed: 4,
                    got: n,
                });
            }
            let shaped =
                |signal: &[f64], keep: Option<(usize, usize)>| -> Result<Vec<Complex64>, Error> {
                    if signal.len() < n {
                        return Err(Error::Length {
                            name: "output of a hit",
                            expected: n,
                            got: signal.len(),
                        });
                    }
                    if let Some(index) = signal[..n].iter().position(|v| !v.is_finite()) {
                        return Err(Error::NotFinite { name: "hit", index });
                    }
                    // The level is that of the end, where everything has decayed.
                    let tail = &signal[n - (n / 10).max(1)..n];
                    let level = tail.iter().sum::<f64>() / tail.len() as f64;
                    let mut part: Vec<f64> = signal[..n]
                        .iter()
                        .enumerate()
                        .map(|(k, v)| {
                            let inside = keep.is_none_or(|(a, b)| (a..=b).contains(&k));
                            let w = decay.map_or(1.0, |d| (-(k as f64) / rate / d).exp());
                            if inside { w * (v - level) } else { 0.0 }
                        })
                        .collect();
                    part.resize(length, 0.0);
                    Ok(fourier::forward_owned(part))
                };
            let top = (0..n)
                .max_by(|a, b| hit.input[*a].abs().total_cmp(&hit.input[*b].abs()))
                .unwrap_or(0);
            let keep = force_window.map(|w| (top.saturating_sub(w), top + w));
            let x = shaped(hit.input, keep)?;
            sums.add_input(&x);
            for (c, output) in hit.outputs.iter().enumerate().take(outputs) {
                let y = shaped(output, None)?;
                sums.add_output(c, &x, &y);
            }
        }
        let count = hits.len();
        Ok(sums.scaled(
            length,
            rate,
            1.0 / (length * count) as f64,
            count,
            count as f64,
            0.0,
        ))
    }
}

/// ½ Σw′²/Σw² in units that make it the factor of the second difference: for Hann 1/6.
fn smoothing(weights: &[f64]) -> f64 {
    let n = weights.len();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let slopes: f64 = (0..n)
        .map(|k| (0.5 * (weights[(k + 1) % n] - weights[(k + n - 1) % n])).powi(2))
        .sum();
    let n = n as f64;
    0.5 * slopes / squares * n * n / (4.0 * std::f64::consts::PI.powi(2))
}

struct Sums {
    input: Vec<f64>,
    outputs: Vec<OutputSpectra>,
}

impl Sums {
    fn new(bins: usize, outputs: usize) -> Self {
        Self {
            input: vec![0.0; bins],
            outputs: vec![
                OutputSpectra {
                    auto: vec![0.0; bins],
                    cross: vec![Complex64::default(); bins],
                };
                outputs
            ],
        }
    }

    fn add_input(&mut self, x: &[Complex64]) {
        for (s, v) in self.input.iter_mut().zip(x) {
            *s += v.norm_sqr();
        }
    }

    fn add_output(&mut self, c: usize, x: &[Complex64], y: &[Complex64]) {
        let OutputSpectra { auto, cross } = &mut self.outputs[c];
        for (((a, s), x), y) in auto.iter_mut().zip(cross).zip(x).zip(y) {
            *a += y.norm_sqr();
            *s += x.conj() * y;
        }
    }

    fn merge(&mut self, other: &Self) {
        for (a, b) in self.input.iter_mut().zip(&other.input) {
            *a += b;
        }
        for (mine, theirs) in self.outputs.iter_mut().zip(&other.outputs) {
            for (a, b) in mine.auto.iter_mut().zip(&theirs.auto) {
                *a += b;
            }
            for (a, b) in mine.cross.iter_mut().zip(&theirs.cross) {
                *a += b;
            }
        }
    }

    fn scaled(
        mut self,
        l: usize,
        rate: f64,
        scale: f64,
        averages: usize,
        independent: f64,
        smoothing: f64,
    ) -> CrossSpectra {
        for k in 0..self.input.len() {
            let own_mirror = k == 0 || 2 * k == l;
            let factor = scale / rate * if own_mirror { 1.0 } else { 2.0 };
            self.input[k] *= factor;
            for output in &mut self.outputs {
                output.auto[k] *= factor;
                output.cross[k] *= factor;
            }
        }
        CrossSpectra {
            frequency: (0..self.input.len())
                .map(|k| k as f64 * rate / l as f64)
                .collect(),
            input: self.input,
            outputs: self.outputs,
            averages,
            independent,
            smoothing,
            kernel: Vec::new(),
        }
    }
}

impl Default for Welch {
    /// 1024 samples, Hann, half overlap, mean removed.
    fn default() -> Self {
        Self {
            detrend: Detrend::Constant,
            ..Self::new(1024)
        }
    }
}

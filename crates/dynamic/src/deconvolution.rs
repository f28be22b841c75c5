//! Acceleration from the output of a device whose model is known: the stable inverse filter, with the uncertainty of every sample.

mod pulse;

pub use pulse::PulseReading;

use super::model::parameters::{Device, STEP};
use super::model::{ModelStructure, TransducerModel};
use crate::limit;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::{Density, Welch, fourier};
use proofmass_uncertainty::{Estimate, student_quantile};

/// How an output is turned back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Deconvolution {
    /// Corner of the zero-phase low-pass, Hz; where the sum of noise and bias is least when `None`.
    pub corner: Option<f64>,
    /// Samples before anything happens; they tell baseline and noise.
    pub quiet: usize,
    /// First sample of what is asked for and the one after its last; found where the output stands out when `None`.
    pub event: Option<[usize; 2]>,
}

/// The acceleration with its uncertainty, sample by sample.
///
/// Â(f) = L(f) U(f)/S(f), L(f) = 1/(1 + (f/f_c)⁸) of zero phase, which keeps the inverse finite where the device no longer answers.
/// The corner is chosen on the event alone, a window around what stands out, for beside a long record a short pulse has no line above
/// the noise; by bands of half an octave, for single lines of a pulse are zero. Three causes, added in squares:
///
/// - **noise**: its density before anything happens, through |L/S|², or what the filter leaves of the quiet samples themselves, where
///   that is more (hum, a drift), and the level of those samples as it would be at the peak if it went on as it changes among them; the same
///   at every sample;
/// - **model**: ∂â/∂θ by the same filter, with the covariance of all parameters (their common errors kept);
/// - **regularisation**: what L removes is at most Δ = 2∫|1 − L| B df, B the modulus of Â where it is seen above the noise, beyond
///   that falling as f⁻²; rectangular, u = Δ/√3.
///
/// **Assumes** a spectrum that falls at least as f⁻² beyond what is seen: a pulse without a step in its acceleration.
///
/// **Accuracy** the peak of a shock whose plain reading is wrong by a quarter lies within its 95 % interval in 200 runs
/// (`coverage_deconvolved_peak`).
///
/// **Source** `[Elster2008]`, `[Eichstaedt2016]`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Deconvolved {
    /// Input of the device: m/s² for an accelerometer.
    pub value: Vec<f64>,
    /// Standard uncertainty of each sample.
    pub standard_uncertainty: Vec<f64>,
    /// Corner that was used, Hz.
    pub corner: f64,
    /// Its parts that are the same at every sample: noise, regularisation.
    pub noise: f64,
    /// Standard uncertainty by what the low-pass removes.
    pub regularisation: f64,
    /// Greatest part of the model.
    pub model: f64,
    /// First sample of the event and the one after its last.
    pub event: [usize; 2],
    /// Sample of its peak: found with a third of the corner, that the noise of a flat top does not choose it, and within a third of a
    /// half period of the corner the greatest.
    pub top: usize,
    /// Seconds from the first to the last passage through a tenth of the peak; `None` where a tenth of the peak cannot be told from the
    /// noise, or the record does not hold both.
    pub duration: Option<PulseReading>,
    /// Integral over the event, input × s; `None` where the record does not hold it and what the low-pass spreads.
    pub velocity_change: Option<PulseReading>,
}

/// The spectrum of an output, to be divided by the response of the device.
struct Inverse {
    spectrum: Vec<Complex64>,
    response: Vec<Complex64>,
    /// Distance of two lines, Hz.
    line: f64,
    /// Samples of the transform, and of the record.
    padded: usize,
    samples: usize,
}

impl Inverse {
    /// The input up to a corner, times a factor by lines.
    fn at(&self, corner: f64, factor: &dyn Fn(usize) -> Complex64) -> Vec<f64> {
        let lines = self.spectrum.iter().zip(&self.response).enumerate();
        let filtered = lines
            .map(|(k, (u, s))| u * low_pass(k as f64 * self.line, corner) / s * factor(k))
            .collect();
        let mut x = fourier::inverse(filtered, self.padded).unwrap_or_default();
        x.truncate(self.samples);
        x
    }

    /// Response at the nearest line.
    fn response_at(&self, f: f64) -> Complex64 {
        let k = (f / self.line).round() as usize;
        self.response[k.min(self.response.len() - 1)]
    }
}

/// Sample of the greatest modulus among some.
fn greatest(value: &[f64], among: std::ops::Range<usize>) -> usize {
    let first = among.start;
    among
        .max_by(|a, b| value[*a].abs().total_cmp(&value[*b].abs()))
        .unwrap_or(first)
}

fn low_pass(f: f64, corner: f64) -> f64 {
    1.0 / (1.0 + (f / corner).powi(8))
}

impl Deconvolution {
    /// The output over the static sensitivity, from the mean of the quiet samples on, as one reads it without a model.
    pub fn plain(&self, sensitivity: f64, output: &[f64]) -> Vec<f64> {
        let quiet = &output[..self.quiet];
        let level = quiet.iter().sum::<f64>() / quiet.len().max(1) as f64;
        output.iter().map(|v| (v - level) / sensitivity).collect()
    }

    /// Turns an output, sampled at `rate`, back into the input.
    ///
    /// The estimate holds the parameters of the model by their names (`sensitivity`, `mode.1.frequency`, …).
    ///
    /// # Errors
    /// [`Error::TooFew`] with fewer than 32 quiet samples; [`Error::NotFinite`]; [`Error::OutOfRange`] for a corner beyond half the
    /// rate or a model with a high-pass, whose inverse has no bound at low frequencies; an estimate without the model's parameters.
    pub fn apply(
        &self,
        model: &TransducerModel,
        structure: &ModelStructure,
        estimate: &Estimate,
        output: &[f64],
        rate: f64,
    ) -> Result<Deconvolved, Error> {
        proofmass_core::check::positive("sample rate", rate)?;
        proofmass_core::check::finite("output", output)?;
        if self.quiet < 32 || self.quiet > output.len() {
            return Err(Error::TooFew {
                name: "quiet samples before the motion",
                needed: 32,
                got: self.quiet.min(output.len()),
            });
        }
        if let Some(corner) = model.high_pass {
            return Err(Error::OutOfRange {
                name: "high-pass corner of the model",
                value: corner,
                min: 0.0,
                max: 0.0,
            });
        }
        if let Some(corner) = self.corner
            && !(corner > 0.0 && corner <= 0.5 * rate)
        {
            return Err(Error::OutOfRange {
                name: "corner of the low-pass",
                value: corner,
                min: 0.0,
                max: 0.5 * rate,
            });
        }
        let n = output.len();
        let time = 1.0 / (std::f64::consts::PI * rate);
        let device = Device::new(model, structure, estimate, time)?;
        let baseline = output[..self.quiet].iter().sum::<f64>() / self.quiet as f64;
        // As much again behind it: the tail of the inverse must not come round to the beginning.
        let padded = fourier::fast_length(2 * n);
        let mut signal: Vec<f64> = output.iter().map(|v| v - baseline).collect();
        signal.resize(padded, 0.0);
        let spectrum = fourier::forward_owned(signal);
        let line = rate / padded as f64;
        let segment = (self.quiet / 4).clamp(8, 1024);
        let noise = Welch::new(segment).density(&output[..self.quiet], rate)?;
        let at = |k: usize| model.response(k as f64 * line);
        let response = (0..spectrum.len()).map(at).collect();
        let event = self.event.unwrap_or_else(|| stands_out(output, self.quiet));
        let seen = Event::of(output, baseline, event, model, rate);
        let envelope = seen.envelope(&noise);
        let (corner, noise_u, bias_u) = match self.corner {
            Some(corner) => {
                let (noise_u, bias_u) = seen.costs(corner, &noise, &envelope);
                (corner, noise_u, bias_u)
            }
            None => seen.best_corner(&noise, &envelope),
        };
        let inverse = Inverse {
            spectrum,
            response,
            line,
            padded,
            samples: n,
        };
        let value = inverse.at(corner, &|_| Complex64::ONE);
        let coarse = greatest(
            &inverse.at(corner / 3.0, &|_| Complex64::ONE),
            event[0]..event[1],
        );
        let near = (rate / (6.0 * corner)) as usize;
        let near = coarse.saturating_sub(near)..(coarse + near + 1).min(n);
        let top = greatest(&value, near);
        let noise_u = noise_u.max(left_of_quiet(&value[..self.quiet], corner / rate));
        let moved = |at, hidden| {
            moved_level(&output[..self.quiet], at, hidden) / inverse.response[0].norm()
        };
        let level_u = moved(top, false);
        let noise_u = noise_u.hypot(level_u);
        let sensitivities: Vec<Vec<f64>> = device
            .shifted
            .iter()
            .map(|[low, high]| {
                inverse.at(corner, &|k| {
                    let f = k as f64 * line;
                    -(high.response(f) - low.response(f)) / (2.0 * STEP * inverse.response[k])
                })
            })
            .collect();
        let p = sensitivities.len();
        let mut model_u = 0.0f64;
        let standard_uncertainty = (0..n)
            .map(|i| {
                let mut v = 0.0;
                for a in 0..p {
                    for b in 0..p {
                        v += sensitivities[a][i] * device.covariance[(a, b)] * sensitivities[b][i];
                    }
                }
                model_u = model_u.max(v.max(0.0).sqrt());
                (v.max(0.0) + noise_u * noise_u + bias_u * bias_u).sqrt()
            })
            .collect::<Vec<f64>>();
        let pulse = pulse::Deconvolution {
            inverse: &inverse,
            noise: &noise,
            corner,
            rate,
            quiet: self.quiet,
            moved: &moved,
            value: &value,
            sensitivities: &sensitivities,
            covariance: &device.covariance,
            sample: standard_uncertainty[top],
            event,
            top,
        };
        let (duration, velocity_change) = (pulse.duration(), pulse.velocity_change());
        Ok(Deconvolved {
            duration,
            velocity_change,
            value,
            standard_uncertainty,
            corner,
            noise: noise_u,
            regularisation: bias_u,
            model: model_u,
            event,
            top,
        })
    }
}

/// What the filter leaves of samples before anything happens, as a standard deviation whose 95 % interval holds with as many degrees of
/// freedom as the band leaves them. The last of them, to which the event reaches through the low-pass, are left out.
fn left_of_quiet(value: &[f64], corner: f64) -> f64 {
    let reach = ((4.0 / corner) as usize).min(value.len() / 2);
    let quiet = &value[..value.len() - reach];
    let squares = quiet.iter().map(|v| v * v).sum::<f64>();
    let dof = (2.0 * corner * quiet.len() as f64).max(1.0);
    let u = (squares / quiet.len().max(1) as f64).sqrt();
    u * student_quantile(0.975, dof) / 1.96
}

/// By how much a level that goes on as it changes among the quiet samples has moved away from their mean at another sample, as a standard
/// uncertainty whose 95 % interval holds it: a drift, or the part of a period of hum. What white noise makes of it is taken off; with `hidden` a
/// change of its size is left, which may be there unseen.
fn moved_level(quiet: &[f64], at: usize, hidden: bool) -> f64 {
    let n = quiet.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = quiet.iter().sum::<f64>() / n;
    let spread = n * (n * n - 1.0) / 12.0;
    let along = quiet.iter().enumerate();
    let slope = along.map(|(k, v)| (k as f64 - middle) * v).sum::<f64>() / spread;
    let left: f64 = quiet
        .iter()
        .enumerate()
        .map(|(k, v)| (v - mean - slope * (k as f64 - middle)).powi(2))
        .sum();
    let by_noise = left / (n - 2.0).max(1.0) / spread;
    let least = if hidden { by_noise } else { 0.0 };
    let steepest = (slope * slope - by_noise).max(least).sqrt();
    limit::standard_uncertainty(steepest * (at as f64 - middle).abs())
}

/// Where an output stands out of the noise of its quiet samples: from its first to its last sample above a tenth of its greatest, or
/// above five standard deviations of the noise.
fn stands_out(output: &[f64], quiet: usize) -> [usize; 2] {
    let before = &output[..quiet];
    let level = before.iter().sum::<f64>() / quiet as f64;
    let squares: f64 = before.iter().map(|v| (v - level).powi(2)).sum();
    let noise = (squares / quiet as f64).sqrt();
    let greatest = output.iter().fold(0.0f64, |m, v| m.max((v - level).abs()));
    let least = (0.1 * greatest).max(5.0 * noise).min(0.99 * greatest);
    let out = |v: &f64| (v - level).abs() >= least;
    let first = output.iter().position(out).unwrap_or(0);
    let last = output.iter().rposition(out).unwrap_or(output.len() - 1);
    [first, last + 1]
}

/// The spectrum of the event.
struct Event {
    spectrum: Vec<Complex64>,
    response: Vec<Complex64>,
    /// Samples that it weighs, by the squares of the window.
    samples: f64,
    /// Distance of two lines, Hz.
    line: f64,
    rate: f64,
}

impl Event {
    /// A window around it, as far again as it is long and at least eight periods of the slowest mode, in which the edges are lost.
    fn of(
        output: &[f64],
        baseline: f64,
        [from, to]: [usize; 2],
        model: &TransducerModel,
        rate: f64,
    ) -> Self {
        let slowest = model.modes.iter().map(|m| m.frequency);
        let slowest = slowest.fold(f64::INFINITY, f64::min);
        let edge = (to - from).max((8.0 * rate / slowest) as usize).max(32);
        let window = |i: usize| {
            let far = from.saturating_sub(i).max((i + 1).saturating_sub(to));
            match far >= edge {
                true => 0.0,
                false => 0.5 + 0.5 * (std::f64::consts::PI * far as f64 / edge as f64).cos(),
            }
        };
        let first = from.saturating_sub(edge);
        let last = (to + edge).min(output.len());
        let weights: Vec<f64> = (first..last).map(window).collect();
        let padded = fourier::fast_length(2 * weights.len());
        let mut signal: Vec<f64> = output[first..last]
            .iter()
            .zip(&weights)
            .map(|(v, w)| (v - baseline) * w)
            .collect();
        signal.resize(padded, 0.0);
        let spectrum = fourier::forward_owned(signal);
        let line = rate / padded as f64;
        Self {
            response: (0..spectrum.len())
                .map(|k| model.response(k as f64 * line))
                .collect(),
            spectrum,
            samples: weights.iter().map(|w| w * w).sum(),
            line,
            rate,
        }
    }

    /// Modulus of the input's spectrum, in input × s, at every line: as seen, and beyond the noise as its f⁻² continuation.
    fn envelope(&self, noise: &Density) -> Vec<f64> {
        let count = self.spectrum.len();
        // Power of the noise in a line: E|N|² = n f_s G/2.
        let level = |k: usize| {
            let bin = (k as f64 * self.line / noise.bin_width).round() as usize;
            let bin = bin.clamp(1, noise.density.len() - 1);
            0.5 * self.samples * self.rate * noise.density[bin]
        };
        let seen: Vec<f64> = (0..count)
            .map(|k| self.spectrum[k].norm() / self.response[k].norm() / self.rate)
            .collect();
        let mut sums = vec![[0.0; 2]];
        for k in 0..count {
            let [power, expected] = sums[k];
            sums.push([power + self.spectrum[k].norm_sqr(), expected + level(k)]);
        }
        // Half an octave; of its lines as many are independent as the window is shorter than the transform.
        let independent = self.samples * self.line / self.rate;
        let ratio = |k: usize| {
            let to = (k + k / 2 + 2).min(count);
            let lines = ((to - k) as f64 * independent).max(1.0);
            let [power, expected] = [0, 1].map(|p| sums[to][p] - sums[k][p]);
            power / (expected * (1.0 + 4.0 / lines.sqrt() + 8.0 / lines))
        };
        let strongest = (1..count).max_by(|a, b| ratio(*a).total_cmp(&ratio(*b)));
        let strongest = strongest.unwrap_or(1);
        let last = (strongest..count).take_while(|k| ratio(*k) > 1.0).last();
        let last = last.unwrap_or(strongest);
        // Against the same power law the greatest of the last octave is the start of the continuation.
        let from = (last / 2).max(1);
        let start = (from..=last)
            .map(|k| seen[k] * (k as f64 / last as f64).powi(2))
            .fold(0.0, f64::max);
        (0..count)
            .map(|k| {
                if k <= last {
                    seen[k]
                } else {
                    start * (last as f64 / k as f64).powi(2)
                }
            })
            .collect()
    }

    /// Standard uncertainties by noise and by what the low-pass removes.
    fn costs(&self, corner: f64, noise: &Density, envelope: &[f64]) -> (f64, f64) {
        let mut variance = 0.0;
        let mut removed = 0.0;
        for (k, s) in self.response.iter().enumerate() {
            let f = k as f64 * self.line;
            let l = low_pass(f, corner);
            let g = ((f / noise.bin_width).round() as usize).min(noise.density.len() - 1);
            variance += noise.density[g] * l * l / s.norm_sqr() * self.line;
            removed += 2.0 * (1.0 - l) * envelope[k] * self.line;
        }
        // Beyond the last line the continuation goes on: ∫ B f⁻² df.
        removed += 2.0 * envelope[envelope.len() - 1] * 0.5 * self.rate;
        (variance.sqrt(), removed / 3f64.sqrt())
    }

    fn best_corner(&self, noise: &Density, envelope: &[f64]) -> (f64, f64, f64) {
        let mut best = (0.25 * self.rate, f64::INFINITY, 0.0);
        let mut least = f64::INFINITY;
        for k in 0..60 {
            let lowest = (20.0 * self.line / self.rate).max(1e-4);
            let corner = 0.5 * self.rate * lowest.powf(f64::from(k) / 59.0);
            let (a, b) = self.costs(corner, noise, envelope);
            let total = a.hypot(b);
            if total < least {
                least = total;
                best = (corner, a, b);
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Mode;
    use proofmass_signal::PulseShape;
    use proofmass_uncertainty::{
        Component, Covariance, DegreesOfFreedom, Effect, Evaluation, Influence,
    };
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const RATE: f64 = 200e3;

    fn device(frequency: f64, damping: f64, sensitivity: f64) -> TransducerModel {
        TransducerModel {
            modes: vec![Mode {
                frequency,
                damping,
                share: 1.0,
            }],
            ..TransducerModel::flat(sensitivity)
        }
    }

    /// Through the device by its exact response.
    fn recorded(truth: &[f64], model: &TransducerModel, noise: f64, seed: u64) -> Vec<f64> {
        let n = truth.len();
        let spectrum = fourier::forward(truth)
            .iter()
            .enumerate()
            .map(|(k, v)| v * model.response(k as f64 * RATE / n as f64))
            .collect();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let clean = fourier::inverse(spectrum, n).unwrap();
        clean
            .iter()
            .map(|v| {
                let e: f64 = StandardNormal.sample(&mut rng);
                v + 0.4 + noise * e
            })
            .collect()
    }

    fn estimate(model: &TransducerModel, u: [f64; 3]) -> Estimate {
        let m = model.modes[0];
        let components = vec![
            Component::new("sensitivity", "V/(m/s²)", model.sensitivity),
            Component::new("mode.1.frequency", "Hz", m.frequency),
            Component::new("mode.1.damping", "1", m.damping),
        ];
        let covariance = Covariance::from_standard_uncertainties(&u).unwrap();
        let influence = Influence {
            key: "points".into(),
            description: "calibration".into(),
            evaluation: Evaluation::A,
            distribution: "normal".into(),
            dof: DegreesOfFreedom::INFINITE,
            effect: Effect::Joint { covariance },
        };
        Estimate::new(components, vec![influence]).unwrap()
    }

    #[test]
    fn coverage_deconvolved_peak() {
        // A haversine of 0.2 ms under a resonance of 8 kHz: the plain reading overshoots.
        let truth = PulseShape::Haversine.record(5000.0, 2e-4, 0.01, 8192, RATE);
        let top = (0..8192)
            .max_by(|a, b| truth[*a].total_cmp(&truth[*b]))
            .unwrap();
        let real = device(8000.0, 0.03, 1e-3);
        let u = [2e-6, 20.0, 1e-3];
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(77);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let (mut inside, mut plain) = (0, 0);
        for seed in 0..200 {
            let output = recorded(&truth, &real, 2e-3, seed);
            let found = device(
                8000.0 + u[1] * normal(),
                0.03 + u[2] * normal(),
                1e-3 + u[0] * normal(),
            );
            let quiet = Deconvolution {
                quiet: 1900,
                ..Deconvolution::default()
            };
            let result = quiet
                .apply(
                    &found,
                    &ModelStructure::default(),
                    &estimate(&found, u),
                    &output,
                    RATE,
                )
                .unwrap();
            let error = (result.value[top] - 5000.0).abs();
            inside += usize::from(error <= 1.96 * result.standard_uncertainty[top]);
            let reading = output.iter().copied().fold(0.0, f64::max) - 0.4;
            plain += usize::from(
                (reading / found.sensitivity - 5000.0).abs()
                    <= 1.96 * result.standard_uncertainty[top],
            );
            // The bound on what is removed is generous, but three per cent at most.
            assert!(
                result.standard_uncertainty[top] < 150.0,
                "{}",
                result.standard_uncertainty[top]
            );
        }
        // The bound on the regularisation is a bound: more than 95 % hold, 179 of 200 at least.
        assert!(inside >= 179, "{inside}");
        assert_eq!(plain, 0);
    }

    #[test]
    fn refuses_what_has_no_inverse() {
        let model = device(8000.0, 0.03, 1e-3);
        let e = estimate(&model, [1e-6, 1.0, 1e-4]);
        let output = vec![0.0; 1000];
        let structure = ModelStructure::default();
        let quiet = |quiet| Deconvolution {
            quiet,
            ..Deconvolution::default()
        };
        assert!(
            quiet(8)
                .apply(&model, &structure, &e, &output, RATE)
                .is_err()
        );
        assert!(
            quiet(2000)
                .apply(&model, &structure, &e, &output, RATE)
                .is_err()
        );
        let piezo = TransducerModel {
            high_pass: Some(1.0),
            ..model.clone()
        };
        assert!(
            quiet(100)
                .apply(&piezo, &structure.with_high_pass(), &e, &output, RATE)
                .is_err()
        );
        let corner = Deconvolution {
            corner: Some(RATE),
            quiet: 100,
            event: None,
        };
        assert!(corner.apply(&model, &structure, &e, &output, RATE).is_err());
        assert!(
            quiet(100)
                .apply(&model, &structure.with_delay(), &e, &output, RATE)
                .is_err()
        );
        let mut bad = output.clone();
        bad[3] = f64::NAN;
        assert!(
            quiet(100)
                .apply(&model, &structure, &e, &bad, RATE)
                .is_err()
        );
    }
}

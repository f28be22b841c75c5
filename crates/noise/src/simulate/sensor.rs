//! A sensor at rest: known noise, a filter in front of the converter, outliers, a step of the converter, stamps that jitter.

use super::simulate;
use crate::front_end::LowPass;
use crate::record::check_sample_rate;
use crate::{NoiseModel, Sinusoid};
use proofmass_core::check::within;
use proofmass_core::{Butterworth, Error, LowPassState};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;

/// A sensor at rest whose noise is known.
///
/// Signal path: noise → low-pass filter → outliers → quantisation noise Q → step of the converter.
///
/// **Units** those of [`NoiseModel`]; frequencies in Hz.
///
/// ```
/// use proofmass_noise::{LowPass, NoiseModel, SimulatedSensor};
/// let mut sensor = SimulatedSensor::new(NoiseModel { white: 1.0e-3, ..Default::default() });
/// sensor.low_pass = Some(LowPass { order: 2, corner: 10.0 });
/// let axes = sensor.record(3, 1000, 100.0, 7).unwrap();
/// assert_eq!((axes.len(), axes[0].len()), (3, 1000));
/// assert_eq!(axes, sensor.record(3, 1000, 100.0, 7).unwrap());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SimulatedSensor {
    /// Noise in front of the filter, that of quantisation behind it. The ramp and the phases of sinusoids count from the first sample.
    pub model: NoiseModel,
    /// Filter in front of the converter.
    pub low_pass: Option<LowPass>,
    /// Share of the samples that are outliers.
    pub outliers: f64,
    /// Standard deviation of an outlier in standard deviations of a sample, √(N² rate).
    pub outlier_size: f64,
    /// Smallest step of the converter; 0 for none.
    pub step: f64,
}

impl SimulatedSensor {
    /// Nothing but noise.
    pub fn new(model: NoiseModel) -> Self {
        Self {
            model,
            ..Self::default()
        }
    }

    /// So many axes of `n` samples: independent records of the same noise.
    ///
    /// **Errors** [`Error::OutOfRange`] for a coefficient, rate, corner, order or share without meaning.
    pub fn record(
        &self,
        axes: usize,
        n: usize,
        sample_rate: f64,
        seed: u64,
    ) -> Result<Vec<Vec<f64>>, Error> {
        check_sample_rate(sample_rate)?;
        within("share of outliers", self.outliers, 0.0, 1.0)?;
        within("size of outliers", self.outlier_size, 0.0, 1e9)?;
        within("step of the converter", self.step, 0.0, f64::MAX)?;
        (0..axes)
            .map(|axis| self.axis(n, sample_rate, &mut source(seed, axis as u64 + 1)))
            .collect()
    }

    fn axis(&self, n: usize, rate: f64, rng: &mut Xoshiro256PlusPlus) -> Result<Vec<f64>, Error> {
        // The filter has settled when the recording begins.
        let before = match self.low_pass {
            Some(filter) => {
                within(
                    "corner frequency, Hz",
                    filter.corner,
                    1e-4 * rate,
                    0.49 * rate,
                )?;
                (10.0 * rate / filter.corner).ceil() as usize
            }
            None => 0,
        };
        let start = before as f64 / rate;
        let front = NoiseModel {
            quantisation: 0.0,
            sinusoids: self
                .model
                .sinusoids
                .iter()
                .map(|s| Sinusoid {
                    phase: s.phase - 2.0 * PI * s.frequency * start,
                    ..*s
                })
                .collect(),
            ..self.model.clone()
        };
        let mut samples = simulate(&front, before + n, rate, rng)?;
        for y in &mut samples {
            *y -= self.model.ramp * start;
        }
        if let Some(filter) = self.low_pass {
            filter.apply(&mut samples, rate)?;
        }
        samples.drain(..before);
        if self.outliers > 0.0 {
            let sigma = self.outlier_size * self.model.white * rate.sqrt();
            let chance = Uniform::new(0.0, 1.0).map_err(|_| Error::OutOfRange {
                name: "share of outliers",
                value: self.outliers,
                min: 0.0,
                max: 1.0,
            })?;
            for y in &mut samples {
                if chance.sample(rng) < self.outliers {
                    let size: f64 = StandardNormal.sample(rng);
                    *y += sigma * size;
                }
            }
        }
        if self.model.quantisation > 0.0 {
            let quantisation = NoiseModel {
                quantisation: self.model.quantisation,
                ..NoiseModel::default()
            };
            let behind = simulate(&quantisation, n, rate, rng)?;
            samples.iter_mut().zip(behind).for_each(|(y, q)| *y += q);
        }
        if self.step > 0.0 {
            for y in &mut samples {
                *y = (*y / self.step).round() * self.step;
            }
        }
        Ok(samples)
    }
}

/// Time stamps of `n` samples at an even rate, each late or early by `jitter` intervals (standard deviation), never backwards.
///
/// **Units** s and Hz. **Errors** [`Error::OutOfRange`] for a rate that is not positive, or a jitter beyond ten intervals.
pub fn simulated_stamps(
    n: usize,
    sample_rate: f64,
    jitter: f64,
    seed: u64,
) -> Result<Vec<f64>, Error> {
    check_sample_rate(sample_rate)?;
    within("jitter", jitter, 0.0, 10.0)?;
    let mut rng = source(seed, 0);
    let mut last = f64::NEG_INFINITY;
    Ok((0..n)
        .map(|k| {
            let departure: f64 = if jitter > 0.0 {
                StandardNormal.sample(&mut rng)
            } else {
                0.0
            };
            let stamp = (k as f64 + jitter * departure) / sample_rate;
            // A receiver stamps what comes in the order in which it comes.
            last = f64::max(stamp, last + 1e-6 / sample_rate);
            last
        })
        .collect())
}

/// A random source of its own for every stream of a seed.
fn source(seed: u64, stream: u64) -> Xoshiro256PlusPlus {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..stream).for_each(|_| rng.jump());
    rng
}

impl LowPass {
    /// Runs the filter over samples, from rest at the first.
    fn apply(self, samples: &mut [f64], sample_rate: f64) -> Result<(), Error> {
        let Some(&first) = samples.first() else {
            return Ok(());
        };
        match self.order {
            1 => {
                let w = (PI * self.corner / sample_rate).tan();
                let (mut input, mut output) = (first, first);
                for y in samples {
                    output = (w * (*y + input) + (1.0 - w) * output) / (1.0 + w);
                    input = *y;
                    *y = output;
                }
            }
            2 => {
                let filter = Butterworth::<f64>::new(self.corner, sample_rate)?;
                let mut state = LowPassState::at(first);
                for y in samples {
                    *y = filter.step(&mut state, *y);
                }
            }
            order => {
                return Err(Error::OutOfRange {
                    name: "order of the low-pass filter",
                    value: f64::from(order),
                    min: 1.0,
                    max: 2.0,
                });
            }
        }
        Ok(())
    }
}

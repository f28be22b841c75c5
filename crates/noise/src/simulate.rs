//! Noise with known coefficients.

mod sensor;

pub use sensor::{SimulatedSensor, simulated_stamps};

use crate::NoiseModel;
use crate::record::check_sample_rate;
use proofmass_core::Error;
use proofmass_signal::fourier::{self, Complex};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::PI;

/// `n` rate samples of a noise model.
///
/// White: independent, N²·rate. Random walk: steps K²/rate from zero. Quantisation: first differences of an
/// independent phase error of variance Q², times the rate. Flicker: a Gaussian process with the density 2B²/s,
/// s = 2 sin(πf/rate)·rate, synthesised in the frequency domain over at least twice the record, so that it is
/// stationary and does not join end to end. Gauss–Markov: exact first-order autoregression in its stationary
/// state. Ramp: R t from t = 0. Sinusoids as they are.
///
/// **Units** those of [`NoiseModel`]; `sample_rate` in Hz.
///
/// **Errors** [`Error::OutOfRange`] for a negative coefficient or a rate that is not positive.
///
/// **Accuracy** Allan variances agree with the model within their confidence (`law_simulated_…`).
///
/// **Source** flicker: `[Kasdin1995]` for the sampled spectrum, `[Timmer1995]` for the synthesis.
///
/// ```
/// use proofmass_noise::{NoiseModel, simulate};
/// use rand::SeedableRng;
///
/// let model = NoiseModel { white: 0.1, ..Default::default() };
/// let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(1);
/// let rate = simulate(&model, 10_000, 100.0, &mut rng).unwrap();
/// let variance = rate.iter().map(|y| y * y).sum::<f64>() / 1e4;
/// assert!((variance - 1.0).abs() < 0.05); // N²·rate
/// ```
pub fn simulate<R: Rng + ?Sized>(
    model: &NoiseModel,
    n: usize,
    sample_rate: f64,
    rng: &mut R,
) -> Result<Vec<f64>, Error> {
    check_sample_rate(sample_rate)?;
    model.check()?;
    let mut normal = || -> f64 { StandardNormal.sample(&mut *rng) };
    let mut rate = vec![0.0; n];
    if model.white > 0.0 {
        let sigma = model.white * sample_rate.sqrt();
        rate.iter_mut().for_each(|y| *y += sigma * normal());
    }
    if model.random_walk > 0.0 {
        let step = model.random_walk / sample_rate.sqrt();
        let mut walk = 0.0;
        for y in &mut rate {
            *y += walk;
            walk += step * normal();
        }
    }
    if model.quantisation > 0.0 {
        let sigma = model.quantisation * sample_rate;
        let mut before = sigma * normal();
        for y in &mut rate {
            let after = sigma * normal();
            *y += after - before;
            before = after;
        }
    }
    for g in &model.gauss_markov {
        let decay = 1.0 / (g.correlation_time * sample_rate);
        let phi = (-decay).exp();
        let drive = g.standard_deviation * (-(-2.0 * decay).exp_m1()).sqrt();
        let mut state = g.standard_deviation * normal();
        for y in &mut rate {
            *y += state;
            state = phi * state + drive * normal();
        }
    }
    if model.flicker > 0.0 && n > 0 {
        let noise = flicker(n, &mut normal);
        rate.iter_mut()
            .zip(noise)
            .for_each(|(y, v)| *y += model.flicker * v);
    }
    for (k, y) in rate.iter_mut().enumerate() {
        let t = k as f64 / sample_rate;
        *y += model.ramp * t;
        for s in &model.sinusoids {
            *y += s.amplitude * (2.0 * PI * s.frequency * t + s.phase).sin();
        }
    }
    Ok(rate)
}

/// Flicker noise of unit B: independent Gaussian Fourier coefficients of variance proportional to the density.
fn flicker(n: usize, normal: &mut impl FnMut() -> f64) -> Vec<f64> {
    let length = 2 * fourier::fast_length(n.max(2));
    let bins = length / 2 + 1;
    // The density is 2/s with s in units of the rate: E|X_k|² = length · (1/s) · 1, half of it in each part.
    let spectrum: Vec<Complex<f64>> = (0..bins)
        .map(|k| {
            if k == 0 {
                return Complex::new(0.0, 0.0);
            }
            let s = 2.0 * (PI * k as f64 / length as f64).sin();
            let variance = length as f64 / s;
            if 2 * k == length {
                Complex::new(variance.sqrt() * normal(), 0.0)
            } else {
                let part = (0.5 * variance).sqrt();
                Complex::new(part * normal(), part * normal())
            }
        })
        .collect();
    let mut noise = fourier::inverse(spectrum, length).unwrap_or_default();
    noise.truncate(n);
    noise
}

//! Where the encoder hands over to the accelerometer: channels of the fused filters, the error predicted from the
//! sensors' noise, and gains found from it or from the smoother.

use crate::{KalmanModel, Method, MotionRecord, ReadingSource};
use proofmass_core::Error;
use proofmass_core::numeric::golden_section;
use proofmass_core::numeric::upper_median;
use proofmass_core::velocity::ProcessNoise;
use proofmass_signal::fourier::Complex;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::f64::consts::PI;

/// Gains of the two channels of a fused filter on the true velocity at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ChannelGain {
    /// Frequency, rad/s.
    pub omega: f64,
    /// |encoder channel|.
    pub encoder: f64,
    /// Its phase, rad.
    pub encoder_phase: f64,
    /// |accelerometer channel|.
    pub accelerometer: f64,
    /// Its phase, rad.
    pub accelerometer_phase: f64,
}

/// Transfer from acceleration and from position to velocity at complex frequency s: (H_a, H_p).
///
/// Their sum over the true velocity, s·(H_a + H_p/s²)/s… = 1: the channels are complementary.
fn transfer(method: &Method, s: Complex<f64>) -> Option<(Complex<f64>, Complex<f64>)> {
    match *method {
        Method::TwoChannel { k1, k2 } => {
            let d = (s + k1) * (s + k2);
            Some((s / d, ((k1 + k2) * s + k1 * k2) * s / d))
        }
        Method::Observer { k_x, k_v } => {
            let d = s * s + k_x * s + k_v;
            Some(((s + k_x) / d, k_v * s / d))
        }
        Method::OffsetObserver { k_x, k_v, k_b } => {
            let d = s * s * s + k_x * s * s + k_v * s + k_b;
            Some((s * (s + k_x) / d, (k_v * s + k_b) * s / d))
        }
        Method::TrackingLoop { bandwidth: b } => {
            Some((Complex::new(0.0, 0.0), b * b * s / ((s + b) * (s + b))))
        }
        _ => None,
    }
}

/// Tustin's s at ω: j (2/T) tan(ωT/2).
fn tustin(omega: f64, dt: f64) -> Complex<f64> {
    Complex::new(0.0, 2.0 / dt * (0.5 * omega * dt).tan())
}

/// Bode plot of the two channels as the discretised filter has them: encoder s H_p·(1/s) and accelerometer s H_a on
/// the true velocity. They add to one at every frequency. `None` for methods that are not such filters.
///
/// **Source** `[ZhuLamarche07]`.
pub fn channels(method: &Method, sample_time: f64, omega: &[f64]) -> Option<Vec<ChannelGain>> {
    omega
        .iter()
        .map(|&w| {
            let s = tustin(w, sample_time);
            let (a, p) = transfer(method, s)?;
            let (a, p) = (a * s, p / s);
            Some(ChannelGain {
                omega: w,
                encoder: p.norm(),
                encoder_phase: p.arg(),
                accelerometer: a.norm(),
                accelerometer_phase: a.arg(),
            })
        })
        .collect()
}

/// White noise of the two sensors: variance of an acceleration sample and of a position reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNoise {
    /// σ_a², (m/s²)².
    pub acceleration: f64,
    /// σ_p², m²; δ²/12 for quantisation.
    pub position: f64,
}

/// Standard deviation of the velocity that a fused filter makes of the sensors' noise.
///
/// σ_v² = (1/2π) ∫_{−π}^{π} (|H_a|² σ_a² + |H_p|² σ_p²) dθ over the discretised filter. `None` for methods that
/// are not such filters, and for a filter that integrates an offset (infinite).
pub fn predicted_error(method: &Method, noise: &SensorNoise, sample_time: f64) -> Option<f64> {
    spectrum_error(method, sample_time, |_| {
        (noise.acceleration, noise.position)
    })
}

/// The same for coloured noise: `density` gives the two-sided spectra (per sample: variance at white) of
/// acceleration and position at θ = ωT.
///
/// Integrated over log θ from 10⁻⁷ to π, 2000 points of the midpoint rule.
pub fn spectrum_error(
    method: &Method,
    sample_time: f64,
    density: impl Fn(f64) -> (f64, f64),
) -> Option<f64> {
    const POINTS: usize = 2000;
    let (low, high) = (1e-7f64.ln(), PI.ln());
    let step = (high - low) / POINTS as f64;
    let mut sum = 0.0;
    for k in 0..POINTS {
        let theta = (low + (k as f64 + 0.5) * step).exp();
        let (a, p) = transfer(method, tustin(theta / sample_time, sample_time))?;
        let (sa, sp) = density(theta);
        sum += (a.norm_sqr() * sa + p.norm_sqr() * sp) * theta * step;
    }
    let variance = sum / PI;
    variance.is_finite().then(|| variance.sqrt())
}

/// Which fused filter is tuned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// k₂, and k₁ from a list.
    TwoChannel,
    /// k_v and the damping k_x/(2√k_v) from a list.
    Observer,
}

/// What the gains are chosen by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion<'a> {
    /// Least predicted error from the sensors' noise: the crossover. Before any motion is recorded.
    Noise(SensorNoise),
    /// Least RMS difference to a reference velocity: the smoother's, or a truth.
    Reference {
        /// Velocity per sample.
        velocity: &'a [f64],
        /// Samples at the start that do not count.
        skip: usize,
    },
}

/// Gains with the value of the criterion, RMS in velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Crossover {
    /// The method with its gains.
    pub method: Method,
    /// Its predicted or measured RMS.
    pub rms: f64,
}

/// High-pass corners k₁ that are tried, over k₂.
const K1_OVER_K2: [f64; 4] = [0.0, 0.003, 0.03, 0.3];
/// Dampings that are tried.
const DAMPING: [f64; 6] = [0.35, 0.5, std::f64::consts::FRAC_1_SQRT_2, 1.0, 1.5, 2.5];

/// Finds the gains of a filter over crossovers from 10⁻³ rad/s to the Nyquist frequency.
///
/// A grid of five points per decade, then the golden section.
///
/// # Errors
/// Of the record when the criterion needs it; [`Error::NotConverged`] when no gain gave a finite error.
pub fn crossover(
    filter: Filter,
    criterion: Criterion<'_>,
    record: &MotionRecord,
) -> Result<Crossover, Error> {
    record.check()?;
    let dt = record.sample_time;
    let shapes: &[f64] = match filter {
        Filter::TwoChannel => &K1_OVER_K2,
        Filter::Observer => &DAMPING,
    };
    let method = |log: f64, shape: f64| {
        let w = 10f64.powf(log);
        match filter {
            Filter::TwoChannel => Method::TwoChannel {
                k1: shape * w,
                k2: w,
            },
            Filter::Observer => Method::Observer {
                k_x: 2.0 * shape * w,
                k_v: w * w,
            },
        }
    };
    let score = |method: &Method| -> Result<f64, Error> {
        match criterion {
            Criterion::Noise(noise) => {
                Ok(predicted_error(method, &noise, dt).unwrap_or(f64::INFINITY))
            }
            Criterion::Reference { velocity, skip } => {
                // Gains beyond what coasting over missing readings bears make the filter run away.
                match method.run(record) {
                    Ok(trace) => Ok(rms(&trace.velocity, velocity, skip)),
                    Err(Error::NotFinite { .. }) => Ok(f64::INFINITY),
                    Err(error) => Err(error),
                }
            }
        }
    };
    if let Criterion::Reference { velocity, .. } = criterion
        && velocity.len() != record.reading.len()
    {
        return Err(Error::Length {
            name: "reference",
            expected: record.reading.len(),
            got: velocity.len(),
        });
    }
    let (low, high) = (-3.0, (PI / dt).log10() + 0.5);
    let steps = ((high - low) * 5.0f64).ceil() as usize;
    let mut best = (f64::INFINITY, low, shapes[0]);
    for &shape in shapes {
        for k in 0..=steps {
            let at = low + (high - low) * k as f64 / steps as f64;
            let value = score(&method(at, shape))?;
            if value < best.0 {
                best = (value, at, shape);
            }
        }
    }
    if !best.0.is_finite() {
        return Err(Error::NotConverged {
            name: "crossover",
            iterations: steps,
            step: f64::INFINITY,
        });
    }
    let better = |c, d| -> Result<bool, Error> {
        Ok(score(&method(c, best.2))? < score(&method(d, best.2))?)
    };
    let ends = [best.1 - 0.2, best.1 + 0.2];
    let at = golden_section(ends, |_, width| width > 0.004, better)?;
    let value = score(&method(at, best.2))?;
    if value < best.0 {
        best = (value, at, best.2);
    }
    Ok(Crossover {
        method: method(best.1, best.2),
        rms: best.0,
    })
}

fn rms(estimate: &[f64], reference: &[f64], skip: usize) -> f64 {
    let skip = skip.min(estimate.len() - 1);
    let square: f64 = estimate[skip..]
        .iter()
        .zip(&reference[skip..])
        .map(|(v, r)| (v - r) * (v - r))
        .sum();
    (square / (estimate.len() - skip) as f64).sqrt()
}

/// Gains without a truth: the filter that comes closest to the smoother of the tuned model.
///
/// The smoother uses every reading twice over and errs less than any filter; the difference to it is nearly the
/// filter's own error.
///
/// # Errors
/// Of the record and of the smoother.
pub fn crossover_by_smoother(
    filter: Filter,
    model: &KalmanModel,
    record: &MotionRecord,
    skip: usize,
) -> Result<Crossover, Error> {
    let reference = model.smooth(record)?;
    crossover_beside(filter, record, &reference.velocity, skip)
}

/// The same beside any reference velocity.
pub(crate) fn crossover_beside(
    filter: Filter,
    record: &MotionRecord,
    velocity: &[f64],
    skip: usize,
) -> Result<Crossover, Error> {
    // The start that every run has, found once.
    let mut started = record.clone();
    started.initial_velocity = Some(record.start_velocity().0);
    crossover(filter, Criterion::Reference { velocity, skip }, &started)
}

/// Kalman gains without a truth: the q at which the on-line filter comes closest to the smoother of the tuned model.
///
/// For a matched model that is the likelihood's own q. Where the acceleration bends between samples, one step ahead
/// of the position is not what the velocity needs: the likelihood widens q for the bend, and the velocity pays. The
/// smoother sees both sides of a step and hardly bends. The search runs from a tenth of the likelihood's q, as little
/// trust in the difference to an estimate of the same readings goes, to ten thousand times it.
///
/// All variances are then scaled so that the mean variance the filter states is its mean square difference to the
/// smoother plus the smoother's own: the error of an optimal smoother is uncorrelated with that difference.
///
/// # Errors
/// Of the record and of the smoother.
pub fn kalman_by_smoother(
    model: &KalmanModel,
    record: &MotionRecord,
    skip: usize,
) -> Result<Crossover, Error> {
    let reference = model.smooth(record)?;
    let reference = (&*reference.velocity, &*reference.velocity_uncertainty);
    kalman_beside(model, record, reference, skip, 0.3)
}

/// The same beside any smoother's velocity and standard uncertainty; the variances are multiplied by `least` and more.
pub(crate) fn kalman_beside(
    model: &KalmanModel,
    record: &MotionRecord,
    (reference, uncertainty): (&[f64], &[f64]),
    skip: usize,
    least: f64,
) -> Result<Crossover, Error> {
    let with = |log: f64| KalmanModel {
        acceleration_noise: model.acceleration_noise * 10f64.powf(log),
        ..*model
    };
    let usual = usual(model, record)?;
    let (reference, uncertainty) = (kept(reference, &usual), kept(uncertainty, &usual));
    let score = |log: f64| -> Result<f64, Error> {
        match with(log).filter(record) {
            Ok(run) => Ok(rms(&kept(&run.velocity, &usual), &reference, skip)),
            Err(Error::NotFinite { .. } | Error::NotPositiveDefinite { .. }) => Ok(f64::INFINITY),
            Err(error) => Err(error),
        }
    };
    let (low, high, step) = (-1.0, 7.0, 0.25);
    let (mut best, mut at) = (score(0.0)?, 0.0);
    let mut log = low;
    while log <= high {
        let value = score(log)?;
        // A flat valley belongs to the likelihood: rounding that repeats makes the rest of the difference.
        if value < 0.97 * best {
            (best, at) = (value, log);
        }
        log += step;
    }
    if at != 0.0 {
        let better = |c, d| -> Result<bool, Error> { Ok(score(c)? < score(d)?) };
        let middle = golden_section([at - step, at + step], |_, width| width > 0.03, better)?;
        let value = score(middle)?;
        if value < best {
            (best, at) = (value, middle);
        }
    }
    let found = with(at);
    let run = found.filter(record)?;
    let skip = skip.min(reference.len() - 1);
    let mean = |u: &[f64]| u[skip..].iter().map(|u| u * u).sum::<f64>() / (u.len() - skip) as f64;
    let (stated, own) = (
        mean(&kept(&run.velocity_uncertainty, &usual)),
        mean(&uncertainty),
    );
    let factor = (best * best + own) / stated;
    Ok(Crossover {
        method: Method::Kalman {
            model: found.scaled(if factor.is_finite() {
                factor.clamp(least, 1e6)
            } else {
                1.0
            }),
        },
        rms: best,
    })
}

/// Uncertainty over its median beyond which a filter is still about what a gap took from it.
const UNUSUAL: f64 = 1.5;

/// The samples at which a filter is what it is without gaps, so that gains and noise are not those of finding the way again; `None` for
/// all of them.
fn usual(model: &KalmanModel, record: &MotionRecord) -> Result<Option<Vec<usize>>, Error> {
    if record.holes.is_empty() {
        return Ok(None);
    }
    let u = model.filter(record)?.velocity_uncertainty;
    let most = UNUSUAL * upper_median(&mut u.clone()).unwrap_or(0.0);
    let list: Vec<usize> = (0..u.len()).filter(|k| u[*k] <= most).collect();
    Ok(Some(list))
}

/// The values at these samples.
fn kept<'a>(values: &'a [f64], at: &Option<Vec<usize>>) -> Cow<'a, [f64]> {
    match at {
        None => Cow::from(values),
        Some(at) => at.iter().map(|k| values[*k]).collect(),
    }
}

/// Noise of the two sensors as a tuned model has it, for [`Criterion::Noise`]; `None` for a speed record.
pub fn noise_of(model: &KalmanModel, record: &MotionRecord) -> Option<SensorNoise> {
    let acceleration = match model.noise_form {
        ProcessNoise::SampleConstant => model.acceleration_noise,
        ProcessNoise::Continuous => model.acceleration_noise / record.sample_time,
    };
    (record.source == ReadingSource::Position).then_some(SensorNoise {
        acceleration,
        position: model.reading_noise,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn law_channels_add_to_one() {
        for method in [
            Method::TwoChannel { k1: 0.3, k2: 10.0 },
            Method::Observer {
                k_x: 5.0,
                k_v: 25.0,
            },
            Method::OffsetObserver {
                k_x: 15.0,
                k_v: 75.0,
                k_b: 125.0,
            },
        ] {
            for c in channels(&method, 1e-3, &[0.01, 1.0, 10.0, 1000.0]).unwrap() {
                let sum = Complex::from_polar(c.encoder, c.encoder_phase)
                    + Complex::from_polar(c.accelerometer, c.accelerometer_phase);
                assert!((sum - 1.0).norm() < 1e-9, "{method:?} {c:?}");
            }
        }
        assert!(channels(&Method::FixedTime, 1e-3, &[1.0]).is_none());
    }

    #[test]
    fn law_predicted_error_is_what_noise_does() {
        let noise = SensorNoise {
            acceleration: 0.04,
            position: 1e-8,
        };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let n = 200_000;
        let mut draw = |s: f64| -> Vec<f64> {
            (0..n)
                .map(|_| -> f64 { StandardNormal.sample(&mut rng) })
                .map(|e| e * s)
                .collect()
        };
        let (x, a) = (draw(1e-4), draw(0.2));
        let mut record = MotionRecord::new(
            1e-2,
            ReadingSource::Position,
            x.into_iter().map(Some).collect(),
            a,
        )
        .unwrap();
        record.initial_velocity = Some(0.0);
        for method in [
            Method::TwoChannel { k1: 0.5, k2: 5.0 },
            Method::Observer {
                k_x: 10.0,
                k_v: 50.0,
            },
        ] {
            let v = method.run(&record).unwrap().velocity;
            let rms = (v[1000..].iter().map(|v| v * v).sum::<f64>() / (n - 1000) as f64).sqrt();
            let predicted = predicted_error(&method, &noise, 1e-2).unwrap();
            // Correlation time 0.2 s in 2000 s: 10⁴ independent values, 0.7 % of a standard deviation; four σ.
            assert!(
                (rms / predicted - 1.0).abs() < 0.03,
                "{method:?} {rms} {predicted}"
            );
        }
    }

    #[test]
    fn agrees_crossover_from_noise_with_the_steady_kalman_gain() {
        let (q, r, dt) = (0.04, 1e-8, 1e-3);
        let record = MotionRecord::new(
            dt,
            ReadingSource::Position,
            vec![Some(0.0); 8],
            vec![0.0; 8],
        )
        .unwrap();
        let noise = SensorNoise {
            acceleration: q,
            position: r,
        };
        let found = crossover(Filter::Observer, Criterion::Noise(noise), &record).unwrap();
        let kalman = KalmanModel::new(q, r).two(dt).unwrap().steady().unwrap();
        let Method::Observer { k_x, k_v } = found.method else {
            unreachable!()
        };
        // The optimum is flat and the damping comes from a list: a few per cent.
        assert!(
            (k_v / (kalman.k[1] / dt) - 1.0).abs() < 0.1,
            "{k_v} {}",
            kalman.k[1] / dt
        );
        assert!(
            (k_x / (kalman.k[0] / dt) - 1.0).abs() < 0.1,
            "{k_x} {}",
            kalman.k[0] / dt
        );
        assert!((found.rms / kalman.velocity_variance.sqrt() - 1.0).abs() < 0.03);
    }
}

//! The bias of a calibrated accelerometer, tracked on line from moments at which the acceleration is known.

use crate::state_space::{Innovation, Reading, predict, predict_covariance, update};
use crate::velocity::BiasModel;
use crate::{Error, Float};

/// Kalman filter of the bias of one axis.
///
/// Between updates the bias moves by its model, ḃ = −b/τ + w (first-order Gauss–Markov) or ḃ = w (random walk). An update
/// is a sample at which the true acceleration is known: gravity along the axis while the sensor rests in a known
/// attitude, or zero motion where gravity does not reach. It is the filter of [`state_space`](crate::state_space) with one state.
///
/// ```text
/// b⁻ = φ b,  P⁻ = φ² P + Q        φ = e^{−T/τ}, Q = σ²(1 − φ²);  φ = 1, Q = q T for the random walk
/// K = P⁻/(P⁻ + R),  b = b⁻ + K (ã − a − b⁻),  P = P⁻ R/(P⁻ + R)
/// ```
///
/// The model is linear, so that the extended filter of the literature is this one.
///
/// **Units** accelerations in m/s², time in s. **Accuracy** its covariance holds: normalised errors and white innovations
/// in `coverage_of_the_stated_covariance`.
/// **Source** `[BarShalom01]` ch. 5; noise from `proofmass noise`.
///
/// ```
/// use proofmass_core::{BiasFilter, velocity::BiasModel};
///
/// let model = BiasModel::GaussMarkov { deviation: 3e-3, time: 300.0 };
/// let (filter, mut state) = BiasFilter::<f32>::new(model, 1e-4, 0.01)?;
/// for _ in 0..2000 {
///     filter.predict(&mut state);
///     filter.update(&mut state, 9.8126, 9.8066); // gravity is known, 6 mm/s² too much are read
/// }
/// assert!((state.bias() - 6e-3).abs() < 1e-4);
/// assert!((filter.correct(&state, 9.8126) - 9.8066).abs() < 1e-4);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias("EKF", "zero-velocity update", "ZUPT"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasFilter<F> {
    keep: [[F; 1]; 1],
    process: [[F; 1]; 1],
    noise: F,
}

/// Bias and its variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasState<F> {
    bias: [F; 1],
    variance: [[F; 1]; 1],
}

impl<F: Float> BiasState<F> {
    /// A state that is known: a bias in m/s² and its variance in (m/s²)².
    pub const fn known(bias: F, variance: F) -> Self {
        Self {
            bias: [bias],
            variance: [[variance]],
        }
    }

    /// Estimate of the bias, m/s².
    pub fn bias(&self) -> F {
        self.bias[0]
    }

    /// Its variance, (m/s²)².
    pub fn variance(&self) -> F {
        self.variance[0][0]
    }
}

impl<F: Float> BiasFilter<F> {
    /// Designs the filter in double precision: model of the bias, variance of a sample in (m/s²)², time between samples in s.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a time, variance or deviation without meaning.
    pub fn new(
        model: BiasModel,
        sample_variance: f64,
        period: f64,
    ) -> Result<(Self, BiasState<F>), Error> {
        let (keep, process) = match model {
            BiasModel::RandomWalk { density, initial } => {
                check("density of the random walk", density, true)?;
                check("initial deviation of the bias", initial, false)?;
                (1.0, density * period)
            }
            BiasModel::GaussMarkov { deviation, time } => {
                check("deviation of the bias", deviation, false)?;
                check("correlation time of the bias", time, false)?;
                // 1 − φ² without cancellation.
                (
                    libm::exp(-period / time),
                    -deviation * deviation * libm::expm1(-2.0 * period / time),
                )
            }
        };
        check("variance of a sample", sample_variance, false)?;
        check("time between samples", period, false)?;
        let initial = model.initial();
        Ok((
            Self::constant(
                F::from_f64(keep),
                F::from_f64(process),
                F::from_f64(sample_variance),
            ),
            BiasState::known(F::ZERO, F::from_f64(initial * initial)),
        ))
    }

    /// From exported coefficients: φ, Q in (m/s²)² and R in (m/s²)² of one sampling period.
    pub const fn constant(keep: F, process: F, noise: F) -> Self {
        Self {
            keep: [[keep]],
            process: [[process]],
            noise,
        }
    }

    /// φ, Q and R, as [`BiasFilter::constant`] takes them.
    pub fn coefficients(&self) -> [F; 3] {
        [self.keep[0][0], self.process[0][0], self.noise]
    }

    /// One sampling period passes.
    #[inline]
    pub fn predict(&self, state: &mut BiasState<F>) {
        state.bias = predict(&self.keep, &state.bias, [F::ZERO]);
        state.variance = predict_covariance(&self.keep, &state.variance, &self.process);
    }

    /// A sample at which the true acceleration is known, zero without motion where gravity does not reach.
    #[inline]
    pub fn update(&self, state: &mut BiasState<F>, measured: F, known: F) -> Innovation<F> {
        update(
            &mut state.bias,
            &mut state.variance,
            Reading::State(0),
            measured - known,
            self.noise,
        )
    }

    /// The measurement without the bias.
    #[inline]
    pub fn correct(&self, state: &BiasState<F>, measured: F) -> F {
        measured - state.bias[0]
    }
}

fn check(name: &'static str, value: f64, zero: bool) -> Result<(), Error> {
    let least = if zero { 0.0 } else { f64::MIN_POSITIVE };
    if value >= least && value.is_finite() {
        Ok(())
    } else {
        Err(Error::OutOfRange {
            name,
            value,
            min: least,
            max: f64::MAX,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Noise(u64);

    impl Noise {
        /// Sum of twelve uniform numbers: normal enough for second moments, variance one.
        fn draw(&mut self) -> f64 {
            let mut sum = -6.0;
            for _ in 0..12 {
                self.0 = self
                    .0
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                sum += (self.0 >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        }
    }

    /// Over 400 runs: (b̂ − b)²/P averages one, innovations have their stated variance and no correlation.
    #[test]
    fn coverage_of_the_stated_covariance() {
        let (period, sigma, tau, noise) = (0.1, 2e-3, 60.0, 1e-2);
        let models = [
            BiasModel::GaussMarkov {
                deviation: sigma,
                time: tau,
            },
            BiasModel::RandomWalk {
                density: 1e-8,
                initial: sigma,
            },
        ];
        for model in models {
            let (mut nees, mut innovations, mut products, mut count) = (0.0, 0.0, 0.0, 0u32);
            let runs = 400;
            for run in 0..runs {
                let mut n = Noise(run * 7919 + 1);
                let (filter, mut state) =
                    BiasFilter::<f64>::new(model, noise * noise, period).unwrap();
                let mut bias = sigma * n.draw();
                let mut last = 0.0;
                for step in 0..600 {
                    bias = match model {
                        BiasModel::GaussMarkov { deviation, time } => {
                            let keep = (-period / time).exp();
                            keep * bias + deviation * (1.0 - keep * keep).sqrt() * n.draw()
                        }
                        BiasModel::RandomWalk { density, .. } => {
                            bias + (density * period).sqrt() * n.draw()
                        }
                    };
                    filter.predict(&mut state);
                    // At rest for two thirds of the time.
                    if step % 300 < 200 {
                        let i = filter.update(&mut state, 9.8 + bias + noise * n.draw(), 9.8);
                        let z = i.value / i.variance.sqrt();
                        innovations += z * z;
                        products += z * last;
                        count += 1;
                        last = z;
                    }
                }
                nees += (state.bias() - bias).powi(2) / state.variance();
            }
            let nees = nees / runs as f64;
            // χ² of 400 degrees over 400: standard deviation √(2/400) = 0.07, four of them.
            assert!((nees - 1.0).abs() < 0.28, "{nees}");
            let m = f64::from(count);
            assert!((innovations / m - 1.0).abs() < 4.0 * (2.0 / m).sqrt());
            assert!((products / m).abs() < 4.0 / m.sqrt(), "{}", products / m);
        }
    }

    /// In single precision too: a million updates without a variance that runs away or turns negative.
    #[test]
    fn law_variance_stays_positive_in_single_precision() {
        let model = BiasModel::RandomWalk {
            density: 1e-12,
            initial: 1.0,
        };
        let (filter, mut state) = BiasFilter::<f32>::new(model, 1e-8, 1e-3).unwrap();
        let (double, mut exact) = BiasFilter::<f64>::new(model, 1e-8, 1e-3).unwrap();
        for _ in 0..1_000_000 {
            filter.predict(&mut state);
            filter.update(&mut state, 0.01, 0.0);
            double.predict(&mut exact);
            double.update(&mut exact, 0.01, 0.0);
            assert!(state.variance() > 0.0);
        }
        // The steady state is held to the digits of single precision.
        let ratio = f64::from(state.variance()) / exact.variance();
        assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
        assert!((state.bias() - 0.01).abs() < 1e-6);
    }

    #[test]
    fn refuses_meaningless_noise() {
        let walk = |density, initial| BiasModel::RandomWalk { density, initial };
        assert!(BiasFilter::<f32>::new(walk(-1.0, 1.0), 1.0, 1.0).is_err());
        assert!(BiasFilter::<f32>::new(walk(0.0, 0.0), 1.0, 1.0).is_err());
        assert!(BiasFilter::<f32>::new(walk(0.0, 1.0), 0.0, 1.0).is_err());
        assert!(BiasFilter::<f32>::new(walk(0.0, 1.0), 1.0, f64::NAN).is_err());
    }
}

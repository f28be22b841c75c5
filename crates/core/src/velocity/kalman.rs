//! The Kalman filter of position and acceleration, with an optional offset of the accelerometer as third state.

use super::{not_negative, positive};
use crate::state_space::{Gain, Innovation, Reading, predict, predict_covariance, update};
use crate::{Error, Float};

/// How the acceleration is taken between two samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[doc(alias = "interpolation")]
#[doc(alias = "zero-order hold")]
pub enum Hold {
    /// The older sample holds: G = [T²/2, T]ᵀ on a_{n−1}. The textbook; late by T/2 on the acceleration.
    Zero,
    /// A straight line from a_{n−1} to a_n: [T²/3, T/2]ᵀ a_{n−1} + [T²/6, T/2]ᵀ a_n. No delay; a motion of ω loses
    /// (ωT)²/12 of its velocity.
    First,
    /// The parabola through a_{n−2}, a_{n−1} and a_n: [5T²/12, 2T/3]ᵀ a_{n−1} + [T²/8, 5T/12]ᵀ a_n
    /// − [T²/24, T/12]ᵀ a_{n−2}, Adams and Moulton's third-order rule. Phase error (ωT)³/24. Off line, where the
    /// samples after a step are at hand, smoothers take the polynomial of fifth degree through the three before and
    /// after instead: at ten samples per period the line loses 3 % of the velocity, the parabola 1 %, the fifth degree
    /// 0.02 %.
    #[default]
    Second,
}

/// Form of the process noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ProcessNoise {
    /// One random acceleration per sample: q [[T⁴/4, T³/2],[T³/2, T²]], q in (m/s²)².
    #[default]
    SampleConstant,
    /// White acceleration in continuous time: q [[T³/3, T²/2],[T²/2, T]], q in (m/s²)²/Hz, two-sided.
    Continuous,
}

/// Noise of the two sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionNoise {
    /// q: variance of an acceleration sample, or its two-sided density, after `form`.
    pub acceleration: f64,
    /// What q means.
    pub form: ProcessNoise,
    /// R: variance of a position reading, δ²/12 for an encoder.
    pub position: f64,
}

impl MotionNoise {
    /// Refuses noise that no filter of this sample time has.
    pub(super) fn check(&self, sample_time: f64) -> Result<(), Error> {
        positive("sample time", sample_time)?;
        not_negative("acceleration noise", self.acceleration)?;
        positive("position noise", self.position)?;
        Ok(())
    }
}

/// How the accelerometer's offset moves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case", tag = "model")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum BiasModel {
    /// Random walk driven by white noise of this two-sided density, (m/s³)²/Hz; 0 for a constant.
    RandomWalk {
        /// Density of the driving noise.
        density: f64,
        /// Standard deviation of the offset at the start, m/s².
        initial: f64,
    },
    /// First-order Gauss–Markov process: standard deviation in m/s² and correlation time in s.
    GaussMarkov {
        /// Standard deviation.
        deviation: f64,
        /// Correlation time.
        time: f64,
    },
}

impl BiasModel {
    /// Standard deviation of the offset before the first sample.
    pub fn initial(&self) -> f64 {
        match *self {
            Self::RandomWalk { initial, .. } => initial,
            Self::GaussMarkov { deviation, .. } => deviation,
        }
    }

    /// The same with every variance multiplied.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        let root = libm::sqrt(factor);
        match self {
            Self::RandomWalk { density, initial } => Self::RandomWalk {
                density: density * factor,
                initial: initial * root,
            },
            Self::GaussMarkov { deviation, time } => Self::GaussMarkov {
                deviation: deviation * root,
                time,
            },
        }
    }
}

/// Kalman filter with state [x, v] (N = 2) or [x, v, offset] (N = 3).
///
/// x⁻ = F x + G₀ a_{n−1} + G₁ a_n + G₂ a_{n−2}, P⁻ = F P Fᵀ + Q; K = P⁻Hᵀ/(H P⁻ Hᵀ + R), H = [1, 0, …];
/// P = (I − K H) P⁻: the filter of
/// [`state_space`](crate::state_space).
///
/// **Delay** none. **Steady-state error** for an offset b: that of an observer with its gains (N = 2), zero (N = 3).
/// **Assumes** white noise of both sensors. Encoder quantisation is white once the axis crosses an increment or
/// more per sample; in slow motion it is not, and [`Innovation`]s show it.
/// **Source** `[BarShalom01]` ch. 6 for both noise forms; `[Kalata84]` for the steady state.
///
/// ```
/// use proofmass_core::velocity::*;
/// let noise = MotionNoise { acceleration: 0.01, form: ProcessNoise::SampleConstant, position: 1e-6 };
/// let kalman = Kalman::<f64, 2>::new(&noise, Hold::First, 0.01)?;
/// let mut state = KalmanState::new([0.0, 0.0], [1.0, 1.0], 2.0);
/// for n in 1..=300 { let t = 0.01 * n as f64; kalman.step(&mut state, Some(t * t), 2.0); }
/// assert!((state.x[1] - 6.0).abs() < 1e-6);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias("Kalman filter", "EKF", "state estimator"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Kalman<T, const N: usize> {
    /// Transition F.
    pub f: [[T; N]; N],
    /// Input G₀ of the older, G₁ of the newer and G₂ of the oldest acceleration.
    pub g: [[T; N]; 3],
    /// Process noise Q of one step.
    pub q: [[T; N]; N],
    /// Measurement noise R.
    pub r: T,
}

/// Mean and covariance of the state, and the last accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KalmanState<T, const N: usize> {
    /// Position, velocity and, for N = 3, offset.
    pub x: [T; N],
    /// Their covariance P.
    pub p: [[T; N]; N],
    /// Accelerations of the last sample and of the one before.
    pub acceleration: [T; 2],
}

impl<T: Float, const N: usize> KalmanState<T, N> {
    /// Starts from a state with these variances and the acceleration of the first sample.
    pub fn new(x: [T; N], variances: [T; N], acceleration: T) -> Self {
        let mut p = [[T::ZERO; N]; N];
        for i in 0..N {
            p[i][i] = variances[i];
        }
        Self {
            x,
            p,
            acceleration: [acceleration; 2],
        }
    }

    /// Standard uncertainty of the velocity.
    pub fn velocity_uncertainty(&self) -> T {
        self.p[1][1].sqrt()
    }
}

/// G₀, G₁, G₂ and Q of [x, v].
type Motion = ([[f64; 2]; 3], [[f64; 2]; 2]);

/// G₀, G₁, G₂, and Q, of [x, v] in double precision.
fn motion(noise: &MotionNoise, hold: Hold, t: f64) -> Result<Motion, Error> {
    noise.check(t)?;
    let q = noise.acceleration;
    let g = match hold {
        Hold::Zero => [[0.5 * t * t, t], [0.0; 2], [0.0; 2]],
        Hold::First => [[t * t / 3.0, 0.5 * t], [t * t / 6.0, 0.5 * t], [0.0; 2]],
        Hold::Second => [
            [5.0 * t * t / 12.0, 2.0 * t / 3.0],
            [t * t / 8.0, 5.0 * t / 12.0],
            [-t * t / 24.0, -t / 12.0],
        ],
    };
    let [xx, xv, vv] = match noise.form {
        ProcessNoise::SampleConstant => [t * t * t * t / 4.0, t * t * t / 2.0, t * t],
        ProcessNoise::Continuous => [t * t * t / 3.0, t * t / 2.0, t],
    };
    Ok((g, [[q * xx, q * xv], [q * xv, q * vv]]))
}

/// G₀ a_{n−1} + G₁ a_n + G₂ a_{n−2}.
fn input<T: Float, const N: usize>(g: &[[T; N]; 3], before: &[T; 2], now: T) -> [T; N] {
    core::array::from_fn(|i| g[0][i] * before[0] + g[1][i] * now + g[2][i] * before[1])
}

impl<T: Float> Kalman<T, 2> {
    /// Position and velocity.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a sample time or R that is not positive, or a negative q.
    pub fn new(noise: &MotionNoise, hold: Hold, sample_time: f64) -> Result<Self, Error> {
        let (g, q) = motion(noise, hold, sample_time)?;
        Ok(Kalman {
            f: [[1.0, sample_time], [0.0, 1.0]],
            g,
            q,
            r: noise.position,
        }
        .cast())
    }
}

impl<T: Float> Kalman<T, 2> {
    /// The same filter for the time that passed since the last sample, where samples do not come evenly; `form` is that of
    /// its noise.
    ///
    /// Every element is a power of the time; the parabola through three accelerations is that of even samples.
    #[must_use]
    pub fn after(&self, time: T, form: ProcessNoise) -> Self {
        let one = if time > T::ZERO { time } else { T::ZERO } / self.f[0][1];
        let two = one * one;
        let q = match form {
            ProcessNoise::SampleConstant => [two * two, two * one, two],
            ProcessNoise::Continuous => [two * one, two, one],
        };
        Self {
            f: [[T::ONE, self.f[0][1] * one], [T::ZERO, T::ONE]],
            g: self.g.map(|g| [g[0] * two, g[1] * one]),
            q: [
                [self.q[0][0] * q[0], self.q[0][1] * q[1]],
                [self.q[1][0] * q[1], self.q[1][1] * q[2]],
            ],
            r: self.r,
        }
    }
}

impl<T: Float> Kalman<T, 3> {
    /// Position, velocity and offset: the accelerometer reads the acceleration plus the offset.
    ///
    /// # Errors
    /// As [`Kalman::new`]; also for a negative density or deviation, or a correlation time that is not positive.
    pub fn with_bias(
        noise: &MotionNoise,
        bias: BiasModel,
        hold: Hold,
        sample_time: f64,
    ) -> Result<Self, Error> {
        let (g, q) = motion(noise, hold, sample_time)?;
        let t = sample_time;
        // φ, ∫φ and ∬φ over a step, and the density of the walk inside one step.
        let (phi, once, twice, s) = match bias {
            BiasModel::RandomWalk { density, .. } => {
                (1.0, t, 0.5 * t * t, not_negative("bias density", density)?)
            }
            BiasModel::GaussMarkov { deviation, time } => {
                not_negative("bias deviation", deviation)?;
                let tau = positive("correlation time", time)?;
                let phi = libm::exp(-t / tau);
                let once = -tau * libm::expm1(-t / tau);
                // τ(T − τ(1 − φ)) loses all digits for T ≪ τ; its series does not.
                let ratio = t / tau;
                let twice = if ratio < 1e-3 {
                    t * t * (0.5 - ratio / 6.0 + ratio * ratio / 24.0)
                } else {
                    tau * (t - once)
                };
                let s = -deviation * deviation * libm::expm1(-2.0 * ratio) / t;
                (phi, once, twice, s)
            }
        };
        let [xx, xv, xb] = [t.powi5() / 20.0, t * t * t * t / 8.0, -t * t * t / 6.0];
        let [vv, vb] = [t * t * t / 3.0, -t * t / 2.0];
        Ok(Kalman {
            f: [[1.0, t, -twice], [0.0, 1.0, -once], [0.0, 0.0, phi]],
            g: g.map(|g| [g[0], g[1], 0.0]),
            q: [
                [q[0][0] + s * xx, q[0][1] + s * xv, s * xb],
                [q[1][0] + s * xv, q[1][1] + s * vv, s * vb],
                [s * xb, s * vb, s * t],
            ],
            r: noise.position,
        }
        .cast())
    }
}

/// Fifth power; `core` has no `powi`.
trait FifthPower {
    fn powi5(self) -> f64;
}
impl FifthPower for f64 {
    fn powi5(self) -> f64 {
        let square = self * self;
        square * square * self
    }
}

impl<T: Float, const N: usize> Kalman<T, N> {
    /// The same filter in another precision.
    pub fn cast<U: Float>(&self) -> Kalman<U, N> {
        let to = |v: T| U::from_f64(v.to_f64());
        Kalman {
            f: self.f.map(|row| row.map(to)),
            g: self.g.map(|row| row.map(to)),
            q: self.q.map(|row| row.map(to)),
            r: to(self.r),
        }
    }

    /// Time update to the sample with this acceleration.
    pub fn predict(&self, state: &mut KalmanState<T, N>, acceleration: T) {
        let input = input(&self.g, &state.acceleration, acceleration);
        self.predict_by(state, input);
        state.acceleration = [acceleration, state.acceleration[0]];
    }

    /// Time update with what the acceleration does to the state over the step already known, as off line, where
    /// the samples after it are at hand.
    pub fn predict_by(&self, state: &mut KalmanState<T, N>, input: [T; N]) {
        state.x = predict(&self.f, &state.x, input);
        state.p = predict_covariance(&self.f, &state.p, &self.q);
    }

    /// Measurement update with a position.
    pub fn update(&self, state: &mut KalmanState<T, N>, position: T) -> Innovation<T> {
        let shown = Reading::State(0);
        update(&mut state.x, &mut state.p, shown, position, self.r)
    }

    /// Measurement update with a state that is read directly: 0 a position, 1 a wheel speed or a tachometer, whose variance is R.
    ///
    /// # Panics
    /// When `component` is not below N.
    pub fn update_state(
        &self,
        state: &mut KalmanState<T, N>,
        component: usize,
        reading: T,
    ) -> Innovation<T> {
        let shown = Reading::State(component);
        update(&mut state.x, &mut state.p, shown, reading, self.r)
    }

    /// Time update, then measurement update when a position came.
    pub fn step(
        &self,
        state: &mut KalmanState<T, N>,
        position: Option<T>,
        acceleration: T,
    ) -> Option<Innovation<T>> {
        self.predict(state, acceleration);
        position.map(|p| self.update(state, p))
    }

    /// The constant gain a filter with a position at every sample settles to, for firmware.
    ///
    /// # Errors
    /// [`Error::NotConverged`] when the gain still moves by more than 1e-12 of itself after 10⁶ steps, as it does
    /// with an acceleration noise of zero.
    pub fn steady(&self) -> Result<SteadyKalman<T, N>, Error> {
        self.steady_for(0)
    }

    /// The same for readings of another state: component 1 for a speed, whose noise is then R.
    ///
    /// # Errors
    /// As [`steady`](Self::steady); [`Error::OutOfRange`] for a component other than 0 and 1.
    pub fn steady_for(&self, component: usize) -> Result<SteadyKalman<T, N>, Error> {
        const LIMIT: usize = 1_000_000;
        if component > 1 {
            return Err(Error::OutOfRange {
                name: "component",
                value: component as f64,
                min: 0.0,
                max: 1.0,
            });
        }
        // Speeds leave the position to itself: its variance grows and its gain tells nothing about convergence.
        let first = component;
        let filter: Kalman<f64, N> = self.cast();
        let mut state = KalmanState::new([0.0; N], [filter.r; N], 0.0);
        let mut last = [0.0; N];
        let mut change = f64::INFINITY;
        for _ in 0..LIMIT {
            filter.predict(&mut state, 0.0);
            let gain = Gain::new(Reading::State(component), &state.p, filter.r);
            gain.reduce(&mut state.p);
            let k = gain.k;
            change = 0.0;
            for i in first..N {
                change = f64::max(change, libm::fabs(k[i] - last[i]) / libm::fabs(k[i]));
            }
            last = k;
            if change < 1e-12 {
                return Ok(SteadyKalman {
                    f: self.f,
                    g: self.g,
                    k: k.map(T::from_f64),
                    component,
                    velocity_variance: T::from_f64(state.p[1][1]),
                });
            }
        }
        Err(Error::NotConverged {
            name: "steady gain",
            iterations: LIMIT,
            step: change,
        })
    }
}

/// The filter with its steady gain: no covariance, a handful of multiplications per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyKalman<T, const N: usize> {
    /// Transition F.
    pub f: [[T; N]; N],
    /// Inputs G₀, G₁, G₂.
    pub g: [[T; N]; 3],
    /// Gain K.
    pub k: [T; N],
    /// State that is read: 0 the position, 1 the speed.
    pub component: usize,
    /// Steady variance of the velocity after a reading.
    pub velocity_variance: T,
}

impl<T: Float, const N: usize> SteadyKalman<T, N> {
    /// One sample; returns the velocity. The covariance in the state is left as it is.
    pub fn step(&self, state: &mut KalmanState<T, N>, reading: Option<T>, acceleration: T) -> T {
        let input = input(&self.g, &state.acceleration, acceleration);
        let mut x = predict(&self.f, &state.x, input);
        if let Some(reading) = reading {
            let innovation = reading - x[self.component];
            for i in 0..N {
                x[i] += self.k[i] * innovation;
            }
        }
        state.x = x;
        state.acceleration = [acceleration, state.acceleration[0]];
        x[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(q: f64, r: f64, form: ProcessNoise) -> MotionNoise {
        MotionNoise {
            acceleration: q,
            form,
            position: r,
        }
    }

    #[test]
    fn law_after_is_the_filter_of_that_sample_time() {
        for form in [ProcessNoise::SampleConstant, ProcessNoise::Continuous] {
            let of = |t| Kalman::<f64, 2>::new(&noise(0.3, 1e-6, form), Hold::First, t).unwrap();
            let (ours, theirs) = (of(0.01).after(0.004, form), of(0.004));
            for i in 0..2 {
                for j in 0..2 {
                    for (a, b) in [
                        (ours.f[i][j], theirs.f[i][j]),
                        (ours.q[i][j], theirs.q[i][j]),
                    ] {
                        assert!((a - b).abs() <= 1e-14 * b.abs(), "{a} {b}");
                    }
                    assert!((ours.g[i][j] - theirs.g[i][j]).abs() <= 1e-14 * theirs.g[i][j].abs());
                }
            }
        }
    }

    #[test]
    fn published_steady_gains_of_the_tracking_index() {
        // `[Kalata84]`: Λ = T² σ_w/σ_v; α = −(Λ² + 8Λ − (Λ + 4)√(Λ² + 8Λ))/8, β = (Λ² + 4Λ − Λ√(Λ² + 8Λ))/4.
        for (q, r, t) in [(1.0, 1.0, 1.0), (4.0, 1e-6, 0.01), (0.01, 1e-4, 0.001)] {
            let index: f64 = t * t * f64::sqrt(q / r);
            let root = (index * index + 8.0 * index).sqrt();
            let alpha = -(index * index + 8.0 * index - (index + 4.0) * root) / 8.0;
            let beta = (index * index + 4.0 * index - index * root) / 4.0;
            let filter =
                Kalman::<f64, 2>::new(&noise(q, r, ProcessNoise::SampleConstant), Hold::Zero, t)
                    .unwrap();
            let k = filter.steady().unwrap().k;
            // The iteration ends at 1e-12 a step, which for slow filters is 1e-12 × steps from the limit.
            assert!((k[0] / alpha - 1.0).abs() < 1e-8, "{} {alpha}", k[0]);
            assert!((k[1] * t / beta - 1.0).abs() < 1e-8, "{} {beta}", k[1] * t);
        }
    }

    #[test]
    fn law_steady_filter_is_an_observer_of_damping_root_half() {
        // Continuous limit: k_v = √(q/R_c), k_x = √(2 k_v), with R_c = R T the density of the readings.
        let (q, r, t) = (1e-4, 1e-6, 1e-4);
        let filter =
            Kalman::<f64, 2>::new(&noise(q, r, ProcessNoise::Continuous), Hold::First, t).unwrap();
        let k = filter.steady().unwrap().k;
        let k_v = f64::sqrt(q / (r * t));
        let k_x = (2.0 * k_v).sqrt();
        assert!((k[1] / t / k_v - 1.0).abs() < 0.01, "{} {k_v}", k[1] / t);
        assert!((k[0] / t / k_x - 1.0).abs() < 0.01, "{} {k_x}", k[0] / t);
    }

    #[test]
    fn law_steady_and_full_filter_agree_after_the_transient() {
        let full = Kalman::<f64, 3>::with_bias(
            &noise(0.01, 1e-6, ProcessNoise::SampleConstant),
            BiasModel::GaussMarkov {
                deviation: 0.1,
                time: 50.0,
            },
            Hold::First,
            0.01,
        )
        .unwrap();
        let steady = full.steady().unwrap();
        let mut a = KalmanState::new([0.0, 1.0, 0.0], [1e-6, 1e-6, 1e-2], 0.0);
        let mut b = a;
        for n in 1..5000 {
            let t = 0.01 * n as f64;
            full.step(&mut a, Some(t.sin()), 0.2 - t.sin());
            steady.step(&mut b, Some(t.sin()), 0.2 - t.sin());
        }
        assert!((a.x[1] - b.x[1]).abs() < 1e-9);
        assert!((a.p[1][1] / steady.velocity_variance - 1.0).abs() < 1e-8);
        assert!((a.x[2] - 0.2).abs() < 0.02, "offset {}", a.x[2]);
    }

    #[test]
    fn law_steady_gain_of_a_speed_is_the_scalar_filter() {
        // v alone: P⁺ = P + qT², K = P⁺/(P⁺ + R); P = (−qT² + √(q²T⁴ + 4 qT² R))/2.
        let (q, r, t) = (0.04, 1e-3, 0.01);
        let filter =
            Kalman::<f64, 2>::new(&noise(q, r, ProcessNoise::SampleConstant), Hold::First, t)
                .unwrap();
        let steady = filter.steady_for(1).unwrap();
        let step = q * t * t;
        let p = 0.5 * (-step + (step * step + 4.0 * step * r).sqrt());
        let k = (p + step) / (p + step + r);
        assert!((steady.k[1] - k).abs() < 1e-9, "{} {k}", steady.k[1]);
        assert!((steady.velocity_variance / p - 1.0).abs() < 1e-6);
        assert!(filter.steady_for(2).is_err());
    }

    #[test]
    fn law_gauss_markov_becomes_the_random_walk() {
        // σ²·2/τ is the density of the walk for T ≪ τ; the other terms agree to T/τ.
        let n = noise(0.0, 1.0, ProcessNoise::Continuous);
        let walk = BiasModel::RandomWalk {
            density: 2e-6,
            initial: 0.0,
        };
        let markov = BiasModel::GaussMarkov {
            deviation: 1.0,
            time: 1e6,
        };
        let a = Kalman::<f64, 3>::with_bias(&n, walk, Hold::Zero, 0.1).unwrap();
        let b = Kalman::<f64, 3>::with_bias(&n, markov, Hold::Zero, 0.1).unwrap();
        for i in 0..3 {
            for j in 0..3 {
                assert!((a.f[i][j] - b.f[i][j]).abs() < 1e-6 * a.f[i][j].abs() + 1e-300);
                assert!((a.q[i][j] - b.q[i][j]).abs() < 1e-6 * a.q[i][j].abs());
            }
        }
    }

    #[test]
    fn law_covariance_stays_positive_in_single_precision() {
        let filter = Kalman::<f32, 3>::with_bias(
            &noise(1e-4, 8e-7, ProcessNoise::SampleConstant),
            BiasModel::RandomWalk {
                density: 1e-8,
                initial: 0.0,
            },
            Hold::First,
            1e-3,
        )
        .unwrap();
        let mut state = KalmanState::new([0.0; 3], [1.0; 3], 0.0);
        for n in 0..50_000 {
            let reading = (n % 7 == 0).then_some(0.0);
            filter.step(&mut state, reading, 0.01);
            let p = state.p;
            assert!(p[0][0] > 0.0 && p[1][1] > 0.0 && p[2][2] > 0.0, "{n}");
            assert!(p[0][1] * p[0][1] <= p[0][0] * p[1][1] * 1.0001, "{n}");
        }
    }

    #[test]
    fn law_a_parabola_of_acceleration_is_integrated_exactly() {
        let n = noise(0.0, 1.0, ProcessNoise::Continuous);
        let filter = Kalman::<f64, 2>::new(&n, Hold::Second, 0.1).unwrap();
        let mut state = KalmanState::new([0.0; 2], [0.0; 2], 0.0);
        // a = t², v = t³/3, x = t⁴/12, begun where three samples are known: a(−0.1) = 0.01.
        state.acceleration = [0.0, 0.01];
        for k in 1..=20 {
            let t = 0.1 * f64::from(k);
            filter.predict(&mut state, t * t);
        }
        assert!((state.x[1] - 8.0 / 3.0).abs() < 1e-13, "{}", state.x[1]);
        assert!((state.x[0] - 16.0 / 12.0).abs() < 1e-13, "{}", state.x[0]);
    }

    #[test]
    fn refuses_meaningless_noise() {
        let n = noise(1.0, 0.0, ProcessNoise::Continuous);
        assert!(Kalman::<f64, 2>::new(&n, Hold::Zero, 0.1).is_err());
        let n = noise(-1.0, 1.0, ProcessNoise::Continuous);
        assert!(Kalman::<f64, 2>::new(&n, Hold::Zero, 0.1).is_err());
        let still = noise(0.0, 1.0, ProcessNoise::Continuous);
        let filter = Kalman::<f64, 2>::new(&still, Hold::Zero, 0.1).unwrap();
        assert!(matches!(filter.steady(), Err(Error::NotConverged { .. })));
    }
}

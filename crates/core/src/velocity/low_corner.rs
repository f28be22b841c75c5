//! The low-frequency corner of the accelerometer as states of the Kalman filter of velocity.

use super::{Hold, Kalman, MotionNoise, ProcessNoise, not_negative, positive};
use crate::{Error, Float};

impl<T: Float> Kalman<T, 4> {
    /// Position, velocity, what the accelerometer has shown of the velocity, and its offset: of an accelerometer whose output falls below a
    /// corner of first order in Hz, as of a charge amplifier or an AC coupling.
    ///
    /// Of an acceleration a it reads y = a − ω s + b with s' = y − b and ω = 2π times the corner: s is the integral of what it showed, and ω s
    /// what it lost. Readings of the position tell s and b, so that neither grows, whereas y + ω ∫ y dt grows with every offset. The offset
    /// b behind the corner walks with this two-sided density, (m/s³)²/Hz.
    ///
    /// ```
    /// use proofmass_core::velocity::*;
    /// let noise = MotionNoise { acceleration: 1e-4, form: ProcessNoise::SampleConstant, position: 1e-8 };
    /// let kalman = Kalman::<f64, 4>::with_low_corner(&noise, 1e-6, 0.5, Hold::Second, 0.001)?;
    /// // 2 m/s² from rest through a corner of 0.5 Hz: the output falls, and the velocity is found.
    /// let y = |t: f64| 2.0 * (-core::f64::consts::PI * t).exp();
    /// let mut state = KalmanState::new([0.0; 4], [1e-6, 1e-6, 1.0, 1e-4], 2.0);
    /// for n in 1..=2000 { let t = 0.001 * n as f64; kalman.step(&mut state, Some(t * t), y(t)); }
    /// assert!((state.x[1] - 4.0).abs() < 1e-3);
    /// # Ok::<(), proofmass_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Kalman::new`]; a corner that is not positive, a negative density.
    pub fn with_low_corner(
        noise: &MotionNoise,
        walk: f64,
        corner: f64,
        hold: Hold,
        sample_time: f64,
    ) -> Result<Self, Error> {
        let rates = |w| {
            [
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, w, -1.0],
                [0.0, 0.0, 0.0, -1.0],
                [0.0; 4],
            ]
        };
        Ok(discrete(corner, rates, noise, walk, hold, sample_time)?.cast())
    }
}

impl<T: Float> Kalman<T, 5> {
    /// Position, velocity, what either stage has shown of the velocity, and the offset: of an accelerometer behind two stages of one corner
    /// in Hz, as of a charge amplifier before an AC coupling.
    ///
    /// Of an acceleration a it reads y = a − ω (s₁ + s₂) + b with s₁' = y − b behind both stages and s₂' = y − b + ω s₁ between them.
    ///
    /// ```
    /// use proofmass_core::velocity::*;
    /// let noise = MotionNoise { acceleration: 1e-4, form: ProcessNoise::SampleConstant, position: 1e-8 };
    /// let kalman = Kalman::<f64, 5>::with_second_order_corner(&noise, 1e-6, 0.5, Hold::Second, 0.001)?;
    /// // 2 m/s² from rest through both stages.
    /// let w = core::f64::consts::PI;
    /// let y = |t: f64| 2.0 * (1.0 - w * t) * (-w * t).exp();
    /// let mut state = KalmanState::new([0.0; 5], [1e-6, 1e-6, 1.0, 1.0, 1e-4], 2.0);
    /// for n in 1..=2000 { let t = 0.001 * n as f64; kalman.step(&mut state, Some(t * t), y(t)); }
    /// assert!((state.x[1] - 4.0).abs() < 1e-3);
    /// # Ok::<(), proofmass_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`with_low_corner`](Kalman::with_low_corner).
    pub fn with_second_order_corner(
        noise: &MotionNoise,
        walk: f64,
        corner: f64,
        hold: Hold,
        sample_time: f64,
    ) -> Result<Self, Error> {
        let rates = |w| {
            [
                [0.0, 1.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, w, w, -1.0],
                [0.0, 0.0, 0.0, 0.0, -1.0],
                [0.0, 0.0, w, 0.0, -1.0],
                [0.0; 5],
            ]
        };
        Ok(discrete(corner, rates, noise, walk, hold, sample_time)?.cast())
    }
}

/// Most states of such a filter.
const MOST_STATES: usize = 5;

/// The filter of one step of time of x' = A x − (last column of A) y, whose last state is the offset of y; A for ω = 2π times the corner.
///
/// Every state is an integral of others, so that Aᴺ = 0 and all of it is a polynomial of the time.
fn discrete<const N: usize>(
    corner: f64,
    rates: impl Fn(f64) -> [[f64; N]; N],
    noise: &MotionNoise,
    walk: f64,
    hold: Hold,
    t: f64,
) -> Result<Kalman<f64, N>, Error> {
    let rates = rates(core::f64::consts::TAU * positive("low corner", corner)?);
    noise.check(t)?;
    let walk = not_negative("bias density", walk)?;
    // tᵏ and 1/k!, as far as the square of the longest polynomial goes.
    let (mut power, mut share) = ([1.0; 2 * MOST_STATES], [1.0; 2 * MOST_STATES]);
    for k in 1..2 * MOST_STATES {
        power[k] = power[k - 1] * t;
        share[k] = share[k - 1] / k as f64;
    }
    // Aᵏ v, of which Aᵏ v τᵏ/k! is what a jump of the states by v has become after τ.
    let chain = |v: [f64; N]| {
        let mut terms = [v; N];
        for k in 1..N {
            let before = terms[k - 1];
            terms[k] = core::array::from_fn(|i| (0..N).map(|j| rates[i][j] * before[j]).sum());
        }
        terms
    };
    let columns: [[[f64; N]; N]; N] =
        core::array::from_fn(|j| chain(core::array::from_fn(|i| f64::from(u8::from(i == j)))));
    let by_walk = columns[N - 1];
    let by_noise = chain(core::array::from_fn(|i| -rates[i][N - 1]));
    // The (k + 1)-fold integral of the polynomial through the accelerations, over tᵏ⁺¹.
    let weights = |k: usize| match hold {
        Hold::Zero => [share[k + 1], 0.0, 0.0],
        Hold::First => [share[k + 1] - share[k + 2], share[k + 2], 0.0],
        Hold::Second => [
            share[k + 1] - 2.0 * share[k + 3],
            0.5 * share[k + 2] + share[k + 3],
            share[k + 3] - 0.5 * share[k + 2],
        ],
    };
    let held: [f64; N] = core::array::from_fn(|i| {
        let of = |k: usize| by_noise[k][i] * power[k + 1] * share[k + 1];
        (0..N).map(of).sum()
    });
    let product = |terms: &[[f64; N]; N], i: usize, j: usize| {
        let mut sum = 0.0;
        for k in 0..N {
            for l in 0..N {
                let both = terms[k][i] * share[k] * terms[l][j] * share[l];
                sum += both * power[k + l + 1] / (k + l + 1) as f64;
            }
        }
        sum
    };
    let table = |of: &dyn Fn(usize, usize) -> f64| -> [[f64; N]; N] {
        core::array::from_fn(|i| core::array::from_fn(|j| of(i, j)))
    };
    Ok(Kalman {
        f: table(&|i, j| {
            let of = |k: usize| columns[j][k][i] * power[k] * share[k];
            (0..N).map(of).sum()
        }),
        g: core::array::from_fn(|h| {
            core::array::from_fn(|i| {
                let of = |k: usize| by_noise[k][i] * power[k + 1] * weights(k)[h];
                (0..N).map(of).sum()
            })
        }),
        q: table(&|i, j| {
            let own = match noise.form {
                ProcessNoise::SampleConstant => held[i] * held[j],
                ProcessNoise::Continuous => product(&by_noise, i, j),
            };
            noise.acceleration * own + walk * product(&by_walk, i, j)
        }),
        r: noise.position,
    })
}

//! Velocity from acceleration alone: the integration rules as difference equations.

use super::positive;
use crate::{Error, Float};

/// Samples that the longest rule weighs.
const LONGEST: usize = 7;

/// Which quadrature rule integrates the acceleration.
///
/// v_n = v_{n−L} + T Σ b_k a_{n−k}
///
/// Closed rules of Newton and Cotes weigh both ends of L steps, open ones leave both out. With L > 1 there are L chains of velocities, and
/// poles at every L-th root of one: what the acceleration has near a multiple of rate/L is summed as if it were slow, and no
/// high-pass takes that away.
///
/// | rule | L | b₀, b₁, … | remark |
/// |---|---|---|---|
/// | trapezoid | 1 | ½, ½ | no phase error; gain (θ/2)/tan(θ/2) |
/// | Simpson | 2 | ⅓, 4/3, ⅓ | no phase error; second pole at z = −1: noise near Nyquist accumulates |
/// | three eighths | 3 | 3/8 (1, 3, 3, 1) | |
/// | Boole | 4 | 2/45 (7, 32, 12, 32, 7) | |
/// | closed, five steps | 5 | 5/288 (19, 75, 50, 50, 75, 19) | |
/// | closed, six steps | 6 | 1/140 (41, 216, 27, 272, 27, 216, 41) | |
/// | midpoint | 2 | 0, 2, 0 | open |
/// | open, three steps | 3 | 3/2 (0, 1, 1, 0) | |
/// | open, four steps (Milne) | 4 | 4/3 (0, 2, −1, 2, 0) | |
/// | open, five steps | 5 | 5/24 (0, 11, 1, 1, 11, 0) | |
/// | open, six steps | 6 | 3/10 (0, 11, −14, 26, −14, 11, 0) | |
/// | Tick | 2 | 0.3584, 1.2832, 0.3584 | as Simpson, flattest gain up to half of Nyquist |
/// | Adams–Moulton 3 | 1 | 5/12, 8/12, −1/12 | third order; phase error of order θ³/24 |
///
/// **Source** `[Hamming89]` on integration rules as recursive filters, Tick's among them; `[AS]` 25.4.2 to 25.4.24.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum IntegratorRule {
    /// v_n = v_{n−1} + T/2 (a_n + a_{n−1})
    Trapezoid,
    /// v_n = v_{n−2} + T/3 (a_n + 4 a_{n−1} + a_{n−2})
    Simpson,
    /// v_n = v_{n−3} + 3T/8 (a_n + 3 a_{n−1} + 3 a_{n−2} + a_{n−3})
    ThreeEighths,
    /// v_n = v_{n−4} + 2T/45 (7 a_n + 32 a_{n−1} + 12 a_{n−2} + 32 a_{n−3} + 7 a_{n−4})
    Boole,
    /// Closed rule over five steps.
    #[cfg_attr(feature = "serde", serde(rename = "closed-5"))]
    Closed5,
    /// Closed rule over six steps.
    #[cfg_attr(feature = "serde", serde(rename = "closed-6"))]
    Closed6,
    /// v_n = v_{n−2} + 2T a_{n−1}
    Midpoint,
    /// v_n = v_{n−3} + 3T/2 (a_{n−1} + a_{n−2})
    #[cfg_attr(feature = "serde", serde(rename = "open-3"))]
    Open3,
    /// v_n = v_{n−4} + 4T/3 (2 a_{n−1} − a_{n−2} + 2 a_{n−3})
    Milne,
    /// Open rule over five steps.
    #[cfg_attr(feature = "serde", serde(rename = "open-5"))]
    Open5,
    /// Open rule over six steps.
    #[cfg_attr(feature = "serde", serde(rename = "open-6"))]
    Open6,
    /// v_n = v_{n−2} + T (0.3584 a_n + 1.2832 a_{n−1} + 0.3584 a_{n−2})
    Tick,
    /// v_n = v_{n−1} + T/12 (5 a_n + 8 a_{n−1} − a_{n−2})
    #[cfg_attr(feature = "serde", serde(rename = "adams-moulton-3"))]
    AdamsMoulton3,
}

impl IntegratorRule {
    /// All rules, in the order of the table.
    pub const ALL: [Self; 13] = [
        Self::Trapezoid,
        Self::Simpson,
        Self::ThreeEighths,
        Self::Boole,
        Self::Closed5,
        Self::Closed6,
        Self::Midpoint,
        Self::Open3,
        Self::Milne,
        Self::Open5,
        Self::Open6,
        Self::Tick,
        Self::AdamsMoulton3,
    ];

    /// Stable lower-case name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Trapezoid => "trapezoid",
            Self::Simpson => "simpson",
            Self::ThreeEighths => "three-eighths",
            Self::Boole => "boole",
            Self::Closed5 => "closed-5",
            Self::Closed6 => "closed-6",
            Self::Midpoint => "midpoint",
            Self::Open3 => "open-3",
            Self::Milne => "milne",
            Self::Open5 => "open-5",
            Self::Open6 => "open-6",
            Self::Tick => "tick",
            Self::AdamsMoulton3 => "adams-moulton-3",
        }
    }

    /// Its name in a text.
    pub fn label(self) -> &'static str {
        match self {
            Self::Trapezoid => "trapezoid",
            Self::Simpson => "Simpson",
            Self::ThreeEighths => "three eighths",
            Self::Boole => "Boole",
            Self::Closed5 => "closed, five steps",
            Self::Closed6 => "closed, six steps",
            Self::Midpoint => "midpoint",
            Self::Open3 => "open, three steps",
            Self::Milne => "Milne",
            Self::Open5 => "open, five steps",
            Self::Open6 => "open, six steps",
            Self::Tick => "Tick",
            Self::AdamsMoulton3 => "Adams–Moulton 3",
        }
    }

    /// Step L back to the velocity that is continued, and the weights b₀, b₁, … of the newest acceleration and those before it.
    pub const fn weights(self) -> (usize, &'static [f64]) {
        match self {
            Self::Trapezoid => (1, &[0.5, 0.5]),
            Self::Simpson => (2, &[1.0 / 3.0, 4.0 / 3.0, 1.0 / 3.0]),
            Self::ThreeEighths => (3, &[3.0 / 8.0, 9.0 / 8.0, 9.0 / 8.0, 3.0 / 8.0]),
            Self::Boole => (
                4,
                &[
                    14.0 / 45.0,
                    64.0 / 45.0,
                    24.0 / 45.0,
                    64.0 / 45.0,
                    14.0 / 45.0,
                ],
            ),
            Self::Closed5 => (
                5,
                &[
                    95.0 / 288.0,
                    375.0 / 288.0,
                    250.0 / 288.0,
                    250.0 / 288.0,
                    375.0 / 288.0,
                    95.0 / 288.0,
                ],
            ),
            Self::Closed6 => (
                6,
                &[
                    41.0 / 140.0,
                    216.0 / 140.0,
                    27.0 / 140.0,
                    272.0 / 140.0,
                    27.0 / 140.0,
                    216.0 / 140.0,
                    41.0 / 140.0,
                ],
            ),
            Self::Midpoint => (2, &[0.0, 2.0]),
            Self::Open3 => (3, &[0.0, 1.5, 1.5]),
            Self::Milne => (4, &[0.0, 8.0 / 3.0, -4.0 / 3.0, 8.0 / 3.0]),
            Self::Open5 => (5, &[0.0, 55.0 / 24.0, 5.0 / 24.0, 5.0 / 24.0, 55.0 / 24.0]),
            Self::Open6 => (6, &[0.0, 3.3, -4.2, 7.8, -4.2, 3.3]),
            Self::Tick => (2, &[0.3584, 1.2832, 0.3584]),
            Self::AdamsMoulton3 => (1, &[5.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0]),
        }
    }

    /// How much larger the random walk of the velocity is than that of a sum of the samples: white noise of σ in the acceleration leaves
    /// c σ √(T t) after t.
    ///
    /// Every pole at a root of one walks by itself: c² is the sum of their squared residues, that at z = 1 being one.
    ///
    /// ```
    /// use proofmass_core::velocity::IntegratorRule;
    /// assert_eq!(IntegratorRule::Trapezoid.noise_walk(), 1.0);
    /// assert!((IntegratorRule::Simpson.noise_walk().powi(2) - 10.0 / 9.0).abs() < 1e-15);
    /// ```
    pub fn noise_walk(self) -> f64 {
        let (lag, b) = self.weights();
        // Of one chain: every sample by the sum of the weights that it meets in step after step, L samples to a step.
        let mut squares = 0.0;
        for first in 0..lag {
            let mut met = 0.0;
            let mut k = first;
            while k < b.len() {
                met += b[k];
                k += lag;
            }
            squares += met * met;
        }
        libm::sqrt(squares / lag as f64)
    }

    /// Transfer function H(e^{jθ})/T of the difference equation at θ = ωT, real and imaginary part.
    ///
    /// Infinite at θ = 0, and at the other multiples of 2π/L.
    pub fn transfer(self, theta: f64) -> (f64, f64) {
        let (lag, b) = self.weights();
        let (mut re, mut im) = (0.0, 0.0);
        for (k, b) in b.iter().enumerate() {
            re += b * libm::cos(k as f64 * theta);
            im -= b * libm::sin(k as f64 * theta);
        }
        let angle = lag as f64 * theta;
        // 1 − e^{−jφ} = 2 sin(φ/2) (sin(φ/2) + j cos(φ/2)), without cancellation at small angles.
        let (s, c) = (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
        let scale = 1.0 / (2.0 * s);
        ((re * s + im * c) * scale, (im * s - re * c) * scale)
    }

    /// Accuracy function |H(e^{jωT})/(1/jω)| at θ = ωT: the gain of the computed velocity against the true one.
    ///
    /// **Source** the published values at θ = π/4 and π/2 are .948059 and .785398 for the trapezoid,
    /// 1.002280 and 1.047198 for Simpson, .994125 and 1.007823 for Tick.
    ///
    /// ```
    /// use proofmass_core::velocity::IntegratorRule;
    /// let gain = IntegratorRule::Trapezoid.accuracy(core::f64::consts::FRAC_PI_4);
    /// assert!((gain - 0.948059).abs() < 5e-7);
    /// ```
    pub fn accuracy(self, theta: f64) -> f64 {
        let (re, im) = self.transfer(theta);
        theta * libm::hypot(re, im)
    }

    /// Phase of H(e^{jωT})/(1/jω) in radians: zero but for Adams–Moulton, and π where the gain of a rule is negative.
    pub fn phase_error(self, theta: f64) -> f64 {
        let (re, im) = self.transfer(theta);
        // Multiplication by jθ turns (re, im) into (−θ im, θ re).
        libm::atan2(re, -im)
    }

    /// Noise amplification |H(e^{jωT})|² in s² at θ = ωT: velocity PSD over acceleration PSD.
    ///
    /// White acceleration noise of standard deviation σ gives a velocity whose standard deviation after time t
    /// is [`Self::noise_walk`] times σ √(T t).
    pub fn noise_amplification(self, theta: f64, sample_time: f64) -> f64 {
        let (re, im) = self.transfer(theta);
        sample_time * sample_time * (re * re + im * im)
    }
}

/// Integrates acceleration to velocity, one sample at a time.
///
/// **Delay** none at low frequency. **Steady-state error** an offset b of the acceleration grows to b t; remove
/// it before (mean of a still period) or use an estimator with a position.
///
/// ```
/// use proofmass_core::velocity::{Integrator, IntegratorRule, IntegratorState};
/// let simpson = Integrator::<f64>::new(IntegratorRule::Simpson, 0.5)?;
/// let mut state = IntegratorState::new(0.0);
/// let v = [0.0, 0.25, 1.0].map(|a| simpson.step(&mut state, a)); // a = t², v = t³/3
/// assert!((v[2] - 1.0 / 3.0).abs() < 1e-15);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator<T> {
    b: [T; LONGEST],
    /// Weights that are used.
    weights: u8,
    lag: u8,
    half: T,
}

/// Memory of an [`Integrator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratorState<T> {
    a: [T; LONGEST - 1],
    v: [T; LONGEST - 1],
    samples: u8,
}

impl<T: Float> IntegratorState<T> {
    /// Starts at this velocity, which is that of the first sample.
    pub fn new(velocity: T) -> Self {
        Self {
            a: [T::ZERO; LONGEST - 1],
            v: [velocity; LONGEST - 1],
            samples: 0,
        }
    }
}

impl<T: Float> Integrator<T> {
    /// # Errors
    /// [`Error::OutOfRange`] for a sample time that is not positive.
    pub fn new(rule: IntegratorRule, sample_time: f64) -> Result<Self, Error> {
        let dt = positive("sample time", sample_time)?;
        let (lag, weights) = rule.weights();
        let mut b = [T::ZERO; LONGEST];
        for (to, from) in b.iter_mut().zip(weights) {
            *to = T::from_f64(from * dt);
        }
        Ok(Self {
            b,
            weights: weights.len() as u8,
            lag: lag as u8,
            half: T::from_f64(0.5 * dt),
        })
    }

    /// Velocity at the time of this acceleration; the samples before the rule has all that it weighs are reached by the trapezoid.
    pub fn step(&self, state: &mut IntegratorState<T>, acceleration: T) -> T {
        let (lag, weights) = (usize::from(self.lag), usize::from(self.weights));
        let needed = if lag > weights - 1 { lag } else { weights - 1 };
        let v = if state.samples == 0 {
            state.v[0]
        } else if usize::from(state.samples) < needed {
            state.v[0] + self.half * (acceleration + state.a[0])
        } else {
            let mut v = state.v[lag - 1] + self.b[0] * acceleration;
            for k in 1..weights {
                v += self.b[k] * state.a[k - 1];
            }
            v
        };
        if usize::from(state.samples) < needed {
            state.samples += 1;
        }
        // What no weight or chain reaches is not kept.
        for k in (1..needed).rev() {
            state.a[k] = state.a[k - 1];
            state.v[k] = state.v[k - 1];
        }
        state.a[0] = acceleration;
        state.v[0] = v;
        v
    }
}

/// Newmark's method: velocity and position from acceleration.
///
/// v_n = v_{n−1} + T [(1−γ) a_{n−1} + γ a_n],
/// x_n = x_{n−1} + T v_{n−1} + T² [(½−β) a_{n−1} + β a_n]
///
/// γ = ½, β = ¼ is the trapezoid in both; β = 1/6 takes the acceleration as linear. γ ≠ ½ costs a delay of
/// (½ − γ) T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newmark<T> {
    v: [T; 2],
    x: [T; 2],
    dt: T,
}

/// Memory of [`Newmark`]: position and velocity of the last sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewmarkState<T> {
    /// Position.
    pub(crate) position: T,
    /// Velocity.
    pub(crate) velocity: T,
    last: Option<T>,
}

impl<T: Float> NewmarkState<T> {
    /// Starts here.
    pub fn new(position: T, velocity: T) -> Self {
        Self {
            position,
            velocity,
            last: None,
        }
    }
}

impl<T: Float> Newmark<T> {
    /// # Errors
    /// [`Error::OutOfRange`] for a sample time that is not positive, γ outside 0…1 or β outside 0…½.
    pub fn new(gamma: f64, beta: f64, sample_time: f64) -> Result<Self, Error> {
        let dt = positive("sample time", sample_time)?;
        for (name, value, max) in [("gamma", gamma, 1.0), ("beta", beta, 0.5)] {
            if !(0.0..=max).contains(&value) {
                return Err(Error::OutOfRange {
                    name,
                    value,
                    min: 0.0,
                    max,
                });
            }
        }
        Ok(Self {
            v: [T::from_f64((1.0 - gamma) * dt), T::from_f64(gamma * dt)],
            x: [
                T::from_f64((0.5 - beta) * dt * dt),
                T::from_f64(beta * dt * dt),
            ],
            dt: T::from_f64(dt),
        })
    }

    /// Velocity at the time of this acceleration; the position stands in the state.
    pub fn step(&self, state: &mut NewmarkState<T>, acceleration: T) -> T {
        if let Some(last) = state.last {
            state.position +=
                self.dt * state.velocity + self.x[0] * last + self.x[1] * acceleration;
            state.velocity += self.v[0] * last + self.v[1] * acceleration;
        }
        state.last = Some(acceleration);
        state.velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    // Printed digits, not constants of mathematics.
    #[allow(clippy::approx_constant)]
    const PUBLISHED: [(IntegratorRule, f64, f64); 3] = [
        (IntegratorRule::Trapezoid, 0.948059, 0.785398),
        (IntegratorRule::Simpson, 1.002280, 1.047198),
        (IntegratorRule::Tick, 0.994125, 1.007823),
    ];

    /// |H|ω of every rule at θ = π/8 and π/4, by scipy 1.17 from weights that sympy integrated of Lagrange's polynomials.
    const COMPUTED: [(IntegratorRule, f64, f64); 11] = [
        (IntegratorRule::Trapezoid, 0.987116, 0.948059),
        (IntegratorRule::Simpson, 1.000135, 1.002280),
        (IntegratorRule::ThreeEighths, 1.000309, 1.005569),
        (IntegratorRule::Boole, 0.999992, 0.999285),
        (IntegratorRule::Closed5, 0.999981, 0.998055),
        (IntegratorRule::Closed6, 1.000001, 1.000446),
        (IntegratorRule::Midpoint, 1.026172, 1.110721),
        (IntegratorRule::Open3, 1.039887, 1.178097),
        (IntegratorRule::Milne, 0.997989, 0.957362),
        (IntegratorRule::Open5, 0.996440, 0.909156),
        (IntegratorRule::Open6, 1.000220, 1.033139),
    ];

    /// Gain and phase of the computed velocity over the true one: a = cos θn through the running integrator,
    /// projected on whole periods. θ is a multiple of π/16 or π/5.
    fn run(rule: IntegratorRule, theta: f64) -> (f64, f64) {
        // Whole periods of θ and of the poles at the roots of one, to which what the start left of these is orthogonal; the first of
        // them is left out.
        const BLOCK: usize = 480;
        let integrator = Integrator::<f64>::new(rule, 1.0).unwrap();
        let mut state = IntegratorState::new(0.0);
        let n = 60 * BLOCK;
        let (mut s, mut c) = (0.0, 0.0);
        for k in 0..n {
            let angle = theta * k as f64;
            let v = integrator.step(&mut state, angle.cos());
            if k >= BLOCK {
                s += v * angle.sin();
                c += v * angle.cos();
            }
        }
        let scale = 2.0 * theta / (n - BLOCK) as f64;
        ((s * scale).hypot(c * scale), c.atan2(s))
    }

    #[test]
    fn crosscheck_accuracy_functions_of_the_newton_cotes_family() {
        for (rule, eighth, quarter) in COMPUTED {
            assert!(
                (rule.accuracy(PI / 8.0) - eighth).abs() < 5.1e-7,
                "{rule:?}"
            );
            assert!(
                (rule.accuracy(FRAC_PI_4) - quarter).abs() < 5.1e-7,
                "{rule:?}"
            );
        }
    }

    /// Velocities of white noise after many steps, against the walk that is stated; the sum of squares of the response to one sample is
    /// their variance.
    #[test]
    fn law_noise_walks_as_stated() {
        for rule in IntegratorRule::ALL {
            let integrator = Integrator::<f64>::new(rule, 1.0).unwrap();
            let mut state = IntegratorState::new(0.0);
            let n = 60_000;
            // The sample comes when the rule runs.
            let response =
                (0..n + 10).map(|k| integrator.step(&mut state, f64::from(u8::from(k == 9))));
            let squares: f64 = response.skip(10).map(|v| v * v).sum();
            let walk = (squares / n as f64).sqrt();
            assert!(
                (walk / rule.noise_walk() - 1.0).abs() < 1e-3,
                "{rule:?} {walk}"
            );
        }
    }

    #[test]
    fn published_accuracy_functions_from_the_difference_equation() {
        for (rule, quarter, half) in PUBLISHED {
            assert!(
                (rule.accuracy(FRAC_PI_4) - quarter).abs() < 5.1e-7,
                "{rule:?}"
            );
            assert!((rule.accuracy(FRAC_PI_2) - half).abs() < 5.1e-7, "{rule:?}");
        }
    }

    #[test]
    fn published_accuracy_functions_from_running_it() {
        for (rule, quarter, half) in PUBLISHED {
            assert!((run(rule, FRAC_PI_4).0 - quarter).abs() < 6e-7, "{rule:?}");
            assert!((run(rule, FRAC_PI_2).0 - half).abs() < 6e-7, "{rule:?}");
        }
    }

    #[test]
    fn law_transfer_function_is_what_runs() {
        for rule in IntegratorRule::ALL {
            for theta in [PI / 16.0, PI / 5.0, FRAC_PI_4] {
                let (gain, phase) = run(rule, theta);
                assert!(
                    (gain - rule.accuracy(theta)).abs() < 1e-9,
                    "{rule:?} {theta}"
                );
                assert!(
                    (phase - rule.phase_error(theta)).abs() < 1e-9,
                    "{rule:?} {theta}"
                );
            }
        }
        assert!(IntegratorRule::Trapezoid.phase_error(1.0).abs() < 1e-15);
        let theta = 0.02; // leading term of the phase of Adams–Moulton 3
        let phase = IntegratorRule::AdamsMoulton3.phase_error(theta);
        assert!((phase.abs() / theta.powi(3) - 1.0 / 24.0).abs() < 1e-4);
    }

    /// Over a step of L the weights integrate powers up to a degree, and not the next.
    #[test]
    fn law_rules_are_exact_for_their_polynomials() {
        for (rule, degree) in [
            (IntegratorRule::Trapezoid, 1),
            (IntegratorRule::Simpson, 3),
            (IntegratorRule::ThreeEighths, 3),
            (IntegratorRule::Boole, 5),
            (IntegratorRule::Closed5, 5),
            (IntegratorRule::Closed6, 7),
            (IntegratorRule::Midpoint, 1),
            (IntegratorRule::Open3, 1),
            (IntegratorRule::Milne, 3),
            (IntegratorRule::Open5, 3),
            (IntegratorRule::Open6, 5),
            (IntegratorRule::AdamsMoulton3, 2),
        ] {
            let (lag, b) = rule.weights();
            let off = |power: i32| {
                let sum: f64 = (0..b.len()).map(|k| b[k] * (-(k as f64)).powi(power)).sum();
                let exact = -(-(lag as f64)).powi(power + 1) / f64::from(power + 1);
                (sum - exact).abs() / exact.abs()
            };
            assert!((0..=degree).all(|power| off(power) < 1e-13), "{rule:?}");
            assert!(off(degree + 1) > 1e-4, "{rule:?} {}", off(degree + 1));
        }
    }

    /// From v = t^{d+1}/(d+1) at the start of L steps, so that the trapezoid of the samples between does not enter.
    #[test]
    fn law_running_rules_are_exact_on_their_own_chain() {
        for (rule, degree) in [
            (IntegratorRule::Trapezoid, 1),
            (IntegratorRule::Simpson, 3),
            (IntegratorRule::Boole, 5),
            (IntegratorRule::Closed6, 7),
            (IntegratorRule::Open6, 5),
        ] {
            let integrator = Integrator::<f64>::new(rule, 0.1).unwrap();
            let mut state = IntegratorState::new(0.0);
            let mut last = 0.0;
            for n in 0..=24 {
                last = integrator.step(&mut state, (0.1 * n as f64).powi(degree));
            }
            let exact = 2.4f64.powi(degree + 1) / f64::from(degree + 1);
            assert!(
                (last / exact - 1.0).abs() < 1e-12,
                "{rule:?} {last} {exact}"
            );
        }
    }

    #[test]
    fn law_newmark_with_half_and_quarter_is_the_trapezoid() {
        let newmark = Newmark::<f64>::new(0.5, 0.25, 0.01).unwrap();
        let trapezoid = Integrator::<f64>::new(IntegratorRule::Trapezoid, 0.01).unwrap();
        let (mut a, mut b) = (NewmarkState::new(0.0, 1.0), IntegratorState::new(1.0));
        let (mut x, mut before) = (0.0, 1.0);
        for n in 0..500 {
            let acceleration = (0.3 * n as f64).sin();
            let v = trapezoid.step(&mut b, acceleration);
            assert!((newmark.step(&mut a, acceleration) - v).abs() < 1e-13);
            if n > 0 {
                x += 0.005 * (v + before);
            }
            before = v;
        }
        assert!((a.position - x).abs() < 1e-12);
    }

    #[test]
    fn law_offset_drifts_as_offset_times_time() {
        for rule in IntegratorRule::ALL {
            let integrator = Integrator::<f32>::new(rule, 0.001).unwrap();
            let mut state = IntegratorState::new(0.0);
            let v = (0..=10_000)
                .map(|_| integrator.step(&mut state, 0.05))
                .last()
                .unwrap();
            assert!((v - 0.5).abs() < 2e-4, "{rule:?}: {v}"); // 10⁴ roundings of f32 at 0.5
        }
    }

    #[test]
    fn refuses_a_sample_time_of_zero() {
        assert!(Integrator::<f64>::new(IntegratorRule::Tick, 0.0).is_err());
        assert!(Newmark::<f64>::new(0.5, 0.6, 0.1).is_err());
        assert!(Newmark::<f64>::new(f64::NAN, 0.2, 0.1).is_err());
    }
}

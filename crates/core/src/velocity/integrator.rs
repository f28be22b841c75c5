//! Velocity from acceleration alone: the integration rules as difference equations.

use super::positive;
use crate::{Error, Float};

/// Which quadrature rule integrates the acceleration.
///
/// v_n = v_{n−L} + T (b₀ a_n + b₁ a_{n−1} + b₂ a_{n−2})
///
/// | rule | L | b₀, b₁, b₂ | remark |
/// |---|---|---|---|
/// | trapezoid | 1 | ½, ½, 0 | no phase error; gain (θ/2)/tan(θ/2) |
/// | Simpson | 2 | ⅓, 4/3, ⅓ | no phase error; second pole at z = −1: noise near Nyquist accumulates |
/// | Tick | 2 | 0.3584, 1.2832, 0.3584 | as Simpson, flattest gain up to half of Nyquist |
/// | Adams–Moulton 3 | 1 | 5/12, 8/12, −1/12 | third order; phase error of order θ³/24 |
///
/// **Source** `[Hamming89]` on integration rules as recursive filters, Tick's among them.
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
    /// v_n = v_{n−2} + T (0.3584 a_n + 1.2832 a_{n−1} + 0.3584 a_{n−2})
    Tick,
    /// v_n = v_{n−1} + T/12 (5 a_n + 8 a_{n−1} − a_{n−2})
    #[cfg_attr(feature = "serde", serde(rename = "adams-moulton-3"))]
    AdamsMoulton3,
}

impl IntegratorRule {
    /// All rules, in the order of the table.
    pub const ALL: [Self; 4] = [
        Self::Trapezoid,
        Self::Simpson,
        Self::Tick,
        Self::AdamsMoulton3,
    ];

    /// Stable lower-case name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Trapezoid => "trapezoid",
            Self::Simpson => "simpson",
            Self::Tick => "tick",
            Self::AdamsMoulton3 => "adams-moulton-3",
        }
    }

    /// Step L back to the velocity that is continued, and the weights b₀, b₁, b₂.
    pub fn weights(self) -> (usize, [f64; 3]) {
        match self {
            Self::Trapezoid => (1, [0.5, 0.5, 0.0]),
            Self::Simpson => (2, [1.0 / 3.0, 4.0 / 3.0, 1.0 / 3.0]),
            Self::Tick => (2, [0.3584, 1.2832, 0.3584]),
            Self::AdamsMoulton3 => (1, [5.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0]),
        }
    }

    /// Transfer function H(e^{jθ})/T of the difference equation at θ = ωT, real and imaginary part.
    ///
    /// Infinite at θ = 0, and for the rules with L = 2 at θ = π.
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

    /// Phase of H(e^{jωT})/(1/jω) in radians: zero but for Adams–Moulton.
    pub fn phase_error(self, theta: f64) -> f64 {
        let (re, im) = self.transfer(theta);
        // Multiplication by jθ turns (re, im) into (−θ im, θ re).
        libm::atan2(re, -im)
    }

    /// Noise amplification |H(e^{jωT})|² in s² at θ = ωT: velocity PSD over acceleration PSD.
    ///
    /// White acceleration noise of standard deviation σ gives a velocity whose standard deviation after time t
    /// is σ √(T t) for every rule: the random walk.
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
    b: [T; 3],
    half: T,
    two_back: bool,
}

/// Memory of an [`Integrator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratorState<T> {
    a: [T; 2],
    v: [T; 2],
    samples: u8,
}

impl<T: Float> IntegratorState<T> {
    /// Starts at this velocity, which is that of the first sample.
    pub fn new(velocity: T) -> Self {
        Self {
            a: [T::ZERO; 2],
            v: [velocity; 2],
            samples: 0,
        }
    }
}

impl<T: Float> Integrator<T> {
    /// # Errors
    /// [`Error::OutOfRange`] for a sample time that is not positive.
    pub fn new(rule: IntegratorRule, sample_time: f64) -> Result<Self, Error> {
        let dt = positive("sample time", sample_time)?;
        let (lag, b) = rule.weights();
        Ok(Self {
            b: b.map(|b| T::from_f64(b * dt)),
            half: T::from_f64(0.5 * dt),
            two_back: lag == 2,
        })
    }

    /// Velocity at the time of this acceleration; the second sample is reached by the trapezoid in every rule.
    pub fn step(&self, state: &mut IntegratorState<T>, acceleration: T) -> T {
        let v = match state.samples {
            0 => state.v[0],
            1 => state.v[0] + self.half * (acceleration + state.a[0]),
            _ => {
                let from = if self.two_back {
                    state.v[1]
                } else {
                    state.v[0]
                };
                from + self.b[0] * acceleration + self.b[1] * state.a[0] + self.b[2] * state.a[1]
            }
        };
        state.samples = (state.samples + 1).min(2);
        state.a = [acceleration, state.a[0]];
        state.v = [v, state.v[0]];
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

    /// Gain and phase of the computed velocity over the true one: a = cos θn through the running integrator,
    /// projected on whole periods.
    fn run(rule: IntegratorRule, theta: f64) -> (f64, f64) {
        let integrator = Integrator::<f64>::new(rule, 1.0).unwrap();
        // A constant and an alternating part from the start are orthogonal to whole periods; the first period,
        // with the samples before the rule is running, is left out.
        let mut state = IntegratorState::new(0.0);
        let n = (400.0 * PI / theta).round() as usize;
        let (mut s, mut c) = (0.0, 0.0);
        for k in 0..n {
            let angle = theta * k as f64;
            let v = integrator.step(&mut state, angle.cos());
            if k >= n / 200 {
                s += v * angle.sin();
                c += v * angle.cos();
            }
        }
        let scale = 2.0 * theta / (n - n / 200) as f64;
        ((s * scale).hypot(c * scale), c.atan2(s))
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
            for theta in [PI / 16.0, PI / 5.0, FRAC_PI_2] {
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

    #[test]
    fn law_rules_are_exact_for_their_polynomials() {
        // Trapezoid to degree 1, Adams–Moulton 3 to 2, Simpson to 3; from v = t^{d+1}/(d+1) at the start of a
        // pair of samples, so that the trapezoid of the second sample does not enter Simpson's even chain.
        for (rule, degree) in [
            (IntegratorRule::Trapezoid, 1),
            (IntegratorRule::AdamsMoulton3, 1),
            (IntegratorRule::Simpson, 3),
        ] {
            let integrator = Integrator::<f64>::new(rule, 0.1).unwrap();
            let mut state = IntegratorState::new(0.0);
            let mut last = 0.0;
            for n in 0..=20 {
                last = integrator.step(&mut state, (0.1 * n as f64).powi(degree));
            }
            let exact = 2f64.powi(degree + 1) / f64::from(degree + 1);
            assert!((last - exact).abs() < 1e-12, "{rule:?} {last} {exact}");
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

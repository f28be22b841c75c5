//! Velocity from the last N positions: backward differences and the one-sided Savitzky–Golay filter.

use super::positive;
use crate::{Error, Float};

/// Derivative at the newest sample of the polynomial fitted to the last N positions.
///
/// v̂_n = Σ_k c_k x_{n−k}, c from exact least squares on orthogonal polynomials over the N points. Degree N − 1
/// goes through all points: the backward-difference expansion (1/T) Σ ∇^j/j. A lower degree averages: the
/// one-sided Savitzky–Golay filter.
///
/// **Delay** (N−1)T/2 for degree 1, zero for higher degrees ([`delay`](Self::delay) computes it from c).
/// **Steady-state error** zero for a motion that is a polynomial of the chosen degree; under constant
/// acceleration a, degree 1 is late by a (N−1)T/2.
/// **Noise** independent position errors of standard deviation σ give σ · [`noise_gain`](Self::noise_gain).
/// **Source** `[SavitzkyGolay64]`; `[Gorry90]` for the one-sided weights.
///
/// ```
/// use proofmass_core::velocity::{PositionDifference, PositionDifferenceState};
/// let cubic = PositionDifference::<f64, 8>::savitzky_golay(2, 0.1)?;
/// let mut state = PositionDifferenceState::new(0.0);
/// let mut v = 0.0;
/// for n in 0..8 { let t = 0.1 * n as f64; v = cubic.step(&mut state, 3.0 * t * t); }
/// assert!((v - 6.0 * 0.7).abs() < 1e-12);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionDifference<T, const N: usize> {
    c: [T; N],
    dt: f64,
}

/// The last N positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionDifferenceState<T, const N: usize> {
    x: [T; N],
    newest: usize,
}

impl<T: Float, const N: usize> PositionDifferenceState<T, N> {
    /// As if the axis had stood at this position before the first sample.
    pub fn new(position: T) -> Self {
        Self {
            x: [position; N],
            newest: 0,
        }
    }
}

impl<T: Float, const N: usize> PositionDifference<T, N> {
    /// Polynomial through all N points: backward differences of order N − 1.
    ///
    /// # Errors
    /// [`Error::TooFew`] below two points, [`Error::OutOfRange`] for a sample time that is not positive.
    pub fn backward(sample_time: f64) -> Result<Self, Error> {
        Self::savitzky_golay(N.saturating_sub(1), sample_time)
    }

    /// Least-squares polynomial of this degree.
    ///
    /// # Errors
    /// [`Error::TooFew`] below two points, [`Error::OutOfRange`] for a degree of zero or above N − 1 and for a
    /// sample time that is not positive.
    pub fn savitzky_golay(degree: usize, sample_time: f64) -> Result<Self, Error> {
        let dt = positive("sample time", sample_time)?;
        if N < 2 {
            return Err(Error::TooFew {
                name: "positions in the window",
                needed: 2,
                got: N,
            });
        }
        if degree == 0 || degree >= N {
            return Err(Error::OutOfRange {
                name: "degree",
                value: degree as f64,
                min: 1.0,
                max: (N - 1) as f64,
            });
        }
        let mut c = [0.0; N];
        derivative_weights(&mut c, degree);
        Ok(Self {
            c: c.map(|c| T::from_f64(c / dt)),
            dt,
        })
    }

    /// As if the axis had come to zero at an even velocity: the window of the last N positions there.
    pub(super) fn window_of(&self, velocity: T) -> PositionDifferenceState<T, N> {
        self.start_moving(velocity * T::from_f64(self.dt), velocity)
    }

    /// As if the axis had come at an even velocity to this position, which is that of the first sample.
    pub fn start_moving(&self, position: T, velocity: T) -> PositionDifferenceState<T, N> {
        let step = velocity * T::from_f64(self.dt);
        let mut back = position;
        let x = core::array::from_fn(|_| {
            back -= step;
            back
        });
        PositionDifferenceState { x, newest: 0 }
    }

    /// Velocity at the time of this position.
    pub fn step(&self, state: &mut PositionDifferenceState<T, N>, position: T) -> T {
        state.newest = if state.newest == 0 {
            N - 1
        } else {
            state.newest - 1
        };
        state.x[state.newest] = position;
        // Differences from the newest position keep the digits when the position is large; Σ c = 0.
        let mut v = T::ZERO;
        for k in 1..N {
            let index = state.newest + k;
            let x = state.x[if index >= N { index - N } else { index }];
            v += self.c[k] * (x - position);
        }
        v
    }

    /// Moves the zero of the positions.
    pub(super) fn rebase(state: &mut PositionDifferenceState<T, N>, by: T) {
        for x in &mut state.x {
            *x -= by;
        }
    }

    /// Weights c_k in 1/s, newest first.
    pub fn weights(&self) -> &[T; N] {
        &self.c
    }

    /// Delay in seconds of the velocity of a slow motion: −(T/2) Σ c_k k² T.
    pub fn delay(&self) -> f64 {
        let sum: f64 = (0..N).map(|k| self.c[k].to_f64() * (k * k) as f64).sum();
        -0.5 * sum * self.dt * self.dt
    }

    /// Standard deviation of the velocity for independent position errors of one: √(Σ c²), in 1/s.
    ///
    /// Quantisation to δ is such an error with δ/√12 when the axis moves over several increments per sample.
    pub fn noise_gain(&self) -> f64 {
        libm::sqrt((0..N).map(|k| self.c[k].to_f64()).map(|c| c * c).sum())
    }
}

/// Weights of the derivative at t = 0 of the least-squares polynomial over the points t = 0, −1, …, −(N−1).
///
/// Orthogonal polynomials by their three-term recurrence: no matrix is formed, so no condition number enters.
fn derivative_weights<const N: usize>(c: &mut [f64; N], degree: usize) {
    let t = |k: usize| -(k as f64);
    let (mut before, mut now) = ([0.0; N], [1.0; N]);
    let (mut value_before, mut value) = (0.0, 1.0); // p_{j−1}(0), p_j(0)
    let (mut slope_before, mut slope) = (0.0, 0.0); // their derivatives at 0
    let mut norm_before = 1.0;
    for j in 0..=degree {
        let norm: f64 = now.iter().map(|p| p * p).sum();
        for k in 0..N {
            c[k] += now[k] * slope / norm;
        }
        let alpha = (0..N).map(|k| t(k) * now[k] * now[k]).sum::<f64>() / norm;
        let beta = if j == 0 { 0.0 } else { norm / norm_before };
        let mut next = [0.0; N];
        for k in 0..N {
            next[k] = (t(k) - alpha) * now[k] - beta * before[k];
        }
        (value_before, value, slope_before, slope) = (
            value,
            -alpha * value - beta * value_before,
            slope,
            value - alpha * slope - beta * slope_before,
        );
        before = now;
        now = next;
        norm_before = norm;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_backward_difference_weights() {
        // (3, −4, 1)/2 and (11, −18, 9, −2)/6: the expansion Σ ∇^j/j written out.
        let second = PositionDifference::<f64, 3>::backward(1.0).unwrap();
        for (c, e) in second.weights().iter().zip([1.5, -2.0, 0.5]) {
            assert!((c - e).abs() < 1e-14);
        }
        let third = PositionDifference::<f64, 4>::backward(1.0).unwrap();
        for (c, e) in third.weights().iter().zip([11.0, -18.0, 9.0, -2.0]) {
            assert!((c - e / 6.0).abs() < 1e-13);
        }
    }

    #[test]
    fn published_end_point_weights_of_five_points() {
        // First derivative at the end point, quadratic, 5 points: (54, −13, −40, −27, 26)/70 `[Gorry90]`.
        let filter = PositionDifference::<f64, 5>::savitzky_golay(2, 1.0).unwrap();
        for (c, e) in filter
            .weights()
            .iter()
            .zip([54.0, -13.0, -40.0, -27.0, 26.0])
        {
            assert!((c - e / 70.0).abs() < 1e-14);
        }
    }

    #[test]
    fn law_polynomials_of_the_degree_pass_exactly() {
        for degree in 1..=5 {
            let filter = PositionDifference::<f64, 20>::savitzky_golay(degree, 0.05).unwrap();
            let mut state = PositionDifferenceState::new(0.0);
            let mut v = 0.0;
            for n in 0..20 {
                v = filter.step(&mut state, (0.05 * n as f64).powi(degree as i32));
            }
            let exact = degree as f64 * 0.95f64.powi(degree as i32 - 1);
            assert!((v - exact).abs() < 1e-10, "degree {degree}: {v} {exact}");
        }
    }

    #[test]
    fn law_delay_and_noise_of_a_line_fit() {
        // Slope of a line through N points: variance 12/(N(N²−1)) per T², delay (N−1)/2 samples.
        let filter = PositionDifference::<f64, 9>::savitzky_golay(1, 0.01).unwrap();
        assert!((filter.delay() - 0.04).abs() < 1e-14);
        let variance = 12.0 / (9.0 * 80.0) / 1e-4;
        assert!((filter.noise_gain() - f64::sqrt(variance)).abs() < 1e-10);
        let parabola = PositionDifference::<f64, 9>::savitzky_golay(2, 0.01).unwrap();
        assert!(parabola.delay().abs() < 1e-14);
        let two = PositionDifference::<f32, 2>::backward(0.01).unwrap();
        assert!((two.delay() - 0.005).abs() < 1e-9);
    }

    #[test]
    fn refuses_degrees_the_window_cannot_carry() {
        assert!(PositionDifference::<f64, 4>::savitzky_golay(4, 1.0).is_err());
        assert!(PositionDifference::<f64, 4>::savitzky_golay(0, 1.0).is_err());
        assert!(PositionDifference::<f64, 1>::backward(1.0).is_err());
    }
}

//! A finite impulse response and decimation behind it, of all axes together.

use crate::decimator::{at_least_one, is_due};
use crate::{Error, Float};

/// Σ h_k x_k over samples that lie in two pieces, the older piece first.
///
/// One order of the sum for desk and chip: from the oldest sample on.
///
/// ```
/// assert_eq!(proofmass_core::weighted_sum(&[0.25, 0.5, 0.25], [&[4.0], &[8.0, 4.0]]), 6.0);
/// ```
#[inline]
pub fn weighted_sum<F: Float>(taps: &[F], [older, newer]: [&[F]; 2]) -> F {
    let (first, rest) = taps.split_at(older.len().min(taps.len()));
    let mut sum = F::ZERO;
    for (h, x) in first.iter().zip(older) {
        sum += *h * *x;
    }
    for (h, x) in rest.iter().zip(newer) {
        sum += *h * *x;
    }
    sum
}

/// A finite impulse response of K taps on each of N axes, of which every M-th result is given and only that computed.
///
/// A result is given from the K-th sample on: there is none that would need samples that never came. The taps are designed off line
/// (`proofmass_signal::LinearPhase`).
///
/// **Shapes** N axes: three, or one. **Delay** (K − 1)/2 samples at every frequency where the taps are symmetric. **Cost** N K
/// multiplications for a result, N stores for a sample.
///
/// ```
/// use proofmass_core::{FirDecimator, FirDecimatorState};
/// let mean = FirDecimator::<f32, 1, 4>::new([0.25; 4], 2)?;
/// let mut state = FirDecimatorState::new();
/// let given = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|x| mean.step(&mut state, [x]));
/// assert_eq!(given, [None, None, None, Some([2.5]), None, Some([4.5])]);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias("FIR", "linear phase", "downsampling"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirDecimator<F, const N: usize, const K: usize> {
    taps: [F; K],
    factor: u32,
}

/// The last K samples of the axes, and how many are to come before the next result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirDecimatorState<F, const N: usize, const K: usize> {
    samples: [[F; K]; N],
    next: usize,
    wait: u32,
}

impl<F: Float, const N: usize, const K: usize> FirDecimatorState<F, N, K> {
    /// As after a long time at one value: a result at once.
    pub fn at(value: [F; N]) -> Self {
        Self {
            samples: value.map(|v| [v; K]),
            next: 0,
            wait: 0,
        }
    }

    /// Before the first sample, and after a gap: a first result with the K-th sample.
    pub fn new() -> Self {
        Self {
            samples: [[F::ZERO; K]; N],
            next: 0,
            wait: (K as u32).saturating_sub(1),
        }
    }
}

impl<F: Float, const N: usize, const K: usize> Default for FirDecimatorState<F, N, K> {
    fn default() -> Self {
        Self::new()
    }
}

impl<F: Float, const N: usize, const K: usize> FirDecimator<F, N, K> {
    /// Taps, the first for the oldest sample, and the number of samples for one result: 1 for all of them.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a factor of zero or no taps.
    pub fn new(taps: [F; K], factor: u32) -> Result<Self, Error> {
        at_least_one("factor of a decimation", factor)?;
        at_least_one("taps", K as u32)?;
        Ok(Self::constant(taps, factor))
    }

    /// From exported coefficients: nothing is checked.
    pub const fn constant(taps: [F; K], factor: u32) -> Self {
        Self { taps, factor }
    }

    /// The impulse response, the oldest sample first.
    pub fn taps(&self) -> &[F; K] {
        &self.taps
    }

    /// One sample of every axis; a result with every M-th, once there are K.
    #[inline]
    pub fn step(&self, state: &mut FirDecimatorState<F, N, K>, input: [F; N]) -> Option<[F; N]> {
        if K == 0 {
            return Some(input);
        }
        for axis in 0..N {
            state.samples[axis][state.next] = input[axis];
        }
        state.next = if state.next + 1 == K {
            0
        } else {
            state.next + 1
        };
        if !is_due(&mut state.wait, self.factor) {
            return None;
        }
        let mut output = input;
        for axis in 0..N {
            let (newer, older) = state.samples[axis].split_at(state.next);
            output[axis] = weighted_sum(&self.taps, [older, newer]);
        }
        Some(output)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every M-th of the convolution over what came, and nothing before the response is full.
    #[test]
    fn law_results_are_those_of_the_convolution() {
        let taps: [f64; 7] = core::array::from_fn(|k| 0.1 + 0.3 * (k as f64).sin());
        let wave = |i: usize, k: f64| (0.37 * k * i as f64).cos() + 9.8;
        for factor in [1, 3] {
            let filter = FirDecimator::<f64, 2, 7>::new(taps, factor).unwrap();
            let mut state = FirDecimatorState::new();
            for i in 0..200usize {
                let got = filter.step(&mut state, [wave(i, 1.0), wave(i, 2.0)]);
                let due = i >= 6 && (i - 6).is_multiple_of(factor as usize);
                let expected = due.then(|| {
                    [1.0, 2.0]
                        .map(|k| (0..7).fold(0.0, |sum, j| sum + taps[j] * wave(i - 6 + j, k)))
                });
                assert_eq!(got, expected, "{i}");
            }
        }
    }

    #[test]
    fn refuses_what_leaves_nothing() {
        assert!(FirDecimator::<f32, 1, 3>::new([0.3; 3], 0).is_err());
        assert!(FirDecimator::<f32, 1, 0>::new([], 1).is_err());
    }
}

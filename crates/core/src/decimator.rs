//! A low-pass and decimation behind it, of all axes together: what runs behind a compensation.

use crate::{Butterworth, Error, Float, LowPassState};

/// A Butterworth low-pass on each of N axes, of which every M-th result is given.
///
/// The gain of [`Butterworth`] at the frequencies that fold into its band, [`Decimator::folded_gain`], is for whoever chooses the corner:
/// nothing is refused here.
///
/// **Shapes** N axes: three, or one. **Delay** that of the low-pass, [`Butterworth::group_delay`].
///
/// ```
/// use proofmass_core::{Butterworth, Decimator, DecimatorState};
/// let decimator = Decimator::<f32, 3>::new(Butterworth::new(20.0, 1000.0)?, 10)?;
/// let mut state = DecimatorState::at([0.0, 0.0, 9.8], 0); // a first result at once, then every tenth
/// let given = (0..100).filter_map(|_| decimator.step(&mut state, [0.0, 0.0, 9.8])).count();
/// assert_eq!(given, 10);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias("downsampling", "anti-aliasing"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decimator<F, const N: usize> {
    low_pass: Butterworth<F>,
    factor: u32,
}

/// The low-passes of the axes, and how many samples there are to come before the next result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecimatorState<F, const N: usize> {
    axes: [LowPassState<F>; N],
    wait: u32,
}

impl<F: Float, const N: usize> DecimatorState<F, N> {
    /// As after a long time at one value, with a first result after so many samples more than one.
    pub fn at(value: [F; N], wait: u32) -> Self {
        Self {
            axes: value.map(LowPassState::at),
            wait,
        }
    }
}

impl<F: Float, const N: usize> Decimator<F, N> {
    /// A low-pass, and the number of samples for one result: 1 for all of them.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a factor of zero.
    pub fn new(low_pass: Butterworth<F>, factor: u32) -> Result<Self, Error> {
        at_least_one("factor of a decimation", factor)?;
        Ok(Self::constant(low_pass, factor))
    }

    /// From exported coefficients: nothing is checked.
    pub const fn constant(low_pass: Butterworth<F>, factor: u32) -> Self {
        Self { low_pass, factor }
    }

    /// The low-pass.
    pub fn low_pass(&self) -> &Butterworth<F> {
        &self.low_pass
    }

    /// One sample of every axis; a result with every M-th.
    #[inline]
    pub fn step(&self, state: &mut DecimatorState<F, N>, input: [F; N]) -> Option<[F; N]> {
        let mut output = input;
        for axis in 0..N {
            output[axis] = self.low_pass.step(&mut state.axes[axis], input[axis]);
        }
        is_due(&mut state.wait, self.factor).then_some(output)
    }

    /// Largest gain of a frequency that decimation folds to one up to the corner, which stands in Hz as the rate before decimation does:
    /// that at rate/M − corner. 1 where that is not above the corner, and so no low-pass can keep them apart; 0 where nothing folds.
    pub fn folded_gain(&self, corner: f64, rate: f64) -> f64 {
        if self.factor <= 1 {
            return 0.0;
        }
        let first = rate / f64::from(self.factor) - corner;
        if !(first > corner) {
            return 1.0;
        }
        self.low_pass.gain(first / rate)
    }
}

/// Refuses a count of zero.
pub(crate) fn at_least_one(name: &'static str, count: u32) -> Result<(), Error> {
    match count {
        0 => Err(Error::OutOfRange {
            name,
            value: 0.0,
            min: 1.0,
            max: f64::from(u32::MAX),
        }),
        _ => Ok(()),
    }
}

/// Whether this sample is one that a result is given for, every `factor`-th, `wait` being those that come before it.
#[inline]
pub(crate) fn is_due(wait: &mut u32, factor: u32) -> bool {
    match wait.checked_sub(1) {
        Some(left) => {
            *wait = left;
            false
        }
        None => {
            *wait = factor.saturating_sub(1);
            true
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decimator(corner: f64, factor: u32) -> Decimator<f64, 1> {
        Decimator::new(Butterworth::new(corner, 1000.0).unwrap(), factor).unwrap()
    }

    /// Every M-th of what the low-pass gives, to the bit, whatever it waits for first.
    #[test]
    fn law_results_are_every_mth_of_the_low_pass() {
        let low_pass = Butterworth::<f64>::new(30.0, 1000.0).unwrap();
        let wave = |i: usize, k: f64| (0.1 * k * i as f64).sin() + 9.8;
        for (factor, wait) in [(1, 0), (4, 0), (7, 3)] {
            let decimator = Decimator::<f64, 3>::new(low_pass, factor).unwrap();
            let input = |i| [wave(i, 1.0), wave(i, 2.0), wave(i, 3.0)];
            let mut state = DecimatorState::at(input(0), wait);
            let mut axes = input(0).map(LowPassState::at);
            for i in 0..200 {
                let all: [f64; 3] =
                    core::array::from_fn(|k| low_pass.step(&mut axes[k], input(i)[k]));
                let due = i >= wait as usize && (i - wait as usize).is_multiple_of(factor as usize);
                assert_eq!(
                    decimator.step(&mut state, input(i)),
                    due.then_some(all),
                    "{i}"
                );
            }
        }
    }

    /// A tone that would fold to 5 Hz comes out with the stated gain, at 5 Hz.
    #[test]
    fn known_alias_has_the_gain_of_the_low_pass() {
        let decimator = decimator(5.0, 10);
        let mut state = DecimatorState::at([0.0], 0);
        // 95 Hz, decimated to 100 Hz: −5 Hz.
        let tone = |i: usize| (core::f64::consts::TAU * 0.095 * i as f64).sin();
        let out: Vec<f64> = (0..20_000)
            .filter_map(|i| decimator.step(&mut state, [tone(i)]))
            .map(|v| v[0])
            .skip(200)
            .collect();
        let power: f64 = out.iter().map(|v| v * v).sum::<f64>() / out.len() as f64;
        let gain = decimator.folded_gain(5.0, 1000.0);
        // About (f_c/f)² = 0.0028; ninety whole periods.
        assert!(((2.0 * power).sqrt() / gain - 1.0).abs() < 1e-6);
        assert!((gain - 0.0027).abs() < 2e-4, "{gain}");
    }

    #[test]
    fn known_gain_where_nothing_and_where_all_folds() {
        assert_eq!(decimator(30.0, 1).folded_gain(30.0, 1000.0), 0.0);
        assert_eq!(decimator(30.0, 20).folded_gain(30.0, 1000.0), 1.0);
    }

    #[test]
    fn refuses_no_samples_for_a_result() {
        let low_pass = Butterworth::<f32>::new(30.0, 1000.0).unwrap();
        assert!(Decimator::<f32, 3>::new(low_pass, 0).is_err());
    }
}

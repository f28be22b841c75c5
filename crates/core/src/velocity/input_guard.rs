//! What a drive may not believe: samples that no axis can have made.

use super::{AxisSample, positive};
use crate::{Error, Float};

/// Takes out of a sample what cannot be: a step beyond the largest speed, an acceleration that is no number or beyond the
/// range, and says so.
///
/// A reading that is refused leaves the estimator to coast. Where the counter comes back (a bit that flipped), the way since
/// the last good reading is taken; where it stays away for eight samples (a counter that was reset), the steps since, with
/// the last good one in place of the jump. An acceleration that is refused is replaced by the last good one.
///
/// ```
/// use proofmass_core::velocity::{AxisSample, Counter, CounterState, InputFault, InputGuard};
/// // At most 2 m/s in samples of 1 ms, and a range of 50 m/s².
/// let guard = InputGuard::<f32>::new(2.0 * 1e-3, 50.0)?;
/// let counter = Counter::new(1e-4, 16)?;
/// let (mut words, mut last) = (CounterState::new(0), guard.start());
/// let (sample, fault) = guard.check(&mut last, &counter.sample(&mut words, 15, 1.0));
/// assert_eq!((sample.counts, fault), (Some(15), None));
/// let (sample, fault) = guard.check(&mut last, &counter.sample(&mut words, 8015, f32::NAN));
/// assert_eq!((sample.counts, sample.acceleration, fault), (None, 1.0, Some(InputFault::Both)));
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputGuard<T> {
    step: T,
    acceleration: T,
}

/// What was refused in a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputFault {
    /// The reading of the position.
    Reading,
    /// The acceleration.
    Acceleration,
    /// Both.
    Both,
}

/// Counts and way of one step or several.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step<T> {
    counts: i32,
    way: T,
}

impl<T: Float> Step<T> {
    const NONE: Self = Self {
        counts: 0,
        way: T::ZERO,
    };

    fn and(self, other: Self) -> Self {
        Self {
            counts: self.counts.wrapping_add(other.counts),
            way: self.way + other.way,
        }
    }
}

/// Memory of an [`InputGuard`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputGuardState<T> {
    acceleration: T,
    /// The last good step.
    last: Step<T>,
    /// Everything since the last good reading, and the same with the jump taken out.
    since: Step<T>,
    likely: Step<T>,
    /// Readings in a row that were refused.
    refused: u32,
    /// Samples since the last reading, for the distance the axis may have gone.
    missed: u32,
    /// Samples in a row in which something was refused.
    pub(crate) faults: u32,
}

/// Readings that are refused before a counter is taken to have been reset.
const PATIENCE: u32 = 8;

impl<T: Float> InputGuard<T> {
    /// Largest way between two samples, and the range of the accelerometer.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for values that are not positive.
    pub fn new(step: f64, acceleration: f64) -> Result<Self, Error> {
        Ok(Self {
            step: T::from_f64(positive("largest step", step)?),
            acceleration: T::from_f64(positive("range of the accelerometer", acceleration)?),
        })
    }

    /// Before the first sample.
    pub fn start(&self) -> InputGuardState<T> {
        InputGuardState {
            acceleration: T::ZERO,
            last: Step::NONE,
            since: Step::NONE,
            likely: Step::NONE,
            refused: 0,
            missed: 0,
            faults: 0,
        }
    }

    /// The sample as it may be believed, and what was refused.
    pub fn check(
        &self,
        state: &mut InputGuardState<T>,
        sample: &AxisSample<T>,
    ) -> (AxisSample<T>, Option<InputFault>) {
        let mut good = *sample;
        let heard = sample.acceleration.abs() <= self.acceleration;
        if heard {
            state.acceleration = sample.acceleration;
        } else {
            good.acceleration = state.acceleration;
        }
        let read = match sample.way {
            Some(way) => {
                let step = Step {
                    counts: sample.counts.unwrap_or(0),
                    way,
                };
                let taken = self.step(state, step);
                good.way = taken.map(|s| s.way);
                good.counts = sample.counts.and(taken.map(|s| s.counts));
                if taken.is_none() {
                    good.edge = None;
                }
                // A counter that comes back brings the right way; one that stays away was wrong before.
                taken.is_some()
            }
            None => {
                state.missed = state.missed.saturating_add(1);
                true
            }
        };
        let fault = match (read, heard) {
            (true, true) => None,
            (false, true) => Some(InputFault::Reading),
            (true, false) => Some(InputFault::Acceleration),
            (false, false) => Some(InputFault::Both),
        };
        state.faults = match fault {
            Some(_) => state.faults.saturating_add(1),
            None => 0,
        };
        (good, fault)
    }

    /// The step that is taken, if any.
    fn step(&self, state: &mut InputGuardState<T>, step: Step<T>) -> Option<Step<T>> {
        // The axis may have gone on in samples that had no reading.
        let samples = state.missed.saturating_add(1);
        let possible = step.way.abs() <= self.step * T::from_u32(samples);
        state.missed = 0;
        if state.refused == 0 && possible {
            state.last = step;
            return Some(step);
        }
        state.refused += 1;
        state.since = state.since.and(step);
        state.likely = state.likely.and(if possible { step } else { state.last });
        let room = self.step * T::from_u32(samples.saturating_add(state.refused));
        let taken = if state.since.way.abs() <= room && state.refused > 1 {
            state.since
        } else if state.refused >= PATIENCE {
            state.likely
        } else {
            return None;
        };
        (state.refused, state.since, state.likely) = (0, Step::NONE, Step::NONE);
        Some(taken)
    }
}

#[cfg(test)]
mod tests {
    use super::super::*;

    #[test]
    fn law_one_wrong_word_moves_the_velocity_by_nothing() {
        let dt = 1e-3;
        let counter = Counter::<f32>::new(1e-3, 16).unwrap();
        let guard = InputGuard::<f32>::new(0.05, 100.0).unwrap();
        let observer = Observer::<f32>::new(10.0, 100.0, dt).unwrap();
        let (mut words, mut last) = (CounterState::new(0), guard.start());
        let mut state = observer.start(0.0);
        let mut refused = 0;
        for n in 1..=4000u32 {
            // A bit that flips once, and comes back.
            let word = if n == 3000 { (20 * n) ^ 0x4000 } else { 20 * n } & 0xffff;
            let a = if n == 3500 { f32::INFINITY } else { 0.0 };
            let (sample, fault) = guard.check(&mut last, &counter.sample(&mut words, word, a));
            refused += u32::from(fault.is_some());
            let v = observer.estimate(&mut state, &sample);
            if n > 2500 {
                assert!((v - 20.0).abs() < 0.01, "{n}: {v}");
            }
        }
        // The word and the acceleration; the word after it brings the way of both.
        assert_eq!(refused, 2);
        assert!(InputGuard::<f32>::new(0.0, 1.0).is_err());
        assert!(InputGuard::<f32>::new(1.0, f64::NAN).is_err());
    }

    #[test]
    fn law_a_counter_that_was_reset_is_taken_up_again() {
        let counter = Counter::<f32>::new(1e-3, 32).unwrap();
        let guard = InputGuard::<f32>::new(0.05, 100.0).unwrap();
        let observer = Observer::<f32>::new(10.0, 100.0, 1e-3).unwrap();
        let (mut words, mut last) = (CounterState::new(0), guard.start());
        let mut state = observer.start(0.0);
        let mut refused = 0;
        for n in 1..=4000u32 {
            let word = if n < 3000 { 20 * n } else { 20 * (n - 3000) };
            let (sample, fault) = guard.check(&mut last, &counter.sample(&mut words, word, 0.0));
            refused += u32::from(fault.is_some());
            let v = observer.estimate(&mut state, &sample);
            assert!(n < 2500 || (v - 20.0).abs() < 0.01, "{n}: {v}");
        }
        assert_eq!(refused, 7);
    }

    #[test]
    fn law_the_room_grows_while_no_reading_comes() {
        let guard = InputGuard::<f64>::new(1.0, 1.0).unwrap();
        let mut last = guard.start();
        for _ in 0..9 {
            guard.check(&mut last, &AxisSample::unread(0.0));
        }
        let far = AxisSample {
            way: Some(9.5),
            ..AxisSample::unread(0.0)
        };
        assert_eq!(guard.check(&mut last, &far).1, None);
        assert_eq!(guard.check(&mut last, &far).1, Some(InputFault::Reading));
        assert_eq!(last.faults, 1);
    }
}

//! What came in since the last sample, from counters and angles that roll over.

use super::{AxisSample, positive};
use crate::{Error, Float};

/// A counter of some bits that rolls over: counts and way since the last reading, exact at any place.
///
/// The step is the one of least magnitude modulo 2^bits: right as long as the axis moves by less than half the range
/// between two readings.
///
/// ```
/// use proofmass_core::velocity::{Counter, CounterState};
/// let counter = Counter::<f32>::new(0.5, 16)?;
/// let mut last = CounterState::new(65_530);
/// let sample = counter.sample(&mut last, 4, 0.0);
/// assert_eq!((sample.counts, sample.way), (Some(10), Some(5.0)));
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counter<T> {
    increment: T,
    shift: u32,
}

/// The last word of a [`Counter`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CounterState {
    word: u32,
}

impl CounterState {
    /// Starts at this word.
    pub fn new(word: u32) -> Self {
        Self { word }
    }
}

impl<T: Float> Counter<T> {
    /// Increment, and bits of the counter, 1 to 32.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an increment that is not positive or another number of bits.
    pub fn new(increment: f64, bits: u32) -> Result<Self, Error> {
        if !(1..=32).contains(&bits) {
            return Err(Error::OutOfRange {
                name: "bits of the counter",
                value: f64::from(bits),
                min: 1.0,
                max: 32.0,
            });
        }
        Ok(Self {
            increment: T::from_f64(positive("increment", increment)?),
            shift: 32 - bits,
        })
    }

    /// The sample of this word and acceleration.
    pub fn sample(&self, state: &mut CounterState, word: u32, acceleration: T) -> AxisSample<T> {
        // The sign of the difference is its highest bit.
        let step = (word.wrapping_sub(state.word) << self.shift) as i32 >> self.shift;
        state.word = word;
        AxisSample {
            counts: Some(step),
            way: Some(T::from_i32(step) * self.increment),
            ..AxisSample::unread(acceleration)
        }
    }
}

/// An angle that begins anew after each turn: the way since the last reading.
///
/// The step is the one of least magnitude: right as long as the axis moves by less than half a turn between two readings.
///
/// ```
/// use proofmass_core::velocity::{Circle, CircleState};
/// let degrees = Circle::<f32>::new(360.0)?;
/// let mut last = CircleState::new(359.0);
/// assert_eq!(degrees.sample(&mut last, 2.0, 0.0).way, Some(3.0));
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle<T> {
    turn: T,
    half: T,
}

/// The last angle on a [`Circle`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CircleState<T> {
    angle: T,
}

impl<T: Float> CircleState<T> {
    /// Starts at this angle.
    pub fn new(angle: T) -> Self {
        Self { angle }
    }
}

impl<T: Float> Circle<T> {
    /// A turn: 2π, 360, or the counts of an absolute encoder.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a turn that is not positive.
    pub fn new(turn: f64) -> Result<Self, Error> {
        let turn = positive("turn", turn)?;
        Ok(Self {
            turn: T::from_f64(turn),
            half: T::from_f64(0.5 * turn),
        })
    }

    /// A difference of two angles of one turn, within half a turn to either side.
    pub fn difference(&self, difference: T) -> T {
        if difference >= self.half {
            difference - self.turn
        } else if difference < -self.half {
            difference + self.turn
        } else {
            difference
        }
    }

    /// The sample of this angle and acceleration. An angle that is no number or beyond two turns is no reading.
    pub fn sample(&self, state: &mut CircleState<T>, angle: T, acceleration: T) -> AxisSample<T> {
        let two = self.turn + self.turn;
        if !(angle.abs() <= two) {
            return AxisSample::unread(acceleration);
        }
        let once = self.difference(angle - state.angle);
        let way = self.difference(once);
        state.angle = angle;
        AxisSample {
            way: Some(way),
            ..AxisSample::unread(acceleration)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::*;

    /// Everything that estimates from positions, after `start` turns of a motor and through `turns` more.
    fn end(start: i64, turns: u32) -> [f32; 9] {
        let dt = 1e-3;
        let counter = Counter::<f32>::new(core::f64::consts::TAU / 2000.0, 32).unwrap();
        let noise = MotionNoise {
            acceleration: 400.0,
            form: ProcessNoise::SampleConstant,
            position: 1e-6,
        };
        let bias = BiasModel::RandomWalk {
            density: 1e-3,
            initial: 1.0,
        };
        let fit = PositionDifference::<f32, 9>::savitzky_golay(2, dt).unwrap();
        let m = FixedTime::<f32>::new(core::f64::consts::TAU / 2000.0, dt).unwrap();
        let pll = TrackingLoop::<f32>::new(100.0, dt).unwrap();
        let observer = Observer::<f32>::with_offset(15.0, 75.0, 125.0, dt).unwrap();
        let adaptive = AdaptiveObserver::<f32>::new(10.0, 100.0, 1.0, 1e-3, dt).unwrap();
        let two = TwoChannel::<f32>::new(0.0, 10.0, dt).unwrap();
        let kalman = Kalman::<f32, 2>::new(&noise, Hold::First, dt).unwrap();
        let three = Kalman::<f32, 3>::with_bias(&noise, bias, Hold::First, dt).unwrap();
        let counting = CountingKalman::<f32>::new(
            core::f64::consts::TAU / 2000.0,
            dt,
            &CountingNoise {
                acceleration: 400.0,
                walk: 0.0,
                edge: 0.005,
                tick: None,
            },
        )
        .unwrap();
        let mut states = (
            Estimator::start(&fit, 0.0),
            Estimator::start(&m, 0.0),
            Estimator::start(&pll, 0.0),
            Estimator::start(&observer, 0.0),
            Estimator::start(&adaptive, 0.0),
            Estimator::start(&two, 0.0),
            Estimator::start(&kalman, 0.0),
            Estimator::start(&three, 0.0),
            Estimator::start(&counting, 0.0),
        );
        let word = |n: i64| (start * 2000 + n) as u32;
        let mut last = CounterState::new(word(0));
        let mut v = [0.0; 9];
        // Half a turn less three counts in a sample, as a motor of 500 turns per second: 3133 rad/s.
        for n in 1..=2 * i64::from(turns) {
            let sample = counter.sample(&mut last, word(997 * n), 0.0);
            v = [
                fit.estimate(&mut states.0, &sample),
                m.estimate(&mut states.1, &sample),
                pll.estimate(&mut states.2, &sample),
                observer.estimate(&mut states.3, &sample),
                adaptive.estimate(&mut states.4, &sample),
                two.estimate(&mut states.5, &sample),
                kalman.estimate(&mut states.6, &sample),
                three.estimate(&mut states.7, &sample),
                counting.estimate(&mut states.8, &sample),
            ];
        }
        v
    }

    #[test]
    fn law_single_precision_does_not_decay_over_ten_million_turns() {
        // Where the motor stands at the start changes no bit.
        let near = end(0, 3000);
        for start in [1_000_000, 10_000_000, -10_000_000] {
            assert_eq!(end(start, 3000), near);
        }
        let truth = 997.0 * core::f32::consts::TAU / 2.0;
        for (i, v) in near.iter().enumerate() {
            // Ten thousand roundings of single precision, through gains of at most the sampling rate.
            assert!((v / truth - 1.0).abs() < 1e-4, "{i}: {v} {truth}");
        }
    }

    #[test]
    fn law_turning_on_changes_nothing() {
        let (early, late) = (end(0, 10_000), end(0, 500_000));
        for (a, b) in early.iter().zip(&late) {
            assert!((a / b - 1.0).abs() < 2e-5, "{early:?} {late:?}");
        }
    }

    #[test]
    fn law_angles_on_a_circle_are_counts_on_a_line() {
        let circle = Circle::<f32>::new(core::f64::consts::TAU).unwrap();
        let pll = TrackingLoop::<f32>::new(50.0, 1e-3).unwrap();
        let mut last = CircleState::new(0.0);
        let mut state = pll.start(0.0);
        let (mut angle, mut v) = (0.0f64, 0.0);
        for _ in 0..20_000 {
            angle = (angle - 0.7).rem_euclid(core::f64::consts::TAU);
            v = pll.estimate(&mut state, &circle.sample(&mut last, angle as f32, 0.0));
        }
        assert!((v / -700.0 - 1.0).abs() < 1e-4, "{v}");
        // No number is no reading: the loop goes on.
        let sample = circle.sample(&mut last, f32::NAN, 0.0);
        assert_eq!(sample.way, None);
        assert!((pll.estimate(&mut state, &sample) / v - 1.0).abs() < 1e-3);
    }

    #[test]
    fn refuses_turns_and_bits_that_cannot_be() {
        assert!(Circle::<f32>::new(0.0).is_err());
        assert!(Circle::<f64>::new(f64::NAN).is_err());
        assert!(Counter::<f32>::new(1.0, 0).is_err());
        assert!(Counter::<f32>::new(1.0, 33).is_err());
        assert!(Counter::<f32>::new(-1.0, 16).is_err());
    }
}

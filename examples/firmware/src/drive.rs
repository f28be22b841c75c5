//! A drive with an encoder on a timer: velocity from captured edges, the accelerometer beside it.
//!
//! The timer counts the encoder in 16 bits and captures its own clock at every edge; once per control period the drive reads
//! both. What cannot be is taken out first. Two estimators run on the same samples: M/T, which needs no accelerometer, and the
//! Kalman filter on edges, which knows its uncertainty.

use proofmass_core::Error;
use proofmass_core::velocity::{
    Counter, CounterState, CountingKalman, CountingNoise, CountingState, Edge, Estimator,
    InputFault, InputGuard, InputGuardState, MixedTime, MixedTimeMemory,
};

/// Control period, s.
pub const PERIOD: f64 = 1e-3;

/// Clock of the timer, Hz.
pub const CLOCK: f64 = 1e6;

/// One of 2000 counts of a turn, rad.
pub const COUNT: f64 = core::f64::consts::TAU / 2000.0;

/// What the timer and the converter hold at the end of a control period.
#[derive(Clone, Copy, Debug)]
pub struct Captured {
    /// Counter of the encoder, which rolls over.
    pub count: u16,
    /// Clock at the end of the period.
    pub clock: u32,
    /// Clock at the last edge, where one came in this period, and whether the count rose.
    pub edge: Option<(u32, bool)>,
    /// Acceleration along the circle over the radius, rad/s².
    pub acceleration: f32,
}

/// Velocity of a motor by M/T and by the Kalman filter on edges.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    counter: Counter<f32>,
    words: CounterState,
    guard: InputGuard<f32>,
    last: InputGuardState<f32>,
    mixed: MixedTime<f32>,
    intervals: MixedTimeMemory<f32>,
    kalman: CountingKalman<f32>,
    motion: CountingState<f32>,
    /// Counts since the start, of which M/T takes differences.
    place: i32,
}

/// What the drive is told.
#[derive(Clone, Copy, Debug)]
pub struct Speed {
    /// By M/T, rad/s.
    pub mixed: f32,
    /// By the Kalman filter, rad/s.
    pub kalman: f32,
    /// Its standard uncertainty.
    pub uncertainty: f32,
    /// What was refused of this sample.
    pub fault: Option<InputFault>,
}

impl Drive {
    /// At rest, with this count: at most 700 rad/s and 5000 rad/s², edges true to a tenth of a count.
    ///
    /// # Errors
    /// None for these numbers.
    pub fn new(count: u16) -> Result<Self, Error> {
        let guard = InputGuard::new(700.0 * PERIOD, 5000.0)?;
        let mixed = MixedTime::new(COUNT, CLOCK, 0.1)?.with_edge_uncertainty(0.07 * COUNT)?;
        let kalman = CountingKalman::new(
            COUNT,
            PERIOD,
            &CountingNoise {
                acceleration: 4.0,
                walk: 0.0,
                edge: 0.005,
                tick: Some(1.0 / CLOCK),
            },
        )?;
        Ok(Self {
            counter: Counter::new(COUNT, 16)?,
            words: CounterState::new(u32::from(count)),
            last: guard.start(),
            guard,
            intervals: Estimator::start(&mixed, 0.0),
            mixed,
            motion: Estimator::start(&kalman, 0.0),
            kalman,
            place: 0,
        })
    }

    /// One control period.
    pub fn step(&mut self, captured: &Captured) -> Speed {
        let word = u32::from(captured.count);
        let sample = self
            .counter
            .sample(&mut self.words, word, captured.acceleration);
        let (sample, fault) = self.guard.check(&mut self.last, &sample);
        self.place = self.place.wrapping_add(sample.counts.unwrap_or(0));
        let edge = captured.edge.filter(|_| sample.counts.is_some());
        let edge = edge.map(|(ticks, upwards)| Edge {
            count: self.place,
            ticks,
            upwards,
        });
        let sample = sample.timed(captured.clock, edge);
        let kalman = self.kalman.estimate(&mut self.motion, &sample);
        Speed {
            mixed: self.mixed.estimate(&mut self.intervals, &sample),
            kalman,
            uncertainty: self.kalman.velocity(&self.motion).1,
            fault,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor that turns at a speed for so many periods, as its timer shows it.
    fn turn(
        drive: &mut Drive,
        from: f64,
        speed: f64,
        periods: u32,
        clock: &mut u32,
    ) -> (f64, Speed) {
        let mut angle = from;
        let mut told = None;
        for _ in 0..periods {
            let before = (angle / COUNT).floor();
            angle += speed * PERIOD;
            let count = (angle / COUNT).floor();
            *clock = clock.wrapping_add((CLOCK * PERIOD) as u32);
            // The last edge lies where the count changed last; the clock is captured at the tick after it.
            let place = if speed > 0.0 { count } else { count + 1.0 };
            let age = (angle - place * COUNT) / speed;
            let edge = (count != before).then(|| {
                (
                    clock.wrapping_sub((age * CLOCK).floor() as u32),
                    speed > 0.0,
                )
            });
            told = Some(drive.step(&Captured {
                count: count as i64 as u16,
                clock: *clock,
                edge,
                acceleration: 0.0,
            }));
        }
        (angle, told.unwrap())
    }

    #[test]
    fn known_speeds_in_both_senses_and_after_millions_of_counts() {
        let start = 65_000.0 * COUNT;
        for speed in [0.5, 40.0, -40.0, 600.0] {
            let mut drive = Drive::new(65_000).unwrap();
            // Close to the clock's own rollover.
            let mut clock = u32::MAX - 5_000;
            let (_, told) = turn(&mut drive, start + 0.3 * COUNT, speed, 20_000, &mut clock);
            let speed = speed as f32;
            assert!(told.fault.is_none());
            // A tick of the clock in the interval between two edges.
            assert!((told.mixed / speed - 1.0).abs() < 2e-3, "{speed}: {told:?}");
            assert!(
                (told.kalman - speed).abs() < 3.0 * told.uncertainty,
                "{speed}: {told:?}"
            );
            assert!(told.uncertainty < 0.3, "{told:?}");
        }
    }

    #[test]
    fn law_a_motor_that_stops_is_told_to_stand() {
        let mut drive = Drive::new(0).unwrap();
        let mut clock = 0;
        let (angle, told) = turn(&mut drive, 0.5 * COUNT, 40.0, 2_000, &mut clock);
        let count = (angle / COUNT).floor() as i64 as u16;
        assert!(told.mixed > 39.0);
        for _ in 0..200 {
            clock += 1000;
            let told = drive.step(&Captured {
                count,
                clock,
                edge: None,
                acceleration: 0.0,
            });
            assert!(told.mixed <= 40.1);
        }
        assert_eq!(drive.intervals.reading.unwrap().0, 0.0);
    }
}

//! One axis with its two sensors on one time base.

mod alignment;

pub use alignment::{
    HoledClock, Stamped, Timing, align, common_start, even_clock, even_rows, interval,
    out_of_order, stamp_digit,
};

use crate::{Hole, LowCorner};
use proofmass_core::Error;
use proofmass_core::check::within;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// What the slow, drift-free sensor reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReadingSource {
    /// Position: encoder, resolver, laser distance.
    Position,
    /// Velocity: wheel speed, tachogenerator, laser Doppler.
    Speed,
}

/// Readings of both sensors at equal steps of time, or of one alone.
///
/// **Units** one length unit throughout: position, position/s, position/s² (or rad).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MotionRecord {
    /// Sample time, s.
    pub sample_time: f64,
    /// What `reading` is.
    pub source: ReadingSource,
    /// Position or speed; `None` where there is none.
    pub reading: Vec<Option<f64>>,
    /// Acceleration; same length. Zeros where there is no accelerometer.
    pub acceleration: Vec<f64>,
    /// Whether there is an accelerometer. Without one the velocity is taken to change at random.
    pub accelerometer: bool,
    /// Increment δ of the reading, when it is quantised: gives R = δ²/12.
    pub increment: Option<f64>,
    /// Velocity at the first sample, where it is stated, zero for a start from rest; `None` where the first readings tell it.
    pub initial_velocity: Option<f64>,
    /// Its standard uncertainty; zero for one that is exact.
    pub initial_velocity_uncertainty: f64,
    /// Edges between the samples, where they were timed; `reading` then is the count at each sample.
    pub edges: Option<TimedEdges>,
    /// Way of one turn, where the reading is the angle of a resolver.
    pub turn: Option<f64>,
    /// Time of the first sample, s, so that the times of findings are those of the recording.
    pub start: f64,
    /// Relative standard uncertainty of the accelerometer's gain, where a calibration or a data sheet states one: the gain is then
    /// found beside the readings and held by this; without it nothing holds it.
    pub gain_uncertainty: Option<f64>,
    /// Where the accelerometer may have missed a part of the motion.
    pub blows: Vec<Blow>,
    /// Samples that have no acceleration, in order; what stands there in its place is a line.
    pub holes: Vec<Hole>,
    /// Frequencies below which the accelerometer shows less and less.
    pub low_corner: Option<LowCorner>,
    /// Corner whose slow accelerations were given back: the noise of the accelerometer was integrated with them.
    pub(crate) given_back: Option<LowCorner>,
}

/// Samples in which the velocity changed faster than an accelerometer follows: filters and smoothers take what it says of them
/// for a part of the change only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blow {
    /// First sample.
    pub from: usize,
    /// Sample after the last.
    pub to: usize,
    /// Standard deviation of the change of velocity that was not seen.
    pub velocity: f64,
}

/// Edges of a counted position with their times.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedEdges {
    /// Tick of the clock that timed them, s.
    pub(crate) tick: f64,
    /// In order of time.
    pub(crate) list: Vec<PassedAt>,
}

/// One edge as a filter at samples takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassedAt {
    /// The first sample at or after it.
    pub(crate) sample: usize,
    /// How long before that sample, s.
    pub(crate) age: f64,
    /// Whether the count rose.
    pub(crate) upwards: bool,
}

impl TimedEdges {
    /// Of a stretch of the samples.
    fn within(&self, range: &std::ops::Range<usize>) -> Self {
        let inside = self
            .list
            .iter()
            .filter(|e| e.sample > range.start && e.sample < range.end);
        Self {
            tick: self.tick,
            list: inside
                .map(|e| PassedAt {
                    sample: e.sample - range.start,
                    ..*e
                })
                .collect(),
        }
    }

    /// Of every n-th sample.
    fn decimated(&self, n: usize, step: f64) -> Self {
        let at = |e: &PassedAt| {
            let sample = e.sample.div_ceil(n);
            PassedAt {
                sample,
                age: e.age + (sample * n - e.sample) as f64 * step,
                upwards: e.upwards,
            }
        };
        Self {
            tick: self.tick,
            list: self.list.iter().map(at).collect(),
        }
    }
}

impl MotionRecord {
    /// A position record that starts at an unknown velocity.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn new(
        sample_time: f64,
        source: ReadingSource,
        reading: Vec<Option<f64>>,
        acceleration: Vec<f64>,
    ) -> Result<Self, Error> {
        let record = Self {
            sample_time,
            source,
            reading,
            acceleration,
            accelerometer: true,
            increment: None,
            initial_velocity: None,
            initial_velocity_uncertainty: 0.0,
            edges: None,
            turn: None,
            start: 0.0,
            gain_uncertainty: None,
            blows: Vec::new(),
            holes: Vec::new(),
            low_corner: None,
            given_back: None,
        };
        record.check()?;
        Ok(record)
    }

    /// Positions or speeds alone, at an unknown velocity at the start.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn without_accelerometer(
        sample_time: f64,
        source: ReadingSource,
        reading: Vec<Option<f64>>,
    ) -> Result<Self, Error> {
        let zeros = vec![0.0; reading.len()];
        let record = Self::new(sample_time, source, reading, zeros)?;
        Ok(Self {
            accelerometer: false,
            ..record
        })
    }

    /// Lengths, finiteness, sample time, and that there is something to work on.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::NotFinite`] with the index, [`Error::OutOfRange`], or [`Error::TooFew`] below
    /// four samples or two readings.
    pub fn check(&self) -> Result<(), Error> {
        let n = self.reading.len();
        if !(self.sample_time.is_finite() && self.sample_time > 0.0) {
            return Err(Error::OutOfRange {
                name: "sample time",
                value: self.sample_time,
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            });
        }
        if self.acceleration.len() != n {
            return Err(Error::Length {
                name: "acceleration",
                expected: n,
                got: self.acceleration.len(),
            });
        }
        if !self.start.is_finite() {
            return Err(Error::NotFinite {
                name: "time of the first sample",
                index: 0,
            });
        }
        let bad = |r: &Option<f64>| r.is_some_and(|r| !r.is_finite());
        if let Some(index) = self.reading.iter().position(bad) {
            return Err(Error::NotFinite {
                name: "reading",
                index,
            });
        }
        if let Some(index) = self.acceleration.iter().position(|a| !a.is_finite()) {
            return Err(Error::NotFinite {
                name: "acceleration",
                index,
            });
        }
        for (name, value) in [
            ("increment", self.increment),
            ("initial velocity", self.initial_velocity),
            ("turn", self.turn),
            ("uncertainty of the gain", self.gain_uncertainty),
        ] {
            if value.is_some_and(|v| !v.is_finite()) {
                return Err(Error::NotFinite { name, index: 0 });
            }
        }
        for (name, value) in [
            ("increment", self.increment),
            ("turn", self.turn),
            ("uncertainty of the gain", self.gain_uncertainty),
        ] {
            if let Some(value) = value.filter(|d| *d <= 0.0) {
                return Err(Error::OutOfRange {
                    name,
                    value,
                    min: f64::MIN_POSITIVE,
                    max: f64::MAX,
                });
            }
        }
        within(
            "uncertainty of the initial velocity",
            self.initial_velocity_uncertainty,
            0.0,
            f64::MAX,
        )?;
        if n < 4 {
            return Err(Error::TooFew {
                name: "samples",
                needed: 4,
                got: n,
            });
        }
        let readings = self.reading.iter().flatten().count();
        if readings < 2 {
            return Err(Error::TooFew {
                name: "readings",
                needed: 2,
                got: readings,
            });
        }
        Ok(())
    }

    /// Every n-th sample, as a slower bench would have taken it: no filter before.
    ///
    /// # Errors
    /// As [`check`](Self::check) when too little is left, [`Error::OutOfRange`] for n = 0.
    pub fn decimated(&self, n: usize) -> Result<Self, Error> {
        if n == 0 {
            return Err(Error::OutOfRange {
                name: "decimation",
                value: 0.0,
                min: 1.0,
                max: f64::MAX,
            });
        }
        let record = Self {
            sample_time: self.sample_time * n as f64,
            reading: self.reading.iter().step_by(n).copied().collect(),
            acceleration: self.acceleration.iter().step_by(n).copied().collect(),
            edges: self
                .edges
                .as_ref()
                .map(|e| e.decimated(n, self.sample_time)),
            blows: self.blows_at(|k| k.div_ceil(n)),
            holes: self.holes.iter().filter_map(|h| h.decimated(n)).collect(),
            ..*self
        };
        record.check()?;
        Ok(record)
    }

    /// The same readings beside an accelerometer whose gain and latency are put right: its values over the gain, taken
    /// `latency` seconds later, on the polynomial of fifth degree through the six nearest samples. Where these lie
    /// beyond an end, the value at the end stands.
    #[must_use]
    pub fn corrected(&self, gain: f64, latency: f64) -> Self {
        let a = &self.acceleration;
        let n = a.len();
        let at = |k: usize| {
            let x = (k as f64 + latency / self.sample_time).clamp(0.0, (n - 1) as f64);
            let whole = x.floor() as usize;
            if latency == 0.0 || n < 6 || x == whole as f64 {
                return a[whole];
            }
            let from = (whole + 1).saturating_sub(3).min(n - 6);
            let s = x - from as f64;
            let weight = |i: usize| -> f64 {
                let others = (0..6).filter(|j| *j != i).map(|j| j as f64);
                others.map(|j| (s - j) / (i as f64 - j)).product()
            };
            (0..6).map(|i| weight(i) * a[from + i]).sum()
        };
        let mut record = self.beside((0..n).map(|k| at(k) / gain).collect());
        for hole in &mut record.holes {
            *hole = Hole {
                velocity: hole.velocity / gain.abs(),
                ..hole.moved(latency / self.sample_time, n)
            };
        }
        record.holes.retain(|hole| hole.from < hole.to);
        record
    }

    /// The same readings beside another acceleration.
    pub(crate) fn beside(&self, acceleration: Vec<f64>) -> Self {
        Self {
            acceleration,
            reading: self.reading.clone(),
            edges: self.edges.clone(),
            blows: self.blows.clone(),
            holes: self.holes.clone(),
            ..*self
        }
    }

    /// The blows with their samples at other places; those that are gone are left out.
    fn blows_at(&self, place: impl Fn(usize) -> usize) -> Vec<Blow> {
        let moved = self.blows.iter().map(|b| Blow {
            from: place(b.from),
            to: place(b.to),
            ..*b
        });
        moved.filter(|b| b.from < b.to).collect()
    }

    /// A stretch of the samples; the velocity at its start is unknown unless it is the beginning. `None` where the
    /// samples are not there.
    pub fn within(&self, range: std::ops::Range<usize>) -> Option<Self> {
        Some(Self {
            reading: self.reading.get(range.clone())?.to_vec(),
            acceleration: self.acceleration.get(range.clone())?.to_vec(),
            initial_velocity: self.initial_velocity.filter(|_| range.start == 0),
            start: self.start + range.start as f64 * self.sample_time,
            edges: self.edges.as_ref().map(|e| e.within(&range)),
            blows: self.blows_at(|k| k.clamp(range.start, range.end) - range.start),
            holes: self.holes.iter().filter_map(|h| h.within(&range)).collect(),
            ..*self
        })
    }

    /// Largest n such that all readings stand at multiples of n samples after the first one.
    pub fn reading_stride(&self) -> usize {
        let mut at = self
            .reading
            .iter()
            .enumerate()
            .filter_map(|(k, r)| r.map(|_| k));
        let Some(first) = at.next() else { return 1 };
        at.fold(0, |stride, k| gcd(stride, k - first)).max(1)
    }

    /// One value for each reading in its place, zeros where one is missing, so that what repeats in time does so in the list. Where
    /// most are missing they have no places, and stand as they are.
    pub(crate) fn in_places<'a>(&self, values: &'a [f64]) -> Cow<'a, [f64]> {
        let at = |r: &(usize, &Option<f64>)| r.1.is_some();
        let mut places = self.reading.iter().enumerate().filter(at).map(|r| r.0);
        let (first, last) = (places.clone().next(), places.clone().next_back());
        let (Some(first), Some(last)) = (first, last) else {
            return Cow::from(values);
        };
        let stride = self.reading_stride();
        let due = (last - first) / stride + 1;
        if due == values.len() || due > 2 * values.len() {
            return Cow::from(values);
        }
        let mut list = vec![0.0; due];
        for (value, k) in values.iter().zip(&mut places) {
            list[(k - first) / stride] = *value;
        }
        Cow::from(list)
    }

    /// The readings as positions: themselves, or the integral of the speed by the trapezoid (over gaps too).
    pub fn positions(&self) -> Vec<Option<f64>> {
        match self.source {
            ReadingSource::Position => self.reading.clone(),
            ReadingSource::Speed => {
                let mut last: Option<(usize, f64)> = None;
                let mut x = 0.0;
                self.reading
                    .iter()
                    .enumerate()
                    .map(|(k, speed)| {
                        let speed = (*speed)?;
                        if let Some((j, before)) = last {
                            x += 0.5 * (k - j) as f64 * self.sample_time * (before + speed);
                        }
                        last = Some((k, speed));
                        Some(x)
                    })
                    .collect()
            }
        }
    }

    /// Times of the samples from zero, s.
    pub fn times(&self) -> Vec<f64> {
        (0..self.reading.len())
            .map(|k| k as f64 * self.sample_time)
            .collect()
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_records_without_substance() {
        let bad = MotionRecord::new(
            0.1,
            ReadingSource::Position,
            vec![Some(1.0); 5],
            vec![0.0; 4],
        );
        assert!(matches!(bad, Err(Error::Length { .. })));
        let bad = MotionRecord::new(0.1, ReadingSource::Position, vec![None; 5], vec![0.0; 5]);
        assert!(matches!(bad, Err(Error::TooFew { .. })));
        let bad = MotionRecord::new(
            0.1,
            ReadingSource::Speed,
            vec![Some(f64::NAN); 5],
            vec![0.0; 5],
        );
        assert!(matches!(bad, Err(Error::NotFinite { .. })));
    }
}

//! One axis with its two sensors on one time base.

use proofmass_core::Error;
use serde::{Deserialize, Serialize};

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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    #[serde(default = "there_is_one")]
    pub accelerometer: bool,
    /// Increment δ of the reading, when it is quantised: gives R = δ²/12.
    pub increment: Option<f64>,
    /// Velocity at the first sample; `None` when unknown, zero for a start from rest.
    pub initial_velocity: Option<f64>,
}

fn there_is_one() -> bool {
    true
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
        ] {
            if value.is_some_and(|v| !v.is_finite()) {
                return Err(Error::NotFinite { name, index: 0 });
            }
        }
        if self.increment.is_some_and(|d| d <= 0.0) {
            return Err(Error::OutOfRange {
                name: "increment",
                value: self.increment.unwrap_or(0.0),
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            });
        }
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
        Self {
            reading: self.reading.clone(),
            acceleration: (0..n).map(|k| at(k) / gain).collect(),
            ..*self
        }
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

/// Samples of one sensor with its own time stamps.
#[derive(Clone, Copy, Debug)]
pub struct Stamped<'a> {
    /// Times, s, strictly increasing.
    pub time: &'a [f64],
    /// Values at them.
    pub value: &'a [f64],
}

impl Stamped<'_> {
    /// Equal lengths, finite, and in order of time.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::NotFinite`]; [`Error::OutOfRange`] with the first time that is not later than
    /// the one before. Its index is [`out_of_order`].
    pub fn check(&self, name: &'static str) -> Result<(), Error> {
        if self.time.len() != self.value.len() {
            return Err(Error::Length {
                name,
                expected: self.time.len(),
                got: self.value.len(),
            });
        }
        for values in [self.time, self.value] {
            if let Some(index) = values.iter().position(|v| !v.is_finite()) {
                return Err(Error::NotFinite { name, index });
            }
        }
        match out_of_order(self.time) {
            Some(index) => Err(Error::NotIncreasing {
                name: "time stamp",
                index,
            }),
            None => Ok(()),
        }
    }

    /// Straight line between the neighbours of a time; `None` outside or over a gap longer than `gap`.
    ///
    /// A sample within `slack` of the time is taken as it is: a line would smear its rounding.
    fn at(&self, t: f64, gap: f64, slack: f64) -> Option<f64> {
        let after = self.time.partition_point(|&s| s < t - slack);
        if after < self.time.len() && self.time[after] <= t + slack {
            return Some(self.value[after]);
        }
        if after == 0 || after == self.time.len() {
            return None;
        }
        let (a, b) = (self.time[after - 1], self.time[after]);
        let share = (t - a) / (b - a);
        (b - a <= gap).then(|| self.value[after - 1] * (1.0 - share) + self.value[after] * share)
    }
}

/// Index of the first time that is not later than the one before it.
pub fn out_of_order(time: &[f64]) -> Option<usize> {
    time.windows(2).position(|w| w[1] <= w[0]).map(|k| k + 1)
}

/// When the readings of a [`Stamped`] sensor were taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Timing {
    /// By a clock, whatever the axis did.
    #[default]
    Sampled,
    /// At the edges of the encoder: between two of them the axis is within one increment, however long it takes.
    Edges,
}

/// Step of a clock whose stamps were rounded, or `None` when the stamps do not lie on one.
///
/// Stamps that are all multiples of a power of ten 10⁻ᵏ s and never further than three quarters of it from a
/// straight line are the stamps of an even clock, rounded: the line is nearer to the truth than they are.
pub fn even_clock(time: &[f64]) -> Option<f64> {
    let n = time.len();
    if n < 3 {
        return None;
    }
    let dt = (time[n - 1] - time[0]) / (n - 1) as f64;
    // Stamps of an absolute clock have no finer digits than the double they are held in.
    let coarse = 4.0 * f64::EPSILON * time.iter().fold(0.0f64, |m, t| m.max(t.abs()));
    let resolution = (0..10).map(|k| 10f64.powi(-k)).find(|r| {
        let off = |t: &f64| (t / r - (t / r).round()).abs() * r > 1e-6 * r + coarse;
        !time.iter().any(off)
    });
    let allowed = 0.75 * resolution.unwrap_or(0.0) + 1e-6 * dt + coarse;
    // The ends are rounded as well: the line of least squares, not the one through them.
    let middle = 0.5 * (n - 1) as f64;
    let mean = time.iter().map(|t| t - time[0]).sum::<f64>() / n as f64;
    let (mut top, mut bottom) = (0.0, 0.0);
    for (k, t) in time.iter().enumerate() {
        let k = k as f64 - middle;
        top += k * (t - time[0] - mean);
        bottom += k * k;
    }
    let step = top / bottom;
    let on_line = |(k, t): (usize, &f64)| {
        (t - time[0] - mean - step * (k as f64 - middle)).abs() <= allowed.min(0.5 * dt)
    };
    (step > 0.0 && time.iter().enumerate().all(on_line)).then_some(step)
}

/// Puts two sensors with their own time stamps on one time base.
///
/// The grid starts with the later sensor and steps by `sample_time`, or by the median interval of the
/// accelerometer. Accelerations are interpolated over gaps up to three intervals; over longer ones the common
/// span would hold invented data and is refused. A reading appears at the grid time nearest to its own,
/// interpolated to it between its neighbours: the error of that, a Δ²/8 for readings Δ apart, is of the order
/// of the sensors' own and stays out of every grid time that has no reading of its own. Where the neighbour is
/// missing, a reading counts only within a hundredth of a step of its own time.
///
/// # Errors
/// Time stamps out of order ([`Error::NotIncreasing`] with the index), unequal lengths, values that are not
/// finite, no common span ([`Error::TooFew`]), a gap of the accelerometer ([`Error::OutOfRange`]).
pub fn align(
    source: ReadingSource,
    reading: Stamped<'_>,
    acceleration: Stamped<'_>,
    sample_time: Option<f64>,
    timing: Timing,
) -> Result<MotionRecord, Error> {
    reading.check("reading")?;
    acceleration.check("acceleration")?;
    let few = |got| Error::TooFew {
        name: "samples common to both sensors",
        needed: 4,
        got,
    };
    if reading.time.len() < 2 || acceleration.time.len() < 4 {
        return Err(few(reading.time.len().min(acceleration.time.len())));
    }
    let median = |time: &[f64]| {
        let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps[steps.len() / 2]
    };
    let own = median(acceleration.time);
    let dt = sample_time.unwrap_or(own);
    if !(dt.is_finite() && dt > 0.0) {
        return Err(Error::OutOfRange {
            name: "sample time",
            value: dt,
            min: f64::MIN_POSITIVE,
            max: f64::MAX,
        });
    }
    let start = reading.time[0].max(acceleration.time[0]);
    let end =
        reading.time[reading.time.len() - 1].min(acceleration.time[acceleration.time.len() - 1]);
    if end - start < 3.0 * dt {
        return Err(few(0));
    }
    // A rounding of the stamps must not cost the last sample.
    let n = ((end - start) / dt + 1e-6).floor() as usize + 1;
    let slack = 1e-6 * dt;
    let gap = 3.0 * own.max(dt);
    let reading_gap = match timing {
        Timing::Sampled => 3.0 * median(reading.time),
        Timing::Edges => f64::INFINITY,
    };
    let mut a = Vec::with_capacity(n);
    let mut r = vec![None; n];
    for (k, r) in r.iter_mut().enumerate() {
        let t = (start + k as f64 * dt).min(end);
        let Some(value) = acceleration.at(t, gap, slack) else {
            let after = acceleration.time.partition_point(|&s| s < t).max(1);
            return Err(Error::OutOfRange {
                name: "gap of the accelerometer",
                value: acceleration.time[after] - acceleration.time[after - 1],
                min: 0.0,
                max: gap,
            });
        };
        a.push(value);
        let near = reading.time.partition_point(|&s| s < t - 0.5 * dt);
        let own = (near..reading.time.len())
            .take_while(|&i| reading.time[i] < t + 0.5 * dt)
            .min_by(|&i, &j| {
                let off = |i: usize| (reading.time[i] - t).abs();
                off(i).total_cmp(&off(j))
            });
        if let Some(own) = own {
            let close = (reading.time[own] - t).abs() <= 0.01 * dt;
            *r = reading
                .at(t, reading_gap, slack)
                .or_else(|| close.then(|| reading.value[own]));
        }
    }
    MotionRecord::new(dt, source, r, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_alignment_puts_two_rates_on_one_base() {
        let fast: Vec<f64> = (0..1000).map(|k| 0.0503 + 0.001 * k as f64).collect();
        let slow: Vec<f64> = (0..200).map(|k| 0.007 * k as f64).collect();
        let a: Vec<f64> = fast.iter().map(|t| 2.0 + 0.0 * t).collect();
        let x: Vec<f64> = slow.iter().map(|t| t * t).collect();
        let record = align(
            ReadingSource::Position,
            Stamped {
                time: &slow,
                value: &x,
            },
            Stamped {
                time: &fast,
                value: &a,
            },
            None,
            Timing::Sampled,
        )
        .unwrap();
        assert_eq!(record.reading.len(), 1000);
        let own = record.reading.iter().flatten().count();
        assert!((142..=143).contains(&own), "{own}");
        for (k, r) in record.reading.iter().enumerate() {
            if let Some(r) = r {
                let t = 0.0503 + record.sample_time * k as f64;
                assert!((r - t * t).abs() <= 2.0 * 0.007f64.powi(2) / 8.0 + 1e-12);
            }
        }
    }

    #[test]
    fn refuses_time_that_runs_backward_with_its_index() {
        let time = [0.0, 0.1, 0.3, 0.2, 0.4];
        let value = [0.0; 5];
        let good = [0.0, 0.1, 0.2, 0.3, 0.4];
        let error = align(
            ReadingSource::Position,
            Stamped {
                time: &time,
                value: &value,
            },
            Stamped {
                time: &good,
                value: &value,
            },
            None,
            Timing::Sampled,
        );
        assert!(
            matches!(error, Err(Error::NotIncreasing { index: 3, .. })),
            "{error:?}"
        );
        assert_eq!(out_of_order(&time), Some(3));
        assert_eq!(out_of_order(&[0.0, 0.0]), Some(1));
    }

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

    #[test]
    fn law_an_even_clock_is_known_behind_rounded_stamps() {
        // 300 Hz stamped in whole milliseconds; and the same after 1.7e9 s.
        for start in [0.0, 1.7e9] {
            let stamps: Vec<f64> = (0..900)
                .map(|k| start + (1000.0 * f64::from(k) / 300.0).round() / 1000.0)
                .collect();
            let step = even_clock(&stamps).expect("an even clock");
            // 900 stamps, each rounded by 0.3 ms: the slope is good to 0.3 ms/(900 √(900/12)).
            assert!((step - 1.0 / 300.0).abs() < 2e-7, "{step}");
        }
        let uneven: Vec<f64> = (0..900)
            .map(|k| f64::from(k) / 300.0 + 1e-3 * (0.1 * f64::from(k)).sin())
            .collect();
        assert!(even_clock(&uneven).is_none());
    }
}

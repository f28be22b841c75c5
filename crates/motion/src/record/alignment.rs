//! Two sensors with their own time stamps on one time base.

use super::{MotionRecord, ReadingSource};
use crate::findings;
use crate::hole;
use crate::stretch::even_times;
use proofmass_core::Error;
use proofmass_signal::clock;
use proofmass_uncertainty::Finding;
use std::ops::Range;

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

impl Stamped<'_> {
    /// Whether a time is none of a sample and lies between two that are further apart than `step`.
    fn misses(&self, t: f64, step: f64, slack: f64) -> bool {
        let after = self.time.partition_point(|&s| s < t - slack);
        after > 0
            && after < self.time.len()
            && self.time[after] > t + slack
            && self.time[after] - self.time[after - 1] > step
    }
}

/// A reading of speed moved from its own time to a near one, along the line of least squares through it and up to three
/// neighbours on either side. A line between two readings would take the highest frequencies from their noise.
fn moved(reading: &Stamped<'_>, own: usize, t: f64, gap: f64) -> f64 {
    const SIDE: usize = 3;
    let (mut from, mut to) = (own, own);
    while from > 0 && own - from < SIDE && reading.time[from] - reading.time[from - 1] <= gap {
        from -= 1;
    }
    while to + 1 < reading.time.len()
        && to - own < SIDE
        && reading.time[to + 1] - reading.time[to] <= gap
    {
        to += 1;
    }
    let count = (to - from + 1) as f64;
    let mean = |x: &[f64]| x[from..=to].iter().sum::<f64>() / count;
    let (middle, level) = (mean(reading.time), mean(reading.value));
    let (mut top, mut bottom) = (0.0, 0.0);
    for k in from..=to {
        let off = reading.time[k] - middle;
        top += off * (reading.value[k] - level);
        bottom += off * off;
    }
    let slope = if bottom > 0.0 { top / bottom } else { 0.0 };
    reading.value[own] + slope * (t - reading.time[own])
}

/// Index of the first time that is not later than the one before it.
pub fn out_of_order(time: &[f64]) -> Option<usize> {
    time.windows(2).position(|w| w[1] <= w[0]).map(|k| k + 1)
}

/// When the readings of a [`Stamped`] sensor were taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// By a clock, whatever the axis did.
    #[default]
    Sampled,
    /// At the edges of the encoder: between two of them the axis is within one increment, however long it takes.
    Edges,
}

/// The power of ten of a second, from one to a nanosecond, all stamps are multiples of; `None` where they have more digits.
pub fn stamp_digit(time: &[f64]) -> Option<f64> {
    // Stamps of an absolute clock have no finer digits than the double they are held in.
    let coarse = 4.0 * f64::EPSILON * time.iter().fold(0.0f64, |m, t| m.max(t.abs()));
    (0..10).map(|k| 10f64.powi(-k)).find(|r| {
        let off = |t: &f64| (t / r - (t / r).round()).abs() * r > 1e-6 * r + coarse;
        !time.iter().any(off)
    })
}

/// Sampling interval behind time stamps, by the line of their clock ([`proofmass_signal::clock`]); `None` where they have none.
pub fn interval(time: &[f64]) -> Option<f64> {
    match time {
        [first, last] => Some(last - first).filter(|step| *step > 0.0),
        _ => Some(1.0 / clock::read(time, None).ok()?.0.rate_hz),
    }
}

/// Step of a clock whose stamps were rounded, or `None` when the stamps do not lie on one.
///
/// Stamps of which none is missing and that scatter about the line of their clock by no more than their resolution does, q/√12 and 40 %
/// for short records, are the stamps of an even clock, rounded: the line is nearer to the truth than they are.
pub fn even_clock(time: &[f64]) -> Option<f64> {
    let (clock, slips) = clock::read(time, None).ok()?;
    let step = 1.0 / clock.rate_hz;
    let allowed = 0.4 * clock.resolution_s + 1e-6 * step + coarse(time);
    let even = slips.is_empty() && clock.change.is_none() && clock.scatter_s <= allowed;
    even.then_some(step)
}

/// An even clock of which samples are missing: its step, and which of its ticks each stamp is.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HoledClock {
    /// Step, s.
    pub step: f64,
    /// Ticks of the stamps, from zero for the first.
    pub tick: Vec<usize>,
    /// Standard deviation of the stamps about their ticks, s.
    scatter: f64,
    /// The same that rounded stamps of an even clock have at most.
    allowed: f64,
}

impl HoledClock {
    /// The clock behind stamps, where it tells between which of them how many samples are missing; `None` where none is, where the
    /// rate changes, where stamps come in bursts or went back, and where they scatter by a third of a step.
    fn behind(time: &[f64]) -> Option<Self> {
        let (clock, slips) = clock::read(time, None).ok()?;
        let missing: i64 = slips.iter().map(|s| s.samples).sum();
        let plain = !slips.is_empty() && slips.iter().all(|s| s.samples > 0);
        if !plain || missing as u64 != clock.missing || clock.change.is_some() || clock.bursts {
            return None;
        }
        let mut tick = Vec::with_capacity(time.len());
        let mut ahead = slips.iter().peekable();
        let mut passed = 0usize;
        for k in 0..time.len() {
            while let Some(slip) = ahead.next_if(|s| s.row <= k) {
                passed += slip.samples as usize;
            }
            tick.push(k + passed);
        }
        let allowed = 0.4 * clock.resolution_s + 1e-6 / clock.rate_hz + coarse(time);
        // The rate is that which every reader states.
        let step = 1.0 / clock.rate_hz;
        let through = Self::through(time, tick, allowed)?;
        (through.scatter <= MOST * step).then_some(Self { step, ..through })
    }

    /// The line of least squares through stamps over their ticks.
    fn through(time: &[f64], tick: Vec<usize>, allowed: f64) -> Option<Self> {
        let n = time.len() as f64;
        let middle = tick.iter().map(|i| *i as f64).sum::<f64>() / n;
        let mean = time.iter().map(|t| t - time[0]).sum::<f64>() / n;
        let (mut top, mut bottom) = (0.0, 0.0);
        for (t, i) in time.iter().zip(&tick) {
            let off = *i as f64 - middle;
            top += off * (t - time[0] - mean);
            bottom += off * off;
        }
        let mut through = Self {
            step: top / bottom,
            tick,
            scatter: 0.0,
            allowed,
        };
        let even = through.times(time);
        let square = time.iter().zip(&even).map(|(t, e)| (t - e) * (t - e));
        through.scatter = (square.sum::<f64>() / n).sqrt();
        (through.step > 0.0).then_some(through)
    }

    /// The same for stamps that lie on it as far as their digits tell.
    pub fn of(time: &[f64]) -> Option<Self> {
        let (clock, slips) = clock::read(time, None).ok()?;
        let digit = clock.resolution_s * clock.rate_hz;
        // Stamps in whole steps are the ticks themselves; by digits of half a step and more a tick may be missed unseen.
        match digit {
            _ if slips.is_empty() => None,
            _ if (digit - 1.0).abs() < 1e-3 => Self::known(time, clock.resolution_s),
            _ if digit > 0.5 => None,
            _ => Self::behind(time).filter(|clock| clock.scatter <= clock.allowed),
        }
    }

    /// The same for times on a clock whose step is known, however many are missing; `None` where none is, and where they do not lie on it.
    pub fn known(time: &[f64], step: f64) -> Option<Self> {
        let mut tick = vec![0usize];
        for w in time.windows(2) {
            let ahead = ((w[1] - w[0]) / step).round();
            if !(ahead >= 1.0) {
                return None;
            }
            tick.push(tick[tick.len() - 1] + ahead as usize);
        }
        let holed = tick.len() == time.len() && tick[tick.len() - 1] + 1 > tick.len();
        let clock = Self::through(time, tick, 1e-6 * step + coarse(time)).filter(|_| holed)?;
        let same = (clock.step / step - 1.0).abs() < 1e-4;
        (same && clock.scatter <= clock.allowed).then_some(clock)
    }

    /// The stamps that a record at all ticks is made of: the most that follow one another with no more ticks missing than three for
    /// every stamp, the longest gaps taken out first.
    pub fn worthwhile(&self) -> Range<usize> {
        let n = self.tick.len();
        let gap = |k: usize| self.tick[k] - self.tick[k - 1] - 1;
        let mut gaps: Vec<usize> = (1..n).filter(|k| gap(*k) > 0).collect();
        gaps.sort_by_key(|k| gap(*k));
        let mut missing = 0;
        let kept = gaps.iter().take_while(|k| {
            missing += gap(**k);
            missing <= 3 * n
        });
        let kept = kept.count();
        let mut cuts = vec![0, n];
        cuts.extend(&gaps[kept..]);
        cuts.sort_unstable();
        let pieces = cuts.windows(2).map(|w| w[0]..w[1]);
        pieces.max_by_key(Range::len).unwrap_or(0..n)
    }

    /// Times of its ticks whose rounded stamps these are.
    pub fn times(&self, stamps: &[f64]) -> Vec<f64> {
        let n = stamps.len().max(1) as f64;
        let middle = self.tick.iter().map(|i| *i as f64).sum::<f64>() / n;
        let first = stamps.first().copied().unwrap_or(0.0);
        let mean = first + stamps.iter().map(|t| t - first).sum::<f64>() / n;
        let at = |i: &usize| mean + self.step * (*i as f64 - middle);
        self.tick.iter().map(at).collect()
    }
}

/// Digits that stamps of an absolute clock do not have in the double they are held in.
fn coarse(time: &[f64]) -> f64 {
    4.0 * f64::EPSILON * time.iter().fold(0.0f64, |m, t| m.max(t.abs()))
}

/// Scatter of stamps over the step beyond which rows may be out of order.
const MOST: f64 = 0.3;

/// The even clock behind stamps that scatter, where it is they that scatter and not the samples.
///
/// A position between two others lies on a line with them but for its bend and its rounding. Taken at wrong times it is off by its
/// velocity times their error: the squares of that at the stamps and at the even times are compared, and the samples are taken for
/// uneven where they are less at the stamps by four standard deviations of the difference. Where neither shows, times matter
/// little, and even ones leave counts what they are. Ticks of which samples are missing stay empty. `None` for stamps of an even
/// clock, and for uneven samples.
pub fn even_rows(stamps: &[f64], reading: Stamped<'_>) -> Option<(Vec<f64>, Finding)> {
    if reading.check("reading").is_err() || even_clock(stamps).is_some() {
        return None;
    }
    let (clock, slips) = clock::read(stamps, None).ok()?;
    let holed = HoledClock::behind(stamps);
    let (step, scatter, even, tick) = match holed {
        Some(holed) if holed.scatter <= holed.allowed => return None,
        Some(holed) => {
            let even = holed.times(stamps);
            let off: Vec<f64> = stamps.iter().zip(&even).map(|(t, e)| t - e).collect();
            // Errors of stamps are each their own: what stays is a clock that began anew behind a gap.
            let alike: f64 = off.windows(2).map(|w| w[0] * w[1]).sum();
            if alike > 0.5 * off.iter().map(|e| e * e).sum::<f64>() {
                return None;
            }
            (holed.step, holed.scatter, even, holed.tick)
        }
        None => {
            let step = 1.0 / clock.rate_hz;
            let plain = slips.is_empty() && clock.change.is_none() && !clock.bursts;
            if !plain || clock.scatter_s > MOST * step {
                return None;
            }
            let tick = (0..stamps.len()).collect();
            (step, clock.scatter_s, even_times(stamps, step), tick)
        }
    };
    let row = |t: f64| stamps.partition_point(|s| *s < t);
    let off = |at: [f64; 3], x: [f64; 3]| {
        let share = (at[1] - at[0]) / (at[2] - at[0]);
        (x[1] - x[0] * (1.0 - share) - x[2] * share).powi(2)
    };
    let places = reading.time.windows(3).zip(reading.value.windows(3));
    let differences: Vec<f64> = places
        .filter_map(|(t, x)| {
            let rows = [row(t[0]), row(t[1]), row(t[2])];
            let beside = rows[2] < even.len() && tick[rows[2]] == tick[rows[0]] + 2;
            let x = [x[0], x[1], x[2]];
            beside.then(|| off([t[0], t[1], t[2]], x) - off(rows.map(|k| even[k]), x))
        })
        .collect();
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let square: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum();
    // Neighbours share two of their three samples.
    let deviation = (3.0 * square).sqrt() / n;
    let uneven = mean < -4.0 * deviation;
    let finding = findings::stamps_scatter(1e3 * scatter, 100.0 * scatter / step);
    (n > 8.0 && !uneven).then_some((even, finding))
}

/// Where the time base of two sensors begins: with the later of them, beside a speed at a sample of the accelerometer.
///
/// A line between two samples would take the highest frequencies from the accelerometer, by which its noise is known. A
/// speed bends less within a step; counts keep their own times.
pub fn common_start(source: ReadingSource, reading: &[f64], acceleration: &[f64]) -> f64 {
    let first = |time: &[f64]| time.first().copied().unwrap_or(0.0);
    let later = first(reading).max(first(acceleration));
    match source {
        ReadingSource::Position => later,
        ReadingSource::Speed => {
            let at = acceleration.partition_point(|t| *t < later);
            acceleration.get(at).copied().unwrap_or(later)
        }
    }
}

/// Puts two sensors with their own time stamps on one time base.
///
/// The grid starts with the later sensor ([`common_start`]) and steps by `sample_time`, or by the interval of the
/// accelerometer's clock. Where a `sample_time` is given, the one by which the accelerometer's clock ticks, its ticks without an
/// acceleration are holes ([`Hole`](crate::Hole)): the line between those beside stands there. Without one accelerations are
/// interpolated over gaps up to three intervals; over longer ones the common
/// span would hold invented data and is refused. A reading appears at the grid time nearest to its own,
/// interpolated to it between its neighbours: the error of that, a Δ²/8 for readings Δ apart, is of the order
/// of the sensors' own and stays out of every grid time that has no reading of its own. Where the neighbour is
/// missing, a reading counts only within a hundredth of a step of its own time. A reading of speed is moved to the grid
/// time along the slope of its neighbours.
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
    let step = |time: &[f64]| interval(time).unwrap_or(0.0);
    let own = step(acceleration.time);
    let dt = sample_time.unwrap_or(own);
    if !(dt.is_finite() && dt > 0.0) {
        return Err(Error::OutOfRange {
            name: "sample time",
            value: dt,
            min: f64::MIN_POSITIVE,
            max: f64::MAX,
        });
    }
    let start = common_start(source, reading.time, acceleration.time);
    let end =
        reading.time[reading.time.len() - 1].min(acceleration.time[acceleration.time.len() - 1]);
    if end - start < 3.0 * dt {
        return Err(few(0));
    }
    // A rounding of the stamps must not cost the last sample.
    let n = ((end - start) / dt + 1e-6).floor() as usize + 1;
    let slack = 1e-6 * dt;
    // A gap of three intervals is one by its rounding too.
    let gap = (3.0 + 1e-6) * own.max(dt);
    let reading_gap = match timing {
        Timing::Sampled => 3.0 * step(reading.time),
        Timing::Edges => f64::INFINITY,
    };
    let mut a = Vec::with_capacity(n);
    let mut r = vec![None; n];
    let mut without = Vec::new();
    for (k, r) in r.iter_mut().enumerate() {
        let t = (start + k as f64 * dt).min(end);
        if sample_time.is_some() && acceleration.misses(t, 1.5 * own, slack) {
            without.push(k);
        }
        let gap = sample_time.map_or(gap, |_| f64::INFINITY);
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
            *r = match source {
                ReadingSource::Speed => Some(moved(&reading, own, t, reading_gap)),
                ReadingSource::Position => {
                    let close = (reading.time[own] - t).abs() <= 0.01 * dt;
                    reading
                        .at(t, reading_gap, slack)
                        .or_else(|| close.then(|| reading.value[own]))
                }
            };
        }
    }
    let mut record = MotionRecord::new(dt, source, r, a)?;
    record.holes = hole::holes(&record, &without);
    Ok(record)
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

    #[test]
    fn law_missing_rows_keep_the_ticks_of_the_rest() {
        // 300 Hz stamped to a tenth of a millisecond, one row in seven and a second missing.
        let ticks: Vec<usize> = (0..3000)
            .filter(|k| k % 7 != 3 && !(900..1200).contains(k))
            .collect();
        for start in [0.0, 1.7e9] {
            let stamp = |k: &usize| start + (1e4 * *k as f64 / 300.0).round() / 1e4;
            let stamps: Vec<f64> = ticks.iter().map(stamp).collect();
            let clock = HoledClock::of(&stamps).expect("a clock");
            assert_eq!(clock.tick, ticks);
            // 2300 stamps, each rounded by 30 µs: 30 µs/(3000 √(2300/12)) and the same again for the gap.
            assert!((clock.step - 1.0 / 300.0).abs() < 5e-9, "{}", clock.step);
            assert_eq!(clock.worthwhile(), 0..ticks.len());
        }
        let even: Vec<f64> = (0..3000).map(|k| f64::from(k) / 300.0).collect();
        assert_eq!(HoledClock::of(&even), None);
        assert_eq!(HoledClock::known(&even, 1.0 / 300.0), None);
        // Half of the rows, in whole steps: the unit of all of them.
        let half: Vec<usize> = (0..3000).filter(|k| (k * 7919) % 101 < 50).collect();
        let times: Vec<f64> = half.iter().map(|k| *k as f64 / 300.0).collect();
        assert!(HoledClock::of(&times).is_none_or(|clock| clock.tick == half));
        assert_eq!(
            HoledClock::known(&times, 1.0 / 300.0)
                .expect("a clock")
                .tick,
            half
        );
        assert_eq!(HoledClock::known(&times, 1.001 / 300.0), None);
    }

    #[test]
    fn law_a_gap_far_longer_than_the_record_is_cut() {
        let of = |k: usize| if k < 100 { k } else { k + 5000 };
        let clock = HoledClock::of(&(0..400).map(|k| 0.01 * of(k) as f64).collect::<Vec<_>>());
        assert_eq!(clock.expect("a clock").worthwhile(), 100..400);
    }

    #[test]
    fn law_empty_cells_are_holes_and_no_smear() {
        let clock: Vec<f64> = (0..1000).map(|k| 1e-3 * f64::from(k)).collect();
        let there: Vec<usize> = (0..1000)
            .filter(|k| ![0, 400, 401, 700].contains(k))
            .collect();
        let time: Vec<f64> = there.iter().map(|k| clock[*k]).collect();
        let value: Vec<f64> = there.iter().map(|k| ((k * 7919) % 101) as f64).collect();
        let step = HoledClock::of(&time).expect("a clock").step;
        let accelerations = Stamped {
            time: &time,
            value: &value,
        };
        let readings = Stamped {
            time: &clock,
            value: &clock,
        };
        let source = ReadingSource::Position;
        let record = align(source, readings, accelerations, Some(step), Timing::Sampled).unwrap();
        let holes: Vec<_> = record.holes.iter().map(|h| h.samples()).collect();
        // The grid begins with the later sensor, a sample after the clock.
        assert_eq!(holes, [399..401, 699..700]);
        for (k, v) in there.iter().zip(&value) {
            assert_eq!(record.acceleration[k - 1], *v);
        }
        let line = 0.5 * (record.acceleration[698] + record.acceleration[700]);
        assert!((record.acceleration[699] - line).abs() < 1e-9);
    }
}

//! Samples of an axis that have no acceleration: rows that were lost, cells that are empty.

use crate::MotionRecord;
use crate::ReadingSource;
use crate::episode::held;
use crate::floor::variance;
use crate::velocity::ground::longest;
use proofmass_uncertainty::findings::gaps_in_record;
use proofmass_uncertainty::{Finding, Severity};
use std::ops::Range;

/// Samples without an acceleration; the line between those beside it stands there.
///
/// Filters and smoothers take over the steps of it what the line misses of the change of velocity for a part of that change which is
/// not seen, as they do of a [`Blow`](crate::Blow).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Hole {
    /// First sample.
    pub from: usize,
    /// Sample after the last.
    pub to: usize,
    /// Standard deviation of the change of velocity that the line misses.
    pub velocity: f64,
    /// Whether the line tells little of the motion: the record is no witness of it, or it misses more than a tenth of the speed.
    pub wide: bool,
}

/// Places beside a hole, on each side, at which a line of its length is held against the samples; and how many there have to be.
const PLACES: usize = 64;
const FEWEST: usize = 16;
/// Samples of a hole that are bridged whatever the line misses: where no clock is known as many are.
const SHORT: usize = 2;
/// Share of the speed that a line may miss and still tell of the motion.
const TOLD: f64 = 0.1;

impl Hole {
    /// Its samples.
    pub fn samples(&self) -> Range<usize> {
        self.from..self.to
    }

    /// Steps on which what it misses is shared out: those that end in it, and the one that leads out.
    pub(crate) fn steps(&self) -> Range<usize> {
        self.from..self.to + 1
    }

    /// That of every n-th sample; `None` where none of them lies in it.
    pub(crate) fn decimated(&self, n: usize) -> Option<Self> {
        let (from, to) = (self.from.div_ceil(n), self.to.div_ceil(n));
        let share = (n * to.saturating_sub(from)) as f64 / (self.to - self.from) as f64;
        (from < to).then_some(Self {
            from,
            to,
            velocity: self.velocity * share.max(1.0),
            ..*self
        })
    }

    /// That of a stretch of the samples; `None` where it lies outside.
    pub fn within(&self, range: &Range<usize>) -> Option<Self> {
        let at = |k: usize| k.clamp(range.start, range.end) - range.start;
        (at(self.from) < at(self.to)).then_some(Self {
            from: at(self.from),
            to: at(self.to),
            ..*self
        })
    }

    /// Where it lies once the samples are taken so many later, with those that are lines in part.
    pub(crate) fn moved(&self, later: f64, n: usize) -> Self {
        let at = |k: f64| k.clamp(0.0, n as f64) as usize;
        Self {
            from: at(self.from as f64 - later.ceil()),
            to: at(self.to as f64 - later.floor()),
            ..*self
        }
    }
}

/// The holes of a record at the samples named, in order, whose accelerations are lines already.
///
/// What a line of this length misses of a change of velocity, T Σ (line − a), is taken at up to 64 places on either side where there are
/// accelerations. The variance is that of the whole hole, or that with which a random walk of the velocity with both ends known is nowhere
/// surer than these lines are, whichever is larger: max over j of E[(s_j − j/m s_m)²]/((j/m)(1 − j/m)). The noise of the accelerometer
/// is in it: m + m²/2 samples' variances more than the steps have without a hole. With fewer than sixteen places all that the
/// acceleration varies by is unknown over the whole hole.
pub(crate) fn holes(record: &MotionRecord, without: &[usize]) -> Vec<Hole> {
    let runs: Vec<Range<usize>> = without
        .chunk_by(|a, b| a + 1 == *b)
        .map(|run| run[0]..run[run.len() - 1] + 1)
        .collect();
    if runs.is_empty() {
        return Vec::new();
    }
    let a = &record.acceleration;
    let dt = record.sample_time;
    let mut sums = Vec::with_capacity(a.len() + 1);
    sums.push(0.0);
    for a in a {
        sums.push(sums[sums.len() - 1] + a);
    }
    // Of an encoder alone nothing.
    let spread = variance(a);
    let told = TOLD * usual_speed(record);
    let hole = |run: &Range<usize>| {
        let m = run.len();
        let places = beside(run, &runs, a.len());
        let few = places.len() < FEWEST;
        let misses = match few {
            // A line between two samples that have nothing to do with what is between them.
            true => 1.5 * (m * m) as f64 * spread,
            false => missed(a, &sums, m, &places),
        };
        let velocity = dt * misses.sqrt();
        Hole {
            from: run.start,
            to: run.end,
            velocity,
            wide: m > SHORT && (few || velocity > told || !(spread > 0.0)),
        }
    };
    runs.iter().map(hole).collect()
}

/// Mean square of what lines over m samples miss of their sum, by the samples before the lines.
fn missed(a: &[f64], sums: &[f64], m: usize, places: &[usize]) -> f64 {
    /// Parts of a line that are looked at.
    const PARTS: usize = 16;
    let parts: Vec<usize> = match m <= PARTS {
        true => (1..=m).collect(),
        false => (1..=PARTS).map(|i| i * m / PARTS).collect(),
    };
    let mut square = vec![0.0; parts.len()];
    for &p in places {
        let slope = (a[p + m + 1] - a[p]) / (m + 1) as f64;
        let off = |j: usize| {
            let line = a[p] * j as f64 + slope * 0.5 * (j * (j + 1)) as f64;
            line - (sums[p + 1 + j] - sums[p + 1])
        };
        let whole = off(m);
        for (total, &j) in square.iter_mut().zip(&parts) {
            let share = j as f64 / m as f64;
            *total += match j == m {
                true => whole * whole,
                false => (off(j) - share * whole).powi(2) / (share * (1.0 - share)),
            };
        }
    }
    square.into_iter().fold(0.0, f64::max) / places.len() as f64
}

/// Samples before lines as long as a hole, near it, where no hole of a quarter of its length is.
fn beside(hole: &Range<usize>, holes: &[Range<usize>], n: usize) -> Vec<usize> {
    let m = hole.len();
    let stride = (m / 4).max(1);
    let clear = |p: usize| {
        let first = holes.partition_point(|h| h.end <= p);
        let inside = holes[first..].iter().take_while(|h| h.start < p + m + 2);
        let mut inside =
            inside.filter(|h| 4 * h.len() > m || h.contains(&p) || h.contains(&(p + m + 1)));
        inside.next().is_none()
    };
    let before = (0..4 * PLACES).map_while(|i| hole.start.checked_sub(m + 2 + i * stride));
    let after = (0..4 * PLACES)
        .map(|i| hole.end + i * stride)
        .take_while(|p| p + m + 2 <= n);
    let mut places: Vec<usize> = before.filter(|p| clear(*p)).take(PLACES).collect();
    places.extend(after.filter(|p| clear(*p)).take(PLACES));
    places
}

/// Root of the mean square speed by the readings, over fifty samples where they are positions.
fn usual_speed(record: &MotionRecord) -> f64 {
    let x = match record.source {
        ReadingSource::Position => held(&record.reading),
        ReadingSource::Speed => {
            let squares = record.reading.iter().flatten().map(|v| v * v);
            let count = record.reading.iter().flatten().count().max(1);
            return (squares.sum::<f64>() / count as f64).sqrt();
        }
    };
    let w = 50.min(x.len() - 1);
    let count = (x.len() - w).max(1) as f64;
    let squares = x.windows(w + 1).map(|x| (x[w] - x[0]).powi(2));
    (squares.sum::<f64>() / count).sqrt() / (w as f64 * record.sample_time)
}

impl MotionRecord {
    /// Samples of which nothing is known but what lies around them: wide holes without a reading.
    pub fn blind(&self) -> Vec<Range<usize>> {
        let holes = self.holes.iter().filter(|h| h.wide);
        let unread = holes.filter(|h| self.reading[h.samples()].iter().all(Option::is_none));
        unread.map(Hole::samples).collect()
    }

    /// The longest stretch of samples without a wide hole; `None` where there is none.
    pub fn in_one_piece(&self) -> Option<Range<usize>> {
        self.holes
            .iter()
            .any(|h| h.wide)
            .then(|| longest(self.reading.len(), |k| !self.gapes(k, 0)))
    }

    /// Whether a sample lies in a hole of which the line tells little, or so many samples beside it.
    pub(crate) fn gapes(&self, k: usize, margin: usize) -> bool {
        let first = self.holes.partition_point(|h| h.to + margin <= k);
        let near = self.holes[first..].iter();
        let mut near = near.take_while(|h| h.from <= k + margin);
        near.any(|h| h.wide)
    }

    /// What is to be said of its holes; `zero` is the time of the first sample.
    pub fn hole_finding(&self, zero: f64) -> Option<Finding> {
        let longest = self.holes.iter().max_by_key(|h| h.samples().len())?;
        let gaps = |count: usize| match count {
            1 => "one gap".to_owned(),
            _ => format!("{count} gaps"),
        };
        let n = self.reading.len();
        let count =
            |holes: &mut dyn Iterator<Item = Range<usize>>| holes.map(|h| h.len()).sum::<usize>();
        let missing = count(&mut self.holes.iter().map(Hole::samples));
        let blind = self.blind();
        let left = count(&mut blind.iter().cloned());
        let share = missing as f64 / n as f64;
        let missed = self.holes.iter().filter(|h| !h.wide);
        let missed = missed.fold(0.0f64, |m, h| m.max(h.velocity));
        let missed = match missed > 0.0 {
            true => format!("; lines miss up to {missed:.2e} m/s of a change of velocity"),
            false => String::new(),
        };
        let treatment = match left {
            _ if share > MANY && blind.is_empty() => {
                ": lines bridge so much of the acceleration that the interval may be too narrow"
            }
            0 => ": lines bridge the acceleration, and the interval is wider there",
            _ => {
                ": lines bridge the acceleration where gaps are short, and long ones are left out of the velocity"
            }
        };
        let left = match left {
            0 => String::new(),
            _ => format!("; {left} in {} are left out", gaps(blind.len())),
        };
        let evidence = format!(
            "{missing} of {n} samples have no acceleration ({:.2} %), in {}, the longest of {} samples after {:.4} s{missed}{left}",
            100.0 * share,
            gaps(self.holes.len()),
            longest.samples().len(),
            zero + longest.from as f64 * self.sample_time,
        );
        let finding = gaps_in_record(
            treatment,
            &evidence,
            "what is missing is known from the samples beside it",
        );
        Some(match blind.is_empty() && share < NOTED {
            true => finding.at(Severity::Note),
            false => finding,
        })
    }
}

/// Share of the samples above which lines in place of accelerations lose of the motion and of its noise by what the noise is known.
const MANY: f64 = 0.2;
/// Share of the samples below which holes that are bridged are no more than noted.
const NOTED: f64 = 0.02;

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const DT: f64 = 1e-3;

    /// Ten seconds of an acceleration with holes of m samples every hundred, as `align` leaves them.
    fn holed(a: impl Fn(usize) -> f64, m: usize) -> MotionRecord {
        let n = 10_000;
        let mut a: Vec<f64> = (0..n).map(a).collect();
        let without: Vec<usize> = (100..n - 50).filter(|k| k % 100 < m).collect();
        for run in without.chunk_by(|a, b| a + 1 == *b) {
            let (before, after) = (run[0] - 1, run[run.len() - 1] + 1);
            for &k in run {
                let share = (k - before) as f64 / (after - before) as f64;
                a[k] = a[before] * (1.0 - share) + a[after] * share;
            }
        }
        let x = (0..n).map(|k| Some(0.5 * DT * k as f64)).collect();
        let mut record = MotionRecord::new(DT, ReadingSource::Position, x, a).unwrap();
        record.holes = holes(&record, &without);
        record
    }

    fn mean_square(record: &MotionRecord) -> f64 {
        let squares = record.holes.iter().map(|h| h.velocity * h.velocity);
        squares.sum::<f64>() / record.holes.len() as f64
    }

    /// A line between two noisy samples in the place of m others: (m + m²/2) σ² T² more than the samples had. Ninety-nine holes with places
    /// that hardly overlap: 3 · √(2/2000) = 10 % for four samples, as much again for what the largest of several parts is.
    #[test]
    fn law_a_line_through_noise_misses_its_own_and_theirs() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let noise: Vec<f64> = (0..10_000)
            .map(|_| StandardNormal.sample(&mut rng))
            .collect();
        for m in [1, 2, 4, 10] {
            let record = holed(|k| noise[k], m);
            assert_eq!(record.holes.len(), 99);
            let due = DT * DT * (m as f64 + 0.5 * (m * m) as f64);
            let ratio = mean_square(&record) / due;
            assert!((0.85..1.2).contains(&ratio), "{m}: {ratio}");
        }
    }

    /// The chord of a sine over T' = (m + 1) T: ω² T'³/12 of the amplitude at its mean square, √½.
    #[test]
    fn law_a_chord_misses_what_the_bend_is() {
        let (w, m) = (std::f64::consts::TAU * 2.0, 9);
        let record = holed(|k| 3.0 * (w * DT * k as f64).sin(), m);
        let chord = DT * (m + 1) as f64;
        let due = 3.0 * w * w * chord.powi(3) / 12.0 * 0.5f64.sqrt();
        let ratio = mean_square(&record).sqrt() / due;
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
    }

    #[test]
    fn law_what_a_record_does_not_show_is_wide() {
        let record = holed(|k| (0.3 * k as f64).sin(), 60);
        assert!(record.holes.iter().all(|h| h.wide));
        // Positions are read all the while.
        assert!(record.blind().is_empty());
        assert_eq!(record.in_one_piece(), Some(0..100));
        let part = record.within(60..9_000).unwrap();
        assert_eq!((part.holes[0].from, part.holes[0].to), (40, 100));
        // Every seventh: 105, 112, … 154.
        let slow = record.decimated(7).unwrap();
        assert_eq!((slow.holes[0].from, slow.holes[0].to), (15, 23));
    }

    #[test]
    fn law_holes_move_with_the_samples() {
        let hole = Hole {
            from: 10,
            to: 13,
            velocity: 1.0,
            wide: false,
        };
        let at = |by: f64| hole.moved(by, 20).samples();
        assert_eq!(at(0.0), 10..13);
        assert_eq!(at(2.0), 8..11);
        assert_eq!(at(0.3), 9..13);
        assert_eq!(at(-0.3), 10..14);
        assert_eq!(at(-9.0), 19..20);
    }
}

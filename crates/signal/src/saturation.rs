//! Samples at the end of the range of a converter or an amplifier.

use proofmass_uncertainty::{Figure, Finding, findings};
use std::collections::HashMap;

/// Part of the range below an extreme that is looked at.
const ZONE: f64 = 0.1;
/// How many times the samples beside it those at a rail must be: a sine has 1/(√2 − 1) = 2.4, the flattest top of a sine with its
/// third harmonic 5.3 where it is a quarter of the zone wide, and less where it is wider or narrower.
const RATIO: f64 = 5.0;
/// Share of a sine's samples in a strip at its extreme over those in the next one.
const SINE: f64 = 2.414_213_562_373_095;
/// Standard deviations by which the ratio must exceed that of a sine.
const SURE: f64 = 5.0;
/// Times that the record must come to the rail, where it is told by how often samples stand there.
const VISITS: usize = 5;
/// Equal samples at a rail, where they are told by their value alone.
const EQUAL: usize = 5;
/// Share of samples at one value from which it is where the record rests.
const REST: f64 = 0.35;
/// Equal samples in a row, where one stretch tells.
const ROW: usize = 4;
/// Visits from which they are not those of a record that rests.
const MANY: usize = 50;
/// Times as long as it takes to come and go that a record stays where it rests: a sine that is cut off at half its height stays 2.2 times
/// as long.
const STAY: usize = 4;
/// Steps of the converter by which the record must have left the rail, half as long after a stretch as this is: a parabola has left it
/// by 5.4 after four samples, and by less after more.
const LEFT: f64 = 8.0;
/// Widths of the stretch by which it must have left, where noise lies behind the limit: a parabola has left by four, a top without any
/// curvature by sixteen.
const LEFT_NOISE: f64 = 20.0;
/// Most noise behind a limit, of the range, that is looked through.
const NOISE: f64 = 0.02;
/// Most samples of a sine whose phases repeat that lie so near its top that none lies beside them, and periods by which it is known.
const PHASES: usize = 5;
const PERIODS: usize = 25;
/// Values that differ by less than this part of the range are equal: the rounding of a sine's argument.
const ROUNDING: f64 = 1e-9;

/// An end of the range at which a record was cut off.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rail {
    /// Whether it is the upper end.
    pub upper: bool,
    /// The extreme value.
    pub level: f64,
    /// Samples there.
    pub samples: usize,
    /// Part of all samples.
    pub share: f64,
    /// Most of them in a row.
    pub longest: usize,
    /// How far from the extreme they lie: zero where they equal it, otherwise what noise behind the limit does.
    pub width: f64,
}

/// The ends of the range at which a record seems to be cut off, whatever its waveform; values that are not finite are passed over.
///
/// A record is cut off where far more samples stand at its extreme than a smooth density has beside it (in strips from one step
/// of the converter to a twentieth of the range, so that noise behind the limit does not hide it), where the very same value comes
/// again and again among values that do not, or where it stays at the extreme for a stretch that no smooth top explains. A level at
/// which a record rests is not taken for it: its commonest one, one of many, or one where it stays far longer than it takes to come and
/// go, and is no stiller than elsewhere. What is cut off within a rest is sought in the rest alone.
///
/// ```
/// use proofmass_signal::saturation::rails;
/// let swing = |i: i32| 1.3 * (0.071 * f64::from(i)).sin();
/// let whole: Vec<f64> = (0..4000).map(swing).collect();
/// assert!(rails(&whole).is_empty());
/// let cut: Vec<f64> = whole.iter().map(|v| v.min(1.0)).collect();
/// let found = rails(&cut);
/// assert!(found.len() == 1 && found[0].upper && found[0].level == 1.0);
/// ```
pub fn rails(values: &[f64]) -> Vec<Rail> {
    let finite = |v: &&f64| v.is_finite();
    let mut middle: Vec<f64> = values.iter().filter(finite).copied().collect();
    let Some(median) = proofmass_core::numeric::upper_median(&mut middle) else {
        return Vec::new();
    };
    let side = |upper: bool| {
        let side = Side {
            sign: if upper { 1.0 } else { -1.0 },
            values,
            median,
        };
        side.rail().map(|rail| Rail { upper, ..rail })
    };
    [true, false].into_iter().filter_map(side).collect()
}

/// A finding for each end at which a record is cut off; `name` is that of the record, `consequence` what becomes of the result.
pub fn clipped(name: &str, values: &[f64], consequence: &str) -> Vec<Finding> {
    let say = |rail: Rail| {
        let side = if rail.upper { "upper" } else { "lower" };
        findings::clipped(
            &format!("{name} is cut off at the {side} end of its range"),
            &rail.evidence(),
            consequence,
        )
    };
    rails(values).into_iter().map(say).collect()
}

impl Rail {
    /// What was seen, in words.
    pub fn evidence(&self) -> String {
        let within = match self.width > 0.0 {
            true => format!("within {} of ", Figure(self.width)),
            false => "at ".to_owned(),
        };
        format!(
            "{} samples ({} %) {within}{}, up to {} in a row",
            self.samples,
            Figure(100.0 * self.share),
            Figure(self.level),
            self.longest
        )
    }
}

/// One side of a record, turned so that its extreme is the largest value.
struct Side<'a> {
    sign: f64,
    values: &'a [f64],
    median: f64,
}

/// The samples near the extreme.
struct Zone {
    extreme: f64,
    range: f64,
    /// In rising order.
    values: Vec<f64>,
    /// The smallest distance of two that differ.
    step: f64,
}

/// How a record comes to its extreme.
#[derive(Default)]
struct Visits {
    number: usize,
    /// Samples of all visits, and the most of one.
    samples: usize,
    longest: usize,
    /// Samples between where the record rests and its extreme.
    way: usize,
}

impl Visits {
    /// Counts a visit; what came after it was last at the extreme was on the way back.
    fn end(&mut self, visit: Option<(usize, usize)>) {
        if let Some((samples, since)) = visit {
            self.samples += samples;
            self.longest = self.longest.max(samples);
            self.way += since;
        }
    }
}

impl Zone {
    /// Samples in a strip at the extreme, and in one that begins with the next sample below it.
    fn strips(&self, width: f64) -> Option<[usize; 2]> {
        let up_to = |limit: f64| {
            self.values
                .partition_point(|v| *v <= limit + 0.5 * self.step)
        };
        let first = up_to(self.extreme - width);
        let next = *self.values.get(first.checked_sub(1)?)?;
        Some([self.values.len() - first, first - up_to(next - width)])
    }
}

impl Side<'_> {
    fn all(&self) -> impl Iterator<Item = f64> {
        let sign = self.sign;
        let finite = |v: &f64| v.is_finite();
        self.values
            .iter()
            .copied()
            .filter(finite)
            .map(move |v| sign * v)
    }

    fn zone(&self) -> Option<Zone> {
        let (low, extreme) = self
            .all()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
        let range = extreme - low;
        if !(range > 0.0 && range.is_finite()) {
            return None;
        }
        let mut values: Vec<f64> = self.all().filter(|v| *v > extreme - ZONE * range).collect();
        values.sort_unstable_by(f64::total_cmp);
        let gaps = values.windows(2).map(|w| w[1] - w[0]);
        let step = gaps
            .filter(|g| *g > ROUNDING * range)
            .fold(f64::INFINITY, f64::min);
        let step = if step.is_finite() { step } else { 0.0 };
        Some(Zone {
            extreme,
            range,
            values,
            step,
        })
    }

    fn rail(&self) -> Option<Rail> {
        let zone = self.zone()?;
        let rest = self.sign * self.median;
        if zone.extreme - rest <= (3.0 * zone.step).max(0.02 * zone.range) {
            return None;
        }
        let width = self.often(&zone).or_else(|| self.in_a_row(&zone))?;
        if self.rests_there(&zone, width) {
            return None;
        }
        let there = |v: f64| v >= zone.extreme - width;
        let (samples, longest) = self.stretches(there);
        Some(Rail {
            upper: true,
            level: self.sign * zone.extreme,
            samples,
            share: samples as f64 / self.all().count() as f64,
            longest,
            width,
        })
    }

    /// How often the record comes within a distance of the extreme, after having left it by the whole zone; the samples from the first to
    /// the last of each such visit, the most of one, and those on the way there from where the record rests.
    fn visits(&self, zone: &Zone, width: f64) -> Visits {
        let rest = self.sign * self.median;
        let on_the_way = rest + ZONE * (zone.extreme - rest);
        let mut visits = Visits::default();
        // Samples of a visit so far, and since it was last at the extreme.
        let mut visit: Option<(usize, usize)> = None;
        for v in self.all() {
            if v >= zone.extreme - width {
                let (so_far, since) = visit.unwrap_or((0, 0));
                visits.number += usize::from(visit.is_none());
                visit = Some((so_far + since + 1, 0));
                continue;
            }
            if v < zone.extreme - ZONE * zone.range {
                visits.end(visit.take());
            }
            match &mut visit {
                Some((_, since)) => *since += 1,
                None => visits.way += usize::from(v > on_the_way),
            }
        }
        visits.end(visit);
        visits
    }

    /// Whether the extreme is a level at which the record rests now and then, and not one at which it is cut off: it stays far longer
    /// than it takes to come and go, and is no stiller there than elsewhere.
    fn rests_there(&self, zone: &Zone, width: f64) -> bool {
        let visits = self.visits(zone, width);
        if visits.number >= MANY || visits.samples <= STAY * visits.way {
            return false;
        }
        if width > 0.0 {
            return true;
        }
        // Equal values at the extreme alone are no rest.
        let all: Vec<f64> = self.all().collect();
        let elsewhere = all.chunk_by(|a, b| a == b);
        let elsewhere = elsewhere
            .filter(|run| run[0] < zone.extreme)
            .map(<[f64]>::len);
        2 * elsewhere.max().unwrap_or(0) >= visits.longest
    }

    /// Samples for which something holds, and most of them in a row.
    fn stretches(&self, holds: impl Fn(f64) -> bool) -> (usize, usize) {
        let (mut samples, mut longest, mut run) = (0, 0, 0);
        for v in self.all() {
            if holds(v) {
                samples += 1;
                run += 1;
                longest = longest.max(run);
            } else {
                run = 0;
            }
        }
        (samples, longest)
    }

    /// How far from the extreme the samples lie that are too many there; `None` where there are none.
    fn often(&self, zone: &Zone) -> Option<f64> {
        let n = self.all().count() as f64;
        let counts = zone.values.chunk_by(|a, b| a == b).map(<[f64]>::len);
        let mut counts: Vec<usize> = counts.collect();
        let equal = counts.pop()?;
        let beside = counts.iter().copied().max().unwrap_or(0).max(1);
        // A record of few values comes back to each of them.
        let varied = counts.len() >= EQUAL;
        let again = varied && equal >= EQUAL && equal as f64 > 4.0 * beside as f64;
        let places = || -> Vec<usize> {
            let all = self.all().enumerate();
            all.filter(|(_, v)| *v == zone.extreme)
                .map(|(i, _)| i)
                .collect()
        };
        if again
            && equal as f64 <= REST * n
            && !self.rests_elsewhere(zone, zone.step, equal)
            && !self.repeats(&places())
        {
            return Some(0.0);
        }
        let mut width = zone.step.max(ROUNDING * zone.range);
        while width <= 0.5 * ZONE * zone.range {
            let Some([at, next]) = zone.strips(width) else {
                break;
            };
            let root = |x: f64| (x + 0.375).sqrt();
            let sure =
                2.0 * (root(at as f64 / SINE) - root(next as f64)) / (1.0 + 1.0 / SINE).sqrt();
            if at as f64 > RATIO * next as f64
                && sure > SURE
                && at as f64 <= REST * n
                && self.visits(zone, width).number >= VISITS
                && self.comes_back(zone.extreme - width)
                && !self.rests_elsewhere(zone, width, at)
            {
                // The values themselves, not the strip that was laid over them.
                let first = zone.values[zone.values.len() - at];
                return Some(zone.extreme - first);
            }
            width *= 2.0;
        }
        None
    }

    /// Whether the record comes above a level time and again, and not as a sine does whose phases come again and again: one sample at a
    /// time, and after at most three different times (the three-gap theorem), or at the same samples of every period.
    fn comes_back(&self, level: f64) -> bool {
        let (mut last, mut visits, mut above) = (None, 0, false);
        let mut gaps: HashMap<usize, usize> = HashMap::new();
        let mut single = true;
        let mut places = Vec::new();
        for (i, v) in self.all().enumerate() {
            if v > level {
                places.push(i);
            }
            single &= !(above && v > level);
            if v > level && !above {
                visits += 1;
                if let Some(last) = last.replace(i) {
                    *gaps.entry(i - last).or_default() += 1;
                }
            }
            above = v > level;
        }
        let mut common: Vec<usize> = gaps.into_values().collect();
        common.sort_unstable_by(|a, b| b.cmp(a));
        let three: usize = common.iter().take(3).sum();
        visits >= VISITS && !(single && 10 * three >= 9 * (visits - 1)) && !self.repeats(&places)
    }

    /// Whether places lie at the same few samples of every period, and those are not at one level: so do the tops of a sine whose
    /// phases repeat, noise hiding some of them. Of three samples at the top of a sine one is lower.
    fn repeats(&self, places: &[usize]) -> bool {
        let mut lags: HashMap<usize, usize> = HashMap::new();
        for (i, last) in places.iter().enumerate() {
            for first in &places[i.saturating_sub(PHASES)..i] {
                *lags.entry(last - first).or_default() += 1;
            }
        }
        let most = lags.values().copied().max().unwrap_or(0);
        let common = lags.into_iter().filter(|&(_, n)| 10 * n >= 9 * most);
        let Some(period) = common.map(|(lag, _)| lag).min() else {
            return false;
        };
        if period < 3 || 2 * most < places.len() || PERIODS * period > self.values.len() {
            return false;
        }
        let mut at: HashMap<usize, usize> = HashMap::new();
        for place in places {
            *at.entry(place % period).or_default() += 1;
        }
        let mut phases: Vec<(usize, usize)> = at.into_iter().map(|(phase, n)| (n, phase)).collect();
        phases.sort_unstable_by(|a, b| b.cmp(a));
        phases.truncate(PHASES);
        let there: usize = phases.iter().map(|p| p.0).sum();
        if 20 * there < 19 * places.len() {
            return false;
        }
        let all: Vec<f64> = self.all().collect();
        let mut levels: Vec<[f64; 2]> = phases
            .iter()
            .map(|&(_, phase)| {
                let same = all.iter().skip(phase).step_by(period);
                let n = same.clone().count() as f64;
                let mean = same.clone().sum::<f64>() / n;
                let scatter = same.map(|v| (v - mean).powi(2)).sum::<f64>();
                [mean, (scatter / (n * (n - 1.0))).sqrt()]
            })
            .collect();
        levels.sort_unstable_by(|a, b| b[0].total_cmp(&a[0]));
        match levels[..] {
            [first, _, third, ..] => {
                first[0] - third[0]
                    > (SURE * first[1].hypot(third[1])).max(ROUNDING * first[0].abs())
            }
            // One or two samples at the top are not flat.
            _ => true,
        }
    }

    /// Whether the record rests at other levels too, as one of a sensor in several attitudes: its commonest level apart, and the other
    /// extreme.
    fn rests_elsewhere(&self, zone: &Zone, width: f64, at: usize) -> bool {
        let width = width.max(ROUNDING * zone.range);
        let mut cells: HashMap<i64, usize> = HashMap::new();
        for v in self.all() {
            let cell = (zone.extreme + 0.5 * zone.step - v) / width;
            *cells.entry(cell as i64).or_default() += 1;
        }
        let count = |k: i64| cells.get(&k).copied().unwrap_or(0);
        // A level may lie across the border of two cells, and stands out of those around.
        let ring = (ZONE * zone.range / width).clamp(1.0, 10.0) as i64;
        let mut levels: Vec<(usize, i64)> = cells
            .keys()
            .map(|&k| (count(k) + count(k + 1), k))
            .filter(|&(both, k)| {
                let around = (k - ring..k)
                    .chain(k + 2..k + 2 + ring)
                    .map(count)
                    .sum::<usize>();
                k > 2 && 2 * both >= at && both as f64 * ring as f64 > RATIO * around as f64
            })
            .collect();
        let last = ((zone.range + 0.5 * zone.step) / width) as i64;
        levels.retain(|&(_, k)| k < last - 2);
        let commonest = levels.iter().max().map_or(0, |&(_, k)| k);
        levels.iter().any(|&(_, k)| (k - commonest).abs() > 2)
    }

    /// How far from the extreme the samples lie of a stretch that neither a smooth top nor the steps of the converter explain, nor
    /// that the record makes elsewhere too.
    fn in_a_row(&self, zone: &Zone) -> Option<f64> {
        let values: Vec<f64> = self.all().collect();
        let mut width = 0.0;
        while width <= NOISE * zone.range {
            let least = if width > 0.0 { 2 * ROW } else { ROW };
            let far = if width > 0.0 {
                LEFT_NOISE * width
            } else {
                LEFT * zone.step
            };
            if self.stays(zone, &values, width, least, far) {
                return Some(width);
            }
            width = (2.0 * width).max(zone.step).max(1e-5 * zone.range);
        }
        None
    }

    /// Whether so many samples in a row and more are within a distance of the extreme, which the record then leaves by more than
    /// `far` on both sides.
    fn stays(&self, zone: &Zone, values: &[f64], width: f64, least: usize, far: f64) -> bool {
        let there = |v: f64| v >= zone.extreme - width;
        let (mut at, mut longest, mut samples) = (0, (0, 0), 0);
        for run in values.chunk_by(|a, b| there(*a) == there(*b)) {
            if there(run[0]) {
                samples += run.len();
                if run.len() > longest.1 {
                    longest = (at, run.len());
                }
            }
            at += run.len();
        }
        let (start, length) = longest;
        let often = self.visits(zone, width).number >= VISITS;
        let away = length.div_ceil(2);
        let left = |i: Option<usize>| {
            let value = i.and_then(|i| values.get(i));
            value.is_some_and(|v| zone.extreme - v > far)
        };
        length >= least
            && (often || samples as f64 <= REST * values.len() as f64)
            && left(start.checked_sub(away))
            && left(Some(start + length - 1 + away))
            && 2 * self.still_elsewhere(zone, values, width, often) < length
    }

    /// Most samples in a row, at least half of them, that stay within a width elsewhere: neither at the extreme nor where the record
    /// rests, and not at the other extreme either where it comes there often.
    fn still_elsewhere(&self, zone: &Zone, values: &[f64], width: f64, often: bool) -> usize {
        let rest = self.sign * self.median;
        let low = zone.extreme - zone.range;
        let left_out = |v: f64| {
            v >= zone.extreme - width
                || (v - rest).abs() <= ZONE * zone.range
                || (often && v <= low + width)
        };
        let (mut longest, mut length) = (0, 0);
        let (mut least, mut most) = (0.0f64, 0.0f64);
        for &v in values {
            if left_out(v) {
                length = 0;
                continue;
            }
            let (low, high) = (least.min(v), most.max(v));
            if length > 0 && high - low <= width {
                (least, most) = (low, high);
                length += 1;
            } else {
                (least, most, length) = (v, v, 1);
            }
            longest = longest.max(length);
        }
        longest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_stretch_at_the_top_of_a_pulse() {
        let pulse = |cut: f64| -> Vec<f64> {
            let at = |i: i32| (f64::from(i - 50) / 80.0 * std::f64::consts::PI).sin();
            let within = |i: i32| (50..130).contains(&i);
            (0..300)
                .map(|i| if within(i) { at(i).min(cut) } else { 0.0 })
                .collect()
        };
        assert!(rails(&pulse(2.0)).is_empty());
        let found = rails(&pulse(0.95));
        assert_eq!(found.len(), 1);
        // 2 acos(0.95)/π of 80 samples.
        assert!(found[0].upper && found[0].longest == 17, "{found:?}");
        let turned: Vec<f64> = pulse(0.95).iter().map(|v| -v).collect();
        assert!(rails(&turned).len() == 1 && !rails(&turned)[0].upper);
    }

    #[test]
    fn known_sines_whose_phases_repeat_are_whole() {
        // From three to two hundred samples a period, the first anywhere in it; with the rounding of the argument, with accumulated
        // phases, and with a little of other things that repeat at no whole sample.
        for (period, phase) in [
            (3, 0.1),
            (8, 0.3),
            (16, 0.3),
            (16, 1.374),
            (20, 0.0),
            (25, 0.1),
            (40, 0.0),
            (200, 0.0),
        ] {
            for noise in [0.0, 1e-6, 1e-3, 5e-3] {
                let w = std::f64::consts::TAU / f64::from(period);
                let at = |i: i32| {
                    (w * f64::from(i) + phase).cos() + noise * (1.7 * f64::from(i * i % 1009)).sin()
                };
                let whole: Vec<f64> = (0..4000).map(at).collect();
                assert!(
                    rails(&whole).is_empty(),
                    "{period} {noise} {:?}",
                    rails(&whole)
                );
                let cut: Vec<f64> = whole.iter().map(|v| v.clamp(-0.8, 0.8)).collect();
                if period >= 25 && noise > 0.0 {
                    assert_eq!(rails(&cut).len(), 2, "{period} {phase} {noise}");
                }
            }
        }
    }

    #[test]
    fn refuses_nothing_and_finds_nothing_where_nothing_is() {
        assert!(rails(&[]).is_empty());
        assert!(rails(&[1.0]).is_empty());
        assert!(rails(&[f64::NAN, f64::INFINITY]).is_empty());
        assert!(rails(&[3.0; 1000]).is_empty());
        let square: Vec<f64> = (0..1000).map(|i| f64::from(i % 2)).collect();
        assert!(rails(&square).is_empty());
        assert!(rails(&[-f64::MAX, f64::MAX, 0.0]).is_empty());
    }
}

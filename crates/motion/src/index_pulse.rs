//! The index pulse of an encoder: absolute zero, and counts that were lost or added, put back at each turn.

use crate::findings;
use proofmass_core::Error;
use proofmass_uncertainty::Finding;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// Counts with their zero at the index.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Indexed {
    /// Count at every sample; zero is where the pulse begins in the positive sense.
    pub count: Vec<i64>,
    /// Every pulse.
    pub passages: Vec<IndexPassage>,
    /// What was found.
    pub findings: Vec<Finding>,
}

/// A pulse, and what it told of the counts since the one before.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct IndexPassage {
    /// First sample at which the pulse was high.
    pub sample: usize,
    /// Turn, by the corrected count.
    pub turn: i64,
    /// Counts that are added from here on: zero where none was lost.
    pub put_back: i64,
    /// What the pulse admits of them, where it is met between counts that are several samples apart.
    pub admitted: RangeInclusive<i64>,
}

/// First and last count at which the pulse is high, each as far as it is known.
#[derive(Clone, Copy, Debug)]
struct Window {
    begin: [i64; 2],
    end: [i64; 2],
}

/// Most samples by which an index may come late.
const LATEST: usize = 16;

/// Beyond every count.
const FAR: i64 = i64::MAX / 8;

impl Window {
    /// From counts during a pulse and those before and after it, where there are any; `within` is one where an edge may lie within a
    /// count, at which the pulse is then both low and high.
    fn of(high: &[i64], before: Option<i64>, after: Option<i64>, within: i64) -> Option<Self> {
        let (least, most) = (*high.iter().min()?, *high.iter().max()?);
        let mut window = Self {
            begin: [-FAR, least],
            end: [most, FAR],
        };
        for low in [before, after].into_iter().flatten() {
            if low < least {
                window.begin[0] = window.begin[0].max(low + 1 - within);
            } else if low > most {
                window.end[1] = window.end[1].min(low - 1 + within);
            }
        }
        Some(window)
    }

    fn moved(self, by: i64) -> Self {
        Self {
            begin: self.begin.map(|v| v + by),
            end: self.end.map(|v| v + by),
        }
    }

    /// Shifts of another that make it agree.
    fn admits(&self, other: &Self) -> [i64; 2] {
        let low = (self.begin[0] - other.begin[1]).max(self.end[0] - other.end[1]);
        let high = (self.begin[1] - other.begin[0]).min(self.end[1] - other.end[0]);
        [low, high]
    }

    fn narrowed(self, by: &Self) -> Self {
        Self {
            begin: [
                self.begin[0].max(by.begin[0]),
                self.begin[1].min(by.begin[1]),
            ],
            end: [self.end[0].max(by.end[0]), self.end[1].min(by.end[1])],
        }
    }

    /// Twice its middle, as far as it was met.
    fn middle(&self) -> i64 {
        self.begin[1] + self.end[0]
    }
}

/// Pulses as they are read when the index is thought to behave in one way.
struct Scan {
    known: Option<Window>,
    passages: Vec<IndexPassage>,
    /// Samples by which the index comes after the counts.
    late: usize,
    /// Passages whose two edges contradict each other.
    contradictions: usize,
}

impl Scan {
    /// Edges at counts and an index in time, unless three times fewer pulses disagree where an edge may lie within a count, or where the
    /// index comes late by up to sixteen samples: on an axis that goes and comes each of these looks like counts lost at one turn and added at
    /// the next.
    fn likeliest(count: &[i64], pulse: &[bool], turn: i64) -> Self {
        let plain = Self::of(count, pulse, turn, 0, 0);
        let doubts = plain.doubts();
        if doubts < 3 && plain.contradictions == 0 {
            return plain;
        }
        let others = (0..=LATEST).flat_map(|late| [(0, late), (1, late)]).skip(1);
        let others = others.map(|(within, late)| Self::of(count, pulse, turn, within, late));
        let fewest = others.min_by_key(Self::doubts);
        match fewest.filter(|other| 3 * other.doubts() <= doubts) {
            Some(other) => other,
            None => plain,
        }
    }

    fn doubts(&self) -> usize {
        let moved = self.passages.iter().filter(|p| p.put_back != 0);
        self.contradictions + moved.count()
    }

    fn of(count: &[i64], pulse: &[bool], turn: i64, within: i64, late: usize) -> Self {
        let pulse = &pulse[late.min(pulse.len())..];
        let mut contradictions = 0;
        let mut passages: Vec<IndexPassage> = Vec::new();
        let mut known: Option<Window> = None;
        let mut shift = 0;
        let mut at = 0;
        while let Some(first) = (at..pulse.len()).find(|k| pulse[*k]) {
            let past = (first..pulse.len()).find(|k| !pulse[*k]);
            let past = past.unwrap_or(pulse.len());
            at = past;
            let after = count[..pulse.len()].get(past).copied();
            let before = first.checked_sub(1).map(|k| count[k]);
            let Some(met) = Window::of(&count[first..past], before, after, within) else {
                break;
            };
            let Some(window) = known else {
                known = Some(met);
                passages.push(IndexPassage {
                    sample: first,
                    turn: 0,
                    put_back: 0,
                    admitted: 0..=0,
                });
                continue;
            };
            let met = met.moved(shift);
            let turns = (met.middle() - window.middle() + turn).div_euclid(2 * turn);
            let met = met.moved(-turns * turn);
            let [low, high] = window.admits(&met);
            contradictions += usize::from(low > high);
            let put_back = match (low <= 0 && high >= 0, low <= high) {
                (true, _) => 0,
                // The middle of what is admitted, toward zero.
                (false, true) => (low.clamp(-turn, turn) + high.clamp(-turn, turn)) / 2,
                (false, false) => (window.middle() - met.middle()) / 2,
            };
            let admitted = match (put_back == 0, low <= high) {
                (true, _) => 0..=0,
                (false, true) => low.max(-turn)..=high.min(turn),
                (false, false) => put_back..=put_back,
            };
            shift += put_back;
            let narrowed = window.narrowed(&met.moved(put_back));
            let sound =
                narrowed.begin[0] <= narrowed.begin[1] && narrowed.end[0] <= narrowed.end[1];
            known = Some(if sound { narrowed } else { window });
            passages.push(IndexPassage {
                sample: first,
                turn: turns,
                put_back,
                admitted,
            });
        }
        Self {
            known,
            passages,
            late,
            contradictions,
        }
    }
}

/// Counts with their zero at the index, and what was lost or added between two pulses put back.
///
/// A pulse is high over a few counts, always the same ones of a turn. What the counts during it, before and after it admit of where it
/// begins and ends is narrowed pulse by pulse; a pulse that no such place agrees with tells how many counts are missing, modulo
/// a turn. An axis that turns back within the pulse tells one side of it. What was lost is put back where both channels changed at
/// once (`illegal`), else where the count jumps by it between two samples, else evenly over the way from the pulse before.
///
/// Where most turns differ by the same number, it is the counts of a turn that are stated wrongly: nothing is put back, and this is
/// reported.
///
/// An index that is not gated with the channels may begin and end within a count, and one that is filtered comes late: both are seen by what
/// an axis that goes and comes makes of them.
///
/// **Assumes** less than half a turn is lost between two pulses.
/// **Accuracy** `coverage_lost_counts`: none is reported in healthy records, whatever their speed; resolved at every count the number is exact.
///
/// ```
/// use proofmass_motion::indexed;
/// // Fifty counts to a turn, three of which are lost at sample 130.
/// let count: Vec<i64> = (0..400).map(|k| if k < 130 { k } else { k - 3 }).collect();
/// let pulse: Vec<bool> = (0..400).map(|k| k % 50 == 20).collect();
/// let found = indexed(&count, &pulse, 50, &[], &|k| k as f64)?;
/// assert_eq!(found.count[20], 0);
/// assert_eq!(found.passages[3].put_back, 3);
/// assert!((0..400).all(|k| found.count[k] == k as i64 - 20));
/// # Ok::<(), proofmass_core::Error>(())
/// ```
///
/// # Errors
/// [`Error::Length`]; [`Error::OutOfRange`] for a turn of fewer than eight counts.
pub fn indexed(
    count: &[i64],
    pulse: &[bool],
    turn: i64,
    illegal: &[usize],
    time: &dyn Fn(usize) -> f64,
) -> Result<Indexed, Error> {
    if pulse.len() != count.len() {
        return Err(Error::Length {
            name: "index",
            expected: count.len(),
            got: pulse.len(),
        });
    }
    if turn < 8 {
        return Err(Error::OutOfRange {
            name: "counts of a turn",
            value: turn as f64,
            min: 8.0,
            max: f64::MAX,
        });
    }
    if is_inverted(count, pulse, turn) {
        let pulse: Vec<bool> = pulse.iter().map(|p| !p).collect();
        let mut found = indexed(count, &pulse, turn, illegal, time)?;
        found.findings.insert(0, findings::index_inverted());
        return Ok(found);
    }
    let changes = pulse.windows(2).any(|p| p[0] != p[1]);
    let scan = changes.then(|| Scan::likeliest(count, pulse, turn));
    let Some(Scan {
        known: Some(window),
        mut passages,
        late,
        ..
    }) = scan
    else {
        let state = match pulse.first() {
            Some(true) => "always",
            _ => "never",
        };
        return Ok(Indexed {
            count: count.to_vec(),
            passages: Vec::new(),
            findings: vec![findings::no_index(state)],
        });
    };
    let zero = match window.begin[0] > -FAR {
        true => (window.begin[0] + window.begin[1]).div_euclid(2),
        false => window.begin[1],
    };
    if let Some(finding) = wrong_turn(count, &passages, turn) {
        return Ok(Indexed {
            count: count.iter().map(|c| c - zero).collect(),
            passages,
            findings: vec![finding],
        });
    }
    dismiss_false(&mut passages, turn);
    let corrected = put_back(count, &passages, illegal);
    let mut findings = vec![findings::zero_at_index(
        passages.len(),
        time(passages[0].sample),
    )];
    findings.extend(lost(count, &passages, time));
    findings.extend((late > 0).then(|| findings::index_late(late)));
    Ok(Indexed {
        count: corrected.iter().map(|c| c - zero).collect(),
        passages,
        findings,
    })
}

/// All pulses are the same number of turns apart, or more than half of the turns that were gone through whole differ by the same number
/// in the sense of motion.
fn wrong_turn(count: &[i64], passages: &[IndexPassage], turn: i64) -> Option<Finding> {
    let whole = passages.windows(2).filter_map(|w| {
        let way = count[w[1].sample] - count[w[0].sample];
        let turns = (way as f64 / turn as f64).round() as i64;
        (turns != 0).then(|| (way.abs(), turns.abs(), w[1].put_back))
    });
    let whole: Vec<(i64, i64, i64)> = whole.collect();
    // A pulse comes once in a turn: where all are the same number of turns apart, that is the turn.
    if let Some((way, several, _)) = whole.iter().min_by_key(|w| w.0)
        && *several > 1
        && whole.len() >= 4
        && whole.iter().all(|w| w.1 == *several)
    {
        return Some(findings::index_turn_mismatch(*way, turn));
    }
    // Counts are lost now and then: where they would be between most pulses, the pulses are no index of this turn.
    let between = passages.windows(2);
    let mut ways: Vec<i64> = between
        .map(|w| (count[w[1].sample] - count[w[0].sample]).abs())
        .collect();
    let doubted = passages.iter().filter(|p| p.put_back != 0).count();
    if ways.len() >= 4 && 2 * doubted > ways.len() {
        ways.sort_unstable();
        return Some(findings::index_turn_mismatch(ways[ways.len() / 2], turn));
    }
    let wrong = whole.iter().filter(|(.., put_back)| *put_back != 0);
    let mut per_turn: Vec<i64> = wrong
        .map(|(way, turns, _)| (*way as f64 / *turns as f64).round() as i64)
        .collect();
    per_turn.sort_unstable();
    let middle = *per_turn.get(per_turn.len() / 2)?;
    let alike = per_turn
        .iter()
        .filter(|n| (**n - middle).abs() <= 1)
        .count();
    (whole.len() >= 3 && 2 * alike > whole.len())
        .then(|| findings::index_turn_mismatch(middle, turn))
}

/// A pulse in the middle of a turn, as noise on its line makes it, takes away what the next one gives back: it is no index.
fn dismiss_false(passages: &mut [IndexPassage], turn: i64) {
    for k in 1..passages.len().saturating_sub(1) {
        let (here, next) = (passages[k].put_back, passages[k + 1].put_back);
        if 20 * here.abs() > turn && 20 * (here + next).abs() <= turn {
            passages[k].put_back = 0;
            passages[k].admitted = 0..=0;
            passages[k + 1].put_back = here + next;
            passages[k + 1].admitted = (here + next)..=(here + next);
        }
    }
}

/// Counts with what was lost put back.
fn put_back(count: &[i64], passages: &[IndexPassage], illegal: &[usize]) -> Vec<i64> {
    let mut shift: Vec<i64> = vec![0; count.len()];
    for pair in passages.windows(2) {
        let (from, to, missing) = (pair[0].sample, pair[1].sample, pair[1].put_back);
        if missing == 0 {
            continue;
        }
        let between = illegal.iter().filter(|k| (from + 1..=to).contains(*k));
        let places: Vec<usize> = between.copied().collect();
        let n = places.len() as i64;
        if n > 0 {
            for (i, k) in places.iter().enumerate() {
                let i = i as i64;
                shift[*k] += missing * (i + 1) / n - missing * i / n;
            }
        } else if let Some(k) = jump(&count[..=to], from + 1, missing) {
            shift[k] += missing;
        } else {
            // Evenly over the way.
            let way = |k: usize| (count[k] - count[k - 1]).abs();
            let all: i64 = (from + 1..=to).map(way).sum();
            let (mut gone, mut given) = (0, 0);
            for k in from + 1..=to {
                gone += way(k);
                let due = match all {
                    0 => missing,
                    _ => (missing as f64 * gone as f64 / all as f64).round() as i64,
                };
                shift[k] += due - given;
                given = due;
            }
        }
    }
    let mut sum = 0;
    count
        .iter()
        .zip(&shift)
        .map(|(c, s)| {
            sum += s;
            c + sum
        })
        .collect()
}

/// The one step from `from` on that is off from the median of its neighbours by what is missing.
fn jump(count: &[i64], from: usize, missing: i64) -> Option<usize> {
    const NEIGHBOURS: usize = 4;
    if missing.abs() < 3 {
        return None;
    }
    let step = |k: usize| count[k] - count[k - 1];
    let mut found: Option<(i64, usize)> = None;
    let mut second = 0;
    for k in from.max(1)..count.len() {
        let near = k.saturating_sub(NEIGHBOURS).max(1)..(k + NEIGHBOURS + 1).min(count.len());
        let mut near: Vec<i64> = near.filter(|j| *j != k).map(step).collect();
        near.sort_unstable();
        let usual = *near.get(near.len() / 2)?;
        let gain = (step(k) - usual).abs() - (step(k) + missing - usual).abs();
        match found {
            Some((best, _)) if gain <= best => second = second.max(gain),
            best => {
                second = second.max(best.map_or(0, |b| b.0));
                found = Some((gain, k));
            }
        }
    }
    let (gain, k) = found?;
    (10 * gain >= 6 * missing.abs() && 2 * second < gain).then_some(k)
}

/// What was lost or added, turn by turn.
fn lost(count: &[i64], passages: &[IndexPassage], time: &dyn Fn(usize) -> f64) -> Option<Finding> {
    const TOLD: usize = 6;
    let (mut all, mut turns, mut told) = (0, 0, Vec::new());
    for pair in passages.windows(2) {
        let missing = pair[1].put_back;
        if missing == 0 {
            continue;
        }
        turns += 1;
        all += missing.abs();
        let way = count[pair[1].sample] - count[pair[0].sample];
        let what = match (way != 0 && (way > 0) == (missing > 0), way == 0) {
            (true, _) => "lost",
            (false, true) => "off",
            (false, false) => "added",
        };
        let number = match pair[1].admitted.start() == pair[1].admitted.end() {
            true => missing.abs().to_string(),
            false => {
                let [a, b] = [pair[1].admitted.start(), pair[1].admitted.end()].map(|v| v.abs());
                format!("{} to {}", a.min(b), a.max(b))
            }
        };
        if told.len() < TOLD {
            told.push(format!(
                "{number} {what} before {:.3} s",
                time(pair[1].sample)
            ));
        }
    }
    if turns > TOLD {
        told.push(format!("and in {} more", turns - TOLD));
    }
    (turns > 0).then(|| findings::counts_put_back(all, turns, passages.len() - 1, &told.join(", ")))
}

/// Whether the index is low at few counts of a turn and high at most of them.
fn is_inverted(count: &[i64], pulse: &[bool], turn: i64) -> bool {
    let mut at = [BTreeSet::new(), BTreeSet::new()];
    for (count, pulse) in count.iter().zip(pulse) {
        at[usize::from(*pulse)].insert(count.rem_euclid(turn));
    }
    let [low, high] = at.map(|counts| counts.len());
    low > 0 && high > 2 * low && 2 * high > turn as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    const TURN: i64 = 2000;

    /// An axis that goes and comes, the true count at every sample; the index is high over `width` counts from 700 on.
    struct Axis {
        truth: Vec<i64>,
        pulse: Vec<bool>,
    }

    fn axis(seed: u64, width: i64, fastest: f64) -> Axis {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let (amplitude, slow) = (
            rng.random_range(1.5..4.0) * TURN as f64,
            rng.random_range(0.6..1.0),
        );
        let n = (amplitude * 6.0 / fastest).max(2000.0) as usize * 3;
        let w = fastest / amplitude;
        let start = rng.random_range(0.0..6.0);
        let truth: Vec<i64> = (0..n)
            .map(|k| w * k as f64 + start)
            .map(|t| (amplitude * (t.sin() + 0.3 * (slow * t).cos())).floor() as i64)
            .collect();
        let pulse = truth
            .iter()
            .map(|c| (c - 700).rem_euclid(TURN) < width)
            .collect();
        Axis { truth, pulse }
    }

    /// What the truth is off by from a corrected count, but for the zero: least and most from a sample on.
    fn spread(found: &Indexed, truth: &[i64], samples: std::ops::Range<usize>) -> i64 {
        let off = samples.map(|k| found.count[k] - truth[k]);
        let (mut least, mut most) = (i64::MAX, i64::MIN);
        for o in off {
            (least, most) = (least.min(o), most.max(o));
        }
        most - least
    }

    /// Whatever the speed, also where the pulse is jumped over or the axis turns back in it: no false alarm.
    #[test]
    fn law_healthy_records_have_nothing_put_back() {
        let mut passed = 0;
        for seed in 0..200 {
            for (width, fastest) in [(1, 0.8), (4, 0.9), (4, 3.0), (12, 30.0), (40, 200.0)] {
                let axis = axis(seed, width, fastest);
                let found = indexed(&axis.truth, &axis.pulse, TURN, &[], &|k| k as f64).unwrap();
                assert!(
                    found.passages.iter().all(|p| p.put_back == 0),
                    "{seed} {width} {fastest}"
                );
                assert_eq!(spread(&found, &axis.truth, 0..axis.truth.len()), 0);
                if width == 4 && fastest < 1.0 {
                    // Resolved at every count the zero is that of the pulse.
                    assert_eq!((found.count[0] - axis.truth[0] + 700).rem_euclid(TURN), 0);
                }
                passed += found.passages.len();
            }
        }
        assert!(passed > 10_000, "{passed}");
    }

    /// An index that is read from the angle itself, whose edges lie within counts, and one that comes up to twelve samples late: nothing is
    /// put back, and a loss of eight counts is still found.
    #[test]
    fn law_an_index_that_is_not_gated_or_late_loses_nothing() {
        let (mut false_alarms, mut told, mut missed, mut all) = (0, 0, 0, 0);
        for seed in 0..100 {
            for (late, fastest) in [(0, 0.9), (0, 5.0), (1, 0.9), (2, 5.0), (3, 3.0), (12, 3.0)] {
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
                let amplitude = rng.random_range(1.5..4.0) * TURN as f64;
                let (edge, width) = (rng.random_range(600.0..700.0), rng.random_range(8.0..30.0));
                let n = (amplitude * 40.0 / fastest) as usize;
                let at = |k: usize| amplitude * (fastest / amplitude * k as f64).sin();
                let truth: Vec<i64> = (0..n).map(|k| at(k).floor() as i64).collect();
                let high = |k: usize| (at(k) - edge).rem_euclid(TURN as f64) < width;
                let pulse: Vec<bool> = (0..n).map(|k| high(k.saturating_sub(late))).collect();
                let found = indexed(&truth, &pulse, TURN, &[], &|k| k as f64).unwrap();
                all += 1;
                let healthy = found.passages.iter().all(|p| p.put_back == 0)
                    && found.findings[0].code() == "zero-at-index";
                false_alarms += usize::from(!healthy);
                let codes: Vec<&str> = found.findings.iter().map(Finding::code).collect();
                assert!(late == 0 || codes.contains(&"index-late"), "{seed} {late}");
                told += usize::from(codes.contains(&"index-late"));
                let mut count = truth.clone();
                count[n / 2..].iter_mut().for_each(|c| *c -= 8);
                let found = indexed(&count, &pulse, TURN, &[], &|k| k as f64).unwrap();
                let put: i64 = found.passages.iter().map(|p| p.put_back).sum();
                missed += usize::from((put - 8).abs() > 1);
            }
        }
        println!("{false_alarms} false, {told} late, {missed} missed of {all}");
        assert!(false_alarms <= 6 && missed <= 6, "{false_alarms} {missed}");
        assert!((400..=403).contains(&told), "{told}");
    }

    /// One to five counts lost or added at random places: the number exactly, and every later count right.
    #[test]
    fn coverage_lost_counts() {
        let (mut lost, mut found_all, mut doubtful) = (0, 0, 0);
        for seed in 0..200 {
            let axis = axis(seed, 4, 0.9);
            let n = axis.truth.len();
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(900 + seed);
            let clean = indexed(&axis.truth, &axis.pulse, TURN, &[], &|k| k as f64).unwrap();
            // Between two pulses that are gone through whole: a turn within the pulse tells one side of it.
            let whole = |first: usize| {
                let past = (first..n).find(|k| !axis.pulse[*k]);
                let before = first.checked_sub(1).map(|k| axis.truth[k]);
                past.zip(before)
                    .is_some_and(|(k, b)| (axis.truth[k] - b).abs() > 4)
            };
            let pairs = clean
                .passages
                .windows(2)
                .map(|w| [w[0].sample, w[1].sample]);
            let pairs: Vec<[usize; 2]> = pairs.filter(|p| p.iter().all(|s| whole(*s))).collect();
            let mut count = axis.truth.clone();
            let mut events = Vec::new();
            for pair in pairs.iter().step_by(3) {
                let k = rng.random_range(pair[0] + 10..pair[1]);
                let size = rng.random_range(1..=5) * if rng.random::<bool>() { 1 } else { -1 };
                count[k..].iter_mut().for_each(|c| *c += size);
                events.push((pair[1], -size));
                lost += 1;
            }
            let found = indexed(&count, &axis.pulse, TURN, &[], &|k| k as f64).unwrap();
            for (sample, size) in &events {
                let passage = found.passages.iter().find(|p| p.sample == *sample).unwrap();
                found_all += usize::from(passage.put_back == *size);
            }
            let first = found.passages[0].sample;
            let turns = (axis.truth[first] - 700 + 10).div_euclid(TURN);
            let put: usize = found.passages.iter().filter(|p| p.put_back != 0).count();
            // Rarely a turn within the pulse leaves a count in doubt between two intervals.
            if put != events.len() {
                doubtful += 1;
                continue;
            }
            // At every pulse the count is right again, and its zero is that of the pulse.
            for p in &found.passages {
                assert_eq!(
                    found.count[p.sample],
                    axis.truth[p.sample] - 700 - TURN * turns,
                    "{seed}"
                );
            }
            assert_eq!(found.findings.len(), 1 + usize::from(!events.is_empty()));
            assert_eq!(found.findings[0].code(), "zero-at-index");
            assert!(
                found.findings[1..]
                    .iter()
                    .all(|f| f.code() == "counts-put-back")
            );
        }
        assert!(found_all + 2 >= lost, "{found_all} of {lost}");
        assert!(doubtful <= 2, "{doubtful} of 200");
        assert!(lost > 300, "{lost}");
    }

    /// Lines that are taken for counts: four times as many come to a turn.
    #[test]
    fn known_lines_that_are_taken_for_counts() {
        let count: Vec<i64> = (0..4000).collect();
        let pulse: Vec<bool> = (0..4000).map(|k| k % 200 < 3).collect();
        let found = indexed(&count, &pulse, 50, &[], &|k| k as f64).unwrap();
        assert_eq!(found.findings[0].code(), "index-turn-mismatch");
    }

    #[test]
    fn known_counts_of_a_turn_that_are_wrong() {
        let axis = axis(3, 4, 0.9);
        let found = indexed(&axis.truth, &axis.pulse, 1900, &[], &|k| k as f64).unwrap();
        assert_eq!(found.findings[0].code(), "index-turn-mismatch");
        assert!(
            found.findings[0].evidence_text().contains("2000"),
            "{:?}",
            found.findings
        );
    }

    #[test]
    fn known_places_of_a_loss() {
        // Both channels changed at once at sample 1300: two counts are put back there.
        let truth: Vec<i64> = (0..8000).collect();
        let pulse: Vec<bool> = truth
            .iter()
            .map(|c| (c - 700).rem_euclid(TURN) < 3)
            .collect();
        let count: Vec<i64> = truth
            .iter()
            .map(|c| if *c < 1300 { *c } else { c - 2 })
            .collect();
        let found = indexed(&count, &pulse, TURN, &[1300], &|k| k as f64).unwrap();
        assert_eq!(spread(&found, &truth, 0..8000), 0);
        // Without that knowledge two counts are spread, five are seen as a jump.
        let found = indexed(&count, &pulse, TURN, &[], &|k| k as f64).unwrap();
        assert_eq!(spread(&found, &truth, 0..8000), 2);
        let count: Vec<i64> = truth
            .iter()
            .map(|c| if *c < 1300 { *c } else { c - 5 })
            .collect();
        let found = indexed(&count, &pulse, TURN, &[], &|k| k as f64).unwrap();
        assert_eq!(spread(&found, &truth, 0..8000), 0);
    }

    #[test]
    fn refuses_what_is_no_index() {
        assert!(indexed(&[0; 5], &[false; 4], 100, &[], &|_| 0.0).is_err());
        assert!(indexed(&[0; 5], &[false; 5], 4, &[], &|_| 0.0).is_err());
        let none = indexed(&[0; 5], &[false; 5], 100, &[], &|_| 0.0).unwrap();
        assert_eq!(none.findings[0].code(), "no-index");
        let always = indexed(&[0; 5], &[true; 5], 100, &[], &|_| 0.0).unwrap();
        assert_eq!(always.findings[0].code(), "no-index");
        assert!(always.findings[0].evidence_text().contains("always"));
    }

    /// Exchanged lines give the same counts, and are told.
    #[test]
    fn law_an_inverted_index_is_turned_round() {
        let count: Vec<i64> = (0..400).map(|k| if k < 130 { k } else { k - 3 }).collect();
        let pulse: Vec<bool> = (0..400).map(|k| k % 50 == 20).collect();
        let inverted: Vec<bool> = pulse.iter().map(|p| !p).collect();
        let plain = indexed(&count, &pulse, 50, &[], &|k| k as f64).unwrap();
        let found = indexed(&count, &inverted, 50, &[], &|k| k as f64).unwrap();
        assert_eq!(found.count, plain.count);
        assert_eq!(found.findings[0].code(), "index-inverted");
        assert_eq!(found.findings[1..], plain.findings);
    }
}

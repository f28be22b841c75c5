//! The clock behind time stamps: rate, resolution, gaps, wraps, in one pass and bounded memory.
//!
//! Stamps are readings of a clock that runs evenly; they are rounded to its resolution, scattered by what lies
//! between the sampling and the reading, and sometimes handed over in bursts. The straight line through them,
//! number of the sample against stamp, is known far better than any step:
//!
//! t_i = a_s + T i + e_i in every stretch s without a gap,
//!
//! with one period T for all stretches, by least squares. The covariance of the errors is taken as that of a
//! first-order autoregression: u²(T) = s²/Σ(i − ī)² · (1 + ρ)/(1 − ρ), with s from the residuals and ρ from
//! successive ones, never less than for ρ = 0. Stamps that are rounded without being spread over the resolution
//! (every step alike) hold T within ±q over the whole elapsed time, a triangular distribution: q²/(6 N²) is added.

use crate::stamp::{PARTS, Stamp};
use serde::{Deserialize, Serialize};

/// A step longer than this many periods is a gap.
const GAP: f64 = 1.5;
/// Steps at the beginning that settle the typical step and the limit of a gap.
const FIRST_STEPS: usize = 1 << 16;
/// Share and number of repeated stamps from which on they are the nature of the clock and not doubled rows.
const REPEATS: (f64, usize) = (0.1, 10);
/// Gaps that are kept by a bounded estimator; all are counted.
pub(crate) const LISTED: usize = 100;

/// A place where samples are missing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Index of the last sample before the gap.
    pub after_sample: usize,
    /// Line of that sample.
    pub line: u64,
    /// Time of that sample, s.
    pub at_s: f64,
    /// Length of the step, s.
    pub step_s: f64,
}

/// What time stamps tell about the clock they came from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// Sampling rate by the clock line, Hz.
    pub rate_hz: f64,
    /// Standard uncertainty of the rate, Hz: from scatter and resolution of the stamps, not from the error of the
    /// clock itself.
    pub rate_u_hz: f64,
    /// Standard deviation of the steps that are not gaps, s; `None` below two.
    pub jitter_s: Option<f64>,
    /// Standard deviation of the stamps about the clock line, s.
    pub scatter_s: f64,
    /// Resolution of the stamps, s: the largest unit of which all steps are multiples; where all steps are alike,
    /// the last digit written.
    pub resolution_s: f64,
    /// Whether the stamps come in bursts, so that a step says little about the sampling.
    pub bursts: bool,
    /// How often the counter behind the stamps began again from its lowest value.
    pub wraps: u64,
    /// Number of gaps.
    pub gaps: u64,
    /// Steps that are not gaps.
    pub steps: u64,
}

/// Why a stamp was not accepted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Backward {
    /// It repeats the one before.
    Repeats { at_s: f64 },
    /// It lies before the one before.
    Runs { from_s: f64, to_s: f64 },
}

/// A wrap of the counter, for the finding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wrap {
    pub line: u64,
    /// Length of one turn, s.
    pub turn_s: f64,
}

#[derive(Clone, Copy)]
struct Step {
    /// Index of the sample before it and its line.
    sample: usize,
    line: u64,
    /// Time of that sample relative to the origin, in parts.
    at: i128,
    length: f64,
    /// The length exactly, in parts.
    parts: i128,
}

/// What the first steps settled.
struct Settled {
    /// Typical step, about which residuals are small.
    period: f64,
    limit: f64,
    bursts: bool,
    repeats: bool,
}

/// Sums of one stretch without a gap, about their means: number of the sample against residual.
#[derive(Default)]
struct Stretch {
    n: f64,
    mean_x: f64,
    mean_r: f64,
    residual: f64,
}

/// Takes stamps one by one and tells the clock at the end.
pub(crate) struct ClockEstimator {
    per_second: f64,
    first: Option<Stamp>,
    last: Option<(usize, u64, Stamp)>,
    /// Turns that the counter has made, in parts.
    turned: i128,
    wraps: Vec<Wrap>,
    wrap_count: u64,
    decimals: u8,
    /// Largest common unit of the steps that are not gaps, and the last two different ones.
    common: i128,
    recent: [i128; 2],
    /// The latest step: parts, seconds.
    latest: (i128, f64),
    waiting: Vec<Step>,
    repeats_waiting: Vec<(u64, f64)>,
    settled: Option<Settled>,
    stretch: Stretch,
    sxx: f64,
    sxr: f64,
    srr: f64,
    count: u64,
    difference: f64,
    difference2: f64,
    pub(crate) gaps: Vec<Gap>,
    all_gaps: bool,
    gap_count: u64,
    /// Repeats that were accepted until the nature of the clock was known.
    pub(crate) backward: Vec<(u64, Backward)>,
    pub(crate) backward_count: u64,
    /// Whether a stamp may lie before the one before it by less than two intervals.
    late_stamps: bool,
    /// Whether one did.
    crossed: bool,
}

impl ClockEstimator {
    /// For stamps in units of which so many make a second.
    pub(crate) fn new(per_second: f64) -> Self {
        Self {
            per_second,
            first: None,
            last: None,
            turned: 0,
            wraps: Vec::new(),
            wrap_count: 0,
            decimals: 0,
            common: 0,
            recent: [0; 2],
            latest: (0, 0.0),
            waiting: Vec::new(),
            repeats_waiting: Vec::new(),
            settled: None,
            stretch: Stretch::default(),
            sxx: 0.0,
            sxr: 0.0,
            srr: 0.0,
            count: 0,
            difference: 0.0,
            difference2: 0.0,
            gaps: Vec::new(),
            all_gaps: false,
            gap_count: 0,
            backward: Vec::new(),
            backward_count: 0,
            late_stamps: false,
            crossed: false,
        }
    }

    /// Whether stamps that cross their neighbours are jitter.
    pub(crate) fn with_late_stamps(self, late_stamps: bool) -> Self {
        Self {
            late_stamps,
            ..self
        }
    }

    /// Keeps every gap, for a recording that is in memory anyway.
    pub(crate) fn keep_all_gaps(mut self) -> Self {
        self.all_gaps = true;
        self
    }

    /// Parts to seconds.
    fn seconds(&self, parts: i128) -> f64 {
        let stamp = Stamp {
            parts,
            decimals: self.decimals,
            dated: false,
        };
        stamp.value() / self.per_second
    }

    /// Takes the stamp of a sample and returns it with wraps undone.
    pub(crate) fn add(&mut self, sample: usize, line: u64, stamp: Stamp) -> Stamp {
        self.decimals = self.decimals.max(stamp.decimals);
        let Some((before, before_line, last)) = self.last else {
            self.first = Some(stamp);
            self.last = Some((sample, line, stamp));
            return stamp;
        };
        let mut stamp = Stamp {
            parts: stamp.parts + self.turned,
            ..stamp
        };
        if stamp.parts < last.parts
            && let Some(turn) = self.turn(stamp, last)
        {
            self.turned += turn;
            stamp.parts += turn;
            self.wrap_count += 1;
            if self.wraps.len() < LISTED {
                let turn_s = self.seconds(turn);
                self.wraps.push(Wrap { line, turn_s });
            }
        }
        let parts = stamp.parts - last.parts;
        self.last = Some((sample, line, stamp));
        if parts < 0 && self.late_stamps {
            let typical = self.typical();
            if typical.is_some_and(|t| -self.seconds(parts) < 2.0 * t) {
                self.crossed = true;
                return stamp;
            }
        }
        if parts < 0 {
            let from_s = last.value() / self.per_second;
            let to_s = stamp.value() / self.per_second;
            self.tell(line, Backward::Runs { from_s, to_s });
            // A new stretch: whatever comes after has another zero.
            self.close();
            return stamp;
        }
        let at = self.first.map_or(0, |f| last.parts - f.parts);
        // Steps are mostly alike.
        let length = match self.latest {
            (same, length) if same == parts => length,
            _ => self.seconds(parts),
        };
        self.latest = (parts, length);
        let step = Step {
            sample: before,
            line: before_line,
            at,
            length,
            parts,
        };
        if parts == 0 {
            let at_s = stamp.value() / self.per_second;
            match &self.settled {
                None => self.repeats_waiting.push((line, at_s)),
                Some(s) if !s.repeats => self.tell(line, Backward::Repeats { at_s }),
                Some(_) => {}
            }
        }
        match self.settled {
            Some(_) => self.count(step),
            None => {
                self.waiting.push(step);
                if self.waiting.len() == FIRST_STEPS {
                    self.settle();
                }
            }
        }
        stamp
    }

    fn tell(&mut self, line: u64, what: Backward) {
        self.backward_count += 1;
        if self.backward.len() < LISTED {
            self.backward.push((line, what));
        }
    }

    /// A step as most are.
    fn typical(&self) -> Option<f64> {
        match &self.settled {
            Some(s) => Some(s.period),
            None if self.waiting.len() >= 3 => {
                let latest = self.waiting.iter().rev().take(99).map(|s| s.length);
                Some(median(&mut latest.collect::<Vec<_>>()))
            }
            None => None,
        }
    }

    /// The turn of a counter that explains a step backwards: the stamp follows the one before as usual once it is
    /// added.
    fn turn(&self, stamp: Stamp, last: Stamp) -> Option<i128> {
        let typical = self.typical()?;
        let whole = self.decimals == 0;
        let bits = [8, 16, 24, 31, 32].map(|b| (whole, (1_i128 << b) * PARTS));
        // Microseconds and milliseconds of 32 bits that were written in another unit.
        let micro = (PARTS as f64 * self.per_second * 4_294.967_296).round() as i128;
        let others = [(true, micro), (true, micro * 1000)];
        bits.into_iter()
            .chain(others)
            .filter(|&(possible, turn)| {
                let length = self.seconds(turn);
                let step = self.seconds(stamp.parts + turn - last.parts);
                // A short counter says little, so that only the very next count is believed.
                let most = if length > 1e4 * typical { 16.0 } else { 1.5 };
                possible && length > 64.0 * typical && step > 0.0 && step <= most * typical
            })
            .map(|(_, turn)| turn)
            .min()
    }

    /// Decides from the first steps what a step of this clock looks like.
    fn settle(&mut self) {
        let waiting = std::mem::take(&mut self.waiting);
        let steps: Vec<f64> = waiting.iter().map(|s| s.length).collect();
        let common = waiting.iter().fold(0, |q, s| gcd(q, s.parts));
        let settled = settled(&steps, self.seconds(common));
        for (line, at_s) in std::mem::take(&mut self.repeats_waiting) {
            if !settled.repeats {
                self.tell(line, Backward::Repeats { at_s });
            }
        }
        self.settled = Some(settled);
        for step in waiting {
            self.count(step);
        }
    }

    /// Resolution so far, s.
    fn quantum(&self) -> f64 {
        let digit = 10_i128.pow(15 - u32::from(self.decimals.min(15)));
        // With all steps alike, how finely the clock could tell is known from the digits alone.
        let parts = if self.recent[1] == 0 {
            digit
        } else {
            self.common
        };
        self.seconds(parts)
    }

    fn count(&mut self, step: Step) {
        let Some(settled) = &self.settled else { return };
        if step.length > settled.limit {
            self.gap_count += 1;
            if self.all_gaps || self.gaps.len() < LISTED {
                self.gaps.push(Gap {
                    after_sample: step.sample,
                    line: step.line,
                    at_s: self.seconds(step.at),
                    step_s: step.length,
                });
            }
            self.close();
            return;
        }
        if step.length == 0.0 && !settled.repeats {
            return;
        }
        if step.parts > 0 && !self.recent.contains(&step.parts) {
            self.common = gcd(self.common, step.parts);
            self.recent = [step.parts, self.recent[0]];
        }
        let difference = step.length - settled.period;
        self.count += 1;
        self.difference += difference;
        self.difference2 += difference * difference;
        if self.stretch.n == 0.0 {
            self.stretch.n = 1.0;
        }
        let s = &mut self.stretch;
        s.residual += difference;
        let x = s.n;
        s.n += 1.0;
        let (dx, dr) = (x - s.mean_x, s.residual - s.mean_r);
        s.mean_x += dx / s.n;
        s.mean_r += dr / s.n;
        self.sxx += dx * (x - s.mean_x);
        self.sxr += dx * (s.residual - s.mean_r);
        self.srr += dr * (s.residual - s.mean_r);
    }

    fn close(&mut self) {
        self.stretch = Stretch::default();
    }

    /// First stamp.
    pub(crate) fn first(&self) -> Option<Stamp> {
        self.first
    }

    /// Last stamp, wraps undone.
    pub(crate) fn last(&self) -> Option<Stamp> {
        self.last.map(|l| l.2)
    }

    /// Wraps that were undone, the first hundred.
    pub(crate) fn wraps(&self) -> &[Wrap] {
        &self.wraps
    }

    /// Whether stamps may repeat, because the clock is coarse or tells bursts; settles it where it is still open.
    pub(crate) fn may_repeat(&mut self) -> bool {
        if self.settled.is_none() && !self.waiting.is_empty() {
            self.settle();
        }
        self.settled.as_ref().is_some_and(|s| s.repeats)
    }

    /// Whether stamps crossed their neighbours by jitter. They may be equal by it then.
    pub(crate) fn crossed(&self) -> bool {
        self.crossed
    }

    /// The clock, where two stamps tell one.
    pub(crate) fn finish(&mut self) -> Option<Clock> {
        if self.settled.is_none() {
            if self.waiting.is_empty() {
                return None;
            }
            self.settle();
        }
        self.close();
        if self.crossed {
            self.backward
                .retain(|b| matches!(b.1, Backward::Runs { .. }));
        }
        self.backward.sort_by_key(|b| b.0);
        let q = self.quantum();
        let settled = self.settled.as_ref()?;
        if self.count == 0 {
            return None;
        }
        let n = self.count as f64;
        let slope = if self.sxx > 0.0 {
            self.sxr / self.sxx
        } else {
            self.difference / n
        };
        let period = settled.period + slope;
        // Samples, less one intercept for each stretch, less the slope.
        let free = self.count as f64 - 1.0;
        let squares = (self.srr - slope * self.sxr).max(0.0);
        let variance = if free > 0.0 { squares / free } else { 0.0 };
        let step_variance =
            (self.difference2 - 2.0 * slope * self.difference + n * slope * slope).max(0.0) / n;
        let rho = if variance > 0.0 {
            (1.0 - step_variance / (2.0 * variance)).clamp(0.0, 1.0 - 2.0 / (n + 2.0))
        } else {
            0.0
        };
        let white = if self.sxx > 0.0 {
            variance / self.sxx
        } else {
            0.0
        };
        let scattered = white * (1.0 + rho) / (1.0 - rho);
        // Rounding that is spread over the resolution has the standard deviation q/√12.
        let spread = variance.sqrt() >= 0.8 * q / 12_f64.sqrt();
        let rounded = if spread { 0.0 } else { q * q / (6.0 * n * n) };
        let u = (scattered + rounded).sqrt();
        let mean = self.difference / n;
        let jitter = (self.count > 1)
            .then(|| ((self.difference2 - n * mean * mean).max(0.0) / (n - 1.0)).sqrt());
        Some(Clock {
            rate_hz: 1.0 / period,
            rate_u_hz: u / (period * period),
            jitter_s: jitter,
            scatter_s: variance.sqrt(),
            resolution_s: q,
            bursts: settled.bursts,
            wraps: self.wrap_count,
            gaps: self.gap_count,
            steps: self.count,
        })
    }
}

/// Typical step and limit of a gap from the first steps, in seconds; `q` is the unit of which all are multiples.
fn settled(steps: &[f64], q: f64) -> Settled {
    let n = steps.len() as f64;
    let zeros = steps.iter().filter(|s| **s == 0.0).count();
    let repeats = zeros >= REPEATS.1 && zeros as f64 >= REPEATS.0 * n;
    let mut sorted = steps.to_vec();
    let median = median(&mut sorted);
    // Rounding makes a step one unit longer than its neighbours. Where that would pass for a missing sample, many
    // such steps, or evenly spaced ones, are rounding: samples are lost seldom and at random.
    let one_more = (median + q) * (1.0 + 1e-9);
    let mut limit = GAP * median;
    if one_more > limit {
        let at: Vec<usize> = (0..steps.len())
            .filter(|&i| steps[i] > limit && steps[i] <= one_more)
            .collect();
        if at.len() as f64 >= 0.05 * n || evenly_spaced(&at) {
            limit = one_more;
        }
    }
    let mut long: Vec<f64> = steps.iter().copied().filter(|s| *s > limit).collect();
    let quarter = |sorted: &mut [f64], p: f64| {
        let k = ((n - 1.0) * p) as usize;
        *sorted.select_nth_unstable_by(k, f64::total_cmp).1
    };
    // Many long steps among short and irregular ones: samples that were handed over together.
    let bursts = long.len() as f64 > 0.02 * n && {
        let spread = quarter(&mut sorted, 0.75) - quarter(&mut sorted, 0.25);
        let typical = self::median(&mut long);
        let irregular = repeats || spread > 0.3 * median + q;
        let found = irregular && typical > 3.5 * median;
        if found {
            limit = GAP * typical + q;
        }
        found
    };
    let (sum, count) = steps
        .iter()
        .filter(|s| **s <= limit && (repeats || **s > 0.0))
        .fold((0.0, 0_usize), |(sum, n), s| (sum + s, n + 1));
    Settled {
        period: sum / count.max(1) as f64,
        limit,
        bursts,
        repeats,
    }
}

/// Whether places follow one another at equal distances, as those of a beat do: four at least.
fn evenly_spaced(at: &[usize]) -> bool {
    let spaces = || at.windows(2).map(|w| w[1] - w[0]);
    match (spaces().min(), spaces().max()) {
        (Some(least), Some(most)) if at.len() >= 4 => most - least <= 2.max(most / 10),
        _ => false,
    }
}

fn gcd(mut a: i128, mut b: i128) -> i128 {
    // Divisions of 64 bits where the numbers have no more, as steps have.
    if let (Ok(mut short_a), Ok(mut short_b)) = (i64::try_from(a), i64::try_from(b)) {
        while short_b != 0 {
            (short_a, short_b) = (short_b, short_a.wrapping_rem(short_b));
        }
        return i128::from(short_a);
    }
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Median of a non-empty slice, which it reorders.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    let n = values.len();
    let (below, &mut upper, _) = values.select_nth_unstable_by(n / 2, f64::total_cmp);
    if n % 2 == 1 {
        upper
    } else {
        let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        0.5 * (lower + upper)
    }
}

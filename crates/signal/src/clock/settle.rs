//! How a clock is read, from its first stamps.

use super::comb::Comb;

/// Stamps on either side of a place whose median is compared, at first and at most.
const WINDOWS: (usize, usize) = (63, 8191);
/// Stamps of a block in which rounding alone is looked for.
const BLOCK: usize = 32;
/// Resolution, mean steps, from which on a grid cannot be told from rounding.
const FINE: f64 = 0.3;
/// Share of missing samples from which on two are lost within the windows whose levels tell of one.
const OFTEN: f64 = 0.004;
/// Resultant of the steps of stamps that scatter by 0.07 intervals.
const STEADY: f64 = 0.82;
/// How far a grid must stand out for its rows to be numbered one by one: a standard deviation of 0.22 intervals.
const NUMBERED: f64 = 0.38;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mode {
    /// Every stamp tells its number.
    Grid,
    /// Medians of so many stamps tell it; they differ by chance by less than the threshold, in intervals.
    Scatter { window: usize, threshold: f64 },
}

impl Mode {
    pub(super) fn is_grid(self) -> bool {
        self == Self::Grid
    }
}

#[derive(Debug)]
pub(super) struct Settled {
    /// Sampling interval, s, to a small fraction of itself.
    pub(super) interval: f64,
    pub(super) mode: Mode,
    pub(super) bursts: bool,
    /// The grid behind stamps that scatter, where one stands out.
    pub(super) comb: Option<Comb>,
}

impl Settled {
    /// From stamps in s that are multiples of `q`; `None` where they do not advance.
    pub(super) fn of(stamps: &[f64], q: f64, nominal: Option<f64>) -> Option<Self> {
        if stamps.len() < 2 {
            return None;
        }
        let steps: Vec<f64> = stamps.windows(2).map(|w| w[1] - w[0]).collect();
        let grid = |interval: f64| Self {
            interval,
            mode: Mode::Grid,
            bursts: false,
            comb: None,
        };
        let (all, range) = line(stamps);
        if all > 0.0 {
            // A row that is missing makes a jump of an interval, which the line shares where it is short.
            let most = if stamps.len() < 8 { 0.3 } else { 0.45 };
            if range <= most * all {
                return Some(grid(all));
            }
            if range <= 1.1 * q && (q < 0.9 * all || as_a_line_has_them(&steps, q)) {
                return Some(Self::scattered(stamps, &steps, q, all, true));
            }
        }
        if let Some(interval) = rounded(stamps, &steps, q) {
            let whole = interval / q;
            if (whole - whole.round()).abs() > 0.02 && !in_whole_steps(&steps, q, whole) {
                return Some(Self::scattered(stamps, &steps, q, interval, false));
            }
        }
        if let Some((interval, alike)) = on_a_grid(&steps, q) {
            // Rows are numbered wrongly now and then where half an interval is less than seven standard deviations.
            let comb = (alike < STEADY && q < 0.5 * interval)
                .then(|| Comb::near(stamps, interval))
                .flatten()
                .filter(|comb| comb.resultant > 0.9 * alike.sqrt());
            return Some(Self {
                comb,
                ..grid(interval)
            });
        }
        // Stamps rounded to whole units stand out at the unit itself, those of packets at every multiple of their rate.
        let mean = (stamps[stamps.len() - 1] - stamps[0]) / steps.len() as f64;
        let packed = steps.iter().filter(|s| **s < 0.1 * mean).count();
        let comb = match q < FINE * mean && 10 * packed < steps.len() {
            true => Comb::of(stamps),
            false => None,
        };
        if let Some(comb) = comb
            && comb.resultant >= NUMBERED
            && comb.missing > OFTEN * stamps.len() as f64
        {
            return Some(Self {
                comb: Some(comb),
                ..grid(comb.interval)
            });
        }
        let first = block_means(stamps)
            .or(nominal.map(|r| 1.0 / r))
            .filter(|i| *i > 0.0 && i.is_finite())?;
        let mut settled = Self::scattered(stamps, &steps, q, first, false);
        settled.comb = comb.filter(|_| !settled.bursts);
        Some(settled)
    }

    /// Windows over which medians are steady; `complete` where no stamp is missing among these.
    fn scattered(stamps: &[f64], steps: &[f64], q: f64, first: f64, complete: bool) -> Self {
        let n = stamps.len();
        let mut interval = first;
        let mut window = WINDOWS.0.min(n / 4).max(1);
        // Interval, window and threshold of the steadiest so far.
        let mut best = (interval, window, f64::INFINITY);
        loop {
            let mut changes = changes(stamps, interval, window);
            if changes.len() < 3 {
                break;
            }
            let drift = median(&mut changes.clone());
            if !complete {
                interval *= 1.0 + drift / window as f64;
                changes.iter_mut().for_each(|c| *c -= drift);
            }
            let (spread, threshold) = if complete {
                let most = changes.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
                // Where the unit is whole intervals, to a beat, rounding moves medians by one of them.
                let whole = (q / interval - (q / interval).round()).abs() < 0.02;
                let least = if whole && q > 0.9 * interval {
                    1.5
                } else {
                    0.5
                };
                (0.5 * most, (2.0 * most).max(least))
            } else {
                let spread = spread(&changes);
                (spread, (8.0 * spread).max(0.5))
            };
            if threshold < best.2 {
                best = (interval, window, threshold);
            }
            if spread <= 1.0 / 14.0 || 2 * window + 1 > WINDOWS.1 || 16 * window > n {
                break;
            }
            window = 2 * window + 1;
        }
        let (interval, window, threshold) = best;
        let count = steps.len() as f64;
        let share =
            |f: &dyn Fn(f64) -> bool| steps.iter().filter(|s| f(**s)).count() as f64 / count;
        Self {
            interval,
            mode: Mode::Scatter { window, threshold },
            bursts: !complete
                && share(&|s| s < 0.6 * interval) > 0.4
                && share(&|s| s > 1.5 * interval) > 0.02,
            comb: None,
        }
    }
}

/// Standard deviation of the bulk of some differences; whole intervals, which are slips, are left out where the rest is steady.
fn spread(changes: &[f64]) -> f64 {
    let of = |sizes: &mut [f64]| {
        sizes.sort_by(f64::total_cmp);
        let at = |p: f64| sizes[((sizes.len() - 1) as f64 * p) as usize];
        (1.4826 * at(0.5), at(0.7) / 1.036)
    };
    let (bulk, tail) = of(&mut changes.iter().map(|c| c.abs()).collect::<Vec<_>>());
    if bulk > 0.2 {
        return bulk.max(tail);
    }
    let parts = changes.iter().map(|c| (c - c.round()).abs());
    let (bulk, tail) = of(&mut parts.collect::<Vec<_>>());
    bulk.max(tail)
}

/// Interval by least squares, and the range of the stamps about the line.
fn line(stamps: &[f64]) -> (f64, f64) {
    let n = stamps.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = stamps.iter().map(|t| t - stamps[0]).sum::<f64>() / n;
    let (mut xx, mut xt) = (0.0, 0.0);
    for (i, t) in stamps.iter().enumerate() {
        let x = i as f64 - middle;
        xx += x * x;
        xt += x * (t - stamps[0] - mean);
    }
    let slope = xt / xx;
    let off = stamps.iter().enumerate();
    let off = off.map(|(i, t)| t - stamps[0] - slope * i as f64);
    let (least, most) = off.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
        (a.min(v), b.max(v))
    });
    (slope, most - least)
}

/// Whether steps that differ by a unit come as rounding has them, which four tell.
fn as_a_line_has_them(steps: &[f64], q: f64) -> bool {
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let longer = steps.iter().filter(|s| **s > least + 0.5 * q).count();
    longer.min(steps.len() - longer) >= 4
}

/// Interval behind stamps rounded to a unit near it, where some are missing: most blocks are lines within the unit.
fn rounded(stamps: &[f64], steps: &[f64], q: f64) -> Option<f64> {
    if stamps.len() < 4 * BLOCK || median(&mut steps.to_vec()) >= 4.0 * q {
        return None;
    }
    let lines = stamps.chunks_exact(BLOCK).map(line);
    let mut slopes: Vec<f64> = lines
        .filter(|(slope, range)| *slope > 0.0 && *range <= 1.1 * q)
        .map(|l| l.0)
        .collect();
    (2 * slopes.len() > stamps.len() / BLOCK).then(|| median(&mut slopes))
}

/// Whether so many steps of whole units follow each other as no line rounded to the unit has between its longer steps, `whole` units apart:
/// a step that falls short by the part f of a unit is made good after 1/f of them, which leaves room for as much jitter again. Rows that
/// are lost at random from a grid leave runs of any length.
fn in_whole_steps(steps: &[f64], q: f64, whole: f64) -> bool {
    let part = whole - whole.round();
    if part <= 0.0 {
        return false;
    }
    let (mut run, mut longest) = (0_u32, 0_u32);
    for step in steps {
        let alike = (step / q - whole.round()).abs() < 0.5;
        run = if alike { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    f64::from(longest) > 2.0 / part + 4.0
}

/// Interval of a grid of which rows are missing, however many.
///
/// With the resultant of the phases of the steps, the square of that of the stamps.
fn on_a_grid(steps: &[f64], q: f64) -> Option<(f64, f64)> {
    let mut interval = median(&mut steps.to_vec());
    if !(interval > 0.0) {
        return None;
    }
    for _ in 0..4 {
        let (mut time, mut samples) = (0.0, 0.0);
        for step in steps {
            let multiple = (step / interval).round();
            if (1.0..=20.0).contains(&multiple) && (step / interval - multiple).abs() < 0.4 {
                time += step;
                samples += multiple;
            }
        }
        if samples == 0.0 {
            return None;
        }
        interval = time / samples;
    }
    let (mut cos, mut sin) = (0.0, 0.0);
    let (mut missing, mut paused) = (0.0, 0.0);
    let mut long = Vec::new();
    let (mut short, mut pauses) = (0, 0);
    for (k, step) in steps.iter().enumerate() {
        let (s, c) = (std::f64::consts::TAU * step / interval).sin_cos();
        (cos, sin) = (cos + c, sin + s);
        let multiple = (step / interval).round();
        // Under fine stamps a row that repeats is one that stands there twice.
        let doubled = *step == 0.0 && q < 0.1 * interval && k > 0 && steps[k - 1] > 0.0;
        short += usize::from(multiple < 1.0 && !doubled);
        if multiple > 20.0 {
            pauses += 1;
            paused += multiple - 1.0;
        } else if multiple > 1.0 {
            missing += multiple - 1.0;
        }
        if multiple > 1.0 {
            long.push(k);
        }
    }
    let n = steps.len() as f64;
    // A pause now and then is no loss; many are the time between packets.
    if 200 * pauses > steps.len() + 600 {
        missing += paused;
    }
    let one_in_three = missing > 0.3 * n;
    (cos.hypot(sin) >= 0.5 * n
        && 20 * short <= steps.len() + 40
        && missing <= 1.5 * n
        && !(one_in_three && evenly_spaced(&long)))
    .then_some((interval, cos.hypot(sin) / n))
}

/// Whether places follow one another at equal distances, as those of packets do.
fn evenly_spaced(at: &[usize]) -> bool {
    let mut spaces: Vec<usize> = at.windows(2).map(|w| w[1] - w[0]).collect();
    spaces.sort_unstable();
    let Some(middle) = spaces.get(spaces.len() / 2) else {
        return false;
    };
    // Every row behind the next has another rate.
    let alike = spaces.iter().filter(|s| *s == middle).count();
    *middle > 1 && 10 * alike >= 9 * spaces.len()
}

/// Median of the mean intervals of blocks: gaps in fewer than half of them do not matter.
fn block_means(stamps: &[f64]) -> Option<f64> {
    let length = (stamps.len() / 50).clamp(2, 500);
    let mut means: Vec<f64> = stamps
        .chunks(length)
        .filter(|c| c.len() > 1)
        .map(|c| (c[c.len() - 1] - c[0]) / (c.len() - 1) as f64)
        .collect();
    (!means.is_empty())
        .then(|| median(&mut means))
        .filter(|m| *m > 0.0)
}

/// Differences of the medians of neighbouring windows, intervals.
fn changes(stamps: &[f64], interval: f64, window: usize) -> Vec<f64> {
    let hop = window.div_ceil(2);
    let medians: Vec<f64> = (0..)
        .map(|k| k * hop)
        .take_while(|start| start + window <= stamps.len())
        .map(|start| {
            let rows = start..start + window;
            let off = rows.map(|r| (stamps[r] - stamps[0]) / interval - r as f64);
            middle_and_edge(&mut off.collect::<Vec<_>>()).0
        })
        .collect();
    (2..medians.len())
        .map(|k| medians[k] - medians[k - 2])
        .collect()
}

/// Mean of the middle fifth of a non-empty slice, and the value a tenth of the others are below.
///
/// Unlike a median the mean is steady where half of the stamps lie on either of two levels, as those of packets do.
pub(super) fn middle_and_edge(values: &mut [f64]) -> (f64, f64) {
    let n = values.len();
    let kept = (n / 5).max(1);
    let (from, tenth) = ((n - kept) / 2, n / 10);
    let (_, &mut least, _) = values.select_nth_unstable_by(from, f64::total_cmp);
    let edge = if tenth < from {
        *values[..from]
            .select_nth_unstable_by(tenth, f64::total_cmp)
            .1
    } else {
        least
    };
    let upper = &mut values[from..];
    if kept < upper.len() {
        upper.select_nth_unstable_by(kept, f64::total_cmp);
    }
    (upper[..kept].iter().sum::<f64>() / kept as f64, edge)
}

/// Median of a non-empty slice, which it reorders.
pub(super) fn median(values: &mut [f64]) -> f64 {
    proofmass_core::numeric::median(values).unwrap_or(0.0)
}

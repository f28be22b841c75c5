//! Time stamps against the line of the sampling clock: jitter, bursts, lost samples.

use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Stamps on either side of a place whose median is compared, at first and at most.
const WINDOWS: (usize, usize) = (21, 1365);

/// Steps between two stamps, in sample intervals, that are looked into.
const SUSPICIOUS: (f64, f64) = (0.5, 1.5);

/// A clock that was set or samples that were lost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slip {
    /// First row behind it.
    pub row: usize,
    /// Samples missing before that row; negative when the stamps went back.
    pub samples: i64,
}

/// The sampling clock behind the stamps of a recording.
///
/// Samples are taken evenly; their stamps are put on later, by a computer that is sometimes busy. A stamp that is late says
/// nothing about the sample; only stamps that *stay* late do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClockLine {
    /// Samples per second.
    pub rate: f64,
    /// Standard uncertainty of the rate from the scatter of the stamps, Hz.
    pub rate_uncertainty: f64,
    /// Root mean square departure of the stamps from the line, in sample intervals.
    pub jitter: f64,
    /// Places where samples are missing or the clock was set.
    pub slips: Vec<Slip>,
}

/// The line through the stamps of evenly taken samples, and where samples are missing.
///
/// Where two stamps are less than half or more than one and a half intervals apart, the medians of the departures from the
/// line on either side are compared; half an interval or more between them, rounded, is the number of samples missing.
/// Jitter, single late stamps and bursts move no median. The windows grow until the medians are steadier than a quarter of an
/// interval.
///
/// **Units** s; a nominal rate in Hz helps where most of the record is missing.
///
/// **Errors** [`Error::TooFew`] below three stamps, [`Error::NotFinite`], [`Error::OutOfRange`] when the stamps do not
/// advance.
///
/// **Accuracy** 20 % jitter: every sample used and the rate within 1e-4; `law_jitter_keeps_every_sample`.
///
/// ```
/// // A hundredth of a second apart, but for one stamp that is late and three samples that are missing.
/// let mut stamps: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k + if k > 600 { 3 } else { 0 })).collect();
/// stamps[200] += 0.008;
/// let line = proofmass_noise::clock_line(&stamps, None).unwrap();
/// assert!((line.rate - 100.0).abs() < 1e-2);
/// assert_eq!(line.slips.len(), 1);
/// assert_eq!((line.slips[0].row, line.slips[0].samples), (601, 3));
/// ```
pub fn clock_line(stamps: &[f64], nominal: Option<f64>) -> Result<ClockLine, Error> {
    crate::record::check_finite("time stamps", stamps)?;
    crate::record::check_count("time stamps", stamps.len(), 3)?;
    let n = stamps.len();
    if let Some(line) = on_a_grid(stamps) {
        return Ok(line);
    }
    let stalled = || Error::OutOfRange {
        name: "duration of the time stamps in s",
        value: stamps[n - 1] - stamps[0],
        min: f64::MIN_POSITIVE,
        max: f64::MAX,
    };
    let mut interval = first_interval(stamps)
        .or(nominal.map(|r| 1.0 / r))
        .filter(|i| *i > 0.0 && i.is_finite())
        .ok_or_else(stalled)?;
    let mut slips = Vec::new();
    let mut fit = Line::default();
    // The line and the slips depend on one another: twice round is enough, a third settles the rate.
    for _ in 0..3 {
        slips = find_slips(stamps, interval);
        fit = Line::through(stamps, &slips);
        if fit.interval <= 0.0 || !fit.interval.is_finite() {
            return Err(stalled());
        }
        interval = fit.interval;
    }
    Ok(fit.clock(slips))
}

/// The line through stamps that lie on an even grid of which rows are missing, however many.
///
/// Steps are whole multiples of the one in the middle, to a tenth of it, but for one in fifty at most; and with these multiples as
/// numbers all stamps lie on one line. A third of the rows may be missing.
fn on_a_grid(stamps: &[f64]) -> Option<ClockLine> {
    let steps: Vec<f64> = stamps.windows(2).map(|w| w[1] - w[0]).collect();
    let grid = median(&mut steps.clone()).filter(|g| *g > 0.0)?;
    let mut slips = Vec::new();
    let mut beside = 0;
    for (index, step) in steps.iter().enumerate() {
        let multiple = (step / grid).round();
        if !(1.0..1e9).contains(&multiple) || (step / grid - multiple).abs() > 0.1 {
            beside += 1;
        } else if multiple > 1.0 {
            slips.push(Slip {
                row: index + 1,
                samples: multiple as i64 - 1,
            });
        }
    }
    // Bursts have a grid of their own, on which most is missing.
    let missing = slips.iter().map(|s| s.samples as f64).sum::<f64>();
    if slips.is_empty() || 50 * beside > steps.len() || 2.0 * missing > stamps.len() as f64 {
        return None;
    }
    let fit = Line::through(stamps, &slips);
    (fit.interval > 0.0 && fit.scatter < 0.25 * fit.interval).then(|| fit.clock(slips))
}

/// Median of the mean intervals of blocks: gaps in fewer than half of them do not matter.
fn first_interval(stamps: &[f64]) -> Option<f64> {
    let length = (stamps.len() / 50).clamp(2, 500);
    let mut means: Vec<f64> = stamps
        .chunks(length)
        .filter(|c| c.len() > 1)
        .map(|c| (c[c.len() - 1] - c[0]) / (c.len() - 1) as f64)
        .collect();
    let middle = median(&mut means)?;
    (middle > 0.0).then_some(middle)
}

fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    let (_, value, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*value)
}

/// Straight line through stamps whose index counts the missing samples.
#[derive(Default)]
struct Line {
    interval: f64,
    interval_uncertainty: f64,
    scatter: f64,
}

impl Line {
    fn clock(&self, slips: Vec<Slip>) -> ClockLine {
        ClockLine {
            rate: 1.0 / self.interval,
            rate_uncertainty: self.interval_uncertainty / self.interval.powi(2),
            jitter: self.scatter / self.interval,
            slips,
        }
    }

    fn through(stamps: &[f64], slips: &[Slip]) -> Self {
        let n = stamps.len() as f64;
        let mut next = slips.iter().peekable();
        let mut missing = 0_i64;
        let index: Vec<f64> = (0..stamps.len())
            .map(|row| {
                while next.next_if(|s| s.row <= row).is_some_and(|s| {
                    missing += s.samples;
                    true
                }) {}
                (row as i64 + missing) as f64
            })
            .collect();
        let mean_i = index.iter().sum::<f64>() / n;
        let mean_t = stamps.iter().map(|t| t - stamps[0]).sum::<f64>() / n;
        let (mut ii, mut it) = (0.0, 0.0);
        for (i, t) in index.iter().zip(stamps) {
            ii += (i - mean_i).powi(2);
            it += (i - mean_i) * (t - stamps[0] - mean_t);
        }
        let interval = it / ii;
        let squares: f64 = index
            .iter()
            .zip(stamps)
            .map(|(i, t)| (t - stamps[0] - mean_t - interval * (i - mean_i)).powi(2))
            .sum();
        let scatter = (squares / (n - 2.0).max(1.0)).sqrt();
        Self {
            interval,
            interval_uncertainty: scatter / ii.sqrt(),
            scatter,
        }
    }
}

fn find_slips(stamps: &[f64], interval: f64) -> Vec<Slip> {
    let n = stamps.len();
    let departure = |row: usize| (stamps[row] - stamps[0]) / interval - row as f64;
    let candidates: Vec<usize> = (1..n)
        .filter(|r| {
            let step = (stamps[*r] - stamps[r - 1]) / interval;
            !(SUSPICIOUS.0..=SUSPICIOUS.1).contains(&step)
        })
        .collect();
    if candidates.is_empty() {
        return Vec::new();
    }
    let window = steady_window(n, &departure);
    let mut slips: Vec<Slip> = Vec::new();
    for &row in &candidates {
        let from = slips
            .last()
            .map_or(0, |s| s.row)
            .max(row.saturating_sub(window));
        // Up to the next place with a step of this size, where something else may have happened.
        let step = ((stamps[row] - stamps[row - 1]) / interval - 1.0).abs();
        let mut to = (row + window).min(n);
        if let Some(next) = candidates
            .iter()
            .skip_while(|c| **c <= row)
            .take_while(|c| **c < to)
            .find(|c| {
                let other = ((stamps[**c] - stamps[*c - 1]) / interval - 1.0).abs();
                other >= 1.5 && other >= 0.7 * step && step >= 1.5 && **c > row + window / 4
            })
        {
            to = *next;
        }
        let level = |range: std::ops::Range<usize>| {
            let mut values: Vec<f64> = range.map(departure).collect();
            median(&mut values)
        };
        let (Some(before), Some(after)) = (level(from..row), level(row..to)) else {
            continue;
        };
        let shift = after - before;
        // The step must make up most of the shift, or it belongs to a neighbour.
        let here = departure(row) - departure(row - 1);
        let samples = shift.round() as i64;
        if samples != 0 && (here - shift).abs() < 0.5 * shift.abs().max(1.0) {
            slips.push(Slip { row, samples });
        }
    }
    slips
}

/// Window over which medians of the departures are steady.
fn steady_window(n: usize, departure: &impl Fn(usize) -> f64) -> usize {
    let mut window = WINDOWS.0;
    while window < WINDOWS.1 && 8 * window < n {
        let blocks = (n / window).min(400);
        let stride = n / blocks;
        let mut changes: Vec<f64> = (0..blocks)
            .filter(|b| b * stride + 2 * window <= n)
            .filter_map(|b| {
                let start = b * stride;
                let mut left: Vec<f64> = (start..start + window).map(departure).collect();
                let mut right: Vec<f64> = (start + window..start + 2 * window)
                    .map(departure)
                    .collect();
                Some((median(&mut right)? - median(&mut left)?).abs())
            })
            .collect();
        changes.sort_by(f64::total_cmp);
        let outer = changes.get(changes.len() * 9 / 10).copied().unwrap_or(0.0);
        if outer < 0.25 {
            break;
        }
        window = window * 2 + 1;
    }
    window.min(n / 2).max(1)
}

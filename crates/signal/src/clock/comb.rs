//! The interval of a grid behind stamps that scatter too much to be numbered one by one.
//!
//! Whatever is lost, the stamps that remain lie about multiples of one interval T, so that the points in time
//! S(f) = |Σ exp(2πi f t_k)|/n stand out at f = 1/T, by the characteristic function of their errors: exp(−2π²σ²) for Gaussian ones of σ
//! intervals. Between multiples n S² is exponential with mean one.

use std::f64::consts::TAU;

/// Stamps from which on a line stands out.
const LEAST: usize = 64;
/// Chance of a line that is none, over all frequencies looked at.
const FALSE: f64 = 1e-9;
/// Bins of a mean step, and bins at most.
const BINS: (f64, usize) = (8.0, 1 << 20);
/// Frequencies that are looked at, in rows per second: nothing lost, to six rows in ten.
const RANGE: (f64, f64) = (0.98, 2.5);

/// A grid that was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Comb {
    /// Interval, s.
    pub(super) interval: f64,
    /// Its relative standard uncertainty.
    pub(super) u: f64,
    /// How far the line stands out: 1 for stamps on the grid, 0.38 for a standard deviation of 0.22 intervals.
    pub(super) resultant: f64,
    /// Samples missing among the stamps it was found in.
    pub(super) missing: f64,
}

impl Comb {
    /// The grid behind stamps in s; `None` where none stands out.
    pub(super) fn of(stamps: &[f64]) -> Option<Self> {
        Self::within(stamps, RANGE)
    }

    /// The grid whose interval is nearly known.
    pub(super) fn near(stamps: &[f64], interval: f64) -> Option<Self> {
        let n = stamps.len();
        let rows = (stamps.last()? - stamps.first()?) / ((n - 1) as f64 * interval);
        Self::within(stamps, (0.97 * rows, 1.03 * rows))
    }

    /// The line that stands out most between two frequencies in rows per second.
    fn within(stamps: &[f64], range: (f64, f64)) -> Option<Self> {
        let n = stamps.len();
        let (first, last) = (*stamps.first()?, *stamps.last()?);
        let time = last - first;
        let step = time / (n - 1) as f64;
        let bins = BINS.0 * n as f64 + 2.0 * BINS.0;
        if n < LEAST || !(step > 0.0) || bins > BINS.1 as f64 {
            return None;
        }
        let width = step / BINS.0;
        let mut counts = vec![0.0; (2.0 * bins) as usize];
        let length = counts.len().next_power_of_two();
        counts.resize(length, 0.0);
        for t in stamps {
            let bin = ((t - first) / width).round();
            if bin >= 0.0 && bin < bins {
                counts[bin as usize] += 1.0;
            }
        }
        let spectrum = crate::fourier::forward(&counts);
        let per_row = length as f64 / BINS.0;
        let (from, to) = ((range.0 * per_row) as usize, (range.1 * per_row) as usize);
        let (at, _) = spectrum
            .get(from..=to)?
            .iter()
            .map(|s| s.norm_sqr())
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        let mut frequency = (from + at) as f64 / (length as f64 * width);
        // The top of the line, by parabolas through three places that come together.
        let mut apart = 0.25 / time;
        for _ in 0..6 {
            let [a, b, c] = [-1.0, 0.0, 1.0].map(|k| power(stamps, frequency + k * apart));
            let bend = a - 2.0 * b + c;
            if bend < 0.0 {
                frequency += apart * (0.5 * (a - c) / bend).clamp(-1.0, 1.0);
            }
            apart *= 0.5;
        }
        let resultant = power(stamps, frequency).sqrt();
        let looked = (range.1 - range.0) * 2.0 * n as f64;
        if resultant * resultant * (n as f64) < (looked / FALSE).ln() {
            return None;
        }
        // Circular dispersion of the phases, and what successive errors share, as a first-order autoregression.
        let second = power(stamps, 2.0 * frequency).sqrt();
        let dispersion = (1.0 - second).max(0.0) / (2.0 * resultant * resultant);
        let shared = shared(stamps, frequency, resultant);
        let mean = stamps.iter().map(|t| t - first).sum::<f64>() / n as f64;
        let about: f64 = stamps.iter().map(|t| (t - first - mean).powi(2)).sum();
        Some(Self {
            interval: 1.0 / frequency,
            u: (dispersion * (1.0 + shared) / (1.0 - shared)).sqrt()
                / (TAU * about.sqrt() * frequency),
            resultant,
            missing: time * frequency - (n - 1) as f64,
        })
    }
}

/// Correlation of the phases of neighbouring stamps, at least none.
fn shared(stamps: &[f64], frequency: f64, resultant: f64) -> f64 {
    let turns = stamps.windows(2).map(|w| (w[1] - w[0]) * frequency);
    let alike = turns.map(|t| (TAU * (t - t.round())).cos()).sum::<f64>();
    let (alike, own) = (alike / (stamps.len() - 1) as f64, resultant * resultant);
    ((alike - own) / (1.0 - own).max(1e-12)).clamp(0.0, 0.98)
}

/// S² at a frequency.
fn power(stamps: &[f64], frequency: f64) -> f64 {
    let (mut cos, mut sin) = (0.0, 0.0);
    for t in stamps {
        let turns = (t - stamps[0]) * frequency;
        let (s, c) = (TAU * (turns - turns.round())).sin_cos();
        (cos, sin) = (cos + c, sin + s);
    }
    (cos * cos + sin * sin) / (stamps.len() as f64).powi(2)
}

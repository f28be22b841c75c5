//! Where a recording stays at one frequency and amplitude.

use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::fourier;
use std::f64::consts::TAU;

/// A stretch of one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Plateau {
    /// First sample.
    pub from: usize,
    /// The sample after the last.
    pub to: usize,
    /// Hz.
    pub frequency: f64,
    /// Relative change of the frequency from its beginning to its end.
    pub(crate) drift: f64,
}

/// Why a recording has no steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoSteps {
    /// Nothing that goes round and round: periods that follow each other, the longest row of alike ones.
    NoSine {
        /// Periods in all.
        periods: usize,
        /// Longest row of periods that are alike.
        steady: usize,
    },
    /// A sine whose frequency never stays: relative change to a period, in the middle of all.
    Sweep {
        /// Periods in all.
        periods: usize,
        /// Relative change of the frequency from one period to the next.
        rate: f64,
    },
}

/// Periods that make a plateau, before any are left out.
const LEAST: usize = 5;
/// Departure of a period from those before it that ends a row, relative.
const PERIOD: f64 = 0.08;
/// The same of the amplitude.
const AMPLITUDE: f64 = 0.2;
/// Departure of the phase from a straight line that is none, rad.
const BENT: f64 = 0.15;

/// Periods of a signal: instants of equal phase (in samples) and mean amplitude of each period between.
struct Periods {
    at: Vec<f64>,
    amplitude: Vec<f64>,
}

impl Periods {
    /// By the analytic signal of the record less its mean.
    fn of(x: &[f64]) -> Option<Self> {
        let n = x.len();
        let mean = x.iter().sum::<f64>() / n as f64;
        let centred: Vec<f64> = x.iter().map(|v| v - mean).collect();
        let turned = fourier::forward(&centred)
            .iter()
            .map(|z| z * Complex64::new(0.0, -1.0))
            .collect();
        let other = fourier::inverse(turned, n)?;
        let mut periods = Self {
            at: Vec::new(),
            amplitude: Vec::new(),
        };
        let (mut phase, mut before) = (0.0f64, None::<Complex64>);
        let (mut sum, mut count, mut next) = (0.0, 0usize, 0.0);
        for (k, (re, im)) in centred.iter().zip(&other).enumerate() {
            let z = Complex64::new(*re, *im);
            let step = before.map_or(0.0, |b| (z * b.conj()).arg());
            before = Some(z);
            let last = phase;
            phase += step;
            sum += z.norm_sqr();
            count += 1;
            // The first time it comes by: noise may turn it back a little.
            while phase >= next && step > 0.0 {
                if !periods.at.is_empty() {
                    periods.amplitude.push((sum / count.max(1) as f64).sqrt());
                }
                periods.at.push(k as f64 - (phase - next) / (phase - last));
                (sum, count) = (0.0, 0);
                next += TAU;
            }
        }
        (periods.at.len() > 2).then_some(periods)
    }

    fn len(&self) -> usize {
        self.amplitude.len()
    }

    fn period(&self, i: usize) -> f64 {
        self.at[i + 1] - self.at[i]
    }

    /// Rows [from, to) of periods that are like those before them.
    fn rows(&self) -> Vec<[usize; 2]> {
        let mut rows = Vec::new();
        let mut from = 0;
        for i in 1..=self.len() {
            let alike = i < self.len() && {
                let near = from.max(i.saturating_sub(8))..i;
                let count = near.len() as f64;
                let (mut t, mut a) = (0.0, 0.0);
                for k in near {
                    t += self.period(k) / count;
                    a += self.amplitude[k] / count;
                }
                (self.period(i) / t - 1.0).abs() < PERIOD
                    && (self.amplitude[i] / a - 1.0).abs() < AMPLITUDE
            };
            if !alike {
                rows.push([from, i]);
                from = i;
            }
        }
        rows
    }

    /// Straight line through the instants from `a` to `b` (both included): offset at `a`, period, largest and sum of squared
    /// departures (samples).
    fn line(&self, a: usize, b: usize) -> [f64; 4] {
        let n = (b - a + 1) as f64;
        let middle = 0.5 * (n - 1.0);
        let mean = self.at[a..=b].iter().sum::<f64>() / n;
        let (mut above, mut below) = (0.0, 0.0);
        for (k, t) in self.at[a..=b].iter().enumerate() {
            let u = k as f64 - middle;
            above += u * (t - mean);
            below += u * u;
        }
        let period = above / below;
        let offset = mean - period * middle;
        let (mut largest, mut squares) = (0.0f64, 0.0);
        for (k, t) in self.at[a..=b].iter().enumerate() {
            let d = t - offset - period * k as f64;
            largest = largest.max(d.abs());
            squares += d * d;
        }
        [offset, period, largest, squares]
    }

    /// Parts a row where its instants bend, until every part is straight.
    fn straight(&self, [from, to]: [usize; 2], into: &mut Vec<[usize; 2]>) {
        let mut waiting = vec![[from, to]];
        while let Some([a, b]) = waiting.pop() {
            if b - a < LEAST {
                into.push([a, b]);
                continue;
            }
            let [_, period, largest, squares] = self.line(a, b);
            // What noise makes of the instants: second differences have six times its variance.
            let jitter = (a + 1..b)
                .map(|k| (self.at[k - 1] - 2.0 * self.at[k] + self.at[k + 1]).powi(2))
                .sum::<f64>()
                / (6.0 * (b - a - 1) as f64);
            let limit = (BENT / TAU * period).max(5.0 * jitter.sqrt());
            if largest < limit {
                into.push([a, b]);
                continue;
            }
            let parted = self.best_split(a, b);
            match parted {
                Some((k, left)) if left < squares => {
                    // The later part first: the stack gives the earlier one back first.
                    waiting.push([k, b]);
                    waiting.push([a, k]);
                }
                _ => into.push([a, b]),
            }
        }
        into.sort();
    }

    /// The instant at which two straight lines leave least, from running sums.
    fn best_split(&self, a: usize, b: usize) -> Option<(usize, f64)> {
        let n = b - a + 1;
        // Sums of 1, u, u², t, ut, t² up to each instant, about the first.
        let mut sums = vec![[0.0f64; 5]; n + 1];
        for k in 0..n {
            let (u, t) = (k as f64, self.at[a + k] - self.at[a]);
            let s = sums[k];
            sums[k + 1] = [s[0] + u, s[1] + u * u, s[2] + t, s[3] + u * t, s[4] + t * t];
        }
        let left = |i: usize, j: usize| {
            let m = (j - i) as f64;
            let d: [f64; 5] = std::array::from_fn(|q| sums[j][q] - sums[i][q]);
            let uu = d[1] - d[0] * d[0] / m;
            let ut = d[3] - d[0] * d[2] / m;
            let tt = d[4] - d[2] * d[2] / m;
            (tt - ut * ut / uu).max(0.0)
        };
        (3..n.saturating_sub(3))
            .map(|k| (a + k, left(0, k + 1) + left(k, n)))
            .min_by(|p, q| p.1.total_cmp(&q.1))
    }

    /// Relative change of the frequency over a stretch, by the curvature of its instants.
    fn drift(&self, a: usize, b: usize) -> f64 {
        let third = (b - a) / 3;
        if third < 1 {
            return 0.0;
        }
        let early = (self.at[a + third] - self.at[a]) / third as f64;
        let late = (self.at[b] - self.at[b - third]) / third as f64;
        // Between the middles of the outer thirds lie two thirds of it.
        1.5 * (early / late - 1.0)
    }
}

/// The plateaus of a record, in order of time.
pub(super) fn find(x: &[f64], rate: f64) -> Result<Result<Vec<Plateau>, NoSteps>, Error> {
    if x.len() < 64 {
        return Err(Error::TooFew {
            name: "samples",
            needed: 64,
            got: x.len(),
        });
    }
    proofmass_core::check::finite("input", x)?;
    let none = NoSteps::NoSine {
        periods: 0,
        steady: 0,
    };
    let Some(periods) = Periods::of(x) else {
        return Ok(Err(none));
    };
    let rows = periods.rows();
    let steady = rows.iter().map(|[a, b]| b - a).max().unwrap_or(0);
    let mut parts = Vec::new();
    for row in &rows {
        periods.straight(*row, &mut parts);
    }
    let plateaus: Vec<(usize, usize, Plateau)> = parts
        .into_iter()
        .filter(|[a, b]| b - a >= LEAST)
        .map(|[a, b]| {
            let [offset, period, ..] = periods.line(a, b);
            let from = offset.max(0.0) as usize;
            let to = (offset + period * (b - a) as f64) as usize;
            let plateau = Plateau {
                from,
                to: to.min(x.len()),
                frequency: rate / period,
                drift: periods.drift(a, b),
            };
            (a, b, plateau)
        })
        // Faster than four samples to the period nothing is followed.
        .filter(|(.., p)| p.frequency < 0.25 * rate * (1.0 + 1e-9) && p.to > p.from)
        .collect();
    if sweeps(&plateaus) || (plateaus.is_empty() && steady >= 4 * LEAST) {
        let mut changes: Vec<f64> = (1..periods.len())
            .map(|i| (periods.period(i - 1) / periods.period(i) - 1.0).abs())
            .collect();
        changes.sort_by(f64::total_cmp);
        return Ok(Err(NoSteps::Sweep {
            periods: periods.len(),
            rate: changes.get(changes.len() / 2).copied().unwrap_or(0.0),
        }));
    }
    if plateaus.is_empty() {
        return Ok(Err(NoSteps::NoSine {
            periods: periods.len(),
            steady,
        }));
    }
    Ok(Ok(plateaus.into_iter().map(|p| p.2).collect()))
}

/// Whether stretches that adjoin are cut out of one sweep: each moves by as much as lies between them.
fn sweeps(plateaus: &[(usize, usize, Plateau)]) -> bool {
    let mut moved = Vec::new();
    let mut adjoining = 0;
    for pair in plateaus.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        if b.0 > a.1 + 2 {
            continue;
        }
        adjoining += 1;
        let between = b.2.frequency / a.2.frequency - 1.0;
        if between.abs() > 1e-9 {
            moved.push((0.5 * (a.2.drift + b.2.drift) / between).abs());
        }
    }
    moved.sort_by(f64::total_cmp);
    adjoining >= 3
        && 2 * adjoining >= plateaus.len().saturating_sub(1)
        && moved.get(moved.len() / 2).is_some_and(|m| *m > 0.3)
}

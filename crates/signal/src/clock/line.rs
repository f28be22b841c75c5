//! The straight line through numbered stamps, in stretches, and whether it bends.

use super::settle::median;

/// Steps of a part at first, and parts at most, of which the rate is compared.
const PART: (usize, usize) = (128, 128);

/// Sums of least squares; departures and slopes are in intervals.
#[derive(Debug, Default)]
pub(super) struct Line {
    /// Rows so far.
    pub(super) rows: usize,
    open: bool,
    n: f64,
    x: f64,
    mean_x: f64,
    mean_y: f64,
    last: f64,
    sxx: f64,
    sxy: f64,
    syy: f64,
    steps: f64,
    /// Sums of the steps' departures and their squares.
    step: f64,
    step2: f64,
    parts: Parts,
    blocks: (Blocks<16>, Blocks<64>, Blocks<128>, Blocks<512>),
}

pub(super) struct Fit {
    pub(super) slope: f64,
    pub(super) slope_u: f64,
    pub(super) scatter: f64,
    pub(super) jitter: Option<f64>,
    pub(super) steps: f64,
}

impl Line {
    /// The next row, so many samples after the one before.
    pub(super) fn add(&mut self, samples: i64, y: f64) {
        let row = self.rows;
        self.rows += 1;
        if !self.open {
            self.open = true;
            (self.n, self.x, self.mean_x, self.mean_y, self.last) = (1.0, 0.0, 0.0, y, y);
            let (a, b, c, d) = &mut self.blocks;
            a.begin();
            b.begin();
            c.begin();
            d.begin();
            return;
        }
        let step = y - self.last;
        self.last = y;
        self.steps += 1.0;
        self.step += step;
        self.step2 += step * step;
        self.x += samples as f64;
        self.n += 1.0;
        let (dx, dy) = (self.x - self.mean_x, y - self.mean_y);
        self.mean_x += dx / self.n;
        self.mean_y += dy / self.n;
        self.sxx += dx * (self.x - self.mean_x);
        self.sxy += dx * (y - self.mean_y);
        self.syy += dy * (y - self.mean_y);
        self.parts.add(row, self.x, y);
        let (a, b, c, d) = &mut self.blocks;
        a.add(y);
        b.add(y);
        c.add(y);
        d.add(y);
    }

    /// Share of the samples whose loss would make the stamps wander as they do; 0 where they do not wander.
    ///
    /// Rows lost at random with the chance p are a random walk of variance p per row, in mean steps squared; the difference of the means of
    /// neighbouring blocks of B rows has 2 B/3 times that. It grows with B, where that of errors that do not last shrinks.
    pub(super) fn wander(&self) -> f64 {
        let (a, b, c, d) = &self.blocks;
        let grows = |short: Option<f64>, long: Option<f64>, by: f64| {
            short.is_some_and(|s| long.is_some_and(|l| l > by * s))
        };
        // The errors of busy computers last for tens of rows; over so many as 512 an eighth of the variance is left.
        if !grows(a.variance(), c.variance(), 1.0) && !grows(b.variance(), d.variance(), 0.6) {
            return 0.0;
        }
        let share = |variance: Option<f64>, rows: f64| 1.5 * variance.unwrap_or(0.0) / rows;
        share(b.variance(), 64.0).max(share(c.variance(), 128.0))
    }

    /// What comes has another intercept.
    pub(super) fn close(&mut self) {
        self.open = false;
        self.parts.stretch += 1;
    }

    pub(super) fn fit(&self) -> Option<Fit> {
        let n = self.steps;
        if n == 0.0 {
            return None;
        }
        let slope = if self.sxx > 0.0 {
            self.sxy / self.sxx
        } else {
            self.step / n
        };
        // Samples, less one intercept for each stretch, less the slope.
        let squares = (self.syy - slope * self.sxy).max(0.0);
        let variance = if n > 1.0 { squares / (n - 1.0) } else { 0.0 };
        let steps = (self.step2 - 2.0 * slope * self.step + n * slope * slope).max(0.0) / n;
        let rho = if variance > 0.0 {
            (1.0 - steps / (2.0 * variance)).clamp(0.0, 1.0 - 2.0 / (n + 2.0))
        } else {
            0.0
        };
        let white = if self.sxx > 0.0 {
            variance / self.sxx
        } else {
            0.0
        };
        let mean = self.step / n;
        let jitter =
            (n > 1.0).then(|| ((self.step2 - n * mean * mean).max(0.0) / (n - 1.0)).sqrt());
        Some(Fit {
            slope,
            slope_u: (white * (1.0 + rho) / (1.0 - rho)).sqrt(),
            scatter: variance.sqrt(),
            jitter,
            steps: n,
        })
    }

    /// Row and intervals before and behind it, where two lines describe the last stretch far better than one.
    pub(super) fn bend(&self) -> Option<(usize, f64, f64)> {
        let own = self.parts.done.last()?.stretch;
        let line: Vec<&Part> = self
            .parts
            .done
            .iter()
            .filter(|p| p.stretch == own)
            .collect();
        let (at, a, b, u) = bend(&line)?;
        ((b - a).abs() > (8.0 * u).max(1e-4)).then(|| (line[at].row, 1.0 + a, 1.0 + b))
    }
}

/// Mean of a part of the record that lies in one stretch.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    row: usize,
    stretch: usize,
    n: f64,
    x: f64,
    y: f64,
}

/// The record in at most 128 parts of equal numbers of rows.
#[derive(Debug, Default)]
struct Parts {
    stretch: usize,
    doublings: u32,
    rows: usize,
    now: Part,
    done: Vec<Part>,
}

impl Parts {
    fn add(&mut self, row: usize, x: f64, y: f64) {
        if self.rows == 0 {
            self.now = Part {
                row,
                stretch: self.stretch,
                ..Part::default()
            };
        }
        self.rows += 1;
        let part = &mut self.now;
        if part.stretch == self.stretch {
            part.n += 1.0;
            part.x += (x - part.x) / part.n;
            part.y += (y - part.y) / part.n;
        }
        if self.rows == PART.0 << self.doublings {
            self.rows = 0;
            self.done.push(self.now);
            if self.done.len() == PART.1 {
                self.doublings += 1;
                self.done = self.done.chunks(2).map(|p| p[0].with(&p[1])).collect();
            }
        }
    }
}

impl Part {
    fn with(&self, next: &Self) -> Self {
        let mut both = *self;
        if self.stretch == next.stretch {
            both.n = self.n + next.n;
            both.x = (self.n * self.x + next.n * next.x) / both.n;
            both.y = (self.n * self.y + next.n * next.y) / both.n;
        }
        both
    }
}

/// Differences of the means of neighbouring blocks of rows.
#[derive(Debug, Default)]
struct Blocks<const ROWS: usize> {
    rows: usize,
    sum: f64,
    before: Option<f64>,
    n: f64,
    mean: f64,
    squares: f64,
}

impl<const ROWS: usize> Blocks<ROWS> {
    fn begin(&mut self) {
        (self.rows, self.sum, self.before) = (0, 0.0, None);
    }

    fn add(&mut self, y: f64) {
        self.rows += 1;
        self.sum += y;
        if self.rows < ROWS {
            return;
        }
        let mean = self.sum / ROWS as f64;
        if let Some(before) = self.before {
            let d = mean - before;
            self.n += 1.0;
            let off = d - self.mean;
            self.mean += off / self.n;
            self.squares += off * (d - self.mean);
        }
        (self.rows, self.sum, self.before) = (0, 0.0, Some(mean));
    }

    /// Variance of the differences; `None` below five.
    fn variance(&self) -> Option<f64> {
        (self.n >= 5.0).then(|| self.squares / (self.n - 1.0))
    }
}

/// What a step is like, in at most 128 parts of the record.
#[derive(Debug, Default)]
pub(super) struct Steps {
    rows: usize,
    doublings: u32,
    now: Vec<f64>,
    /// First row of a part and its steps.
    done: Vec<(usize, f64)>,
}

impl Steps {
    /// A step in intervals.
    pub(super) fn add(&mut self, step: f64) {
        self.rows += 1;
        self.now.push(step);
        if self.now.len() < PART.0 << self.doublings {
            return;
        }
        let middle = median(&mut self.now);
        // The mean of the steps like most: rounding leaves their median where it was.
        let like = self
            .now
            .iter()
            .filter(|s| (**s - middle).abs() <= 0.3 * middle);
        let (sum, n) = like.fold((0.0, 0.0), |(sum, n), s| (sum + s, n + 1.0));
        let mean = if 2.0 * n > self.now.len() as f64 {
            sum / n
        } else {
            f64::NAN
        };
        self.done.push((self.rows - self.now.len(), mean));
        self.now.clear();
        if self.done.len() == PART.1 {
            self.doublings += 1;
            let both = |p: &[(usize, f64)]| (p[0].0, 0.5 * (p[0].1 + p[1].1));
            self.done = self.done.chunks(2).map(both).collect();
        }
    }

    /// Row and intervals before and behind it, where steps are of two kinds.
    pub(super) fn change(&self) -> Option<(usize, f64, f64)> {
        let steps: Vec<f64> = self.done.iter().map(|p| p.1).collect();
        if steps.len() < 6 || steps.iter().any(|s| s.is_nan()) {
            return None;
        }
        let (at, a, b, u) = best_split(&steps)?;
        ((b - a).abs() > (8.0 * u).max(3e-3 * a.min(b))).then(|| (self.done[at].0, a, b))
    }
}

/// Place, level before, level behind, and standard uncertainty of their difference.
fn best_split(values: &[f64]) -> Option<(usize, f64, f64, f64)> {
    let n = values.len();
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let squares = |v: &[f64], m: f64| v.iter().map(|x| (x - m).powi(2)).sum::<f64>();
    let split = |at: usize| {
        let (a, b) = values.split_at(at);
        let (ma, mb) = (mean(a), mean(b));
        (at, ma, mb, squares(a, ma) + squares(b, mb))
    };
    let (at, a, b, left) = (2..n - 1).map(split).min_by(|x, y| x.3.total_cmp(&y.3))?;
    let variance = left / (n - 2) as f64;
    let u = (variance * (1.0 / at as f64 + 1.0 / (n - at) as f64)).sqrt();
    Some((at, a, b, u))
}

/// Place, slope before, slope behind, and standard uncertainty of their difference: a line with one bend through the means of the parts.
fn bend(parts: &[&Part]) -> Option<(usize, f64, f64, f64)> {
    let n = parts.len();
    if n < 12 {
        return None;
    }
    let line = |p: &[&Part]| {
        let n = p.len() as f64;
        let (mx, my) = (
            p.iter().map(|p| p.x).sum::<f64>() / n,
            p.iter().map(|p| p.y).sum::<f64>() / n,
        );
        let sum = |f: &dyn Fn(&Part) -> f64| p.iter().map(|p| f(p)).sum::<f64>();
        let sxx = sum(&|p| (p.x - mx).powi(2));
        let slope = sum(&|p| (p.x - mx) * (p.y - my)) / sxx;
        let left = sum(&|p| (p.y - my - slope * (p.x - mx)).powi(2));
        (slope, left, sxx)
    };
    let split = |at: usize| {
        let (a, b) = (line(&parts[..at]), line(&parts[at..]));
        (at, a, b, a.1 + b.1)
    };
    let (at, a, b, left) = (4..n - 3).map(split).min_by(|x, y| x.3.total_cmp(&y.3))?;
    let variance = left / (n - 4) as f64;
    let u = (variance * (1.0 / a.2 + 1.0 / b.2)).sqrt();
    Some((at, a.0, b.0, u))
}

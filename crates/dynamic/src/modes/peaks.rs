//! Peaks of a modulus at every width: means of |H|² over so many lines, the greatest of which stand above their valleys.

use proofmass_signal::transfer::ResponseEstimate;

/// By how much of the lower one the modulus rises from the higher valley to the top: the peak of ζ = 0.3 rises by three quarters.
const LEAST_RISE: f64 = 0.2;
/// Standard uncertainties by which a peak stands above its valley: where half of its modulus is passed is known then.
const ABOVE: f64 = 10.0;
/// Lines to either side of a peak that are fitted at least; before a higher peak.
const LEAST_SIDE: [usize; 2] = [8, 4];

/// One peak: its line, and the first and last line that belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peak {
    pub line: usize,
    pub from: usize,
    pub to: usize,
}

/// |H|² less what its noise adds, by lines.
pub(super) struct Curve {
    power: Vec<f64>,
    /// Variance of |H|² of a line.
    spread: Vec<f64>,
    /// Variance of either part of H, of some neighbours together, without the leakage.
    pub variance: Vec<f64>,
    /// Distance of lines, Hz.
    pub step: f64,
    every: f64,
}

impl Curve {
    /// `pooled`: degrees of freedom that a variance is to have.
    pub fn of(response: &ResponseEstimate, pooled: f64) -> Self {
        let n = response.lines();
        let single: Vec<f64> = (0..n)
            .map(|k| {
                let [rr, _, ii] = response.covariance[k];
                let leakage = response.leakage.get(k).map_or(0.0, |b| b.norm_sqr());
                (0.5 * (rr + ii - leakage))
                    .max(1e-9 * (rr + ii))
                    .max(f64::MIN_POSITIVE)
            })
            .collect();
        let dof = response.dof.iter().copied().fold(f64::INFINITY, f64::min);
        let aside = match dof.is_finite() {
            true => (pooled / dof.max(1.0)).ceil() as usize,
            false => 0,
        };
        let variance = means(&single, aside);
        let squares: Vec<f64> = response.value.iter().map(|h| h.norm_sqr()).collect();
        let spread = (0..n).map(|k| 4.0 * variance[k] * (squares[k] + variance[k]));
        Self {
            power: (0..n).map(|k| squares[k] - 2.0 * variance[k]).collect(),
            spread: spread.collect(),
            step: match response.frequency.as_slice() {
                [first, .., last] => (last - first) / (n - 1) as f64,
                _ => 0.0,
            },
            every: response.independent_every.max(1) as f64,
            variance,
        }
    }

    /// Peaks at every width, the narrowest means first; one peak may come several times.
    pub fn peaks(&self) -> Vec<Peak> {
        let n = self.power.len();
        let mut found = Vec::new();
        let mut aside = 0;
        while 8 * aside + 4 <= n {
            let mean = means(&self.power, aside);
            let spread = means(&self.spread, aside);
            // Of the lines that a mean is taken over so many are independent.
            let readings = ((2 * aside + 1) as f64 / self.every).max(1.0);
            let around = (2 * aside).max(3);
            for k in 1..n.saturating_sub(1) {
                let near = k.saturating_sub(around)..(k + around + 1).min(n);
                if !(mean[k] > 0.0) || near.clone().any(|i| mean[i] > mean[k]) {
                    continue;
                }
                let valley = valley(&mean, k);
                let sigma = (spread[k] / readings).sqrt();
                if mean[k] - valley > ABOVE * sigma && is_higher(mean[k], valley) {
                    found.extend(self.window(&mean, k));
                }
            }
            aside = (2 * aside).max(1);
        }
        found.dedup();
        found
    }

    /// The lines of a peak: down to half of its modulus, or to the valley before a higher one.
    fn window(&self, mean: &[f64], k: usize) -> Option<Peak> {
        let n = mean.len();
        let side = |lines: &mut dyn Iterator<Item = usize>| {
            let (mut edge, mut lowest) = (k, k);
            for i in lines {
                if mean[i] > mean[k] {
                    return (lowest, LEAST_SIDE[1]);
                }
                edge = i;
                if mean[i] < mean[lowest] {
                    lowest = i;
                }
                if mean[i] < 0.25 * mean[k] {
                    break;
                }
            }
            (edge, LEAST_SIDE[0])
        };
        let (from, least) = side(&mut (0..k).rev());
        let from = from.min(k.saturating_sub(least));
        let (to, least) = side(&mut (k + 1..n));
        let to = to.max((k + least).min(n - 1));
        (to - from >= 5).then_some(Peak { line: k, from, to })
    }

    /// Whether the modulus falls to either side of an oscillator's peak within three of its half widths: the flank of a filter does not.
    pub fn rises(&self, response: &ResponseEstimate, frequency: f64, damping: f64) -> bool {
        let top = frequency * (1.0 - 2.0 * damping * damping).max(0.0).sqrt();
        let half = damping * frequency / self.step.max(f64::MIN_POSITIVE);
        let mean = means(&self.power, (0.2 * half) as usize);
        let f = &response.frequency;
        let reach = (3.0 * damping * frequency).max(4.0 * self.step);
        let lowest = |from: f64, to: f64| {
            let inside = (0..f.len()).filter(|k| (from..=to).contains(&f[*k]));
            inside.map(|k| mean[k]).min_by(f64::total_cmp)
        };
        let apart = |k: &usize| (f[*k] - top).abs();
        let nearest = (0..f.len()).min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let sides = [lowest(top - reach, top), lowest(top, top + reach)];
        let [Some(below), Some(above)] = sides else {
            return false;
        };
        nearest.is_some_and(|k| is_higher(mean[k], below.max(above)))
    }
}

fn is_higher(top: f64, valley: f64) -> bool {
    top > (1.0 + LEAST_RISE).powi(2) * valley.max(0.0)
}

/// The higher of the lowest values on both sides, each up to where the curve is higher than here.
fn valley(mean: &[f64], k: usize) -> f64 {
    let lowest = |values: &mut dyn Iterator<Item = &f64>| {
        let until = values.take_while(|v| **v <= mean[k]);
        until.copied().fold(mean[k], f64::min)
    };
    lowest(&mut mean[..k].iter().rev()).max(lowest(&mut mean[k + 1..].iter()))
}

/// Means over so many neighbours to either side, of fewer at the ends.
fn means(values: &[f64], aside: usize) -> Vec<f64> {
    if aside == 0 {
        return values.to_vec();
    }
    let n = values.len();
    let mut sums = vec![0.0; n + 1];
    for (k, v) in values.iter().enumerate() {
        sums[k + 1] = sums[k] + v;
    }
    let mean = |k: usize| {
        let (from, to) = (k.saturating_sub(aside), (k + aside + 1).min(n));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    (0..n).map(mean).collect()
}

//! Are the innovations what the noise lets expect?

use proofmass_uncertainty::{chi_squared_quantile, normal_quantile};

/// Probability of each kind of finding on a healthy recording, over the three axes together.
const FALSE_ALARMS: f64 = 1e-3;
/// Ratio of standard deviations from which a departure matters.
const EFFECT: f64 = 1.25;
/// Correlation from which a departure matters.
const CORRELATION: f64 = 0.1;
/// Fewest innovations of which a correlation is sought.
const FEWEST: usize = 20;
/// Lags of the test of whiteness at most.
const LAGS: usize = 10;

/// Innovations of one axis against their stated variance.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Consistency {
    /// Root of the mean square of the normalised innovations, one for a filter whose noise is right; rests that deviate left
    /// out.
    pub ratio: f64,
    /// What it stays within on a healthy recording, but for one in three thousand.
    pub limits: [f64; 2],
    /// Innovations.
    pub updates: usize,
    /// Correlation at lag 1, 2, …; empty for fewer than twenty innovations.
    pub correlation: Vec<f64>,
    /// Ljung–Box statistic of these lags, and its limit.
    pub whiteness: Option<[f64; 2]>,
    /// Rests that the noise does not explain.
    pub deviating: Vec<DeviatingRest>,
}

/// A rest whose means lie too far from what was predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DeviatingRest {
    /// Which one.
    pub rest: usize,
    /// Largest innovation in it, m/s².
    pub innovation: f64,
    /// The same over its standard deviation.
    pub normalised: f64,
}

impl Consistency {
    pub(super) fn new(innovations: &[f64], normalised: &[f64], rest: &[usize]) -> Self {
        let m = normalised.len();
        let limit = normal_quantile(1.0 - FALSE_ALARMS / (6.0 * m.max(1) as f64));
        let mut deviating: Vec<DeviatingRest> = Vec::new();
        let mut kept = Vec::with_capacity(m);
        for ((z, value), rest) in normalised.iter().zip(innovations).zip(rest) {
            if z.abs() <= limit {
                kept.push(*z);
                continue;
            }
            let found = DeviatingRest {
                rest: *rest,
                innovation: *value,
                normalised: *z,
            };
            match deviating.last_mut() {
                Some(last) if last.rest == *rest => {
                    if z.abs() > last.normalised.abs() {
                        *last = found;
                    }
                }
                _ => deviating.push(found),
            }
        }
        let n = kept.len();
        let square: f64 = kept.iter().map(|z| z * z).sum();
        let nu = n.max(1) as f64;
        let bound = |p: f64| (chi_squared_quantile(p, nu) / nu).sqrt();
        let lags = if n >= FEWEST { LAGS.min(n / 5) } else { 0 };
        let correlation: Vec<f64> = (1..=lags)
            .map(|k| {
                let sum: f64 = kept.iter().zip(&kept[k..]).map(|(a, b)| a * b).sum();
                sum / square
            })
            .collect();
        let whiteness = (lags > 0).then(|| {
            let parts = correlation.iter().zip(1..);
            let sum: f64 = parts.map(|(r, k)| r * r / (nu - f64::from(k))).sum();
            [
                nu * (nu + 2.0) * sum,
                chi_squared_quantile(1.0 - FALSE_ALARMS / 3.0, lags as f64),
            ]
        });
        Self {
            ratio: (square / nu).sqrt(),
            limits: [bound(FALSE_ALARMS / 6.0), bound(1.0 - FALSE_ALARMS / 6.0)],
            updates: m,
            correlation,
            whiteness,
            deviating,
        }
    }

    /// Ratio, where it departs by chance and by size.
    pub(super) fn departure(&self) -> Option<f64> {
        let [low, high] = self.limits;
        let significant = self.ratio < low || self.ratio > high;
        let matters = self.ratio > EFFECT || self.ratio < 1.0 / EFFECT;
        (self.updates > self.deviating.len() && significant && matters).then_some(self.ratio)
    }

    /// The largest correlation, where innovations are not white.
    pub(super) fn coloured(&self) -> Option<f64> {
        let [statistic, limit] = self.whiteness?;
        let largest = self
            .correlation
            .iter()
            .fold(0.0f64, |a, r| if r.abs() > a.abs() { *r } else { a });
        (statistic > limit && largest.abs() > CORRELATION).then_some(largest)
    }
}

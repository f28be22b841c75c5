//! A coefficient of the noise over the temperature, from several recordings.

use crate::profile::square_level;
use crate::unit_comparison::{Parabolas, minimum};
use crate::{CoefficientFit, Term};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// A straight line of a coefficient over the temperature.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TermSlope {
    /// Which coefficient.
    pub term: Term,
    /// Unit of the coefficient; the slope is in it per kelvin.
    pub unit: String,
    /// Mean temperature of the recordings, °C.
    pub temperature: f64,
    /// Value there.
    pub value: f64,
    /// Change per kelvin.
    pub slope: f64,
    /// Its interval, at the probability of the fits.
    pub interval: (f64, f64),
    /// Rise of −2 ln L from every recording at its own best value to the line.
    pub statistic: f64,
    /// Recordings less two.
    pub freedom: usize,
    /// Probability of such a rise by chance where a line is right; `None` of two recordings.
    pub chance: Option<f64>,
}

/// The line of a coefficient over the temperatures of the recordings, °C, by the parabolas through the ends of their intervals.
///
/// −2 ln L = Σ r_i(a + s (T_i − T̄)) is least over both; the interval of s is where it has risen, at its best over a, by the level of the
/// intervals themselves. A recording that tells only a limit does not take part.
///
/// `None` for fewer than two temperatures, or where fewer than two recordings have an interval of the coefficient.
///
/// **Accuracy** `coverage_of_the_slope_of_white_noise`. **Source** as [`equal_coefficients`](crate::equal_coefficients).
pub fn slope_over_temperature(term: Term, fits: &[(&CoefficientFit, f64)]) -> Option<TermSlope> {
    let first = fits.first()?.0.get(term)?;
    let chi = |freedom: usize| ChiSquared::new(freedom as f64).ok();
    let quantile = |p: f64| match term {
        Term::Ramp => chi(1).map(|c| c.inverse_cdf(p)),
        _ => Some(square_level(p)),
    };
    let known: Vec<(Parabolas, f64)> = fits
        .iter()
        .filter_map(|(fit, t)| {
            let verdict = fit.get(term)?.verdict;
            // A limit alone says nothing of a slope.
            verdict.interval()?;
            Some((
                Parabolas::of(&verdict, term, quantile(fit.probability)?)?,
                *t,
            ))
        })
        .collect();
    if known.len() < 2 {
        return None;
    }
    let mean = known.iter().map(|(_, t)| t).sum::<f64>() / known.len() as f64;
    let ends = known
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], (_, t)| {
            [a.min(*t), b.max(*t)]
        });
    let span = ends[1] - ends[0];
    if !(span > 0.0) {
        return None;
    }
    let rise = |value: f64, slope: f64| -> f64 {
        known
            .iter()
            .map(|(p, t)| p.rise(value + slope * (t - mean)))
            .sum()
    };
    // Both sums are convex: golden sections between the values that single recordings would have.
    let value_at = |slope: f64| {
        let [low, high] =
            known
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], (p, t)| {
                    let own = p.best - slope * (t - mean);
                    [a.min(own), b.max(own)]
                });
        minimum(&|v| rise(v, slope), low, high, 70)
    };
    let least = |slope: f64| rise(value_at(slope), slope);
    let reach = known
        .iter()
        .map(|(p, _)| p.best.abs() + p.below + p.above)
        .fold(0.0, f64::max);
    // No two recordings are nearer to each other than tells their own line.
    let steepest = known
        .iter()
        .flat_map(|(_, a)| known.iter().map(move |(_, b)| (a - b).abs()));
    let nearest = steepest.filter(|d| *d > 0.0).fold(span, f64::min);
    let most = 2.0 * reach / nearest;
    let slope = minimum(&least, -most, most, 90);
    let statistic = least(slope);
    let allowed = statistic + quantile(fits.first()?.0.probability)?;
    let end = |direction: f64| {
        let mut step = reach / span;
        while least(slope + direction * step) < allowed && step.is_finite() {
            step *= 2.0;
        }
        let (mut inside, mut outside) = (0.0, step);
        for _ in 0..50 {
            let middle = 0.5 * (inside + outside);
            match least(slope + direction * middle) < allowed {
                true => inside = middle,
                false => outside = middle,
            }
        }
        slope + direction * inside
    };
    let freedom = known.len() - 2;
    let chance = match freedom {
        0 => None,
        n => Some(1.0 - chi(n)?.cdf(statistic)),
    };
    Some(TermSlope {
        term,
        unit: first.unit.clone(),
        temperature: mean,
        value: value_at(slope),
        slope,
        interval: (end(-1.0), end(1.0)),
        statistic,
        freedom,
        chance,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FitOptions, NoiseModel, simulate, whittle};
    use rand::SeedableRng;

    fn fits(at: &[f64], slope: f64, seed: u64) -> Vec<CoefficientFit> {
        let options = FitOptions {
            courses: false,
            ..FitOptions::default()
        };
        let one = |(k, t): (usize, &f64)| {
            let noise = NoiseModel {
                white: 1.0 + slope * (t - 20.0),
                ..NoiseModel::default()
            };
            let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(100 * seed + k as u64);
            let record = simulate(&noise, 3000, 50.0, &mut rng).unwrap();
            whittle(&record, 50.0, &options).unwrap()
        };
        at.iter().enumerate().map(one).collect()
    }

    fn line(term: Term, at: &[f64], slope: f64, seed: u64) -> TermSlope {
        let fits = fits(at, slope, seed);
        let with: Vec<(&CoefficientFit, f64)> = fits.iter().zip(at.iter().copied()).collect();
        slope_over_temperature(term, &with).unwrap()
    }

    /// N grows by 0.3 % of its value at 20 °C per kelvin; or not at all.
    #[test]
    fn coverage_of_the_slope_of_white_noise() {
        let at = [-20.0, 20.0, 40.0, 70.0];
        let (mut held, mut told, mut bad) = (0, 0, 0);
        for seed in 0..12 {
            for truth in [3e-3, 0.0] {
                let l = line(Term::White, &at, truth, seed);
                held += usize::from(l.interval.0 <= truth && truth <= l.interval.1);
                told += usize::from(truth > 0.0 && l.interval.0 > 0.0);
                bad += usize::from(l.chance.unwrap() < 0.01);
            }
        }
        // 24 intervals that hold 97 % and more.
        assert!(held >= 22, "{held}");
        assert!(told >= 11 && bad <= 2, "{told} {bad}");
    }

    /// A least-squares line by hand: equal recordings of two temperatures give the difference over them.
    #[test]
    fn known_line_through_two_recordings() {
        let at = [0.0, 50.0];
        let fits = fits(&at, 2e-3, 9);
        let with: Vec<(&CoefficientFit, f64)> = fits.iter().zip(at.iter().copied()).collect();
        let l = slope_over_temperature(Term::White, &with).unwrap();
        let best: Vec<f64> = fits
            .iter()
            .map(|f| f.get(Term::White).unwrap().verdict.estimate().unwrap())
            .collect();
        assert!((l.slope - (best[1] - best[0]) / 50.0).abs() < 1e-7, "{l:?}");
        assert!(l.statistic < 1e-9 && l.chance.is_none());
        assert!(slope_over_temperature(Term::White, &with[..1]).is_none());
        let same: Vec<(&CoefficientFit, f64)> = fits.iter().map(|f| (f, 20.0)).collect();
        assert!(slope_over_temperature(Term::White, &same).is_none());
    }
}

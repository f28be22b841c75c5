//! What a record will say of a coefficient, before it is recorded.

use crate::cosine_spectrum::{CosineSpectrum, pair};
use crate::profile::{Fitted, slope_level, square_level};
use crate::quick_fit::POWERS;
use crate::record::check_sample_rate;
use crate::term_density::{Process, column};
use crate::variance_fit::Likelihood;
use crate::whittle::widened;
use crate::{NoiseModel, Term};
use proofmass_core::{Error, check};
use proofmass_uncertainty::normal_quantile;

/// The interval of a coefficient that a record lets expect.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ExpectedInterval {
    /// Most likely value.
    pub value: f64,
    /// Lower end; zero where the record will not tell the term from zero.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Standard deviation of the most likely value from record to record.
    pub scatter: f64,
}

/// Fewest samples of which an interval is expected: those from which coefficients are estimated.
pub const FEWEST_SAMPLES: usize = 64;

/// Upper limit of the excess kurtosis of n Gaussian samples, times √n, in five of six records: three standard deviations √(2 · 96/n) of
/// the mean fourth power of their differences, twice that for the samples themselves.
const KURTOSIS_LIMIT: f64 = 83.14;

/// Fewest samples that are planned.
const FEWEST_PLANNED: usize = 1000;

/// Length that is planned over that whose expected interval suffices: what is sought beside the terms (band, front end, courses) takes
/// its part of records at times (`cargo run --release -p proofmass-jobs --example device_plan_map`).
const SOUGHT_BESIDE: usize = 2;

/// The interval of a coefficient that [`whittle()`](crate::whittle()) will give of a record of a noise that is known.
///
/// The same likelihood, of a record whose squared cosines are what the noise lets expect of them (the "Asimov" data set of
/// `[Cowan2011]`): its interval is the median of those of records, ends at zero and terms that take each other's place included.
/// The scatter is the distance to the upper end over the square root of the rise of −2 ln L there.
///
/// **Units** those of [`NoiseModel`]; `samples` at `sample_rate` in Hz.
///
/// **Assumes** white noise in `noise`; no front end, no courses, no gaps. Gauss–Markov processes and sinusoids of `noise` are left out.
///
/// **Errors** [`Error::TooFew`] below 64 samples, [`Error::OutOfRange`] for noise without N, a probability or a rate;
/// [`Error::NotConverged`] where the likelihood has no least point; [`Error::Unobservable`] for a term other than Q, N, B, K and R.
///
/// **Accuracy** `crosscheck_intervals_are_those_of_simulated_records`: the upper end within 0.6 of the half width of the median of simulated
/// records.
///
/// **Source** `[Cowan2011]` 3.2; likelihood as [`whittle()`](crate::whittle()).
pub fn expected_interval(
    noise: &NoiseModel,
    term: Term,
    samples: usize,
    sample_rate: f64,
    probability: f64,
) -> Result<ExpectedInterval, Error> {
    check_sample_rate(sample_rate)?;
    check::positive("white noise", noise.white)?;
    if samples < FEWEST_SAMPLES {
        return Err(Error::TooFew {
            name: "samples",
            needed: FEWEST_SAMPLES,
            got: samples,
        });
    }
    let unfit = || Error::NotConverged {
        name: "noise likelihood",
        iterations: 0,
        step: 0.0,
    };
    let spectrum = CosineSpectrum::of_length(samples, sample_rate);
    let columns = POWERS
        .iter()
        .map(|t| column(&spectrum, Process::Power(*t), 1))
        .collect();
    let mut likelihood = Likelihood::new(&spectrum, columns);
    let squares = [
        noise.quantisation,
        noise.white,
        noise.flicker,
        noise.random_walk,
    ]
    .map(|c| c * c);
    let density = likelihood.density(&squares).ok_or_else(unfit)?;
    for (i, s) in density.iter().enumerate() {
        let ramp = likelihood.products[pair(1, 1)][i];
        likelihood.products[pair(0, 0)][i] = s + noise.ramp.powi(2) * ramp;
        likelihood.products[pair(1, 0)][i] = noise.ramp * ramp;
    }
    let walk = POWERS.iter().position(|t| *t == Term::RandomWalk);
    let fitted = Fitted::new(likelihood, vec![None; POWERS.len()], walk).ok_or_else(unfit)?;
    match POWERS.iter().position(|t| *t == term) {
        Some(j) => {
            let level = square_level(probability);
            let mut profile = fitted.square(j, level);
            let scatter = (profile.interval.1.sqrt() - profile.best.sqrt()) / level.sqrt();
            if term == Term::White {
                // What the fourth powers of Gaussian samples leave open of heavy tails.
                let n = samples as f64;
                let tails = widened(&profile, level, KURTOSIS_LIMIT / n.sqrt() / n);
                profile = fitted.square(j, level * tails);
            }
            let [value, low, high] =
                [profile.best, profile.interval.0, profile.interval.1].map(|s| s.max(0.0).sqrt());
            Ok(ExpectedInterval {
                value,
                low,
                high,
                scatter,
            })
        }
        None if term == Term::Ramp => {
            let level = slope_level(probability);
            let profile = fitted.first(level, true).ok_or_else(unfit)?;
            let (low, high) = profile.interval;
            Ok(ExpectedInterval {
                value: profile.best,
                low,
                high,
                scatter: (high - profile.best) / level.sqrt(),
            })
        }
        None => Err(Error::Unobservable {
            parameter: "size of a process that a plan does not know",
            condition: f64::INFINITY,
        }),
    }
}

/// The fewest samples after which a device with this noise is told to be within a limit, the interval `r` times as wide as its guard
/// band, in a share of `decided` of all records; a thousand at least, and `None` where `most` samples do not suffice.
///
/// **Units** `limit` that of the coefficient.
///
/// # Errors
/// As [`expected_interval`].
pub fn samples_for_limit(
    noise: &NoiseModel,
    term: Term,
    limit: f64,
    sample_rate: f64,
    asked: &AskedOfRecord,
) -> Result<Option<usize>, Error> {
    let normal = normal_quantile(asked.decided);
    let suffices = |samples: usize| -> Result<bool, Error> {
        let known = samples / SOUGHT_BESIDE;
        let e = expected_interval(noise, term, known, sample_rate, asked.probability)?;
        // Of a ramp the end that lies further from zero counts.
        let (value, end) = match term.is_signed() {
            true => (e.value.abs(), e.high.abs().max(e.low.abs())),
            false => (e.value, e.high),
        };
        Ok(value + asked.r * (end - value) + normal * e.scatter <= limit)
    };
    let mut high = FEWEST_PLANNED;
    while !suffices(high)? {
        if high >= asked.most {
            return Ok(None);
        }
        high = (2 * high).min(asked.most);
    }
    let mut low = (high / 2).max(FEWEST_PLANNED);
    // To two per cent.
    while high > low + low / 50 {
        let middle = low + (high - low) / 2;
        match suffices(middle)? {
            true => high = middle,
            false => low = middle,
        }
    }
    Ok(Some(high))
}

/// What is asked of a record: the decision rule, and how often it is to decide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AskedOfRecord {
    /// Share of the records that are to be decided.
    pub decided: f64,
    /// Width of the guard band in units of the interval.
    pub r: f64,
    /// Probability of the intervals.
    pub probability: f64,
    /// Most samples.
    pub most: usize,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FitOptions, Verdict, simulate, whittle};
    use rand::SeedableRng;

    /// Of white noise alone every cosine tells as much: u(N²)/N² = √(2/n), u(N)/N = 1/√(2n). Beside Q, B and K, none of
    /// which can be negative, the interval may be wider, not narrower.
    #[test]
    fn published_interval_of_white_noise() {
        let noise = NoiseModel {
            white: 2.0,
            ..NoiseModel::default()
        };
        for n in [2_000, 200_000] {
            let e = expected_interval(&noise, Term::White, n, 50.0, 0.95).unwrap();
            let u = 2.0 / (2.0 * n as f64).sqrt();
            // The ends rise by 1.2 χ²: √4.61 = 2.147; heavy tails that n samples do not exclude add 83/√n to 2.
            let tails = (1.0 + 0.5 * 83.14 / (n as f64).sqrt()).sqrt();
            let ratio = (e.high - e.value) / (2.147 * u * tails);
            assert!((0.85..1.4).contains(&ratio), "{n}: {ratio}");
            assert!((e.value / 2.0 - 1.0).abs() < 1e-3, "{e:?}");
        }
    }

    /// The median of the ends of simulated records.
    #[test]
    fn crosscheck_intervals_are_those_of_simulated_records() {
        let noise = NoiseModel {
            white: 1.0,
            random_walk: 0.02,
            ..NoiseModel::default()
        };
        let (n, rate) = (20_000, 10.0);
        let options = FitOptions {
            highest_frequency: Some(5.0),
            courses: false,
            ..FitOptions::default()
        };
        let mut ends: [Vec<f64>; 2] = Default::default();
        let mut best: [Vec<f64>; 2] = Default::default();
        let terms = [Term::White, Term::RandomWalk];
        for seed in 0..10 {
            let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
            let record = simulate(&noise, n, rate, &mut rng).unwrap();
            let fit = whittle(&record, rate, &options).unwrap();
            for (k, term) in terms.into_iter().enumerate() {
                let verdict: Verdict = fit.get(term).unwrap().verdict;
                ends[k].extend(verdict.upper());
                best[k].extend(verdict.estimate());
            }
        }
        for (k, term) in terms.into_iter().enumerate() {
            let e = expected_interval(&noise, term, n, rate, 0.95).unwrap();
            ends[k].sort_by(f64::total_cmp);
            let median = ends[k][5];
            let scatter = {
                let all = &best[k];
                let mean = all.iter().sum::<f64>() / all.len() as f64;
                let squares = all.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
                (squares / (all.len() - 1) as f64).sqrt()
            };
            // Ten records: the median of the ends scatters by 1.25/√10 of their own scatter, which is that of the values.
            let bound = 0.6 * (e.high - e.value);
            assert!((median - e.high).abs() < bound, "{term:?} {median} {e:?}");
            // A standard deviation of ten is good to 24 %; N scatters by more than its upper side where Q comes out above zero.
            let ratio = scatter / e.scatter;
            assert!((0.3..2.2).contains(&ratio), "{term:?} {ratio}");
        }
    }

    #[test]
    fn law_the_record_for_a_limit_is_the_shortest_that_suffices() {
        let noise = NoiseModel {
            white: 1.0,
            ..NoiseModel::default()
        };
        let asked = AskedOfRecord {
            decided: 0.9,
            r: 1.0,
            probability: 0.95,
            most: 1 << 30,
        };
        let n = samples_for_limit(&noise, Term::White, 1.05, 100.0, &asked)
            .unwrap()
            .unwrap();
        let suffices = |n: usize| {
            let e = expected_interval(&noise, Term::White, n / 2, 100.0, 0.95).unwrap();
            e.high + 1.281_55 * e.scatter <= 1.05
        };
        assert!(suffices(n) && !suffices(n - n / 25), "{n}");
        // At the limit itself no record suffices.
        let never = samples_for_limit(&noise, Term::White, 1.0, 100.0, &asked).unwrap();
        assert_eq!(never, None);
    }
}

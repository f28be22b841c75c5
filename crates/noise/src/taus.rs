//! Which averaging times are computed.

use crate::Statistic;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Choice of averaging times τ = m τ0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Taus {
    /// m = 1, 2, 4, 8, …
    Octave,
    /// m = 1, 2, 4, 10, 20, 40, 100, …
    Decade,
    /// Every m. The work grows with the square of the record.
    All,
    /// Logarithmically even, this many per decade (one for zero), rounded to whole m.
    PerDecade(usize),
    /// These times in seconds; each must be a whole number of sample intervals to 1e-6.
    Chosen(Vec<f64>),
    /// These averaging factors.
    Factors(Vec<usize>),
}

impl Taus {
    /// Averaging factors m for a record of `phase_points` phase samples (one more than rate samples).
    ///
    /// Automatic choices stop where the statistic has fewer than one free term left; a chosen τ beyond that is
    /// refused, never dropped.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a chosen τ (in seconds) or factor that the record cannot give.
    pub fn factors(
        &self,
        statistic: Statistic,
        phase_points: usize,
        sample_rate: f64,
    ) -> Result<Vec<usize>, Error> {
        let (min, max) = statistic.factor_range(phase_points);
        if max < min {
            return Err(Error::TooFew {
                name: "samples for this statistic",
                needed: statistic.points_needed(min),
                got: phase_points,
            });
        }
        let even = |m: usize| !statistic.even_factors_only() || m.is_multiple_of(2);
        let keep = |m: &usize| (min..=max).contains(m) && even(*m);
        Ok(match self {
            Self::Octave => (0..usize::BITS - 1).map(|k| 1 << k).filter(keep).collect(),
            Self::Decade => (0..18)
                .flat_map(|k| [1, 2, 4].map(|d| d * 10_usize.pow(k)))
                .filter(keep)
                .collect(),
            Self::All => (min..=max).filter(keep).collect(),
            Self::PerDecade(n) => {
                let n = (*n).max(1) as f64;
                let last = ((max as f64).log10() * n).floor() as usize;
                let mut factors: Vec<usize> = (0..=last)
                    .map(|k| {
                        let m = 10_f64.powf(k as f64 / n).round() as usize;
                        if even(m) { m } else { m + 1 }
                    })
                    .filter(keep)
                    .collect();
                factors.dedup();
                factors
            }
            Self::Chosen(seconds) => {
                let mut factors = Vec::with_capacity(seconds.len());
                for &tau in seconds {
                    let ratio = tau * sample_rate;
                    let m = ratio.round();
                    let whole = (ratio - m).abs() <= 1e-6 * m;
                    let within = (1.0..=max as f64).contains(&m);
                    if !whole || !within || !keep(&(m as usize)) {
                        return Err(Error::OutOfRange {
                            name: "tau",
                            value: tau,
                            // To the nanosecond: a rate read from stamps has digits that mean nothing.
                            min: (1e9 * min as f64 / sample_rate).round() / 1e9,
                            max: (1e9 * max as f64 / sample_rate).round() / 1e9,
                        });
                    }
                    factors.push(m as usize);
                }
                factors
            }
            Self::Factors(factors) => {
                if let Some(m) = factors.iter().find(|m| !keep(m)) {
                    return Err(Error::OutOfRange {
                        name: "averaging factor",
                        value: *m as f64,
                        min: min as f64,
                        max: max as f64,
                    });
                }
                factors.clone()
            }
        })
    }
}

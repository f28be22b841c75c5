//! Whether the slowest cycles follow the noise that the whole band is fitted with, and a random walk of the lowest frequencies alone.

use crate::fit_family::Builder;
use crate::profile::{Fitted, Profile};
use crate::usable_band::below;
use crate::variance_fit::Likelihood;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Cosines that are looked at.
const LOWEST: usize = 20;

/// Chance of a departure that is one, on both sides together.
const CHANCE: f64 = 0.005;

/// Chance of what is left in a narrower band that describes them.
const ENOUGH: f64 = 0.1;

/// Fewest bins of a narrower band.
const FEWEST: usize = 40;

/// The slowest cycles do not follow the noise terms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SlowMisfit {
    /// Mean of the squares of the lowest twenty cosines over what the fit expects.
    pub ratio: f64,
    /// Chance of such a one.
    pub chance: f64,
    /// K of the whole band.
    pub whole: f64,
    /// Highest frequency below which the terms describe them, Hz.
    pub highest_frequency: f64,
}

/// What is fitted to the lowest frequencies where the whole band misses them.
pub(crate) struct SlowFit {
    pub(crate) fitted: Fitted,
    pub(crate) misfit: SlowMisfit,
}

impl SlowFit {
    /// `times` are fitted beside the sizes of the forms. `None` where the slowest cycles follow the fit, or no narrower band describes them.
    pub(crate) fn of(
        fitted: &Fitted,
        builder: &Builder<'_>,
        walk: usize,
        times: usize,
    ) -> Option<Self> {
        let frequencies = &builder.frequencies;
        let (ratio, chance) =
            departure(&fitted.likelihood, frequencies, &fitted.best.squares, times)?;
        if chance > CHANCE {
            return None;
        }
        let mut sorted = frequencies.clone();
        sorted.sort_by(f64::total_cmp);
        let mut highest = 0.5 * sorted.last()?;
        let fewest = *sorted.get(FEWEST)?;
        let mut best: Option<Self> = None;
        while highest > fewest {
            let narrow = below(&fitted.likelihood, frequencies, highest, None);
            let part: Vec<f64> = frequencies
                .iter()
                .copied()
                .filter(|f| *f <= highest)
                .collect();
            let fit = Fitted::new(narrow, fitted.held.clone(), Some(walk))?;
            let (_, left) = departure(&fit.likelihood, &part, &fit.best.squares, times)?;
            let misfit = SlowMisfit {
                ratio,
                chance,
                whole: fitted.best.squares[walk].sqrt(),
                highest_frequency: highest,
            };
            best = Some(Self {
                fitted: fit,
                misfit,
            });
            if left > ENOUGH {
                break;
            }
            highest *= 0.5;
        }
        best
    }

    /// The profile of the walk: its best value from the lowest frequencies, its interval over both.
    pub(crate) fn joined(&self, walk: usize, level: f64, whole: Profile) -> Profile {
        let slow = self.fitted.square(walk, level);
        Profile {
            best: slow.best,
            interval: (
                slow.interval.0.min(whole.interval.0),
                slow.interval.1.max(whole.interval.1),
            ),
            gain: slow.gain.min(whole.gain),
        }
    }
}

/// Mean ratio of the lowest cosines to the fit, and the chance of one as far off on either side.
fn departure(
    likelihood: &Likelihood,
    frequencies: &[f64],
    squares: &[f64],
    times: usize,
) -> Option<(f64, f64)> {
    let density = likelihood.density(squares)?;
    let left = likelihood.freed(&density);
    let mut order: Vec<usize> = (0..frequencies.len()).collect();
    order.sort_by(|a, b| frequencies[*a].total_cmp(&frequencies[*b]));
    let (mut sum, mut count) = (0.0, 0.0);
    for i in order {
        sum += likelihood.count[i] * left[i] / density[i];
        count += likelihood.count[i];
        if count >= LOWEST as f64 {
            break;
        }
    }
    let dof = count - (likelihood.forms + times) as f64;
    if dof < 5.0 {
        return None;
    }
    let below = ChiSquared::new(dof).ok()?.cdf(sum);
    Some((sum / dof, 2.0 * below.min(1.0 - below)))
}

//! Whether a coefficient may be the same in several units or runs.

use crate::profile::square_level;
use crate::{CoefficientFit, Reason, Term, Verdict};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Whether one coefficient may be the same in several units.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TermComparison {
    /// Which coefficient.
    pub term: Term,
    /// Unit of the coefficient.
    pub unit: String,
    /// The value that suits all best.
    pub common: f64,
    /// Its limits at the probability of the fits, if it is common.
    pub interval: (f64, f64),
    /// Rise of −2 ln L from every unit at its own best value to all at the common one.
    pub statistic: f64,
    /// Units less one.
    pub freedom: usize,
    /// Probability of such a rise by chance where they are equal.
    pub chance: f64,
}

/// What a fit says of one coefficient as a parabola on either side of its best value.
///
/// An interval ends where the profile has risen by its level: that of a square is used as it is; a ramp that a walk can stand in for needs
/// more, and is counted in units of χ²₁ again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parabolas {
    pub(crate) best: f64,
    pub(crate) below: f64,
    pub(crate) above: f64,
}

impl Parabolas {
    /// `None` for a coefficient that is given, and for one without a limit.
    pub(crate) fn of(verdict: &Verdict, term: Term, quantile: f64) -> Option<Self> {
        let (best, low, high) = match *verdict {
            Verdict::Identified {
                value, interval, ..
            }
            | Verdict::Present {
                value, interval, ..
            }
            | Verdict::Reported {
                value, interval, ..
            } => (value, interval.0, interval.1),
            Verdict::NotIdentifiable {
                reason: Reason::NoSupport { gain, needed },
                estimate: Some(best),
                upper_limit: Some(limit),
            } => {
                // At zero the profile has risen by `gain`, at the upper limit by `needed`; a ramp reaches as far down.
                let width = |to_zero: f64| to_zero * (needed / gain.max(1e-3 * needed)).sqrt();
                let low = match term {
                    Term::Ramp => best - (limit - best).max(width(best.abs())),
                    _ => best - width(best),
                };
                (best, low, limit.max(best))
            }
            _ => return None,
        };
        let side = |distance: f64| (distance / quantile.sqrt()).max(f64::MIN_POSITIVE);
        Some(Self {
            best,
            below: side(best - low),
            above: side(high - best),
        })
    }

    pub(crate) fn rise(&self, x: f64) -> f64 {
        let distance = x - self.best;
        let side = if distance < 0.0 {
            self.below
        } else {
            self.above
        };
        (distance / side).powi(2)
    }
}

/// Whether a coefficient may be the same in all fits: likelihood ratio of one common value against one for each.
///
/// The profile of each fit is taken as a parabola on either side of its best value, through the ends of its interval. The rise of their
/// sum at its minimum is χ² of one degree less than fits. `None` where fewer than two fits say something of the coefficient.
///
/// **Accuracy** `coverage_equal_units_are_called_equal`. **Source** S. S. Wilks, *The large-sample distribution of the likelihood ratio*,
/// Ann. Math. Stat. 9 (1938) 60–62.
pub fn equal_coefficients(term: Term, fits: &[&CoefficientFit]) -> Option<TermComparison> {
    let first = fits.first()?.get(term)?;
    let chi = |freedom: usize| ChiSquared::new(freedom as f64).ok();
    let level = fits.first()?.probability;
    let quantile = |p: f64| match term {
        Term::Ramp => chi(1).map(|c| c.inverse_cdf(p)),
        _ => Some(square_level(p)),
    };
    let parabolas: Vec<Parabolas> = fits
        .iter()
        .filter_map(|fit| {
            let verdict = fit.get(term)?.verdict;
            Parabolas::of(&verdict, term, quantile(fit.probability)?)
        })
        .collect();
    if parabolas.len() < 2 {
        return None;
    }
    let sum = |x: f64| parabolas.iter().map(|p| p.rise(x)).sum::<f64>();
    // The sum is convex: golden sections between the smallest and the largest best value.
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in &parabolas {
        low = low.min(p.best);
        high = high.max(p.best);
    }
    let common = minimum(&sum, low, high, 100);
    let statistic = sum(common);
    let allowed = statistic + quantile(level)?;
    let reach = |direction: f64, scale: f64| {
        let mut step = scale;
        while sum(common + direction * step) < allowed && step.is_finite() {
            step *= 2.0;
        }
        let (mut inside, mut outside) = (0.0, step);
        for _ in 0..60 {
            let middle = 0.5 * (inside + outside);
            if sum(common + direction * middle) < allowed {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        common + direction * inside
    };
    let widest = |f: fn(&Parabolas) -> f64| parabolas.iter().map(f).fold(0.0, f64::max);
    let (mut from, to) = (
        reach(-1.0, widest(|p| p.below)),
        reach(1.0, widest(|p| p.above)),
    );
    if term != Term::Ramp {
        from = from.max(0.0);
    }
    let freedom = parabolas.len() - 1;
    Some(TermComparison {
        term,
        unit: first.unit.clone(),
        common,
        interval: (from, to),
        statistic,
        freedom,
        chance: 1.0 - chi(freedom)?.cdf(statistic),
    })
}

/// Minimum of a function with one minimum, by so many golden sections.
pub(crate) fn minimum(f: &impl Fn(f64) -> f64, mut low: f64, mut high: f64, steps: usize) -> f64 {
    let golden = 0.618_033_988_749_895;
    for _ in 0..steps {
        let a = high - golden * (high - low);
        let b = low + golden * (high - low);
        if f(a) < f(b) {
            high = b;
        } else {
            low = a;
        }
    }
    0.5 * (low + high)
}

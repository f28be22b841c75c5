//! What a fit to the spectrum leaves to doubt.

use crate::coefficients::figure;
use crate::front_end::FrontEnd;
use crate::profile::Fitted;
use crate::usable_band::{Band, misfit};
use proofmass_uncertainty::{Finding, Severity};

/// Chance of a departure from the model as large as the one that is reported.
const MISFIT_CHANCE: f64 = 1e-3;

/// Gain of a filter from which the narrower band is reported as a finding and not only as a number.
const FILTER_SEEN: f64 = 16.0;

/// How the spectrum departs from the fitted model.
pub(crate) struct Misfit {
    statistic: f64,
    groups: usize,
    dof: f64,
    /// Relative root mean square departure beyond its scatter, zero when chance explains it.
    pub(crate) discrepancy: f64,
}

impl Misfit {
    pub(crate) fn of(fitted: &Fitted, frequencies: &[f64]) -> Self {
        let (statistic, groups, discrepancy) =
            misfit(&fitted.likelihood, frequencies, &fitted.best.squares, 0.0);
        let free = fitted.best.squares.iter().filter(|v| **v > 0.0).count()
            + fitted.likelihood.forms.max(1);
        let dof = groups.saturating_sub(free) as f64;
        let seen = dof > 0.0
            && crate::edf::chi_square_quantile(1.0 - MISFIT_CHANCE, dof)
                .is_some_and(|q| statistic > q);
        Self {
            statistic,
            groups,
            dof,
            discrepancy: if seen { discrepancy } else { 0.0 },
        }
    }

    pub(crate) fn findings(&self, band: &Band) -> Vec<Finding> {
        if self.discrepancy <= 0.0 {
            return Vec::new();
        }
        vec![
            Finding::new(
                Severity::Warning,
                "noise-model-misfit",
                "the spectrum departs from the sum of the noise terms",
            )
            .evidence(format!(
                "by {:.1} % (root mean square over {} bins) beyond its scatter below {} Hz; χ² = {:.0} with {:.0} degrees of freedom",
                100.0 * self.discrepancy,
                self.groups,
                figure(band.highest),
                self.statistic,
                self.dof,
            ))
            .advice("look at the density plot for a bump or a resonance: coefficients are biased by up to that share where the departure lies; seek a Gauss–Markov process or sinusoids, or give the highest frequency"),
        ]
    }
}

/// The band that was used, where it is narrower than half the sample rate.
pub(crate) fn of_the_band(band: &Band, sample_rate: f64) -> Option<Finding> {
    let used = format!(
        "used 0 to {} Hz of {} Hz",
        figure(band.highest),
        figure(0.5 * sample_rate)
    );
    if band.filter.is_some_and(|(_, gain)| gain > FILTER_SEEN) {
        let rest = match &band.front_end {
            Some(d) => {
                let half = match (d.shape, d.shape.half_power(sample_rate)) {
                    (FrontEnd::LowPass { .. }, Some(f)) if f <= d.end => {
                        format!(" with half its power at {} Hz", figure(f))
                    }
                    _ => String::new(),
                };
                format!(
                    "{}{half} describes the spectrum up to {} Hz and is part of the fit",
                    d.shape,
                    figure(d.end)
                )
            }
            None => {
                "neither a low-pass filter nor an overlap of averages describes the rest".to_owned()
            }
        };
        return Some(
            Finding::new(
                Severity::Note,
                "band-limited",
                "the noise is filtered in front of the converter",
            )
            .evidence(format!("{used}; {rest}"))
            .advice("quantisation cannot be determined behind a filter; give the highest frequency to choose otherwise"),
        );
    }
    band.resonance.then(|| {
        Finding::new(
            Severity::Note,
            "band-limited",
            "the upper part of the spectrum follows no noise term: it was left out",
        )
        .evidence(used)
        .advice("look at the density plot for a resonance or a decimator; give the highest frequency to choose otherwise")
    })
}

/// Tails heavier than Gaussian.
pub(crate) fn of_the_tails(kurtosis: f64, widened: f64, samples: usize) -> Option<Finding> {
    (kurtosis > 0.5 && 0.5 * kurtosis > 5.0 * (6.0 / samples as f64).sqrt()).then(|| {
        Finding::new(
            Severity::Note,
            "heavy-tails",
            "the samples scatter with heavier tails than Gaussian noise",
        )
        .evidence(format!(
            "excess kurtosis {kurtosis:.2}; the interval of N is wider by {:.0} % for it",
            100.0 * (widened.sqrt() - 1.0)
        ))
        .advice("look at the time plot for outliers: N includes them; --robust fits without them")
    })
}

/// A temperature that was recorded and explains nothing.
pub(crate) fn steady_temperature() -> Finding {
    Finding::new(
        Severity::Warning,
        "steady-temperature",
        "the temperature does not vary beyond the noise of its thermometer: no coefficient of it can be given",
    )
    .evidence("its slowest changes are no larger than its fastest".to_owned())
    .advice("leave the temperature out, or let it change by several times the thermometer's noise")
}

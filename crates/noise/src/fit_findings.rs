//! What a fit to the spectrum leaves to doubt.

use crate::coefficients::figure;
use crate::findings;
use crate::front_end::FrontEnd;
use crate::profile::Fitted;
use crate::usable_band::{Band, misfit};
use crate::{Course, CourseShape, SlowMisfit};
use proofmass_uncertainty::{Figure, Finding};

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
        vec![findings::noise_model_misfit(
            "spectrum",
            &format!(
                "by {:.1} % (root mean square over {} bins) beyond its scatter below {} Hz; χ² = {:.0} with {:.0} degrees of freedom",
                100.0 * self.discrepancy,
                self.groups,
                figure(band.highest),
                self.statistic,
                self.dof,
            ),
        )]
    }
}

/// The band that was used, where it is narrower than half the sample rate.
pub(crate) fn of_the_band(band: &Band, sample_rate: f64) -> Option<Finding> {
    let (used, half_rate) = (Figure(band.highest), Figure(0.5 * sample_rate));
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
        return Some(findings::band_limited(used, half_rate, &rest));
    }
    band.resonance
        .then(|| findings::resonance_left_out(used, half_rate))
}

/// Tails heavier than Gaussian.
pub(crate) fn of_the_tails(kurtosis: f64, widened: f64, samples: usize) -> Option<Finding> {
    (kurtosis > 0.5 && 0.5 * kurtosis > 5.0 * (6.0 / samples as f64).sqrt())
        .then(|| findings::heavy_tails(kurtosis, 100.0 * (widened.sqrt() - 1.0)))
}

/// The slowest cycles do not follow the noise of the whole band.
pub(crate) fn of_slow_cycles(misfit: &SlowMisfit, walk: f64) -> Finding {
    findings::slow_noise_misfit(
        misfit.ratio,
        misfit.chance,
        Figure(misfit.whole),
        Figure(walk),
        Figure(misfit.highest_frequency),
    )
}

/// Courses beside the noise that were found: one finding of each kind.
pub(crate) fn of_courses(courses: &[Course]) -> Vec<Finding> {
    let size = |c: &Course| Figure(c.size.value().unwrap_or(0.0));
    let mut steps: Vec<String> = Vec::new();
    let mut found = Vec::new();
    for course in courses {
        let (low, high) = course.interval.unwrap_or((0.0, 0.0));
        let (low, high) = (Figure(low), Figure(high));
        match course.shape {
            CourseShape::Exponential { time } => {
                let time = Figure(time);
                found.push(findings::output_settles(
                    size(course),
                    time,
                    low,
                    high,
                    course.gain,
                ));
            }
            CourseShape::Step { at } => steps.push(format!(
                "{} at {} s ({low} to {high} s; it raises twice the log-likelihood by {:.1})",
                size(course),
                Figure(at),
                course.gain
            )),
            CourseShape::DayCycle => found.push(findings::day_cycle(size(course), course.gain)),
        }
    }
    if !steps.is_empty() {
        found.push(findings::mean_steps(&steps.join(", ")));
    }
    found
}

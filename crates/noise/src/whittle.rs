//! Coefficients by maximum likelihood on the spectrum: every term in the model, intervals from profiles.

use crate::coefficients::Limits;
use crate::cosine_spectrum::CosineSpectrum;
use crate::lines::{self, Lines};
use crate::markov::{self, Markov};
use crate::profile::{Fitted, Profile, slope_level, square_level};
use crate::record::{check_count, check_finite, check_sample_rate};
use crate::term_density::{Process, column};
use crate::usable_band::{Band, Candidate, below, misfit, usable_band};
use crate::variance_fit::{Likelihood, Line, solve};
use crate::{BandUse, Coefficient, CoefficientFit, FitOptions, NoiseModel, Reason, Term, Verdict};
use proofmass_core::Error;
use proofmass_uncertainty::{Covariance, Finding, Severity};

/// Fewest rate samples from which coefficients are estimated.
const FEWEST_SAMPLES: usize = 64;

/// Cycles in the record below which the band is not cut.
const FEWEST_CYCLES: f64 = 100.0;

/// Chance of a departure from the model as large as the one that is reported.
const MISFIT_CHANCE: f64 = 1e-3;

/// Gain of a filter from which the narrower band is reported as a finding and not only as a number.
const FILTER_SEEN: f64 = 16.0;

/// Noise coefficients of a rate record, all terms together.
///
/// The record is expanded in cosines, c_k = √(2/f_s)√(2/n) Σ y_i cos(πk(i+½)/n), whose variances are the density
/// S_k = Σ c_t² g_t(k) of the terms and whose mean is that of a ramp, R d_k. Minimised is the restricted
/// −2 ln L = Σ (ln S_k + (c_k − R d_k)²/S_k) + ln Σ d_k²/S_k over squares that are not negative. **No term is selected:**
/// every term of [`FitOptions::terms`] is in the model, and its interval is where the likelihood, at its best over all
/// others, has not fallen by more than a calibrated amount. Where that interval reaches zero its upper end is the limit.
/// "Identified" is a word about an interval, not a different interval.
///
/// Before, the highest frequency is sought below which no low-pass filter shows (unless
/// [`FitOptions::highest_frequency`] gives one).
///
/// **Units** `rate` in U = `options.unit`, `sample_rate` in Hz; coefficients as [`NoiseModel`].
///
/// **Assumes** even sampling, stationary increments. Heavy tails widen the interval of N by √(1 + κ/2) with the excess
/// kurtosis κ of the differences.
///
/// **Memory** some 30 bytes per sample: recordings of more than a few hundred million samples are averaged to a lower
/// rate first or read through a [`LongRecord`](crate::LongRecord).
///
/// **Errors** [`Error::NotFinite`], [`Error::TooFew`] below 64 samples, [`Error::OutOfRange`] for a constant channel
/// (its standard deviation), a sample rate, a frequency or a probability.
///
/// **Accuracy** coverage and false identifications over record lengths and mixtures: `docs/noise.md`, a part of it in
/// `coverage_of_mixtures`.
///
/// **Source** `[Whittle1953]`, restricted likelihood `[Patterson1971]`.
pub fn whittle(
    rate: &[f64],
    sample_rate: f64,
    options: &FitOptions,
) -> Result<CoefficientFit, Error> {
    whittle_stretches(&[rate], sample_rate, options)
}

/// [`whittle()`] of a record with gaps: one likelihood of all its stretches, each with a mean of its own.
///
/// Stretches of fewer than three samples tell nothing and are left out.
pub fn whittle_stretches(
    stretches: &[&[f64]],
    sample_rate: f64,
    options: &FitOptions,
) -> Result<CoefficientFit, Error> {
    check_sample_rate(sample_rate)?;
    for stretch in stretches {
        check_finite("rate", stretch)?;
    }
    let samples = stretches.iter().map(|s| s.len()).sum();
    check_count("rate samples", samples, FEWEST_SAMPLES)?;
    options.check(sample_rate)?;
    refuse_constant_stretches(stretches)?;

    let mut lines = Lines::default();
    let mut freed: Vec<Vec<f64>> = Vec::new();
    let mut spectrum = CosineSpectrum::new(stretches, sample_rate, &[]);
    if options.seeks(Term::Sinusoid) {
        let model = quick_model(&spectrum, options.averaged);
        lines = lines::find(stretches, sample_rate, &model, options.false_alarm_rate);
        if !lines.found.is_empty() {
            freed = stretches.iter().map(|s| lines.remove(s)).collect();
            let parts: Vec<&[f64]> = freed.iter().map(Vec::as_slice).collect();
            spectrum = CosineSpectrum::new(&parts, sample_rate, &lines.neighbourhoods());
        }
    }
    drop(freed);
    check_count("cosines", spectrum.bins.len(), 8)?;

    let mut terms: Vec<Term> = options
        .terms
        .iter()
        .copied()
        .filter(|t| POWERS.contains(t))
        .collect();
    terms.sort();
    terms.dedup();
    let whole = likelihood_of(
        &spectrum,
        terms
            .iter()
            .map(|t| column(&spectrum, Process::Power(*t), options.averaged))
            .collect(),
    );
    if terms.is_empty() {
        return Err(Error::TooFew {
            name: "noise terms",
            needed: 1,
            got: 0,
        });
    }
    let frequencies: Vec<f64> = spectrum.bins.iter().map(|b| b.frequency).collect();
    let line = if options.seeks(Term::Ramp) {
        options.fixed(Term::Ramp).map_or(Line::Restricted, Line::At)
    } else {
        Line::At(0.0)
    };
    let quantisation = terms.iter().position(|t| *t == Term::Quantisation);
    let band = match options.highest_frequency {
        Some(highest) => Band {
            highest,
            filter: None,
            resonance: false,
        },
        None => {
            // A process that is sought is no filter.
            let with_processes = if options.seeks(Term::GaussMarkov) {
                let search = markov::Search {
                    spectrum: &spectrum,
                    highest: 0.5 * sample_rate,
                    line,
                    walk: terms.iter().position(|t| *t == Term::RandomWalk),
                };
                search
                    .add(whole.clone(), &vec![None; terms.len()], options)
                    .0
            } else {
                whole.clone()
            };
            usable_band(&Candidate {
                likelihood: &with_processes,
                frequencies: &frequencies,
                quantisation,
                sample_rate,
                lowest: FEWEST_CYCLES / spectrum.longest,
                line,
            })
        }
    };
    let chosen_narrower =
        options.highest_frequency.is_none() && band.highest < 0.4999 * sample_rate;
    let without = quantisation.filter(|_| chosen_narrower);
    let mut likelihood = below(&whole, &frequencies, band.highest, without);
    let used: Vec<f64> = frequencies
        .iter()
        .copied()
        .filter(|f| *f <= band.highest)
        .collect();
    check_count("cosines below the highest frequency", used.len(), 8)?;
    let fitted_terms: Vec<Term> = terms
        .iter()
        .enumerate()
        .filter(|(t, _)| Some(*t) != without)
        .map(|(_, term)| *term)
        .collect();
    let mut held: Vec<Option<f64>> = fitted_terms
        .iter()
        .map(|t| options.fixed(*t).map(|c| c * c))
        .collect();
    let walk = fitted_terms.iter().position(|t| *t == Term::RandomWalk);

    let mut processes: Vec<Markov> = Vec::new();
    if options.seeks(Term::GaussMarkov) {
        let search = markov::Search {
            spectrum: &spectrum,
            highest: band.highest,
            line,
            walk,
        };
        (likelihood, processes) = search.add(likelihood, &held, options);
        held.resize(likelihood.terms(), None);
    }
    let fitted = Fitted::new(likelihood, held, line, walk).ok_or(Error::NotConverged {
        name: "noise likelihood",
        iterations: 0,
        step: 0.0,
    })?;

    let kurtosis = excess_kurtosis(stretches);
    let level = square_level(options.probability);
    let mut model = NoiseModel::default();
    let mut coefficients = Vec::new();
    let mut kept: Vec<Kept> = Vec::new();
    for &term in &terms {
        let coefficient = |verdict| Coefficient {
            term,
            unit: term.unit(&options.unit),
            verdict,
            parameter: None,
        };
        let Some(j) = fitted_terms.iter().position(|t| *t == term) else {
            coefficients.push(coefficient(Verdict::NotIdentifiable {
                reason: Reason::BeyondBand {
                    highest_frequency: band.highest,
                },
                estimate: None,
                upper_limit: None,
            }));
            continue;
        };
        model.set(term, fitted.best.squares[j].sqrt());
        if let Some(value) = options.fixed(term) {
            coefficients.push(coefficient(Verdict::Fixed { value }));
            continue;
        }
        // Means of squares of a heavy-tailed sequence scatter more than Gaussian ones.
        let tails = if term == Term::White {
            1.0 + 0.5 * kurtosis
        } else {
            1.0
        };
        let profile = fitted.square(j, level * tails);
        let root = Profile {
            best: profile.best.sqrt(),
            interval: (profile.interval.0.sqrt(), profile.interval.1.sqrt()),
            gain: profile.gain,
        };
        let limits = Limits {
            needed: square_level(1.0 - options.false_alarm_rate),
            excludes_zero: level,
            forced: options.forced.contains(&term),
            probability: options.probability,
        };
        let verdict = limits.verdict(&root);
        if verdict.value().is_some() {
            kept.push(Kept {
                position: Some(j),
                value: root.best,
                u: limits.standard_uncertainty(&root),
            });
        }
        coefficients.push(coefficient(verdict));
    }
    for (index, process) in processes.iter().enumerate() {
        let j = fitted_terms.len() + index;
        let profile = fitted.square(j, level);
        let root = Profile {
            best: profile.best.sqrt(),
            interval: (profile.interval.0.sqrt(), profile.interval.1.sqrt()),
            gain: process.gain,
        };
        let limits = Limits {
            needed: 0.0,
            excludes_zero: 0.0,
            forced: true,
            probability: options.probability,
        };
        model.push_markov(root.best, process.time);
        kept.push(Kept {
            position: Some(j),
            value: root.best,
            u: limits.standard_uncertainty(&root),
        });
        coefficients.push(Coefficient {
            term: Term::GaussMarkov,
            unit: Term::GaussMarkov.unit(&options.unit),
            verdict: limits.verdict(&root),
            parameter: Some(crate::TermParameter {
                value: process.time,
                interval: Some(process.interval),
            }),
        });
    }
    if options.seeks(Term::GaussMarkov) && processes.is_empty() {
        coefficients.push(Coefficient {
            term: Term::GaussMarkov,
            unit: Term::GaussMarkov.unit(&options.unit),
            verdict: Verdict::NotIdentifiable {
                reason: Reason::OtherTermsSuffice,
                estimate: None,
                upper_limit: None,
            },
            parameter: None,
        });
    }
    if options.seeks(Term::Ramp) {
        let verdict = match line {
            Line::At(value) => {
                model.ramp = value;
                Verdict::Fixed { value }
            }
            _ => ramp_verdict(&fitted, options, &mut model, &mut kept),
        };
        coefficients.push(Coefficient {
            term: Term::Ramp,
            unit: Term::Ramp.unit(&options.unit),
            verdict,
            parameter: None,
        });
    }
    for found in &lines.found {
        let density = model.density(found.frequency, sample_rate);
        // Variance of an amplitude: one-sided density over the record length.
        let u = (density / spectrum.longest).sqrt();
        let k = normal_quantile(0.5 * (1.0 + options.probability));
        model.push_line(found.amplitude, found.frequency, found.phase);
        kept.push(Kept {
            position: None,
            value: found.amplitude,
            u,
        });
        coefficients.push(Coefficient {
            term: Term::Sinusoid,
            unit: options.unit.clone(),
            verdict: Verdict::Identified {
                value: found.amplitude,
                standard_uncertainty: u,
                interval: ((found.amplitude - k * u).max(0.0), found.amplitude + k * u),
                gain: (found.amplitude / u).powi(2),
            },
            parameter: Some(crate::TermParameter {
                value: found.frequency,
                interval: None,
            }),
        });
    }

    let (statistic, groups, discrepancy) =
        misfit(&fitted.likelihood, &used, &fitted.best.squares, 0.0);
    let mut findings = Vec::new();
    let free = fitted.best.squares.iter().filter(|v| **v > 0.0).count() + 1;
    let dof = groups.saturating_sub(free) as f64;
    let misfits = dof > 0.0
        && crate::edf::chi_square_quantile(1.0 - MISFIT_CHANCE, dof).is_some_and(|q| statistic > q);
    if misfits {
        findings.push(
            Finding::new(
                Severity::Warning,
                "noise-model-misfit",
                "the spectrum departs from the sum of the noise terms",
            )
            .evidence(format!(
                "by {:.1} % (root mean square over {groups} bins) beyond its scatter below {} Hz; χ² = {statistic:.0} with {dof:.0} degrees of freedom",
                100.0 * discrepancy,
                crate::coefficients::figure(band.highest),
            ))
            .advice("look at the density plot for a bump or a resonance: coefficients are biased by up to that share where the departure lies; seek a Gauss–Markov process or sinusoids, or give the highest frequency"),
        );
    }
    if let Some((filter, gain)) = band.filter.filter(|(_, gain)| *gain > FILTER_SEEN) {
        findings.push(
            Finding::new(
                Severity::Note,
                "band-limited",
                "the noise is filtered: the spectrum was used below the filter only",
            )
            .evidence(format!(
                "used 0 to {} Hz of {} Hz; a filter of order {} near {} Hz describes the rest (gain {:.0})",
                crate::coefficients::figure(band.highest),
                crate::coefficients::figure(0.5 * sample_rate),
                filter.order,
                crate::coefficients::figure(filter.corner),
                gain
            ))
            .advice("quantisation cannot be determined behind a filter; give the highest frequency to choose otherwise"),
        );
    } else if band.resonance {
        findings.push(
            Finding::new(
                Severity::Note,
                "band-limited",
                "the upper part of the spectrum follows no noise term: it was left out",
            )
            .evidence(format!(
                "used 0 to {} Hz of {} Hz",
                crate::coefficients::figure(band.highest),
                crate::coefficients::figure(0.5 * sample_rate),
            ))
            .advice("look at the density plot for a resonance or a decimator; give the highest frequency to choose otherwise"),
        );
    }
    if kurtosis > 0.5 && 0.5 * kurtosis > 5.0 * (6.0 / samples as f64).sqrt() {
        findings.push(
            Finding::new(
                Severity::Note,
                "heavy-tails",
                "the samples scatter with heavier tails than Gaussian noise",
            )
            .evidence(format!(
                "excess kurtosis {kurtosis:.2}; the interval of N is wider by {:.0} % for it",
                100.0 * ((1.0 + 0.5 * kurtosis).sqrt() - 1.0)
            ))
            .advice("look at the time plot for outliers: N includes them"),
        );
    }
    Ok(CoefficientFit {
        probability: options.probability,
        false_alarm_rate: options.false_alarm_rate,
        covariance: covariance(&fitted, &kept)?,
        coefficients,
        model,
        discrepancy: if misfits { discrepancy } else { 0.0 },
        band: BandUse {
            highest_frequency: band.highest,
            cut: chosen_narrower,
            filter: band.filter.map(|(f, _)| (f.order.unsigned_abs(), f.corner)),
        },
        findings,
    })
}

/// The four terms with a density.
pub(crate) const POWERS: [Term; 4] = [
    Term::Quantisation,
    Term::White,
    Term::Flicker,
    Term::RandomWalk,
];

/// A coefficient that is given: where its square stands in the fit, its value and standard uncertainty.
struct Kept {
    position: Option<usize>,
    value: f64,
    u: f64,
}

fn ramp_verdict(
    fitted: &Fitted,
    options: &FitOptions,
    model: &mut NoiseModel,
    kept: &mut Vec<Kept>,
) -> Verdict {
    let level = slope_level(options.probability);
    let limits = Limits {
        needed: slope_level(1.0 - options.false_alarm_rate),
        excludes_zero: level,
        forced: options.forced.contains(&Term::Ramp),
        probability: options.probability,
    };
    let Some(profile) = fitted.slope(level) else {
        return Verdict::NotIdentifiable {
            reason: Reason::OtherTermsSuffice,
            estimate: None,
            upper_limit: None,
        };
    };
    let verdict = limits.verdict(&profile);
    if let Some(value) = verdict.value() {
        model.ramp = value;
        kept.push(Kept {
            position: None,
            value,
            u: limits.standard_uncertainty(&profile),
        });
    }
    verdict
}

/// The best model of a spectrum, without intervals and over its whole band.
pub(crate) fn quick_model(spectrum: &CosineSpectrum, averaged: usize) -> NoiseModel {
    let columns = POWERS
        .iter()
        .map(|t| column(spectrum, Process::Power(*t), averaged))
        .collect();
    let likelihood = likelihood_of(spectrum, columns);
    let mut model = NoiseModel::default();
    let start = likelihood.start();
    if let Some(best) = likelihood.minimise(&[&start], &[None; 4], Line::Restricted) {
        for (term, v) in POWERS.into_iter().zip(best.squares) {
            model.set(term, v.sqrt());
        }
    }
    model
}

pub(crate) fn likelihood_of(spectrum: &CosineSpectrum, columns: Vec<Vec<f64>>) -> Likelihood {
    let pick = |f: fn(&crate::cosine_spectrum::Bin) -> f64| spectrum.bins.iter().map(f).collect();
    Likelihood {
        count: pick(|b| b.count),
        cc: pick(|b| b.cc),
        cd: pick(|b| b.cd),
        dd: pick(|b| b.dd),
        columns,
    }
}

/// Excess kurtosis of a white sequence from that of its first differences, which drift leaves alone; not below zero.
fn excess_kurtosis(stretches: &[&[f64]]) -> f64 {
    let (mut n, mut second, mut fourth) = (0.0, 0.0, 0.0);
    for stretch in stretches {
        for w in stretch.windows(2) {
            let d2 = (w[1] - w[0]).powi(2);
            n += 1.0;
            second += d2;
            fourth += d2 * d2;
        }
    }
    if n < 1.0 || second <= 0.0 || !fourth.is_finite() {
        return 0.0;
    }
    // The sum of two independent values has half their excess.
    (2.0 * (n * fourth / (second * second) - 3.0)).max(0.0)
}

/// A channel without variation has no noise to describe.
pub(crate) fn refuse_constant(rate: &[f64]) -> Result<(), Error> {
    refuse_constant_stretches(&[rate])
}

fn refuse_constant_stretches(stretches: &[&[f64]]) -> Result<(), Error> {
    let constant = stretches
        .iter()
        .all(|s| s.iter().all(|v| Some(v) == s.first()));
    if constant {
        return Err(Error::OutOfRange {
            name: "standard deviation of a constant channel",
            value: 0.0,
            min: f64::MIN_POSITIVE,
            max: f64::MAX,
        });
    }
    Ok(())
}

pub(crate) fn normal_quantile(p: f64) -> f64 {
    use statrs::distribution::{ContinuousCDF, Normal};
    Normal::standard().inverse_cdf(p)
}

/// Covariance of the coefficients given: their uncertainties, with the correlation of the expected information.
fn covariance(fitted: &Fitted, kept: &[Kept]) -> Result<Covariance, Error> {
    let free: Vec<usize> = (0..fitted.likelihood.terms())
        .filter(|t| fitted.held[*t].is_none() && fitted.best.squares[*t] > 0.0)
        .collect();
    let q = free.len();
    let p = fitted.likelihood.terms();
    let inverse: Option<Vec<Vec<f64>>> = fitted
        .likelihood
        .information(&fitted.best.squares, fitted.line)
        .and_then(|h| {
            let matrix: Vec<f64> = (0..q * q)
                .map(|k| h[free[k / q] * p + free[k % q]])
                .collect();
            (0..q)
                .map(|i| {
                    let unit: Vec<f64> = (0..q).map(|j| f64::from(u8::from(i == j))).collect();
                    solve(&matrix, &unit)
                })
                .collect()
        });
    let correlation = |a: &Kept, b: &Kept| -> f64 {
        let place = |k: &Kept| k.position.and_then(|p| free.iter().position(|f| *f == p));
        match (place(a), place(b), &inverse) {
            (Some(i), Some(j), Some(v)) => {
                (v[i][j] / (v[i][i] * v[j][j]).sqrt()).clamp(-0.999, 0.999)
            }
            _ => 0.0,
        }
    };
    let n = kept.len();
    let rows: Vec<f64> = (0..n * n)
        .map(|k| {
            let (a, b) = (&kept[k / n], &kept[k % n]);
            let r = if k / n == k % n {
                1.0
            } else {
                0.5 * (correlation(a, b) + correlation(b, a))
            };
            r * a.u * b.u
        })
        .collect();
    debug_assert!(kept.iter().all(|k| k.value.is_finite()));
    Covariance::try_from_rows(n, &rows)
}

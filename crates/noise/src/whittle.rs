//! Coefficients by maximum likelihood on the spectrum: every term in the model, intervals from profiles.

use crate::coefficients::Limits;
use crate::cosine_spectrum::CosineSpectrum;
use crate::course;
use crate::fit_family::{Builder, Family};
use crate::fit_findings;
use crate::fit_record::FitRecord;
use crate::fit_verdicts::{Kept, covariance, ramp_verdict};
use crate::known_forms::KnownForms;
use crate::lines::{self, Lines};
use crate::markov::{self, Markov};
use crate::profile::{Fitted, Profile, square_level};
use crate::quick_fit::{POWERS, quick_fit, without_forms};
use crate::record::{check_count, check_sample_rate};
use crate::slow_misfit::SlowFit;
use crate::slow_sinusoid;
use crate::term_density::{Process, column};
use crate::usable_band::{Band, Candidate, below, usable_band};
use crate::variance_fit::Likelihood;
use crate::{BandUse, Coefficient, CoefficientFit, FitOptions, NoiseModel, Reason, Term, Verdict};
use proofmass_core::Error;
use proofmass_uncertainty::normal_quantile;

/// Fewest rate samples from which coefficients are estimated.
const FEWEST_SAMPLES: usize = 64;

/// Further rise of −2 ln L at the ends of the interval of a slow noise for each course that stands beside it: of few slow cosines it takes
/// one. Held against simulations (`examples/courses.rs`).
const LOST: f64 = 0.8;

/// Cycles in the record below which the band is not cut.
const FEWEST_CYCLES: f64 = 100.0;

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
/// **Assumes** even sampling, stationary increments. Heavy tails add κ/n to the relative variance of N², κ the excess kurtosis (from
/// the differences, at its upper limit) of n samples.
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
    whittle_record(&FitRecord::new(stretches), sample_rate, options)
}

/// [`whittle()`] of a record with gaps and with what was measured beside it.
///
/// The temperature, where there is one, is a known form beside the ramp: its size is in the likelihood with all terms, so that
/// what follows the temperature is not taken for B, K or R. Sinusoids of 1.5 to 32 cycles, where they are sought, are such forms
/// too, and are judged by the likelihood of the model with all other terms. So are a warm-up, steps and the cycle of the day, where
/// [`FitOptions::courses`] says so. Stretches without a start follow one another.
///
/// **Errors** as [`whittle()`]; [`Error::Length`] where temperature or starts do not fit the stretches.
pub fn whittle_record(
    record: &FitRecord<'_>,
    sample_rate: f64,
    options: &FitOptions,
) -> Result<CoefficientFit, Error> {
    check_sample_rate(sample_rate)?;
    record.check(FEWEST_SAMPLES)?;
    options.check(sample_rate)?;
    let (stretches, samples) = (record.stretches, record.samples());
    refuse_constant_stretches(stretches)?;
    let mut terms: Vec<Term> = options
        .terms
        .iter()
        .copied()
        .filter(|t| POWERS.contains(t))
        .collect();
    terms.sort();
    terms.dedup();
    if terms.is_empty() {
        return Err(Error::TooFew {
            name: "noise terms",
            needed: 1,
            got: 0,
        });
    }

    let known = KnownForms::of(record, sample_rate, options);
    let mut lines = Lines::default();
    let mut freed: Option<Vec<Vec<f64>>> = None;
    if options.seeks(Term::Sinusoid) {
        let forms = known.of_the_fit();
        let spectrum = CosineSpectrum::beside(stretches, &forms, sample_rate, &[]);
        let (model, sizes) = quick_fit(&spectrum, options.averaged);
        let alone = without_forms(stretches, &forms, &sizes[1..]);
        let parts: Vec<&[f64]> = alone.iter().map(Vec::as_slice).collect();
        let fastest_slow = slow_sinusoid::MOST * sample_rate / record.span() as f64;
        // Half of the false alarms each for slow and fast ones.
        lines = lines::find(
            &parts,
            sample_rate,
            &model,
            0.5 * options.false_alarm_rate,
            fastest_slow,
        );
        if !lines.found.is_empty() {
            freed = Some(stretches.iter().map(|s| lines.remove(s)).collect());
        }
    }
    let parts: Vec<&[f64]> = match &freed {
        Some(freed) => freed.iter().map(Vec::as_slice).collect(),
        None => stretches.to_vec(),
    };
    let spectrum =
        CosineSpectrum::beside(&parts, &known.forms, sample_rate, &lines.neighbourhoods());
    check_count("cosines", spectrum.bins.len(), 8)?;

    let mut all = Likelihood::new(
        &spectrum,
        terms
            .iter()
            .map(|t| column(&spectrum, Process::Power(*t), options.averaged))
            .collect(),
    );
    // A ramp that is not sought, or known, is no form of the fit.
    let ramp_given = match options.fixed(Term::Ramp) {
        Some(slope) => Some(slope),
        None => (!options.seeks(Term::Ramp)).then_some(0.0),
    };
    if let Some(slope) = ramp_given {
        all = all.given(0, slope);
    }
    let ramp = ramp_given.is_none().then_some(0);
    let after_ramp = usize::from(ramp.is_some());
    let whole = known.chosen(&all, after_ramp, &known.best);
    let frequencies: Vec<f64> = spectrum.bins.iter().map(|b| b.frequency).collect();
    let quantisation = terms.iter().position(|t| *t == Term::Quantisation);
    let band = match options.highest_frequency {
        Some(highest) => Band {
            highest,
            filter: None,
            front_end: None,
            resonance: false,
        },
        None => {
            // A process that is sought is no filter.
            let with_processes = if options.seeks(Term::GaussMarkov) {
                let search = markov::Search {
                    spectrum: &spectrum,
                    highest: 0.5 * sample_rate,
                    walk: terms.iter().position(|t| *t == Term::RandomWalk),
                    front_end: None,
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
                level: square_level(options.probability),
            })
        }
    };
    let front_end = band.front_end.as_ref().map(|d| d.shape);
    let cut = options.highest_frequency.is_none()
        && (band.highest < 0.4999 * sample_rate || front_end.is_some());
    let without = quantisation.filter(|_| cut);
    let builder = Builder {
        base: below(&whole, &frequencies, band.highest, without),
        frequencies: frequencies
            .iter()
            .copied()
            .filter(|f| *f <= band.highest)
            .collect(),
        powers: band.front_end.as_ref().map_or(&[], |d| d.powers),
        spectrum: &spectrum,
    };
    let used = &builder.frequencies;
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
    let mut likelihood = builder.likelihood(front_end, &[]);
    held.resize(likelihood.terms(), None);
    if options.seeks(Term::GaussMarkov) {
        let search = markov::Search {
            spectrum: &spectrum,
            highest: band.highest,
            walk,
            front_end,
        };
        (likelihood, processes) = search.add(likelihood, &held, options);
        held.resize(likelihood.terms(), None);
    }
    let unfit = || Error::NotConverged {
        name: "noise likelihood",
        iterations: 0,
        step: 0.0,
    };
    let fitted = Fitted::new(likelihood, held, walk).ok_or_else(unfit)?;
    let mut family = Family::new(fitted);
    if let Some(described) = &band.front_end {
        family.vary_front_end(&builder, described, &processes);
    }
    if options.seeks(Term::GaussMarkov) {
        family.vary_times(&builder, front_end, &processes, options);
    }
    let all = below(&all, &frequencies, band.highest, without);
    family.vary_courses(
        &builder,
        (&all, after_ramp),
        (front_end, &processes),
        &known,
        options,
    );
    let fitted = &family.fitted;

    let slow_fit = walk
        .filter(|w| fitted.held[*w].is_none())
        .and_then(|w| SlowFit::of(fitted, &builder, w, known.times()));
    let (kurtosis, most) = excess_kurtosis(stretches);
    let level = square_level(options.probability);
    let of_slow = level + LOST * known.further().min(3) as f64;
    let mut tails = 1.0;
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
        let is_fast = matches!(term, Term::Quantisation | Term::White);
        let level = if is_fast { level } else { of_slow };
        let mut profile = family.square(j, level, is_fast);
        if term == Term::White {
            tails = widened(&profile, level, most / samples as f64);
            if tails > 1.001 {
                profile = family.square(j, level * tails, is_fast);
            }
        }
        if let (Term::RandomWalk, Some(slow)) = (term, &slow_fit) {
            profile = slow.joined(j, level, profile);
            model.random_walk = profile.best.sqrt();
        }
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
        let profile = family.square(j, level, false);
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
    let mut findings = Vec::new();
    let span = record.span() as f64 / sample_rate;
    let settling = known.settles().then_some(after_ramp + known.head());
    let sensitivity = known.temperature.as_ref().map(|t| {
        let (sensitivity, doubts) = t.sensitivity(
            &family,
            (after_ramp, settling),
            ramp,
            (&known.lag, span),
            options,
        );
        findings.extend(doubts);
        sensitivity
    });
    if record.temperature.is_some() && known.temperature.is_none() {
        findings.push(crate::findings::steady_temperature());
    }
    let first_course = after_ramp + known.head() + usize::from(known.settles());
    let courses = course::sizes(&family, first_course, &known.courses.found, options);
    findings.extend(fit_findings::of_courses(&courses));
    if options.seeks(Term::Ramp) {
        let collinear = sensitivity.as_ref().is_some_and(|s| s.is_collinear());
        let verdict = match ramp_given {
            Some(value) => {
                model.ramp = value;
                Verdict::Fixed { value }
            }
            None if collinear => Verdict::NotIdentifiable {
                reason: Reason::Collinear,
                estimate: None,
                upper_limit: None,
            },
            None => ramp_verdict(&family, options, &mut model, &mut kept),
        };
        coefficients.push(Coefficient {
            term: Term::Ramp,
            unit: Term::Ramp.unit(&options.unit),
            verdict,
            parameter: None,
        });
    }
    let first_slow = after_ramp + usize::from(known.temperature.is_some());
    for (index, found) in known.slow.iter().enumerate() {
        let places = (first_slow + 2 * index, first_slow + 2 * index + 1);
        let Some((sinusoid, verdict)) = slow_sinusoid::amplitude(fitted, places, found, options)
        else {
            continue;
        };
        model.push_line(sinusoid.amplitude, sinusoid.frequency, sinusoid.phase);
        kept.push(Kept {
            position: None,
            value: sinusoid.amplitude,
            u: verdict.standard_uncertainty().unwrap_or(0.0),
        });
        coefficients.push(Coefficient {
            term: Term::Sinusoid,
            unit: options.unit.clone(),
            verdict,
            parameter: Some(crate::TermParameter {
                value: found.frequency,
                interval: Some(found.interval),
            }),
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

    if let Some(slow) = &slow_fit {
        findings.push(fit_findings::of_slow_cycles(
            &slow.misfit,
            model.random_walk,
        ));
    }
    let misfit = fit_findings::Misfit::of(fitted, used);
    findings.extend(misfit.findings(&band));
    findings.extend(fit_findings::of_the_band(&band, sample_rate));
    findings.extend(fit_findings::of_the_tails(kurtosis, tails, samples));
    Ok(CoefficientFit {
        probability: options.probability,
        false_alarm_rate: options.false_alarm_rate,
        covariance: covariance(fitted, &kept)?,
        coefficients,
        model,
        discrepancy: misfit.discrepancy,
        temperature: sensitivity,
        courses,
        slow_misfit: slow_fit.as_ref().map(|s| s.misfit),
        band: BandUse {
            highest_frequency: band.highest,
            cut,
            front_end,
            described_to: band
                .front_end
                .as_ref()
                .map_or(band.highest, |d| d.end.max(band.highest)),
        },
        findings,
    })
}

/// Variance of a profile with `further` relative variance of the square, over that without.
///
/// Squared cosines of a white sequence of excess kurtosis κ have covariances of κ/n of their product: one factor common to all of
/// them, however few are used, while what is left of each is nearly Gaussian.
pub(crate) fn widened(profile: &Profile, level: f64, further: f64) -> f64 {
    let half = 0.5 * (profile.interval.1 - profile.interval.0) / profile.best;
    let variance = half * half / level;
    if variance > 0.0 && variance.is_finite() {
        1.0 + further / variance
    } else {
        1.0
    }
}

/// Excess kurtosis of a white sequence from that of its first differences, which drift leaves alone, and its upper limit; neither
/// below zero.
///
/// The limit is two standard deviations of the mean fourth power up: where few samples make it, it tells little of the others.
fn excess_kurtosis(stretches: &[&[f64]]) -> (f64, f64) {
    let (mut n, mut second, mut fourth, mut eighth) = (0.0, 0.0, 0.0, 0.0);
    for stretch in stretches {
        for w in stretch.windows(2) {
            let d2 = (w[1] - w[0]).powi(2);
            n += 1.0;
            second += d2;
            fourth += d2 * d2;
            eighth += d2.powi(4);
        }
    }
    if n < 1.0 || second <= 0.0 || !eighth.is_finite() {
        return (0.0, 0.0);
    }
    let (second, fourth, eighth) = (second / n, fourth / n, eighth / n);
    // The sum of two independent values has half their excess; every value is in two differences.
    let of = |fourth: f64| (2.0 * (fourth / (second * second) - 3.0)).max(0.0);
    let u = (2.0 * (eighth - fourth * fourth).max(0.0) / n).sqrt();
    (of(fourth), of(fourth + 2.0 * u))
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

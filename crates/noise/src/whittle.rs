//! Coefficients by maximum likelihood on the spectrum (Whittle), with the terms chosen by the data.

use crate::coefficients::identified;
use crate::likelihood::{Likelihood, inverse, sorted};
use crate::record::{check_count, check_finite, check_sample_rate};
use crate::slope::slope_uncertainty;
use crate::spectrum_bins::SpectrumBins;
use crate::{Coefficient, CoefficientFit, FitOptions, Method, NoiseModel, Reason, Term, Verdict};
use faer::Mat;
use proofmass_core::Error;
use proofmass_signal::Detrend;
use proofmass_uncertainty::{Covariance, Finding, Severity};

/// Fewest rate samples from which coefficients are estimated.
const FEWEST_SAMPLES: usize = 64;

/// Noise coefficients of a rate record by maximum Whittle likelihood.
///
/// The record, freed from its straight line, is seen through three sine tapers; their spectrum, averaged over
/// bins of a tenth of their frequency, has gamma-distributed values Ī_b with ν_b degrees of freedom about the
/// model density S_b = Σ c_t² g_t. Minimised is Σ ν_b (ln S_b + Ī_b/S_b) over every combination of terms with positive
/// squares; a term is kept only if it gains more than chance at the stated false-alarm rate. Intervals come from
/// the Fisher information, as χ² for the squares.
///
/// The ramp is the least-squares slope, judged against its variance under the fitted noise.
///
/// **Units** `rate` in U = `options.unit`, `sample_rate` in Hz; coefficients as [`NoiseModel`].
///
/// **Assumes** even sampling, Gaussian noise, stationary increments. When the spectrum departs from every
/// combination of terms (finding `noise-model-misfit`), the departure is taken as an uncertainty of every bin.
///
/// **Memory** some 50 bytes per sample: recordings of more than a few hundred million samples are averaged to a lower
/// rate first (which changes neither N, B nor K) or seen through [`StreamingAllan`](crate::StreamingAllan) and
/// [`fit_curve`](crate::fit_curve).
///
/// **Errors** [`Error::NotFinite`], [`Error::TooFew`] below 64 samples, [`Error::OutOfRange`] for a constant channel
/// (its standard deviation), a sample rate or a probability.
///
/// **Accuracy** intervals hold the truth in 95 % of simulated records (`coverage_white_and_random_walk`); white noise
/// alone shows another term no more often than stated (`law_white_noise_is_white`).
///
/// **Source** `[Whittle1953]`, `[Riedel1995]`.
pub fn whittle(
    rate: &[f64],
    sample_rate: f64,
    options: &FitOptions,
) -> Result<CoefficientFit, Error> {
    check_sample_rate(sample_rate)?;
    check_finite("rate", rate)?;
    check_count("rate samples", rate.len(), FEWEST_SAMPLES)?;
    crate::deviation::check_probability(options.probability)?;
    crate::deviation::check_probability(options.false_alarm_rate)?;
    if !(options.highest_frequency > 0.0 && options.highest_frequency <= 1.0) {
        return Err(Error::OutOfRange {
            name: "highest frequency as a share of the Nyquist frequency",
            value: options.highest_frequency,
            min: 0.0,
            max: 1.0,
        });
    }
    refuse_constant(rate)?;
    let mut detrended = rate.to_vec();
    let trend = Detrend::Linear.remove(&mut detrended, sample_rate)?;
    let mut bins = SpectrumBins::new(detrended, sample_rate, options.highest_frequency);
    check_count("frequency bins", bins.bins.len(), 4)?;

    let mut findings = Vec::new();
    let mut likelihood = Likelihood::new(&bins, options);
    let mut best = likelihood.best(options);
    let mut lines = Vec::new();
    if options.seeks(Term::Sinusoid) {
        lines = bins.lines(&likelihood.model(&best), options.false_alarm_rate);
        if !lines.is_empty() {
            bins.exclude(&lines);
            likelihood = Likelihood::new(&bins, options);
            best = likelihood.best(options);
        }
    }

    let information = likelihood.information(&best.columns, &best.mean);
    let variance = inverse(&information)?;
    if likelihood.discrepancy > 0.0 {
        findings.push(
            Finding::new(
                Severity::Warning,
                "noise-model-misfit",
                "the spectrum departs from every combination of the noise terms",
            )
            .evidence(format!(
                "it departs by {:.1} % (root mean square over {} bins) beyond its scatter",
                100.0 * likelihood.discrepancy,
                bins.bins.len()
            ))
            .advice("look at the density plot for a filter or a resonance; the departure was taken as an uncertainty of every bin, which widens the intervals"),
        );
    }

    let mut coefficients = Vec::new();
    let mut model = NoiseModel::default();
    let mut kept: Vec<(usize, f64)> = Vec::new();
    let needed = options.needed_gain();
    for &term in &sorted(&options.terms) {
        let coefficient = |verdict, parameter| Coefficient {
            term,
            unit: term.unit(&options.unit),
            verdict,
            parameter,
        };
        match term {
            Term::Ramp | Term::Sinusoid => {}
            Term::GaussMarkov => match best.markov_position() {
                Some((position, time)) => {
                    let v = best.squares[position];
                    let u2 = variance[(position, position)];
                    let gain = likelihood.loss_without(&best, position);
                    let verdict = identified(v, u2, gain, options.probability);
                    model.push_markov(v.sqrt(), time);
                    kept.push((position, v));
                    coefficients.push(coefficient(verdict, Some(time)));
                }
                None => coefficients.push(coefficient(
                    Verdict::NotIdentifiable {
                        reason: Reason::OtherTermsSuffice,
                        upper_limit: None,
                    },
                    None,
                )),
            },
            _ => {
                let column = likelihood.column_of(term);
                let verdict = match best.columns.iter().position(|c| Some(*c) == column) {
                    Some(position) => {
                        let v = best.squares[position];
                        let u2 = variance[(position, position)];
                        model.set(term, v.sqrt());
                        kept.push((position, v));
                        let gain = likelihood.loss_without(&best, position);
                        identified(v, u2, gain, options.probability)
                    }
                    None => likelihood.refuse(&best, column, needed, options),
                };
                coefficients.push(coefficient(verdict, None));
            }
        }
    }

    let mut variances = scale_to_coefficients(&variance, &kept);
    if options.seeks(Term::Ramp) {
        let u = slope_uncertainty(&model, rate.len(), sample_rate);
        let slope = trend.slope.abs();
        let z = slope / u;
        let verdict = if z * z > needed && u.is_finite() {
            let k = normal_quantile(0.5 * (1.0 + options.probability));
            model.ramp = trend.slope;
            variances.push((usize::MAX, u * u));
            Verdict::Identified {
                value: slope,
                standard_uncertainty: u,
                interval: ((slope - k * u).max(0.0), slope + k * u),
                gain: z * z,
            }
        } else {
            Verdict::NotIdentifiable {
                reason: Reason::WithinNoise {
                    slope,
                    standard_uncertainty: u,
                },
                upper_limit: Some(slope + normal_quantile(options.probability) * u),
            }
        };
        coefficients.push(Coefficient {
            term: Term::Ramp,
            unit: Term::Ramp.unit(&options.unit),
            verdict,
            parameter: None,
        });
    }
    for &index in &lines {
        let (amplitude, frequency, phase) = line_at(rate, &bins, index);
        let density = model.density(frequency, sample_rate);
        // Variance of an amplitude: one-sided density over the record length, times the tapers' loss.
        let u = (density * sample_rate / rate.len() as f64).sqrt();
        let k = normal_quantile(0.5 * (1.0 + options.probability));
        model.push_line(amplitude, frequency, phase);
        variances.push((usize::MAX, u * u));
        coefficients.push(Coefficient {
            term: Term::Sinusoid,
            unit: options.unit.clone(),
            verdict: Verdict::Identified {
                value: amplitude,
                standard_uncertainty: u,
                interval: ((amplitude - k * u).max(0.0), amplitude + k * u),
                gain: (amplitude / u).powi(2),
            },
            parameter: Some(frequency),
        });
    }
    let covariance = covariance(&variance, &kept, &variances)?;
    Ok(CoefficientFit {
        method: Method::Whittle,
        probability: options.probability,
        false_alarm_rate: options.false_alarm_rate,
        coefficients,
        model,
        covariance,
        discrepancy: likelihood.discrepancy,
        findings,
    })
}

/// A channel without variation has no noise to describe.
pub(crate) fn refuse_constant(rate: &[f64]) -> Result<(), Error> {
    let first = rate[0];
    if rate.iter().all(|v| *v == first) {
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

/// Positions with the variances of the coefficients themselves, from those of their squares.
fn scale_to_coefficients(variance: &Mat<f64>, kept: &[(usize, f64)]) -> Vec<(usize, f64)> {
    kept.iter()
        .map(|&(i, v)| (i, variance[(i, i)] / (4.0 * v)))
        .collect()
}

/// Covariance of the identified coefficients: joint for those of the spectrum, independent for ramp and lines.
fn covariance(
    variance: &Mat<f64>,
    kept: &[(usize, f64)],
    variances: &[(usize, f64)],
) -> Result<Covariance, Error> {
    let n = variances.len();
    let mut rows = vec![0.0; n * n];
    for i in 0..n {
        rows[i * n + i] = variances[i].1;
        for j in 0..i.min(kept.len()) {
            if i < kept.len() {
                let ((a, va), (b, vb)) = (kept[i], kept[j]);
                let value = variance[(a, b)] / (4.0 * (va * vb).sqrt());
                rows[i * n + j] = value;
                rows[j * n + i] = value;
            }
        }
    }
    Covariance::try_from_rows(n, &rows)
}

/// Amplitude, frequency and phase of the line near a Fourier index, by maximising the periodogram.
fn line_at(rate: &[f64], bins: &SpectrumBins, index: usize) -> (f64, f64, f64) {
    let n = rate.len() as f64;
    let mean = rate.iter().sum::<f64>() / n;
    let phasor = |cycles: f64| {
        let step = 2.0 * std::f64::consts::PI * cycles / n;
        let (mut c, mut s) = (0.0, 0.0);
        for (k, y) in rate.iter().enumerate() {
            let (sin, cos) = (step * k as f64).sin_cos();
            c += (y - mean) * cos;
            s += (y - mean) * sin;
        }
        (2.0 * c / n, 2.0 * s / n)
    };
    let power = |cycles: f64| {
        let (c, s) = phasor(cycles);
        c * c + s * s
    };
    // Coarse search over the tapers' bandwidth, then golden sections within one coarse step.
    let centre = index as f64;
    let coarse = (-8..=8)
        .map(|k| centre + 0.25 * f64::from(k))
        .max_by(|a, b| power(*a).total_cmp(&power(*b)))
        .unwrap_or(centre);
    let (mut low, mut high) = (coarse - 0.25, coarse + 0.25);
    let golden = 0.618_033_988_749_895;
    for _ in 0..16 {
        let a = high - golden * (high - low);
        let b = low + golden * (high - low);
        if power(a) > power(b) {
            high = b;
        } else {
            low = a;
        }
    }
    let cycles = 0.5 * (low + high);
    let (c, s) = phasor(cycles);
    (c.hypot(s), bins.frequency(cycles), c.atan2(s))
}

//! Coefficients by maximum likelihood on the spectrum (Whittle), with the terms chosen by the data.

use crate::coefficients::identified;
use crate::record::{check_count, check_finite, check_sample_rate};
use crate::spectrum_bins::SpectrumBins;
use crate::{Coefficient, CoefficientFit, FitOptions, Method, NoiseModel, Reason, Term, Verdict};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use proofmass_core::Error;
use proofmass_signal::Detrend;
use proofmass_uncertainty::{Covariance, Finding, Severity};

/// Fewest rate samples from which coefficients are estimated.
const FEWEST_SAMPLES: usize = 64;

/// Candidate correlation times per decade of a Gauss–Markov process.
const TIMES_PER_DECADE: f64 = 4.0;

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

fn sorted(terms: &[Term]) -> Vec<Term> {
    let mut terms = terms.to_vec();
    terms.sort();
    terms.dedup();
    terms
}

pub(crate) fn normal_quantile(p: f64) -> f64 {
    use statrs::distribution::{ContinuousCDF, Normal};
    Normal::standard().inverse_cdf(p)
}

/// One column of the design: a power law or a Gauss–Markov process of some correlation time.
struct Column {
    term: Term,
    correlation_time: Option<f64>,
    values: Vec<f64>,
}

struct Likelihood<'a> {
    bins: &'a SpectrumBins,
    columns: Vec<Column>,
    /// Degrees of freedom of each bin, with the discrepancy.
    dof: Vec<f64>,
    /// Relative standard departure of the bins from every model, zero unless one is needed.
    discrepancy: f64,
}

/// A combination of terms at its maximum.
struct Combination {
    columns: Vec<usize>,
    squares: Vec<f64>,
    mean: Vec<f64>,
    /// −2 log-likelihood up to a constant.
    deviance: f64,
    correlation_time: Option<(usize, f64)>,
}

impl Combination {
    fn markov_position(&self) -> Option<(usize, f64)> {
        self.correlation_time
    }
}

impl<'a> Likelihood<'a> {
    fn new(bins: &'a SpectrumBins, options: &FitOptions) -> Self {
        let mut columns = Vec::new();
        for &term in &sorted(&options.terms) {
            match term {
                Term::Quantisation | Term::White | Term::Flicker | Term::RandomWalk => {
                    columns.push(Column {
                        term,
                        correlation_time: None,
                        values: bins.term(term),
                    });
                }
                Term::GaussMarkov => {
                    // Shorter times look white, longer ones like a random walk.
                    let shortest = 3.0 / bins.sample_rate;
                    let longest = bins.n as f64 / bins.sample_rate / 12.0;
                    let count = ((longest / shortest).log10() * TIMES_PER_DECADE).ceil();
                    for k in 0..=count.max(0.0) as usize {
                        let time = shortest * 10_f64.powf(k as f64 / TIMES_PER_DECADE);
                        if time <= longest {
                            columns.push(Column {
                                term,
                                correlation_time: Some(time),
                                values: bins.markov(time),
                            });
                        }
                    }
                }
                Term::Ramp | Term::Sinusoid => {}
            }
        }
        Self {
            bins,
            columns,
            dof: bins.bins.iter().map(|b| b.dof).collect(),
            discrepancy: 0.0,
        }
    }

    fn column_of(&self, term: Term) -> Option<usize> {
        self.columns.iter().position(|c| c.term == term)
    }

    /// The combination of least penalised deviance.
    ///
    /// When even the richest combination leaves a deviance that chance exceeds once in a thousand, the model is wrong by some
    /// relative amount δ in every bin: the degrees of freedom become 1/(1/ν + δ²/2), with the δ that brings the deviance
    /// to its expectation. High frequencies with their thousands of degrees of freedom then no longer outvote the
    /// low ones that hold the random walk.
    fn best(&mut self, options: &FitOptions) -> Combination {
        let fits = self.combinations();
        let floor = self.floor(&fits);
        let expected = (self.bins.bins.len() as f64 - 4.0).max(1.0);
        let limit = crate::edf::chi_square_quantile(0.999, expected).unwrap_or(f64::INFINITY);
        if floor <= limit {
            return self.choose(fits, options);
        }
        let (mut low, mut high) = (1e-4_f64, 3.0_f64);
        for _ in 0..12 {
            let middle = (low * high).sqrt();
            self.set_discrepancy(middle);
            let fits = self.combinations();
            if self.floor(&fits) > expected {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.set_discrepancy(high);
        let fits = self.combinations();
        self.choose(fits, options)
    }

    fn set_discrepancy(&mut self, discrepancy: f64) {
        self.discrepancy = discrepancy;
        self.dof = self
            .bins
            .bins
            .iter()
            .map(|b| 1.0 / (1.0 / b.dof + 0.5 * discrepancy * discrepancy))
            .collect();
    }

    fn floor(&self, fits: &[Combination]) -> f64 {
        fits.iter()
            .map(|f| f.deviance)
            .fold(self.mean_only().deviance, f64::min)
    }

    /// Every combination of terms that has positive squares.
    fn combinations(&self) -> Vec<Combination> {
        let powers: Vec<usize> = (0..self.columns.len())
            .filter(|&c| self.columns[c].correlation_time.is_none())
            .collect();
        let markov: Vec<usize> = (0..self.columns.len())
            .filter(|&c| self.columns[c].correlation_time.is_some())
            .collect();
        let mut fits = Vec::new();
        for subset in 0_usize..1 << powers.len() {
            let chosen: Vec<usize> = powers
                .iter()
                .enumerate()
                .filter(|(i, _)| subset >> i & 1 == 1)
                .map(|(_, c)| *c)
                .collect();
            if !chosen.is_empty() {
                fits.extend(self.fit(&chosen));
            }
            fits.extend(markov.iter().filter_map(|&m| {
                let mut with = chosen.clone();
                with.push(m);
                self.fit(&with)
            }));
        }
        fits
    }

    fn choose(&self, fits: Vec<Combination>, options: &FitOptions) -> Combination {
        let needed = options.needed_gain();
        // A correlation time is a further parameter found by search over some dozens of independent places.
        let times = self
            .columns
            .iter()
            .filter(|c| c.correlation_time.is_some())
            .count();
        let search = 2.0 * (times.max(1) as f64).ln() + 2.0;
        let cost = |f: &Combination| {
            let searched = if f.correlation_time.is_some() {
                search
            } else {
                0.0
            };
            f.deviance + needed * f.columns.len() as f64 + searched
        };
        fits.into_iter()
            .min_by(|a, b| cost(a).total_cmp(&cost(b)))
            .unwrap_or_else(|| self.mean_only())
    }

    /// White noise as it stands: used only if no combination could be fitted.
    fn mean_only(&self) -> Combination {
        let total: f64 = self.dof.iter().sum();
        let mean = self
            .bins
            .bins
            .iter()
            .zip(&self.dof)
            .map(|(b, nu)| nu * b.mean)
            .sum::<f64>()
            / total.max(1e-9);
        let means = vec![mean; self.bins.bins.len()];
        let column = self.column_of(Term::White).unwrap_or(0);
        let unit = self.columns.get(column).map_or(2.0, |c| c.values[0]);
        Combination {
            columns: vec![column],
            squares: vec![mean / unit],
            deviance: self.deviance(&means),
            mean: means,
            correlation_time: None,
        }
    }

    /// Σ ν (Ī/S − 1 − ln(Ī/S)): zero for a perfect fit, about the number of bins for a right model.
    fn deviance(&self, mean: &[f64]) -> f64 {
        self.bins
            .bins
            .iter()
            .zip(&self.dof)
            .zip(mean)
            .map(|((bin, nu), s)| {
                let ratio = bin.mean / s;
                nu * (ratio - 1.0 - ratio.ln())
            })
            .sum()
    }

    /// Maximum likelihood of one combination by Fisher scoring; `None` when a square would be negative.
    fn fit(&self, chosen: &[usize]) -> Option<Combination> {
        let mut weights_from: Vec<f64> = self.bins.bins.iter().map(|b| b.mean).collect();
        let mut squares = Vec::new();
        let mut last = f64::INFINITY;
        for _ in 0..60 {
            squares = self.scoring_step(chosen, &weights_from)?;
            let mean = self.mean(chosen, &squares);
            if mean.iter().any(|s| !(*s > 0.0)) {
                // A small negative square on the way may recover: restart from the positive part.
                let positive: Vec<f64> = squares.iter().map(|v| v.max(0.0)).collect();
                let repaired = self.mean(chosen, &positive);
                if repaired.iter().any(|s| !(*s > 0.0)) {
                    return None;
                }
                weights_from = repaired;
                continue;
            }
            let deviance = self.deviance(&mean);
            weights_from = mean;
            if (last - deviance).abs() < 1e-9 * (1.0 + deviance.abs()) {
                break;
            }
            last = deviance;
        }
        if squares.iter().any(|v| !(*v > 0.0)) {
            return None;
        }
        let mean = self.mean(chosen, &squares);
        let correlation_time = chosen
            .iter()
            .enumerate()
            .find_map(|(i, &c)| self.columns[c].correlation_time.map(|t| (i, t)));
        Some(Combination {
            columns: chosen.to_vec(),
            deviance: self.deviance(&mean),
            squares,
            mean,
            correlation_time,
        })
    }

    fn mean(&self, chosen: &[usize], squares: &[f64]) -> Vec<f64> {
        (0..self.bins.bins.len())
            .map(|b| {
                chosen
                    .iter()
                    .zip(squares)
                    .map(|(&c, v)| v * self.columns[c].values[b])
                    .sum()
            })
            .collect()
    }

    /// Σ_b ν/(2 S²) g_i g_j.
    fn information(&self, chosen: &[usize], mean: &[f64]) -> Mat<f64> {
        let p = chosen.len();
        Mat::from_fn(p, p, |i, j| {
            let (a, b) = (
                &self.columns[chosen[i]].values,
                &self.columns[chosen[j]].values,
            );
            self.dof
                .iter()
                .enumerate()
                .map(|(k, nu)| 0.5 * nu * (a[k] / mean[k]) * (b[k] / mean[k]))
                .sum::<f64>()
        })
    }

    /// Weighted least squares of the spectrum with the weights of a mean.
    fn scoring_step(&self, chosen: &[usize], mean: &[f64]) -> Option<Vec<f64>> {
        let p = chosen.len();
        let information = self.information(chosen, mean);
        let score = Mat::from_fn(p, 1, |i, _| {
            let a = &self.columns[chosen[i]].values;
            self.bins
                .bins
                .iter()
                .enumerate()
                .map(|(k, bin)| 0.5 * self.dof[k] * (a[k] / mean[k]) * (bin.mean / mean[k]))
                .sum::<f64>()
        });
        // Columns of very different size are brought to unit diagonal.
        let d: Vec<f64> = (0..p).map(|i| 1.0 / information[(i, i)].sqrt()).collect();
        let scaled = Mat::from_fn(p, p, |i, j| information[(i, j)] * d[i] * d[j]);
        let right = Mat::from_fn(p, 1, |i, _| score[(i, 0)] * d[i]);
        let solution = scaled.llt(Side::Lower).ok()?.solve(&right);
        let squares: Vec<f64> = (0..p).map(|i| solution[(i, 0)] * d[i]).collect();
        squares.iter().all(|v| v.is_finite()).then_some(squares)
    }

    /// Twice the loss of log-likelihood without one column, the others refitted.
    fn loss_without(&self, best: &Combination, position: usize) -> f64 {
        let others: Vec<usize> = best
            .columns
            .iter()
            .enumerate()
            .filter(|(i, _)| *i != position)
            .map(|(_, c)| *c)
            .collect();
        let without = if others.is_empty() {
            // Alone it cannot be left out: compared with white noise of the same mean.
            self.mean_only().deviance
        } else {
            self.fit(&others).map_or(f64::INFINITY, |f| f.deviance)
        };
        (without - best.deviance).clamp(0.0, f64::MAX)
    }

    /// Verdict on a term that was not kept: the gain it would bring, and what it cannot exceed.
    fn refuse(
        &self,
        best: &Combination,
        column: Option<usize>,
        needed: f64,
        options: &FitOptions,
    ) -> Verdict {
        let mut with = best.columns.clone();
        with.extend(column);
        let gain = self
            .fit(&with)
            .map_or(0.0, |f| (best.deviance - f.deviance).max(0.0));
        let reason = if gain > needed {
            Reason::OtherTermsSuffice
        } else {
            Reason::NoSupport { gain, needed }
        };
        // One scoring step from the fitted model gives the square, possibly negative, and its variance.
        let upper_limit = self.scoring_step(&with, &best.mean).and_then(|squares| {
            let variance = inverse(&self.information(&with, &best.mean)).ok()?;
            let last = with.len() - 1;
            let u = variance[(last, last)].sqrt();
            let limit = squares[last].max(0.0) + normal_quantile(options.probability) * u;
            limit.is_finite().then_some(limit.sqrt())
        });
        Verdict::NotIdentifiable {
            reason,
            upper_limit,
        }
    }

    fn model(&self, best: &Combination) -> NoiseModel {
        let mut model = NoiseModel::default();
        for (&c, v) in best.columns.iter().zip(&best.squares) {
            match self.columns[c].correlation_time {
                Some(time) => model.push_markov(v.sqrt(), time),
                None => model.set(self.columns[c].term, v.sqrt()),
            }
        }
        model
    }
}

fn inverse(information: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let p = information.nrows();
    let d: Vec<f64> = (0..p).map(|i| 1.0 / information[(i, i)].sqrt()).collect();
    let scaled = Mat::from_fn(p, p, |i, j| information[(i, j)] * d[i] * d[j]);
    let llt = scaled.llt(Side::Lower).map_err(|_| Error::Singular {
        name: "information of the noise coefficients",
        condition: f64::INFINITY,
    })?;
    let unit = llt.solve(&Mat::<f64>::identity(p, p));
    Ok(Mat::from_fn(p, p, |i, j| unit[(i, j)] * d[i] * d[j]))
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

/// Standard uncertainty of the least-squares slope under a noise model, U/s.
///
/// White noise gives 12N²/T³, a random walk 6K²/(5T), flicker 3B²·(2/π)/T² and quantisation 72Q²/(T⁴·rate)… the
/// integrals ∫ S |W|² df of the slope's weights W; a Gauss–Markov process lies between the first two.
fn slope_uncertainty(model: &NoiseModel, n: usize, sample_rate: f64) -> f64 {
    let t = n as f64 / sample_rate;
    // |W(f)|² of the continuous least-squares slope: 36/(π f T²)² · (sinc x − cos x)² with x = π f T, sinc x = sin x/x.
    let steps = 400;
    let (low, high) = (1e-3_f64.ln(), (0.5 * n as f64).max(2.0).ln());
    let width = (high - low) / steps as f64;
    let sum: f64 = (0..steps)
        .map(|i| {
            // Jittered by the golden ratio, so that the oscillation averages out.
            let jitter = (i as f64 * 0.618_033_988_749_895).fract();
            let cycles = (low + (i as f64 + jitter) * width).exp();
            let f = cycles / t;
            let x = std::f64::consts::PI * cycles;
            let shape = if x < 1e-2 {
                x * x / 3.0
            } else {
                x.sin() / x - x.cos()
            };
            let w = 6.0 / (x * t) * shape;
            model.density(f, sample_rate) * w * w * f * width
        })
        .sum();
    sum.sqrt()
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

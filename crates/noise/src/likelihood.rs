//! The Whittle likelihood of combinations of noise terms, and the choice among them.

use crate::spectrum_bins::SpectrumBins;
use crate::whittle::normal_quantile;
use crate::{FitOptions, NoiseModel, Reason, Term, Verdict};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use proofmass_core::Error;

/// Candidate correlation times per decade of a Gauss–Markov process.
const TIMES_PER_DECADE: f64 = 4.0;

pub(crate) fn sorted(terms: &[Term]) -> Vec<Term> {
    let mut terms = terms.to_vec();
    terms.sort();
    terms.dedup();
    terms
}

/// One column of the design: a power law or a Gauss–Markov process of some correlation time.
struct Column {
    term: Term,
    correlation_time: Option<f64>,
    values: Vec<f64>,
}

pub(crate) struct Likelihood<'a> {
    bins: &'a SpectrumBins,
    columns: Vec<Column>,
    /// Degrees of freedom of each bin, with the discrepancy.
    dof: Vec<f64>,
    /// Relative standard departure of the bins from every model, zero unless one is needed.
    pub(crate) discrepancy: f64,
}

/// A combination of terms at its maximum.
pub(crate) struct Combination {
    pub(crate) columns: Vec<usize>,
    pub(crate) squares: Vec<f64>,
    pub(crate) mean: Vec<f64>,
    /// −2 log-likelihood up to a constant.
    deviance: f64,
    correlation_time: Option<(usize, f64)>,
}

impl Combination {
    pub(crate) fn markov_position(&self) -> Option<(usize, f64)> {
        self.correlation_time
    }
}

impl<'a> Likelihood<'a> {
    pub(crate) fn new(bins: &'a SpectrumBins, options: &FitOptions) -> Self {
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

    pub(crate) fn column_of(&self, term: Term) -> Option<usize> {
        self.columns.iter().position(|c| c.term == term)
    }

    /// The combination of least penalised deviance.
    ///
    /// When even the richest combination leaves a deviance that chance exceeds once in a thousand, the model is wrong by some
    /// relative amount δ in every bin: the degrees of freedom become 1/(1/ν + δ²/2), with the δ that brings the deviance
    /// to its expectation. High frequencies with their thousands of degrees of freedom then no longer outvote the
    /// low ones that hold the random walk.
    pub(crate) fn best(&mut self, options: &FitOptions) -> Combination {
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
            if mean.iter().any(|s| s.is_nan() || *s <= 0.0) {
                // A small negative square on the way may recover: restart from the positive part.
                let positive: Vec<f64> = squares.iter().map(|v| v.max(0.0)).collect();
                let repaired = self.mean(chosen, &positive);
                if repaired.iter().any(|s| s.is_nan() || *s <= 0.0) {
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
        if squares.iter().any(|v| v.is_nan() || *v <= 0.0) {
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
    pub(crate) fn information(&self, chosen: &[usize], mean: &[f64]) -> Mat<f64> {
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
    pub(crate) fn loss_without(&self, best: &Combination, position: usize) -> f64 {
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
    pub(crate) fn refuse(
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

    pub(crate) fn model(&self, best: &Combination) -> NoiseModel {
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

pub(crate) fn inverse(information: &Mat<f64>) -> Result<Mat<f64>, Error> {
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

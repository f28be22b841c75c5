//! The fit without gross outliers, beside the ordinary one.

use crate::cosine_spectrum::{cosines, inverse_cosines};
use crate::fit_record::FitRecord;
use crate::{CoefficientFit, FitOptions, Term, Verdict, whittle_record};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Residual, in robust standard deviations, from which a sample is replaced.
const OUTLIER: f64 = 4.0;

/// Variance of a Gaussian sample that lies within: 1 − 2·4 φ(4)/(1 − 2 Q(4)).
const WITHIN: f64 = 0.998_929;

/// Rounds of search and replacement; neighbours of an outlier are judged without it.
const ROUNDS: usize = 4;

/// Largest share of a record that is replaced; beyond it what is replaced is no outlier.
const MOST: f64 = 0.1;

/// Width of the smoothing of the spectrum that predicts a sample, relative to its frequency.
const WIDTH: f64 = 0.05;

/// Coefficients after gross outliers were replaced by what their neighbours predict, and how they differ from the ordinary ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RobustFit {
    /// The fit; N with the variance that the replaced samples lack.
    pub fit: CoefficientFit,
    /// Samples replaced.
    pub replaced: usize,
    /// Ordinary less robust value of each coefficient that both give, in standard uncertainties of the robust one.
    pub differences: Vec<(Term, f64)>,
}

/// Fits without gross outliers.
///
/// The residual of every sample is what all others do not predict, C⁻¹y/diag C⁻¹ with the smoothed spectrum of the record as
/// covariance. Beyond four robust standard deviations (1.4826 times the median magnitude) a sample is replaced by its prediction,
/// and all are judged again. The influence of one sample is bounded; of Gaussian noise one sample in 16 000 is replaced, and N
/// corrected for it.
///
/// **Errors** as [`whittle_record`](crate::whittle_record); [`Error::OutOfRange`] when more than a tenth of the samples would be replaced.
pub fn robust_fit(
    record: &FitRecord<'_>,
    ordinary: &CoefficientFit,
    sample_rate: f64,
    options: &FitOptions,
) -> Result<RobustFit, Error> {
    let mut replaced = 0;
    let mut cleaned: Vec<Vec<f64>> = Vec::with_capacity(record.stretches.len());
    for stretch in record.stretches {
        let (samples, count) = without_outliers(stretch, sample_rate);
        replaced += count;
        cleaned.push(samples);
    }
    let share = replaced as f64 / record.samples().max(1) as f64;
    if share > MOST {
        return Err(Error::OutOfRange {
            name: "share of outliers",
            value: share,
            min: 0.0,
            max: MOST,
        });
    }
    let parts: Vec<&[f64]> = cleaned.iter().map(Vec::as_slice).collect();
    let mut fit = whittle_record(
        &FitRecord {
            stretches: &parts,
            ..*record
        },
        sample_rate,
        options,
    )?;
    // What was replaced has no white noise of its own, what was kept too little.
    let lacking = (1.0 / ((1.0 - share) * WITHIN)).sqrt();
    fit.model.white *= lacking;
    for c in fit
        .coefficients
        .iter_mut()
        .filter(|c| c.term == Term::White)
    {
        scale(&mut c.verdict, lacking);
    }
    let differences = fit
        .coefficients
        .iter()
        .filter(|c| !matches!(c.term, Term::GaussMarkov | Term::Sinusoid))
        .filter_map(|c| {
            let u = c.verdict.standard_uncertainty().filter(|u| *u > 0.0)?;
            Some((c.term, (ordinary.value(c.term)? - c.verdict.value()?) / u))
        })
        .collect();
    Ok(RobustFit {
        fit,
        replaced,
        differences,
    })
}

fn scale(verdict: &mut Verdict, factor: f64) {
    match verdict {
        Verdict::Identified {
            value,
            standard_uncertainty,
            interval,
            ..
        }
        | Verdict::Present {
            value,
            standard_uncertainty,
            interval,
            ..
        }
        | Verdict::Reported {
            value,
            standard_uncertainty,
            interval,
            ..
        } => {
            *value *= factor;
            *standard_uncertainty *= factor;
            *interval = (interval.0 * factor, interval.1 * factor);
        }
        Verdict::NotIdentifiable {
            estimate,
            upper_limit,
            ..
        } => {
            *estimate = estimate.map(|v| v * factor);
            *upper_limit = upper_limit.map(|v| v * factor);
        }
        Verdict::Fixed { .. } => {}
    }
}

/// A stretch with its outliers replaced by what the other samples predict, and how many.
fn without_outliers(rate: &[f64], sample_rate: f64) -> (Vec<f64>, usize) {
    let n = rate.len();
    let mut samples = rate.to_vec();
    if n < 64 {
        return (samples, 0);
    }
    let mut flagged = vec![false; n];
    for _ in 0..ROUNDS {
        let residuals = unpredicted(&samples, sample_rate);
        let mut magnitudes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
        let (_, median, _) = magnitudes.select_nth_unstable_by(n / 2, f64::total_cmp);
        let limit = OUTLIER * 1.4826 * *median;
        if limit <= 0.0 {
            break;
        }
        let mut more = false;
        for i in 0..n {
            let beyond = residuals[i].abs() > limit;
            // Of a cluster the largest goes first: the others may lean on it.
            let largest = (i.saturating_sub(2)..(i + 3).min(n))
                .all(|j| residuals[j].abs() <= residuals[i].abs());
            if flagged[i] {
                samples[i] -= residuals[i];
            } else if beyond && largest {
                flagged[i] = true;
                samples[i] -= residuals[i];
                more = true;
            }
        }
        if !more {
            break;
        }
    }
    let replaced = flagged.iter().filter(|f| **f).count();
    (samples, replaced)
}

/// What the other samples do not predict of each: C⁻¹y over the diagonal of C⁻¹, C from the smoothed spectrum.
fn unpredicted(rate: &[f64], sample_rate: f64) -> Vec<f64> {
    let n = rate.len();
    let mut c = cosines(rate, sample_rate);
    let mut sums = Vec::with_capacity(n + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for c in &c {
        sum += c * c;
        sums.push(sum);
    }
    let mut diagonal = 0.0;
    for k in 1..n {
        let half = ((WIDTH * k as f64) as usize).max(12);
        let (from, to) = (k.saturating_sub(half).max(1), (k + half + 1).min(n));
        let density = (sums[to] - sums[from]) / (to - from) as f64;
        if density > 0.0 {
            diagonal += 1.0 / density;
            c[k] /= density;
        }
    }
    let mean = diagonal / n as f64;
    let mut residuals = inverse_cosines(&c, sample_rate);
    residuals.iter_mut().for_each(|r| *r /= mean);
    residuals
}

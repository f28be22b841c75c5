//! Calls on arrays that need no command: a deviation, a sine.

use crate::buffer::Numbers;
use crate::call::beside;
use crate::stored_result::refused;
use proofmass::jobs::{Unwatched, Watch};
use proofmass::noise::{DeviationOptions, NoiseRecord, Statistic, Taus, deviation_watched};
use proofmass::signal::sine::{Frequency, Residuals, SineApproximation, dominant_frequency};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// τ, deviation, lower, upper, degrees of freedom, terms.
type Point = (f64, f64, Option<f64>, Option<f64>, Option<f64>, usize);

/// Samples below which a deviation is a matter of milliseconds.
const SHORT: usize = 10_000;

#[pyfunction]
pub(crate) fn allan_deviation(
    py: Python<'_>,
    samples: Bound<'_, PyAny>,
    rate: f64,
    statistic: &str,
    taus: &str,
    probability: f64,
) -> PyResult<Vec<Point>> {
    let samples = Numbers::of(&samples)?;
    let statistic: Statistic = statistic
        .parse()
        .map_err(|e| PyValueError::new_err(format!("statistic: {e}")))?;
    let taus: Taus = taus
        .parse()
        .map_err(|e| PyValueError::new_err(format!("taus: {e}")))?;
    let short = samples.len() < SHORT;
    let options = DeviationOptions {
        taus,
        probability,
        ..DeviationOptions::default()
    };
    let work = move |watch: &dyn Watch| {
        let record = NoiseRecord::Rate(&samples);
        deviation_watched(record, rate, statistic, &options, watch)
    };
    let curve = match short {
        true => py.detach(|| work(&Unwatched)),
        false => beside(py, work)?,
    };
    let points = curve.map_err(refused)?.points.into_iter();
    let of = |p: proofmass::noise::DeviationPoint| {
        let (low, high) = p.interval.unzip();
        (p.tau, p.deviation, low, high, p.edf, p.terms)
    };
    Ok(points.map(of).collect())
}

/// Covariance `[rr, ri, ii]` of the amplitude, its degrees of freedom, offset, root mean square of the residuals.
type Rest = ([f64; 3], f64, f64, f64);

/// Frequency with u (`None` where it was given), complex amplitude, and the rest.
type Sine = (f64, Option<f64>, (f64, f64), Rest);

#[pyfunction]
pub(crate) fn fit_sine(
    py: Python<'_>,
    samples: Bound<'_, PyAny>,
    rate: f64,
    frequency: Option<f64>,
    white: bool,
) -> PyResult<Sine> {
    let samples = Numbers::of(&samples)?;
    let residuals = match white {
        true => Residuals::White,
        false => Residuals::Coloured,
    };
    let fit = py.detach(|| {
        let approximation = match frequency {
            Some(known) => SineApproximation::new(known),
            None => SineApproximation::new(dominant_frequency(rate, &samples)?)
                .frequency(Frequency::Common),
        };
        approximation.residuals(residuals).fit(rate, &[&samples])
    });
    let fit = fit.map_err(refused)?;
    let sine = &fit.channels[0];
    let amplitude = (sine.amplitude.re, sine.amplitude.im);
    let rest = (sine.covariance, sine.dof, sine.offset, sine.residual_rms);
    Ok((fit.frequency, fit.frequency_uncertainty, amplitude, rest))
}

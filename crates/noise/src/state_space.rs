//! Fitted noise as a state-space model for filters, flicker noise included.

use crate::model::{markov_density, term_density};
use crate::record::check_sample_rate;
use crate::{CoefficientFit, Term};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Correlation times of the states that stand for flicker noise, per decade.
const PER_DECADE: f64 = 1.5;

/// The shortest of them in sampling periods: what a faster one would add is white, and the sampled density is best met so.
const SHORTEST: f64 = 0.53;

/// One state of the bias: x_{k+1} = φ x_k + w_k, w of variance q, from a variance p₀.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BiasComponent {
    /// The term it belongs to.
    pub term: Term,
    /// Correlation time in s; `None` for a random walk.
    pub time: Option<f64>,
    /// Stationary standard deviation, U; `None` for a random walk.
    pub standard_deviation: Option<f64>,
    /// φ of one sampling period.
    pub transition: f64,
    /// Variance of w over one sampling period, U².
    pub process: f64,
}

/// A rate y = (true rate) + Σ x + v with v white of variance R: the noise of a sensor for a Kalman filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StateSpace {
    /// Samples per second.
    pub sample_rate: f64,
    /// R, variance of the white part of one sample, N² times the rate, U².
    pub measurement_variance: f64,
    /// States of the bias.
    pub components: Vec<BiasComponent>,
    /// Band in Hz in which the states stand for the flicker noise; `None` without any.
    pub flicker_band: Option<(f64, f64)>,
    /// Largest relative error of their density there.
    pub flicker_error: Option<f64>,
    /// Whether the random walk is the upper limit of K, because its most likely value is zero.
    pub random_walk_is_limit: bool,
}

/// A fit as states: a random walk, the Gauss–Markov processes, and first-order processes for the flicker noise.
///
/// Flicker noise has no finite state. Processes with correlation times T_j in steps of r = 10^{2/3}, from half a sampling period to a decade
/// and a half beyond the record, and variances (B²/π) ln r have its density on average over the steps. The largest error from 1/T to f_s/4
/// is computed, sampling included, and stated: about 2 %.
///
/// The most likely values are used, identified or not. Where that of K is zero its upper limit stands in: no filter is told that a bias
/// cannot move. Quantisation, ramp and sinusoids are not part of the model.
///
/// **Units** `duration` of the record in s, `sample_rate` in Hz; variances in the square of the rate's unit.
///
/// **Errors** [`Error::OutOfRange`] for a rate or duration that is not positive.
///
/// **Source** `[Keshner1982]`.
///
/// ```
/// use proofmass_noise::{FitOptions, NoiseModel, SimulatedSensor, Term, state_space, whittle};
/// let sensor = SimulatedSensor::new(NoiseModel { white: 1.0, flicker: 0.5, ..Default::default() });
/// let y = sensor.record(1, 20_000, 10.0, 3).unwrap().remove(0);
/// let fit = whittle(&y, 10.0, &FitOptions::default()).unwrap();
/// let states = state_space(&fit, 10.0, 2000.0).unwrap();
/// assert!((states.measurement_variance / 10.0 - 1.0).abs() < 0.05);
/// assert!(states.flicker_error.unwrap() < 0.05);
/// // A bias that cannot move is never among them.
/// assert!(states.components.iter().all(|c| c.process > 0.0));
/// ```
pub fn state_space(
    fit: &CoefficientFit,
    sample_rate: f64,
    duration: f64,
) -> Result<StateSpace, Error> {
    check_sample_rate(sample_rate)?;
    proofmass_core::check::positive("duration", duration)?;
    let period = 1.0 / sample_rate;
    let (walk, random_walk_is_limit) = fit.random_walk_or_limit();
    let mut components = Vec::new();
    if walk > 0.0 {
        components.push(BiasComponent {
            term: Term::RandomWalk,
            time: None,
            standard_deviation: None,
            transition: 1.0,
            process: walk * walk * period,
        });
    }
    for g in &fit.model.gauss_markov {
        components.push(first_order(
            Term::GaussMarkov,
            g.standard_deviation,
            g.correlation_time,
            period,
        ));
    }
    let b = fit.model.flicker;
    let (mut flicker_band, mut flicker_error) = (None, None);
    let band = (1.0 / duration, 0.25 * sample_rate);
    if b > 0.0 && band.0 < band.1 {
        let step = 10_f64.powf(1.0 / PER_DECADE);
        let sigma = (b * b / PI * step.ln()).sqrt();
        let shortest = SHORTEST * period;
        let longest = 10_f64.powf(1.5) / (2.0 * PI * band.0);
        let count = ((longest / shortest).ln() / step.ln()).ceil() as i32;
        let times: Vec<f64> = (0..=count).map(|j| shortest * step.powi(j)).collect();
        let points = 400;
        let worst = (0..=points)
            .map(|k| {
                let f = band.0 * (band.1 / band.0).powf(f64::from(k) / f64::from(points));
                let all: f64 = times
                    .iter()
                    .map(|t| sigma * sigma * markov_density(*t, f, sample_rate))
                    .sum();
                (all / (b * b * term_density(Term::Flicker, f, sample_rate)) - 1.0).abs()
            })
            .fold(0.0, f64::max);
        components.extend(
            times
                .iter()
                .map(|t| first_order(Term::Flicker, sigma, *t, period)),
        );
        (flicker_band, flicker_error) = (Some(band), Some(worst));
    }
    Ok(StateSpace {
        sample_rate,
        measurement_variance: fit.model.white.powi(2) * sample_rate,
        components,
        flicker_band,
        flicker_error,
        random_walk_is_limit,
    })
}

fn first_order(term: Term, sigma: f64, time: f64, period: f64) -> BiasComponent {
    BiasComponent {
        term,
        time: Some(time),
        standard_deviation: Some(sigma),
        transition: (-period / time).exp(),
        process: -sigma * sigma * (-2.0 * period / time).exp_m1(),
    }
}

//! Samples at instants of their own: the sine is fitted where each of them was taken.

use super::{Frequency, SineApproximation, SineFit};
use num_complex::Complex64;
use proofmass_core::Error;
use std::f64::consts::TAU;

/// Rounds in which the samples are moved to an even grid along the sine that was found.
const ROUNDS: usize = 40;
/// Change of an amplitude, in standard uncertainties, at which the rounds end …
const AGREED: f64 = 1e-3;
/// … or relative to it, where there is no noise.
const ROUNDING: f64 = 1e-13;

impl SineApproximation {
    /// Fits samples that were taken at n/`sampling_frequency` + `late[n]` seconds, as their time stamps say.
    ///
    /// In each round the samples are moved to the even grid along the sine of the round before, and fitted there. What
    /// is left at the end are the residuals at the instants themselves, so that a sine without noise is returned
    /// exactly, and drift, harmonics, tones and noise of any colour are treated as on an even grid.
    ///
    /// **Assumes** that the places in the grid are within some tenths of a period of the instants.
    ///
    /// **Accuracy** `law_a_sine_is_found_at_its_own_instants`, `coverage_at_jittered_instants`.
    ///
    /// # Errors
    /// As [`SineApproximation::fit`]; [`Error::Length`] for another number of instants than samples,
    /// [`Error::NotFinite`], [`Error::NotConverged`] for instants too far from an even grid.
    pub fn fit_at(
        &self,
        sampling_frequency: f64,
        late: &[f64],
        channels: &[&[f64]],
    ) -> Result<SineFit, Error> {
        let mut fit = self.fit(sampling_frequency, channels)?;
        let samples = channels.first().map_or(0, |c| c.len());
        if late.len() != samples {
            return Err(Error::Length {
                name: "time stamps",
                expected: samples,
                got: late.len(),
            });
        }
        proofmass_core::check::finite("time stamps", late)?;
        if late.iter().all(|t| *t == 0.0) {
            return Ok(fit);
        }
        let mut step = f64::INFINITY;
        for _ in 0..ROUNDS {
            let moved: Vec<Vec<f64>> = channels
                .iter()
                .enumerate()
                .map(|(k, x)| evenly(&fit, k, sampling_frequency, late, x))
                .collect();
            let views: Vec<&[f64]> = moved.iter().map(Vec::as_slice).collect();
            let again = match self.frequency {
                Frequency::Common => self.clone().start(fit.frequency),
                Frequency::Known => self.clone(),
            };
            let next = again.fit(sampling_frequency, &views)?;
            step = next
                .channels
                .iter()
                .zip(&fit.channels)
                .map(|(a, b)| {
                    let u = (a.covariance[0] + a.covariance[2]).sqrt();
                    let enough = (AGREED * u).max(ROUNDING * a.amplitude.norm());
                    (a.amplitude - b.amplitude).norm() / enough.max(f64::MIN_POSITIVE)
                })
                .fold(0.0, f64::max);
            fit = next;
            if step <= 1.0 {
                return Ok(fit);
            }
        }
        Err(Error::NotConverged {
            name: "sine at its own instants",
            iterations: ROUNDS,
            step,
        })
    }
}

/// The samples of channel `k` as an even grid would have had them, were they the sine that was found.
fn evenly(fit: &SineFit, k: usize, sampling_frequency: f64, late: &[f64], x: &[f64]) -> Vec<f64> {
    let c = &fit.channels[k];
    let turn = TAU * fit.frequency;
    let own: Vec<(f64, Complex64)> = std::iter::once(&c.amplitude)
        .chain(&c.harmonics)
        .enumerate()
        .map(|(h, a)| ((h + 1) as f64 * turn, *a))
        .chain(
            fit.tones
                .iter()
                .map(|t| (TAU * t.frequency, t.amplitudes[k])),
        )
        .collect();
    x.iter()
        .zip(late)
        .enumerate()
        .map(|(i, (x, late))| {
            if *late == 0.0 {
                return *x;
            }
            let even = i as f64 / sampling_frequency;
            let waves: f64 = own
                .iter()
                .map(|(omega, a)| {
                    let there = a * Complex64::from_polar(1.0, omega * even);
                    // e^{jωδ} − 1 without cancellation.
                    let (sin, _) = (0.5 * omega * late).sin_cos();
                    let off = Complex64::new(-2.0 * sin * sin, (omega * late).sin());
                    (there * off).re
                })
                .sum();
            x - waves - c.drift * late
        })
        .collect()
}

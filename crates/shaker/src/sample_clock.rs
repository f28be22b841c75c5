//! The clock of a digital sensor beside that of the bench: its error by the sine, or the delay of its samples.

use super::recording::Quality;
use crate::findings;
use crate::observation::ascending;
use proofmass_uncertainty::chi_squared_chance;
use proofmass_uncertainty::{DegreesOfFreedom, Finding};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// By whose clock a sensor samples that has a file of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SampleClock {
    /// Its own: moduli are calibrated, and phases among its own channels, but none against the reference.
    Own,
    /// One clock stamps both files, and their times count from one zero.
    Shared,
}

/// Error of a sensor's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ClockError {
    /// Samples it takes in a second over those it says, less one.
    pub relative: f64,
    /// Its standard uncertainty; that of the scatter between the runs where they scatter beyond their own.
    pub standard_uncertainty: f64,
    /// Degrees of freedom of that scatter, infinite where it is not used.
    pub dof: DegreesOfFreedom,
    /// Runs it is the mean of.
    pub runs: usize,
    /// Standard deviation of the runs.
    pub scatter: f64,
}

/// Chance of a scatter this large from which on it is told.
const TOLD: f64 = 1e-4;
/// Difference of two clocks that are said to be one: what two crystals differ by.
const ONE_CLOCK: f64 = 2e-4;

impl ClockError {
    /// From what the runs say, by name.
    pub fn of<'a>(
        clock: SampleClock,
        runs: impl Iterator<Item = (&'a str, &'a Quality)>,
    ) -> (Option<Self>, Vec<Finding>) {
        let all: Vec<(&str, f64, f64)> = runs
            .filter_map(|(name, q)| q.clock_error.map(|(e, u)| (name, e, u)))
            .collect();
        if all.is_empty() {
            return (None, vec![]);
        }
        let n = all.len() as f64;
        // A record without noise still has the digits of its numbers.
        let weight = |u: f64| 1.0 / (u * u).max(1e-24);
        let sum: f64 = all.iter().map(|(.., u)| weight(*u)).sum();
        let mut relative = all.iter().map(|(_, e, u)| weight(*u) * e).sum::<f64>() / sum;
        let statistic: f64 = all
            .iter()
            .map(|(_, e, u)| weight(*u) * (e - relative) * (e - relative))
            .sum();
        let plain = all.iter().map(|a| a.1).sum::<f64>() / n;
        let scatter = if all.len() > 1 {
            (all.iter().map(|a| (a.1 - plain).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
        } else {
            0.0
        };
        let (mut u, mut dof) = (sum.sqrt().recip(), DegreesOfFreedom::INFINITE);
        let mut found = vec![];
        let chance = chi_squared_chance(statistic, (n - 1.0).max(1.0));
        if all.len() > 1 && chance < TOLD {
            (relative, u) = (plain, scatter / n.sqrt());
            dof = DegreesOfFreedom::new(n - 1.0).unwrap_or(DegreesOfFreedom::INFINITE);
            let far = |a: &&(&str, f64, f64)| (a.1 - plain).abs();
            if let Some(worst) = all.iter().max_by(|a, b| far(a).total_cmp(&far(b))) {
                found.push(findings::clock_unsteady(
                    1e6 * scatter,
                    all.len(),
                    1e6 * all.iter().map(|a| a.2).sum::<f64>() / n,
                    worst.0,
                    1e6 * worst.1,
                ));
            }
        }
        let off = relative.abs() > ONE_CLOCK.max(5.0 * u);
        if clock == SampleClock::Shared && off {
            found.push(findings::clocks_differ(-1e6 * relative, 1e6 * u));
        }
        let error = Self {
            relative,
            standard_uncertainty: u,
            dof,
            runs: all.len(),
            scatter,
        };
        (Some(error), found)
    }
}

/// One delay that explains the phases of all frequencies: arg S(f) = −2π f τ (+ π for an output of the other sign).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Latency {
    /// τ, s.
    pub delay: f64,
    /// Its standard uncertainty, enlarged by what the phases depart from one delay.
    pub standard_uncertainty: f64,
    /// χ² of that departure and its degrees of freedom.
    pub misfit: (f64, usize),
    /// Frequencies it is from.
    pub frequencies: usize,
    /// Another delay explains the phases as well when it differs by this, s.
    pub ambiguity: f64,
}

impl Latency {
    /// From phases (Hz, rad, u in rad) of one or more channels, an even sign for all of them.
    ///
    /// Phases are read modulo a turn; of delays that explain them alike, the smallest counts. What the phases of several
    /// frequencies have in common is not known here: u is the larger one of that of independent and that of common errors.
    pub fn of(phases: &[(f64, f64, f64)]) -> (Option<Self>, Vec<Finding>) {
        let frequencies = ascending(phases.iter().map(|p| p.0));
        let (Some(&lowest), Some(&highest)) = (frequencies.first(), frequencies.last()) else {
            return (None, vec![]);
        };
        let floor = phases.iter().map(|p| p.2).fold(0.0, f64::max).max(1e-9) * 1e-3;
        let weight = |u: f64| 1.0 / u.max(floor).powi(2);
        // Half a turn of the lowest frequency either way, in steps of a fraction of the highest.
        let reach = 0.5 / lowest;
        let steps = (40.0 * reach * highest).ceil().min(2e6) as i64;
        let left = |tau: f64, turned: bool, p: &(f64, f64, f64)| {
            let off = p.1 + TAU * p.0 * tau - if turned { PI } else { 0.0 };
            off - TAU * (off / TAU).round()
        };
        // Robust against the few that a resonance turns: cos counts each once.
        let total: f64 = phases.iter().map(|p| weight(p.2).sqrt()).sum();
        let score = |tau: f64, turned: bool| -> f64 {
            let agree = phases.iter();
            let agree = agree.map(|p| weight(p.2).sqrt() * left(tau, turned, p).cos());
            agree.sum::<f64>() / total
        };
        let mut peaks: Vec<(f64, f64, bool)> = vec![];
        for turned in [false, true] {
            let all: Vec<f64> = (-steps..=steps)
                .map(|k| score(reach * k as f64 / steps as f64, turned))
                .collect();
            for k in 0..all.len() {
                let higher = |i: Option<&f64>| i.is_none_or(|v| *v <= all[k]);
                if higher(k.checked_sub(1).and_then(|i| all.get(i))) && higher(all.get(k + 1)) {
                    let tau = reach * (k as f64 - steps as f64) / steps as f64;
                    peaks.push((all[k], tau, turned));
                }
            }
        }
        let best = peaks.iter().map(|p| p.0).fold(f64::MIN, f64::max);
        // Steps are a twentieth of a turn of the highest frequency.
        let near = |p: &&(f64, f64, bool)| p.0 > best - 0.03;
        let alike: Vec<&(f64, f64, bool)> = peaks.iter().filter(near).collect();
        let Some((_, start, turned)) = alike.iter().min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        else {
            return (None, vec![]);
        };
        let (mut tau, turned) = (*start, *turned);
        let square: f64 = phases
            .iter()
            .map(|p| weight(p.2) * (TAU * p.0).powi(2))
            .sum();
        for _ in 0..5 {
            let along = phases.iter();
            let along = along.map(|p| weight(p.2) * TAU * p.0 * left(tau, turned, p));
            tau -= along.sum::<f64>() / square;
        }
        let misfit: f64 = phases
            .iter()
            .map(|p| weight(p.2) * left(tau, turned, p).powi(2))
            .sum();
        let dof = phases.len() - 1;
        let common: f64 = phases
            .iter()
            .map(|p| weight(p.2) * TAU * p.0 * p.2)
            .sum::<f64>()
            / square;
        let factor = if dof > 0 {
            (misfit / dof as f64).max(1.0).sqrt()
        } else {
            1.0
        };
        let u = square.sqrt().recip().max(common) * factor;
        let others = alike.iter().map(|p| (p.1 - start).abs());
        let ambiguity = others
            .filter(|d| *d > 0.1 / highest)
            .fold(1.0 / lowest, f64::min);
        let mut found = vec![];
        let chance = chi_squared_chance(misfit, dof.max(1) as f64);
        if dof > 0 && chance < TOLD {
            found.push(findings::delay_and_more(misfit, dof, 1e3 * tau));
        }
        if frequencies.len() < 2 || ambiguity < 0.99 / lowest {
            found.push(findings::delay_ambiguous(
                1e3 * tau,
                1e3 * ambiguity,
                &match frequencies.len() {
                    1 => "1 frequency".to_owned(),
                    n => format!("{n} frequencies"),
                },
            ));
        }
        let latency = Self {
            delay: tau,
            standard_uncertainty: u,
            misfit: (misfit, dof),
            frequencies: frequencies.len(),
            ambiguity,
        };
        (Some(latency), found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_delay_of_several_turns_is_found() {
        for (tau, turned) in [(4.2e-3, false), (-1e-3, true), (31e-3, false), (0.0, true)] {
            let phases: Vec<(f64, f64, f64)> = [10.0, 16.0, 25.0, 40.0, 63.0, 100.0, 160.0]
                .map(|f: f64| {
                    let phase = -TAU * f * tau + if turned { PI } else { 0.0 };
                    (f, phase - TAU * (phase / TAU).round(), 1e-3)
                })
                .to_vec();
            let (latency, findings) = Latency::of(&phases);
            let latency = latency.unwrap();
            assert!((latency.delay - tau).abs() < 1e-9, "{tau}: {latency:?}");
            assert!(findings.is_empty(), "{tau}: {findings:?}");
        }
        // A filter turns the phase as the square of the frequency beside it.
        let bent = [10.0, 16.0, 25.0, 40.0, 63.0, 100.0, 160.0]
            .map(|f: f64| (f, -TAU * f * 1e-3 - 2e-6 * f * f * f.sqrt(), 1e-4));
        let (_, findings) = Latency::of(&bent);
        assert_eq!(findings[0].code(), "delay-and-more");
        // Multiples of one frequency leave a whole turn of it open.
        let (_, findings) = Latency::of(&[(20.0, 0.1, 1e-3)]);
        assert_eq!(findings[0].code(), "delay-ambiguous");
    }

    #[test]
    fn law_a_clock_that_scatters_is_told() {
        let quality = |e: f64, u: f64| Quality {
            clock_error: Some((e, u)),
            ..Quality::default()
        };
        let steady = [quality(1e-3, 1e-7), quality(1e-3 + 1e-7, 1e-7)];
        let unsteady = [quality(1e-3, 1e-7), quality(1.1e-3, 1e-7)];
        let of = |list: &[Quality]| ClockError::of(SampleClock::Own, list.iter().map(|q| ("a", q)));
        let (error, findings) = of(&steady);
        assert!(findings.is_empty());
        let error = error.unwrap();
        assert!((error.standard_uncertainty - 1e-7 / 2f64.sqrt()).abs() < 1e-12);
        let (error, findings) = of(&unsteady);
        assert_eq!(findings[0].code(), "clock-unsteady");
        assert!((error.unwrap().standard_uncertainty - 5e-5).abs() < 1e-9);
    }
}

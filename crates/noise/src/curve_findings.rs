//! Where the curve is not that of the fitted model, and what of the spectrum makes it so.

use crate::ChannelAnalysis;
use crate::coefficients::figure;
use crate::findings;
use proofmass_uncertainty::{Finding, Severity};

/// Averaging times outside the limits beyond which chance does not explain them: of twenty one is expected.
const BY_CHANCE: usize = 2;

/// Relative departure of a density that is said.
const DEPARTS: f64 = 0.1;

/// How many half intervals of 95 % a density must be off, one in some 10⁵.
const STRONG: f64 = 2.2;

/// Bands that are named, at most.
const NAMED: usize = 4;

/// A band in which the spectrum departs from the model, and by which factor at most.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Departure {
    from: f64,
    to: f64,
    factor: f64,
}

/// Where the fitted model lies outside the limits of the curve, with the bands of the spectrum that depart.
pub(crate) fn of_the_curve(channel: &ChannelAnalysis) -> Option<Finding> {
    let curve = channel.compensated.as_ref().or(channel.curve.as_ref())?;
    let fit = channel.whittle.as_ref()?;
    let outside: Vec<f64> = channel
        .fitted
        .iter()
        .filter(|p| !p.inside)
        .map(|p| p.tau)
        .collect();
    let seen: Vec<_> = channel.fitted.iter().filter(|p| p.in_band).collect();
    let within = seen.iter().filter(|p| !p.inside).count();
    let departures = departures(channel);
    // Neighbouring τ share their differences: a third of the points outside is not chance.
    if within > BY_CHANCE && 3 * within > seen.len() {
        let worst = seen
            .iter()
            .filter_map(|p| {
                let q = curve.points.iter().find(|q| q.tau == p.tau)?;
                Some((p.tau, q.deviation / p.deviation - 1.0))
            })
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
            .unwrap_or((0.0, 0.0));
        return Some(findings::noise_model_misfit(
            "Allan curve",
            &format!(
                "outside its limits at {within} of {} averaging times in the band that was fitted; by {:+.1} % at {} s{}",
                seen.len(),
                100.0 * worst.1,
                figure(worst.0),
                words(&departures)
            ),
        ));
    }
    let (first, last) = (outside.first()?, outside.last()?);
    (outside.len() > BY_CHANCE).then(|| {
        findings::noise_model_misfit(
            "Allan curve",
            &format!(
                "outside its limits at {} of {} averaging times, from {} to {} s{}; fitted below {} Hz",
                outside.len(),
                channel.fitted.len(),
                figure(*first),
                figure(*last),
                words(&departures),
                figure(fit.band.highest_frequency)
            ),
        )
        .at(Severity::Note)
    })
}

/// Neighbouring points of the spectrum that all lie on one side of the model, beyond chance and by a tenth at least; the
/// strongest, in the order of their frequencies.
fn departures(channel: &ChannelAnalysis) -> Vec<Departure> {
    let mut found: Vec<Departure> = Vec::new();
    let mut last: Option<usize> = None;
    let points = &channel.spectrum;
    for (i, p) in points.iter().enumerate() {
        let (Some(model), Some((low, high))) = (p.model, p.interval) else {
            continue;
        };
        let factor = p.density / model;
        // What is left of a record that is almost all ramp may be rounding.
        if !(factor > 0.0 && factor.is_finite()) {
            continue;
        }
        let chance = if factor > 1.0 {
            (p.density / low).powf(STRONG)
        } else {
            (p.density / high).powf(STRONG)
        };
        let strong = if factor > 1.0 {
            factor > chance.max(1.0 + DEPARTS)
        } else {
            factor < chance.min(1.0 - DEPARTS)
        };
        if !strong {
            continue;
        }
        // Half the way to the neighbours.
        let edge = |other: Option<usize>| {
            let other = other.and_then(|k| points.get(k)).unwrap_or(p);
            (p.frequency * other.frequency).sqrt()
        };
        let (from, to) = (edge(i.checked_sub(1)), edge(Some(i + 1)));
        match found.last_mut() {
            Some(d) if last == i.checked_sub(1) && (d.factor > 1.0) == (factor > 1.0) => {
                d.to = to;
                if factor.ln().abs() > d.factor.ln().abs() {
                    d.factor = factor;
                }
            }
            _ => found.push(Departure { from, to, factor }),
        }
        last = Some(i);
    }
    found.sort_by(|a, b| b.factor.ln().abs().total_cmp(&a.factor.ln().abs()));
    found.truncate(NAMED);
    found.sort_by(|a, b| a.from.total_cmp(&b.from));
    found
}

fn words(departures: &[Departure]) -> String {
    if departures.is_empty() {
        return String::new();
    }
    let each: Vec<String> = departures
        .iter()
        .map(|d| {
            format!(
                "{} to {} Hz ({} times the model)",
                figure(d.from),
                figure(d.to),
                figure(d.factor)
            )
        })
        .collect();
    format!("; the spectrum deviates most at {}", each.join(", "))
}

//! What to doubt in temperature coefficients.

use super::coefficients::TemperatureFit;
use crate::findings;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Severity};

const MG: f64 = 1e3 / STANDARD_GRAVITY;

pub(super) fn of(
    fit: &TemperatureFit,
    cycle: bool,
    settings: &super::TemperatureSweep,
) -> Vec<Finding> {
    let probability = settings.probability;
    let mut found = Vec::new();
    turned(fit, &mut found);
    jump(fit, settings.tilt, &mut found);
    steps(fit, probability, &mut found);
    found.extend(super::soak::of(fit, probability));
    environment(fit, &mut found);
    if cycle {
        hysteresis(fit, probability, &mut found);
    } else {
        found.push(findings::one_direction(fit.range[0], fit.range[1]));
    }
    if !fit.scale {
        let largest = fit
            .attitudes()
            .iter()
            .map(|a| proofmass_core::norm(a.output))
            .fold(0.0, f64::max);
        found.push(findings::bias_and_scale_together(1e-4 * largest * 1e3 * MG));
    }
    thermometer(fit, &mut found);
    self_heating(fit, &mut found);
    if cycle && fit.axes.iter().any(|a| a.lag.is_none()) {
        found.push(findings::lag_not_determined());
    }
    found
}

/// Own part of its course below which a quantity of the surroundings is told badly.
const FOLLOWS: f64 = 0.2;

fn environment(fit: &TemperatureFit, found: &mut Vec<Finding>) {
    let follow = fit
        .environment
        .iter()
        .filter(|e| e.determined && e.own_part < FOLLOWS);
    found.extend(follow.map(|e| findings::environment_follows(&e.name, 1e2 * e.own_part)));
}

/// One in a hundred healthy recordings of three axes: 2.94 standard uncertainties each.
const SELF_HEATING: f64 = 2.94;

fn self_heating(fit: &TemperatureFit, found: &mut Vec<Finding>) {
    let heating: Vec<(&str, crate::SelfHeating)> = fit
        .named_axes()
        .filter_map(|(name, axis)| Some((name, axis.self_heating?)))
        .collect();
    let part = heating
        .iter()
        .map(|(_, h)| h.own_part)
        .fold(f64::INFINITY, f64::min);
    if heating.iter().any(|(_, h)| !h.determined) {
        found.push(findings::self_heating_not_determined(1e2 * part));
        return;
    }
    let seen: Vec<String> = heating
        .iter()
        .filter(|(_, h)| h.amplitude.abs() > SELF_HEATING * h.standard_uncertainty)
        .map(|(name, h)| {
            format!(
                "{name}: {:.3} mg ± {:.3} mg, {:.0} s",
                h.amplitude * MG,
                2.0 * h.standard_uncertainty * MG,
                h.time_constant
            )
        })
        .collect();
    if !seen.is_empty() {
        let finding = findings::warm_up(
            "the coefficients are those of the warm sensor",
            &seen.join("; "),
        );
        found.push(finding.at(Severity::Note));
    }
}

fn turned(fit: &TemperatureFit, found: &mut Vec<Finding>) {
    let steps: Vec<String> = fit
        .attitudes()
        .iter()
        .filter_map(|a| {
            a.step
                .map(|s| format!("{:.1} mg at {:.0} s", s * MG, a.time[0]))
        })
        .collect();
    if !steps.is_empty() {
        found.push(findings::output_step(
            "each segment has an intercept of its own, and only changes within the segments count",
            &steps.join(", "),
        ));
    }
}

/// A coefficient that rests on the difference of two stretches cannot be told from a tilt between them.
fn jump(fit: &TemperatureFit, tilt: Option<f64>, found: &mut Vec<Finding>) {
    let jumps = fit.blocks.jumps();
    let Some((_, kelvin, change)) = jumps
        .iter()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .copied()
    else {
        return;
    };
    let (treatment, alternative) = match tilt {
        None => (
            "the recording was interrupted, and a tilt of the sensor meanwhile would look like a coefficient; \
             the intervals hold every tilt that the outputs leave possible"
                .to_owned(),
            ", or say how well the attitude was kept (--tilt)",
        ),
        Some(tilt) => (
            format!("that the sensor was not turned meanwhile is taken from the {:.3}° that were declared", tilt.to_degrees()),
            "",
        ),
    };
    let change = proofmass_core::norm(change) * MG;
    let finding = findings::temperature_jump(&treatment, jumps.len(), kelvin, change, alternative);
    found.push(if tilt.is_some() {
        finding.at(Severity::Note)
    } else {
        finding
    });
}

/// Probability of a step on any axis where there is none, were the noise exactly the most likely one.
const STEP: f64 = 1e-2;

/// Below this it is a step whatever the noise: a real output wanders in other ways than those that are weighed.
const SURE_STEP: f64 = 1e-4;

/// A small turn while the temperature goes on is a step; so is whatever else a polynomial does not follow.
fn steps(fit: &TemperatureFit, probability: f64, found: &mut Vec<Finding>) {
    let mut gravest = Severity::Warning;
    let mut seen = Vec::new();
    for (a, (name, axis)) in fit.named_axes().enumerate() {
        let Some(step) = axis.step.filter(|s| s.p_value < STEP) else {
            continue;
        };
        let slope = fit.slope(a);
        let sure = step.p_value < SURE_STEP;
        if sure && slope.is_some_and(|q| step.slope.abs() > q.expanded(probability)) {
            gravest = Severity::Decision;
        }
        seen.push(format!(
            "{name}: {:+.2} mg at {:.0} s, {:+.1} µg/K of its mean slope",
            step.size * MG,
            step.time,
            step.slope * MG * 1e3
        ));
    }
    if !seen.is_empty() {
        let finding = findings::output_step("that is in the coefficients", &seen.join("; "));
        found.push(finding.at(gravest));
    }
}

fn hysteresis(fit: &TemperatureFit, probability: f64, found: &mut Vec<Finding>) {
    let k = DegreesOfFreedom::INFINITE.coverage_factor(probability);
    for (name, axis) in fit.named_axes() {
        let Some(h) = &axis.hysteresis else { continue };
        if let Some([temperature, raw, model]) = h.disagreement {
            found.push(findings::branches_beyond_model(
                name,
                raw * MG,
                model * MG,
                temperature,
                h.of_a_reading() * MG,
            ));
        }
        // The largest of a curve of three parameters: Scheffé's factor keeps the rate of false alarms at 1 %.
        let limit = 3.37 * h.standard_uncertainty;
        if h.difference.abs() > limit {
            found.push(findings::hysteresis(
                name,
                h.difference * MG,
                k * h.standard_uncertainty * MG,
                h.temperature,
                h.of_a_reading() * MG,
            ));
        }
    }
}

/// Noise of the thermometer flattens a regression; in blocks it hardly does.
fn thermometer(fit: &TemperatureFit, found: &mut Vec<Finding>) {
    let n = fit.blocks.len() as f64;
    let mean = fit.blocks.temperature.iter().sum::<f64>() / n;
    let variance = fit
        .blocks
        .temperature
        .iter()
        .map(|t| (t - mean).powi(2))
        .sum::<f64>()
        / n;
    let share = fit.blocks.temperature_noise / variance;
    for (axis, (name, _)) in fit.named_axes().enumerate() {
        let Some(slope) = fit.slope(axis) else {
            continue;
        };
        let bias = share * slope.value.abs();
        if bias > 0.3 * slope.standard_uncertainty {
            found.push(proofmass_uncertainty::findings::noisy_thermometer(
                &format!("the slope of {name}"),
                &format!("by {:.2} %, a part of its uncertainty", 1e2 * share),
            ));
        }
    }
}

//! What to doubt in temperature coefficients.

use super::coefficients::{AXES, TemperatureFit};
use proofmass_core::STANDARD_GRAVITY;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Severity};

const MG: f64 = 1e3 / STANDARD_GRAVITY;

pub(super) fn of(
    fit: &TemperatureFit,
    cycle: bool,
    settings: &super::TemperatureSweep,
) -> Vec<Finding> {
    let probability = settings.probability;
    let mut findings = Vec::new();
    turned(fit, &mut findings);
    jump(fit, settings.tilt, &mut findings);
    steps(fit, probability, &mut findings);
    if cycle {
        hysteresis(fit, probability, &mut findings);
    } else {
        findings.push(
            Finding::new(
                Severity::Note,
                "one-direction",
                "in no attitude did the temperature go both ways: hysteresis and lag are in the coefficients and cannot be seen",
            )
            .evidence(format!("{:.1} to {:.1} °C", fit.range[0], fit.range[1]))
            .advice("record the way back as well, at several rates"),
        );
    }
    if !fit.scale {
        let largest = fit
            .attitudes()
            .iter()
            .map(|a| proofmass_core::norm(a.output))
            .fold(0.0, f64::max);
        findings.push(
            Finding::new(
                Severity::Note,
                "bias-and-scale-together",
                "in one attitude bias and scale are not told apart: the coefficients are those of the output there",
            )
            .evidence(format!(
                "100 ppm/K of scale would be {:.0} µg/K along the specific force",
                1e-4 * largest * 1e3 * MG
            ))
            .advice("sweep the temperature with each axis up and down in turn"),
        );
    }
    thermometer(fit, &mut findings);
    self_heating(fit, &mut findings);
    if cycle && fit.axes.iter().any(|a| a.lag.is_none()) {
        findings.push(
            Finding::new(
                Severity::Note,
                "lag-not-determined",
                "the temperature ran at one rate: a lag of the thermometer looks as hysteresis does, and is counted there",
            )
            .evidence("the rate varies by less than a third within the branches")
            .advice("record at several rates, or with plateaus, to tell them apart"),
        );
    }
    findings
}

/// One in a hundred healthy recordings of three axes: 2.94 standard uncertainties each.
const SELF_HEATING: f64 = 2.94;

fn self_heating(fit: &TemperatureFit, findings: &mut Vec<Finding>) {
    let found: Vec<(&str, crate::SelfHeating)> = AXES
        .into_iter()
        .zip(&fit.axes)
        .filter_map(|(name, axis)| Some((name, axis.self_heating?)))
        .collect();
    let part = found
        .iter()
        .map(|(_, h)| h.own_part)
        .fold(f64::INFINITY, f64::min);
    if found.iter().any(|(_, h)| !h.determined) {
        findings.push(
            Finding::new(
                Severity::Decision,
                "self-heating-not-determined",
                "the temperature ran as self-heating decays: the coefficients and the warming of the sensor cannot be told apart",
            )
            .evidence(format!("{:.2} % of the decay is not explained by temperature and attitudes", 1e2 * part))
            .advice("hold the temperature after switching on until the output rests, or record the way back too"),
        );
        return;
    }
    let seen: Vec<String> = found
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
        findings.push(
            Finding::new(
                Severity::Note,
                "self-heating",
                "the sensor warmed itself after it was switched on; the coefficients are those of the warm sensor",
            )
            .evidence(seen.join("; "))
            .advice("wait several time constants before a measurement"),
        );
    }
}

fn turned(fit: &TemperatureFit, findings: &mut Vec<Finding>) {
    let steps: Vec<String> = fit
        .attitudes()
        .iter()
        .filter_map(|a| {
            a.step
                .map(|s| format!("{:.1} mg at {:.0} s", s * MG, a.time[0]))
        })
        .collect();
    if !steps.is_empty() {
        findings.push(
            Finding::new(
                Severity::Warning,
                "turned",
                "the output changed suddenly, as when the sensor is moved: each stretch has an intercept of its own, \
                 and only what happens within the stretches counts",
            )
            .evidence(steps.join(", "))
            .advice("keep the sensor in one attitude while the temperature changes"),
        );
    }
}

/// A coefficient that rests on the difference of two stretches cannot be told from a tilt between them.
fn jump(fit: &TemperatureFit, tilt: Option<f64>, findings: &mut Vec<Finding>) {
    let jumps = fit.blocks.jumps();
    let Some((_, kelvin, change)) = jumps
        .iter()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .copied()
    else {
        return;
    };
    let evidence = format!(
        "{} of them, the largest by {kelvin:.1} K, where the output changed by {:.2} mg",
        jumps.len(),
        proofmass_core::norm(change) * MG
    );
    findings.push(match tilt {
        None => Finding::new(
            Severity::Decision,
            "temperature-jump",
            "the temperature jumps: the recording was interrupted, and a tilt of the sensor meanwhile would look like a \
             coefficient; the intervals hold every tilt that the outputs leave possible",
        )
        .evidence(evidence)
        .advice("record while the temperature changes, or say how well the attitude was kept (--tilt)"),
        Some(tilt) => Finding::new(
            Severity::Note,
            "temperature-jump",
            "the temperature jumps: that the sensor was not turned meanwhile is taken from what was declared",
        )
        .evidence(format!("{evidence}; declared {:.3}°", tilt.to_degrees()))
        .advice("record while the temperature changes"),
    });
}

/// Probability of a step on any axis where there is none, were the noise exactly the most likely one.
const STEP: f64 = 1e-2;

/// Below this it is a step whatever the noise: a real output wanders in other ways than those that are weighed.
const SURE_STEP: f64 = 1e-4;

/// A small turn while the temperature goes on is a step; so is whatever else a polynomial does not follow.
fn steps(fit: &TemperatureFit, probability: f64, findings: &mut Vec<Finding>) {
    let mut gravest = Severity::Warning;
    let mut seen = Vec::new();
    for (name, axis) in AXES.into_iter().zip(&fit.axes) {
        let Some(step) = axis.step.filter(|s| s.p_value < STEP) else {
            continue;
        };
        let slope = fit.estimate.get(&format!("slope.{name}"));
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
        findings.push(
            Finding::new(
                gravest,
                "output-step",
                "the output steps beside the temperature, as when the sensor is moved a little: that is in the coefficients",
            )
            .evidence(seen.join("; "))
            .advice("look at the figure, and record again with the sensor fixed; or leave the samples before or after it out"),
        );
    }
}

fn hysteresis(fit: &TemperatureFit, probability: f64, findings: &mut Vec<Finding>) {
    let k = DegreesOfFreedom::INFINITE.coverage_factor(probability);
    for (name, axis) in AXES.iter().zip(&fit.axes) {
        let Some(h) = &axis.hysteresis else { continue };
        // The largest of a curve of three parameters: Scheffé's factor keeps the rate of false alarms at 1 %.
        let limit = 3.37 * h.standard_uncertainty;
        if h.difference.abs() > limit {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "hysteresis",
                    format!("heating and cooling differ on {name}: a reading is uncertain by it whatever the coefficients"),
                )
                .evidence(format!(
                    "{:.2} mg ± {:.2} mg at {:.1} °C",
                    h.difference * MG,
                    k * h.standard_uncertainty * MG,
                    h.temperature
                ))
                .advice(format!("count {:.2} mg as standard uncertainty of a compensated reading", h.of_a_reading() * MG)),
            );
        }
    }
}

/// Noise of the thermometer flattens a regression; in blocks it hardly does.
fn thermometer(fit: &TemperatureFit, findings: &mut Vec<Finding>) {
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
    for (axis, name) in AXES.iter().enumerate() {
        let Some(slope) = fit.estimate.get(&format!("slope.{name}")) else {
            continue;
        };
        let bias = share * slope.value.abs();
        if axis < 3 && bias > 0.3 * slope.standard_uncertainty {
            findings.push(
                Finding::new(
                    Severity::Warning,
                    "thermometer-noise",
                    format!("the noise of the thermometer makes the slope of {name} too small by a part of its uncertainty"),
                )
                .evidence(format!("{:.2} % of the slope", 1e2 * share))
                .advice("record longer, or over a wider range"),
            );
        }
    }
}

//! What to doubt in temperature coefficients.

use super::TemperatureFit;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Severity};

const AXES: [&str; 3] = ["x", "y", "z"];
const MG: f64 = 1e3 / STANDARD_GRAVITY;

pub(super) fn of(fit: &TemperatureFit, cycle: bool, probability: f64) -> Vec<Finding> {
    let mut findings = Vec::new();
    turned(fit, &mut findings);
    jump(fit, &mut findings);
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
    findings
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
fn jump(fit: &TemperatureFit, findings: &mut Vec<Finding>) {
    let (share, angle) = fit.blocks.largest_jump();
    // A continuous sweep of two hundred blocks moves a few hundredths of the range at most between two of them.
    if fit.attitudes().len() == 1 && share > 0.25 {
        findings.push(
            Finding::new(
                if angle > 1f64.to_radians() { Severity::Decision } else { Severity::Warning },
                "temperature-jump",
                "the coefficients rest on a jump of the temperature: a tilt of the sensor between the two stretches would look the same",
            )
            .evidence(format!(
                "{:.0} % of the range between two blocks, where the specific force turned by {:.2}°",
                1e2 * share,
                angle.to_degrees()
            ))
            .advice("record while the temperature changes, or prove that the sensor was not moved"),
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

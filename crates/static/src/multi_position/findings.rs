//! What to doubt about a multi-position fit.

use super::misfit::{Misfit, MisfitCause};
use super::suspects::in_words;
use super::{Model, MultiPositionFit, wiring};
use crate::Triple;
use proofmass_core::STANDARD_GRAVITY;
use proofmass_uncertainty::{Finding, Severity, chi_squared_quantile};

/// Attitudes below which the literature advises more: nine parameters, and a third of that to check them.
const FEW: usize = 12;
/// A hole of this radius leaves an axis to be extrapolated.
const WIDE_HOLE_DEG: f64 = 75.0;
/// A standstill with this many times the median deviation was not still.
const RESTLESS: f64 = 3.0;
/// Share of g beyond which a systematic error of a compensated standstill needs a decision.
const RULE: f64 = 1e-3;
/// Misalignments that stay below this with their uncertainty are not worth a parameter.
const NEGLIGIBLE: f64 = 1e-3;

pub(super) fn of(fit: &MultiPositionFit, kappa: &[Triple; 3]) -> Vec<Finding> {
    let wiring = fit.attitudes_given().then(|| wiring::of(kappa)).flatten();
    // Angles of wrongly wired axes mean nothing, nor does what they leave in the residuals.
    let small = wiring.is_none().then(|| smaller_model(fit)).flatten();
    [
        wiring,
        excess(fit),
        redundancy(fit),
        few_attitudes(fit),
        spread(fit),
        restless(fit),
        small,
    ]
    .into_iter()
    .flatten()
    .chain(fit.misfits().iter().filter_map(|m| misfit(fit, m)))
    .chain(suspects(fit))
    .collect()
}

/// What an equation of the fit comes from.
fn word(fit: &MultiPositionFit) -> &'static str {
    let single = fit.poses().iter().all(|p| p.segment.len() == 1);
    match (fit.effective_readings(), single) {
        (Some(_), _) => "part",
        (None, true) => "reading",
        (None, false) => "standstill",
    }
}

/// A probability by chance with one digit.
fn chance(p: f64) -> String {
    if p < 1e-15 {
        return "probability by chance below 1e-15".to_owned();
    }
    format!("probability by chance {p:.0e}")
}

fn mg(acceleration: f64) -> f64 {
    1e3 * acceleration / STANDARD_GRAVITY
}

/// Found on 0.5 % of healthy recordings: the Birge ratio beyond the upper end of its 99 % range.
fn excess(fit: &MultiPositionFit) -> Option<Finding> {
    let nu = fit.degrees_of_freedom();
    let beyond_rule = fit.excess() > RULE * fit.gravity().value();
    let Some(birge) = fit.birge_ratio() else {
        // Readings of unknown noise: all of their scatter is here. That of a motion is a hand's, and told as such.
        return (beyond_rule && fit.effective_readings().is_none() && fit.chi_square().is_none())
            .then(|| {
                Finding::new(
                    Severity::Decision,
                    "excess-residuals",
                    "the readings scatter about the model by more than 0.1 % of g",
                )
                .evidence(scatter_text(fit))
                .advice("noise of single readings averages down with more of them, or with means in their place (`reading_standard_uncertainty` says how well they are known); hysteresis, non-linearity, drift and a model that is too small do not: see what else is found")
            });
    };
    let limit = (chi_squared_quantile(0.995, nu as f64) / nu as f64).sqrt();
    (birge > limit).then(|| {
        let (severity, what) = if beyond_rule {
            (
                Severity::Decision,
                "the standstills scatter about the model by more than 0.1 % of g beyond their noise",
            )
        } else {
            (
                Severity::Note,
                "the residuals exceed the noise of the standstill means, and the intervals carry the excess",
            )
        };
        Finding::new(severity, "excess-residuals", what)
            .evidence(format!(
                "Birge ratio {birge:.1}, at most {limit:.1} by chance with {nu} degrees of freedom; {}",
                scatter_text(fit)
            ))
            .advice(CAUSES)
    })
}

const CAUSES: &str = "what changes from standstill to standstill by chance averages down with more attitudes, not with longer ones; hysteresis, non-linearity, drift and a model that is too small do not average down: see what else is found";

fn scatter_text(fit: &MultiPositionFit) -> String {
    let interval = fit.scatter().map_or(String::new(), |s| {
        let g = fit.gravity().value();
        let [low, high] = s.excess_interval.map(|tau| mg(tau * g));
        format!(" ({low:.2} to {high:.2})")
    });
    let of = match fit.chi_square() {
        None => "of a reading about the model",
        Some(_) => "between standstills",
    };
    format!(
        "standard deviation {of} {:.2} mg{interval}, {:.2} mm/s²",
        mg(fit.excess()),
        1e3 * fit.excess()
    )
}

fn redundancy(fit: &MultiPositionFit) -> Option<Finding> {
    (fit.degrees_of_freedom() == 0).then(|| {
        Finding::new(
            Severity::Decision,
            "no-redundancy",
            "there are as many equations as parameters: nothing checks the fit",
        )
        .evidence(format!("{} standstills", fit.poses().len()))
        .advice("record more standstills, or choose a smaller model")
    })
}

fn few_attitudes(fit: &MultiPositionFit) -> Option<Finding> {
    let n = fit.poses().len();
    let large = fit.parameters() > Model::BiasScale.parameters();
    (n < FEW && large && !fit.attitudes_given()).then(|| {
        Finding::new(Severity::Warning, "few-attitudes", "few attitudes")
            .evidence(format!(
                "{n} standstills for {} parameters",
                fit.parameters()
            ))
            .advice(format!(
                "record at least {FEW} well-spread attitudes: of 10 the intervals are 3 to 4 times as wide as of 12, and the residuals tell nothing of what the model leaves out"
            ))
    })
}

fn spread(fit: &MultiPositionFit) -> Option<Finding> {
    let coverage = fit.coverage();
    if coverage.missing.len() < 2 && coverage.largest_hole_deg < WIDE_HOLE_DEG {
        return None;
    }
    let there = fit.expanded_at(coverage.hole_centre);
    let severity = match there {
        Some(u) if u <= RULE * fit.gravity().value() => Severity::Warning,
        _ => Severity::Decision,
    };
    let [x, y, z] = coverage.hole_centre;
    let expected = there.map_or(String::new(), |u| {
        format!(
            "; a compensated reading there has U = {:.2} mg, if the model holds there",
            mg(u)
        )
    });
    Some(
        Finding::new(severity, "attitudes-badly-spread", "the attitudes leave a part of the sphere open")
            .evidence(format!(
                "{coverage}; no attitude within {:.0}° of ({x:+.2}, {y:+.2}, {z:+.2}){expected}",
                coverage.largest_hole_deg
            ))
            .advice("record standstills there; until then bias and scale factor of that axis lean on each other, and nothing checks the model there"),
    )
}

fn restless(fit: &MultiPositionFit) -> Option<Finding> {
    let poses = fit.poses();
    let deviations: Option<Vec<Triple>> = poses.iter().map(|p| p.deviation).collect();
    let deviations = deviations?;
    let medians: Triple =
        std::array::from_fn(|axis| super::median(deviations.iter().map(|d| d[axis]).collect()));
    let ratio = |i: usize| {
        (0..3)
            .map(|axis| deviations[i][axis] / medians[axis].max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max)
    };
    let (worst, ratio) = (0..poses.len())
        .map(|i| (i, ratio(i)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    (ratio > RESTLESS && medians.iter().all(|m| *m > 0.0)).then(|| {
        let segment = &poses[worst].segment;
        Finding::new(
            Severity::Warning,
            "restless-standstill",
            format!("standstill {} is not still", poses[worst].name(worst)),
        )
        .evidence(format!(
            "samples {} to {}: {ratio:.1} times the median deviation",
            segment.start, segment.end
        ))
        .advice("lay the sensor down instead of holding it, or leave this standstill out (`exclude` in [standstill])")
    })
}

/// A term that the residuals speak for, with its size; a decision beyond 0.1 % of g.
fn misfit(fit: &MultiPositionFit, misfit: &Misfit) -> Option<Finding> {
    if !misfit.found {
        return None;
    }
    let size = misfit.size_mg();
    let severity = if size > 1e3 * RULE * fit.gravity().value() / STANDARD_GRAVITY {
        Severity::Decision
    } else {
        Severity::Warning
    };
    let [x, y, z] = misfit.amplitudes_mg;
    let axes = format!("{x:+.2}, {y:+.2}, {z:+.2} mg along x, y, z");
    let (code, what, evidence, advice) = match misfit.cause {
        MisfitCause::LargerModel { model } => {
            let free = fit.form().free_elements();
            let names: Vec<String> = model
                .free_elements()
                .iter()
                .filter(|e| !free.contains(e))
                .zip(misfit.amplitudes_mg)
                .map(|(&(i, j), a)| {
                    let value = 1e-3 * a * STANDARD_GRAVITY / fit.gravity().value();
                    if i == j {
                        format!("{} off by {:+.3} %", super::ELEMENT[i][j], 1e2 * value)
                    } else {
                        format!("{} {:+.4} rad", super::ELEMENT[i][j], value)
                    }
                })
                .collect();
            let alike = misfit.amplitudes_mg.iter().all(|a| (a - x).abs() < 0.3 * x.abs());
            (
                "model-too-small",
                format!("the residuals ask for model {model}"),
                format!("{}: up to {size:.2} mg", names.join(", ")),
                if fit.form() == Model::Bias && alike {
                    format!("fit `model = \"{model}\"`; equal on the three axes, it may as well be the value of gravity or the unit of the outputs")
                } else {
                    format!("fit `model = \"{model}\"`")
                },
            )
        }
        MisfitCause::Drift => (
            "bias-drift",
            "the biases drift during the recording".to_owned(),
            format!("{axes} from the first standstill to the last"),
            "let the sensor settle, record faster, or repeat the first attitudes at the end; the bias is that of the middle of the recording".to_owned(),
        ),
        MisfitCause::WarmUp { time_constant } => (
            "warm-up",
            "the biases settle during the recording".to_owned(),
            format!("{axes} at the first standstill, time constant about {time_constant:.0} s"),
            "switch the sensor on earlier, or leave out the beginning".to_owned(),
        ),
        MisfitCause::Temperature { span } => (
            "temperature-dependence",
            "the biases follow the temperature, and the model has no temperature term".to_owned(),
            format!(
                "{axes} over {span:.1} K: {:+.3}, {:+.3}, {:+.3} mg/K",
                x / span,
                y / span,
                z / span
            ),
            "let the sensor settle before recording; the calibration holds for the mean temperature".to_owned(),
        ),
        MisfitCause::Quadratic => (
            "quadratic-term",
            "the outputs are not linear: a term in the square of the acceleration".to_owned(),
            format!("{axes} at 1 g"),
            "biases and scale factors hold for the mean over ±1 g; at other accelerations the error grows with the square".to_owned(),
        ),
        MisfitCause::Cubic => (
            "cubic-term",
            "the outputs are not linear: a term in the third power of the acceleration".to_owned(),
            format!("{axes} at 1 g"),
            "scale factors hold for the mean over ±1 g; beyond 1 g the error grows with the third power".to_owned(),
        ),
        MisfitCause::LastMotion => (
            "last-motion",
            "the outputs depend on from where an attitude was reached: hysteresis, friction or play".to_owned(),
            format!("±{:.2}, ±{:.2}, ±{:.2} mg along x, y, z", x.abs(), y.abs(), z.abs()),
            "come into each attitude from both sides; hysteresis does not average down and part of it counts as scale factor".to_owned(),
        ),
    };
    Some(
        Finding::new(severity, code, what)
            .evidence(format!("{evidence} ({})", chance(misfit.p_value)))
            .advice(advice),
    )
}

/// No misalignment reaches 1 mrad with its uncertainty: a model without them leaves more to check the fit.
fn smaller_model(fit: &MultiPositionFit) -> Option<Finding> {
    let smaller = match fit.form() {
        Model::Triangular | Model::Symmetric => Model::BiasScale,
        _ => return None,
    };
    let mut largest = 0.0f64;
    for q in fit.quantities().iter().filter(|q| q.unit == "rad") {
        let reach = q.value.abs() + q.expanded(fit.probability());
        largest = largest.max(reach);
    }
    (largest < NEGLIGIBLE && fit.degrees_of_freedom() < FEW).then(|| {
        Finding::new(
            Severity::Note,
            "smaller-model-suffices",
            format!("the misalignments are negligible: model {smaller} would do"),
        )
        .evidence(format!(
            "every misalignment with its U stays below {:.2} mrad",
            1e3 * largest
        ))
        .advice(format!(
            "fit `model = \"{smaller}\"`: three more degrees of freedom narrow the intervals"
        ))
    })
}

fn suspects(fit: &MultiPositionFit) -> Vec<Finding> {
    let Some(without) = fit.without_suspects() else {
        return Vec::new();
    };
    without
        .suspects
        .iter()
        .map(|suspect| {
            let residual = &fit.residuals()[suspect.index];
            let word = word(fit);
            let (first, end) = residual.samples;
            let place = match word {
                "reading" => String::new(),
                _ => format!("samples {first} to {end}: "),
            };
            let off = mg(suspect.deviation * fit.gravity().value());
            let given = fit.poses()[suspect.index].segment.attitude;
            match (suspect.seen, given) {
                (Some(seen), Some(given)) => Finding::new(
                    Severity::Decision,
                    "wrong-label",
                    format!("{word} {} has another attitude than its label says", suspect.name),
                )
                .evidence(format!(
                    "{place}given {}, the others see it along {}",
                    in_words(given),
                    in_words(seen)
                ))
                .advice("correct the attitude in the table of standstills, or leave the standstill out (`exclude` in [standstill])"),
                _ => Finding::new(
                    Severity::Warning,
                    "standstill-out-of-line",
                    format!("{word} {} is out of line", suspect.name),
                )
                .evidence(format!(
                    "{place}{off:.2} mg off the others ({}); ‖a‖ − g = {:+.2} mm/s²",
                    chance(suspect.p_value),
                    1e3 * residual.magnitude_residual
                ).replace("= -", "= −"))
                .advice(match word {
                    "part" => "look at the recording there; it was kept in the fit, and the result without it stands beside",
                    _ => "look at the recording there; it was kept in the fit, and the result without it stands beside (`exclude` in [standstill] leaves it out)",
                }),
            }
        })
        .collect()
}

//! What to doubt about a multi-position fit.

use super::misfit::{Misfit, MisfitCause};
use super::suspects::in_words;
use super::{Model, MultiPositionFit, ScatterForm, wiring};
use crate::{Triple, findings};
use proofmass_core::STANDARD_GRAVITY;
use proofmass_core::numeric::median;
use proofmass_uncertainty::findings::excess_residuals;
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
        walk(fit),
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
    let scatter = match beyond_rule {
        true => format!("{}, more than 0.1 % of g", scatter_text(fit)),
        false => scatter_text(fit),
    };
    let Some(birge) = fit.birge_ratio() else {
        // Readings of unknown noise: all of their scatter is here. That of a motion is a hand's, and told as such.
        return (beyond_rule && fit.effective_readings().is_none() && fit.chi_square().is_none())
            .then(|| {
                excess_residuals("between the readings", &scatter, READINGS).at(Severity::Decision)
            });
    };
    let limit = (chi_squared_quantile(0.995, nu as f64) / nu as f64).sqrt();
    (birge > limit).then(|| {
        excess_residuals(
            "between the standstills",
            &format!(
                "Birge ratio {birge:.1}, at most {limit:.1} by chance with {nu} degrees of freedom; {scatter}"
            ),
            CAUSES,
        )
        .at(if beyond_rule { Severity::Decision } else { Severity::Note })
    })
}

const CAUSES: &str = "what changes from standstill to standstill by chance averages down with more attitudes, not with longer ones; hysteresis, non-linearity, drift and a model that is too small do not average down: see what else is found";
const READINGS: &str = "noise of single readings averages down with more of them, or with means in their place (`reading_standard_uncertainty` says how well they are known); hysteresis, non-linearity, drift and a model that is too small do not: see what else is found";

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
        findings::few_attitudes(
            "as many equations as parameters, so that nothing checks the fit",
            fit.poses().len(),
            fit.parameters(),
            "record more standstills, or choose a smaller model",
        )
        .at(Severity::Decision)
    })
}

fn few_attitudes(fit: &MultiPositionFit) -> Option<Finding> {
    let n = fit.poses().len();
    let large = fit.parameters() > Model::BiasScale.parameters();
    (n < FEW && large && !fit.attitudes_given())
        .then(|| {
            findings::few_attitudes(
                "of 10 the intervals are 3 to 4 times as wide as of 12",
                n,
                fit.parameters(),
                &format!("record at least {FEW} well-spread attitudes: the residuals tell nothing of what the model leaves out"),
            )
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
        findings::attitudes_badly_spread(
            &coverage.to_string(),
            coverage.largest_hole_deg,
            x,
            y,
            z,
            &expected,
        )
        .at(severity),
    )
}

fn restless(fit: &MultiPositionFit) -> Option<Finding> {
    let poses = fit.poses();
    let deviations: Option<Vec<Triple>> = poses.iter().map(|p| p.deviation).collect();
    let deviations = deviations?;
    let medians: Triple = std::array::from_fn(|axis| {
        let mut column: Vec<f64> = deviations.iter().map(|d| d[axis]).collect();
        median(&mut column).unwrap_or(0.0)
    });
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
        findings::restless_standstill(&poses[worst].name(worst), segment.start, segment.end, ratio)
    })
}

/// What share of the weight of all forms of the scatter a walk has to have to be told.
const WALKS: f64 = 0.95;

fn walk(fit: &MultiPositionFit) -> Option<Finding> {
    let forms = fit.scatter_forms().iter();
    let walk = forms.filter(|w| w.form == ScatterForm::Walk && w.weight > WALKS);
    walk.filter_map(|w| Some(findings::bias_walk(1e3 * mg(w.walk?), 1e2 * w.weight)))
        .next()
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
    let chance = chance(misfit.p_value);
    let finding = match misfit.cause {
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
            let alike = misfit
                .amplitudes_mg
                .iter()
                .all(|a| (a - x).abs() < 0.3 * x.abs());
            let alternative = match fit.form() == Model::Bias && alike {
                true => {
                    "; equal on the three axes, it may as well be the value of gravity or the unit of the outputs"
                }
                false => "",
            };
            findings::model_too_small(
                &model.to_string(),
                &names.join(", "),
                size,
                &chance,
                alternative,
            )
        }
        MisfitCause::Drift => findings::bias_drift(
            &format!("{axes} from the first standstill to the last ({chance})"),
            "record faster, or repeat the first attitudes at the end; the bias is that of the middle of the recording",
        ),
        MisfitCause::WarmUp { time_constant } => findings::warm_up(
            "the biases settle during the recording",
            &format!(
                "{axes} at the first standstill, time constant about {time_constant:.0} s ({chance})"
            ),
        ),
        MisfitCause::Temperature { span } => {
            let coefficients = format!("{:+.3}, {:+.3}, {:+.3}", x / span, y / span, z / span);
            findings::temperature_dependence(
                "the biases follow the temperature",
                &format!("{axes} over {span:.1} K: {coefficients} mg/K ({chance})"),
            )
        }
        MisfitCause::Quadratic => findings::nonlinear_output(
            "a term in the square of the acceleration",
            &format!("{axes} at 1 g ({chance})"),
            "biases and scale factors hold for the mean over ±1 g, beyond it the error grows with the square",
        ),
        MisfitCause::Cubic => findings::nonlinear_output(
            "a term in the third power of the acceleration",
            &format!("{axes} at 1 g ({chance})"),
            "scale factors hold for the mean over ±1 g, beyond it the error grows with the third power",
        ),
        MisfitCause::LastMotion => findings::last_motion(x.abs(), y.abs(), z.abs(), &chance),
    };
    Some(finding.at(severity))
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
    (largest < NEGLIGIBLE && fit.degrees_of_freedom() < FEW)
        .then(|| findings::smaller_model_suffices(&smaller.to_string(), 1e3 * largest))
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
                (Some(seen), Some(given)) => findings::wrong_label(
                    word,
                    &suspect.name,
                    &place,
                    &in_words(given),
                    &in_words(seen),
                ),
                _ => findings::standstill_out_of_line(
                    word,
                    &suspect.name,
                    &place,
                    off,
                    &chance(suspect.p_value),
                    &format!("{:+.2}", 1e3 * residual.magnitude_residual).replace('-', "−"),
                    match word {
                        "part" => "",
                        _ => " (`exclude` in [standstill] leaves it out)",
                    },
                ),
            }
        })
        .collect()
}

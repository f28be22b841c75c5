//! What to doubt in the inputs of a model and in the comparison of the two roads.

use super::Evaluate;
use crate::findings;
use crate::{
    Finding, InputEntry, OutputEntry, OutputResult, Severity, UncertaintyModel, Validation,
    Verdict, scientific,
};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

impl UncertaintyModel {
    /// What a careful reader would ask about the inputs themselves.
    pub(super) fn doubtful_inputs(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        for input in &self.input {
            findings.extend(groups(input));
            let Some(values) = &input.observations else {
                continue;
            };
            if values.windows(2).all(|pair| pair[0] == pair[1]) {
                findings.push(findings::no_scatter(&input.name, values.len(), values[0]));
            }
        }
        findings
    }
}

/// Spacings of the doubles that u needs for the draws to have its distribution: rounding then adds 0.1 % to u.
const SPACINGS: f64 = 8.0;

/// A u that rounding of the value takes away.
pub(super) fn resolution(quantity: &str, value: f64, u: f64) -> Option<Finding> {
    let spacing = value.abs().next_up() - value.abs();
    (u > 0.0 && u < SPACINGS * spacing).then(|| {
        let number = |x: f64| crate::scientific(x, 2);
        findings::finer_than_doubles(quantity, &number(u), &number(value), &number(spacing))
    })
}

/// What the groups of an input say: scatter within and between, and how often chance alone makes it so large.
fn groups(input: &InputEntry) -> Option<Finding> {
    let groups = input.groups.as_ref()?;
    let means = input.means_of_groups().ok()??;
    let total: usize = groups.iter().map(Vec::len).sum();
    let (j, n) = (groups.len() as f64, total as f64);
    let grand = groups.iter().flatten().sum::<f64>() / n;
    let between: f64 = groups
        .iter()
        .zip(&means)
        .map(|(group, mean)| group.len() as f64 * (mean - grand).powi(2))
        .sum::<f64>()
        / (j - 1.0);
    let within: f64 = groups
        .iter()
        .zip(&means)
        .flat_map(|(group, mean)| group.iter().map(move |x| (x - mean).powi(2)))
        .sum::<f64>()
        / (n - j);
    if !(within > 0.0 && between.is_finite()) {
        return None;
    }
    // Of unequal groups the mean size of the analysis of variance.
    let squares: f64 = groups.iter().map(|g| (g.len() as f64).powi(2)).sum();
    let size = (n - squares / n) / (j - 1.0);
    let scatter = ((between - within) / size).max(0.0).sqrt();
    let f = between / within;
    let p = 1.0 - FisherSnedecor::new(j - 1.0, n - j).ok()?.cdf(f);
    Some(findings::scatter_of_groups(
        &input.name,
        groups.len(),
        &scientific(within.sqrt(), 2),
        &scientific(scatter, 2),
        f,
        groups.len() - 1,
        total - groups.len(),
        p,
    ))
}

/// Difference over the half-width of the interval from which on somebody has to decide; below, the result is stated by
/// Monte Carlo and a warning says so.
const LARGE: f64 = 0.2;

/// What the verdict asks of the reader; trials that are too few are for [`too_few`].
pub(super) fn verdict(
    validation: &Validation,
    entry: &OutputEntry,
    options: &Evaluate,
) -> Option<Finding> {
    let evidence = || evidence(validation, &unit(&entry.unit), options);
    match validation.verdict {
        Verdict::Validated => None,
        _ if validation.few_degrees_of_freedom => Some(findings::few_degrees_of_freedom_differ(
            &entry.name,
            &evidence(),
        )),
        Verdict::Undecided => None,
        Verdict::NotValidated => Some(
            findings::linear_result_not_validated(
                &entry.name,
                "the Monte Carlo interval",
                &evidence(),
            )
            .at(if validation.relative >= LARGE {
                Severity::Decision
            } else {
                Severity::Warning
            }),
        ),
    }
}

/// Terms of second order that contradict the linear result, where Monte Carlo, which has all terms, cannot tell.
pub(super) fn second_order(output: &OutputResult, options: &Evaluate) -> Option<Finding> {
    let told = |v: &Validation| v.holds() || v.refutes();
    let linear = output.linear.as_ref()?;
    let second = linear.second_order?;
    let quantity = &linear.quantity;
    if output.validation.as_ref().is_some_and(told)
        || second.agrees(quantity, options.probability, options.check_digits)
    {
        return None;
    }
    Some(findings::linear_result_not_validated(
        &output.name,
        "that with second-order terms",
        &format!(
            "for normal inputs u = {} to first order, {} to second; the mean shifts by {}",
            scientific(quantity.standard_uncertainty, 3),
            scientific(second.standard_uncertainty, 3),
            scientific(second.shift, 2)
        ),
    ))
}

/// One finding for everything that the trials are too few for: figures that are not yet stable, and these verdicts.
pub(super) fn too_few(
    unstable: Option<&Finding>,
    outputs: &[OutputResult],
    options: &Evaluate,
) -> Option<Finding> {
    let open: Vec<(&OutputResult, &Validation)> = outputs
        .iter()
        .filter_map(|o| Some((o, o.validation.as_ref()?)))
        .filter(|(_, v)| v.verdict == Verdict::Undecided && !v.few_degrees_of_freedom)
        .collect();
    let worst = open
        .iter()
        .max_by(|a, b| (a.1.scatter / a.1.tolerance).total_cmp(&(b.1.scatter / b.1.tolerance)));
    let Some((output, validation)) = worst else {
        return unstable.cloned();
    };
    let names: Vec<&str> = open.iter().map(|(o, _)| o.name.as_str()).collect();
    let unit = unit(&output.unit);
    Some(findings::too_few_trials(
        &format!("to check the linear interval of {}", names.join(", ")),
        &format!(
            "{}, and the ends of the Monte Carlo interval scatter by {}{unit}{}",
            evidence(validation, &unit, options),
            scientific(validation.scatter, 1),
            match names.len() {
                1 => String::new(),
                _ => format!(" ({})", output.name),
            }
        ),
    ))
}

/// Both ends beside what is allowed.
fn evidence(validation: &Validation, unit: &str, options: &Evaluate) -> String {
    format!(
        "by {} and {}{unit} at the ends, {:.0} % of the half-width; {}{unit} is allowed for {} of u",
        scientific(validation.lower, 2),
        scientific(validation.upper, 2),
        100.0 * validation.relative,
        scientific(validation.tolerance, 2),
        match options.check_digits {
            1 => "1 digit".to_owned(),
            n => format!("{n} digits"),
        },
    )
}

/// A unit behind a number.
fn unit(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        unit => format!(" {unit}"),
    }
}

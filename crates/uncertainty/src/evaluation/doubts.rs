//! What to doubt in the inputs of a model and in the comparison of the two roads.

use super::Evaluate;
use crate::{
    Finding, InputEntry, OutputEntry, Refusal, Severity, UncertaintyModel, Validation, Verdict,
    scientific,
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
                findings.push(
                    Finding::new(
                        Severity::Warning,
                        "no-scatter",
                        format!("the observations of {} are all the same", input.name),
                    )
                    .evidence(format!("{} times {}", values.len(), values[0]))
                    .advice("add an input for the resolution of the instrument: rectangular, one digit wide"),
                );
            }
        }
        findings
    }
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
    Some(
        Finding::new(
            Severity::Note,
            "scatter-of-groups",
            format!(
                "the uncertainty of {} is that of the mean of {} groups, whatever their scatter is due to",
                input.name,
                groups.len()
            ),
        )
        .evidence(format!(
            "standard deviation within groups {}, between groups {}; F = {f:.2} with {} and {} degrees of freedom, \
             p = {p:.3}",
            scientific(within.sqrt(), 2),
            scientific(scatter, 2),
            groups.len() - 1,
            total - groups.len()
        )),
    )
}

/// The law of propagation has no result.
pub(super) fn no_linear_result(refusal: &Refusal) -> Finding {
    Finding::new(
        Severity::Warning,
        "no-linear-result",
        "the law of propagation has no result: the model has no value or no derivative at the estimates",
    )
    .evidence(refusal.to_string())
    .advice("the result is that of Monte Carlo")
}

/// Monte Carlo has no result.
pub(super) fn no_monte_carlo_result(refusal: &Refusal) -> Finding {
    Finding::new(
        Severity::Decision,
        "no-monte-carlo-result",
        "Monte Carlo has no result: almost no trial gave a number",
    )
    .evidence(refusal.to_string())
    .advice("the linear result is not checked; state distributions that keep to what is possible")
}

/// Difference over the half-width of the interval from which on somebody has to decide; below, the result is stated by
/// Monte Carlo and a warning says so.
const LARGE: f64 = 0.2;

/// What the verdict asks of the reader.
pub(super) fn verdict(
    validation: &Validation,
    entry: &OutputEntry,
    options: &Evaluate,
) -> Option<Finding> {
    let unit = match entry.unit.as_str() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let evidence = format!(
        "by {} and {}{unit} at the ends, {:.0} % of the half-width; {}{unit} is allowed for {} of u",
        scientific(validation.lower, 2),
        scientific(validation.upper, 2),
        100.0 * validation.relative,
        scientific(validation.tolerance, 1),
        match options.check_digits {
            1 => "1 digit".to_owned(),
            n => format!("{n} digits"),
        },
    );
    match validation.verdict {
        Verdict::Validated => None,
        Verdict::NotValidated => Some(
            Finding::new(
                if validation.relative >= LARGE {
                    Severity::Decision
                } else {
                    Severity::Warning
                },
                "linear-result-not-validated",
                format!(
                    "the linear and the Monte Carlo interval of {} differ",
                    entry.name
                ),
            )
            .evidence(evidence)
            .advice("report the Monte Carlo interval"),
        ),
        Verdict::Undecided => Some(
            Finding::new(
                Severity::Warning,
                "monte-carlo-undecided",
                format!(
                    "the trials do not tell whether the linear interval of {} stands",
                    entry.name
                ),
            )
            .evidence(format!(
                "{evidence}, and the ends of the Monte Carlo interval scatter by {}{unit}",
                scientific(validation.scatter, 1)
            ))
            .advice("allow more trials, or ask for fewer digits"),
        ),
    }
}

//! Calibrations of one device over frequency, held against each other: two, or several and their reference value.

mod page;

use crate::findings;
use crate::frequency_response::PHASE_NOT_STATED;
use crate::outcome::{Job, Outcome, section};
use crate::plural::count;
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_dynamic::FrequencyResponse;
use proofmass_dynamic::frequency_response::{ReferenceComparison, ResponseComparison};
use proofmass_io::Unit;
use proofmass_report::Report;
use proofmass_uncertainty::{EvidenceValue, Finding, Severity};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// How calibrations are compared.
///
/// ```
/// use proofmass_dynamic::FrequencyResponse;
/// use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
/// use proofmass_jobs::comparison::{ComparisonData, ComparisonJob};
/// use proofmass_jobs::{Job, Unwatched};
///
/// let certificate = |sensitivity: f64| {
///     let line = |frequency: f64| ReferencePoint {
///         frequency, sensitivity, phase: 0.0, modulus_uncertainty: 0.005, phase_uncertainty: 0.005,
///     };
///     let table = ReferenceTable::new(vec![line(10.0), line(100.0), line(1000.0)])?;
///     FrequencyResponse::try_from(&table)
/// };
/// let (ours, theirs) = (certificate(0.01002)?, certificate(0.01)?);
/// let data = ComparisonData { responses: &[&ours, &theirs], names: &["ours", "theirs"], findings: &[] };
/// let outcome = ComparisonJob::default().evaluate(&data, &Unwatched)?;
/// // 0.2 % with U = 1.96 · 0.5 % · √2.
/// assert!((outcome.pair().unwrap().points[0].modulus_en - 0.144).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ComparisonJob {
    /// Probability of the expanded uncertainties in E_n.
    pub probability: f64,
    /// Of two calibrations, entries of their budgets that are one error of both, such as `reference`: they go out of U of the differences.
    /// What stands before a dot is enough.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub common: Vec<String>,
}

impl Default for ComparisonJob {
    fn default() -> Self {
        Self {
            probability: 0.95,
            common: Vec::new(),
        }
    }
}

/// Two calibrations or more.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonData<'a> {
    /// All; of two, differences are the first less the second.
    pub responses: &'a [&'a FrequencyResponse],
    /// What they are called.
    pub names: &'a [&'a str],
    /// What reading them found.
    pub findings: &'a [Finding],
}

impl Job for ComparisonJob {
    type Data<'a> = ComparisonData<'a>;
    type Outcome = ComparisonOutcome;

    fn evaluate(&self, data: &ComparisonData<'_>, watch: &dyn Watch) -> Result<ComparisonOutcome> {
        watch.step("comparison", 0, 1)?;
        let (Some(first), true) = (
            data.responses.first(),
            data.responses.len() >= 2 && data.names.len() == data.responses.len(),
        ) else {
            return Err(
                Trouble::request("a comparison needs two calibrations or more")
                    .with_hint("give each of them with its name"),
            );
        };
        let phases = !data.findings.iter().any(|f| f.code() == PHASE_NOT_STATED);
        if let (false, true) = (phases, data.responses.len() > 2) {
            return Err(Trouble::data(
                "a table states no phase, which is part of the reference value of several",
            )
            .with_hint(
                "add phase_deg and u_phase_deg to it, or compare two at a time, their moduli alone",
            ));
        }
        for (response, name) in data.responses.iter().zip(data.names) {
            stated(response, name, phases)?;
        }
        let mut converted = Vec::with_capacity(data.responses.len());
        for (response, name) in data.responses.iter().zip(data.names) {
            let (own, other) = (first.unit(), response.unit());
            let factor = between(other, own).ok_or_else(|| {
                Trouble::data(format!("{} is in {own}, {name} in {other}", data.names[0]))
                    .with_hint("calibrations of one device have one unit: bring all to the same")
            })?;
            converted.push(match other == own {
                true => Cow::Borrowed(*response),
                false => Cow::Owned(response.in_unit(own, factor)?),
            });
        }
        for (response, name) in data.responses.iter().zip(data.names).skip(1) {
            same_elements(first, data.names[0], response, name)?;
        }
        let about = |e: proofmass_core::Error| {
            Trouble::from(e).detail(data.names.join(", ")).with_hint(
                "the same outputs and axes, ranges that meet and stated uncertainties are needed",
            )
        };
        let mut findings: Vec<Finding> = data.findings.iter().map(alone).collect();
        let (mut comparison, mut reference) = (None, None);
        if let [one, other] = &converted[..] {
            self.common_is_of_both(one, other, data.names)?;
            let compare = |causes: &[String]| {
                ResponseComparison::without_common(one, other, self.probability, phases, causes)
            };
            let pair = compare(&self.common).map_err(|e| match e {
                proofmass_core::Error::OutOfRange { .. }
                | proofmass_core::Error::NotPositiveDefinite { .. }
                    if !self.common.is_empty() =>
                {
                    nothing_left(data.names, &self.common)
                }
                e => about(e),
            })?;
            findings.extend(pair.findings.iter().cloned());
            if self.common.is_empty() {
                findings.extend(perhaps_common(one, other, &pair, compare));
            }
            comparison = Some(pair);
        } else {
            if !self.common.is_empty() {
                return Err(Trouble::request(
                    "common causes are taken out of two calibrations, not of several",
                )
                .with_hint("compare two at a time, or leave --common out"));
            }
            let all: Vec<&FrequencyResponse> = converted.iter().map(Cow::as_ref).collect();
            let several = ReferenceComparison::of(&all, self.probability).map_err(about)?;
            let several = several.judged(data.names);
            findings.extend(several.findings.iter().cloned());
            reference = Some(several);
        }
        let compared = comparison
            .iter()
            .flat_map(|p| p.points.iter().map(|p| p.frequency));
        let among = reference
            .iter()
            .flat_map(|r| r.points.iter().map(|p| p.frequency));
        findings.extend(left_out(data, compared.chain(among)));
        watch.step("comparison", 1, 1)?;
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Ok(ComparisonOutcome {
            names: data.names.iter().map(|&n| n.to_owned()).collect(),
            comparison,
            reference,
            findings,
        })
    }
}

/// The entry of the budgets of shakers that certificates give: one standard may be behind both calibrations.
const REFERENCE: &str = "reference";
/// Share by which the largest |E_n| has to change for a common cause to be asked for.
const APPRECIABLE: f64 = 0.05;

impl ComparisonJob {
    /// Every common cause is an entry of both budgets.
    fn common_is_of_both(
        &self,
        one: &FrequencyResponse,
        other: &FrequencyResponse,
        names: &[&str],
    ) -> Result<()> {
        let both = ResponseComparison::causes_of_both(one, other);
        let missing = self.common.iter().find(|cause| {
            let of_it = |key: &&String| *key == *cause || key.starts_with(&format!("{cause}."));
            both.iter().find(of_it).is_none()
        });
        match missing {
            None => Ok(()),
            Some(cause) => Err(Trouble::request(format!(
                "\"{cause}\" is no entry of the budgets of both {}",
                names.join(" and ")
            ))
            .with_hint(match both.is_empty() {
                true => "they name no entry in common".to_owned(),
                false => format!("entries of both: {}", both.join(", ")),
            })),
        }
    }
}

fn nothing_left(names: &[&str], common: &[String]) -> Trouble {
    Trouble::data(format!(
        "without {} nothing is left of the uncertainty of a difference of {}",
        common.join(", "),
        names.join(" and ")
    ))
    .with_hint("two calibrations share their standard, and not their readings and mountings: name the standard alone")
}

/// Whether the calibrations name a reference that may be one error of both, and what that would change.
fn perhaps_common(
    one: &FrequencyResponse,
    other: &FrequencyResponse,
    pair: &ResponseComparison,
    compare: impl Fn(&[String]) -> std::result::Result<ResponseComparison, proofmass_core::Error>,
) -> Option<Finding> {
    let mut keys = ResponseComparison::causes_of_both(one, other);
    keys.retain(|key| key == REFERENCE || key.starts_with(&format!("{REFERENCE}.")));
    if keys.is_empty() {
        return None;
    }
    let without = compare(&keys).ok()?;
    let largest = |pair: &ResponseComparison| {
        let points = pair.points.iter().map(|p| p.largest_en());
        points.fold(0.0, f64::max)
    };
    let (as_it_is, shared) = (largest(pair), largest(&without));
    (shared > (1.0 + APPRECIABLE) * as_it_is)
        .then(|| findings::common_cause_possible(&keys.join(", "), as_it_is, shared))
}

/// Calibrations of one axis and of three have nothing in common that could be compared.
fn same_elements(
    first: &FrequencyResponse,
    first_name: &str,
    other: &FrequencyResponse,
    name: &str,
) -> Result<()> {
    let size = |r: &FrequencyResponse| [r.outputs().len(), r.axes().len()];
    if size(first) == size(other) {
        return Ok(());
    }
    let said = |r: &FrequencyResponse| match size(r) {
        [1, 1] => "one output along one axis".to_owned(),
        [outputs, axes] => format!(
            "{} along {}",
            count(outputs, "output"),
            match axes {
                1 => "one axis".to_owned(),
                n => format!("{n} axes"),
            }
        ),
    };
    Err(Trouble::data(format!(
        "{first_name} has {}, {name} has {}: they cannot be compared element by element",
        said(first),
        said(other)
    ))
    .with_hint(
        "compare two calibrations of one axis, or two of all axes; of a triaxial calibration write the element of that axis into the table of a laboratory \
         (.csv: frequency_Hz, sensitivity, phase_deg with their uncertainties; sensitivity.csv of its result has the numbers) and compare that",
    ))
}

/// Frequencies of the calibrations beyond those that all have; a warning where that is half of one and more.
fn left_out(data: &ComparisonData<'_>, compared: impl Iterator<Item = f64>) -> Option<Finding> {
    let mut compared: Vec<f64> = compared.collect();
    compared.sort_unstable_by(f64::total_cmp);
    compared.dedup();
    let (low, high) = (*compared.first()?, *compared.last()?);
    let within = low * (1.0 - 1e-9)..=high * (1.0 + 1e-9);
    let (mut lost, mut much) = (Vec::new(), false);
    for (response, name) in data.responses.iter().zip(data.names) {
        let all = response.frequencies().count();
        let beyond = response
            .frequencies()
            .filter(|f| !within.contains(f))
            .count();
        if beyond > 0 {
            lost.push(format!("{beyond} of {all} of {name}"));
        }
        much |= 2 * beyond >= all;
    }
    let severity = if much {
        Severity::Warning
    } else {
        Severity::Note
    };
    let finding = || findings::frequencies_not_compared(compared.len(), &lost.join(", "));
    (!lost.is_empty()).then(|| finding().at(severity))
}

/// What a table without phases means here.
fn alone(finding: &Finding) -> Finding {
    match finding.evidence_fields().get("table") {
        Some(EvidenceValue::Text(table)) if finding.code() == PHASE_NOT_STATED => {
            findings::phase_not_stated(table, "moduli alone are compared").at(Severity::Note)
        }
        _ => finding.clone(),
    }
}

/// Every point of a response has an uncertainty of modulus and, where it is compared, of phase.
fn stated(response: &FrequencyResponse, name: &str, phases: bool) -> Result<()> {
    let modulus = if phases {
        "modulus or phase"
    } else {
        "modulus"
    };
    for point in response.series().points() {
        let c = point.estimate.covariance();
        for i in (0..c.dimension()).step_by(2) {
            let (a, b, both) = (c[(i, i)], c[(i + 1, i + 1)], c[(i, i + 1)]);
            let known = match phases {
                true => a * b - both * both > 1e-14 * a.max(b).powi(2),
                false => a + b > 0.0,
            };
            if !known {
                return Err(Trouble::data(format!(
                    "{name} states no uncertainty of {modulus} at {} Hz",
                    point.at
                ))
                .with_hint("a value without uncertainty cannot be compared: give that of both"));
            }
        }
    }
    Ok(())
}

/// How many of the unit `to` one of `from` is: outputs in volts, counts, or accelerations, per m/s².
fn between(from: &str, to: &str) -> Option<f64> {
    if from == to {
        return Some(1.0);
    }
    let output = |unit: &str| -> Option<(Unit, f64)> {
        let label = unit.strip_suffix("/(m/s²)")?;
        let label = label.trim_start_matches('(').trim_end_matches(')');
        Some(label.parse::<Unit>().ok()?.si())
    };
    let ((a, x), (b, y)) = (output(from)?, output(to)?);
    (a == b).then(|| x / y)
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonOutcome {
    names: Vec<String>,
    comparison: Option<ResponseComparison>,
    reference: Option<ReferenceComparison>,
    findings: Vec<Finding>,
}

impl ComparisonOutcome {
    /// Of two: point by point and as a whole.
    pub fn pair(&self) -> Option<&ResponseComparison> {
        self.comparison.as_ref()
    }

    /// Of three and more: against their reference value.
    pub fn reference(&self) -> Option<&ReferenceComparison> {
        self.reference.as_ref()
    }

    /// Number of elements and frequencies that were compared.
    pub fn points(&self) -> usize {
        let pair = self.pair().map_or(0, |p| p.points.len());
        pair + self.reference().map_or(0, |r| r.points.len())
    }
}

impl Outcome for ComparisonOutcome {
    const KIND: &'static str = "comparison";

    fn title(&self, record: &Record) -> String {
        let title = record.title.clone();
        title.unwrap_or_else(|| match &self.names[..] {
            [all @ .., last] => format!("Comparison of {} and {last}", all.join(", ")),
            [] => "Comparison".to_owned(),
        })
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        Vec::new()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(match (self.pair(), self.reference()) {
            (Some(pair), _) => vec![section("whole", &pair.whole)?],
            (None, Some(several)) => vec![section("furthest", &several.furthest)?],
            (None, None) => Vec::new(),
        })
    }

    fn page(&self, page: Report) -> Report {
        let page = match self.pair() {
            Some(pair) => page::pair(page, pair, &self.names),
            None => page,
        };
        match self.reference() {
            Some(several) => page::several(page, several, &self.names),
            None => page,
        }
    }
}

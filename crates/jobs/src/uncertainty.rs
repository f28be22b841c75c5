//! From a formula and what is known of its inputs to a result with its budget.

mod model_text;
mod page;

pub use model_text::ModelText;

use crate::outcome::section;
use crate::record::Record;
use crate::trouble::{Result, Trouble, TroubleKind};
use crate::{Job, Outcome};
use proofmass_core::Watch;
use proofmass_documents::{StatedQuantity, TRIALS_SECTION, TrialFile};
use proofmass_report::Report;
use proofmass_uncertainty::{
    Estimate, Evaluate, Finding, FitScatter, FitWeights, InputEntry, ModelResult, Refusal,
    StatementMethod, UncertaintyModel,
};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// The equations of one measurement with what is known of its inputs, and how to evaluate them.
///
/// ```
/// use proofmass_jobs::uncertainty::UncertaintyJob;
/// use proofmass_jobs::{Job, Outcome, Unwatched};
/// let model = proofmass_documents::read_model(r#"
/// [[input]]
/// name = "V"
/// unit = "V"
/// value = 5.0
/// u = 0.01
/// [[input]]
/// name = "R"
/// unit = "Ω"
/// value = 100.0
/// half_width = 0.1
/// [[output]]
/// name = "I"
/// unit = "A"
/// expression = "V / R"
/// "#).unwrap();
/// let outcome = UncertaintyJob { model, ..Default::default() }.evaluate(&(), &Unwatched)?;
/// let current = &outcome.quantities()[0];
/// assert!((current.value - 0.05).abs() < 1e-12 && (current.expanded - 2.0e-4).abs() < 5e-6);
/// # Ok::<(), proofmass_jobs::Trouble>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UncertaintyJob {
    /// The model.
    pub model: UncertaintyModel,
    /// How to evaluate it.
    #[serde(default)]
    pub options: Evaluate,
}

impl UncertaintyJob {
    /// As [`Job::evaluate`], with the refusal that [`proofmass_documents::explain_model`] finds the line of.
    ///
    /// # Errors
    /// As [`UncertaintyModel::evaluate`].
    pub fn run(&self, watch: &dyn Watch) -> Result<UncertaintyOutcome, Refusal> {
        let result = self.model.evaluate(&self.options, &mut |progress| {
            watch.progress("trials", progress.done as u64, progress.most as u64)
        })?;
        if watch.progress("trials", 1, 1) == ControlFlow::Break(()) {
            return Err(Refusal::Cancelled);
        }
        Ok(UncertaintyOutcome {
            model: self.model.clone(),
            result,
        })
    }
}

impl Job for UncertaintyJob {
    type Data<'a> = ();
    type Outcome = UncertaintyOutcome;

    fn evaluate(&self, _data: &(), watch: &dyn Watch) -> Result<UncertaintyOutcome> {
        self.run(watch).map_err(|refusal| trouble(&refusal))
    }
}

/// What a model file is, for somebody whose file was refused.
const MODEL_FILE: &str = "a model file is TOML: [[input]] with name, unit, value and u (or observations, or a distribution), and [[output]] \
                          with name, unit and expression; `proofmass uncertainty --help` shows one";

/// What to do about a refusal.
pub fn trouble(refusal: &Refusal) -> Trouble {
    let (kind, hint) = match refusal {
        Refusal::Cancelled => return Trouble::new(TroubleKind::Cancelled, "cancelled"),
        Refusal::Output { .. } => (
            TroubleKind::Data,
            "the formulas must be finite at the estimates of the inputs, or in most of what their distributions allow",
        ),
        Refusal::Unknown { .. } => (
            TroubleKind::Request,
            "names are those of [[input]], [[intermediate]] and [[output]] of the file; functions stand in `proofmass uncertainty --help`",
        ),
        Refusal::Duplicate { .. } | Refusal::Name { .. } => (
            TroubleKind::Request,
            "give each input and output a name of its own: a letter, then letters, digits and underscores",
        ),
        Refusal::Correlation { .. } | Refusal::Pair { .. } | Refusal::Unreachable { .. } => (
            TroubleKind::Request,
            "correct the coefficient in [[correlation]]; all of them together must be possible",
        ),
        Refusal::Expression { .. } => (
            TroubleKind::Request,
            "a formula has + - * / ^, brackets, functions such as sqrt(x), and names of the file; 2*x, not 2x",
        ),
        Refusal::Input { .. } | Refusal::Incomplete { .. } | Refusal::Contradiction { .. } => (
            TroubleKind::Request,
            "an [[input]] has name and unit, and one statement: value and u, or value and half_width, or observations, or a distribution",
        ),
        _ => (TroubleKind::Request, MODEL_FILE),
    };
    Trouble::new(kind, refusal.to_string()).with_hint(hint)
}

/// The result of a model, with the model.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct UncertaintyOutcome {
    /// The model.
    pub(crate) model: UncertaintyModel,
    /// Its result by every road.
    pub result: ModelResult,
}

impl Outcome for UncertaintyOutcome {
    const KIND: &'static str = "uncertainty";

    fn title(&self, record: &Record) -> String {
        let own = || {
            if self.model.title.is_empty() {
                "Uncertainty of a measurement".to_owned()
            } else {
                self.model.title.clone()
            }
        };
        record.title.clone().unwrap_or_else(own)
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        let outputs = self.result.outputs.iter();
        outputs
            .map(|output| {
                let stated = &output.stated;
                let ends = [stated.interval.lower, stated.interval.upper];
                StatedQuantity {
                    name: stated.name.clone(),
                    unit: stated.unit.clone(),
                    value: stated.value,
                    u: stated.standard_uncertainty,
                    expanded: stated.reach(),
                    k: stated.coverage_factor,
                    nu_eff: stated.dof,
                    probability: stated.probability,
                    interval: stated.expanded_uncertainty.is_none().then_some(ends),
                    method: Some(
                        match stated.method {
                            StatementMethod::LawOfPropagation => "law-of-propagation",
                            StatementMethod::SecondOrder => "second-order",
                            _ => "monte-carlo",
                        }
                        .to_owned(),
                    ),
                }
            })
            .collect()
    }

    fn findings(&self) -> &[Finding] {
        &self.result.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        self.result.stated.as_ref()
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        let outputs = self.result.outputs.iter();
        let linear: Vec<StatedQuantity> = outputs
            .filter_map(|o| {
                Some(StatedQuantity::new(
                    &o.linear.as_ref()?.quantity,
                    self.result.options.probability,
                ))
            })
            .collect();
        // For information: what is stated stands under `quantities`.
        let mut sections = vec![section("linear", &linear)?];
        if let Some(table) = &self.result.table {
            sections.push(section(TRIALS_SECTION, &TrialFile::of(table)?.0)?);
        }
        let result = &self.result;
        if !result.conformity.is_empty() {
            sections.push(section("conformity", &result.conformity)?);
        }
        if !result.sweeps.is_empty() {
            sections.push(section("sweeps", &result.sweeps)?);
        }
        if !result.targets.is_empty() {
            sections.push(section("targets", &result.targets)?);
        }
        Ok(sections)
    }

    fn beside(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let Some(table) = &self.result.table else {
            return Ok(Vec::new());
        };
        let (file, bytes) = TrialFile::of(table)?;
        Ok(vec![(file.file, bytes)])
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}

impl UncertaintyOutcome {
    /// Names and formulas of what is computed on the way to the outputs.
    fn parts(&self) -> Vec<[String; 2]> {
        let intermediate = self.model.intermediate.iter();
        let mut parts: Vec<[String; 2]> = intermediate
            .map(|i| [i.name.clone(), i.expression.clone()])
            .collect();
        for solve in &self.model.solve {
            let text = format!("solve {}", solve.equations.join("; "));
            parts.push([solve.unknown.join(", "), text]);
        }
        for fit in &self.model.fit {
            let shape = match &fit.curve {
                Some(curve) => format!("curve {curve}"),
                None => format!(
                    "polynomial of degree {}",
                    fit.parameters.len().saturating_sub(1)
                ),
            };
            let text = format!(
                "{}: {shape} through ({}, {}), {}{}",
                fit.name,
                fit.x,
                fit.y,
                match fit.weights {
                    FitWeights::Y => "weighed by the covariance of the ordinates",
                    FitWeights::Both => "weighed by the covariance of both variables",
                    _ => "equal weights",
                },
                match fit.scatter {
                    FitScatter::Residuals => "; scatter of the points from the residuals",
                    _ => "",
                }
            );
            parts.push([fit.parameters.join(", "), text]);
        }
        parts
    }
}

/// Name, unit, what is known and description of an input, as far as its model states it.
fn given(entry: &InputEntry) -> [String; 4] {
    let list = |values: &[f64]| -> String {
        let values: Vec<String> = values.iter().map(f64::to_string).collect();
        values.join(", ")
    };
    let mut known = match (&entry.distribution, &entry.observations) {
        (Some(distribution), _) => distribution.to_string(),
        (None, Some(values)) if values.len() <= 12 => list(values),
        (None, Some(values)) => format!("{} observations", values.len()),
        (None, None) => stated(entry),
    };
    if let Some(file) = &entry.file {
        let column = entry.column.as_deref().unwrap_or_default();
        known += &format!("; column {column} of {file}");
    }
    if let Some(dof) = entry.dof {
        known += &format!("; ν = {}", dof.get());
    }
    if let Some(word) = &entry.together {
        known += &format!("; together as {word}");
    }
    [
        entry.name.clone(),
        entry.unit.clone(),
        known,
        entry.description.clone().unwrap_or_default(),
    ]
}

/// A value with its uncertainty, in the words of its statement.
fn stated(entry: &InputEntry) -> String {
    if let Some(groups) = &entry.groups {
        let count: usize = groups.iter().map(Vec::len).sum();
        return format!("{count} observations in {} groups", groups.len());
    }
    let mut text = match (entry.value, &entry.values) {
        (Some(value), _) => format!("{value:?}"),
        (None, Some(values)) if values.len() <= 12 => format!("{values:?}"),
        (None, Some(values)) => format!("{} values", values.len()),
        (None, None) => return String::new(),
    };
    match &entry.u_of_each {
        Some(each) if each.len() <= 12 => text += &format!(", u = {each:?}"),
        Some(_) => text += ", u of each",
        None => {}
    }
    let number =
        |name: &str, x: Option<f64>| x.map_or_else(String::new, |x| format!(", {name} = {x:?}"));
    text += &number("u", entry.u);
    text += &number("U", entry.expanded);
    text += &number("k", entry.k);
    text += &number("p", entry.probability);
    text += &number("half-width", entry.half_width);
    if let Some(shape) = &entry.shape {
        text += &format!(" ({shape})");
    }
    text += &number("resolution", entry.resolution);
    if let Some(accuracy) = &entry.accuracy {
        text += &format!(
            ", accuracy {} % of reading + {} % of {:?} + {:?}",
            accuracy.reading_percent, accuracy.range_percent, accuracy.range, accuracy.constant
        );
    }
    text
}

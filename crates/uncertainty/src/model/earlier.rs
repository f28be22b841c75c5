//! Earlier results as inputs of a model, with the causes they share.

mod alike;

use super::InputEntry;
use crate::findings;
use crate::{
    DegreesOfFreedom, Distribution, Effect, Estimate, Finding, Influence, Input, Inputs, Refusal,
    TrialColumn, TrialTable,
};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// One `[[earlier]]`: quantities of a result that was filed before, as inputs.
///
/// A cause that two results name, and state with the same u, degrees of freedom and unit, is one cause: what they share
/// correlates them. `independent` names the causes of this result that are its own although another has the same.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct EarlierEntry {
    /// The result.json, from the folder of the model file.
    pub file: String,
    /// Name in the formulas = name in the result.
    pub quantities: BTreeMap<String, String>,
    /// Causes that are not those of the same name in another result.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) independent: Vec<String>,
    /// The estimate of that result, as it is stated: what a reader of the file puts here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimate: Option<Estimate>,
    /// Its trials, where it states a quantity by them: likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trials: Option<TrialTable>,
    /// What needs a decision before that result is used: likewise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
    /// What that result warns of: likewise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Whether no list of files beside it says that it is as it was written: likewise.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub unlisted: bool,
}

impl EarlierEntry {
    /// The trials that are drawn, where a quantity that is asked for is stated by them or had better be drawn.
    fn drawn(&self) -> Option<&TrialTable> {
        let table = self.trials.as_ref()?;
        let by_trials = |name: &String| table.quantity(name).is_some_and(TrialColumn::drawn);
        self.quantities.values().any(by_trials).then_some(table)
    }

    /// Whether it is drawn by its trials, and may as well be by its causes: it states nothing by trials alone.
    fn by_causes(&self) -> bool {
        let alone = |c: &TrialColumn| !c.cause && c.by_trials;
        let table = self.drawn().filter(|_| self.estimate.is_some());
        table.is_some_and(|t| !t.columns.iter().any(alone))
    }

    /// Whether one of the causes of its trials, its own apart, stands behind another result too.
    fn shares_with(&self, other: &Self) -> bool {
        let causes = self
            .trials
            .iter()
            .flat_map(|t| &t.columns)
            .filter(|c| c.cause);
        let mut common = causes.filter(|c| !self.independent.contains(&c.name));
        common.any(|c| c.dof.is_some_and(|nu| other.has(c, nu)))
    }
}

/// One quantity: value + Σ factor (variable − its estimate).
pub(super) struct EarlierQuantity {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) value: f64,
    /// Variable (by its position among the earlier ones), factor, estimate of the variable.
    pub(crate) terms: Vec<(usize, f64, f64)>,
}

/// All quantities of all earlier results, and the causes behind them as inputs.
#[derive(Default)]
pub(super) struct Earlier {
    pub(crate) quantities: Vec<EarlierQuantity>,
    pub(crate) inputs: Vec<Input>,
    correlations: Vec<(usize, usize, f64)>,
    ensembles: Vec<Vec<usize>>,
    /// Statement of each scalar cause, to recognise it: key, u, dof, unit.
    known: Vec<(String, f64, DegreesOfFreedom, String, usize)>,
    /// Variables that are columns of one table of trials.
    rows: Vec<Vec<usize>>,
    /// What is to be said of the results themselves.
    findings: Vec<Finding>,
    /// Causes that two results share.
    shared: Vec<String>,
    /// Causes that two results share, each of them stated by its trials.
    lost: Vec<String>,
}

impl Earlier {
    pub fn of(entries: &[EarlierEntry], inputs: &[InputEntry]) -> Result<Self, Refusal> {
        // What two results share counts for more than how nearly linear they are.
        let mut entries = Cow::Borrowed(entries);
        let (mut all, mut by_law) = (Self::default(), Vec::new());
        for k in 0..entries.len() {
            let entry = &entries[k];
            let mut others = entries.iter().filter(|e| !std::ptr::eq(*e, entry));
            if entry.by_causes() && others.any(|e| e.drawn().is_some() && entry.shares_with(e)) {
                by_law.push(findings::earlier_result_linearised(&entry.file));
                entries.to_mut()[k].trials = None;
            }
        }
        let doubts = entries.iter().filter(|e| !e.doubts.is_empty());
        let doubts =
            doubts.map(|e| findings::earlier_result_in_doubt(&e.file, &e.doubts.join("; ")));
        let warned = entries.iter().filter(|e| !e.warnings.is_empty());
        let warned =
            warned.map(|e| findings::earlier_result_warned(&e.file, &e.warnings.join("; ")));
        let unlisted = entries.iter().filter(|e| e.unlisted);
        let unlisted = unlisted.map(|e| findings::earlier_result_unlisted(&e.file));
        let alike = alike::nearly_alike(&entries);
        let alike = (!alike.is_empty()).then(|| findings::causes_nearly_alike(&alike.join("; ")));
        let own = doubts.chain(warned).chain(unlisted).chain(by_law);
        all.findings = own.chain(alike).collect();
        // Rows of trials come first: a cause that others share with them is a column of theirs.
        for entry in entries.iter() {
            if let Some(table) = entry.drawn() {
                all.add_trials(entry, table, &entries, inputs)?;
            }
        }
        for entry in entries.iter() {
            all.add(entry, inputs)?;
        }
        Ok(all)
    }

    fn add(&mut self, entry: &EarlierEntry, inputs: &[InputEntry]) -> Result<(), Refusal> {
        let refuse = |what: String| Refusal::Equation {
            name: entry.file.clone(),
            what,
        };
        // What is stated by trials is there already.
        let drawn = entry.drawn();
        let by_law = |quantity: &String| {
            let column = drawn.and_then(|table| table.quantity(quantity));
            column.is_none_or(|c| !c.drawn())
        };
        if !entry.quantities.values().any(by_law) {
            return Ok(());
        }
        let Some(estimate) = &entry.estimate else {
            return Err(refuse(
                "the result has no estimate with the causes of its uncertainty".to_owned(),
            ));
        };
        let n = estimate.components().len();
        let mut places = Vec::new();
        for (name, quantity) in entry.quantities.iter().filter(|(_, q)| by_law(q)) {
            let Some(place) = estimate.index_of(quantity) else {
                let names: Vec<&str> = estimate
                    .components()
                    .iter()
                    .map(|c| c.name.as_str())
                    .collect();
                return Err(refuse(format!(
                    "it has no quantity {quantity}; it has {}",
                    names.join(", ")
                )));
            };
            let component = &estimate.components()[place];
            self.quantities.push(EarlierQuantity {
                name: name.clone(),
                unit: component.unit.clone(),
                value: component.value,
                terms: Vec::new(),
            });
            places.push((self.quantities.len() - 1, place));
        }
        if let Some(unknown) = entry
            .independent
            .iter()
            .find(|key| !estimate.influences().iter().any(|i| i.key == **key))
        {
            let keys: Vec<&str> = estimate
                .influences()
                .iter()
                .map(|i| i.key.as_str())
                .collect();
            return Err(refuse(format!(
                "it has no cause {unknown}; its causes are {}",
                keys.join(", ")
            )));
        }
        for influence in estimate.influences() {
            match &influence.effect {
                Effect::Scalar {
                    value,
                    unit,
                    standard_uncertainty: u,
                    sensitivity,
                } => {
                    if *u == 0.0 || places.iter().all(|(_, p)| sensitivity[*p] == 0.0) {
                        continue;
                    }
                    let variable = self.scalar(entry, influence, inputs, *value, *u, unit);
                    let estimate = self.inputs[variable].estimate();
                    for &(quantity, place) in &places {
                        if sensitivity[place] != 0.0 {
                            let term = (variable, sensitivity[place], estimate);
                            self.quantities[quantity].terms.push(term);
                        }
                    }
                }
                joint => {
                    // As the quantities see it: one variable each, correlated.
                    let covariance = joint.covariance(n)?;
                    let mut set: Vec<(usize, usize)> = Vec::new();
                    for &(quantity, place) in &places {
                        let u = covariance.standard_uncertainty(place);
                        if !(u > 0.0) {
                            continue;
                        }
                        let component = &estimate.components()[place];
                        let name = format!("{} on {}", influence.key, component.name);
                        let input = Input::new(
                            self.unused(name, entry, inputs),
                            &component.unit,
                            Distribution::Normal { mean: 0.0, u },
                        );
                        let variable = self.variable(input, influence);
                        self.quantities[quantity].terms.push((variable, 1.0, 0.0));
                        for &(other, other_place) in &set {
                            let r = covariance.correlation(place, other_place).unwrap_or(0.0);
                            if r != 0.0 {
                                self.correlations.push((other, variable, r));
                            }
                        }
                        set.push((variable, place));
                    }
                    if set.len() > 1 {
                        self.ensembles
                            .push(set.into_iter().map(|(v, _)| v).collect());
                    }
                }
            }
        }
        Ok(())
    }

    /// A result that is stated by its trials: whole rows of them, with the columns of the causes that others share.
    fn add_trials(
        &mut self,
        entry: &EarlierEntry,
        table: &TrialTable,
        entries: &[EarlierEntry],
        inputs: &[InputEntry],
    ) -> Result<(), Refusal> {
        let mut row = Vec::new();
        // What is stated by the law of propagation follows from the causes in the same row.
        let mut by_law = false;
        for (name, quantity) in &entry.quantities {
            let column = table.quantity(quantity).filter(|c| c.drawn());
            by_law |= column.is_none();
            let Some(column) = column else { continue };
            let variable = self.column(column, entry, inputs);
            // The draw as it is, whatever was stated as the value (a median, or y of the law of propagation).
            self.quantities.push(EarlierQuantity {
                name: name.clone(),
                unit: column.unit.clone(),
                value: 0.0,
                terms: vec![(variable, 1.0, 0.0)],
            });
            row.push(variable);
        }
        for cause in table.columns.iter().filter(|c| c.cause) {
            let (Some(dof), false) = (cause.dof, entry.independent.contains(&cause.name)) else {
                continue;
            };
            let known =
                |(key, u, nu, unit, _): &&(String, f64, DegreesOfFreedom, String, usize)| {
                    *key == cause.name
                        && crate::estimate::same(*u, cause.scale)
                        && *nu == dof
                        && *unit == cause.unit
                };
            if self.known.iter().any(|k| known(&k)) {
                self.lost.push(cause.name.clone());
                continue;
            }
            let others = entries.iter().filter(|e| !std::ptr::eq(*e, entry));
            if by_law || others.into_iter().any(|e| e.has(cause, dof)) {
                let variable = self.column(cause, entry, inputs);
                self.known.push((
                    cause.name.clone(),
                    cause.scale,
                    dof,
                    cause.unit.clone(),
                    variable,
                ));
                row.push(variable);
            }
        }
        self.rows.push(row);
        Ok(())
    }

    /// A variable that is a column of trials.
    fn column(
        &mut self,
        column: &TrialColumn,
        entry: &EarlierEntry,
        inputs: &[InputEntry],
    ) -> usize {
        let name = self.unused(format!("{} of {}", column.name, entry.file), entry, inputs);
        let values = column.trials.clone();
        let input = Input::new(name, &column.unit, Distribution::Samples { values });
        self.inputs.push(input.description(&column.name));
        self.inputs.len() - 1
    }

    /// The variable of a scalar cause: one that is known, or a new one.
    fn scalar(
        &mut self,
        entry: &EarlierEntry,
        influence: &Influence,
        inputs: &[InputEntry],
        value: f64,
        u: f64,
        unit: &str,
    ) -> usize {
        let own = entry.independent.contains(&influence.key);
        let known = self.known.iter().find(|(key, v, dof, label, _)| {
            !own && *key == influence.key
                && crate::estimate::same(u, *v)
                && *dof == influence.dof
                && label == unit
        });
        if let Some((key, .., variable)) = known {
            if entry.drawn().is_none() && !self.shared.contains(key) {
                self.shared.push(key.clone());
            }
            return *variable;
        }
        let half = |by: f64| (value - u * by.sqrt(), value + u * by.sqrt());
        let distribution = match influence.distribution.as_str() {
            "rectangular" => {
                let (lower, upper) = half(3.0);
                Distribution::Rectangular { lower, upper }
            }
            "triangular" => {
                let (lower, upper) = half(6.0);
                Distribution::Triangular { lower, upper }
            }
            "arcsine" => {
                let (lower, upper) = half(2.0);
                Distribution::Arcsine { lower, upper }
            }
            _ => Distribution::Normal { mean: value, u },
        };
        let name = self.unused(influence.key.clone(), entry, inputs);
        let input = Input::new(name, unit, distribution);
        let variable = self.variable(input, influence);
        if !own {
            self.known.push((
                influence.key.clone(),
                u,
                influence.dof,
                unit.to_owned(),
                variable,
            ));
        }
        variable
    }

    /// A new variable, stated as its cause is.
    fn variable(&mut self, input: Input, cause: &Influence) -> usize {
        self.inputs.push(
            input
                .description(&cause.description)
                .evaluation(cause.evaluation)
                .dof(cause.dof),
        );
        self.inputs.len() - 1
    }

    /// A name that no other input has.
    fn unused(&self, name: String, entry: &EarlierEntry, inputs: &[InputEntry]) -> String {
        let taken = |name: &str| {
            inputs.iter().any(|i| i.name == name) || self.inputs.iter().any(|i| i.name() == name)
        };
        if !taken(&name) {
            return name;
        }
        let mut unused = format!("{name} ({})", entry.file);
        while taken(&unused) {
            unused.push('′');
        }
        unused
    }

    /// The causes beside the inputs of the model.
    pub fn beside(&self, mut inputs: Inputs) -> Result<Inputs, Refusal> {
        let name = |k: usize| self.inputs[k].name();
        let before = inputs.inputs().len();
        for input in &self.inputs {
            inputs = inputs.add(input.clone());
        }
        for &(a, b, r) in &self.correlations {
            inputs = inputs.correlate(name(a), name(b), r);
        }
        for set in &self.ensembles {
            let names: Vec<&str> = set.iter().map(|&k| name(k)).collect();
            inputs = inputs.ensemble(&names)?;
        }
        for row in self.rows.iter().filter(|row| row.len() > 1) {
            let row: Vec<usize> = row.iter().map(|k| before + k).collect();
            inputs = inputs.sampled_together(&row)?;
        }
        Ok(inputs)
    }

    /// What was taken as common, and what could not be.
    pub fn findings(&self) -> Vec<Finding> {
        let shared =
            (!self.shared.is_empty()).then(|| findings::shared_causes(&self.shared.join(", ")));
        let lost = (!self.lost.is_empty())
            .then(|| findings::shared_causes_of_trials(&self.lost.join(", ")));
        let own = self.findings.iter().cloned();
        own.chain(shared).chain(lost).collect()
    }
}

impl EarlierEntry {
    /// Whether it has this cause, stated alike, and does not call it its own.
    fn has(&self, cause: &TrialColumn, dof: DegreesOfFreedom) -> bool {
        let same = |key: &str, u: f64, nu: DegreesOfFreedom, unit: &str| {
            *key == cause.name
                && crate::estimate::same(u, cause.scale)
                && nu == dof
                && unit == cause.unit
        };
        if self.independent.contains(&cause.name) {
            return false;
        }
        if let Some(table) = self.drawn() {
            let mut causes = table.columns.iter().filter(|c| c.cause);
            return causes.any(|c| c.dof.is_some_and(|nu| same(&c.name, c.scale, nu, &c.unit)));
        }
        let influences = self.estimate.iter().flat_map(Estimate::influences);
        influences.into_iter().any(|i| match &i.effect {
            Effect::Scalar {
                unit,
                standard_uncertainty,
                ..
            } => same(&i.key, *standard_uncertainty, i.dof, unit),
            _ => false,
        })
    }
}

//! A model file, with the lines that its refusals point to.

use super::{UncertaintyJob, UncertaintyOutcome, trouble};
use crate::Outcome;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::{
    ColumnTrouble, Fate, ResultDocument, StatedQuantity, TrialFile, Verification, check_model,
    explain_model, fill_columns, parse_model,
};
use proofmass_io::{Input, LARGEST_DOCUMENT, RowWriter, Source, unlisted};
use proofmass_uncertainty::{
    EarlierEntry, Evaluate, EvidenceValue, Finding, Refusal, Severity, SweepEntry, TargetEntry,
    UncertaintyModel,
};
use std::ops::ControlFlow;
use std::path::Path;

/// The text of a model and what it says.
#[derive(Clone, Debug)]
pub struct ModelText {
    model: UncertaintyModel,
    text: String,
    name: String,
    inputs: Vec<Input>,
}

impl ModelText {
    /// Reads a model file (TOML).
    ///
    /// # Errors
    /// No text, no model; with the line.
    pub fn read(source: Source) -> Result<Self> {
        let name = source.name().display().to_string();
        let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
        let text = String::from_utf8(bytes).map_err(|_| {
            Trouble::data(format!("{name}: the text is not UTF-8"))
                .with_hint("a model is a TOML text in UTF-8")
        })?;
        let at_line = |refusal: &Refusal| at_its_line(&name, refusal);
        let mut model = parse_model(&text).map_err(|refusal| at_line(&refusal))?;
        let mut inputs = vec![input];
        for entry in &mut model.earlier {
            let path = Path::new(&name).with_file_name(&entry.file);
            let (bytes, mut input) = Source::open(&path)?.into_bytes(LARGEST_DOCUMENT)?;
            // The entry says it.
            let doubt = input.doubt.take();
            entry.unlisted = unlisted(&path, &input).is_some();
            inputs.push(input);
            let about = |trouble: proofmass_io::Error| Trouble::from(trouble).about(&entry.file);
            let document = ResultDocument::from_json(&bytes).map_err(about)?;
            entry.estimate = document.stated().map_err(about)?.cloned();
            entry.doubts = doubts(&document);
            entry.doubts.extend(doubt);
            entry.doubts.extend(altered(&path, &document));
            entry.warnings = warnings(&document);
            if let Some(name) = unstated(&document, entry) {
                return Err(Trouble::data(format!(
                    "{}: {name} is in its estimate, but no quantity that it states",
                    entry.file
                ))
                .with_hint("the file was changed: evaluate the result again"));
            }
            if let Some(file) = TrialFile::in_result(&document).map_err(about)? {
                let beside = path.with_file_name(&file.file);
                let source = Source::open(&beside).map_err(|e| {
                    e.with_hint("the result states quantities by Monte Carlo: keep this file beside its result.json, as -o writes both")
                })?;
                let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
                let table = file.table(bytes, &document);
                entry.trials = Some(table.map_err(|e| Trouble::from(e.at(&beside)))?);
                inputs.push(input);
            } else if let Some(name) = without_trials(&document, entry) {
                return Err(Trouble::data(format!(
                    "{}: {name} is stated by Monte Carlo, which no value with an uncertainty says again",
                    entry.file
                ))
                .with_hint("evaluate it again with this version, which keeps the trials beside it"));
            }
        }
        let folder = Path::new(&name).with_file_name("");
        inputs.extend(
            fill_columns(&mut model, &folder).map_err(|trouble| match trouble {
                ColumnTrouble::Table(error) => Trouble::from(error),
                ColumnTrouble::Entry(refusal) => at_line(&explain_model(&model, &text, refusal)),
            })?,
        );
        check_model(&model, &text).map_err(|refusal| at_line(&refusal))?;
        Ok(Self {
            model,
            text,
            name,
            inputs,
        })
    }

    /// Evaluates the model.
    ///
    /// # Errors
    /// As [`UncertaintyJob::run`], with the line.
    pub fn evaluate(&self, options: Evaluate, watch: &dyn Watch) -> Result<UncertaintyOutcome> {
        let job = UncertaintyJob {
            model: self.model.clone(),
            options,
        };
        job.run(watch).map_err(|refusal| {
            at_its_line(&self.name, &explain_model(&self.model, &self.text, refusal))
        })
    }

    /// Asks for sweeps and targets beside those of the file.
    pub fn ask(&mut self, sweeps: Vec<SweepEntry>, targets: Vec<TargetEntry>) {
        self.model.sweep.extend(sweeps);
        self.model.target.extend(targets);
    }

    /// Writes the trials behind a result as CSV, a column per output, and says how many were left out because an output is no
    /// finite number in them.
    ///
    /// # Errors
    /// As [`UncertaintyModel::draws`]; a file that cannot be written, or that is an input.
    pub fn write_draws(
        &self,
        options: &Evaluate,
        outcome: &UncertaintyOutcome,
        path: &Path,
    ) -> Result<usize> {
        let outputs = outcome.result.outputs.iter();
        let headings: Vec<String> = outputs
            .map(|o| match o.unit.as_str() {
                "" | "1" => o.name.clone(),
                unit => format!("{}_{unit}", o.name),
            })
            .collect();
        let inputs: Vec<&Path> = self.inputs.iter().map(|i| Path::new(&i.path)).collect();
        let mut writer = RowWriter::create(path, &headings, &inputs)?;
        let (mut left_out, mut failed) = (0, None);
        let mut row = Vec::with_capacity(headings.len());
        let made = self
            .model
            .draws(options, outcome.result.trials, &mut |columns| {
                for trial in 0..columns.first().map_or(0, Vec::len) {
                    row.clear();
                    row.extend(columns.iter().map(|column| column[trial]));
                    if row.iter().any(|y| !y.is_finite()) {
                        left_out += 1;
                    } else if let Err(error) = writer.row(&row) {
                        failed = Some(error);
                        return ControlFlow::Break(());
                    }
                }
                ControlFlow::Continue(())
            });
        if let Some(error) = failed {
            return Err(error.into());
        }
        made.map_err(|refusal| trouble(&refusal))?;
        writer.commit()?;
        Ok(left_out)
    }

    /// The model file, and the earlier results and tables it speaks of, with their digests.
    pub fn inputs(&self) -> Vec<Input> {
        self.inputs.clone()
    }
}

/// What needs a decision before a result is used. That Monte Carlo refutes a linear result is settled where Monte Carlo states it.
fn doubts(document: &ResultDocument) -> Vec<String> {
    let settled = |finding: &Finding| {
        let named = document.quantities.iter().find(|q| {
            let name = EvidenceValue::from(q.name.as_str());
            finding.evidence_fields().get("name") == Some(&name)
        });
        finding.code() == "linear-result-not-validated"
            && named.is_some_and(|q| q.method.as_deref() == Some("monte-carlo"))
    };
    let findings = document.findings.iter();
    let grave = findings.filter(|f| f.severity() == Severity::Decision && !settled(f));
    grave.map(|f| f.what().to_owned()).collect()
}

/// What a result warns of, which its numbers carry on; that Monte Carlo states a quantity settles a warning about its linearity.
fn warnings(document: &ResultDocument) -> Vec<String> {
    let findings = document.findings.iter();
    let warned = findings
        .filter(|f| f.severity() == Severity::Warning && f.code() != "linear-result-not-validated");
    warned.map(|f| f.what().to_owned()).collect()
}

/// What was changed since the result was written: the file itself, and of models, which are small, what they were computed from.
fn altered(path: &Path, document: &ResultDocument) -> Vec<String> {
    let mut found = Vec::new();
    if document.kind == UncertaintyOutcome::KIND
        && let Ok(chain) = Verification::of(path, None)
    {
        let changed = chain.links.iter().filter(|l| l.fate == Fate::Changed);
        let others = changed.filter(|l| l.found.as_deref() != Some(path));
        found.extend(others.map(|l| {
            let place = l.found.as_deref().unwrap_or(Path::new(&l.name));
            let by = l.named_by.display();
            format!("{} was changed since {by} was computed", place.display())
        }));
    }
    found
}

/// A quantity that is asked for and in the estimate, but is not stated.
fn unstated<'a>(document: &ResultDocument, entry: &'a EarlierEntry) -> Option<&'a str> {
    let estimate = entry.estimate.as_ref()?;
    let mut asked = entry.quantities.values();
    let found = asked.find(|name| {
        estimate.index_of(name).is_some() && !document.quantities.iter().any(|q| q.name == **name)
    });
    found.map(String::as_str)
}

/// A quantity that is asked for and stated by trials, which are not there.
fn without_trials<'a>(document: &'a ResultDocument, entry: &EarlierEntry) -> Option<&'a str> {
    let asked = |name: &String| entry.quantities.values().any(|q| q == name);
    let by_trials =
        |q: &StatedQuantity| q.interval.is_some() || q.method.as_deref() == Some("monte-carlo");
    let mut quantities = document.quantities.iter();
    let found = quantities.find(|q| by_trials(q) && asked(&q.name));
    found.map(|q| q.name.as_str())
}

/// `file:line: what`, and what to do.
fn at_its_line(name: &str, refusal: &Refusal) -> Trouble {
    let Refusal::File { line, reason } = refusal else {
        return trouble(refusal).about(name);
    };
    let line = line.map_or(String::new(), |line| format!("{line}:"));
    Trouble::request(format!("{name}:{line} {reason}")).with_hint(super::MODEL_FILE)
}

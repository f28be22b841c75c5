//! What became of recordings that were written in another format.

use super::plan::{Plan, word};
use crate::outcome::Outcome;
use crate::plural::count;
use crate::record::Record;
use proofmass_documents::StatedQuantity;
use proofmass_io::{Input, TargetForm};
use proofmass_report::{KeyFigure, Report, Section};
use proofmass_uncertainty::Finding;

/// Rows, digest, and what the target lost.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvertOutcome {
    form: TargetForm,
    rows: u64,
    columns: Vec<String>,
    lost: Vec<String>,
    notes: Vec<String>,
    recordings: Vec<Input>,
    sha256: Option<String>,
    findings: Vec<Finding>,
}

impl ConvertOutcome {
    pub(super) fn new(
        form: TargetForm,
        plans: Vec<Plan>,
        recordings: Vec<Input>,
        sha256: Option<String>,
        mut findings: Vec<Finding>,
    ) -> Self {
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Self {
            form,
            rows: plans.iter().map(|plan| plan.writing.rows()).sum(),
            lost: together(&plans, |plan| &plan.lost),
            notes: together(&plans, |plan| &plan.notes),
            columns: plans.into_iter().next().map_or(Vec::new(), |p| p.columns),
            recordings,
            sha256,
            findings,
        }
    }

    /// Rows written: samples of each signal.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Columns or channels that were written, with their units.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// What the target lost, each in a line.
    pub fn lost(&self) -> &[String] {
        &self.lost
    }

    /// What was left away or put in without loss, each in a line.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The recordings with their digests.
    pub fn recordings(&self) -> &[Input] {
        &self.recordings
    }

    /// SHA-256 of what was written, where a file of it stays.
    pub fn sha256(&self) -> Option<&str> {
        self.sha256.as_deref()
    }

    /// What was written, in one line.
    pub fn statement(&self) -> String {
        let rows = count(self.rows as usize, "row");
        let word_of = if self.form.holds_times() {
            "column"
        } else {
            "channel"
        };
        let columns = count(self.columns.len(), word_of);
        format!("{rows} of {columns}, {}", word(self.form))
    }
}

impl Outcome for ConvertOutcome {
    const KIND: &'static str = "convert";

    fn title(&self, record: &Record) -> String {
        record.title(
            "Recording in another format of",
            "Recording in another format",
        )
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        Vec::new()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn page(&self, page: Report) -> Report {
        let mut section = Section::new("Lost on the way");
        for line in &self.lost {
            section = section.paragraph(line.clone());
        }
        if self.lost.is_empty() {
            section = section.paragraph("Nothing.");
        }
        for line in &self.notes {
            section = section.paragraph(format!("Not lost: {line}"));
        }
        page.verdict(format!("Written: {}.", self.statement()))
            .answers([KeyFigure::new("rows", self.rows.to_string(), "")])
            .section(section.summarised())
    }
}

/// Lines about recordings: what is said of all of them once, what differs with the first one that it is said of.
fn together(plans: &[Plan], lines: impl Fn(&Plan) -> &Vec<String>) -> Vec<String> {
    let head = |line: &str| line.split(':').next().unwrap_or_default().to_owned();
    let mut all: Vec<(String, Vec<(&str, &str)>)> = Vec::new();
    for plan in plans {
        for line in lines(plan) {
            let (key, of) = (head(line), (plan.recordings.as_str(), line.as_str()));
            match all.iter_mut().find(|(known, _)| *known == key) {
                Some((_, said)) => said.push(of),
                None => all.push((key, vec![of])),
            }
        }
    }
    let line = |said: Vec<(&str, &str)>| {
        let (first, line) = said[0];
        if said.len() == plans.len() && said.iter().all(|(_, other)| *other == line) {
            return line.to_owned();
        }
        match said.len() - 1 {
            0 => format!("{first}: {line}"),
            others => format!(
                "{first}: {line}; {} likewise",
                count(others, "other recording")
            ),
        }
    };
    all.into_iter().map(|(_, said)| line(said)).collect()
}

//! What became of recordings that were written in another format.

use super::plan::{Plan, word};
use crate::outcome::Outcome;
use crate::plural::count;
use crate::record::Record;
use proofmass_io::{Input, StatedQuantity, TargetForm};
use proofmass_report::{KeyFigure, Report, Section};
use proofmass_uncertainty::Finding;

/// Rows, digest, and what the target lost.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvertOutcome {
    form: TargetForm,
    rows: u64,
    columns: Vec<String>,
    lost: Vec<String>,
    recordings: Vec<Input>,
    sha256: Option<String>,
    findings: Vec<Finding>,
}

impl ConvertOutcome {
    pub(super) fn new(
        form: TargetForm,
        plan: Plan,
        recordings: Vec<Input>,
        sha256: Option<String>,
        mut findings: Vec<Finding>,
    ) -> Self {
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Self {
            form,
            rows: plan.writing.rows(),
            columns: plan.columns,
            lost: plan.lost,
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

    /// What the target lost and what was put in, each in a line.
    pub fn lost(&self) -> &[String] {
        &self.lost
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
        page.verdict(format!("Written: {}.", self.statement()))
            .answers([KeyFigure::new("rows", self.rows.to_string(), "")])
            .section(section.summarised())
    }
}

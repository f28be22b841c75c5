//! The page of a simulation: which files, with which digests.

use crate::{Report, Section};

/// What the page tells.
#[derive(Clone, Debug, Default)]
pub struct SimulationReport {
    /// Title.
    pub title: String,
    /// Label and value.
    pub meta: Vec<(String, String)>,
    /// What was simulated.
    pub scenario: String,
    /// Name and SHA-256 of each file.
    pub files: Vec<(String, String)>,
    /// Last line.
    pub footer: String,
}

impl SimulationReport {
    /// The page.
    pub fn page(&self) -> Report {
        let mut report = Report::new(self.title.clone()).meta("Scenario", self.scenario.clone());
        for (label, value) in &self.meta {
            report = report.meta(label.clone(), value.clone());
        }
        report
            .section(Section::new("Files").inputs(&self.files))
            .footer(self.footer.clone())
    }
}

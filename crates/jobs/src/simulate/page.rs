//! The page of a simulation: which files, with which digests.

use proofmass_report::{Head, Report, Section};

/// What the page tells.
#[derive(Clone, Debug, Default)]
pub(crate) struct SimulationReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Name and SHA-256 of each file.
    pub files: Vec<(String, String)>,
}

impl SimulationReport<'_> {
    /// The page.
    pub(crate) fn page(&self) -> Report {
        self.head
            .open()
            .section(Section::new("Files").inputs(&self.files))
            .footer(self.head.footer.clone())
    }
}

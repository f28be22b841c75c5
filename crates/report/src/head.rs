//! What every report says of where it comes from.

use crate::{Report, Section};
use proofmass_uncertainty::Finding;

/// Title, device, inputs, findings: what the caller and the outcome give to a page of any kind.
#[derive(Clone, Debug, Default)]
pub struct Head<'a> {
    /// Title.
    pub title: String,
    /// Label and value: device, conditions, date.
    pub meta: Vec<(String, String)>,
    /// Name and SHA-256 of each input file.
    pub inputs: Vec<(String, String)>,
    /// All findings.
    pub findings: &'a [Finding],
    /// Last line.
    pub footer: String,
}

impl Head<'_> {
    /// A report of this title and device.
    pub fn open(&self) -> Report {
        self.meta
            .iter()
            .fold(Report::new(self.title.clone()), |report, (label, value)| {
                report.meta(label.clone(), value.clone())
            })
    }
}

impl Report {
    /// Ends with the input files and the last line.
    pub fn foot(self, head: &Head<'_>) -> Self {
        self.section(Section::new("Inputs").inputs(&head.inputs))
            .footer(head.footer.clone())
    }
}

//! The page of a simulation: which files, with which digests.

use super::SimulateOutcome;
use proofmass_report::{KeyFigure, Report, Section};

pub(super) fn add(page: Report, simulation: &SimulateOutcome) -> Report {
    let files = simulation.files.iter();
    let files: Vec<_> = files.map(|f| (f.path.clone(), f.sha256.clone())).collect();
    page.meta("Scenario", &simulation.scenario)
        .verdict("The truth is known and stands in truth.json.")
        .answers(
            [KeyFigure::new("files written", files.len().to_string(), "")
                .note(format!("scenario {}", simulation.scenario))],
        )
        .section(Section::new("Files").inputs(&files).summarised())
}

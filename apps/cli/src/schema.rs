//! `proofmass schema`: the JSON schema of a file or a request.

use crate::{Failure, Outcome, console};
use clap::builder::PossibleValuesParser;
use std::fmt::Write as _;

/// Declares the schemas that come with the program, by the name of their file.
macro_rules! schemas {
    ($($name:literal,)*) => {
        /// Name and text of every schema; the files are made from the types that read (`cargo run -p proofmass-jobs --features schema --example schemas`).
        const SCHEMAS: &[(&str, &str)] = &[$(($name, include_str!(concat!("../schemas/", $name, ".json")))),*];
        /// Names of them.
        const NAMES: &[&str] = &[$($name),*];
    };
}

schemas! {
    "campaign",
    "multi-position",
    "free-living",
    "single-axis",
    "shaker-triaxial",
    "shaker-single",
    "shaker-primary",
    "transverse-sensitivity",
    "spurious-motion",
    "budget",
    "modes",
    "model",
    "limits",
    "laboratory",
    "result",
    "calibration",
    "manifest",
    "provenance",
    "request",
    "multi-position-request",
    "free-living-request",
    "shaker-triaxial-request",
    "shaker-single-request",
    "shaker-primary-request",
    "transverse-sensitivity-request",
    "spurious-motion-request",
    "plan-request",
    "validation-request",
    "apply-request",
    "convert-request",
    "inspect-request",
    "noise-request",
    "noise-comparison-request",
    "device-check-request",
    "device-plan-request",
    "velocity-estimate-request",
    "velocity-compare-request",
    "velocity-tune-request",
    "velocity-map-request",
    "velocity-drift-request",
    "velocity-integrator-request",
    "temperature-request",
    "bias-request",
    "static-test-request",
    "simulate-request",
    "uncertainty-request",
    "modes-request",
    "shock-request",
    "response-request",
    "transducer-model-request",
    "step-request",
    "levels-request",
    "motion-request",
    "comparison-request",
    "certificate-request",
    "deconvolution-request",
}

/// Print the JSON schema (draft 2020-12) of a file or a request, or list them.
///
/// Editors complete and mark the keys of a campaign.toml whose first line names its schema, as `proofmass init` writes it: `#:schema ADDRESS`.
/// Without a network put the schema beside it: `proofmass schema multi-position > schema.json`, and `#:schema ./schema.json`.
#[derive(clap::Args)]
pub(crate) struct Schema {
    /// Kind of a campaign, another file, or a job with `-request` behind it; none for the list
    #[arg(value_parser = PossibleValuesParser::new(NAMES), hide_possible_values = true)]
    kind: Option<String>,
}

impl Schema {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let text = match &self.kind {
            Some(kind) => {
                let found = SCHEMAS.iter().find(|(name, _)| name == kind);
                found.map_or_else(String::new, |(_, text)| (*text).to_owned())
            }
            None => list(),
        };
        console::print(&text)?;
        Ok(Outcome::Done)
    }
}

/// A line for each: name and title.
fn list() -> String {
    let width = NAMES.iter().map(|name| name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for (name, schema) in SCHEMAS {
        let title = schema
            .lines()
            .find_map(|line| line.trim().strip_prefix("\"title\": \""));
        let title = title.unwrap_or_default().trim_end_matches("\",");
        let _ = writeln!(text, "{name:width$}  {title}");
    }
    text
}

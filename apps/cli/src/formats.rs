//! `proofmass formats`: which formats of recordings are read and written.

use crate::{Failure, Outcome, console};
use proofmass::io::formats::FORMATS;
use serde::Serialize;

/// List the formats of recordings that are known by their content: which are read, how far, which `convert` writes, and what to do with the others.
#[derive(clap::Args)]
pub(crate) struct Formats {
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

/// A row of the list.
#[derive(Serialize)]
struct Row {
    format: &'static str,
    name: &'static str,
    read: bool,
    /// The cargo feature without which it is not read.
    #[serde(skip_serializing_if = "Option::is_none")]
    feature: Option<&'static str>,
    written: bool,
    limits: &'static str,
}

/// What has no mark at its beginning.
const UNMARKED: [Row; 2] = [
    Row {
        format: "text",
        name: "delimited text (CSV and its kin)",
        read: true,
        feature: None,
        written: true,
        limits: "one row for each sample; written by every command; gzip and zstd around any format are unpacked",
    },
    Row {
        format: "f32",
        name: "raw 32-bit floats",
        read: true,
        feature: None,
        written: false,
        limits: "waveforms of a campaign that says `format = \"f32\"`",
    },
];

impl Formats {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let known = FORMATS.iter().map(|f| Row {
            format: f.word,
            name: f.name,
            read: f.is_read(),
            feature: f.feature(),
            written: f.is_written(),
            limits: f.limits,
        });
        let mut rows: Vec<Row> = UNMARKED.into_iter().chain(known).collect();
        rows.sort_by_key(|row| !row.read);
        if self.json {
            let json = serde_json::to_vec_pretty(&rows);
            let json =
                json.map_err(|e| Failure::new(format!("the list cannot be written: {e}")))?;
            console::print_json(&json)?;
            return Ok(Outcome::Done);
        }
        let width = rows.iter().map(|row| row.format.len()).max().unwrap_or(0);
        for row in &rows {
            let read = match (row.read, row.written) {
                (true, true) => "read, written",
                (true, false) => "read",
                _ => "not read",
            };
            let (format, name, limits) = (row.format, row.name, row.limits);
            let feature = row.feature.map(|f| format!(" (feature {f})"));
            let feature = feature.unwrap_or_default();
            console::print(&format!(
                "{format:width$}  {read:13}  {name}{feature}: {limits}\n"
            ))?;
        }
        Ok(Outcome::Done)
    }
}

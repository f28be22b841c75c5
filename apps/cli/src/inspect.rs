//! `proofmass inspect`: what is in a file.

use crate::plural::count;
use crate::{Failure, Outcome, console};
use proofmass::io::{Inspection, inspect};
use proofmass::report::{Cell, Column, Report, Section, Table};
use std::path::PathBuf;

/// Show what is in a recording: columns, units, rate, gaps, ranges, statistics.
#[derive(clap::Args)]
pub(crate) struct Inspect {
    /// Delimited text of any common shape
    file: PathBuf,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let inspection = inspect(&self.file)?;
        if self.json {
            let json = serde_json::to_vec_pretty(&inspection)
                .map_err(|e| Failure::new(format!("the inspection cannot be written: {e}")))?;
            console::print_json(&json)?;
        } else {
            console::show(&report(&inspection))?;
        }
        Ok(Outcome::Done)
    }
}

fn report(inspection: &Inspection) -> Report {
    let layout = &inspection.layout;
    let mut report = Report::new(inspection.path.display().to_string())
        .meta("rows", inspection.rows.to_string())
        .meta(
            "separator",
            format!("{:?}", layout.separator).to_lowercase(),
        )
        .meta("header", if layout.header.is_some() { "yes" } else { "no" });
    if let Some(time) = &inspection.time {
        report = report
            .meta("time", format!("column {}", time.column))
            .meta("rate", format!("{:.6} Hz", time.rate_hz))
            .meta("duration", format!("{:.3} s", time.duration_s))
            .meta("gaps", time.gap_count.to_string());
        if let Some(jitter) = time.jitter_s {
            report = report.meta("jitter", format!("{:.1e} s", jitter));
        }
    }
    let mut table = Table::new(
        "",
        [
            Column::number("no.", ""),
            Column::text("name"),
            Column::text("unit"),
            Column::number("min", ""),
            Column::number("mean", ""),
            Column::number("max", ""),
            Column::number("std dev", ""),
            Column::number("step", ""),
        ],
    );
    let number = |v: Option<f64>| v.map_or(Cell::Empty, |v| Cell::number(significant(v)));
    for column in &inspection.columns {
        let s = column.statistics.as_ref();
        table = table.row([
            Cell::number(column.number.to_string()),
            Cell::text(column.name.clone()),
            Cell::text(column.unit.map(|u| u.to_string()).unwrap_or_default()),
            number(s.map(|s| s.min)),
            number(s.map(|s| s.mean)),
            number(s.map(|s| s.max)),
            number(s.and_then(|s| s.standard_deviation)),
            number(s.and_then(|s| s.resolution)),
        ]);
    }
    let mut section = Section::new("Columns").table(table);
    if let Some(time) = &inspection.time {
        if let Some(line) = time.backward_lines.first() {
            section = section.paragraph(format!(
                "Time does not run forward on {}, the first is line {line}.",
                count(time.backward_lines.len(), "line")
            ));
        }
        if let Some(gap) = time.gaps.first() {
            section = section.paragraph(format!(
                "{}; the first is {:.4} s long, after line {}.",
                count(time.gap_count as usize, "gap"),
                gap.step_s,
                gap.line
            ));
        }
    }
    if let Some(bad) = inspection.bad.first() {
        section = section.paragraph(format!(
            "{} not a finite number; the first is {:?} on line {}, column {}.",
            count(inspection.bad_count as usize, "field"),
            bad.text,
            bad.line,
            bad.column
        ));
    }
    report.section(section)
}

/// Six significant digits.
fn significant(v: f64) -> String {
    if v == 0.0 {
        return "0".to_owned();
    }
    let magnitude = v.abs().log10().floor() as i32;
    if !(-4..=9).contains(&magnitude) {
        return format!("{v:.3e}");
    }
    format!("{v:.*}", (5 - magnitude).clamp(0, 9) as usize)
}

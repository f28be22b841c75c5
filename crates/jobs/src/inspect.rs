//! What is in a recording, before anything is made of it.

use crate::outcome::{Job, Outcome};
use crate::plural::count;
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_io::{Inspection, Source, StatedQuantity, inspect_source};
use proofmass_report::{Cell, Column, Report, Section, Table};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};
use std::sync::Mutex;

/// How closely a recording is looked at.
///
/// ```
/// use proofmass_io::Source;
/// use proofmass_jobs::inspect::{InspectData, InspectJob};
/// use proofmass_jobs::{Job, Unwatched};
///
/// let recording = Source::from_bytes("raw.csv", "t_s,acc_m/s2\n0,9.81\n0.01,9.82\n0.02,9.80\n")?;
/// let outcome = InspectJob::default().evaluate(&InspectData::new(recording), &Unwatched)?;
/// let inspection = outcome.inspection();
/// assert_eq!((inspection.rows, inspection.columns.len()), (3, 2));
/// assert!((inspection.time.as_ref().unwrap().rate_hz - 100.0).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct InspectJob {
    /// How many damaged places are listed; all are counted.
    pub listed: usize,
    /// Whether the page lists them.
    pub damage: bool,
}

impl Default for InspectJob {
    fn default() -> Self {
        Self {
            listed: 100,
            damage: false,
        }
    }
}

impl InspectJob {
    /// Every damaged place, up to ten thousand, is listed on the page.
    pub fn damage() -> Self {
        Self {
            listed: 10_000,
            damage: true,
        }
    }
}

/// A recording that is seen once.
pub struct InspectData {
    once: Mutex<Option<Source>>,
}

impl InspectData {
    /// The data serve one evaluation.
    pub fn new(recording: Source) -> Self {
        Self {
            once: Mutex::new(Some(recording)),
        }
    }
}

/// What was seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InspectOutcome {
    inspection: Inspection,
    damage: bool,
}

impl InspectOutcome {
    /// Columns, units, rate, gaps, ranges, statistics.
    pub fn inspection(&self) -> &Inspection {
        &self.inspection
    }
}

impl Job for InspectJob {
    type Data<'a> = InspectData;
    type Outcome = InspectOutcome;

    fn evaluate(&self, data: &InspectData, watch: &dyn Watch) -> Result<InspectOutcome> {
        watch.step("inspection", 0, 1)?;
        let once = data.once.lock().ok().and_then(|mut once| once.take());
        let source = once
            .ok_or_else(|| Trouble::data("the recording was read already: it can be seen once"))?;
        let inspection = inspect_source(source, self.listed)?;
        watch.step("inspection", 1, 1)?;
        Ok(InspectOutcome {
            inspection,
            damage: self.damage,
        })
    }
}

impl Outcome for InspectOutcome {
    const KIND: &'static str = "inspect";

    fn title(&self, record: &Record) -> String {
        let name = || self.inspection.path.display().to_string();
        record.title.clone().unwrap_or_else(name)
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        Vec::new()
    }

    fn findings(&self) -> &[Finding] {
        &self.inspection.findings
    }

    fn summary(&self, record: &Record) -> Report {
        report(&self.inspection, self.damage, self.title(record))
    }

    fn report(&self, record: &Record) -> Report {
        self.summary(record).footer(record.software.to_string())
    }
}

fn report(inspection: &Inspection, damage: bool, title: String) -> Report {
    let layout = &inspection.layout;
    let mut report = Report::new(title)
        .meta("rows", inspection.rows.to_string())
        .meta(
            "separator",
            format!("{:?}", layout.separator).to_lowercase(),
        )
        .meta("header", if layout.header.is_some() { "yes" } else { "no" });
    if let Some(time) = &inspection.time {
        report = report
            .meta("time", format!("column {}", time.column))
            .meta(
                "rate",
                format!(
                    "{:.6} Hz, u = {:.1e} Hz",
                    time.rate_hz, time.clock.rate_u_hz
                ),
            )
            .meta(
                "resolution of the stamps",
                format!("{} s", significant(time.clock.resolution_s)),
            )
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
    if let Some(row) = inspection.bad_rows.first() {
        section = section.paragraph(format!(
            "{} of another width, left out of everything above; the first has {} on line {}.",
            count(inspection.bad_row_count as usize, "row"),
            count(row.fields, "field"),
            row.line
        ));
    }
    let mut report = report
        .section(section)
        .findings(inspection.findings.iter().cloned());
    if damage {
        report = report.section(places(inspection));
    }
    report
}

/// Every damaged place, in the order of lines.
fn places(inspection: &Inspection) -> Section {
    let rows = inspection.bad_rows.iter().map(|b| {
        let what = format!(
            "{}, not {}",
            count(b.fields, "field"),
            inspection.layout.columns
        );
        (b.line, String::new(), what, b.text.clone())
    });
    let fields = inspection.bad.iter().map(|b| {
        let what = "not a finite number".to_owned();
        (b.line, b.column.clone(), what, b.text.clone())
    });
    let times = inspection.time.iter().flat_map(|t| {
        let column = t.column.clone();
        let backward = t.backward_lines.iter().map({
            let column = column.clone();
            move |line| {
                (
                    *line,
                    column.clone(),
                    "time does not run forward".to_owned(),
                    String::new(),
                )
            }
        });
        let gaps = t.gaps.iter().map(move |g| {
            let what = format!("{:.6} s without a sample after this line", g.step_s);
            (g.line, column.clone(), what, String::new())
        });
        backward.chain(gaps).collect::<Vec<_>>()
    });
    let mut all: Vec<_> = rows.chain(fields).chain(times).collect();
    all.sort_by_key(|p| p.0);
    if all.is_empty() {
        return Section::new("Damage").paragraph("None was found.");
    }
    let table = Table::new(
        "",
        [
            Column::number("line", ""),
            Column::text("column"),
            Column::text("what"),
            Column::text("text"),
        ],
    );
    let table = all
        .into_iter()
        .fold(table, |table, (line, column, what, text)| {
            table.row([
                Cell::number(line.to_string()),
                Cell::text(column),
                Cell::text(what),
                Cell::text(text),
            ])
        });
    Section::new("Damage").table(table)
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

//! What is in a recording, before anything is made of it.

mod course;

use crate::findings;
use crate::outcome::{Job, Outcome, section};
use crate::page::answer::plus_minus;
use crate::page::measures::lines;
use crate::plural::count;
use crate::record::Record;
use crate::recording::RecordingReading;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_documents::StatedQuantity;
use proofmass_io::{
    ColumnSummary, Inspection, Source, Statistics, StreamSummary, Trace, inspect_source,
    inspect_traced,
};
use proofmass_report::{Cell, Field, KeyFigure, Place, Report, Section, Table, scientific};
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct InspectJob {
    /// How many damaged places are listed; all are counted.
    pub listed: usize,
    /// Whether the page lists them.
    pub damage: bool,
    /// Whether the page shows the course of the signals.
    pub plot: bool,
    /// What the recording does not say itself; every column is looked at where none is named.
    pub reading: RecordingReading,
}

impl Default for InspectJob {
    fn default() -> Self {
        Self {
            listed: 100,
            damage: false,
            plot: false,
            reading: RecordingReading::default(),
        }
    }
}

impl InspectJob {
    /// Every damaged place, up to ten thousand, is listed on the page.
    pub fn damage() -> Self {
        Self {
            listed: 10_000,
            damage: true,
            ..Self::default()
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
#[derive(Clone, Debug, PartialEq)]
pub struct InspectOutcome {
    inspection: Inspection,
    traces: Vec<Trace>,
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
        let source = once.ok_or_else(|| {
            Trouble::data("this recording was used up by an earlier job: open it again")
        })?;
        let columns = self.reading.columns.clone().unwrap_or_default();
        let options = self.reading.reading_of(columns)?;
        let (mut inspection, traces) = match self.plot {
            true => inspect_traced(source, &options, self.listed)?,
            false => (inspect_source(source, &options, self.listed)?, Vec::new()),
        };
        if self.plot && undecided(&inspection) {
            return Err(Trouble::data(format!(
                "a picture shows one stream, and the file holds {}",
                inspection.streams.len()
            ))
            .detail(inspection.path.display().to_string())
            .with_hint("choose one with --source NAME; `proofmass inspect` lists them"));
        }
        watch.step("inspection", 1, 1)?;
        let told = (!undecided(&inspection))
            .then(|| unsaid(&inspection))
            .flatten();
        inspection.findings.extend(told);
        Ok(InspectOutcome {
            inspection,
            traces,
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

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![section("inspection", &self.inspection)?])
    }

    fn page(&self, page: Report) -> Report {
        let mut page = head(page, &self.inspection);
        if let Some((caption, plot)) = course::plot(&self.inspection, &self.traces) {
            page = page.shown_by(caption, plot);
        }
        if self.inspection.streams.len() > 1 {
            page = page.section(streams(&self.inspection).summarised());
        }
        if !undecided(&self.inspection) {
            page = page.section(columns(&self.inspection).summarised());
        }
        // No result.json holds what the reader of the file says.
        let said: Vec<String> = self
            .inspection
            .findings
            .iter()
            .filter_map(evidence)
            .collect();
        if !said.is_empty() {
            let section = Section::new("Evidence").at(Place::Summary);
            page = page.section(said.into_iter().fold(section, Section::paragraph));
        }
        // A summary cuts long tables of the page; these places stand in it alone and whole.
        match self.damage {
            true => page
                .section(places(&self.inspection).at(Place::Summary))
                .section(places(&self.inspection)),
            false => page,
        }
    }
}

/// What the file does not say and other commands ask for: units of columns of numbers, the clock.
fn unsaid(inspection: &Inspection) -> Option<Finding> {
    let layout = &inspection.layout;
    let open: Vec<usize> = inspection
        .columns
        .iter()
        .filter(|c| c.unit.is_none() && c.statistics.is_some())
        .filter(|c| inspection.reading.time.column != Some(c.number))
        .map(|c| c.number - 1)
        .filter(|&i| !layout.counts_rows(i))
        .collect();
    let clock = inspection.time.is_none() && inspection.reading.time.rate_hz.is_none();
    let names: Vec<String> = open.iter().map(|&i| layout.name(i)).collect();
    let what = match (names.as_slice(), clock) {
        ([], false) => return None,
        ([], true) => "the time of its rows".to_owned(),
        (names, false) => format!("the unit of {}", names.join(", ")),
        (names, true) => format!("the unit of {}, and the time of its rows", names.join(", ")),
    };
    let likely = (!open.is_empty())
        .then(|| layout.likely_unit(&open))
        .flatten();
    let likely = likely.map_or(String::new(), |unit| {
        format!("by the size of the numbers the unit is likely {unit}")
    });
    Some(findings::file_does_not_say(&what, &likely))
}

/// Size, layout and clock, in the head of the page.
fn head(page: Report, inspection: &Inspection) -> Report {
    let layout = &inspection.layout;
    let separator = format!("{:?}", layout.separator).to_lowercase();
    let header = if layout.header.is_some() { "yes" } else { "no" };
    let page = match inspection.bad_count + inspection.bad_row_count {
        _ if undecided(inspection) => page.question(format!(
            "The file holds {}: choose one with --source NAME.",
            count(inspection.streams.len(), "stream")
        )),
        0 if backward(inspection) > 0 => page.question(format!(
            "The time does not run forward on {}: no command takes such a clock. State one with --rate, or read a part with --between.",
            count(backward(inspection), "line")
        )),
        0 => page.verdict(match inspection.time.as_ref().map_or(0, |t| t.gap_count as usize) {
            0 => format!("All {} are whole.", count(inspection.rows as usize, "row")),
            n => format!(
                "All {} are whole; the time has {}.",
                count(inspection.rows as usize, "row"),
                count(n, "gap")
            ),
        }),
        n => page.question(format!(
            "{} damaged: `--damage` lists every one.",
            count(n as usize, "place")
        )),
    };
    let page = page
        .answers([match undecided(inspection) {
            true => KeyFigure::new("streams", inspection.streams.len().to_string(), "")
                .note("none is chosen"),
            false => KeyFigure::new("rows", inspection.rows.to_string(), "")
                .note(count(inspection.columns.len(), "column")),
        }])
        .reading(match undecided(inspection) {
            true => inspection.path.display().to_string(),
            false => inspection
                .reading
                .line(&inspection.path.display().to_string()),
        });
    let page = match (&layout.stream, &inspection.streams[..]) {
        (Some(stream), [one]) => {
            let page = page.meta("format", stream.format.as_str());
            match &one.start {
                Some(start) => page.meta("time zero", format!("{start} by the clock of the file")),
                None => page,
            }
        }
        (Some(stream), _) => page.meta("format", stream.format.as_str()),
        (None, _) => page.meta("separator", separator).meta("header", header),
    };
    let Some(time) = &inspection.time else {
        return page;
    };
    let clock = &time.clock;
    let rate = match time.rate_is_stated {
        true => KeyFigure::new("rate", significant(time.rate_hz), "Hz").note("as the file states"),
        false => KeyFigure::new(
            "rate",
            plus_minus(time.rate_hz, 2.0 * clock.rate_u_hz),
            "Hz",
        )
        .note("k = 2"),
    };
    let resolution = format!("{} s", significant(clock.resolution_s));
    let page = page
        .meta("time", format!("column {}", time.column))
        .meta("resolution of the stamps", resolution)
        .answers([
            rate,
            KeyFigure::new("duration", duration(time.duration_s), "s"),
            KeyFigure::new("gaps", time.gap_count.to_string(), ""),
        ]);
    match time.jitter_s {
        Some(jitter) => page.meta("jitter", format!("{jitter:.1e} s")),
        None => page,
    }
}

fn evidence(finding: &Finding) -> Option<String> {
    let said = finding.evidence_text();
    (!said.is_empty()).then(|| format!("{}: {said}", finding.code()))
}

/// Lines on which the time repeats or runs backwards, as far as they are listed.
fn backward(inspection: &Inspection) -> usize {
    inspection
        .time
        .as_ref()
        .map_or(0, |time| time.backward_lines.len())
}

/// Whether there are several streams, and none was chosen.
fn undecided(inspection: &Inspection) -> bool {
    inspection.streams.len() > 1 && inspection.columns.is_empty()
}

fn streams(inspection: &Inspection) -> Section {
    let fields = [
        Field::shown("name", "", |s: &StreamSummary| s.name.as_str().into()),
        Field::shown("samples", "", |s: &StreamSummary| {
            Cell::number(s.rows.to_string())
        }),
        Field::shown("rate", "Hz", |s: &StreamSummary| {
            s.rate_hz.map(|v| Cell::number(significant(v))).into()
        }),
        Field::shown("channels", "", |s: &StreamSummary| {
            Cell::text(s.channels.join(", "))
        }),
        Field::shown("time zero", "", |s: &StreamSummary| {
            s.start.as_deref().map(Cell::text).into()
        }),
    ];
    Section::new("Streams").table(Table::of("", fields, &inspection.streams))
}

fn columns(inspection: &Inspection) -> Section {
    let statistic = |heading: &str, of: fn(&Statistics) -> Option<f64>| {
        let value = move |c: &ColumnSummary| c.statistics.as_ref().and_then(of);
        Field::shown(heading, "", move |c: &ColumnSummary| {
            value(c).map(|v| Cell::number(significant(v))).into()
        })
    };
    let fields = [
        Field::shown("no.", "", |c: &ColumnSummary| c.number.into()),
        Field::shown("name", "", |c: &ColumnSummary| c.name.as_str().into()),
        Field::shown("unit", "", |c: &ColumnSummary| {
            Cell::text(c.unit.map(|u| u.to_string()).unwrap_or_default())
        }),
        statistic("min", |s| Some(s.min)),
        statistic("mean", |s| Some(s.mean)),
        statistic("max", |s| Some(s.max)),
        statistic("std dev", |s| s.standard_deviation),
        statistic("step", |s| s.resolution),
    ];
    let mut section = Section::new("Columns").table(Table::of("", fields, &inspection.columns));
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
    section
}

/// Every damaged place, in the order of lines.
fn places(inspection: &Inspection) -> Section {
    /// Line, column, what is wrong, text.
    type Place<'a> = (u64, &'a str, String, &'a str);
    let width = inspection.layout.columns;
    let rows = inspection.bad_rows.iter();
    let mut all: Vec<Place<'_>> = rows
        .map(|b| {
            let what = format!("{}, not {width}", count(b.fields, "field"));
            (b.line, "", what, b.text.as_str())
        })
        .collect();
    let no_number = || "not a finite number".to_owned();
    let fields = inspection.bad.iter();
    all.extend(fields.map(|b| (b.line, b.column.as_str(), no_number(), b.text.as_str())));
    if let Some(time) = &inspection.time {
        let backward = || "time does not run forward".to_owned();
        let lines = time.backward_lines.iter();
        all.extend(lines.map(|line| (*line, time.column.as_str(), backward(), "")));
        all.extend(time.gaps.iter().map(|g| {
            let what = format!("{:.6} s without a sample after this line", g.step_s);
            (g.line, time.column.as_str(), what, "")
        }));
    }
    all.sort_by_key(|p| p.0);
    if all.is_empty() {
        return Section::new("Damage").paragraph("None was found.");
    }
    let rows = all.into_iter().map(|(line, column, what, text)| {
        [
            Cell::number(line.to_string()),
            column.into(),
            what.into(),
            text.into(),
        ]
    });
    let headings = [("line", ""), ("column", ""), ("what", ""), ("text", "")];
    Section::new("Damage").table(lines("", headings, rows))
}

/// To a millisecond; a shorter one by its digits.
fn duration(seconds: f64) -> String {
    match seconds < 1.0 {
        true => scientific(seconds, 4),
        false => format!("{seconds:.3}"),
    }
}

/// Six significant digits.
fn significant(v: f64) -> String {
    if v == 0.0 {
        return "0".to_owned();
    }
    // Of the rounded number: 0.0099999 is 0.010000.
    let rounded = format!("{v:.4e}");
    let magnitude: i32 = rounded
        .split_once('e')
        .and_then(|(_, e)| e.parse().ok())
        .unwrap_or(0);
    if !(-4..=9).contains(&magnitude) {
        return format!("{v:.3e}");
    }
    format!("{v:.*}", (4 - magnitude).clamp(0, 9) as usize)
}

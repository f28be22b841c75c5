//! Streams of the recordings of others behind the one view: each has the layout of a table, whose rows are its samples.
//!
//! Columns are the channels in the order of the file. Where the file says a rate and no times, a last column holds the times that
//! follow from it.

use crate::column_head::ColumnHead;
use crate::rows::{BadField, BadFields, RowBlock};
use crate::stamp::Stamp;
use crate::{Error, ErrorKind, Layout, Result, Separator, Source, Unit, findings};
use proofmass_formats::{Channel, Clock, Container, RemarkKind, Rows, Stream, is_absent};
use proofmass_uncertainty::{DecimalMark, Finding};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Heading of the times that follow from a rate.
const TIME: &str = "time";
/// Rows that tell what the columns hold.
const HEAD_ROWS: usize = 4000;

/// What a recording of another format says of itself, beside its columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StreamLayout {
    /// Word for the format: `tdms`, `wav`.
    pub format: String,
    /// Name of the stream; none where the file has one alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Rate that the file says, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Time of the first sample in the count of the file, s.
    #[serde(default)]
    pub start_s: f64,
    /// What the file declares to be done to stored numbers, and was, for each column.
    #[serde(default)]
    pub scaling: Vec<Option<String>>,
    /// Size of full scale where the numbers are whole ones out of a converter and the file does not say their unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub full_scale: Option<f64>,
    /// Whether the last column holds times.
    pub timed: bool,
    #[serde(skip)]
    pub(crate) findings: Vec<Finding>,
    /// Nanoseconds since 1970 at which its times are zero, where the clock of the file shows a date.
    #[serde(skip)]
    pub(crate) origin_ns: Option<i64>,
}

/// A stream of a file, as `inspect` lists it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StreamSummary {
    /// What it is chosen by.
    pub name: String,
    /// Samples of each channel.
    pub rows: u64,
    /// Rate that the file says, Hz.
    pub rate_hz: Option<f64>,
    /// Channels with the units that the file says.
    pub channels: Vec<String>,
    /// Date and time where its times are zero, by the clock of the file, where that says so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
}

impl StreamSummary {
    fn of(stream: &Stream) -> Self {
        Self {
            name: stream.name.clone(),
            rows: stream.rows,
            rate_hz: rate(stream),
            channels: stream.channels.iter().map(shown).collect(),
            start: stream.start(),
        }
    }
}

impl fmt::Display for StreamSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 4;
        let channels = self.channels.iter().take(SHOWN).cloned();
        let more = if self.channels.len() > SHOWN {
            ", …"
        } else {
            ""
        };
        let channels: Vec<String> = channels.collect();
        write!(
            f,
            "\"{}\" ({} samples of {}{more}",
            self.name,
            self.rows,
            channels.join(", ")
        )?;
        if let Some(rate) = self.rate_hz {
            write!(f, ", {}", crate::time_unit::hertz(rate))?;
        }
        write!(f, ")")
    }
}

fn shown(channel: &Channel) -> String {
    match &channel.unit {
        Some(unit) => format!("{} in {unit}", channel.name),
        None => channel.name.clone(),
    }
}

fn rate(stream: &Stream) -> Option<f64> {
    match stream.clock {
        Clock::Rate { hz, .. } => Some(hz),
        _ => None,
    }
}

/// A file of another format that was opened, and the layout of its stream.
pub(crate) struct Opened {
    pub(crate) layout: Layout,
    rows: Option<Box<Rows>>,
    pub(crate) streams: Vec<StreamSummary>,
}

/// Opens what lies ahead in a source where it is of another format than text; `None` where it may be a text.
pub(crate) fn open(source: &mut Source) -> Result<bool> {
    if source.opened.is_some() {
        return Ok(true);
    }
    let (head, _) = source.ahead(proofmass_formats::HEAD)?;
    let Some(format) = proofmass_formats::recognise(head) else {
        return match source.stream.is_some() {
            true => Err(Error::new(
                ErrorKind::Format,
                "is a text, which has no streams to choose from",
            )
            .with_hint("leave --source out")),
            false => Ok(false),
        };
    };
    if !format.is_read() {
        return Err(refusal(&format.refusal()));
    }
    let file = source.seekable()?;
    let mut container =
        Container::open_beside(file, &mut |name| source.beside(name)).map_err(|e| refusal(&e))?;
    if source.as_stored {
        container = container.without_scaling();
    }
    let streams: Vec<StreamSummary> = container.streams().iter().map(StreamSummary::of).collect();
    let Some(chosen) = chosen(&streams, source.stream.as_deref())? else {
        source.opened = Some(Opened {
            layout: Layout::of_streams(&container),
            rows: None,
            streams,
        });
        return Ok(true);
    };
    let all: Vec<usize> = (0..container.streams()[chosen].channels.len()).collect();
    let mut rows = container.rows(chosen, &all).map_err(|e| refusal(&e))?;
    let layout = layout(&mut rows, &all)?;
    source.opened = Some(Opened {
        layout,
        rows: Some(Box::new(rows)),
        streams,
    });
    Ok(true)
}

impl Opened {
    /// The layout of the one stream.
    ///
    /// # Errors
    /// There are several, and none was chosen.
    pub(crate) fn one(&self) -> Result<&Layout> {
        match self.rows {
            Some(_) => Ok(&self.layout),
            None => Err(several(&self.streams)),
        }
    }
}

fn refusal(e: &proofmass_formats::Error) -> Error {
    let kind = match e.refused() {
        Some(_) => ErrorKind::Access,
        None => ErrorKind::Format,
    };
    let error = Error::new(kind, e.to_string());
    match e.hint() {
        Some(hint) => error.with_hint(hint),
        None => error,
    }
}

/// The stream of a name; the only one without; nothing where several would serve.
fn chosen(streams: &[StreamSummary], name: Option<&str>) -> Result<Option<usize>> {
    let Some(name) = name else {
        return Ok((streams.len() == 1).then_some(0));
    };
    let exact = streams.iter().position(|s| s.name == name);
    let loose = || {
        let mut found = (0..streams.len()).filter(|&i| streams[i].name.eq_ignore_ascii_case(name));
        found.next().filter(|_| found.next().is_none())
    };
    match exact.or_else(loose) {
        Some(found) => Ok(Some(found)),
        None => Err(Error::new(
            ErrorKind::Column,
            format!("the file has no stream \"{name}\""),
        )
        .with_hint(format!("its streams are {}", listed(streams)))),
    }
}

fn listed(streams: &[StreamSummary]) -> String {
    const SHOWN: usize = 8;
    let mut words: Vec<String> = streams
        .iter()
        .take(SHOWN)
        .map(ToString::to_string)
        .collect();
    if streams.len() > SHOWN {
        words.push(format!("and {} more", streams.len() - SHOWN));
    }
    words.join("; ")
}

fn several(streams: &[StreamSummary]) -> Error {
    Error::new(
        ErrorKind::Column,
        format!("holds {} streams: {}", streams.len(), listed(streams)),
    )
    .with_hint("choose one with --source NAME (`source = \"NAME\"` in [recording] of a campaign on a shaker)")
}

impl Layout {
    /// No columns, since nobody said which stream.
    fn of_streams(container: &Container) -> Self {
        let remarks = remarks(container);
        Self::of_channels(
            &[],
            StreamLayout {
                format: container.format().word.to_owned(),
                name: None,
                rate_hz: None,
                start_s: 0.0,
                scaling: Vec::new(),
                full_scale: None,
                timed: false,
                findings: remarks,
                origin_ns: None,
            },
        )
    }

    fn of_channels(channels: &[Channel], stream: StreamLayout) -> Self {
        let mut header: Vec<String> = channels.iter().map(|c| c.name.clone()).collect();
        let known = |c: &Channel| c.unit.as_deref().and_then(Unit::recognise);
        let mut units: Vec<Option<Unit>> = channels.iter().map(known).collect();
        if stream.rate_hz.is_some() {
            header.push(TIME.to_owned());
            units.push(Some(Unit::Second));
        }
        let columns = header.len();
        Self {
            separator: Separator::Comma,
            decimal: DecimalMark::Point,
            decimal_is_stated: true,
            comment: Vec::new(),
            header: Some(header),
            unit_line: Some(units),
            passed_over: Vec::new(),
            columns,
            numeric: vec![true; columns],
            other_mark: Vec::new(),
            dated: vec![false; columns],
            first_data_line: 1,
            data_offset: 0,
            head: Vec::new(),
            stream: Some(Box::new(stream)),
        }
    }

    /// Column of the times that the format itself has, counted from zero.
    pub(crate) fn own_times(&self) -> Option<usize> {
        let timed = self.stream.as_ref().is_some_and(|s| s.timed);
        timed.then(|| self.columns.checked_sub(1)).flatten()
    }

    /// The rate that the file says, where a column holds the times that follow from it and count from zero, Hz.
    pub(crate) fn stated_rate(&self, time: usize) -> Option<f64> {
        let stream = self.stream.as_ref()?;
        let own = self.own_times() == Some(time) && stream.start_s == 0.0;
        stream.rate_hz.filter(|_| own)
    }
}

fn remarks(container: &Container) -> Vec<Finding> {
    let mut found = Vec::new();
    for (kind, of) in [
        (RemarkKind::Cut, findings::file_cut as fn(&str) -> Finding),
        (RemarkKind::Damaged, findings::parts_damaged),
        (RemarkKind::PassedOver, findings::parts_passed_over),
    ] {
        const SHOWN: usize = 3;
        let all = || container.remarks().iter().filter(|r| r.kind == kind);
        let mut words: Vec<&str> = all().take(SHOWN).map(|r| r.text.as_str()).collect();
        let more = format!("and {} more", all().count().saturating_sub(SHOWN));
        if all().count() > SHOWN {
            words.push(&more);
        }
        if !words.is_empty() {
            found.push(of(&words.join("; ")));
        }
    }
    found
}

/// The layout of a stream, by what it says and by its first rows.
fn layout(rows: &mut Rows, all: &[usize]) -> Result<Layout> {
    let mut findings = remarks(rows.container());
    let stream = rows.stream();
    let several = rows.container().streams().len() > 1;
    let (rate_hz, start_s) = match stream.clock {
        Clock::Rate { hz, start_s } => (Some(hz), start_s),
        _ => (None, 0.0),
    };
    let unknown = stream.channels.iter().filter_map(|c| {
        let unit = c.unit.as_deref().filter(|u| Unit::recognise(u).is_none())?;
        Some(format!("\"{unit}\" of {}", c.name))
    });
    let unknown: Vec<String> = unknown.collect();
    if let Some(first) = unknown.first() {
        let more = match unknown.len() {
            1 => String::new(),
            n => format!(", and of {} more", n - 1),
        };
        findings.push(findings::unit_word_unknown(first, &more));
    }
    let mut layout = Layout::of_channels(
        &stream.channels,
        StreamLayout {
            format: rows.container().format().word.to_owned(),
            name: several.then(|| stream.name.clone()),
            rate_hz,
            start_s,
            scaling: stream.channels.iter().map(|c| c.scaling.clone()).collect(),
            full_scale: stream.full_scale,
            timed: rate_hz.is_some() || stream.clock == Clock::Times,
            findings,
            origin_ns: stream.origin_ns.filter(|_| stream.start().is_some()),
        },
    );
    let mut block = vec![Vec::new(); all.len()];
    rows.next_block(&mut block).map_err(|e| refusal(&e))?;
    let stamps = |values: &mut dyn Iterator<Item = f64>| -> ColumnHead {
        let stamps: Vec<Stamp> = values.take(HEAD_ROWS).filter_map(Stamp::of).collect();
        ColumnHead::of(&stamps)
    };
    let mut head: Vec<ColumnHead> = block
        .iter()
        .map(|column| stamps(&mut column.iter().copied()))
        .collect();
    if let Some(rate) = rate_hz {
        head.push(stamps(
            &mut (0..HEAD_ROWS).map(|i| start_s + i as f64 / rate),
        ));
    }
    layout.head = head;
    rows.restart(all).map_err(|e| refusal(&e))?;
    Ok(layout)
}

/// Reads the rows of a stream as those of a table.
pub(crate) struct StreamRows {
    rows: Box<Rows>,
    layout: Layout,
    selected: Vec<usize>,
    /// Channels that are read, in their order in the file.
    channels: Vec<usize>,
    block: Vec<Vec<f64>>,
    done: u64,
    total: u64,
    keep_text: bool,
}

impl StreamRows {
    /// Takes the stream out of a source that was looked at; `None` where it is a text.
    pub(crate) fn of(source: &mut Source, selected: &[usize]) -> Result<Option<Self>> {
        open(source)?;
        let Some(opened) = source.opened.take() else {
            return Ok(None);
        };
        opened.one()?;
        let Some(rows) = opened.rows else {
            return Ok(None);
        };
        let mut reader = Self {
            total: rows.rest(),
            rows,
            layout: opened.layout,
            selected: selected.to_vec(),
            channels: Vec::new(),
            block: Vec::new(),
            done: 0,
            keep_text: false,
        };
        reader.restart()?;
        Ok(Some(reader))
    }

    fn restart(&mut self) -> Result<()> {
        let count = self.rows.stream().channels.len();
        self.channels = match self.keep_text {
            true => (0..count).collect(),
            false => (0..count).filter(|c| self.selected.contains(c)).collect(),
        };
        // Without a channel nothing tells how many rows a block has.
        if self.channels.is_empty() {
            self.channels.push(0);
        }
        self.block = vec![Vec::new(); self.channels.len()];
        self.rows.restart(&self.channels).map_err(|e| refusal(&e))
    }

    /// Gives the rows as text too.
    pub(crate) fn keep_text(&mut self) -> Result<()> {
        self.keep_text = true;
        self.restart()
    }

    /// The share of the rows that went by.
    pub(crate) fn share(&self) -> f64 {
        self.done as f64 / self.total.max(1) as f64
    }

    /// The next rows.
    pub(crate) fn next_block(
        &mut self,
        stamp_slot: Option<usize>,
        bad_fields: BadFields,
    ) -> Result<Option<RowBlock>> {
        let n = self
            .rows
            .next_block(&mut self.block)
            .map_err(|e| refusal(&e))?;
        if n == 0 {
            return Ok(None);
        }
        let mut block = RowBlock {
            rows: n,
            lines: vec![(0, self.done + 1)],
            ..RowBlock::default()
        };
        let times = || self.times(n);
        for (slot, &index) in self.selected.iter().enumerate() {
            let place = self.channels.iter().position(|&c| c == index);
            let mut column = place.map_or_else(times, |place| self.block[place].clone());
            let sound = column.iter().filter(|v| crate::field::is_reading(**v));
            if sound.count() < n {
                for (row, value) in column.iter_mut().enumerate() {
                    if crate::field::is_reading(*value) {
                        continue;
                    }
                    let line = self.done + row as u64 + 1;
                    if bad_fields == BadFields::Refuse {
                        return Err(self.bad_sample(index, line, *value));
                    }
                    block.bad.push(BadField {
                        line,
                        selected: slot,
                        text: match is_absent(*value) {
                            true => String::new(),
                            false => format!("{value}"),
                        },
                    });
                    *value = f64::NAN;
                }
            }
            if stamp_slot == Some(slot) {
                block.stamps = column.iter().map(|v| Stamp::of(*v)).collect();
            }
            block.columns.push(column);
        }
        if self.keep_text {
            self.text(&mut block, n);
        }
        self.done += n as u64;
        Ok(Some(block))
    }

    /// Times by the rate.
    fn times(&self, n: usize) -> Vec<f64> {
        let stream = self.layout.stream.as_ref();
        let (rate, start) = stream.map_or((1.0, 0.0), |s| (s.rate_hz.unwrap_or(1.0), s.start_s));
        let rows = self.done..self.done + n as u64;
        rows.map(|i| start + i as f64 / rate).collect()
    }

    fn text(&self, block: &mut RowBlock, n: usize) {
        let times = match self.layout.columns > self.channels.len() {
            true => self.times(n),
            false => Vec::new(),
        };
        let columns = self
            .block
            .iter()
            .chain((!times.is_empty()).then_some(&times));
        let columns: Vec<&Vec<f64>> = columns.collect();
        let mut number = ryu::Buffer::new();
        for row in 0..n {
            let start = block.text.len();
            for (i, column) in columns.iter().enumerate() {
                if i > 0 {
                    block.text.push(b',');
                }
                // As the empty field that it would be in a text.
                if is_absent(column[row]) {
                    continue;
                }
                let text = number.format(column[row]);
                let text = text.strip_suffix(".0").unwrap_or(text);
                block.text.extend_from_slice(text.as_bytes());
            }
            block.ranges.push(start..block.text.len());
            block.text.push(b'\n');
        }
    }

    fn bad_sample(&self, index: usize, line: u64, value: f64) -> Error {
        if is_absent(value) {
            let what = format!("sample {line} is absent");
            return Error::new(ErrorKind::Field, what)
                .column(self.layout.name(index))
                .with_hint("the file holds no number there (a null, or a damaged part): cut this part out with --between FROM TO");
        }
        Error::new(
            ErrorKind::Field,
            format!("sample {line} is {value}, which is no reading"),
        )
        .column(self.layout.name(index))
        .with_hint("the sensor or the converter overflowed there, or the file is damaged: cut this part out with --between FROM TO")
    }
}

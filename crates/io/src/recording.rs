//! A recording: selected columns of a delimited text as numbers, with their units and times.

use crate::findings;
use crate::layout::{ColumnRef, Layout, LayoutOptions};
use crate::rows::{RowReader, bad_field, line_of};
use crate::time_base::TimeBaseBuilder;
use crate::time_unit::hertz;
use crate::{
    ClockUnit, Error, ErrorKind, ReadQuantity, Reading, Result, SaidBy, Source, Thermometer,
    TimeBase, TimeUnit, TimeWindow, Unit, UnitRatio, split_heading,
};
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A file that went into a result, with its digest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Input {
    /// Path as the user gave it.
    pub path: String,
    /// SHA-256 in hexadecimal digits.
    pub sha256: String,
    /// How it was read, where it is a recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reading: Option<Box<Reading>>,
    /// Files beside it that it names and that were read with it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<Input>,
    /// Why it is not to be trusted, where the list of its folder or the provenance beside it says that it was written otherwise. It is a
    /// finding of what is computed from the file, and not filed with its name.
    #[serde(skip)]
    pub doubt: Option<String>,
}

impl Input {
    /// Digest of a file that was not read as a recording, such as `campaign.toml`.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn of(path: &Path) -> Result<Self> {
        Source::open(path)?.finish()
    }

    /// What the doubts of it and of the files beside it are to a result.
    pub fn findings(&self) -> impl Iterator<Item = Finding> {
        self.files().filter_map(|file| {
            let doubt = file.doubt.as_deref()?;
            Some(findings::input_changed(&file.path, doubt))
        })
    }

    /// The file and those beside it that were read with it.
    pub fn files(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.beside)
    }

    /// The same with how it was read.
    #[must_use]
    pub fn with_reading(self, reading: Reading) -> Self {
        Self {
            reading: Some(Box::new(reading)),
            ..self
        }
    }
}

/// Which columns of a file to read, and what is known about them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordingOptions {
    /// Shape of the text.
    pub layout: LayoutOptions,
    /// Columns of the signals, in the order wanted.
    pub columns: Vec<ColumnRef>,
    /// Time column. Without it and without a rate, a column that is named as a time is taken.
    pub time: Option<ColumnRef>,
    /// Unit of the time column where the heading does not say it.
    pub time_unit: Option<TimeUnit>,
    /// Sampling rate, Hz.
    pub sampling_rate_hz: Option<f64>,
    /// Temperature column: °C, or what its heading says.
    pub temperature: Option<ColumnRef>,
    /// Columns of other quantities of the surroundings, in whatever units.
    pub surroundings: Vec<ColumnRef>,
    /// Unit of the signals where the headings do not say it.
    pub unit: Option<Unit>,
    /// The stretch to be read, from one time on and before another, s ([`TimeWindow`]); all without it.
    pub between: Option<[f64; 2]>,
    /// Rows have an order and no clock: a table of readings.
    pub table: bool,
    /// Rows are events that come when they come, such as the edges of an encoder, not samples of a clock.
    pub events: bool,
    /// Stream of a file that holds several.
    pub stream: Option<String>,
    /// Numbers as stored, without the scaling that a file declares.
    pub as_stored: bool,
    /// Samples are even and their stamps were put on later: one may lie before the one before it, by less than two intervals.
    pub late_stamps: bool,
}

/// One column of a recording.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RecordedColumn {
    /// Name without unit.
    pub name: String,
    /// Unit of `data`, where known.
    pub unit: Option<Unit>,
    /// One finite number per sample.
    pub data: Vec<f64>,
}

/// A recording in memory.
///
/// **Units** columns stand in the unit of the file until [`Recording::into_si`]; times are in seconds.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Recording {
    /// The file.
    pub path: PathBuf,
    /// Its name and digest.
    pub file: Input,
    /// Shape of the text.
    pub layout: Layout,
    /// The signals in the order asked for.
    pub columns: Vec<RecordedColumn>,
    /// Temperature in °C, where asked for.
    pub temperature: Option<RecordedColumn>,
    /// Other quantities of the surroundings, as they stand in the file.
    pub surroundings: Vec<RecordedColumn>,
    /// Times.
    pub time: TimeBase,
    lines: Vec<(usize, u64)>,
    missing: Vec<Vec<usize>>,
    findings: Vec<Finding>,
    reading: Reading,
}

/// What an absent value in a column means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Absent {
    /// Damage: refused with its line.
    #[default]
    Refused,
    /// No sample was taken in this row: an empty field is none, NaN is refused.
    Empty,
    /// No sample was taken in this row: an empty field or NaN is none.
    EmptyOrNan,
}

/// A number with four significant digits, without needless zeros.
fn brief(value: f64) -> String {
    let size = value.abs().max(f64::MIN_POSITIVE).log10().floor();
    let places = (3.0 - size).clamp(0.0, 12.0) as usize;
    let text = format!("{value:.places$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

impl Recording {
    /// Values that are held at most, all chosen columns together: 4 GiB.
    pub const MOST_VALUES: usize = 1 << 29;

    /// Reads the chosen columns of a file.
    ///
    /// # Errors
    /// A file that cannot be read as numbers (with line and column), fewer than two rows, a time column that does
    /// not run forward, no time base at all, a stated unit that contradicts the heading.
    pub fn read(path: &Path, options: &RecordingOptions) -> Result<Self> {
        Self::from_source(Source::open(path)?, options)
    }

    /// Reads the chosen columns of a file in which a row need not hold every sensor.
    ///
    /// `absent` belongs to `options.columns`, in their order; columns beyond its end are refused absent values.
    /// Where a sample is absent ([`Recording::missing`]) the column repeats the one before it, or the first one.
    ///
    /// # Errors
    /// As [`Recording::read`]; a column without any value.
    pub fn read_sparse(path: &Path, options: &RecordingOptions, absent: &[Absent]) -> Result<Self> {
        Self::from_source_sparse(Source::open(path)?, options, absent)
    }

    /// Reads the chosen columns of a source: a pipe, standard input, bytes in memory.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn from_source(source: Source, options: &RecordingOptions) -> Result<Self> {
        Self::from_source_sparse(source, options, &[])
    }

    /// Reads a source in which a row need not hold every sensor, as [`Recording::read_sparse`] does.
    ///
    /// # Errors
    /// As [`Recording::read_sparse`].
    pub fn from_source_sparse(
        source: Source,
        options: &RecordingOptions,
        absent: &[Absent],
    ) -> Result<Self> {
        let name = source.name().to_path_buf();
        Self::read_inner(source, options, absent).map_err(|e| e.at(&name))
    }

    fn read_inner(
        mut source: Source,
        options: &RecordingOptions,
        absent: &[Absent],
    ) -> Result<Self> {
        let path = source.name().to_path_buf();
        source = source.with_stream(options.stream.as_deref(), options.as_stored);
        let layout = Layout::of(&mut source, &options.layout)?;
        if options.columns.is_empty() {
            return Err(
                Error::new(ErrorKind::Column, "no column was chosen").with_hint(
                    "name the columns of the axes: --columns X,Y,Z, or columns = { x = 2, y = 3, z = 4 } in a campaign",
                ),
            );
        }
        // Each by itself: which signal is which is told by their order.
        let mut selected = options
            .columns
            .iter()
            .map(|c| layout.find(c))
            .collect::<Result<Vec<_>>>()?;
        let signals = selected.len();
        // The rows of a table follow one another as if one came every second.
        let rate = options.sampling_rate_hz.or(options.table.then_some(1.0));
        let When { time, rate, stated } = When::of(&layout, options, rate, &selected)?;
        if time.is_none() && rate.is_none() {
            return Err(layout.ask_clock());
        }
        let clock = time
            .map(|index| clock_unit(&layout, index, options))
            .transpose()?;
        selected.extend(time);
        let asked = Thermometer::asked(&layout, options.temperature.as_ref())?;
        let (temperature, thermometer) = asked.unzip();
        selected.extend(temperature);
        let surroundings = options
            .surroundings
            .iter()
            .map(|c| layout.find(c))
            .collect::<Result<Vec<_>>>()?;
        selected.extend(&surroundings);

        let mut findings = layout.findings();
        findings.extend(unused_time(&layout, options, &selected));
        findings.extend(clock.iter().filter_map(|c| c.finding.clone()));
        let units = selected[..signals]
            .iter()
            .map(|&index| signal_unit(&layout, index, options.unit))
            .collect::<Result<Vec<_>>>()?;
        layout.refuse_grouped(&selected[..signals], options.unit)?;
        let mut reading = Reading::of(
            &layout,
            &selected[..signals],
            options.unit,
            time.zip(clock.as_ref()),
            options.sampling_rate_hz.or(stated),
        );
        if stated.is_some() {
            reading.time.by = SaidBy::File;
        }
        reading.between_s = options.between;
        reading.temperature = temperature
            .zip(thermometer.as_ref())
            .map(|(index, thermometer)| Reading::thermometer(&layout, index, thermometer));
        let window = options
            .between
            .and_then(|between| TimeWindow::of(between, signals, clock.as_ref(), rate));
        let mut reader = RowReader::new(source, layout, &selected)?.between(window);
        if time.is_some() {
            reader = reader.stamps(signals);
        }
        let mut times: Option<TimeBaseBuilder> = None;
        let sparse = absent.iter().any(|a| *a != Absent::Refused);
        if sparse {
            reader = reader.locate_bad_fields();
        }
        let mut data = vec![Vec::new(); selected.len()];
        let mut missing = vec![Vec::new(); signals];
        let mut lines: Vec<(usize, u64)> = Vec::new();
        let mut rows = 0;
        while let Some(block) = reader.next_block()? {
            for bad in &block.bad {
                let text = bad.text.trim();
                let absent = absent.get(bad.selected).copied().unwrap_or_default();
                let none = match absent {
                    Absent::Refused => false,
                    Absent::Empty => text.is_empty(),
                    Absent::EmptyOrNan => text.is_empty() || text.eq_ignore_ascii_case("nan"),
                };
                if !none {
                    let layout = reader.layout();
                    return Err(bad_field(&bad.text, layout.decimal)
                        .line(bad.line)
                        .column(layout.name(selected[bad.selected])));
                }
            }
            for (i, column) in data.iter_mut().enumerate() {
                if i < signals && sparse {
                    let absent = block.column(i).iter().enumerate();
                    missing[i].extend(
                        absent
                            .filter(|(_, v)| v.is_nan())
                            .map(|(row, _)| rows + row),
                    );
                }
                column.extend_from_slice(block.column(i));
            }
            for (row, stamp) in block.stamps().iter().enumerate() {
                let Some(stamp) = stamp else { continue };
                let times = times.get_or_insert_with(|| {
                    let scale = clock.as_ref().map_or(1.0, |c| c.per_second);
                    let origin = reader.window().and_then(TimeWindow::origin);
                    TimeBaseBuilder::new(scale, options.events)
                        .with_late_stamps(options.late_stamps)
                        .with_origin(origin)
                });
                times.push(*stamp, block.line(row));
            }
            for &(row, line) in block.line_runs() {
                if lines.is_empty() || line_of(&lines, rows + row) != line {
                    lines.push((rows + row, line));
                }
            }
            rows += block.rows();
            if rows * selected.len() > Self::MOST_VALUES {
                return Err(Error::new(
                    ErrorKind::Format,
                    format!(
                        "holds more than {} values in the chosen columns, the most that is held in memory",
                        Self::MOST_VALUES
                    ),
                )
                .with_hint("choose fewer columns or a part of the recording; `inspect`, `apply` and `noise --stream` read recordings of any length"));
            }
        }
        let layout = reader.layout().clone();
        let window = reader.window().cloned();
        findings.extend(reader.findings());
        let file = reader.finish()?;
        if let (true, Some(window)) = (rows < 2, &window) {
            return Err(Error::new(ErrorKind::Time, window.nothing())
                .with_hint("give another --between FROM TO; `proofmass inspect` shows the times"));
        }
        if rows < 2 {
            return Err(Error::new(
                ErrorKind::Format,
                format!("the file holds {rows} row of data"),
            )
            .with_hint("a recording needs at least two rows, and a calibration some thousands"));
        }

        for (i, column) in data.iter_mut().enumerate().take(signals) {
            let first = column.iter().copied().find(|v| !v.is_nan());
            let mut last = first.ok_or_else(|| {
                Error::new(ErrorKind::Field, "the column holds no value at all")
                    .column(layout.name(selected[i]))
                    .with_hint("see `proofmass inspect` for what the columns hold")
            })?;
            for v in column.iter_mut() {
                if v.is_nan() {
                    *v = last;
                }
                last = *v;
            }
        }

        let beside = data.split_off(data.len() - surroundings.len());
        let surroundings = surroundings.iter().zip(beside);
        let surroundings = surroundings.map(|(&index, data)| RecordedColumn {
            name: layout.name(index),
            unit: layout.unit(index),
            data,
        });
        let surroundings = surroundings.collect();
        let temperature = temperature.zip(thermometer).map(|(index, thermometer)| {
            let numbers = data.pop().unwrap_or_default();
            RecordedColumn {
                name: layout.name(index),
                unit: Some(Unit::DegreeCelsius),
                data: numbers.iter().map(|v| thermometer.celsius(*v)).collect(),
            }
        });
        if time.is_some() {
            data.pop();
        }
        let time_base = match (times, time) {
            (Some(times), Some(index)) => {
                let base = times.finish().map_err(|e| e.column(layout.name(index)))?;
                for finding in &mut findings {
                    if finding.code() == "time-unit-assumed" {
                        let (duration, rate) = (base.duration_s(), base.rate_hz());
                        *finding = finding.clone().with_evidence(|_| {
                            let [duration, rate] = [duration, rate].map(brief);
                            format!("{rows} samples in {duration} s, {rate} Hz")
                        });
                    }
                }
                base
            }
            _ => TimeBase::uniform(rate.unwrap_or(f64::NAN), rows)?,
        };
        findings.extend(time_base.findings().iter().cloned());
        if time.is_some() {
            reading.time.rate_hz = Some(time_base.rate_hz());
        }
        let columns = data.into_iter().zip(&selected).zip(units);
        let columns = columns
            .map(|((data, &index), unit)| RecordedColumn {
                name: layout.name(index),
                unit,
                data,
            })
            .collect();
        Ok(Self {
            path,
            file,
            layout,
            columns,
            temperature,
            surroundings,
            time: time_base,
            lines,
            missing,
            findings,
            reading,
        })
    }

    /// Samples at which a column holds no value of its own, in order; empty unless
    /// [`Recording::read_sparse`] allowed it.
    pub fn missing(&self, column: usize) -> &[usize] {
        self.missing.get(column).map_or(&[], Vec::as_slice)
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.columns.first().map_or(0, |c| c.data.len())
    }

    /// Duration, s.
    pub fn duration_s(&self) -> f64 {
        self.time.duration_s()
    }

    /// Line of the file on which a sample stands.
    pub fn line(&self, sample: usize) -> u64 {
        line_of(&self.lines, sample)
    }

    /// What is doubtful about the recording: lines passed over, gaps in time, an assumed time unit.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// Path and digest, for the list of inputs of a result.
    pub fn input(&self) -> Input {
        self.file.clone().with_reading(self.reading.clone())
    }

    /// How it was read.
    pub fn reading(&self) -> &Reading {
        &self.reading
    }

    /// Says how quantities of the surroundings are read: the column of each by its name, with its unit, and whether that was stated.
    ///
    /// # Errors
    /// A column that is not there.
    pub fn say_surroundings(&mut self, read: &[(&ColumnRef, &str, &str, bool)]) -> Result<()> {
        let layout = &self.layout;
        let said = read.iter().map(|(column, quantity, unit, stated)| {
            let index = layout.find(column)?;
            Ok(ReadQuantity::of(layout, index, quantity, unit, *stated))
        });
        self.reading.surroundings = said.collect::<Result<_>>()?;
        Ok(())
    }

    /// States the unit of a signal whose heading does not say it, and who says it: what nobody says gives way to the heading.
    ///
    /// # Errors
    /// A person says another unit than the heading.
    pub fn state_unit(&mut self, column: usize, unit: Option<Unit>, by: SaidBy) -> Result<()> {
        let read = self.reading.columns.get(column);
        let (Some(own), Some(index)) = (self.columns.get_mut(column), read.map(|c| c.number - 1))
        else {
            return Ok(());
        };
        if by == SaidBy::Person {
            signal_unit(&self.layout, index, unit).map_err(|e| e.at(&self.path))?;
        }
        let named = by == SaidBy::Person && names_alone(&self.layout, index, unit);
        if own.unit.is_none() || named {
            own.unit = unit;
            self.reading.columns[column].unit = None;
            self.reading.state_unit(column, unit, by);
        }
        Ok(())
    }

    /// States the unit of a signal as one over another; its numbers stay as they are.
    pub fn state_ratio(&mut self, column: usize, ratio: UnitRatio, by: SaidBy) {
        if let Some(own) = self.columns.get_mut(column) {
            own.unit = Some(Unit::One);
            self.reading.state_ratio(column, ratio, by);
        }
    }

    /// States the size of one of what a signal is recorded in, which then has the unit to which it leads.
    pub fn state_scale_of(&mut self, column: usize, factor: f64, unit: Unit) {
        self.reading.state_scale_of(column, factor, unit);
    }

    /// States the size of one count or volt of the signals.
    pub fn state_scale(&mut self, factor: f64, unit: Unit) {
        self.reading.state_scale(factor, unit);
    }

    /// Asks for the units of the signals that have none; each option belongs to a signal and says its unit, in their order.
    ///
    /// # Errors
    /// One of them is not known: all that are not are named, with the options to type.
    pub fn need_units(&self, options: &[&str]) -> Result<()> {
        let columns = self.columns.iter().zip(&self.reading.columns).zip(options);
        let open: Vec<(usize, &str)> = columns
            .filter(|((column, _), _)| column.unit.is_none())
            .map(|((_, read), option)| (read.number - 1, *option))
            .collect();
        match open.is_empty() {
            true => Ok(()),
            false => Err(self.layout.ask_units(&open).at(&self.path)),
        }
    }

    /// The same recording with every column in SI where its unit has one; counts stay counts.
    #[must_use]
    pub fn into_si(mut self) -> Self {
        for column in &mut self.columns {
            if let Some((unit, factor)) = column.unit.map(Unit::si) {
                if factor != 1.0 {
                    column.data.iter_mut().for_each(|v| *v *= factor);
                }
                column.unit = Some(unit);
            }
        }
        self
    }
}

/// What tells when the rows of a recording were taken; neither where nobody says it.
pub(crate) struct When {
    /// The column of the times.
    pub(crate) time: Option<usize>,
    /// Samples per second, as stated.
    pub(crate) rate: Option<f64>,
    /// The same where the file states it.
    pub(crate) stated: Option<f64>,
}

impl When {
    /// By what a person says, else by the column that is named as a time and is none of those selected.
    pub(crate) fn of(
        layout: &Layout,
        options: &RecordingOptions,
        rate: Option<f64>,
        selected: &[usize],
    ) -> Result<Self> {
        let time = match (&options.time, rate) {
            (Some(column), _) => Some(layout.find(column)?),
            (None, None) => time_column(layout).filter(|i| !selected.contains(i)),
            // What counts the rows needs the rate beside it.
            (None, Some(_)) if options.time_unit == Some(TimeUnit::Index) => {
                time_column(layout).filter(|i| !selected.contains(i))
            }
            (None, Some(_)) => None,
        };
        // Times that follow from a rate are not estimated from.
        let stated = time
            .filter(|_| rate.is_none())
            .and_then(|index| layout.stated_rate(index));
        Ok(Self {
            time: time.filter(|_| stated.is_none()),
            rate: stated.or(rate),
            stated,
        })
    }
}

/// The first column whose heading says that it is the time.
pub(crate) fn time_column(layout: &Layout) -> Option<usize> {
    if let Some(own) = layout.own_times() {
        return Some(own);
    }
    let read = (0..layout.columns).filter(|&i| layout.numeric[i] || layout.dated[i]);
    // `rostopic echo -p` calls `time` when a message was logged; when it was measured stands beside it.
    let measured = |&i: &usize| layout.name(i) == "field.header.stamp";
    let stamp = read.clone().find(measured);
    let called = || read.clone().find(|&i| is_called_time(layout, i));
    // Whatever it is called: dates, and numbers that rise in a unit of time, are times.
    let is_time = |&i: &usize| {
        let rises = layout.head.get(i).is_some_and(|h| h.rises);
        layout.dated[i] || rises && layout.unit(i).is_some_and(Unit::is_time)
    };
    stamp.or_else(called).or_else(|| read.clone().find(is_time))
}

/// Whether the heading of a column says that it is the time, in the languages that measuring programs are set to.
fn is_called_time(layout: &Layout, i: usize) -> bool {
    let Some(heading) = layout.header.as_ref().and_then(|h| h.get(i)) else {
        return false;
    };
    let name = split_heading(heading).0.to_ascii_lowercase();
    matches!(
        name.as_str(),
        "t" | "time"
            | "timestamp"
            | "time_stamp"
            | "time stamp"
            | "datetime"
            | "date_time"
            | "elapsed"
            | "elapsed time"
            | "elapsed_time"
            | "epoch"
            | "zeit"
            | "zeitstempel"
            | "uhrzeit"
            | "tempo"
            | "tiempo"
            | "tijd"
            | "czas"
    ) || layout.unit(i).is_some_and(Unit::is_time)
        && (name.starts_with('t') || Unit::recognise(&name).is_some_and(Unit::is_time))
}

/// A time column beside a stated rate is not read, which is said.
pub(crate) fn unused_time(
    layout: &Layout,
    options: &RecordingOptions,
    selected: &[usize],
) -> Option<Finding> {
    let rate = options.sampling_rate_hz?;
    let index = time_column(layout).filter(|i| !selected.contains(i))?;
    if options.time.is_some() {
        return None;
    }
    let unit = options
        .time_unit
        .or(layout.unit(index).and_then(TimeUnit::of));
    let step = layout.head.get(index).and_then(|h| h.step);
    let per_second = unit.and_then(|u| u.per_second(None));
    let of_stamps = per_second.zip(step).map(|(scale, step)| scale / step);
    let near = |r: f64| (r / rate - 1.0).abs() < 0.01;
    // Where nobody says what the times count, no unit may give the rate that was stated.
    let any = |step: f64| {
        let mut all = TimeUnit::ALL.iter().filter_map(|u| u.per_second(None));
        all.any(|scale| near(scale / step))
    };
    let contradicts = match (of_stamps, step) {
        (Some(r), _) => !near(r),
        (None, Some(step)) => step > 0.0 && !any(step),
        (None, None) => false,
    };
    let seen = match (of_stamps, step) {
        (Some(r), _) => format!(", the column says {}", hertz(r)),
        (None, Some(step)) if contradicts => {
            format!(
                ", the column advances by {} a row, and no unit of time makes that rate of it",
                crate::time_unit::short(step)
            )
        }
        _ => String::new(),
    };
    let told = findings::time_column_unused(&layout.name(index), rate, &seen);
    Some(if contradicts {
        told.at(Severity::Warning)
    } else {
        told
    })
}

impl Layout {
    /// The question for the clock of a recording in which no column of times is found.
    pub fn ask_clock(&self) -> Error {
        let unread = (0..self.columns).find(|&i| is_called_time(self, i));
        let what = match unread {
            Some(i) => format!(
                "the times in column {:?} are not read: they are neither numbers, nor dates such as 2026-03-01T12:00:00.25, nor hh:mm:ss",
                self.name(i)
            ),
            None => "neither a time column nor a sampling rate is known".to_owned(),
        };
        if let Some((line, text, rate)) = self.counted_above() {
            let rate = crate::time_unit::short(rate);
            return Error::new(ErrorKind::Time, what).with_hint(format!(
                "where \"{text}\" in line {line} is the number of rows and their interval in seconds, add --rate {rate} (`sampling_rate_Hz = {rate}` in a campaign); else --time COLUMN (`time = \"name or number of the column\"` in a campaign) or --rate HZ (`sampling_rate_Hz = 100` in a campaign)"
            ));
        }
        Error::new(ErrorKind::Time, what).with_hint("add --time COLUMN (`time = \"name or number of the column\"` in a campaign) or --rate HZ (`sampling_rate_Hz = 100` in a campaign)")
    }
}

/// What the time column counts.
pub(crate) fn clock_unit(
    layout: &Layout,
    index: usize,
    options: &RecordingOptions,
) -> Result<ClockUnit> {
    let rate = options.sampling_rate_hz;
    let clock = ClockUnit::of(layout, index, options.time_unit, rate, options.events)?;
    if clock.unit != TimeUnit::Index && rate.is_some() {
        return Err(Error::new(ErrorKind::Time, "both a time column and a sampling rate are given")
            .column(layout.name(index))
            .with_hint("keep one of them; a column that counts samples needs --time-unit index (`time_unit = \"index\"` in a campaign) beside the rate"));
    }
    Ok(clock)
}

/// The unit of a column, by its heading or as stated.
/// Whether a heading that is one letter and read as a unit, as `A`, is a name: something else is stated of the column.
fn names_alone(layout: &Layout, index: usize, given: Option<Unit>) -> bool {
    let name = layout.name(index);
    let read = layout.unit(index).filter(|_| name.chars().count() == 1);
    let of = |unit: Unit| unit.si().0;
    match (given, read) {
        (Some(given), Some(read)) => Unit::recognise(&name) == Some(read) && of(given) != of(read),
        _ => false,
    }
}

pub(crate) fn signal_unit(
    layout: &Layout,
    index: usize,
    given: Option<Unit>,
) -> Result<Option<Unit>> {
    if names_alone(layout, index, given) {
        return Ok(given);
    }
    match (given, layout.unit(index)) {
        (Some(given), Some(stated)) if given != stated => Err(Error::new(
            ErrorKind::Column,
            format!("the heading says {stated}, {given} is stated"),
        )
        .column(layout.name(index))
        .line(layout.first_data_line.saturating_sub(1).max(1))
        .with_hint(
            "leave out the option that states it (or `unit` in a campaign), or correct the heading: the heading counts",
        )),
        (given, stated) => Ok(given.or(stated)),
    }
}

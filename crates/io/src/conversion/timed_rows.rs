//! The rows of one recording with their times.

use crate::inspection::chosen;
use crate::recording::{When, clock_unit, time_column, unused_time};
use crate::rows::bad_field;
use crate::{
    ClockUnit, Error, ErrorKind, Input, Layout, Reading, RecordingOptions, Result, RowBlock,
    RowReader, SaidBy, Source, TimeUnit, TimeWindow, Unit,
};
use proofmass_uncertainty::Finding;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What tells the times of rows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum RowClock {
    /// A column, with its unit and so many units in a second.
    Stamps(TimeUnit, f64),
    /// Samples per second, as stated.
    Rate(f64),
    /// Nothing: rows have an order alone.
    Order,
}

/// What a recording says of its columns and its clock.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TimedLayout {
    /// Names of the signals without their units.
    pub names: Vec<String>,
    /// Their units, where they are known.
    pub units: Vec<Option<Unit>>,
    /// What tells the times.
    pub clock: RowClock,
    /// How it is read; the rate of time stamps is not known yet.
    pub reading: Reading,
    /// Columns that hold no numbers.
    pub left_out: Vec<String>,
    /// Question for the clock, where nobody states one.
    pub no_clock: Option<String>,
    /// Column of times that a stated rate stands for, with the gaps that may be in it.
    pub times_set_aside: Option<String>,
}

/// Parts of a second in a nanosecond.
const NANOSECOND: i128 = 1_000_000;

/// The rows of a recording, block by block. A field without a sample is NaN.
pub struct TimedRows {
    name: PathBuf,
    reader: RowReader,
    layout: TimedLayout,
    selected: Vec<usize>,
    signals: usize,
    findings: Vec<Finding>,
    /// When its times are zero by the clock of the file, in parts of a second.
    origin: Option<i128>,
}

impl TimedRows {
    /// Begins with the first block: every column of numbers where `options` name none. Of these `part` is read, with the times where
    /// `timed` says so. `window` is that of the recording that this one continues.
    ///
    /// # Errors
    /// A file that is no recording, columns that there are not, a clock whose unit has to be asked for.
    pub fn open(
        source: Source,
        options: &RecordingOptions,
        part: Option<Range<usize>>,
        timed: bool,
        window: Option<TimeWindow>,
    ) -> Result<Self> {
        let name = source.name().to_path_buf();
        Self::open_inner(source, options, part, timed, window).map_err(|e| e.at(&name))
    }

    fn open_inner(
        source: Source,
        options: &RecordingOptions,
        part: Option<Range<usize>>,
        timed: bool,
        window: Option<TimeWindow>,
    ) -> Result<Self> {
        let name = source.name().to_path_buf();
        let mut source = source.with_stream(options.stream.as_deref(), options.as_stored);
        let layout = Layout::of(&mut source, &options.layout)?;
        let named = layout.find_all(&options.columns)?;
        let when = When::of(&layout, options, options.sampling_rate_hz, &named)?;
        let times = when.time.or_else(|| time_column(&layout));
        let (signals, units) = chosen(&layout, options, times)?;
        if signals.is_empty() {
            return Err(Error::new(
                ErrorKind::Column,
                "no column holds numbers beside the times",
            )
            .with_hint(
                "`proofmass inspect` shows the columns; name those to be written with --columns",
            ));
        }
        let unit = when
            .time
            .map(|index| clock_unit(&layout, index, options))
            .transpose()?;
        layout.refuse_grouped(&signals, options.unit)?;
        let mut findings = layout.findings();
        findings.extend(unused_time(&layout, options, &signals));
        findings.extend(unit.iter().filter_map(|c| c.finding.clone()));
        let clock = match (&unit, when.rate) {
            (Some(unit), _) => RowClock::Stamps(unit.unit, unit.per_second),
            (None, Some(rate)) if rate.is_finite() && rate > 0.0 => RowClock::Rate(rate),
            (None, Some(rate)) => {
                let what =
                    format!("a sampling rate of {rate} Hz is out of range: it must be positive");
                return Err(Error::new(ErrorKind::Time, what)
                    .with_hint("give the number of samples per second with --rate"));
            }
            (None, None) => RowClock::Order,
        };
        let about = Self::about(
            &layout,
            options,
            (&signals, units),
            &when,
            unit.as_ref(),
            clock,
        );
        // Recordings continue each other by the clock of their files.
        let origin = layout.stream.as_ref().and_then(|s| s.origin_ns);
        let origin = origin.filter(|_| when.time.is_some_and(|i| Some(i) == time_column(&layout)));
        let origin = origin.map(|ns| i128::from(ns) * NANOSECOND);
        let part = part.unwrap_or(0..signals.len());
        let mut selected = signals[part].to_vec();
        let window = match (window, options.between) {
            (None, Some(between)) => {
                let rate = when.rate;
                let of = TimeWindow::of(between, selected.len(), unit.as_ref(), rate);
                Some(of.ok_or_else(|| layout.ask_clock())?)
            }
            (window, _) => window,
        };
        let signals = selected.len();
        let time = when.time.filter(|_| timed || window.is_some());
        selected.extend(time);
        let mut reader = RowReader::new(source, layout, &selected)?
            .locate_bad_fields()
            .between(window);
        if time.is_some() {
            reader = reader.stamps(signals);
        }
        Ok(Self {
            name,
            reader,
            layout: about,
            selected,
            signals,
            findings,
            origin,
        })
    }

    fn about(
        layout: &Layout,
        options: &RecordingOptions,
        (signals, units): (&[usize], Vec<Option<Unit>>),
        when: &When,
        unit: Option<&ClockUnit>,
        clock: RowClock,
    ) -> TimedLayout {
        let timed = when.time.zip(unit);
        let mut reading = Reading::of(layout, signals, options.unit, timed, when.rate);
        if when.stated.is_some() {
            reading.time.by = SaidBy::File;
        }
        reading.between_s = options.between;
        let text =
            |i: &usize| options.columns.is_empty() && !layout.numeric[*i] && when.time != Some(*i);
        let left_out = (0..layout.columns).filter(text).map(|i| layout.name(i));
        let aside = time_column(layout).filter(|i| {
            let stated = options.sampling_rate_hz.is_some() && when.time.is_none();
            stated && layout.stated_rate(*i).is_none() && !signals.contains(i)
        });
        let no_clock = matches!(clock, RowClock::Order).then(|| layout.ask_clock().to_string());
        TimedLayout {
            names: signals.iter().map(|i| layout.name(*i)).collect(),
            units,
            clock,
            left_out: left_out.collect(),
            reading,
            no_clock,
            times_set_aside: aside.map(|i| layout.name(i)),
        }
    }

    /// Name of the file.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// What the recording says of itself.
    pub fn layout(&self) -> &TimedLayout {
        &self.layout
    }

    /// The next rows.
    ///
    /// # Errors
    /// A field that is neither a finite number nor empty nor NaN, a time that is none, a row of another width.
    pub fn next_block(&mut self) -> Result<Option<RowBlock>> {
        let Some(mut block) = self.reader.next_block()? else {
            return Ok(None);
        };
        if let Some(origin) = self.origin {
            let stamps = block.stamps.iter_mut().flatten();
            stamps.for_each(|stamp| stamp.parts += origin);
        }
        for bad in &block.bad {
            let text = bad.text.trim();
            let absent = text.is_empty() || text.eq_ignore_ascii_case("nan");
            if !absent || bad.selected >= self.signals {
                let layout = self.reader.layout();
                return Err(bad_field(&bad.text, layout.decimal)
                    .at(&self.name)
                    .line(bad.line)
                    .column(layout.name(self.selected[bad.selected])));
            }
        }
        Ok(Some(block))
    }

    /// Bytes taken in so far, and all of them where that is known.
    pub fn progress(&self) -> (u64, u64) {
        (self.reader.bytes_read(), self.reader.size().unwrap_or(0))
    }

    /// The file with its digest, what is doubtful about it, and the window for the one that continues it.
    ///
    /// # Errors
    /// The rest of the file cannot be read.
    pub fn finish(mut self) -> Result<(Input, Vec<Finding>, Option<TimeWindow>)> {
        self.findings.extend(self.reader.findings());
        let window = self.reader.window().cloned();
        Ok((self.reader.finish()?, self.findings, window))
    }
}

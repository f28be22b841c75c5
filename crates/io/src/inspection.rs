//! What is in a recording: columns, ranges, rate, gaps. One pass, bounded memory.

use crate::clock::{Clock, ClockEstimator, LISTED};
use crate::layout::Layout;
use crate::recording::{RecordingOptions, signal_unit, time_column};
use crate::rows::{BadRow, RowReader};
use crate::trace::{Trace, Tracer};
use crate::{
    ClockUnit, Error, ErrorKind, Gap, Reading, Result, Source, StreamSummary, TimeUnit, TimeWindow,
    Unit,
};
use proofmass_uncertainty::Finding;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Distinct values that are told apart; a column with more is called continuous.
const DISTINCT: usize = 1 << 16;
/// Columns whose course is kept.
const TRACED: usize = 24;

/// A field that is not a finite number.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct BadEntry {
    /// Line, from one.
    pub line: u64,
    /// Name of the column.
    pub column: String,
    /// The field as it stands.
    pub text: String,
}

/// One column.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct ColumnSummary {
    /// Name without unit.
    pub name: String,
    /// Number from one.
    pub number: usize,
    /// Unit of the heading.
    pub unit: Option<Unit>,
    /// Statistics; `None` for a column of text or without a finite number.
    pub statistics: Option<Statistics>,
}

/// Statistics of the finite numbers of a column, in its unit.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Statistics {
    /// How many.
    pub count: u64,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Mean.
    pub mean: f64,
    /// Standard deviation; `None` for one sample.
    pub standard_deviation: Option<f64>,
    /// Number of distinct values; `None` beyond 65 536.
    pub distinct: Option<usize>,
    /// Smallest difference of two distinct values, the resolution of a quantised signal; `None` beyond 65 536.
    pub resolution: Option<f64>,
}

/// Times of a recording as far as a single pass shows them.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct TimeSummary {
    /// Name of the column.
    pub column: String,
    /// What the column counts; [`Inspection::reading`] tells who says so.
    pub unit: TimeUnit,
    /// Sampling rate by the straight line through the stamps, or as the file states it, Hz.
    pub rate_hz: f64,
    /// Whether the file states the rate and its times follow from it: there is nothing to estimate then.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub rate_is_stated: bool,
    /// Standard deviation of the steps that are not gaps, s.
    pub jitter_s: Option<f64>,
    /// What else the stamps tell about their clock: uncertainty of the rate, resolution, bursts, wraps.
    pub clock: Clock,
    /// Time of the first sample, s.
    #[serde(default)]
    pub first_s: f64,
    /// From first to last sample and one step more, s.
    pub duration_s: f64,
    /// The first hundred gaps.
    pub gaps: Vec<Gap>,
    /// All gaps.
    pub gap_count: u64,
    /// Lines at which the time repeats or runs backwards; the first hundred.
    pub backward_lines: Vec<u64>,
}

/// What is in a file.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Inspection {
    /// The file.
    pub path: PathBuf,
    /// SHA-256 in hexadecimal digits.
    pub sha256: String,
    /// Shape of the text.
    pub layout: Layout,
    /// Rows of data.
    pub rows: u64,
    /// Every column.
    pub columns: Vec<ColumnSummary>,
    /// Times, where a column is named as such and has two samples.
    pub time: Option<TimeSummary>,
    /// The first hundred fields that are not finite numbers.
    pub bad: Vec<BadEntry>,
    /// All such fields.
    pub bad_count: u64,
    /// The first rows that have not as many fields as the others; they are left out of everything else.
    pub bad_rows: Vec<BadRow>,
    /// All such rows.
    pub bad_row_count: u64,
    /// How it was read.
    pub reading: Reading,
    /// The streams of a file of another format than text; of several none was looked at unless it was chosen.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub streams: Vec<StreamSummary>,
    /// What is doubtful: lines passed over, an open last row, coarse or bursting time stamps.
    pub findings: Vec<Finding>,
}

/// Looks through a recording without refusing what is bad in it.
///
/// # Errors
/// A file that is no text with rows, a line of more than 1 MiB.
pub fn inspect(path: impl AsRef<Path>) -> Result<Inspection> {
    inspect_source(Source::open(path)?, &RecordingOptions::default(), LISTED)
}

/// Looks through a source, such as standard input, without refusing what is bad in it; so many bad fields and rows
/// are listed, and all are counted.
///
/// Without columns every column of numbers is looked at. A unit of time that nobody says is the likely one, with a finding
/// that asks for it.
///
/// # Errors
/// As [`inspect`]; columns that there are not, units that contradict the headings.
pub fn inspect_source(
    source: Source,
    options: &RecordingOptions,
    listed: usize,
) -> Result<Inspection> {
    let name = source.name().to_path_buf();
    let seen = inspect_inner(source, options, listed, 0);
    seen.map(|(inspection, _)| inspection)
        .map_err(|e: Error| e.at(&name))
}

/// As [`inspect_source`], and the course of the first columns that are looked at.
///
/// # Errors
/// As [`inspect_source`].
pub fn inspect_traced(
    source: Source,
    options: &RecordingOptions,
    listed: usize,
) -> Result<(Inspection, Vec<Trace>)> {
    let name = source.name().to_path_buf();
    inspect_inner(source, options, listed, TRACED).map_err(|e: Error| e.at(&name))
}

fn inspect_inner(
    mut source: Source,
    options: &RecordingOptions,
    listed: usize,
    traced: usize,
) -> Result<(Inspection, Vec<Trace>)> {
    let path = source.name().to_path_buf();
    source = source.with_stream(options.stream.as_deref(), options.as_stored);
    crate::stream::open(&mut source)?;
    let opened = source.opened.as_ref();
    let streams = opened.map_or_else(Vec::new, |o| o.streams.clone());
    if let Some(several) = opened.filter(|o| o.one().is_err()) {
        let layout = several.layout.clone();
        let inspection = Inspection {
            path,
            rows: 0,
            columns: Vec::new(),
            time: None,
            bad: Vec::new(),
            bad_count: 0,
            bad_rows: Vec::new(),
            bad_row_count: 0,
            reading: Reading::of(&layout, &[], None, None, None),
            findings: layout.findings(),
            layout,
            streams,
            sha256: source.finish()?.sha256,
        };
        return Ok((inspection, Vec::new()));
    }
    let layout = Layout::of(&mut source, &options.layout)?;
    let rate = options.sampling_rate_hz;
    let time_column = match &options.time {
        Some(column) => Some(layout.find(column)?),
        // What counts the rows needs the rate beside it.
        None if rate.is_some() && options.time_unit != Some(TimeUnit::Index) => None,
        None => time_column(&layout),
    };
    let (mut selected, units) = chosen(&layout, options, time_column)?;
    let signals = selected.len();
    let clock = time_column
        .map(|index| ClockUnit::likely(&layout, index, options.time_unit, rate))
        .transpose()?;
    let mut reading = Reading::of(
        &layout,
        &selected,
        options.unit,
        time_column.zip(clock.as_ref()),
        rate,
    );
    reading.between_s = options.between;
    selected.extend(time_column);
    let time_at = time_column.map(|_| signals);
    let window = |between| {
        TimeWindow::of(between, signals, clock.as_ref(), rate).ok_or_else(|| {
            Error::new(ErrorKind::Time, "a stretch of time needs times")
                .with_hint("add --time COLUMN or --rate HZ")
        })
    };
    let window = options.between.map(window).transpose()?;
    let mut times: Option<Times> = None;
    let mut sums: Vec<Sums> = selected.iter().map(|_| Sums::default()).collect();
    let traced = signals.min(traced);
    let mut tracers: Vec<Tracer> = (0..traced).map(|_| Tracer::new()).collect();
    // Place of each row of a block on the axis of the traces.
    let mut places: Vec<f64> = Vec::new();
    let (mut bad_rows, mut bad_row_count) = (Vec::new(), 0);
    let (mut rows, mut bad, mut bad_count) = (0_u64, Vec::new(), 0);
    let mut reader = RowReader::new(source, layout.clone(), &selected)?
        .survey()
        .between(window);
    if let Some(slot) = time_at {
        reader = reader.stamps(slot);
    }
    while let Some(block) = reader.next_block()? {
        for (i, sum) in sums.iter_mut().enumerate() {
            match block.bad.is_empty() {
                true => sum.add(block.column(i)),
                false => {
                    let finite = block.column(i).iter().copied().filter(|v| v.is_finite());
                    sum.add(&finite.collect::<Vec<_>>());
                }
            }
        }
        if traced > 0 {
            let place = |row| match time_at {
                Some(_) => f64::NAN,
                None => (rows as f64 + row as f64) / rate.unwrap_or(1.0),
            };
            places.clear();
            places.extend((0..block.rows()).map(place));
        }
        for (row, stamp) in block.stamps().iter().enumerate() {
            let Some(stamp) = *stamp else { continue };
            let scale = clock.as_ref().map_or(1.0, |c| c.per_second);
            let times = times.get_or_insert_with(|| Times::new(scale));
            let line = block.line(row);
            let at = times.clock.add(rows as usize + row, line, stamp);
            if let Some(place) = places.get_mut(row) {
                let first = times.clock.first().unwrap_or(at);
                *place = at.since(first) / scale;
            }
        }
        for (i, tracer) in tracers.iter_mut().enumerate() {
            let rows = places.iter().zip(block.column(i));
            rows.for_each(|(place, value)| tracer.add(*place, *value));
        }
        bad_count += block.bad.len() as u64;
        let room = listed - bad.len();
        bad.extend(block.bad.iter().take(room).map(|b| BadEntry {
            line: b.line,
            column: layout.name(selected[b.selected]),
            text: b.text.clone(),
        }));
        bad_row_count += block.bad_rows.len() as u64;
        let room = listed - bad_rows.len();
        bad_rows.extend(block.bad_rows.iter().take(room).cloned());
        rows += block.rows() as u64;
    }
    let mut findings = layout.findings();
    if let Some((column, number)) = layout.grouped(&selected[..signals], options.unit) {
        findings.push(crate::findings::thousands_suspected(&column, number));
    }
    findings.extend(clock.iter().filter_map(|c| c.finding.clone()));
    findings.extend(reader.findings());
    if let (0, Some(window)) = (rows, reader.window()) {
        return Err(Error::new(ErrorKind::Time, window.nothing()));
    }
    let sha256 = reader.sha256()?;
    let traces = tracers.into_iter().zip(&selected);
    let traces = traces
        .map(|(tracer, index)| tracer.trace(index + 1))
        .collect();
    let columns = (0..layout.columns)
        .map(|index| ColumnSummary {
            name: layout.name(index),
            number: index + 1,
            unit: selected[..signals]
                .iter()
                .position(|&i| i == index)
                .map_or(layout.unit(index), |i| units[i]),
            statistics: selected
                .iter()
                .position(|&i| i == index)
                .and_then(|i| sums[i].statistics()),
        })
        .collect();
    let time = times
        .zip(time_column.zip(clock))
        .and_then(|(times, (i, clock))| times.summary(layout.name(i), clock.unit, &mut findings));
    let mut time = time;
    if let (Some(time), Some(stated)) = (
        &mut time,
        time_column.and_then(|index| layout.stated_rate(index)),
    ) {
        time.rate_hz = stated;
        time.rate_is_stated = true;
    }
    if let Some(time) = &time {
        reading.time.rate_hz = Some(time.rate_hz);
    }
    let inspection = Inspection {
        path,
        sha256,
        layout,
        rows,
        columns,
        time,
        bad,
        bad_count,
        bad_rows,
        bad_row_count,
        reading,
        streams,
        findings,
    };
    Ok((inspection, traces))
}

/// The columns that are looked at, with their units: those that are named, else every column of numbers but the times.
pub(crate) fn chosen(
    layout: &Layout,
    options: &RecordingOptions,
    time: Option<usize>,
) -> Result<(Vec<usize>, Vec<Option<Unit>>)> {
    if options.columns.is_empty() {
        layout.refuse_mixed_marks()?;
    }
    let selected: Vec<usize> = match options.columns.is_empty() {
        true => (0..layout.columns)
            .filter(|&i| layout.numeric[i] && Some(i) != time)
            .collect(),
        false => layout.find_all(&options.columns)?,
    };
    let unit = |&i: &usize| match options.columns.is_empty() {
        // Of all columns a stated unit is that of those which have none.
        true => Ok(layout.unit(i).or(options.unit)),
        false => signal_unit(layout, i, options.unit),
    };
    let units = selected.iter().map(unit).collect::<Result<_>>()?;
    Ok((selected, units))
}

/// Running sums, block by block about the mean of each, so that a large mean does not swallow the scatter.
#[derive(Default)]
struct Sums {
    count: u64,
    mean: f64,
    m2: f64,
    min: f64,
    max: f64,
    distinct: HashSet<u64>,
    /// Values met a short while ago, each at the place that its bits choose: most of a recording of counts.
    recent: Vec<u64>,
    continuous: bool,
}

impl Sums {
    /// Places for recent values, a power of two.
    const RECENT: u32 = 10;
    /// No finite value has these bits.
    const NOTHING: u64 = u64::MAX;

    /// Takes finite values.
    fn add(&mut self, values: &[f64]) {
        let Some(&first) = values.first() else { return };
        if self.count == 0 {
            (self.min, self.max) = (first, first);
        }
        let n = values.len() as f64;
        let about = sum_of(values, |v| v) / n;
        // What rounding left in the mean is taken out again.
        let rest = sum_of(values, |v| v - about);
        let squares = sum_of(values, |v| (v - about) * (v - about));
        let (mean, m2) = (about + rest / n, squares - rest * rest / n);
        let all = self.count as f64 + n;
        let apart = mean - self.mean;
        self.m2 += m2 + apart * apart * (self.count as f64 * n / all);
        self.mean += apart * (n / all);
        self.count += values.len() as u64;
        let smaller = |a: f64, b: f64| if b < a { b } else { a };
        let larger = |a: f64, b: f64| if b > a { b } else { a };
        self.min = lanes(values, self.min, smaller)
            .into_iter()
            .fold(self.min, smaller);
        self.max = lanes(values, self.max, larger)
            .into_iter()
            .fold(self.max, larger);
        if !self.continuous {
            // Not for the few rows of a table of very many columns.
            if self.count > 1 << Self::RECENT {
                self.recent.resize(1 << Self::RECENT, Self::NOTHING);
            }
            for &v in values {
                // Adding zero makes −0 and 0 one value.
                let bits = (v + 0.0).to_bits();
                let place = bits.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> (64 - Self::RECENT);
                let seen = self.recent.get_mut(place as usize);
                if seen.is_some_and(|seen| std::mem::replace(seen, bits) == bits) {
                    continue;
                }
                self.distinct.insert(bits);
                if self.distinct.len() > DISTINCT {
                    self.continuous = true;
                    self.distinct = HashSet::new();
                    break;
                }
            }
        }
    }

    fn statistics(&self) -> Option<Statistics> {
        let mut values: Vec<f64> = self.distinct.iter().map(|&b| f64::from_bits(b)).collect();
        values.sort_by(f64::total_cmp);
        let resolution = values
            .windows(2)
            .map(|w| w[1] - w[0])
            .min_by(f64::total_cmp);
        (self.count > 0).then(|| Statistics {
            count: self.count,
            min: self.min,
            max: self.max,
            mean: self.mean,
            standard_deviation: (self.count > 1)
                .then(|| (self.m2 / (self.count - 1) as f64).sqrt()),
            distinct: (!self.continuous).then_some(values.len()),
            resolution,
        })
    }
}

/// Eight folds side by side, of every eighth value each.
fn lanes(values: &[f64], start: f64, step: impl Fn(f64, f64) -> f64) -> [f64; 8] {
    let mut lanes = [start; 8];
    let (eights, rest) = values.as_chunks::<8>();
    for eight in eights {
        for (lane, v) in lanes.iter_mut().zip(eight) {
            *lane = step(*lane, *v);
        }
    }
    for (lane, v) in lanes.iter_mut().zip(rest) {
        *lane = step(*lane, *v);
    }
    lanes
}

fn sum_of(values: &[f64], of: impl Fn(f64) -> f64) -> f64 {
    lanes(values, 0.0, |sum, v| sum + of(v)).iter().sum()
}

/// The clock behind the time column.
struct Times {
    clock: ClockEstimator,
    per_second: f64,
}

impl Times {
    fn new(per_second: f64) -> Self {
        Self {
            clock: ClockEstimator::new(per_second),
            per_second,
        }
    }

    fn summary(
        mut self,
        column: String,
        unit: TimeUnit,
        findings: &mut Vec<Finding>,
    ) -> Option<TimeSummary> {
        let (first, last) = (self.clock.first()?, self.clock.last()?);
        let clock = self.clock.finish()?;
        // Gaps stand in the summary itself.
        findings.extend(crate::clock_findings::of(
            &clock,
            self.clock.wraps(),
            &[],
            false,
        ));
        let mut gaps = std::mem::take(&mut self.clock.gaps);
        let start = first.value() / self.per_second;
        for gap in &mut gaps {
            gap.at_s += start;
        }
        Some(TimeSummary {
            column,
            unit,
            rate_hz: clock.rate_hz,
            rate_is_stated: false,
            first_s: start,
            jitter_s: clock.jitter_s,
            clock,
            duration_s: last.since(first) / self.per_second + 1.0 / clock.rate_hz,
            gaps,
            gap_count: clock.gaps,
            backward_lines: self.clock.backward.iter().map(|b| b.0).collect(),
        })
    }
}

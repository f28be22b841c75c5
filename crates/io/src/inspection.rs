//! What is in a recording: columns, ranges, rate, gaps. One pass, bounded memory.

use crate::layout::{Layout, LayoutOptions};
use crate::recording::time_column;
use crate::rows::RowReader;
use crate::time_base::{Steps, median};
use crate::{Error, Gap, Result, Source, Unit};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Distinct values that are told apart; a column with more is called continuous.
const DISTINCT: usize = 1 << 16;
/// Steps at the beginning that settle the median step.
const FIRST_STEPS: usize = 1 << 16;
/// Bad fields and gaps that are listed; all are counted.
const LISTED: usize = 100;

/// A field that is not a finite number.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct BadEntry {
    /// Line, from one.
    pub line: u64,
    /// Name of the column.
    pub column: String,
    /// The field as it stands.
    pub text: String,
}

/// One column.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
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
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TimeSummary {
    /// Name of the column.
    pub column: String,
    /// Unit of the heading; seconds are assumed without one.
    pub unit: Option<Unit>,
    /// Inverse of the median of the first 65 536 steps, Hz.
    pub rate_hz: f64,
    /// Standard deviation of the steps that are not gaps, s.
    pub jitter_s: Option<f64>,
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
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
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
}

/// Looks through a recording without refusing what is bad in it.
///
/// # Errors
/// A file that is no text with rows, or a row of another width.
pub fn inspect(path: impl AsRef<Path>) -> Result<Inspection> {
    inspect_source(Source::open(path)?)
}

/// Looks through a source, such as standard input, without refusing what is bad in it.
///
/// # Errors
/// As [`inspect`].
pub fn inspect_source(source: Source) -> Result<Inspection> {
    let name = source.name().to_path_buf();
    inspect_inner(source).map_err(|e: Error| e.at(&name))
}

fn inspect_inner(mut source: Source) -> Result<Inspection> {
    let path = source.name().to_path_buf();
    let layout = Layout::of(&mut source, &LayoutOptions::default())?;
    let selected: Vec<usize> = (0..layout.columns).filter(|&i| layout.numeric[i]).collect();
    let time_at = time_column(&layout).and_then(|t| selected.iter().position(|&i| i == t));
    let unit = time_at.and_then(|i| layout.unit(selected[i]));
    let scale = unit.map_or(1.0, |u| u.si().1);
    let mut time = Times::new();
    let mut sums: Vec<Sums> = selected.iter().map(|_| Sums::default()).collect();
    let (mut rows, mut bad, mut bad_count) = (0_u64, Vec::new(), 0);
    let mut reader = RowReader::new(source, layout.clone(), &selected)?.locate_bad_fields();
    while let Some(block) = reader.next_block()? {
        for (i, sum) in sums.iter_mut().enumerate() {
            block
                .column(i)
                .iter()
                .filter(|v| v.is_finite())
                .for_each(|&v| sum.add(v));
        }
        if let Some(i) = time_at {
            for (row, &t) in block
                .column(i)
                .iter()
                .enumerate()
                .filter(|(_, t)| t.is_finite())
            {
                time.add(rows as usize + row, block.line(row), t * scale);
            }
        }
        bad_count += block.bad.len() as u64;
        let room = LISTED - bad.len();
        bad.extend(block.bad.iter().take(room).map(|b| BadEntry {
            line: b.line,
            column: layout.name(selected[b.selected]),
            text: b.text.clone(),
        }));
        rows += block.rows() as u64;
    }
    let sha256 = reader.sha256()?;
    let columns = (0..layout.columns)
        .map(|index| ColumnSummary {
            name: layout.name(index),
            number: index + 1,
            unit: layout.unit(index),
            statistics: selected
                .iter()
                .position(|&i| i == index)
                .and_then(|i| sums[i].statistics()),
        })
        .collect();
    let time = time_at.and_then(|i| time.summary(layout.name(selected[i]), unit));
    Ok(Inspection {
        path,
        sha256,
        layout,
        rows,
        columns,
        time,
        bad,
        bad_count,
    })
}

/// Running sums after Welford, so that a large mean does not swallow the scatter.
#[derive(Default)]
struct Sums {
    count: u64,
    mean: f64,
    m2: f64,
    min: f64,
    max: f64,
    distinct: HashSet<u64>,
    continuous: bool,
}

impl Sums {
    fn add(&mut self, v: f64) {
        if self.count == 0 {
            (self.min, self.max) = (v, v);
        }
        self.count += 1;
        let d = v - self.mean;
        self.mean += d / self.count as f64;
        self.m2 += d * (v - self.mean);
        self.min = self.min.min(v);
        self.max = self.max.max(v);
        if !self.continuous {
            // Adding zero makes −0 and 0 one value.
            self.distinct.insert((v + 0.0).to_bits());
            if self.distinct.len() > DISTINCT {
                self.continuous = true;
                self.distinct = HashSet::new();
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

/// Steps wait until the median of the first of them is known.
struct Times {
    waiting: Vec<(usize, u64, f64, f64)>,
    steps: Option<(f64, Steps)>,
    first: f64,
    last: Option<(usize, u64, f64)>,
    gaps: Vec<Gap>,
    gap_count: u64,
    backward: Vec<u64>,
}

impl Times {
    fn new() -> Self {
        Self {
            waiting: Vec::new(),
            steps: None,
            first: 0.0,
            last: None,
            gaps: Vec::new(),
            gap_count: 0,
            backward: Vec::new(),
        }
    }

    fn add(&mut self, sample: usize, line: u64, t: f64) {
        match self.last {
            None => self.first = t,
            Some((_, _, before)) if t <= before => {
                if self.backward.len() < LISTED {
                    self.backward.push(line);
                }
            }
            Some((sample, line, before)) => {
                let step = (sample, line, before, t - before);
                if self.steps.is_some() {
                    self.count(step);
                } else {
                    self.waiting.push(step);
                    if self.waiting.len() == FIRST_STEPS {
                        self.settle();
                    }
                }
            }
        }
        self.last = Some((sample, line, t));
    }

    fn settle(&mut self) {
        let waiting = std::mem::take(&mut self.waiting);
        if waiting.is_empty() {
            return;
        }
        let mut steps: Vec<f64> = waiting.iter().map(|w| w.3).collect();
        let median = median(&mut steps);
        self.steps = Some((median, Steps::new(median)));
        waiting.into_iter().for_each(|w| self.count(w));
    }

    fn count(&mut self, (after_sample, line, at_s, step_s): (usize, u64, f64, f64)) {
        if let Some((_, steps)) = &mut self.steps
            && steps.is_gap(step_s)
        {
            self.gap_count += 1;
            if self.gaps.len() < LISTED {
                self.gaps.push(Gap {
                    after_sample,
                    line,
                    at_s,
                    step_s,
                });
            }
        }
    }

    fn summary(mut self, column: String, unit: Option<Unit>) -> Option<TimeSummary> {
        if self.steps.is_none() {
            self.settle();
        }
        let (median, steps) = self.steps?;
        Some(TimeSummary {
            column,
            unit,
            rate_hz: 1.0 / median,
            jitter_s: steps.deviation(),
            duration_s: self.last?.2 - self.first + median,
            gaps: self.gaps,
            gap_count: self.gap_count,
            backward_lines: self.backward,
        })
    }
}

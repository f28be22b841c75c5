//! What recordings that continue each other hold, in one pass.

use super::target::TargetForm;
use super::timed_rows::{RowClock, TimedLayout};
use crate::clock::{Clock, ClockEstimator};
use crate::stamp::Stamp;
use crate::time_base::backward;
use crate::time_window::FAR;
use crate::{Error, ErrorKind, Result, RowBlock, clock_findings};
use proofmass_uncertainty::Finding;
use std::path::{Path, PathBuf};

/// Standard deviation of stamps about even steps beyond which these do not stand for them, intervals.
const SCATTER: f64 = 0.25;
/// Relative change of the rate within a recording beyond which there is not one rate.
const CHANGE: f64 = 1e-3;

/// Goes over the rows of recordings that continue each other.
pub struct Survey {
    form: TargetForm,
    layout: Option<TimedLayout>,
    clock: Option<ClockEstimator>,
    rows: u64,
    absent: Vec<u64>,
    rounded: u64,
    departure: f64,
    /// The recording at work, and whether none of its rows was seen.
    file: PathBuf,
    opens: bool,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Surveyed {
    /// Columns and clock, as the first recording says them.
    pub layout: TimedLayout,
    /// Rows of all recordings.
    pub rows: u64,
    /// The clock behind time stamps.
    pub clock: Option<Clock>,
    /// Rows before which samples are missing, counted from zero, and how many.
    pub gaps: Vec<(u64, u64)>,
    /// Absent samples of each signal.
    pub absent: Vec<u64>,
    /// Numbers that the target rounds.
    pub rounded: u64,
    /// Largest departure of a rounded number, relative to it.
    pub departure: f64,
    /// What is doubtful about the times.
    pub findings: Vec<Finding>,
    pub(crate) start: Option<Stamp>,
    pub(crate) wraps: bool,
}

impl Survey {
    /// Before the first recording.
    pub fn new(form: TargetForm) -> Self {
        Self {
            form,
            layout: None,
            clock: None,
            rows: 0,
            absent: Vec::new(),
            rounded: 0,
            departure: 0.0,
            file: PathBuf::new(),
            opens: false,
        }
    }

    /// Begins a recording, which continues the one before.
    ///
    /// # Errors
    /// Other columns, units or another clock than that.
    pub fn begin(&mut self, file: &Path, layout: &TimedLayout) -> Result<()> {
        match &self.layout {
            Some(first) => alike(first, layout, &self.file).map_err(|e| e.at(file))?,
            None => {
                self.absent = vec![0; layout.names.len()];
                if let RowClock::Stamps(_, per_second) = layout.clock {
                    self.clock = Some(ClockEstimator::new(per_second).keep_missing());
                }
                self.layout = Some(layout.clone());
            }
        }
        self.opens = self.rows > 0;
        if !self.opens {
            self.file = file.to_path_buf();
        }
        Ok(())
    }

    /// Takes the next rows of the recording.
    ///
    /// # Errors
    /// Times that do not run forward, a number that the target cannot hold.
    pub fn block(&mut self, file: &Path, block: &RowBlock) -> Result<()> {
        self.times(file, block).map_err(|e| e.at(file))?;
        self.numbers(block).map_err(|e| e.at(file))?;
        self.rows += block.rows() as u64;
        if block.rows() > 0 {
            self.file = file.to_path_buf();
            self.opens = false;
        }
        Ok(())
    }

    fn times(&mut self, file: &Path, block: &RowBlock) -> Result<()> {
        let Some(clock) = &mut self.clock else {
            return Ok(());
        };
        let Some(RowClock::Stamps(_, scale)) = self.layout.as_ref().map(|l| l.clock) else {
            return Ok(());
        };
        for (row, stamp) in block.stamps().iter().enumerate() {
            let Some(stamp) = *stamp else { continue };
            let before = clock.last();
            let at = clock.add(self.rows as usize + row, block.line(row), stamp);
            if self.opens
                && row == 0
                && let Some(before) = before
                && at.parts <= before.parts
            {
                return Err(
                    overlap(&self.file, before.value() / scale, at.value() / scale)
                        .at(file)
                        .line(block.line(0)),
                );
            }
        }
        match clock.backward.first() {
            Some((line, what)) => Err(backward(*what).line(*line)),
            None => Ok(()),
        }
    }

    /// Counts what is absent and what is rounded.
    fn numbers(&mut self, block: &RowBlock) -> Result<()> {
        let exact = self.form.is_exact();
        for (i, absent) in self.absent.iter_mut().enumerate() {
            let column = block.column(i);
            if !block.bad.is_empty() {
                *absent += column.iter().filter(|v| v.is_nan()).count() as u64;
            }
            if exact {
                continue;
            }
            for (row, &number) in column.iter().enumerate() {
                if number.is_nan() {
                    continue;
                }
                let Some(stored) = self.form.stored(number) else {
                    let name = self.layout.as_ref().map(|l| l.names[i].clone());
                    let what = format!("{number} cannot be held in the form of the WAV file");
                    return Err(Error::new(ErrorKind::Field, what)
                        .line(block.line(row))
                        .column(name.unwrap_or_default())
                        .with_hint("--wav-form float64 holds every number as it is"));
                };
                if stored != number {
                    self.rounded += 1;
                    self.departure = self.departure.max((stored / number - 1.0).abs());
                }
            }
        }
        Ok(())
    }

    /// What was found in all of them.
    ///
    /// # Errors
    /// No recording was begun, a clock that stands still or repeats.
    pub fn finish(self) -> Result<Surveyed> {
        let Some(layout) = self.layout else {
            return Err(Error::new(ErrorKind::Format, "no recording was named"));
        };
        let mut surveyed = Surveyed {
            layout,
            rows: self.rows,
            clock: None,
            gaps: Vec::new(),
            absent: self.absent,
            rounded: self.rounded,
            departure: self.departure,
            findings: Vec::new(),
            start: None,
            wraps: false,
        };
        let Some(mut stamps) = self.clock else {
            return Ok(surveyed);
        };
        let repeats = stamps.may_repeat();
        surveyed.clock = stamps.finish();
        if let Some((line, what)) = stamps.backward.first() {
            return Err(backward(*what).at(&self.file).line(*line));
        }
        surveyed.start = stamps.first();
        surveyed.wraps = !stamps.wraps().is_empty();
        surveyed.gaps = stamps.missing.take().unwrap_or_default();
        if self.rows > 2 && surveyed.clock.is_none() {
            return Err(Error::new(
                ErrorKind::Time,
                "the clock stands still: its times do not advance",
            )
            .at(&self.file)
            .with_hint(
                "name another column with --time, or give --rate HZ in place of the times",
            ));
        }
        if let Some(clock) = &surveyed.clock {
            surveyed.findings = clock_findings::of(clock, stamps.wraps(), &stamps.gaps, repeats);
        }
        Ok(surveyed)
    }
}

impl Surveyed {
    /// Whether the rows can stand behind those of another recording in one table.
    ///
    /// # Errors
    /// Other columns or units, or times in one of them alone.
    pub fn stands_behind(&self, first: &Self, first_file: &Path) -> Result<()> {
        same_columns(&first.layout, &self.layout, first_file)?;
        let is_timed = |of: &Self| of.layout.clock != RowClock::Order;
        let (own, other) = match (is_timed(first), is_timed(self)) {
            (true, false) => ("has no clock", "has times"),
            (false, true) => ("has times", "has no clock"),
            _ => return Ok(()),
        };
        let what = format!("{own}, {} {other}", first_file.display());
        Err(Error::new(ErrorKind::Time, what)
            .with_hint("rows of one table all have times, or none: --rate HZ says a clock for all"))
    }

    /// Samples per second, as stated or by the line through the time stamps.
    pub fn rate_hz(&self) -> Option<f64> {
        match self.layout.clock {
            RowClock::Rate(rate) => Some(rate),
            RowClock::Stamps(..) => self.clock.as_ref().map(|c| c.rate_hz),
            RowClock::Order => None,
        }
    }

    /// Standard deviation of the time stamps about even steps, s, where there are stamps.
    pub fn scatter_s(&self) -> Option<f64> {
        self.clock.as_ref().map(|c| c.scatter_s)
    }

    /// Samples whose place is known to be empty.
    pub fn missing(&self) -> u64 {
        self.gaps.iter().map(|(_, samples)| samples).sum()
    }

    /// Samples that are missing where nobody can say.
    pub fn missing_somewhere(&self) -> u64 {
        let all = self.clock.as_ref().map_or(0, |c| c.missing);
        all.saturating_sub(self.missing())
    }

    /// Time of the first sample, s, and whether it lies so far from zero that times of doubles count from it.
    pub fn start_s(&self) -> (f64, bool) {
        match (self.start, self.layout.clock) {
            (Some(start), RowClock::Stamps(_, per_second)) => {
                let start = start.value() / per_second;
                (start, start.abs() >= FAR)
            }
            _ => (0.0, false),
        }
    }

    /// Why one steady rate does not tell the times, where it does not.
    pub fn uneven(&self) -> Option<String> {
        if !matches!(self.layout.clock, RowClock::Stamps(..)) {
            return None;
        }
        let Some(clock) = &self.clock else {
            return Some("its times are too few to tell a rate".to_owned());
        };
        let missing = clock.missing.max(self.missing());
        let scatter = clock.scatter_s * clock.rate_hz;
        if let Some((row, samples)) = self.gaps.first() {
            let all = match self.gaps.len() {
                1 => "a gap".to_owned(),
                n => format!("{n} gaps"),
            };
            return Some(format!(
                "has {all}, {missing} samples long in all; the first is {samples} long, behind sample {row}"
            ));
        }
        if missing > 0 {
            return Some(format!(
                "misses about {missing} samples, and nothing tells where"
            ));
        }
        if clock.untested {
            return Some("has times of which nothing tells whether samples are missing".to_owned());
        }
        if let Some(change) = clock.change
            && (change.after_hz / change.before_hz - 1.0).abs() > CHANGE
        {
            return Some(format!(
                "changes its rate near sample {}, from {:.6} Hz to {:.6} Hz",
                change.row, change.before_hz, change.after_hz
            ));
        }
        (scatter > SCATTER)
            .then(|| format!("has times that scatter by {scatter:.2} intervals about even ones"))
    }
}

/// Refuses a recording that does not continue another.
fn alike(first: &TimedLayout, other: &TimedLayout, before: &Path) -> Result<()> {
    same_columns(first, other, before)?;
    if first.clock == other.clock {
        return Ok(());
    }
    let before = before.display();
    let word = |clock: RowClock| match clock {
        RowClock::Stamps(unit, _) => format!("times in {unit}"),
        RowClock::Rate(rate) => format!("a rate of {rate} Hz"),
        RowClock::Order => "no clock".to_owned(),
    };
    let what = format!("has {}, {before} {}", word(other.clock), word(first.clock));
    Err(Error::new(ErrorKind::Time, what)
        .with_hint("recordings that are written as one need one clock: --rate HZ says it for all"))
}

/// Refuses a recording of other columns or units than another.
fn same_columns(first: &TimedLayout, other: &TimedLayout, before: &Path) -> Result<()> {
    let before = before.display();
    let column = |what: String| {
        Err(Error::new(ErrorKind::Column, what).with_hint(
            "recordings that are written as one need the same columns in the same units: name them with --columns, or convert each by itself",
        ))
    };
    if first.names.len() != other.names.len() {
        return column(format!(
            "holds {} signals, {before} {}",
            other.names.len(),
            first.names.len()
        ));
    }
    let pairs = first.names.iter().zip(&other.names);
    if let Some((one, another)) = pairs.into_iter().find(|(one, another)| one != another) {
        return column(format!(
            "holds \"{another}\" where {before} holds \"{one}\""
        ));
    }
    let mut units = first.units.iter().zip(&other.units).zip(&first.names);
    if let Some(((one, another), name)) = units.find(|((one, another), _)| one != another) {
        let word = |unit: &Option<crate::Unit>| match unit {
            Some(unit) => format!("in {unit}"),
            None => "in a unit that is not said".to_owned(),
        };
        return column(format!(
            "holds \"{name}\" {}, {before} {}",
            word(another),
            word(one)
        ));
    }
    Ok(())
}

fn overlap(before: &Path, end_s: f64, begin_s: f64) -> Error {
    let before = before.display();
    let what = format!("begins at {begin_s} s, but {before} before it ends at {end_s} s");
    Error::new(ErrorKind::Time, what).with_hint(
        "name the recordings in the order of their times, each sample in one of them; where each counts from its own zero, --rate HZ puts them behind one another",
    )
}

//! A recording compensated with a calibration, row by row.

mod band;
mod chain;
mod compensation;
mod environment;
mod outcome;
mod page;
mod steps;

pub use crate::destination::Destination;
pub use band::calibration_of_band;
pub use chain::{Chain, LowPass, LowPassForm, Rotation};
pub use compensation::{CompensationMethod, CompensationStream};
pub use environment::FollowedColumn;
pub use outcome::{ApplyOutcome, FilterFigures};
pub use steps::ChainFigures;

use crate::bias::TrackedBias;
use crate::block_clock::BlockClock;
use crate::outcome::Job;
use crate::recording::RecordingReading;
use crate::trouble::{Result, Trouble, TroubleKind};
use proofmass_core::Watch;
use proofmass_documents::AnyCalibration;
use proofmass_io::{
    ClockUnit, ColumnRef, Layout, LayoutOptions, Reading, Rewriter, RowBlock, RowReader, Source,
    Thermometer, WaitingRows, split_heading,
};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::rc::Rc;
use std::sync::Mutex;
use steps::Steps;

/// What to do with a sample beyond the range in which the calibration was tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum OutOfRange {
    /// It is compensated, counted and reported.
    #[default]
    Report,
    /// The recording is refused at the first one.
    Refuse,
}

/// Which recording is to be compensated, and how.
///
/// ```
/// use proofmass_documents::{AnyCalibration, CalibrationFile};
/// use proofmass_io::{Source, Unit};
/// use proofmass_jobs::apply::{ApplyData, ApplyJob, Destination};
/// use proofmass_jobs::{Job, Unwatched};
/// use proofmass_uncertainty::Estimate;
///
/// let k = [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0]];
/// let file = CalibrationFile::new("full", Unit::Count, k, [1.0, 0.0, 0.0], Estimate::new(vec![], vec![])?);
/// let calibration = AnyCalibration::from(file);
/// let recording = Source::from_bytes("raw.csv", "t_s,x_count,y_count,z_count\n0,3,4,8\n1,5,6,40\n")?;
/// let mut job = ApplyJob::default();
/// job.reading.columns = Some(vec!["x".into(), "y".into(), "z".into()]);
/// let mut written = Vec::new();
/// let data = ApplyData::new(&calibration, recording, Destination::Bytes(&mut written));
/// let outcome = job.evaluate(&data, &Unwatched)?;
/// assert_eq!(outcome.rows(), 2);
/// drop(data);
/// assert_eq!(
///     String::from_utf8(written)?,
///     "t_s,x_m/s2,y_m/s2,z_m/s2\n0,1.0,2.0,2.0\n1,2.0,3.0,10.0\n"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ApplyJob {
    /// How the calibration is used.
    pub method: CompensationMethod,
    /// What to do with samples beyond the tested range.
    pub out_of_range: OutOfRange,
    /// How the recording is read.
    pub reading: RecordingReading,
    /// Column of the temperature in °C, for a calibration that follows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<ColumnRef>,
    /// Columns of the other quantities of the surroundings that the calibration follows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub environment: Vec<FollowedColumn>,
    /// What follows the calibration: rotation, low-pass, decimation.
    #[serde(skip_serializing_if = "Chain::is_empty")]
    pub chain: Chain,
}

/// A calibration, a recording that is seen once, and where the compensated one goes.
pub struct ApplyData<'a> {
    calibration: &'a AnyCalibration,
    bias: Option<&'a TrackedBias>,
    once: Mutex<Option<(Source, Destination<'a>)>>,
}

impl<'a> ApplyData<'a> {
    /// A recording is read once: the data serve one evaluation.
    pub fn new(calibration: &'a AnyCalibration, recording: Source, to: Destination<'a>) -> Self {
        Self {
            calibration,
            bias: None,
            once: Mutex::new(Some((recording, to))),
        }
    }

    /// The same with a bias that was tracked over this recording, which is subtracted behind the calibration.
    #[must_use]
    pub fn with_bias(mut self, bias: &'a TrackedBias) -> Self {
        self.bias = Some(bias);
        self
    }
}

impl Job for ApplyJob {
    type Data<'a> = ApplyData<'a>;
    type Outcome = ApplyOutcome;

    fn evaluate(&self, data: &ApplyData<'_>, watch: &dyn Watch) -> Result<ApplyOutcome> {
        let once = data.once.lock().ok().and_then(|mut once| once.take());
        let Some((source, to)) = once else {
            return Err(Trouble::data(
                "this recording was used up by an earlier job: open it again",
            ));
        };
        let name = source.name().display().to_string();
        let about = |t: Trouble| t.detail(name.clone());
        let calibration = data.calibration;
        let axes = match calibration {
            AnyCalibration::FrequencyResponse(file) => file.axes.len(),
            AnyCalibration::Constant(file) => file.axes(),
            _ => return Err(Trouble::request("a calibration of an unknown kind")),
        };
        self.chain.check(axes)?;
        if let Some(bias) = data.bias {
            bias.belongs_to(calibration, axes)?;
        }
        let mut source = self.reading.choice.stream_of(source);
        let layout = Layout::of(&mut source, &LayoutOptions::default())?;
        let (mut columns, mut headings) = (Vec::new(), Vec::new());
        let exchanged = self.reading.exchanged(calibration, &layout);
        let unit = match calibration {
            AnyCalibration::FrequencyResponse(file) => file.output_unit,
            AnyCalibration::Constant(file) => file.output_unit,
            _ => return Err(Trouble::request("a calibration of an unknown kind")),
        };
        for signal in self.reading.signals(calibration)? {
            let index = layout
                .find(&signal)
                .map_err(|e| about(self.reading.not_of_calibration(e, calibration)))?;
            let column = layout.name(index);
            columns.push(index);
            let bare = split_heading(&column).0.replace(' ', "_");
            headings.push((index, format!("{bare}_{}", unit.ascii())));
        }
        let factors = self
            .reading
            .factors(calibration.input_unit(), &layout, &columns)
            .map_err(about)?;
        let temperature = self.thermometer(calibration, &layout).map_err(about)?;
        let signals = columns.clone();
        columns.extend(temperature.map(|(index, _)| index));
        let environment =
            environment::columns(&self.environment, calibration, &layout).map_err(about)?;
        columns.extend(environment.iter().map(|e| e.index));
        let (clock, timed) = self.clock(&layout, data.bias.is_some(), &mut columns)?;
        let timed = timed.as_ref().map(|(index, unit)| (*index, unit));
        let mut reading = self.reading.of_stream(&layout, &signals, timed)?;
        reading.temperature =
            temperature.map(|(index, told)| Reading::thermometer(&layout, index, &told));
        reading.surroundings = environment.iter().map(|e| e.read.clone()).collect();
        let mut work = Work {
            job: self,
            calibration,
            temperature: temperature.map(|(_, told)| told),
            environment: environment.iter().map(|e| e.factor).collect(),
            clock,
            compensation: None,
            bias: data.bias,
            steps: None,
            first_row: 0,
            origin: None,
            factors,
            waiting: WaitingRows::new(headings.len()),
            figures: outcome::Figures::default(),
            writer: match &to {
                Destination::File { path, inputs, .. } => {
                    Rewriter::create(path, &layout, &headings, inputs)?
                }
                Destination::Bytes(_) => Rewriter::in_memory(source.name(), &layout, &headings)?,
            },
            name: name.clone(),
        };
        let window = match (reading.between_s, &work.clock) {
            (None, _) => None,
            (between, Some(clock)) => clock.window(between, columns.len() - 1),
            (Some(_), None) => {
                return Err(Trouble::request("a stretch of time needs times")
                    .detail(name)
                    .with_hint("add --time COLUMN or --rate HZ"));
            }
        };
        if data.bias.is_some() {
            let Some(clock) = &work.clock else {
                return Err(
                    Trouble::request("a bias over time needs the times of the samples")
                        .detail(name)
                        .with_hint("add --time COLUMN or --rate HZ"),
                );
            };
            if let (None, Some([from, _])) = (clock.per_second, reading.between_s) {
                work.first_row = (from * clock.nominal).ceil().max(0.0) as u64;
            }
        }
        if !self.needs_times() && data.bias.is_none() {
            // Only filters care for gaps, and a bias for times.
            work.clock = None;
        }
        let mut reader = RowReader::new(source, layout, &columns)?
            .keep_text()
            .between(window);
        let size = reader.size().unwrap_or(0);
        while let Some(block) = reader.next_block()? {
            let origin = reader.window().and_then(|w| w.zero());
            work.block(Rc::new(block), origin, watch)?;
            watch.step("compensation", reader.bytes_read(), size)?;
        }
        work.end_of_stretch()?;
        let mut findings = reader.findings();
        findings.extend(exchanged);
        let Work {
            compensation,
            figures,
            steps,
            mut writer,
            clock,
            ..
        } = work;
        let rate = clock.as_ref().and_then(BlockClock::rate);
        if let Some(clock) = clock.filter(|_| self.needs_times()) {
            findings.extend(clock.doubts());
        }
        reading.time.rate_hz = rate.or(self.reading.rate);
        let recording = reader.finish()?.with_reading(reading);
        let kept = writer.file().is_none_or(|file| file.is_kept());
        let sha256 = kept.then(|| writer.sha256());
        if figures.written == 0 {
            return Err(about(Trouble::data(
                "nothing is left of the recording: no segment without a gap is as long as the filter",
            )
            .detail(format!("{} samples", figures.read)))
            .with_hint(match self.method {
                CompensationMethod::Filter(_) => "record for longer, or use --band for a constant matrix",
                _ => "record for longer, raise the corner of the low-pass, or widen --between",
            }));
        }
        match to {
            Destination::File { beside, .. } => {
                writer.settle()?;
                if let Some(sha256) = &sha256 {
                    let matrix = compensation.as_ref().and_then(|c| c.band());
                    let mut chain: Vec<String> =
                        matrix.map(outcome::matrix_applied).into_iter().collect();
                    chain.extend(steps.iter().flat_map(|s| s.figures.steps.iter().cloned()));
                    beside(std::slice::from_ref(&recording), sha256, &chain)?;
                }
                writer.commit()?;
            }
            Destination::Bytes(bytes) => *bytes = writer.into_bytes().unwrap_or_default(),
        }
        let headings = headings.into_iter().map(|(_, h)| h).collect();
        findings.extend(outcome::findings(
            &figures,
            compensation.as_ref(),
            calibration,
            steps.as_ref(),
        ));
        Ok(ApplyOutcome::new(
            self,
            (compensation.as_ref(), calibration),
            steps.map(|s| s.figures),
            figures,
            headings,
            (recording, sha256),
            findings,
        ))
    }
}

impl ApplyJob {
    /// Column of the temperature, and how it is read; what follows the temperature is not applied without it.
    fn thermometer(
        &self,
        calibration: &AnyCalibration,
        layout: &Layout,
    ) -> Result<Option<(usize, Thermometer)>> {
        let follows = match calibration {
            AnyCalibration::Constant(file) => file.temperature.as_ref(),
            _ => None,
        };
        match (follows, &self.temperature) {
            (None, None) => Ok(None),
            (None, Some(_)) => Err(Trouble::request(
                "a temperature is named, but the calibration does not follow it",
            )
            .with_hint(
                "leave --temperature out, or complete the calibration with `proofmass test temperature`",
            )),
            (Some(block), None) => Err(Trouble::request(
                "the calibration follows the temperature, and no column of temperatures is named",
            )
            .detail(format!(
                "it was measured from {:.1} to {:.1} °C",
                block.range[0], block.range[1]
            ))
            .with_hint("add --temperature COLUMN")),
            (Some(_), Some(column)) => Ok(Thermometer::asked(layout, Some(column))?),
        }
    }

    /// Whether a filter asks for the rate.
    fn needs_times(&self) -> bool {
        matches!(self.method, CompensationMethod::Filter(_)) || self.chain.low_pass.is_some()
    }

    /// What tells the times of the samples, which only a filter or a bias needs; a time column is added to those that are read.
    fn clock(&self, layout: &Layout, bias: bool, columns: &mut Vec<usize>) -> Result<Timed> {
        if !self.needs_times() && !bias && self.reading.between.is_none() {
            return Ok((None, None));
        }
        let reading = &self.reading;
        let time = match &reading.time {
            Some(column) => Some(layout.find(column)?),
            None if reading.rate.is_some() => None,
            None => layout.time_column(),
        };
        Ok(match (time, reading.rate) {
            (Some(index), rate) => {
                columns.push(index);
                let unit = ClockUnit::of(layout, index, reading.time_unit, rate, false)?;
                let clock = BlockClock::stamped(unit.per_second, rate);
                (Some(clock), Some((index, unit)))
            }
            (None, Some(rate)) => (Some(BlockClock::steady(rate)), None),
            (None, None) => (None, None),
        })
    }
}

/// What tells the times of the samples, and the column with its unit where one does.
type Timed = (Option<BlockClock>, Option<(usize, ClockUnit)>);

/// A recording on its way: rows wait for the samples that a filter completes.
struct Work<'a> {
    job: &'a ApplyJob,
    calibration: &'a AnyCalibration,
    /// The next column after the outputs is the temperature, which is read so.
    temperature: Option<Thermometer>,
    /// The columns after it are the other quantities of the surroundings, which are multiplied by these; then comes the time.
    environment: Vec<f64>,
    clock: Option<BlockClock>,
    /// Made at the first block, which tells the rate.
    compensation: Option<CompensationStream>,
    bias: Option<&'a TrackedBias>,
    /// What follows it, made with it; none where nothing follows.
    steps: Option<Steps<'a>>,
    /// Number of the next row that is read, where a rate tells the times.
    first_row: u64,
    /// Time of the column that counts as zero, s.
    origin: Option<f64>,
    factors: Vec<f64>,
    waiting: WaitingRows,
    figures: outcome::Figures,
    writer: Rewriter,
    name: String,
}

impl Work<'_> {
    fn block(&mut self, block: Rc<RowBlock>, origin: Option<f64>, watch: &dyn Watch) -> Result<()> {
        let time = self.time_column();
        let mut breaks = Vec::new();
        if let Some(clock) = self.clock.as_mut().filter(|c| c.per_second.is_some()) {
            breaks = clock.breaks(block.column(time)).map_err(|(row, what)| {
                Trouble::data(what)
                    .detail(format!("{}:{}", self.name, block.line(row)))
                    .with_hint("look for a restart of the clock or a doubled row, or give --rate in place of the time column")
            })?;
        }
        if self.compensation.is_none() {
            let rate = self.clock.as_ref().map(|c| c.nominal);
            let rate = rate.filter(|r| r.is_finite());
            let method = self.job.method;
            let made = CompensationStream::new(self.calibration, method, rate, watch)?;
            if self.bias.is_some() || !self.job.chain.is_empty() {
                let steps = Steps::new(&self.job.chain, self.bias, rate)
                    .map_err(|e| e.detail(self.name.clone()))?;
                self.waiting.keep_every(steps.every());
                self.steps = Some(steps);
            }
            let skip = made.half();
            self.compensation = Some(made);
            self.begin(skip);
        }
        if self.origin.is_none() && block.rows() > 0 {
            self.origin = origin.or_else(|| self.zero_of(&block));
        }
        let mut edges = vec![0];
        edges.extend(breaks.iter().copied().filter(|b| *b > 0));
        edges.push(block.rows());
        for (i, pair) in edges.windows(2).enumerate() {
            if i > 0 || breaks.first() == Some(&0) {
                self.figures.gaps += 1;
                self.end_of_stretch()?;
            }
            self.rows(&block, pair[0]..pair[1])?;
        }
        Ok(())
    }

    /// Where the times stand among the columns that are read.
    fn time_column(&self) -> usize {
        self.factors.len() + usize::from(self.temperature.is_some()) + self.environment.len()
    }

    /// Rows that follow one another without a gap.
    fn rows(&mut self, block: &Rc<RowBlock>, rows: Range<usize>) -> Result<()> {
        let mut scaled: Vec<Vec<f64>> = self
            .factors
            .iter()
            .enumerate()
            .map(|(i, factor)| block.scaled(i, rows.clone(), 0.0, *factor))
            .collect();
        self.figures.read += rows.len() as u64;
        let outputs = self.factors.len();
        let celsius = |t: Thermometer| block.scaled(outputs, rows.clone(), t.zero, t.factor);
        let temperature: Option<Vec<f64>> = self.temperature.map(celsius);
        if let (Some(temperature), AnyCalibration::Constant(file)) =
            (&temperature, self.calibration)
        {
            let beyond = self.figures.temperatures(file, temperature);
            if let (Some(row), OutOfRange::Refuse) = (beyond, self.job.out_of_range) {
                return Err(Trouble::data(
                    "a temperature is beyond the range in which the calibration was measured",
                )
                .detail(format!("{}:{}", self.name, block.line(rows.start + row)))
                .with_hint("sweep a larger range, or have such samples reported"));
            }
        }
        if let AnyCalibration::Constant(file) = self.calibration
            && !self.environment.is_empty()
        {
            let behind = self.time_column() - self.environment.len();
            let factors = self.environment.iter().enumerate();
            let around: Vec<Vec<f64>> = factors
                .map(|(k, factor)| block.scaled(behind + k, rows.clone(), 0.0, *factor))
                .collect();
            let beyond = self.figures.environment(file, &around);
            if let (Some((row, name)), OutOfRange::Refuse) = (beyond, self.job.out_of_range) {
                return Err(Trouble::data(format!(
                    "{name} is beyond the range in which the calibration was measured"
                ))
                .detail(format!("{}:{}", self.name, block.line(rows.start + row)))
                .with_hint("measure over a larger range, or have such samples reported"));
            }
            file.at_reference(&mut scaled, temperature.as_deref(), &around);
        }
        let slices: Vec<&[f64]> = scaled.iter().map(Vec::as_slice).collect();
        self.times(block, &rows);
        if let Some(compensation) = &mut self.compensation {
            let values = match &temperature {
                Some(temperature) => compensation.push_at(&slices, temperature),
                None => compensation.push(&slices),
            };
            self.waiting.wait(block, rows.clone());
            self.accept(values, Some((block, rows)))?;
        }
        Ok(())
    }

    /// Writes the waiting rows as far as their values are there.
    ///
    /// A calibration with a range gives its values at once: those of `rows`.
    fn accept(
        &mut self,
        mut values: Vec<Vec<f64>>,
        rows: Option<(&Rc<RowBlock>, Range<usize>)>,
    ) -> Result<()> {
        if values.first().is_some_and(|v| !v.is_empty()) {
            let slices: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
            let beyond = self.figures.count(self.calibration, &slices);
            if let (Some(row), OutOfRange::Refuse) = (beyond, self.job.out_of_range) {
                let line = rows.map(|(block, rows)| block.line(rows.start + row));
                let place = line.map_or(String::new(), |line| format!(":{line}"));
                return Err(Trouble::new(
                    TroubleKind::Data,
                    "a sample is beyond the range in which the calibration was tested",
                )
                .detail(format!("{}{place}", self.name))
                .with_hint("calibrate over a larger range, or have such samples reported"));
            }
        }
        if let Some(steps) = &mut self.steps {
            values = steps.push(values, &self.name)?;
        }
        self.waiting.accept(values);
        while let Some(ready) = self.waiting.take() {
            let slices: Vec<&[f64]> = ready.values.iter().map(Vec::as_slice).collect();
            self.figures.written += slices.first().map_or(0, |v| v.len() as u64);
            self.writer
                .every(&ready.block, ready.rows, ready.every, &slices)?;
        }
        Ok(())
    }

    /// Tells the steps the times of rows, where one of them subtracts a bias.
    fn times(&mut self, block: &Rc<RowBlock>, rows: &Range<usize>) {
        let column = self.time_column();
        let (Some(steps), Some(clock), true) = (&mut self.steps, &self.clock, self.bias.is_some())
        else {
            return;
        };
        let (first, zero) = (self.first_row, self.origin.unwrap_or(0.0));
        steps.rows(rows.clone().enumerate().map(|(i, row)| {
            let time = match clock.per_second {
                Some(scale) => block.column(column)[row] / scale - zero,
                None => (first + i as u64) as f64 / clock.nominal,
            };
            (time, block.line(row))
        }));
        self.first_row += rows.len() as u64;
    }

    /// Where the times of a recording count from: its first stamp, where that is far from zero.
    fn zero_of(&self, block: &RowBlock) -> Option<f64> {
        let scale = self.clock.as_ref()?.per_second?;
        let column = self.time_column();
        Some(proofmass_io::zero_of_times(block.column(column)[0] / scale))
    }

    /// A stretch begins, whose first rows have no value.
    fn begin(&mut self, skip: usize) {
        let skip = match &mut self.steps {
            Some(steps) => steps.begin(skip),
            None => skip,
        };
        self.waiting.begin(skip);
    }

    fn end_of_stretch(&mut self) -> Result<()> {
        let Some(compensation) = &mut self.compensation else {
            return Ok(());
        };
        let half = compensation.half();
        let rest = compensation.finish();
        self.accept(rest, None)?;
        self.begin(half);
        Ok(())
    }
}

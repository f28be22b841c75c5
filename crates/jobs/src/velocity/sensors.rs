//! The two sensors of an axis, from one file or two, on one time base.

use super::clock::{clock, counted, evened, holed, nothing, timed};
use super::offered::offered;
use super::reading::{NAMED, Reading, Samples};
use super::reference::Reference;
use super::turning::Turning;
use super::{AxisData, VelocityMap};
use crate::apply::calibration_of_band;
use crate::channels::by_option;
use crate::frequency_response::read_calibration;
use crate::record::Record;
use crate::recording::stretch;
use crate::store::Store;
use crate::stored_result::RESULT;
use crate::stream_choice::StreamChoice;
use crate::trouble::Trouble;
use proofmass_core::Watch;
use proofmass_documents::{AnyCalibration, CalibrationFile};
use proofmass_io::{
    Absent, ClockUnit, ColumnRef, Error, Input, Layout, LayoutOptions, RecordedColumn, Recording,
    RecordingOptions, SaidBy, Source as Bytes, TimeUnit, Unit,
};
use proofmass_motion::{
    LowCorner, MotionRecord, ReadingSource, Stamped, Timing, Ungapped, align, common_start,
    drop_glitches, drop_wild_accelerations, edge_places, even_clock, held, longest_stretch,
    mean_between, moves_while_still, thin, ungapped,
};
use proofmass_signal::AnyCompensation;
use proofmass_signal::saturation;
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// No axis moves faster, m/s or rad/s.
const FASTEST: f64 = 1e6;

/// What is left of the accelerations where more is missing than can be bridged: of an even clock a little, else all of three steps and more.
///
/// Rows in which a slower sensor stands several times are counted from one another, and not from a clock.
fn gaps(acceleration: &Samples, rows: &[f64]) -> Option<Ungapped> {
    let Samples { time, value } = acceleration;
    let stretch = longest_stretch(time);
    let used = stretch.as_ref().map_or(0..time.len(), |s| s.used.clone());
    match holed(time, rows) {
        Some(clock) if held(&value[used]).is_none() => ungapped(&clock, time),
        _ => stretch,
    }
}

/// A number as a person may have typed it, without hundreds of digits.
fn typed(number: f64) -> String {
    match number.abs() > FASTEST {
        true => format!("{number:e}"),
        false => number.to_string(),
    }
}

/// The two sensors of an axis: files in a store, columns, units, and what is known about the clocks.
///
/// Times are seconds, and count as those of the recording do: from the zero of its time column, from its first stamp where that
/// lies beyond 10⁵ s, and from the first row where a rate is stated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(default)]
#[non_exhaustive]
pub struct AxisSensors {
    /// Recording with the encoder or the wheel speed, and with the accelerometer unless that has its own file
    #[cfg_attr(feature = "clap", arg(value_hint = clap::ValueHint::FilePath))]
    pub recording: String,
    /// Encoder or wheel speed
    #[cfg_attr(feature = "clap", command(flatten))]
    pub reading: Reading,
    /// Gyroscope beside two wheels
    #[cfg_attr(feature = "clap", command(flatten))]
    pub turning: Turning,
    /// Column of the acceleration or of a calibrated output; x,y,z with a calibration of three axes; none for an encoder alone
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "COLUMN", value_delimiter = ',')
    )]
    pub acceleration: Vec<String>,
    /// Unit of the acceleration, where the heading does not say it: m/s², mm/s², g, mg, …
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub acceleration_unit: Option<Unit>,
    /// File of the accelerometer, when it has its own; its clock must be that of the recording
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath))]
    pub acceleration_file: Option<String>,
    /// Stream of that file, where it holds several; it may be the same file as the recording
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "NAME", requires = "acceleration_file")
    )]
    pub acceleration_source: Option<String>,
    /// Time column of the accelerometer's file, where no heading names it
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "COLUMN", requires = "acceleration_file")
    )]
    pub acceleration_time: Option<String>,
    /// Sampling rate of the accelerometer's file in hertz, when that has no time column
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "HZ", requires = "acceleration_file")
    )]
    pub acceleration_rate: Option<f64>,
    /// Calibration of the accelerometer (calibration.json, or result.json of a test of one axis): compensates the acceleration first,
    /// and its uncertainty of the gain is the prior of the gain
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath))]
    pub calibration: Option<String>,
    /// Calibration over frequency, as of a shaker: the band in hertz whose constant is used; one frequency twice is that alone
    #[cfg_attr(feature = "clap", arg(long, value_name = "LOW,HIGH", value_parser = crate::arguments::stretch, requires = "calibration"))]
    pub calibration_band: Option<[f64; 2]>,
    /// Axis of the compensated accelerometer that lies along the motion, where the calibration has three
    #[cfg_attr(feature = "clap", arg(long, value_enum, requires = "calibration"))]
    pub axis: Option<SensorAxis>,
    /// Standard uncertainty of the accelerometer's gain, per cent, from a calibration or data sheet (limits of ± 5 % are 2.9);
    /// the gain is then estimated, with this as its prior
    #[cfg_attr(feature = "clap", arg(long, value_name = "PERCENT"))]
    pub gain_uncertainty: Option<f64>,
    /// Frequency below which the accelerometer shows less (3 dB), as of a piezoelectric one or an AC coupling, Hz; slow accelerations are
    /// given back. Without it a corner is looked for beside positions
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ"))]
    pub low_corner: Option<f64>,
    /// Its standard uncertainty, Hz
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "HZ", requires = "low_corner")
    )]
    pub low_corner_uncertainty: Option<f64>,
    /// Stages of first order with that corner: 1, where nothing is said, or 2
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", requires = "low_corner"))]
    pub low_corner_order: Option<u8>,
    /// Time by which the accelerometer is later than the encoder, s; it is shifted back by it
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "SECONDS",
            default_value_t = 0.0,
            allow_negative_numbers = true
        )
    )]
    pub latency: f64,
    /// Interval at rest, in seconds: its mean acceleration is the offset that is removed
    #[cfg_attr(feature = "clap", arg(long, value_name = "FROM,TO", value_parser = crate::arguments::stretch))]
    pub still: Option<[f64; 2]>,
    /// Use the rows from one time on and before another, in seconds
    #[cfg_attr(
        feature = "clap",
        arg(long, num_args = 2, value_names = ["FROM", "TO"], allow_negative_numbers = true)
    )]
    pub between: Option<Vec<f64>>,
    /// Map of the encoder that is subtracted from the positions: result.json of `proofmass velocity map`
    #[cfg_attr(feature = "clap", arg(long, value_name = "RESULT", value_hint = clap::ValueHint::FilePath))]
    pub encoder_map: Option<String>,
    /// The axis stands still at the first sample
    #[cfg_attr(feature = "clap", arg(long))]
    pub at_rest: bool,
    /// Velocity at the first sample that is used, m/s (rad/s of an angle) [default: that of the first readings]
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "M/S",
            allow_negative_numbers = true,
            conflicts_with = "at_rest"
        )
    )]
    pub initial_velocity: Option<f64>,
    /// Its standard uncertainty, m/s (rad/s of an angle) [default: 0, exact]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "M/S", requires = "initial_velocity")
    )]
    pub initial_velocity_uncertainty: Option<f64>,
    /// Time column by name or number
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLUMN"))]
    pub time: Option<String>,
    /// Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with --rate)
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    pub time_unit: Option<TimeUnit>,
    /// Sampling rate in hertz, for recordings without a time column
    #[cfg_attr(feature = "clap", arg(long, value_name = "HZ"))]
    pub rate: Option<f64>,
    /// Which stream of the recording.
    #[serde(flatten)]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub choice: StreamChoice,
}

/// A calibration of the accelerometer as this recording uses it.
struct Calibrated {
    file: CalibrationFile,
    model: AnyCompensation,
    /// Which of its axes lies along the motion.
    axis: usize,
    /// Relative standard uncertainty of the scale factor of that axis, where it is stated.
    gain: Option<f64>,
    place: String,
    input: Input,
    findings: Vec<Finding>,
}

/// One axis of a triaxial sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum SensorAxis {
    /// First of the three
    X,
    /// Second
    Y,
    /// Third
    Z,
}

impl SensorAxis {
    /// 0, 1, 2 for x, y, z.
    pub(super) fn index(self) -> usize {
        self as usize
    }
}

/// Unit of a column by its heading or by an option, which must not contradict each other.
pub(super) fn stated_unit(
    recording: &Recording,
    column: &RecordedColumn,
    (given, option): (Option<Unit>, &str),
) -> Result<Option<Unit>, Trouble> {
    match (column.unit, given) {
        (Some(heading), Some(given)) if heading != given => Err(Trouble::data(format!(
            "column {:?} is in {heading} by its heading, in {given} by {option}",
            column.name
        ))
        .detail(recording.path.display().to_string())
        .with_hint(format!("remove {option}, or correct the heading"))),
        (heading, given) => Ok(heading.or(given)),
    }
}

/// Neither heading nor option tells the unit.
pub(super) fn unknown_unit(recording: &Recording, column: &RecordedColumn, hint: &str) -> Trouble {
    Trouble::data(format!("the unit of column {:?} is not known", column.name))
        .detail(recording.path.display().to_string())
        .with_hint(hint)
}

/// An error about a file beside the recording, whose clock has options of its own.
fn of_second(error: Error, of: &str) -> Trouble {
    let hint = error.hint().map(|hint| {
        hint.replace("--rate", &format!("--{of}-rate"))
            .replace("--time COLUMN", &format!("--{of}-time COLUMN"))
    });
    match hint {
        Some(hint) => error.with_hint(hint).into(),
        None => error.into(),
    }
}

/// Both sensors of an axis in SI on one time base, as a store held them.
#[derive(Clone, Debug)]
pub struct AxisRecordings {
    /// Both sensors.
    pub(super) record: MotionRecord,
    /// Zero of the times below in the clock of the recording, s: its first row.
    pub(super) origin: f64,
    /// Time of the first sample after that, s.
    pub(super) start: f64,
    /// First and last time of what was recorded, s, where gaps leave a part of it.
    recorded: Option<[f64; 2]>,
    /// Whether it is an angle: rad in place of m.
    pub(super) angular: bool,
    /// Way or angle of one turn of the encoder, where it is known and no map was subtracted.
    turn: Option<f64>,
    /// What was stated of the encoder, in words.
    encoder: Option<String>,
    /// Latency of the accelerometer that was stated, s.
    latency: f64,
    /// Reference velocity per sample, m/s or rad/s.
    pub(super) reference: Option<Vec<f64>>,
    /// Files with their digests.
    inputs: Vec<Input>,
    /// What to doubt about the files.
    pub(super) findings: Vec<Finding>,
    /// The recording in messages and titles.
    name: String,
}

impl AxisRecordings {
    /// The data as the jobs want them.
    pub fn data(&self) -> AxisData<'_> {
        AxisData {
            record: &self.record,
            start: self.origin + self.start,
            recorded: self.recorded,
            angular: self.angular,
            turn: self.turn,
            encoder: self.encoder.as_deref(),
            latency: self.latency,
            reference: self.reference.as_deref(),
            findings: &self.findings,
            name: &self.name,
        }
    }

    /// What a result is filed with.
    pub fn record(&self, date: Option<String>) -> Record {
        Record {
            date,
            inputs: self.inputs.clone(),
            ..Record::default()
        }
    }
}

impl AxisSensors {
    /// Names of the files that are read.
    pub fn files(&self) -> Vec<&str> {
        let second = self.acceleration_file.as_deref();
        std::iter::once(self.recording.as_str())
            .chain(second)
            .chain(self.calibration.as_deref())
            .chain(self.encoder_map.as_deref())
            .collect()
    }

    /// Reads both sensors and, where one is asked for, the reference.
    ///
    /// # Errors
    /// A file or column that is not there or cannot be read, units that do not fit, clocks without a common stretch.
    pub fn load(
        &self,
        store: &dyn Store,
        reference: Option<&Reference>,
        watch: &dyn Watch,
    ) -> Result<AxisRecordings, Trouble> {
        watch.step("reading", 0, 0)?;
        let between = stretch(self.between.as_deref())?;
        for (name, value) in [("--latency", Some(self.latency)), ("--rate", self.rate)] {
            if value.is_some_and(|v| !v.is_finite()) {
                return Err(Trouble::data(format!("{name} must be a finite number")));
            }
        }
        if let Some(u) = self.gain_uncertainty.filter(|u| !(*u > 0.0 && *u <= 100.0)) {
            return Err(Trouble::request(format!(
                "--gain-uncertainty {u} is no standard uncertainty in per cent"
            ))
            .with_hint("limits of ± 5 % are a standard uncertainty of 2.9; leave it out where nothing is known"));
        }
        let start = self.start()?;
        let resting = !self.reading.is_named() && !self.acceleration.is_empty();
        if resting && self.still.is_none() {
            return Err(Trouble::data(
                "an accelerometer alone drifts: an interval at rest is needed, and no position or speed is named",
            )
            .with_hint(self.hint("add --still FROM,TO, or --position COLUMN or --speed COLUMN", store)?));
        }
        let mut columns = match resting {
            true => Vec::new(),
            false if !self.reading.is_named() => {
                return Err(Trouble::data("no column of a position or a speed is named")
                    .with_hint(self.hint(NAMED, store)?));
            }
            false => self.reading.columns()?,
        };
        let of_reading = columns.len();
        let calibrated = match self.acceleration.is_empty() {
            true => None,
            false => self.calibration(store)?,
        };
        let of_acceleration = self.acceleration_columns(calibrated.as_ref().map(|c| &c.file))?;
        let alone = of_acceleration.is_empty();
        let together = self.acceleration_file.is_none();
        if together {
            columns.extend(of_acceleration.iter().cloned());
        }
        let of_yaw = columns.len();
        columns.extend(self.turning.column());
        let with_reference = reference.filter(|r| r.file.is_none());
        columns.extend(with_reference.map(|r| ColumnRef::from_word(&r.column)));
        let mut absent = vec![Absent::EmptyOrNan; columns.len()];
        if together {
            absent[of_reading..of_reading + of_acceleration.len()].fill(Absent::Empty);
        }
        let mut source = self.choice.stream_of(store.open(&self.recording)?);
        let one_file = together && reference.is_none_or(|r| r.file.is_none());
        let (mut options, mut lacking) =
            self.options(&mut source, true, columns, self.time.as_deref(), self.rate)?;
        if !lacking && !one_file {
            // What this heading says, another file may lack.
            options.time_unit = None;
        }
        let mut main = Recording::from_source_sparse(source, &options, &absent)?;
        for column in 0..of_reading {
            // With a scale the unit is that to which it leads; counts are said by what a turn or a metre has of them.
            match (self.reading.scale, self.reading.unit) {
                (Some(scale), Some(unit)) => main.state_scale_of(column, scale, unit),
                (None, unit) => main
                    .state_unit(column, unit, SaidBy::Person)
                    .map_err(|e| by_option(e, Some("--unit")))?,
                _ => {}
            }
            let index = self.reading.index.is_some() && column + 1 == of_reading;
            let logic = index || self.reading.is_level();
            let volts = main.columns[column].unit.map(|u| u.si().0) == Some(Unit::Volt);
            let counts = self.reading.increment().map(|_| Unit::Count);
            main.state_unit(column, counts.filter(|_| !(logic && volts)), SaidBy::Person)?;
        }
        if together {
            for column in of_reading..of_yaw {
                main.state_unit(column, self.acceleration_unit, SaidBy::Person)
                    .map_err(|e| by_option(e, Some("--acceleration-unit")))?;
            }
        }
        if self.turning.yaw_rate.is_some() {
            main.state_unit(of_yaw, self.turning.yaw_rate_unit, SaidBy::Person)?;
        }
        if let Some(reference) = with_reference {
            let last = main.columns.len() - 1;
            reference.state_unit(&mut main, last)?;
        }
        let mut inputs = vec![main.input()];
        let mut findings = main.findings().to_vec();
        if self.reading.edges() {
            // Edges come when they come.
            findings.retain(|f| f.code() != "gaps-in-record");
        }
        // Seconds since an epoch leave a double too few digits for a step.
        let origin = main.time.seconds(0);
        // What is asked for in times of the recording, in those from its first row.
        let from_start = |[from, to]: [f64; 2]| [from - origin, to - origin];
        let still = self.still.map(from_start);
        let mut clock = clock(&main, &main, origin, self.reading.edges());

        let angular = self.reading.angular
            || (alone && self.reading.turn().is_none() && self.reading.turns(&main)?);
        let told = Reading {
            angular,
            ..self.reading.clone()
        };
        let mut reading = match resting {
            true => Samples::default(),
            false => told.decode(&main, &clock, &mut findings)?,
        };
        reading.value.iter_mut().for_each(|r| *r *= told.sense());
        let rows = together && !resting && !self.reading.edges() && !self.reading.is_modulated();
        if rows && told.source() == ReadingSource::Position {
            findings.extend(evened(&mut clock, &mut reading));
        }
        if self.turning.yaw_rate.is_some() {
            let about = &self.turning;
            findings.extend(about.findings(&self.reading, &main, &clock, of_yaw)?);
        } else {
            findings.extend(self.reading.departures(&main, &clock)?);
        }
        // Edges as counts after each, in increments.
        let increment = told
            .increment()
            .filter(|_| self.reading.edges() && !resting);
        if let Some(increment) = increment {
            let (edges, lost) = counted(&reading, increment, self.reading.is_level());
            reading = edges;
            findings.extend(lost);
        }
        let digit = match told.source() {
            ReadingSource::Speed if !resting && !self.reading.edges() => reading
                .speed_digits(&mut findings)
                .map_err(|e| Trouble::from(e).detail(self.recording.clone()))?,
            _ => None,
        };
        if let Some(map) = &self.encoder_map {
            if resting || self.reading.speed.is_some() {
                return Err(Trouble::request(
                    "an encoder map is subtracted from positions, and none are named",
                )
                .with_hint("add --position COLUMN, or leave out --encoder-map"));
            }
            // The folder that a command wrote stands for its result.
            let inside = format!("{map}/{RESULT}");
            let name = if store.holds(&inside) { &inside } else { map };
            let (map, input) = VelocityMap::read(store.open(name)?, angular)?;
            inputs.push(input);
            if let Some(increment) = increment {
                edge_places(&mut reading.value, increment);
            }
            reading.value.iter_mut().for_each(|r| *r -= map.error(*r));
        }
        let mut rows_of_acceleration = clock.clone();
        let mut acceleration = match &self.acceleration_file {
            None if alone && self.reading.is_modulated() => nothing(&reading.time, false),
            None if alone => nothing(&clock, self.reading.edges()),
            None => self.accelerations(calibrated.as_ref(), &main, &clock, of_reading)?,
            Some(name) => {
                let stream = self.acceleration_source.as_deref();
                let mut source = store.open(name)?.with_stream(stream, self.choice.raw);
                let (options, lacks) = self.options(
                    &mut source,
                    false,
                    of_acceleration.clone(),
                    self.acceleration_time.as_deref(),
                    self.acceleration_rate,
                )?;
                lacking |= lacks;
                let absent = vec![Absent::Empty; of_acceleration.len()];
                let mut other = Recording::from_source_sparse(source, &options, &absent)
                    .map_err(|e| of_second(e, "acceleration"))?;
                for column in 0..absent.len() {
                    other
                        .state_unit(column, self.acceleration_unit, SaidBy::Person)
                        .map_err(|e| by_option(e, Some("--acceleration-unit")))?;
                }
                findings.extend(other.findings().iter().cloned());
                inputs.push(other.input());
                let own = super::clock::clock(&other, &main, origin, false);
                let accelerations = self.accelerations(calibrated.as_ref(), &other, &own, 0)?;
                rows_of_acceleration = own;
                accelerations
            }
        };
        for t in &mut acceleration.time {
            *t -= self.latency;
        }
        if let Some([from, to]) = still {
            let (first, last) = (acceleration.time.first(), acceleration.time.last());
            if let (true, Some(first), Some(last)) = (resting, first, last)
                && *first >= from
                && *last <= to
            {
                // Digits that a clock counted from zero has, without those of its sum.
                let shown = |t: f64| (1e6 * (t + origin)).round() / 1e6;
                return Err(Trouble::request(format!(
                    "the interval at rest, {} s to {} s, leaves no other sample to estimate from",
                    shown(from),
                    shown(to)
                ))
                .detail(self.recording.clone())
                .with_hint(format!(
                    "end --still before the last sample, {} s",
                    shown(*last)
                )));
            }
            let offset = mean_between(&acceleration.time, &acceleration.value, from, to)
                .ok_or_else(|| {
                    Trouble::data(format!(
                        "no sample lies in the interval at rest, {} s to {} s",
                        from + origin,
                        to + origin
                    ))
                    .detail(self.recording.clone())
                })?;
            let stretch = acceleration.within(from, to);
            findings.extend(moves_while_still(&stretch));
            acceleration.value.iter_mut().for_each(|a| *a -= offset);
            if resting {
                // The rest is the reading; times without one are taken out again below.
                reading = Samples {
                    value: vec![0.0; acceleration.time.len()],
                    time: acceleration.time.clone(),
                };
            }
        }
        if let Some(asked) = between {
            let [from, to] = from_start(asked);
            acceleration.keep(|t| t >= from && t < to);
            if acceleration.time.len() < 2 {
                let last = main.time.seconds(main.samples().max(1) - 1);
                return Err(Trouble::request(format!(
                    "no row lies between {} s and {} s; the last time is {last} s",
                    asked[0], asked[1]
                ))
                .detail(self.recording.clone())
                .with_hint("give another --between FROM TO; `proofmass inspect` shows the times"));
            }
            for reading in inputs.iter_mut().filter_map(|input| input.reading.as_mut()) {
                reading.between_s = between;
            }
        }
        let mut recorded = None;
        if let Some(gaps) = gaps(&acceleration, &rows_of_acceleration) {
            let Samples { time, value } = &mut acceleration;
            recorded = Some([time[0] + origin, time[time.len() - 1] + origin]);
            if let (Some(_), true) = (start, gaps.used.start > 0) {
                return Err(Trouble::request(format!(
                    "the velocity at the first sample is stated, and a gap makes {} s the first sample that is used",
                    time[gaps.used.start] + origin
                ))
                .detail(self.recording.clone())
                .with_hint("add --between FROM TO, a stretch without the gap, and state the velocity at FROM, or leave --initial-velocity or --at-rest out"));
            }
            *time = time[gaps.used.clone()].to_vec();
            *value = value[gaps.used.clone()].to_vec();
            findings.push(gaps.finding);
        }

        if let Some(found) = held(&acceleration.value) {
            let Samples { time, value } = &mut acceleration;
            let every = |list: &[f64]| {
                let new = list.iter().skip(found.first).step_by(found.rows);
                new.copied().collect()
            };
            (*time, *value) = (every(time), every(value));
            let all = (time.len().max(2) - 1) as f64;
            let rate = all / (time[time.len() - 1] - time[0]);
            findings.push(found.finding(rate));
        }

        if !alone {
            let consequence = "the velocity misses what was cut off until the next readings";
            let value = &acceleration.value;
            findings.extend(saturation::clipped("the accelerometer", value, consequence));
        }
        let stated_start = start;
        let (mut record, start) =
            self.common(&reading, &acceleration, &rows_of_acceleration, resting)?;
        if let (true, Some([from, to])) = (resting, still) {
            for (k, r) in record.reading.iter_mut().enumerate() {
                let t = start + record.sample_time * k as f64;
                *r = r.filter(|_| t >= from && t <= to);
            }
            record.check()?;
        }
        record.accelerometer = !alone;
        record.start = start;
        if let Some(finding) = record.hole_finding(origin + start) {
            // What the clocks say of them is less.
            findings.retain(|f| f.code() != "gaps-in-record");
            findings.push(finding);
        }
        record.turn = told.resolver_turn();
        record.low_corner = self.corner(&record, resting)?;
        let stated = self.gain_uncertainty.map(|percent| 0.01 * percent);
        record.gain_uncertainty = stated.or(calibrated.as_ref().and_then(|c| c.gain));
        if let Some(calibrated) = &calibrated {
            inputs.push(calibrated.input.clone());
            findings.extend(calibrated.findings.iter().cloned());
            findings.extend(crate::findings::taken_at_reference(&calibrated.file));
        }
        record.increment = told.increment().filter(|_| !self.reading.edges()).or(digit);
        if let (Some(increment), None) = (increment, &self.encoder_map) {
            record = timed(&record, &reading, increment, start)
                .map_err(|e| Trouble::from(e).detail(self.recording.clone()))?;
        }
        if let Some((velocity, uncertainty)) = stated_start {
            record.start_at(velocity, uncertainty)?;
        }
        if self.reading.is_analogue() && !resting && told.source() == ReadingSource::Position {
            findings.extend(thin(&mut record));
        }
        if !resting && !self.reading.edges() {
            findings.extend(drop_glitches(&mut record));
            findings.extend(drop_wild_accelerations(&mut record));
        }
        // The mean of several wheels has no turn of its own.
        let own_turns = told.position.as_ref().is_none_or(|p| p.len() == 1);
        let mut bench = AxisRecordings {
            record,
            origin,
            start,
            recorded,
            angular,
            turn: told
                .turn()
                .filter(|_| own_turns && self.encoder_map.is_none()),
            encoder: self.reading.stated(),
            latency: self.latency,
            reference: None,
            inputs,
            findings,
            name: store.describe(&self.recording).display().to_string(),
        };
        if let Some(reference) = reference {
            let samples = match &reference.file {
                None => reference.samples(&main, &clock, main.columns.len() - 1, angular)?,
                Some(name) => {
                    let column = ColumnRef::from_word(&reference.column);
                    let time = reference.time.as_deref();
                    let mut source = store.open(name)?;
                    let (options, lacks) =
                        self.options(&mut source, false, vec![column], time, reference.rate)?;
                    lacking |= lacks;
                    let absent = [Absent::EmptyOrNan];
                    let mut other = Recording::from_source_sparse(source, &options, &absent)
                        .map_err(|e| of_second(e, "reference"))?;
                    reference.state_unit(&mut other, 0)?;
                    bench.inputs.push(other.input());
                    let own = super::clock::clock(&other, &main, origin, false);
                    reference.samples(&other, &own, 0, angular)?
                }
            };
            reference.attach(&mut bench, &samples)?;
        }
        // No file needed it: it holds for the first, whose heading it must not contradict.
        if let (Some(_), false, None) = (self.time_unit, lacking, self.rate) {
            let named = self.time.as_deref().map(ColumnRef::from_word);
            let named = named.and_then(|column| main.layout.find(&column).ok());
            if let Some(index) = named.or_else(|| main.layout.time_column()) {
                ClockUnit::of(&main.layout, index, self.time_unit, None, false)
                    .map_err(|e| e.at(&main.path))?;
            }
        }
        Ok(bench)
    }

    /// What to do where no column is named, with the columns that there are.
    fn hint(&self, todo: &str, store: &dyn Store) -> Result<String, Trouble> {
        let source = self.choice.stream_of(store.open(&self.recording)?);
        Ok(format!("{todo}; {}", offered(source)?))
    }

    /// The velocity at the first sample with its standard uncertainty, where it is stated.
    fn start(&self) -> Result<Option<(f64, f64)>, Trouble> {
        let uncertainty = self.initial_velocity_uncertainty;
        let Some(velocity) = self.initial_velocity else {
            if uncertainty.is_some() {
                return Err(Trouble::request(
                    "--initial-velocity-uncertainty is about a velocity that is not stated",
                )
                .with_hint("add --initial-velocity M/S"));
            }
            return Ok(self.at_rest.then_some((0.0, 0.0)));
        };
        if self.at_rest {
            return Err(Trouble::request(
                "--at-rest and --initial-velocity both state the velocity at the first sample",
            )
            .with_hint("leave one of them out"));
        }
        if !(velocity.abs() <= FASTEST) {
            return Err(Trouble::request(format!(
                "--initial-velocity {} is no velocity",
                typed(velocity)
            ))
            .with_hint("give metres per second (rad/s of an angle)"));
        }
        let u = uncertainty.unwrap_or(0.0);
        if !(0.0..=FASTEST).contains(&u) {
            return Err(Trouble::request(format!(
                "--initial-velocity-uncertainty {} is no standard uncertainty",
                typed(u)
            ))
            .with_hint("give metres per second (rad/s of an angle), zero or more; leave the velocity out where it is not known"));
        }
        Ok(Some((velocity, u)))
    }

    /// The corner that is stated.
    fn corner(&self, record: &MotionRecord, resting: bool) -> Result<Option<LowCorner>, Trouble> {
        let Some(frequency) = self.low_corner else {
            return Ok(None);
        };
        // An offset behind the corner that is off by b makes a velocity that is off by π f b t²: nothing tells how large b is.
        if resting {
            return Err(Trouble::request(
                "--low-corner needs readings of position or speed beside the accelerometer: alone, how far its velocity drifts is not known",
            )
            .with_hint("add --position COLUMN or --speed COLUMN, or leave --low-corner out for motions much faster than it"));
        }
        let u = self.low_corner_uncertainty.unwrap_or(0.0);
        let corner = LowCorner::new(frequency, u, self.low_corner_order.unwrap_or(1));
        let corner = corner.map_err(|e| {
            Trouble::from(e).with_hint("--low-corner HZ is above zero, --low-corner-uncertainty less than half of it, --low-corner-order 1 or 2")
        })?;
        let highest = LowCorner::highest(record.sample_time);
        if frequency > highest {
            return Err(Trouble::request(format!(
                "--low-corner {frequency} Hz lies above {highest} Hz, a twentieth of the sampling rate"
            ))
            .with_hint("state the lower of the two corners of the accelerometer, in Hz"));
        }
        // Of a velocity that lasts T it takes 2πf T: less than a ten-thousandth does not show beside its noise.
        let duration = record.sample_time * record.reading.len() as f64;
        let lowest = 1e-5 / duration;
        if frequency < lowest {
            return Err(Trouble::request(format!(
                "--low-corner {frequency:e} Hz takes nothing in {duration:.3} s: below {lowest:.1e} Hz it does not show"
            ))
            .with_hint("leave --low-corner out"));
        }
        Ok(Some(corner))
    }

    /// The calibration of the accelerometer, that of a band where it is one over frequency.
    fn calibration(&self, store: &dyn Store) -> Result<Option<Calibrated>, Trouble> {
        let Some(name) = &self.calibration else {
            return Ok(None);
        };
        let place = store.describe(name).display().to_string();
        let (any, input, findings) = read_calibration(store.open(name)?, None)?;
        let file = match (any, self.calibration_band) {
            (AnyCalibration::Constant(file), None) => *file,
            (AnyCalibration::FrequencyResponse(_), None) => {
                return Err(Trouble::request(
                    "the calibration is one over frequency: no single constant stands for all of it",
                )
                .detail(place)
                .with_hint("add --calibration-band LOW,HIGH, the frequencies of the motion"));
            }
            (any, Some(band)) => {
                calibration_of_band(&any, band)
                    .map_err(|e| e.detail(place.clone()))?
                    .0
            }
            _ => return Err(Trouble::request("a calibration of an unknown kind").detail(place)),
        };
        let model = file.compensation()?;
        let axis = match self.axis {
            Some(SensorAxis::X) | None => 0,
            Some(SensorAxis::Y) => 1,
            Some(SensorAxis::Z) => 2,
        };
        let scale = match file.axes() {
            1 => "scale".to_owned(),
            _ => format!("scale.{}", ["x", "y", "z"][axis]),
        };
        let gain = file
            .estimate
            .get(&scale)
            .map(|q| q.standard_uncertainty / q.value.abs());
        let gain = gain.filter(|u| *u > 0.0 && u.is_finite());
        if gain.is_some() && self.gain_uncertainty.is_some() {
            return Err(Trouble::request(
                "the calibration and --gain-uncertainty both state how well the gain is known",
            )
            .detail(place)
            .with_hint("leave out --gain-uncertainty: the calibration was measured"));
        }
        Ok(Some(Calibrated {
            file,
            model,
            axis,
            gain,
            place,
            input,
            findings,
        }))
    }

    fn acceleration_columns(
        &self,
        calibration: Option<&CalibrationFile>,
    ) -> Result<Vec<ColumnRef>, Trouble> {
        if self.acceleration.is_empty() {
            let in_vain = [
                (self.acceleration_file.is_some(), "--acceleration-file"),
                (self.acceleration_source.is_some(), "--acceleration-source"),
                (self.calibration.is_some(), "--calibration"),
                (self.still.is_some(), "--still"),
                (self.latency != 0.0, "--latency"),
                (self.gain_uncertainty.is_some(), "--gain-uncertainty"),
                (self.low_corner.is_some(), "--low-corner"),
            ];
            if let Some((_, option)) = in_vain.iter().find(|(given, _)| *given) {
                return Err(Trouble::data(format!(
                    "{option} is about an accelerometer, and none is named"
                ))
                .with_hint("add --acceleration COLUMN"));
            }
            return Ok(Vec::new());
        }
        let needed = calibration.map_or(1, CalibrationFile::axes);
        if self.acceleration.len() != needed {
            let (of, hint) = match calibration {
                None => (
                    String::new(),
                    "one column along the motion, or three columns x,y,z together with --calibration and --axis",
                ),
                Some(file) if file.axes() == 1 => (
                    ", and the calibration is of one axis".to_owned(),
                    "name the one column that was calibrated",
                ),
                Some(file) => (
                    format!(", and the calibration is of {} axes", file.axes()),
                    "name the columns x,y,z, or use a calibration of the one axis",
                ),
            };
            return Err(Trouble::data(format!(
                "--acceleration names {}{of}",
                match self.acceleration.len() {
                    1 => "one column".to_owned(),
                    n => format!("{n} columns"),
                }
            ))
            .with_hint(hint));
        }
        match (calibration.map_or(1, CalibrationFile::axes), self.axis) {
            (3, None) => {
                return Err(Trouble::request(
                    "which axis of the calibration lies along the motion is not said",
                )
                .with_hint("add --axis x, y or z"));
            }
            (1, Some(_)) => {
                return Err(Trouble::request(
                    "--axis names an axis of three, and the calibration is of one",
                )
                .with_hint("leave out --axis"));
            }
            _ => {}
        }
        Ok(self
            .acceleration
            .iter()
            .map(|name| ColumnRef::from_word(name))
            .collect())
    }

    /// How a file is read, and whether it lacks the unit of its times.
    fn options(
        &self,
        source: &mut Bytes,
        main: bool,
        columns: Vec<ColumnRef>,
        time: Option<&str>,
        rate: Option<f64>,
    ) -> Result<(RecordingOptions, bool), Trouble> {
        let time = time.map(ColumnRef::from_word);
        // --time-unit is for headings that do not say it; one of several files may.
        let layout = Layout::of(source, &LayoutOptions::default())?;
        let at = match &time {
            Some(column) => Some(
                layout
                    .find(column)
                    .map_err(|e| Trouble::from(e).detail(source.name().display().to_string()))?,
            ),
            None => layout.time_column(),
        };
        let told = at.is_some_and(|i| layout.unit(i).is_some_and(Unit::is_time));
        // Beside a rate the times are not read, but where they count the rows.
        let read = rate.is_none() || self.time_unit == Some(TimeUnit::Index);
        let options = RecordingOptions {
            layout: LayoutOptions::default(),
            columns,
            time,
            time_unit: self.time_unit.filter(|_| read && (main || !told)),
            sampling_rate_hz: rate,
            events: self.reading.edges() && main,
            ..RecordingOptions::default()
        };
        Ok((options, at.is_some() && !told && read))
    }

    /// Acceleration along the motion in m/s², where the file holds one.
    fn accelerations(
        &self,
        calibrated: Option<&Calibrated>,
        recording: &Recording,
        clock: &[f64],
        first: usize,
    ) -> Result<Samples, Trouble> {
        let columns = &recording.columns[first..first + self.acceleration.len()];
        let missing: Vec<&[usize]> = (first..first + columns.len())
            .map(|i| recording.missing(i))
            .collect();
        let unit = |i: usize| -> Result<Unit, Trouble> {
            let given = (self.acceleration_unit, "--acceleration-unit");
            stated_unit(recording, &columns[i], given)?.ok_or_else(|| {
                let index = recording.reading().columns[first + i].number - 1;
                let asked = [(index, "--acceleration-unit")];
                Trouble::from(recording.layout.ask_units(&asked).at(&recording.path))
            })
        };
        let value: Vec<f64> = match calibrated {
            None => {
                let unit = unit(0)?;
                if !unit.is_acceleration() {
                    return Err(Trouble::data(format!(
                        "column {:?} is in {unit}, which is no acceleration",
                        columns[0].name
                    ))
                    .with_hint("raw outputs need their gain: --calibration FILE, the result of a test of this axis or a calibration.json (--axis x where it has three)"));
                }
                let factor = unit.si().1 / self.reading.lever()?;
                columns[0].data.iter().map(|v| factor * v).collect()
            }
            Some(calibrated) => {
                let file = &calibrated.file;
                let mut outputs = Vec::with_capacity(columns.len());
                for (i, column) in columns.iter().enumerate() {
                    let (si, factor) = unit(i)?.si();
                    if si != file.input_unit {
                        return Err(Trouble::data(format!(
                            "column {:?} is in {si}, the calibration takes {}",
                            column.name, file.input_unit
                        ))
                        .detail(calibrated.place.clone()));
                    }
                    outputs.push(column.data.iter().map(|v| factor * v).collect::<Vec<f64>>());
                }
                let outputs: Vec<&[f64]> = outputs.iter().map(Vec::as_slice).collect();
                let to_si = file.output_unit.si().1 / self.reading.lever()?;
                let mut compensated = calibrated.model.apply_columns(&outputs, None);
                let along = compensated.swap_remove(calibrated.axis);
                along.into_iter().map(|a| to_si * a).collect()
            }
        };
        Ok(Samples::present(clock, &value, &missing))
    }

    /// Both sensors on the clock of the accelerometer.
    fn common(
        &self,
        reading: &Samples,
        acceleration: &Samples,
        rows: &[f64],
        resting: bool,
    ) -> Result<(MotionRecord, f64), Trouble> {
        let source = match resting {
            true => ReadingSource::Speed,
            false => self.reading.source(),
        };
        let timing = if self.reading.edges() {
            Timing::Edges
        } else {
            Timing::Sampled
        };
        let time = &acceleration.time;
        let step = even_clock(time).or_else(|| holed(time, rows).map(|clock| clock.step));
        let start = common_start(source, &reading.time, &acceleration.time);
        let record = align(
            source,
            Stamped {
                time: &reading.time,
                value: &reading.value,
            },
            Stamped {
                time: &acceleration.time,
                value: &acceleration.value,
            },
            step,
            timing,
        )
        .map_err(|e| {
            Trouble::data(format!(
                "the two sensors cannot be put on one time base: {e}"
            ))
            .detail(self.recording.clone())
            .with_hint("both clocks must share their zero and overlap; see `proofmass inspect`")
        })?;
        Ok((record, start))
    }
}

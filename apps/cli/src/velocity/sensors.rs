//! The two sensors of an axis, from one file or two, on one time base.

use super::reading::{Reading, Samples};
use super::reference::Reference;
use crate::Failure;
use proofmass::core::{Matrix3, SensorModel};
use proofmass::io::{
    Absent, CalibrationFile, Column, ColumnRef, Input, Layout, LayoutOptions, Recording,
    RecordingOptions, TimeSource, TimeUnit, Unit,
};
use proofmass::motion::{
    MotionRecord, Source, Stamped, Timing, align, conditions, even_clock, repetition,
};
use proofmass::uncertainty::{Finding, Severity};
use std::path::{Path, PathBuf};

/// Options of every velocity command.
#[derive(clap::Args)]
pub(crate) struct Sensors {
    /// Recording with the encoder or the wheel speed, and with the accelerometer unless --acceleration-file says else
    pub(super) recording: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Column of the acceleration; with --calibration the three columns x,y,z
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', required = true)]
    acceleration: Vec<String>,
    /// Unit of the acceleration, where the heading does not say it: m/s², mm/s², g, mg, …
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    acceleration_unit: Option<Unit>,
    /// File of the accelerometer, when it has its own; its clock must be that of the recording
    #[arg(long, value_name = "FILE")]
    acceleration_file: Option<PathBuf>,
    /// Time column of --acceleration-file, where its heading does not tell
    #[arg(long, value_name = "COLUMN", requires = "acceleration_file")]
    acceleration_time: Option<String>,
    /// Sampling rate of --acceleration-file in hertz, when that has no time column
    #[arg(long, value_name = "HZ", requires = "acceleration_file")]
    acceleration_rate: Option<f64>,
    /// calibration.json that compensates the acceleration first; needs --axis and three columns
    #[arg(long, value_name = "FILE", requires = "axis")]
    calibration: Option<PathBuf>,
    /// Axis of the compensated accelerometer that lies along the motion
    #[arg(long, value_enum, requires = "calibration")]
    axis: Option<Axis>,
    /// Time by which the accelerometer is later than the encoder, s; it is shifted back by it
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    latency: f64,
    /// Stretch at rest, seconds from the start: its mean acceleration is the offset that is removed
    #[arg(long, value_name = "FROM,TO", value_parser = stretch)]
    still: Option<Stretch>,
    /// Stretch that is used, seconds from the start [default: all]
    #[arg(long, value_name = "FROM,TO", value_parser = stretch)]
    between: Option<Stretch>,
    /// The axis stands still at the first sample
    #[arg(long)]
    at_rest: bool,
    /// Time column by name or number
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Unit of the time column, where the heading does not say it: s, ms, us, ns
    #[arg(long, value_name = "UNIT", value_parser = crate::recording_arguments::time_unit)]
    time_unit: Option<TimeUnit>,
    /// Sampling rate in hertz, for recordings without a time column
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
}

/// One axis of a triaxial sensor.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Axis {
    X,
    Y,
    Z,
}

/// Seconds from and to.
#[derive(Clone, Copy, Debug)]
struct Stretch(f64, f64);

fn stretch(text: &str) -> Result<Stretch, String> {
    let wrong = || format!("{text:?} is no stretch of time: write FROM,TO in seconds");
    let (from, to) = text.split_once(',').ok_or_else(wrong)?;
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match (number(from), number(to)) {
        (Some(from), Some(to)) if from < to => Ok(Stretch(from, to)),
        _ => Err(wrong()),
    }
}

pub(super) fn unit(text: &str) -> Result<Unit, String> {
    Unit::recognise(text).ok_or_else(|| {
        format!(
            "{text:?} is no known unit (m, mm, rad, °, turn, count, m/s, km/h, rad/s, r/min, m/s², g)"
        )
    })
}

/// Unit of a column by its heading or by an option, which must not contradict each other.
pub(super) fn stated_unit(
    recording: &Recording,
    column: &Column,
    (given, option): (Option<Unit>, &str),
) -> Result<Option<Unit>, Failure> {
    match (column.unit, given) {
        (Some(heading), Some(given)) if heading != given => Err(Failure::new(format!(
            "column {:?} is in {heading} by its heading, in {given} by {option}",
            column.name
        ))
        .detail(recording.path.display().to_string())
        .hint(format!("remove {option}, or correct the heading"))),
        (heading, given) => Ok(heading.or(given)),
    }
}

/// Neither heading nor option tells the unit.
pub(super) fn unknown_unit(recording: &Recording, column: &Column, hint: &str) -> Failure {
    Failure::new(format!("the unit of column {:?} is not known", column.name))
        .detail(recording.path.display().to_string())
        .hint(hint)
}

/// What a velocity command works on.
pub(super) struct Bench {
    /// Both sensors in SI on one time base.
    pub(super) record: MotionRecord,
    /// Zero of the times below in the clock of the recording, s: its first row.
    pub(super) origin: f64,
    /// Time of the first sample after that, s.
    pub(super) start: f64,
    /// Reference velocity per sample, m/s.
    pub(super) reference: Option<Vec<f64>>,
    /// Files with their digests.
    pub(super) inputs: Vec<Input>,
    /// What to doubt about the files.
    pub(super) findings: Vec<Finding>,
}

impl Sensors {
    /// The files that are read.
    pub(super) fn files(&self) -> Vec<&Path> {
        let second = self.acceleration_file.as_deref();
        std::iter::once(self.recording.as_path())
            .chain(second)
            .collect()
    }

    /// Reads both sensors and, where one is asked for, the reference.
    pub(super) fn read(&self, reference: Option<&Reference>) -> Result<Bench, Failure> {
        for (name, value) in [("--latency", Some(self.latency)), ("--rate", self.rate)] {
            if value.is_some_and(|v| !v.is_finite()) {
                return Err(Failure::new(format!("{name} must be a finite number")));
            }
        }
        let mut columns = self.reading.columns()?;
        let of_reading = columns.len();
        let of_acceleration = self.acceleration_columns()?;
        let together = self.acceleration_file.is_none();
        if together {
            columns.extend(of_acceleration.iter().cloned());
        }
        let with_reference = reference.filter(|r| r.file.is_none());
        columns.extend(with_reference.map(|r| ColumnRef::from_word(&r.column)));
        let mut absent = vec![Absent::EmptyOrNan; columns.len()];
        if together {
            absent[of_reading..of_reading + of_acceleration.len()].fill(Absent::Empty);
        }
        let main = Recording::read_sparse(
            &self.recording,
            &self.options(&self.recording, columns, self.time.as_deref(), self.rate)?,
            &absent,
        )?;
        let mut inputs = vec![main.input()];
        let mut findings = main.findings().to_vec();
        if self.reading.edges() {
            // Edges come when they come.
            findings.retain(|f| f.code() != "time-gaps");
        }
        // Seconds since an epoch leave a double too few digits for a step.
        let origin = main.time.seconds(0);
        let clock = clock(&main, &main, origin, self.reading.edges());

        let reading = self
            .reading
            .decode(&main, &clock, &self.recording, &mut findings)?;
        let mut acceleration = match &self.acceleration_file {
            None => self.accelerations(&main, &clock, of_reading)?,
            Some(path) => {
                let options = self.options(
                    path,
                    of_acceleration.clone(),
                    self.acceleration_time.as_deref(),
                    self.acceleration_rate,
                )?;
                let absent = vec![Absent::Empty; of_acceleration.len()];
                let other = Recording::read_sparse(path, &options, &absent)?;
                findings.extend(other.findings().iter().cloned());
                inputs.push(other.input());
                let own = self::clock(&other, &main, origin, false);
                self.accelerations(&other, &own, 0)?
            }
        };
        for t in &mut acceleration.time {
            *t -= self.latency;
        }
        if let Some(Stretch(from, to)) = self.still {
            let offset = mean_between(&acceleration, from, to).ok_or_else(|| {
                Failure::new(format!(
                    "no sample lies in the still stretch {from} s to {to} s"
                ))
                .detail(self.recording.display().to_string())
            })?;
            acceleration.value.iter_mut().for_each(|a| *a -= offset);
        }
        if let Some(Stretch(from, to)) = self.between {
            acceleration.keep(|t| t >= from && t <= to);
        }
        findings.extend(longest_stretch(&mut acceleration));

        let (mut record, start) = self.common(&reading, &acceleration)?;
        record.increment = self.reading.increment();
        if self.at_rest {
            record.initial_velocity = Some(0.0);
        }
        if self.reading.is_analogue() {
            findings.extend(thin(&mut record));
        }
        let mut bench = Bench {
            record,
            origin,
            start,
            reference: None,
            inputs,
            findings,
        };
        if let Some(reference) = reference {
            let samples = match &reference.file {
                None => reference.samples(&main, &clock, main.columns.len() - 1)?,
                Some(path) => {
                    let column = ColumnRef::from_word(&reference.column);
                    let time = reference.time.as_deref();
                    let options = self.options(path, vec![column], time, reference.rate)?;
                    let other = Recording::read_sparse(path, &options, &[Absent::EmptyOrNan])?;
                    bench.inputs.push(other.input());
                    reference.samples(&other, &self::clock(&other, &main, origin, false), 0)?
                }
            };
            reference.attach(&mut bench, &samples)?;
        }
        Ok(bench)
    }

    fn acceleration_columns(&self) -> Result<Vec<ColumnRef>, Failure> {
        let needed = if self.calibration.is_some() { 3 } else { 1 };
        if self.acceleration.len() != needed {
            return Err(Failure::new(format!(
                "--acceleration names {} columns, {needed} are needed",
                self.acceleration.len()
            ))
            .hint("one column along the motion, or three columns x,y,z together with --calibration and --axis"));
        }
        Ok(self
            .acceleration
            .iter()
            .map(|name| ColumnRef::from_word(name))
            .collect())
    }

    fn options(
        &self,
        path: &Path,
        columns: Vec<ColumnRef>,
        time: Option<&str>,
        rate: Option<f64>,
    ) -> Result<RecordingOptions, Failure> {
        let time = time.map(ColumnRef::from_word);
        // --time-unit is for headings that do not say it; one of several files may.
        let layout = Layout::sniff(path)?;
        let at = match &time {
            Some(column) => Some(
                layout
                    .find(column)
                    .map_err(|e| Failure::from(e).detail(path.display().to_string()))?,
            ),
            None => layout.time_column(),
        };
        let told = at.is_some_and(|i| layout.unit(i).is_some_and(Unit::is_time));
        let main = path == self.recording;
        Ok(RecordingOptions {
            layout: LayoutOptions::default(),
            columns,
            time,
            time_unit: self.time_unit.filter(|_| rate.is_none() && (main || !told)),
            sampling_rate_hz: rate,
            events: self.reading.edges() && main,
            ..RecordingOptions::default()
        })
    }

    /// Acceleration along the motion in m/s², where the file holds one.
    fn accelerations(
        &self,
        recording: &Recording,
        clock: &[f64],
        first: usize,
    ) -> Result<Samples, Failure> {
        let columns = &recording.columns[first..first + self.acceleration.len()];
        let missing: Vec<&[usize]> = (first..first + columns.len())
            .map(|i| recording.missing(i))
            .collect();
        let unit = |i: usize| -> Result<Unit, Failure> {
            let given = (self.acceleration_unit, "--acceleration-unit");
            stated_unit(recording, &columns[i], given)?.ok_or_else(|| {
                unknown_unit(
                    recording,
                    &columns[i],
                    "add --acceleration-unit m/s2, g, mg, …",
                )
            })
        };
        let value: Vec<f64> = match &self.calibration {
            None => {
                let unit = unit(0)?;
                if !unit.is_acceleration() {
                    return Err(Failure::new(format!(
                        "column {:?} is in {unit}, which is no acceleration",
                        columns[0].name
                    ))
                    .hint("raw outputs need a calibration: --calibration FILE --axis x"));
                }
                let factor = unit.si().1;
                columns[0].data.iter().map(|v| factor * v).collect()
            }
            Some(path) => {
                let calibration = CalibrationFile::read(path)?;
                let sensor = SensorModel::new(Matrix3(calibration.k), calibration.b)?;
                let mut factors = [1.0; 3];
                for (i, factor) in factors.iter_mut().enumerate() {
                    let (si, to_si) = unit(i)?.si();
                    if si != calibration.input_unit {
                        return Err(Failure::new(format!(
                            "column {:?} is in {si}, the calibration takes {}",
                            columns[i].name, calibration.input_unit
                        ))
                        .detail(path.display().to_string()));
                    }
                    *factor = to_si;
                }
                let axis = match self.axis {
                    Some(Axis::X) | None => 0,
                    Some(Axis::Y) => 1,
                    Some(Axis::Z) => 2,
                };
                let to_si = calibration.output_unit.si().1;
                (0..columns[0].data.len())
                    .map(|k| {
                        let output = std::array::from_fn(|i| factors[i] * columns[i].data[k]);
                        to_si * sensor.apply(output)[axis]
                    })
                    .collect()
            }
        };
        Ok(Samples::present(clock, &value, &missing))
    }

    /// Both sensors on the clock of the accelerometer.
    fn common(
        &self,
        reading: &Samples,
        acceleration: &Samples,
    ) -> Result<(MotionRecord, f64), Failure> {
        let source = self.reading.source();
        let timing = if self.reading.edges() {
            Timing::Edges
        } else {
            Timing::Sampled
        };
        let step = even_clock(&acceleration.time);
        let start = acceleration
            .time
            .first()
            .copied()
            .unwrap_or(0.0)
            .max(reading.time.first().copied().unwrap_or(0.0));
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
            Failure::new(format!(
                "the two sensors cannot be put on one time base: {e}"
            ))
            .detail(self.recording.display().to_string())
            .hint("both clocks must share their zero and overlap; see `proofmass inspect`")
        })?;
        Ok((record, start))
    }
}

/// Times of the rows after an origin: of an even clock behind rounded stamps, the clock.
fn clock(recording: &Recording, main: &Recording, origin: f64, edges: bool) -> Vec<f64> {
    let n = recording.samples();
    // Recordings with stamps since 1970 count from their own first one.
    let origin = origin - recording.time.offset_s(&main.time);
    let own: Vec<f64> = (0..n).map(|k| recording.time.seconds(k) - origin).collect();
    let TimeSource::Column(stamps) = recording.time.source() else {
        return own;
    };
    match even_clock(stamps).filter(|_| !edges) {
        Some(step) => {
            let middle = 0.5 * (n - 1) as f64;
            let mean = own.iter().sum::<f64>() / n as f64;
            (0..n).map(|k| mean + step * (k as f64 - middle)).collect()
        }
        None => own,
    }
}

fn mean_between(samples: &Samples, from: f64, to: f64) -> Option<f64> {
    let inside: Vec<f64> = samples
        .time
        .iter()
        .zip(&samples.value)
        .filter(|(t, _)| **t >= from && **t <= to)
        .map(|(_, v)| *v)
        .collect();
    (!inside.is_empty()).then(|| inside.iter().sum::<f64>() / inside.len() as f64)
}

/// Keeps the longest stretch of the accelerometer without a gap of more than three steps.
fn longest_stretch(samples: &mut Samples) -> Option<Finding> {
    let mut steps: Vec<f64> = samples.time.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_by(f64::total_cmp);
    let limit = 3.0 * steps.get(steps.len() / 2)?;
    let mut cuts: Vec<usize> = vec![0];
    cuts.extend(
        (1..samples.time.len()).filter(|&k| samples.time[k] - samples.time[k - 1] >= limit),
    );
    cuts.push(samples.time.len());
    if cuts.len() == 2 {
        return None;
    }
    let (from, to) = cuts
        .windows(2)
        .map(|w| (w[0], w[1]))
        .max_by_key(|(from, to)| to - from)?;
    let finding = Finding::new(
        Severity::Warning,
        "gaps-in-acceleration",
        "the accelerometer has gaps: only the longest stretch without one is used",
    )
    .evidence(format!(
        "{} gaps of more than three steps; used {:.3} s to {:.3} s after the start",
        cuts.len() - 2,
        samples.time[from],
        samples.time[to - 1]
    ))
    .advice("choose another stretch with --between FROM,TO");
    samples.time = samples.time[from..to].to_vec();
    samples.value = samples.value[from..to].to_vec();
    Some(finding)
}

/// Of a slower sensor whose value stands in several rows, keeps the row in which it is new.
fn thin(record: &mut MotionRecord) -> Option<Finding> {
    let n = repetition(record)?;
    let mut last = None;
    let mut age = 0;
    for reading in &mut record.reading {
        age += 1;
        // A value that stays (a wheel at rest) is new again after as many rows.
        if *reading != last || age >= n {
            (last, age) = (*reading, 0);
        } else {
            *reading = None;
        }
    }
    Some(
        Finding::new(
            Severity::Note,
            "repeated-readings",
            "each reading stands in several rows: only the first of each is taken",
        )
        .evidence(format!(
            "most values stand {n} times in a row, at {:.4} Hz of {:.4} Hz",
            1.0 / (n as f64 * record.sample_time),
            1.0 / record.sample_time
        )),
    )
}

/// What stands in the way of any result.
pub(super) fn unusable(record: &MotionRecord) -> bool {
    conditions(record)
        .iter()
        .any(|f| f.code() == "readings-never-change")
}

/// A refusal of the calculation, with the file and a remedy.
pub(super) fn failure(error: proofmass::core::Error, path: &Path) -> Failure {
    use proofmass::core::Error;
    let hint = match error {
        Error::TooFew { .. } => "record longer, or use a stretch with more readings",
        Error::NotFinite { .. } => {
            "gains too high for this rate make a filter run away: lower them, or leave them to `velocity tune`"
        }
        Error::OutOfRange { .. } => {
            "see `proofmass velocity estimate --help` for what a method takes"
        }
        _ => "see `proofmass inspect` for what the file holds",
    };
    Failure::from(error)
        .detail(path.display().to_string())
        .hint(hint)
}

/// Whether the record holds speeds.
pub(super) fn is_speed(record: &MotionRecord) -> bool {
    record.source == Source::Speed
}

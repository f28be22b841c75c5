//! `proofmass test tilt | sensitivity | zero-g | orthogonality | linearity | centrifuge | stability | mounting`.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::gravity_arguments::GravityArguments;
use crate::number_arguments::not_negative;
use crate::{Failure, Outcome, clock};
use proofmass::io::{ColumnRef, Source};
use proofmass::jobs::static_test::{
    ReadingColumns, StaticTest, StaticTestFiles, StaticTestJob, StaticTestOutcome,
};
use proofmass::jobs::velocity::SensorAxis;
use proofmass::jobs::{Job, Outcome as _, RecordingReading, StatedMarks, StoredResult};
use proofmass::statics::static_test::{
    Centrifuge, Linearity, Mounting, Orthogonality, Sensitivity, Stability, Tilt, ZeroG,
};
use std::path::{Path, PathBuf};

/// A table of readings of one axis.
#[derive(clap::Args)]
struct Readings {
    /// Table of readings, one line each
    table: PathBuf,
    #[command(flatten)]
    columns: ReadingColumns,
    #[command(flatten)]
    marks: StatedMarks,
    #[command(flatten)]
    delivery: Delivery,
}

impl Readings {
    fn run(self, input: &ColumnRef, job: StaticTestJob) -> Result<Outcome, Failure> {
        answer(&self.delivery, &[&self.table], job, |test| {
            let table = self.marks.of(Source::open(&self.table)?);
            let files = StaticTestFiles::readings(table, test, input, &self.columns)?;
            Ok(files)
        })
    }
}

/// Reads the files, runs the test and delivers.
fn answer(
    delivery: &Delivery,
    paths: &[&Path],
    job: StaticTestJob,
    read: impl FnOnce(&StaticTest) -> Result<StaticTestFiles, Failure>,
) -> Result<Outcome, Failure> {
    let folder = delivery.begin(StaticTestOutcome::KIND, paths)?;
    let files = read(&job.test)?;
    let record = files.record(Some(clock::today()));
    let outcome = job.answer(&files.data(), &record.inputs, &Progress::new())?;
    delivery.deliver(folder, &StoredResult::new(record, &outcome)?)
}

/// A test in the field of gravity.
fn under(gravity: &GravityArguments, test: StaticTest) -> StaticTestJob {
    let mut job = StaticTestJob::new(test);
    job.standard_gravity = gravity.is_standard();
    job.place = gravity.place();
    job
}

/// Bias, sensitivity, misalignment of one axis turned through known angles.
#[derive(clap::Args)]
pub(super) struct TiltTest {
    #[command(flatten)]
    readings: Readings,
    /// Column of the angle between the axis and the vertical, in degrees unless its heading says rad
    #[arg(long, value_name = "COLUMN")]
    angle: ColumnRef,
    /// Standard uncertainty of the zero of the angles, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    zero_uncertainty: f64,
    /// Full scale of the output in its unit [default: twice its largest deviation from the bias]
    #[arg(long, value_name = "OUTPUT")]
    full_scale: Option<f64>,
    #[command(flatten)]
    gravity: GravityArguments,
}

impl TiltTest {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut test = Tilt::new(self.gravity.value()?);
        test.zero_uncertainty = self.zero_uncertainty.to_radians();
        test.full_scale = self.full_scale;
        let job = under(&self.gravity, StaticTest::Tilt(test));
        self.readings.run(&self.angle, job)
    }
}

/// Roll, pitch and yaw of a sensor on a vehicle or machine, by a rest and straight accelerations.
///
/// Gravity at rest tells the vertical, accelerations on a straight line the direction of travel. `apply` and `export` take the result:
/// `--rotate FOLDER/result.json`.
#[derive(clap::Args)]
pub(super) struct MountingTest {
    /// Recording of three axes, compensated
    recording: PathBuf,
    /// Rest on level ground, in seconds
    #[arg(long, value_name = "FROM,TO", value_parser = stretch, allow_hyphen_values = true)]
    rest: [f64; 2],
    /// Acceleration forward on a straight line, in seconds; may be given several times
    #[arg(long, value_name = "FROM,TO", value_parser = stretch, allow_hyphen_values = true, required_unless_present = "braking")]
    forward: Vec<[f64; 2]>,
    /// Braking, or acceleration backward, on a straight line, in seconds; may be given several times
    #[arg(long, value_name = "FROM,TO", value_parser = stretch, allow_hyphen_values = true)]
    braking: Vec<[f64; 2]>,
    /// Standard uncertainty of the level of the ground at rest, in degrees
    #[arg(long, value_name = "DEG", value_parser = not_negative, default_value = "0")]
    levelling: f64,
    /// Standard uncertainty of the bias of each axis, m/s²
    #[arg(long, value_name = "M/S2", value_parser = not_negative, default_value = "0")]
    bias_uncertainty: f64,
    /// Standard uncertainty of the direction of travel in the frame of the machine, in degrees
    #[arg(long, value_name = "DEG", value_parser = not_negative, default_value = "0")]
    straightness: f64,
    #[command(flatten)]
    reading: RecordingReading,
    #[command(flatten)]
    delivery: Delivery,
}

/// Two times, the first before the second.
fn stretch(text: &str) -> Result<[f64; 2], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[from, to]) if from < to && to.is_finite() => Ok([from, to]),
        _ => Err(format!("{text:?} is no stretch in seconds such as 2,12")),
    }
}

impl MountingTest {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let paths: [&Path; 1] = [&self.recording];
        let folder = self.delivery.begin(StaticTestOutcome::KIND, &paths)?;
        let files = StaticTestFiles::motion(Source::open(&self.recording)?, &self.reading)?;
        let mut test = Mounting::default();
        test.rest = files.samples(self.rest)?;
        for (stretches, of) in [
            (&self.forward, &mut test.forward),
            (&self.braking, &mut test.braking),
        ] {
            for stretch in stretches {
                of.push(files.samples(*stretch)?);
            }
        }
        test.levelling = self.levelling.to_radians();
        test.bias = self.bias_uncertainty;
        test.straightness = self.straightness.to_radians();
        let job = StaticTestJob::new(StaticTest::Mounting(test));
        let record = files.record(Some(clock::today()));
        let outcome = job.answer(&files.data(), &record.inputs, &Progress::new())?;
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

/// Sensitivity and bias of one axis up and down.
///
/// S = (V₊ − V₋)/2g and b = (V₊ + V₋)/2.
#[derive(clap::Args)]
pub(super) struct SensitivityTest {
    #[command(flatten)]
    readings: Readings,
    /// Column of the position: 1 up, -1 down
    #[arg(long, value_name = "COLUMN")]
    position: ColumnRef,
    /// Standard uncertainty of the levelling, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    levelling: f64,
    /// Standard uncertainty of one reading in its unit, where each position is read once
    #[arg(long, value_name = "OUTPUT")]
    reading_uncertainty: Option<f64>,
    #[command(flatten)]
    gravity: GravityArguments,
}

impl SensitivityTest {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut test = Sensitivity::new(self.gravity.value()?);
        test.levelling = self.levelling.to_radians();
        test.reading = self.reading_uncertainty;
        let job = under(&self.gravity, StaticTest::Sensitivity(test));
        self.readings.run(&self.position, job)
    }
}

/// Bias, sensitivity and curvature of one axis at known accelerations.
///
/// Also the temperature coefficient, where the table has temperatures. The order is chosen by the data.
#[derive(clap::Args)]
pub(super) struct LinearityTest {
    #[command(flatten)]
    readings: Readings,
    /// Column of the accelerations, in m/s² unless its heading says g
    #[arg(long, value_name = "COLUMN")]
    acceleration: ColumnRef,
    /// Relative standard uncertainty of all accelerations together, in per cent
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0)]
    scale_uncertainty: f64,
    /// Full scale in m/s² [default: the largest acceleration]
    #[arg(long, value_name = "M_PER_S2")]
    full_scale: Option<f64>,
    /// Largest order
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=3))]
    order: u8,
}

impl LinearityTest {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut test = Linearity::default();
        test.scale_uncertainty = 1e-2 * self.scale_uncertainty;
        test.full_scale = self.full_scale;
        test.largest_order = usize::from(self.order);
        let job = StaticTestJob::new(StaticTest::Linearity(test));
        self.readings.run(&self.acceleration, job)
    }
}

/// Sensitivity and curvature of one axis on a rotating arm, at many g.
///
/// Radius, speed, elongation of the arm and alignment are in the budget.
#[derive(clap::Args)]
pub(super) struct CentrifugeTest {
    #[command(flatten)]
    readings: Readings,
    /// Column of the speeds, in r/min unless its heading says rad/s
    #[arg(long, value_name = "COLUMN")]
    speed: ColumnRef,
    /// Radius of the proof mass at rest, in m
    #[arg(long, value_name = "M")]
    radius: f64,
    /// Its standard uncertainty, in m
    #[arg(long, value_name = "M", default_value_t = 0.0)]
    radius_uncertainty: f64,
    /// Relative standard uncertainty of all speeds together, in per cent
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0)]
    speed_uncertainty: f64,
    /// Relative elongation of the arm per squared speed, in s²
    #[arg(long, value_name = "S2", default_value_t = 0.0)]
    stretch: f64,
    /// Its standard uncertainty, in s²
    #[arg(long, value_name = "S2", default_value_t = 0.0)]
    stretch_uncertainty: f64,
    /// Standard uncertainty of the angle between axis and radius, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    misalignment: f64,
    /// Standard uncertainty of the inclination of the axis against the horizontal, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    inclination: f64,
    /// Full scale in m/s² [default: the largest acceleration]
    #[arg(long, value_name = "M_PER_S2")]
    full_scale: Option<f64>,
}

impl CentrifugeTest {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut test = Centrifuge::new(self.radius);
        test.radius_uncertainty = self.radius_uncertainty;
        test.speed_uncertainty = 1e-2 * self.speed_uncertainty;
        test.stretch = self.stretch;
        test.stretch_uncertainty = self.stretch_uncertainty;
        test.misalignment = self.misalignment.to_radians();
        test.inclination = self.inclination.to_radians();
        test.full_scale = self.full_scale;
        let job = StaticTestJob::new(StaticTest::Centrifuge(test));
        self.readings.run(&self.speed, job)
    }
}

/// Bias of a triaxial sensor at rest on a level surface.
#[derive(clap::Args)]
pub(super) struct ZeroGTest {
    /// Recording of three axes at rest
    recording: PathBuf,
    /// Axis that points up
    #[arg(long, value_enum, default_value = "z")]
    up: SensorAxis,
    /// Standard uncertainty of the levelling, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    levelling: f64,
    #[command(flatten)]
    gravity: GravityArguments,
    #[command(flatten)]
    reading: RecordingReading,
    #[command(flatten)]
    delivery: Delivery,
}

impl ZeroGTest {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut test = ZeroG::new(self.gravity.value()?);
        test.up = self.up as usize;
        test.levelling = self.levelling.to_radians();
        let paths: [&Path; 1] = [&self.recording];
        let job = under(&self.gravity, StaticTest::ZeroG(test));
        answer(&self.delivery, &paths, job, |_| {
            let recording = Source::open(&self.recording)?;
            Ok(StaticTestFiles::rest(recording, &self.reading)?)
        })
    }
}

/// Angles between the sensitive axes of a calibration.
#[derive(clap::Args)]
pub(super) struct OrthogonalityTest {
    /// calibration.json written by `proofmass calibrate`
    calibration: PathBuf,
    #[command(flatten)]
    delivery: Delivery,
}

impl OrthogonalityTest {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let job = StaticTestJob::new(StaticTest::Orthogonality(Orthogonality::default()));
        answer(&self.delivery, &[&self.calibration], job, |_| {
            let calibration = Source::open(&self.calibration)?;
            Ok(StaticTestFiles::calibration(calibration)?)
        })
    }
}

/// Drift of calibration results over months, and when the next one is due.
#[derive(clap::Args)]
pub(super) struct StabilityTest {
    /// result.json of three or more calibrations of one device
    #[arg(required = true)]
    results: Vec<PathBuf>,
    /// Largest tolerated change of a quantity in its unit, such as bias.x=0.01; may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = tolerance)]
    tolerance: Vec<(String, f64)>,
    /// Longest time between calibrations, in months
    #[arg(long, value_name = "MONTHS", default_value_t = 12.0)]
    longest_interval: f64,
    #[command(flatten)]
    delivery: Delivery,
}

fn tolerance(text: &str) -> Result<(String, f64), String> {
    match text
        .split_once('=')
        .map(|(name, value)| (name, value.parse::<f64>()))
    {
        Some((name, Ok(value))) if value > 0.0 && value.is_finite() => Ok((name.to_owned(), value)),
        _ => Err("a name and a positive number are needed, such as bias.x=0.01".to_owned()),
    }
}

impl StabilityTest {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let mut test = Stability::default();
        test.tolerances = self.tolerance;
        test.longest_interval = self.longest_interval;
        let paths: Vec<&Path> = self.results.iter().map(PathBuf::as_path).collect();
        let job = StaticTestJob::new(StaticTest::Stability(test));
        answer(&self.delivery, &paths, job, |_| {
            let sources = self.results.iter().map(Source::open);
            let sources = sources.collect::<Result<Vec<_>, _>>()?;
            Ok(StaticTestFiles::history(sources)?)
        })
    }
}

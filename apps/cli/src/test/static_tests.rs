//! `proofmass test tilt | sensitivity | zero-g | orthogonality | linearity | centrifuge | stability`.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::recording_arguments::RecordingArguments;
use crate::{Failure, Outcome, clock};
use proofmass::calibration::static_test::{
    Centrifuge, DatedEstimate, Linearity, Orthogonality, Sensitivity, Stability, Tilt, ZeroG,
};
use proofmass::core::{Gravity, STANDARD_GRAVITY};
use proofmass::io::{
    CalibrationFile, ColumnRef, Device, Input, RecordedColumn, Recording, RecordingOptions, Unit,
};
use proofmass::jobs::static_test::{
    StaticTest, StaticTestData, StaticTestInput, StaticTestJob, StaticTestOutcome, dated,
};
use proofmass::jobs::{Filed, Job, Outcome as _, Record};
use std::path::{Path, PathBuf};

/// Local gravity.
#[derive(clap::Args)]
struct GravityArguments {
    /// Local gravity in m/s²
    #[arg(long, value_name = "M_PER_S2", default_value_t = STANDARD_GRAVITY)]
    gravity: f64,
    /// Its standard uncertainty in m/s² [default: 0.03 without a stated gravity, which covers the ground]
    #[arg(long, value_name = "M_PER_S2")]
    gravity_uncertainty: Option<f64>,
}

impl GravityArguments {
    fn value(&self) -> Result<Gravity, Failure> {
        let u = match self.gravity_uncertainty {
            Some(u) => u,
            None if self.gravity == STANDARD_GRAVITY => 0.03,
            None => {
                return Err(
                    Failure::new("the uncertainty of the stated gravity is not known")
                        .hint("add --gravity-uncertainty; from a map it is 0.0001 m/s² or so"),
                );
            }
        };
        Ok(Gravity::given(self.gravity, u)?)
    }
}

/// A table of readings of one axis.
#[derive(clap::Args)]
struct Readings {
    /// Table of readings, one line each
    table: PathBuf,
    /// Column of the outputs, by name or number (from 1)
    #[arg(long, value_name = "COLUMN")]
    output_column: String,
    /// Unit of the outputs, where the heading does not say it
    #[arg(long, value_name = "UNIT", value_parser = crate::recording_arguments::unit)]
    output_unit: Option<Unit>,
    /// Column of temperatures in °C
    #[arg(long, value_name = "COLUMN")]
    temperature: Option<String>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Readings {
    /// Reads inputs in SI and outputs as they are, runs the test and delivers.
    fn run(self, input: &str, input_unit: Unit, test: StaticTest) -> Result<Outcome, Failure> {
        let folder = self
            .delivery
            .begin(StaticTestOutcome::KIND, &[&self.table])?;
        let options = RecordingOptions {
            columns: vec![
                ColumnRef::from_word(input),
                ColumnRef::from_word(&self.output_column),
            ],
            temperature: self.temperature.as_deref().map(ColumnRef::from_word),
            // Readings have an order, not a clock.
            sampling_rate_hz: Some(1.0),
            ..RecordingOptions::default()
        };
        let recording = Recording::read(&self.table, &options)?;
        let [inputs, outputs] = recording.columns.as_slice() else {
            return Err(Failure::new("two columns are needed"));
        };
        let name = self.table.display().to_string();
        let factor = to_si(inputs, input_unit).map_err(|e| e.detail(name.clone()))?;
        let inputs: Vec<f64> = inputs.data.iter().map(|v| v * factor).collect();
        let unit = outputs
            .unit
            .or(self.output_unit)
            .unwrap_or(Unit::Count)
            .to_string();
        let temperature = recording.temperature.as_ref().map(|t| t.data.as_slice());
        let data = StaticTestData {
            input: StaticTestInput::Readings {
                input: &inputs,
                output: &outputs.data,
                temperature,
                unit: &unit,
            },
            findings: recording.findings(),
            name: &name,
        };
        let outcome = StaticTestJob::new(test).evaluate(&data, &Progress::new())?;
        let record = record(Device::default(), vec![recording.input()]);
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }
}

fn record(device: Device, inputs: Vec<Input>) -> Record {
    Record {
        device,
        date: Some(clock::today()),
        inputs,
        ..Record::default()
    }
}

/// Factor of a column to SI; its heading wins over the usual unit, and must be of the same kind.
fn to_si(column: &RecordedColumn, usual: Unit) -> Result<f64, Failure> {
    let (unit, factor) = column.unit.unwrap_or(usual).si();
    if unit == usual.si().0 {
        Ok(factor)
    } else {
        Err(Failure::new(format!(
            "column {:?} is in {unit}, {} is needed",
            column.name,
            usual.si().0
        )))
    }
}

/// One axis turned through known angles: bias, sensitivity, misalignment, departure from the cosine.
#[derive(clap::Args)]
pub(super) struct TiltTest {
    #[command(flatten)]
    readings: Readings,
    /// Column of the angle between the axis and the vertical, in degrees unless its heading says rad
    #[arg(long, value_name = "COLUMN")]
    angle: String,
    /// Standard uncertainty of the zero of the angles, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    zero_uncertainty: f64,
    /// Full scale of the output in its unit [default: twice its largest departure from the bias]
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
        self.readings
            .run(&self.angle, Unit::Degree, StaticTest::Tilt(test))
    }
}

/// One axis up and down: S = (V₊ − V₋)/2g and b = (V₊ + V₋)/2.
#[derive(clap::Args)]
pub(super) struct SensitivityTest {
    #[command(flatten)]
    readings: Readings,
    /// Column of the position: 1 up, -1 down
    #[arg(long, value_name = "COLUMN")]
    position: String,
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
        self.readings
            .run(&self.position, Unit::One, StaticTest::Sensitivity(test))
    }
}

/// One axis at known accelerations: bias, sensitivity, curvature, temperature coefficient, order by evidence.
#[derive(clap::Args)]
pub(super) struct LinearityTest {
    #[command(flatten)]
    readings: Readings,
    /// Column of the accelerations, in m/s² unless its heading says g
    #[arg(long, value_name = "COLUMN")]
    acceleration: String,
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
        self.readings.run(
            &self.acceleration,
            Unit::MetrePerSecondSquared,
            StaticTest::Linearity(test),
        )
    }
}

/// One axis on a rotating arm: sensitivity and curvature at many g, with radius, speed, stretch and alignment in the budget.
#[derive(clap::Args)]
pub(super) struct CentrifugeTest {
    #[command(flatten)]
    readings: Readings,
    /// Column of the speeds, in r/min unless its heading says rad/s
    #[arg(long, value_name = "COLUMN")]
    speed: String,
    /// Radius of the proof mass at rest, in m
    #[arg(long, value_name = "M")]
    radius: f64,
    /// Its standard uncertainty, in m
    #[arg(long, value_name = "M", default_value_t = 0.0)]
    radius_uncertainty: f64,
    /// Relative standard uncertainty of all speeds together, in per cent
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0)]
    speed_uncertainty: f64,
    /// Relative stretch of the arm per squared speed, in s²
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
        self.readings.run(
            &self.speed,
            Unit::TurnPerMinute,
            StaticTest::Centrifuge(test),
        )
    }
}

/// Bias of a sensor at rest on a level surface, the autocorrelation of its noise counted.
#[derive(clap::Args)]
pub(super) struct ZeroGTest {
    /// Recording of three axes at rest
    recording: PathBuf,
    /// Axis that points up
    #[arg(long, value_enum, default_value = "z")]
    up: Up,
    /// Standard uncertainty of the levelling, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    levelling: f64,
    #[command(flatten)]
    gravity: GravityArguments,
    #[command(flatten)]
    reading: RecordingArguments,
    #[command(flatten)]
    delivery: Delivery,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Up {
    X,
    Y,
    Z,
}

impl ZeroGTest {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let folder = self
            .delivery
            .begin(StaticTestOutcome::KIND, &[&self.recording])?;
        let recording = Recording::read(&self.recording, &self.reading.reading().options_alone()?)?;
        let [x, y, z] = recording.columns.as_slice() else {
            return Err(Failure::new("three columns are needed"));
        };
        let name = self.recording.display().to_string();
        let (si, factor) = self.reading.reading().common_unit([x, y, z])?.si();
        if !si.is_acceleration() {
            return Err(
                Failure::new(format!("the outputs are in {si}, which is no acceleration"))
                    .detail(name)
                    .hint("apply a calibration first, or convert with the nominal sensitivity"),
            );
        }
        let columns = [x, y, z].map(|c| c.data.iter().map(|v| v * factor).collect::<Vec<f64>>());
        let [x, y, z] = &columns;
        let mut test = ZeroG::new(self.gravity.value()?);
        test.up = self.up as usize;
        test.levelling = self.levelling.to_radians();
        let data = StaticTestData {
            input: StaticTestInput::Recording([x, y, z]),
            findings: recording.findings(),
            name: &name,
        };
        let outcome =
            StaticTestJob::new(StaticTest::ZeroG(test)).evaluate(&data, &Progress::new())?;
        let record = record(Device::default(), vec![recording.input()]);
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }
}

/// Angles between the sensitive axes of a calibration, and what they cost.
#[derive(clap::Args)]
pub(super) struct OrthogonalityTest {
    /// calibration.json written by `proofmass calibrate`
    calibration: PathBuf,
    #[command(flatten)]
    delivery: Delivery,
}

impl OrthogonalityTest {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let folder = self
            .delivery
            .begin(StaticTestOutcome::KIND, &[&self.calibration])?;
        let file = CalibrationFile::read(&self.calibration)?;
        let name = self.calibration.display().to_string();
        let data = StaticTestData {
            input: StaticTestInput::Calibration(&file),
            findings: &[],
            name: &name,
        };
        let test = StaticTest::Orthogonality(Orthogonality::default());
        let outcome = StaticTestJob::new(test).evaluate(&data, &Progress::new())?;
        let record = record(file.device.clone(), vec![Input::of(&self.calibration)?]);
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }
}

/// Drift of calibration results over time, a control chart of each quantity, and when the next one is due.
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
        let places: Vec<&Path> = self.results.iter().map(PathBuf::as_path).collect();
        let folder = self.delivery.begin(StaticTestOutcome::KIND, &places)?;
        let mut history: Vec<DatedEstimate> = Vec::new();
        let mut inputs = Vec::new();
        for path in &self.results {
            let bytes = std::fs::read(path)
                .map_err(|e| Failure::new(format!("{}: {e}", path.display())))?;
            history.push(dated(&bytes, &path.display().to_string())?);
            inputs.push(Input::of(path)?);
        }
        for (name, _) in &self.tolerance {
            if history[0].estimate.index_of(name).is_none() {
                return Err(Failure::new(format!(
                    "the calibrations have no quantity {name:?}"
                )));
            }
        }
        let mut test = Stability::default();
        test.tolerances = self.tolerance;
        test.longest_interval = self.longest_interval;
        let data = StaticTestData {
            input: StaticTestInput::History(&history),
            findings: &[],
            name: "the calibrations",
        };
        let outcome =
            StaticTestJob::new(StaticTest::Stability(test)).evaluate(&data, &Progress::new())?;
        let record = record(Device::default(), inputs);
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }
}

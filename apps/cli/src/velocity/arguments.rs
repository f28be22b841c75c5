//! Options of every velocity command: the two sensors, and a reference.

use proofmass::core::encoder::Decoding;
use proofmass::io::{TimeUnit, Unit};
use proofmass::jobs::velocity::{AxisSensors, Reading, Reference, SensorAxis};
use std::path::{Path, PathBuf};

/// Options of every velocity command.
#[derive(clap::Args)]
pub(crate) struct Sensors {
    /// Recording with the encoder or the wheel speed, and with the accelerometer unless --acceleration-file says else
    recording: PathBuf,
    #[command(flatten)]
    reading: ReadingArguments,
    /// Column of the acceleration; with --calibration the three columns x,y,z; none for an encoder alone
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
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

fn unit(text: &str) -> Result<Unit, String> {
    Unit::recognise(text).ok_or_else(|| {
        format!(
            "{text:?} is no known unit (m, mm, rad, °, turn, count, m/s, km/h, rad/s, r/min, m/s², g)"
        )
    })
}

/// Options of the encoder or the wheel speed.
#[derive(clap::Args)]
#[group(id = "reading", required = false)]
struct ReadingArguments {
    /// Column of the position (count, length or angle); of several columns the mean, as of two wheels
    #[arg(long, value_name = "COLUMN,…", value_delimiter = ',', conflicts_with_all = ["speed", "quadrature", "resolver"])]
    position: Option<Vec<String>>,
    /// Column of a speed instead of a position (wheel, tachogenerator); of several columns the mean
    #[arg(long, value_name = "COLUMN,…", value_delimiter = ',', conflicts_with_all = ["quadrature", "resolver"])]
    speed: Option<Vec<String>>,
    /// Columns of the logic levels A,B or A,B,Z of an incremental encoder
    #[arg(
        long,
        value_name = "A,B[,Z]",
        value_delimiter = ',',
        conflicts_with = "resolver"
    )]
    quadrature: Option<Vec<String>>,
    /// Columns of the demodulated voltages of a resolver, sine and cosine
    #[arg(long, value_name = "SIN,COS", value_delimiter = ',')]
    resolver: Option<Vec<String>>,
    /// Unit of position or speed, where the heading does not say it: count, m, mm, rad, °, turn, m/s, km/h, rad/s, …
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    unit: Option<Unit>,
    /// The column times this is in --unit: a tachogenerator's speed per volt, half a wavelength per hertz of laser Doppler
    #[arg(
        long,
        value_name = "FACTOR",
        requires = "unit",
        allow_negative_numbers = true
    )]
    scale: Option<f64>,
    /// Counts per turn of the encoder (four times its lines with fourfold decoding)
    #[arg(long, value_name = "N", conflicts_with = "counts_per_metre")]
    counts_per_turn: Option<f64>,
    /// Counts per metre of a linear encoder
    #[arg(long, value_name = "N")]
    counts_per_metre: Option<f64>,
    /// Radius that turns an angle into a length, m: of the wheel, or where the accelerometer sits
    #[arg(long, value_name = "METRES")]
    radius: Option<f64>,
    /// Bits of the counter or of the absolute encoder, which rolls over
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(1..=32))]
    bits: Option<u32>,
    /// The words are Gray code
    #[arg(long, requires = "bits")]
    gray: bool,
    /// Edges counted per line of --quadrature: 1, 2 or 4
    #[arg(long, value_name = "EDGES", default_value = "4", value_parser = decoding)]
    decoding: Decoding,
    /// Each row is an edge of the encoder with its time stamp, not a sample
    #[arg(long)]
    edges: bool,
    /// Angles begin anew after each turn, as those of an absolute encoder in degrees
    #[arg(long)]
    wraps: bool,
    /// Velocity in rad/s: angles stay angles, and --radius is where the accelerometer sits
    #[arg(long)]
    angular: bool,
}

fn decoding(text: &str) -> Result<Decoding, String> {
    match text {
        "1" => Ok(Decoding::Single),
        "2" => Ok(Decoding::Double),
        "4" => Ok(Decoding::Quadruple),
        _ => Err(format!("{text:?} must be 1, 2 or 4 edges per line")),
    }
}

/// Options of the reference.
#[derive(clap::Args)]
pub(crate) struct ReferenceArguments {
    /// Column of a reference velocity, from a better instrument or a simulation
    #[arg(long, value_name = "COLUMN")]
    reference: Option<String>,
    /// Unit of the reference, where the heading does not say it: m/s, km/h, mm/s, …
    #[arg(long, value_name = "UNIT", requires = "reference", value_parser = unit)]
    reference_unit: Option<Unit>,
    /// File of the reference, when it has its own; its clock must be that of the recording
    #[arg(long, value_name = "FILE", requires = "reference")]
    reference_file: Option<PathBuf>,
    /// Time column of --reference-file, where its heading does not tell
    #[arg(long, value_name = "COLUMN", requires = "reference_file")]
    reference_time: Option<String>,
    /// Sampling rate of --reference-file in hertz, when that has no time column
    #[arg(long, value_name = "HZ", requires = "reference_file")]
    reference_rate: Option<f64>,
    /// Time by which the reference is late, s; it is shifted back by it
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 0.0,
        requires = "reference",
        allow_negative_numbers = true
    )]
    reference_latency: f64,
}

/// Name of a file in the store that is the file system.
fn name(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

impl Sensors {
    /// The sensors as the jobs take them.
    pub(crate) fn request(&self) -> AxisSensors {
        let stretch = |s: Stretch| [s.0, s.1];
        let r = &self.reading;
        AxisSensors {
            recording: name(&self.recording),
            reading: Reading {
                position: r.position.clone(),
                speed: r.speed.clone(),
                quadrature: r.quadrature.clone(),
                resolver: r.resolver.clone(),
                unit: r.unit,
                scale: r.scale,
                counts_per_turn: r.counts_per_turn,
                counts_per_metre: r.counts_per_metre,
                radius: r.radius,
                bits: r.bits,
                gray: r.gray,
                decoding: r.decoding,
                edges: r.edges,
                angular: r.angular,
                wraps: r.wraps,
            },
            acceleration: self.acceleration.clone(),
            acceleration_unit: self.acceleration_unit,
            acceleration_file: self.acceleration_file.as_deref().map(name),
            acceleration_time: self.acceleration_time.clone(),
            acceleration_rate: self.acceleration_rate,
            calibration: self.calibration.as_deref().map(name),
            axis: self.axis.map(|axis| match axis {
                Axis::X => SensorAxis::X,
                Axis::Y => SensorAxis::Y,
                Axis::Z => SensorAxis::Z,
            }),
            latency: self.latency,
            still: self.still.map(stretch),
            between: self.between.map(stretch),
            at_rest: self.at_rest,
            time: self.time.clone(),
            time_unit: self.time_unit,
            rate: self.rate,
        }
    }
}

impl ReferenceArguments {
    /// The reference as the jobs take it, where one is named.
    pub(crate) fn reference(&self) -> Option<Reference> {
        Some(Reference {
            column: self.reference.clone()?,
            unit: self.reference_unit,
            file: self.reference_file.as_deref().map(name),
            time: self.reference_time.clone(),
            rate: self.reference_rate,
            latency: self.reference_latency,
        })
    }
}

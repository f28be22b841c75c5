//! `proofmass velocity`: velocity from an encoder and an accelerometer.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::{band_or_frequency, not_negative, positive};
use crate::{Failure, Outcome, clock};
use proofmass::io::Source;
use proofmass::jobs::velocity::{
    AxisRecordings, AxisSensors, DriftResults, Reference, SensorAxis, VelocityCompareJob,
    VelocityDrift, VelocityDriftJob, VelocityEstimateJob, VelocityIntegrator,
    VelocityIntegratorJob, VelocityMapJob, VelocityTuneJob,
};
use proofmass::jobs::{Folder, Job, Outcome as _, Record, StoredResult};
use proofmass::motion::{BiasChoice, DriftSources, EncoderAiding, IntegratorTask, Method, Tuning};
use std::path::{Path, PathBuf};

/// Velocity from an encoder or wheel speed and an accelerometer, or one alone.
#[derive(clap::Args)]
pub(crate) struct Velocity {
    #[command(subcommand)]
    question: Question,
}

#[derive(clap::Subcommand)]
enum Question {
    Estimate(Estimate),
    Compare(Compare),
    Tune(Tune),
    Map(Map),
    Drift(Drift),
    Integrator(Integrator),
}

impl Velocity {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match self.question {
            Question::Estimate(c) => {
                let job = VelocityEstimateJob::new(c.method, c.circumference);
                answer(&job, &c.sensors, None, &c.delivery)
            }
            Question::Compare(c) => {
                let job = VelocityCompareJob::new(c.method, c.rates, c.skip);
                answer(&job, &c.sensors, c.reference.as_ref(), &c.delivery)
            }
            Question::Tune(c) => {
                let tuning = Tuning {
                    bias: match c.offset {
                        Offset::None => BiasChoice::None,
                        Offset::Constant => BiasChoice::Constant,
                        Offset::RandomWalk => BiasChoice::RandomWalk,
                        Offset::Automatic => BiasChoice::Automatic,
                    },
                    ..Tuning::default()
                };
                let job = VelocityTuneJob::new(tuning, c.known_increment);
                answer(&job, &c.sensors, None, &c.delivery)
            }
            Question::Map(c) => {
                let turn = c.turn.or(c.sensors.axis.reading.turn()).ok_or_else(|| {
                    Failure::new("the distance of one turn is not known")
                        .hint("add --turn METRES, or --radius METRES, or --angular")
                })?;
                let mut job = VelocityMapJob::new(turn);
                job.search.orders = c.orders;
                job.search.quarters = c.quarters;
                job.search.false_alarm_rate = c.false_alarm_rate;
                answer(&job, &c.sensors, None, &c.delivery)
            }
            Question::Drift(c) => c.run(),
            Question::Integrator(c) => c.run(),
        }
    }
}

impl Drift {
    fn run(self) -> Result<Outcome, Failure> {
        let (noise, sample_time) = match (self.noise, self.rate, self.noise_density) {
            (Some(noise), Some(rate), _) => (noise, 1.0 / rate),
            // One-sided density n is that of samples of n √(f/2); the rate falls out of the drift.
            (_, _, Some(density)) => (density / std::f64::consts::SQRT_2, 1.0),
            _ => (0.0, 0.0),
        };
        let mut sources = DriftSources {
            offset: self.offset,
            offset_uncertainty: self.offset_uncertainty,
            orientation: self.tilt.to_radians(),
            orientation_uncertainty: self.tilt_uncertainty.to_radians(),
            gain: 0.01 * self.gain_error,
            gain_uncertainty: 0.01 * self.gain_uncertainty,
            speed: self.speed,
            noise,
            sample_time,
            walk: self.offset_walk,
            ..DriftSources::default()
        };
        sources.rest = self.rest;
        let files = [self.noise_result.as_deref(), self.calibration.as_deref()];
        let files: Vec<&Path> = files.into_iter().flatten().collect();
        let folder = self.delivery.begin(VelocityDrift::KIND, &files)?;
        let mut job = VelocityDriftJob::new(sources, self.times);
        job.encoder = match (self.encoder_increment, self.encoder_rate.or(self.rate)) {
            (Some(increment), Some(rate)) => Some(EncoderAiding {
                increment,
                rate,
                scale_uncertainty: 0.01 * self.encoder_scale_uncertainty,
                walk: self.encoder_walk,
            }),
            (Some(_), None) => {
                return Err(Failure::new("how often the encoder is read is not known")
                    .hint("add --encoder-rate HZ"));
            }
            (None, _) => None,
        };
        let mut results = DriftResults::of(self.axis, self.noise_channel);
        if let Some(file) = &self.noise_result {
            results.take_noise(Source::open(file)?, &mut job)?;
        }
        if let Some(file) = &self.calibration {
            results.take_calibration(Source::open(file)?, &mut job)?;
        }
        let record = results.record(Some(clock::today()));
        let outcome = job.answer(&(), &record.inputs, &Progress::new())?;
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

/// The sensors of an axis, and the short way to name their columns.
#[derive(clap::Args)]
struct Sensors {
    #[command(flatten)]
    axis: AxisSensors,
    /// Columns of position and acceleration in one: --position and --acceleration
    #[arg(long, value_name = "POSITION,ACCELERATION", value_delimiter = ',', num_args = 1..=2, conflicts_with_all = ["position", "acceleration", "speed", "quadrature", "resolver"])]
    columns: Vec<String>,
}

impl Sensors {
    /// The columns where they belong; one alone is an encoder without an accelerometer.
    fn named(&self) -> AxisSensors {
        let mut axis = self.axis.clone();
        if let [position, acceleration @ ..] = &self.columns[..] {
            axis.reading.position = Some(vec![position.clone()]);
            axis.acceleration = acceleration.to_vec();
        }
        axis
    }
}

fn answer<J>(
    job: &J,
    sensors: &Sensors,
    reference: Option<&Reference>,
    delivery: &Delivery,
) -> Result<Outcome, Failure>
where
    J: for<'a> Job<Data<'a> = proofmass::jobs::velocity::AxisData<'a>>,
{
    let sensors = &sensors.named();
    let mut files = sensors.files();
    files.extend(reference.and_then(|r| r.file.as_deref()));
    let paths: Vec<&Path> = files.into_iter().map(Path::new).collect();
    let folder = delivery.begin(J::Outcome::KIND, &paths)?;
    let watch = Progress::new();
    let recordings: AxisRecordings = sensors.load(&Folder::new(""), reference, &watch)?;
    let record = recordings.record(Some(clock::today()));
    let outcome = job.answer(&recordings.data(), &record.inputs, &watch)?;
    delivery.deliver(folder, &StoredResult::new(record, &outcome)?)
}

/// Velocity with its uncertainty; slip, collisions and encoder ripple are reported.
///
/// Without --method it is the Kalman filter. Its noise is found by maximum likelihood, its gains by comparison with the
/// smoother, which uses the readings before and after. With -o, a folder gets result.json, report.html and velocity.csv.
#[derive(clap::Args)]
struct Estimate {
    #[command(flatten)]
    sensors: Sensors,
    /// Method with its settings, such as observer:5,25 or savitzky-golay:9,2 [default: Kalman, tuned]
    #[arg(long, value_name = "METHOD")]
    method: Option<Method>,
    /// Circumference of the wheel, m: errors that repeat every turn are then reported by themselves
    #[arg(long, value_name = "METRES")]
    circumference: Option<f64>,
    #[command(flatten)]
    delivery: Delivery,
}

/// Errors of many methods, against a reference velocity or the smoother.
///
/// At any list of sampling rates.
/// Without --method: differences, a fit and the integral of single sensors, two channels and observers with the
/// gains of the literature, and every fused method with gains found at that rate. With -o, a folder gets
/// result.json, report.html, errors.csv and velocities.csv.
#[derive(clap::Args)]
struct Compare {
    #[command(flatten)]
    sensors: Sensors,
    #[command(flatten)]
    reference: Option<Reference>,
    /// Sampling rates in hertz, to which the recording is thinned [default: its own]
    #[arg(long, value_name = "HZ,…", value_delimiter = ',')]
    rates: Vec<f64>,
    /// Method with its settings, such as observer:5,25; may be given several times [default: all]
    #[arg(long, value_name = "METHOD")]
    method: Vec<Method>,
    /// Seconds at the start that are not compared: filters settle there [default: 1, at most a tenth]
    #[arg(long, value_name = "SECONDS")]
    skip: Option<f64>,
    #[command(flatten)]
    delivery: Delivery,
}

/// Noise of both sensors and gains of every filter, from the recording alone.
///
/// The noise is found by maximum likelihood. The gains are those whose velocity comes closest to the smoother's. With -o, a folder gets result.json,
/// report.html and likelihood.csv.
#[derive(clap::Args)]
struct Tune {
    #[command(flatten)]
    sensors: Sensors,
    /// Whether the accelerometer's offset is a state of the filter
    #[arg(long, value_enum, default_value = "automatic")]
    offset: Offset,
    /// Take the noise of a count as known, increment/√12, instead of finding it
    #[arg(long)]
    known_increment: bool,
    #[command(flatten)]
    delivery: Delivery,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Offset {
    /// It was removed before, or is part of the noise
    None,
    /// An unknown constant
    Constant,
    /// A random walk
    RandomWalk,
    /// The one that the likelihood-ratio criterion favours
    Automatic,
}

/// Drift of a velocity from an accelerometer alone; needs no recording.
///
/// It is computed from the stated errors of the sensor, or from results: its noise and what its calibration leaves open.
/// Known errors add up, uncertainties and noise widen the interval; each stands by itself in the table. With -o, a folder
/// gets result.json, report.html and drift.csv.
#[derive(clap::Args)]
struct Drift {
    /// Offset, m/s²
    #[arg(
        long,
        value_name = "M/S2",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    offset: f64,
    /// Its standard uncertainty, m/s²
    #[arg(long, value_name = "M/S2", default_value_t = 0.0)]
    offset_uncertainty: f64,
    /// Random walk of the offset, (m/s²)/√s, as `proofmass noise` states it (coefficient K)
    #[arg(long, value_name = "M/S2/√S", default_value_t = 0.0)]
    offset_walk: f64,
    /// Inclination of the axis, degrees: the component of gravity along it is taken for motion
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    tilt: f64,
    /// Its standard uncertainty, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    tilt_uncertainty: f64,
    /// Error of the gain, per cent; acts on --speed
    #[arg(
        long,
        value_name = "PERCENT",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        requires = "speed"
    )]
    gain_error: f64,
    /// Its standard uncertainty, per cent; acts on --speed
    #[arg(
        long,
        value_name = "PERCENT",
        default_value_t = 0.0,
        requires = "speed"
    )]
    gain_uncertainty: f64,
    /// Change of the velocity since the integration began, m/s
    #[arg(
        long,
        value_name = "M/S",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    speed: f64,
    /// Standard deviation of a sample, m/s²; needs --rate
    #[arg(
        long,
        value_name = "M/S2",
        requires = "rate",
        conflicts_with = "noise_density"
    )]
    noise: Option<f64>,
    /// Sampling rate of that noise, Hz
    #[arg(long, value_name = "HZ", requires = "noise")]
    rate: Option<f64>,
    /// Density of the noise in place of its samples, (m/s²)/√Hz, one-sided as in data sheets
    #[arg(long, value_name = "M/S2/√HZ")]
    noise_density: Option<f64>,
    /// result.json of `proofmass noise`: N, B, K and Gauss–Markov processes with their intervals, in place of typed noise
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["noise", "noise_density", "offset_walk"]
    )]
    noise_result: Option<PathBuf>,
    /// Channel of the noise result, by its name [default: its only one, or that of --axis]
    #[arg(long, value_name = "NAME", requires = "noise_result")]
    noise_channel: Option<String>,
    /// Calibration at rest (calibration.json or result.json): what it leaves open of offset and gain, with their covariance
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["offset_uncertainty", "gain_uncertainty"]
    )]
    calibration: Option<PathBuf>,
    /// Axis of both along the motion, where they have three
    #[arg(long, value_enum)]
    axis: Option<SensorAxis>,
    /// Rest just before the start, in seconds: the drift is stated also with its mean taken off
    #[arg(long, value_name = "S", value_parser = not_negative, default_value = "0")]
    rest: f64,
    /// Length of a count of an encoder beside the accelerometer, m: the drift is stated also with its aiding
    #[arg(long, value_name = "METRES", value_parser = positive)]
    encoder_increment: Option<f64>,
    /// Readings of the encoder per second [default: --rate]
    #[arg(long, value_name = "HZ", value_parser = positive, requires = "encoder_increment")]
    encoder_rate: Option<f64>,
    /// Standard uncertainty of the length of a count (the radius of a wheel), per cent; acts on --speed
    #[arg(long, value_name = "PERCENT", value_parser = not_negative, default_value = "0", requires = "encoder_increment")]
    encoder_scale_uncertainty: f64,
    /// What errors of single counts and slip add up to after a metre, standard deviation, m/√m; acts on --speed
    #[arg(long, value_name = "M/√M", value_parser = not_negative, default_value = "0", requires = "encoder_increment")]
    encoder_walk: f64,
    /// Times after the start, s
    #[arg(
        long,
        value_name = "S,…",
        value_delimiter = ',',
        default_value = "1,10,60,600"
    )]
    times: Vec<f64>,
    #[command(flatten)]
    delivery: Delivery,
}

/// Which integration rule and which high-pass: ranked for a band, a bias and a noise; needs no recording.
///
/// Every rule of Newton and Cotes, closed and open, Tick's and Adams and Moulton's, each with the order and the corner of a Butterworth
/// high-pass that err least in all. With -o, a folder gets result.json, report.html, integrators.csv and rules.csv.
#[derive(clap::Args)]
struct Integrator {
    /// Lowest and highest frequency of the motion, Hz
    #[arg(long, value_name = "LOW,HIGH", value_parser = band_or_frequency)]
    band: [f64; 2],
    /// Sampling rate, Hz
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: f64,
    /// Bias of the accelerometer that was not taken off: its size or standard uncertainty, m/s²
    #[arg(long, value_name = "M/S2", value_parser = not_negative)]
    bias: f64,
    /// Standard deviation of a sample, m/s²
    #[arg(long, value_name = "M/S2", value_parser = not_negative)]
    noise: f64,
    /// Amplitude of the velocity in the band, m/s: what errors of gain and phase act on
    #[arg(long, value_name = "M/S", value_parser = positive)]
    speed: f64,
    /// Length of the record, s
    #[arg(long, value_name = "S", value_parser = positive, default_value = "60")]
    duration: f64,
    /// Error of the velocity that is allowed, m/s: whether the best choice holds is stated
    #[arg(long, value_name = "M/S", value_parser = positive)]
    error: Option<f64>,
    /// Only what runs while the record comes in, and no high-pass that is run forward and backward
    #[arg(long)]
    on_line: bool,
    #[command(flatten)]
    delivery: Delivery,
}

impl Integrator {
    fn run(self) -> Result<Outcome, Failure> {
        let mut job = VelocityIntegratorJob::new(IntegratorTask {
            band: self.band,
            rate: self.rate,
            bias: self.bias,
            noise: self.noise,
            speed: self.speed,
            duration: self.duration,
        });
        job.allowed = self.error;
        job.on_line = self.on_line;
        let folder = self.delivery.begin(VelocityIntegrator::KIND, &[])?;
        let outcome = job.evaluate(&(), &Progress::new())?;
        let record = Record {
            date: Some(clock::today()),
            ..Record::default()
        };
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

/// Errors of the encoder that repeat every turn, such as those of an eccentric disc.
///
/// They are found with the help of the accelerometer. A few turns in either direction, or there and back, suffice. Where the
/// wheel slips, the segments without slip are used. Lines that differ significantly from zero are subtracted by
/// `--encoder-map RESULT` of the other commands. The map belongs to the zero of the readings: an incremental encoder is set
/// to zero at its index. With -o, a folder gets result.json, report.html and lines.csv.
#[derive(clap::Args)]
struct Map {
    #[command(flatten)]
    sensors: Sensors,
    /// Distance or angle of one turn, in m or rad [default: by --angular or --radius]
    #[arg(long, value_name = "M|RAD")]
    turn: Option<f64>,
    /// Cycles per turn of each line: 1 for an eccentric disc, 2 for an ellipse, the ratio of a gear
    #[arg(
        long,
        value_name = "N,…",
        value_delimiter = ',',
        default_value = "1,2,3,4"
    )]
    orders: Vec<f64>,
    /// Also look for unequal quarters of the encoder's lines: an error that repeats every four counts
    #[arg(long)]
    quarters: bool,
    /// Probability that any line is subtracted from an ideal encoder
    #[arg(long, value_name = "P", default_value_t = 0.001)]
    false_alarm_rate: f64,
    #[command(flatten)]
    delivery: Delivery,
}

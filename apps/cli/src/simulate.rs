//! `proofmass simulate`: recordings with truth.

mod transducer;

use crate::console::Progress;
use crate::{Failure, Outcome, console};
use clap::ValueEnum;
use proofmass::io::OutputFolder;
use proofmass::jobs::campaign::SpuriousFile;
use proofmass::jobs::simulate::{
    PracticeFault, SimulateJob, SimulateOutcome, SimulatedAxis, SimulatedMotion,
    SimulatedMultiPosition, SimulatedShaker, SimulatedSpuriousMotion,
};
use proofmass::jobs::{Job, Sink};
use proofmass::rig::bench::Bending;
use std::path::PathBuf;

/// Make a campaign whose truth is known.
#[derive(clap::Args)]
pub(crate) struct Simulate {
    #[command(subcommand)]
    scenario: Scenario,
}

#[derive(clap::Subcommand)]
enum Scenario {
    MultiPosition(MultiPosition),
    Shaker(Shaker),
    SpuriousMotion(SpuriousMotion),
    Axis(Axis),
    Transducer(Box<transducer::Transducer>),
}

impl Simulate {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match self.scenario {
            Scenario::MultiPosition(s) => campaign(&SimulateJob::MultiPosition(s.job()), s.output),
            Scenario::Shaker(s) => campaign(&SimulateJob::Shaker(s.job()?), s.bench.output),
            Scenario::SpuriousMotion(s) => {
                campaign(&SimulateJob::SpuriousMotion(s.job()?), s.bench.output)
            }
            Scenario::Axis(s) => s.run(),
            Scenario::Transducer(s) => s.run(),
        }
    }
}

/// Simulates into a folder, which appears whole or not at all.
fn into_folder(job: &SimulateJob, place: PathBuf) -> Result<(PathBuf, SimulateOutcome), Failure> {
    let folder = OutputFolder::create(place, false)?;
    let outcome = job.evaluate(&(&folder as &dyn Sink), &Progress::new())?;
    Ok((folder.commit()?, outcome))
}

fn campaign(job: &SimulateJob, place: PathBuf) -> Result<Outcome, Failure> {
    let (place, _) = into_folder(job, place)?;
    console::note(format!(
        "written: {0}; next: proofmass calibrate {0}",
        place.display()
    ));
    Ok(Outcome::Done)
}

/// A triaxial accelerometer turned by hand from rest to rest: campaign.toml, recording.csv, truth.json.
#[derive(clap::Args)]
struct MultiPosition {
    /// Folder for the campaign
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// The same seed makes the same recording on every machine
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of standstills
    #[arg(long, default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..=1000))]
    standstills: u32,
    /// Noise of one sample, counts
    #[arg(long, default_value_t = 4.0)]
    noise: f64,
    /// Wander between standstills, m/s²
    #[arg(long, default_value_t = 0.001)]
    wander: f64,
}

impl MultiPosition {
    fn job(&self) -> SimulatedMultiPosition {
        let mut job = SimulatedMultiPosition::default();
        job.seed = self.seed;
        job.standstills = self.standstills;
        job.noise = self.noise;
        job.wander = self.wander;
        job
    }
}

/// Options of every simulation of the shaker bench.
#[derive(clap::Args)]
struct BenchArguments {
    /// Folder for the campaign
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// The same seed makes the same campaign on every machine
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Drive frequencies, Hz
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "5,10,20,40,80,160,315,630,1000"
    )]
    frequencies: Vec<f64>,
    /// Bending of the wedges named in it, in place of the standard one: spurious.csv of `proofmass modes`
    #[arg(long, value_name = "FILE")]
    wedge_motion: Option<PathBuf>,
}

impl BenchArguments {
    fn bending(&self) -> Result<Vec<Bending>, Failure> {
        match &self.wedge_motion {
            Some(path) => Ok(SpuriousFile::open(path)?.bending()),
            None => Ok(Vec::new()),
        }
    }
}

/// A triaxial accelerometer on wedges on a shaker: campaign.toml, runs.csv, one recording per run, reference.csv,
/// spurious.csv, truth.json.
#[derive(clap::Args)]
struct Shaker {
    #[command(flatten)]
    bench: BenchArguments,
    /// Number of configurations: the best ones of the published 44
    #[arg(long, default_value_t = 44, value_parser = clap::value_parser!(u32).range(3..=44))]
    configurations: u32,
    /// Duration of a recording, s
    #[arg(long, default_value_t = 2.0)]
    duration: f64,
    /// Sampling rate, Hz
    #[arg(long, default_value_t = 51_200.0)]
    sampling_rate: f64,
    /// Write phasors into runs.csv instead of recordings
    #[arg(long)]
    phasors: bool,
    /// A table and wedges that move along the excitation alone
    #[arg(long, conflicts_with = "wedge_motion")]
    ideal_table: bool,
    /// Repeats of every vibrometer reading
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=1000))]
    repeats: u32,
    /// Something that goes wrong, for practice: swapped-cables, inverted-channel, clipped, wrong-frequency,
    /// wrong-mounting, missing-run, double-run; in the run in the middle, or in run 17 with `swapped-cables:17`
    #[arg(long, value_name = "FAULT[:RUN]")]
    fault: Vec<PracticeFault>,
}

impl Shaker {
    fn job(&self) -> Result<SimulatedShaker, Failure> {
        let mut job = SimulatedShaker::default();
        job.seed = self.bench.seed;
        job.frequencies = self.bench.frequencies.clone();
        job.configurations = self.configurations;
        job.duration = self.duration;
        job.sampling_rate = self.sampling_rate;
        job.phasors = self.phasors;
        job.ideal_table = self.ideal_table;
        job.repeats = self.repeats;
        job.fault = self.fault.clone();
        job.wedge_motion = self.bench.bending()?;
        Ok(job)
    }
}

/// A vibrometer along the three axes of the table, wedge by wedge: campaign.toml, runs.csv with the phasors of every
/// repeat, truth.json.
#[derive(clap::Args)]
struct SpuriousMotion {
    #[command(flatten)]
    bench: BenchArguments,
    /// Repeats of every reading
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=1000))]
    repeats: u32,
    /// The samples of the vibrometer do not share the clock of the reference
    #[arg(long)]
    no_common_clock: bool,
}

impl SpuriousMotion {
    fn job(&self) -> Result<SimulatedSpuriousMotion, Failure> {
        let mut job = SimulatedSpuriousMotion::default();
        job.seed = self.bench.seed;
        job.frequencies = self.bench.frequencies.clone();
        job.repeats = self.repeats;
        job.no_common_clock = self.no_common_clock;
        job.wedge_motion = self.bench.bending()?;
        Ok(job)
    }
}

/// A driven axis with encoder and accelerometer: recording.csv, truth.csv, truth.json.
///
/// The defaults are those of the reference experiment: 500 lines decoded fourfold at 0.3 m, 16 bits fitted to the
/// signal, 1 kHz. The same seed makes the same recording on every machine.
#[derive(clap::Args)]
struct Axis {
    /// Folder for the recording
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// What the axis does
    #[arg(long, value_enum, default_value = "oscillation")]
    motion: Motion,
    /// Frequency of the oscillation or of the motor's reference, Hz [default: 4 or 5]
    #[arg(long, value_name = "HZ")]
    frequency: Option<f64>,
    /// Duration, s
    #[arg(long, default_value_t = 5.0)]
    duration: f64,
    /// Sampling rate, Hz
    #[arg(long, default_value_t = 1000.0)]
    rate: f64,
    /// Lines of the encoder, decoded fourfold
    #[arg(long, default_value_t = 500)]
    lines: u32,
    /// Radius at which the accelerometer sits, m
    #[arg(long, default_value_t = 0.3)]
    radius: f64,
    /// A reading of the encoder at every n-th sample
    #[arg(long, value_name = "N", default_value_t = 1)]
    every: usize,
    /// Probability that a reading of the encoder is missing
    #[arg(long, default_value_t = 0.0)]
    missing: f64,
    /// Once-per-turn error of an eccentric disc, rad
    #[arg(long, default_value_t = 0.0)]
    eccentricity: f64,
    /// Bits of the counter, which rolls over [default: it never does]
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(8..=32))]
    counter_bits: Option<u32>,
    /// Noise of one sample of the accelerometer, m/s²
    #[arg(long, default_value_t = 0.02)]
    noise: f64,
    /// Offset of the accelerometer as a share of the largest acceleration
    #[arg(long, default_value_t = 0.0005, allow_negative_numbers = true)]
    offset: f64,
    /// Relative gain error of the accelerometer
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    gain_error: f64,
    /// Inclination of the sensitive axis out of the horizontal, °
    #[arg(
        long,
        value_name = "DEGREES",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    orientation: f64,
    /// Low corner of a piezoelectric accelerometer, Hz; 0 measures down to rest
    #[arg(long, value_name = "HZ", default_value_t = 0.0)]
    roll_off: f64,
    /// Time by which the accelerometer is late, s
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    latency: f64,
    /// Bits of the converter, 0 for none
    #[arg(long, default_value_t = 16)]
    bits: u32,
    /// Seed of the noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(Clone, Copy, ValueEnum)]
enum Motion {
    /// A rod between springs, let go
    Oscillation,
    /// A motor under a position loop that follows a sine
    Motor,
    /// A moving body that is hit
    Impact,
    /// From rest to a slow constant velocity
    Ramp,
    /// Nothing moves
    Standstill,
}

impl Axis {
    fn job(&self) -> SimulatedAxis {
        let mut job = SimulatedAxis::default();
        job.motion = match self.motion {
            Motion::Oscillation => SimulatedMotion::Oscillation,
            Motion::Motor => SimulatedMotion::Motor,
            Motion::Impact => SimulatedMotion::Impact,
            Motion::Ramp => SimulatedMotion::Ramp,
            Motion::Standstill => SimulatedMotion::Standstill,
        };
        job.frequency = self.frequency;
        job.duration = self.duration;
        job.rate = self.rate;
        job.lines = self.lines;
        job.radius = self.radius;
        job.every = self.every;
        job.missing = self.missing;
        job.eccentricity = self.eccentricity;
        job.counter_bits = self.counter_bits;
        job.noise = self.noise;
        job.offset = self.offset;
        job.gain_error = self.gain_error;
        job.orientation = self.orientation;
        job.roll_off = self.roll_off;
        job.latency = self.latency;
        job.bits = self.bits;
        job.seed = self.seed;
        job
    }

    fn run(self) -> Result<Outcome, Failure> {
        let (place, _) = into_folder(&SimulateJob::Axis(self.job()), self.output)?;
        let bits = self
            .counter_bits
            .map_or(String::new(), |b| format!(" --bits {b}"));
        console::note(format!(
            "written: {0}; next: proofmass velocity compare {0}/recording.csv --position encoder \
             --counts-per-turn {1} --radius {2}{bits} --acceleration acceleration --reference velocity \
             --reference-file {0}/truth.csv",
            place.display(),
            4 * u64::from(self.lines),
            self.radius
        ));
        Ok(Outcome::Done)
    }
}

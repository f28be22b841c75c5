//! `proofmass simulate`: recordings with truth.

use crate::console::Progress;
use crate::{Failure, Outcome, console};
use proofmass::io::OutputFolder;
use proofmass::jobs::campaign::SpuriousFile;
use proofmass::jobs::simulate::{
    SimulateJob, SimulateOutcome, SimulatedAxis, SimulatedExcitation, SimulatedMultiPosition,
    SimulatedNoise, SimulatedPrimary, SimulatedShaker, SimulatedSpuriousMotion,
    SimulatedTransducer, TransducerConstruction,
};
use proofmass::jobs::{Job, Sink};
use std::path::{Path, PathBuf};

/// Simulate recordings and campaigns whose truth is known.
#[derive(clap::Args)]
pub(crate) struct Simulate {
    #[command(subcommand)]
    scenario: Scenario,
}

#[derive(clap::Subcommand)]
enum Scenario {
    MultiPosition(Simulated<SimulatedMultiPosition>),
    Shaker(Shaker),
    SpuriousMotion(SpuriousMotion),
    Primary(Simulated<SimulatedPrimary>),
    Axis(Simulated<SimulatedAxis>),
    Transducer(Transducer),
    Noise(Simulated<SimulatedNoise>),
}

// Without a comment of its own: the help of a scenario is that of its request.
#[derive(clap::Args)]
struct Simulated<T: clap::Args> {
    #[command(flatten)]
    job: T,
    /// Folder for the files
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

/// A triaxial accelerometer on wedges on a shaker: campaign.toml, runs.csv, one recording per run, reference.csv,
/// spurious.csv, truth.json.
#[derive(clap::Args)]
struct Shaker {
    #[command(flatten)]
    simulated: Simulated<SimulatedShaker>,
    /// Bending of the wedges named in it, in place of the standard one: spurious.csv of `proofmass modes`
    #[arg(long, value_name = "FILE", conflicts_with = "ideal_table")]
    wedge_motion: Option<PathBuf>,
}

/// A vibrometer along the three axes of the table, wedge by wedge: campaign.toml, runs.csv with the phasors of every
/// repeat, truth.json.
#[derive(clap::Args)]
struct SpuriousMotion {
    #[command(flatten)]
    simulated: Simulated<SimulatedSpuriousMotion>,
    /// Bending of the wedges named in it, in place of the standard one: spurious.csv of `proofmass modes`
    #[arg(long, value_name = "FILE")]
    wedge_motion: Option<PathBuf>,
}

// Without a comment of its own, as above.
#[derive(clap::Args)]
struct Transducer {
    #[command(flatten)]
    simulated: Simulated<SimulatedTransducer>,
    /// The device by its construction (sizes, materials, circuit), a TOML file, in place of a principle
    #[arg(long, value_name = "FILE", conflicts_with_all = ["principle", "natural_frequency", "damping"])]
    construction: Option<PathBuf>,
}

impl Simulate {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match self.scenario {
            Scenario::MultiPosition(s) => campaign(SimulateJob::MultiPosition(s.job), s.output),
            Scenario::Shaker(s) => {
                let mut job = s.simulated.job;
                if let Some(path) = &s.wedge_motion {
                    job.wedge_motion = SpuriousFile::open(path)?.bending();
                }
                campaign(SimulateJob::Shaker(job), s.simulated.output)
            }
            Scenario::SpuriousMotion(s) => {
                let mut job = s.simulated.job;
                if let Some(path) = &s.wedge_motion {
                    job.wedge_motion = SpuriousFile::open(path)?.bending();
                }
                campaign(SimulateJob::SpuriousMotion(job), s.simulated.output)
            }
            Scenario::Primary(s) => campaign(SimulateJob::Primary(s.job), s.output),
            Scenario::Axis(s) => axis(s.job, s.output),
            Scenario::Transducer(s) => {
                let mut job = s.simulated.job;
                if let Some(path) = &s.construction {
                    job.construction = Some(TransducerConstruction::open(path)?);
                }
                transducer(job, s.simulated.output)
            }
            Scenario::Noise(s) => noise(s.job, s.output),
        }
    }
}

/// Simulates into a folder, which appears whole or not at all.
fn into_folder(job: &SimulateJob, place: PathBuf) -> Result<(PathBuf, SimulateOutcome), Failure> {
    let folder = OutputFolder::create(place, false)?;
    let outcome = job.evaluate(&(&folder as &dyn Sink), &Progress::new())?;
    Ok((folder.commit()?, outcome))
}

fn next(place: &Path, command: &str) -> Outcome {
    console::note(format!(
        "written: {}; next: proofmass {command}",
        place.display()
    ));
    Outcome::Done
}

fn campaign(job: SimulateJob, place: PathBuf) -> Result<Outcome, Failure> {
    let (place, _) = into_folder(&job, place)?;
    Ok(next(&place, &format!("calibrate {}", place.display())))
}

fn axis(job: SimulatedAxis, place: PathBuf) -> Result<Outcome, Failure> {
    let counts = 4 * u64::from(job.lines);
    let bits = job.counter_bits.map(|b| format!(" --bits {b}"));
    let bits = bits.unwrap_or_default();
    let radius = job.radius;
    let (place, _) = into_folder(&SimulateJob::Axis(job), place)?;
    let command = format!(
        "velocity compare {0}/recording.csv --position encoder --counts-per-turn {counts} --radius {radius}{bits} \
         --acceleration acceleration --reference velocity --reference-file {0}/truth.csv",
        place.display()
    );
    Ok(next(&place, &command))
}

fn noise(job: SimulatedNoise, place: PathBuf) -> Result<Outcome, Failure> {
    let sought = [
        (!job.gauss_markov.is_empty(), " --gauss-markov"),
        (!job.sinusoid.is_empty(), " --sinusoids"),
    ];
    let sought: String = sought.iter().filter(|s| s.0).map(|s| s.1).collect();
    let (place, _) = into_folder(&SimulateJob::Noise(job), place)?;
    let command = format!("noise {}/recording.csv{sought}", place.display());
    Ok(next(&place, &command))
}

fn transducer(job: SimulatedTransducer, place: PathBuf) -> Result<Outcome, Failure> {
    let device = job.device()?;
    let range = device.limits().acceleration;
    // Behind a slow first order a step shows nothing of the mass.
    let natural = device.mass.natural_frequency();
    let hidden = matches!(job.motion, SimulatedExcitation::Step)
        && device.principle.low_pass().is_some_and(|f| f < natural);
    let (test, columns) = match job.motion {
        SimulatedExcitation::Shock => ("shock", "--reference reference --output-column output"),
        SimulatedExcitation::Random => (
            "random",
            "--input reference --output-column output --model 1mode",
        ),
        SimulatedExcitation::Sweep => (
            "sweep",
            "--input reference --output-column output --model 1mode",
        ),
        SimulatedExcitation::Step => ("step", "--column output"),
    };
    let (place, outcome) = into_folder(&SimulateJob::Transducer(job), place)?;
    match outcome.truth()["samples_beyond_range"].as_u64() {
        None | Some(0) => {}
        Some(beyond) => console::note(format!(
            "note: {beyond} samples lie beyond what the device measures ({range:.4} m/s²)"
        )),
    }
    let command = match hidden {
        true => format!("inspect {}/recording.csv", place.display()),
        false => format!("test {test} {}/recording.csv {columns}", place.display()),
    };
    Ok(next(&place, &command))
}

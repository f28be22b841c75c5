//! `proofmass velocity tune`: noise and gains from a recording alone.

use super::estimate::{document, report};
use super::sensors::{Sensors, failure, unusable};
use crate::delivery::{Delivery, Results};
use crate::{Failure, Outcome, clock};
use proofmass::core::Unwatched;
use proofmass::io::Table;
use proofmass::motion::{BiasChoice, ReadingNoise, TuneResult, Tuning, tune};

/// Noise of both sensors by maximum likelihood, and the gains of every fused filter, without a reference.
///
/// The gains are those whose velocity comes closest to the smoother's. With -o, a folder gets result.json,
/// report.html and likelihood.csv.
#[derive(clap::Args)]
pub(crate) struct Tune {
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
    /// The one whose likelihood pays for its parameters
    Automatic,
}

impl Tune {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let folder = self.delivery.begin(&self.sensors.files())?;
        let bench = self.sensors.read(None)?;
        if unusable(&bench.record) {
            return Err(
                Failure::new("the axis never moves: nothing can be tuned on a standstill")
                    .detail(self.sensors.recording.display().to_string())
                    .hint(
                        "record a motion of many increments, or check the column of the position",
                    ),
            );
        }
        let reading_noise = match (self.known_increment, bench.record.increment) {
            (false, _) => ReadingNoise::Free,
            (true, Some(increment)) => ReadingNoise::Known {
                variance: increment * increment / 12.0,
            },
            (true, None) => {
                return Err(Failure::new("--known-increment needs counts")
                    .hint("state --counts-per-turn or --counts-per-metre"));
            }
        };
        let tuning = Tuning {
            reading_noise,
            bias: match self.offset {
                Offset::None => BiasChoice::None,
                Offset::Constant => BiasChoice::Constant,
                Offset::RandomWalk => BiasChoice::RandomWalk,
                Offset::Automatic => BiasChoice::Automatic,
            },
            ..Tuning::default()
        };
        let result = tune(&bench.record, &tuning, &Unwatched)
            .map_err(|e| failure(e, &self.sensors.recording))?;
        let mut findings = bench.findings.clone();
        findings.extend(result.findings.iter().cloned());
        let json = document("velocity-tuning", &bench, &findings)?
            .section("date", &clock::today())?
            .section("options", &tuning)?
            .section("tuning", &result)?
            .to_json()?;
        let title = format!("Tuning on {}", self.sensors.recording.display());
        let text = report(title, &bench, &findings);
        self.delivery.hand_over(
            folder,
            &Results {
                json,
                summary: &|| text.tune_summary(&result),
                report: &|| text.tune(&result),
                files: vec![("likelihood.csv", likelihood(&result)?)],
                findings: &findings,
            },
        )
    }
}

fn likelihood(result: &TuneResult) -> Result<Vec<u8>, Failure> {
    let mut table = Table::new(["q_(m/s2)2", "log_likelihood_below_maximum"]);
    for (q, value) in &result.tuned.profile {
        table.push([*q, *value])?;
    }
    Ok(table.to_csv()?)
}

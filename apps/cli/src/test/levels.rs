//! `proofmass test levels`.

use super::channel_arguments::{unit, wanted};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock};
use proofmass::io::{Source, Unit};
use proofmass::jobs::linearity::{LinearityData, LinearityJob, LinearityOutcome};
use proofmass::jobs::{ChannelReading, Filed, Job, Outcome as _, Record};
use std::path::PathBuf;

/// Linearity over the level at one frequency: sensitivity, amplitude coefficient, largest departure from a straight line.
#[derive(clap::Args)]
pub(super) struct Levels {
    /// Table with a line for each level
    table: PathBuf,
    /// Column of the level (amplitude of the acceleration), by name or number (from 1)
    #[arg(long, value_name = "COLUMN")]
    level: String,
    /// Its unit, where the heading does not say it
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    level_unit: Option<Unit>,
    /// Column of the amplitude of the output
    #[arg(long, value_name = "COLUMN")]
    output_column: String,
    /// Its unit and that of its uncertainty, where the headings do not say it
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    output_unit: Option<Unit>,
    /// Column of its standard uncertainty
    #[arg(long, value_name = "COLUMN")]
    output_u: String,
    #[command(flatten)]
    delivery: Delivery,
}

impl Levels {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let folder = self
            .delivery
            .begin(LinearityOutcome::KIND, &[&self.table])?;
        // A table has no clock.
        let mut reading = ChannelReading::default();
        reading.rate = Some(1.0);
        let table = reading.read(
            Source::open(&self.table)?,
            &[
                wanted(&self.level, self.level_unit),
                wanted(&self.output_column, self.output_unit),
                wanted(&self.output_u, self.output_unit),
            ],
        )?;
        let [level, output, u] = table.channels.as_slice() else {
            return Err(Failure::new("three columns are needed"));
        };
        if output.unit != u.unit {
            return Err(Failure::new(format!(
                "the output is in {}, its uncertainty in {}",
                output.unit, u.unit
            ))
            .hint("state the unit of both with --output-unit, or correct the headings"));
        }
        let data = LinearityData {
            level: level.view(),
            output: output.view(),
            uncertainty: u.view(),
            findings: &table.findings,
            name: &table.name,
        };
        let outcome = LinearityJob::default().evaluate(&data, &Progress::new())?;
        let record = Record {
            title: Some(format!(
                "Linearity over the level, {}",
                self.table.display()
            )),
            date: Some(clock::today()),
            inputs: vec![table.input.clone()],
            ..Record::default()
        };
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }
}

//! `proofmass test levels`.

use crate::clock::{named, record};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome};
use proofmass::io::{ColumnRef, Source, Unit};
use proofmass::jobs::linearity::{LinearityJob, LinearityOutcome, RecordedLevels};
use proofmass::jobs::{Job, Outcome as _, StatedMarks, StoredResult, WantedChannel};
use std::path::PathBuf;

/// Linearity over the amplitude at one frequency.
///
/// Sensitivity, amplitude coefficient, largest deviation from a straight line.
#[derive(clap::Args)]
pub(super) struct Levels {
    /// Table with a line for each level
    table: PathBuf,
    /// Column of the level (amplitude of the acceleration), by name or number (from 1)
    #[arg(long, value_name = "COLUMN")]
    level: ColumnRef,
    /// Its unit, where the heading does not say it
    #[arg(long, value_name = "UNIT")]
    level_unit: Option<Unit>,
    /// Column of the amplitude of the output
    #[arg(long, value_name = "COLUMN")]
    output_column: ColumnRef,
    /// Its unit and that of its uncertainty, where the headings do not say it
    #[arg(long, value_name = "UNIT")]
    output_unit: Option<Unit>,
    /// Column of its standard uncertainty
    #[arg(long, value_name = "COLUMN")]
    output_u: ColumnRef,
    #[command(flatten)]
    marks: StatedMarks,
    #[command(flatten)]
    delivery: Delivery,
}

impl Levels {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let folder = self
            .delivery
            .begin(LinearityOutcome::KIND, &[&self.table])?;
        let columns = [
            WantedChannel::new(self.level.clone(), self.level_unit, "--level-unit"),
            WantedChannel::new(
                self.output_column.clone(),
                self.output_unit,
                "--output-unit",
            ),
            WantedChannel::new(self.output_u.clone(), self.output_unit, "--output-unit"),
        ];
        let levels = RecordedLevels::read(self.marks.of(Source::open(&self.table)?), &columns)?;
        let inputs = vec![levels.input()];
        let job = LinearityJob::default();
        let outcome = job.answer(&levels.data()?, &inputs, &Progress::new())?;
        let title = format!("Linearity over the level, {}", named(&self.table));
        let record = record(title, inputs);
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}

//! `proofmass test model`.

use crate::clock::{named, record};
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::{band, not_negative, positive};
use crate::{Failure, Outcome};
use proofmass::dynamic::model::ModelStructure;
use proofmass::io::{ColumnRef, Source, UnitRatio};
use proofmass::jobs::response::{ModelJob, PointColumns, RecordedPoints, ResponseOutcome};
use proofmass::jobs::{Job, Outcome as _, StatedMarks, StoredResult};
use std::path::PathBuf;

/// Fit a model (modes, delay, filters) to a frequency response.
///
/// The response is a calibration.json or a table of points. A model that does not fit is reported.
/// A table needs its five columns named; without them the file is read as a calibration of kind frequency-response, or as the table
/// of a certificate (.csv: frequency, sensitivity, phase, uncertainties).
#[derive(clap::Args)]
pub(super) struct Model {
    /// Table with a line for each point, or calibration.json of kind frequency-response
    table: PathBuf,
    /// Elements of 1mode … 4modes, high-pass, delay, low-pass=ORDER, joined by +
    #[arg(long, value_name = "ELEMENTS", default_value = "1mode")]
    model: ModelStructure,
    /// Column of the frequency in hertz
    #[arg(long, value_name = "COLUMN")]
    frequency: Option<String>,
    /// Column of the modulus
    #[arg(long, value_name = "COLUMN")]
    modulus: Option<String>,
    /// Column of its standard uncertainty
    #[arg(long, value_name = "COLUMN")]
    modulus_u: Option<String>,
    /// Column of the phase
    #[arg(long, value_name = "COLUMN")]
    phase: Option<String>,
    /// Column of its standard uncertainty
    #[arg(long, value_name = "COLUMN")]
    phase_u: Option<String>,
    /// Unit of phase and its uncertainty, where the headings do not say it [default: rad]
    #[arg(long, value_enum)]
    phase_unit: Option<PhaseUnit>,
    /// Unit of the modulus, where the heading does not say it: V/(m/s2), mV/g, count/g, …; 1 for a pure number
    #[arg(long, value_name = "UNIT")]
    unit: Option<UnitRatio>,
    /// Relative standard uncertainty of the reference, in per cent, common to all points
    #[arg(long, value_name = "PERCENT", value_parser = not_negative, default_value = "0")]
    reference_uncertainty: f64,
    /// Lowest and highest frequency in hertz
    #[arg(long, value_name = "LOW,HIGH", value_parser = band)]
    band: Option<[f64; 2]>,
    /// Frequency in hertz to whose modulus bandwidths refer [default: the lowest]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    reference_frequency: Option<f64>,
    /// Coverage factor of the expanded uncertainties (U_…) in the table of a certificate
    #[arg(short = 'k', long = "coverage-factor", alias = "coverage", value_name = "K", value_parser = crate::number_arguments::coverage_factor)]
    coverage: Option<f64>,
    #[command(flatten)]
    marks: StatedMarks,
    #[command(flatten)]
    delivery: Delivery,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum PhaseUnit {
    Rad,
    Deg,
}

impl Model {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        let folder = self.delivery.begin(ResponseOutcome::KIND, &[&self.table])?;
        let points = self
            .points()?
            .with_reference(1e-2 * self.reference_uncertainty);
        let mut job = ModelJob::new(self.model);
        job.band = self.band;
        job.reference_frequency = self.reference_frequency;
        let inputs = vec![points.input()];
        let outcome = job.answer(&points.data(), &inputs, &Progress::new())?;
        let title = format!("Model of a frequency response, {}", named(&self.table));
        let record = record(title, inputs);
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }

    fn points(&self) -> Result<RecordedPoints, Failure> {
        let named = [
            ("frequency", &self.frequency),
            ("modulus", &self.modulus),
            ("modulus-u", &self.modulus_u),
            ("phase", &self.phase),
            ("phase-u", &self.phase_u),
        ];
        if named.iter().all(|(_, column)| column.is_none()) {
            let stated = [
                (self.phase_unit.is_some(), "phase", "phase_rad"),
                (self.unit.is_some(), "modulus", "sensitivity_V/(m/s2)"),
            ];
            let of_none = stated.iter().find(|(stated, ..)| *stated);
            if let Some((_, column, heading)) = of_none {
                let option = if *column == "phase" {
                    "--phase-unit"
                } else {
                    "--unit"
                };
                return Err(Failure::new(format!(
                    "{option} says the unit of a column that --{column} names, and none is named",
                ))
                .hint(format!("name all five columns (--frequency, --modulus, --modulus-u, --phase, --phase-u), or write the unit into the heading, as {heading}")));
            }
            let source = Source::open(&self.table)?;
            return Ok(RecordedPoints::of_calibration(source, self.coverage)?);
        }
        if let Some((option, _)) = named.iter().find(|(_, column)| column.is_none()) {
            return Err(
                Failure::new(format!("the column of --{option} is not named"))
                    .hint("name all five columns of a table, or none for a calibration.json"),
            );
        }
        let [
            frequency,
            modulus,
            modulus_uncertainty,
            phase,
            phase_uncertainty,
        ] = named.map(|(_, column)| ColumnRef::from_word(column.as_deref().unwrap_or_default()));
        let columns = PointColumns {
            frequency,
            modulus,
            modulus_uncertainty,
            phase,
            phase_uncertainty,
            degrees: self.phase_unit == Some(PhaseUnit::Deg),
            unit: self.unit,
        };
        let source = self.marks.of(Source::open(&self.table)?);
        Ok(RecordedPoints::of_table(source, &columns)?)
    }
}

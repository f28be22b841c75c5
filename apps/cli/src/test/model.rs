//! `proofmass test model`.

use super::channel_arguments::{band, not_negative, positive, wanted};
use super::response::structure;
use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock};
use proofmass::calibration::dynamic::model::{ModelStructure, ResponsePoints};
use proofmass::io::{AnyCalibration, Input, Source};
use proofmass::jobs::response::{ModelData, ModelJob, ResponseOutcome};
use proofmass::jobs::{ChannelReading, Filed, Job, Outcome as _, Record, frequency_response};
use proofmass::uncertainty::Finding;
use std::path::PathBuf;

/// Fit a model to a frequency response from a calibration.json or a table, as stepped sines or a laboratory give it; say when it
/// does not fit.
///
/// A table needs its five columns named; without them the file is read as a calibration of kind frequency-response, or as the table
/// of a certificate (.csv: frequency, sensitivity, phase, uncertainties).
#[derive(clap::Args)]
pub(super) struct Model {
    /// Table with a line for each point, or calibration.json of kind frequency-response
    table: PathBuf,
    /// Elements of 1mode … 4modes, high-pass, delay, low-pass=ORDER, joined by +
    #[arg(long, value_name = "ELEMENTS", value_parser = structure, default_value = "1mode")]
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
    /// Unit of phase and its uncertainty, where the headings do not say it
    #[arg(long, value_enum, default_value = "rad")]
    phase_unit: PhaseUnit,
    /// Unit of the modulus, for the report
    #[arg(long, value_name = "UNIT", default_value = "1")]
    unit: String,
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
    #[arg(long, value_name = "K", value_parser = positive)]
    coverage: Option<f64>,
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
        let Points {
            points,
            findings,
            name,
            input,
        } = self.points()?;
        let mut job = ModelJob::new(self.model);
        job.band = self.band;
        job.reference_frequency = self.reference_frequency;
        let data = ModelData {
            points: &points,
            findings: &findings,
            name: &name,
        };
        let outcome = job.evaluate(&data, &Progress::new())?;
        let record = Record {
            title: Some(format!(
                "Model of a frequency response, {}",
                self.table.display()
            )),
            date: Some(clock::today()),
            inputs: vec![input],
            ..Record::default()
        };
        self.delivery.deliver(folder, &Filed::new(record, outcome))
    }

    fn points(&self) -> Result<Points, Failure> {
        let named = [
            &self.frequency,
            &self.modulus,
            &self.modulus_u,
            &self.phase,
            &self.phase_u,
        ];
        let uncertainty = 1e-2 * self.reference_uncertainty;
        if named.iter().all(|c| c.is_none()) {
            let source = Source::open(&self.table)?;
            let (calibration, input, findings) =
                frequency_response::read_calibration(source, self.coverage)?;
            let name = self.table.display().to_string();
            let AnyCalibration::FrequencyResponse(file) = calibration else {
                return Err(Failure::new(format!("{name} is no frequency response"))
                    .hint("give a calibration.json of kind frequency-response, a certificate, or a table with its five columns named"));
            };
            let response = frequency_response::of_file(&file)?;
            let points = ResponsePoints::of_response(&response, 0, 0)
                .map_err(|e| Failure::from(e).detail(name.clone()))?;
            return Ok(Points {
                points: points.with_reference(uncertainty, 0.0, None),
                findings,
                name,
                input,
            });
        }
        let mut columns = Vec::new();
        for (column, option) in
            named
                .into_iter()
                .zip(["frequency", "modulus", "modulus-u", "phase", "phase-u"])
        {
            let Some(column) = column else {
                return Err(
                    Failure::new(format!("the column of --{option} is not named"))
                        .hint("name all five columns of a table, or none for a calibration.json"),
                );
            };
            columns.push(wanted(column, None));
        }
        // A table has no clock.
        let mut reading = ChannelReading::default();
        reading.rate = Some(1.0);
        let table = reading.read(Source::open(&self.table)?, &columns)?;
        let [f, m, um, phase, up] = table.channels.as_slice() else {
            return Err(Failure::new("five columns are needed"));
        };
        let radians = |c: &proofmass::jobs::RecordedChannel| -> Vec<f64> {
            // A heading in degrees has been turned into radians by the reader.
            let degrees = self.phase_unit == PhaseUnit::Deg && c.unit != "rad";
            let factor = if degrees { 1f64.to_radians() } else { 1.0 };
            c.data.iter().map(|v| factor * v).collect()
        };
        let points = ResponsePoints::polar(
            f.data.clone(),
            &m.data,
            &um.data,
            &radians(phase),
            &radians(up),
            &self.unit,
        )
        .map_err(|e| Failure::from(e).detail(table.name.clone()))?;
        Ok(Points {
            points: points.with_reference(uncertainty, 0.0, None),
            findings: table.findings.clone(),
            name: table.name.clone(),
            input: table.input.clone(),
        })
    }
}

/// Points with where they are from.
struct Points {
    points: ResponsePoints,
    findings: Vec<Finding>,
    name: String,
    input: Input,
}

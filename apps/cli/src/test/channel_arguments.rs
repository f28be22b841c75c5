//! The channels of a dynamic test on the command line.

use crate::Failure;
use proofmass::dynamic::model::ModelStructure;
use proofmass::io::{ColumnRef, Sensitivity, Source, Unit};
use proofmass::jobs::campaign::{Certificate, CertificateOptions};
use proofmass::jobs::{ChannelReading, RecordedChannels, WantedChannel};
use std::path::{Path, PathBuf};

/// Calibration over frequency of the transducer whose channel is the reference.
#[derive(clap::Args)]
pub(super) struct StandardArguments {
    /// Calibration over frequency of the reference transducer, whose channel is then in volts (.json, a table .csv, a digital certificate .xml)
    #[arg(long, value_name = "FILE")]
    pub(super) standard: Option<PathBuf>,
    /// Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory
    #[arg(long = "standard-coverage-factor", alias = "standard-coverage", value_name = "K", value_parser = crate::number_arguments::coverage_factor, requires = "standard")]
    standard_coverage: Option<f64>,
    /// Axis of a calibration of several
    #[arg(long, value_name = "AXIS", requires = "standard")]
    standard_axis: Option<String>,
    /// Model that is fitted to the calibration and stands for its points, such as 1mode+delay
    #[arg(long, value_name = "ELEMENTS", requires = "standard")]
    standard_model: Option<ModelStructure>,
    /// Number of a digital certificate that is taken although nobody checked the signature in it
    #[arg(long, value_name = "NUMBER", requires = "standard")]
    accept_unchecked_signature: Option<String>,
}

impl StandardArguments {
    /// The certificate, where one was named.
    pub(super) fn read(&self) -> Result<Option<Certificate>, Failure> {
        let Some(path) = &self.standard else {
            return Ok(None);
        };
        let mut options = CertificateOptions::default();
        options.coverage = self.standard_coverage;
        options.axis = self.standard_axis.clone();
        options.model = self.standard_model;
        options
            .accept_unchecked_signature
            .clone_from(&self.accept_unchecked_signature);
        Ok(Some(Certificate::from_document(
            Source::open(path)?,
            &options,
        )?))
    }
}

/// What turns volts or counts of the one channel into an acceleration.
#[derive(clap::Args, Default)]
pub(super) struct SensitivityArguments {
    /// What makes m/s² of volts or counts: "0.5 mV/(m/s²)", "16384 LSB/g", …
    #[arg(long, value_name = "VALUE UNIT", allow_hyphen_values = true)]
    sensitivity: Option<Sensitivity>,
    /// Relative standard uncertainty of the sensitivity, in per cent
    #[arg(long, value_name = "PERCENT", value_parser = crate::number_arguments::not_negative, requires = "sensitivity")]
    sensitivity_uncertainty: Option<f64>,
}

impl SensitivityArguments {
    /// A channel through it.
    pub(super) fn of(&self, wanted: WantedChannel) -> WantedChannel {
        match &self.sensitivity {
            Some(sensitivity) => wanted.by(sensitivity.clone(), self.relative_uncertainty()),
            None => wanted,
        }
    }

    /// Relative standard uncertainty of the acceleration by it.
    pub(super) fn relative_uncertainty(&self) -> f64 {
        1e-2 * self.sensitivity_uncertainty.unwrap_or(0.0)
    }
}

/// The one channel of a recording.
#[derive(clap::Args)]
pub(super) struct ChannelArguments {
    /// Column of the sensor, by name or number (from 1) [default: the only one beside the time]
    #[arg(long, value_name = "COLUMN", aliases = ["output-column", "columns"])]
    column: Option<ColumnRef>,
    /// Unit of the column, where the heading does not say it
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,
    #[command(flatten)]
    clock: ChannelReading,
}

impl ChannelArguments {
    /// The recording with that channel alone.
    pub(super) fn read(&self, path: &Path) -> Result<RecordedChannels, Failure> {
        self.read_by(path, &SensitivityArguments::default())
    }

    /// The recording with that channel as an acceleration, where a sensitivity is stated.
    pub(super) fn read_by(
        &self,
        path: &Path,
        by: &SensitivityArguments,
    ) -> Result<RecordedChannels, Failure> {
        let mut source = Source::open(path)?;
        let roles = [("--column", self.column.as_ref())];
        let columns = self.clock.columns(&mut source, &roles)?.into_iter();
        let wanted = columns.map(|c| by.of(WantedChannel::new(c, self.unit, "--unit")));
        let wanted: Vec<_> = wanted.collect();
        Ok(self.clock.read(source, &wanted)?)
    }
}

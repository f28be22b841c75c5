//! `kind = "transverse-sensitivity"`: a single-axis accelerometer shaken across its axis (ISO 16063-31).

use super::shaker::{
    Certificate, CertificateTable, PhasorQuantity, RunTable, RunsTable, ShakerRecording,
    TransverseSeat, read_runs,
};
use super::shaker_single::{OUTPUTS, REFERENCES, reference_fits};
use super::shaker_triaxial::waveform_options;
use super::statement::{StatementTable, coverage_factor};
use crate::device_output::DeviceOutput;
use proofmass_io::{Result, WaveformOptions};
use serde::Deserialize;

/// `[mounting]`: how well the device sits, standard uncertainties in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TransverseMounting {
    /// Tilt of the base of the device against the axis it is turned about, in each of two directions.
    pub(crate) u_tilt_deg: f64,
    /// Angle by which that axis is not square to the vibration; needed with two directions, else found from the runs.
    pub(crate) u_squareness_deg: Option<f64>,
    /// Zero of the angles of rotation.
    #[serde(default)]
    pub(crate) u_rotation_deg: f64,
}

/// `[reading]` of a transverse test: needed where no runs are left to show the scatter.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TransverseReading {
    /// Standard uncertainty of real and imaginary part of one reading, relative to the sensitivity along the axis.
    pub(crate) u_relative: f64,
    /// Its degrees of freedom; infinite when left out.
    pub(crate) dof: Option<f64>,
}

/// `[datasheet]` of a transverse test.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TransverseDatasheet {
    /// Largest transverse sensitivity, per cent of the sensitivity along the axis.
    #[serde(rename = "transverse_%")]
    pub(crate) transverse: f64,
}

super::head::campaign! {
    /// The tables of a transverse test; the files they name are read by its methods.
    pub struct TransverseCampaign {
        /// Runs.
        pub(crate) runs: RunsTable,
        /// Waveforms.
        pub(crate) recording: Option<ShakerRecording>,
        /// Certificate of the reference; `None` when the runs carry accelerations.
        pub(crate) reference: Option<CertificateTable>,
        /// The calibration along the axis, where no run is along it.
        pub(crate) axis: Option<CertificateTable>,
        /// How well the device sits.
        pub(crate) mounting: TransverseMounting,
        /// Uncertainty of a reading.
        pub(crate) reading: Option<TransverseReading>,
        /// Largest transverse sensitivity of the datasheet.
        pub(crate) datasheet: Option<TransverseDatasheet>,
        /// How U is stated.
        #[serde(default)]
        pub(crate) method: StatementTable,
    }
}

impl TransverseCampaign {
    /// Names of the channels, in the order of every run.
    pub const CHANNELS: [&str; 2] = ["reference", "output"];

    /// Refuses values that are impossible, each with its line.
    pub(super) fn check(&self) -> Result<()> {
        let source = &self.source;
        coverage_factor(source, self.method.coverage_factor)?;
        let m = self.mounting;
        let largest = 45.0;
        for (table, key, value, limit) in [
            ("mounting", "u_tilt_deg", Some(m.u_tilt_deg), largest),
            ("mounting", "u_squareness_deg", m.u_squareness_deg, largest),
            (
                "mounting",
                "u_rotation_deg",
                Some(m.u_rotation_deg),
                largest,
            ),
            (
                "reading",
                "u_relative",
                self.reading.map(|r| r.u_relative),
                1.0,
            ),
            (
                "reading",
                "dof",
                self.reading.and_then(|r| r.dof),
                f64::INFINITY,
            ),
            (
                "datasheet",
                "transverse_%",
                self.datasheet.map(|d| d.transverse),
                100.0,
            ),
        ] {
            if let Some(v) = value
                && !(v >= 0.0 && v.is_finite() && v <= limit && (key != "dof" || v > 0.0))
            {
                let rule = match key {
                    "dof" => "degrees of freedom must be positive".to_owned(),
                    _ if limit.is_finite() && limit < f64::MAX => format!("from 0 to {limit}"),
                    _ => "it must not be negative".to_owned(),
                };
                return Err(source.refuse(table, key, format!("{v} is out of range: {rule}")));
            }
        }
        Ok(())
    }

    /// Reads the table of runs.
    ///
    /// # Errors
    /// As the table says, with line and column; volts of a reference without a certificate, accelerations with one.
    pub(crate) fn read_runs(&self) -> Result<RunTable<TransverseSeat>> {
        let channels: [(&str, &[PhasorQuantity]); 2] =
            [("reference", REFERENCES), ("output", OUTPUTS)];
        let table = read_runs(&self.source, &self.runs, &channels)?;
        reference_fits(&self.source, &table, self.reference.is_some())?;
        Ok(table)
    }

    /// How the waveforms are read.
    ///
    /// # Errors
    /// No `[recording]`, or a channel that is missing.
    pub(crate) fn waveform_options(&self) -> Result<WaveformOptions> {
        waveform_options(&self.source, self.recording.as_ref(), &Self::CHANNELS)
    }

    /// Reads the calibration along the axis, in the unit of the output.
    ///
    /// # Errors
    /// As the table says, with line and column.
    pub(crate) fn read_axis(&self, output: DeviceOutput) -> Result<Option<Certificate>> {
        let table = self.axis.as_ref();
        table
            .map(|t| Certificate::read_as(&self.source, "axis", t, output))
            .transpose()
    }
}

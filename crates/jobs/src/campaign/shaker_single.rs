//! `kind = "shaker-single"`: comparison of a single-axis accelerometer with a reference (ISO 16063-21).

use super::CampaignFile;
use super::shaker::{
    Certificate, CertificateTable, PhasorQuantity, RunTable, RunsTable, ShakerRecording,
    SingleAxisSeat, read_runs,
};
use super::shaker_triaxial::{Datasheet, waveform_options};
use proofmass_io::{Ambient, Device};
use proofmass_io::{Result, WaveformOptions};
use serde::Deserialize;

/// `[reading]`: standard uncertainties of the comparison beside those of the certificate.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReadingTable {
    /// Relative standard uncertainty of the ratio of the two outputs.
    pub u_relative: f64,
    /// Standard uncertainty of its phase, degrees.
    pub u_phase_deg: f64,
    /// Degrees of freedom of both; infinite when left out.
    pub dof: Option<f64>,
}

/// The tables of a comparison; the files they name are read by its methods.
#[derive(Clone, Debug, PartialEq)]
pub struct ShakerSingleCampaign {
    /// The file it was read from.
    pub source: CampaignFile,
    /// One line for the head of the report.
    pub title: Option<String>,
    /// The device under calibration.
    pub device: Device,
    /// Runs.
    pub runs: RunsTable,
    /// Waveforms.
    pub recording: Option<ShakerRecording>,
    /// Certificate of the reference.
    pub reference: CertificateTable,
    /// Uncertainty of a reading.
    pub reading: ReadingTable,
    /// Datasheet sensitivity and its tolerance, V/(m/s²).
    pub datasheet: Option<(f64, f64)>,
    /// Conditions.
    pub ambient: Ambient,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "kind")]
    _kind: String,
    title: Option<String>,
    #[serde(default)]
    device: Device,
    runs: RunsTable,
    recording: Option<ShakerRecording>,
    reference: CertificateTable,
    reading: ReadingTable,
    datasheet: Option<Datasheet>,
    #[serde(default)]
    ambient: Ambient,
}

impl ShakerSingleCampaign {
    /// Names of the channels, in the order of every run.
    pub const CHANNELS: [&str; 2] = ["reference", "output"];

    pub(crate) fn from_file(source: CampaignFile) -> Result<Self> {
        let file: File = source.parse()?;
        for (key, value) in [
            ("u_relative", Some(file.reading.u_relative)),
            ("u_phase_deg", Some(file.reading.u_phase_deg)),
            ("dof", file.reading.dof),
        ] {
            if let Some(v) = value
                && !(v.is_finite() && v >= 0.0)
            {
                return Err(source.refuse("reading", key, format!("{v} is impossible")));
            }
        }
        Ok(Self {
            title: file.title,
            device: file.device,
            runs: file.runs,
            recording: file.recording,
            reference: file.reference,
            reading: file.reading,
            datasheet: file.datasheet.map(|d| d.si(&source)).transpose()?,
            ambient: file.ambient,
            source,
        })
    }

    /// Reads the table of runs.
    ///
    /// # Errors
    /// As the table says, with line and column.
    pub fn read_runs(&self) -> Result<RunTable<SingleAxisSeat>> {
        const VOLTS: &[PhasorQuantity] = &[PhasorQuantity::Voltage];
        read_runs(
            &self.source,
            &self.runs,
            &[("reference", VOLTS), ("output", VOLTS)],
        )
    }

    /// How the waveforms are read.
    ///
    /// # Errors
    /// No `[recording]`, or a channel that is missing.
    pub fn waveform_options(&self) -> Result<WaveformOptions> {
        waveform_options(&self.source, self.recording.as_ref(), &Self::CHANNELS)
    }

    /// Reads the certificate of the reference.
    ///
    /// # Errors
    /// As the table says, with line and column.
    pub fn read_reference(&self) -> Result<Certificate> {
        Certificate::read(&self.source, &self.reference)
    }
}

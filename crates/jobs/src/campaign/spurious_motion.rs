//! `kind = "spurious-motion"`: what the table and the wedges do beside the excitation, by a vibrometer.

use super::shaker::{
    CertificateTable, PhasorQuantity, RunTable, RunsTable, ShakerRecording, SpuriousFile,
    SpuriousSeat, read_runs,
};
use super::shaker_single::{REFERENCES, reference_fits};
use super::shaker_triaxial::waveform_options;
use proofmass_io::{Result, WaveformOptions};
use serde::Deserialize;

/// `[vibrometer]`: its decoder, where the runs carry its volts, and what is uncertain of it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct VibrometerTable {
    /// Sensitivity in V/(m/s); none where the runs carry velocities.
    #[serde(rename = "sensitivity_V_per_m_s")]
    pub(crate) sensitivity: Option<f64>,
    /// Delay of the decoder behind the motion, s.
    #[serde(default)]
    pub(crate) delay_s: f64,
    /// Relative standard uncertainty of the sensitivity, by its certificate.
    #[serde(default)]
    pub(crate) relative_standard_uncertainty: f64,
    /// Standard uncertainty of the delay, s.
    #[serde(default)]
    pub(crate) delay_standard_uncertainty_s: f64,
}

/// `[[model]]`: spurious.csv of `proofmass modes`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ModelTable {
    /// Label in results.
    pub(crate) label: String,
    /// Table of calculated motion, relative to the campaign.
    pub(crate) file: String,
}

super::head::campaign! {
    /// The tables of a campaign of spurious motion; the files they name are read by its methods.
    pub struct SpuriousMotionCampaign {
        /// Runs: one repeat along one axis each.
        pub(crate) runs: RunsTable,
        /// Waveforms.
        pub(crate) recording: Option<ShakerRecording>,
        /// Certificate of the reference; `None` when the runs carry accelerations.
        pub(crate) reference: Option<CertificateTable>,
        /// The vibrometer; `None` when the runs carry velocities of which nothing is uncertain.
        pub(crate) vibrometer: Option<VibrometerTable>,
        /// Calculated motions to set beside the measured one.
        #[serde(default, rename = "model")]
        pub(crate) models: Vec<ModelTable>,
    }
}

impl SpuriousMotionCampaign {
    /// Names of the channels, in the order of every run.
    pub const CHANNELS: [&str; 2] = ["reference", "velocity"];

    /// Refuses values that are impossible, each with its line.
    pub(super) fn check(&self) -> Result<()> {
        let source = &self.source;
        if let Some(v) = &self.vibrometer {
            if let Some(sensitivity) = v.sensitivity
                && !(sensitivity.is_finite() && sensitivity != 0.0)
            {
                return Err(source
                    .refuse(
                        "vibrometer",
                        "sensitivity_V_per_m_s",
                        format!("{sensitivity} is impossible"),
                    )
                    .with_hint("a range of 10 mm/s per volt is 100 V/(m/s)"));
            }
            for (key, value, most, unit, hint) in [
                (
                    "relative_standard_uncertainty",
                    v.relative_standard_uncertainty,
                    0.1,
                    "",
                    "of 1 % with k = 2 it is 0.005",
                ),
                (
                    "delay_standard_uncertainty_s",
                    v.delay_standard_uncertainty_s,
                    0.01,
                    " s",
                    "of a delay that is known to a tenth of a microsecond it is 1e-7",
                ),
                (
                    "delay_s",
                    v.delay_s,
                    1.0,
                    " s",
                    "decoders delay by microseconds: 5.9e-6",
                ),
            ] {
                if !(0.0..most).contains(&value) {
                    return Err(source
                        .refuse("vibrometer", key, format!("{value}{unit} is out of place"))
                        .with_hint(hint));
                }
            }
        }
        Ok(())
    }

    /// Reads the table of runs.
    ///
    /// # Errors
    /// As the table says, with line and column; volts without certificate or vibrometer.
    pub(crate) fn read_runs(&self) -> Result<RunTable<SpuriousSeat>> {
        const VELOCITY: &[PhasorQuantity] = &[PhasorQuantity::Voltage, PhasorQuantity::Velocity];
        let table = read_runs(
            &self.source,
            &self.runs,
            &[("reference", REFERENCES), ("velocity", VELOCITY)],
        )?;
        reference_fits(&self.source, &table, self.reference.is_some())?;
        let velocity = table.quantities.get(1);
        let volts = velocity.is_none_or(|q| *q == PhasorQuantity::Voltage);
        let stated = self.vibrometer.and_then(|v| v.sensitivity);
        if volts != stated.is_some() {
            return Err(self
                .source
                .refuse(
                    "vibrometer",
                    "sensitivity_V_per_m_s",
                    if volts {
                        "the runs carry volts of the vibrometer, and its sensitivity is not stated"
                    } else {
                        "the runs carry velocities already, and the sensitivity would be applied twice"
                    },
                )
                .with_hint("velocity_V goes with sensitivity_V_per_m_s in [vibrometer], velocity_mm/s without"));
        }
        Ok(table)
    }

    /// Reads the calculated motions.
    ///
    /// # Errors
    /// As the tables say, with line and column.
    pub(crate) fn read_models(&self) -> Result<Vec<SpuriousFile>> {
        self.models
            .iter()
            .map(|m| SpuriousFile::read(self.source.source(&m.file)?, &m.label))
            .collect()
    }

    /// How the waveforms are read.
    ///
    /// # Errors
    /// No `[recording]`, or a channel that is missing.
    pub(crate) fn waveform_options(&self) -> Result<WaveformOptions> {
        waveform_options(&self.source, self.recording.as_ref(), &Self::CHANNELS)
    }
}

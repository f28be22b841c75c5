//! `kind = "spurious-motion"`: what the table and the wedges do beside the excitation, by a vibrometer.

use super::shaker::{
    CertificateTable, PhasorQuantity, RunTable, RunsTable, ShakerRecording, SpuriousFile,
    SpuriousSeat, read_runs,
};
use super::shaker_single::{REFERENCES, reference_fits};
use super::shaker_triaxial::waveform_options;
use proofmass_io::{Error, ErrorKind, Result, WaveformOptions};
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

/// Channels that are the velocity along an axis of the bench, x′ to z′.
const ALONG: [&str; 3] = ["velocity_x", "velocity_y", "velocity_z"];

impl SpuriousMotionCampaign {
    /// The reference, in every run.
    const REFERENCE: &str = "reference";
    /// The velocity along the axis of its row.
    const VELOCITY: &str = "velocity";

    /// The channels of velocity behind the reference, each with its axis; the rows say it where there is none. Several vibrometers
    /// stand in one record.
    ///
    /// # Errors
    /// A table of runs that cannot be read.
    pub(crate) fn velocities(&self) -> Result<Vec<(&'static str, Option<usize>)>> {
        let found: Vec<usize> = match &self.recording {
            Some(recording) => (0..3)
                .filter(|&axis| recording.channels.contains_key(ALONG[axis]))
                .collect(),
            None => {
                let (text, _) = self.source.text(&self.runs.file)?;
                let heading = text.lines().find(|l| !l.trim_start().starts_with('#'));
                let heading = heading.unwrap_or_default();
                let has = |axis: &usize| heading.contains(&format!("{}_", ALONG[*axis]));
                (0..3).filter(has).collect()
            }
        };
        Ok(match found.is_empty() {
            true => vec![(Self::VELOCITY, None)],
            false => found
                .iter()
                .map(|&axis| (ALONG[axis], Some(axis)))
                .collect(),
        })
    }

    /// Names of the channels, in the order of every run.
    fn channels(&self) -> Result<Vec<&'static str>> {
        let velocities = self.velocities()?.into_iter().map(|v| v.0);
        Ok(std::iter::once(Self::REFERENCE).chain(velocities).collect())
    }

    /// Standard uncertainty of the delay between reference and velocity of the front end, s: of several the largest.
    ///
    /// # Errors
    /// As [`Self::velocities`].
    pub(crate) fn front_end(&self) -> Result<f64> {
        let Some(recording) = &self.recording else {
            return Ok(0.0);
        };
        let velocities = self.velocities()?.into_iter();
        let largest = velocities
            .map(|v| recording.delay_uncertainty(v.0))
            .fold(0.0, f64::max);
        Ok(recording.delay_uncertainty(Self::REFERENCE).hypot(largest))
    }

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
                        format!(
                            "{sensitivity} is out of range: a sensitivity is finite and not zero"
                        ),
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
                        .refuse(
                            "vibrometer",
                            key,
                            format!("{value}{unit} is out of range: from 0 to below {most}{unit}"),
                        )
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
        let velocities = self.velocities()?;
        let mut channels = vec![(Self::REFERENCE, REFERENCES)];
        channels.extend(velocities.iter().map(|v| (v.0, VELOCITY)));
        let table = read_runs::<SpuriousSeat>(&self.source, &self.runs, &channels)?;
        // Either the row says the axis, or the channel does.
        let by_channel = velocities.iter().all(|v| v.1.is_some());
        if let Some(run) = table
            .runs
            .iter()
            .find(|r| r.seat.axis.is_some() == by_channel)
        {
            let (what, hint) = match by_channel {
                true => (
                    "the channels say the axis, and a column `axis` says it again",
                    "take the column out: velocity_x, velocity_y and velocity_z are along x′, y′ and z′",
                ),
                false => (
                    "the table of runs has no column `axis`",
                    "add a column axis with x, y or z, or name the channels velocity_x, velocity_y, velocity_z where several stand in one record",
                ),
            };
            return Err(Error::new(ErrorKind::Column, what)
                .at(&table.path)
                .line(run.line)
                .column("axis")
                .with_hint(hint));
        }
        reference_fits(&self.source, &table, self.reference.is_some())?;
        let velocity = table.quantities.get(1);
        if let Some(other) = table
            .quantities
            .iter()
            .skip(1)
            .find(|q| Some(*q) != velocity)
        {
            return Err(Error::new(
                ErrorKind::Column,
                format!("one velocity is in {velocity:?} and another in {other:?}").to_lowercase(),
            )
            .at(&table.path)
            .with_hint("give all of them in volts, or all as velocities"));
        }
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
        waveform_options(&self.source, self.recording.as_ref(), &self.channels()?)
    }
}

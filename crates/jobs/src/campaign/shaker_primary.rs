//! `kind = "shaker-primary"`: a single-axis accelerometer against a laser interferometer (ISO 16063-11).

use super::shaker::{Datasheet, RunTable, RunsTable, ShakerRecording, SingleAxisSeat, read_runs};
use super::shaker_single::TransverseTable;
use super::statement::{StatementTable, coverage_factor};
use proofmass_io::{Result, WaveformOptions};
use proofmass_shaker::interferometer::HELIUM_NEON_UNCERTAINTY;
use proofmass_shaker::primary::{DeclaredInput, PrimaryBudget};
use proofmass_shaker::recording::Drive;
use proofmass_uncertainty::DegreesOfFreedom;
use serde::Deserialize;

/// Which way the phase grows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum MotionSign {
    /// While the surface moves along the positive axis of the device.
    #[default]
    Along,
    /// While it moves against it.
    Against,
}

impl MotionSign {
    pub(crate) fn against(self) -> bool {
        self == Self::Against
    }
}

/// `[interferometer]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct InterferometerTable {
    /// Wavelength in the air of the path, nm.
    pub(crate) wavelength_nm: Option<f64>,
    /// Its relative standard uncertainty.
    pub(crate) u_wavelength_relative: Option<f64>,
    /// Relative standard uncertainty of the sampling rate.
    pub(crate) u_rate_relative: f64,
    /// Which way the phase grows.
    pub(crate) motion: MotionSign,
}

/// `[[budget]]`: an input that the samples do not show, alike in all runs.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DeclaredTable {
    /// Its key.
    pub(crate) name: String,
    /// What it is.
    pub(crate) description: Option<String>,
    /// Relative standard uncertainty of the modulus.
    #[serde(default)]
    pub(crate) u_relative: f64,
    /// Standard uncertainty of the phase, degrees.
    #[serde(default)]
    pub(crate) u_phase_deg: f64,
    /// Degrees of freedom; infinite when left out.
    pub(crate) dof: Option<f64>,
}

super::head::campaign! {
    /// The tables of a primary calibration; the files they name are read by its methods.
    pub struct ShakerPrimaryCampaign {
        /// Runs.
        pub(crate) runs: RunsTable,
        /// Waveforms.
        pub(crate) recording: ShakerRecording,
        /// The laser.
        #[serde(default)]
        pub(crate) interferometer: InterferometerTable,
        /// Inputs that the samples do not show.
        #[serde(default)]
        pub(crate) budget: Vec<DeclaredTable>,
        /// Transverse sensitivity and motion.
        pub(crate) transverse: Option<TransverseTable>,
        /// Sensitivity on the datasheet, and its tolerance.
        pub(crate) datasheet: Option<Datasheet>,
        /// How U is stated.
        #[serde(default)]
        pub(crate) method: StatementTable,
    }
}

/// Channels of a recording.
const CHANNELS: [&str; 3] = ["cosine", "sine", "output"];
/// Wavelengths of lasers, nm.
const LIGHT: std::ops::RangeInclusive<f64> = 150.0..=12_000.0;

impl ShakerPrimaryCampaign {
    /// Refuses values that are impossible, each with its line.
    pub(super) fn check(&self) -> Result<()> {
        let source = &self.source;
        coverage_factor(source, self.method.coverage_factor)?;
        let laser = &self.interferometer;
        let refuse = |key: &str, what: String| source.refuse("interferometer", key, what);
        if let Some(nm) = laser.wavelength_nm.filter(|nm| !LIGHT.contains(nm)) {
            let hint = match nm {
                nm if LIGHT.contains(&(1e9 * nm)) => format!(
                    "that is a wavelength in metres: write wavelength_nm = {:.4}",
                    1e9 * nm
                ),
                nm if LIGHT.contains(&(1e3 * nm)) => format!(
                    "that is a wavelength in micrometres: write wavelength_nm = {:.4}",
                    1e3 * nm
                ),
                _ => "nanometres, such as 632.8 of a helium-neon laser".to_owned(),
            };
            let what = format!("{nm} nm is no wavelength of a laser");
            return Err(refuse("wavelength_nm", what).with_hint(hint));
        }
        match (laser.wavelength_nm, laser.u_wavelength_relative) {
            (Some(_), None) => {
                return Err(refuse(
                    "wavelength_nm",
                    "the uncertainty of the wavelength is not stated".to_owned(),
                )
                .with_hint(
                    "add u_wavelength_relative: about 1.5e-6 for a free-running helium-neon laser whose air is known, 1e-8 for a stabilised one",
                ));
            }
            (None, Some(_)) => {
                return Err(refuse(
                    "u_wavelength_relative",
                    "the wavelength that it belongs to is not stated".to_owned(),
                )
                .with_hint("add wavelength_nm, the wavelength in the air of the path"));
            }
            _ => {}
        }
        for (key, value) in [
            ("u_wavelength_relative", laser.u_wavelength_relative),
            ("u_rate_relative", Some(laser.u_rate_relative)),
        ] {
            if let Some(v) = value.filter(|v| !(0.0..0.1).contains(v)) {
                let what = format!(
                    "a relative standard uncertainty of {v} is out of range: from 0 to below 0.1"
                );
                return Err(refuse(key, what)
                    .with_hint("give a share of the value: 1e-6 is a millionth of it"));
            }
        }
        for (k, input) in self.budget.iter().enumerate() {
            let of = |key: &str, what: String| Err(source.refuse("budget", key, what));
            let fine = |v: f64| v.is_finite() && v >= 0.0;
            if input.name.is_empty() {
                return of("name", "an input of the budget has no name".to_owned());
            }
            if self.budget[..k].iter().any(|b| b.name == input.name) {
                return of("name", format!("\"{}\" stands twice", input.name));
            }
            if !fine(input.u_relative) || !fine(input.u_phase_deg) {
                return of(
                    "u_relative",
                    format!(
                        "\"{}\": u_relative and u_phase_deg must not be negative",
                        input.name
                    ),
                );
            }
            if let Some(dof) = input.dof.filter(|d| DegreesOfFreedom::new(*d).is_none()) {
                return of(
                    "dof",
                    format!("{dof} is out of range: degrees of freedom must be positive"),
                );
            }
        }
        if let Some(transverse) = &self.transverse {
            transverse.check(source)?;
        }
        if let Some(datasheet) = &self.datasheet {
            datasheet.si(source)?;
        }
        if self.recording.drive() != Drive::Sine {
            return Err(source
                .refuse(
                    "recording",
                    "drive",
                    "an interferometer is read at one frequency in a recording",
                )
                .with_hint("record every frequency by itself, and take `drive` out"));
        }
        Ok(())
    }

    /// Reads the table of runs.
    ///
    /// # Errors
    /// As the table says, with line and column; phasors in place of recordings, several frequencies in one.
    pub(crate) fn read_runs(&self) -> Result<RunTable<SingleAxisSeat>> {
        let table = read_runs(&self.source, &self.runs, &[])?;
        if let Some(rows) = table.runs.windows(2).find(|w| w[0].line == w[1].line) {
            return Err(self
                .source
                .refuse(
                    "runs",
                    "file",
                    format!("run \"{}\" has several frequencies", rows[0].run),
                )
                .with_hint("record every frequency by itself"));
        }
        Ok(table)
    }

    /// How the waveforms are read.
    ///
    /// # Errors
    /// A channel that is missing.
    pub(crate) fn waveform_options(&self) -> Result<WaveformOptions> {
        self.recording.options(&self.source, &CHANNELS)
    }

    /// What is known of the bench beside the recordings.
    pub(crate) fn budget(&self) -> PrimaryBudget {
        let [cosine, sine, output] = CHANNELS.map(|c| self.recording.delay_uncertainty(c));
        let laser = &self.interferometer;
        let declared = self.budget.iter().map(|b| DeclaredInput {
            name: b.name.clone(),
            description: b.description.clone().unwrap_or_else(|| b.name.clone()),
            relative: b.u_relative,
            phase: b.u_phase_deg.to_radians(),
            dof: b
                .dof
                .and_then(DegreesOfFreedom::new)
                .unwrap_or(DegreesOfFreedom::INFINITE),
        });
        PrimaryBudget {
            wavelength: laser
                .u_wavelength_relative
                .unwrap_or(HELIUM_NEON_UNCERTAINTY),
            clock: laser.u_rate_relative,
            front_end: output.hypot(0.5 * cosine.hypot(sine)),
            transverse: self.transverse.map(|t| t.shares()),
            declared: declared.collect(),
        }
    }
}

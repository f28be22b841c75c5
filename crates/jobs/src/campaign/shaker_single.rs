//! `kind = "shaker-single"`: comparison of a single-axis accelerometer with a reference (ISO 16063-21).

use super::CampaignFile;
use super::shaker::{
    Certificate, CertificateTable, Datasheet, OutputRecording, PhasorQuantity, RunTable, RunsTable,
    ShakerRecording, SingleAxisSeat, read_runs,
};
use super::shaker_triaxial::{of_the_bench, waveform_options};
use super::statement::{StatementTable, coverage_factor};
use crate::device_output::DeviceOutput;
use proofmass_documents::Device;
use proofmass_io::{Result, WaveformOptions};
use proofmass_shaker::single_axis::TransverseMotion;
use serde::Deserialize;

/// `[reading]`: standard uncertainties of the comparison beside those of the certificate.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ReadingTable {
    /// Relative standard uncertainty of the ratio of the two outputs in one run; the mean of repeats keeps it, beside their
    /// scatter.
    pub(crate) u_relative: f64,
    /// Standard uncertainty of its phase, degrees.
    pub(crate) u_phase_deg: f64,
    /// Degrees of freedom of both; infinite when left out.
    pub(crate) dof: Option<f64>,
}

/// `[transverse]`: what a motion of the table across the axis does.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TransverseTable {
    /// Transverse sensitivity of the device, per cent of the sensitivity along its axis.
    #[serde(rename = "sensitivity_%")]
    pub(crate) sensitivity: f64,
    /// Largest transverse motion of the table, per cent, where the runs do not say it.
    #[serde(rename = "motion_%")]
    pub(crate) motion: Option<f64>,
}

impl TransverseTable {
    /// Refuses per cents that are impossible.
    pub(super) fn check(&self, source: &CampaignFile) -> Result<()> {
        for (key, value) in [
            ("sensitivity_%", Some(self.sensitivity)),
            ("motion_%", self.motion),
        ] {
            if let Some(v) = value.filter(|v| !(0.0..=100.0).contains(v)) {
                let what = format!("{v} % is out of range: from 0 % to 100 %");
                return Err(source
                    .refuse("transverse", key, what)
                    .with_hint("give per cent, such as 2"));
            }
        }
        Ok(())
    }

    /// The same as shares.
    pub(crate) fn shares(&self) -> TransverseMotion {
        TransverseMotion {
            sensitivity: self.sensitivity / 100.0,
            largest: self.motion.map(|m| m / 100.0),
        }
    }
}

/// `[[devices]]`: one of several devices on the table at once.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DeviceChannel {
    /// Its channel, which is also the name of the folder of its result.
    pub(crate) channel: String,
    /// Maker, where it is not that of `[device]`.
    pub(crate) manufacturer: Option<String>,
    /// Type, where it is not that of `[device]`.
    pub(crate) model: Option<String>,
    /// Serial number.
    pub(crate) serial: Option<String>,
    /// Anything else worth filing.
    pub(crate) description: Option<String>,
}

/// `[check_standard]`: a device of known sensitivity on the same table.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CheckStandardTable {
    /// Its channel.
    #[serde(default = "check")]
    pub(crate) channel: String,
    /// Its calibration: the table of a laboratory (`.csv`), a calibration.json or a result.json, relative to the campaign.
    pub(crate) file: String,
    /// Coverage factor of the columns `U_…`.
    pub(crate) k: Option<f64>,
    /// Axis of a calibration of several.
    pub(crate) axis: Option<String>,
    /// Number of a certificate that is taken although nobody checked its signature.
    pub(crate) accept_unchecked_signature: Option<String>,
}

fn check() -> String {
    "check".to_owned()
}

/// What the reference of a run may be.
pub(super) const REFERENCES: &[PhasorQuantity] =
    &[PhasorQuantity::Voltage, PhasorQuantity::Acceleration];
/// What a device may give.
pub(super) const OUTPUTS: &[PhasorQuantity] = &[
    PhasorQuantity::Voltage,
    PhasorQuantity::Acceleration,
    PhasorQuantity::Count,
];

/// Volts of a reference need a certificate, accelerations need none.
pub(super) fn reference_fits<S>(
    source: &CampaignFile,
    table: &RunTable<S>,
    certificate: bool,
) -> Result<()> {
    let acceleration = table.quantities.first() == Some(&PhasorQuantity::Acceleration);
    let what = match (certificate, acceleration) {
        (true, true) => {
            "the runs carry accelerations already, and a certificate would be applied twice"
        }
        (false, false) => "the runs carry volts of the reference, and no certificate is named",
        _ => return Ok(()),
    };
    Err(source
        .refuse("reference", "file", what)
        .with_hint("reference_V goes with [reference], reference_m/s2 without"))
}

super::head::campaign! {
    /// The tables of a comparison; the files they name are read by its methods.
    pub struct ShakerSingleCampaign {
        /// Its channel.
        #[serde(skip)]
        pub(crate) channel: String,
        /// All devices on the table, where they are several.
        #[serde(default)]
        pub(crate) devices: Vec<DeviceChannel>,
        /// A device of known sensitivity on the same table.
        pub(crate) check_standard: Option<CheckStandardTable>,
        /// Runs.
        pub(crate) runs: RunsTable,
        /// Waveforms.
        pub(crate) recording: Option<ShakerRecording>,
        /// Files of a sensor that records by itself.
        pub(crate) output_recording: Option<OutputRecording>,
        /// Certificate of the reference; `None` when the runs carry accelerations.
        pub(crate) reference: Option<CertificateTable>,
        /// Uncertainty of a reading.
        pub(crate) reading: ReadingTable,
        /// Transverse sensitivity and motion.
        pub(crate) transverse: Option<TransverseTable>,
        /// Sensitivity on the datasheet, and its tolerance.
        pub(crate) datasheet: Option<Datasheet>,
        /// How U is stated.
        #[serde(default)]
        pub(crate) method: StatementTable,
    }
}

impl ShakerSingleCampaign {
    /// Refuses values that are impossible, each with its line; names the first device.
    pub(super) fn check(&mut self) -> Result<()> {
        let source = &self.source;
        coverage_factor(source, self.method.coverage_factor)?;
        for (key, value) in [
            ("u_relative", Some(self.reading.u_relative)),
            ("u_phase_deg", Some(self.reading.u_phase_deg)),
            ("dof", self.reading.dof),
        ] {
            let least = if key == "dof" { f64::MIN_POSITIVE } else { 0.0 };
            if let Some(v) = value
                && !(v.is_finite() && v >= least)
            {
                let (rule, hint) = match key {
                    "dof" => (
                        "degrees of freedom must be positive",
                        "leave it out for infinite",
                    ),
                    _ => (
                        "a standard uncertainty must not be negative",
                        "give a number from zero up",
                    ),
                };
                return Err(source
                    .refuse("reading", key, format!("{v} is out of range: {rule}"))
                    .with_hint(hint));
            }
        }
        if let Some(transverse) = &self.transverse {
            transverse.check(source)?;
        }
        self.channels_differ()?;
        if let Some(datasheet) = &self.datasheet {
            datasheet.si(source)?;
        }
        // Of several each has its own, from what they have in common.
        self.channel = "output".to_owned();
        if let Some(first) = self.devices.first() {
            self.channel = first.channel.clone();
            self.device = first.merged(&self.device);
        }
        Ok(())
    }

    /// Names of the channels, in the order of every run: the reference, the devices, the check standard.
    pub fn channels(&self) -> Vec<&str> {
        let mut names = vec!["reference"];
        if self.devices.is_empty() {
            names.push(&self.channel);
        } else {
            names.extend(self.devices.iter().map(|d| d.channel.as_str()));
        }
        names.extend(self.check_standard.as_ref().map(|c| c.channel.as_str()));
        names
    }

    /// One campaign for each device, with its channel; the campaign itself where there is one.
    pub fn of_each_device(self) -> Vec<Self> {
        if self.devices.len() < 2 {
            return vec![self];
        }
        let common = self.device.clone();
        let of = |device: &DeviceChannel| Self {
            channel: device.channel.clone(),
            device: device.merged(&common),
            ..self.clone()
        };
        self.devices.iter().map(of).collect()
    }

    /// Every channel has a name of its own, which is good for a folder.
    fn channels_differ(&self) -> Result<()> {
        let source = &self.source;
        let mut seen = vec!["reference"];
        let devices = self.devices.iter().map(|d| ("devices", &d.channel));
        let check = self.check_standard.iter();
        let check = check.map(|c| ("check_standard", &c.channel));
        for (table, name) in devices.chain(check) {
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            if name.is_empty() || !name.chars().all(plain) {
                return Err(source
                .refuse(table, "channel", format!("{name:?} is no name of a channel"))
                .with_hint("letters, digits, - and _: the results of a device stand in a folder of that name"));
            }
            if seen.contains(&name.as_str()) {
                return Err(source
                .refuse(table, "channel", format!("the channel {name:?} stands twice"))
                .with_hint("every device has a channel of its own, and `reference` is that of the reference"));
            }
            seen.push(name);
        }
        if self.devices.len() > 1 && self.device.serial.is_some() {
            return Err(source
                .refuse(
                    "device",
                    "serial",
                    "several devices cannot have one serial number",
                )
                .with_hint(
                    "write it to each of [[devices]]; [device] holds what they have in common",
                ));
        }
        Ok(())
    }

    /// Reads the table of runs.
    ///
    /// # Errors
    /// As the table says, with line and column; volts of a reference without a certificate, accelerations with one.
    pub(crate) fn read_runs(&self) -> Result<RunTable<SingleAxisSeat>> {
        let names = self.channels();
        let channels: Vec<(&str, &[PhasorQuantity])> = names
            .iter()
            .map(|name| {
                (
                    *name,
                    if *name == "reference" {
                        REFERENCES
                    } else {
                        OUTPUTS
                    },
                )
            })
            .collect();
        let table = read_runs(&self.source, &self.runs, &channels)?;
        reference_fits(&self.source, &table, self.reference.is_some())?;
        Ok(table)
    }

    /// How the waveforms are read.
    ///
    /// # Errors
    /// No `[recording]`, or a channel that is missing.
    pub(crate) fn waveform_options(&self) -> Result<WaveformOptions> {
        let names = of_the_bench(&self.channels(), self.output_recording.as_ref());
        waveform_options(&self.source, self.recording.as_ref(), &names)
    }

    /// Reads the calibration of the check standard, whose channel has this output.
    ///
    /// # Errors
    /// As the table says, with line and column.
    pub(crate) fn read_check_standard(&self, output: DeviceOutput) -> Result<Option<Certificate>> {
        let Some(check) = &self.check_standard else {
            return Ok(None);
        };
        let table = CertificateTable {
            file: check.file.clone(),
            k: check.k,
            description: None,
            axis: check.axis.clone(),
            model: None,
            accept_unchecked_signature: check.accept_unchecked_signature.clone(),
        };
        Certificate::read_as(&self.source, "check_standard", &table, output).map(Some)
    }
}

impl DeviceChannel {
    fn merged(&self, common: &Device) -> Device {
        let or = |own: &Option<String>, all: &Option<String>| own.clone().or_else(|| all.clone());
        Device {
            manufacturer: or(&self.manufacturer, &common.manufacturer),
            model: or(&self.model, &common.model),
            serial: self.serial.clone(),
            description: or(&self.description, &common.description),
        }
    }
}

//! `kind = "shaker-triaxial"`: a triaxial accelerometer on a single-axis shaker, by wedges and rotations.

use super::CampaignFile;
use super::shaker::{
    BudgetSource, CampaignPlan, CertificateTable, ConditionerTable, Mounting, MountingTable,
    OutputRecording, PhasorQuantity, RunTable, RunsTable, ShakerBudget, ShakerRecording, ShakerRun,
    SpuriousFile, TriaxialDatasheet, read_runs,
};
use super::shaker_single::{REFERENCES, reference_fits};
use super::statement::coverage_factor;
use crate::device_output::DeviceOutput;
use proofmass_io::{Error, ErrorKind, Result, WaveformOptions};
use proofmass_shaker::datasheet::Datasheet;
use proofmass_shaker::geometry::published_plan;
use proofmass_shaker::{Correction, ShakerMethod, SpuriousTable, UnmeasuredMotion};
use proofmass_uncertainty::Finding;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Most trials of the check: an hour of a small campaign on one core.
const MOST_TRIALS: u64 = 100_000_000;

/// `[method]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ShakerMethods {
    /// Calculations to set side by side; the first is the result.
    pub(crate) methods: Vec<ShakerMethod>,
    /// Monte Carlo trials for the check of the propagation; zero for none.
    pub(crate) trials: u64,
    /// Seed of the random numbers.
    pub(crate) seed: u64,
    /// Coverage factor of the stated U, such as 2; else that of 95 %.
    pub(crate) coverage_factor: Option<f64>,
}

impl Default for ShakerMethods {
    fn default() -> Self {
        Self {
            methods: vec![ShakerMethod::Joint, ShakerMethod::Complex],
            trials: 10_000,
            seed: 1,
            coverage_factor: None,
        }
    }
}

/// `[published]`: inputs of the published method, where they are not those that were printed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct PublishedInputs {
    /// Relative standard uncertainty of an output, u_S.
    pub(crate) output: f64,
    /// Relative standard uncertainty of the reference.
    pub(crate) reference: f64,
    /// Half width of the inclination, degrees.
    pub(crate) inclination_deg: f64,
    /// Half width of the rotation, degrees.
    pub(crate) rotation_deg: f64,
}

impl Default for PublishedInputs {
    fn default() -> Self {
        Self {
            output: 0.0035,
            reference: 0.002,
            inclination_deg: 0.1,
            rotation_deg: 1.0,
        }
    }
}

/// `[[correction]]`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CorrectionTable {
    /// Label in results.
    pub(crate) label: String,
    /// Table of spurious motion, relative to the campaign; none is no correction.
    pub(crate) file: Option<String>,
    /// Whether the motion was read beside the reference of this campaign, with the same calibration: its error is then in both and goes out.
    /// Asked for where the table states an uncertainty of the reference.
    pub(crate) same_reference: Option<bool>,
}

/// `[plan]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PlanTable {
    /// Table of inclinations and rotations, relative to the campaign.
    pub(crate) file: Option<String>,
    /// `published`: the 44 published configurations.
    pub(crate) name: Option<String>,
    /// Acceleration wanted, m/s², where the runs do not say it.
    #[serde(rename = "amplitude_m_per_s2")]
    pub(crate) amplitude: Option<f64>,
}

/// `[shaker]`: what the shaker can do, by its data sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ShakerTable {
    /// Largest displacement from peak to peak, mm.
    #[serde(rename = "stroke_mm", skip_serializing_if = "Option::is_none")]
    pub(crate) stroke_mm: Option<f64>,
    /// Largest velocity, m/s.
    #[serde(rename = "velocity_m_per_s", skip_serializing_if = "Option::is_none")]
    pub(crate) velocity: Option<f64>,
    /// Largest acceleration with the bare table, m/s².
    #[serde(
        rename = "acceleration_m_per_s2",
        skip_serializing_if = "Option::is_none"
    )]
    pub(crate) acceleration: Option<f64>,
    /// Largest force of a sine, peak, N.
    #[serde(rename = "force_N", skip_serializing_if = "Option::is_none")]
    pub(crate) force: Option<f64>,
    /// Mass of the moving table, kg.
    #[serde(rename = "table_mass_kg", skip_serializing_if = "Option::is_none")]
    pub(crate) table_mass: Option<f64>,
    /// Mass on it: wedge, device, reference, kg.
    #[serde(rename = "payload_kg", skip_serializing_if = "Option::is_none")]
    pub(crate) payload: Option<f64>,
    /// Largest mass that may lie on it, kg.
    #[serde(rename = "largest_payload_kg", skip_serializing_if = "Option::is_none")]
    pub(crate) largest_payload: Option<f64>,
    /// Lowest frequency, Hz.
    #[serde(
        rename = "lowest_frequency_Hz",
        skip_serializing_if = "Option::is_none"
    )]
    pub(crate) lowest: Option<f64>,
    /// Highest frequency, Hz.
    #[serde(
        rename = "highest_frequency_Hz",
        skip_serializing_if = "Option::is_none"
    )]
    pub(crate) highest: Option<f64>,
}

impl ShakerTable {
    /// Each key with its number.
    pub(crate) fn numbers(&self) -> [(&'static str, Option<f64>); 9] {
        [
            ("stroke_mm", self.stroke_mm),
            ("velocity_m_per_s", self.velocity),
            ("acceleration_m_per_s2", self.acceleration),
            ("force_N", self.force),
            ("table_mass_kg", self.table_mass),
            ("payload_kg", self.payload),
            ("largest_payload_kg", self.largest_payload),
            ("lowest_frequency_Hz", self.lowest),
            ("highest_frequency_Hz", self.highest),
        ]
    }

    /// Largest acceleration at a frequency in Hz, and what limits it.
    pub(crate) fn reach(&self, frequency: f64) -> Option<(f64, &'static str)> {
        let omega = std::f64::consts::TAU * frequency;
        let mass = self.table_mass.unwrap_or(0.0) + self.payload.unwrap_or(0.0);
        let limits = [
            // Half of the way from peak to peak.
            (self.stroke_mm.map(|d| 0.5e-3 * d * omega * omega), "stroke"),
            (self.velocity.map(|v| v * omega), "velocity"),
            (self.acceleration, "acceleration"),
            (self.force.filter(|_| mass > 0.0).map(|f| f / mass), "force"),
        ];
        let known = limits.into_iter().filter_map(|(a, why)| Some((a?, why)));
        known.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Why a point cannot be measured: acceleration in m/s² at a frequency in Hz.
    pub(crate) fn beyond(&self, frequency: f64, amplitude: f64) -> Option<String> {
        if let Some(low) = self.lowest.filter(|low| frequency < *low) {
            return Some(format!("below its lowest frequency of {low} Hz"));
        }
        if let Some(high) = self.highest.filter(|high| frequency > *high) {
            return Some(format!("above its highest frequency of {high} Hz"));
        }
        let (most, why) = self.reach(frequency)?;
        (amplitude > most).then(|| {
            format!(
                "its {why} allows {} m/s²",
                proofmass_report::scientific(most, 3)
            )
        })
    }
}

super::head::campaign! {
    /// The tables of a campaign on the shaker; the files they name are read by its methods.
    pub struct ShakerTriaxialCampaign {
        /// Runs; a plan may do without.
        pub(crate) runs: Option<RunsTable>,
        /// Waveforms.
        pub(crate) recording: Option<ShakerRecording>,
        /// Files of a sensor that records by itself.
        pub(crate) output_recording: Option<OutputRecording>,
        /// Certificate of the reference; `None` when the runs carry accelerations.
        pub(crate) reference: Option<CertificateTable>,
        /// Gains of the conditioner, by channel: the readings are divided by them, so that S is that of the device itself.
        #[serde(default)]
        pub(crate) conditioner: BTreeMap<String, ConditionerTable>,
        /// Ratio of another mounting to that of the runs, over frequency: the result is that of the other mounting.
        pub(crate) mounting: Option<MountingTable>,
        /// Corrections to set side by side.
        #[serde(default, rename = "correction")]
        pub(crate) corrections: Vec<CorrectionTable>,
        /// How large the motion of the bench may be where no correction says it, relative to the excitation; the runs tell it
        /// without this table.
        pub(crate) unmeasured_motion: Option<UnmeasuredMotion>,
        /// Methods.
        #[serde(default)]
        pub(crate) method: ShakerMethods,
        /// Inputs of the published method.
        #[serde(default)]
        pub(crate) published: PublishedInputs,
        /// What the maker states: sensitivity with its tolerance, of all axes or of each, bands of frequencies, transverse sensitivity.
        pub(crate) datasheet: Option<TriaxialDatasheet>,
        /// Plan.
        pub(crate) plan: Option<PlanTable>,
        /// What the shaker can do: a plan says which points are beyond it.
        pub(crate) shaker: Option<ShakerTable>,
        /// Results of `modes` of the wedges, by file.
        #[serde(default)]
        pub(crate) fixtures: Vec<String>,
        /// What is uncertain on the bench.
        #[serde(default)]
        budget: BudgetSource,
    }
}

impl ShakerTriaxialCampaign {
    /// Refuses values that are impossible, each with its line.
    pub(super) fn check(&self) -> Result<()> {
        self.datasheet()?;
        let methods = &self.method.methods;
        if methods.is_empty() {
            return Err(self
                .source
                .refuse("method", "methods", "no method is named")
                .with_hint(
                    "some of \"joint\", \"complex\", \"published\"; the first is the result",
                ));
        }
        if methods[0] == ShakerMethod::PublishedMagnitude && methods.len() > 1 {
            return Err(self
                .source
                .refuse(
                    "method",
                    "methods",
                    "the published method is for comparison only and cannot be the first",
                )
                .with_hint("put \"joint\" or \"complex\" before it"));
        }
        coverage_factor(&self.source, self.method.coverage_factor)?;
        if (1..10_000).contains(&self.method.trials) {
            return Err(self
                .source
                .refuse(
                    "method",
                    "trials",
                    format!("{} trials are too few to check the ends of an interval", self.method.trials),
                )
                .with_hint("10 000 (the default) or more, or 0 for no check: the tolerance of one digit of u takes that many"));
        }
        if self.method.trials > MOST_TRIALS {
            return Err(self
                .source
                .refuse(
                    "method",
                    "trials",
                    format!("{} trials, {MOST_TRIALS} at most", self.method.trials),
                )
                .with_hint("10 000 trials suffice for one digit of u; each further digit needs 100 times as many"));
        }
        for (i, a) in self.corrections.iter().enumerate() {
            if self.corrections[..i].iter().any(|b| b.label == a.label) {
                return Err(self.source.refuse(
                    "correction",
                    "label",
                    format!("the label \"{}\" is given twice", a.label),
                ));
            }
        }
        let impossible = self
            .unmeasured_motion
            .and_then(|motion| motion.impossible());
        if let Some((key, value)) = impossible {
            return Err(self
                .source
                .refuse(
                    "unmeasured_motion",
                    key,
                    format!("{value} is out of range: the motion must not be negative"),
                )
                .with_hint("a ratio to the excitation, such as 0.01 for 1 %; 0 for none"));
        }
        for (key, value) in [
            ("output", self.published.output),
            ("reference", self.published.reference),
            ("inclination_deg", self.published.inclination_deg),
            ("rotation_deg", self.published.rotation_deg),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(self
                    .source
                    .refuse(
                        "published",
                        key,
                        format!(
                            "{value} is out of range: a standard uncertainty must not be negative"
                        ),
                    )
                    .with_hint("give a number from zero up"));
            }
        }
        if let Some(shaker) = &self.shaker {
            for (key, value) in shaker.numbers() {
                if let Some(v) = value
                    && !(v.is_finite() && v > 0.0)
                {
                    return Err(self
                        .source
                        .refuse("shaker", key, format!("{v} is not a positive number"))
                        .with_hint("the data sheet of the shaker states it"));
                }
            }
            if shaker.force.is_some() && shaker.table_mass.is_none() && shaker.payload.is_none() {
                return Err(self
                    .source
                    .refuse(
                        "shaker",
                        "force_N",
                        "a force limits an acceleration by the mass it moves",
                    )
                    .with_hint("add table_mass_kg and payload_kg"));
            }
        }
        if let Some(plan) = &self.plan {
            match (&plan.file, &plan.name) {
                (Some(_), Some(_)) => {
                    return Err(self.source.refuse(
                        "plan",
                        "name",
                        "`file` and `name` exclude each other",
                    ));
                }
                (None, Some(name)) if name != "published" => {
                    return Err(self
                        .source
                        .refuse("plan", "name", format!("unknown plan \"{name}\""))
                        .with_hint("known: published"));
                }
                _ => {}
            }
            if let Some(a) = plan.amplitude
                && !(a.is_finite() && a > 0.0)
            {
                return Err(self.source.refuse(
                    "plan",
                    "amplitude_m_per_s2",
                    format!("{a} is not a positive number"),
                ));
            }
        }
        Ok(())
    }

    /// What the models of the wedges say about points (inclination in rad, frequency in Hz) of the campaign or of a plan.
    ///
    /// # Errors
    /// As [`read_fixtures`](crate::modes::read_fixtures).
    pub fn fixture_findings(&self, points: &[(f64, f64)]) -> Result<Vec<Finding>> {
        let fixtures = crate::modes::read_fixtures(&self.source, &self.fixtures)?;
        Ok(crate::modes::fixture_findings(&fixtures, points))
    }

    /// What the datasheet states, in what the device gives per m/s².
    pub(crate) fn datasheet(&self) -> Result<Option<Datasheet>> {
        let Some(datasheet) = &self.datasheet else {
            return Ok(None);
        };
        let outputs = match &self.output_recording {
            Some(sensor) => sensor.output(&self.source)?,
            None => DeviceOutput::Volt,
        };
        datasheet.si(&self.source, outputs).map(Some)
    }

    /// What the device gives: volts, or what its own files hold.
    ///
    /// # Errors
    /// A unit that no accelerometer gives, a channel of the device in the recording of the bench.
    pub fn output(&self) -> Result<DeviceOutput> {
        let Some(sensor) = &self.output_recording else {
            return Ok(DeviceOutput::Volt);
        };
        for name in &Self::CHANNELS[1..] {
            if !sensor.channels.contains_key(*name) {
                return Err(self
                    .source
                    .refuse("output_recording", "channels", format!("the channel \"{name}\" is missing"))
                    .with_hint("all three outputs of a triaxial sensor stand in one file: channels = { x = \"acc_x\", y = \"acc_y\", z = \"acc_z\" }"));
            }
        }
        sensor.output(&self.source)
    }

    /// Names of the channels, in the order of every run.
    pub const CHANNELS: [&str; 4] = ["reference", "x", "y", "z"];

    /// Reads the table of runs.
    ///
    /// # Errors
    /// As the table says, with line and column.
    pub(crate) fn read_runs(&self) -> Result<RunTable<Mounting>> {
        const OUTPUT: &[PhasorQuantity] = &[PhasorQuantity::Voltage];
        let Some(runs) = &self.runs else {
            return Err(self
                .source
                .refuse("runs", "file", "the campaign names no runs")
                .with_hint("add [runs] with file = \"runs.csv\""));
        };
        let table = read_runs(
            &self.source,
            runs,
            &[
                ("reference", REFERENCES),
                ("x", OUTPUT),
                ("y", OUTPUT),
                ("z", OUTPUT),
            ],
        )?;
        self.angles_are_degrees(&table)?;
        reference_fits(&self.source, &table, self.reference.is_some())?;
        Ok(table)
    }

    /// Radians that stand under a heading in degrees are a plan within six degrees.
    fn angles_are_degrees(&self, table: &RunTable<Mounting>) -> Result<()> {
        type Angle = fn(&Mounting) -> f64;
        let angles: [(&str, f64, Angle); 2] = [
            ("inclination", 1.01 * std::f64::consts::PI, |m| {
                m.configuration.inclination
            }),
            ("rotation", 1.01 * std::f64::consts::TAU, |m| {
                m.configuration.rotation
            }),
        ];
        for (name, limit, of) in angles {
            let mut sizes: Vec<f64> = table
                .runs
                .iter()
                .map(|r| of(&r.seat).to_degrees().abs())
                .collect();
            sizes.sort_by(f64::total_cmp);
            sizes.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
            let largest = sizes.last().copied().unwrap_or(0.0);
            if sizes.len() > 2 && largest < limit {
                return Err(Error::new(
                    ErrorKind::Column,
                    format!("no {name} exceeds {largest:.4}°: these look like radians"),
                )
                .at(&table.path)
                .column(format!("{name}_deg"))
                .with_hint(format!("write {name}_rad into the heading; a plan within a few degrees does not determine S across it")));
            }
        }
        Ok(())
    }

    /// How the waveforms are read.
    ///
    /// # Errors
    /// No `[recording]`, or a channel that is missing.
    pub(crate) fn waveform_options(&self) -> Result<WaveformOptions> {
        let names = of_the_bench(&Self::CHANNELS, self.output_recording.as_ref());
        waveform_options(&self.source, self.recording.as_ref(), &names)
    }

    /// Refuses a correction of which no line is of a wedge and a frequency of the runs: nothing would be corrected by it.
    ///
    /// # Errors
    /// With the first line of the table and the first run.
    pub(crate) fn meets(
        &self,
        corrections: &[SpuriousFile],
        runs: &[ShakerRun<Mounting>],
    ) -> Result<()> {
        for SpuriousFile { correction, .. } in corrections {
            let table = &correction.table;
            let met = |r: &ShakerRun<Mounting>| {
                let inclination = r.seat.configuration.inclination;
                table.get(inclination, r.frequency_hz).is_some()
            };
            let (Some(line), Some(run)) = (table.entries.first(), runs.first()) else {
                continue;
            };
            if runs.iter().any(met) {
                continue;
            }
            let said = format!(
                "the table of \"{}\" has no line of a wedge and a frequency of the runs: its first is of {:.4}° at {} Hz, the first run of {:.4}° at {} Hz",
                correction.label,
                line.inclination.to_degrees(),
                line.frequency,
                run.seat.configuration.inclination.to_degrees(),
                run.frequency_hz
            );
            return Err(self.source.refuse("correction", "file", said).with_hint(
                "check its columns of inclination (degrees) and frequency (hertz), or name the table that was measured on this bench",
            ));
        }
        Ok(())
    }

    /// Reads the tables of spurious motion.
    ///
    /// # Errors
    /// As the tables say, with line and column.
    pub(crate) fn read_corrections(&self) -> Result<Vec<SpuriousFile>> {
        self.corrections
            .iter()
            .map(|c| match &c.file {
                Some(file) => {
                    let mut file = SpuriousFile::read(self.source.source(file)?, &c.label)?;
                    let common = &mut file.correction.table.common;
                    let asked = common.at.iter().flat_map(|c| c.reference).any(|u| u > 0.0);
                    if asked && c.same_reference.is_none() {
                        return Err(self
                            .source
                            .refuse(
                                "correction",
                                "label",
                                format!(
                                    "{} states an uncertainty of the reference beside the vibrometer, and whether that is the reference of this campaign is not said",
                                    c.label
                                ),
                            )
                            .with_hint(
                                "add same_reference = true where it is the same one with the same calibration (its error goes out), else false",
                            ));
                    }
                    common.same_reference = c.same_reference.unwrap_or(false);
                    Ok(file)
                }
                None => Ok(SpuriousFile {
                    input: None,
                    correction: Correction {
                        label: c.label.clone(),
                        table: SpuriousTable::default(),
                    },
                }),
            })
            .collect()
    }

    /// Reads the budget.
    ///
    /// # Errors
    /// None is stated, or an entry is wrong (with its line).
    pub fn read_budget(&self) -> Result<ShakerBudget> {
        ShakerBudget::read(&self.source, &self.budget, self.output()?)
    }

    /// Reads the plan.
    ///
    /// # Errors
    /// As the table says, with line and column.
    pub(crate) fn read_plan(&self) -> Result<Option<CampaignPlan>> {
        match self.plan.as_ref().map(|p| (&p.file, &p.name)) {
            Some((Some(file), _)) => super::shaker::read_plan(self.source.source(file)?).map(Some),
            Some((None, Some(_))) => Ok(Some(CampaignPlan {
                configurations: published_plan(),
                ..CampaignPlan::default()
            })),
            _ => Ok(None),
        }
    }
}

/// The channels that stand in the recordings of the bench and not in the files of the sensor.
pub(super) fn of_the_bench<'a>(
    names: &[&'a str],
    sensor: Option<&OutputRecording>,
) -> Vec<&'a str> {
    let in_sensor = |name: &&&str| sensor.is_some_and(|s| s.channels.contains_key(**name));
    names.iter().filter(|n| !in_sensor(n)).copied().collect()
}

/// Options of `[recording]`, which runs with a column `file` need.
pub(super) fn waveform_options(
    source: &CampaignFile,
    recording: Option<&ShakerRecording>,
    names: &[&str],
) -> Result<WaveformOptions> {
    match recording {
        Some(recording) => recording.options(source, names),
        None => Err(source
            .refuse("recording", "format", "the runs name recordings, and [recording] is missing")
            .with_hint("add [recording] with format = \"f32\", sampling_rate_Hz, full_scale_V and channels")),
    }
}

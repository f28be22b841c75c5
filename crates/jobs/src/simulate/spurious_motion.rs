//! A measurement of the spurious motion, with its truth.

use super::Desk;
use super::shaker::{SimulatedShaker, inclinations};
use super::wedge_motion::bent;
use crate::trouble::{Result, Trouble};
use proofmass_io::{Cell, Table};
use proofmass_rig::bench::laboratory::Laboratory;
use proofmass_rig::bench::{Bench, BenchVibrometer, Bending, published_plan, target_amplitude};
use serde::{Deserialize, Serialize};

/// A vibrometer along the three axes of the table, wedge by wedge: campaign.toml, runs.csv with the phasors of every
/// repeat, truth.json.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SimulatedSpuriousMotion {
    /// The same seed makes the same campaign on every machine
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedSpuriousMotion::default().seed))]
    pub seed: u64,
    /// Drive frequencies, Hz
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "LIST",
            value_delimiter = ',',
            default_value = "5,10,20,40,80,160,315,630,1000"
        )
    )]
    pub frequencies: Vec<f64>,
    /// Repeats of every reading
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedSpuriousMotion::default().repeats))]
    pub repeats: u32,
    /// The samples of the vibrometer do not share the clock of the reference
    #[cfg_attr(feature = "clap", arg(long))]
    pub no_common_clock: bool,
    /// Bending of wedges by inclination and frequency, in place of the standard one
    #[cfg_attr(feature = "clap", arg(skip))]
    pub wedge_motion: Vec<Bending>,
}

impl Default for SimulatedSpuriousMotion {
    fn default() -> Self {
        Self {
            seed: 1,
            frequencies: SimulatedShaker::default().frequencies,
            repeats: 10,
            no_common_clock: false,
            wedge_motion: Vec::new(),
        }
    }
}

#[derive(Serialize)]
struct Ratio {
    inclination_deg: f64,
    #[serde(rename = "frequency_Hz")]
    frequency: f64,
    ratio: [[f64; 2]; 3],
}

#[derive(Serialize)]
struct TruthFile {
    scenario: &'static str,
    seed: u64,
    common_clock: bool,
    ratios: Vec<Ratio>,
}

impl SimulatedSpuriousMotion {
    pub(super) fn simulate(&self, desk: &Desk<'_>) -> Result<serde_json::Value> {
        if !(2..=1000).contains(&self.repeats) {
            return Err(
                Trouble::request(format!("{} repeats cannot be simulated", self.repeats))
                    .with_hint("from 2 to 1000"),
            );
        }
        if let Some(f) = self.frequencies.iter().find(|f| !(1.0..=10e3).contains(*f)) {
            return Err(Trouble::request(format!("{f} Hz cannot be simulated"))
                .with_hint("from 1 Hz to 10 kHz"));
        }
        let standard = Laboratory::default();
        let laboratory = Laboratory {
            vibrometer: BenchVibrometer {
                common_clock: !self.no_common_clock,
                ..standard.vibrometer.clone()
            },
            bench: Bench {
                wedge: bent(
                    standard.bench.wedge.clone(),
                    &self.wedge_motion,
                    &self.frequencies,
                )?,
                ..standard.bench.clone()
            },
            ..standard
        };
        let plan = published_plan();
        let setup = laboratory.set_up(&plan, &self.frequencies, self.seed);
        let mut table = Table::new([
            "run",
            "frequency_Hz",
            "inclination_deg",
            "axis",
            "reference_m/s2",
            "reference_phase_deg",
            "velocity_mm/s",
            "velocity_phase_deg",
        ]);
        let mut ratios = vec![];
        let mut number = 0;
        for inclination in inclinations(&plan) {
            for &frequency in &self.frequencies {
                if let Some(wedge) = &laboratory.bench.wedge {
                    let ratio = wedge.ratio(inclination, frequency);
                    ratios.push(Ratio {
                        inclination_deg: inclination,
                        frequency,
                        ratio: ratio.map(|z| [z.re, z.im]),
                    });
                }
                let amplitude = target_amplitude(frequency);
                for (axis, name) in ["x", "y", "z"].iter().enumerate() {
                    for r in setup.vibrometer(inclination, frequency, axis, self.repeats as usize) {
                        number += 1;
                        table.push([
                            Cell::from(format!("repeat-{number:04}").as_str()),
                            Cell::from(frequency),
                            Cell::from(inclination),
                            Cell::from(*name),
                            Cell::from(amplitude * r.reference.norm()),
                            Cell::from(r.reference.arg().to_degrees()),
                            Cell::from(1e3 * amplitude * r.velocity.norm()),
                            Cell::from(r.velocity.arg().to_degrees()),
                        ])?;
                    }
                }
            }
        }
        let truth = TruthFile {
            scenario: "spurious-motion",
            seed: self.seed,
            common_clock: !self.no_common_clock,
            ratios,
        };
        desk.write("runs.csv", table.to_csv()?)?;
        desk.write("campaign.toml", campaign(self.seed).into_bytes())?;
        desk.truth(&truth)
    }
}

fn campaign(seed: u64) -> String {
    format!(
        r#"# Spurious motion of a simulated bench (seed {seed}); its truth is in truth.json.
kind = "spurious-motion"
title = "Spurious motion of a simulated bench"

[device]
manufacturer = "proofmass"
model = "simulated shaker with wedges"

[runs]
file = "runs.csv"
"#
    )
}

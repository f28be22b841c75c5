//! A measurement of the spurious motion, with its truth.

use super::bench_arguments::BenchArguments;
use super::hand_over;
use super::shaker::inclinations;
use crate::{Failure, Outcome};
use proofmass::io::{Cell, OutputFolder, Table};
use proofmass::rig::bench::laboratory::Laboratory;
use proofmass::rig::bench::{Vibrometer, published_plan, target_amplitude};
use serde::Serialize;

/// A vibrometer along the three axes of the table, wedge by wedge: campaign.toml, runs.csv with the phasors of every
/// repeat, truth.json.
#[derive(clap::Args)]
pub(super) struct SpuriousMotion {
    #[command(flatten)]
    bench: BenchArguments,
    /// Repeats of every reading
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=1000))]
    repeats: u32,
    /// The samples of the vibrometer do not share the clock of the reference
    #[arg(long)]
    no_common_clock: bool,
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

impl SpuriousMotion {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        if let Some(f) = self
            .bench
            .frequencies
            .iter()
            .find(|f| !(1.0..=10e3).contains(*f))
        {
            return Err(
                Failure::new(format!("{f} Hz cannot be simulated")).hint("from 1 Hz to 10 kHz")
            );
        }
        let folder = OutputFolder::create(&self.bench.output, false)?;
        let standard = Laboratory::default();
        let laboratory = Laboratory {
            vibrometer: Vibrometer {
                common_clock: !self.no_common_clock,
                ..standard.vibrometer.clone()
            },
            ..standard
        };
        let plan = published_plan();
        let setup = laboratory.set_up(&plan, &self.bench.frequencies, self.bench.seed);
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
            for &frequency in &self.bench.frequencies {
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
            seed: self.bench.seed,
            common_clock: !self.no_common_clock,
            ratios,
        };
        folder.write("runs.csv", table.to_csv()?)?;
        hand_over(folder, campaign(self.bench.seed), &truth)
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

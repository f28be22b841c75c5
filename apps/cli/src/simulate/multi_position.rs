//! A recording turned by hand, with its truth.

use super::hand_over;
use crate::{Failure, Outcome};
use proofmass::io::{OutputFolder, Table};
use proofmass::rig::HandHeld;
use serde::Serialize;
use std::path::PathBuf;

/// A triaxial accelerometer turned by hand from rest to rest: campaign.toml, recording.csv, truth.json.
#[derive(clap::Args)]
pub(super) struct MultiPosition {
    /// Folder for the campaign
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// The same seed makes the same recording on every machine
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of standstills
    #[arg(long, default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..=1000))]
    standstills: u32,
    /// Noise of one sample, counts
    #[arg(long, default_value_t = 4.0)]
    noise: f64,
    /// Wander between standstills, m/s²
    #[arg(long, default_value_t = 0.001)]
    wander: f64,
}

/// The truth beside a simulated recording.
#[derive(Serialize)]
struct Truth {
    scenario: &'static str,
    seed: u64,
    #[serde(rename = "K_count_per_m_per_s2")]
    k: [[f64; 3]; 3],
    b_count: [f64; 3],
    gravity_m_per_s2: f64,
    noise_count: f64,
    wander_m_per_s2: f64,
    standstills: Vec<proofmass::rig::Rest>,
}

impl MultiPosition {
    pub(super) fn run(self) -> Result<Outcome, Failure> {
        for (name, value) in [("--noise", self.noise), ("--wander", self.wander)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(
                    Failure::new(format!("{name} {value} is no standard deviation"))
                        .hint("give a number from zero up"),
                );
            }
        }
        let folder = OutputFolder::create(&self.output, false)?;
        let rig = HandHeld {
            rests: self.standstills as usize,
            rest: 3.5,
            turn: 1.5,
            noise: self.noise,
            correlation: 0.3,
            wander: self.wander,
            ..HandHeld::default()
        };
        let recording = rig.simulate(self.seed);
        let mut table = Table::new(["time_s", "acc_x_count", "acc_y_count", "acc_z_count"]);
        let [x, y, z] = &recording.outputs;
        for (i, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
            table.push([i as f64 / recording.rate, *x, *y, *z])?;
        }
        let truth = Truth {
            scenario: "multi-position",
            seed: self.seed,
            k: rig.sensor.k().0,
            b_count: rig.sensor.bias(),
            gravity_m_per_s2: rig.gravity,
            noise_count: self.noise,
            wander_m_per_s2: self.wander,
            standstills: recording.rests,
        };
        folder.write("recording.csv", table.to_csv()?)?;
        hand_over(folder, campaign(self.seed), &truth)
    }
}

fn campaign(seed: u64) -> String {
    format!(
        r#"# A hand-held multi-position campaign of a simulated sensor (seed {seed}); its truth is in truth.json.
kind = "multi-position"
title = "Triaxial accelerometer, simulated hand-held recording"

[device]
manufacturer = "proofmass"
model = "simulated 16-bit sensor"
serial = "{seed}"

[recording]
file = "recording.csv"
columns = {{ x = "acc_x", y = "acc_y", z = "acc_z" }}
time = "time"
range = [0, 65535]

[gravity]
value = 9.80665
standard_uncertainty = 1e-5

[method]
model = "triangular"
"#
    )
}

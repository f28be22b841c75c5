//! A recording turned by hand, with its truth.

use super::Desk;
use crate::trouble::{Result, Trouble};
use proofmass_io::Table;
use proofmass_rig::HandHeld;
use serde::{Deserialize, Serialize};

/// A triaxial accelerometer turned by hand from rest to rest: campaign.toml, recording.csv, truth.json.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SimulatedMultiPosition {
    /// The same seed makes the same recording on every machine
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedMultiPosition::default().seed))]
    pub seed: u64,
    /// Number of standstills
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedMultiPosition::default().standstills))]
    pub standstills: u32,
    /// Noise of one sample, counts
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedMultiPosition::default().noise))]
    pub noise: f64,
    /// Wander between standstills, m/s²
    #[cfg_attr(feature = "clap", arg(long, default_value_t = SimulatedMultiPosition::default().wander))]
    pub wander: f64,
}

impl Default for SimulatedMultiPosition {
    fn default() -> Self {
        Self {
            seed: 1,
            standstills: 24,
            noise: 4.0,
            wander: 0.001,
        }
    }
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
    standstills: Vec<proofmass_rig::Rest>,
}

impl SimulatedMultiPosition {
    pub(super) fn simulate(&self, desk: &Desk<'_>) -> Result<serde_json::Value> {
        if !(1..=1000).contains(&self.standstills) {
            return Err(Trouble::request(format!(
                "{} standstills cannot be simulated",
                self.standstills
            ))
            .with_hint("from 1 to 1000"));
        }
        for (name, value) in [("noise", self.noise), ("wander", self.wander)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(
                    Trouble::request(format!("{name} {value} is no standard deviation"))
                        .with_hint("give a number from zero up"),
                );
            }
        }
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
        desk.write("recording.csv", table.to_csv()?)?;
        desk.write("campaign.toml", campaign(self.seed).into_bytes())?;
        desk.truth(&truth)
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

# Local gravity of the simulation. For a recording of your own: latitude_deg and height_m of its place instead.
[gravity]
value = 9.80665
standard_uncertainty = 1e-5

[method]
model = "triangular"
"#
    )
}

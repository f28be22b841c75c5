//! Small campaigns on the simulated bench, written as a laboratory would write them.
#![allow(dead_code)] // every test file uses its own part

use proofmass::io::write_f32;
use proofmass::rig::bench::{
    Bench, BenchCampaign, BenchWedge, published_plan, waveform::Acquisition,
};
use proofmass::shaker::Complex64;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::fmt::Write;
use std::path::Path;

/// Sensitivity of the reference, V/(m/s²).
pub const REFERENCE: f64 = 9.9e-3;

/// One row of the table of runs; channels reference, x, y, z in V.
#[derive(Clone)]
pub struct Row {
    pub run: String,
    pub frequency: f64,
    /// Frequency that is vibrated, whatever the table says.
    pub vibrated: f64,
    pub inclination: f64,
    pub rotation: f64,
    pub channels: [Complex64; 4],
}

/// The published plan at some frequencies, drawn with the errors of the bench.
pub fn rows(frequencies: &[f64]) -> Vec<Row> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    rows_of(&Bench::default().campaign(&published_plan(), frequencies, &mut rng))
}

/// The same on a table that moves aside too, with its truth.
pub fn rocking(frequencies: &[f64]) -> (Vec<Row>, BenchCampaign) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
    let bench = Bench {
        wedge: Some(BenchWedge::default()),
        ..Bench::default()
    };
    let campaign = bench.campaign(&published_plan(), frequencies, &mut rng);
    (rows_of(&campaign), campaign)
}

fn rows_of(campaign: &BenchCampaign) -> Vec<Row> {
    campaign
        .runs
        .iter()
        .enumerate()
        .map(|(i, r)| Row {
            run: format!("r{:03}", i + 1),
            frequency: r.frequency,
            vibrated: r.frequency,
            inclination: r.inclination_deg,
            rotation: r.rotation_deg,
            channels: [
                r.reference * REFERENCE,
                r.outputs[0],
                r.outputs[1],
                r.outputs[2],
            ],
        })
        .collect()
}

const BUDGET: &str = r#"
[[input]]
name = "wedge.angle"
unit = "deg"
acts = "inclination"
distribution = { kind = "rectangular", lower = -0.1, upper = 0.1 }
varies_with = ["inclination"]
[[input]]
name = "gluing.angle"
unit = "deg"
acts = "rotation"
distribution = { kind = "rectangular", lower = -1.0, upper = 1.0 }
varies_with = ["inclination", "rotation"]
[[input]]
name = "gain"
unit = "%"
acts = "output-modulus"
distribution = { kind = "rectangular", lower = -0.15, upper = 0.15 }
varies_with = ["channel"]
[[input]]
name = "reading"
unit = "%"
acts = "output-modulus"
distribution = { kind = "normal", mean = 0.0, u = 0.34 }
varies_with = ["run", "channel"]
[[input]]
name = "reading.phase"
unit = "mrad"
acts = "output-phase"
distribution = { kind = "normal", mean = 0.0, u = 3.0 }
varies_with = ["run", "channel"]
[[input]]
name = "noise"
unit = "µV"
acts = "output-additive"
distribution = { kind = "normal", mean = 0.0, u = 50.0 }
varies_with = ["run", "channel"]
"#;

/// The campaign without its runs: certificate from 5 to 2000 Hz, plan, budget, no Monte Carlo.
pub fn campaign(folder: &Path, recording: &str) {
    let toml = format!(
        "kind = \"shaker-triaxial\"\n[runs]\nfile = \"runs.csv\"\n{recording}[reference]\nfile = \"reference.csv\"\nk = 2\n\
         [unmeasured_motion]\nacross = 0\nalong = 0\n\
         [plan]\nname = \"published\"\n[budget]\nfile = \"budget.toml\"\n[method]\ntrials = 0\n"
    );
    crate::support::campaign(folder, &toml);
    std::fs::write(folder.join("budget.toml"), BUDGET).expect("budget");
    certificate(folder, 2000.0);
}

pub fn certificate(folder: &Path, last: f64) {
    let points = [5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 315.0, 630.0, 1250.0];
    let points = points.into_iter().filter(|f| *f < last).chain([last]);
    let rows: String = points.map(|f| format!("{f},9.9,0,0.4,0.35\n")).collect();
    let text =
        format!("frequency_Hz,sensitivity_mV/(m/s2),phase_deg,U_relative_%,U_phase_deg\n{rows}");
    std::fs::write(folder.join("reference.csv"), text).expect("certificate");
}

/// `runs.csv` with phasors.
pub fn phasor_table(rows: &[Row]) -> String {
    let mut text = "run,frequency_Hz,inclination_deg,rotation_deg,reference_V,reference_phase_deg,x_V,x_phase_deg,y_V,y_phase_deg,z_V,z_phase_deg\n".to_owned();
    for r in rows {
        let _ = write!(
            text,
            "{},{},{},{}",
            r.run, r.frequency, r.inclination, r.rotation
        );
        for z in r.channels {
            let _ = write!(text, ",{},{}", z.norm(), z.arg().to_degrees());
        }
        text.push('\n');
    }
    text
}

/// A campaign of phasors.
pub fn phasors(folder: &Path, rows: &[Row]) {
    campaign(folder, "");
    std::fs::write(folder.join("runs.csv"), phasor_table(rows)).expect("runs");
}

/// A campaign of recordings: 0.25 s at 20 kS/s, full scale 1 V.
pub fn recordings(folder: &Path, rows: &[Row]) {
    campaign(
        folder,
        "[recording]\nformat = \"f32\"\nsampling_rate_Hz = 20000\nfull_scale_V = 1\n\
         channels = { reference = 1, x = 2, y = 3, z = 4 }\n",
    );
    let daq = Acquisition {
        sampling_frequency: 20_000.0,
        duration: 0.25,
        full_scale: 1.0,
        noise: 1e-5,
        ..Acquisition::default()
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
    let mut text = "run,frequency_Hz,inclination_deg,rotation_deg,target_m/s2,file\n".to_owned();
    for r in rows {
        let x = r
            .channels
            .map(|z| daq.channel(&[z, z * 0.01, z * 0.003], r.vibrated, &mut rng));
        let name = format!("{}.f32", r.run);
        write_f32(&folder.join(&name), &[&x[0], &x[1], &x[2], &x[3]]).expect("recording");
        let _ = writeln!(
            text,
            "{},{},{},{},10,{name}",
            r.run, r.frequency, r.inclination, r.rotation
        );
    }
    std::fs::write(folder.join("runs.csv"), text).expect("runs");
}

//! How often does a healthy recording carry a finding?
//!
//! Prints the table of docs/multi-position.md: `cargo run --release -p proofmass-static --example false_alarms`.
//! Rows are findings, columns recordings without a fault; an argument sets their number per column (2000). A scatter
//! between the standstills is no fault, and `excess-residuals` then tells of what is there: it counts only without. A
//! second table tells how often wrong readings are named.

use proofmass_core::{Error, Gravity, Matrix3, SensorModel};
use proofmass_rig::HandHeld;
use proofmass_static::{
    Model, MultiPosition, Pose, Samples, Segment, Standstill, StandstillCalibration, frozen,
    temperature_drift,
};
use proofmass_uncertainty::Finding;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::collections::BTreeMap;

const GRAVITY: f64 = 9.80665;
/// Standard deviation of a mean, m/s².
const NOISE: f64 = 1e-3;

/// Healthy recordings of one sort.
#[derive(Clone, Copy, Debug)]
pub enum Healthy {
    /// Standstill means, drawn directly.
    Means {
        /// What is fitted.
        model: Model,
        /// Number of standstills.
        attitudes: usize,
        /// Standard deviation between the standstills over the noise of a mean.
        ratio: f64,
        /// Whether the noise is told.
        known: bool,
    },
    /// Samples of a sensor held by hand, standstills found, with a temperature.
    Samples {
        /// Correlation of neighbouring samples.
        correlation: f64,
        /// Step of the output over the noise of a sample.
        resolution: f64,
        /// Standard deviation between the standstills, m/s².
        wander: f64,
    },
}

/// Findings of each recording: how often each shows.
pub fn count(healthy: Healthy, recordings: u64) -> BTreeMap<String, usize> {
    let all: Vec<Vec<String>> = (0..recordings)
        .into_par_iter()
        .map(|seed| findings(healthy, seed))
        .map(|found| match found {
            Ok(found) => found.iter().map(|f| f.code().to_owned()).collect(),
            Err(_) => vec!["(refused)".to_owned()],
        })
        .collect();
    let mut counts = BTreeMap::new();
    for mut codes in all {
        codes.sort_unstable();
        codes.dedup();
        for code in codes {
            *counts.entry(code).or_insert(0) += 1;
        }
    }
    if healthy.scatters() {
        counts.remove("excess-residuals");
    }
    // Eleven attitudes and fewer are few, whatever was recorded.
    counts.remove("few-attitudes");
    counts
}

impl Healthy {
    fn scatters(self) -> bool {
        match self {
            Self::Means { ratio, .. } => ratio > 0.0,
            Self::Samples { wander, .. } => wander > 0.0,
        }
    }
}

fn findings(healthy: Healthy, seed: u64) -> Result<Vec<Finding>, Error> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xfa15e);
    match healthy {
        Healthy::Means {
            model,
            attitudes,
            ratio,
            known,
        } => {
            let poses = poses(model, attitudes, ratio, known, &mut rng);
            let fit = MultiPosition::new(gravity())
                .model(model)
                .nominal_sensitivity(1.0)
                .output_unit("m/s²")
                .fit(&poses);
            fit.map(|fit| fit.findings().to_vec())
        }
        Healthy::Samples {
            correlation,
            resolution,
            wander,
        } => {
            let rig = HandHeld {
                noise: 8.0,
                resolution: 8.0 * resolution,
                correlation,
                wander,
                ..HandHeld::default()
            };
            of_samples(&rig, seed, &mut rng)
        }
    }
}

fn gravity() -> Gravity {
    Gravity::given(GRAVITY, 1e-5).unwrap_or_else(|error| unreachable!("{error}"))
}

fn of_samples(
    rig: &HandHeld,
    seed: u64,
    rng: &mut Xoshiro256PlusPlus,
) -> Result<Vec<Finding>, Error> {
    let recording = rig.simulate(seed);
    let [x, y, z] = &recording.outputs;
    let time: Vec<f64> = (0..x.len()).map(|i| i as f64 / rig.rate).collect();
    // A room: half a kelvin up and down within minutes, a sensor that reads it to a tenth.
    let phase = std::f64::consts::TAU * rng.random::<f64>();
    let temperature: Vec<f64> = time
        .iter()
        .map(|t| (10.0 * (22.0 + 0.5 * (t / 40.0 + phase).sin())).round() / 10.0)
        .collect();
    let samples = Samples::new(x, y, z)?
        .at_times(&time)?
        .at_temperatures(&temperature)?;
    let settings = MultiPosition::new(gravity());
    let search = Standstill::default();
    let found = StandstillCalibration::run(&samples, rig.rate, &[], &search, &settings)?;
    let residuals = found.fit.residuals();
    let drift = temperature_drift(&temperature, &found.sweep.segments, residuals);
    let all = found.fit.findings().iter().cloned();
    Ok(all.chain(frozen(&samples)).chain(drift).collect())
}

/// The six faces, then evenly over the sphere, all some 80 mrad askew, four seconds apart.
fn poses(
    model: Model,
    attitudes: usize,
    ratio: f64,
    known: bool,
    rng: &mut Xoshiro256PlusPlus,
) -> Vec<Pose> {
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    let mut k = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for &(i, j) in model.free_elements() {
        // Misalignments that a smaller model would not do for.
        k[i][j] += if i == j { 0.01 * normal() } else { 0.02 };
        if model == Model::Symmetric {
            k[j][i] = k[i][j];
        }
    }
    let bias = std::array::from_fn(|_| 0.15 * normal());
    let sensor = SensorModel::new(Matrix3(k), bias);
    let sensor = sensor.unwrap_or_else(|error| unreachable!("{error}"));
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let spread = attitudes.saturating_sub(6).max(1) as f64;
    let (start, phase) = (3.0 * normal(), 3.0 * normal());
    (0..attitudes)
        .map(|index| {
            let mut up = [0.0; 3];
            if index < 6 {
                up[index / 2] = if index % 2 == 0 { 1.0 } else { -1.0 };
            } else {
                let z = 1.0 - (2.0 * (index - 6) as f64 + 1.0) / spread;
                let angle = golden * index as f64 + start;
                let r = (1.0 - z * z).sqrt();
                up = [r * angle.cos(), r * angle.sin(), z];
            }
            let up = up.map(|v| v + 0.08 * normal());
            let norm = proofmass_core::norm(up);
            let up = up.map(|v| v / norm);
            let force = std::array::from_fn(|i| GRAVITY * up[i] + ratio * NOISE * normal());
            let v = NOISE * NOISE;
            let time = 4.0 * index as f64;
            Pose {
                covariance: known.then_some([[v, 0.0, 0.0], [0.0, v, 0.0], [0.0, 0.0, v]]),
                time: Some(time),
                temperature: Some(22.0 + 0.5 * (time / 40.0 + phase).sin() + 0.05 * normal()),
                deviation: Some([0.02, 0.02, 0.02].map(|d| d * (1.0 + 0.05 * normal()))),
                ..Pose::reading(
                    Segment {
                        start: 400 * index,
                        end: 400 * index + 400,
                        attitude: (model == Model::Full).then_some(up),
                        force_uncertainty: None,
                        label: None,
                    },
                    sensor.invert(force).map(|c| c + NOISE * normal()),
                )
            }
        })
        .collect()
}

/// Share of recordings, noise and scatter 1 mm/s², in which exactly the `wrong` readings are named that are 1 % too long or
/// too short (98 mm/s²).
pub fn named(model: Model, attitudes: usize, wrong: usize, recordings: u64) -> f64 {
    let hits = (0..recordings)
        .into_par_iter()
        .filter(|seed| {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xbad);
            let mut poses = poses(model, attitudes, 1.0, true, &mut rng);
            let mut bad: Vec<usize> = Vec::new();
            while bad.len() < wrong {
                let index = rng.random_range(0..attitudes);
                if !bad.contains(&index) {
                    let factor = if rng.random::<bool>() { 1.01 } else { 0.99 };
                    poses[index].mean = poses[index].mean.map(|m| factor * m);
                    bad.push(index);
                }
            }
            bad.sort_unstable();
            let suspects = MultiPosition::new(gravity())
                .model(model)
                .nominal_sensitivity(1.0)
                .output_unit("m/s²")
                .suspects(&poses);
            suspects.is_ok_and(|s| s.iter().map(|s| s.index).eq(bad))
        })
        .count();
    hits as f64 / recordings as f64
}

const fn means(model: Model, attitudes: usize, ratio: f64) -> Healthy {
    Healthy::Means {
        model,
        attitudes,
        ratio,
        known: true,
    }
}

/// The columns of the table.
pub const ALL: [(&str, Healthy); 16] = [
    ("12", means(Model::Triangular, 12, 0.0)),
    ("12, scatter 1", means(Model::Triangular, 12, 1.0)),
    ("16, 0", means(Model::Triangular, 16, 0.0)),
    ("16, 1", means(Model::Triangular, 16, 1.0)),
    ("24, 0", means(Model::Triangular, 24, 0.0)),
    ("24, 1", means(Model::Triangular, 24, 1.0)),
    ("24, 3", means(Model::Triangular, 24, 3.0)),
    ("40, 1", means(Model::Triangular, 40, 1.0)),
    ("symmetric 24, 1", means(Model::Symmetric, 24, 1.0)),
    ("bias-scale 12, 1", means(Model::BiasScale, 12, 1.0)),
    ("bias 10, 1", means(Model::Bias, 10, 1.0)),
    ("full 12, 1", means(Model::Full, 12, 1.0)),
    ("full 24, 1", means(Model::Full, 24, 1.0)),
    (
        "readings of unknown noise 24, 1",
        Healthy::Means {
            model: Model::Triangular,
            attitudes: 24,
            ratio: 1.0,
            known: false,
        },
    ),
    (
        "samples",
        Healthy::Samples {
            correlation: 0.0,
            resolution: 0.1,
            wander: 0.0,
        },
    ),
    (
        "samples, correlated 0.6, coarse, wander",
        Healthy::Samples {
            correlation: 0.6,
            resolution: 2.0,
            wander: 2e-3,
        },
    ),
];

#[allow(dead_code)]
fn main() {
    let recordings: u64 = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(2000);
    let columns: Vec<BTreeMap<String, usize>> = ALL
        .iter()
        .map(|(_, healthy)| count(*healthy, recordings))
        .collect();
    let mut codes: Vec<&String> = columns.iter().flat_map(|c| c.keys()).collect();
    codes.sort_unstable();
    codes.dedup();
    println!("| recordings | findings, share in % |");
    println!("|---|---|");
    for ((name, _), counts) in ALL.iter().zip(&columns) {
        let shares: Vec<String> = codes
            .iter()
            .filter_map(|code| {
                let share = 100.0 * *counts.get(*code)? as f64 / recordings as f64;
                Some(format!("{code} {share:.2}"))
            })
            .collect();
        let shares = match shares.is_empty() {
            true => "none".to_owned(),
            false => shares.join(", "),
        };
        println!("| {name} | {shares} |");
    }
    println!("\n| finding | share of all / % | worst column / % |");
    println!("|---|---|---|");
    for code in codes {
        let shares = columns.iter().map(|c| c.get(code).copied().unwrap_or(0));
        let worst = shares.clone().max().unwrap_or(0) as f64 / recordings as f64;
        let all = shares.sum::<usize>() as f64 / (columns.len() as u64 * recordings) as f64;
        println!("| `{code}` | {:.2} | {:.2} |", 100.0 * all, 100.0 * worst);
    }
    println!("\n| attitudes | one wrong / % | two wrong / % |");
    println!("|---|---|---|");
    for (name, model, attitudes) in [
        ("12, `bias-scale`", Model::BiasScale, 12),
        ("12", Model::Triangular, 12),
        ("16", Model::Triangular, 16),
        ("24", Model::Triangular, 24),
        ("40", Model::Triangular, 40),
        ("12, given, `full`", Model::Full, 12),
        ("24, given, `full`", Model::Full, 24),
    ] {
        let [one, two] = [1, 2].map(|n| 100.0 * named(model, attitudes, n, recordings / 4));
        println!("| {name} | {one:.0} | {two:.0} |");
    }
}

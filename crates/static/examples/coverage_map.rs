//! Do the 95 % intervals of a multi-position fit hold the truth, whatever varies between the standstills?
//!
//! Prints the table of docs/multi-position.md: `cargo run --release -p proofmass-static --example coverage_map`.
//! Standstill means are drawn directly, with a noise that is itself estimated from the samples of all of them; from
//! there on everything is the real fit. An argument sets the number of recordings per cell of the first table (10 000);
//! the others take a quarter of it.

use proofmass_core::{Gravity, Matrix3, SensorModel};
use proofmass_static::{Model, MultiPosition, Pose, Segment};
use proofmass_uncertainty::DegreesOfFreedom;
use rand::SeedableRng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

const GRAVITY: f64 = 9.80665;
/// Standard deviation of a sample, m/s², and samples of a standstill: means of some 1 mm/s².
const NOISE: f64 = 0.02;
const SAMPLES: usize = 400;

/// One place of the map.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// What is fitted.
    pub model: Model,
    /// Number of standstills.
    pub attitudes: usize,
    /// Standard deviation between the standstills over that of the noise of a mean.
    pub ratio: f64,
    /// Longest standstill over the shortest; lengths alternate.
    pub lengths: f64,
}

/// What came of the recordings of one place.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Share of intervals that hold the truth, mean over the parameters.
    pub mean: f64,
    /// That share of the worst parameter.
    pub worst: f64,
    /// Mean U over that of an interval made with the true standard deviations.
    pub width: f64,
    /// Recordings that gave a result.
    pub fitted: usize,
}

impl Place {
    /// The six faces, some 60 mrad askew, then anywhere; the sensor K ± 2 %, b ± 0.3 m/s².
    fn recording(&self, seed: u64) -> (Vec<Pose>, SensorModel<f64>, DegreesOfFreedom) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut k = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for &(i, j) in self.model.free_elements() {
            k[i][j] += 0.01 * normal();
            if self.model == Model::Symmetric {
                k[j][i] = k[i][j];
            }
        }
        let bias = [0.15 * normal(), 0.15 * normal(), 0.15 * normal()];
        let sensor = SensorModel::new(Matrix3(k), bias).expect("close to the identity");
        let lengths: Vec<usize> = (0..self.attitudes)
            .map(|i| {
                let short = 2.0 * SAMPLES as f64 / (1.0 + self.lengths);
                let factor = if i % 2 == 0 { 1.0 } else { self.lengths };
                (short * factor).round() as usize
            })
            .collect();
        let freedom = (lengths.iter().sum::<usize>() - self.attitudes) as f64;
        let drawn = ChiSquared::new(freedom).expect("positive").sample(&mut rng) / freedom;
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let wander = self.ratio * NOISE / (SAMPLES as f64).sqrt();
        let poses = lengths
            .iter()
            .enumerate()
            .map(|(index, &samples)| {
                let up = direction(index, &mut normal);
                let force = std::array::from_fn(|i| GRAVITY * up[i] + wander * normal());
                let variance = NOISE * NOISE / samples as f64;
                let clean = sensor.invert(force);
                let v = variance * drawn;
                Pose {
                    covariance: Some([[v, 0.0, 0.0], [0.0, v, 0.0], [0.0, 0.0, v]]),
                    ..Pose::reading(
                        Segment {
                            start: index,
                            end: index + samples,
                            attitude: (self.model == Model::Full).then_some(up),
                            force_uncertainty: None,
                            label: None,
                        },
                        clean.map(|c| c + variance.sqrt() * normal()),
                    )
                }
            })
            .collect();
        let dof = DegreesOfFreedom::new(freedom).expect("positive");
        (poses, sensor, dof)
    }

    /// Runs many recordings.
    pub fn cell(&self, recordings: usize) -> Cell {
        let gravity = Gravity::given(GRAVITY, 0.0).expect("on Earth");
        let truth = self.ratio.hypot(1.0) * NOISE / (SAMPLES as f64).sqrt();
        let results: Vec<Vec<(bool, f64)>> = (0..recordings as u64)
            .into_par_iter()
            .filter_map(|run| {
                let seed = run ^ ((self.attitudes as u64) << 32) ^ self.ratio.to_bits();
                let (poses, sensor, dof) = self.recording(seed);
                let fit = MultiPosition::new(gravity)
                    .model(self.model)
                    .nominal_sensitivity(1.0)
                    .output_unit("m/s²")
                    .noise_dof(dof)
                    .fit(&poses)
                    .ok()?;
                // Width with true standard deviations, for lengths that are alike: u over that of the fit's weights.
                let fitted = fit.scatter().map_or(f64::NAN, |_| {
                    let noise = fit.residuals().iter().map(|r| r.noise.powi(2)).sum::<f64>();
                    (noise / poses.len() as f64 + fit.excess().powi(2)).sqrt()
                });
                let quantities = fit.quantities().iter();
                Some(
                    quantities
                        .map(|q| {
                            let error = (q.value - of(&sensor, &q.name)).abs();
                            let u = q.standard_uncertainty * truth / fitted;
                            (error <= q.expanded(0.95), q.expanded(0.95) / (1.96 * u))
                        })
                        .collect(),
                )
            })
            .collect();
        let fitted = results.len();
        let parameters = results.first().map_or(0, Vec::len);
        let share =
            |c: usize| results.iter().filter(|r| r[c].0).count() as f64 / fitted.max(1) as f64;
        let all: Vec<f64> = (0..parameters).map(share).collect();
        let widths: Vec<f64> = results.iter().flatten().map(|r| r.1).collect();
        Cell {
            mean: all.iter().sum::<f64>() / parameters.max(1) as f64,
            worst: all.iter().copied().fold(1.0, f64::min),
            width: widths.iter().sum::<f64>() / widths.len().max(1) as f64,
            fitted,
        }
    }
}

fn direction(index: usize, normal: &mut impl FnMut() -> f64) -> [f64; 3] {
    let mut v = [0.0; 3];
    if index < 6 {
        v[index / 2] = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        v = v.map(|x| x + 0.06 * normal());
    } else {
        v = v.map(|_| normal());
    }
    let norm = proofmass_core::norm(v);
    v.map(|x| x / norm)
}

fn of(sensor: &SensorModel<f64>, name: &str) -> f64 {
    let axis = |c: char| "xyz".find(c).unwrap_or(0);
    let letters: Vec<char> = name.rsplit('.').next().unwrap_or("").chars().collect();
    let (i, k) = (axis(letters[0]), sensor.k().0);
    match name.split('.').next() {
        Some("bias") => sensor.bias()[i],
        Some("scale") => k[i][i],
        _ => k[i][axis(letters[1])] / k[i][i],
    }
}

const RATIOS: [f64; 7] = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 6.0];
const ATTITUDES: [usize; 6] = [8, 10, 12, 16, 24, 40];

#[allow(dead_code)]
fn main() {
    let recordings = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(10_000);
    for (model, lengths) in [
        (Model::Triangular, 1.0),
        (Model::Triangular, 5.0),
        (Model::Symmetric, 1.0),
        (Model::BiasScale, 1.0),
        (Model::Bias, 1.0),
        (Model::Full, 1.0),
    ] {
        let recordings = if (model, lengths) == (Model::Triangular, 1.0) {
            recordings
        } else {
            recordings / 4
        };
        println!("\n{model}, lengths 1:{lengths}: coverage / % (worst parameter), width\n");
        println!(
            "| attitudes | {} |",
            RATIOS.map(|r| r.to_string()).join(" | ")
        );
        println!("|{}", "---|".repeat(RATIOS.len() + 1));
        let mut refused = 0.0f64;
        for attitudes in ATTITUDES {
            let row: Vec<String> = RATIOS
                .iter()
                .map(|&ratio| {
                    let cell = Place {
                        model,
                        attitudes,
                        ratio,
                        lengths,
                    }
                    .cell(recordings);
                    if cell.fitted < recordings / 2 {
                        return "–".to_owned();
                    }
                    refused = refused.max(1.0 - cell.fitted as f64 / recordings as f64);
                    format!(
                        "{:.1} ({:.1}) {:.2}",
                        100.0 * cell.mean,
                        100.0 * cell.worst,
                        cell.width
                    )
                })
                .collect();
            println!("| {attitudes} | {} |", row.join(" | "));
        }
        println!("\nrefused in the worst cell: {:.1} %", 100.0 * refused);
    }
}

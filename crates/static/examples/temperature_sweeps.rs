//! Do the intervals of temperature coefficients hold the truth, whatever the noise is like?
//!
//! Prints the table of docs/temperature.md: `cargo run --release -p proofmass-static --example temperature_sweeps`. An argument sets the number
//! of recordings per cell (500).

use proofmass_static::{SweepData, TemperatureSweep};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

const MG: f64 = 9.80665e-3;
/// True mean slopes of x, y, z, m/s²/K.
const SLOPE: [f64; 3] = [0.05 * MG, -0.2 * MG, 1.0 * MG];

/// One kind of recording: an hour at 1 Hz from −20 °C to 60 °C.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Whether the temperature comes back.
    pub cycle: bool,
    /// White noise of a sample, mg.
    pub white: f64,
    /// Random walk of the outputs, µg/√s.
    pub walk: f64,
    /// Gauss–Markov noise: standard deviation in mg and correlation time in s.
    pub wander: (f64, f64),
}

/// What came of its recordings.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cell {
    /// Share of the intervals of the mean slopes that hold the truth.
    pub slope: f64,
    /// Those of the coefficients of the first, second and third power.
    pub powers: [f64; 3],
    /// Median U of a mean slope, µg/K.
    pub expanded: f64,
    /// Share of axes with a difference of the branches that counts.
    pub hysteresis: f64,
}

impl Place {
    fn one(&self, seed: u64) -> Option<([[bool; 4]; 3], [f64; 3], usize)> {
        let n = 3600;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x7e39);
        let mut normal = move || -> f64 { random.sample(StandardNormal) };
        let path = |i: usize| {
            let s = i as f64 / n as f64;
            match self.cycle {
                true => 20.0 - 40.0 * (std::f64::consts::TAU * s).cos(),
                false => -20.0 + 80.0 * s,
            }
        };
        let temperature: Vec<f64> = (0..n).map(|i| path(i) + 0.05 * normal()).collect();
        let outputs = [0, 1, 2].map(|axis| {
            let (deviation, time) = self.wander;
            let keep = (-1.0 / time.max(1e-9)).exp();
            let (mut wander, mut walk) = (deviation * normal(), 0.0);
            let level = [0.0, 0.0, 9.80665][axis];
            (0..n)
                .map(|i| {
                    wander = keep * wander + deviation * (1.0 - keep * keep).sqrt() * normal();
                    walk += 1e-3 * self.walk * normal();
                    level
                        + SLOPE[axis] * (path(i) - 20.0)
                        + MG * (wander + walk + self.white * normal())
                })
                .collect::<Vec<f64>>()
        });
        let [x, y, z] = &outputs;
        let mut settings = TemperatureSweep::default();
        settings.reference = Some(20.0);
        settings.blocks = 100;
        let data = SweepData {
            outputs: vec![x, y, z],
            temperature: &temperature,
            rate: 1.0,
        };
        let fit = settings.fit(&data).ok()?;
        let mut widths = [0.0; 3];
        let held = [0, 1, 2].map(|axis| {
            let name = ["x", "y", "z"][axis];
            let names = [
                (format!("slope.{name}"), SLOPE[axis]),
                (format!("output.{name}.T1"), SLOPE[axis]),
                (format!("output.{name}.T2"), 0.0),
                (format!("output.{name}.T3"), 0.0),
            ];
            widths[axis] = fit
                .estimate
                .get(&names[0].0)
                .map_or(0.0, |q| q.expanded(0.95));
            names.map(|(name, truth)| {
                let quantity = fit.estimate.get(&name);
                quantity.is_some_and(|q| (q.value - truth).abs() <= q.expanded(0.95))
            })
        });
        let found = fit.findings.iter().filter(|f| f.code() == "hysteresis");
        Some((held, widths, found.count()))
    }

    /// Runs many recordings.
    pub fn cell(&self, recordings: usize) -> Cell {
        let runs: Vec<_> = (0..recordings as u64)
            .into_par_iter()
            .filter_map(|seed| self.one(seed))
            .collect();
        let n = 3.0 * runs.len().max(1) as f64;
        let share = |k: usize| {
            let held = runs.iter().flat_map(|r| r.0.iter());
            held.filter(|axis| axis[k]).count() as f64 / n
        };
        let mut widths: Vec<f64> = runs.iter().flat_map(|r| r.1).collect();
        widths.sort_by(f64::total_cmp);
        Cell {
            slope: share(0),
            powers: [share(1), share(2), share(3)],
            expanded: 1e3 * widths.get(widths.len() / 2).copied().unwrap_or(0.0) / MG,
            hysteresis: runs.iter().map(|r| r.2).sum::<usize>() as f64 / n,
        }
    }
}

const fn place(cycle: bool, white: f64, walk: f64, wander: (f64, f64)) -> Place {
    Place {
        cycle,
        white,
        walk,
        wander,
    }
}

/// The map.
pub const PLACES: [Place; 12] = [
    place(true, 5.0, 0.0, (0.0, 1.0)),
    place(true, 5.0, 20.0, (0.0, 1.0)),
    place(true, 1.0, 20.0, (0.0, 1.0)),
    place(true, 1.0, 100.0, (0.0, 1.0)),
    place(true, 5.0, 5.0, (0.0, 1.0)),
    place(true, 1.0, 0.0, (0.5, 180.0)),
    place(true, 1.0, 0.0, (0.5, 1800.0)),
    place(false, 5.0, 0.0, (0.0, 1.0)),
    place(false, 5.0, 20.0, (0.0, 1.0)),
    place(false, 1.0, 20.0, (0.0, 1.0)),
    place(false, 1.0, 0.0, (0.5, 180.0)),
    place(false, 1.0, 0.0, (0.5, 1800.0)),
];

#[allow(dead_code)]
fn main() {
    let recordings = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(500);
    println!(
        "| temperature | white noise / mg | walk / (µg/√s) | Gauss–Markov / mg, s | slopes hold / % | T1, T2, T3 hold / % | U(slope) / (µg/K) | `hysteresis` / % of axes |"
    );
    println!("|{}", "---|".repeat(8));
    for place in PLACES {
        let cell = place.cell(recordings);
        let [a, b, c] = cell.powers.map(|p| 100.0 * p);
        let (deviation, time) = place.wander;
        let wander = match deviation > 0.0 {
            true => format!("{deviation}, {time}"),
            false => "–".to_owned(),
        };
        println!(
            "| {} | {} | {} | {wander} | {:.1} | {a:.1}, {b:.1}, {c:.1} | {:.2} | {:.1} |",
            if place.cycle { "up and down" } else { "up" },
            place.white,
            place.walk,
            100.0 * cell.slope,
            cell.expanded,
            100.0 * cell.hysteresis,
        );
    }
}

//! Do the intervals of sensors that were worn hold the truth?
//!
//! Prints the table of docs/multi-position.md: `cargo run --release -p proofmass-static --example worn_sensors`. Still windows of ten
//! seconds are drawn from days of postures that last, with the temperature of a logger on a wrist. An argument sets the number of
//! sensors per cell (2000).

use proofmass_static::{AutoCalibration, StillWindow};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// One kind of wear.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Days.
    pub days: f64,
    /// Whether the logger has a thermometer; without one its coefficients are zero.
    pub temperature: bool,
    /// Standard deviation of an error along gravity that lasts as long as a posture, mg: slow motion that passes as rest.
    pub motion: f64,
    /// Mean duration of a posture at night and by day, s.
    pub posture: [f64; 2],
}

/// What came of its sensors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cell {
    /// Share of the intervals of offsets, scale factors and temperature coefficients that hold the truth.
    pub coverage: [f64; 3],
    /// That of the worst quantity.
    pub worst: f64,
    /// Share that was refused.
    pub refused: f64,
    /// Median U of offset.x, mg.
    pub expanded: f64,
}

impl Place {
    fn one(&self, seed: u64) -> Option<(Vec<bool>, f64)> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x3aa1);
        let normal = |rng: &mut Xoshiro256PlusPlus| -> f64 { StandardNormal.sample(rng) };
        let s: [f64; 3] = std::array::from_fn(|_| 1.0 + 0.01 * normal(&mut rng));
        let o: [f64; 3] = std::array::from_fn(|_| 0.03 * normal(&mut rng));
        let size = if self.temperature { 1e-3 } else { 0.0 };
        let c: [f64; 3] = std::array::from_fn(|_| size * normal(&mut rng));
        let mut windows = Vec::new();
        let (mut posture, mut temperature, mut error) = ([0.0, 0.0, 1.0], 30.0, 0.0);
        for window in 0..(8640.0 * self.days) as usize {
            let hour = (window as f64 / 360.0) % 24.0;
            let night = hour < 7.0;
            let turn = std::f64::consts::TAU * (hour - 17.0) / 24.0;
            // Taken off for a wash in the morning.
            let worn = !(7.0..7.5).contains(&hour);
            let target = match worn {
                true => 31.0 + 1.5 * turn.sin() + if night { 1.5 } else { 0.0 },
                false => 22.0,
            };
            temperature += (target - temperature) * 10.0 / 1200.0;
            let [at_night, by_day] = self.posture;
            let lasts = if night { at_night } else { by_day };
            if rng.random::<f64>() < 10.0 / lasts {
                let v = [
                    normal(&mut rng),
                    0.8 * normal(&mut rng),
                    normal(&mut rng) - 0.3,
                ];
                let norm = proofmass_core::norm(v);
                posture = v.map(|x| x / norm);
                error = 1e-3 * self.motion * normal(&mut rng);
            }
            let (a, error) = match worn {
                true => (posture, error),
                false => ([0.02, -0.01, -0.99975], 0.0),
            };
            if rng.random::<f64>() < if night || !worn { 0.85 } else { 0.4 } {
                // The mean of 200 samples of 4 mg.
                let t = (temperature * 256.0 / 75.0).round() * 75.0 / 256.0;
                let mean = std::array::from_fn(|k| {
                    let force = a[k] * (1.0 + error);
                    (force - (temperature - 25.0) * c[k]) / s[k] - o[k] + 2.8e-4 * normal(&mut rng)
                });
                windows.push(StillWindow {
                    time: 10.0 * window as f64,
                    mean,
                    temperature: self.temperature.then_some(t),
                });
            }
        }
        let fit = AutoCalibration::default().fit(&windows).ok()?;
        let off = fit.mean_temperature.map_or(0.0, |t| t - 25.0);
        let truth = |name: &str| {
            let k = "xyz".find(&name[name.len() - 1..]).unwrap_or(0);
            match name.split('.').next() {
                Some("offset") => o[k] + off * c[k] / s[k],
                Some("scale") => s[k],
                _ => c[k],
            }
        };
        let quantities = fit.quantities();
        let held = quantities
            .iter()
            .map(|q| (q.value - truth(&q.name)).abs() <= q.expanded(0.95));
        Some((held.collect(), 1e3 * quantities[0].expanded(0.95)))
    }

    /// Calibrates many sensors.
    pub fn cell(&self, sensors: usize) -> Cell {
        let runs: Vec<Option<(Vec<bool>, f64)>> = (0..sensors as u64)
            .into_par_iter()
            .map(|seed| self.one(seed))
            .collect();
        let good: Vec<_> = runs.iter().flatten().collect();
        let n = good.len().max(1) as f64;
        let p = good.first().map_or(0, |r| r.0.len());
        let shares: Vec<f64> = (0..p)
            .map(|c| good.iter().filter(|r| r.0[c]).count() as f64 / n)
            .collect();
        let mut widths: Vec<f64> = good.iter().map(|r| r.1).collect();
        widths.sort_by(f64::total_cmp);
        let group = |k: usize| shares.iter().skip(3 * k).take(3).sum::<f64>() / 3.0;
        Cell {
            coverage: [group(0), group(1), group(2)],
            worst: shares.iter().copied().fold(1.0, f64::min),
            refused: 1.0 - good.len() as f64 / sensors as f64,
            expanded: widths.get(widths.len() / 2).copied().unwrap_or(0.0),
        }
    }
}

/// The map.
pub const PLACES: [Place; 6] = [
    place(3.0, true, 0.0, [720.0, 120.0]),
    place(3.0, true, 2.0, [720.0, 120.0]),
    place(3.0, true, 2.0, [2400.0, 600.0]),
    place(3.0, false, 2.0, [720.0, 120.0]),
    place(1.0, true, 2.0, [720.0, 120.0]),
    place(7.0, true, 2.0, [720.0, 120.0]),
];

const fn place(days: f64, temperature: bool, motion: f64, posture: [f64; 2]) -> Place {
    Place {
        days,
        temperature,
        motion,
        posture,
    }
}

#[allow(dead_code)]
fn main() {
    let sensors = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(2000);
    println!(
        "| days | thermometer | motion / mg | postures at night, by day / s | offset, scale, temperature hold / % (worst) | U(offset.x) / mg | refused / % |"
    );
    println!("|{}", "---|".repeat(7));
    for place in PLACES {
        let cell = place.cell(sensors);
        let [o, s, t] = cell.coverage.map(|c| format!("{:.1}", 100.0 * c));
        let t = if place.temperature {
            t
        } else {
            "–".to_owned()
        };
        println!(
            "| {} | {} | {} | {}, {} | {o}, {s}, {t} ({:.1}) | {:.3} | {:.1} |",
            place.days,
            if place.temperature { "yes" } else { "no" },
            place.motion,
            place.posture[0],
            place.posture[1],
            100.0 * cell.worst,
            cell.expanded,
            100.0 * cell.refused
        );
    }
}

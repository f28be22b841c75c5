//! Lines of an encoder: how often their 95 % intervals hold the truth, and how often one is found where there is none.
//!
//! Prints the table of docs/velocity.md: `cargo run --release -p proofmass-motion --example encoder_map_coverage [RECORDS]`,
//! 1000 records a cell if no number is given. The suite takes one record of each (`tests/encoder_map.rs`).

use proofmass_core::Unwatched;
use proofmass_motion::{MapSearch, MotionRecord, ReadingSource};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

/// Of the wheel, m.
pub const RADIUS: f64 = 0.005;
const DT: f64 = 1e-3;

/// How a wheel of 5 mm shows its motion in 2000 counts per turn.
#[derive(Clone, Copy, Default)]
pub struct Wheel {
    /// Of the disc, rad.
    pub eccentricity: f64,
    /// Angle of the disc, rad.
    pub phase: f64,
    /// By how much the edges of a line stand too far, counts.
    pub quarters: [f64; 4],
    /// Extra way the wheel makes from 3 s to 3.3 s, m.
    pub slip: f64,
}

/// Way of one count, m.
pub const COUNT: f64 = TAU * RADIUS / 2000.0;

impl Wheel {
    /// Rolled ±0.14 m, four and a half turns to either side, with the truth of its velocity.
    pub fn roll(&self, seed: u64) -> (MotionRecord, Vec<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        // Two sines whose periods have no common multiple in the record: the roundings differ every time.
        let parts = [(0.12, 0.31, 0.4 * normal()), (0.02, 0.97, 0.4 * normal())];
        let place = |t: f64, order: u32| -> f64 {
            let part = |&(a, f, p): &(f64, f64, f64)| {
                let w = TAU * f;
                match order {
                    0 => a * (w * t + p).sin(),
                    1 => a * w * (w * t + p).cos(),
                    _ => -a * w * w * (w * t + p).sin(),
                }
            };
            parts.iter().map(part).sum()
        };
        let time = |k: usize| DT * k as f64;
        let reading = (0..8000).map(|k| {
            let spun = ((time(k) - 3.0) / 0.3).clamp(0.0, 1.0);
            let x = place(time(k), 0) + self.slip * spun;
            let shown = x + RADIUS * self.eccentricity * (x / RADIUS + self.phase).sin();
            Some(self.count(shown / COUNT) * COUNT)
        });
        let acceleration = (0..8000).map(|k| place(time(k), 2) + 0.05 + 0.02 * normal());
        let mut record = MotionRecord::new(
            DT,
            ReadingSource::Position,
            reading.collect(),
            acceleration.collect(),
        )
        .unwrap();
        record.increment = Some(COUNT);
        (record, (0..8000).map(|k| place(time(k), 1)).collect())
    }

    /// The count n between the edges n − ½ and n + ½, each where it stands.
    fn count(&self, y: f64) -> f64 {
        let edge = |n: f64| n - 0.5 + self.quarters[n.rem_euclid(4.0) as usize];
        let n = y.round();
        if y < edge(n) {
            n - 1.0
        } else if y >= edge(n + 1.0) {
            n + 1.0
        } else {
            n
        }
    }
}

/// An eccentric wheel.
pub fn wheel(eccentricity: f64, phase: f64, seed: u64) -> (MotionRecord, Vec<f64>) {
    let wheel = Wheel {
        eccentricity,
        phase,
        ..Wheel::default()
    };
    wheel.roll(seed)
}

/// Eccentricity and ellipse.
pub fn search() -> MapSearch {
    let mut search = MapSearch::default();
    search.turn = TAU * RADIUS;
    search.orders = vec![1.0, 2.0];
    search
}

/// Cosine and sine of the first line that a wheel shows: m.
pub fn truth(wheel: &Wheel) -> [f64; 2] {
    if wheel.quarters != [0.0; 4] {
        // The cell of count 0 lies between edges that stand 0 and 0.1 too far, its middle 0.05: the reading is too small.
        return [-0.05 * COUNT; 2];
    }
    let size = RADIUS * wheel.eccentricity;
    [size * wheel.phase.sin(), size * wheel.phase.cos()]
}

/// Eccentricity and ellipse, and unequal quarters where they are asked for.
pub fn search_for(quarters: bool) -> MapSearch {
    let mut search = search();
    search.quarters = quarters;
    search
}

/// Wheels of the map that show something, with their names.
pub const WHEELS: [(&str, Wheel); 5] = {
    const PLAIN: Wheel = Wheel {
        eccentricity: 0.0,
        phase: 0.7,
        quarters: [0.0; 4],
        slip: 0.0,
    };
    [
        (
            "eccentric by 0.01 rad",
            Wheel {
                eccentricity: 0.01,
                ..PLAIN
            },
        ),
        (
            "eccentric by 0.03 rad",
            Wheel {
                eccentricity: 0.03,
                ..PLAIN
            },
        ),
        (
            "eccentric by 0.01 rad, slips by 60 mm",
            Wheel {
                eccentricity: 0.01,
                slip: 0.06,
                ..PLAIN
            },
        ),
        (
            "eccentric by 0.03 rad, slips by −50 mm",
            Wheel {
                eccentricity: 0.03,
                slip: -0.05,
                ..PLAIN
            },
        ),
        (
            "quarters unequal by ±0.1 counts",
            Wheel {
                quarters: [0.0, 0.1, 0.0, -0.1],
                ..PLAIN
            },
        ),
    ]
};

/// Errors of cosine and sine over their standard uncertainties; none where the first line is not the true one.
pub fn errors(wheel: &Wheel, seed: u64) -> Option<[f64; 2]> {
    let quarters = wheel.quarters != [0.0; 4];
    let (record, _) = wheel.roll(seed);
    let found = search_for(quarters).run(&record, &Unwatched).ok()?;
    let line = found.map.lines.first()?;
    let order = if quarters { 500.0 } else { 1.0 };
    let [cosine, sine] = truth(wheel);
    ((line.order - order).abs() < 1e-9).then(|| {
        [(line.cosine - cosine, 0), (line.sine - sine, 1)]
            .map(|(error, axis)| error / line.covariance[axis][axis].sqrt())
    })
}

#[allow(dead_code, reason = "a test has no use for the printed table")]
fn main() {
    let records: u64 = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(1000);
    println!("| wheel | records | line found | cosine held in % | sine held in % |");
    println!("|---|---|---|---|---|");
    for (name, wheel) in &WHEELS {
        let all: Vec<[f64; 2]> = (0..records).filter_map(|s| errors(wheel, s)).collect();
        let held = |axis: usize| {
            let inside = all.iter().filter(|z| z[axis].abs() < 1.959_964).count();
            100.0 * inside as f64 / all.len().max(1) as f64
        };
        println!(
            "| {name} | {records} | {} | {:.1} | {:.1} |",
            all.len(),
            held(0),
            held(1)
        );
    }
    for (name, quarters) in [("ideal", false), ("ideal, quarters sought", true)] {
        let false_lines = (0..records)
            .filter(|seed| {
                let (record, _) = Wheel::default().roll(1_000_000 + seed);
                let found = search_for(quarters).run(&record, &Unwatched);
                found.is_ok_and(|f| !f.map.lines.is_empty())
            })
            .count();
        println!("| {name} | {records} | {false_lines} | | |");
    }
}

//! Are rests at known angles found, and do the intervals of bias, sensitivity and misalignment hold the truth?
//!
//! Prints the table of docs/static-tests.md: `cargo run --release -p proofmass-jobs --example single_axis_map`. A recording of one
//! axis at 12, 24 or 36 angles is simulated and calibrated as the command calibrates it. Arguments are the number of
//! recordings per cell (1000) and how many cells are passed over (0).

use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::{Memory, StoredResult, Unwatched};
use proofmass_rig::TurnedAxis;
use proofmass_uncertainty::Severity;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::sync::Arc;

/// One place of the map.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Number of angles over a turn.
    pub angles: usize,
    /// Sampling rate, Hz.
    pub rate: f64,
    /// Mean duration of a rest, s.
    pub rest: f64,
    /// Duration of a turn from angle to angle, s.
    pub turn: f64,
    /// Noise of a sample, m/s².
    pub noise: f64,
    /// Swing while it turns, m/s².
    pub jolt: f64,
    /// Tremor in a rest, m/s².
    pub tremor: f64,
    /// Share of the rests that are touched.
    pub touched: f64,
    /// Angles that were passed over in the recording though they are listed.
    pub missing: usize,
    /// Rests that are in the recording though they are not listed.
    pub added: usize,
}

/// What came of the recordings of one place.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    /// Recordings.
    pub recordings: usize,
    /// Those that were refused.
    pub refused: usize,
    /// Those with a decision.
    pub decided: usize,
    /// Of those without one: intervals that hold the truth, and all of them.
    pub held: [usize; 3],
    /// Recordings without a decision.
    pub stated: usize,
    /// Of those without a decision: a value beyond three times its U.
    pub beyond: usize,
    /// Of those without a decision: φ wrong by more than a degree.
    pub turned: usize,
    /// First refusal.
    pub reason: Option<String>,
    /// First decision.
    pub decision: Option<String>,
}

impl Place {
    /// Runs many recordings.
    pub fn cell(&self, recordings: usize) -> Cell {
        let results: Vec<_> = (0..recordings as u64)
            .into_par_iter()
            .map(|seed| self.one(seed))
            .collect();
        let mut cell = Cell {
            recordings,
            ..Cell::default()
        };
        for result in results {
            match result {
                Err(reason) => {
                    cell.refused += 1;
                    cell.reason.get_or_insert(reason);
                }
                Ok((_, Some(decision))) => {
                    cell.decided += 1;
                    cell.decision.get_or_insert(decision);
                }
                Ok((ratios, None)) => {
                    cell.stated += 1;
                    for (held, [off, expanded]) in cell.held.iter_mut().zip(ratios) {
                        *held += usize::from(off <= expanded);
                    }
                    cell.beyond += usize::from(ratios.iter().any(|[off, u]| *off > 3.0 * u));
                    cell.turned += usize::from(ratios[2][0] > 1f64.to_radians());
                }
            }
        }
        cell
    }

    /// Departure and U of bias, sensitivity and misalignment, and the decision that has to be made.
    fn one(&self, seed: u64) -> Result<([[f64; 2]; 3], Option<String>), String> {
        let step = 360.0 / self.angles as f64;
        let listed: Vec<f64> = (0..self.angles).map(|i| step * i as f64).collect();
        let mut actual = listed.clone();
        for k in 0..self.missing {
            actual.remove((seed as usize * 7 + 3 * k) % actual.len());
        }
        for k in 0..self.added {
            let at = (seed as usize * 5 + 3 * k) % actual.len();
            actual.insert(at, actual[at] + 0.4 * step);
        }
        let mut rig = TurnedAxis::default();
        rig.angles = actual.iter().map(|a| a.to_radians()).collect();
        rig.rate = self.rate;
        rig.rest = self.rest;
        rig.turn = self.turn;
        rig.noise = self.noise;
        rig.resolution = 1e-4;
        rig.jolt = self.jolt;
        rig.tremor = self.tremor;
        rig.touched = self.touched;
        let recording = rig.simulate(seed);
        let mut text = "a_m/s2\n".to_owned();
        for value in &recording.output {
            let _ = writeln!(text, "{value:.4}");
        }
        let campaign = format!(
            "kind = \"single-axis\"\n[recording]\nfile = \"turn.csv\"\ncolumn = \"a\"\nsampling_rate_Hz = {:?}\n\
             [position]\nangles_deg = {listed:?}\n[gravity]\nvalue = {}\nstandard_uncertainty = 1e-6\n",
            self.rate, rig.gravity
        );
        let store = Memory::new()
            .file("campaign.toml", campaign)
            .file("turn.csv", text);
        let result = Campaign::read(Arc::new(store), "campaign.toml")
            .map_err(|e| e.to_string())?
            .evaluate(None, &Unwatched)
            .map_err(|e| e.to_string())?;
        stated(&result, &rig)
    }
}

fn stated(
    result: &StoredResult,
    rig: &TurnedAxis,
) -> Result<([[f64; 2]; 3], Option<String>), String> {
    let truth = [
        ("bias", rig.bias),
        ("sensitivity", rig.sensitivity),
        ("misalignment", rig.misalignment),
    ];
    let mut ratios = [[0.0; 2]; 3];
    for (ratio, (name, truth)) in ratios.iter_mut().zip(truth) {
        let all = result.quantities().iter();
        let quantity = all
            .into_iter()
            .find(|q| q.name == name)
            .ok_or_else(|| format!("no {name}"))?;
        *ratio = [(quantity.value - truth).abs(), quantity.expanded];
    }
    let decision = result
        .findings()
        .iter()
        .find(|f| f.severity() == Severity::Decision)
        .map(|f| format!("{}: {}", f.code(), f.evidence_text()));
    Ok((ratios, decision))
}

fn main() {
    let argument = |i| std::env::args().nth(i).and_then(|a| a.parse().ok());
    let (recordings, passed) = (argument(1).unwrap_or(1000), argument(2).unwrap_or(0));
    println!(
        "| angles | rate / Hz | rest / s | turn / s | noise / (mm/s²) | swing / (m/s²) | tremor / (mm/s²) | touched / % | not turned to, not listed | b, S, φ hold / % | beyond 3 U | φ off 1° | decision / % | refused / % |"
    );
    println!("|{}", "---|".repeat(14));
    for place in &PLACES[passed.min(PLACES.len())..] {
        let cell = place.cell(recordings);
        let share = |n: usize| 100.0 * n as f64 / cell.recordings as f64;
        let held = cell
            .held
            .map(|h| format!("{:.1}", 100.0 * h as f64 / cell.stated.max(1) as f64));
        println!(
            "| {} | {} | {} | {} | {} | {} | {} | {} | {}, {} | {} | {} | {} | {:.1} | {:.1} |",
            place.angles,
            place.rate,
            place.rest,
            place.turn,
            1e3 * place.noise,
            place.jolt,
            1e3 * place.tremor,
            1e2 * place.touched,
            place.missing,
            place.added,
            held.join(", "),
            cell.beyond,
            cell.turned,
            share(cell.decided),
            share(cell.refused),
        );
        for text in cell.reason.iter().chain(&cell.decision) {
            eprintln!("    {text}");
        }
    }
}

const fn place(angles: usize, rate: f64, rest: f64, noise: f64, jolt: f64) -> Place {
    Place {
        angles,
        rate,
        rest,
        turn: 1.0,
        noise,
        jolt,
        tremor: 0.0,
        touched: 0.0,
        missing: 0,
        added: 0,
    }
}

/// The map.
pub const PLACES: [Place; 15] = [
    place(12, 50.0, 10.0, 0.01, 1.0),
    place(12, 100.0, 5.0, 0.01, 0.02),
    place(12, 100.0, 3.0, 0.05, 0.2),
    place(24, 100.0, 3.0, 0.01, 1.0),
    place(24, 50.0, 5.0, 0.02, 0.05),
    place(36, 50.0, 5.0, 0.01, 1.0),
    place(36, 50.0, 5.0, 0.01, 0.02),
    Place {
        tremor: 0.02,
        ..place(12, 50.0, 10.0, 0.01, 0.5)
    },
    Place {
        touched: 0.2,
        ..place(12, 50.0, 10.0, 0.01, 0.5)
    },
    Place {
        touched: 0.2,
        tremor: 0.02,
        ..place(24, 50.0, 6.0, 0.01, 0.2)
    },
    Place {
        touched: 0.1,
        ..place(36, 50.0, 6.0, 0.01, 0.2)
    },
    Place {
        missing: 1,
        touched: 0.1,
        ..place(12, 50.0, 10.0, 0.01, 0.5)
    },
    Place {
        added: 1,
        ..place(12, 50.0, 10.0, 0.01, 0.5)
    },
    Place {
        missing: 1,
        touched: 0.1,
        ..place(24, 50.0, 6.0, 0.01, 0.5)
    },
    Place {
        added: 1,
        missing: 1,
        touched: 0.1,
        ..place(36, 50.0, 6.0, 0.01, 0.2)
    },
];

//! Are sessions told that do not reproduce each other, how often are they accused that do, and do the intervals hold the truth?
//!
//! Prints the tables of docs/shaker.md: `cargo run -p proofmass-shaker --example session_map`. An argument sets the number of
//! campaigns per line (300).

use num_complex::Complex64;
use proofmass_rig::bench::session_gains;
use proofmass_shaker::{
    Acts, Budget, Correction, Fit, Key, Observations, PhasorRow, ShakerCampaign, ShakerInput,
    joint, observations,
};
use rayon::prelude::*;

#[path = "shaker_faults.rs"]
#[allow(dead_code, reason = "the simulator of the table of faults")]
pub mod shaker_faults;
use shaker_faults::runs;
use shaker_faults::shaker_coverage::{CASES, Case, Gluings, Simulated};

/// Which runs a session has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Every wedge in every session, in turn.
    Mixed,
    /// One session after the other in the order of the plan, wedge after wedge.
    Wedges,
}

/// What a session changes: standard deviations of the modulus (relative) and of the phase (rad).
#[derive(Clone, Copy, Debug)]
pub enum Change {
    /// Nothing.
    None,
    /// The gain of each output by itself.
    Outputs(f64),
    /// The gain of the reference.
    Reference(f64),
    /// The gain of one output in the last session, by just this.
    Step(f64),
}

/// Sessions of a campaign.
#[derive(Clone, Copy, Debug)]
pub struct Sessions {
    /// Mountings.
    pub gluings: Gluings,
    /// How many sessions.
    pub count: usize,
    /// Their runs.
    pub split: Split,
    /// What they change.
    pub change: Change,
    /// Whether the budget declares a change of each output by so much.
    pub declared: Option<f64>,
}

impl Sessions {
    /// The bench.
    pub fn bench(&self) -> Case {
        Case {
            gluings: self.gluings,
            repeats: Some((10, 2e-4)),
            ..CASES[0]
        }
    }

    /// What the laboratory declares.
    pub fn budget(&self) -> Budget {
        let mut inputs = self.bench().budget().inputs;
        if let Some(u) = self.declared {
            let keys = [Key::Session, Key::Channel];
            inputs.push(ShakerInput::new(
                "session.gain",
                Acts::OutputModulus,
                u,
                &keys,
            ));
            inputs.push(ShakerInput::new(
                "session.phase",
                Acts::OutputPhase,
                u,
                &keys,
            ));
        }
        Budget::new(inputs).expect("a budget")
    }

    /// Runs of three frequencies, with their session.
    pub fn campaign(&self, seed: u64) -> Simulated {
        let mut simulated = self.bench().campaign(&[10.0, 160.0, 1000.0], seed);
        let n = simulated.rows.len() / 3;
        let drawn = |u: f64| session_gains(self.count, u, seed);
        let one = Complex64::new(1.0, 0.0);
        let gains: Vec<[Complex64; 3]> = match self.change {
            Change::None => vec![[one; 3]; self.count],
            Change::Outputs(u) => drawn(u),
            Change::Reference(u) => drawn(u).into_iter().map(|g| [g[0]; 3]).collect(),
            Change::Step(size) => {
                let mut gains = vec![[one; 3]; self.count];
                gains[self.count - 1][1] += size;
                gains
            }
        };
        for (i, row) in simulated.rows.iter_mut().enumerate() {
            let session = match self.split {
                Split::Mixed => i % n % self.count,
                Split::Wedges => i % n * self.count / n,
            };
            row.session = Some(format!("day {}", session + 1));
            for (output, gain) in row.outputs.iter_mut().zip(gains[session]) {
                *output *= gain;
            }
        }
        simulated
    }

    /// Runs and budget as a calibration has them.
    pub fn seen(&self, simulated: &Simulated) -> (Vec<PhasorRow>, Budget) {
        let mut campaign = ShakerCampaign::new(runs(&simulated.rows), self.budget());
        campaign.corrections = vec![Correction {
            label: "measured".to_owned(),
            table: simulated.spurious.clone(),
        }];
        let Observations { rows, budget, .. } = observations(&campaign).expect("sound runs");
        (rows, budget)
    }

    /// The joint fit of a campaign.
    pub fn fit(&self, seed: u64) -> (Fit, Simulated) {
        let mut simulated = self.campaign(seed);
        simulated.spurious = simulated.spurious.pooled("measured").0;
        let (rows, budget) = self.seen(&simulated);
        let fit = joint(&rows, &simulated.spurious, &budget).expect("sound runs");
        (fit, simulated)
    }
}

/// Whether the sessions are said to differ.
pub fn differ(fit: &Fit) -> bool {
    fit.findings.iter().any(|f| f.code() == "sessions-differ")
}

/// Share of the intervals of the moduli of the main terms, and of all reals, that hold the truth; mean relative U of the main terms.
pub fn holding(fit: &Fit, simulated: &Simulated) -> [f64; 3] {
    let (mut main, mut all, mut width) = (0, 0, 0.0);
    for (f, truth) in fit.frequencies.iter().zip(&simulated.truth) {
        for (p, q) in f.estimate.quantities().iter().enumerate() {
            let s = truth[p / 6][p / 2 % 3];
            let truth = if p % 2 == 0 { s.re } else { s.im };
            let held = (q.value - truth).abs() <= q.expanded(0.95);
            all += i32::from(held);
            if [0, 8, 16].contains(&p) {
                main += i32::from(held);
                width += q.expanded(0.95) / q.value;
            }
        }
    }
    let n = fit.frequencies.len() as f64;
    [
        f64::from(main) / (3.0 * n),
        f64::from(all) / (18.0 * n),
        width / (3.0 * n),
    ]
}

#[allow(dead_code, reason = "a test has no use for the printed table")]
fn main() {
    let campaigns: u64 = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(300);
    let only = std::env::args().nth(2).unwrap_or_default();
    println!(
        "| sessions change | mountings, sessions, runs | declared | `sessions-differ` | main | all 18 | U main in % |"
    );
    println!("|---|---|---|---|---|---|---|");
    let plans = [
        (Gluings::Published, 2, Split::Mixed),
        (Gluings::Published, 2, Split::Wedges),
        (Gluings::Published, 5, Split::Mixed),
        (Gluings::Twelve, 2, Split::Mixed),
        (Gluings::Twelve, 3, Split::Mixed),
    ];
    let changes = [
        ("nothing", Change::None, None),
        ("nothing", Change::None, Some(0.003)),
        ("outputs 0.3 %", Change::Outputs(0.003), None),
        ("outputs 0.3 %", Change::Outputs(0.003), Some(0.003)),
        ("outputs 1 %", Change::Outputs(0.01), None),
        ("outputs 1 %", Change::Outputs(0.01), Some(0.003)),
        ("reference 0.3 %", Change::Reference(0.003), None),
        ("reference 1 %", Change::Reference(0.01), None),
        ("output y by 0.5 %", Change::Step(0.005), None),
        ("output y by 1 %", Change::Step(0.01), None),
    ];
    for (change, what, declared) in changes {
        for (gluings, count, split) in plans {
            let sessions = Sessions {
                gluings,
                count,
                split,
                change: what,
                declared,
            };
            let name = format!("{change} {gluings:?} {count} {split:?} {declared:?}");
            if !name.contains(&only) {
                continue;
            }
            let all: Vec<(bool, [f64; 3])> = (0..campaigns)
                .into_par_iter()
                .map(|seed| {
                    let (fit, simulated) = sessions.fit(400_000 + seed);
                    (differ(&fit), holding(&fit, &simulated))
                })
                .collect();
            let n = campaigns as f64;
            let told = all.iter().filter(|a| a.0).count() as f64 / n;
            let mountings = match gluings {
                Gluings::Published => 44,
                Gluings::Twelve => 12,
                Gluings::Six => 6,
            };
            let split = match split {
                Split::Mixed => "mixed",
                Split::Wedges => "wedge after wedge",
            };
            let mean = |k: usize| 100.0 * all.iter().map(|a| a.1[k]).sum::<f64>() / n;
            println!(
                "| {change} | {mountings}, {count}, {split} | {} | {:.2} | {:.1} | {:.1} | {:.3} |",
                declared.map_or("no".to_owned(), |u| format!("{} %", 100.0 * u)),
                100.0 * told,
                mean(0),
                mean(1),
                mean(2),
            );
        }
    }
}

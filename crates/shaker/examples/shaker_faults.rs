//! How well are faults of a campaign on the shaker named, and how often is a sound one accused?
//!
//! Prints the tables of docs/shaker.md: `cargo run --release -p proofmass-shaker --example shaker_faults`. Arguments
//! set the number of sound campaigns (500) and of seeds per fault of a whole campaign (20).

use num_complex::Complex64;
use proofmass_shaker::recording::RunInput;
use proofmass_shaker::{Configuration, PhasorRow, ShakerCampaign, Suspicion, calibrate, diagnose};
use proofmass_uncertainty::Severity;
use rayon::prelude::*;

#[path = "shaker_coverage.rs"]
#[allow(dead_code, reason = "the simulator of the coverage table")]
pub mod shaker_coverage;
use shaker_coverage::{CASES, Case, Simulated};

/// A fault of one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The cables of two outputs exchanged.
    Swapped(usize, usize),
    /// One output inverted.
    Inverted,
    /// The reference inverted.
    ReferenceInverted,
    /// A range switch of ten on one output.
    OneGain,
    /// A range switch of ten on all outputs.
    AllGains,
    /// The next wedge of the plan at the same rotation.
    Wedge,
    /// An eighth of a turn too far.
    Rotation,
    /// Taken at 1000 Hz.
    Frequency,
    /// The phasors of another run.
    Copied,
    /// The strongest output dead.
    Dead,
    /// All outputs cut off at a level of 0.6 of the strongest.
    Clipped,
    /// The cables of the reference, of 10 mV/(m/s²), and of the strongest output exchanged.
    ReferenceSwapped,
}

/// Sensitivity of the reference, V/(m/s²).
const REFERENCE: Complex64 = Complex64::new(0.01, 0.0);

/// All of them: thirteen at each of 22 positions are 286.
pub const FAULTS: [Fault; 13] = [
    Fault::Swapped(0, 1),
    Fault::Swapped(1, 2),
    Fault::Inverted,
    Fault::ReferenceInverted,
    Fault::OneGain,
    Fault::AllGains,
    Fault::Wedge,
    Fault::Rotation,
    Fault::Frequency,
    Fault::Copied,
    Fault::Dead,
    Fault::Clipped,
    Fault::ReferenceSwapped,
];

/// What is left of the fundamental of a sine of amplitude one that is cut off, by a sum over one period.
fn cut(level: f64) -> f64 {
    let n = 20_000;
    let sample = |i: usize| (std::f64::consts::TAU * i as f64 / f64::from(n)).cos();
    let sum: f64 = (0..n as usize)
        .map(|i| sample(i).clamp(-level, level) * sample(i))
        .sum();
    2.0 * sum / f64::from(n)
}

fn strongest(row: &PhasorRow) -> usize {
    (0..3)
        .max_by(|&a, &b| row.outputs[a].norm().total_cmp(&row.outputs[b].norm()))
        .unwrap_or(0)
}

impl Fault {
    /// Strikes a row of a campaign with three frequencies of 44 runs.
    pub fn strike(self, rows: &mut [PhasorRow], index: usize) {
        let first = index - index % 44;
        let by_place = |inclination: f64, rotation: f64| {
            let wanted = Configuration::degrees(inclination, rotation);
            (first..first + 44).find(|&k| rows[k].configuration.same_as(&wanted))
        };
        let c = rows[index].configuration;
        let (a, w) = (
            c.inclination.to_degrees().round(),
            c.rotation.to_degrees().round(),
        );
        let take = |rows: &mut [PhasorRow], from: usize| {
            let ratio = rows[index].reference / rows[from].reference;
            rows[index].outputs = rows[from].outputs.map(|o| o * ratio);
        };
        match self {
            Self::Swapped(i, j) => rows[index].outputs.swap(i, j),
            Self::Inverted => {
                let k = strongest(&rows[index]);
                rows[index].outputs[k] = -rows[index].outputs[k];
            }
            Self::ReferenceInverted => rows[index].reference = -rows[index].reference,
            Self::OneGain => {
                let k = strongest(&rows[index]);
                rows[index].outputs[k] *= 10.0;
            }
            Self::AllGains => rows[index].outputs = rows[index].outputs.map(|o| o * 10.0),
            Self::Wedge => {
                let other = match a as i64 {
                    0 => by_place(15.0, w),
                    15 => by_place(35.0, w),
                    35 => by_place(55.0, w),
                    55 => by_place(75.0, w),
                    75 => by_place(90.0, w),
                    _ => by_place(75.0, w),
                };
                if let Some(from) = other {
                    take(rows, from);
                }
            }
            Self::Rotation => {
                let step = if a == 0.0 { 90.0 } else { 45.0 };
                if let Some(from) = by_place(a, (w + step) % 360.0) {
                    take(rows, from);
                }
            }
            Self::Frequency => take(rows, index % 44 + 88),
            Self::Copied => {
                let from = first + (index - first + 17) % 44;
                rows[index].outputs = rows[from].outputs;
                rows[index].reference = rows[from].reference;
            }
            Self::Dead => {
                let k = strongest(&rows[index]);
                rows[index].outputs[k] = Complex64::new(1e-6, 2e-6);
            }
            Self::ReferenceSwapped => {
                let row = &mut rows[index];
                let k = strongest(row);
                let device = row.outputs[k];
                row.outputs[k] = row.reference * REFERENCE;
                row.reference = device / REFERENCE;
            }
            Self::Clipped => {
                let level = 0.6 * rows[index].outputs[strongest(&rows[index])].norm();
                let outputs = &mut rows[index].outputs;
                for o in outputs.iter_mut() {
                    *o *= cut(level / o.norm().max(1e-12));
                }
            }
        }
    }

    /// Whether a suspicion is this fault.
    fn named(self, suspicion: &Suspicion) -> bool {
        match (self, suspicion) {
            (Self::Swapped(i, j), Suspicion::Channels { channel, sign }) => {
                channel[i] == j && channel[j] == i && *sign == [1; 3]
            }
            (Self::Inverted, Suspicion::Channels { channel, sign }) => {
                *channel == [0, 1, 2] && sign.iter().filter(|s| **s < 0).count() == 1
            }
            (Self::ReferenceInverted, Suspicion::Channels { sign, .. }) => *sign == [-1; 3],
            (Self::OneGain, Suspicion::Gain { channel, factor }) => {
                channel.is_some() && (factor / 10.0 - 1.0).abs() < 0.05
            }
            (Self::AllGains, Suspicion::Gain { channel, factor }) => {
                channel.is_none() && (factor / 10.0 - 1.0).abs() < 0.05
            }
            (Self::Wedge | Self::Rotation, Suspicion::Mounting { .. }) => true,
            (Self::Frequency, Suspicion::Frequency { frequency }) => *frequency == 1000.0,
            (Self::Copied, Suspicion::Copied { .. }) => true,
            (Self::Dead, Suspicion::Dead { .. }) => true,
            (Self::Clipped, Suspicion::Clipped { .. }) => true,
            (Self::ReferenceSwapped, Suspicion::ReferenceSwapped { .. }) => true,
            _ => false,
        }
    }

    fn verdict(self, suspicion: &Suspicion) -> Verdict {
        match suspicion {
            Suspicion::Either(a, b) if self.named(a) || self.named(b) => {
                if self.named(a) {
                    Verdict::FirstOfTwo
                } else {
                    Verdict::SecondOfTwo
                }
            }
            other if self.named(other) => Verdict::Alone,
            Suspicion::Unexplained => Verdict::Unexplained,
            _ => Verdict::Wrong,
        }
    }
}

/// What became of a struck run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Named, and nothing else.
    Alone,
    /// Named first of two.
    FirstOfTwo,
    /// Named second of two.
    SecondOfTwo,
    /// Found, without a cause.
    Unexplained,
    /// Found, with another cause.
    Wrong,
    /// Not found.
    Unseen,
    /// The calibration stopped.
    Stopped,
}

/// The case that is struck.
pub fn usual() -> Case {
    Case {
        repeats: Some((10, 2e-4)),
        ..CASES[0]
    }
}

/// One struck run: its verdict, and the sound runs that were accused.
pub fn single(fault: Fault, position: usize, seed: u64) -> (Verdict, usize) {
    let Simulated {
        mut rows, spurious, ..
    } = usual().campaign(&[10.0, 160.0, 1000.0], seed);
    for row in &mut rows {
        row.reference_sensitivity = Some(REFERENCE);
    }
    let index = 44 + position;
    fault.strike(&mut rows, index);
    let Ok((suspects, _)) = diagnose(&rows, &spurious, &usual().budget(), None) else {
        return (Verdict::Stopped, 0);
    };
    let verdict = suspects
        .iter()
        .find(|s| s.row == index)
        .map_or(Verdict::Unseen, |s| fault.verdict(&s.suspicion));
    // A copy is as good as its original: either may be named.
    let others = suspects.iter().filter(|s| s.row != index).count();
    (verdict, others)
}

/// Faults of a whole campaign, and the code that names each.
pub const THROUGHOUT: [(&str, &str); 9] = [
    ("phases of the runs conjugated", "phases-conjugated"),
    ("rotation counted backwards", "angle-sense"),
    ("inclination counted backwards", "angle-sense"),
    ("x′ of the spurious motion reversed", "spurious-sign"),
    ("y′ of the spurious motion reversed", "spurious-sign"),
    ("reference inverted", "reference-inverted"),
    ("cables of x and y", "swapped-channels"),
    ("mask 10° off", "mask-offset"),
    ("conditioner drifts by 1 %", "gain-drift"),
];

/// Findings that need a look, of a campaign with one of [`THROUGHOUT`].
pub fn throughout(fault: usize, seed: u64) -> Vec<String> {
    let case = match fault {
        7 => Case {
            mask: [0.0, 0.0],
            ..usual()
        },
        _ => usual(),
    };
    let Simulated {
        mut rows,
        mut spurious,
        ..
    } = case.campaign(&[10.0, 160.0, 1000.0], seed);
    for (i, row) in rows.iter_mut().enumerate() {
        match fault {
            0 => {
                row.reference = row.reference.conj();
                row.outputs = row.outputs.map(|o| o.conj());
            }
            1 => row.configuration.rotation = -row.configuration.rotation,
            2 => row.configuration.inclination = -row.configuration.inclination,
            5 => row.reference = -row.reference,
            6 => row.outputs.swap(0, 1),
            7 => row.configuration.rotation += 10f64.to_radians(),
            8 => {
                // Gluing after gluing, with all frequencies at each.
                let gain = 1.0 + 0.01 * ((i % 44) as f64 / 43.0 - 0.5);
                row.outputs = row.outputs.map(|o| o * gain);
            }
            _ => {}
        }
    }
    for entry in &mut spurious.entries {
        match fault {
            2 => entry.inclination = -entry.inclination,
            3 => entry.ratio[0] = -entry.ratio[0],
            4 => entry.ratio[1] = -entry.ratio[1],
            _ => {}
        }
    }
    codes(&case, rows, spurious)
}

/// Rows as the runs of a campaign.
pub fn runs(rows: &[PhasorRow]) -> Vec<RunInput> {
    rows.iter()
        .map(|r| RunInput {
            run: r.run.clone(),
            session: r.session.clone(),
            frequency: r.frequency,
            configuration: r.configuration,
            reference: r.reference,
            outputs: r.outputs,
            covariance: r.covariance,
            quality: Default::default(),
        })
        .collect()
}

/// Codes of the findings of a calibration but for notes.
pub fn codes(
    case: &Case,
    rows: Vec<PhasorRow>,
    spurious: proofmass_shaker::SpuriousTable,
) -> Vec<String> {
    let runs = runs(&rows);
    let mut campaign = ShakerCampaign::new(runs, case.budget());
    campaign.methods = vec![proofmass_shaker::ShakerMethod::Joint];
    campaign.corrections = vec![proofmass_shaker::Correction {
        label: "measured".to_owned(),
        table: spurious,
    }];
    let Ok(calibration) = calibrate(&campaign) else {
        return vec!["stopped".to_owned()];
    };
    let own = calibration.results.iter().flat_map(|r| &r.findings);
    calibration
        .findings
        .iter()
        .chain(own)
        .filter(|f| f.severity() != Severity::Note)
        .map(|f| f.code().to_owned())
        .collect()
}

/// A campaign of nine frequencies whose certificate is 2 % off at one of them, if any: what the diagnosis says.
pub fn certificate(off: Option<usize>, seed: u64) -> Vec<proofmass_uncertainty::Finding> {
    let frequencies = [5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 315.0, 630.0, 1000.0];
    let mut simulated = usual().campaign(&frequencies, seed);
    if let Some(k) = off {
        for row in &mut simulated.rows[44 * k..44 * (k + 1)] {
            row.reference *= 1.02;
        }
    }
    let (rows, spurious) = (&simulated.rows, &simulated.spurious);
    let told = diagnose(rows, spurious, &usual().budget(), None);
    told.map(|(_, findings)| findings).unwrap_or_default()
}

/// Whether a sound campaign of three frequencies is told to need anything, and how many of its runs are accused.
pub fn sound(seed: u64) -> Vec<String> {
    let simulated = usual().campaign(&[10.0, 160.0, 1000.0], seed);
    codes(&usual(), simulated.rows, simulated.spurious)
}

#[allow(dead_code, reason = "a test has no use for the printed table")]
fn main() {
    let argument = |k: usize, otherwise: u64| {
        let given = std::env::args().nth(k).and_then(|a| a.parse().ok());
        given.unwrap_or(otherwise)
    };
    let (campaigns, seeds) = (argument(1, 500), argument(2, 20));
    println!(
        "| fault | alone | first of two | second | no cause | wrong cause | unseen | stopped | sound runs accused |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for fault in FAULTS {
        let all: Vec<(Verdict, usize)> = (0..22usize)
            .into_par_iter()
            .map(|k| single(fault, 2 * k, 70_000 + k as u64))
            .collect();
        let count = |v: Verdict| all.iter().filter(|a| a.0 == v).count();
        println!(
            "| {fault:?} | {} | {} | {} | {} | {} | {} | {} | {} |",
            count(Verdict::Alone),
            count(Verdict::FirstOfTwo),
            count(Verdict::SecondOfTwo),
            count(Verdict::Unexplained),
            count(Verdict::Wrong),
            count(Verdict::Unseen),
            count(Verdict::Stopped),
            all.iter().map(|a| a.1).sum::<usize>(),
        );
    }
    for (k, (name, code)) in THROUGHOUT.iter().enumerate() {
        let all: Vec<Vec<String>> = (0..seeds)
            .into_par_iter()
            .map(|seed| throughout(k, 80_000 + seed))
            .collect();
        let named = all.iter().filter(|c| c.iter().any(|c| c == code)).count();
        let mut others: Vec<&String> = all.iter().flatten().filter(|c| c != code).collect();
        others.sort();
        others.dedup();
        println!("| {name} | {named} of {seeds} as {code} | beside it: {others:?} |");
    }
    for off in [
        None,
        Some(0),
        Some(1),
        Some(2),
        Some(3),
        Some(4),
        Some(5),
        Some(6),
        Some(7),
        Some(8),
    ] {
        let all: Vec<Vec<proofmass_uncertainty::Finding>> = (0..seeds)
            .into_par_iter()
            .map(|seed| certificate(off, 90_000 + seed))
            .collect();
        let named = all.iter().flatten();
        let named = named.filter(|f| f.code() == "certificate-off");
        let mut said: Vec<&str> = named.map(|f| f.what()).collect();
        let count = said.len();
        said.sort();
        said.dedup();
        println!("| certificate off at {off:?} | {count} of {seeds} named | {said:?} |");
    }
    let all: Vec<Vec<String>> = (0..campaigns)
        .into_par_iter()
        .map(|seed| sound(100_000 + seed))
        .collect();
    let accused = all.iter().filter(|c| !c.is_empty()).count();
    let mut said: Vec<&String> = all.iter().flatten().collect();
    said.sort();
    println!(
        "| sound campaigns | {accused} of {campaigns} with a warning or decision | {said:?} |"
    );
}

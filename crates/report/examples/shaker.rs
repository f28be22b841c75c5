//! The report of a simulated campaign: 44 configurations at nine frequencies, two measurements of the spurious motion.
//!
//! `cargo run -p proofmass-report --example shaker [FILE]` writes the page (`shaker.html` if no name is given) and prints
//! the terminal form.

use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
use proofmass_report::{Head, ShakerReport, html, terminal};
use proofmass_rig::bench::{Bench, BenchWedge, SpuriousReading, published_plan, target_amplitude};
use proofmass_shaker::monte_carlo::CheckOptions;
use proofmass_shaker::recording::{Quality, RunInput};
use proofmass_shaker::{
    Acts, Budget, Configuration, Correction, Key, PhasorRow, ShakerCampaign, ShakerInput,
    ShakerMethod, Spurious, SpuriousTable, calibrate, check,
};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

const FREQUENCIES: [f64; 9] = [5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 315.0, 630.0, 1000.0];

fn table(readings: &[SpuriousReading]) -> SpuriousTable {
    let entries = readings.iter().map(|s| {
        let v = s.standard_uncertainty.powi(2);
        Spurious {
            inclination: s.inclination_deg.to_radians(),
            dof: proofmass_uncertainty::DegreesOfFreedom::INFINITE,
            frequency: s.frequency,
            ratio: s.ratio,
            covariance: [[v, 0.0, v]; 3],
        }
    });
    SpuriousTable {
        entries: entries.collect(),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let bench = Bench {
        wedge: Some(BenchWedge::default()),
        ..Bench::default()
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
    let simulated = bench.campaign(&published_plan(), &FREQUENCIES, &mut rng);
    let again = bench.campaign(&published_plan(), &FREQUENCIES, &mut rng);
    let runs = simulated.runs.iter().enumerate().map(|(i, r)| {
        let row = PhasorRow::new(
            format!("run-{:03}", i + 1),
            r.frequency,
            Configuration::degrees(r.inclination_deg, r.rotation_deg),
            r.reference * 9.9e-3,
            r.outputs,
        );
        RunInput {
            run: row.run,
            frequency: row.frequency,
            configuration: row.configuration,
            reference: row.reference,
            outputs: row.outputs,
            covariance: row.covariance,
            quality: Quality::default(),
        }
    });
    let mut budget = Budget::published_bench();
    budget.inputs.retain(|i| i.key != "reference.calibration");
    budget.inputs.push(
        ShakerInput::new(
            "noise",
            Acts::OutputAdditive,
            bench.floor,
            &[Key::Run, Key::Channel],
        )
        .described("noise of the conditioner"),
    );
    let mut campaign = ShakerCampaign::new(runs.collect(), budget);
    let point = |frequency| ReferencePoint {
        frequency,
        sensitivity: 9.9e-3,
        phase: 0.0,
        modulus_uncertainty: bench.reference_modulus,
        phase_uncertainty: bench.reference_phase,
    };
    campaign.reference = Some(ReferenceTable::new(vec![point(5.0), point(1000.0)])?);
    campaign.methods = vec![
        ShakerMethod::Joint,
        ShakerMethod::Complex,
        ShakerMethod::PublishedMagnitude,
    ];
    campaign.targets = FREQUENCIES
        .iter()
        .map(|&f| (f, target_amplitude(f)))
        .collect();
    campaign.datasheet = Some((10.2e-3, 1.0e-3));
    campaign.corrections = vec![
        Correction {
            label: "first measurement".into(),
            table: table(&simulated.spurious),
        },
        Correction {
            label: "second measurement".into(),
            table: table(&again.spurious),
        },
        Correction {
            label: "none".into(),
            table: SpuriousTable::default(),
        },
    ];
    let calibration = calibrate(&campaign)?;
    let checks = check(
        &campaign,
        &calibration,
        &CheckOptions::default(),
        &mut |_| std::ops::ControlFlow::Continue(()),
    )?;
    let report = ShakerReport {
        head: Head {
            title: "Triaxial accelerometer, simulated campaign".into(),
            meta: vec![
                ("Device".into(), "simulated triaxial accelerometer".into()),
                ("Runs".into(), campaign.runs.len().to_string()),
            ],
            footer: "simulated, seed 4".into(),
            ..Head::default()
        },
        datasheet: campaign.datasheet,
        checks: &checks,
    };
    let file = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "shaker.html".into());
    std::fs::write(&file, html::render(&report.full(&calibration))?)?;
    let options = terminal::Options {
        width: 100,
        colour: false,
    };
    print!(
        "{}",
        terminal::render(&report.summary(&calibration), &options)?
    );
    Ok(())
}

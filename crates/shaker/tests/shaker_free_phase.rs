//! A sensor with a clock of its own: the phase that the outputs of a run have in common is unknown. Moduli, and phases among
//! the axes, have intervals that hold the truth; and a run that does not belong is named.

use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_rig::bench::{Bench, BenchCampaign, Spread, published_plan};
use proofmass_shaker::matrix::to_real;
use proofmass_shaker::{
    Acts, Budget, Configuration, Fit, Key, OutputPhases, PhasorRow, ShakerInput, SpuriousTable,
    Suspicion, complex, diagnose, joint,
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

pub(super) const FREQUENCIES: [f64; 2] = [80.0, 800.0];

pub(super) fn bench() -> Bench {
    Bench {
        wedge: None,
        spread: Spread::Normal,
        ..Bench::default()
    }
}

pub(super) fn budget(bench: &Bench) -> Budget {
    let r3 = 3f64.sqrt();
    let input = |key, acts, u, keys: &[Key]| ShakerInput::new(key, acts, u, keys);
    let run = [Key::Run, Key::Channel];
    Budget::new(vec![
        input(
            "reference",
            Acts::ReferenceModulus,
            bench.reference_modulus,
            &[Key::Frequency],
        ),
        input(
            "reference.phase",
            Acts::ReferencePhase,
            bench.reference_phase,
            &[Key::Frequency],
        ),
        input(
            "wedge",
            Acts::Inclination,
            bench.wedge_angle / r3,
            &[Key::Inclination],
        ),
        input(
            "gluing",
            Acts::Rotation,
            bench.gluing_angle / r3,
            &[Key::Inclination, Key::Rotation],
        ),
        input(
            "gain",
            Acts::OutputModulus,
            bench.gain / r3,
            &[Key::Channel],
        ),
        input("reading", Acts::OutputModulus, bench.reading, &run),
        input(
            "reading.phase",
            Acts::OutputPhase,
            bench.reading_phase,
            &run,
        ),
        input("noise", Acts::OutputAdditive, bench.floor, &run),
    ])
    .unwrap()
}

/// A campaign in which every run has a phase of its own.
fn campaign(bench: &Bench, plan: &[(f64, f64)], seed: u64) -> (BenchCampaign, Vec<PhasorRow>) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let campaign = bench.campaign(plan, &FREQUENCIES, &mut rng);
    let rows = campaign.runs.iter().enumerate().map(|(i, r)| {
        let turn = Complex64::from_polar(1.0, rng.random_range(-3.1..3.1));
        PhasorRow {
            phases: OutputPhases::InCommon,
            ..PhasorRow::new(
                format!("r{i}"),
                r.frequency,
                Configuration::degrees(r.inclination_deg, r.rotation_deg),
                r.reference,
                r.outputs.map(|o| o * turn),
            )
        }
    });
    let rows = rows.collect();
    (campaign, rows)
}

/// Of the 17 reals of every frequency whether the interval holds the truth, and χ² of all of them.
fn hits(fit: &Fit, campaign: &BenchCampaign) -> (Vec<bool>, f64) {
    let mut inside = vec![];
    for (f, truth) in fit.frequencies.iter().zip(&campaign.truth) {
        let turn = truth[0][0].conj() / truth[0][0].norm();
        let (here, there) = (
            to_real(&f.sensitivity),
            to_real(&truth.map(|r| r.map(|z| z * turn))),
        );
        assert!(here[1].abs() < 1e-9 * here[0], "S_xx is real");
        let c = f.estimate.covariance();
        for p in (0..18).filter(|p| *p != 1) {
            inside.push((here[p] - there[p]).abs() < 1.96 * c[(p, p)].sqrt());
        }
    }
    (inside, fit.chi_squared / fit.dof as f64)
}

#[test]
fn coverage_with_a_clock_of_its_own() {
    let bench = bench();
    let budget = budget(&bench);
    // Every third of the published configurations: 15 runs.
    let plan: Vec<(f64, f64)> = published_plan().into_iter().step_by(3).collect();
    for of in [complex, joint] {
        let trials = 200u64;
        let all: Vec<(Vec<bool>, f64)> = (0..trials)
            .into_par_iter()
            .map(|seed| {
                let (campaign, rows) = campaign(&bench, &plan, 4_000 + seed);
                hits(
                    &of(&rows, &SpuriousTable::default(), &budget).unwrap(),
                    &campaign,
                )
            })
            .collect();
        let counts: Vec<usize> = (0..34)
            .map(|k| all.iter().filter(|h| h.0[k]).count())
            .collect();
        let fit = all.iter().map(|h| h.1).sum::<f64>() / trials as f64;
        println!("{counts:?}, χ²/ν = {fit:.3}");
        // 190 ± 3.1; four standard deviations for each of 34 terms.
        assert!(counts.iter().all(|c| (177..=200).contains(c)), "{counts:?}");
        let share = counts.iter().sum::<usize>() as f64 / (34.0 * trials as f64);
        assert!((share - 0.95).abs() < 0.01, "{share}");
        // ν is 5 per run less 17 per frequency, and the angles add none.
        assert!((fit - 1.0).abs() < 0.05, "{fit}");
    }
}

#[test]
fn known_fault_of_a_run_with_a_clock_of_its_own() {
    let bench = bench();
    let budget = budget(&bench);
    let (_, rows) = campaign(&bench, &published_plan(), 11);
    let none = SpuriousTable::default();
    let (suspects, findings) = diagnose(&rows, &none, &budget, None).unwrap();
    assert!(suspects.is_empty(), "{suspects:?} {findings:?}");
    let mut wrong = rows.clone();
    wrong[17].outputs.swap(0, 1);
    wrong[60].outputs[2] *= -1.0;
    let (suspects, _) = diagnose(&wrong, &none, &budget, None).unwrap();
    let named: Vec<usize> = suspects.iter().map(|s| s.row).collect();
    assert_eq!(named, [17, 60]);
    for s in &suspects {
        let cables = matches!(
            s.suspicion,
            Suspicion::Channels { .. } | Suspicion::Either(..)
        );
        assert!(cables, "{s:?}");
    }
}

#[test]
fn refuses_phases_that_no_run_tells() {
    // One axis at a time: which phase the axes have against each other, nothing says.
    let bench = bench();
    let plan = [(0.0, 0.0), (90.0, 0.0), (90.0, 90.0), (90.0, 180.0)];
    let (_, rows) = campaign(&bench, &plan, 5);
    let error = complex(&rows, &SpuriousTable::default(), &budget(&bench)).unwrap_err();
    assert!(matches!(error, Error::Unobservable { .. }), "{error}");
}

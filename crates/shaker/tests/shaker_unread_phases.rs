//! Moduli alone: main terms and what is in phase with them have intervals that hold the truth, and the rest is within what is stated.

use super::shaker_free_phase::{FREQUENCIES, bench, budget};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_rig::bench::{Bench, BenchCampaign, published_plan};
use proofmass_shaker::matrix::to_real;
use proofmass_shaker::{
    Configuration, Fit, OutputPhases, PhasorRow, SpuriousTable, complex, diagnose, joint,
};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// A campaign of which the moduli of the outputs were read.
fn campaign(bench: &Bench, plan: &[(f64, f64)], seed: u64) -> (BenchCampaign, Vec<PhasorRow>) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let campaign = bench.campaign(plan, &FREQUENCIES, &mut rng);
    let rows = campaign.runs.iter().enumerate().map(|(i, r)| PhasorRow {
        phases: OutputPhases::Unread,
        ..PhasorRow::new(
            format!("r{i}"),
            r.frequency,
            Configuration::degrees(r.inclination_deg, r.rotation_deg),
            Complex64::new(r.reference.norm(), 0.0),
            r.outputs.map(|o| Complex64::new(o.norm(), 0.0)),
        )
    });
    let rows = rows.collect();
    (campaign, rows)
}

/// Whether the interval holds the truth, of every term in phase with the main term of its output and of every cross term out of phase, and χ².
fn hits(fit: &Fit, campaign: &BenchCampaign) -> (Vec<bool>, f64) {
    let mut inside = vec![];
    for (f, truth) in fit.frequencies.iter().zip(&campaign.truth) {
        let turned: [[Complex64; 3]; 3] = std::array::from_fn(|a| {
            std::array::from_fn(|j| truth[a][j] * truth[j][j].conj() / truth[j][j].norm())
        });
        let (here, there) = (to_real(&f.sensitivity), to_real(&turned));
        let c = f.estimate.covariance();
        for p in (0..18).filter(|p| ![1, 9, 17].contains(p)) {
            inside.push((here[p] - there[p]).abs() < 1.96 * c[(p, p)].sqrt());
        }
    }
    (inside, fit.chi_squared / fit.dof as f64)
}

#[test]
fn coverage_of_moduli() {
    let bench = bench();
    let budget = budget(&bench);
    for (step, trials) in [(1, 100u64), (3, 100)] {
        let plan: Vec<(f64, f64)> = published_plan().into_iter().step_by(step).collect();
        for of in [complex, joint] {
            let all: Vec<(Vec<bool>, f64)> = (0..trials)
                .into_par_iter()
                .map(|seed| {
                    let (campaign, rows) = campaign(&bench, &plan, 7_000 + seed);
                    hits(
                        &of(&rows, &SpuriousTable::default(), &budget).unwrap(),
                        &campaign,
                    )
                })
                .collect();
            let counts: Vec<usize> = (0..30)
                .map(|k| all.iter().filter(|h| h.0[k]).count())
                .collect();
            let fit = all.iter().map(|h| h.1).sum::<f64>() / trials as f64;
            println!("{counts:?}, χ²/ν = {fit:.3}");
            let share = |of: &[usize]| {
                let held: usize = of.iter().map(|k| counts[*k] + counts[k + 15]).sum();
                held as f64 / (2 * of.len()) as f64 / trials as f64
            };
            // xx, xy.re, xy.im, xz.re, xz.im, yx.re, yx.im, yy, …
            let in_phase = share(&[0, 1, 3, 5, 7, 8, 10, 12, 14]);
            let out_of_phase = share(&[2, 4, 6, 9, 11, 13]);
            println!("{in_phase} {out_of_phase}");
            // 1 800 intervals of which those of one campaign are not independent.
            assert!((0.93..=0.985).contains(&in_phase), "{in_phase}");
            assert!(out_of_phase >= 0.93, "{out_of_phase}");
            // ν is 3 per run less 9 per frequency, or what is told of them.
            assert!((fit - 1.0).abs() < 0.06, "{fit}");
        }
    }
}

#[test]
fn known_fault_among_moduli() {
    let bench = bench();
    let budget = budget(&bench);
    let (_, rows) = campaign(&bench, &published_plan(), 11);
    let none = SpuriousTable::default();
    let (suspects, findings) = diagnose(&rows, &none, &budget, None).unwrap();
    assert!(suspects.is_empty(), "{suspects:?} {findings:?}");
    let codes: Vec<&str> = findings.iter().map(|f| f.code()).collect();
    assert_eq!(codes, ["magnitudes-only"]);
    let mut wrong = rows.clone();
    wrong[60].outputs[2] *= 10.0;
    let (suspects, _) = diagnose(&wrong, &none, &budget, None).unwrap();
    let named: Vec<usize> = suspects.iter().map(|s| s.row).collect();
    assert_eq!(named, [60], "{suspects:?}");
}

#[test]
fn refuses_moduli_that_leave_a_cross_term_open() {
    // One axis at a time: of what an axis gives to the other outputs, the sense is unknown.
    let bench = bench();
    let plan = [(0.0, 0.0), (90.0, 0.0), (90.0, 90.0), (90.0, 180.0)];
    let (_, rows) = campaign(&bench, &plan, 5);
    let error = complex(&rows, &SpuriousTable::default(), &budget(&bench)).unwrap_err();
    assert!(
        matches!(error, Error::Unobservable { parameter, .. } if parameter.contains("phases were not read")),
        "{error}"
    );
}

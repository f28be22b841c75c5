//! Do the stated uncertainties hold the truth? Simulated campaigns with known sensitivities.

use proofmass_calibration::shaker::{
    Acts, Budget, Configuration, Fit, Input, Key, PhasorRow, Spurious, SpuriousTable, complex, joint,
    published,
};
use proofmass_rig::bench::{Bench, Campaign, Spread, Wedge, published_plan};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// χ²₂ at 95 %: the region of one complex term.
const REGION: f64 = 5.991;

/// The budget that describes the simulated bench.
fn budget(bench: &Bench) -> Budget {
    let r3 = 3f64.sqrt();
    Budget::new(vec![
        Input::new("reference.calibration", Acts::ReferenceModulus, bench.reference_modulus, &[Key::Frequency]),
        Input::new("reference.phase", Acts::ReferencePhase, bench.reference_phase, &[Key::Frequency]),
        Input::new("wedge.angle", Acts::Inclination, bench.wedge_angle / r3, &[Key::Inclination]),
        Input::new("gluing.angle", Acts::Rotation, bench.gluing_angle / r3, &[Key::Inclination, Key::Rotation]),
        Input::new("conditioner.gain", Acts::OutputModulus, bench.gain / r3, &[Key::Channel]),
        Input::new("reading", Acts::OutputModulus, bench.reading, &[Key::Run, Key::Channel]),
        Input::new("reading.phase", Acts::OutputPhase, bench.reading_phase, &[Key::Run, Key::Channel]),
        Input::new("noise", Acts::OutputAdditive, bench.floor, &[Key::Run, Key::Channel]),
    ])
    .unwrap()
}

fn rows(campaign: &Campaign) -> Vec<PhasorRow> {
    campaign
        .runs
        .iter()
        .map(|r| {
            PhasorRow::new(
                format!("{} Hz, {}°, {}°", r.frequency, r.inclination_deg, r.rotation_deg),
                r.frequency,
                Configuration::degrees(r.inclination_deg, r.rotation_deg),
                r.reference,
                r.outputs,
            )
        })
        .collect()
}

fn spurious(campaign: &Campaign) -> SpuriousTable {
    SpuriousTable {
        entries: campaign
            .spurious
            .iter()
            .map(|s| {
                let v = s.standard_uncertainty.powi(2);
                Spurious {
                    inclination: s.inclination_deg.to_radians(),
                    frequency: s.frequency,
                    ratio: s.ratio,
                    covariance: [[v, 0.0, v]; 3],
                }
            })
            .collect(),
    }
}

/// For every frequency and term, whether the 95 % region holds the truth.
fn hits(fit: &Fit, campaign: &Campaign) -> Vec<bool> {
    let mut hits = vec![];
    for (f, truth) in fit.frequencies.iter().zip(&campaign.truth) {
        for k in 0..9 {
            let e = f.sensitivity[k / 3][k % 3] - truth[k / 3][k % 3];
            let c = f.estimate.covariance();
            let (rr, ri, ii) = (c[(2 * k, 2 * k)], c[(2 * k, 2 * k + 1)], c[(2 * k + 1, 2 * k + 1)]);
            let q = (e.re * e.re * ii - 2.0 * e.re * e.im * ri + e.im * e.im * rr) / (rr * ii - ri * ri);
            hits.push(q < REGION);
        }
    }
    hits
}

fn count(
    bench: &Bench,
    frequencies: &[f64],
    trials: u64,
    fit: impl Fn(&[PhasorRow], &SpuriousTable) -> Fit + Sync,
) -> Vec<usize> {
    let plan = published_plan();
    let all: Vec<Vec<bool>> = (0..trials)
        .into_par_iter()
        .map(|seed| {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(7_000 + seed);
            let campaign = bench.campaign(&plan, frequencies, &mut rng);
            hits(&fit(&rows(&campaign), &spurious(&campaign)), &campaign)
        })
        .collect();
    (0..all[0].len())
        .map(|k| all.iter().filter(|h| h[k]).count())
        .collect()
}

/// 95 % of n trials: n p ± 4 √(n p q). Two-sided 6e-5 per term, so a test of 100 terms fails by chance in 0.6 %
/// of seeds; the seeds are fixed.
fn bound(trials: u64) -> std::ops::RangeInclusive<usize> {
    let n = trials as f64;
    let half = 4.0 * (n * 0.95 * 0.05).sqrt();
    (0.95 * n - half).floor() as usize..=((0.95 * n + half).ceil() as usize).min(trials as usize)
}

fn bench(wedge: bool) -> Bench {
    Bench {
        wedge: wedge.then(Wedge::default),
        spread: Spread::Normal,
        ..Bench::default()
    }
}

#[test]
fn coverage_complex_without_and_with_spurious_motion() {
    for wedge in [false, true] {
        let bench = bench(wedge);
        let budget = budget(&bench);
        let counts = count(&bench, &[10.0, 1000.0], 1000, |rows, spurious| {
            complex(rows, spurious, &budget).unwrap()
        });
        println!("spurious motion {wedge}: {counts:?}");
        assert!(counts.iter().all(|c| bound(1000).contains(c)), "{counts:?}");
    }
}

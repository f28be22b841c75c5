//! What a plan predicts is what campaigns by that plan achieve, with the spurious motion among the causes.
//!
//! The campaigns are those of the simulated bench, which shares no formula with the prediction.

use proofmass_rig::bench::{Bench, BenchCampaign, BenchWedge, Spread, published_plan};
use proofmass_shaker::plan::{Expected, best, predict};
use proofmass_shaker::{
    Acts, Budget, Configuration, Key, PhasorRow, ShakerInput, Spurious, SpuriousTable, complex,
};
use proofmass_uncertainty::DegreesOfFreedom;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

const FREQUENCY: f64 = 160.0;
const CAMPAIGNS: u64 = 400;
/// Relative standard deviation of a standard deviation from so many campaigns.
const KNOWN: f64 = 0.0354;

fn bench() -> Bench {
    Bench {
        wedge: Some(BenchWedge::default()),
        // As large as it matters: half of u of the cross terms.
        spurious_reading: 0.004,
        spread: Spread::Normal,
        ..Bench::default()
    }
}

fn budget(bench: &Bench) -> Budget {
    let r3 = 3f64.sqrt();
    let gluing = [Key::Inclination, Key::Rotation];
    let reading = [Key::Run, Key::Channel];
    let input = ShakerInput::new;
    Budget::new(vec![
        input(
            "reference.calibration",
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
            "wedge.angle",
            Acts::Inclination,
            bench.wedge_angle / r3,
            &[Key::Inclination],
        ),
        input(
            "gluing.angle",
            Acts::Rotation,
            bench.gluing_angle / r3,
            &gluing,
        ),
        input(
            "conditioner.gain",
            Acts::OutputModulus,
            bench.gain / r3,
            &[Key::Channel],
        ),
        input("reading", Acts::OutputModulus, bench.reading, &reading),
        input(
            "reading.phase",
            Acts::OutputPhase,
            bench.reading_phase,
            &reading,
        ),
        input("noise", Acts::OutputAdditive, bench.floor, &reading),
    ])
    .unwrap()
}

fn spurious(campaign: &BenchCampaign) -> SpuriousTable {
    let entries = campaign.spurious.iter().map(|s| {
        let v = s.standard_uncertainty.powi(2);
        Spurious {
            basis: Default::default(),
            inclination: s.inclination_deg.to_radians(),
            frequency: s.frequency,
            ratio: s.ratio,
            covariance: [[v, 0.0, v]; 3],
            dof: DegreesOfFreedom::INFINITE,
        }
    });
    SpuriousTable::new(entries.collect())
}

fn rows(campaign: &BenchCampaign) -> Vec<PhasorRow> {
    let runs = campaign.runs.iter();
    runs.map(|r| {
        let seat = Configuration::degrees(r.inclination_deg, r.rotation_deg);
        PhasorRow::new("run", r.frequency, seat, r.reference, r.outputs)
    })
    .collect()
}

#[test]
fn law_a_plan_predicts_what_its_campaigns_achieve() {
    let bench = bench();
    let budget = budget(&bench);
    let all = published_plan();
    let candidates: Vec<Configuration> = all
        .iter()
        .map(|&(a, w)| Configuration::degrees(a, w))
        .collect();
    let chosen = |count| -> Vec<(f64, f64)> {
        let list = best(&candidates, count).unwrap();
        list.into_iter().map(|k| all[k]).collect()
    };
    let axes = vec![(0.0, 0.0), (90.0, 0.0), (90.0, 270.0)];
    for plan in [axes, chosen(6), chosen(12)] {
        let configurations: Vec<Configuration> = plan
            .iter()
            .map(|&(a, w)| Configuration::degrees(a, w))
            .collect();
        // The table of the spurious motion as it will be known: without the noise of its measurement.
        let mut quiet = Bench {
            spurious_reading: 0.0,
            ..bench.clone()
        }
        .campaign(
            &plan,
            &[FREQUENCY],
            &mut Xoshiro256PlusPlus::seed_from_u64(1),
        );
        for s in &mut quiet.spurious {
            s.standard_uncertainty = bench.spurious_reading;
        }
        let table = spurious(&quiet);
        let truth = quiet.truth[0];
        let with = |spurious: &SpuriousTable| {
            let expected = Expected {
                budget: &budget,
                spurious,
                sensitivity: &truth,
                amplitude: 10.0,
                frequency: FREQUENCY,
                sessions: &[],
            };
            predict(&configurations, &expected).unwrap()
        };
        let predicted = with(&table);
        // The spurious motion is in it: without its uncertainty a cross term would look better by a tenth and more.
        let mut known = table.clone();
        for e in &mut known.entries {
            e.covariance = [[0.0; 3]; 3];
        }
        let without = with(&known);
        let gain = |k: usize| predicted[k].relative_imaginary / without[k].relative_imaginary;
        assert!(
            (0..9).any(|k| gain(k) > 1.1),
            "{} configurations",
            plan.len()
        );
        let main = (0..3).map(|i| truth[i][i].norm()).sum::<f64>() / 3.0;
        let errors: Vec<[f64; 18]> = (0..CAMPAIGNS)
            .into_par_iter()
            .map(|seed| {
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(23_000 + seed);
                let campaign = bench.campaign(&plan, &[FREQUENCY], &mut rng);
                let fit = complex(&rows(&campaign), &spurious(&campaign), &budget).unwrap();
                let s = fit.frequencies[0].sensitivity;
                std::array::from_fn(|p| {
                    let e = s[p / 6][p / 2 % 3] - truth[p / 6][p / 2 % 3];
                    [e.re, e.im][p % 2] / main
                })
            })
            .collect();
        let mut ratios = vec![];
        for p in 0..18 {
            let square: f64 = errors.iter().map(|e| e[p] * e[p]).sum();
            let due = [
                predicted[p / 2].relative_real,
                predicted[p / 2].relative_imaginary,
            ][p % 2];
            ratios.push((square / CAMPAIGNS as f64).sqrt() / due);
        }
        let mean = ratios.iter().sum::<f64>() / 18.0;
        println!(
            "{} configurations: mean ratio {mean:.3}, {ratios:.3?}",
            plan.len()
        );
        // Of 54 ratios four and a half standard deviations; components of one campaign are correlated, so the mean may be
        // off as far as half of one of them.
        for (p, ratio) in ratios.iter().enumerate() {
            assert!(
                (ratio - 1.0).abs() < 4.5 * KNOWN,
                "{} configurations, component {p}: {ratio}",
                plan.len()
            );
        }
        assert!(
            (mean - 1.0).abs() < 2.0 * KNOWN,
            "{} configurations: {mean}",
            plan.len()
        );
    }
}

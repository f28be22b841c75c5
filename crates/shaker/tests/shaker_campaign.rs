//! From samples to matrices, as a laboratory would run it.

use crate::budgets;
use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
use proofmass_rig::bench::{Bench, BenchWedge, published_plan, waveform::Acquisition};
use proofmass_shaker::datasheet::Datasheet;
use proofmass_shaker::recording::{PhasorReading, RunInput};
use proofmass_shaker::{
    Budget, Configuration, Correction, ShakerCampaign, ShakerMethod, Spurious, SpuriousTable,
    UnmeasuredMotion, calibrate,
};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

const REFERENCE: f64 = 9.9e-3;

fn budget() -> Budget {
    let mut budget = Budget::published_bench();
    budget.inputs.retain(|i| i.key != "reference.calibration");
    budget.inputs.push(budgets::noise());
    budget
}

fn certificate(from: f64) -> ReferenceTable {
    ReferenceTable::new(
        [from, 160.0, 2000.0]
            .map(|frequency| ReferencePoint {
                frequency,
                sensitivity: REFERENCE,
                phase: 0.0,
                modulus_uncertainty: 0.002,
                phase_uncertainty: 0.003,
            })
            .to_vec(),
    )
    .unwrap()
}

/// Samples of 0.2 s per run, read by sine approximation.
fn recorded(frequencies: &[f64]) -> (ShakerCampaign, proofmass_rig::bench::BenchCampaign) {
    let bench = Bench {
        wedge: Some(BenchWedge::default()),
        ..Bench::default()
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
    let campaign = bench.campaign(&published_plan(), frequencies, &mut rng);
    let daq = Acquisition {
        duration: 0.2,
        ..Acquisition::default()
    };
    let mut reading = PhasorReading::new(daq.sampling_frequency);
    reading.full_scale = Some(daq.full_scale);
    let runs: Vec<RunInput> = campaign
        .runs
        .iter()
        .enumerate()
        .map(|(i, r)| {
            // The generator runs 20 ppm off the clock of the acquisition.
            let f = r.frequency * (1.0 + 2e-5);
            let x = [
                r.reference * REFERENCE,
                r.outputs[0],
                r.outputs[1],
                r.outputs[2],
            ]
            .map(|p| daq.channel(&[p, p * 0.01, p * 0.003], f, &mut rng));
            let c = Configuration::degrees(r.inclination_deg, r.rotation_deg);
            reading
                .observe(
                    &format!("run-{:03}", i + 1),
                    r.frequency,
                    c,
                    [&x[0], &x[1], &x[2], &x[3]],
                )
                .unwrap()
        })
        .collect();
    let mut shaker = ShakerCampaign::new(runs, budget());
    shaker.reference = Some(certificate(10.0));
    shaker.methods = vec![
        ShakerMethod::PublishedMagnitude,
        ShakerMethod::Complex,
        ShakerMethod::Joint,
    ];
    shaker.targets = frequencies.iter().map(|&f| (f, 10.0)).collect();
    shaker.datasheet = Some(Datasheet::of(10.2e-3, Some(0.2e-3)));
    let entries = campaign
        .spurious
        .iter()
        .map(|s| Spurious {
            basis: Default::default(),
            inclination: s.inclination_deg.to_radians(),
            dof: proofmass_uncertainty::DegreesOfFreedom::INFINITE,
            frequency: s.frequency,
            ratio: s.ratio,
            covariance: [[
                s.standard_uncertainty.powi(2),
                0.0,
                s.standard_uncertainty.powi(2),
            ]; 3],
        })
        .collect();
    shaker.corrections = vec![
        Correction {
            label: "measured".into(),
            table: SpuriousTable::new(entries),
        },
        Correction {
            label: "none".into(),
            table: SpuriousTable::default(),
        },
    ];
    (shaker, campaign)
}

/// A bench that moves beside the excitation, and nobody measured how: it is an unknown, and no run is accused of it.
#[test]
fn law_motion_that_nobody_measured_is_said_and_accuses_no_run() {
    let (mut shaker, _) = recorded(&[160.0]);
    shaker.corrections.clear();
    shaker.methods = vec![ShakerMethod::Joint];
    let said = |shaker: &ShakerCampaign| {
        let result = calibrate(shaker).unwrap();
        assert!(result.suspects.is_empty());
        let codes: Vec<&str> = result.findings.iter().map(|f| f.code()).collect();
        let [motion] = result.results[0].motion[..] else {
            panic!("one frequency");
        };
        let u = result.results[0].frequencies[0].sensitivity[0]
            .modulus
            .expanded;
        (codes.join(" "), motion.across.unwrap(), u)
    };
    let (codes, found, u) = said(&shaker);
    assert!(codes.contains("motion-not-measured"), "{codes}");
    // The bench moves by 1 % along x′ and 0.6 % along y′, and its wedges add to it.
    assert!((0.002..0.03).contains(&found), "{found}");
    // What is stated is a floor.
    let stated = |across: f64, along: f64| Some(UnmeasuredMotion { across, along });
    shaker.unmeasured_motion = stated(0.05, 0.01);
    let (codes, taken, wider) = said(&shaker);
    assert!(codes.contains("motion-declared"), "{codes}");
    assert!(
        taken > 0.99 * 0.05 && wider > u,
        "{taken}, {wider} beside {u}"
    );
    // Half of nothing and more than all are no ratios.
    for (across, along) in [(-0.01, 0.0), (0.0, 1.0), (f64::NAN, 0.0)] {
        shaker.unmeasured_motion = stated(across, along);
        assert!(calibrate(&shaker).is_err());
    }
}

#[test]
fn law_samples_become_matrices_that_hold_the_truth() {
    let (shaker, truth) = recorded(&[80.0, 160.0, 1000.0]);
    let result = calibrate(&shaker).unwrap();
    for f in &result.findings {
        println!("{f}");
    }
    assert!(result.suspects.is_empty());
    assert_eq!(result.results.len(), 6);
    for method in result
        .results
        .iter()
        .filter(|r| r.method != ShakerMethod::PublishedMagnitude)
    {
        let misses: usize = method
            .frequencies
            .iter()
            .zip(&truth.truth)
            .map(|(f, t)| {
                (0..9)
                    .filter(|&k| {
                        let m = &f.sensitivity[k].modulus;
                        (m.value - t[k / 3][k % 3].norm()).abs() > 1.5 * m.expanded
                    })
                    .count()
            })
            .sum();
        println!(
            "{:?} {}: {misses} of 27 moduli beyond 1.5 U, χ² {:?}, {} findings",
            method.method,
            method.correction,
            method.chi_squared,
            method.findings.len()
        );
        // 1.5 U is three standard uncertainties: 0.3 % of 27 terms.
        if method.correction == "measured" {
            assert!(misses <= 1);
        }
    }
    let f = &result.results[2].frequencies[0];
    assert_eq!(
        (f.sensitivity.len(), f.transverse.len(), f.intrinsic.len()),
        (9, 6, 6)
    );
    let json = serde_json::to_value(&result).unwrap();
    assert!(json["results"][2]["frequencies"][0]["sensitivity"][0]["modulus"]["value"].is_number());
}

#[test]
fn refuses_clipped_runs_and_a_wrong_frequency_and_a_short_certificate() {
    let (mut shaker, _) = recorded(&[80.0, 160.0]);
    // A certificate from 100 Hz on does not reach 80 Hz.
    shaker.reference = Some(certificate(100.0));
    shaker.methods = vec![ShakerMethod::Complex];
    shaker.corrections.truncate(1);
    let daq = Acquisition {
        duration: 0.2,
        ..Acquisition::default()
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(12);
    let mut reading = PhasorReading::new(daq.sampling_frequency);
    reading.full_scale = Some(10.0);
    // Run 50 at 160 Hz: overdriven. Run 60: recorded at 315 Hz.
    let again = |k: usize, gain: f64, f: f64, rng: &mut Xoshiro256PlusPlus| {
        let r = shaker.runs[k].clone();
        let x = [r.reference, r.outputs[0], r.outputs[1], r.outputs[2]]
            .map(|p| daq.channel(&[p * gain, p * (0.01 * gain)], f, rng));
        reading
            .observe(
                &r.run,
                r.frequency,
                r.configuration,
                [&x[0], &x[1], &x[2], &x[3]],
            )
            .unwrap()
    };
    let clipped = again(49, 250.0, 160.0, &mut rng);
    let wrong = again(59, 1.0, 315.0, &mut rng);
    shaker.runs[49] = clipped;
    shaker.runs[59] = wrong;
    let result = calibrate(&shaker).unwrap();
    let found = |code: &str| {
        result
            .findings
            .iter()
            .find(|f| f.code() == code)
            .unwrap_or_else(|| panic!("{code} is missing: {:?}", result.findings))
            .to_string()
    };
    assert!(found("clipped").contains("run-050"));
    assert!(
        found("frequency-mismatch").contains("run-060")
            && found("frequency-mismatch").contains("315")
    );
    assert!(found("reference-out-of-range").contains("80 Hz"));
    assert_eq!(result.results[0].frequencies.len(), 1);
}

//! The tables of docs/shaker.md, cut down: coverage with a complete mounting, and faults that are named.
//!
//! Counts are binomial. The components of one campaign are correlated, so a mean over several is held to the bound of one
//! alone; 4.5 standard deviations leave less than 1 in 1000 for all bounds of this file together.

use proofmass_uncertainty::Severity;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

#[path = "../examples/shaker_faults.rs"]
#[allow(dead_code, reason = "its printed table")]
mod shaker_faults;

use shaker_faults::shaker_coverage::{self, CASES, Case};
use shaker_faults::{FAULTS, Fault, Verdict};

const CAMPAIGNS: usize = 60;

/// Least share that is 95 % within chance.
fn least(p: f64, n: usize) -> f64 {
    p - 4.5 * (p * (1.0 - p) / n as f64).sqrt()
}

fn case(name: &str) -> Case {
    let of = |c: &&Case| c.name == name;
    *CASES.iter().find(of).expect("a case of the table")
}

#[test]
fn coverage_map_of_the_mounting() {
    let all: Vec<usize> = (0..18).collect();
    for name in [
        "tilt ±0.1°",
        "tilt ±0.3°",
        "lean ±0.3° of wedges",
        "mask ±1°",
        "spurious, 2 × 0.004",
        "spurious, 2 × 0.004, u of each",
        "spurious, 3 × 0.004, u of each",
        "cross terms zero",
    ] {
        let cell = case(name).cell(&[160.0], CAMPAIGNS);
        println!("{name}: {:.3} {:?}", cell.mean(&all), cell.components);
        assert!(cell.mean(&all) > least(0.95, CAMPAIGNS), "{name}");
        for (p, share) in cell.components.iter().enumerate() {
            assert!(
                *share > least(0.95, CAMPAIGNS),
                "{name}: component {p}: {share}"
            );
        }
        for share in &cell.sizes {
            assert!(*share > least(0.95, CAMPAIGNS), "{name}: {:?}", cell.sizes);
        }
        // 0.3 % of campaigns are told of an input that they do not lack: two of sixty are one cell in seventy.
        assert!(
            1.5 > cell.said[0] * CAMPAIGNS as f64,
            "{name}: an input is missed that is declared"
        );
        // One campaign in a thousand has an accused run.
        assert_eq!(cell.said[2], 0.0, "{name}: a sound run is accused");
    }
}

#[test]
fn coverage_map_of_motion_that_nobody_measured() {
    const CAMPAIGNS: usize = 24;
    let all: Vec<usize> = (0..18).collect();
    for name in [
        "unmeasured motion 0",
        "unmeasured motion 2 %",
        "half measured, motion 1 %",
        "12 gluings, unmeasured motion 1 %",
    ] {
        let cell = case(name).cell(&[10.0, 160.0], CAMPAIGNS);
        println!("{name}: {:.3} {:?}", cell.mean(&all), cell.components);
        assert!(cell.mean(&all) > least(0.95, CAMPAIGNS), "{name}");
        for (p, share) in cell.components.iter().enumerate() {
            assert!(*share > least(0.95, CAMPAIGNS), "{name}, {p}: {share}");
        }
        assert_eq!(cell.said[2], 0.0, "{name}: a sound run is accused");
    }
}

#[test]
fn coverage_map_of_tilts_that_nobody_or_too_little_declared() {
    // Three frequencies: the runs see a tilt of ±0.1° in every campaign.
    let frequencies = [10.0, 160.0, 1000.0];
    let undeclared = case("tilt ±0.1° undeclared").cell(&frequencies, 20);
    assert_eq!(undeclared.said[0], 1.0, "a missing tilt is told");
    assert!(undeclared.mean(&[4, 10, 12, 14]) < 0.85, "and it matters");
    let small = case("tilt ±0.3° declared ±0.1°").cell(&frequencies, 40);
    println!("{small:?}");
    assert_eq!(small.said[1], 1.0, "a tilt declared too small is told");
    assert!(small.mean(&[4, 10, 12, 14]) > least(0.95, 40));
}

#[test]
fn coverage_map_of_readings_and_gluings_beyond_the_budget() {
    let frequencies = [10.0, 160.0, 1000.0];
    let all: Vec<usize> = (0..18).collect();
    for name in [
        "12 gluings, readings × 1, gluing × 1",
        "12 gluings, readings × 2, gluing × 1",
        "12 gluings, readings × 1, gluing × 4",
        "6 gluings, readings × 1, gluing × 2",
        "6 gluings, readings × 1, gluing × 4",
    ] {
        let cell = case(name).cell(&frequencies, CAMPAIGNS);
        println!("{name}: {:.3} {:?}", cell.mean(&all), cell.components);
        for (p, share) in cell.components.iter().enumerate() {
            assert!(*share > least(0.95, CAMPAIGNS), "{name}, {p}: {share}");
        }
        // Noisier readings are no missing tilt.
        assert_eq!(cell.said[0], 0.0, "{name}");
    }
}

/// Estimates of the variances are without bias, and scatter as their degrees of freedom say.
#[test]
fn law_the_runs_find_the_variances_of_readings_and_gluings() {
    use proofmass_shaker::joint;
    let usual = case("12 gluings, readings × 2, gluing × 1");
    for (readings, gluing) in [(1.0, 1.0), (2.0, 1.0), (1.0, 3.0)] {
        let case = Case {
            beyond: [readings, gluing],
            ..usual
        };
        let budget = case.budget();
        let fits = (0..CAMPAIGNS as u64).map(|seed| {
            let simulated = case.campaign(&[10.0, 160.0, 1000.0], 120_000 + seed);
            joint(&simulated.rows, &simulated.spurious, &budget).expect("a fit")
        });
        let components: Vec<_> = fits.flat_map(|f| f.components).collect();
        // The variance of a rectangular error varies less than that of a normal one, for which the freedom is stated.
        for (key, truth) in [("readings", readings), ("gluing.angle", gluing)] {
            let of_key: Vec<_> = components.iter().filter(|c| c.key == key).collect();
            let n = of_key.len() as f64;
            let mean = of_key.iter().map(|c| c.estimated.powi(2)).sum::<f64>() / n;
            let stated = of_key
                .iter()
                .map(|c| 2.0 / c.freedom * c.estimated.powi(4))
                .sum::<f64>()
                / n;
            let found = of_key
                .iter()
                .map(|c| (c.estimated.powi(2) - truth * truth).powi(2))
                .sum::<f64>()
                / n;
            println!(
                "{key} × {truth}: mean {:.3}, scatter {:.3} of {:.3}",
                mean / (truth * truth),
                found.sqrt() / (truth * truth),
                stated.sqrt() / (truth * truth)
            );
            assert!(
                (mean - truth * truth).abs() < 4.5 * (stated / n).sqrt(),
                "{key}: {mean} for {truth}²"
            );
            assert!(found < 1.7 * stated, "{key}: {found} {stated}");
        }
    }
}

/// Who knows his gluings from thirty others says so, and the runs add to it; a certificate is told by no run, with whatever
/// degrees of freedom it comes.
#[test]
fn known_a_declaration_with_degrees_of_freedom_counts_as_observations() {
    use proofmass_shaker::joint;
    use proofmass_uncertainty::DegreesOfFreedom;
    let usual = case("12 gluings, readings × 1, gluing × 1");
    let simulated = usual.campaign(&[10.0, 160.0, 1000.0], 1);
    let freedom = |key: &str, nu: f64| {
        let mut budget = usual.budget();
        for input in budget.inputs.iter_mut().filter(|i| i.key == key) {
            input.dof = DegreesOfFreedom::new(nu).expect("positive");
        }
        let fit = joint(&simulated.rows, &simulated.spurious, &budget).expect("a fit");
        let mut components = fit.components.into_iter();
        components.find(|c| c.key == key)
    };
    let by_runs = freedom("gluing.angle", f64::INFINITY).expect("told by the runs");
    let with_others = freedom("gluing.angle", 29.0).expect("told by the runs");
    assert!(
        by_runs.freedom > 5.0 && by_runs.freedom < 12.0,
        "{by_runs:?}"
    );
    let added = with_others.freedom - 29.0;
    assert!(added > 5.0 && added < 12.0, "{with_others:?}");
    assert!(with_others.dof.get() <= with_others.freedom);
    assert_eq!(freedom("reference.calibration", 30.0), None);
    assert_eq!(freedom("conditioner.gain", 30.0), None);
}

#[test]
fn law_a_fault_of_one_run_is_named_first_and_no_other_run_is() {
    for (k, fault) in FAULTS.iter().enumerate() {
        for position in [5, 20, 38] {
            let (verdict, others) = shaker_faults::single(*fault, position, 70_100 + k as u64);
            // Along one axis a swapped reference is a gain of another size.
            let along = *fault == Fault::ReferenceSwapped && verdict == Verdict::SecondOfTwo;
            assert!(
                along || matches!(verdict, Verdict::Alone | Verdict::FirstOfTwo),
                "{fault:?} at {position}: {verdict:?}"
            );
            assert_eq!(others, 0, "{fault:?} at {position}");
        }
    }
}

#[test]
fn law_sound_campaigns_are_told_nothing() {
    for seed in 0..12 {
        let codes = shaker_faults::sound(100_100 + seed);
        assert!(codes.is_empty(), "{seed}: {codes:?}");
    }
}

/// A vibrometer that is wrong by half a per cent makes every sensitivity wrong by that: U has it where its certificate is stated, and not
/// where it is not. Beside the same reference, which was read as wrong in both, the error of the reference goes out.
#[test]
fn coverage_behind_a_vibrometer_with_a_certificate() {
    use proofmass_shaker::{CommonCauses, Correction, ShakerCampaign, calibrate};
    const U: f64 = 0.005;
    let usual = Case {
        repeats: Some((10, 2e-4)),
        ..CASES[0]
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(17);
    let (campaigns, mut held) = (60, [0; 3]);
    for seed in 0..campaigns {
        let simulated = usual.campaign(&[160.0], 77_000 + seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let (vibrometer, reference) = (U * normal(), 2.0 * U * normal());
        let covered = |stated: bool, wrong: f64, same_reference: bool| {
            let mut rows = simulated.rows.clone();
            rows.iter_mut().for_each(|r| r.reference *= 1.0 + wrong);
            let mut table = simulated.spurious.clone();
            for entry in &mut table.entries {
                for (axis, z) in entry.ratio.iter_mut().enumerate() {
                    let whole = f64::from(axis == 2);
                    *z = (*z + whole) * ((1.0 + vibrometer) / (1.0 + wrong)) - whole;
                }
            }
            if stated {
                table.common.same_reference = same_reference;
                table.common.at = vec![CommonCauses {
                    frequency: 160.0,
                    vibrometer: [U, 0.0],
                    reference: [2.0 * U, 0.0],
                }];
                if !same_reference {
                    table.common.at[0].reference = [0.0; 2];
                }
            }
            let mut campaign = ShakerCampaign::new(shaker_faults::runs(&rows), usual.budget());
            campaign.methods = vec![proofmass_shaker::ShakerMethod::Joint];
            campaign.corrections = vec![Correction {
                label: "measured".to_owned(),
                table,
            }];
            let result = calibrate(&campaign).expect("a calibration");
            let zz = &result.results[0].frequencies[0].estimate.quantities()[16];
            (zz.value - simulated.truth[0][2][2].re).abs() <= zz.expanded(0.95)
        };
        held[0] += i32::from(covered(true, 0.0, false));
        held[1] += i32::from(covered(true, reference, true));
        held[2] += i32::from(covered(false, 0.0, false));
    }
    // Of 60 at 95 %, fewer than 51 come once in a thousand times.
    assert!(held[0] >= 51 && held[1] >= 51, "{held:?}");
    assert!(held[2] < 45, "{held:?}");
}

/// While it is not decided about a run, its frequency reaches the result with it and the others are as without the fault.
#[test]
fn law_a_run_in_question_widens_its_own_frequency_alone() {
    use proofmass_shaker::{Correction, ShakerCampaign, calibrate};
    let usual = Case {
        repeats: Some((10, 2e-4)),
        ..CASES[0]
    };
    let mut simulated = usual.campaign(&[10.0, 160.0, 1000.0], 4242);
    let calibration = |simulated: &shaker_coverage::Simulated| {
        let mut campaign =
            ShakerCampaign::new(shaker_faults::runs(&simulated.rows), usual.budget());
        campaign.corrections = vec![Correction {
            label: "measured".to_owned(),
            table: simulated.spurious.clone(),
        }];
        calibrate(&campaign).expect("a calibration")
    };
    let sound = calibration(&simulated);
    assert!(sound.contested.is_empty() && sound.set_aside.is_empty());
    simulated.rows[44 + 20].outputs.swap(0, 1);
    let struck = calibration(&simulated);
    assert_eq!(struck.set_aside.len(), 1);
    assert!(
        struck
            .findings
            .iter()
            .any(|f| f.code() == "runs-set-aside" && f.severity() == Severity::Decision)
    );
    let contested = &struck.contested[0];
    assert_eq!(contested.frequency, 160.0);
    let with = contested.with.as_ref().expect("reconciled");
    for (a, b) in sound.results.iter().zip(&struck.results) {
        for (f, (a, b)) in a.frequencies.iter().zip(&b.frequencies).enumerate() {
            for (k, (a, b)) in a
                .estimate
                .quantities()
                .iter()
                .zip(&b.estimate.quantities())
                .enumerate()
            {
                let ratio = b.standard_uncertainty / a.standard_uncertainty;
                if f != 1 {
                    assert!((ratio - 1.0).abs() < 0.1, "{f} {k}: {ratio}");
                } else {
                    let part = with[k / 2][k % 2];
                    assert!(
                        (b.value - part).abs() <= b.expanded(0.95),
                        "{k}: {b} {part}"
                    );
                }
                // Without the run the result is that of a sound campaign within its uncertainty.
                assert!(
                    (a.value - b.value).abs() < 2.0 * a.standard_uncertainty,
                    "{f} {k}"
                );
            }
        }
    }
}

/// What no run can tell keeps its declared uncertainty, and is told so.
#[test]
fn known_what_the_runs_tell_of_the_mounting() {
    use proofmass_shaker::joint;
    let tilted = case("tilt and mean tilt ±0.1°");
    let simulated = tilted.campaign(&[10.0, 160.0, 1000.0], 1);
    let fit = joint(&simulated.rows, &simulated.spurious, &tilted.budget()).expect("a fit");
    let known = fit.identifiability.expect("angles");
    // 6 wedges, 44 gluings with their turn and two tilts each, two mean tilts.
    assert_eq!(known.count(), 6 + 44 + 88 + 2);
    assert_eq!(known.directions.iter().sum::<usize>(), known.count());
    // Three turns of the frame, 44 turns of a device about the excitation and more tell nothing at all.
    assert!(known.directions[4] >= 47, "{:?}", known.directions);
    let mean = known
        .inputs
        .iter()
        .find(|i| i.key == "device.tilt.mean")
        .expect("declared");
    assert!(
        mean.freedom < 0.02 && mean.after > 0.99 * mean.declared,
        "{mean:?}"
    );
    let declared = 0.1f64.to_radians() / 3f64.sqrt();
    for turn in known.turns.iter().filter(|t| t.about != "z") {
        assert!(
            turn.turn > declared && turn.turn < 1.1 * declared,
            "{turn:?}"
        );
        assert!(turn.right_angle < 0.5 * declared, "{turn:?}");
    }
}

/// The cable of the reference on an output: the finding shows what the run says with the cables exchanged.
#[test]
fn known_a_swapped_reference_is_shown_corrected() {
    use proofmass_shaker::diagnosis::strangest;
    use proofmass_shaker::{Complex64, diagnose};
    let usual = Case {
        repeats: Some((10, 2e-4)),
        ..CASES[0]
    };
    let mut simulated = usual.campaign(&[160.0], 4243);
    for row in &mut simulated.rows {
        row.reference_sensitivity = Some(Complex64::new(0.01, 0.0));
    }
    let index = 20;
    let output = simulated.rows[index].outputs[0].norm();
    shaker_faults::Fault::ReferenceSwapped.strike(&mut simulated.rows, index);
    let name = simulated.rows[index].run.clone();
    let (suspects, findings) =
        diagnose(&simulated.rows, &simulated.spurious, &usual.budget(), None).expect("a diagnosis");
    assert_eq!(suspects.len(), 1);
    let finding = findings
        .iter()
        .find(|f| f.code() == "swapped-channels")
        .expect("named");
    let evidence = finding.evidence_text();
    let after = |words: &str| -> f64 {
        let (_, rest) = evidence.split_once(words).expect(evidence);
        let number = rest.split(' ').next().expect("a number");
        number.parse().expect("a number")
    };
    // 10 m/s² with the error of the certificate.
    assert!(
        (after("the table moves by ") / 10.0 - 1.0).abs() < 0.02,
        "{evidence}"
    );
    assert!(
        (after("outputs are x ") / (1e3 * output) - 1.0).abs() < 1e-4,
        "{evidence}"
    );
    // What an adjustment stumbles over is told without one.
    let strange = strangest(&simulated.rows, &simulated.spurious, &usual.budget());
    assert_eq!(strange.first(), Some(&(name, 160.0)), "{strange:?}");
}

//! Jobs on the shaker from memory alone: stopped by who watches, written, read again and rendered to the same bytes.

use num_complex::Complex64;
use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
use proofmass_jobs::plan::PlanJob;
use proofmass_jobs::shaker_single::{ShakerSingleData, ShakerSingleJob, ShakerSingleRun};
use proofmass_jobs::shaker_triaxial::{ShakerTriaxialData, ShakerTriaxialJob};
use proofmass_jobs::spurious_motion::{SpuriousMotionData, SpuriousMotionJob, SpuriousRun};
use proofmass_jobs::{Job, Outcome, Record, StoredResult, TroubleKind, Unwatched, Watch};
use proofmass_shaker::geometry::published_plan;
use proofmass_shaker::recording::{Quality, RunInput};
use proofmass_shaker::single_axis::{ComparisonBudget, ComparisonRow};
use proofmass_shaker::{
    Acts, Budget, Correction, Key, ShakerInput, ShakerMethod, Spurious, SpuriousTable,
};
use proofmass_uncertainty::DegreesOfFreedom;
use std::ops::ControlFlow;

struct Impatient;

impl Watch for Impatient {
    fn progress(&self, _: &'static str, _: u64, _: u64) -> ControlFlow<()> {
        ControlFlow::Break(())
    }
}

/// The outcome again, after a check of everything that must hold for one of any kind.
fn check<J: Job + PartialEq + std::fmt::Debug>(job: &J, data: &J::Data<'_>) -> J::Outcome
where
    J::Outcome: std::fmt::Debug,
{
    let stopped = job.evaluate(data, &Impatient).expect_err("a stopped job");
    assert_eq!(stopped.kind(), TroubleKind::Cancelled);
    let request = serde_json::to_string(job).expect("a request");
    let again: J = serde_json::from_str(&request).expect("the request again");
    assert_eq!(&again, job);
    let record = Record {
        date: Some("2026-01-01".into()),
        ..Record::default()
    };
    let outcome = again.evaluate(data, &Unwatched).expect("an outcome");
    let result = StoredResult::new(record, &outcome).expect("a result");
    let read =
        StoredResult::from_json(&result.to_json().expect("result.json")).expect("the result again");
    assert_eq!(read.files().expect("files"), result.files().expect("files"));
    outcome
}

fn budget() -> Budget {
    let run = [Key::Run, Key::Channel];
    Budget::new(vec![
        ShakerInput::new("reading", Acts::OutputModulus, 0.003, &run).type_a(20.0),
        ShakerInput::new("noise", Acts::OutputAdditive, 5e-5, &run),
        ShakerInput::rectangular(
            "gluing.angle",
            Acts::Rotation,
            0.017,
            &[Key::Inclination, Key::Rotation],
        ),
    ])
    .expect("a budget")
}

#[test]
fn law_a_triaxial_outcome_is_read_again() {
    let mut runs = vec![];
    for (i, configuration) in published_plan().into_iter().step_by(3).enumerate() {
        for frequency in [80.0, 160.0] {
            runs.push(RunInput {
                run: format!("{i} at {frequency} Hz"),
                session: None,
                frequency,
                configuration,
                reference: Complex64::new(10.0, 0.0),
                // An ideal device: cross terms of exactly zero.
                outputs: configuration
                    .direction()
                    .map(|d| Complex64::new(0.1 * d, 0.0)),
                covariance: [[1e-12, 0.0, 1e-12]; 4],
                quality: Quality::default(),
            });
        }
    }
    let mut job = ShakerTriaxialJob::new(budget());
    job.methods.push(ShakerMethod::PublishedMagnitude);
    let filed = check(&job, &ShakerTriaxialData::new(&runs));
    // Every place that states the principal result states the same one.
    let quantities = filed.quantities();
    let term = &filed.calibration().results[0].frequencies[0].sensitivity[0];
    assert_eq!(quantities[0].name, "S.xx.modulus[frequency=80]");
    assert_eq!(quantities[0].expanded, term.modulus.expanded);
    assert_eq!(quantities[0].k, Some(term.modulus.coverage_factor));
    // A cross term of zero has an interval of the size of its noise, and no phase.
    let zero = &filed.calibration().results[0].frequencies[0].sensitivity[1];
    assert!(zero.phase.is_none());
    assert!(
        zero.modulus.expanded > 1.5 * zero.real.standard_uncertainty,
        "{zero:?}"
    );
}

#[test]
fn law_a_comparison_is_read_again() {
    let reference = ReferenceTable::new(vec![ReferencePoint {
        frequency: 160.0,
        sensitivity: 0.01,
        phase: 0.0,
        modulus_uncertainty: 0.002,
        phase_uncertainty: 0.001,
    }])
    .expect("a certificate");
    let job = ShakerSingleJob::new(
        Some(reference),
        ComparisonBudget {
            ratio: 0.001,
            phase: 0.002,
            dof: DegreesOfFreedom::INFINITE,
            transverse: None,
            front_end: 0.0,
            free_phase: false,
        },
    );
    let run = |name: &str, output: f64| ShakerSingleRun {
        row: ComparisonRow {
            run: name.into(),
            frequency: 160.0,
            reference: Complex64::new(0.1, 0.0),
            output: Complex64::new(output, 0.0),
            transverse: Some(0.02),
            covariance: [[0.0; 3]; 2],
        },
        check: None,
        target: None,
        quality: Quality::default(),
        place: "here".into(),
    };
    let runs = [run("a", 0.2), run("b", 0.2002)];
    let filed = check(&job, &ShakerSingleData::new(&runs));
    assert!((filed.quantities()[0].value - 0.02001).abs() < 1e-9);
}

/// A run at 160 Hz and 10 m/s² in which the motion along an axis is this part of the excitation.
fn spurious_run(measurement: &str, axis: i32, repeat: i32, ratio: Complex64) -> SpuriousRun {
    let velocity = ratio * 10.0 / Complex64::new(0.0, std::f64::consts::TAU * 160.0);
    SpuriousRun {
        run: format!("{measurement} {axis} {repeat}"),
        frequency: 160.0,
        inclination: 0.0,
        axis: axis as usize,
        measurement: measurement.into(),
        phasors: [Complex64::new(10.0, 0.0), velocity],
        quality: Quality::default(),
        place: "here".into(),
    }
}

#[test]
fn law_spurious_motion_is_read_again() {
    let mut runs = vec![];
    for (measurement, size) in [("first", 0.01), ("second", 0.0101)] {
        for axis in 0..3 {
            for repeat in 0..4 {
                let whole = f64::from(axis == 2);
                let ratio = whole + size * (1.0 + 0.01 * f64::from(repeat));
                let ratio = Complex64::new(ratio, 0.001);
                runs.push(spurious_run(measurement, axis, repeat, ratio));
            }
        }
    }
    let filed = check(
        &SpuriousMotionJob::default(),
        &SpuriousMotionData::new(&runs),
    );
    assert_eq!(filed.measurements().len(), 2);
}

/// Of one percent of the excitation, in two set-ups whose repeats scatter by a hundredth of that; the second is `grown` times as large
/// across the excitation.
#[test]
fn known_measurements_of_two_set_ups_that_disagree() {
    let disagreement = |grown: f64| {
        let mut runs = vec![];
        for (measurement, factor) in [("first", 1.0), ("second", grown)] {
            for axis in 0..3 {
                for repeat in 0..4 {
                    let turn = f64::from(repeat) * std::f64::consts::FRAC_PI_2;
                    let along = f64::from(axis == 2);
                    let size = if axis < 2 { 0.01 * factor } else { 0.01 };
                    let ratio = along + size + 1e-4 * Complex64::cis(turn + f64::from(axis));
                    runs.push(spurious_run(measurement, axis, repeat, ratio));
                }
            }
        }
        let job = SpuriousMotionJob::default();
        let outcome = job.evaluate(&SpuriousMotionData::new(&runs), &Unwatched);
        let outcome = outcome.expect("an outcome");
        let findings = outcome.findings();
        let found = findings
            .iter()
            .find(|f| f.code() == "measurements-disagree");
        found.map(|f| f.evidence_text().to_owned())
    };
    assert_eq!(disagreement(1.0), None);
    let evidence = disagreement(1.5).expect("a finding");
    assert!(
        evidence.starts_with("E_n > 1 for 2 of 3 ratios"),
        "{evidence}"
    );
    assert!(evidence.ends_with("difference 0.500 %"), "{evidence}");
}

#[test]
fn law_a_plan_is_read_again() {
    let mut job = PlanJob::new(budget());
    job.best = Some(12);
    job.sizes = vec![6, 12];
    let filed = check(&job, &());
    assert_eq!(filed.configurations().len(), 12);
}

/// A plan says what it takes for granted: 10 mV/(m/s²) where none is stated, and the spurious motion of an earlier campaign.
#[test]
fn known_assumptions_of_a_plan() {
    let found = |job: &PlanJob| -> Vec<(String, String)> {
        let outcome = job.evaluate(&(), &Unwatched).expect("a plan");
        let findings = outcome.findings().iter();
        findings
            .map(|f| (f.code().to_owned(), f.evidence_text().to_owned()))
            .collect()
    };
    let mut job = PlanJob::new(budget());
    job.sizes = vec![12];
    let assumed = found(&job);
    assert!(assumed.iter().any(|f| f.0 == "sensitivity-assumed"));
    job.sensitivity = Some(0.01);
    assert!(found(&job).is_empty());
    // Measured at one inclination of seven, at 100 Hz.
    let u = 2e-4_f64;
    job.correction = Some(Correction {
        label: "vibrometer".into(),
        table: SpuriousTable::new(vec![Spurious {
            basis: Default::default(),
            inclination: 0.0,
            frequency: 100.0,
            ratio: [Complex64::new(0.01, 0.0); 3],
            covariance: [[u * u, 0.0, u * u]; 3],
            dof: DegreesOfFreedom::INFINITE,
        }]),
    });
    let expected = found(&job);
    let expected = expected.iter().find(|f| f.0 == "spurious-motion-expected");
    assert_eq!(
        expected.expect("a finding").1,
        "u = 2.0e-4 of the excitation in each part of a ratio where it is known least; 5 inclinations are not in the table and were given that"
    );
}

/// What the page and the summary of an outcome say, and its files.
fn stored<O: Outcome>(outcome: &O, serial: &str) -> StoredResult {
    let mut record = Record {
        date: Some("2026-01-01".into()),
        ..Record::default()
    };
    record.device.serial = Some(serial.into());
    StoredResult::new(record, outcome).expect("a result")
}

/// Cables of x and y exchanged in every run: the verdict says so, and states no U as known.
#[test]
fn law_a_verdict_begins_with_an_open_decision() {
    let verdict = |exchanged: bool| {
        let mut runs = vec![];
        for (i, configuration) in published_plan().into_iter().step_by(3).enumerate() {
            let turn = Complex64::from_polar(1.0, 1e-3 * (i as f64).sin());
            let mut outputs = configuration.direction().map(|d| 0.1 * d * turn);
            if exchanged {
                outputs.swap(0, 1);
            }
            runs.push(RunInput {
                run: format!("{i}"),
                session: None,
                frequency: 160.0,
                configuration,
                reference: Complex64::new(10.0, 0.0),
                outputs,
                covariance: [[1e-12, 0.0, 1e-12]; 4],
                quality: Quality::default(),
            });
        }
        let job = ShakerTriaxialJob::new(budget());
        let outcome = job
            .evaluate(&ShakerTriaxialData::new(&runs), &Unwatched)
            .expect("an outcome");
        let report = stored(&outcome, "1").report();
        report.answer.verdict
    };
    let sound = verdict(false);
    assert!(sound.contains("are known to U"), "{sound}");
    let open = verdict(true);
    assert!(
        open.starts_with(
            "The sensitivities are not known before it is decided: channel x follows the y axis"
        ),
        "{open}"
    );
}

/// The best configurations stand in the summary, which the terminal prints.
#[test]
fn law_a_chosen_plan_is_in_the_summary() {
    let mut job = PlanJob::new(budget());
    (job.best, job.sizes) = (Some(6), vec![6]);
    let outcome = job.evaluate(&(), &Unwatched).expect("a plan");
    let summary = stored(&outcome, "1").summary();
    let tables = summary.filed_tables();
    let plan = tables.iter().filter(|t| t.file == "plan.csv");
    let rows: Vec<usize> = plan.map(|t| t.rows.len()).collect();
    assert_eq!(rows, [6]);
}

/// Repeats of a spurious motion that are there twice, and the answer of the page.
#[test]
fn known_copies_and_size_of_a_spurious_motion() {
    let mut runs = vec![];
    for axis in 0..3 {
        for repeat in 0..4 {
            let along = f64::from(axis == 2);
            let turn = f64::from(repeat) * std::f64::consts::FRAC_PI_2;
            let size = if axis == 1 { 0.02 } else { 0.01 };
            let ratio = along + size + 1e-4 * Complex64::cis(turn + f64::from(axis));
            runs.push(spurious_run("first", axis, repeat, ratio));
        }
    }
    let evaluated = |runs: &[SpuriousRun]| {
        SpuriousMotionJob::default()
            .evaluate(&SpuriousMotionData::new(runs), &Unwatched)
            .expect("an outcome")
    };
    let outcome = evaluated(&runs);
    assert!(outcome.findings().iter().all(|f| f.code() != "copied-run"));
    let verdict = stored(&outcome, "1").report().answer.verdict;
    assert!(
        verdict.starts_with("Across the excitation the motion is up to (2.00"),
        "{verdict}"
    );
    let again: Vec<SpuriousRun> = runs
        .iter()
        .map(|r| SpuriousRun {
            run: format!("{} again", r.run),
            ..r.clone()
        })
        .collect();
    runs.extend(again);
    let outcome = evaluated(&runs);
    let copied = outcome.findings().iter().find(|f| f.code() == "copied-run");
    let copied = copied.expect("a finding").what();
    assert!(copied.ends_with("11 others likewise"), "{copied}");
}

/// Two comparisons of devices with other serial numbers, and of one device.
#[test]
fn known_devices_and_values_of_a_comparison() {
    use proofmass_jobs::comparison::{ComparisonData, ComparisonJob};
    use proofmass_jobs::frequency_response::{devices_apart, read_document};
    let calibration = |serial: &str, factor: f64| {
        let budget = ComparisonBudget {
            ratio: 0.001,
            phase: 0.002,
            dof: DegreesOfFreedom::INFINITE,
            transverse: None,
            front_end: 0.0,
            free_phase: false,
        };
        let runs: Vec<ShakerSingleRun> = [80.0, 160.0, 315.0]
            .into_iter()
            .map(|frequency| ShakerSingleRun {
                row: ComparisonRow {
                    run: format!("{frequency}"),
                    frequency,
                    reference: Complex64::new(10.0, 0.0),
                    output: Complex64::new(0.1 * factor, 0.001),
                    transverse: Some(0.02),
                    covariance: [[0.0; 3]; 2],
                },
                check: None,
                target: None,
                quality: Quality::default(),
                place: "here".into(),
            })
            .collect();
        let job = ShakerSingleJob::new(None, budget);
        let outcome = job
            .evaluate(&ShakerSingleData::new(&runs), &Unwatched)
            .expect("an outcome");
        let files = stored(&outcome, serial).files().expect("files");
        let file = files.into_iter().find(|f| f.0 == "calibration.json");
        let bytes = std::io::Cursor::new(file.expect("a calibration").1);
        let source = proofmass_io::Source::new(format!("{serial}.json"), bytes);
        read_document(source.expect("a source"), None).expect("a document")
    };
    let names = ["a".to_owned(), "b".to_owned()];
    let same = [calibration("7", 1.0), calibration("7", 1.0)];
    assert!(devices_apart(&same, &names).is_none());
    let apart = [calibration("7", 1.0), calibration("8", 1.01)];
    let found = devices_apart(&apart, &names).expect("a finding");
    assert_eq!(found.code(), "devices-differ");
    assert!(found.evidence_text().contains("serial number 8"), "{found}");
    let verdict = |documents: &[proofmass_jobs::frequency_response::ResponseDocument]| {
        let responses: Vec<_> = documents.iter().map(|d| &d.response).collect();
        let data = ComparisonData {
            responses: &responses,
            names: &["a", "b"],
            findings: &[],
        };
        let outcome = ComparisonJob::default()
            .evaluate(&data, &Unwatched)
            .expect("a comparison");
        stored(&outcome, "7").report().answer.verdict
    };
    let said = verdict(&same);
    assert!(said.contains("the moduli are the same."), "{said}");
    let said = verdict(&apart);
    assert!(
        said.contains("moduli differ by up to") && said.contains("%, at "),
        "{said}"
    );
}

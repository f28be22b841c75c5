//! Jobs of every room, from memory alone: answered, stopped, its request as JSON, its result written, read and rendered
//! again, and its principal result the same wherever it is stated.

mod support;

use num_complex::Complex64;
use proofmass_calibration::FrequencyResponse;
use proofmass_calibration::shaker::recording::Quality;
use proofmass_calibration::shaker::reference::{ReferencePoint, ReferenceTable};
use proofmass_calibration::shaker::single_axis::{ComparisonBudget, ComparisonRow};
use proofmass_calibration::shaker::{Acts, Budget, Input, Key};
use proofmass_io::{AnyCalibration, Source, Unit};
use proofmass_jobs::apply::{ApplyData, ApplyJob, CompensationMethod, Destination};
use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::comparison::{ComparisonData, ComparisonJob};
use proofmass_jobs::noise::{NoiseData, NoiseJob};
use proofmass_jobs::plan::PlanJob;
use proofmass_jobs::shaker_single::{ShakerSingleData, ShakerSingleJob, ShakerSingleRun};
use proofmass_jobs::simulate::{
    SimulateJob, SimulatedMultiPosition, SimulatedShaker, SimulatedSpuriousMotion,
};
use proofmass_jobs::uncertainty::UncertaintyJob;
use proofmass_jobs::validation::{ValidationData, ValidationJob};
use proofmass_jobs::velocity::{AxisData, VelocityEstimateJob};
use proofmass_jobs::{
    AnyData, AnyJob, AnyResult, Gathered, Record, Sink, Trouble, TroubleKind, Unwatched, Watch,
    frequency_response, read_result,
};
use proofmass_motion::{MotionRecord, Source as MotionSource};
use proofmass_noise::{Channel, NoiseModel, Sensor, simulate};
use proofmass_report::terminal;
use proofmass_rig::{Axis, AxisMotion, HandHeld};
use proofmass_uncertainty::DegreesOfFreedom;
use rand::SeedableRng;
use std::sync::{Arc, OnceLock};
use support::{Stop, record};

/// Jobs that have a table of their principal result.
const WITH_TABLES: [&str; 3] = ["multi-position", "shaker-triaxial", "shaker-single"];

type Answer = Result<Box<dyn AnyResult>, Trouble>;

/// Everything that must hold for a result of any kind.
fn check(kind: &str, answer: &dyn Fn(&dyn Watch) -> Answer) -> Box<dyn AnyResult> {
    let Err(stopped) = answer(&Stop) else {
        panic!("{kind} goes on when it is stopped");
    };
    assert_eq!(stopped.kind(), TroubleKind::Cancelled, "{kind}: {stopped}");
    let result = answer(&Unwatched).unwrap_or_else(|e| panic!("{kind}: {e} {:?}", e.place()));
    assert_eq!(result.kind(), kind);
    let bytes = result.to_json().expect("result.json");
    let again = read_result(&bytes).expect("read again");
    let (files, files_again) = (
        result.files().expect("files"),
        again.files().expect("files"),
    );
    for ((name, a), (other, b)) in files.iter().zip(&files_again) {
        assert!(
            name == other && a == b,
            "{kind}: {name} differs when it is read again"
        );
    }
    assert_eq!(files.len(), files_again.len());
    let document: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
    let quantities = result.quantities();
    let stated = document["quantities"].as_array().map_or(0, Vec::len);
    assert_eq!(stated, quantities.len(), "{kind}");
    for (q, d) in quantities
        .iter()
        .zip(document["quantities"].as_array().into_iter().flatten())
    {
        assert_eq!(d["name"], q.name.as_str());
        assert_eq!(d["value"].as_f64(), Some(q.value), "{kind}: {}", q.name);
        assert_eq!(d["U"].as_f64(), Some(q.expanded), "{kind}: {}", q.name);
    }
    let options = terminal::Options {
        width: 200,
        colour: false,
    };
    let text = terminal::render(&result.summary(), &options).expect("terminal");
    let page = files
        .iter()
        .find(|(name, _)| name == "report.html")
        .expect("a page");
    let page = String::from_utf8_lossy(&page.1);
    // The first quantity is what a job was asked for: it stands in the terminal and on the page.
    if let Some(q) = quantities
        .first()
        .filter(|q| q.value != 0.0 && q.expanded > 0.0)
    {
        assert!(
            states(&text, q.value),
            "{kind}: terminal without {} = {}:\n{text}",
            q.name,
            q.value
        );
        assert!(
            states(&page, q.value),
            "{kind}: page without {} = {}",
            q.name,
            q.value
        );
        let tables: Vec<String> = files
            .iter()
            .filter(|(name, _)| name.ends_with(".csv"))
            .map(|(_, bytes)| String::from_utf8_lossy(bytes).into_owned())
            .collect();
        // Tables of the others hold series, budgets or intervals, not the principal result.
        if WITH_TABLES.contains(&kind) {
            let found = tables.iter().any(|t| in_a_row(t, q.value, q.expanded));
            assert!(
                found,
                "{kind}: no table states {} = {} with U = {}",
                q.name, q.value, q.expanded
            );
        }
    }
    result
}

/// Factors between SI and the units that pages print.
const SCALES: [f64; 8] = [
    1.0,
    1e3,
    1e6,
    1e-3,
    1e2,
    180.0 / std::f64::consts::PI,
    1e9,
    1.0 / 9.80665e-3,
];

/// Whether a number of three digits or more in the text is the value, rounded, in some unit.
fn states(text: &str, value: f64) -> bool {
    let normal: String = text
        .chars()
        .map(|c| match c {
            '−' => '-',
            c => c,
        })
        .filter(|c| !matches!(c, '\u{202f}' | '\u{2009}' | '\u{a0}'))
        .collect();
    let numbers = normal.split(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-')));
    numbers
        .filter(|n| n.chars().filter(char::is_ascii_digit).count() >= 3)
        .filter_map(|n| {
            Some((
                n.parse::<f64>().ok()?,
                n.split_once('.').map_or(0, |p| p.1.len()),
            ))
        })
        .any(|(number, decimals)| {
            let half = 0.5001 * 0.1f64.powi(decimals as i32);
            // Powers of ten may stand beside the number.
            let scaled = |s: f64| {
                (-9..=9)
                    .any(|p| (number - value * s * 10f64.powi(p)).abs() <= half && number != 0.0)
            };
            SCALES.iter().any(|s| scaled(*s))
        })
}

/// Whether a row of a table holds the value and its expanded uncertainty, all digits, in some unit.
fn in_a_row(table: &str, value: f64, expanded: f64) -> bool {
    table.lines().any(|line| {
        let numbers: Vec<f64> = line.split(',').filter_map(|f| f.parse().ok()).collect();
        SCALES.iter().any(|s| {
            let has = |v: f64| {
                numbers
                    .iter()
                    .any(|n| (n - v * s).abs() <= 1e-9 * (v * s).abs())
            };
            has(value) && has(expanded)
        })
    })
}

/// A request goes through JSON before it is answered.
fn ask(job: impl Into<AnyJob>, data: &AnyData<'_>, watch: &dyn Watch) -> Answer {
    let job: AnyJob = job.into();
    let text = job.to_json()?;
    let again = AnyJob::from_json(text.as_bytes())?;
    assert_eq!(again, job, "{}", job.kind());
    assert!(AnyJob::KINDS.contains(&job.kind()));
    again.evaluate(data, record(), watch)
}

/// A campaign of a simulation, in memory.
fn simulated(job: &SimulateJob) -> Campaign {
    let files = Gathered::default();
    let data = AnyData::Sink(&files as &dyn Sink);
    ask(job.clone(), &data, &Unwatched).expect("a simulation");
    Campaign::read(Arc::new(files.into_memory()), "campaign.toml").expect("a campaign")
}

fn budget() -> Budget {
    let run = [Key::Run, Key::Channel];
    Budget::new(vec![
        Input::new("reading", Acts::OutputModulus, 0.003, &run).type_a(20.0),
        Input::new("noise", Acts::OutputAdditive, 5e-5, &run),
    ])
    .expect("a budget")
}

fn certificate() -> ReferenceTable {
    let line = |frequency: f64| ReferencePoint {
        frequency,
        sensitivity: 0.01,
        phase: 0.01,
        modulus_uncertainty: 0.002,
        phase_uncertainty: 0.001,
    };
    ReferenceTable::new(vec![line(80.0), line(160.0), line(320.0)]).expect("a certificate")
}

/// The campaign of a simulated recording turned by hand, and its calibration.
fn hand_held() -> &'static (Campaign, AnyCalibration) {
    static ONE: OnceLock<(Campaign, AnyCalibration)> = OnceLock::new();
    ONE.get_or_init(|| {
        let campaign = simulated(&SimulateJob::MultiPosition(
            SimulatedMultiPosition::default(),
        ));
        let result = campaign.evaluate(None, &Unwatched).expect("a calibration");
        let files = result.files().expect("files");
        let file = files.iter().find(|(name, _)| name == "calibration.json");
        let calibration = AnyCalibration::from_json(&file.expect("calibration.json").1);
        (campaign, calibration.expect("a calibration"))
    })
}

#[test]
fn law_campaigns() {
    check("multi-position", &|watch| {
        hand_held().0.evaluate(Some("2026-01-01".into()), watch)
    });
    let mut shaker = SimulatedShaker::default();
    (shaker.phasors, shaker.configurations) = (true, 12);
    shaker.frequencies = vec![80.0, 160.0];
    let shaker = simulated(&SimulateJob::Shaker(shaker));
    let result = check("shaker-triaxial", &|watch| shaker.evaluate(None, watch));
    let files = result.files().expect("files");
    assert!(files.iter().any(|(name, _)| name == "calibration.json"));
    let mut spurious = SimulatedSpuriousMotion::default();
    spurious.frequencies = vec![80.0, 160.0];
    let spurious = simulated(&SimulateJob::SpuriousMotion(spurious));
    check("spurious-motion", &|watch| spurious.evaluate(None, watch));
}

#[test]
fn law_shaker_single_and_plan() {
    let run = |name: &str, output: f64| ShakerSingleRun {
        row: ComparisonRow {
            run: name.into(),
            frequency: 160.0,
            reference: Complex64::new(0.1, 0.0),
            output: Complex64::new(output, 0.01),
            transverse: Some(0.02),
        },
        target: None,
        quality: Quality::default(),
        place: "here".into(),
    };
    let runs = [run("a", 0.2), run("b", 0.2002)];
    let comparison = ComparisonBudget {
        ratio: 0.001,
        phase: 0.002,
        dof: DegreesOfFreedom::INFINITE,
    };
    check("shaker-single", &|watch| {
        let job = ShakerSingleJob::new(certificate(), comparison);
        ask(
            job,
            &AnyData::ShakerSingle(ShakerSingleData::new(&runs)),
            watch,
        )
    });
    let response = FrequencyResponse::try_from(&certificate()).unwrap();
    check("comparison", &|watch| {
        let data = ComparisonData {
            responses: [&response, &response],
            names: ["a", "b"],
            findings: &[],
        };
        ask(ComparisonJob::default(), &AnyData::Comparison(data), watch)
    });
    check("plan", &|watch| {
        let mut job = PlanJob::new(budget());
        job.best = Some(12);
        ask(job, &AnyData::None, watch)
    });
}

#[test]
fn law_validation_and_apply() {
    let (_, calibration) = hand_held();
    let AnyCalibration::Triaxial(file) = calibration else {
        panic!("{}", calibration.kind());
    };
    let recording = HandHeld::default().simulate(9);
    let [x, y, z] = &recording.outputs;
    check("validation", &|watch| {
        let data = ValidationData {
            calibration: file,
            outputs: [x, y, z],
            rate: recording.rate,
            breaks: &[],
            segments: None,
            findings: &[],
            sha256: None,
            name: "memory",
        };
        ask(ValidationJob::default(), &AnyData::Validation(data), watch)
    });
    let response = proofmass_calibration::FrequencyResponse::try_from(&certificate());
    let over_frequency: AnyCalibration = frequency_response::to_file(
        &response.expect("a response"),
        "certificate",
        Unit::Volt,
        &Record::default(),
    )
    .into();
    for (calibration, method, text) in [
        (
            calibration,
            CompensationMethod::Model,
            "acc_x_count,acc_y_count,acc_z_count\n1,2,3\n",
        ),
        (
            &over_frequency,
            CompensationMethod::Band([100.0, 200.0]),
            "u_V\n0.1\n",
        ),
    ] {
        check("apply", &|watch| {
            let mut job = ApplyJob::default();
            job.method = method;
            if method != CompensationMethod::Model {
                job.reading.columns = Some(vec!["u".into()]);
            }
            let mut written = Vec::new();
            let source = Source::from_bytes("recording.csv", text)?;
            let data = ApplyData::new(calibration, source, Destination::Bytes(&mut written));
            let data = AnyData::Apply(data);
            ask(job, &data, watch)
        });
    }
}

#[test]
fn law_noise() {
    let model = NoiseModel {
        white: 2.5e-3,
        random_walk: 5.0e-4,
        ..NoiseModel::default()
    };
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(11);
    let rate = simulate(&model, 20_000, 50.0, &mut rng).expect("noise");
    check("noise", &|watch| {
        let channel = Channel {
            name: "acc_x",
            sensor: Some(Sensor::Accelerometer),
            unit: "m/s²",
            rate: &rate,
        };
        let data = NoiseData::samples(vec![channel], 50.0);
        ask(NoiseJob::default(), &AnyData::Noise(data), watch)
    });
}

#[test]
fn law_velocity() {
    let mut axis = Axis::new(AxisMotion::servo(5.0));
    axis.duration = 2.0;
    let recording = axis.simulate(1).expect("an axis");
    let mut motion = MotionRecord::new(
        recording.sample_time,
        MotionSource::Position,
        recording.position(),
        recording.acceleration.clone(),
    )
    .expect("a record");
    motion.increment = Some(recording.increment);
    let truth: Vec<f64> = recording.truth.iter().map(|p| p.velocity).collect();
    let data = || {
        AnyData::Axis(AxisData {
            reference: Some(&truth),
            ..AxisData::new(&motion)
        })
    };
    check("velocity-estimate", &|watch| {
        ask(VelocityEstimateJob::default(), &data(), watch)
    });
}

#[test]
fn law_uncertainty_and_simulations() {
    let model = "[[input]]\nname = \"m\"\nunit = \"kg\"\nvalue = 2.0\nu = 0.1\n\
                 [[output]]\nname = \"w\"\nunit = \"kg\"\nexpression = \"2.137 * m\"\n";
    check("uncertainty", &|watch| {
        let job = UncertaintyJob {
            model: proofmass_io::read_model(model).expect("a model"),
            ..UncertaintyJob::default()
        };
        ask(job, &AnyData::None, watch)
    });
    check("simulate", &|watch| {
        let files = Gathered::default();
        let mut scenario = SimulatedMultiPosition::default();
        scenario.standstills = 3;
        let data = AnyData::Sink(&files as &dyn Sink);
        ask(SimulateJob::MultiPosition(scenario), &data, watch)
    });
}

#[test]
fn refuses_data_of_another_job_and_requests_of_no_job() {
    let job = AnyJob::from(PlanJob::new(budget()));
    let sink = Gathered::default();
    let Err(trouble) = job.evaluate(&AnyData::Sink(&sink), record(), &Unwatched) else {
        panic!("a plan from a sink");
    };
    assert_eq!(trouble.kind(), TroubleKind::Request);
    for text in [
        "",
        "{}",
        "[]",
        "{\"job\": \"plan\"}",
        "{\"job\": \"noise\", \"alpha\": }",
        "{\"job\": 7}",
    ] {
        let trouble = AnyJob::from_json(text.as_bytes()).expect_err("a refusal");
        assert!(trouble.hint().is_some_and(|h| h.contains("multi-position")));
    }
}

//! Calibrations of sensors, and what is done with them.

use crate::agreement::{
    cell, check, figure, in_the_terminal, stands_on_the_page, states_everywhere,
};
use crate::ask;
use num_complex::Complex64;
use proofmass_core::Gravity;
use proofmass_documents::AnyCalibration;
use proofmass_dynamic::FrequencyResponse;
use proofmass_dynamic::reference_table::{ReferencePoint, ReferenceTable};
use proofmass_io::{Source, Unit};
use proofmass_jobs::apply::{ApplyData, ApplyJob, CompensationMethod, Destination, Rotation};
use proofmass_jobs::bias::{AxisNoise, BiasData, BiasJob};
use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::comparison::{ComparisonData, ComparisonJob};
use proofmass_jobs::free_living::{FreeLivingJob, FreeLivingWindows};
use proofmass_jobs::shaker_single::{ShakerSingleData, ShakerSingleJob, ShakerSingleRun};
use proofmass_jobs::shaker_triaxial::ShakerTriaxialData;
use proofmass_jobs::simulate::{
    SimulateJob, SimulatedMultiPosition, SimulatedPrimary, SimulatedShaker, SimulatedSpuriousMotion,
};
use proofmass_jobs::spurious_motion::{SpuriousMotionData, SpuriousRun};
use proofmass_jobs::temperature::{TemperatureData, TemperatureJob};
use proofmass_jobs::transverse::{TransverseData, TransverseJob, TransverseRun};
use proofmass_jobs::validation::{ValidationData, ValidationJob};
use proofmass_jobs::{
    AnyData, Gathered, Record, Sink, StoredResult, Unwatched, frequency_response,
};
use proofmass_rig::HandHeld;
use proofmass_shaker::recording::Quality;
use proofmass_shaker::single_axis::{ComparisonBudget, ComparisonRow};
use proofmass_shaker::transverse::{Motion, SeatUncertainty};
use proofmass_static::StillWindow;
use proofmass_uncertainty::{Component, Covariance, DegreesOfFreedom, Effect, Estimate, Influence};
use std::sync::{Arc, OnceLock};

/// A campaign of a simulation, in memory.
fn simulated(job: &SimulateJob) -> Campaign {
    let files = Gathered::default();
    let data = AnyData::Sink(&files as &dyn Sink);
    ask(job.clone(), &data, &Unwatched).expect("a simulation");
    Campaign::read(Arc::new(files.into_memory()), "campaign.toml").expect("a campaign")
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
pub fn hand_held() -> &'static (Campaign, AnyCalibration) {
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

pub fn multi_position(kind: &str) -> StoredResult {
    multi_position_of(kind, "2026-01-01")
}

/// The same of a day.
pub fn multi_position_of(kind: &str, day: &str) -> StoredResult {
    check(kind, &|watch| {
        hand_held().0.evaluate(Some(day.into()), watch)
    })
}

/// A logger whose still moments lie all over the sphere; its axis x reads one hundredth and 25 mg too much.
pub fn free_living(kind: &str) {
    let windows = (0..240).map(|k| {
        let (i, turn) = (f64::from(k % 60), f64::from(k / 60));
        let up = 1.0 - (2.0 * i + 1.0) / 60.0;
        let (around, across) = (2.4 * i + 0.3 * turn, (1.0 - up * up).sqrt());
        let noise = |a: f64| 3e-4 * (a * f64::from(k + 1)).sin();
        StillWindow {
            time: 600.0 * f64::from(k),
            mean: [
                1.01 * across * around.cos() + 0.025 + noise(7.1),
                across * around.sin() + noise(3.7),
                up + noise(5.3),
            ],
            temperature: None,
        }
    });
    let data = FreeLivingWindows {
        still: windows.collect(),
        seen: 1000,
        name: "memory".into(),
        ..FreeLivingWindows::default()
    };
    check(kind, &|watch| {
        ask(FreeLivingJob::default(), &AnyData::FreeLiving(&data), watch)
    });
}

pub fn shaker_triaxial(kind: &str) -> StoredResult {
    let mut shaker = SimulatedShaker::default();
    (shaker.phasors, shaker.configurations) = (true, 12);
    shaker.frequencies = vec![80.0, 160.0];
    let shaker = simulated(&SimulateJob::Shaker(shaker));
    let result = check(kind, &|watch| shaker.evaluate(None, watch));
    let files = result.files().expect("files");
    assert!(files.iter().any(|(name, _)| name == "calibration.json"));
    let mut recorded = SimulatedShaker::default();
    (recorded.duration, recorded.configurations) = (0.2, 6);
    recorded.frequencies = vec![160.0];
    let recorded = simulated(&SimulateJob::Shaker(recorded));
    check(kind, &|watch| recorded.evaluate(None, watch));
    // Every other run on another day.
    let Campaign::ShakerTriaxial(campaign) = &shaker else {
        panic!("a triaxial campaign");
    };
    let files = campaign.load(&Unwatched).expect("runs");
    let mut runs = files.data().runs().to_vec();
    for (k, run) in runs.iter_mut().enumerate() {
        run.session = Some(["one day", "another day"][k % 2].to_owned());
    }
    check(kind, &|watch| {
        let data = ShakerTriaxialData::new(&runs);
        ask(files.job.clone(), &AnyData::ShakerTriaxial(data), watch)
    });
    result
}

pub fn spurious_motion(kind: &str) {
    let mut spurious = SimulatedSpuriousMotion::default();
    spurious.frequencies = vec![80.0, 160.0];
    let spurious = simulated(&SimulateJob::SpuriousMotion(spurious));
    let result = check(kind, &|watch| spurious.evaluate(None, watch));
    let [re, im] = ["real", "imaginary"].map(|part| cell(&result, "ratios.csv", 0, part));
    states_everywhere(&result, 100.0 * re.hypot(im));
    // Every reading once more, on another day.
    let Campaign::SpuriousMotion(campaign) = &spurious else {
        panic!("a spurious motion");
    };
    let files = campaign.load(&Unwatched).expect("readings");
    let mut runs = files.data().runs().to_vec();
    for run in runs.clone() {
        runs.push(SpuriousRun {
            run: format!("{} again", run.run),
            measurement: "another day".into(),
            ..run
        });
    }
    check(kind, &|watch| {
        let data = SpuriousMotionData::new(&runs);
        ask(files.job.clone(), &AnyData::SpuriousMotion(data), watch)
    });
}

pub fn shaker_single(kind: &str) -> StoredResult {
    let run = |name: &str, output: f64| ShakerSingleRun {
        row: ComparisonRow {
            run: name.into(),
            frequency: 160.0,
            reference: Complex64::new(0.1, 0.0),
            output: Complex64::new(output, 0.01),
            transverse: Some(0.02),
            covariance: [[0.0; 3]; 2],
        },
        check: None,
        target: None,
        quality: Quality::default(),
        place: "here".into(),
    };
    let runs = [run("a", 0.2), run("b", 0.2002)];
    // A check standard of 0.1 V/(m/s²) beside the device.
    let checked = runs.clone().map(|run| ShakerSingleRun {
        check: Some((Complex64::new(0.1, 0.0), [0.0; 3])),
        ..run
    });
    let comparison = ComparisonBudget {
        ratio: 0.001,
        phase: 0.002,
        dof: DegreesOfFreedom::INFINITE,
        transverse: None,
        front_end: 0.0,
        free_phase: false,
    };
    check(kind, &|watch| {
        let mut job = ShakerSingleJob::new(Some(certificate()), comparison);
        job.check_standard = Some(certificate());
        let data = AnyData::ShakerSingle(ShakerSingleData::new(&checked));
        ask(job, &data, watch)
    });
    check(kind, &|watch| {
        let job = ShakerSingleJob::new(Some(certificate()), comparison);
        ask(
            job,
            &AnyData::ShakerSingle(ShakerSingleData::new(&runs)),
            watch,
        )
    })
}

/// Two repeats at three frequencies: one with counted fringes, one at a zero of J₁.
pub fn shaker_primary(kind: &str) -> StoredResult {
    let mut primary = SimulatedPrimary::default();
    (primary.repeats, primary.duration) = (2, 0.05);
    primary.frequencies = vec![200.0, 400.0, 2000.0];
    let Campaign::ShakerPrimary(campaign) = simulated(&SimulateJob::Primary(primary)) else {
        panic!("a primary calibration");
    };
    let files = campaign.load(&Unwatched).expect("recordings");
    let result = check(kind, &|watch| {
        ask(
            files.job.clone(),
            &AnyData::ShakerPrimary(files.data()),
            watch,
        )
    });
    let written = result.files().expect("files");
    for name in ["calibration.json", "methods.csv", "interferometer.csv"] {
        assert!(written.iter().any(|(file, _)| file == name), "{name}");
    }
    result
}

pub fn transverse(kind: &str) -> StoredResult {
    let run = |name: String, motion, output: f64| TransverseRun {
        run: name,
        frequency: 160.0,
        motion,
        reference: Complex64::new(0.1, 0.0),
        output: Complex64::new(output, 0.1 * output),
        transverse: Some(0.02),
        target: None,
        quality: Quality::default(),
        place: "here".into(),
    };
    let mut runs = vec![run("axis".into(), Motion::Axial, 0.2)];
    for k in 0..8 {
        let rotation = f64::from(k) * std::f64::consts::FRAC_PI_4;
        // A jitter that is no cosine.
        let output = 0.004 * rotation.cos() + 1e-5 * f64::from(k * k % 5);
        runs.push(run(
            format!("across {k}"),
            Motion::Transverse { rotation },
            output,
        ));
    }
    let result = check(kind, &|watch| {
        let mut job = TransverseJob::new(SeatUncertainty::new(1e-3));
        job.reference = Some(certificate());
        job.limit = Some(0.05);
        ask(job, &AnyData::Transverse(TransverseData::new(&runs)), watch)
    });
    figure(&result, "transverse.csv", 0, "transverse_%");
    result
}

pub fn validation(kind: &str) {
    let (_, calibration) = hand_held();
    let AnyCalibration::Constant(file) = calibration else {
        panic!("{}", calibration.kind());
    };
    let recording = HandHeld::default().simulate(9);
    let [x, y, z] = &recording.outputs;
    let result = check(kind, &|watch| {
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
    for name in ["rms_after_mg", "chi_square"] {
        let validation = result.section("validation").expect("a section");
        states_everywhere(&result, validation[name].as_f64().expect("a number"));
    }
}

pub fn apply(kind: &str) {
    let (_, calibration) = hand_held();
    let response = FrequencyResponse::try_from(&certificate());
    let over_frequency: AnyCalibration = frequency_response::to_file(
        &response.expect("a response"),
        "certificate",
        Unit::Volt,
        &Record::default(),
    )
    .into();
    let rotation = Rotation {
        angles: [0.1, -0.2, 0.3],
        uncertainty: [0.01; 3],
        covariance: None,
    };
    for (calibration, method, rotation, text) in [
        (
            calibration,
            CompensationMethod::Model,
            None,
            "acc_x_count,acc_y_count,acc_z_count\n1,2,3\n",
        ),
        (
            calibration,
            CompensationMethod::Model,
            Some(rotation),
            "acc_x_count,acc_y_count,acc_z_count\n1,2,3\n",
        ),
        (
            &over_frequency,
            CompensationMethod::Band([100.0, 200.0]),
            None,
            "u_V\n0.1\n",
        ),
    ] {
        check(kind, &|watch| {
            let mut job = ApplyJob::default();
            job.method = method;
            job.chain.rotation = rotation;
            if method != CompensationMethod::Model {
                job.reading.columns = Some(vec!["u".into()]);
            }
            let mut written = Vec::new();
            let source = Source::from_bytes("recording.csv", text)?;
            let data = ApplyData::new(calibration, source, Destination::Bytes(&mut written));
            let answer = ask(job, &AnyData::Apply(data), watch);
            // What was stopped left no row.
            assert_eq!(answer.is_ok(), written.len() > 20, "{written:?}");
            answer
        });
    }
}

/// 0 … 40 °C in 1000 samples, x by 0.5 mg/K.
pub fn temperature(kind: &str) -> StoredResult {
    let temperature: Vec<f64> = (0..1000).map(|i| f64::from(i) / 25.0).collect();
    let column = |k: usize, level: f64, slope: f64| -> Vec<f64> {
        let noise = |i: usize| ((i * (7919 + 104 * k) % 10_007) as f64 / 10_007.0 - 0.5) * 4e-3;
        let all = temperature.iter().enumerate();
        all.map(|(i, t)| level + slope * t + noise(i)).collect()
    };
    let outputs = [
        column(0, 0.01, 5e-4),
        column(1, 0.0, 0.0),
        column(2, 1.0, 0.0),
    ];
    check(kind, &|watch| {
        let data = TemperatureData {
            outputs: outputs.iter().map(Vec::as_slice).collect(),
            unit: Unit::StandardGravity,
            temperature: &temperature,
            environment: &[],
            rate: 10.0,
            calibration: None,
            findings: &[],
            name: "memory",
        };
        ask(
            TemperatureJob::default(),
            &AnyData::Temperature(data),
            watch,
        )
    })
}

pub fn bias(kind: &str) {
    // At rest with z up, x 5 mm/s² too much.
    let column = |level: f64, k: f64| -> Vec<f64> {
        let noise = |i: u32| 2e-3 * (k * f64::from(i)).sin();
        (0..6000).map(|i| level + noise(i)).collect()
    };
    let outputs = [column(5e-3, 7.1), column(0.0, 3.3), column(9.80665, 5.7)];
    let time: Vec<f64> = (0..6000).map(|i| f64::from(i) / 100.0).collect();
    let noise = AxisNoise::walk(2e-4, 1e-6);
    let mut job = BiasJob::new([noise.clone(), AxisNoise::markov(2e-4, 1e-3, 60.0), noise]);
    job.gravity = Some(Gravity::given(9.80665, 1e-4).expect("gravity"));
    job.up = Some([0.0, 0.0, 1.0]);
    check(kind, &|watch| {
        let data = BiasData {
            outputs: outputs.each_ref().map(Vec::as_slice),
            time: &time,
            rate: 100.0,
            breaks: &[],
            segments: None,
            findings: &[],
            name: "memory",
        };
        ask(job.clone(), &AnyData::Bias(data), watch)
    });
}

fn of_one_bench(factor: f64) -> FrequencyResponse {
    let of = |key: &str, u: f64| {
        let covariance = Covariance::from_standard_uncertainties(&[u, u]).expect("a covariance");
        Influence::normal(key, key, Effect::Joint { covariance })
    };
    let components = vec![
        Component::new("modulus", "V/(m/s²)", factor),
        Component::new("phase", "rad", 0.0),
    ];
    let influences = vec![of("reference.calibration", 0.002), of("reading", 0.001)];
    let estimate = Estimate::new(components, influences).expect("an estimate");
    FrequencyResponse::from_polar("z", &[(80.0, &estimate), (160.0, &estimate)], None)
        .expect("a response")
}

pub fn comparison(kind: &str) {
    let ours = FrequencyResponse::try_from(&certificate()).expect("a response");
    let mut lines = certificate().points().to_vec();
    lines.iter_mut().for_each(|line| line.sensitivity *= 1.0123);
    let theirs = ReferenceTable::new(lines).expect("a certificate");
    let theirs = FrequencyResponse::try_from(&theirs).expect("a response");
    let result = check(kind, &|watch| {
        let data = ComparisonData {
            responses: &[&ours, &theirs],
            names: &["a", "b"],
            findings: &[],
        };
        ask(ComparisonJob::default(), &AnyData::Comparison(data), watch)
    });
    // The sentence gives the size, the table the sign.
    let first = cell(&result, "comparison.csv", 0, "difference_percent");
    assert!(first < 0.0);
    stands_on_the_page(&result, first);
    assert!(in_the_terminal(&result).contains("by up to 1.2 %"));
    // Two calibrations of one bench, whose reference is one error of both.
    let [glued, screwed] = [0.99, 1.0].map(of_one_bench);
    check(kind, &|watch| {
        let data = ComparisonData {
            responses: &[&glued, &screwed],
            names: &["glued", "screwed"],
            findings: &[],
        };
        let mut job = ComparisonJob::default();
        job.common = vec!["reference".into()];
        ask(job, &AnyData::Comparison(data), watch)
    });
    let several = check(kind, &|watch| {
        let data = ComparisonData {
            responses: &[&ours, &theirs, &ours],
            names: &["a", "b", "c"],
            findings: &[],
        };
        ask(ComparisonJob::default(), &AnyData::Comparison(data), watch)
    });
    // Two thirds of 1.23 % less than b, one third more than a and c, near enough.
    let second = figure(&several, "equivalence.csv", 1, "modulus_difference_percent");
    assert!((second - 0.82).abs() < 0.02);
}

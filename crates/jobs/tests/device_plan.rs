//! Plans for a data sheet: what is needed, by hand; whether devices are decided as planned; what is asked for and refused.

use proofmass_core::{Gravity, Matrix3, SensorModel};
use proofmass_io::{Input, Unit};
use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::data_sheet::{DataSheet, sheet};
use proofmass_jobs::device_check::{DeviceCheckData, DeviceCheckJob, DeviceResult, SheetVerdict};
use proofmass_jobs::device_plan::{DevicePlanJob, DevicePlanOutcome, PlannedLimit};
use proofmass_jobs::multi_position::{MultiPositionData, MultiPositionJob};
use proofmass_jobs::noise::{NoiseData, NoiseJob};
use proofmass_jobs::{Job, Outcome, Record, StoredResult, Trouble, Unwatched};
use proofmass_noise::{NoiseChannel, NoiseModel, Sensor, simulate};
use proofmass_rig::{HandHeld, TurnedAxis};
use rand::SeedableRng;

const G: f64 = 9.80665;
/// µg/√Hz one-sided of one (m/s²)/√Hz two-sided.
const N: f64 = std::f64::consts::SQRT_2 * 1e6 / G;

fn limit(lines: &str) -> String {
    format!("[[limit]]\n{}\n", lines.replace("; ", "\n"))
}

fn job(text: &str) -> DevicePlanJob {
    let mut job = DevicePlanJob::default();
    job.sheet = sheet(text).unwrap_or_else(|e| panic!("{text}: {e}"));
    job.given.rate = Some(50.0);
    job.given.gravity_uncertainty = Some(1e-4);
    job.given.reference_uncertainty = Some(0.5);
    job
}

fn planned(job: &DevicePlanJob) -> DevicePlanOutcome {
    job.evaluate(&(), &Unwatched)
        .unwrap_or_else(|e| panic!("{e} {:?}", e.place()))
}

fn only(outcome: &DevicePlanOutcome) -> &PlannedLimit {
    let [one] = outcome.limits() else {
        panic!("{:?}", outcome.limits());
    };
    one
}

fn found(outcome: &DevicePlanOutcome, code: &str) -> bool {
    outcome.findings().iter().any(|f| f.code() == code)
}

fn verdicts(sheet: &DataSheet, kind: &str, result: &StoredResult) -> Vec<SheetVerdict> {
    let input = Input {
        path: kind.to_owned(),
        sha256: kind.to_owned(),
        ..Input::default()
    };
    let bytes = result.to_json().expect("JSON");
    let results =
        [DeviceResult::from_json("unit", "unit/result.json", &bytes, input).expect("a result")];
    let mut check = DeviceCheckJob::default();
    check.sheet = sheet.clone();
    let outcome = check
        .evaluate(&DeviceCheckData { results: &results }, &Unwatched)
        .expect("a verdict");
    outcome.devices()[0]
        .limits
        .iter()
        .map(|l| l.verdict)
        .collect()
}

/// A typical value 15 below a limit of 160: U (1 + 1.2816/1.9600) = 15, U = 9.0700; the tolerance over U is that of JCGM 106,
/// 7.6.3: without a typical value, ± 130 over 4.
#[test]
fn known_uncertainty_that_a_limit_needs() {
    let outcome = planned(&job(&limit(
        "term = \"N\"; most = 160; typical = 145; unit = \"µg/√Hz\"",
    )));
    assert!(
        (only(&outcome).expanded() - 9.0700).abs() < 1e-3,
        "{:?}",
        only(&outcome)
    );
    assert!(found(&outcome, "slow-noise-not-stated"));
    assert_eq!(outcome.findings().len(), 1);
    let bias = limit("characteristic = \"bias\"; most = 130; unit = \"mg\"");
    let mut wide = job(&bias);
    wide.noise = Some(Default::default());
    let refused = wide.evaluate(&(), &Unwatched).unwrap_err();
    assert!(refused.to_string().contains("white noise"), "{refused}");
    let outcome = planned(&job(&format!(
        "{bias}{}",
        limit("term = \"N\"; most = 160; typical = 145; unit = \"µg/√Hz\"")
    )));
    assert!((outcome.limits()[0].expanded() - 32.5).abs() < 1e-9);
    assert!(found(&outcome, "typical-not-stated"));
    // By the value alone, in nine of ten: U = 1.96 · 15/1.2816.
    let simple = format!(
        "[decision]\nrule = \"simple\"\n{}",
        limit("term = \"N\"; most = 160; typical = 145; unit = \"µg/√Hz\"")
    );
    assert!((only(&planned(&job(&simple))).expanded() - 22.94).abs() < 0.01);
}

/// Of white noise alone u(N)/N = 1/√(2n) at least, and the ends of the interval lie √4.61 of it away: with a margin of 10.34 %
/// n = ½ ((2.147 + 1.2816)/0.1034)², 550 samples or more; heavy tails that so few samples do not exclude take as
/// many again, and what is sought beside the noise the double.
#[test]
fn crosscheck_length_of_a_recording_of_white_noise() {
    let outcome = planned(&job(&limit(
        "term = \"N\"; most = 160; typical = 145; unit = \"µg/√Hz\"",
    )));
    let samples = 50.0 * only(&outcome).duration.unwrap();
    assert!((550.0..4000.0).contains(&samples), "{samples}");
}

/// Devices with the typical noise, recorded for as long as planned and judged by `device check`.
#[test]
fn coverage_a_device_is_decided_by_the_planned_recording() {
    let text = limit("term = \"N\"; most = 160; typical = 145; unit = \"µg/√Hz\"");
    let job = job(&text);
    let duration = only(&planned(&job)).duration.unwrap();
    let model = NoiseModel {
        white: 145.0 / N,
        ..NoiseModel::default()
    };
    let runs = 60;
    let decided = (0..runs).filter(|seed| {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(*seed);
        let rate = simulate(&model, (50.0 * duration) as usize, 50.0, &mut rng).expect("noise");
        let channel = NoiseChannel {
            name: "acc",
            sensor: Some(Sensor::Accelerometer),
            unit: "m/s²",
            rate: &rate,
        };
        let data = NoiseData::samples(vec![channel], 50.0);
        let outcome = NoiseJob::default()
            .evaluate(&data, &Unwatched)
            .expect("an analysis");
        let result = StoredResult::new(Record::default(), &outcome).expect("a result");
        verdicts(&job.sheet, "noise", &result) == [SheetVerdict::Pass]
    });
    let decided = decided.count();
    println!("{duration} s: {decided} of {runs} decided");
    assert!(decided >= 54, "{decided} of {runs}");
}

/// Three axes with the typical bias, turned by hand as planned, their rests found by the search, judged by `device check`.
#[test]
fn coverage_a_bias_is_decided_by_the_planned_positions() {
    let noise = limit("term = \"N\"; most = 300; typical = 200; unit = \"µg/√Hz\"");
    let text = format!(
        "{}{noise}",
        limit("characteristic = \"bias\"; most = 5; typical = 4.8; unit = \"mg\"")
    );
    let job = job(&text);
    let outcome = planned(&job);
    let plan = &outcome.limits()[0];
    let (attitudes, rest) = plan.positions.unwrap();
    let (rate, bias) = (25.0, 4.8e-3 * G);
    let ideal = Matrix3([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let rig = HandHeld {
        sensor: SensorModel::new(ideal, [bias, -bias, bias]).expect("a sensor"),
        rate,
        rest,
        turn: 2.0,
        rests: attitudes,
        noise: 200.0 / N * rate.sqrt(),
        resolution: 1e-4,
        ..HandHeld::default()
    };
    let (runs, mut decided) = (30, 0);
    for seed in 0..runs {
        let recording = rig.simulate(1000 + seed);
        let data = MultiPositionData::new(
            recording.outputs.each_ref().map(Vec::as_slice),
            rate,
            Unit::MetrePerSecondSquared,
        );
        let fit = MultiPositionJob::new(Gravity::given(G, 1e-4).expect("gravity"));
        let Ok(outcome) = fit.evaluate(&data, &Unwatched) else {
            continue;
        };
        let result = StoredResult::new(Record::default(), &outcome).expect("a result");
        let all = verdicts(&job.sheet, "multi-position", &result);
        decided += all.iter().filter(|v| **v == SheetVerdict::Pass).count();
    }
    println!(
        "{attitudes} attitudes of {rest} s: {decided} of {} decided",
        3 * runs
    );
    assert!(decided >= 81, "{decided} of {}, {plan:?}", 3 * runs);
}

/// One axis with the typical bias and scale, turned through the planned angles, its rests found in the recording by `calibrate`, judged by
/// `device check`.
#[test]
fn coverage_one_axis_is_decided_by_the_planned_angles() {
    let noise = limit("term = \"N\"; most = 300; typical = 200; unit = \"µg/√Hz\"");
    let text = format!(
        "{}{}{noise}",
        limit("characteristic = \"bias\"; most = 5; typical = 4; unit = \"mg\""),
        limit(
            "characteristic = \"scale\"; nominal = 1; \"tolerance_%\" = 0.6; typical = 1.005; unit = \"1\""
        )
    );
    let mut job = job(&text);
    job.given.axes = 1;
    let e = refused(&job);
    assert!(e.hint().unwrap().contains("--fixture-angle"), "{e}");
    job.given.fixture_angle = Some(1.0);
    let outcome = planned(&job);
    let plan = &outcome.limits()[0];
    let (angles, rest) = plan.positions.unwrap();
    assert!(
        plan.reached && plan.what.starts_with("12 angles, 30° apart"),
        "{plan:?}"
    );
    let (rate, bias) = (25.0, 4e-3 * G);
    let mut rig = TurnedAxis::default();
    rig.angles = (0..angles)
        .map(|k| (360.0 * k as f64 / angles as f64).to_radians())
        .collect();
    (rig.bias, rig.sensitivity, rig.misalignment) = (bias, 1.005, 0.0);
    (rig.gravity, rig.rate, rig.rest) = (G, rate, 1.25 * rest);
    rig.noise = 200.0 / N * rate.sqrt();
    let (runs, mut decided) = (30, 0);
    let folder = tempfile::tempdir().unwrap();
    let steps: Vec<f64> = rig.angles.iter().map(|a| a.to_degrees()).collect();
    let campaign = format!(
        "kind = \"single-axis\"\n[recording]\nfile = \"turn.csv\"\ncolumn = \"a\"\n[position]\nangles_deg = {steps:?}\n\
         lean_deg = 1.0\nout_of_plane_deg = 1.0\nminimum_duration_s = {:.2}\n[gravity]\nvalue = {G}\nstandard_uncertainty = 1e-4\n",
        0.8 * rest
    );
    std::fs::write(folder.path().join("campaign.toml"), campaign).unwrap();
    for seed in 0..runs {
        let mut table = String::from("t_s,a_m/s2\n");
        for (k, a) in rig.simulate(2000 + seed).output.iter().enumerate() {
            table += &format!("{:.2},{a:.6}\n", k as f64 / rate);
        }
        std::fs::write(folder.path().join("turn.csv"), table).unwrap();
        let campaign = Campaign::open(folder.path().join("campaign.toml")).unwrap();
        let Ok(result) = campaign.evaluate(None, &Unwatched) else {
            continue;
        };
        let all = verdicts(&job.sheet, "static-test", &result);
        decided += all.iter().filter(|v| **v == SheetVerdict::Pass).count();
    }
    println!(
        "{angles} angles of {rest} s: {decided} of {} decided",
        2 * runs
    );
    assert!(decided >= 54, "{decided} of {}, {plan:?}", 2 * runs);
    // A limit between two axes is none of such a device.
    job.sheet = sheet(&format!(
        "{text}{}",
        limit("characteristic = \"non-orthogonality\"; most = 1; unit = \"°\"")
    ))
    .unwrap();
    assert!(refused(&job).to_string().contains("limit 4"));
}

/// Every limit has a way, its command, and a number that was worked out by hand.
#[test]
fn known_ways_of_other_characteristics() {
    let noise = limit("term = \"N\"; most = 160; typical = 145; unit = \"µg/√Hz\"");
    let plan = |lines: &str| {
        let mut job = job(&format!("{}{noise}", limit(lines)));
        job.given.acceleration = Some(50.0);
        job.given.temperature_range = Some(vec![-20.0, 60.0]);
        let outcome = planned(&job);
        let first = outcome.limits()[0].clone();
        println!("{}: {}", first.command, first.what);
        first
    };
    // N 1005 µ(m/s²)/√Hz two-sided; U 0.0605 mg/K over 80 K: a minute suffices.
    let slope =
        plan("characteristic = \"bias-temperature\"; most = 0.5; typical = 0.4; unit = \"mg/K\"");
    assert!(
        slope.what.contains("-20 to 60 °C") && slope.what.contains("15 min of soak"),
        "{}",
        slope.what
    );
    assert_eq!(slope.duration, Some(9.0 * 960.0));
    // U 2 % needed, 0.98 % of it the reference's: √(4 − 0.96)·√3/4.303 = 0.702 %.
    let scale = plan(
        "characteristic = \"scale\"; nominal = 10; \"tolerance_%\" = 8; unit = \"mV/g\"; frequency_Hz = [10, 1000]",
    );
    assert!(
        scale.what.contains("21 frequencies from 10 to 1000 Hz") && scale.what.contains("0.702 %"),
        "{}",
        scale.what
    );
    // u(k₂) = σ/(A² √(4n/45)), σ = 0.5 % of 50/√3 m/s²: U of 1.2·10⁻⁵ 1/(m/s²) takes 1000 levels, of 1.2·10⁻⁴ eleven.
    let square =
        plan("characteristic = \"second-order\"; most = 1e-3; typical = 8e-4; unit = \"1/(m/s²)\"");
    assert!(
        square.reached && square.what.contains("11 accelerations"),
        "{}",
        square.what
    );
    let square = plan(
        "characteristic = \"second-order\"; most = 1e-4; typical = 9.8e-5; unit = \"1/(m/s²)\"",
    );
    assert!(!square.reached && square.why.contains("second-order"));
    let corner = plan("characteristic = \"low-corner\"; most = 0.5; typical = 0.4; unit = \"Hz\"");
    assert!(
        corner.what.contains("0.08 to 5 Hz for 4.17 min"),
        "{}",
        corner.what
    );
    for (lines, word) in [
        (
            "characteristic = \"third-order\"; most = 1e-4; unit = \"1/(m/s²)²\"",
            "accelerations",
        ),
        (
            "characteristic = \"scale-temperature\"; most = 0.01; unit = \"%/K\"",
            "two attitudes",
        ),
        (
            "characteristic = \"bias-drift\"; most = 0.1; unit = \"mg/month\"",
            "three calibrations",
        ),
        (
            "characteristic = \"transverse-sensitivity\"; most = 3; typical = 2; unit = \"%\"",
            "twelve directions",
        ),
        (
            "characteristic = \"resonance\"; lower = 2.4; typical = 3; unit = \"kHz\"",
            "240 to 9000 Hz",
        ),
        (
            "characteristic = \"delay\"; most = 1; typical = 0.5; unit = \"ms\"",
            "one clock",
        ),
        (
            "characteristic = \"damping\"; most = 1; typical = 0.7; unit = \"1\"",
            "resonance",
        ),
    ] {
        assert!(plan(lines).what.contains(word), "{lines}");
    }
}

#[test]
fn known_limits_that_no_measurement_decides() {
    let noise = limit("term = \"N\"; most = 160; typical = 159.9999; unit = \"µg/√Hz\"");
    let mut short = job(&noise);
    short.given.longest = 1.0;
    let outcome = planned(&short);
    assert!(!only(&outcome).reached);
    assert!(found(&outcome, "plan-out-of-reach"));
    // Gravity known to 0.03 m/s² leaves 0.6 % of the scale.
    let scale =
        limit("characteristic = \"scale\"; nominal = 1; \"tolerance_%\" = 0.4; unit = \"1\"");
    let mut coarse = job(&format!(
        "{scale}{}",
        limit("term = \"N\"; most = 160; typical = 145; unit = \"µg/√Hz\"")
    ));
    coarse.given.gravity_uncertainty = Some(0.03);
    let outcome = planned(&coarse);
    assert!(!outcome.limits()[0].reached && outcome.limits()[0].why.contains("gravity"));
    // A reference that is worse than the limit.
    let scale = limit(
        "characteristic = \"scale\"; nominal = 1; \"tolerance_%\" = 1; unit = \"1\"; frequency_Hz = [10, 100]",
    );
    assert!(only(&planned(&job(&scale))).why.contains("reference"));
}

fn refused(job: &DevicePlanJob) -> Trouble {
    job.evaluate(&(), &Unwatched).expect_err("refused")
}

/// All that is not known is asked for at once.
#[test]
fn refuses_with_everything_that_is_missing() {
    let text = [
        limit("term = \"N\"; most = 160; unit = \"µg/√Hz\""),
        limit("characteristic = \"bias\"; most = 100; unit = \"V\""),
        limit("characteristic = \"scale\"; most = 100; unit = \"V/g\"; frequency_Hz = [1, 10]"),
        limit("characteristic = \"bias-temperature\"; most = 1; unit = \"mg/K\""),
        limit("characteristic = \"second-order\"; most = 1; unit = \"µg/g²\""),
    ]
    .concat();
    let mut job = DevicePlanJob::default();
    job.sheet = sheet(&text).expect("a sheet");
    let e = refused(&job);
    let hint = e.hint().unwrap_or_default();
    for word in [
        "typical = … in limit 1 (N)",
        "--noise-result",
        "--rate HZ",
        "--gravity-uncertainty",
        "--reference-uncertainty",
        "--temperature-range",
        "--acceleration",
        "nominal",
    ] {
        assert!(hint.contains(word), "{word}: {hint}");
    }
    assert!(e.to_string().contains("8 things"), "{e}");
}

#[test]
fn refuses_numbers_without_meaning() {
    let noise = limit("term = \"N\"; most = 160; typical = 145; unit = \"µg/√Hz\"");
    type Change = fn(&mut DevicePlanJob);
    let changes: [(Change, &str); 11] = [
        (|j| j.given.rate = Some(0.0), "rate"),
        (|j| j.given.gravity_uncertainty = Some(f64::NAN), "gravity"),
        (|j| j.given.reference_uncertainty = Some(-1.0), "reference"),
        (|j| j.given.acceleration = Some(0.0), "acceleration"),
        (
            |j| j.given.temperature_range = Some(vec![60.0, -20.0]),
            "temperature",
        ),
        (|j| j.given.ratio = 0.5, "ratio"),
        (|j| j.given.decided = 1.0, "decided"),
        (|j| j.given.wander = f64::INFINITY, "wander"),
        (|j| j.given.soak = -1.0, "soak"),
        (|j| j.given.axes = 2, "axes"),
        (|j| j.given.fixture_angle = Some(-1.0), "fixture-angle"),
    ];
    for (change, word) in changes {
        let mut job = job(&noise);
        change(&mut job);
        assert!(refused(&job).to_string().contains(word), "{word}");
    }
    let beyond = sheet(&limit(
        "term = \"N\"; most = 160; typical = 170; unit = \"µg/√Hz\"",
    ))
    .unwrap_err();
    assert!(
        beyond.to_string().contains("does not lie within"),
        "{beyond}"
    );
    let mut loud = job(&noise);
    loud.noise = Some(Default::default());
    if let Some(noise) = &mut loud.noise {
        noise.white = 200.0 / N;
    }
    loud.sheet.limit[0].typical = None;
    assert!(only(&planned(&loud)).why.contains("lies beyond"));
    let gyroscope = job(&limit(
        "term = \"N\"; most = 1; typical = 0.5; unit = \"°/√h\"",
    ));
    assert!(
        refused(&gyroscope).to_string().contains("no unit"),
        "{}",
        refused(&gyroscope)
    );
}

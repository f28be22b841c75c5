//! The three questions to an axis, from memory alone.

use crate::support;
use proofmass_jobs::velocity::{
    AxisData, AxisRecordings, AxisSensors, Reference, VelocityCompareJob, VelocityEstimateJob,
    VelocityMapJob, VelocityTuneJob,
};
use proofmass_jobs::{Job, Memory, Outcome, TroubleKind, Unwatched};
use proofmass_motion::{LowCorner, Method, MotionRecord, ReadingSource};
use proofmass_rig::{AxisMotion, AxisRecording, DrivenAxis};
use proofmass_uncertainty::Finding;

fn recording() -> AxisRecording {
    let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
    axis.duration = 2.0;
    axis.simulate(1).unwrap()
}

fn record() -> (MotionRecord, Vec<f64>) {
    let recording = recording();
    let mut record = MotionRecord::new(
        recording.sample_time,
        ReadingSource::Position,
        recording.position(),
        recording.acceleration.clone(),
    )
    .unwrap();
    record.increment = Some(recording.increment);
    (record, recording.truth.iter().map(|p| p.velocity).collect())
}

#[test]
fn law_outcomes_come_back_to_the_byte() {
    let (record, truth) = record();
    let data = AxisData::new(&record);
    let outcome = VelocityEstimateJob::default()
        .evaluate(&data, &Unwatched)
        .unwrap();
    assert_eq!(outcome.quantities()[0].name, "largest_speed");
    support::law_outcome_comes_back(&outcome);
    // A method without an uncertainty, on line.
    let observer: Method = "observer:10,100".parse().unwrap();
    let job = VelocityEstimateJob::new(Some(observer), None);
    support::law_outcome_comes_back(&job.evaluate(&data, &Unwatched).unwrap());
    support::law_outcome_comes_back(
        &VelocityTuneJob::default()
            .evaluate(&data, &Unwatched)
            .unwrap(),
    );
    let job = VelocityCompareJob::new(Vec::new(), vec![1000.0, 100.0], Some(0.5));
    let with = AxisData {
        reference: Some(&truth),
        ..data
    };
    support::law_outcome_comes_back(&job.evaluate(&with, &Unwatched).unwrap());
}

#[test]
fn law_an_onlooker_can_stop_it() {
    let (record, _) = record();
    let data = AxisData::new(&record);
    let troubles = [
        VelocityEstimateJob::default()
            .evaluate(&data, &support::Stop)
            .unwrap_err(),
        VelocityTuneJob::default()
            .evaluate(&data, &support::Stop)
            .unwrap_err(),
        VelocityCompareJob::default()
            .evaluate(&data, &support::Stop)
            .unwrap_err(),
    ];
    for trouble in troubles {
        assert_eq!(trouble.kind(), TroubleKind::Cancelled);
    }
}

#[test]
fn law_requests_are_plain_data() {
    let mut sensors = AxisSensors::default();
    sensors.recording = "axis.csv".into();
    sensors.reading.position = Some(vec!["count".into()]);
    sensors.reading.counts_per_metre = Some(1000.0);
    sensors.acceleration = vec!["acceleration".into()];
    let text = serde_json::to_string(&sensors).unwrap();
    assert_eq!(serde_json::from_str::<AxisSensors>(&text).unwrap(), sensors);
    let job = VelocityCompareJob::new(vec![Method::FixedTime], vec![100.0], None);
    let text = serde_json::to_string(&job).unwrap();
    assert_eq!(
        serde_json::from_str::<VelocityCompareJob>(&text).unwrap(),
        job
    );
}

/// Two files and a reference that never touch a disk.
#[test]
fn law_sensors_are_read_from_memory() {
    let recording = recording();
    let (mut axis, mut truth) = (
        String::from("time_s,count,acceleration_m/s2\n"),
        String::from("time_s,velocity_m/s\n"),
    );
    for (k, count) in recording.count.iter().enumerate() {
        let t = recording.sample_time * k as f64;
        axis += &format!("{t:.3},{},{}\n", count.unwrap(), recording.acceleration[k]);
        truth += &format!("{t:.3},{}\n", recording.truth[k].velocity);
    }
    // A reference that stops after a quarter of the recording.
    let rows = truth.lines().count();
    let half: String = truth
        .lines()
        .take(1 + rows / 4)
        .map(|l| format!("{l}\n"))
        .collect();
    let store = Memory::new()
        .file("axis.csv", axis)
        .file("truth.csv", truth)
        .file("half.csv", half);
    let mut sensors = AxisSensors::default();
    sensors.recording = "axis.csv".into();
    sensors.reading.position = Some(vec!["count".into()]);
    sensors.reading.counts_per_metre = Some(1.0 / recording.increment);
    sensors.acceleration = vec!["acceleration".into()];
    let mut reference = Reference::default();
    reference.column = "velocity".into();
    reference.file = Some("truth.csv".into());
    let loaded = sensors.load(&store, Some(&reference), &Unwatched).unwrap();
    let job = VelocityCompareJob::new(vec![Method::FixedTime], Vec::new(), None);
    let outcome = job.evaluate(&loaded.data(), &Unwatched).unwrap();
    let result = outcome.result();
    assert!(result.reference_is_truth);
    let best = result.rows.iter().map(|r| r.agreement.rms);
    assert!(best.fold(f64::INFINITY, f64::min) < 1e-3);
    assert_eq!(loaded.record(None).inputs.len(), 2);
    let mut half = reference;
    half.file = Some("half.csv".into());
    let short = sensors.load(&store, Some(&half), &Unwatched).unwrap();
    let said = |data: &AxisData<'_>| {
        let cut = data
            .findings
            .iter()
            .find(|f| f.code() == "cut-to-reference");
        cut.map(|f| f.evidence_text().to_owned())
    };
    assert_eq!(said(&loaded.data()), None);
    // Straight lines reach up to its last value.
    let covered = rows / 4;
    assert_eq!(
        said(&short.data()),
        Some(format!("{covered} of {} samples", rows - 1))
    );
    let trouble = sensors.load(&Memory::new(), None, &Unwatched).unwrap_err();
    assert!(trouble.to_string().contains("no such file"), "{trouble}");
}

/// Stop and go with an accelerometer that reads 1.02 times the acceleration, 5.4 ms late, of which 2 ms are stated, on stamps that
/// scatter by a tenth of a step: from the bytes of a file to what stands in the result and in the firmware.
#[test]
fn law_what_was_applied_stands_in_the_result() {
    let sweep = |t: f64| {
        // Out in 0.4 s along sin², and a rest of 0.4 s, in turn with the way back.
        let (w, cycle) = (std::f64::consts::TAU / 0.4, (t / 1.6).floor());
        let s = t - 1.6 * cycle;
        let hop = |s: f64| {
            let s = s.clamp(0.0, 0.4);
            (0.25 * (s - (w * s).sin() / w), 0.25 * w * (w * s).sin())
        };
        let (out, back) = (hop(s - 0.2), hop(s - 1.0));
        (out.0 - back.0, out.1 - back.1)
    };
    let mut axis = String::from("time_s,count,acceleration_m/s2\n");
    let mut state = 1u64;
    let mut uniform = || {
        // Knuth's linear congruential generator.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 9_007_199_254_740_992.0
    };
    let increment = 1.57e-4;
    for k in 0..6000 {
        let t = 1e-3 * f64::from(k);
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let stamp = t + 1e-4 * normal();
        let count = (sweep(t).0 / increment + 0.3).floor();
        let a = 1.02 * sweep(t - 0.0054).1 + 0.05 + 0.02 * normal();
        axis += &format!("{stamp:.7},{count},{a:.6}\n");
    }
    let store = Memory::new().file("axis.csv", axis);
    let mut sensors = AxisSensors::default();
    sensors.recording = "axis.csv".into();
    sensors.reading.position = Some(vec!["count".into()]);
    sensors.reading.counts_per_metre = Some(1.0 / increment);
    sensors.acceleration = vec!["acceleration".into()];
    sensors.latency = 0.002;
    let loaded = sensors.load(&store, None, &Unwatched).unwrap();
    let data = loaded.data();
    let outcome = VelocityEstimateJob::default()
        .evaluate(&data, &Unwatched)
        .unwrap();
    let codes: Vec<&str> = outcome.findings().iter().map(|f| f.code()).collect();
    assert!(codes.contains(&"stamps-scatter"), "{codes:?}");
    assert!(!codes.contains(&"slip"), "{codes:?}");
    let sections = outcome.sections().unwrap();
    let applied = |sections: &[(&str, serde_json::Value)]| {
        let found = sections
            .iter()
            .find(|s| s.0 == "applied")
            .unwrap()
            .1
            .clone();
        ["gain", "latency_s", "stated_latency_s"].map(|name| found[name].as_f64().unwrap())
    };
    let [gain, latency, stated] = applied(&sections);
    // Four standard uncertainties of some 0.0006 and 0.05 ms.
    assert!((gain - 1.02).abs() < 2.5e-3, "{gain}");
    assert!((latency - 0.0054).abs() < 2e-4, "{latency}");
    assert_eq!(stated, 0.002);
    let tuned = VelocityTuneJob::default()
        .evaluate(&data, &Unwatched)
        .unwrap();
    let [gain, latency, _] = applied(&tuned.sections().unwrap());
    assert!((gain - 1.02).abs() < 2.5e-3 && (latency - 0.0054).abs() < 2e-4);
}

/// An accelerometer at 100 Hz in rows at 1 kHz: each of its values stands in ten. The rows with a new one are used, and the interval holds.
#[test]
fn known_accelerometer_that_holds_its_values() {
    const DT: f64 = 1e-3;
    let w = std::f64::consts::TAU;
    let noise = |k: usize| {
        let hash = ((k as f64 * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0);
        (hash - 0.5) * 0.07
    };
    let truth = |t: f64| 0.2 * w * (w * t).cos();
    let mut file = "time_s,position_mm,acceleration_m/s2\n".to_owned();
    for k in 0..8000 {
        let t = DT * k as f64;
        let x = (200.0 * (w * t).sin() / 0.1).round() * 0.1;
        let held = k / 10 * 10;
        let a = -0.2 * w * w * (w * DT * held as f64).sin() + 0.05 + noise(held);
        file += &format!("{t:.3},{x:.1},{a:.6}\n");
    }
    let store = Memory::new().file("axis.csv", file);
    let mut sensors = AxisSensors::default();
    sensors.recording = "axis.csv".into();
    sensors.reading.position = Some(vec!["position_mm".into()]);
    sensors.acceleration = vec!["acceleration".into()];
    let loaded = sensors.load(&store, None, &Unwatched).unwrap();
    let outcome = VelocityEstimateJob::default()
        .evaluate(&loaded.data(), &Unwatched)
        .unwrap();
    let codes: Vec<&str> = outcome.findings().iter().map(|f| f.code()).collect();
    assert!(codes.contains(&"accelerometer-held"), "{codes:?}");
    let (start, step) = outcome.clock();
    assert!((step - 0.01).abs() < 1e-12);
    let smoother = &outcome.result().smoother;
    let u = smoother.standard_uncertainty.as_ref().unwrap();
    let all = 100..smoother.velocity.len();
    let inside = all
        .clone()
        .filter(|&k| (smoother.velocity[k] - truth(start + step * k as f64)).abs() < 1.96 * u[k]);
    let share = inside.count() as f64 / all.len() as f64;
    assert!(share > 0.9, "{share}");
}

/// An accelerometer that never changes has lost nothing that could be given back, whatever it reads, and no result has an infinity.
#[test]
fn law_a_dead_accelerometer_is_told_beside_a_corner() {
    let (record, _) = record();
    for dead in [0.0, 9.80665] {
        for order in [0, 1, 2] {
            let mut record = record.clone();
            record.acceleration.fill(dead);
            record.low_corner =
                (order > 0).then(|| LowCorner::new(0.5, 0.0, order).expect("a corner"));
            let data = AxisData::new(&record);
            let outcome = VelocityEstimateJob::default()
                .evaluate(&data, &Unwatched)
                .unwrap();
            let told = |code: &str| outcome.findings().iter().any(|f| f.code() == code);
            assert!(told("constant-channel"), "{dead}, order {order}");
            support::law_outcome_comes_back(&outcome);
        }
    }
}

#[test]
fn refuses_corners_that_do_not_show_and_rates_that_are_none() {
    let mut text = String::from("time_s,position (m),acceleration_m/s2\n");
    for k in 0..400 {
        let t = 0.01 * f64::from(k);
        text += &format!("{t},{},{}\n", t.sin(), -t.sin());
    }
    let store = Memory::new().file("axis.csv", text);
    let mut sensors = AxisSensors::default();
    sensors.recording = "axis.csv".into();
    sensors.reading.position = Some(vec!["position".into()]);
    sensors.acceleration = vec!["acceleration".into()];
    sensors.low_corner = Some(1e-9);
    let trouble = sensors.load(&store, None, &Unwatched).unwrap_err();
    assert!(
        trouble
            .to_string()
            .contains("--low-corner 1e-9 Hz takes nothing in 4.000 s"),
        "{trouble}"
    );
    let (record, _) = record();
    for rate in [0.0, -1.0, 2.0, f64::NAN] {
        let mut job = VelocityMapJob::new(0.3);
        job.search.false_alarm_rate = rate;
        let trouble = job
            .evaluate(&AxisData::new(&record), &Unwatched)
            .unwrap_err();
        assert!(trouble.to_string().contains("no probability"), "{trouble}");
    }
}

/// Rows of a driven axis: time, count, acceleration. Changed row by row.
fn table(change: impl Fn(usize, i64, f64) -> Option<(i64, f64)>) -> String {
    let recording = recording();
    let mut text = String::from("time_s,count,acceleration_m/s2\n");
    for (k, count) in recording.count.iter().enumerate() {
        let t = recording.sample_time * k as f64;
        if let Some((count, a)) = change(k, count.unwrap(), recording.acceleration[k]) {
            text += &format!("{t:.3},{count},{a}\n");
        }
    }
    text
}

fn counted() -> AxisSensors {
    let mut sensors = AxisSensors::default();
    sensors.recording = "axis.csv".into();
    sensors.reading.position = Some(vec!["count".into()]);
    sensors.reading.counts_per_metre = Some(1.0 / recording().increment);
    sensors.acceleration = vec!["acceleration".into()];
    sensors
}

/// A counter of eight bits that is stated to have more: every command reads it so.
#[test]
fn law_a_stated_width_that_the_counter_does_not_show_is_told() {
    let axis = table(|_, count, a| Some((count.rem_euclid(256), a)));
    let store = Memory::new().file("axis.csv", axis);
    let told = |bits: Option<u32>| {
        let mut sensors = counted();
        sensors.reading.bits = bits;
        let loaded = sensors.load(&store, None, &Unwatched).unwrap();
        let found = loaded.data().findings.iter();
        let mut found = found.filter(|f| f.code() == "rollover-suspected");
        found.next().map(|f| f.advice_text().to_owned())
    };
    assert_eq!(told(Some(8)), None);
    for bits in [None, Some(9), Some(16), Some(32)] {
        let advice = told(bits).unwrap_or_default();
        assert!(advice.contains("--bits 8"), "{bits:?}: {advice}");
    }
    assert!(told(Some(16)).is_some_and(|a| a.contains("not 16")));
}

/// Positions that are positive against the acceleration: the decision names the option, and the option mends it.
#[test]
fn law_readings_of_the_other_sense_are_reversed() {
    let store = Memory::new().file("axis.csv", table(|_, count, a| Some((-count, a))));
    let mut sensors = counted();
    let found = |sensors: &AxisSensors| {
        let loaded = sensors.load(&store, None, &Unwatched).unwrap();
        let outcome = VelocityEstimateJob::default()
            .evaluate(&loaded.data(), &Unwatched)
            .unwrap();
        let opposite = outcome.findings().iter();
        let mut opposite = opposite.filter(|f| f.code() == "opposite-sense");
        let advice = opposite.next().map(|f| f.advice_text().to_owned());
        (advice, outcome.result().pairing.as_ref().unwrap().gain)
    };
    let (advice, gain) = found(&sensors);
    assert!(advice.is_some_and(|a| a.contains("--reverse")) && gain < -0.9);
    sensors.reading.reverse = true;
    let (advice, gain) = found(&sensors);
    assert!(advice.is_none() && gain > 0.9, "{gain}");
}

/// Logic levels in columns that are called A and B as the help calls them, or that are in volts.
#[test]
fn known_headings_of_quadrature() {
    let level = |on: bool| if on { 1 } else { 0 };
    let rows = |heading: &str| {
        let mut text = format!("time_s,{heading},acceleration_m/s2\n");
        for k in 0..400i64 {
            // Each quarter lasts three samples.
            let quarter = (k / 3) % 4;
            let (a, b) = (level(quarter == 1 || quarter == 2), level(quarter >= 2));
            text += &format!(
                "{:.3},{a},{b},{}\n",
                0.001 * k as f64,
                (k * 7919 % 101) as f64
            );
        }
        text
    };
    for (heading, names) in [("A,B", ["A", "B"]), ("A (V),B (V)", ["A", "B"])] {
        let store = Memory::new().file("axis.csv", rows(heading));
        let mut sensors = AxisSensors::default();
        sensors.recording = "axis.csv".into();
        sensors.reading.quadrature = Some(names.map(str::to_owned).to_vec());
        sensors.reading.counts_per_metre = Some(1e5);
        sensors.acceleration = vec!["acceleration".into()];
        let loaded = sensors.load(&store, None, &Unwatched);
        assert!(loaded.is_ok(), "{heading}: {:?}", loaded.err());
    }
}

/// A screw of 5 mm of lead: its counts are those of so many to a metre.
#[test]
fn known_lead_of_a_screw() {
    let store = Memory::new().file("axis.csv", table(|_, count, a| Some((count, a))));
    let linear = counted();
    let mut screw = counted();
    let per_metre = linear.reading.counts_per_metre.unwrap();
    screw.reading.counts_per_metre = None;
    screw.reading.counts_per_turn = Some(0.005 * per_metre);
    screw.reading.lead = Some(0.005);
    let read = |sensors: &AxisSensors| {
        let loaded = sensors.load(&store, None, &Unwatched).unwrap();
        let (data, last) = (loaded.data(), loaded.data().record.reading.len() - 1);
        (data.record.reading[last].unwrap(), data.turn)
    };
    let ((x, _), (y, turn)) = (read(&linear), read(&screw));
    assert!(
        (x / y - 1.0).abs() < 1e-12 && turn == Some(0.005),
        "{x} {y}"
    );
    screw.reading.radius = Some(0.1);
    let trouble = screw.load(&store, None, &Unwatched).unwrap_err();
    assert!(trouble.to_string().contains("--lead"), "{trouble}");
}

/// What was stated of a column is in the line of how it was read.
#[test]
fn known_units_that_were_stated() {
    let recording = recording();
    let mut text = String::from("time_s,way,acceleration_m/s2,yaw\n");
    for (k, x) in recording.position().iter().enumerate() {
        let (t, a) = (recording.sample_time * k as f64, recording.acceleration[k]);
        text += &format!("{t:.3},{},{a},0.01\n", 1e6 * x.unwrap());
    }
    let store = Memory::new().file("axis.csv", text);
    let mut sensors = AxisSensors::default();
    sensors.recording = "axis.csv".into();
    sensors.reading.position = Some(vec!["way".into()]);
    sensors.acceleration = vec!["acceleration".into()];
    let how = |unit: &str, scale: Option<f64>| {
        let mut sensors = sensors.clone();
        sensors.reading.unit = Some(unit.parse().unwrap());
        sensors.reading.scale = scale;
        let loaded = sensors.load(&store, None, &Unwatched).unwrap();
        let read = loaded.data().record.reading.clone();
        let said = loaded.record(None).inputs[0]
            .reading
            .as_ref()
            .unwrap()
            .to_string();
        (said, read)
    };
    let (said, micro) = how("µm", None);
    assert!(said.contains("way in µm as stated"), "{said}");
    let (said, scaled) = how("mm", Some(0.001));
    assert!(
        said.contains("one of which is 0.001 mm as stated"),
        "{said}"
    );
    assert!(!said.contains("not said"), "{said}");
    for (a, b) in micro.iter().flatten().zip(scaled.iter().flatten()) {
        assert!((a - b).abs() < 1e-12);
    }
}

/// Three rows of two thousand are missing: all of the recording is used. Four hundred are: they are left out, and what must be in one piece
/// says which part it is; both are in the verdict.
#[test]
fn law_a_gap_is_told_with_what_is_used() {
    let load = |gap: std::ops::Range<usize>| {
        let store = Memory::new().file(
            "axis.csv",
            table(|k, count, a| (!gap.contains(&k)).then_some((count, a))),
        );
        counted().load(&store, None, &Unwatched).unwrap()
    };
    let estimated = |loaded: &AxisRecordings| {
        let job = VelocityEstimateJob::default();
        job.evaluate(&loaded.data(), &Unwatched).unwrap()
    };
    let short = load(601..604);
    assert!(short.data().recorded.is_none());
    let outcome = estimated(&short);
    assert_eq!(outcome.result().stated().count(), 2001);
    let page = support::page(&outcome);
    assert!(!page.contains("s is used"), "{page}");
    let told = |f: &&Finding| f.code() == "gaps-in-record";
    let told = outcome.findings().iter().find(told).unwrap();
    assert!(told.evidence_text().starts_with("3 of 2001 samples"));

    let long = load(601..1001);
    let outcome = estimated(&long);
    let out = &outcome.result().left_out;
    assert_eq!((out.len(), &out[0]), (1, &(601..1001)));
    let page = support::page(&outcome);
    assert!(page.contains("0.601 s to 1.000 s is left out"), "{page}");
    let tuned = VelocityTuneJob::default();
    let page = support::page(&tuned.evaluate(&long.data(), &Unwatched).unwrap());
    assert!(page.contains("only 1.001 s to"), "{page}");
}

/// The start that is not compared is told beside the winner.
#[test]
fn law_the_start_that_is_left_out_is_told() {
    let (record, truth) = record();
    let data = AxisData {
        reference: Some(&truth),
        ..AxisData::new(&record)
    };
    let job = VelocityCompareJob::default();
    let page = support::page(&job.evaluate(&data, &Unwatched).unwrap());
    assert!(page.contains("the first 0.200 s"), "{page}");
    // The smoother comes closest of all, and is drawn.
    assert!(page.matches("smoother on edges").count() > 1, "{page}");
}

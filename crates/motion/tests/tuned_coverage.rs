//! Whether the stated uncertainty is the true one after tuning: intervals of the velocity on simulated axes whose noise
//! nobody was told.

use proofmass_core::Unwatched;
use proofmass_motion::{EstimateResult, MotionRecord, Source, estimate};
use proofmass_rig::{Axis, AxisMotion, AxisRecording};

/// The record as a user has it, and the true velocity.
fn record(recording: &AxisRecording) -> (MotionRecord, Vec<f64>) {
    let truth = recording.truth.iter().map(|p| p.velocity).collect();
    let mut record = MotionRecord::new(
        recording.sample_time,
        Source::Position,
        recording.position(),
        recording.acceleration.clone(),
    )
    .unwrap();
    record.increment = Some(recording.increment);
    (record, truth)
}

/// Share of the samples after the first second whose 95 % interval holds the truth, and RMS error: filter, smoother.
struct Outcome {
    filter: f64,
    smoother: f64,
    filter_rms: f64,
    smoother_rms: f64,
    result: EstimateResult,
}

fn outcome(axis: &Axis, seed: u64) -> Outcome {
    let (record, truth) = record(&axis.simulate(seed).unwrap());
    let result = estimate(&record, None, None, &Unwatched).unwrap();
    let skip = (1.0 / record.sample_time) as usize;
    let of = |v: &[f64], u: &[f64]| {
        let n = truth.len() - skip;
        let inside = (skip..truth.len())
            .filter(|&k| (v[k] - truth[k]).abs() < 1.959_964 * u[k])
            .count();
        let square: f64 = (skip..truth.len()).map(|k| (v[k] - truth[k]).powi(2)).sum();
        (inside as f64 / n as f64, (square / n as f64).sqrt())
    };
    let u = result.trace.standard_uncertainty.as_deref().unwrap();
    let (filter, filter_rms) = of(&result.trace.velocity, u);
    let u = result.smoother.standard_uncertainty.as_deref().unwrap();
    let (smoother, smoother_rms) = of(&result.smoother.velocity, u);
    Outcome {
        filter,
        smoother,
        filter_rms,
        smoother_rms,
        result,
    }
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count() as f64;
    values.sum::<f64>() / n
}

/// Runs a scenario over seeds and prints it; gives the outcomes.
fn scenario(name: &str, axis: &Axis, seeds: std::ops::Range<u64>) -> Vec<Outcome> {
    let list: Vec<Outcome> = seeds.map(|seed| outcome(axis, seed)).collect();
    let least = |f: &dyn Fn(&Outcome) -> f64| list.iter().map(f).fold(1.0f64, f64::min);
    println!(
        "{name}: filter {:.3} (least {:.3}) rms {:.3e}, smoother {:.3} (least {:.3}) rms {:.3e}",
        mean(list.iter().map(|o| o.filter)),
        least(&|o| o.filter),
        mean(list.iter().map(|o| o.filter_rms)),
        mean(list.iter().map(|o| o.smoother)),
        least(&|o| o.smoother),
        mean(list.iter().map(|o| o.smoother_rms)),
    );
    for o in &list {
        let tuned = o.result.tuned.as_ref().unwrap();
        println!(
            "   {:.3} {:.3} {} sqrt q {:.4} {:?} sqrt R {:.2e} b {:?} g {:?} t {:?} ne {:.0} passes {} {:?}",
            o.filter,
            o.smoother,
            o.result.trace.label,
            tuned.model.acceleration_noise.sqrt(),
            tuned.log_q_interval,
            tuned.model.reading_noise.sqrt(),
            tuned.offset.map(|x| x.value),
            tuned.gain.map(|x| x.value),
            tuned.latency.map(|x| x.value),
            tuned.effective_readings,
            tuned.passes,
            o.result
                .findings
                .iter()
                .map(|f| f.code())
                .collect::<Vec<_>>()
        );
    }
    list
}

#[test]
fn coverage_of_a_motor_after_tuning() {
    for frequency in [5.0, 10.0, 15.0] {
        scenario("motor", &Axis::new(AxisMotion::servo(frequency)), 1..4);
    }
    scenario(
        "oscillation",
        &Axis::new(AxisMotion::damped_oscillation()),
        1..5,
    );
    scenario("ramp", &Axis::new(AxisMotion::ramp()), 1..4);
    let mut axis = Axis::new(AxisMotion::servo(5.0));
    axis.accelerometer.gain_error = 0.02;
    scenario("gain", &axis, 1..3);
    axis.accelerometer.gain_error = 0.0;
    axis.accelerometer.latency = 0.0005;
    scenario("latency 0.5", &axis, 1..3);
    axis.accelerometer.latency = 0.005;
    scenario("latency 5", &axis, 1..3);
    axis.accelerometer.latency = 0.0;
    scenario("vertical", &axis, 1..3);
}

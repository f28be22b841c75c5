//! Whether the stated uncertainty is the true one after tuning: intervals of the velocity on simulated axes whose noise
//! nobody was told.

use proofmass_core::Unwatched;
use proofmass_motion::{EstimateResult, MotionRecord, ReadingSource, estimate};
use proofmass_rig::{AxisMotion, AxisRecording, DrivenAxis};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// The record as a user has it, and the true velocity.
fn record(recording: &AxisRecording) -> (MotionRecord, Vec<f64>) {
    let truth = recording.truth.iter().map(|p| p.velocity).collect();
    let mut record = MotionRecord::new(
        recording.sample_time,
        ReadingSource::Position,
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

fn outcome(axis: &DrivenAxis, seed: u64) -> Outcome {
    let (record, truth) = record(&axis.simulate(seed).unwrap());
    judged(&record, &truth)
}

fn judged(record: &MotionRecord, truth: &[f64]) -> Outcome {
    let result = estimate(record, None, None, &Unwatched).unwrap();
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
fn scenario(name: &str, axis: &DrivenAxis, seeds: std::ops::Range<u64>) -> Vec<Outcome> {
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

/// Five seconds hold some thirty independent values, whose share inside scatters by √(0.05 · 0.95/30) = 0.04; the mean
/// over n seeds by 0.04/√n, and three of that.
fn judge(list: &[Outcome]) {
    let slack = 3.0 * 0.04 / (list.len() as f64).sqrt();
    for coverage in [
        mean(list.iter().map(|o| o.filter)),
        mean(list.iter().map(|o| o.smoother)),
    ] {
        assert!(coverage > 0.95 - slack, "{coverage}");
    }
    // Three deviations of one seed.
    for o in list {
        assert!(
            o.smoother > 0.83 && o.filter > 0.83,
            "{} {}",
            o.filter,
            o.smoother
        );
    }
}

#[test]
fn coverage_of_a_motor_after_tuning() {
    for frequency in [5.0, 10.0, 15.0] {
        let axis = DrivenAxis::new(AxisMotion::servo(frequency));
        let list = scenario("motor", &axis, 1..7);
        judge(&list);
        // A filter that was told everything has 1.3e-4 and 2.5e-4 m/s.
        for o in &list {
            assert!(o.smoother_rms < 2e-4 && o.filter_rms < 4e-4);
            let tuned = o.result.tuned.as_ref().unwrap();
            assert!(tuned.gain.is_none() && tuned.latency.is_none());
        }
    }
}

#[test]
fn coverage_of_an_oscillation_after_tuning() {
    let axis = DrivenAxis::new(AxisMotion::damped_oscillation());
    judge(&scenario("oscillation", &axis, 1..10));
}

#[test]
fn coverage_with_gravity_on_the_axis() {
    let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
    // The largest acceleration is 20 m/s²: the offset is near that of a vertical axis.
    axis.accelerometer.offset = 0.5;
    let list = scenario("vertical", &axis, 1..6);
    judge(&list);
    for o in &list {
        let tuned = o.result.tuned.as_ref().unwrap();
        let q = tuned.model.acceleration_noise.sqrt();
        assert!((0.5..2.0).contains(&(q / 0.02)), "{q}");
        assert!(tuned.offset.unwrap().value > 5.0);
    }
}

#[test]
fn coverage_with_a_gain_error_and_a_latency() {
    let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
    axis.accelerometer.gain_error = 0.02;
    let list = scenario("gain 2 %", &axis, 1..4);
    judge(&list);
    for o in &list {
        let gain = o.result.tuned.as_ref().unwrap().gain.unwrap();
        assert!(
            (gain.value - 1.02).abs() < 3.0 * gain.uncertainty,
            "{gain:?}"
        );
    }
    axis.accelerometer.gain_error = 0.0;
    for late in [0.0005, 0.005, -0.003] {
        axis.accelerometer.latency = late;
        let list = scenario("latency", &axis, 1..4);
        judge(&list);
        for o in &list {
            let latency = o.result.tuned.as_ref().unwrap().latency.unwrap();
            assert!(
                (latency.value - late).abs() < 3.0 * latency.uncertainty,
                "{latency:?}"
            );
            // Uncorrected: 1.9e-3 m/s and more.
            assert!(o.filter_rms < 8e-4, "{}", o.filter_rms);
        }
    }
}

/// Readings with noise of their own and no increment, as of an interpolated encoder: scale of the noise, gain and latency
/// are found together.
#[test]
fn coverage_of_gain_and_latency_without_an_increment() {
    let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
    axis.accelerometer.gain_error = 0.02;
    axis.accelerometer.latency = 0.002;
    let (mut held, mut all) = (0, 0);
    for deviation in [1e-5, 1e-4, 1e-3] {
        let mut filter = Vec::new();
        for seed in 1..13 {
            let recording = axis.simulate(seed).unwrap();
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(1000 + seed);
            let noisy = recording.truth.iter().map(|p| {
                let error: f64 = StandardNormal.sample(&mut rng);
                Some(p.position + deviation * error)
            });
            let record = MotionRecord::new(
                recording.sample_time,
                ReadingSource::Position,
                noisy.collect(),
                recording.acceleration.clone(),
            )
            .unwrap();
            let truth: Vec<f64> = recording.truth.iter().map(|p| p.velocity).collect();
            let outcome = judged(&record, &truth);
            let tuned = outcome.result.tuned.as_ref().unwrap();
            for (found, truth) in [(tuned.gain, 1.02), (tuned.latency, 0.002)] {
                let found = found.unwrap();
                all += 1;
                held += usize::from((found.value - truth).abs() < 1.959_964 * found.uncertainty);
            }
            filter.push(outcome.filter);
        }
        // An error of the gain is in every sample: seeds scatter more than judge() allows, their mean by 0.14/√12.
        let mean = mean(filter.iter().copied());
        println!("readings of {deviation:e} m: filter {mean:.3}, {held} of {all} constants");
        assert!((0.87..0.985).contains(&mean), "{mean}");
    }
    // Binomial: fewer than 62 of 72 once in a thousand.
    assert!(held >= 62 && all == 72, "{held} of {all}");
}

#[test]
fn known_slow_motion_stays_below_the_best_low_pass() {
    // 20 mm/s over increments of 0.94 mm: 47 samples to a count.
    for o in scenario("ramp", &DrivenAxis::new(AxisMotion::ramp()), 1..6) {
        assert!(o.filter_rms < 7e-4 && o.smoother_rms < 5e-4);
        assert!(o.smoother > 0.85 && o.filter > 0.85);
    }
}

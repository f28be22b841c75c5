//! Intervals of methods that state none themselves, and of an encoder without an accelerometer.

use proofmass_core::Unwatched;
use proofmass_motion::{Method, MotionRecord, ReadingSource, estimate};
use proofmass_rig::{AxisMotion, DrivenAxis};

const METHODS: [&str; 13] = [
    "fixed-time",
    "backward-difference:1",
    "backward-difference:3",
    "savitzky-golay:9,2",
    "tracking-loop:100",
    "trapezoid",
    "simpson",
    "newmark:0.5,0.25",
    "zero-phase:0.1,2",
    "two-channel:0,10",
    "observer:10,100",
    "offset-observer:15,75,125",
    "steady-kalman:4e-4,2e-8",
];

fn recordings() -> Vec<(&'static str, MotionRecord, Vec<f64>)> {
    let mut list = Vec::new();
    for (name, motion) in [
        ("oscillation", AxisMotion::damped_oscillation()),
        ("motor 5 Hz", AxisMotion::servo(5.0)),
        ("motor 15 Hz", AxisMotion::servo(15.0)),
    ] {
        for seed in 1..3 {
            let recording = DrivenAxis::new(motion).simulate(seed).unwrap();
            let (x, a) = (recording.position(), recording.acceleration.clone());
            let mut record =
                MotionRecord::new(recording.sample_time, ReadingSource::Position, x, a).unwrap();
            record.increment = Some(recording.increment);
            list.push((
                name,
                record,
                recording.truth.iter().map(|p| p.velocity).collect(),
            ));
        }
    }
    list
}

fn share(velocity: &[f64], u: &[f64], truth: &[f64]) -> f64 {
    let skip = 1000;
    let inside = (skip..truth.len()).filter(|&k| (velocity[k] - truth[k]).abs() < 1.959_964 * u[k]);
    inside.count() as f64 / (truth.len() - skip) as f64
}

/// 95 % intervals of single-sensor and fused methods hold the truth: at 95 % where the error is noise, more often where it is a
/// delay that follows the motion.
#[test]
fn coverage_of_methods_beside_the_smoother() {
    let recordings = recordings();
    for word in METHODS {
        let method: Method = word.parse().unwrap();
        let mut shares = Vec::new();
        for (_, record, truth) in &recordings {
            let mut record = record.clone();
            record.initial_velocity = Some(truth[0]);
            let result = estimate(&record, Some(method), None, &Unwatched).unwrap();
            let u = result.trace.standard_uncertainty.as_ref().unwrap();
            shares.push(share(&result.trace.velocity, u, truth));
        }
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        println!("{word}: {mean:.3} {shares:.3?}");
        assert!(mean > 0.935, "{word}: {shares:?}");
    }
}

/// Counts alone: the acceleration is a random walk, its spread found with the noise. The error is a tenth of that of differences.
#[test]
fn coverage_of_an_encoder_alone() {
    let mut pooled = [0.0; 2];
    let recordings = recordings();
    for (name, record, truth) in &recordings {
        let mut alone = MotionRecord::without_accelerometer(
            record.sample_time,
            ReadingSource::Position,
            record.reading.clone(),
        )
        .unwrap();
        alone.increment = record.increment;
        let result = estimate(&alone, None, None, &Unwatched).unwrap();
        let shares = [&result.trace, &result.smoother].map(|t| {
            let e: f64 = (1000..truth.len())
                .map(|k| (t.velocity[k] - truth[k]).powi(2))
                .sum();
            let rms = (e / (truth.len() - 1000) as f64).sqrt();
            (
                share(&t.velocity, t.standard_uncertainty.as_ref().unwrap(), truth),
                rms,
            )
        });
        let differences = Method::FixedTime.run(&alone).unwrap();
        let e = |k: usize| (differences.velocity[k] - truth[k]).powi(2);
        let plain = ((1000..truth.len()).map(e).sum::<f64>() / (truth.len() - 1000) as f64).sqrt();
        assert!(
            shares[0].1 < 0.5 * plain && shares[1].1 < 0.1 * plain,
            "{name}: {shares:?} {plain}"
        );
        println!(
            "{name}: {} {shares:?} {:?}",
            result.trace.label,
            result.findings.iter().map(|f| f.code()).collect::<Vec<_>>()
        );
        for (sum, share) in pooled.iter_mut().zip(shares) {
            *sum += share.0 / recordings.len() as f64;
        }
    }
    println!("{pooled:?}");
    // A smooth motion is not random: its intervals hold more than they say, never less.
    for share in pooled {
        assert!(share > 0.95, "{pooled:?}");
    }
}
#[test]
fn regress_one_sensor_without_noise_gives_its_speed() {
    /// Position and speed at a time.
    type Course = (fn(f64) -> f64, fn(f64) -> f64);
    let motions: [Course; 4] = [
        (|_| 0.0, |_| 0.0),
        (|t| 0.3 * t, |_| 0.3),
        (|t| 0.25 * t * t, |t| 0.5 * t),
        (|t| t.sin(), |t| t.cos()),
    ];
    for (m, (position, speed)) in motions.into_iter().enumerate() {
        for source in [ReadingSource::Position, ReadingSource::Speed] {
            let at = |k: usize| 0.01 * k as f64;
            let readings = (0..2000).map(|k| {
                Some(match source {
                    ReadingSource::Position => position(at(k)),
                    ReadingSource::Speed => speed(at(k)),
                })
            });
            let record =
                MotionRecord::without_accelerometer(0.01, source, readings.collect()).unwrap();
            let found = estimate(&record, None, None, &Unwatched).unwrap();
            let stated = found.smoother.standard_uncertainty.unwrap();
            for k in 0..2000 {
                let error = found.smoother.velocity[k] - speed(at(k));
                assert!(
                    error.abs() < 4.0 * stated[k] && stated[k] < 0.01,
                    "motion {m}, {source:?}, sample {k}: {error:e} beside {:e}",
                    stated[k]
                );
            }
            assert!(
                !found
                    .findings
                    .iter()
                    .any(|f| f.code() == "likelihood-at-bound")
            );
        }
    }
}

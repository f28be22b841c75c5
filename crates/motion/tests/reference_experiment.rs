//! The reference experiment in simulation: damped oscillation and DC motor, encoder of 500 lines, 16-bit converter,
//! at 1000, 100 and 20 Hz.

use proofmass_core::Unwatched;
use proofmass_motion::{
    Criterion, Filter, IntegratorRule, KalmanModel, Method, MethodRow, MotionRecord, ReadingSource,
    Tuning, agreement, compare, crossover, tune,
};
use proofmass_rig::{AxisMotion, AxisRecording, DrivenAxis};

fn record(recording: &AxisRecording) -> (MotionRecord, Vec<f64>) {
    let truth: Vec<f64> = recording.truth.iter().map(|p| p.velocity).collect();
    let mut record = MotionRecord::new(
        recording.sample_time,
        ReadingSource::Position,
        recording.position(),
        recording.acceleration.clone(),
    )
    .unwrap();
    record.increment = Some(recording.increment);
    record.initial_velocity = Some(truth[0]);
    (record, truth)
}

/// Name without the gains that were found, so that rates share a row.
fn name(row: &MethodRow, published: usize) -> String {
    match row.method {
        Method::Kalman { .. } => "Kalman, tuned".into(),
        Method::Smoother { .. } => "smoother, tuned".into(),
        Method::TwoChannel { .. } if published >= 3 => "two channels, tuned".into(),
        Method::Observer { .. } if published >= 3 => "observer, tuned".into(),
        _ => row.label.clone(),
    }
}

/// Prints the table of `docs/velocity.md`: RMS error in mm/s of every method at every rate.
#[test]
fn law_fused_methods_beat_both_sensors_at_every_rate() {
    for (motion, title, decimations) in [
        (
            AxisMotion::damped_oscillation(),
            "oscillation, 4 Hz",
            &[1, 10, 50][..],
        ),
        (AxisMotion::servo(5.0), "motor, 5 Hz", &[1, 10, 50]),
        (AxisMotion::servo(10.0), "motor, 10 Hz", &[1, 10]),
        (AxisMotion::servo(15.0), "motor, 15 Hz", &[1, 10]),
    ] {
        let mut axis = DrivenAxis::new(motion);
        axis.accelerometer.offset = 0.0005;
        let (record, truth) = record(&axis.simulate(31).unwrap());
        let result = compare(&record, Some(&truth), &[], decimations, 0.5, &Unwatched).unwrap();
        for f in &result.findings {
            println!("{f}");
        }
        let rates: Vec<f64> = decimations.iter().map(|n| 1000.0 / *n as f64).collect();
        let mut table: Vec<(String, Vec<f64>)> = Vec::new();
        for rate in &rates {
            let (mut two, mut observer) = (0, 0);
            for row in result
                .rows
                .iter()
                .filter(|r| (r.rate / rate - 1.0).abs() < 1e-6)
            {
                let seen = match row.method {
                    Method::TwoChannel { .. } => &mut two,
                    Method::Observer { .. } => &mut observer,
                    _ => &mut 0,
                };
                let name = name(row, *seen);
                *seen += 1;
                let rms = 1e3 * row.agreement.rms;
                match table.iter_mut().find(|(n, _)| *n == name) {
                    Some((_, list)) => list.push(rms),
                    None => table.push((name, vec![rms])),
                }
            }
        }
        println!(
            "| {title} | {} |",
            rates
                .iter()
                .map(|r| format!("{r} Hz"))
                .collect::<Vec<_>>()
                .join(" | ")
        );
        for (name, list) in &table {
            let list: Vec<String> = list.iter().map(|v| format!("{v:.2}")).collect();
            println!("| {name} | {} |", list.join(" | "));
        }
        for (k, rate) in rates.iter().enumerate() {
            let of = |wanted: &dyn Fn(&str) -> bool| {
                let inside = table.iter().filter(|(n, _)| wanted(n));
                inside
                    .map(|(_, list)| list[k])
                    .fold(f64::INFINITY, f64::min)
            };
            let single = of(&|n| {
                n.starts_with("fixed") || n.starts_with("Savitzky") || n.starts_with("integration")
            });
            let kalman = of(&|n| n == "Kalman, tuned");
            assert!(
                kalman < 0.8 * single,
                "{title} {rate} Hz: {kalman} {single}"
            );
            for fused in ["two channels, tuned", "observer, tuned"] {
                let rms = of(&|n| n == fused);
                // At four samples per period neither integral is worth much: these two come out even there.
                let even = if motion == AxisMotion::servo(5.0) && *rate < 50.0 {
                    1.1
                } else {
                    1.0
                };
                assert!(
                    rms < even * single,
                    "{title} {rate} Hz {fused}: {rms} {single}"
                );
            }
        }
    }
}

/// One run is one draw: with the truth at hand a search fits the draw as well, so runs are pooled.
///
/// A motor of 15 Hz has no velocity at 20 Hz: it lies beyond half the rate.
#[test]
fn law_tuning_comes_within_ten_per_cent_of_the_best_with_truth() {
    const SEEDS: [u64; 3] = [41, 42, 43];
    for (motion, rates) in [
        (AxisMotion::damped_oscillation(), &[1, 10, 50][..]),
        (AxisMotion::servo(5.0), &[1, 10, 50]),
        (AxisMotion::servo(10.0), &[1, 10]),
        (AxisMotion::servo(15.0), &[1, 10]),
    ] {
        for &n in rates {
            // Kalman: only q/R shapes it; every ratio in steps of an eighth of a decade.
            let ratios: Vec<f64> = (-88..=40).map(|k| 10f64.powf(f64::from(k) / 8.0)).collect();
            let mut exhaustive = vec![0.0; ratios.len()];
            let mut found = [0.0; 3];
            let mut best = [0.0; 3];
            for seed in SEEDS {
                let (full, truth) = record(&DrivenAxis::new(motion).simulate(seed).unwrap());
                let slow = full.decimated(n).unwrap();
                let truth: Vec<f64> = truth.iter().step_by(n).copied().collect();
                let dt = slow.sample_time;
                let skip = (0.5 / dt) as usize;
                let square = |m: &Method| {
                    let v = m.run(&slow).unwrap().velocity;
                    let e = v[skip..].iter().zip(&truth[skip..]);
                    e.map(|(v, t)| (v - t).powi(2)).sum::<f64>() / (v.len() - skip) as f64
                };
                let tuned = tune(&slow, &Tuning::default(), &Unwatched).unwrap();
                println!(
                    "   gain {:?} latency {:?} offset {:?} of {:.0} readings",
                    tuned.tuned.gain.map(|g| g.value),
                    tuned.tuned.latency.map(|t| t.value),
                    tuned.tuned.offset.map(|b| b.value),
                    tuned.tuned.effective_readings
                );
                let r = tuned.tuned.model.reading_noise;
                found[0] += square(&tuned.kalman.method);
                for (sum, ratio) in exhaustive.iter_mut().zip(&ratios) {
                    let model = KalmanModel::new(ratio * r / dt.powi(4), r);
                    *sum += square(&Method::Kalman { model });
                }
                for (k, (filter, gains)) in [
                    (Filter::TwoChannel, tuned.two_channel),
                    (Filter::Observer, tuned.observer),
                ]
                .into_iter()
                .enumerate()
                {
                    let with_truth = Criterion::Reference {
                        velocity: &truth,
                        skip,
                    };
                    best[k + 1] += crossover(filter, with_truth, &slow).unwrap().rms.powi(2);
                    found[k + 1] += square(&gains.method);
                }
            }
            best[0] = exhaustive.iter().copied().fold(f64::INFINITY, f64::min);
            for (k, name) in ["Kalman", "two channels", "observer"]
                .into_iter()
                .enumerate()
            {
                let (f, b): (f64, f64) = (found[k], best[k]);
                let ratio = (f / b).sqrt();
                println!(
                    "{motion:?} {:.0} Hz {name}: {:.6} best {:.6} ({ratio:.3})",
                    1000.0 / n as f64,
                    (f / 3.0).sqrt(),
                    (b / 3.0).sqrt()
                );
                assert!(ratio < 1.1, "{name} {motion:?} {n}: {ratio}");
            }
        }
    }
}

#[test]
fn law_offset_drifts_alone_and_not_fused() {
    // Sustained motion: an oscillation that dies within one increment of the encoder tells nothing of its noise.
    let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
    axis.accelerometer.offset = 0.0005;
    axis.duration = 10.0;
    let recording = axis.simulate(51).unwrap();
    let (with, truth) = record(&recording);
    let dt = with.sample_time;
    let error = |m: &Method, r: &MotionRecord| {
        agreement(&m.run(r).unwrap().velocity, &truth, dt, 500).unwrap()
    };
    let alone = Method::Integration {
        rule: IntegratorRule::Trapezoid,
        offset: 0.0,
    };
    // Random walk of the noise over 10 s: 0.02 √(0.001 · 10) = 2e-3 m/s; its slope is below 4e-4 with 95 %.
    // The trapezoid's own error, (ωT)²/12 = 5e-5 of the velocity, does not drift.
    let drift = error(&alone, &with).drift;
    assert!(
        (drift - recording.offset).abs() < 8e-4,
        "{drift} {}",
        recording.offset
    );
    assert!(recording.offset > 0.01);
    axis.accelerometer.offset = 0.0;
    let (without, _) = record(&axis.simulate(51).unwrap());
    for method in tune(&with, &Tuning::default(), &Unwatched)
        .unwrap()
        .methods()
    {
        let (a, b) = (error(&method, &with), error(&method, &without));
        println!(
            "{}: {:.6} with, {:.6} without, drift {:.2e}",
            method.label(),
            a.rms,
            b.rms,
            a.drift
        );
        // Alone it drifts with the offset itself; what the start leaves behind is not a drift.
        assert!(
            a.drift.abs() < 0.03 * recording.offset,
            "{} {}",
            method.label(),
            a.drift
        );
        // The second-order observer keeps offset · k_x/k_v, the others nothing.
        let kept = match method {
            Method::Observer { k_x, k_v } => recording.offset * k_x / k_v,
            _ => 0.0,
        };
        assert!(
            a.rms < 1.5 * b.rms + kept + 1e-4,
            "{}: {} {} {kept}",
            method.label(),
            a.rms,
            b.rms
        );
    }
}

#[test]
fn law_missing_samples_and_a_slow_encoder_are_carried() {
    let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
    axis.encoder.every = 5;
    axis.encoder.missing = 0.1;
    let (r, truth) = record(&axis.simulate(61).unwrap());
    let tuned = tune(&r, &Tuning::default(), &Unwatched).unwrap();
    for method in tuned.methods() {
        let v = method.run(&r).unwrap().velocity;
        let rms = agreement(&v, &truth, r.sample_time, 500).unwrap().rms;
        println!("{} {rms}", method.label());
        assert!(rms < 0.02, "{} {rms}", method.label()); // of a velocity of 0.65 m/s amplitude
    }
}

#[test]
fn law_a_stationary_start_stays_stationary() {
    let (r, _) = record(
        &DrivenAxis::new(AxisMotion::Standstill)
            .simulate(71)
            .unwrap(),
    );
    for method in [
        Method::TwoChannel { k1: 0.1, k2: 10.0 },
        Method::Observer {
            k_x: 10.0,
            k_v: 50.0,
        },
        Method::Kalman {
            model: KalmanModel::new(4e-4, r.increment.unwrap().powi(2) / 12.0),
        },
    ] {
        let v = method.run(&r).unwrap().velocity;
        // White noise of 0.02 m/s² through a filter of some 0.1 s memory: 0.02 √(0.001 · 0.1) = 2e-4.
        assert!(v.iter().all(|v| v.abs() < 2e-3), "{method:?}");
    }
}

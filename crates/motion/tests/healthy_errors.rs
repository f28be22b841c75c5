//! What a healthy axis has beside noise: a gain that is off by some per cent, a latency of milliseconds, a disc off its axis, stamps
//! that scatter, an even speed. The intervals hold, and slip is found where there is some. The map over all of them is the program
//! `velocity_map` of `proofmass-jobs`.

use crate::motions;
use crate::motions::{Motion, even, s_curve, sine, stop_and_go};
use proofmass_core::Unwatched;
use proofmass_motion::{
    EstimateResult, Method, MotionRecord, ReadingSource, Stamped, estimate, estimate_turning,
    even_rows,
};
use proofmass_uncertainty::Severity;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const DT: f64 = 1e-3;

#[derive(Clone, Copy)]
struct Axis {
    gain: f64,
    latency: f64,
    /// Way of a turn, m, in 2000 counts.
    turn: f64,
    /// Error once per turn, rad.
    disc: f64,
    /// Speed of a slip from 3.0 s to 3.2 s, m/s.
    slip: f64,
}

const HEALTHY: Axis = Axis {
    gain: 1.0,
    latency: 0.0,
    turn: 0.314,
    disc: 0.0,
    slip: 0.0,
};

impl Axis {
    fn increment(&self) -> f64 {
        self.turn / 2000.0
    }

    fn simulate(&self, motion: &Motion, seed: u64) -> (MotionRecord, Vec<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let (phase, start): (f64, f64) = (rng.random(), TAU * rng.random::<f64>());
        let increment = self.increment();
        let (mut reading, mut acceleration, mut truth) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..6000 {
            let t = DT * f64::from(k);
            let [x, v, _] = motion(t);
            let error = self.disc * self.turn / TAU * (TAU * x / self.turn + start).sin();
            let spun = self.slip * (t - 3.0).clamp(0.0, 0.2);
            let seen = ((x + error + spun) / increment + phase).floor() + 0.5;
            let noise: f64 = StandardNormal.sample(&mut rng);
            reading.push(Some(seen * increment));
            acceleration.push(self.gain * motion(t - self.latency)[2] + 0.05 + 0.02 * noise);
            truth.push(v);
        }
        let record = MotionRecord::new(DT, ReadingSource::Position, reading, acceleration);
        let mut record = record.unwrap();
        record.increment = Some(increment);
        (record, truth)
    }
}

/// Share of the samples after the first second inside the smoother's 95 % interval, and its RMS error.
fn judged(result: &EstimateResult, truth: &[f64]) -> (f64, f64) {
    let u = result.smoother.standard_uncertainty.as_ref().unwrap();
    let errors = (1000..truth.len()).map(|k| (result.smoother.velocity[k] - truth[k], u[k]));
    let inside = errors.clone().filter(|(e, u)| e.abs() < 1.96 * u).count();
    let n = (truth.len() - 1000) as f64;
    let square: f64 = errors.map(|(e, _)| e * e).sum();
    (inside as f64 / n, (square / n).sqrt())
}

fn codes(result: &EstimateResult) -> Vec<&str> {
    result.findings.iter().map(|f| f.code()).collect()
}

#[test]
fn coverage_beside_a_gain_and_a_latency_that_pass_for_slip() {
    let mut shares = Vec::new();
    for (gain, latency) in [(1.0, 0.003), (1.0, 0.0054), (1.02, 0.0), (0.98, 0.0078)] {
        for motion in [stop_and_go(0.5, 0.4), s_curve(1.0, 5.0, 100.0)] {
            let axis = Axis {
                gain,
                latency,
                ..HEALTHY
            };
            let (record, truth) = axis.simulate(&motion, 5);
            let result = estimate(&record, None, None, &Unwatched).unwrap();
            assert!(!codes(&result).contains(&"slip"), "{:?}", result.findings);
            let tuned = result.tuned.as_ref().unwrap();
            for (found, due, none) in [(tuned.gain, gain, 1.0), (tuned.latency, latency, 0.0)] {
                match found {
                    Some(f) => assert!((f.value - due).abs() < 4.0 * f.uncertainty, "{f:?}"),
                    None => assert_eq!(due, none),
                }
            }
            let (share, rms) = judged(&result, &truth);
            // A smoother that is told everything errs by 0.10 mm/s.
            assert!(rms < 2e-4, "{rms}");
            shares.push(share);
        }
    }
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    // Five seconds hold some thirty independent values: one share scatters by 0.04, the mean of eight by 0.014, and three of that.
    assert!((0.91..0.995).contains(&mean), "{mean} {shares:?}");
}

#[test]
fn law_slip_is_found_beside_gain_and_latency() {
    let axis = Axis {
        gain: 1.02,
        latency: 0.004,
        slip: 0.3,
        ..HEALTHY
    };
    let (record, _) = axis.simulate(&stop_and_go(0.5, 0.4), 6);
    let result = estimate(&record, None, None, &Unwatched).unwrap();
    let slip = result.slip.unwrap();
    assert!(slip.slips(3000, 0) && slip.slips(3200, 0));
    for e in &slip.slip {
        assert!(e.from > 2900 && e.to < 3300, "{e:?}");
    }
    let tuned = result.tuned.unwrap();
    let (gain, latency) = (tuned.gain.unwrap(), tuned.latency.unwrap());
    assert!((gain.value - 1.02).abs() < 4.0 * gain.uncertainty);
    assert!((latency.value - 0.004).abs() < 4.0 * latency.uncertainty);
}

/// A wheel that rolls nine turns there and back.
#[test]
fn coverage_beside_a_disc_off_its_axis() {
    let motion = stop_and_go(0.4, 0.7);
    let mut shares = Vec::new();
    for (disc, latency) in [(0.002, 0.0), (0.01, 0.0), (0.01, 0.0043)] {
        let axis = Axis {
            turn: 0.0314,
            disc,
            latency,
            ..HEALTHY
        };
        let (record, truth) = axis.simulate(&motion, 7);
        let result = estimate_turning(&record, None, None, Some(axis.turn), &Unwatched).unwrap();
        let codes = codes(&result);
        assert!(codes.contains(&"encoder-map-subtracted"), "{codes:?}");
        assert!(!codes.contains(&"slip"), "{codes:?}");
        let (share, rms) = judged(&result, &truth);
        // With an ideal encoder 0.05 mm/s; with 0.01 rad and no map 1.3 mm/s.
        assert!(rms < 1e-4, "{rms}");
        shares.push(share);
    }
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    // As above, for three.
    assert!(mean > 0.88, "{shares:?}");
}

/// The other motions of the map of axes, thirty records in all: at one in a thousand one has a chance of 0.03.
#[test]
fn known_false_maps_of_ideal_encoders() {
    let mut told = 0;
    for seed in 0..6 {
        for motion in [
            stop_and_go(0.5, 0.4),
            s_curve(1.0, 5.0, 100.0),
            sine(0.2, 1.0),
            sine(0.02, 5.0),
            motions::creeping(0.05),
        ] {
            let (record, _) = HEALTHY.simulate(&motion, 100 + seed);
            let turn = Some(HEALTHY.turn);
            let result = estimate_turning(&record, None, None, turn, &Unwatched).unwrap();
            told += usize::from(codes(&result).contains(&"encoder-map-subtracted"));
        }
    }
    assert!(told <= 1, "{told} of 30");
}

/// 5.01 counts a sample: the rounding of one sample is nearly that of the next, and repeats at 10 Hz.
#[test]
fn regress_counts_that_stand_still_in_phase() {
    for (turn, counts) in [(0.314, 5.01), (0.0314, 5.01), (0.314, 20.01)] {
        let axis = Axis { turn, ..HEALTHY };
        let speed = counts * axis.increment() / DT;
        // Moves of a tenth of a count per sample keep the accelerometer in the estimate.
        let shake = sine(0.02 * axis.increment() / DT, 0.5);
        let motion: Motion = Box::new(move |t| {
            let [x, v, a] = shake(t);
            [speed * t + x, speed + v, a]
        });
        let (record, truth) = axis.simulate(&motion, 8);
        let result = estimate(&record, None, None, &Unwatched).unwrap();
        assert!(matches!(
            result.smoother.method,
            Method::CountingSmoother { .. }
        ));
        let (share, rms) = judged(&result, &truth);
        // What rounding makes as white noise: 0.3 mm/s and more.
        assert!(
            share > 0.85 && rms < 1.5e-4,
            "{turn} {counts}: {share} {rms}"
        );
    }
}

#[test]
fn law_the_encoder_alone_is_taken_where_the_accelerometer_adds_noise() {
    let speed = 7.37 * HEALTHY.increment() / DT;
    let (record, truth) = HEALTHY.simulate(&even(speed), 9);
    let result = estimate(&record, None, None, &Unwatched).unwrap();
    assert!(codes(&result).contains(&"encoder-alone"), "{result:?}");
    let (share, rms) = judged(&result, &truth);
    // Beside the accelerometer 0.08 mm/s.
    assert!(share > 0.9 && rms < 1e-6, "{share} {rms}");
    let (record, _) = HEALTHY.simulate(&stop_and_go(0.5, 0.4), 9);
    let result = estimate(&record, None, None, &Unwatched).unwrap();
    assert!(!codes(&result).contains(&"encoder-alone"));
}

#[test]
fn law_stamps_that_scatter_are_told_from_samples_that_do() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(10);
    let motion = sine(0.02, 5.0);
    let increment = HEALTHY.increment();
    for uneven in [false, true] {
        let (mut stamps, mut value) = (Vec::new(), Vec::new());
        for k in 0..4000 {
            let normal: f64 = StandardNormal.sample(&mut rng);
            let even = DT * f64::from(k);
            let stamp = even + 1e-4 * normal;
            let x = motion(if uneven { stamp } else { even })[0];
            stamps.push(stamp);
            value.push((x / increment).floor() * increment);
        }
        let reading = Stamped {
            time: &stamps,
            value: &value,
        };
        let found = even_rows(&stamps, reading);
        assert_eq!(found.is_none(), uneven);
        if let Some((even, finding)) = found {
            let code = finding.code();
            assert_eq!(code, "stamps-scatter");
            // The mean of 4000 stamps, and their line.
            let off = |k: usize| (even[k] - DT * k as f64).abs();
            assert!(off(0) < 1e-5 && off(3999) < 1e-5);
        }
    }
    let even: Vec<f64> = (0..100).map(|k| DT * f64::from(k)).collect();
    let reading = Stamped {
        time: &even,
        value: &even,
    };
    assert!(even_rows(&even, reading).is_none());
}

/// Readings whose noise lasts for some samples, which no model of a position has.
#[test]
fn known_innovations_that_are_alike() {
    let told = |alike: f64| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
        let motion = sine(0.2, 1.0);
        let mut error = 0.0;
        let (mut reading, mut acceleration) = (Vec::new(), Vec::new());
        for k in 0..6000 {
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            error = alike * error + (1.0 - alike * alike).sqrt() * 1e-4 * normal();
            let [x, _, a] = motion(DT * f64::from(k));
            reading.push(Some(x + error));
            acceleration.push(a + 0.02 * normal());
        }
        let record = MotionRecord::new(DT, ReadingSource::Position, reading, acceleration);
        let result = estimate(&record.unwrap(), None, None, &Unwatched).unwrap();
        codes(&result).contains(&"innovations-correlated")
    };
    assert!(told(0.9) && !told(0.0));
}

/// Words of a counter whose width is stated wrongly: what is left is no rounding that repeats, and the correlation needs a decision.
#[test]
fn known_innovations_of_words_that_jump() {
    let found = |range: Option<f64>| {
        let (mut record, _) = HEALTHY.simulate(&sine(0.2, 1.0), 5);
        let increment = HEALTHY.increment();
        if let Some(range) = range {
            for r in record.reading.iter_mut().flatten() {
                *r = r.rem_euclid(range * increment);
            }
        }
        record.increment = Some(increment);
        let result = estimate(&record, None, None, &Unwatched).unwrap();
        let mut told = result.findings.into_iter();
        let told = told.find(|f| f.code() == "innovations-correlated");
        told.map(|f| f.severity())
    };
    assert!(found(Some(256.0)).is_some_and(|s| s > Severity::Note));
    assert!(found(None).is_none_or(|s| s == Severity::Note));
}

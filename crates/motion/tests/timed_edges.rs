//! Counts whose edges were timed, against the same counts at the samples: noise not told, found from the record.

use proofmass_core::Unwatched;
use proofmass_motion::{EstimateResult, Method, MotionRecord, ReadingSource, estimate, time_edges};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const COUNT: f64 = 0.157e-3;
const DT: f64 = 1e-3;
const N: usize = 12_000;

/// Position, velocity, acceleration at a time.
type Motion = fn(f64) -> [f64; 3];

/// Counts at the samples, the same with edges timed to a microsecond, and the true velocity.
fn axis(motion: Motion, seed: u64, quarters: [f64; 4]) -> (MotionRecord, MotionRecord, Vec<f64>) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let shift: f64 = 0.3 * normal();
    let edge = |n: f64| n + quarters[n.rem_euclid(4.0) as usize];
    let cell = |t: f64| {
        let y = motion(t)[0] / COUNT + shift;
        let n = y.floor();
        if y < edge(n) {
            n - 1.0
        } else if y >= edge(n + 1.0) {
            n + 1.0
        } else {
            n
        }
    };
    let (mut time, mut count) = (vec![0.0], vec![cell(0.0)]);
    let fine = DT / 20.0;
    for k in 1..N * 20 {
        let (mut low, mut high) = (fine * (k - 1) as f64, fine * k as f64);
        let (from, to) = (cell(low), cell(high));
        if from == to {
            continue;
        }
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if cell(middle) == from {
                low = middle;
            } else {
                high = middle;
            }
        }
        time.push((high * 1e6).round() * 1e-6);
        count.push(to);
    }
    let t = |k: usize| DT * k as f64;
    let reading = (0..N).map(|k| Some(cell(t(k)) * COUNT)).collect();
    let acceleration = (0..N)
        .map(|k| motion(t(k))[2] + 0.03 + 0.02 * normal())
        .collect();
    let mut sampled =
        MotionRecord::new(DT, ReadingSource::Position, reading, acceleration).unwrap();
    sampled.increment = Some(COUNT);
    let timed = time_edges(&sampled, &time, &count, COUNT, 1e-6).unwrap();
    (sampled, timed, (0..N).map(|k| motion(t(k))[1]).collect())
}

/// RMS error and share inside 95 % of filter and smoother after the first two seconds.
fn worth(result: &EstimateResult, truth: &[f64]) -> [(f64, f64); 2] {
    [&result.trace, &result.smoother].map(|trace| {
        let u = trace.standard_uncertainty.as_ref().unwrap();
        let inner = 2000..N;
        let n = inner.len() as f64;
        let (mut square, mut inside) = (0.0, 0.0);
        for k in inner {
            let e = trace.velocity[k] - truth[k];
            square += e * e;
            inside += f64::from(u8::from(e.abs() <= 1.96 * u[k]));
        }
        ((square / n).sqrt(), inside / n)
    })
}

/// Pooled over seeds: sampled filter and smoother, timed filter and smoother.
fn pooled(motion: Motion, quarters: [f64; 4]) -> [(f64, f64); 4] {
    let mut sum = [(0.0, 0.0); 4];
    let seeds = 3;
    for seed in 0..seeds {
        let (sampled, timed, truth) = axis(motion, seed, quarters);
        let run = |record: &MotionRecord| estimate(record, None, None, &Unwatched).unwrap();
        let [a, b] = worth(&run(&sampled), &truth);
        let [c, d] = worth(&run(&timed), &truth);
        for (sum, w) in sum.iter_mut().zip([a, b, c, d]) {
            sum.0 += w.0 * w.0 / seeds as f64;
            sum.1 += w.1 / seeds as f64;
        }
    }
    sum.map(|(square, share)| (square.sqrt(), share))
}

fn shown(name: &str, found: &[(f64, f64); 4]) {
    let text = found.map(|(rms, share)| format!("{:.4} ({share:.3})", 1e3 * rms));
    println!("{name}: {}", text.join(", "));
}

const EQUAL: [f64; 4] = [0.0; 4];

fn one_sense(t: f64) -> [f64; 3] {
    // A fifth of a count per sample, ± 20 %.
    let (v, w) = (0.2 * COUNT / DT, TAU * 0.7);
    [
        v * (t - 0.2 / w * (w * t).cos()),
        v * (1.0 + 0.2 * (w * t).sin()),
        v * 0.2 * w * (w * t).cos(),
    ]
}

fn reversing(t: f64) -> [f64; 3] {
    let (v, w) = (0.01, TAU);
    [
        v / w * (w * t).sin(),
        v * (w * t).cos(),
        -v * w * (w * t).sin(),
    ]
}

fn trembling(t: f64) -> [f64; 3] {
    let (x, w) = (0.7 * COUNT, TAU * 7.0);
    [
        x * (w * t).sin(),
        x * w * (w * t).cos(),
        -x * w * w * (w * t).sin(),
    ]
}

#[test]
fn coverage_of_timed_edges_in_one_sense() {
    let found = pooled(one_sense, EQUAL);
    shown("one sense", &found);
    assert!(found[2].0 < found[0].0 / 3.0 && found[3].0 < found[1].0 / 3.0);
    assert!(found[2].1 > 0.93 && found[3].1 > 0.93);
}

#[test]
fn coverage_of_timed_edges_at_reversals() {
    for (name, motion) in [
        ("reversals", reversing as Motion),
        ("trembling", trembling as Motion),
    ] {
        let found = pooled(motion, EQUAL);
        shown(name, &found);
        assert!(found[2].0 < 1.03 * found[0].0 && found[3].0 < 1.03 * found[1].0);
        assert!(found[2].1 > 0.93 && found[3].1 > 0.93);
    }
}

#[test]
fn coverage_of_timed_edges_of_unequal_quarters() {
    let quarters = [0.0, 0.1, 0.0, -0.1];
    for (name, motion) in [
        ("one sense, quarters", one_sense as Motion),
        ("reversals, quarters", reversing as Motion),
    ] {
        let found = pooled(motion, quarters);
        shown(name, &found);
        assert!(found[2].0 < 1.03 * found[0].0);
        assert!(found[2].1 > 0.9 && found[3].1 > 0.9);
    }
}

#[test]
fn law_edges_give_the_methods_that_live_on_them() {
    let (sampled, timed, truth) = axis(one_sense, 5, EQUAL);
    for method in [
        Method::MixedTime { timeout: 0.5 },
        Method::FixedPosition { edges: 4 },
    ] {
        assert!(method.run(&sampled).is_err());
        let trace = method.run(&timed).unwrap();
        assert!(trace.stated_delay > 2e-3 && trace.stated_delay < 0.03);
        // A mean over an interval of five samples or twenty, that much later: the motion changes by 2 % and less.
        let late = (trace.stated_delay / DT).round() as usize;
        for k in 2000..N {
            let e = trace.velocity[k] - truth[k - late];
            assert!(e.abs() < 0.02 * truth[k], "{}: {e} at {k}", trace.label);
        }
    }
}

/// M/T and T have intervals, too: their distance from the smoother, which their delay makes longer than noise would.
#[test]
fn coverage_of_the_methods_that_live_on_edges() {
    for (name, motion) in [
        ("one sense", one_sense as Motion),
        ("reversals", reversing as Motion),
    ] {
        for method in [
            Method::MixedTime { timeout: 0.5 },
            Method::FixedPosition { edges: 4 },
        ] {
            let (_, timed, truth) = axis(motion, 1, EQUAL);
            let result = estimate(&timed, Some(method), None, &Unwatched).unwrap();
            let share = worth(&result, &truth)[0].1;
            println!("{name}, {}: {share:.3}", method.label());
            assert!(share > 0.93, "{name}, {method:?}: {share}");
        }
    }
}

#[test]
fn refuses_edges_that_cannot_be() {
    let (sampled, ..) = axis(one_sense, 1, EQUAL);
    let timed = |time: &[f64], count: &[f64], increment, tick| {
        time_edges(&sampled, time, count, increment, tick).is_err()
    };
    assert!(timed(&[0.0, 1.0], &[0.0], COUNT, 1e-6));
    assert!(timed(&[1.0, 0.5], &[0.0, 1.0], COUNT, 1e-6));
    assert!(timed(&[0.0, f64::NAN], &[0.0, 1.0], COUNT, 1e-6));
    assert!(timed(&[0.0, 1.0], &[0.0, 1.0], 0.0, 1e-6));
    assert!(timed(&[0.0, 1.0], &[0.0, 1.0], COUNT, f64::NAN));
    assert!(timed(&[0.0, 1.0], &[0.0, 1e12], COUNT, 1e-6));
    assert!(timed(&[], &[], COUNT, 1e-6));
}

//! Healthy axes with known truth: how often each finding is given, and whether the intervals after tuning hold what those of a
//! filter hold that was told the noise.
//!
//!     cargo run --release -p proofmass-motion --example healthy_axes -- [SEEDS] [PART OF A NAME]
//!
//! Prints the two tables of docs/velocity.md.

#[path = "../tests/motions/mod.rs"]
mod motions;

use motions::{Motion, hard_stops, s_curve, stop_and_go};
use proofmass_core::Unwatched;
use proofmass_motion::{
    BesideReference, BiasModel, CountingModel, EstimateResult, KalmanModel, Method, MotionRecord,
    ReadingSource, drop_glitches, estimate, rollover,
};
use proofmass_rig::AxisMotion;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Standard deviation of an acceleration sample, m/s².
const NOISE: f64 = 0.02;
/// Arc of the encoder, m.
const RADIUS: f64 = 0.3;

struct Axis {
    name: String,
    motion: Motion,
    lines: f64,
    rate: f64,
    duration: f64,
    /// Offset of the accelerometer, m/s².
    offset: f64,
    /// Time that is not judged: a collision.
    blow: Option<(f64, f64)>,
}

impl Axis {
    fn new(name: &str, motion: Motion) -> Self {
        Self {
            name: name.to_owned(),
            motion,
            lines: 500.0,
            rate: 1000.0,
            duration: 5.0,
            offset: 0.01,
            blow: None,
        }
    }

    /// The record of a seed, and the true velocity.
    fn simulate(&self, seed: u64) -> (MotionRecord, Vec<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let phase: f64 = rng.random();
        let dt = 1.0 / self.rate;
        let increment = TAU * RADIUS / (4.0 * self.lines);
        let n = (self.duration * self.rate) as usize;
        let (mut reading, mut acceleration, mut truth) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..n {
            let [x, v, a] = (self.motion)(dt * k as f64);
            let e: f64 = StandardNormal.sample(&mut rng);
            reading.push(Some(((x / increment + phase).floor() + 0.5) * increment));
            acceleration.push(a + self.offset + NOISE * e);
            truth.push(v);
        }
        let record = MotionRecord::new(dt, ReadingSource::Position, reading, acceleration);
        let mut record = record.expect("a record");
        record.increment = Some(increment);
        (record, truth)
    }
}

fn simulated(motion: AxisMotion) -> Motion {
    Box::new(move |t| {
        let p = motion.at(t);
        [p.position, p.velocity, p.acceleration]
    })
}

fn scenarios() -> Vec<Axis> {
    let mut list = vec![
        Axis::new(
            "oscillation, 4 Hz",
            simulated(AxisMotion::damped_oscillation()),
        ),
        Axis::new("motor, 5 Hz", simulated(AxisMotion::servo(5.0))),
        Axis::new("motor, 10 Hz", simulated(AxisMotion::servo(10.0))),
        Axis::new("motor, 15 Hz", simulated(AxisMotion::servo(15.0))),
        Axis::new("ramp to 20 mm/s", simulated(AxisMotion::ramp())),
        Axis::new("stop and go, 0.5 m/s", stop_and_go(0.5, 0.4)),
        Axis::new("stop and go, 20 mm/s", stop_and_go(0.02, 0.4)),
        Axis::new("stop and go of 80 ms, 0.5 m/s", stop_and_go(0.5, 0.08)),
        Axis::new("hard stops, 0.3 m/s", hard_stops(0.3, 1, 60.0)),
        Axis {
            lines: 5000.0,
            ..Axis::new(
                "hard stops, 0.05 m/s, 5000 lines",
                hard_stops(0.05, 1, 60.0),
            )
        },
        Axis::new("S-curve, 1 m/s", s_curve(1.0, 5.0, 100.0)),
        Axis {
            offset: 9.81,
            ..Axis::new("vertical axis, S-curve", s_curve(1.0, 5.0, 100.0))
        },
        Axis {
            offset: 9.81,
            ..Axis::new(
                "vertical axis, motor 5 Hz",
                simulated(AxisMotion::servo(5.0)),
            )
        },
        Axis {
            blow: Some((0.99, 1.1)),
            ..Axis::new("impact", simulated(AxisMotion::impact()))
        },
    ];
    for lines in [100.0, 2500.0, 10_000.0] {
        list.push(Axis {
            lines,
            ..Axis::new(
                &format!("oscillation, {lines} lines"),
                simulated(AxisMotion::damped_oscillation()),
            )
        });
        list.push(Axis {
            lines,
            ..Axis::new(&format!("S-curve, {lines} lines"), s_curve(1.0, 5.0, 100.0))
        });
        list.push(Axis {
            lines,
            ..Axis::new(
                &format!("stop and go, {lines} lines"),
                stop_and_go(0.5, 0.4),
            )
        });
    }
    for (rate, duration) in [(100.0, 20.0), (20.0, 60.0)] {
        list.push(Axis {
            rate,
            duration,
            ..Axis::new(
                &format!("stop and go of 2 s, {rate} Hz"),
                stop_and_go(0.5, 2.0),
            )
        });
        list.push(Axis {
            rate,
            duration,
            ..Axis::new(&format!("S-curve, {rate} Hz"), s_curve(1.0, 1.0, 2.0))
        });
    }
    list.push(Axis {
        rate: 100.0,
        ..Axis::new(
            "oscillation, 100 Hz",
            simulated(AxisMotion::damped_oscillation()),
        )
    });
    list.push(Axis {
        rate: 20.0,
        duration: 20.0,
        ..Axis::new(
            "oscillation, 20 Hz",
            simulated(AxisMotion::damped_oscillation()),
        )
    });
    list.push(Axis {
        rate: 100.0,
        ..Axis::new("motor 5 Hz, 100 Hz", simulated(AxisMotion::servo(5.0)))
    });
    list
}

/// Shares inside the 95 % interval, and mean square errors.
#[derive(Clone, Copy, Default)]
struct Judged {
    inside: f64,
    square: f64,
}

fn judged(axis: &Axis, v: &[f64], u: &[f64], truth: &[f64]) -> Judged {
    let dt = 1.0 / axis.rate;
    let (mut inside, mut square, mut n) = (0.0, 0.0, 0.0);
    let blown = |t: f64| axis.blow.is_some_and(|(from, to)| t > from && t < to);
    for k in (axis.rate as usize)..truth.len() {
        if blown(dt * k as f64) {
            continue;
        }
        let e = (v[k] - truth[k]).abs();
        inside += f64::from(u8::from(e < 1.959_964 * u[k]));
        square += e * e;
        n += 1.0;
    }
    Judged {
        inside: inside / n,
        square: square / n,
    }
}

/// Filter and smoother after tuning, and of a filter that was told the noise.
fn run(axis: &Axis, seed: u64) -> ([Judged; 4], EstimateResult, Vec<String>) {
    let (mut record, truth) = axis.simulate(seed);
    let counts: Vec<i64> = record
        .reading
        .iter()
        .flatten()
        .map(|x| (x / record.increment.unwrap_or(1.0)).floor() as i64)
        .collect();
    let mut codes: Vec<String> = rollover(&counts, None)
        .iter()
        .map(|f| f.code().to_owned())
        .collect();
    codes.extend(
        drop_glitches(&mut record)
            .iter()
            .map(|f| f.code().to_owned()),
    );
    let result = estimate(&record, None, None, &Unwatched).expect("an estimate");
    codes.extend(result.findings.iter().map(|f| f.code().to_owned()));
    let skip = axis.rate as usize;
    let beside = BesideReference::of(
        &result.smoother.velocity[skip..],
        &truth[skip..],
        1.0 / axis.rate,
    );
    let beside = beside.and_then(|b| b.finding());
    if let (Some(_), Some(f)) = (std::env::var_os("TOLD"), &beside) {
        println!("      {}: {}", axis.name, f.evidence_text());
    }
    codes.extend(beside.map(|f| f.code().to_owned()));
    codes.sort();
    codes.dedup();
    let told = match result.trace.method {
        Method::Counting { .. } => {
            let model = CountingModel {
                acceleration_noise: NOISE * NOISE,
                edge: 1e-6,
                offset: 3.0 * axis.offset.abs() + 0.1,
                walk: 0.0,
            };
            [
                Method::Counting { model },
                Method::CountingSmoother { model },
            ]
        }
        _ => {
            let increment = record.increment.unwrap_or(0.0);
            let model = KalmanModel {
                bias: Some(BiasModel::RandomWalk {
                    density: 0.0,
                    initial: 3.0 * axis.offset.abs() + 0.1,
                }),
                interpolation: result.model.interpolation,
                ..KalmanModel::new(NOISE * NOISE, increment * increment / 12.0)
            };
            [Method::Kalman { model }, Method::Smoother { model }]
        }
    };
    let of = |v: &[f64], u: &Option<Vec<f64>>| {
        judged(axis, v, u.as_deref().expect("uncertainties"), &truth)
    };
    let told = told.map(|m| m.run(&record).expect("a filter that was told"));
    let all = [
        of(&result.trace.velocity, &result.trace.standard_uncertainty),
        of(
            &result.smoother.velocity,
            &result.smoother.standard_uncertainty,
        ),
        of(&told[0].velocity, &told[0].standard_uncertainty),
        of(&told[1].velocity, &told[1].standard_uncertainty),
    ];
    (all, result, codes)
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(20);
    let wanted = arguments.next().unwrap_or_default();
    let mut list = scenarios();
    list.retain(|a| a.name.contains(&wanted));
    let mut alarms: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    println!(
        "| axis | filter: share (told), runs below 0.9 (told), error over told | smoother: the same | q over truth: lower, middle, upper |"
    );
    println!("|---|---|---|---|");
    for axis in &list {
        let found = motions::of_seeds(seeds, |seed| run(axis, seed));
        let n = found.len() as f64;
        let mean = |i: usize| found.iter().map(|f| f.0[i].inside).sum::<f64>() / n;
        let low = |i: usize| found.iter().filter(|f| f.0[i].inside < 0.9).count();
        let rms = |i: usize| (found.iter().map(|f| f.0[i].square).sum::<f64>() / n).sqrt();
        let mut q: Vec<f64> = found
            .iter()
            .filter_map(|f| f.1.tuned.as_ref())
            .map(|t| t.model.acceleration_noise.sqrt() / NOISE)
            .collect();
        q.sort_by(f64::total_cmp);
        let cell = |i: usize| {
            format!(
                "{:.3} ({:.3}), {} ({}), {:.3} mm/s, × {:.3}",
                mean(i),
                mean(i + 2),
                low(i),
                low(i + 2),
                1e3 * rms(i),
                rms(i) / rms(i + 2)
            )
        };
        println!(
            "| {} | {} | {} | {:.2} {:.2} {:.2} |",
            axis.name,
            cell(0),
            cell(1),
            q.first().unwrap_or(&0.0),
            q.get(q.len() / 2).unwrap_or(&0.0),
            q.last().unwrap_or(&0.0)
        );
        for (_, result, codes) in &found {
            if std::env::var_os("TOLD").is_some() {
                let tuned = result.tuned.as_ref();
                println!(
                    "    n_e {:.0} q {:?} R {:?} b {:?} g {:?} t {:?} floor {:?} w {:?} agree {:?}",
                    tuned.map_or(0.0, |t| t.effective_readings),
                    tuned.map(|t| t.model.acceleration_noise.sqrt()),
                    tuned.map(|t| t.model.reading_noise.sqrt()),
                    tuned.and_then(|t| t.offset),
                    tuned.and_then(|t| t.gain),
                    tuned.and_then(|t| t.latency),
                    tuned.and_then(|t| t.noise_floor).map(f64::sqrt),
                    tuned.map(|t| t.whiteness.mean_square),
                    result.agreement
                );
                for f in &result.findings {
                    println!("      {}: {}", f.code(), f.evidence_text());
                }
            }
            for code in codes {
                *alarms
                    .entry(code.clone())
                    .or_default()
                    .entry(axis.name.clone())
                    .or_default() += 1;
            }
        }
    }
    let all = seeds as usize * list.len();
    println!("\nOf {all} records:\n\n| finding | records | per cent | where |\n|---|---|---|---|");
    for (code, places) in &alarms {
        let n: usize = places.values().sum();
        let mut places: Vec<_> = places.iter().collect();
        places.sort_by(|a, b| b.1.cmp(a.1));
        let places: Vec<String> = places.iter().map(|(p, n)| format!("{p}: {n}")).collect();
        println!(
            "| `{code}` | {n} | {:.2} | {} |",
            100.0 * n as f64 / all as f64,
            places.join("; ")
        );
    }
}

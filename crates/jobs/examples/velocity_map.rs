//! Healthy axes as they are found: an accelerometer whose gain is off by some per cent and that is late by milliseconds, a disc off
//! its axis, stamps that jitter. How often the intervals of `velocity estimate` hold the truth, what it errs beside others, and
//! which findings it gives, all by its own door, from the bytes of a file.
//!
//!     cargo run --release --workspace --example velocity_map -- [SEEDS] [PART OF A NAME]
//!
//! Prints the tables of docs/velocity.md. `TOLD=1` prints every record.

#[path = "../../motion/tests/motions/mod.rs"]
mod motions;

use motions::{
    HighPass, Motion, STEP, creeping, even, hand, hard_stops, nearly_even, s_curve, sine,
    stop_and_go,
};
use proofmass_core::Unwatched;
use proofmass_jobs::velocity::{AxisSensors, VelocityEstimate, VelocityEstimateJob};
use proofmass_jobs::{Job, Memory, Outcome};
use proofmass_motion::{
    BiasModel, CountingModel, EstimateResult, IntegratorRule, KalmanModel, Method, MotionRecord,
    OffLineIntegration, ReadingSource, integrate,
};
use proofmass_uncertainty::{Finding, Severity};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Standard deviation of an acceleration sample, m/s².
const NOISE: f64 = 0.02;
/// Offset of the accelerometer, m/s².
const OFFSET: f64 = 0.05;
/// Sample time, s.
const DT: f64 = 1e-3;

/// What a log loses.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lost {
    Nothing,
    /// Share of the accelerations that are empty cells.
    Cells(f64),
    /// Share of the rows.
    Rows(f64),
    /// Bursts of so many rows.
    Bursts(usize, usize),
    /// Rows at one place, sixty hundredths from the start.
    Gap(usize),
}

impl Lost {
    /// Whether the row and the acceleration of each sample are there.
    fn kept(self, n: usize, seed: u64) -> Vec<(bool, bool)> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x1057);
        let mut kept = vec![(true, true); n];
        match self {
            Self::Nothing => {}
            Self::Cells(share) => kept.iter_mut().for_each(|k| k.1 = !rng.random_bool(share)),
            Self::Rows(share) => kept.iter_mut().for_each(|k| k.0 = !rng.random_bool(share)),
            Self::Bursts(count, rows) => {
                for _ in 0..count {
                    let from = rng.random_range(1..n - rows - 1);
                    kept[from..from + rows].fill((false, false));
                }
            }
            Self::Gap(rows) => kept[n * 6 / 10..n * 6 / 10 + rows].fill((false, false)),
        }
        kept
    }
}

/// An axis with the errors that a healthy one has.
#[derive(Clone)]
pub struct Cell {
    /// What it is called.
    pub name: String,
    motion: &'static str,
    /// Counts per turn, and radius of the wheel, m.
    counts: f64,
    radius: f64,
    duration: f64,
    gain: f64,
    /// Time by which the accelerometer is late, s.
    latency: f64,
    /// Amplitude of the error once per turn, rad.
    disc: f64,
    /// Corner below which the accelerometer shows less, Hz; zero where it measures down to zero.
    corner: f64,
    /// Stages of the corner. That of one is not stated, that of two is.
    stages: u8,
    /// Rows in which each value of the accelerometer stands.
    held: usize,
    /// Standard deviation of a stamp over the sample time.
    jitter: f64,
    /// Whether it is the samples that are taken at uneven times, with true stamps, and not the stamps that err.
    uneven: bool,
    /// Whether gain, latency, disc and jitter of each record are drawn.
    drawn: bool,
    /// What the log loses.
    lost: Lost,
}

fn motion_of(name: &str, seed: u64) -> Motion {
    match name {
        "stop and go" => stop_and_go(0.5, 0.4),
        "hand" => hand(2.0, 7000 + seed),
        "S-curve" => s_curve(1.0, 5.0, 100.0),
        "hard stops" => hard_stops(0.3, 300 + seed, 60.0),
        "sine, 5 Hz" => sine(0.02, 5.0),
        "sine, 1 Hz" => sine(0.2, 1.0),
        "creeping" => creeping(0.05),
        "nearly even" => nearly_even(0.5, 0.1),
        "wheel" => stop_and_go(0.4, 0.7),
        _ => panic!("no such motion: {name}"),
    }
}

/// Counts per sample of an even motion, from the name.
fn even_counts(name: &str) -> Option<f64> {
    name.strip_prefix("even, ")?.parse().ok()
}

impl Cell {
    fn new(motion: &'static str, gain: f64, latency: f64) -> Self {
        Self {
            name: format!("{motion}, gain {gain}, {} ms", 1e3 * latency),
            motion,
            counts: 2000.0,
            radius: 0.05,
            duration: 8.0,
            gain,
            latency,
            disc: 0.0,
            corner: 0.0,
            stages: 1,
            held: 1,
            jitter: 0.0,
            uneven: false,
            drawn: false,
            lost: Lost::Nothing,
        }
    }

    /// What a seed makes of a cell whose errors are drawn.
    fn of_seed(&self, seed: u64) -> Self {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5eed);
        match self.drawn {
            false => self.clone(),
            true => Self {
                gain: rng.random_range(0.97..1.03),
                latency: rng.random_range(0.0..0.01),
                // Over a tenth of a turn a disc is a gain of the encoder, which nothing tells.
                disc: match self.motion {
                    "sine, 5 Hz" => 0.0,
                    _ => rng.random_range(0.0..0.01) * f64::from(u8::from(rng.random_bool(0.5))),
                },
                jitter: 0.1 * f64::from(u8::from(rng.random_bool(0.25))),
                ..self.clone()
            },
        }
    }

    fn increment(&self) -> f64 {
        TAU * self.radius / self.counts
    }

    fn motion(&self, seed: u64) -> Motion {
        match even_counts(self.motion) {
            Some(counts) => even(counts * self.increment() / DT),
            None => motion_of(self.motion, seed),
        }
    }

    /// The file, what an oracle reads (the same noise, and none of the errors), and the true velocity.
    fn simulate(&self, seed: u64) -> (String, MotionRecord, Vec<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let phase: f64 = rng.random();
        let turn: f64 = TAU * rng.random::<f64>();
        let increment = self.increment();
        let motion = self.motion(seed);
        let n = (self.duration / DT) as usize;
        let (mut shown, mut clock) = (0.0, 0.0);
        let late = |t: f64| motion(t - self.latency)[2];
        let mut first = HighPass::new(self.corner, late(0.0));
        let mut second = HighPass::new(self.corner, late(0.0));
        let mut file = String::from("time_s,count,acceleration_m/s2\n");
        let (mut reading, mut right, mut truth) = (Vec::new(), Vec::new(), Vec::new());
        let kept = self.lost.kept(n, seed);
        for k in 0..n {
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            let (even, noise) = (DT * k as f64, NOISE * normal());
            let off = self.jitter * DT * normal();
            let at = if self.uneven { even + off } else { even };
            let stamp = if self.jitter > 0.0 { even + off } else { even };
            let [x, ..] = motion(at);
            let angle = x / self.radius;
            let seen = x + self.radius * self.disc * ((angle + turn).sin() - turn.sin());
            let count = (seen / increment + phase).floor();
            let mut passed = late(at);
            if self.corner > 0.0 {
                while clock + 0.5 * STEP < at {
                    clock += STEP;
                    let one = first.pass(late(clock));
                    passed = if self.stages > 1 {
                        second.pass(one)
                    } else {
                        one
                    };
                }
            }
            if k % self.held == 0 {
                shown = self.gain * passed + OFFSET + noise;
            }
            let a = shown;
            match kept[k] {
                (true, true) => file += &format!("{stamp:.7},{count},{a:.6}\n"),
                (true, false) => file += &format!("{stamp:.7},{count},\n"),
                _ => {}
            }
            let [x, v, a] = motion(even);
            reading.push(Some(((x / increment + phase).floor() + 0.5) * increment));
            right.push(a + OFFSET + noise);
            truth.push(v);
        }
        let record = MotionRecord::new(DT, ReadingSource::Position, reading, right);
        let mut record = record.expect("a record");
        record.increment = Some(increment);
        (file, record, truth)
    }

    fn sensors(&self, alone: bool) -> AxisSensors {
        let mut sensors = AxisSensors::default();
        sensors.recording = "axis.csv".into();
        sensors.reading.position = Some(vec!["count".into()]);
        sensors.reading.counts_per_turn = Some(self.counts);
        sensors.reading.radius = Some(self.radius);
        if !alone {
            sensors.acceleration = vec!["acceleration".into()];
        }
        if self.stages > 1 && !alone {
            sensors.low_corner = Some(self.corner);
            sensors.low_corner_order = Some(self.stages);
        }
        sensors
    }
}

/// The cells: first those that were found to fail, then a thinned grid of all errors together.
pub fn cells() -> Vec<Cell> {
    let mut list = Vec::new();
    for motion in ["stop and go", "hand", "S-curve", "sine, 5 Hz"] {
        for (gain, latency) in [
            (1.0, 0.0),
            (1.0, 3e-3),
            (1.0, 5e-3),
            (1.02, 0.0),
            (0.98, 8e-3),
        ] {
            list.push(Cell::new(motion, gain, latency));
        }
    }
    for motion in ["hard stops", "sine, 1 Hz", "creeping", "nearly even"] {
        for (gain, latency) in [(1.0, 0.0), (1.03, 4e-3)] {
            list.push(Cell::new(motion, gain, latency));
        }
    }
    for motion in [
        "even, 5.01",
        "even, 10.01",
        "even, 20.01",
        "even, 7.37",
        "even, 0.31",
    ] {
        list.push(Cell::new(motion, 1.0, 0.0));
    }
    // An increment so fine that a rounding that repeats at 10 Hz is not smoothed away.
    for motion in ["even, 5.01", "even, 20.01"] {
        list.push(Cell {
            name: format!("{motion}, fine"),
            counts: 20_000.0,
            ..Cell::new(motion, 1.0, 0.0)
        });
    }
    // A wheel of a centimetre that rolls nine turns there and back.
    for disc in [0.0, 0.002, 0.01] {
        for (gain, latency) in [(1.0, 0.0), (1.02, 4e-3)] {
            list.push(Cell {
                name: format!("wheel, disc {disc} rad, gain {gain}, {} ms", 1e3 * latency),
                radius: 0.005,
                disc,
                ..Cell::new("wheel", gain, latency)
            });
        }
    }
    for motion in ["stop and go", "hand", "sine, 5 Hz"] {
        for uneven in [false, true] {
            let what = if uneven { "samples" } else { "stamps" };
            list.push(Cell {
                name: format!("{motion}, {what} jitter by 10 %"),
                jitter: 0.1,
                uneven,
                ..Cell::new(motion, 1.0, 0.0)
            });
        }
    }
    for motion in ["stop and go", "hand", "S-curve"] {
        for held in [5, 10] {
            list.push(Cell {
                name: format!("{motion}, held for {held} rows"),
                held,
                ..Cell::new(motion, 1.0, 0.0)
            });
        }
    }
    for motion in ["stop and go", "hand", "S-curve", "sine, 5 Hz"] {
        for (what, lost) in [
            ("1 % of the cells empty", Lost::Cells(0.01)),
            ("5 % of the cells empty", Lost::Cells(0.05)),
            ("half of the cells empty", Lost::Cells(0.5)),
            ("1 % of the rows lost", Lost::Rows(0.01)),
            ("20 bursts of 10 rows lost", Lost::Bursts(20, 10)),
            ("3 ms lost", Lost::Gap(3)),
            ("50 ms lost", Lost::Gap(50)),
            ("1 s lost", Lost::Gap(1000)),
        ] {
            list.push(Cell {
                name: format!("{motion}, {what}"),
                lost,
                ..Cell::new(motion, 1.0, 0.0)
            });
        }
    }
    for motion in ["stop and go", "hand", "S-curve", "hard stops", "sine, 1 Hz"] {
        for corner in [0.05, 0.1, 0.2, 0.5, 1.0, 2.0] {
            list.push(Cell {
                name: format!("{motion}, corner {corner} Hz"),
                corner,
                ..Cell::new(motion, 1.0, 0.0)
            });
        }
    }
    for motion in ["stop and go", "hand", "S-curve", "hard stops", "sine, 1 Hz"] {
        for corner in [0.05, 0.5, 2.0] {
            list.push(Cell {
                name: format!("{motion}, two stages at {corner} Hz"),
                corner,
                stages: 2,
                duration: 20.0,
                ..Cell::new(motion, 1.0, 0.0)
            });
        }
    }
    for motion in [
        "stop and go",
        "hand",
        "S-curve",
        "hard stops",
        "sine, 5 Hz",
        "sine, 1 Hz",
        "creeping",
        "nearly even",
        "wheel",
    ] {
        list.push(Cell {
            name: format!("{motion}, all errors drawn"),
            radius: if motion == "wheel" { 0.005 } else { 0.05 },
            drawn: true,
            ..Cell::new(motion, 1.0, 0.0)
        });
    }
    list
}

/// Share inside the 95 % interval, and mean square error, after the first second.
#[derive(Clone, Copy, Default)]
pub struct Judged {
    /// Share of the samples.
    pub inside: f64,
    /// m²/s².
    pub square: f64,
}

fn judged(v: &[f64], u: Option<&[f64]>, truth: &[f64], step: f64) -> Judged {
    let n = v.len().min(truth.len());
    let from = (1.0 / step) as usize;
    let mut sum = Judged::default();
    for k in from..n {
        let e = (v[k] - truth[k]).abs();
        sum.inside += f64::from(u8::from(u.is_some_and(|u| e < 1.959_964 * u[k])));
        sum.square += e * e;
    }
    let count = (n - from) as f64;
    Judged {
        inside: sum.inside / count,
        square: sum.square / count,
    }
}

/// The low-pass of the readings' differences, forwards and back, that is nearest to the truth.
fn best_low_pass(record: &MotionRecord, truth: &[f64]) -> f64 {
    let x: Vec<f64> = record.reading.iter().flatten().copied().collect();
    let n = x.len();
    let rate: Vec<f64> = (0..n)
        .map(|k| {
            let (a, b) = (k.saturating_sub(1), (k + 1).min(n - 1));
            (x[b] - x[a]) / ((b - a) as f64 * DT)
        })
        .collect();
    let corners = (0..24).map(|i| 1.0 * 200f64.powf(f64::from(i) / 23.0));
    let of = |corner: f64| {
        let w = (TAU * 0.5 * corner * DT).tan();
        let norm = 1.0 / (1.0 + 2f64.sqrt() * w + w * w);
        let (b, a1, a2) = (
            w * w * norm,
            2.0 * (w * w - 1.0) * norm,
            (1.0 - 2f64.sqrt() * w + w * w) * norm,
        );
        let run = |x: &[f64]| -> Vec<f64> {
            let (mut x1, mut x2, mut y1, mut y2) = (x[0], x[0], x[0], x[0]);
            x.iter()
                .map(|&x0| {
                    let y = b * (x0 + 2.0 * x1 + x2) - a1 * y1 - a2 * y2;
                    (x2, x1, y2, y1) = (x1, x0, y1, y);
                    y
                })
                .collect()
        };
        let mut y = run(&rate);
        y.reverse();
        y = run(&y);
        y.reverse();
        judged(&y, None, truth, DT).square
    };
    corners.map(of).fold(f64::INFINITY, f64::min)
}

/// The integral of the accelerometer behind the high-pass, forwards and back, that is nearest to the truth.
fn best_integrator(record: &MotionRecord, truth: &[f64]) -> f64 {
    let corners = (0..24).map(|i| 0.02 * 500f64.powf(f64::from(i) / 23.0));
    let of = |corner: f64| {
        let method = OffLineIntegration::ZeroPhase {
            rule: IntegratorRule::Trapezoid,
            order: 2,
            corner,
        };
        integrate(&record.acceleration, record.sample_time, None, method)
            .map_or(f64::INFINITY, |v| {
                judged(&v, None, truth, record.sample_time).square
            })
    };
    corners.map(of).fold(f64::INFINITY, f64::min)
}

/// The smoother of one that was told everything.
fn oracle(record: &MotionRecord, result: &EstimateResult, truth: &[f64]) -> f64 {
    let method = match result.smoother.method {
        Method::CountingSmoother { .. } => Method::CountingSmoother {
            model: CountingModel {
                acceleration_noise: NOISE * NOISE,
                edge: 1e-6,
                offset: 0.2,
                walk: 0.0,
            },
        },
        _ => {
            let increment = record.increment.unwrap_or(0.0);
            Method::Smoother {
                model: KalmanModel {
                    bias: Some(BiasModel::RandomWalk {
                        density: 0.0,
                        initial: 0.2,
                    }),
                    ..KalmanModel::new(NOISE * NOISE, increment * increment / 12.0)
                },
            }
        }
    };
    let run = method.run(record).expect("one that was told");
    judged(&run.velocity, None, truth, DT).square
}

/// What one record gave.
pub struct One {
    /// The filter.
    pub filter: Judged,
    /// The smoother.
    pub smoother: Judged,
    /// Samples whose velocity is stated.
    pub stated: usize,
    oracle: f64,
    alone: f64,
    low_pass: f64,
    /// Mean square error of the best integrator behind a high-pass.
    pub integrator: f64,
    /// Codes of what was found.
    pub findings: Vec<(String, Severity)>,
}

/// One record; nothing where it is refused.
pub fn run(cell: &Cell, seed: u64) -> Option<One> {
    let cell = &cell.of_seed(seed);
    let (file, right, truth) = cell.simulate(seed);
    let store = Memory::new().file("axis.csv", file);
    let told = std::env::var_os("TOLD").is_some();
    let loaded = cell.sensors(false).load(&store, None, &Unwatched);
    let integrator = loaded.map_or(f64::NAN, |l| best_integrator(l.data().record, &truth));
    let estimate = |alone: bool| {
        let loaded = cell.sensors(alone).load(&store, None, &Unwatched);
        let loaded = loaded.map_err(|e| e.to_string())?;
        let job = VelocityEstimateJob::default();
        let outcome = job.evaluate(&loaded.data(), &Unwatched);
        outcome.map_err(|e| e.to_string())
    };
    let outcome = match estimate(false) {
        Ok(outcome) => outcome,
        Err(refusal) => {
            println!("    {} {seed}: {refusal}", cell.name);
            return None;
        }
    };
    let result = outcome.result();
    // Stamps that err make a clock that starts with the first of them.
    let motion = cell.motion(seed);
    let truth_of = |outcome: &VelocityEstimate| -> Vec<f64> {
        let (start, step) = outcome.clock();
        let count = outcome.result().trace.velocity.len();
        (0..count)
            .map(|k| motion(start + step * k as f64)[1])
            .collect()
    };
    let own = truth_of(&outcome);
    // What is left out of a gap is not stated.
    let stated = |v: &[f64]| result.stated().map(|k| v[k]).collect::<Vec<f64>>();
    let of = |v: &[f64], u: &Option<Vec<f64>>| {
        let u = u.as_deref().map(stated);
        judged(&stated(v), u.as_deref(), &stated(&own), outcome.clock().1)
    };
    let alone = match std::env::var_os("QUICK") {
        Some(_) => f64::NAN,
        None => estimate(true).map_or(f64::NAN, |o| {
            judged(
                &o.result().smoother.velocity,
                None,
                &truth_of(&o),
                o.clock().1,
            )
            .square
        }),
    };
    let one = One {
        filter: of(&result.trace.velocity, &result.trace.standard_uncertainty),
        smoother: of(
            &result.smoother.velocity,
            &result.smoother.standard_uncertainty,
        ),
        stated: result.stated().count(),
        oracle: oracle(&right, result, &truth),
        alone,
        low_pass: best_low_pass(&right, &truth),
        integrator,
        findings: outcome
            .findings()
            .iter()
            .map(|f: &Finding| (f.code().to_owned(), f.severity()))
            .collect(),
    };
    if told {
        println!(
            "    seed {seed}, gain {:.4}, {:.2} ms, disc {:.4} rad, jitter {}: filter {:.3}, smoother {:.3}, {:.3} mm/s (oracle {:.3})",
            cell.gain,
            1e3 * cell.latency,
            cell.disc,
            cell.jitter,
            one.filter.inside,
            one.smoother.inside,
            1e3 * one.smoother.square.sqrt(),
            1e3 * one.oracle.sqrt()
        );
        if let Some(t) = &result.tuned {
            println!(
                "      √q {:.4} √R {:.2e} b {:?} g {:?} τ {:?} n_e {:.0} ρ1 {:.3} size {:.3} largest {:?} inflation {:.2}",
                t.model.acceleration_noise.sqrt(),
                t.model.reading_noise.sqrt(),
                t.offset.map(|x| x.value),
                t.gain.map(|x| (x.value, x.uncertainty)),
                t.latency.map(|x| (x.value, x.uncertainty)),
                t.effective_readings,
                t.autocorrelation.get(1).copied().unwrap_or(0.0),
                t.whiteness.mean_square,
                t.whiteness.largest_correlation,
                1.0 + 2.0 * t.autocorrelation.iter().skip(1).sum::<f64>(),
            );
        }
        for f in outcome.findings() {
            println!(
                "      {:?} {}: {}",
                f.severity(),
                f.code(),
                f.evidence_text()
            );
        }
    }
    Some(one)
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(4);
    let wanted = arguments.next().unwrap_or_default();
    let mut list = cells();
    list.retain(|c| c.name.contains(&wanted));
    println!(
        "| axis | filter inside | smoother inside, least | below 0.85 | smoother, mm/s | over oracle | over encoder alone | over best low-pass | over best integrator | findings |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let (mut inside, mut records, mut low, mut alarmed) = (0.0, 0.0, 0, 0);
    let mut codes: BTreeMap<String, usize> = BTreeMap::new();
    for cell in &list {
        let found: Vec<One> = motions::of_seeds(seeds, |seed| run(cell, seed))
            .into_iter()
            .flatten()
            .collect();
        let n = found.len() as f64;
        let mean = |f: &dyn Fn(&One) -> f64| found.iter().map(f).sum::<f64>() / n;
        let rms = |f: &dyn Fn(&One) -> f64| mean(f).sqrt();
        let least = found.iter().fold(1.0f64, |m, o| m.min(o.smoother.inside));
        let below = found.iter().filter(|o| o.smoother.inside < 0.85).count();
        let mut own: BTreeMap<&str, usize> = BTreeMap::new();
        for one in &found {
            let mut list: Vec<&str> = one.findings.iter().map(|f| f.0.as_str()).collect();
            list.sort_unstable();
            list.dedup();
            for code in list {
                *own.entry(code).or_default() += 1;
                *codes.entry(code.to_owned()).or_default() += 1;
            }
            alarmed += usize::from(one.findings.iter().any(|f| f.1 != Severity::Note));
        }
        let own: Vec<String> = own.iter().map(|(c, n)| format!("{c} {n}")).collect();
        let smoother = rms(&|o| o.smoother.square);
        println!(
            "| {} | {:.3} | {:.3}, {least:.3} | {below} | {:.3} | {:.2} | {:.2} | {:.3} | {:.4} | {} |",
            cell.name,
            mean(&|o| o.filter.inside),
            mean(&|o| o.smoother.inside),
            1e3 * smoother,
            smoother / rms(&|o| o.oracle),
            smoother / rms(&|o| o.alone),
            smoother / rms(&|o| o.low_pass),
            smoother / rms(&|o| o.integrator),
            own.join(", ")
        );
        inside += found.iter().map(|o| o.smoother.inside).sum::<f64>();
        records += n;
        low += below;
    }
    println!(
        "\n{records} records, smoother inside {:.3}, {low} below 0.85, {alarmed} with a warning or decision",
        inside / records
    );
    for (code, n) in &codes {
        println!("{code}: {n}");
    }
}

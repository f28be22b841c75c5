//! The Allan family and Welch's density beside allantools and SciPy, on the same samples, in the same minutes.
//!
//! The Python interpreter is taken from the variable PROOFMASS_BENCH_PYTHON, else `python3`; it needs numpy, scipy and
//! allantools. Ours and theirs run by turns, so that other work on the machine hits both; each figure is the best of
//! several runs. Processor time is that of all threads together: what remains of the advantage on one core.

use proofmass_noise::{
    Bias, DeviationOptions, NoiseModel, NoiseRecord, NoiseType, Statistic, StreamingAllan,
    deviation, simulate,
};
use proofmass_signal::Welch;
use rand::SeedableRng;
use rayon::prelude::*;
use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

type Failure = Box<dyn std::error::Error>;

const RATE: f64 = 100.0;

/// The peer, which waits for the name of its next measurement.
struct Peer {
    process: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

/// Seconds by the clock and of the processor, and what came out.
struct Run {
    clock: f64,
    processor: f64,
    values: Vec<f64>,
}

impl Peer {
    fn start(samples: &std::path::Path) -> Result<Self, Failure> {
        let python = std::env::var("PROOFMASS_BENCH_PYTHON").unwrap_or_else(|_| "python3".into());
        let mut process = Command::new(&python)
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/src/allan_peer.py"))
            .arg(samples)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let input = process.stdin.take().ok_or("no input")?;
        let output = BufReader::new(process.stdout.take().ok_or("no output")?);
        Ok(Self {
            process,
            input,
            output,
        })
    }

    fn run(&mut self, name: &str) -> Result<Run, Failure> {
        writeln!(self.input, "{name}")?;
        let mut line = String::new();
        self.output.read_line(&mut line)?;
        let numbers = line
            .split_whitespace()
            .map(str::parse)
            .collect::<Result<Vec<f64>, _>>()?;
        match numbers.as_slice() {
            [clock, processor, values @ ..] => Ok(Run {
                clock: *clock,
                processor: *processor,
                values: values.to_vec(),
            }),
            _ => Err(format!("the peer did not answer {name}").into()),
        }
    }

    fn end(mut self) -> Result<(), Failure> {
        drop(self.input);
        self.process.wait()?;
        Ok(())
    }
}

/// Nanoseconds of processor time of all threads so far, where the system tells (Linux).
fn processor_time() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten();
    tasks
        .filter_map(|task| {
            let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
            text.split_whitespace().next()?.parse::<f64>().ok()
        })
        .sum::<f64>()
        * 1e-9
}

fn run(f: impl FnOnce() -> Vec<f64>) -> Run {
    let (start, processor) = (Instant::now(), processor_time());
    let values = black_box(f());
    Run {
        clock: start.elapsed().as_secs_f64(),
        processor: processor_time() - processor,
        values,
    }
}

/// Best of some runs of both by turns, printed as one line.
fn compare(
    peer: &mut Peer,
    name: &str,
    title: &str,
    rounds: usize,
    ours: impl Fn() -> Vec<f64>,
) -> Result<Run, Failure> {
    let none = || Run {
        clock: f64::INFINITY,
        processor: f64::INFINITY,
        values: Vec::new(),
    };
    let (mut best, mut theirs) = (none(), none());
    let keep = |best: &mut Run, new: Run| {
        best.clock = best.clock.min(new.clock);
        best.processor = best.processor.min(new.processor);
        best.values = new.values;
    };
    for _ in 0..rounds {
        keep(&mut theirs, peer.run(name)?);
        for _ in 0..3 {
            keep(&mut best, run(&ours));
        }
    }
    let difference = best
        .values
        .iter()
        .zip(&theirs.values)
        .map(|(a, b)| (a / b - 1.0).abs())
        .fold(0.0, f64::max);
    println!("{title}");
    println!(
        "  peer        {:10.2} ms   processor {:10.2} ms",
        1e3 * theirs.clock,
        1e3 * theirs.processor
    );
    println!(
        "  proofmass   {:10.2} ms   processor {:10.2} ms",
        1e3 * best.clock,
        1e3 * best.processor
    );
    println!(
        "  ratio       {:10.1}      processor {:10.1}      largest relative difference {difference:.1e} of {} values",
        theirs.clock / best.clock,
        theirs.processor / best.processor,
        best.values.len().min(theirs.values.len())
    );
    Ok(best)
}

fn deviations(rate: &[f64], statistic: Statistic, noise: Option<NoiseType>) -> Vec<f64> {
    let options = DeviationOptions {
        noise,
        // As the peer defines it.
        bias: Bias::AsDefined,
        ..Default::default()
    };
    deviation(NoiseRecord::Rate(rate), RATE, statistic, &options)
        .map(|curve| curve.points.iter().map(|p| p.deviation).collect())
        .unwrap_or_default()
}

fn main() -> Result<(), Failure> {
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(1);
    let white = NoiseModel {
        white: 0.1,
        ..Default::default()
    };
    let rate = simulate(&white, 10_000_000, RATE, &mut rng)?;
    let mut file = tempfile::NamedTempFile::new()?;
    for part in rate.chunks(1 << 16) {
        let bytes: Vec<u8> = part.iter().flat_map(|v| v.to_le_bytes()).collect();
        file.write_all(&bytes)?;
    }
    file.flush()?;
    let mut peer = Peer::start(file.path())?;

    let oadev = compare(
        &mut peer,
        "oadev",
        "overlapping Allan deviation, octave τ, 10⁷ samples, ours with noise types and intervals",
        5,
        || deviations(&rate, Statistic::OverlappingAllan, None),
    )?;
    let bits = |part: &[f64]| part.iter().fold(0_u64, |a, v| a ^ v.to_bits());
    let by_one = || bits(&rate);
    let by_all = || {
        rate.par_chunks(1 << 16)
            .map(bits)
            .reduce(|| 0, |a, b| a ^ b)
    };
    let seconds = |pass: &dyn Fn() -> u64| {
        (0..9)
            .map(|_| run(|| vec![pass() as f64]).clock)
            .fold(f64::INFINITY, f64::min)
    };
    for (who, pass) in [("all threads", seconds(&by_all)), ("one", seconds(&by_one))] {
        println!(
            "  reading the samples once takes {who} {:.1} ms; ours takes {:.1} times as long as three such readings",
            1e3 * pass,
            oadev.clock / (3.0 * pass)
        );
    }
    compare(
        &mut peer,
        "mtotdev",
        "MTOTDEV, octave τ, 2000 samples",
        2,
        || deviations(&rate[..2000], Statistic::ModifiedTotal, None),
    )?;
    for (name, segment) in [("welch_256", 256), ("welch_4096", 4096)] {
        compare(
            &mut peer,
            name,
            &format!("Welch's density, segments of {segment}, 10⁷ samples"),
            5,
            || {
                Welch::new(segment)
                    .density(&rate, RATE)
                    .map(|d| d.density[1..9].to_vec())
                    .unwrap_or_default()
            },
        )?;
    }
    peer.end()?;

    let stream = (0..5)
        .map(|_| {
            run(|| {
                let Ok(mut stream) = StreamingAllan::new(RATE) else {
                    return Vec::new();
                };
                for part in rate.chunks(1 << 16) {
                    // Simulated samples are finite.
                    let _ = stream.push(part);
                }
                vec![stream.samples() as f64]
            })
        })
        .min_by(|a, b| a.clock.total_cmp(&b.clock))
        .ok_or("no run")?;
    println!(
        "the same deviation from a stream: {:.1} ms, {:.0} million samples a second in constant memory",
        1e3 * stream.clock,
        10.0 / stream.clock
    );
    Ok(())
}

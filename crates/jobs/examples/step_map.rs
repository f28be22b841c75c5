//! Are steps answered, and do the 95 % intervals of natural frequency and damping hold the truth?
//!
//! Prints the table of docs/dynamic-tests.md: `cargo run --release -p proofmass-jobs --example step_map`. A recorded step is written as a
//! text, read and fitted as `proofmass test step` does it. Sixty cells are spread evenly over damping, noise, samples to a period, length,
//! place of the step, and what the acceleration rises like. Arguments are the number of recordings per cell (1000) and the first seed (0).

use proofmass_dynamic::step::step_response;
use proofmass_io::{ColumnRef, Source};
use proofmass_jobs::step::{StepData, StepJob};
use proofmass_jobs::{ChannelReading, Job, Outcome, Unwatched, WantedChannel};
use proofmass_uncertainty::Severity;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::fmt::Write as _;

/// How the acceleration comes.
#[derive(Clone, Copy, Debug)]
pub enum Rise {
    /// At once.
    None,
    /// Straight, between two samples.
    Sample,
    /// As a half cosine, a tenth of a period long.
    Smooth,
    /// At once, seen through a first-order low-pass of a time constant of a fiftieth of a period.
    LowPass,
}

/// One place of the map.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// ζ.
    pub damping: f64,
    /// Noise of a sample, as a share of the step.
    pub noise: f64,
    /// Samples to a period.
    pub samples: f64,
    /// Periods after the step.
    pub after: f64,
    /// Periods before it.
    pub before: f64,
    /// How the acceleration comes.
    pub rise: Rise,
    /// Correlation of the noise from sample to sample.
    pub pole: f64,
}

/// What came of the recordings of one place.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    /// Recordings.
    pub recordings: usize,
    /// Those that were refused.
    pub refused: usize,
    /// Intervals of frequency and damping that hold the truth.
    pub held: [usize; 2],
    /// Intervals of the height that hold it.
    pub height_held: usize,
    /// Sum of U of frequency (as a share) and damping.
    pub expanded: [f64; 2],
    /// Recordings with a warning.
    pub warned: usize,
    /// First refusal or warning.
    pub reason: Option<String>,
}

const FREQUENCY: f64 = 1000.0;
const HEIGHT: f64 = -2.0;

impl Place {
    /// The record, and its sampling rate.
    pub fn record(&self, seed: u64) -> (Vec<f64>, f64) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let rate = FREQUENCY * self.samples;
        let n = ((self.before + self.after) * self.samples).max(48.0) as usize;
        // Anywhere between two samples.
        let instant = (self.before * self.samples + rng.random::<f64>()) / rate;
        // Delays of parts of the step, in periods.
        let parts: Vec<f64> = (0..64)
            .map(|k| (f64::from(k) + 0.5) / 64.0)
            .map(|share| match self.rise {
                Rise::None => 0.0,
                Rise::Sample => share / self.samples,
                Rise::Smooth => 0.1 * (1.0 - 2.0 * share).acos() / std::f64::consts::PI,
                Rise::LowPass => -0.02 * (1.0 - share).ln(),
            })
            .collect();
        let parts = match self.rise {
            Rise::None => &parts[..1],
            _ => &parts[..],
        };
        let mut state: f64 = StandardNormal.sample(&mut rng);
        let record = (0..n).map(|k| {
            let t = k as f64 / rate - instant;
            let one = |delay: &f64| step_response(t - delay / FREQUENCY, FREQUENCY, self.damping);
            let swing = parts.iter().map(one).sum::<f64>() / parts.len() as f64;
            let e: f64 = StandardNormal.sample(&mut rng);
            state = self.pole * state + (1.0 - self.pole * self.pole).sqrt() * e;
            0.3 + HEIGHT * (swing + self.noise * state)
        });
        (record.collect(), rate)
    }

    /// Departure and U of frequency and height (shares) and damping, and the first warning.
    fn one(&self, seed: u64) -> Result<([[f64; 2]; 3], Option<String>), String> {
        let (record, rate) = self.record(seed);
        let mut text = "u_V\n".to_owned();
        for value in &record {
            let _ = writeln!(text, "{value:.7}");
        }
        let mut reading = ChannelReading::default();
        reading.rate = Some(rate);
        let source = Source::from_bytes("step.csv", text).map_err(|e| e.to_string())?;
        let column = ColumnRef::Name("u".into());
        let wanted = [WantedChannel::new(column, None, "--unit")];
        let recording = reading.read(source, &wanted).map_err(|e| e.to_string())?;
        let data = StepData {
            channel: recording.channels[0].view(),
            rate: recording.rate,
            findings: &recording.findings,
            name: &recording.name,
        };
        let outcome = StepJob::default()
            .evaluate(&data, &Unwatched)
            .map_err(|e| e.to_string())?;
        let mut ratios = [[0.0; 2]; 3];
        let truth = [
            ("frequency", FREQUENCY),
            ("damping", self.damping),
            ("height", HEIGHT),
        ];
        for (ratio, (name, truth)) in ratios.iter_mut().zip(truth) {
            let all = outcome.quantities();
            let quantity = all.iter().find(|q| q.name == name);
            let quantity = quantity.ok_or_else(|| format!("no {name}"))?;
            *ratio = [(quantity.value - truth).abs(), quantity.expanded];
        }
        ratios[0] = ratios[0].map(|v| v / FREQUENCY);
        ratios[2] = ratios[2].map(|v| v / HEIGHT.abs());
        let warning = outcome.findings().iter();
        let warning = warning
            .filter(|f| f.severity() != Severity::Note)
            .map(|f| format!("{}: {}", f.code(), f.evidence_text()))
            .next();
        Ok((ratios, warning))
    }

    /// Runs many recordings.
    pub fn cell(&self, recordings: usize, first: u64) -> Cell {
        let results: Vec<_> = (first..first + recordings as u64)
            .into_par_iter()
            .map(|seed| self.one(seed))
            .collect();
        let mut cell = Cell {
            recordings,
            ..Cell::default()
        };
        for result in results {
            match result {
                Err(reason) => {
                    cell.refused += 1;
                    cell.reason.get_or_insert(reason);
                }
                Ok(([frequency, damping, height], warning)) => {
                    cell.height_held += usize::from(height[0] <= height[1]);
                    for (k, [off, expanded]) in [frequency, damping].into_iter().enumerate() {
                        cell.held[k] += usize::from(off <= expanded);
                        cell.expanded[k] += expanded;
                    }
                    cell.warned += usize::from(warning.is_some());
                    if cell.reason.is_none() {
                        cell.reason = warning;
                    }
                }
            }
        }
        cell
    }
}

/// The map: each coordinate runs through its values by its own stride, so that no two go together.
pub fn places() -> Vec<Place> {
    const DAMPING: [f64; 10] = [0.01, 0.02, 0.05, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.2];
    const NOISE: [f64; 5] = [1e-4, 1e-3, 3e-3, 1e-2, 3e-2];
    const SAMPLES: [f64; 5] = [5.0, 10.0, 20.0, 50.0, 100.0];
    const AFTER: [f64; 5] = [2.5, 5.0, 10.0, 25.0, 50.0];
    const BEFORE: [f64; 4] = [0.5, 2.0, 6.0, 20.0];
    const RISE: [Rise; 4] = [Rise::None, Rise::Sample, Rise::Smooth, Rise::LowPass];
    const POLE: [f64; 3] = [0.0, 0.0, 0.5];
    // Fractions of irrational numbers, as of a Kronecker sequence.
    let at = |k: usize, root: f64| ((k as f64 + 0.5) * root.sqrt()).fract();
    fn pick<T: Copy>(of: &[T], at: f64) -> T {
        of[(at * of.len() as f64) as usize]
    }
    (0..60)
        .map(|k| Place {
            damping: pick(&DAMPING, at(k, 2.0)),
            noise: pick(&NOISE, at(k, 3.0)),
            samples: pick(&SAMPLES, at(k, 5.0)),
            after: pick(&AFTER, at(k, 7.0)),
            before: pick(&BEFORE, at(k, 11.0)),
            rise: pick(&RISE, at(k, 13.0)),
            pole: pick(&POLE, at(k, 17.0)),
        })
        .collect()
}

fn main() {
    let argument = |i| std::env::args().nth(i).and_then(|a| a.parse().ok());
    let (recordings, first) = (argument(1).unwrap_or(1000), argument(2).unwrap_or(0));
    println!(
        "| ζ | noise / % | correlation | samples to a period | periods before, after | rise | refused / % | f, ζ hold / % | U of f / %, of ζ | warned / % |"
    );
    println!("|{}", "---|".repeat(10));
    let mut all = [0; 3];
    // Recordings, answers, and those that hold, by damping and noise.
    let mut groups = vec![[0; 4]; 9];
    for place in places() {
        let cell = place.cell(recordings, first as u64);
        let stated = cell.recordings - cell.refused;
        let share = |n: usize, of: usize| 100.0 * n as f64 / of.max(1) as f64;
        let mean = cell.expanded.map(|u| u / stated.max(1) as f64);
        println!(
            "| {} | {} | {} | {} | {}, {} | {} | {:.1} | {:.1}, {:.1} | {:.2e}, {:.2e} | {:.1} |",
            place.damping,
            100.0 * place.noise,
            place.pole,
            place.samples,
            place.before,
            place.after,
            match place.rise {
                Rise::None => "none",
                Rise::Sample => "one sample",
                Rise::Smooth => "smooth",
                Rise::LowPass => "low-pass",
            },
            share(cell.refused, cell.recordings),
            share(cell.held[0], stated),
            share(cell.held[1], stated),
            100.0 * mean[0],
            mean[1],
            share(cell.warned, cell.recordings),
        );
        if let Some(reason) = &cell.reason {
            eprintln!("    {reason}");
        }
        let damping = [0.05, 0.4].iter().filter(|d| place.damping > **d).count();
        let noise = [1e-3, 1e-2].iter().filter(|n| place.noise > **n).count();
        let counts = [cell.recordings, stated, cell.held[0], cell.held[1]];
        for (sum, count) in groups[3 * damping + noise].iter_mut().zip(counts) {
            *sum += count;
        }
        // Least number that 92 % leave, once in a thousand for all cells together.
        let n = stated as f64;
        let least = 0.92 * n - 4.3 * (0.92 * 0.08 * n).sqrt();
        if cell.held.iter().any(|held| (*held as f64) < least) {
            eprintln!("    below 92 %: {place:?}");
        }
        all[0] += stated;
        all[1] += cell.held[0];
        all[2] += cell.held[1];
    }
    println!(
        "\n| ζ | noise / % | recordings | answers | f holds / % | ζ holds / % |\n|---|---|---|---|---|---|"
    );
    for (k, [recordings, stated, f, damping]) in groups.iter().enumerate() {
        let share = |n: usize| 100.0 * n as f64 / (*stated).max(1) as f64;
        println!(
            "| {} | {} | {recordings} | {stated} | {:.1} | {:.1} |",
            ["0.01 to 0.05", "0.1 to 0.4", "0.7 to 1.2"][k / 3],
            ["0.01, 0.1", "0.3, 1", "3"][k % 3],
            share(*f),
            share(*damping)
        );
    }
    let share = |n: usize| 100.0 * n as f64 / all[0].max(1) as f64;
    println!(
        "\nOf {} answers {:.2} % hold the frequency and {:.2} % the damping.",
        all[0],
        share(all[1]),
        share(all[2])
    );
}

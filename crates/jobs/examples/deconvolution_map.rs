//! Of which shocks does `proofmass test deconvolve` state a peak, a duration and a velocity change whose 95 % intervals hold?
//!
//! Prints the tables of docs/dynamic-tests.md: `cargo run -p proofmass-jobs --example deconvolution_map`. Places are spread evenly over
//! shape, duration, damping, noise, length of the record, hum, offset and drift; each record is asked as a job, as the command does it. Arguments are
//! the number of records (3000) and the first of them (0).

#[path = "../tests/support/deconvolution.rs"]
mod deconvolution;

use deconvolution::{SENSITIVITY, asked, fitted};
use proofmass_jobs::Outcome;
use proofmass_jobs::deconvolution::DeconvolutionJob;
use proofmass_signal::{PulseShape, fourier};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// What moves the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Half a sine.
    HalfSine,
    /// Its square.
    Haversine,
    /// A straight rise and a fall at once: a step in the acceleration.
    SawTooth,
    /// Two half-sines one after the other, the second with 0.8 of the peak.
    Double,
}

/// One record of the map. Levels are shares of the static output at the peak.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Shape of the acceleration.
    pub shape: Shape,
    /// Of one pulse, s.
    pub duration: f64,
    /// ζ.
    pub damping: f64,
    /// Standard deviation of a sample.
    pub noise: f64,
    /// Of the record, in durations.
    pub length: f64,
    /// Amplitude of hum of 50 Hz.
    pub hum: f64,
    /// Level at rest.
    pub offset: f64,
    /// Straight drift over the record.
    pub drift: f64,
}

/// What came of a record.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Not answered, and why.
    Refused(String),
    /// Peak and U over the true peak; whether the interval holds the peak, and the peak as the stated low-pass leaves it.
    Stated {
        /// Value over truth.
        peak: f64,
        /// U over truth.
        expanded: f64,
        /// Holds the peak.
        held: bool,
        /// Holds the peak of the acceleration in the stated band.
        in_band: bool,
        /// Whether the duration is held, with U over it, where it is stated.
        duration: Option<(bool, f64)>,
        /// The same of the velocity change.
        velocity_change: Option<(bool, f64)>,
    },
}

/// m/s².
const PEAK: f64 = 5000.0;
/// Of the device, Hz.
const RESONANCE: f64 = 20e3;

impl Place {
    /// Forty samples to the pulse, at least two and a half to a period of the resonance.
    fn rate(&self) -> f64 {
        (40.0 / self.duration).clamp(2.5 * RESONANCE, 50.0 * RESONANCE)
    }

    fn truth(&self, n: usize) -> Vec<f64> {
        let rate = self.rate();
        let start = 0.5 * (n as f64 / rate - self.duration).max(0.0);
        let pulse = |shape: PulseShape, peak: f64, late: f64| {
            shape.record(peak, self.duration, start + late, n, rate)
        };
        match self.shape {
            Shape::HalfSine => pulse(PulseShape::HalfSine, PEAK, 0.0),
            Shape::Haversine => pulse(PulseShape::Haversine, PEAK, 0.0),
            Shape::SawTooth => pulse(PulseShape::TerminalPeakSawtooth, PEAK, 0.0),
            Shape::Double => {
                let second = pulse(PulseShape::HalfSine, 0.8 * PEAK, self.duration);
                let first = pulse(PulseShape::HalfSine, PEAK, 0.0);
                first.iter().zip(second).map(|(a, b)| a + b).collect()
            }
        }
    }

    /// Between the passages through a tenth of the peak, s.
    fn tenth_duration(&self) -> f64 {
        let one = match self.shape {
            Shape::HalfSine => PulseShape::HalfSine.tenth_duration(),
            Shape::Haversine => PulseShape::Haversine.tenth_duration(),
            Shape::SawTooth => PulseShape::TerminalPeakSawtooth.tenth_duration(),
            // The second pulse passes a tenth of the first one's peak at an eighth of its own.
            Shape::Double => 2.0 - (0.1f64.asin() + 0.125f64.asin()) / std::f64::consts::PI,
        };
        one * self.duration
    }

    /// Asks for the peak.
    pub fn answer(&self, seed: u64) -> Answer {
        let rate = self.rate();
        let n = (self.length * self.duration * rate) as usize;
        let (device, fit) = fitted(RESONANCE, self.damping);
        let truth = self.truth(n);
        // As much again behind it, that the ringing does not come round to the beginning.
        let long = fourier::fast_length(2 * n);
        let turned = |by: &dyn Fn(f64) -> num_complex::Complex64| -> Vec<f64> {
            let mut padded = truth.clone();
            padded.resize(long, 0.0);
            let spectrum = fourier::forward(&padded).into_iter().enumerate();
            let through = spectrum.map(|(k, v)| v * by(k as f64 * rate / long as f64));
            let mut x = fourier::inverse(through.collect(), long).expect("a record");
            x.truncate(n);
            x
        };
        let volts = SENSITIVITY * PEAK;
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let phase = 3.0 * normal();
        let record: Vec<f64> = turned(&|f| device.response(f))
            .into_iter()
            .enumerate()
            .map(|(k, v)| {
                let hum = (std::f64::consts::TAU * 50.0 * k as f64 / rate + phase).sin();
                let drift = self.drift * k as f64 / n as f64;
                v + volts * (self.offset + drift + self.noise * normal() + self.hum * hum)
            })
            .collect();
        let outcome = match asked(&DeconvolutionJob::default(), &fit, &record, rate) {
            Ok(outcome) => outcome,
            Err(trouble) => return Answer::Refused(trouble.to_string()),
        };
        let (peak, corner) = (&outcome.quantities()[0], outcome.deconvolved().corner);
        let left =
            turned(&|f| num_complex::Complex64::new(1.0 / (1.0 + (f / corner).powi(8)), 0.0));
        let in_band = left.iter().copied().fold(0.0f64, |m, v| m.max(v.abs()));
        let holds = |truth: f64| (peak.value.abs() - truth).abs() <= peak.expanded;
        // The record is of the samples: a saw tooth that ends between two of them has lost a part.
        let change = truth.iter().sum::<f64>() / rate;
        let read = |name: &str, truth: f64| {
            let q = outcome.quantities().into_iter().find(|q| q.name == name)?;
            Some((
                (q.value.abs() - truth).abs() <= q.expanded,
                q.expanded / truth,
            ))
        };
        Answer::Stated {
            duration: read("duration", self.tenth_duration()),
            velocity_change: read("velocity_change", change),
            peak: peak.value.abs() / PEAK,
            expanded: peak.expanded / PEAK,
            held: holds(PEAK),
            in_band: holds(in_band),
        }
    }
}

/// Place k of the map: each coordinate runs through its values by its own stride, so that no two go together.
pub fn place(k: u64) -> Place {
    const SHAPE: [Shape; 4] = [
        Shape::HalfSine,
        Shape::Haversine,
        Shape::SawTooth,
        Shape::Double,
    ];
    const DURATION: [f64; 6] = [6e-5, 2e-4, 6e-4, 2e-3, 6e-3, 2e-2];
    const DAMPING: [f64; 5] = [0.005, 0.02, 0.05, 0.2, 0.7];
    const NOISE: [f64; 7] = [1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1];
    const LENGTH: [f64; 6] = [3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];
    const HUM: [f64; 4] = [0.0, 0.0, 0.003, 0.03];
    const OFFSET: [f64; 3] = [0.0, 0.1, -1.0];
    const DRIFT: [f64; 4] = [0.0, 0.0, 0.01, -0.1];
    let at = |root: f64| ((k as f64 + 0.5) * root.sqrt()).fract();
    fn pick<T: Copy>(of: &[T], at: f64) -> T {
        of[(at * of.len() as f64) as usize]
    }
    let duration = pick(&DURATION, at(3.0));
    // Two hundred thousand samples at most.
    let longest = 2e5 / (40.0 / duration).clamp(2.5 * RESONANCE, 50.0 * RESONANCE) / duration;
    Place {
        shape: pick(&SHAPE, at(2.0)),
        duration,
        damping: pick(&DAMPING, at(5.0)),
        noise: pick(&NOISE, at(7.0)),
        length: pick(&LENGTH, at(11.0)).min(longest),
        hum: pick(&HUM, at(13.0)),
        offset: pick(&OFFSET, at(17.0)),
        drift: pick(&DRIFT, at(19.0)),
    }
}

/// Counts of one group of places.
#[derive(Clone, Copy, Debug, Default)]
pub struct Group {
    /// Records.
    pub records: usize,
    /// Answers.
    pub answers: usize,
    /// Answers that hold the peak, and the peak in the band.
    pub held: [usize; 2],
    /// Sum of the logarithms of U over the peak.
    pub width: f64,
    /// Durations stated, and held, with the sum of the logarithms of U over them.
    pub duration: (usize, usize, f64),
    /// The same of velocity changes.
    pub velocity_change: (usize, usize, f64),
}

impl Group {
    /// Counts the answers of the records that belong to it.
    pub fn of(all: &[(Place, Answer)], belongs: impl Fn(&Place) -> bool) -> Self {
        let mut group = Self::default();
        for (_, answer) in all.iter().filter(|(place, _)| belongs(place)) {
            group.records += 1;
            if let Answer::Stated {
                expanded,
                held,
                in_band,
                duration,
                velocity_change,
                ..
            } = answer
            {
                let sums = [&mut group.duration, &mut group.velocity_change];
                for ((stated, held, width), read) in
                    sums.into_iter().zip([duration, velocity_change])
                {
                    *stated += usize::from(read.is_some());
                    *held += usize::from(read.is_some_and(|r| r.0));
                    *width += read.map_or(0.0, |r| r.1.ln());
                }
                group.answers += 1;
                group.held[0] += usize::from(*held);
                group.held[1] += usize::from(*in_band);
                group.width += expanded.ln();
            }
        }
        group
    }

    fn line(&self, name: &str) {
        let share = |n: usize, of: usize| 100.0 * n as f64 / of.max(1) as f64;
        let read = |(stated, held, width): (usize, usize, f64)| {
            let u = 100.0 * (width / stated.max(1) as f64).exp();
            format!(
                "{:.0}, {:.1}, {u:.2}",
                share(stated, self.answers),
                share(held, stated)
            )
        };
        println!(
            "| {name} | {} | {:.1} | {:.1} | {:.1} | {:.2} | {} | {} |",
            self.records,
            share(self.records - self.answers, self.records),
            share(self.held[0], self.answers),
            share(self.held[1], self.answers),
            100.0 * (self.width / self.answers.max(1) as f64).exp(),
            read(self.duration),
            read(self.velocity_change)
        );
    }
}

/// The records of bench/src/deconvolution_peer.py but for their noise, and how far off the peak is.
fn peer() {
    for noise in [1e-4, 1e-2, 1e-1] {
        let (mut errors, mut held, mut refused) = (vec![], 0u32, 0u32);
        let begin = std::time::Instant::now();
        for shape in [Shape::HalfSine, Shape::Haversine] {
            for (duration, damping) in [6e-5, 2e-4, 2e-3].map(|d| [(d, 0.02), (d, 0.7)]).concat() {
                let place = Place {
                    shape,
                    duration,
                    damping,
                    noise,
                    length: 10.0,
                    hum: 0.0,
                    offset: 0.0,
                    drift: 0.0,
                };
                for seed in 0..20 {
                    match place.answer(seed) {
                        Answer::Stated { peak, held: h, .. } => {
                            errors.push(100.0 * (peak - 1.0));
                            held += u32::from(h);
                        }
                        Answer::Refused(_) => refused += 1,
                    }
                }
            }
        }
        let n = errors.len() as f64;
        let square = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
        let most = errors.iter().fold(0.0f64, |m, e| m.max(e.abs()));
        println!(
            "deconvolve {noise} {n} {square:.2} {most:.1} {:.1} {:.2}, {refused} refused",
            100.0 * f64::from(held) / n,
            1e3 * begin.elapsed().as_secs_f64() / (n + f64::from(refused))
        );
    }
}

#[allow(dead_code, reason = "a test has no use for the printed table")]
fn main() {
    if std::env::args().nth(1).as_deref() == Some("peer") {
        return peer();
    }
    let argument = |i| std::env::args().nth(i).and_then(|a| a.parse().ok());
    let (records, first) = (argument(1).unwrap_or(3000), argument(2).unwrap_or(0));
    let all: Vec<(Place, Answer)> = (first..first + records)
        .into_par_iter()
        .map(|k| (place(k), place(k).answer(k)))
        .collect();
    println!(
        "| group | records | refused / % | peak held / % | in the band held / % | U / % of the peak | duration: stated, held / %, U / % | velocity change: stated, held / %, U / % |"
    );
    println!("|{}", "---|".repeat(8));
    Group::of(&all, |_| true).line("all");
    let smooth = |p: &Place| p.shape != Shape::SawTooth;
    Group::of(&all, smooth).line("without saw teeth");
    for shape in [
        Shape::HalfSine,
        Shape::Haversine,
        Shape::Double,
        Shape::SawTooth,
    ] {
        Group::of(&all, |p| p.shape == shape).line(&format!("{shape:?}"));
    }
    let between = |v: f64, [low, high]: [f64; 2]| (low..=high).contains(&v);
    for band in [[5e-5, 2e-4], [6e-4, 2e-3], [6e-3, 2e-2]] {
        let name = format!("smooth, {} to {} ms", 1e3 * band[0], 1e3 * band[1]);
        Group::of(&all, |p| smooth(p) && between(p.duration, band)).line(&name);
    }
    for band in [[0.005, 0.02], [0.05, 0.2], [0.7, 0.7]] {
        let name = format!("smooth, ζ {} to {}", band[0], band[1]);
        Group::of(&all, |p| smooth(p) && between(p.damping, band)).line(&name);
    }
    for band in [[1e-4, 3e-4], [1e-3, 3e-3], [1e-2, 3e-2], [1e-1, 1e-1]] {
        let name = format!("smooth, noise {} to {}", band[0], band[1]);
        Group::of(&all, |p| smooth(p) && between(p.noise, band)).line(&name);
    }
    for band in [[0.0, 5.0], [6.0, 40.0], [50.0, 1000.0]] {
        let name = format!("smooth, record of {} to {} durations", band[0], band[1]);
        Group::of(&all, |p| smooth(p) && between(p.length, band)).line(&name);
    }
    for hum in [0.0, 0.003, 0.03] {
        Group::of(&all, |p| smooth(p) && p.hum == hum).line(&format!("smooth, hum {hum}"));
    }
    for drift in [0.0, 0.01, -0.1] {
        Group::of(&all, |p| smooth(p) && p.drift == drift).line(&format!("smooth, drift {drift}"));
    }
    let mut reasons: Vec<(String, usize)> = vec![];
    for (place, answer) in &all {
        match answer {
            Answer::Refused(why) => {
                let why: String = why.lines().next().unwrap_or("").chars().take(60).collect();
                match reasons.iter_mut().find(|(r, _)| *r == why) {
                    Some((_, n)) => *n += 1,
                    None => reasons.push((why, 1)),
                }
            }
            Answer::Stated {
                held: false,
                peak,
                expanded,
                ..
            } if smooth(place) => {
                eprintln!("missed {peak:.4} ± {expanded:.4}: {place:?}");
            }
            Answer::Stated {
                duration,
                velocity_change,
                ..
            } if smooth(place) => {
                for (name, read) in [("duration", duration), ("change", velocity_change)] {
                    if let Some((false, u)) = read {
                        eprintln!("missed {name}, U = {u:.4}: {place:?}");
                    }
                }
            }
            Answer::Stated { .. } => {}
        }
    }
    eprintln!("{reasons:?}");
}

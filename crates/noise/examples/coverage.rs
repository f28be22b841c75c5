//! Coverage of the intervals and false identifications over record lengths and mixtures, as in `docs/noise.md`.
//!
//! `cargo run --release -p proofmass-noise --example coverage -- 500 [FIRST_SEED [CELL]]`. Records of 20 000 samples at
//! 10 Hz with N = 1; K by T/τ_c with τ_c = √3 N/K, B by T/τ_f = 0.4413 T B²/N². For each cell and term: how often the
//! truth lies in the 95 % interval (or below the limit), how often the term is called identified, and how often zero is
//! excluded. Gauss–Markov processes have σ = 1 and 5 s.

use proofmass_noise::{
    FitOptions, GaussMarkov, LowPass, NoiseModel, SimulatedSensor, Term, Verdict, simulate, whittle,
};
use rand::SeedableRng;
use rayon::prelude::*;

const RATE: f64 = 10.0;
const SAMPLES: usize = 20_000;
/// Standard deviation of the Gauss–Markov process, and its correlation time in s.
const DEVIATION: f64 = 1.0;
const TIME: f64 = 5.0;
const TERMS: [Term; 5] = [
    Term::Quantisation,
    Term::White,
    Term::Flicker,
    Term::RandomWalk,
    Term::Ramp,
];

/// A mixture by its crossing times in the record; zero leaves a term out. R in √(12N²/T³), Q in N·Δt.
struct Cell {
    name: &'static str,
    walk: f64,
    flicker: f64,
    ramp: f64,
    quantisation: f64,
    markov: bool,
    /// Whether Gauss–Markov processes are sought.
    sought: bool,
    /// Order of the filter and its corner as a part of the rate.
    filter: Option<(i32, f64)>,
    samples: usize,
}

impl Cell {
    const fn new(name: &'static str, walk: f64, flicker: f64) -> Self {
        Self {
            name,
            walk,
            flicker,
            ramp: 0.0,
            quantisation: 0.0,
            markov: false,
            sought: false,
            filter: None,
            samples: SAMPLES,
        }
    }

    fn model(&self) -> NoiseModel {
        let t = self.samples as f64 / RATE;
        NoiseModel {
            white: 1.0,
            random_walk: 3.0_f64.sqrt() * self.walk / t,
            flicker: (self.flicker / (0.4413 * t)).sqrt(),
            ramp: self.ramp * (12.0 / t.powi(3)).sqrt(),
            quantisation: self.quantisation / RATE,
            gauss_markov: if self.markov {
                vec![GaussMarkov {
                    standard_deviation: DEVIATION,
                    correlation_time: TIME,
                }]
            } else {
                Vec::new()
            },
            ..Default::default()
        }
    }
}

fn cells() -> Vec<Cell> {
    vec![
        Cell::new("N", 0.0, 0.0),
        Cell::new("N+K3", 3.0, 0.0),
        Cell::new("N+K6", 6.0, 0.0),
        Cell::new("N+K10", 10.0, 0.0),
        Cell::new("N+K15", 15.0, 0.0),
        Cell::new("N+K20", 20.0, 0.0),
        Cell::new("N+K30", 30.0, 0.0),
        Cell::new("N+K80", 80.0, 0.0),
        Cell::new("N+K300", 300.0, 0.0),
        Cell::new("N+B10", 0.0, 10.0),
        Cell::new("N+B30", 0.0, 30.0),
        Cell::new("N+B100", 0.0, 100.0),
        Cell::new("N+B300", 0.0, 300.0),
        Cell::new("N+B100+K20", 20.0, 100.0),
        Cell::new("N+B30+K60", 60.0, 30.0),
        Cell {
            ramp: 16.0,
            ..Cell::new("N+R", 0.0, 0.0)
        },
        Cell {
            ramp: 100.0,
            ..Cell::new("N+K30+R", 30.0, 0.0)
        },
        Cell {
            ramp: 100.0,
            ..Cell::new("N+B100+K20+R", 20.0, 100.0)
        },
        Cell {
            quantisation: 1.0,
            ..Cell::new("N+Q+B100+K60", 60.0, 100.0)
        },
        Cell {
            markov: true,
            sought: true,
            ..Cell::new("N+GM", 0.0, 0.0)
        },
        Cell {
            filter: Some((1, 0.25)),
            ..Cell::new("N+K80:1st/4", 80.0, 0.0)
        },
        Cell {
            filter: Some((1, 0.1)),
            ..Cell::new("N+K80:1st/10", 80.0, 0.0)
        },
        Cell {
            filter: Some((2, 0.25)),
            ..Cell::new("N+K80:2nd/4", 80.0, 0.0)
        },
        Cell {
            filter: Some((2, 0.1)),
            ..Cell::new("N+K80:2nd/10", 80.0, 0.0)
        },
        Cell {
            filter: Some((2, 0.1)),
            ..Cell::new("N+B100:2nd/10", 0.0, 100.0)
        },
        Cell {
            filter: Some((1, 0.1)),
            ..Cell::new("N+B100:1st/10", 0.0, 100.0)
        },
        Cell {
            markov: true,
            sought: true,
            ..Cell::new("N+B100+GM", 0.0, 100.0)
        },
    ]
    .into_iter()
    .chain(long_filters(0.0, &[0.0, 1000.0]))
    .chain([
        Cell {
            markov: true,
            sought: true,
            ..Cell::new("N+K30+GM", 30.0, 0.0)
        },
        Cell {
            sought: true,
            ..Cell::new("N,GM sought", 0.0, 0.0)
        },
        Cell {
            sought: true,
            ..Cell::new("N+B100,GM s.", 0.0, 100.0)
        },
        Cell {
            sought: true,
            ..Cell::new("N+K30,GM s.", 30.0, 0.0)
        },
        Cell {
            markov: true,
            ..Cell::new("N+GM unsought", 0.0, 0.0)
        },
    ])
    .chain(long_filters(1000.0, &[0.0]))
    .collect()
}

/// Filters over 2·10⁵ samples. Flicker noise crosses the white noise at a fifth of the lowest corner, the walk at a seventh.
fn long_filters(walk: f64, flickers: &'static [f64]) -> impl Iterator<Item = Cell> {
    let one = move |order: i32, part: u32, flicker: f64| {
        let word = if order == 1 { "1st" } else { "2nd" };
        let front = match (walk > 0.0, flicker > 0.0) {
            (true, _) => "N+K1000",
            (false, true) => "N+B1000",
            (false, false) => "N",
        };
        let name = format!("{front}:{word}/{part}");
        Cell {
            filter: Some((order, 1.0 / f64::from(part))),
            samples: 200_000,
            ..Cell::new(name.leak(), walk, flicker)
        }
    };
    [1, 2].into_iter().flat_map(move |order| {
        [3, 10, 30, 100]
            .into_iter()
            .flat_map(move |part| flickers.iter().map(move |f| one(order, part, *f)))
    })
}

/// Per term: held, identified, zero excluded; then misfit findings and bands cut; then N over the truth, and its square;
/// then Gauss–Markov processes found, and of the first whether its σ and its time are held.
type Counts = [f64; 22];

fn examine(cell: &Cell, seed: u64) -> Counts {
    let model = cell.model();
    let mut terms = TERMS.to_vec();
    terms.extend(cell.sought.then_some(Term::GaussMarkov));
    let options = FitOptions {
        terms,
        ..FitOptions::default()
    };
    let truth = [
        model.quantisation,
        model.white,
        model.flicker,
        model.random_walk,
        model.ramp,
    ];
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
    let rate = match cell.filter {
        None => simulate(&model, cell.samples, RATE, &mut rng).expect("a legal model"),
        Some((order, corner)) => {
            let mut sensor = SimulatedSensor::new(model.clone());
            sensor.low_pass = Some(LowPass {
                order,
                corner: corner * RATE,
            });
            let axes = sensor.record(1, cell.samples, RATE, seed);
            axes.expect("a legal sensor").remove(0)
        }
    };
    let fit = whittle(&rate, RATE, &options).expect("a long record");
    let mut row = [0.0; 22];
    for (k, term) in TERMS.into_iter().enumerate() {
        let verdict = fit.get(term).expect("sought").verdict;
        let held = match verdict {
            Verdict::Identified { interval, .. } | Verdict::Present { interval, .. } => {
                interval.0 <= truth[k] && truth[k] <= interval.1
            }
            _ => verdict.upper().is_none_or(|u| truth[k] <= u),
        };
        row[k] = flag(held);
        row[5 + k] = flag(verdict.is_identified());
        row[10 + k] = flag(verdict.value().is_some());
    }
    row[15] = flag(fit.discrepancy > 0.0);
    row[16] = flag(fit.band.cut);
    let white = fit.model.white / model.white - 1.0;
    row[17] = white;
    row[18] = white * white;
    let process = fit.get(Term::GaussMarkov);
    if let Some((low, high)) = process.and_then(|p| p.verdict.interval()) {
        let inside = |value: f64, limits: (f64, f64)| flag(limits.0 <= value && value <= limits.1);
        row[19] = 1.0;
        row[20] = inside(DEVIATION, (low, high));
        let time = process.and_then(|p| p.parameter).and_then(|t| t.interval);
        row[21] = time.map_or(0.0, |limits| inside(TIME, limits));
    }
    row
}

fn flag(yes: bool) -> f64 {
    f64::from(u8::from(yes))
}

fn main() {
    let argument = |k: usize| std::env::args().nth(k).and_then(|a| a.parse::<u64>().ok());
    let records = argument(1).unwrap_or(500);
    let first = argument(2).unwrap_or(0);
    let only = std::env::args().nth(3);
    println!("{records} records a cell: % holding the truth | % identified / % excluding zero");
    println!(
        "{:13} {:^16} {:^16} {:^16} {:^16} {:^16} misfit  cut  bias of N, %",
        "", "Q", "N", "B", "K", "R"
    );
    for (index, cell) in cells().iter().enumerate() {
        if only.as_deref().is_some_and(|o| o != cell.name) {
            continue;
        }
        let counts = (0..records)
            .into_par_iter()
            .map(|k| examine(cell, (index as u64) << 32 | (first + k)))
            .reduce(
                || [0.0; 22],
                |mut a, b| {
                    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                    a
                },
            );
        let share = |n: f64| 100.0 * n / records as f64;
        print!("{:13}", cell.name);
        for k in 0..5 {
            print!(
                " {:5.1}|{:4.1}/{:5.1}",
                share(counts[k]),
                share(counts[5 + k]),
                share(counts[10 + k])
            );
        }
        let (bias, square) = (share(counts[17]), share(counts[18]));
        let scatter = (100.0 * square - bias * bias).max(0.0).sqrt() / (records as f64).sqrt();
        print!(
            "   {:4.1}  {:4.1}  {bias:+.2}({scatter:.2})",
            share(counts[15]),
            share(counts[16])
        );
        if cell.sought {
            let of_found = |n: f64| 100.0 * n / f64::max(counts[19], 1.0);
            print!(
                "  GM found {:.1}, its sigma held {:.1}, its time {:.1}",
                share(counts[19]),
                of_found(counts[20]),
                of_found(counts[21])
            );
        }
        println!();
    }
}

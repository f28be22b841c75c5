//! The acceptance case in full: 400 Hz, 11 000 s, N = 0.00250199, K = 6.97244e-5, as many records as asked for.
//!
//! `cargo run --release --example acceptance -- 500`. Prints how often the truth lies in the 95 % intervals and how
//! often bias instability and quantisation are refused. The test-suite runs the same case averaged to 10 Hz.

use proofmass_noise::{FitOptions, NoiseModel, Term, simulate, whittle};
use rand::SeedableRng;

fn main() {
    let records: u64 = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(500);
    let (n, k) = (0.00250199, 6.97244e-5);
    let model = NoiseModel {
        white: n,
        random_walk: k,
        ..Default::default()
    };
    let mut inside = [0_u64; 2];
    let mut refused = [0_u64; 2];
    for seed in 0..records {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
        let rate = simulate(&model, 4_400_000, 400.0, &mut rng).expect("the model is legal");
        let fit = whittle(&rate, 400.0, &FitOptions::default()).expect("the record is long enough");
        for (count, (term, truth)) in inside
            .iter_mut()
            .zip([(Term::White, n), (Term::RandomWalk, k)])
        {
            let interval = fit.get(term).and_then(|c| c.verdict.interval());
            *count += u64::from(interval.is_some_and(|(low, high)| low <= truth && truth <= high));
        }
        for (count, term) in refused.iter_mut().zip([Term::Flicker, Term::Quantisation]) {
            *count += u64::from(fit.value(term).is_none());
        }
    }
    let share = |count: u64| 100.0 * count as f64 / records as f64;
    println!("{records} records of 4.4 million samples");
    println!("N in its 95 % interval: {:.1} %", share(inside[0]));
    println!("K in its 95 % interval: {:.1} %", share(inside[1]));
    println!("B not identifiable:     {:.1} %", share(refused[0]));
    println!("Q not identifiable:     {:.1} %", share(refused[1]));
}

//! The acceptance case in full: 400 Hz, 11 000 s, N = 0.00250199, K = 6.97244e-5, as many records as asked for.
//!
//! `cargo run --release -p proofmass-noise --example acceptance -- 500`. Prints how often the truth lies in the 95 %
//! intervals and how often bias instability and quantisation are refused, by maximum likelihood on the spectrum (the
//! route of `analyse`) and by regression on the Allan curve. The test-suite runs the same case averaged to 10 Hz.

use proofmass_noise::{
    CoefficientFit, FitOptions, NoiseModel, Term, allan_regression, simulate, whittle,
};
use rand::SeedableRng;

const N: f64 = 0.00250199;
const K: f64 = 6.97244e-5;

/// What was counted for one route.
#[derive(Default)]
struct Count {
    records: u64,
    inside: [u64; 2],
    refused: [u64; 2],
    /// Σ and Σ of squares of (K̂ − K)/u.
    score: (f64, f64),
}

impl Count {
    fn add(&mut self, fit: &CoefficientFit) {
        self.records += 1;
        for (count, (term, truth)) in self
            .inside
            .iter_mut()
            .zip([(Term::White, N), (Term::RandomWalk, K)])
        {
            let interval = fit.get(term).and_then(|c| c.verdict.interval());
            *count += u64::from(interval.is_some_and(|(low, high)| low <= truth && truth <= high));
        }
        for (count, term) in self
            .refused
            .iter_mut()
            .zip([Term::Flicker, Term::Quantisation])
        {
            *count += u64::from(fit.value(term).is_none());
        }
        if let Some(proofmass_noise::Verdict::Identified {
            value,
            standard_uncertainty,
            ..
        }) = fit.get(Term::RandomWalk).map(|c| c.verdict)
        {
            let z = (value - K) / standard_uncertainty;
            self.score.0 += z;
            self.score.1 += z * z;
        }
    }

    fn print(&self, name: &str) {
        let n = self.records as f64;
        let share = |count: u64| 100.0 * count as f64 / n;
        let mean = self.score.0 / n;
        println!(
            "{name}: {} records; in their 95 % intervals N {:.1} %, K {:.1} %; not identifiable B {:.1} %, Q {:.1} %; \
             (K̂ − K)/u mean {mean:.2}, spread {:.2}",
            self.records,
            share(self.inside[0]),
            share(self.inside[1]),
            share(self.refused[0]),
            share(self.refused[1]),
            (self.score.1 / n - mean * mean).sqrt()
        );
    }
}

fn main() {
    let argument = |k: usize| std::env::args().nth(k).and_then(|a| a.parse::<u64>().ok());
    let records = argument(1).unwrap_or(500);
    let first = argument(2).unwrap_or(0);
    let model = NoiseModel {
        white: N,
        random_walk: K,
        ..Default::default()
    };
    let (mut likelihood, mut regression) = (Count::default(), Count::default());
    for seed in first..first + records {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
        let rate = simulate(&model, 4_400_000, 400.0, &mut rng).expect("the model is legal");
        let options = FitOptions::default();
        likelihood.add(&whittle(&rate, 400.0, &options).expect("the record is long enough"));
        regression
            .add(&allan_regression(&rate, 400.0, &options).expect("the record is long enough"));
        if (seed + 1 - first).is_multiple_of(50) || seed + 1 == first + records {
            likelihood.print("maximum likelihood");
            regression.print("Allan regression");
        }
    }
}

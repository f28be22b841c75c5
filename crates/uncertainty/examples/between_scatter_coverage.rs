//! Coverage of the intervals of [`BetweenScatter`]: the table of docs/uncertainty.md.
//!
//! `cargo run --release -p proofmass-uncertainty --example between_scatter_coverage [sets]`
//!
//! The linearised model of a multi-position calibration: n directions (six faces ± 0.06 rad, the others at random), three
//! offsets and six elements of a symmetric matrix. Half of the equations have five times the variance of the others, each
//! estimated with 20 degrees of freedom; σ is the root mean square over all.
use proofmass_uncertainty::{BetweenScatter, DegreesOfFreedom, NoiseDof};
use rand::{RngExt, SeedableRng};
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

const P: usize = 9;
const NU: f64 = 20.0;

fn direction(i: usize, rng: &mut Xoshiro256PlusPlus) -> [f64; 3] {
    let mut normal = || rng.sample::<f64, _>(StandardNormal);
    let mut a = if i < 6 {
        let mut a: [f64; 3] = std::array::from_fn(|_| 0.06 * normal());
        a[i / 2] = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        a
    } else {
        std::array::from_fn(|_| normal())
    };
    let norm = a.iter().map(|x| x * x).sum::<f64>().sqrt();
    a.iter_mut().for_each(|x| *x /= norm);
    a
}

/// Share of the sets, averaged over the nine parameters, in which the interval holds the true value.
fn coverage(n: usize, ratio: f64, sets: usize, rng: &mut Xoshiro256PlusPlus) -> Option<f64> {
    let chi = ChiSquared::new(NU).ok()?;
    let each = NoiseDof::Each(vec![DegreesOfFreedom::new(NU)?; n]);
    let mut held = 0;
    for _ in 0..sets {
        let jacobian: Vec<f64> = (0..n)
            .flat_map(|i| {
                let [x, y, z] = direction(i, rng);
                [x, y, z, x * x, y * y, z * z, x * y, x * z, y * z]
            })
            .collect();
        let variance = |i: usize| {
            if i.is_multiple_of(2) {
                5.0 / 3.0
            } else {
                1.0 / 3.0
            }
        };
        let observed: Vec<f64> = (0..n)
            .map(|i| (variance(i) + ratio * ratio).sqrt() * rng.sample::<f64, _>(StandardNormal))
            .collect();
        let stated: Vec<f64> = (0..n).map(|i| variance(i) * chi.sample(rng) / NU).collect();
        let (x, scatter) =
            BetweenScatter::linear(&jacobian, &observed, &stated, each.clone(), 0.95).ok()?;
        held += (0..P)
            .filter(|&c| x[c].abs() <= scatter.expanded(c))
            .count();
    }
    Some(held as f64 / (P * sets) as f64)
}

fn main() {
    let sets = std::env::args()
        .nth(1)
        .and_then(|s| s.parse().ok())
        .unwrap_or(2000);
    let ratios = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 6.0, 10.0];
    for n in [10, 12, 16, 24, 40] {
        let mut line = format!("| {n} |");
        for (k, ratio) in ratios.iter().enumerate() {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64((100 * n + k) as u64);
            match coverage(n, *ratio, sets, &mut rng) {
                Some(share) => line += &format!(" {:.1} |", 100.0 * share),
                None => line += " – |",
            }
        }
        println!("{line}");
    }
}

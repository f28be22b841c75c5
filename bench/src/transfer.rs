//! Frequency responses of three outputs to one input, 10⁷ samples × 4 channels, beside scipy, run in the same minute.
//!
//! The Python interpreter is taken from the variable PROOFMASS_BENCH_PYTHON, else `python3`; it needs numpy and scipy. The
//! peer takes `scipy.signal.welch` of all channels and `scipy.signal.csd` of each output with the input: what H₁ and coherence
//! need. Ours gives the variance of every line as well.

mod peer;
mod processor;

use peer::{Peers, best};
use processor::processor_time;
use proofmass_core::Unwatched;
use proofmass_signal::Welch;
use proofmass_signal::transfer::{CrossSpectra, Estimator};

const SAMPLES: u64 = 10_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let peers = Peers::run("transfer_peer.py", &[])?;
    let input: Vec<f64> = (0..SAMPLES)
        .map(|k| ((7 * k * k + 3 * k) % 10_007) as f64 / 10_007.0 - 0.5)
        .collect();
    let outputs: Vec<Vec<f64>> = (1..=3)
        .map(|delay: usize| {
            let mut y = vec![0.0; delay];
            y.extend(&input[..input.len() - delay]);
            y
        })
        .collect();
    let views: Vec<&[f64]> = outputs.iter().map(Vec::as_slice).collect();
    let welch = Welch::new(4096);
    let figure = |spectra: &CrossSpectra| -> f64 {
        spectra
            .response(2, Estimator::H1)
            .map_or(f64::NAN, |r| r.value[100].im)
    };
    let (theirs, their_figure) = peers.get("csd")?;
    println!("frequency response, 10⁷ samples × 4 channels, segments of 4096");
    println!(
        "  scipy                     {:8.0} ms              Im H(f₁₀₀) = {their_figure:.9}",
        1e3 * theirs
    );
    let all = std::thread::available_parallelism()?.get();
    for threads in [1, all] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let mut value = f64::NAN;
        let ours = best(3, || {
            value = pool
                .install(|| CrossSpectra::welch(&input, &views, 1.0, &welch, &Unwatched))
                .map_or(f64::NAN, |s| figure(&s));
        });
        println!(
            "  proofmass, {threads} thr.         {:8.0} ms   {:6.1} ×   Im H(f₁₀₀) = {value:.9}",
            1e3 * ours,
            theirs / ours
        );
    }
    let run = || {
        std::hint::black_box(CrossSpectra::welch(&input, &views, 1.0, &welch, &Unwatched).is_ok());
    };
    if let Some(ours) = processor_time(2, run) {
        let (theirs, _) = peers.get("csd_processor")?;
        println!(
            "  processor time: scipy {:.0} ms, ours {:.0} ms   {:.1} ×",
            1e3 * theirs,
            1e3 * ours,
            theirs / ours
        );
    }
    Ok(())
}

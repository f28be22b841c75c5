//! Shock response spectrum, 200 natural frequencies of 10⁶ samples, beside scipy, run in the same minute.
//!
//! The Python interpreter is taken from the variable PROOFMASS_BENCH_PYTHON, else `python3`; it needs numpy and scipy. The
//! peer filters with `scipy.signal.lfilter` and the ramp-invariant coefficients of ISO 18431-4, as Python programs do.

mod peer;
mod processor;

use peer::{Peers, best};
use processor::processor_time;
use proofmass_signal::{Extremes, ShockSpectrum, octaves};

const SAMPLES: u64 = 1_000_000;
const RATE: f64 = 100e3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut record: Vec<f64> = (0..SAMPLES)
        .map(|k| ((7 * k * k + 3 * k) % 101) as f64 / 101.0 - 0.5)
        .collect();
    // What a filter starts with is then the same for both.
    record[0] = 0.0;
    let mut frequencies = octaves(10.0, 10_000.0, 20);
    frequencies.truncate(200);
    assert_eq!(frequencies.len(), 200);
    let spectrum = ShockSpectrum::new(frequencies, 10.0);
    let peers = Peers::run("shock_spectrum_peer.py", &[])?;
    let (theirs, figure) = peers.get("lfilter")?;
    println!("shock response spectrum, 200 natural frequencies, 10⁶ samples");
    println!(
        "  scipy                     {:8.1} ms              Σ maximax = {figure:.9}",
        1e3 * theirs
    );
    let all = std::thread::available_parallelism()?.get();
    for threads in [1, all] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let mut sum = f64::NAN;
        let ours = best(5, || {
            sum = pool
                .install(|| spectrum.evaluate(&record, RATE))
                .map_or(f64::NAN, |s| {
                    s.curve(Extremes::recorded_maximax).iter().sum()
                });
        });
        println!(
            "  proofmass, {threads} thr.         {:8.1} ms   {:6.1} ×   Σ maximax = {sum:.9}",
            1e3 * ours,
            theirs / ours
        );
    }
    let run = || {
        std::hint::black_box(spectrum.evaluate(&record, RATE).is_ok());
    };
    if let Some(ours) = processor_time(5, run) {
        let (theirs, _) = peers.get("lfilter_processor")?;
        println!(
            "  processor time: scipy {:.0} ms, ours {:.0} ms   {:.1} ×",
            1e3 * theirs,
            1e3 * ours,
            theirs / ours
        );
    }
    Ok(())
}

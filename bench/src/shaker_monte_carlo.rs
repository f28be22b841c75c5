//! Monte Carlo of a triaxial calibration beside numpy: 44 configurations, one frequency and nine.
//!
//! The Python interpreter is taken from the variable PROOFMASS_BENCH_PYTHON, else `python3`; it needs numpy. The peer
//! draws trials in batches and is scaled to a million. It estimates twice: by ordinary least squares with gains that are made
//! once, and with the weights of the budget in every trial, as ours does.

mod peer;
mod processor;

use num_complex::Complex64;
use peer::{Peers, best};
use processor::processor_time;
use proofmass_shaker::geometry::published_plan;
use proofmass_shaker::matrix::{Matrix, row_times};
use proofmass_shaker::monte_carlo::{CheckOptions, validate};
use proofmass_shaker::{
    Acts, Budget, ComponentCheck, Key, PhasorRow, ShakerInput, ShakerMethod, SpuriousTable,
};

fn case() -> Result<(Vec<PhasorRow>, Budget), proofmass_core::Error> {
    let s: Matrix = std::array::from_fn(|i| {
        std::array::from_fn(|j| Complex64::new(if i == j { 0.0104 } else { 3e-4 }, 1e-5))
    });
    let rows = published_plan()
        .into_iter()
        .map(|c| {
            let a = c.direction().map(|d| Complex64::new(10.0 * d, 0.0));
            PhasorRow::new("", 160.0, c, Complex64::new(10.0, 0.0), row_times(a, &s))
        })
        .collect();
    let mut inputs = Budget::published_bench().inputs;
    inputs.push(ShakerInput::new(
        "noise",
        Acts::OutputAdditive,
        5e-5,
        &[Key::Run, Key::Channel],
    ));
    inputs.push(ShakerInput::new(
        "reference.phase",
        Acts::ReferencePhase,
        0.003,
        &[Key::Frequency],
    ));
    Ok((rows, Budget::new(inputs)?))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let peers = Peers::run("shaker_monte_carlo_peer.py", &[])?;
    let (rows, budget) = case()?;
    let (theirs, their_u) = peers.get("one_frequency")?;
    println!("Monte Carlo of one frequency, 44 configurations, 10⁶ trials");
    println!(
        "  numpy       {theirs:8.2} s              u(Re S_xx) = {their_u:.4e}, ordinary least squares"
    );
    let (same, same_u) = peers.get("weighted")?;
    println!("  numpy       {same:8.2} s              u(Re S_xx) = {same_u:.4e}, weighted as ours");
    let all = std::thread::available_parallelism()?.get();
    let run = |seed| {
        let mut options = CheckOptions::default();
        options.trials = 100_000;
        options.seed = seed;
        let table = SpuriousTable::default();
        let go = |_| std::ops::ControlFlow::Continue(());
        validate(
            ShakerMethod::Complex,
            &rows,
            &table,
            &budget,
            &options,
            &mut { go },
        )
    };
    for threads in [1, all] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let mut components: Vec<ComponentCheck> = vec![];
        // A tenth of the peer's trials, scaled to as many.
        let ours = 10.0
            * best(3, || {
                let checks = pool.install(|| run(1)).unwrap_or_default();
                components = checks.into_iter().flat_map(|c| c.components).collect();
            });
        let u = components
            .first()
            .map_or(f64::NAN, |v| v.monte_carlo.unwrap_or(f64::NAN));
        println!(
            "  {threads} thread{}   {ours:8.2} s   {:6.1} ×   u(Re S_xx) = {u:.4e}; {:.0} × the weighted one",
            if threads == 1 { " " } else { "s" },
            theirs / ours,
            same / ours
        );
    }
    let used = processor_time(1, || {
        let _ = std::hint::black_box(run(1));
    });
    if let Some(ours) = used.map(|t| 10.0 * t) {
        let (theirs, _) = peers.get("one_frequency_processor")?;
        let (weighted, _) = peers.get("weighted_processor")?;
        println!(
            "  processor time: numpy {theirs:.2} s, weighted {weighted:.2} s, ours {ours:.2} s   {:.1} × and {:.0} × on one core",
            theirs / ours,
            weighted / ours
        );
    }
    let nine = 10.0
        * best(1, || {
            for seed in 0..9 {
                let _ = std::hint::black_box(run(seed));
            }
        });
    println!("  nine frequencies, {all} threads: {nine:.1} s");
    Ok(())
}

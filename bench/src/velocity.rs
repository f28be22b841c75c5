//! One step of the Kalman filter beside filterpy's, on the same readings, run in the same minute.
//!
//! The Python interpreter is taken from the variable PROOFMASS_BENCH_PYTHON, else `python3`; it needs numpy and
//! filterpy. The peer runs alone, before ours. Costs of the other estimators: the example `step_cost` of the core
//! crate; instructions: `bench/instructions.py`.

use proofmass_core::velocity::{Hold, Kalman, KalmanState, MotionNoise, ProcessNoise};
use std::hint::black_box;
use std::process::Command;
use std::time::Instant;

const SAMPLES: usize = 20_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let python = std::env::var("PROOFMASS_BENCH_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/src/velocity_peer.py");
    let output = Command::new(&python).arg(script).output()?;
    if !output.status.success() {
        return Err(format!("{python}: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    let text = String::from_utf8(output.stdout)?;
    let mut words = text.split_whitespace();
    let (Some(time), Some(velocity)) = (words.next(), words.next()) else {
        return Err(format!("two numbers were expected: {text}").into());
    };
    let (peer, their_velocity): (f64, f64) = (time.parse()?, velocity.parse()?);

    let dt = 1e-3;
    let noise = MotionNoise {
        acceleration: 4e-4,
        form: ProcessNoise::SampleConstant,
        position: 7e-8,
    };
    let kalman = Kalman::<f64, 2>::new(&noise, Hold::Zero, dt)?;
    let signal: Vec<(f64, f64)> = (0..SAMPLES)
        .map(|k| (25.0 * dt * k as f64).sin())
        .map(|s| (0.06 * s, -37.5 * s))
        .collect();
    let (mut best, mut velocity) = (f64::INFINITY, 0.0);
    for _ in 0..50 {
        let mut state = KalmanState::new([0.0; 2], [1.0; 2], signal[0].1);
        let start = Instant::now();
        for &(x, a) in &signal[1..] {
            kalman.step(&mut state, Some(black_box(x)), black_box(a));
        }
        best = best.min(start.elapsed().as_secs_f64() / (SAMPLES - 1) as f64);
        velocity = state.x[1];
    }
    println!(
        "filterpy {:.2} us, ours {:.1} ns a step: {:.0} times; velocities differ by {:.1e}",
        1e6 * peer,
        1e9 * best,
        peer / best,
        (velocity - their_velocity).abs()
    );
    Ok(())
}

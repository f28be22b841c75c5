//! Compensated samples per second on one core, in memory: linear model, temperature, temperature and curvature.
//!
//! ```text
//! cargo run --release -p proofmass-bench --bin compensation
//! ```

use proofmass_core::{Compensation, Curvature, Error, Matrix3, SensorModel, ThermalTerms};
use std::hint::black_box;
use std::time::Instant;

/// Three-axis samples in a piece: 24 B each in and out, within the second cache.
const PIECE: usize = 8192;
const PIECES: usize = 4096;

/// Million samples per second, the best of five runs.
fn rate(mut work: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let begin = Instant::now();
        for _ in 0..PIECES {
            work();
        }
        best = best.min(begin.elapsed().as_secs_f64());
    }
    (PIECE * PIECES) as f64 / best / 1e6
}

fn main() -> Result<(), Error> {
    let k = Matrix3([[415.0, 1.25, 4.0], [0.0, 412.5, 8.75], [0.5, 0.0, 414.0f32]]);
    let sensor = SensorModel::new(k, [33_120.0, 33_271.0, 32_366.0])?;
    let thermal = ThermalTerms {
        reference: 25.0,
        range: [-40.0, 85.0],
        bias: [[0.4, -1e-3, 2e-6]; 3],
        scale: [[2e-4, 1e-7, 0.0]; 3],
    };
    let curvature = Curvature {
        quadratic: [1e-5; 3],
        cubic: [1e-7; 3],
    };
    let column = |axis: usize| -> Vec<f32> {
        (0..PIECE)
            .map(|i| 32_000.0 + ((axis * 7919 + i * 104_729) % 4000) as f32)
            .collect()
    };
    let [x, y, z] = [column(0), column(1), column(2)];
    let temperature: Vec<f32> = (0..PIECE).map(|i| 20.0 + (i % 100) as f32 * 0.1).collect();
    let mut out = [
        vec![0.0f32; PIECE],
        vec![0.0f32; PIECE],
        vec![0.0f32; PIECE],
    ];
    let mut failed = None;
    let linear = rate(|| {
        let [ax, ay, az] = &mut out;
        failed = sensor
            .apply_columns([black_box(&x), &y, &z], [ax, ay, az])
            .err();
        black_box(&mut out);
    });
    println!("| model | million samples/s | share of the linear model |\n|---|---|---|");
    println!("| linear, single precision | {linear:.0} | 1 |");
    for (name, model) in [
        (
            "temperature",
            Compensation::new(sensor, Some(thermal), None, 0.0)?,
        ),
        (
            "temperature and curvature",
            Compensation::new(sensor, Some(thermal), Some(curvature), 80.0)?,
        ),
    ] {
        let rate = rate(|| {
            let [ax, ay, az] = &mut out;
            failed = model
                .apply_columns([black_box(&x), &y, &z], &temperature, [ax, ay, az])
                .err();
            black_box(&mut out);
        });
        println!(
            "| {name}, single precision | {rate:.0} | {:.2} |",
            rate / linear
        );
    }
    failed.map_or(Ok(()), Err)
}

//! Wall-clock times of the statistics at the sizes that occur in use. `cargo run --release --example speed`.

use proofmass_noise::{
    AnalysisOptions, Channel, DeviationOptions, FitOptions, NoiseModel, NoiseType, Record, Sensor,
    Statistic, StreamingAllan, allan_regression, analyse, deviation, disturbances, simulate,
    whittle,
};
use proofmass_signal::Welch;
use rand::SeedableRng;
use std::hint::black_box;
use std::time::Instant;

/// Shortest of some runs, in seconds.
fn best<T>(runs: usize, mut f: impl FnMut() -> T) -> f64 {
    (0..runs)
        .map(|_| {
            let start = Instant::now();
            black_box(f());
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

fn main() {
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(1);
    let white = NoiseModel {
        white: 0.1,
        ..Default::default()
    };
    let rate = simulate(&white, 10_000_000, 100.0, &mut rng).unwrap();

    let options = DeviationOptions {
        noise: Some(NoiseType::White),
        ..Default::default()
    };
    let oadev = best(7, || {
        deviation(
            Record::Rate(&rate),
            100.0,
            Statistic::OverlappingAllan,
            &options,
        )
    });
    let with_identification = best(3, || {
        deviation(
            Record::Rate(&rate),
            100.0,
            Statistic::OverlappingAllan,
            &Default::default(),
        )
    });
    // What the memory alone costs: one pass of reading, one of writing.
    let mut copy = vec![0.0; rate.len()];
    let pass = best(5, || copy.copy_from_slice(&rate));
    println!(
        "OADEV, octave taus, 1e7 samples: {oadev:.4} s ({with_identification:.4} s with noise types); copying the samples once: {pass:.4} s"
    );

    let short = &rate[..2000];
    let mtot = best(20, || {
        deviation(
            Record::Rate(short),
            1.0,
            Statistic::ModifiedTotal,
            &Default::default(),
        )
    });
    println!("MTOTDEV, octave taus, 2000 samples: {:.6} s", mtot);

    for segment in [256, 1024, 4096, 65_536] {
        let welch = best(5, || Welch::new(segment).density(&rate, 100.0));
        println!("Welch, segments of {segment}, 1e7 samples: {welch:.4} s");
    }

    let stream = best(3, || {
        let mut stream = StreamingAllan::new(100.0).unwrap();
        for piece in rate.chunks(65_536) {
            stream.push(piece).unwrap();
        }
        stream.curve(0.95)
    });
    println!("stream, 1e7 samples: {stream:.4} s");

    let model = NoiseModel {
        white: 3e-4,
        random_walk: 1e-5,
        ..Default::default()
    };
    let three_hours = simulate(&model, 1_080_000, 100.0, &mut rng).unwrap();
    let fit = FitOptions::default();
    println!("100 Hz for 3 h:");
    println!(
        "  Whittle {:.4} s",
        best(3, || whittle(&three_hours, 100.0, &fit))
    );
    println!(
        "  regression {:.4} s",
        best(3, || allan_regression(&three_hours, 100.0, &fit))
    );
    println!(
        "  disturbances {:.4} s",
        best(3, || disturbances(&three_hours, 100.0, 1e-4))
    );
    let channel = Channel {
        name: "x",
        sensor: Some(Sensor::Accelerometer),
        unit: "m/s²",
        rate: &three_hours,
    };
    let three = [channel; 3];
    println!(
        "  whole analysis, three channels {:.4} s",
        best(3, || analyse(
            &three,
            None,
            100.0,
            &AnalysisOptions::default()
        ))
    );
}

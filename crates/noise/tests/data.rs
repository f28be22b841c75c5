//! Data as they come: stamps that jitter, rows that are missing, converters that clip.

use proofmass_noise::{
    AnalysisOptions, ConverterTrace, NoiseChannel, NoiseModel, analyse, converter_traces, simulate,
};
use proofmass_signal::clock::read;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;

fn noise(n: usize, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let model = NoiseModel {
        white: 1.0,
        ..Default::default()
    };
    simulate(&model, n, 1.0, &mut rng).unwrap()
}

/// Jitter of a tenth and a fifth of the interval: no sample is lost to it, and the rate is that of the clock.
#[test]
fn law_jitter_keeps_every_sample() {
    let n = 100_000;
    for (jitter, seed) in [(0.02, 1), (0.1, 2), (0.2, 3), (0.3, 4)] {
        let e = noise(n, seed);
        let stamps: Vec<f64> = (0..n).map(|k| 0.01 * (k as f64 + jitter * e[k])).collect();
        let (line, slips) = read(&stamps, None).unwrap();
        assert_eq!(slips, [], "{jitter}");
        assert!(
            (line.rate_hz / 100.0 - 1.0).abs() < 1e-5,
            "{jitter}: {}",
            line.rate_hz
        );
        assert!(
            ((line.scatter_s * line.rate_hz) / jitter - 1.0).abs() < 0.05,
            "{jitter}: {}",
            (line.scatter_s * line.rate_hz)
        );
    }
    // As the analysis sees it.
    let e = noise(20_000, 9);
    let stamps: Vec<f64> = (0..20_000)
        .map(|k| 0.01 * (k as f64 + 0.2 * e[k]))
        .collect();
    let y = noise(20_000, 10);
    let channel = NoiseChannel {
        name: "x",
        sensor: None,
        unit: "V",
        rate: &y,
    };
    let analysis = analyse(
        &[channel],
        Some(&stamps),
        100.0,
        &AnalysisOptions::default(),
    )
    .unwrap();
    assert_eq!(analysis.channels[0].samples, 20_000);
    assert!(analysis.gaps.is_empty());
}

/// Samples that are really lost are found where they are, under jitter, and the rate does not suffer.
#[test]
fn law_lost_samples_are_found_under_jitter() {
    let n = 50_000;
    for jitter in [0.0, 0.1] {
        let e = noise(n, 5);
        let mut lost = 0;
        let stamps: Vec<f64> = (0..n)
            .map(|k| {
                if k > 0 && k % 1000 == 0 {
                    lost += 1 + (k / 1000) % 3;
                }
                0.01 * ((k + lost) as f64 + jitter * e[k])
            })
            .collect();
        let (line, slips) = read(&stamps, None).unwrap();
        let found: Vec<(usize, i64)> = slips.iter().map(|s| (s.row, s.samples)).collect();
        let truth: Vec<(usize, i64)> = (1..50)
            .map(|k| (1000 * k, i64::try_from(1 + k % 3).unwrap()))
            .collect();
        assert_eq!(found, truth, "jitter {jitter}");
        assert!(
            (line.rate_hz / 100.0 - 1.0).abs() < 1e-5,
            "{}",
            line.rate_hz
        );
    }
}

/// Stamps on arrival of packets of ten samples, and a hundred single late ones, lose nothing.
#[test]
fn law_bursts_lose_nothing() {
    let n = 20_000;
    let bursts: Vec<f64> = (0..n)
        .map(|k| 0.01 * (k / 10 * 10 + 9) as f64 + 1e-5 * (k % 10) as f64)
        .collect();
    let (line, slips) = read(&bursts, None).unwrap();
    assert_eq!(slips, []);
    assert!(
        (line.rate_hz / 100.0 - 1.0).abs() < 1e-4,
        "{}",
        line.rate_hz
    );
    let late: Vec<f64> = (0..n)
        .map(|k| 0.01 * (k as f64 + if k % 200 == 77 { 0.8 } else { 0.0 }))
        .collect();
    let (line, slips) = read(&late, None).unwrap();
    assert_eq!(slips, []);
    assert!(
        (line.rate_hz / 100.0 - 1.0).abs() < 1e-5,
        "{}",
        line.rate_hz
    );
}

/// Rows lost at random from an even grid, one in a hundred to one in three: each is a gap, and the rate is that of the grid.
#[test]
fn law_rows_lost_from_a_grid_are_gaps() {
    for (seed, lost) in [(1, 0.01), (2, 0.05), (3, 0.2), (4, 0.33)] {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let chance = Uniform::new(0.0, 1.0).unwrap();
        let mut missing = 0;
        let mut stamps = Vec::new();
        for k in 0..20_000 {
            // The first and the last are there, so that all that is lost lies between.
            if k == 0 || k == 19_999 || chance.sample(&mut rng) > lost {
                // Microseconds of a clock that is a little fast.
                stamps.push((f64::from(k) * 10_000.1).round() * 1e-6);
            } else {
                missing += 1;
            }
        }
        let (line, slips) = read(&stamps, None).unwrap();
        assert!(
            (line.rate_hz * 0.010_000_1 - 1.0).abs() < 1e-6,
            "{lost}: {}",
            line.rate_hz
        );
        assert_eq!(
            slips.iter().map(|s| s.samples).sum::<i64>(),
            missing,
            "{lost}"
        );
    }
}

#[test]
fn refuses_stamps_without_a_clock() {
    assert!(read(&[0.0, 1.0], None).is_err());
    assert!(read(&[1.0; 100], None).is_err());
    assert!(read(&[0.0, f64::NAN, 2.0], None).is_err());
    let back: Vec<f64> = (0..100).map(|k| -f64::from(k)).collect();
    assert!(read(&back, None).is_err());
}

#[test]
fn known_converter_traces() {
    let y = noise(20_000, 20);
    let clipped: Vec<f64> = y.iter().map(|v| v.min(1.0)).collect();
    assert!(matches!(
        converter_traces(&clipped)[..],
        [ConverterTrace::Clipped { rail: 1.0, share }] if (share - 0.1587).abs() < 0.01
    ));
    for (lsb, coarse) in [(0.4, false), (2.0, true), (4.0, true)] {
        let steps: Vec<f64> = y.iter().map(|v| (v / lsb).round() * lsb).collect();
        let traces = converter_traces(&steps);
        let found = matches!(traces[..], [ConverterTrace::Coarse { .. }]);
        assert_eq!(found, coarse, "{lsb}: {traces:?}");
        assert!(coarse || traces.is_empty(), "{lsb}: {traces:?}");
    }
    let held: Vec<f64> = (0..20_000).map(|k| y[k / 4]).collect();
    assert!(matches!(
        converter_traces(&held)[..],
        [ConverterTrace::Repeated { share }] if (share - 0.75).abs() < 0.01
    ));
}

/// An output that stood still is named with its size, also where the values come in steps, and not as a sensor that is slower.
#[test]
fn known_standstill() {
    for lsb in [0.0, 0.5] {
        let mut y = noise(20_000, 21);
        if lsb > 0.0 {
            y.iter_mut().for_each(|v| *v = (*v / lsb).round() * lsb);
        }
        let value = y[4000];
        y[4000..10_000].fill(value);
        let traces = converter_traces(&y);
        assert!(
            matches!(
                traces[..],
                [ConverterTrace::Frozen {
                    first: 3999..=4000,
                    longest: 6000..=6010,
                    ..
                }]
            ),
            "{lsb}: {traces:?}"
        );
    }
}

/// Healthy records: white noise, noise in fine steps, a walk.
#[test]
fn law_healthy_records_show_no_trace() {
    for seed in 0..500 {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut level = 0.0;
        let y: Vec<f64> = (0..5000)
            .map(|_| {
                let e: f64 = StandardNormal.sample(&mut rng);
                let w: f64 = StandardNormal.sample(&mut rng);
                match seed % 3 {
                    0 => e,
                    1 => (e / 0.4).round() * 0.4,
                    _ => {
                        level += 0.05 * w;
                        level + 0.3 * e
                    }
                }
            })
            .collect();
        assert!(
            converter_traces(&y).is_empty(),
            "{seed}: {:?}",
            converter_traces(&y)
        );
    }
}

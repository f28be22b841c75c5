//! The whole analysis: simulators against theory, streams against records, disturbances, refusals.

use proofmass_core::{Error, OctaveAllan};
use proofmass_noise::{
    AnalysisOptions, DeviationOptions, FrontEnd, Gaps, GaussMarkov, NoiseChannel, NoiseModel,
    NoiseRecord, Sensor, Sinusoid, Statistic, StreamingAllan, Taus, Term, Verdict, analyse,
    consistency, deviation, simulate,
};
use proofmass_signal::Welch;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::path::PathBuf;

fn record(model: &NoiseModel, samples: usize, rate: f64, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    simulate(model, samples, rate, &mut rng).unwrap()
}

fn channel<'a>(rate: &'a [f64]) -> NoiseChannel<'a> {
    NoiseChannel {
        name: "x",
        sensor: Some(Sensor::Accelerometer),
        unit: "m/s²",
        rate,
    }
}

/// Every simulated process has the Allan variance of the model. The mean over 40 records is compared; its standard
/// error follows from the records themselves and five of them are allowed, 12 τ × 7 processes.
#[test]
fn law_simulated_allan_variances() {
    let processes = [
        NoiseModel {
            white: 0.3,
            ..Default::default()
        },
        NoiseModel {
            random_walk: 0.2,
            ..Default::default()
        },
        NoiseModel {
            quantisation: 0.01,
            ..Default::default()
        },
        NoiseModel {
            flicker: 0.5,
            ..Default::default()
        },
        NoiseModel {
            ramp: 0.02,
            white: 0.01,
            ..Default::default()
        },
        NoiseModel {
            gauss_markov: vec![GaussMarkov {
                standard_deviation: 0.4,
                correlation_time: 2.0,
            }],
            ..Default::default()
        },
        NoiseModel {
            sinusoids: vec![Sinusoid {
                amplitude: 0.7,
                frequency: 0.31,
                phase: 0.4,
            }],
            white: 0.01,
            ..Default::default()
        },
    ];
    let rate = 10.0;
    for (index, model) in processes.iter().enumerate() {
        let options = DeviationOptions {
            // From eight samples on: below, sampled processes differ from continuous ones.
            taus: Taus::Factors((4..10).map(|k| 1 << k).collect()),
            ..Default::default()
        };
        let curves: Vec<Vec<f64>> = (0..40)
            .map(|seed| {
                let y = record(model, 8192, rate, 100 * index as u64 + seed);
                let curve = deviation(
                    NoiseRecord::Rate(&y),
                    rate,
                    Statistic::OverlappingAllan,
                    &options,
                )
                .unwrap();
                curve
                    .points
                    .iter()
                    .map(|p| p.deviation * p.deviation)
                    .collect()
            })
            .collect();
        for (k, m) in (4..10).map(|k| 1 << k).enumerate() {
            let values: Vec<f64> = curves.iter().map(|c| c[k]).collect();
            let mean = values.iter().sum::<f64>() / 40.0;
            let spread = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 39.0;
            let error = (spread / 40.0).sqrt();
            let expected = model.allan_variance(f64::from(m) / rate);
            // Sampled walks and Gauss–Markov processes exceed continuous ones by 1/(2m²) ≤ 0.2 %, flicker and
            // sinusoids by (π f τ0)²/6; a finite record cuts the sinusoid's mean by less than 1 %.
            assert!(
                (mean - expected).abs() < 5.0 * error + 0.01 * expected,
                "process {index}, m = {m}: {mean:e}, expected {expected:e} ± {error:e}"
            );
        }
    }
}

/// The stream agrees with the record to rounding up to m = 8, and within a small share of its uncertainty beyond.
#[test]
fn law_stream_is_the_record() {
    let model = NoiseModel {
        white: 1.0,
        random_walk: 0.05,
        ..Default::default()
    };
    let y: Vec<f64> = record(&model, 50_000, 100.0, 5)
        .iter()
        .map(|v| v + 9.8)
        .collect();
    let whole = deviation(
        NoiseRecord::Rate(&y),
        100.0,
        Statistic::OverlappingAllan,
        &DeviationOptions::default(),
    )
    .unwrap();
    let mut stream = StreamingAllan::new(100.0).unwrap();
    let mut rest = &y[..];
    for size in [1, 2, 3, 17, 4096, 2047, 2049, 1000].iter().cycle() {
        let (piece, tail) = rest.split_at((*size).min(rest.len()));
        stream.push(piece).unwrap();
        rest = tail;
        if rest.is_empty() {
            break;
        }
    }
    let curve = stream.curve(0.95).unwrap();
    assert!(curve.points.len() >= whole.points.len() - 1);
    for (a, b) in curve.points.iter().zip(&whole.points) {
        assert_eq!(a.factor, b.factor);
        let relative = (a.deviation / b.deviation - 1.0).abs();
        if a.factor <= 8 {
            assert_eq!(a.terms, b.terms);
            assert!(relative < 1e-10, "m = {}: {relative:e}", a.factor);
        } else {
            // A quarter of the standard uncertainty 1/√(2ν).
            let u = 1.0 / (2.0 * b.edf.unwrap()).sqrt();
            assert!(
                relative < 0.25 * u,
                "m = {}: {relative:e} against {u:e}",
                a.factor
            );
        }
    }
}

/// The chip takes the differences of the desk: the same numbers to rounding in both precisions and for counts, gaps included.
#[test]
fn crosscheck_chip_and_desk() {
    let model = NoiseModel {
        white: 20.0,
        random_walk: 0.5,
        ..Default::default()
    };
    let counts: Vec<i32> = record(&model, 70_000, 1.0, 11)
        .iter()
        .map(|v| (v + 16_384.0).round() as i32)
        .collect();
    let mut desk = StreamingAllan::new(1.0).unwrap();
    let mut double = OctaveAllan::<f64, 11>::new();
    let mut single = OctaveAllan::<f32, 11>::new();
    let mut exact = OctaveAllan::<i64, 11>::new();
    for (i, run) in counts.chunks(23_457).enumerate() {
        if i > 0 {
            desk.gap();
            double.gap();
            single.gap();
            exact.gap();
        }
        let piece: Vec<f64> = run.iter().map(|c| f64::from(*c)).collect();
        desk.push(&piece).unwrap();
        for c in run {
            double.push(f64::from(*c)).unwrap();
            single.push(*c as f32).unwrap();
            exact.push(*c).unwrap();
        }
    }
    let curve = desk.curve(0.95).unwrap();
    assert_eq!(curve.points.len(), 14);
    for (octave, p) in curve.points.iter().enumerate() {
        let d = double.deviation(octave).unwrap();
        assert_eq!((d.factor, d.terms), (p.factor as u64, p.terms as u64));
        let near = |v: f64, limit: f64| (v / p.deviation - 1.0).abs() < limit;
        assert!(near(d.deviation, 1e-12), "m = {}", p.factor);
        let s = single.deviation(octave).unwrap().deviation;
        assert!(near(f64::from(s), 1e-5), "m = {}", p.factor);
        let e = exact.deviation(octave).unwrap().deviation;
        assert!(near(f64::from(e), 1e-6), "m = {}", p.factor);
    }
    assert!(double.deviation(14).is_none());
    // What the guide to firmware states for ten levels.
    let size = size_of::<OctaveAllan<f32, 10>>();
    assert!((1000..1150).contains(&size), "{size}");
    let size = size_of::<OctaveAllan<i64, 10>>();
    assert!((1700..1850).contains(&size), "{size}");
}

/// Nothing reaches across a gap: two halves at different levels look like one noise.
#[test]
fn law_stream_does_not_bridge_gaps() {
    let y = record(
        &NoiseModel {
            white: 1.0,
            ..Default::default()
        },
        20_000,
        1.0,
        6,
    );
    let mut stream = StreamingAllan::new(1.0).unwrap();
    stream.push(&y[..10_000]).unwrap();
    stream.gap();
    let shifted: Vec<f64> = y[10_000..].iter().map(|v| v + 1000.0).collect();
    stream.push(&shifted).unwrap();
    for p in stream.curve(0.95).unwrap().points {
        let expected = 1.0 / p.tau.sqrt();
        assert!(
            p.deviation < 3.0 * expected,
            "m = {}: {}",
            p.factor,
            p.deviation
        );
    }
}

/// `[IEEE952]` annex C: the Allan variance is an integral of the density.
#[test]
fn law_density_gives_the_allan_curve() {
    let model = NoiseModel {
        white: 1.0,
        gauss_markov: vec![GaussMarkov {
            standard_deviation: 3.0,
            correlation_time: 0.5,
        }],
        ..Default::default()
    };
    let y = record(&model, 400_000, 100.0, 12);
    let curve = deviation(
        NoiseRecord::Rate(&y),
        100.0,
        Statistic::OverlappingAllan,
        &DeviationOptions::default(),
    )
    .unwrap();
    let density = Welch::new(8192).density(&y, 100.0).unwrap();
    let points = consistency(&density, &curve);
    assert!(points.len() > 8);
    for p in points {
        // Both come from the same record: they agree far better than either with the truth.
        let bound = 0.01 + 0.5 * p.relative_uncertainty;
        assert!(
            (p.ratio() - 1.0).abs() < bound,
            "τ = {}: {}",
            p.tau,
            p.ratio()
        );
    }
}

/// A line and a Gauss–Markov process, sought by name, are identified with their truth inside the interval.
#[test]
fn law_line_and_markov_are_identified() {
    let model = NoiseModel {
        white: 1e-3,
        gauss_markov: vec![GaussMarkov {
            standard_deviation: 2e-3,
            correlation_time: 3.0,
        }],
        sinusoids: vec![Sinusoid {
            amplitude: 1e-3,
            frequency: 12.34,
            phase: 1.0,
        }],
        ..Default::default()
    };
    let y = record(&model, 200_000, 100.0, 21);
    let mut options = proofmass_noise::FitOptions::default();
    options.terms.extend([Term::GaussMarkov, Term::Sinusoid]);
    let fit = proofmass_noise::whittle(&y, 100.0, &options).unwrap();
    let line = fit.get(Term::Sinusoid).expect("a line");
    assert!((line.parameter.unwrap().value - 12.34).abs() < 1e-4);
    assert!((line.verdict.value().unwrap() / 1e-3 - 1.0).abs() < 0.05);
    let markov = fit.get(Term::GaussMarkov).unwrap();
    assert!(
        (markov.verdict.value().unwrap() / 2e-3 - 1.0).abs() < 0.15,
        "{markov:?}"
    );
    let time = markov.parameter.unwrap();
    let (low, high) = time.interval.unwrap();
    assert!(low < 3.0 && 3.0 < high && high < 6.0, "{markov:?}");
    assert!((fit.value(Term::White).unwrap() / 1e-3 - 1.0).abs() < 0.02);
    assert_eq!(fit.value(Term::RandomWalk), None);
}

/// A drift is a ramp when it exceeds the noise, in both estimators' words.
#[test]
fn law_ramp_is_identified() {
    let model = NoiseModel {
        white: 1e-3,
        ramp: 1e-5,
        ..Default::default()
    };
    let y = record(&model, 100_000, 100.0, 31);
    let fit = proofmass_noise::whittle(&y, 100.0, &Default::default()).unwrap();
    let (low, high) = fit.get(Term::Ramp).unwrap().verdict.interval().unwrap();
    assert!(low < 1e-5 && 1e-5 < high);
    assert_eq!(fit.value(Term::RandomWalk), None);
}

#[test]
fn refuses_or_explains_bad_records() {
    let y = record(
        &NoiseModel {
            white: 1.0,
            ..Default::default()
        },
        4000,
        100.0,
        41,
    );
    let options = AnalysisOptions::default();
    // Fewer than ten samples.
    assert_eq!(
        analyse(&[channel(&y[..9])], None, 100.0, &options),
        Err(Error::TooFew {
            name: "samples without a gap between them",
            needed: 10,
            got: 9
        })
    );
    assert!(analyse(&[channel(&y[..10])], None, 100.0, &options).is_ok());
    assert!(analyse(&[], None, 100.0, &options).is_err());
    // τ beyond the record.
    let mut long = options.clone();
    long.deviation.taus = Taus::Chosen(vec![1.0, 1000.0]);
    assert!(matches!(
        analyse(&[channel(&y)], None, 100.0, &long),
        Err(Error::OutOfRange {
            name: "tau",
            value: 1000.0,
            ..
        })
    ));
    // A constant channel beside a good one.
    let constant = vec![1.0; y.len()];
    let both = analyse(&[channel(&constant), channel(&y)], None, 100.0, &options).unwrap();
    assert_eq!(both.channels[0].findings[0].code(), "constant-channel");
    assert!(both.channels[0].curve.is_none() && both.channels[1].whittle.is_some());
    // A missing row: refused, or the longest stretch with a finding.
    let mut holes = y.clone();
    holes[1000] = f64::NAN;
    let refuse = AnalysisOptions {
        gaps: Gaps::Refuse,
        ..options.clone()
    };
    assert_eq!(
        analyse(&[channel(&holes)], None, 100.0, &refuse),
        Err(Error::NotFinite {
            name: "rate",
            index: 1000
        })
    );
    let both_sides = analyse(&[channel(&holes)], None, 100.0, &options).unwrap();
    assert_eq!(both_sides.stretches, [(0, 1000), (1001, 4000)]);
    assert_eq!(both_sides.channels[0].samples, 3999);
    assert_eq!(both_sides.findings[0].code(), "gaps-in-record");
    let one = AnalysisOptions {
        gaps: Gaps::LongestStretch,
        ..options.clone()
    };
    let longest = analyse(&[channel(&holes)], None, 100.0, &one).unwrap();
    assert_eq!(longest.rows, (1001, 4000));
    // Stamps that jump.
    let stamps: Vec<f64> = (0..4000)
        .map(|k| f64::from(k) * 0.01 + if k >= 500 { 3.0 } else { 0.0 })
        .collect();
    let jumped = analyse(&[channel(&y)], Some(&stamps), 100.0, &options).unwrap();
    assert_eq!(jumped.stretches, [(0, 500), (500, 4000)]);
    assert_eq!(jumped.gaps[0].rows, 300);
    // A rate that is not the stated one.
    let slow: Vec<f64> = (0..4000).map(|k| f64::from(k) * 0.0102).collect();
    let uneven = analyse(&[channel(&y)], Some(&slow), 100.0, &options).unwrap();
    assert_eq!(uneven.findings[0].code(), "rate-contradicts-stamps");
    // All missing.
    assert!(analyse(&[channel(&[f64::NAN; 100])], None, 100.0, &options).is_err());
    // Nonsense rates.
    for rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(analyse(&[channel(&y)], None, rate, &options).is_err());
    }
}

/// Everything that leaves is finite, for awkward but legal records.
#[test]
fn law_results_are_finite() {
    let mut records: Vec<Vec<f64>> = vec![
        (0..200).map(|k| f64::from(k % 2)).collect(),
        (0..200).map(f64::from).collect(),
        (0..200).map(|k| if k == 100 { 1.0 } else { 0.0 }).collect(),
        (0..5000).map(|k| (f64::from(k) * 0.1).sin()).collect(),
        (0..5000)
            .map(|k| 1e12 + (f64::from(k) * 0.7).sin().round())
            .collect(),
        (0..2000)
            .map(|k| 1e-200 * f64::from((k * 7919) % 1009))
            .collect(),
    ];
    records.push((0..5000).map(|k| f64::from(k).powi(2)).collect());
    for (index, y) in records.iter().enumerate() {
        let result = analyse(&[channel(y)], None, 100.0, &AnalysisOptions::default());
        let Ok(analysis) = result else {
            println!("{index}: {}", result.unwrap_err());
            continue;
        };
        // serde_json writes NaN and infinities as null.
        let text = serde_json::to_value(&analysis).unwrap();
        let c = &text["channels"][0];
        for key in [
            "curve",
            "whittle",
            "spectrum",
            "consistency",
            "disturbances",
        ] {
            let part = serde_json::to_string(&c[key]["points"]).unwrap()
                + &serde_json::to_string(&c[key]["model"]).unwrap();
            if c[key].is_object() && c[key].get("points").is_some() {
                assert!(
                    !serde_json::to_string(&c[key]["points"][0]["deviation"])
                        .unwrap()
                        .contains("null"),
                    "{index} {key} {part}"
                );
            }
        }
    }
}

/// A real inertial unit at rest: the analysis runs, its gyroscopes are white with a floor, and no disturbance is seen.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn adis16405_analysis() {
    let root = PathBuf::from(
        std::env::var_os("PROOFMASS_REFERENCE_DATA")
            .expect("PROOFMASS_REFERENCE_DATA names the folder of the recordings of others"),
    );
    let path = root.join("adis16405/imu1_counts_int16.npy.gz");
    let file = std::fs::File::open(&path).unwrap();
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(file), &mut bytes).unwrap();
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let counts: Vec<i16> = bytes[header..]
        .as_chunks::<2>()
        .0
        .iter()
        .map(|b| i16::from_le_bytes(*b))
        .collect();
    let names = ["gyro x", "gyro y", "gyro z", "acc x", "acc y", "acc z"];
    let rates: Vec<Vec<f64>> = counts
        .chunks(1_000_000)
        .enumerate()
        .map(|(c, counts)| {
            let scale = if c < 3 {
                0.05 * std::f64::consts::PI / 180.0
            } else {
                0.00333 * 9.80665
            };
            counts.iter().map(|&v| f64::from(v) * scale).collect()
        })
        .collect();
    let channels: Vec<NoiseChannel> = rates
        .iter()
        .enumerate()
        .map(|(c, rate)| NoiseChannel {
            name: names[c],
            sensor: Some(if c < 3 {
                Sensor::Gyroscope
            } else {
                Sensor::Accelerometer
            }),
            unit: if c < 3 { "rad/s" } else { "m/s²" },
            rate,
        })
        .collect();
    let start = std::time::Instant::now();
    let analysis = analyse(&channels, None, 100.0, &AnalysisOptions::default()).unwrap();
    println!("{:?}", start.elapsed());
    for c in &analysis.channels {
        println!(
            "{} mean {:.4} sd {:.5}",
            c.name, c.mean, c.standard_deviation
        );
        for fit in [c.whittle.as_ref().unwrap()] {
            print!("  discrepancy {:.3} {:?}:", fit.discrepancy, fit.band);
            for k in &fit.coefficients {
                match k.verdict {
                    Verdict::Identified {
                        value, interval, ..
                    } => {
                        print!(
                            " {}={value:.3e} [{:.3e},{:.3e}]",
                            k.term.symbol(),
                            interval.0,
                            interval.1
                        )
                    }
                    verdict => print!(" {} {verdict:?}", k.term.symbol()),
                }
            }
            println!();
        }
        println!(
            "  model inside the limits of the curve at {} of {}: {:?}",
            c.fitted.iter().filter(|p| p.inside).count(),
            c.fitted.len(),
            c.fitted
                .iter()
                .zip(&c.curve.as_ref().unwrap().points)
                .map(|(p, q)| (
                    (1e3 * (p.deviation / q.deviation - 1.0)).round() / 10.0,
                    p.inside
                ))
                .collect::<Vec<_>>()
        );
        println!("  {:?}", c.disturbances.iter().take(4).collect::<Vec<_>>());
        for f in &c.findings {
            println!("  {f}");
        }
        println!(
            "  {:?}",
            c.consistency
                .iter()
                .map(|p| (p.ratio() * 1e4).round() / 1e4)
                .collect::<Vec<_>>()
        );
    }
    // Two gyroscopes average over into the next sample and nothing else: terms and front end make the whole curve. The others
    // resonate, and the accelerometers carry lines: the bands are named.
    for (index, c) in analysis.channels.iter().enumerate() {
        assert!(c.findings.iter().any(|f| f.code() == "band-limited"));
        let inside = c.fitted.iter().filter(|p| p.inside).count();
        if index < 2 {
            assert!(inside >= 17, "{}: {inside} of 19", c.name);
            let front_end = c.whittle.as_ref().unwrap().band.front_end;
            assert!(
                matches!(front_end, Some(FrontEnd::Overlap { loss }) if (loss - 0.5).abs() < 0.01),
                "{front_end:?}"
            );
        } else {
            let finding = c
                .findings
                .iter()
                .find(|f| f.code() == "noise-model-misfit" && f.what().contains("Allan curve"))
                .unwrap();
            assert!(
                finding.to_string().contains("deviates most at"),
                "{finding}"
            );
        }
        // No random walk alone is more than the curve admits at 655 s; y and z stepped at the same time.
        let curve = c.curve.as_ref().unwrap();
        let long = curve.points.iter().find(|p| p.factor == 65_536).unwrap();
        let most = long.interval.unwrap().1 / (long.tau / 3.0).sqrt();
        let fit = c.whittle.as_ref().unwrap();
        assert!(fit.model.random_walk < most, "{}: {most}", c.name);
        if index > 3 {
            let stepped = |at: &&f64| (**at - 2150.0).abs() < 5.0;
            let steps: Vec<f64> = fit.courses.iter().filter_map(|k| k.shape.time()).collect();
            assert!(steps.iter().any(|at| stepped(&at)), "{}: {steps:?}", c.name);
        }
    }
}

/// White noise with a missing row every now and then: every stretch counts, and the coefficients hold.
#[test]
fn law_gaps_cost_no_samples() {
    let model = NoiseModel {
        white: 1.0,
        random_walk: 0.02,
        ..Default::default()
    };
    let mut y = record(&model, 100_000, 100.0, 77);
    for k in 0..50 {
        y[1000 + 1960 * k] = f64::NAN;
    }
    let analysis = analyse(&[channel(&y)], None, 100.0, &AnalysisOptions::default()).unwrap();
    let c = &analysis.channels[0];
    assert_eq!(c.samples, 99_950);
    let fit = c.whittle.as_ref().unwrap();
    assert!((fit.value(Term::White).unwrap() - 1.0).abs() < 0.01);
    assert_eq!(fit.get(Term::Ramp).unwrap().verdict.value(), None);
    let curve = c.curve.as_ref().unwrap();
    assert_eq!(curve.points[0].terms, 99_950 - 51);
    for p in &curve.points {
        let truth = (1.0 / p.tau + 0.02_f64.powi(2) * p.tau / 3.0).sqrt();
        let (low, high) = p.interval.unwrap();
        // Eleven octaves at 95 %: widened by half.
        assert!(low / 1.1 < truth && truth < high * 1.1, "{p:?} {truth}");
    }
}

/// A resonance is noise: none of its maxima is a line, and a line beside it is found.
#[test]
fn law_a_resonance_is_no_line() {
    let n = 200_000;
    let white = NoiseModel {
        white: 1.0,
        ..Default::default()
    };
    let drive = record(&white, n, 1.0, 11);
    let floor = record(&white, n, 1.0, 12);
    // Two poles at a fifth of the rate, two per cent of the rate wide.
    let (radius, angle) = (0.97_f64, 0.4 * std::f64::consts::PI);
    let (mut last, mut before) = (0.0, 0.0);
    let rate: Vec<f64> = (0..n)
        .map(|i| {
            let y = drive[i] + 2.0 * radius * angle.cos() * last - radius * radius * before;
            (before, last) = (last, y);
            y + floor[i] + 0.2 * (2.0 * std::f64::consts::PI * 0.4 * i as f64).sin()
        })
        .collect();
    let mut options = proofmass_noise::FitOptions::default();
    options.terms.push(Term::Sinusoid);
    let fit = proofmass_noise::whittle(&rate, 1.0, &options).unwrap();
    let lines: Vec<f64> = fit.model.sinusoids.iter().map(|s| s.frequency).collect();
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!((lines[0] - 0.4).abs() < 1e-5, "{lines:?}");
}

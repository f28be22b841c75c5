//! Compensation over frequency against a simulated truth: is the true error within the stated one?

use num_complex::Complex64;
use proofmass_core::{Error, Unwatched};
use proofmass_dynamic::FrequencyResponse;
use proofmass_dynamic::frequency_response::{Beyond, FilterDesign};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, EstimateSeries, Evaluation,
    Influence, SeriesPoint,
};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

/// A triaxial sensor: resonances of 4, 5 and 6 kHz, a delay of 30 µs of its filter, 2 % of cross-axis sensitivity.
fn truth(f: f64, output: usize, axis: usize) -> Complex64 {
    let x = f / [4000.0, 5000.0, 6000.0][output];
    let resonance = 1.0 / Complex64::new(1.0 - x * x, 0.06 * x);
    let mixed = if output == axis {
        0.0102
    } else {
        0.0002 * (1.0 + axis as f64 - output as f64)
    };
    Complex64::cis(-TAU * f * 30e-6) * resonance * mixed
}

/// Its calibration with a relative standard uncertainty of every element, drawn once per point.
fn calibration(
    channels: usize,
    frequencies: &[f64],
    relative: f64,
    rng: &mut Xoshiro256PlusPlus,
) -> FrequencyResponse {
    let names: Vec<String> = ["x", "y", "z"][..channels]
        .iter()
        .map(|s| (*s).to_owned())
        .collect();
    let labels = FrequencyResponse::names(&names, &names);
    let u = relative * 0.0102;
    let points = frequencies
        .iter()
        .map(|&at| {
            let mut components = Vec::new();
            for o in 0..channels {
                for a in 0..channels {
                    let k = truth(at, o, a);
                    for part in [k.re, k.im] {
                        let draw: f64 = StandardNormal.sample(rng);
                        let name = labels[components.len()].clone();
                        components.push(Component::new(name, "V/(m/s²)", part + u * draw));
                    }
                }
            }
            let covariance =
                Covariance::from_standard_uncertainties(&vec![u; labels.len()]).unwrap();
            let influence = Influence {
                key: "reading".into(),
                description: "reading".into(),
                evaluation: Evaluation::A,
                distribution: "normal".into(),
                dof: DegreesOfFreedom::INFINITE,
                effect: Effect::Joint { covariance },
            };
            let estimate = Estimate::new(components, vec![influence]).unwrap();
            SeriesPoint { at, estimate }
        })
        .collect();
    let series = EstimateSeries::new(points, Some(vec![])).unwrap();
    FrequencyResponse::new(names.clone(), names, series).unwrap()
}

fn thirds(from: f64, to: f64) -> Vec<f64> {
    (0..)
        .map(|i| from * 2f64.powf(f64::from(i) / 3.0))
        .take_while(|f| *f <= to * 1.001)
        .collect()
}

/// A sum of sines within a band: acceleration along every axis, and the outputs of the sensor, exactly.
struct Motion {
    sines: Vec<(f64, Vec<Complex64>)>,
}

impl Motion {
    fn new(channels: usize, band: [f64; 2], rng: &mut Xoshiro256PlusPlus) -> Self {
        let sines = (0..12)
            .map(|_| {
                let f = band[0] * (band[1] / band[0]).powf(rng.random::<f64>());
                let draw = |rng: &mut Xoshiro256PlusPlus| -> f64 { StandardNormal.sample(rng) };
                let a = (0..channels).map(|_| Complex64::new(draw(rng), draw(rng)));
                (f, a.collect())
            })
            .collect();
        Self { sines }
    }

    fn acceleration(&self, axis: usize, t: f64) -> f64 {
        let of = |(f, a): &(f64, Vec<Complex64>)| (a[axis] * Complex64::cis(TAU * f * t)).re;
        self.sines.iter().map(of).sum()
    }

    fn output(&self, output: usize, t: f64) -> f64 {
        let of = |(f, a): &(f64, Vec<Complex64>)| {
            let k: Complex64 = a
                .iter()
                .enumerate()
                .map(|(axis, a)| truth(*f, output, axis) * a)
                .sum();
            (k * Complex64::cis(TAU * f * t)).re
        };
        self.sines.iter().map(of).sum()
    }
}

/// 95 % of n trials less four standard deviations of their number.
fn least(n: usize) -> usize {
    let n = n as f64;
    (0.95 * n - 4.0 * (n * 0.95 * 0.05).sqrt()).floor() as usize
}

#[test]
fn coverage_of_the_stated_error_of_a_band() {
    for (relative, band) in [(0.005, [20.0, 500.0]), (0.02, [100.0, 1500.0])] {
        let trials = 200;
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
        let (mut inside, mut stated) = (0, 0.0);
        for _ in 0..trials {
            let response = calibration(3, &thirds(10.0, 2600.0), relative, &mut rng);
            let constant = response.band_matrix(band).unwrap();
            let error = constant.error;
            assert!((error.delay - 30e-6).abs() < 20e-6, "{error:?}");
            stated += error.stated / f64::from(trials);
            let motion = Motion::new(3, band, &mut rng);
            let (mut square, mut size) = (0.0, 0.0);
            for i in 0..4000 {
                let t = f64::from(i) * 1.234e-3;
                let outputs: Vec<f64> = (0..3).map(|o| motion.output(o, t)).collect();
                for (axis, a) in constant.apply(&outputs).iter().enumerate() {
                    let truth = motion.acceleration(axis, t - error.delay);
                    square += (a - truth).powi(2);
                    size += truth * truth;
                }
            }
            inside += usize::from((square / size).sqrt() < error.stated);
        }
        println!(
            "band {band:?} Hz: {inside} of {trials} within {:.2} % on average",
            100.0 * stated
        );
        assert!(inside >= least(trials as usize));
    }
}

#[test]
fn known_error_of_a_band_where_the_sensitivity_is_known() {
    // 1/(1 − x²) over 100 Hz to 500 Hz with a resonance of 5 kHz: from 1.0004 to 1.0101 of the static one, ±0.5 %.
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let response = calibration(1, &thirds(10.0, 2600.0), 1e-9, &mut rng);
    let constant = response.band_matrix([100.0, 400.0]).unwrap();
    // 4 kHz for the first output: from 1.000625 to 1.010101.
    let spread = 1.010101 / 1.000625 - 1.0;
    let departure = constant.error.departure;
    assert!((0.5 * spread..spread).contains(&departure), "{departure}");
    // Without the delay of some 30 µs the phase is an error: 2π 400 Hz 30 µs.
    let phase = TAU * 400.0 * constant.error.delay;
    let with_delay = constant.error.departure_with_delay;
    assert!((with_delay / phase - 1.0).abs() < 0.05, "{with_delay}");
    assert!(constant.error.uncertainty < 1e-7);
}

#[test]
fn coverage_of_the_stated_error_of_a_filter() {
    let rate = 20_000.0;
    for (channels, trials, relative) in [(1usize, 60usize, 0.005), (3, 6, 0.01)] {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let (mut inside, mut stated) = (0, 0.0);
        for _ in 0..trials {
            let response = calibration(channels, &thirds(80.0, 2600.0), relative, &mut rng);
            let filter = response
                .compensation_filter(rate, &FilterDesign::default(), &Unwatched)
                .unwrap();
            assert!(filter.within_tolerance, "{:?}", filter.error);
            let error = filter.error;
            stated += error.stated / trials as f64;
            let motion = Motion::new(channels, error.band, &mut rng);
            let n = 8000 + 2 * filter.half;
            let outputs: Vec<Vec<f64>> = (0..channels)
                .map(|o| (0..n).map(|i| motion.output(o, i as f64 / rate)).collect())
                .collect();
            let mut stream = filter.stream();
            // Uneven pieces: the result may not depend on them.
            let mut result = vec![Vec::new(); channels];
            let mut begin = 0;
            while begin < n {
                let end = (begin + 1 + rng.random_range(0..3000)).min(n);
                let piece: Vec<&[f64]> = outputs.iter().map(|o| &o[begin..end]).collect();
                for (all, new) in result.iter_mut().zip(stream.push(&piece)) {
                    all.extend(new);
                }
                begin = end;
            }
            for (all, new) in result.iter_mut().zip(stream.finish()) {
                all.extend(new);
            }
            assert_eq!(result[0].len(), n - 2 * filter.half);
            let (mut square, mut size) = (0.0, 0.0);
            for (axis, values) in result.iter().enumerate() {
                for (i, a) in values.iter().enumerate() {
                    let truth = motion.acceleration(axis, (i + filter.half) as f64 / rate);
                    square += (a - truth).powi(2);
                    size += truth * truth;
                }
            }
            inside += usize::from((square / size).sqrt() < error.stated);
        }
        println!(
            "filter, {channels} axes: {inside} of {trials} within {:.2} % on average",
            100.0 * stated
        );
        assert!(inside >= least(trials));
    }
}

#[test]
fn law_a_filter_rejects_or_holds_what_was_never_calibrated() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    let response = calibration(1, &thirds(100.0, 1000.0), 1e-6, &mut rng);
    let gain = |beyond: Beyond, f: f64| {
        let mut design = FilterDesign::default();
        design.beyond = beyond;
        let filter = response
            .compensation_filter(8000.0, &design, &Unwatched)
            .unwrap();
        let h: Complex64 = filter.taps[0]
            .iter()
            .enumerate()
            .map(|(i, h)| h * Complex64::cis(-TAU * f * (i as f64 - filter.half as f64) / 8000.0))
            .sum();
        (h * truth(f.max(1.0), 0, 0)).norm()
    };
    for f in [0.0, 30.0, 2500.0] {
        assert!(gain(Beyond::Reject, f) < 2e-3, "{f}");
    }
    assert!((gain(Beyond::Hold, 0.0) - 1.0).abs() < 5e-3);
    for f in [120.0, 300.0, 700.0] {
        assert!((gain(Beyond::Reject, f) - 1.0).abs() < 2e-3);
        assert!((gain(Beyond::Hold, f) - 1.0).abs() < 2e-3);
    }
}

#[test]
fn refuses_bands_and_rates_that_were_not_calibrated() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let response = calibration(1, &thirds(100.0, 1600.0), 0.01, &mut rng);
    for band in [
        [50.0, 200.0],
        [200.0, 5000.0],
        [800.0, 200.0],
        [f64::NAN, 200.0],
    ] {
        assert!(matches!(
            response.band_matrix(band),
            Err(Error::OutOfRange { .. })
        ));
    }
    for rate in [100.0, 0.0, -1.0, f64::NAN, f64::INFINITY] {
        let design = FilterDesign::default();
        assert!(
            response
                .compensation_filter(rate, &design, &Unwatched)
                .is_err()
        );
    }
    for longest in [0, 10, usize::MAX] {
        let mut design = FilterDesign::default();
        design.longest = longest;
        assert!(
            response
                .compensation_filter(8000.0, &design, &Unwatched)
                .is_err()
        );
    }
    let mut design = FilterDesign::default();
    design.band = Some([100.0, 1500.0]);
    assert!(
        response
            .compensation_filter(3000.0, &design, &Unwatched)
            .is_err()
    );
}

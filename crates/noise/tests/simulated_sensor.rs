//! Simulated sensors: filters, axes, stamps.

use proofmass_noise::{LowPass, NoiseModel, SimulatedSensor, simulated_stamps};
use proofmass_signal::Welch;

fn sensor(low_pass: Option<LowPass>) -> SimulatedSensor {
    let mut sensor = SimulatedSensor::new(NoiseModel {
        white: 1.0,
        ..Default::default()
    });
    sensor.low_pass = low_pass;
    sensor
}

/// White noise behind a filter has the density 2N²|H|²: within five standard deviations of 390 averages, √(1/390), at each of
/// seventeen frequencies. (Nearer to half the rate the window leaks more than the filter lets through.)
#[test]
fn law_filters_shape_the_density() {
    for order in [1, 2] {
        let filter = LowPass {
            order,
            corner: 12.0,
        };
        let y = sensor(Some(filter)).record(1, 100_000, 100.0, 3).unwrap();
        let density = Welch::new(512).density(&y[0], 100.0).unwrap();
        for (f, s) in density
            .frequency
            .iter()
            .zip(&density.density)
            .take(205)
            .skip(3)
            .step_by(12)
        {
            let expected = 2.0 * filter.response(*f, 100.0);
            assert!(
                (s / expected - 1.0).abs() < 0.26,
                "order {order}, {f} Hz: {}",
                s / expected
            );
        }
    }
}

/// Axes share nothing; more axes do not change the first; ramps and sinusoids begin with the record.
#[test]
fn law_axes_are_independent() {
    let plain = sensor(None);
    let three = plain.record(3, 20_000, 10.0, 5).unwrap();
    assert_eq!(three[0], plain.record(1, 20_000, 10.0, 5).unwrap()[0]);
    let product: f64 = three[0].iter().zip(&three[1]).map(|(a, b)| a * b).sum();
    // N² rate √n is one standard deviation.
    assert!(product.abs() < 4.0 * 10.0 * 20_000_f64.sqrt());
    let mut slow = SimulatedSensor::new(NoiseModel {
        ramp: 2.0,
        ..Default::default()
    });
    slow.low_pass = Some(LowPass {
        order: 2,
        corner: 4.0,
    });
    let ramp = &slow.record(1, 100, 10.0, 1).unwrap()[0];
    // Late by the delay of the filter, √2/(2 tan(πf_c/f_s)) samples.
    let late = 0.1 * 2_f64.sqrt() / (2.0 * (0.4 * std::f64::consts::PI).tan());
    // What is left of the beginning: the poles' 0.643 to the power of 25 samples.
    assert!((ramp[0] + 2.0 * late).abs() < 1e-5, "{}", ramp[0]);
    assert!((ramp[99] - ramp[0] - 19.8).abs() < 1e-5);
}

#[test]
fn law_stamps_never_go_back() {
    let stamps = simulated_stamps(10_000, 100.0, 0.6, 2).unwrap();
    assert!(stamps.windows(2).all(|w| w[1] > w[0]));
    assert_eq!(simulated_stamps(3, 2.0, 0.0, 9).unwrap(), [0.0, 0.5, 1.0]);
}

#[test]
fn refuses_what_has_no_meaning() {
    let with = |order, corner| sensor(Some(LowPass { order, corner })).record(1, 10, 100.0, 1);
    assert!(with(3, 10.0).is_err() && with(1, 60.0).is_err() && with(2, 0.0).is_err());
    let mut many = sensor(None);
    many.outliers = 1.5;
    assert!(many.record(1, 10, 100.0, 1).is_err());
    assert!(simulated_stamps(10, 0.0, 0.1, 1).is_err());
}

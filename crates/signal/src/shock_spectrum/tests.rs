use super::*;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn half_sine(per_pulse: usize) -> Vec<f64> {
    (0..=per_pulse)
        .map(|n| (PI * n as f64 / per_pulse as f64).sin())
        .collect()
}

/// Greatest absolute acceleration of an undamped oscillator during and after a half-sine, closed form.
///
/// During the pulse x″ + ω²x = −sin Ωt gives ω²x = −(sin Ωt − r sin ωt)/(1 − r²), r = Ω/ω; extremes where Ωt = ±ωt + 2πm.
fn undamped_half_sine(ratio: f64) -> (f64, f64) {
    // f τ: natural periods per pulse; Ω = π/τ.
    let r = 0.5 / ratio;
    let y = |s: f64| ((PI * s).sin() - r * (PI * s / r).sin()) / (1.0 - r * r);
    let mut during: f64 = 0.0;
    for m in 1..200 {
        for s in [
            2.0 * f64::from(m) / (1.0 + 1.0 / r),
            2.0 * f64::from(m) / (1.0 / r - 1.0),
        ] {
            if (0.0..=1.0).contains(&s) {
                during = during.max(y(s).abs());
            }
        }
    }
    let after = 2.0 * r / (1.0 - r * r) * (PI / (2.0 * r)).cos();
    (during, after.abs())
}

#[test]
fn known_half_sine_response() {
    let rate = 4000.0;
    let pulse = half_sine(4000);
    let ratios = [0.11, 0.3, 0.62, 0.8085, 1.7, 4.3];
    let spectrum = ShockSpectrum {
        damping: 0.0,
        peaks: Peaks::BetweenSamples,
        ..ShockSpectrum::new(ratios.to_vec(), 10.0)
    };
    let result = spectrum.evaluate(&pulse, rate).unwrap();
    for (ratio, e) in ratios.iter().zip(&result.extremes) {
        let (during, after) = undamped_half_sine(*ratio);
        // Straight lines between 4000 points of a half-sine lie below it by (π/4000)²/12 on the mean: 5e-8.
        let primary = absolute(e.primary);
        assert!(
            (e.residual_maximax() - after).abs() < 1e-7,
            "{ratio} {after} {e:?}"
        );
        if *ratio > 0.5 {
            assert!(
                (primary - during).abs() < 1e-7,
                "{ratio} {during} {primary}"
            );
        }
    }
    // The greatest of all: 1.7685 at f τ = 0.8085.
    let fine = ShockSpectrum {
        damping: 0.0,
        peaks: Peaks::BetweenSamples,
        ..ShockSpectrum::new((0..400).map(|k| 0.70 + 5e-4 * f64::from(k)).collect(), 10.0)
    };
    let result = fine.evaluate(&pulse, rate).unwrap();
    let (f, peak) = result
        .frequency
        .iter()
        .zip(result.curve(Extremes::maximax))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap();
    assert!((peak - 1.7685).abs() < 5e-5, "{peak}");
    // A maximum is known in its abscissa to the square root of its ordinate's digits.
    assert!((f - 0.8085).abs() < 1.5e-3, "{f}");
}

#[test]
fn published_half_sine_of_50_g_and_11_ms() {
    for peaks in [Peaks::AtSamples, Peaks::BetweenSamples] {
        let rate = 1100.0 / 0.011;
        let pulse: Vec<f64> = half_sine(1100).iter().map(|a| 50.0 * a).collect();
        let spectrum = ShockSpectrum {
            peaks,
            ..ShockSpectrum::new(vec![30.0, 80.0, 140.0], 10.0)
        };
        let result = spectrum.evaluate(&pulse, rate).unwrap();
        for (got, expected) in result
            .curve(Extremes::maximax)
            .iter()
            .zip([55.4, 82.4, 70.2])
        {
            assert!((got - expected).abs() < 0.05, "{got} {expected}");
        }
    }
}

/// The response by many small steps of the classical Runge–Kutta method through the straight lines.
fn integrated(record: &[f64], rate: f64, f: f64, zeta: f64, response: Response) -> [f64; 2] {
    let w = TAU * f;
    let fine = 400;
    let h = 1.0 / rate / f64::from(fine);
    let (mut x, mut v) = (0.0, 0.0);
    let mut range = [0.0f64; 2];
    let slope = |x: f64, v: f64, a: f64| (v, -a - 2.0 * zeta * w * v - w * w * x);
    for pair in record.windows(2) {
        for k in 0..fine {
            let a = |s: f64| pair[0] + (pair[1] - pair[0]) * (f64::from(k) + s) / f64::from(fine);
            let k1 = slope(x, v, a(0.0));
            let k2 = slope(x + 0.5 * h * k1.0, v + 0.5 * h * k1.1, a(0.5));
            let k3 = slope(x + 0.5 * h * k2.0, v + 0.5 * h * k2.1, a(0.5));
            let k4 = slope(x + h * k3.0, v + h * k3.1, a(1.0));
            x += h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
            v += h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
            let y = match response {
                Response::AbsoluteAcceleration => -w * w * x - 2.0 * zeta * w * v,
                Response::RelativeDisplacement => x,
                Response::RelativeVelocity => v,
                Response::PseudoVelocity => w * x,
                Response::PseudoAcceleration => w * w * x,
            };
            range = [range[0].min(y), range[1].max(y)];
        }
    }
    range
}

#[test]
fn law_between_samples() {
    // Up to three periods of the oscillator in one sample: several extremes lie in it.
    let record: Vec<f64> = (0..40)
        .map(|k| f64::from(k * k % 17) * 0.3 - 2.0 * f64::from(k % 3))
        .collect();
    for (f, zeta) in [(3.0, 0.05), (40.0, 0.01), (130.0, 0.2), (300.0, 0.02)] {
        for response in Response::ALL {
            let spectrum = ShockSpectrum {
                damping: zeta,
                response,
                peaks: Peaks::BetweenSamples,
                ..ShockSpectrum::new(vec![f], 10.0)
            };
            let e = spectrum.evaluate(&record, 100.0).unwrap().extremes[0];
            let expected = integrated(&record, 100.0, f, zeta, response);
            let scale = expected[1].max(-expected[0]);
            for (got, want) in e.in_record().iter().zip(expected) {
                // 400 points to a step of at most three periods: between them the peak is missed by (2π 3/800)²/2 = 3e-4.
                // The last ramp to zero may reach further.
                assert!(
                    (got - want).abs() < 3e-4 * scale || got.abs() > want.abs(),
                    "{f} {response:?} {got} {want}"
                );
            }
        }
    }
}

#[test]
fn law_low_frequencies_keep_their_digits() {
    // At ωT = 6e-8 the mass stays where it is: the relative displacement is minus the twice integrated record.
    let record: Vec<f64> = (0..100_000).map(|k| (0.01 * f64::from(k)).sin()).collect();
    let rate = 1e5;
    let motion = crate::Baseline::None.integrate(&record, rate).unwrap();
    let spectrum = ShockSpectrum {
        response: Response::RelativeDisplacement,
        ..ShockSpectrum::new(vec![1e-3], 10.0)
    };
    let e = spectrum.evaluate(&record, rate).unwrap().extremes[0];
    let expected = motion
        .displacement
        .iter()
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    // The damper acts by 2ζωt at most: 6.3e-4.
    assert!((absolute(e.in_record()) / expected - 1.0).abs() < 6.3e-4);
}

#[test]
fn law_free_motion_equals_a_padded_record() {
    let mut record = half_sine(100);
    let rate = 100.0;
    for (f, zeta) in [(0.2, 0.05), (1.3, 0.0), (7.0, 0.3)] {
        let spectrum = ShockSpectrum {
            damping: zeta,
            peaks: Peaks::BetweenSamples,
            ..ShockSpectrum::new(vec![f], 10.0)
        };
        let short = spectrum.evaluate(&record, rate).unwrap().extremes[0];
        let mut long = record.clone();
        long.resize(2000, 0.0);
        let padded = ShockSpectrum {
            shock_end: Some(101),
            ..spectrum
        };
        let padded = padded.evaluate(&long, rate).unwrap().extremes[0];
        assert!((short.maximax() - padded.maximax()).abs() < 1e-12);
        assert!(
            (short.residual_maximax() - padded.residual_maximax()).abs()
                < 1e-9 * short.maximax().max(1.0)
        );
    }
    record.clear();
    assert!(
        ShockSpectrum::new(vec![1.0], 10.0)
            .evaluate(&record, rate)
            .is_err()
    );
}

#[test]
fn refuses_what_makes_no_oscillator() {
    let record = [0.0, 1.0, 0.0];
    let good = ShockSpectrum::new(vec![1.0], 10.0);
    assert!(good.evaluate(&record, 10.0).is_ok());
    for bad in [
        ShockSpectrum::new(vec![], 10.0),
        ShockSpectrum::new(vec![0.0], 10.0),
        ShockSpectrum::new(vec![f64::NAN], 10.0),
        ShockSpectrum::new(vec![1.0], 0.5),
        ShockSpectrum::new(vec![1.0], f64::NAN),
        ShockSpectrum {
            shock_end: Some(4),
            ..good.clone()
        },
    ] {
        assert!(bad.evaluate(&record, 10.0).is_err(), "{bad:?}");
    }
    assert!(good.evaluate(&[0.0, f64::INFINITY], 10.0).is_err());
    assert!(good.evaluate(&record, 0.0).is_err());
    assert!(octaves(10.0, 1.0, 3).is_empty());
}

proptest! {
    #[test]
    fn law_spectra_are_homogeneous(scale in -1e3f64..1e3, f in 0.1f64..49.0, q in 0.6f64..200.0) {
        let record = half_sine(30);
        let scaled: Vec<f64> = record.iter().map(|a| scale * a).collect();
        let spectrum = ShockSpectrum::new(vec![f], q);
        let one = spectrum.evaluate(&record, 50.0).unwrap().extremes[0];
        let many = spectrum.evaluate(&scaled, 50.0).unwrap().extremes[0];
        prop_assert!((many.maximax() - scale.abs() * one.maximax()).abs() <= 1e-12 * scale.abs());
    }
}

#[test]
fn law_lanes_do_not_change_a_result() {
    let record = half_sine(64);
    let all = octaves(0.5, 20.0, 6);
    let together = ShockSpectrum::new(all.clone(), 10.0)
        .evaluate(&record, 64.0)
        .unwrap();
    for (f, e) in all.iter().zip(&together.extremes) {
        let alone = ShockSpectrum::new(vec![*f], 10.0)
            .evaluate(&record, 64.0)
            .unwrap();
        assert_eq!(alone.extremes[0], *e);
    }
}

#[test]
fn law_both_states_give_the_same_spectrum() {
    // Every oscillator once in the company it is stepped with, once by single steps of the complex state.
    let record: Vec<f64> = (0..3000)
        .map(|k| f64::from(k * k % 101) / 101.0 - 0.3 + f64::from(k % 7))
        .collect();
    let rate = 1000.0;
    let frequencies = [
        0.01, 0.5, 7.0, 90.0, 300.0, 440.0, 446.0, 499.0, 500.0, 650.0,
    ];
    for response in Response::ALL {
        for damping in [0.0, 1e-3, 0.05, 0.7] {
            let spectrum = ShockSpectrum {
                damping,
                response,
                ..ShockSpectrum::new(frequencies.to_vec(), 10.0)
            };
            let result = spectrum.evaluate(&record, rate).unwrap();
            for (f, e) in frequencies.iter().zip(&result.extremes) {
                let oscillator = Oscillator::new(*f, damping, 1.0 / rate);
                let kappa = response.reading(&oscillator);
                let mut z = num_complex::Complex64::new(0.0, 0.0);
                let mut range = [0.0f64; 2];
                for pair in record.windows(2) {
                    z = oscillator.next(z, pair[0], pair[1]);
                    crate::oscillator::widen(&mut range, (kappa * z).re);
                }
                let scale = absolute(range);
                for (got, want) in e.in_record().iter().zip(range) {
                    // 3000 steps, each rounding to 2⁻⁵³ of the state, whose damping is known to 2⁻⁵³ of a step.
                    assert!(
                        (got - want).abs() < 1e-11 * scale,
                        "{f} Hz, {damping}, {response:?}: {got} {want}"
                    );
                }
            }
        }
    }
}

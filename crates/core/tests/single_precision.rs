//! The covariance in single precision: the short form of the update beside Joseph's, both against double precision.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

use proofmass_core::state_space::predict_covariance;
use proofmass_core::velocity::{BiasModel, Hold, Kalman, KalmanState, MotionNoise, ProcessNoise};

/// (I − K hᵀ) P (I − K hᵀ)ᵀ + K R Kᵀ for a position.
fn joseph<const N: usize>(p: &mut [[f32; N]; N], r: f32) {
    let gain = p[0].map(|v| v / (p[0][0] + r));
    let keep: [[f32; N]; N] = std::array::from_fn(|i| {
        std::array::from_fn(|j| f32::from(u8::from(i == j)) - if j == 0 { gain[i] } else { 0.0 })
    });
    let noise: [[f32; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|j| gain[i] * r * gain[j]));
    *p = predict_covariance(&keep, p, &noise);
}

/// Largest relative error of a variance by our update and by Joseph's form, from a start of a hundred times the noise.
fn errors<const N: usize>(filter: &Kalman<f64, N>, every: usize) -> [f64; 2] {
    let single: Kalman<f32, N> = filter.cast();
    // The same coefficients: rounding of the steps alone is compared.
    let double: Kalman<f64, N> = single.cast();
    let step = double.f[0][1];
    let variances = std::array::from_fn(|i| 1e4 * double.r / step.powi(2 * i as i32));
    let mut exact = KalmanState::new([0.0; N], variances, 0.0);
    let mut ours = KalmanState::new([0.0; N], variances.map(|v| v as f32), 0.0);
    let mut theirs = ours.p;
    let mut worst = [0.0f64; 2];
    for n in 1..2000 {
        double.predict(&mut exact, 0.0);
        single.predict(&mut ours, 0.0);
        theirs = predict_covariance(&single.f, &theirs, &single.q);
        if n % every == 0 {
            double.update(&mut exact, 0.0);
            single.update(&mut ours, 0.0);
            joseph(&mut theirs, single.r);
        }
        for (worst, p) in worst.iter_mut().zip([&ours.p, &theirs]) {
            for i in 0..N {
                *worst = worst.max((f64::from(p[i][i]) / exact.p[i][i] - 1.0).abs());
            }
        }
    }
    worst
}

#[test]
fn law_single_precision_loses_no_more_than_josephs_form() {
    let (mut two, mut three) = (Vec::new(), Vec::new());
    for acceleration in [1e-6, 1e-4, 1e-2, 1.0] {
        for position in [1e-14, 1e-10, 1e-6, 1e-4] {
            for dt in [1e-4, 1e-3, 1e-2] {
                for every in [1, 7, 50] {
                    let form = ProcessNoise::SampleConstant;
                    let noise = MotionNoise {
                        acceleration,
                        form,
                        position,
                    };
                    two.push(errors(
                        &Kalman::<f64, 2>::new(&noise, Hold::First, dt).unwrap(),
                        every,
                    ));
                    for density in [0.0, 1e-8, 1e-4] {
                        let walk = BiasModel::RandomWalk {
                            density,
                            initial: 0.0,
                        };
                        let filter = Kalman::with_bias(&noise, walk, Hold::First, dt).unwrap();
                        three.push(errors::<3>(&filter, every));
                    }
                }
            }
        }
    }
    // Two states are held to a per cent by both.
    let worst = two
        .iter()
        .fold([0.0f64; 2], |m, e| [m[0].max(e[0]), m[1].max(e[1])]);
    assert!(worst[0] < 0.01, "{worst:?}");
    // Of three, filters whose noise is far below that of the start lose digits.
    let lost = |form: usize| three.iter().filter(|e| !(e[form] < 0.1)).count();
    println!(
        "{worst:?}, of {} filters {} and {}",
        three.len(),
        lost(0),
        lost(1)
    );
    assert!(lost(0) <= lost(1) + 10, "{} {}", lost(0), lost(1));
}

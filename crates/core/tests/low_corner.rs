//! A low corner of the accelerometer as a state of the velocity estimator: what the chip runs for hours.

use proofmass_core::velocity::{
    Hold, Kalman, KalmanState, MotionNoise, ProcessNoise, SteadyKalman,
};
use std::f64::consts::TAU;

/// Position, velocity and acceleration: half a minute of motion, half a minute of rest.
fn motion(t: f64) -> [f64; 3] {
    let moves = f64::from(u8::from((t / 30.0).rem_euclid(2.0) < 1.0));
    let swing = TAU * 0.2;
    let (s, c) = (swing * t).sin_cos();
    [
        moves * 0.1 * (1.0 - c),
        moves * 0.1 * swing * s,
        moves * 0.1 * swing * swing * c,
    ]
}

/// An accelerometer behind stages of 0.5 Hz with an offset behind them: the steady filter finds the velocity after ten minutes as after one, in
/// single precision as in double, where the integral of the output grows by the offset. Largest error, largest difference in single precision,
/// and the states at the end.
fn ten_minutes<const N: usize>(
    filter: &Kalman<f64, N>,
    stages: usize,
    offset: f64,
) -> (f64, f64, [f64; N]) {
    let filter = filter.steady().unwrap();
    let single = SteadyKalman::<f32, N> {
        f: filter.f.map(|r| r.map(|v| v as f32)),
        g: filter.g.map(|r| r.map(|v| v as f32)),
        k: filter.k.map(|v| v as f32),
        component: 0,
        velocity_variance: filter.velocity_variance as f32,
    };
    let mut state = KalmanState::new([0.0; N], [0.0; N], 0.0);
    let mut on_chip = KalmanState::new([0.0f32; N], [0.0; N], 0.0);
    let decay = (-TAU * CORNER * DT).exp();
    let (mut low, mut last) = ([0.0; 2], [0.0; 2]);
    let (mut worst, mut off) = (0.0f64, 0.0f64);
    for k in 0..600_000 {
        let t = DT * f64::from(k);
        let [x, v, a] = motion(t);
        let mut shown = a;
        for i in 0..stages {
            low[i] = low[i] * decay + 0.5 * (shown + last[i]) * (1.0 - decay);
            last[i] = shown;
            shown -= low[i];
        }
        let read = (x / 1e-4).round() * 1e-4;
        let found = filter.step(&mut state, Some(read), shown + offset);
        let chip = single.step(&mut on_chip, Some(read as f32), (shown + offset) as f32);
        if k > 300_000 {
            worst = worst.max((found - v).abs());
            off = off.max((f64::from(chip) - found).abs());
        }
    }
    (worst, off, state.x)
}

const DT: f64 = 1e-3;
const CORNER: f64 = 0.5;

#[test]
fn law_a_corner_that_is_a_state_does_not_drift() {
    let offset = 0.05;
    let noise = MotionNoise {
        acceleration: 4e-4,
        form: ProcessNoise::SampleConstant,
        position: 1e-9,
    };
    let rate = 0.1 * TAU * CORNER;
    let walk = rate * rate * noise.acceleration * DT;
    let one = Kalman::<f64, 4>::with_low_corner(&noise, walk, CORNER, Hold::Second, DT).unwrap();
    let (worst, off, x) = ten_minutes(&one, 1, offset);
    // Counts of a tenth of a millimetre, and jumps of the acceleration by 0.16 m/s² at the ends of a swing.
    assert!(worst < 5e-3, "{worst}");
    assert!(off < 1e-3, "{off}");
    // What the filter has found of the output is bounded: the velocity that was shown is no integral of the offset.
    assert!(x[2].abs() < 1.0 && (x[3] - offset).abs() < 0.02, "{x:?}");
    let two = Kalman::<f64, 5>::with_second_order_corner(&noise, walk, CORNER, Hold::Second, DT);
    let (worst, off, x) = ten_minutes(&two.unwrap(), 2, offset);
    assert!(worst < 5e-3, "{worst}");
    assert!(off < 1e-3, "{off}");
    let bounded = x[2].abs() < 1.0 && x[3].abs() < 1.0;
    assert!(bounded && (x[4] - offset).abs() < 0.02, "{x:?}");
}

/// The transition, the inputs and the noise are those of many small steps.
fn many_small_steps<const N: usize>(of: impl Fn(f64) -> Kalman<f64, N>) {
    let (dt, parts) = (0.05, 50);
    let (one, small) = (of(dt), of(dt / f64::from(parts)));
    let begin = std::array::from_fn(|i| [0.3, -0.2, 0.7, 0.1, 0.4][i]);
    let variances = std::array::from_fn(|i| [1e-3, 2e-3, 5e-3, 1e-3, 2e-3][i]);
    // The acceleration rises on a straight line, which both take as it is.
    let a = |share: f64| 1.0 + 2.0 * share;
    let mut whole = KalmanState::new(begin, variances, a(0.0));
    one.predict(&mut whole, a(1.0));
    let mut pieces = KalmanState::new(begin, variances, a(0.0));
    for k in 1..=parts {
        small.predict(&mut pieces, a(f64::from(k) / f64::from(parts)));
    }
    for i in 0..N {
        assert!(
            (whole.x[i] - pieces.x[i]).abs() < 1e-12,
            "{i}: {whole:?} {pieces:?}"
        );
        for j in 0..N {
            let (w, p) = (whole.p[i][j], pieces.p[i][j]);
            assert!((w - p).abs() < 1e-10 * (1.0 + w.abs()), "{i} {j}: {w} {p}");
        }
    }
}

#[test]
fn crosscheck_a_step_is_many_small_steps() {
    let noise = MotionNoise {
        acceleration: 3e-3,
        form: ProcessNoise::Continuous,
        position: 1e-6,
    };
    let hold = Hold::First;
    many_small_steps(|dt| Kalman::<f64, 4>::with_low_corner(&noise, 5e-4, 2.0, hold, dt).unwrap());
    many_small_steps(|dt| {
        Kalman::<f64, 5>::with_second_order_corner(&noise, 5e-4, 2.0, hold, dt).unwrap()
    });
}

//! Time of one step of each velocity estimator, in nanoseconds, for one million samples of a damped oscillation.

use proofmass_core::velocity::*;
use std::hint::black_box;
use std::time::Instant;

const SAMPLES: usize = 1_000_000;

fn measure(name: &str, mut step: impl FnMut(f64, f64) -> f64) {
    let signal: Vec<(f64, f64)> = (0..4096)
        .map(|k| {
            let t = 1e-3 * f64::from(k);
            ((25.0 * t).sin() * 0.06, -(25.0 * t).sin() * 37.5)
        })
        .collect();
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        let mut sum = 0.0;
        for k in 0..SAMPLES {
            let (x, a) = signal[k & 4095];
            sum += step(black_box(x), black_box(a));
        }
        black_box(sum);
        best = best.min(start.elapsed().as_secs_f64());
    }
    println!("{name:32} {:7.2} ns", 1e9 * best / SAMPLES as f64);
}

fn main() -> Result<(), proofmass_core::Error> {
    let dt = 1e-3;
    let noise = MotionNoise {
        acceleration: 4e-4,
        form: ProcessNoise::SampleConstant,
        position: 7e-8,
    };
    let trapezoid = Integrator::<f64>::new(IntegratorRule::Trapezoid, dt)?;
    let mut s = IntegratorState::new(0.0);
    measure("trapezoid", |_, a| trapezoid.update(&mut s, a));
    let fit = PositionDifference::<f64, 9>::savitzky_golay(2, dt)?;
    let mut s = PositionDifferenceState::new(0.0);
    measure("Savitzky-Golay, 9 points", |x, _| fit.update(&mut s, x));
    let pll = TrackingLoop::<f64>::new(100.0, dt)?;
    let mut s = ObserverState::new(0.0, 0.0, 0.0);
    measure("tracking loop", |x, _| pll.update(&mut s, x));
    let two = TwoChannel::<f64>::new(0.1, 10.0, dt)?;
    let mut s = TwoChannelState::new(0.0, 0.0, 0.0);
    measure("two channels", |x, a| two.update(&mut s, x, a));
    let observer = Observer::<f64>::new(5.0, 25.0, dt)?;
    let mut s = ObserverState::new(0.0, 0.0, 0.0);
    measure("observer, second order", |x, a| {
        observer.update(&mut s, x, a)
    });
    let adaptive = AdaptiveObserver::<f64>::new(5.0, 25.0, 1.0, 1e-3, dt)?;
    let mut s = AdaptiveObserverState::new(0.0, 0.0, 0.0);
    measure("observer, adaptive gain", |x, a| {
        adaptive.update(&mut s, x, a)
    });
    let kalman = Kalman::<f64, 2>::new(&noise, Hold::First, dt)?;
    let mut s = KalmanState::new([0.0; 2], [1.0; 2], 0.0);
    measure("Kalman, two states", |x, a| {
        kalman.step(&mut s, Some(x), a);
        s.x[1]
    });
    let walk = BiasModel::RandomWalk { density: 1e-8 };
    let kalman3 = Kalman::<f64, 3>::with_bias(&noise, walk, Hold::First, dt)?;
    let mut s3 = KalmanState::new([0.0; 3], [1.0; 3], 0.0);
    measure("Kalman, three states", |x, a| {
        kalman3.step(&mut s3, Some(x), a);
        s3.x[1]
    });
    let steady = kalman.steady()?;
    measure("Kalman, steady gain", |x, a| {
        steady.step(&mut s, Some(x), a)
    });
    Ok(())
}

//! Cost of one step of each velocity estimator and of the compensation.
//!
//! Without arguments: nanoseconds, the best of several runs over a million samples of an oscillation. With the name
//! of one and a number of steps: runs these steps and says nothing, for tools that count instructions
//! (`bench/instructions.py`).

use proofmass_core::velocity::*;
use proofmass_core::{Error, Matrix3, SensorModel};
use std::hint::black_box;
use std::time::Instant;

/// What is done with each: timed, or one of them run.
enum Task {
    Time,
    Run { name: String, steps: usize },
}

impl Task {
    fn measure(&self, name: &str, mut step: impl FnMut(f64, f64) -> f64) {
        let signal: Vec<(f64, f64)> = (0..4096)
            .map(|k| {
                let t = 1e-3 * f64::from(k);
                ((25.0 * t).sin() * 0.06, -(25.0 * t).sin() * 37.5)
            })
            .collect();
        let mut steps = |n: usize| {
            let mut sum = 0.0;
            for k in 0..n {
                let (x, a) = signal[k & 4095];
                sum += step(black_box(x), black_box(a));
            }
            black_box(sum);
        };
        match self {
            Self::Run { name: wanted, .. } if wanted != name => {}
            Self::Run { steps: n, .. } => steps(*n),
            Self::Time => {
                const SAMPLES: usize = 1_000_000;
                let mut best = f64::INFINITY;
                for _ in 0..7 {
                    let start = Instant::now();
                    steps(SAMPLES);
                    best = best.min(start.elapsed().as_secs_f64());
                }
                println!("{name:28} {:7.2} ns", 1e9 * best / SAMPLES as f64);
            }
        }
    }
}

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let task = match (arguments.next(), arguments.next()) {
        (Some(name), Some(steps)) => Task::Run {
            name,
            steps: steps.parse().unwrap_or(0),
        },
        _ => Task::Time,
    };
    let dt = 1e-3;
    let noise = MotionNoise {
        acceleration: 4e-4,
        form: ProcessNoise::SampleConstant,
        position: 7e-8,
    };
    task.measure("nothing", |x, a| x + a);

    let k = Matrix3([[415.0, 1.2, 0.3], [0.0, 413.0, -0.8], [0.0, 0.0, 415.0]]);
    let model = SensorModel::<f64>::new(k, [33123.0, 33276.0, 32360.0])?;
    task.measure("compensation", |x, a| model.apply([x, a, x]).iter().sum());
    let single = model.cast::<f32>();
    task.measure("compensation-f32", |x, a| {
        let [x, a] = [x as f32, a as f32];
        f64::from(single.apply([x, a, x]).iter().sum::<f32>())
    });

    let trapezoid = Integrator::<f64>::new(IntegratorRule::Trapezoid, dt)?;
    let mut s = IntegratorState::new(0.0);
    task.measure("trapezoid", |_, a| trapezoid.step(&mut s, a));
    let tick = Integrator::<f64>::new(IntegratorRule::Tick, dt)?;
    let mut s = IntegratorState::new(0.0);
    task.measure("tick", |_, a| tick.step(&mut s, a));
    let m = FixedTime::<f64>::new(1e-4, dt)?;
    let mut s = FixedTimeState::new(0);
    task.measure("fixed-time", |x, _| m.step(&mut s, (1e4 * x) as i32));
    let mt = MixedTime::<f64>::new(1e-4, 1e6, 0.1)?;
    let mut s = MixedTimeState::new(Edge {
        count: 0,
        ticks: 0,
        upwards: true,
    });
    let mut ticks = 0u32;
    task.measure("mixed-time", |x, _| {
        ticks = ticks.wrapping_add(1000);
        let edge = Edge {
            count: (1e4 * x) as i32,
            ticks: ticks.wrapping_sub(100),
            upwards: true,
        };
        mt.step(&mut s, ticks, Some(edge)).velocity
    });
    let fit = PositionDifference::<f64, 9>::savitzky_golay(2, dt)?;
    let mut s = PositionDifferenceState::new(0.0);
    task.measure("savitzky-golay-9", |x, _| fit.step(&mut s, x));
    let pll = TrackingLoop::<f64>::new(100.0, dt)?;
    let mut s = ObserverState::new(0.0, 0.0, 0.0);
    task.measure("tracking-loop", |x, _| pll.step(&mut s, x));
    let two = TwoChannel::<f64>::new(0.1, 10.0, dt)?;
    let mut s = TwoChannelState::new(0.0, 0.0, 0.0);
    task.measure("two-channels", |x, a| two.step(&mut s, x, a));
    let observer = Observer::<f64>::new(5.0, 25.0, dt)?;
    let mut s = ObserverState::new(0.0, 0.0, 0.0);
    task.measure("observer", |x, a| observer.step(&mut s, x, a));
    let observer32 = Observer::<f32>::new(5.0, 25.0, dt)?;
    let mut s = ObserverState::new(0.0, 0.0, 0.0);
    task.measure("observer-f32", |x, a| {
        f64::from(observer32.step(&mut s, x as f32, a as f32))
    });
    let third = Observer::<f64>::with_offset(15.0, 75.0, 125.0, dt)?;
    let mut s = ObserverState::new(0.0, 0.0, 0.0);
    task.measure("observer-offset", |x, a| third.step(&mut s, x, a));
    let adaptive = AdaptiveObserver::<f64>::new(5.0, 25.0, 1.0, 1e-3, dt)?;
    let mut s = AdaptiveObserverState::new(0.0, 0.0, 0.0);
    task.measure("observer-adaptive", |x, a| adaptive.step(&mut s, x, a));
    let kalman = Kalman::<f64, 2>::new(&noise, Hold::Second, dt)?;
    let mut s = KalmanState::new([0.0; 2], [1.0; 2], 0.0);
    task.measure("kalman-2", |x, a| {
        kalman.step(&mut s, Some(x), a);
        s.x[1]
    });
    let steady = kalman.steady()?;
    task.measure("kalman-2-steady", |x, a| steady.step(&mut s, Some(x), a));
    let kalman32 = kalman.cast::<f32>();
    let mut s = KalmanState::new([0.0; 2], [1.0; 2], 0.0);
    task.measure("kalman-2-f32", |x, a| {
        kalman32.step(&mut s, Some(x as f32), a as f32);
        f64::from(s.x[1])
    });
    let walk = BiasModel::RandomWalk {
        density: 1e-8,
        initial: 0.0,
    };
    let kalman3 = Kalman::<f64, 3>::with_bias(&noise, walk, Hold::Second, dt)?;
    let mut s = KalmanState::new([0.0; 3], [1.0; 3], 0.0);
    task.measure("kalman-3", |x, a| {
        kalman3.step(&mut s, Some(x), a);
        s.x[1]
    });
    // The same through the face of all estimators, fed by a counter.
    let counter = Counter::<f32>::new(1e-4, 16)?;
    let mut word = CounterState::new(0);
    let mut s = observer32.start(0.0);
    task.measure("estimator-observer-f32", |x, a| {
        let sample = counter.sample(&mut word, (1e4 * x) as i32 as u32, a as f32);
        f64::from(observer32.estimate(&mut s, &sample))
    });
    let mut word = CounterState::new(0);
    let mut s = Estimator::start(&kalman32, 0.0);
    task.measure("estimator-kalman-2-f32", |x, a| {
        let sample = counter.sample(&mut word, (1e4 * x) as i32 as u32, a as f32);
        f64::from(kalman32.estimate(&mut s, &sample))
    });
    let resolver = ResolverLoop::<f32>::tracking(100.0, 1.0, dt)?;
    let mut s = resolver.start(0.0);
    task.measure("resolver-loop-f32", |x, _| {
        let x = x as f32;
        f64::from(resolver.step(&mut s, x, 1.0 - 0.5 * x * x, 0.0).velocity)
    });
    let counting = CountingKalman::<f32>::new(
        1e-4,
        dt,
        &CountingNoise {
            acceleration: 4e-4,
            walk: 0.0,
            edge: 0.005,
            tick: None,
        },
    )?;
    let mut word = CounterState::new(0);
    let mut s = Estimator::start(&counting, 0.0);
    task.measure("estimator-counting-f32", |x, a| {
        let sample = counter.sample(&mut word, (1e4 * x) as i32 as u32, a as f32);
        f64::from(counting.estimate(&mut s, &sample))
    });
    Ok(())
}

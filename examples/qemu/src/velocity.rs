//! Instructions of one step of the velocity estimators, in single precision.

use crate::measure;
use core::hint::black_box;
use proofmass_core::Error;
use proofmass_core::encoder::{Hall, HallSpacing};
use proofmass_core::velocity::{
    Counter, CounterState, CountingKalman, CountingNoise, Edge, Estimator, FixedTime,
    FixedTimeState, Hold, Kalman, MixedTime, MixedTimeState, MotionNoise, Observer, ObserverState,
    ProcessNoise, ResolverLoop, TrackingLoop,
};
use proofmass_example_firmware::drive::{Captured, Drive};

const PERIOD: f64 = 1e-3;
const INCREMENT: f64 = 1e-4;

/// A motion of 60 mm to and fro at 4 Hz, as its sensors show it.
struct Input {
    count: i32,
    position: f32,
    acceleration: f32,
    sine: f32,
    cosine: f32,
}

fn inputs() -> [Input; 64] {
    core::array::from_fn(|k| {
        let angle = 25.0 * PERIOD * k as f64;
        let position = 0.06 * libm::sin(angle);
        Input {
            count: (position / INCREMENT) as i32,
            position: position as f32,
            acceleration: (-37.5 * libm::sin(angle)) as f32,
            sine: libm::sin(angle) as f32,
            cosine: libm::cos(angle) as f32,
        }
    })
}

/// Name and ticks of each.
pub fn costs() -> Result<[(&'static str, u32); 10], Error> {
    let inputs = inputs();
    let at = |s: u32| black_box(&inputs[s as usize & 63]);
    let fixed = FixedTime::<f32>::new(INCREMENT, PERIOD)?;
    let mut state = FixedTimeState::new(0);
    let fixed = measure(|s| {
        black_box(fixed.step(&mut state, at(s).count));
    });
    let edge = |count, ticks| Edge {
        count,
        ticks,
        upwards: true,
    };
    let mixed = MixedTime::<f32>::new(INCREMENT, 1e6, 0.1)?;
    let mut state = MixedTimeState::new(edge(0, 0));
    let mut now = 0u32;
    let mixed = measure(|s| {
        now = now.wrapping_add(1000);
        let last = edge(at(s).count, now.wrapping_sub(100));
        black_box(mixed.step(&mut state, now, Some(last)));
    });
    let mut hall = Hall::new(HallSpacing::Wide);
    let hall = measure(|s| {
        let c = at(s).count;
        black_box(hall.update([c & 1 != 0, c & 2 != 0, c & 4 != 0]));
    });
    let tracking = TrackingLoop::<f32>::new(100.0, PERIOD)?;
    let mut state = ObserverState::new(0.0, 0.0, 0.0);
    let tracking = measure(|s| {
        black_box(tracking.step(&mut state, at(s).position));
    });
    let observer = Observer::<f32>::new(5.0, 25.0, PERIOD)?;
    let mut state = ObserverState::new(0.0, 0.0, 0.0);
    let observed = measure(|s| {
        let input = at(s);
        black_box(observer.step(&mut state, input.position, input.acceleration));
    });
    let resolver = ResolverLoop::<f32>::tracking(100.0, 1.0, PERIOD)?;
    let mut state = resolver.start(0.0);
    let resolver = measure(|s| {
        let input = at(s);
        black_box(resolver.step(&mut state, input.sine, input.cosine, 0.0));
    });
    let noise = MotionNoise {
        acceleration: 4e-4,
        form: ProcessNoise::SampleConstant,
        position: 7e-8,
    };
    let counter = Counter::<f32>::new(INCREMENT, 16)?;
    let kalman = Kalman::<f64, 2>::new(&noise, Hold::Second, PERIOD)?;
    let steady = kalman.cast::<f32>().steady()?;
    let kalman = kalman.cast::<f32>();
    let mut word = CounterState::new(0);
    let mut state = Estimator::start(&kalman, 0.0);
    let full = measure(|s| {
        let input = at(s);
        let sample = counter.sample(&mut word, input.count as u32, input.acceleration);
        black_box(kalman.estimate(&mut state, &sample));
    });
    let mut word = CounterState::new(0);
    let mut state = Estimator::start(&steady, 0.0);
    let constant = measure(|s| {
        let input = at(s);
        let sample = counter.sample(&mut word, input.count as u32, input.acceleration);
        black_box(steady.estimate(&mut state, &sample));
    });
    let edges = CountingNoise {
        acceleration: 4e-4,
        walk: 0.0,
        edge: 0.005,
        tick: None,
    };
    let counting = CountingKalman::<f32>::new(INCREMENT, PERIOD, &edges)?;
    let mut word = CounterState::new(0);
    let mut state = Estimator::start(&counting, 0.0);
    let counted = measure(|s| {
        let input = at(s);
        let sample = counter.sample(&mut word, input.count as u32, input.acceleration);
        black_box(counting.estimate(&mut state, &sample));
    });
    let mut drive = Drive::new(0)?;
    let mut clock = 0u32;
    let whole = measure(|s| {
        let input = at(s);
        clock = clock.wrapping_add(1000);
        black_box(drive.step(&Captured {
            count: input.count as u16,
            clock,
            edge: Some((clock.wrapping_sub(100), true)),
            acceleration: input.acceleration,
        }));
    });
    Ok([
        ("M, fixed time", fixed),
        ("M/T, mixed", mixed),
        ("Hall sensors", hall),
        ("tracking loop", tracking),
        ("observer", observed),
        ("resolver loop", resolver),
        ("counter and steady Kalman filter", constant),
        ("counter and Kalman filter, two states", full),
        ("counter and Kalman filter on edges", counted),
        ("drive: guard, M/T and Kalman filter on edges", whole),
    ])
}

//! Streaming estimators over the samples of a record.

use super::range;
use crate::filtering::start;
use crate::{KalmanModel, MotionRecord, steady_gain};
use proofmass_core::Error;
use proofmass_core::velocity::{
    Kalman, Observer, ObserverState, PositionDifference, PositionDifferenceState, ResolverLoop,
};
use std::f64::consts::TAU;

/// Difference over n readings; over fewer at the start.
pub(super) fn long_window(
    record: &MotionRecord,
    n: usize,
    dt: f64,
) -> Result<(Vec<f64>, f64), Error> {
    if !(1..=1_000_000).contains(&n) {
        return Err(range("samples of a window", n as f64, 1.0, 1e6));
    }
    let mut past: std::collections::VecDeque<f64> = std::collections::VecDeque::new();
    let v = at_readings(record, |x, v| {
        past.push_back(x);
        if past.len() > n + 1 {
            past.pop_front();
        }
        match past.len() - 1 {
            0 => v,
            steps => (x - past[0]) / (steps as f64 * dt),
        }
    });
    Ok((v, 0.5 * n as f64 * dt))
}

/// One-sided fit over the last N readings.
pub(super) fn window<const N: usize>(
    record: &MotionRecord,
    degree: usize,
    dt: f64,
) -> Result<(Vec<f64>, f64), Error> {
    let filter = PositionDifference::<f64, N>::savitzky_golay(degree, dt)?;
    let mut state: Option<PositionDifferenceState<f64, N>> = None;
    let v = at_readings(record, |x, v| {
        let state = state.get_or_insert_with(|| filter.start_moving(x, v));
        filter.step(state, x)
    });
    Ok((v, filter.delay()))
}

/// The loop on sine and cosine of the readings; where there is none, on no signal.
///
/// The loop divides by the amplitude: sine and cosine of the angle that was read are the voltages it feels.
pub(super) fn resolver_loop(
    record: &MotionRecord,
    b: f64,
    dt: f64,
) -> Result<(Vec<f64>, f64), Error> {
    let Some(turn) = record.turn else {
        return Err(range(
            "turns of a resolver, of a record without",
            0.0,
            1.0,
            1.0,
        ));
    };
    let way = turn / TAU;
    let tracking = ResolverLoop::<f64>::tracking(b, 1.0, dt)?;
    let stride = record.reading_stride();
    let first = record.reading.iter().position(Option::is_some).unwrap_or(0);
    let mut v = record.start_velocity().0;
    let mut state: Option<ObserverState<f64>> = None;
    let mut velocity = Vec::with_capacity(record.reading.len());
    for (k, reading) in record.reading.iter().enumerate() {
        if k >= first && (k - first).is_multiple_of(stride) {
            let (sine, cosine) = reading.map_or((0.0, 0.0), |x| (x / way).sin_cos());
            match &mut state {
                // From half a turn off a loop leaves slowly.
                None => state = Some(ObserverState::new(sine.atan2(cosine), v / way, 0.0)),
                Some(state) => v = way * tracking.step(state, sine, cosine, 0.0).velocity,
            }
        }
        velocity.push(v);
    }
    Ok((velocity, 2.0 / b))
}

/// Runs a position method at the stride of the readings and holds its velocity between.
pub(super) fn at_readings(
    record: &MotionRecord,
    mut update: impl FnMut(f64, f64) -> f64,
) -> Vec<f64> {
    let positions = record.positions();
    let stride = record.reading_stride();
    let step = stride as f64 * record.sample_time;
    let first = positions.iter().position(Option::is_some).unwrap_or(0);
    let mut v = record.start_velocity().0;
    let mut x = 0.0;
    let mut velocity = Vec::with_capacity(positions.len());
    for (k, p) in positions.iter().enumerate() {
        if k >= first && (k - first).is_multiple_of(stride) {
            x = p.unwrap_or(x + v * step);
            v = update(x, v);
        }
        velocity.push(v);
    }
    velocity
}

/// Runs a fused method at every sample; without a reading the position moves on with velocity and acceleration.
pub(super) fn at_samples(
    record: &MotionRecord,
    mut update: impl FnMut(f64, f64, f64) -> f64,
) -> Vec<f64> {
    let positions = record.positions();
    let dt = record.sample_time;
    let mut v = record.start_velocity().0;
    let mut x = positions.iter().flatten().next().copied().unwrap_or(0.0);
    let mut before = record.acceleration[0];
    let mut velocity = Vec::with_capacity(positions.len());
    for (k, (p, a)) in positions.iter().zip(&record.acceleration).enumerate() {
        let coast = if k == 0 {
            x
        } else {
            x + dt * v + dt * dt * (before / 3.0 + a / 6.0)
        };
        x = p.unwrap_or(coast);
        v = update(x, *a, v);
        before = *a;
        velocity.push(v);
    }
    velocity
}

pub(super) fn observe(record: &MotionRecord, observer: &Observer<f64>) -> Vec<f64> {
    let positions = record.positions();
    let dt = record.sample_time;
    let x0 = positions.iter().flatten().next().copied().unwrap_or(0.0);
    let v0 = record.start_velocity().0;
    let mut state = ObserverState::new(x0, v0, record.acceleration[0]);
    let mut velocity = vec![v0];
    let mut before = record.acceleration[0];
    for (p, a) in positions.iter().zip(&record.acceleration).skip(1) {
        let coast = state.position + dt * state.velocity + dt * dt * (before / 3.0 + a / 6.0);
        velocity.push(observer.step(&mut state, p.unwrap_or(coast), *a));
        before = *a;
    }
    velocity
}

pub(super) fn steady(record: &MotionRecord, model: &KalmanModel) -> Result<Vec<f64>, Error> {
    let dt = record.sample_time;
    if let Some(corner) = record.behind_two_stages() {
        let kalman = model.behind_two_stages(&corner, dt)?;
        return settled(&kalman, &record.taken_again(&corner));
    }
    match model.bias {
        None => settled(&model.two(dt)?, record),
        Some(bias) => settled(&model.three(bias, dt)?.0, record),
    }
}

/// With the gain that the filter settles to.
fn settled<const N: usize>(
    kalman: &Kalman<f64, N>,
    record: &MotionRecord,
) -> Result<Vec<f64>, Error> {
    let gain = steady_gain(kalman, record.source)?;
    let mut state = start::<N>(record, kalman.r, 0.0);
    state.x[1] = record.start_velocity().0;
    let mut velocity = vec![state.x[1]];
    for (p, a) in record.reading.iter().zip(&record.acceleration).skip(1) {
        velocity.push(gain.step(&mut state, *p, *a));
    }
    Ok(velocity)
}

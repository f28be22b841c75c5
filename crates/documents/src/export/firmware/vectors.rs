//! Steps with which an exported filter checks itself: inputs, and what the desk computed for them.

use super::{FirmwareBlock, LONGEST_AVERAGE};
use proofmass_core::encoder::ErrorLine;
use proofmass_core::velocity::{
    KalmanState, Observer, ObserverState, SteadyKalman, TwoChannel, TwoChannelState,
};
use proofmass_core::{
    BiasFilter, BiasState, Butterworth, Error, Float, LowPassState, check, weighted_sum,
};
use serde::Serialize;
use serde_json::json;

/// Steps.
const STEPS: usize = 16;
/// Operations of one step that may round otherwise, for any of the filters.
const OPERATIONS: f64 = 20.0;

/// Inputs and results of sixteen steps from rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Vectors {
    /// First input: sample, reading, or measured acceleration.
    pub(super) first: Vec<f64>,
    /// Second input: acceleration, or known acceleration; zero where there is none.
    pub(super) second: Vec<f64>,
    /// Result of each step.
    pub(super) expected: Vec<f64>,
    /// Largest difference that rounding explains.
    pub(super) bound: f64,
}

impl Vectors {
    pub(super) fn of(block: &FirmwareBlock, single: bool) -> Result<Self, Error> {
        if single {
            run::<f32>(block, f64::from(f32::EPSILON))
        } else {
            run::<f64>(block, f64::EPSILON)
        }
    }
}

fn run<T: Float>(block: &FirmwareBlock, epsilon: f64) -> Result<Vectors, Error> {
    // What single precision holds is what every precision is given.
    let to = |v: f64| f64::from(v as f32);
    let wave = |k: usize, a: f64, b: f64| to(a * (b * (k as f64 + 1.0)).sin());
    let steps = 0..STEPS;
    let mut first: Vec<f64> = steps.clone().map(|k| wave(k, 1.0, 0.7)).collect();
    let mut second = vec![0.0; STEPS];
    let t = T::from_f64;
    let mut largest = 1.0f64;
    let expected: Vec<T> = match block {
        FirmwareBlock::LowPass { corner, rate } => {
            let filter = Butterworth::<T>::new(*corner, *rate)?;
            let mut state = LowPassState::at(T::ZERO);
            first
                .iter()
                .map(|v| filter.step(&mut state, t(*v)))
                .collect()
        }
        FirmwareBlock::LinearPhase { taps, rate, .. } => {
            check::positive("sampling rate, Hz", *rate)?;
            let taps: Vec<T> = taps.iter().map(|h| t(*h)).collect();
            let mut past = vec![T::ZERO; taps.len()];
            first
                .iter()
                .map(|v| {
                    past.push(t(*v));
                    weighted_sum(&taps, [&past[past.len() - taps.len()..], &[]])
                })
                .collect()
        }
        FirmwareBlock::MovingAverage { samples, rate } => {
            check_average(*samples, *rate)?;
            let mut past: Vec<T> = Vec::new();
            first
                .iter()
                .map(|v| {
                    past.push(t(*v));
                    let from = past.len().saturating_sub(*samples);
                    let mut sum = T::ZERO;
                    for v in &past[from..] {
                        sum += *v;
                    }
                    sum / t((past.len() - from) as f64)
                })
                .collect()
        }
        FirmwareBlock::Bias {
            coefficients,
            state,
            ..
        } => {
            let [keep, process, noise] = coefficients[0].map(t);
            let filter = BiasFilter::constant(keep, process, noise);
            let [bias, variance] = state[0].map(t);
            let mut state = BiasState::known(bias, variance);
            second = steps.map(|k| wave(k, 1.0, 0.9)).collect();
            first
                .iter_mut()
                .zip(&second)
                .for_each(|(m, k)| *m = to(*k + 0.01 * *m));
            first
                .iter()
                .zip(&second)
                .map(|(measured, known)| {
                    filter.predict(&mut state);
                    filter.update(&mut state, t(*measured), t(*known));
                    state.bias()
                })
                .collect()
        }
        FirmwareBlock::Velocity {
            filter,
            sample_time,
        } => {
            moving(*sample_time, &mut first, &mut second);
            kalman(filter, [0.0; 2], [&first, &second], &mut largest)
        }
        FirmwareBlock::VelocityOffset {
            filter,
            offset,
            sample_time,
        } => {
            moving(*sample_time, &mut first, &mut second);
            let begin = [0.0, 0.0, *offset];
            kalman(filter, begin, [&first, &second], &mut largest)
        }
        FirmwareBlock::VelocityCorner {
            filter,
            sample_time,
            ..
        } => {
            moving(*sample_time, &mut first, &mut second);
            kalman(filter, [0.0; 4], [&first, &second], &mut largest)
        }
        FirmwareBlock::VelocitySecondOrderCorner {
            filter,
            sample_time,
            ..
        } => {
            moving(*sample_time, &mut first, &mut second);
            kalman(filter, [0.0; 5], [&first, &second], &mut largest)
        }
        FirmwareBlock::Observer {
            k_x,
            k_v,
            k_b,
            sample_time,
        } => {
            let observer = Observer::<T>::with_offset(*k_x, *k_v, *k_b, *sample_time)?;
            let mut state = ObserverState::new(T::ZERO, T::ZERO, T::ZERO);
            moving(*sample_time, &mut first, &mut second);
            pairs(&first, &second)
                .map(|(p, a)| observer.step(&mut state, t(p), t(a)))
                .collect()
        }
        FirmwareBlock::TwoChannel {
            k1,
            k2,
            sample_time,
        } => {
            let filter = TwoChannel::<T>::new(*k1, *k2, *sample_time)?;
            let mut state = TwoChannelState::new(T::ZERO, T::ZERO, T::ZERO);
            moving(*sample_time, &mut first, &mut second);
            pairs(&first, &second)
                .map(|(p, a)| filter.step(&mut state, t(p), t(a)))
                .collect()
        }
        FirmwareBlock::EncoderMap { turn, lines, .. } => {
            check::positive("turn of the encoder", *turn)?;
            first.iter_mut().for_each(|v| *v = to(*v * turn));
            let sizes = lines.iter().map(|l| l.cosine.abs() + l.sine.abs());
            let turns = lines.iter().map(|l| l.order.abs()).fold(1.0, f64::max);
            largest = sizes.sum::<f64>() * turns;
            let chip: Vec<ErrorLine<T>> = lines.iter().map(line).collect();
            first
                .iter()
                .map(|reading| {
                    let turns = t(*reading) / t(*turn);
                    let mut sum = T::ZERO;
                    for line in &chip {
                        sum += line.at(turns);
                    }
                    sum
                })
                .collect()
        }
    };
    let expected: Vec<f64> = expected.into_iter().map(Float::to_f64).collect();
    if let Some(index) = expected.iter().position(|v| !v.is_finite()) {
        return Err(Error::NotFinite {
            name: "result of the filter",
            index,
        });
    }
    let all = first.iter().chain(&second).chain(&expected);
    // A map is summed line by line and has no memory; its readings are no terms of the sum.
    if !matches!(block, FirmwareBlock::EncoderMap { .. }) {
        largest = all.fold(largest, |m, v| m.max(v.abs()));
    }
    Ok(Vectors {
        first,
        second,
        expected,
        bound: OPERATIONS * STEPS as f64 * epsilon * largest,
    })
}

pub(super) fn line<T: Float>(line: &ErrorLine<f64>) -> ErrorLine<T> {
    ErrorLine {
        order: T::from_f64(line.order),
        cosine: T::from_f64(line.cosine),
        sine: T::from_f64(line.sine),
    }
}

fn check_average(samples: usize, rate: f64) -> Result<(), Error> {
    if !(1..=LONGEST_AVERAGE).contains(&samples) {
        return Err(Error::OutOfRange {
            name: "samples of the mean",
            value: samples as f64,
            min: 1.0,
            max: LONGEST_AVERAGE as f64,
        });
    }
    check::positive("sampling rate, Hz", rate)?;
    Ok(())
}

/// A motion in `first` (position) and `second` (acceleration) that fits the sample time.
fn moving(sample_time: f64, first: &mut [f64], second: &mut [f64]) {
    for (k, (p, a)) in first.iter_mut().zip(second).enumerate() {
        let phase = 0.7 * (k as f64 + 1.0);
        *a = f64::from(phase.sin() as f32);
        *p = f64::from((sample_time * sample_time * 3.0 * phase.cos()) as f32);
    }
}

fn pairs<'a>(first: &'a [f64], second: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
    first.iter().copied().zip(second.iter().copied())
}

fn kalman<T: Float, const N: usize>(
    filter: &SteadyKalman<f64, N>,
    begin: [f64; N],
    [first, second]: [&[f64]; 2],
    largest: &mut f64,
) -> Vec<T> {
    let to = T::from_f64;
    let filter = SteadyKalman::<T, N> {
        f: filter.f.map(|row| row.map(to)),
        g: filter.g.map(|row| row.map(to)),
        k: filter.k.map(to),
        component: filter.component,
        velocity_variance: to(filter.velocity_variance),
    };
    let mut state = KalmanState::new(begin.map(to), [T::ZERO; N], T::ZERO);
    pairs(first, second)
        .map(|(p, a)| {
            let v = filter.step(&mut state, Some(to(p)), to(a));
            let states = state.x.iter().map(|x| x.to_f64().abs());
            *largest = states.fold(*largest, f64::max);
            v
        })
        .collect()
}

/// The coefficients themselves.
pub(super) fn plain(block: &FirmwareBlock) -> Result<serde_json::Value, Error> {
    fn filter<const N: usize>(
        kind: &str,
        filter: &SteadyKalman<f64, N>,
        sample_time: f64,
    ) -> serde_json::Value {
        let rows = |m: &[[f64; N]]| m.iter().map(|r| r.to_vec()).collect::<Vec<_>>();
        json!({
            "kind": kind, "sample_time_s": sample_time, "F": rows(&filter.f), "G": rows(&filter.g),
            "K": filter.k.to_vec(), "read": filter.component, "velocity_variance": filter.velocity_variance,
        })
    }
    let behind = |mut filter: serde_json::Value, corner: f64| {
        filter["corner_Hz"] = json!(corner);
        filter
    };
    Ok(match block {
        FirmwareBlock::LowPass { corner, rate } => {
            let design = Butterworth::<f64>::new(*corner, *rate)?;
            json!({
                "kind": "low-pass", "corner_Hz": corner, "rate_Hz": rate,
                "numerator": design.numerator, "denominator": [1.0, design.denominator[0], design.denominator[1]],
            })
        }
        FirmwareBlock::LinearPhase {
            taps,
            corner,
            ripple,
            stop,
            stop_gain,
            rate,
        } => json!({
            "kind": "linear-phase", "corner_Hz": corner, "ripple": ripple, "stop_Hz": stop, "stop_gain": stop_gain, "rate_Hz": rate,
            "taps": taps,
        }),
        FirmwareBlock::Velocity {
            filter: f,
            sample_time,
        } => filter("velocity", f, *sample_time),
        FirmwareBlock::VelocityOffset {
            filter: f,
            offset,
            sample_time,
        } => {
            let mut plain = filter("velocity-offset", f, *sample_time);
            plain["begin"] = json!([0.0, 0.0, offset]);
            plain
        }
        FirmwareBlock::VelocityCorner {
            filter: f,
            corner,
            sample_time,
        } => behind(filter("velocity-corner", f, *sample_time), *corner),
        FirmwareBlock::VelocitySecondOrderCorner {
            filter: f,
            corner,
            sample_time,
        } => behind(
            filter("velocity-second-order-corner", f, *sample_time),
            *corner,
        ),
        FirmwareBlock::MovingAverage { samples, rate } => {
            json!({"kind": "moving-average", "samples": samples, "rate_Hz": rate})
        }
        FirmwareBlock::Bias {
            rate,
            coefficients,
            state,
        } => json!({
            "kind": "bias", "rate_Hz": rate, "phi_Q_R": coefficients, "bias_and_variance": state,
        }),
        FirmwareBlock::Observer {
            k_x,
            k_v,
            k_b,
            sample_time,
        } => json!({
            "kind": "observer", "sample_time_s": sample_time, "k_x": k_x, "k_v": k_v, "k_b": k_b,
        }),
        FirmwareBlock::TwoChannel {
            k1,
            k2,
            sample_time,
        } => json!({
            "kind": "two-channel", "sample_time_s": sample_time, "k1": k1, "k2": k2,
        }),
        FirmwareBlock::EncoderMap { turn, lines, unit } => {
            let lines: Vec<_> = lines
                .iter()
                .map(|l| json!({"cycles_per_turn": l.order, "cosine": l.cosine, "sine": l.sine}))
                .collect();
            json!({"kind": "encoder-map", "turn": turn, "unit": unit, "lines": lines})
        }
    })
}

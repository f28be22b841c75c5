//! Transition, noise and readings of the states, and the columns that run through them.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

use super::{
    COLUMNS, DATA, GAIN, LATENCY, Noise, OFFSET, PARABOLA, Prepared, RAMP, START_POSITION,
    START_VELOCITY,
};
use crate::filtering::component;
use crate::step_input::shake;
use crate::{MotionRecord, ProcessNoise};
use proofmass_core::state_space::{Gain, Reading, predict, predict_covariance};

/// Transition, noise, start and reading of N states: position, velocity, then the walk, its slope behind two stages of a corner, then the
/// coloured part.
pub(super) struct System<const N: usize> {
    pub(super) f: [[f64; N]; N],
    pub(super) q: [[f64; N]; N],
    pub(super) p: [[f64; N]; N],
    pub(super) reading: Reading<f64, N>,
    pub(super) r: f64,
}

/// Density of the walk of the slope; nothing without a walk, and without two stages.
fn slope(noise: &Noise, record: &MotionRecord) -> Option<f64> {
    let corner = record.behind_two_stages()?;
    noise.walk.map(|walk| corner.slope_of_walk(walk))
}

/// States of this noise beside this record.
pub(super) fn states(noise: &Noise, record: &MotionRecord) -> usize {
    let further = [
        noise.walk.is_some(),
        slope(noise, record).is_some(),
        noise.colour.is_some(),
    ];
    2 + further.into_iter().filter(|state| *state).count()
}

pub(super) fn system<const N: usize>(noise: &Noise, record: &MotionRecord) -> System<N> {
    let t = record.sample_time;
    let [xx, xv, vv] = match noise.form {
        ProcessNoise::SampleConstant => [t.powi(4) / 4.0, t.powi(3) / 2.0, t * t],
        ProcessNoise::Continuous => [t.powi(3) / 3.0, t * t / 2.0, t],
    };
    let mut f = [[0.0; N]; N];
    let mut q = [[0.0; N]; N];
    let mut p = [[0.0; N]; N];
    for i in 0..N {
        f[i][i] = 1.0;
    }
    f[0][1] = t;
    (q[0][0], q[0][1], q[1][0], q[1][1]) = (noise.q * xx, noise.q * xv, noise.q * xv, noise.q * vv);
    if let Some(s) = noise.walk {
        (f[0][2], f[1][2]) = (-0.5 * t * t, -t);
        let row = [t.powi(5) / 20.0, t.powi(4) / 8.0, -t.powi(3) / 6.0];
        let rest = [t.powi(3) / 3.0, -0.5 * t * t, t];
        q[0][0] += s * row[0];
        q[0][1] += s * row[1];
        q[1][0] += s * row[1];
        q[1][1] += s * rest[0];
        (q[0][2], q[2][0]) = (s * row[2], s * row[2]);
        (q[1][2], q[2][1]) = (s * rest[1], s * rest[1]);
        q[2][2] = s * rest[2];
    }
    if let Some(s) = slope(noise, record) {
        // What a slope of one has become of each state after τ: a coefficient times a power of τ.
        let shares: [(f64, i32); 4] = [(-1.0 / 6.0, 3), (-0.5, 2), (1.0, 1), (1.0, 0)];
        for (i, (a, power)) in shares.into_iter().enumerate() {
            f[i][3] = a * t.powi(power);
            for (j, (b, other)) in shares.into_iter().enumerate() {
                let both = power + other + 1;
                q[i][j] += s * a * b * t.powi(both) / f64::from(both);
            }
        }
    }
    if let Some((variance, time)) = noise.colour {
        let phi = (-t / time).exp();
        f[N - 1][N - 1] = phi;
        q[N - 1][N - 1] = -variance * (-2.0 * t / time).exp_m1();
        p[N - 1][N - 1] = variance;
    }
    // The coloured part, the last state, adds to what is read.
    let at = component(record.source);
    let reading = match noise.colour {
        None => Reading::State(at),
        Some(_) => Reading::Combination(std::array::from_fn(|i| {
            f64::from(u8::from(i == at || i == N - 1))
        })),
    };
    System {
        f,
        q,
        p,
        reading,
        r: noise.r,
    }
}

/// Columns and covariance at one sample.
#[derive(Clone, Copy)]
pub(super) struct State<const N: usize> {
    pub(super) m: [[f64; N]; COLUMNS],
    pub(super) p: [[f64; N]; N],
}

/// Innovations of the columns and their common gain.
#[derive(Clone, Copy)]
pub(super) struct Seen<const N: usize> {
    pub(super) e: [f64; COLUMNS],
    pub(super) gain: Gain<f64, N>,
}

impl<const N: usize> System<N> {
    pub(super) fn start(&self, record: &MotionRecord) -> State<N> {
        let mut m = [[0.0; N]; COLUMNS];
        m[DATA][1] = record.initial_velocity.unwrap_or(0.0);
        m[START_VELOCITY][1] = 1.0;
        m[START_POSITION][0] = 1.0;
        State { m, p: self.p }
    }

    pub(super) fn predict(
        &self,
        state: &mut State<N>,
        prepared: &Prepared<'_>,
        k: usize,
        active: usize,
    ) {
        let t = prepared.record.sample_time;
        let u = prepared.curve.steps[k];
        let (now, before) = (
            prepared.record.acceleration[k],
            prepared.record.acceleration[k - 1],
        );
        let input = |column: usize| match column {
            DATA => u,
            OFFSET => [-0.5 * t * t, -t],
            GAIN => [-u[0], -u[1]],
            RAMP => {
                let from = t * (k - 1) as f64;
                [-t * t * (0.5 * from + t / 6.0), -t * (from + 0.5 * t)]
            }
            PARABOLA => {
                let from = t * (k - 1) as f64;
                [
                    -t * t * (from * from / 4.0 + from * t / 6.0 + t * t / 24.0),
                    -t * (0.5 * from * (from + t) + t * t / 6.0),
                ]
            }
            LATENCY => [u[1] - t * before, now - before],
            _ => [0.0; 2],
        };
        for (column, m) in state.m.iter_mut().enumerate().take(active) {
            let mut shift = [0.0; N];
            [shift[0], shift[1]] = input(column);
            *m = predict(&self.f, m, shift);
        }
        state.p = predict_covariance(&self.f, &state.p, &self.q);
        shake(&mut state.p, prepared.curve.unseen[k]);
    }

    pub(super) fn update(&self, state: &mut State<N>, reading: f64, active: usize) -> Seen<N> {
        let gain = Gain::new(self.reading, &state.p, self.r);
        let mut e = [0.0; COLUMNS];
        for (j, m) in state.m.iter_mut().enumerate().take(active) {
            e[j] = if j == DATA { reading } else { 0.0 } - self.reading.of(m);
            gain.correct(m, e[j]);
        }
        gain.reduce(&mut state.p);
        Seen { e, gain }
    }
}

/// Runs a body with the number of states the noise has.
macro_rules! with_states {
    ($noise:expr, $record:expr, |$system:ident| $body:expr) => {
        match $crate::diffuse::system::states($noise, $record) {
            2 => {
                let $system = $crate::diffuse::system::system::<2>($noise, $record);
                $body
            }
            3 => {
                let $system = $crate::diffuse::system::system::<3>($noise, $record);
                $body
            }
            4 => {
                let $system = $crate::diffuse::system::system::<4>($noise, $record);
                $body
            }
            _ => {
                let $system = $crate::diffuse::system::system::<5>($noise, $record);
                $body
            }
        }
    };
}

//! Transition, noise and readings of the states, and the columns that run through them.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

use super::{
    COLUMNS, DATA, GAIN, LATENCY, Noise, OFFSET, Prepared, START_POSITION, START_VELOCITY,
};
use crate::filtering::component;
use crate::step_input::shake;
use crate::{MotionRecord, ProcessNoise, ReadingSource};

/// Transition, noise, start and reading of N states: position, velocity, then the walk, then the coloured part.
pub(super) struct System<const N: usize> {
    pub(super) f: [[f64; N]; N],
    pub(super) q: [[f64; N]; N],
    pub(super) p: [[f64; N]; N],
    pub(super) at: usize,
    pub(super) colour: bool,
    pub(super) r: f64,
}

pub(super) fn system<const N: usize>(noise: &Noise, source: ReadingSource, t: f64) -> System<N> {
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
    if let Some((variance, time)) = noise.colour {
        let phi = (-t / time).exp();
        f[N - 1][N - 1] = phi;
        q[N - 1][N - 1] = -variance * (-2.0 * t / time).exp_m1();
        p[N - 1][N - 1] = variance;
    }
    System {
        f,
        q,
        p,
        at: component(source),
        colour: noise.colour.is_some(),
        r: noise.r,
    }
}

/// Columns and covariance at one sample.
#[derive(Clone, Copy)]
pub(super) struct State<const N: usize> {
    pub(super) m: [[f64; N]; COLUMNS],
    pub(super) p: [[f64; N]; N],
}

/// Innovations of the columns and their common variance.
#[derive(Clone, Copy)]
pub(super) struct Seen {
    pub(super) e: [f64; COLUMNS],
    pub(super) s: f64,
}

impl<const N: usize> System<N> {
    pub(super) fn start(&self, record: &MotionRecord) -> State<N> {
        let mut m = [[0.0; N]; COLUMNS];
        m[DATA][1] = record.initial_velocity.unwrap_or(0.0);
        m[START_VELOCITY][1] = 1.0;
        m[START_POSITION][0] = 1.0;
        State { m, p: self.p }
    }

    pub(super) fn advance(
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
            LATENCY => [u[1] - t * before, now - before],
            _ => [0.0; 2],
        };
        for (column, m) in state.m.iter_mut().enumerate().take(active) {
            let mut x = [0.0; N];
            for i in 0..N {
                for j in 0..N {
                    x[i] += self.f[i][j] * m[j];
                }
            }
            let [dx, dv] = input(column);
            x[0] += dx;
            x[1] += dv;
            *m = x;
        }
        let mut half = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..N {
                for l in 0..N {
                    half[i][j] += self.f[i][l] * state.p[l][j];
                }
            }
        }
        let mut p = self.q;
        for i in 0..N {
            for j in 0..=i {
                for l in 0..N {
                    p[i][j] += half[i][l] * self.f[j][l];
                }
                p[j][i] = p[i][j];
            }
        }
        shake(&mut p, prepared.curve.unseen[k]);
        state.p = p;
    }

    /// h · x.
    pub(super) fn shown(&self, x: &[f64; N]) -> f64 {
        x[self.at] + if self.colour { x[N - 1] } else { 0.0 }
    }

    /// P hᵀ.
    pub(super) fn column(&self, p: &[[f64; N]; N]) -> [f64; N] {
        std::array::from_fn(|i| self.shown(&p[i]))
    }

    pub(super) fn observe(&self, state: &mut State<N>, reading: f64, active: usize) -> Seen {
        let ph = self.column(&state.p);
        let s = self.shown(&ph) + self.r;
        let mut e = [0.0; COLUMNS];
        for (j, m) in state.m.iter_mut().enumerate().take(active) {
            e[j] = if j == DATA { reading } else { 0.0 } - self.shown(m);
            for i in 0..N {
                m[i] += ph[i] / s * e[j];
            }
        }
        for i in 0..N {
            for j in 0..=i {
                let p = if !self.colour && (i == self.at || j == self.at) {
                    // 1 − P/(P + R) is R/(P + R): the difference would lose an exact reading's digits.
                    state.p[i][j] * (self.r / s)
                } else {
                    state.p[i][j] - ph[i] * ph[j] / s
                };
                state.p[i][j] = p;
                state.p[j][i] = p;
            }
        }
        Seen { e, s }
    }
}

/// Runs a body with the number of states the noise has.
macro_rules! with_states {
    ($noise:expr, $source:expr, $t:expr, |$system:ident| $body:expr) => {
        match 2 + usize::from($noise.walk.is_some()) + usize::from($noise.colour.is_some()) {
            2 => {
                let $system = $crate::diffuse::system::system::<2>($noise, $source, $t);
                $body
            }
            3 => {
                let $system = $crate::diffuse::system::system::<3>($noise, $source, $t);
                $body
            }
            _ => {
                let $system = $crate::diffuse::system::system::<4>($noise, $source, $t);
                $body
            }
        }
    };
}

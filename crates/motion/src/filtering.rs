//! The Kalman filter of `core` over a whole record, with everything a smoother and a likelihood need.

use crate::{MotionRecord, ReadingSource};
use proofmass_core::Error;
use proofmass_core::velocity::{
    BiasModel, Hold, Innovation, Kalman, KalmanState, MotionNoise, ProcessNoise,
};
use serde::{Deserialize, Serialize};

/// A Kalman filter of an axis, as data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct KalmanModel {
    /// q, after `noise_form`.
    pub acceleration_noise: f64,
    /// What q means.
    pub noise_form: ProcessNoise,
    /// R: variance of a reading; δ²/12 for quantisation alone.
    pub reading_noise: f64,
    /// The accelerometer's offset; `None` where it has been removed, or is part of the noise.
    pub bias: Option<BiasModel>,
    /// Acceleration between samples.
    pub interpolation: Hold,
}

impl KalmanModel {
    /// No offset, the acceleration as a curve, q as a sample variance.
    pub fn new(acceleration_noise: f64, reading_noise: f64) -> Self {
        Self {
            acceleration_noise,
            noise_form: ProcessNoise::SampleConstant,
            reading_noise,
            bias: None,
            interpolation: Hold::Second,
        }
    }

    /// The same gains with every variance multiplied: q, R and those of the offset.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.acceleration_noise *= factor;
        self.reading_noise *= factor;
        self.bias = self.bias.map(|bias| bias.scaled(factor));
        self
    }

    fn noise(&self) -> MotionNoise {
        MotionNoise {
            acceleration: self.acceleration_noise,
            form: self.noise_form,
            position: self.reading_noise,
        }
    }

    /// The filter without offset state.
    pub(crate) fn two(&self, dt: f64) -> Result<Kalman<f64, 2>, Error> {
        Kalman::<f64, 2>::new(&self.noise(), self.interpolation, dt)
    }

    /// The filter with offset state, and the variance the offset starts with.
    pub(crate) fn three(&self, bias: BiasModel, dt: f64) -> Result<(Kalman<f64, 3>, f64), Error> {
        let kalman = Kalman::<f64, 3>::with_bias(&self.noise(), bias, self.interpolation, dt)?;
        Ok((kalman, bias.initial() * bias.initial()))
    }
}

/// Samples that the curve off line goes through.
const NODES: usize = 6;

/// Change of position and velocity that the acceleration makes over the step to each sample, by the polynomial of
/// fifth degree through the three samples before and after the middle of the step, at the ends through the six
/// nearest; `None` for models that take the acceleration otherwise, and for fewer samples.
pub(crate) fn steps(record: &MotionRecord, model: &KalmanModel) -> Option<Vec<[f64; 2]>> {
    let (a, dt) = (&record.acceleration, record.sample_time);
    let n = a.len();
    if model.interpolation != Hold::Second || n < NODES {
        return None;
    }
    // The step lies between the nodes j and j + 1 of its six.
    let weights: [_; NODES - 1] = std::array::from_fn(|j| step_weights(j as f64));
    let change = |k: usize| {
        let from = k.saturating_sub(NODES / 2).min(n - NODES);
        let (position, velocity) = &weights[k - 1 - from];
        let sum = |w: &[f64; NODES]| -> f64 {
            let pairs = w.iter().zip(&a[from..from + NODES]);
            pairs.map(|(w, a)| w * a).sum()
        };
        [dt * dt * sum(position), dt * sum(velocity)]
    };
    let first = std::iter::once([0.0; 2]);
    Some(first.chain((1..n).map(change)).collect())
}

/// The same for every model: where it takes no curve, the straight line, or the older sample.
pub(crate) fn step_inputs(record: &MotionRecord, model: &KalmanModel) -> Vec<[f64; 2]> {
    if let Some(curve) = steps(record, model) {
        return curve;
    }
    let (a, dt) = (&record.acceleration, record.sample_time);
    let step = |w: &[f64]| match model.interpolation {
        Hold::Zero => [0.5 * dt * dt * w[0], dt * w[0]],
        _ => [
            dt * dt * (w[0] / 3.0 + w[1] / 6.0),
            0.5 * dt * (w[0] + w[1]),
        ],
    };
    let first = std::iter::once([0.0; 2]);
    first.chain(a.windows(2).map(step)).collect()
}

/// ∫(1 − s) L_i and ∫ L_i over 0 < s < 1 for Lagrange's polynomials over 0…5, s counted from node `from`.
///
/// Gauss's rule of four points is exact up to degree seven.
fn step_weights(from: f64) -> ([f64; NODES], [f64; NODES]) {
    let root = (1.2f64).sqrt();
    let (near, far) = ((3.0 - 2.0 * root) / 7.0, (3.0 + 2.0 * root) / 7.0);
    let (heavy, light) = ((18.0 + 30f64.sqrt()) / 72.0, (18.0 - 30f64.sqrt()) / 72.0);
    let (mut position, mut velocity) = ([0.0; NODES], [0.0; NODES]);
    for (at, weight) in [
        (-far.sqrt(), light),
        (-near.sqrt(), heavy),
        (near.sqrt(), heavy),
        (far.sqrt(), light),
    ] {
        let s = 0.5 * (1.0 + at);
        for i in 0..NODES {
            let others = (0..NODES).filter(|j| *j != i).map(|j| j as f64);
            let lagrange: f64 = others.map(|j| (from + s - j) / (i as f64 - j)).product();
            position[i] += weight * (1.0 - s) * lagrange;
            velocity[i] += weight * lagrange;
        }
    }
    (position, velocity)
}

/// Every step of a filter over a record.
pub(crate) struct Pass<const N: usize> {
    pub prior: Vec<KalmanState<f64, N>>,
    pub posterior: Vec<KalmanState<f64, N>>,
    pub innovations: Vec<Option<Innovation<f64>>>,
}

/// State component the readings show.
pub(crate) fn component(source: ReadingSource) -> usize {
    match source {
        ReadingSource::Position => 0,
        ReadingSource::Speed => 1,
    }
}

/// Start of the filter at the first sample, before its reading.
///
/// An unknown velocity gets three times the fastest step of the readings as its standard deviation; an unknown
/// position the same over the time to the first reading, and a large multiple of the reading's own noise.
pub(crate) fn start<const N: usize>(
    record: &MotionRecord,
    r: f64,
    bias_variance: f64,
) -> KalmanState<f64, N> {
    let mut known = record
        .reading
        .iter()
        .enumerate()
        .filter_map(|(k, r)| r.map(|r| (k, r)));
    let (first_at, first) = known.next().unwrap_or((0, 0.0));
    let mut last = (first_at, first);
    let mut fastest = first.abs() * f64::from(u8::from(record.source == ReadingSource::Speed));
    for (k, x) in known {
        let speed = match record.source {
            ReadingSource::Position => {
                (x - last.1).abs() / ((k - last.0) as f64 * record.sample_time)
            }
            ReadingSource::Speed => x.abs(),
        };
        fastest = fastest.max(speed);
        last = (k, x);
    }
    let unknown = 9.0 * fastest * fastest + r;
    let (v, v_variance) = record.initial_velocity.map_or((0.0, unknown), |v| (v, 0.0));
    let wait = first_at as f64 * record.sample_time;
    let (x, x_variance) = match record.source {
        ReadingSource::Position => (first, 1e6 * r + unknown * wait * wait),
        ReadingSource::Speed => (0.0, 0.0),
    };
    let (mut state, mut variances) = ([0.0; N], [0.0; N]);
    state[0] = x;
    state[1] = v;
    variances[0] = x_variance;
    variances[1] = v_variance;
    if N > 2 {
        variances[2] = bias_variance;
    }
    let mut state = KalmanState::new(state, variances, record.acceleration[0]);
    // Before the first sample nothing is known: the first step takes a straight line.
    state.acceleration[1] = 2.0 * record.acceleration[0] - record.acceleration[1];
    state
}

fn time_update<const N: usize>(
    kalman: &Kalman<f64, N>,
    state: &mut KalmanState<f64, N>,
    acceleration: f64,
    step: Option<[f64; 2]>,
) {
    match step {
        None => kalman.predict(state, acceleration),
        Some([x, v]) => {
            let mut input = [0.0; N];
            (input[0], input[1]) = (x, v);
            kalman.advance(state, input);
        }
    }
}

/// The filter over the record, all steps kept.
///
/// With `steps` the acceleration acts as they say, else as the filter does on line.
pub(crate) fn pass<const N: usize>(
    kalman: &Kalman<f64, N>,
    record: &MotionRecord,
    bias_variance: f64,
    steps: Option<&[[f64; 2]]>,
) -> Pass<N> {
    let n = record.reading.len();
    let at = component(record.source);
    let mut state = start::<N>(record, kalman.r, bias_variance);
    let mut pass = Pass {
        prior: Vec::with_capacity(n),
        posterior: Vec::with_capacity(n),
        innovations: Vec::with_capacity(n),
    };
    for (k, (reading, a)) in record.reading.iter().zip(&record.acceleration).enumerate() {
        if k > 0 {
            time_update(kalman, &mut state, *a, steps.map(|s| s[k]));
        }
        pass.prior.push(state);
        pass.innovations
            .push(reading.map(|r| Kalman::observe(&mut state, at, r, kalman.r)));
        pass.posterior.push(state);
    }
    pass
}

/// A filter or smoother over a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KalmanRun {
    /// Velocity per sample.
    pub velocity: Vec<f64>,
    /// Its standard uncertainty from the covariance.
    pub velocity_uncertainty: Vec<f64>,
    /// Position per sample.
    pub position: Vec<f64>,
    /// Offset of the accelerometer per sample and its standard uncertainty, when it is a state.
    pub offset: Option<(Vec<f64>, Vec<f64>)>,
    /// Innovation over its predicted standard deviation, per sample with a reading.
    pub innovations: Vec<Option<f64>>,
    /// ln L of the readings: −½ Σ (ln 2πS + ν²/S).
    pub log_likelihood: f64,
}

impl KalmanModel {
    /// Filters the record: every estimate uses the readings up to its own time.
    ///
    /// # Errors
    /// Of the record ([`MotionRecord::check`]) and of the noise ([`Kalman::new`]); [`Error::NotFinite`] when the
    /// arithmetic overflowed.
    pub fn filter(&self, record: &MotionRecord) -> Result<KalmanRun, Error> {
        record.check()?;
        match self.bias {
            None => {
                let kalman = self.two(record.sample_time)?;
                let pass = pass(&kalman, record, 0.0, None);
                KalmanRun::of(&pass.posterior, &pass.innovations)
            }
            Some(bias) => {
                let (kalman, variance) = self.three(bias, record.sample_time)?;
                let pass = pass(&kalman, record, variance, None);
                KalmanRun::of(&pass.posterior, &pass.innovations)
            }
        }
    }
}

impl KalmanRun {
    pub(crate) fn of<const N: usize>(
        states: &[KalmanState<f64, N>],
        innovations: &[Option<Innovation<f64>>],
    ) -> Result<Self, Error> {
        let ok = |s: &KalmanState<f64, N>| {
            s.x.iter().all(|x| x.is_finite()) && s.p.iter().flatten().all(|p| p.is_finite())
        };
        if let Some(index) = states.iter().position(|s| !ok(s)) {
            return Err(Error::NotFinite {
                name: "filter state",
                index,
            });
        }
        let bad = |s: &KalmanState<f64, N>| s.p[1][1] < 0.0 || s.p[N - 1][N - 1] < 0.0;
        if let Some(s) = states.iter().find(|s| bad(s)) {
            return Err(Error::NotPositiveDefinite {
                name: "covariance of the state",
                row: 1,
                column: 1,
                value: s.p[1][1].min(s.p[N - 1][N - 1]),
            });
        }
        let log_likelihood = innovations
            .iter()
            .flatten()
            .map(|i| -0.5 * ((std::f64::consts::TAU * i.variance).ln() + i.normalised_squared()))
            .sum();
        Ok(Self {
            velocity: states.iter().map(|s| s.x[1]).collect(),
            velocity_uncertainty: states.iter().map(|s| s.p[1][1].sqrt()).collect(),
            position: states.iter().map(|s| s.x[0]).collect(),
            offset: (N > 2).then(|| {
                (
                    states.iter().map(|s| s.x[N - 1]).collect(),
                    states.iter().map(|s| s.p[N - 1][N - 1].sqrt()).collect(),
                )
            }),
            innovations: innovations
                .iter()
                .map(|i| i.map(|i| i.value / i.variance.sqrt()))
                .collect(),
            log_likelihood,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_fifth_degree_is_integrated_exactly_up_to_both_ends() {
        let dt = 0.1;
        let t = |k: usize| dt * k as f64 - 0.7;
        let n = 20;
        let record = MotionRecord::new(
            dt,
            ReadingSource::Position,
            vec![Some(0.0); n],
            (0..n).map(|k| 42.0 * t(k).powi(5)).collect(),
        )
        .unwrap();
        let steps = steps(&record, &KalmanModel::new(1.0, 1.0)).unwrap();
        // v = 7 t⁶, x = t⁷.
        for k in 1..n {
            let (a, b) = (t(k - 1), t(k));
            let v = 7.0 * (b.powi(6) - a.powi(6));
            let x = b.powi(7) - a.powi(7) - 7.0 * a.powi(6) * dt;
            assert!((steps[k][1] - v).abs() < 1e-13, "{k}");
            assert!((steps[k][0] - x).abs() < 1e-13, "{k}");
        }
    }
}

//! The Kalman filter of `core` over a whole record, with everything a smoother and a likelihood need.

use crate::step_input::{Curve, not_seen, shake};
use crate::{MotionRecord, ReadingSource};
use proofmass_core::Error;
use proofmass_core::state_space::Innovation;
use proofmass_core::velocity::{BiasModel, Hold, Kalman, KalmanState, MotionNoise, ProcessNoise};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A Kalman filter of an axis, as data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

    /// What drives the motion and what the readings err by.
    pub fn noise(&self) -> MotionNoise {
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

/// Every step of a filter over a record.
pub(crate) struct Pass<const N: usize> {
    pub(crate) prior: Vec<KalmanState<f64, N>>,
    pub(crate) posterior: Vec<KalmanState<f64, N>>,
    pub(crate) innovations: Vec<Option<Innovation<f64>>>,
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
    let u = record.initial_velocity_uncertainty;
    let (v, v_variance) = record
        .initial_velocity
        .map_or((0.0, unknown), |v| (v, u * u));
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
    // What the stages of a corner have shown of the velocity is no better known than the velocity.
    if N > 2 {
        variances[2..].fill(unknown);
        variances[N - 1] = bias_variance;
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
            kalman.predict_by(state, input);
        }
    }
}

/// The filter over the record, all steps kept.
///
/// With a curve the acceleration acts as it says, else as the filter does on line.
pub(crate) fn pass<const N: usize>(
    kalman: &Kalman<f64, N>,
    record: &MotionRecord,
    bias_variance: f64,
    curve: Option<&Curve>,
) -> Pass<N> {
    let n = record.reading.len();
    let unseen = curve.map_or_else(|| Cow::from(not_seen(record)), |c| Cow::from(&c.unseen));
    let at = component(record.source);
    let mut state = start::<N>(record, kalman.r, bias_variance);
    let mut pass = Pass {
        prior: Vec::with_capacity(n),
        posterior: Vec::with_capacity(n),
        innovations: Vec::with_capacity(n),
    };
    for (k, (reading, a)) in record.reading.iter().zip(&record.acceleration).enumerate() {
        if k > 0 {
            time_update(kalman, &mut state, *a, curve.map(|c| c.steps[k]));
            shake(&mut state.p, unseen[k]);
        }
        pass.prior.push(state);
        pass.innovations
            .push(reading.map(|r| kalman.update_state(&mut state, at, r)));
        pass.posterior.push(state);
    }
    pass
}

/// A filter or smoother over a record.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
        if let Some((_, pass)) = self.pass_behind_two_stages(record)? {
            return KalmanRun::of(&pass.posterior, &pass.innovations);
        }
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

impl KalmanModel {
    /// The filter whose states the stages of a corner are, and its pass, of a record behind two of them.
    ///
    /// The parabola that an offset becomes, and the noise integrated twice, are no offset that walks.
    pub(crate) fn pass_behind_two_stages(
        &self,
        record: &MotionRecord,
    ) -> Result<Option<(Kalman<f64, 5>, Pass<5>)>, Error> {
        let Some(corner) = record.behind_two_stages() else {
            return Ok(None);
        };
        let kalman = self.behind_two_stages(&corner, record.sample_time)?;
        let initial = self.bias.map_or(0.0, |bias| bias.initial());
        let shown = record.taken_again(&corner);
        let pass = pass(&kalman, &shown, initial * initial, None);
        Ok(Some((kalman, pass)))
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

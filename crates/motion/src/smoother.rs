//! The fixed-interval smoother: every estimate uses all readings, before and after it.

use crate::filtering::{KalmanModel, KalmanRun, Pass, component, pass};
use crate::step_input::curve;
use crate::{MotionRecord, ReadingSource};
use proofmass_core::Error;
use proofmass_core::state_space::{Adjoint, Gain, Reading};
use proofmass_core::velocity::{Kalman, KalmanState};

impl KalmanModel {
    /// Smooths the record: the best estimate of the model off line, and the reference where no truth exists.
    ///
    /// [`Adjoint`] goes back over the filter.
    ///
    /// # Errors
    /// As [`KalmanModel::filter`].
    pub fn smooth(&self, record: &MotionRecord) -> Result<KalmanRun, Error> {
        record.check()?;
        if let Some((kalman, pass)) = self.pass_behind_two_stages(record)? {
            let smoothed = backward(&kalman, &pass, record.source);
            return KalmanRun::of(&smoothed, &pass.innovations);
        }
        let curve = curve(record, self);
        match self.bias {
            None => {
                let kalman = self.two(record.sample_time)?;
                let pass = pass(&kalman, record, 0.0, curve.as_ref());
                KalmanRun::of(&backward(&kalman, &pass, record.source), &pass.innovations)
            }
            Some(bias) => {
                let (kalman, variance) = self.three(bias, record.sample_time)?;
                let pass = pass(&kalman, record, variance, curve.as_ref());
                KalmanRun::of(&backward(&kalman, &pass, record.source), &pass.innovations)
            }
        }
    }
}

/// Smoothed states; of their covariance the diagonal.
fn backward<const N: usize>(
    kalman: &Kalman<f64, N>,
    pass: &Pass<N>,
    source: ReadingSource,
) -> Vec<KalmanState<f64, N>> {
    let reading = Reading::State(component(source));
    let mut after = Adjoint::<f64, N>::default();
    let mut smoothed = pass.prior.clone();
    for (state, innovation) in smoothed.iter_mut().zip(&pass.innovations).rev() {
        let KalmanState { x, p, .. } = *state;
        if let Some(innovation) = innovation {
            after.update(&Gain::new(reading, &p, kalman.r), &[innovation.value]);
        }
        state.x = std::array::from_fn(|i| after.value(0, i, &x, &p));
        for i in 0..N {
            state.p[i][i] = after.variance(i, &p);
        }
        after.predict(&kalman.f, 1);
    }
    smoothed
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_core::velocity::BiasModel;

    fn record(n: usize) -> MotionRecord {
        let dt = 0.01;
        let t = |k: usize| dt * k as f64;
        let wiggle = |k: usize| ((k * 7919 % 101) as f64 - 50.0) / 50.0;
        let x = (0..n).map(|k| (k % 3 != 1).then(|| (3.0 * t(k)).sin() + 1e-3 * wiggle(k)));
        let a = (0..n).map(|k| -9.0 * (3.0 * t(k)).sin() + 0.1 * wiggle(k + 13));
        let mut r =
            MotionRecord::new(dt, ReadingSource::Position, x.collect(), a.collect()).unwrap();
        r.initial_velocity = None;
        r
    }

    #[test]
    fn crosscheck_rauch_tung_striebel_with_explicit_inverses() {
        let record = record(300);
        let model = KalmanModel::new(0.01, 3e-7);
        let kalman = model.two(record.sample_time).unwrap();
        let pass = pass(&kalman, &record, 0.0, curve(&record, &model).as_ref());
        let ours = model.smooth(&record).unwrap();
        let n = record.reading.len();
        let (mut x, mut p) = (pass.posterior[n - 1].x, pass.posterior[n - 1].p);
        for k in (0..n - 1).rev() {
            let (filtered, next) = (&pass.posterior[k], &pass.prior[k + 1]);
            let [[a, b], [_, d]] = next.p;
            let det = a * d - b * b;
            let inverse = [[d / det, -b / det], [-b / det, a / det]];
            let f = kalman.f;
            let mut c = [[0.0; 2]; 2];
            for i in 0..2 {
                for j in 0..2 {
                    for l in 0..2 {
                        for m in 0..2 {
                            c[i][j] += filtered.p[i][l] * f[m][l] * inverse[m][j];
                        }
                    }
                }
            }
            let dx = [x[0] - next.x[0], x[1] - next.x[1]];
            let mut new_p = filtered.p;
            for i in 0..2 {
                for j in 0..2 {
                    for l in 0..2 {
                        for m in 0..2 {
                            new_p[i][j] += c[i][l] * (p[l][m] - next.p[l][m]) * c[j][m];
                        }
                    }
                }
            }
            x = std::array::from_fn(|i| filtered.x[i] + c[i][0] * dx[0] + c[i][1] * dx[1]);
            p = new_p;
            assert!((ours.velocity[k] - x[1]).abs() < 1e-9, "{k}");
            // P⁻ − P⁻ Λ P⁻ and the explicit inverses both cancel where P⁻ is still 10⁶ times the final variance.
            let u = ours.velocity_uncertainty[k];
            let rounding = 1e-8 * pass.prior[k].p[1][1] + 1e-9 * p[1][1];
            assert!(
                (u * u - p[1][1]).abs() < rounding,
                "{k}: {} {}",
                u * u,
                p[1][1]
            );
        }
    }

    #[test]
    fn law_smoother_is_never_less_certain_than_the_filter() {
        let record = record(400);
        for bias in [
            None,
            Some(BiasModel::RandomWalk {
                density: 1e-4,
                initial: 0.5,
            }),
            Some(BiasModel::GaussMarkov {
                deviation: 0.2,
                time: 10.0,
            }),
        ] {
            let model = KalmanModel {
                bias,
                ..KalmanModel::new(0.01, 3e-7)
            };
            let (f, s) = (
                model.filter(&record).unwrap(),
                model.smooth(&record).unwrap(),
            );
            for (f, s) in f.velocity_uncertainty.iter().zip(&s.velocity_uncertainty) {
                assert!(*s <= f * (1.0 + 1e-9));
            }
            assert_eq!(f.offset.is_some(), bias.is_some());
        }
    }
}

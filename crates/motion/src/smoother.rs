//! The fixed-interval smoother: every estimate uses all readings, before and after it.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

use crate::filtering::{KalmanModel, KalmanRun, Pass, component, pass};
use crate::step_input::curve;
use crate::{MotionRecord, ReadingSource};
use proofmass_core::Error;
use proofmass_core::velocity::{Kalman, KalmanState};

impl KalmanModel {
    /// Smooths the record: the best estimate of the model off line, and the reference where no truth exists.
    ///
    /// The Rauch–Tung–Striebel estimate, computed in Bryson and Frazier's modified form: backward for
    /// λ̃ = −Hᵀν/S + (I − K H)ᵀ λ̂, λ̂ = Fᵀ λ̃ (and Λ likewise), x_s = x⁻ − P⁻ λ̃, P_s = P⁻ − P⁻ Λ̃ P⁻. No matrix is
    /// inverted, so a singular covariance (a known start) is no trouble.
    ///
    /// # Errors
    /// As [`KalmanModel::filter`].
    ///
    /// **Source** `[Bierman73]`; `[RauchTungStriebel65]`.
    pub fn smooth(&self, record: &MotionRecord) -> Result<KalmanRun, Error> {
        record.check()?;
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

fn backward<const N: usize>(
    kalman: &Kalman<f64, N>,
    pass: &Pass<N>,
    source: ReadingSource,
) -> Vec<KalmanState<f64, N>> {
    let at = component(source);
    let mut vector = [0.0; N];
    let mut matrix = [[0.0; N]; N];
    let mut smoothed = pass.prior.clone();
    for k in (0..pass.prior.len()).rev() {
        let prior = &pass.prior[k];
        if let Some(innovation) = pass.innovations[k] {
            let s = innovation.variance;
            // (I − K H)ᵀ x = x − Hᵀ (K · x); its diagonal is R/S, which 1 − K would lose for an exact reading.
            let gain: [f64; N] = std::array::from_fn(|i| prior.p[i][at] / s);
            let rest = kalman.r / s;
            let dot = |x: &dyn Fn(usize) -> f64| -> f64 {
                let others = (0..N).filter(|i| *i != at);
                rest * x(at) - others.map(|i| gain[i] * x(i)).sum::<f64>()
            };
            vector[at] = dot(&|i| vector[i]) - innovation.value / s;
            for i in 0..N {
                matrix[i][at] = dot(&|j| matrix[i][j]);
            }
            for j in 0..N {
                matrix[at][j] = dot(&|i| matrix[i][j]);
            }
            matrix[at][at] += 1.0 / s;
        }
        let state = &mut smoothed[k];
        let mut half = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..N {
                state.x[i] -= prior.p[i][j] * vector[j];
                for l in 0..N {
                    half[i][j] += prior.p[i][l] * matrix[l][j];
                }
            }
        }
        for i in 0..N {
            for j in 0..N {
                for l in 0..N {
                    state.p[i][j] -= half[i][l] * prior.p[l][j];
                }
            }
        }
        // A difference of doubles resolves no less of what it is taken from.
        for i in 0..N {
            state.p[i][i] = state.p[i][i].max(1e-12 * prior.p[i][i]);
        }
        // λ̂ = Fᵀ λ̃, Λ̂ = Fᵀ Λ̃ F
        let f = &kalman.f;
        vector = std::array::from_fn(|i| (0..N).map(|l| f[l][i] * vector[l]).sum());
        let mut half = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..N {
                for l in 0..N {
                    half[i][j] += matrix[i][l] * f[l][j];
                }
            }
        }
        for i in 0..N {
            for j in 0..N {
                matrix[i][j] = (0..N).map(|l| f[l][i] * half[l][j]).sum();
            }
        }
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

//! Likelihood, filter and smoother with constants of which nothing is known before: the start, and offset, gain and
//! latency of the accelerometer.
//!
//! Each unknown constant is a column that runs through the same recursion as the data, with the same gains; what they
//! are worth follows from the innovations by least squares. No start variance has to be invented, so that the scale of
//! the noise and an offset of 9.81 m/s² do not meet.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

#[macro_use]
mod system;
mod constants;
mod regression;
mod smoother;

pub(crate) use constants::{Solution, Sums};
pub(crate) use regression::{REGRESSORS, Regression};

#[cfg(test)]
use constants::solve;
use constants::{active, columns};
#[cfg(test)]
use smoother::spread;
use system::{Seen, System};

use crate::step_input::{Curve, step_inputs};
use crate::{KalmanModel, MotionRecord, ProcessNoise, ReadingSource};
use serde::{Deserialize, Serialize};

/// Which constants of the accelerometer are unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Unknowns {
    /// A constant is added to its readings.
    pub offset: bool,
    /// Its gain is not one.
    pub gain: bool,
    /// It is later than the readings by a constant time.
    pub latency: bool,
}

/// A part of the readings' error that is correlated in time: a first-order Gauss–Markov process.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ColouredNoise {
    /// Standard deviation, in the unit of the readings.
    pub deviation: f64,
    /// Correlation time, s.
    pub time: f64,
}

/// Noise of an axis without any start: what the likelihood is a function of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    /// q after `form`.
    pub(crate) q: f64,
    pub(crate) form: ProcessNoise,
    /// White part of a reading.
    pub(crate) r: f64,
    /// Density of the walk of the offset.
    pub(crate) walk: Option<f64>,
    /// Variance and correlation time of the coloured part of a reading.
    pub(crate) colour: Option<(f64, f64)>,
}

impl Noise {
    /// The same gains with every variance multiplied.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            q: self.q * factor,
            r: self.r * factor,
            walk: self.walk.map(|s| s * factor),
            colour: self.colour.map(|(v, t)| (v * factor, t)),
            ..self
        }
    }
}

/// Number of columns: the data, and seven constants.
const COLUMNS: usize = 8;
const DATA: usize = 0;
const START_VELOCITY: usize = 1;
const START_POSITION: usize = 2;
const OFFSET: usize = 3;
const GAIN: usize = 4;
const LATENCY: usize = 5;
/// Slope of the offset over time, where the acceleration was integrated.
const RAMP: usize = 6;
/// Bend of the offset over time, where it was integrated twice.
const PARABOLA: usize = 7;

/// A record made ready for many passes.
pub(crate) struct Prepared<'a> {
    record: &'a MotionRecord,
    /// What the acceleration does to position and velocity over the step to each sample.
    curve: Curve,
    first: f64,
}

/// Velocity with the constants found from all readings (smoother) or from those up to each sample (filter).
#[derive(Clone, Debug)]
pub(crate) struct Trajectory {
    pub(crate) velocity: Vec<f64>,
    pub(crate) uncertainty: Vec<f64>,
    /// Offset of the accelerometer and its standard uncertainty, when it is unknown.
    pub(crate) offset: Option<(Vec<f64>, Vec<f64>)>,
    /// Innovation over its standard deviation with the constants of the whole record, per reading.
    pub(crate) innovations: Vec<Option<f64>>,
}

impl Trajectory {
    /// The smoother of one model.
    pub fn of(run: crate::KalmanRun) -> Self {
        Self {
            velocity: run.velocity,
            uncertainty: run.velocity_uncertainty,
            offset: run.offset,
            innovations: run.innovations,
        }
    }
}

impl<'a> Prepared<'a> {
    pub fn new(record: &'a MotionRecord, model: &KalmanModel) -> Self {
        let first = match record.source {
            ReadingSource::Position => record.reading.iter().flatten().next().copied(),
            ReadingSource::Speed => None,
        };
        Self {
            record,
            curve: step_inputs(record, model),
            first: first.unwrap_or(0.0),
        }
    }

    /// Sums over the record; `motion` asks for the columns of gain and latency as well.
    pub fn sums(&self, noise: &Noise, motion: bool) -> Sums {
        let all = Unknowns {
            offset: true,
            gain: motion,
            latency: motion,
        };
        let active = active(&columns(self.record, all));
        with_states!(noise, self.record, |s| self.sums_of(&s, active))
    }

    fn sums_of<const N: usize>(&self, system: &System<N>, active: usize) -> Sums {
        let mut state = system.start(self.record);
        let mut sums = Sums {
            n: 0,
            logs: 0.0,
            g: [[0.0; COLUMNS]; COLUMNS],
        };
        for (k, reading) in self.record.reading.iter().enumerate() {
            if k > 0 {
                system.predict(&mut state, self, k, active);
            }
            if let Some(reading) = reading {
                let Seen { e, gain } = system.update(&mut state, reading - self.first, active);
                let s = gain.variance;
                sums.n += 1;
                sums.logs += s.ln();
                add(&mut sums.g, &e, s, active);
            }
        }
        for i in 0..COLUMNS {
            for j in 0..i {
                sums.g[j][i] = sums.g[i][j];
            }
        }
        sums
    }

    /// Innovations over their standard deviations for constants that were found.
    pub fn innovations(&self, noise: &Noise, solution: &Solution) -> Vec<f64> {
        let active = active(&solution.columns);
        with_states!(noise, self.record, |s| {
            let mut state = s.start(self.record);
            let mut list = Vec::with_capacity(self.record.reading.len());
            for (k, reading) in self.record.reading.iter().enumerate() {
                if k > 0 {
                    s.predict(&mut state, self, k, active);
                }
                if let Some(reading) = reading {
                    let seen = s.update(&mut state, reading - self.first, active);
                    list.push(total(&seen.e, solution) / seen.gain.variance.sqrt());
                }
            }
            list
        })
    }

    /// Every estimate uses the readings up to its own time; `None` before they determine the constants.
    #[cfg(test)]
    pub fn filter(&self, noise: &Noise, unknowns: Unknowns) -> Vec<Option<(f64, f64)>> {
        with_states!(noise, self.record, |s| {
            let mut state = s.start(self.record);
            let mut g = [[0.0; COLUMNS]; COLUMNS];
            let mut list = Vec::with_capacity(self.record.reading.len());
            for (k, reading) in self.record.reading.iter().enumerate() {
                if k > 0 {
                    s.predict(&mut state, self, k, COLUMNS);
                }
                if let Some(reading) = reading {
                    let seen = s.update(&mut state, reading - self.first, COLUMNS);
                    add(&mut g, &seen.e, seen.gain.variance, COLUMNS);
                }
                let mut full = g;
                for i in 0..COLUMNS {
                    for j in 0..i {
                        full[j][i] = full[i][j];
                    }
                }
                list.push(
                    solve(&full, columns(self.record, unknowns)).map(|solution| {
                        let c: Vec<f64> = solution.columns.iter().map(|c| state.m[*c][1]).collect();
                        spread(state.m[DATA][1], state.p[1][1], &c, &solution)
                    }),
                );
            }
            list
        })
    }
}

fn add(g: &mut [[f64; COLUMNS]; COLUMNS], e: &[f64; COLUMNS], s: f64, active: usize) {
    let inverse = 1.0 / s;
    for i in 0..active {
        let scaled = e[i] * inverse;
        for j in 0..=i {
            g[i][j] += scaled * e[j];
        }
    }
}

/// Innovation with the constants put in.
fn total(e: &[f64; COLUMNS], solution: &Solution) -> f64 {
    let constants = solution.columns.iter().zip(&solution.beta);
    e[DATA] + constants.map(|(c, b)| e[*c] * b).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vector() -> MotionRecord {
        let k = |k: usize| k as f64;
        let z = (0..200).map(|i| Some((100.0 * (0.03 * k(i)).sin()).round() / 1000.0));
        let a = (0..200).map(|i| {
            -0.9 * (0.03 * k(i)).sin() + 0.05 + 0.02 * (((7919 * i) % 101) as f64 - 50.0) / 50.0
        });
        MotionRecord::new(0.01, ReadingSource::Position, z.collect(), a.collect()).unwrap()
    }

    fn noise(q: f64) -> Noise {
        Noise {
            q,
            form: ProcessNoise::SampleConstant,
            r: 1e-6 / 12.0,
            walk: None,
            colour: None,
        }
    }

    fn near(ours: f64, theirs: f64, digits: f64) {
        assert!(
            (ours / theirs - 1.0).abs() < digits,
            "{ours} instead of {theirs}"
        );
    }

    /// Against a dense 200 × 200 covariance and an independent programme, printed to the digits that are compared.
    #[test]
    fn crosscheck_likelihood_constants_filter_and_smoother() {
        let record = vector();
        let model = KalmanModel::new(1.0, 1.0);
        let prepared = Prepared::new(&record, &model);
        let none = Unknowns::default();
        let offset = Unknowns {
            offset: true,
            ..none
        };
        let all = Unknowns {
            offset: true,
            gain: true,
            latency: true,
        };
        let q = 4e-4;
        let rows = [
            (
                noise(q),
                none,
                [-3238.68334598, 833.69962690, 1156.06943945, 6.01854339],
                [-0.28890843, 8.1235305e-4, -0.29722533, 4.1211179e-4],
            ),
            (
                noise(q),
                offset,
                [-3238.68334598, 1350.01365398, 1351.17220949, 0.85540312],
                [-0.29710328, 9.0612871e-4, -0.29722607, 4.1211179e-4],
            ),
            (
                noise(1e-4),
                offset,
                [-3245.55896612, 1352.17366560, 1353.12727003, 0.86818111],
                [-0.29693616, 5.9505092e-4, -0.29705999, 2.452114e-4],
            ),
            (
                noise(4e-3),
                offset,
                [-3220.42391353, 1342.73257810, 1344.22732126, 0.83691672],
                [-0.29718559, 2.0071865e-3, -0.29757633, 9.7679946e-4],
            ),
            (
                noise(q),
                all,
                [-3238.68334598, 1350.01954533, 1351.17909695, 0.85534421],
                [-0.29725400, 1.9821874e-3, -0.29722628, 4.1225164e-4],
            ),
            (
                Noise {
                    walk: Some(1e-3),
                    ..noise(q)
                },
                offset,
                [-3221.48051328, 1342.67383368, 1344.05663283, 0.84278716],
                [-0.29746080, 1.7059863e-3, -0.29733851, 5.0510204e-4],
            ),
            (
                Noise {
                    colour: Some((4e-7, 0.1)),
                    ..noise(q)
                },
                offset,
                [-3083.32904635, 1307.03030601, 1325.51268540, 0.50846511],
                [-0.29703490, 2.7569751e-3, -0.29685474, 7.3083557e-4],
            ),
        ];
        for (noise, unknowns, likelihood, velocity) in rows {
            let sums = prepared.sums(&noise, true);
            let solution = sums.solve(&record, unknowns).unwrap();
            let (_, concentrated, factor) = sums
                .solve_concentrated(&record, unknowns, f64::MIN_POSITIVE)
                .unwrap();
            // Printed to ten digits and more.
            near(sums.logs, likelihood[0], 1e-11);
            near(sums.log_likelihood(&solution), likelihood[1], 1e-10);
            near(concentrated, likelihood[2], 1e-10);
            near(factor, likelihood[3], 1e-7);
            let filtered = prepared.filter(&noise, unknowns)[100].unwrap();
            let smooth = prepared.smooth(&noise, &solution).unwrap();
            near(filtered.0, velocity[0], 1e-7);
            near(filtered.1, velocity[1], 1e-6);
            near(smooth.velocity[100], velocity[2], 1e-7);
            near(smooth.uncertainty[100], velocity[3], 1e-6);
        }
        let sums = prepared.sums(&noise(q), true);
        let two = sums.solve(&record, offset).unwrap();
        near(two.of(START_VELOCITY).unwrap().0, 0.29970943, 1e-7);
        near(two.of(START_POSITION).unwrap().0, 3.1751178e-5, 1e-6);
        near(two.offset().unwrap().0, 0.049881805, 1e-7);
        near(two.of(START_VELOCITY).unwrap().1, 8.5176e-4, 1e-4);
        near(two.of(START_POSITION).unwrap().1, 9.8484049e-5, 1e-6);
        near(two.offset().unwrap().1, 1.5522805e-3, 1e-6);
        let all = sums.solve(&record, all).unwrap();
        near(all.gain().unwrap().0, 1.1456802e-5, 1e-4);
        near(all.gain().unwrap().1, 2.2927024e-3, 1e-5);
        near(all.latency().unwrap().0, -1.0823359e-4, 1e-4);
        near(all.latency().unwrap().1, 1.006451e-3, 1e-5);
    }

    #[test]
    fn law_an_offset_of_any_size_leaves_the_likelihood_alone() {
        let record = vector();
        let mut upright = record.clone();
        upright.acceleration.iter_mut().for_each(|a| *a += 9.81);
        let unknowns = Unknowns {
            offset: true,
            ..Unknowns::default()
        };
        let value = |record: &MotionRecord| {
            let prepared = Prepared::new(record, &KalmanModel::new(1.0, 1.0));
            let sums = prepared.sums(&noise(4e-4), false);
            let solution = sums.solve(record, unknowns).unwrap();
            (sums.log_likelihood(&solution), solution.offset().unwrap().0)
        };
        let (a, b) = (value(&record), value(&upright));
        // Fourteen digits of squares of 10⁴ standard deviations.
        assert!((a.0 - b.0).abs() < 1e-5, "{} {}", a.0, b.0);
        assert!((b.1 - a.1 - 9.81).abs() < 1e-9);
    }
}

//! Three wheels and more of a vehicle: a wheel that departs from what the others allow slips.

use crate::findings;
use crate::slip::{episodes, held, largest, others, quiet, slope};
use crate::{Episode, ReadingSource};
use proofmass_core::{Error, Matrix3, check};
use proofmass_uncertainty::Finding;
use serde::{Deserialize, Serialize};

/// The wheels of a vehicle at equal steps of time.
///
/// Which of three or four stand on one side is found from the readings; more than four are left and right in turn, and of
/// an odd number the last one in the middle.
#[derive(Clone, Copy, Debug)]
pub struct Wheels<'a> {
    /// Sample time, s.
    pub sample_time: f64,
    /// Whether the wheels tell ways or speeds.
    pub source: ReadingSource,
    /// Readings of each, m or m/s; `None` where there is none.
    pub readings: &'a [Vec<Option<f64>>],
    /// Name of each.
    pub names: &'a [&'a str],
    /// Increment of a reading, where it is known; else the smallest step of the readings is taken for it.
    pub increment: Option<f64>,
}

/// Wheels that depart from the others, and when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Departure {
    /// The wheels, by their place among the readings: one, or where no single one explains it two of an axle.
    pub wheels: Vec<usize>,
    /// Stretch; `velocity` is how much faster the first of them became within one window than the others allow.
    pub episode: Episode,
}

/// Where wheels depart from the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Departures {
    /// In order of time.
    pub found: Vec<Departure>,
    /// Largest standard deviation of a wheel's quiet part over one window, m/s.
    pub quiet_deviation: f64,
    /// In words.
    pub findings: Vec<Finding>,
}

/// Window in which a speed is taken, s: a tyre takes some tenths of a second to spin up.
const WINDOW: f64 = 0.2;
/// Threshold in standard deviations of the quiet part.
const THRESHOLD: f64 = 8.0;
/// Speeds below which a wheel's sensor may read zero, m/s, at most.
const SENSORLESS: f64 = 1.0;
/// Share of the squares that one wheel may leave unexplained.
const UNEXPLAINED: f64 = 0.1;

/// Largest coefficients that a vehicle has: radius, track, and square of wheelbase over track of a steered axle, of which the
/// mean takes half. Without curves creep of the tyres would pass for larger ones.
const MOST: [f64; 3] = [1.0, 0.15, 6.0];

/// Mean speed and half the difference of the sides, at a window.
#[derive(Clone, Copy, Debug, Default)]
struct Body {
    ahead: f64,
    turning: f64,
}

impl Wheels<'_> {
    /// Compares every wheel with a rigid vehicle that goes ahead and turns, as all of them together show it.
    ///
    /// What a wheel has beyond that in proportion to the speed (its radius), to the turning (its track) and to the square
    /// of the turning over the speed (a steered axle) is found by regression with Huber's weights and taken off; the rest
    /// may not change from one window to the next by more than eight standard deviations of the quiet part, nor by less
    /// than rounding can do. Of the wheels that would explain a change alike (with four, two of one side do) that one is
    /// named which leaves the vehicle's own motion as it was before.
    ///
    /// **Assumes** wheels that do not slip most of the time; where all slip alike only the accelerometer tells.
    /// **Accuracy** healthy drives in curves, and wheels that spin or lock: tests of this file. **Source** `[Huber64]` for the weights.
    ///
    /// # Errors
    /// [`Error::Length`] for channels of unequal length or names; [`Error::TooFew`] below three wheels or eight windows;
    /// [`Error::OutOfRange`] for a sample time that is not positive; [`Error::NotFinite`].
    pub fn slip(&self) -> Result<Departures, Error> {
        let n = self.check()?;
        let dt = self.sample_time;
        let read = self.readings[0].iter().flatten().count().max(1);
        let w = ((WINDOW / dt).round() as usize)
            .max(5)
            .max(4 * n.div_ceil(read));
        if n < 8 * w {
            return Err(Error::TooFew {
                name: "samples",
                needed: 8 * w,
                got: n,
            });
        }
        let increment = self.increment.unwrap_or_else(|| {
            self.readings
                .iter()
                .map(|r| smallest_step(r))
                .fold(0.0, f64::max)
        });
        let span = w as f64 * dt;
        let speeds: Vec<Vec<f64>> = self
            .readings
            .iter()
            .map(|r| {
                let r = held(r);
                let windows = r.windows(w);
                match self.source {
                    ReadingSource::Position => windows.map(|x| slope(x, dt)).collect(),
                    ReadingSource::Speed => windows
                        .map(|x| x.iter().sum::<f64>() / w as f64)
                        .collect::<Vec<f64>>(),
                }
            })
            .collect();
        // At rest nothing is rounded and nothing slips; near it sensors read zero one after another.
        let slow = match self.source {
            ReadingSource::Position => 2.0 * increment / span,
            ReadingSource::Speed => {
                let first = self.readings.iter().map(|r| first_reading(r));
                (3.0 * first.fold(0.0, f64::max))
                    .min(SENSORLESS)
                    .max(2.0 * increment)
            }
        };
        let moves: Vec<bool> = (0..speeds[0].len())
            .map(|k| speeds.iter().any(|s| s[k].abs() > slow))
            .collect();
        let none = Departures {
            found: Vec::new(),
            quiet_deviation: 0.0,
            findings: Vec::new(),
        };
        if moves.iter().filter(|m| **m).count() < 8 * w {
            return Ok(none);
        }
        let candidates = sides(speeds.len());
        let models = candidates.iter().map(|y| Rigid::new(&speeds, y, &moves, w));
        let rigid = models.min_by(|a, b| a.typical.total_cmp(&b.typical));
        let Some(rigid) = rigid else { return Ok(none) };

        let changes: Vec<Change> = rigid
            .beyond
            .iter()
            .map(|b| Change::of(b, &moves, w))
            .collect();
        let rounding = match self.source {
            ReadingSource::Position => 6.0 * increment / span,
            ReadingSource::Speed => 2.0 * increment,
        };
        let last = speeds[0].len() - w;
        let strange: Vec<f64> = (0..last)
            .map(|k| {
                let sizes = changes.iter().map(|c| c.deviations(k, rounding));
                sizes.fold(0.0, f64::max)
            })
            .collect();
        let found: Vec<Departure> = episodes(&strange, |z| z > THRESHOLD, w, w, n, |z| (0.0, z))
            .into_iter()
            .map(|episode| {
                let inside = episode.from - w..episode.to - w;
                let top = inside
                    .max_by(|a, b| strange[*a].total_cmp(&strange[*b]))
                    .unwrap_or(episode.from - w);
                let (wheels, velocity) = rigid.to_blame(&changes, &moves, top, w);
                let episode = Episode {
                    velocity,
                    ..episode
                };
                Departure { wheels, episode }
            })
            .collect();
        Ok(Departures {
            findings: self.told(&found, dt, span),
            found,
            quiet_deviation: changes.iter().fold(0.0, |m, c| c.deviation.max(m)),
        })
    }

    fn told(&self, found: &[Departure], dt: f64, span: f64) -> Vec<Finding> {
        let all: Vec<Episode> = found.iter().map(|d| d.episode).collect();
        let told = largest(&all);
        let told = found.iter().filter(|d| told.contains(&d.episode));
        told.map(|Departure { wheels, episode: e }| {
            let names: Vec<&str> = wheels.iter().map(|i| self.names[*i]).collect();
            let faster = if e.velocity > 0.0 { "faster" } else { "slower" };
            findings::wheel_slip(
                &names.join(", "),
                e.from as f64 * dt,
                e.to as f64 * dt,
                e.velocity.abs(),
                faster,
                1e3 * span,
                e.deviations,
                &others(&all),
            )
        })
        .collect()
    }

    fn check(&self) -> Result<usize, Error> {
        let count = self.readings.len();
        if count < 3 {
            return Err(Error::TooFew {
                name: "wheels",
                needed: 3,
                got: count,
            });
        }
        if self.names.len() != count {
            return Err(Error::Length {
                name: "names of the wheels",
                expected: count,
                got: self.names.len(),
            });
        }
        let n = self.readings[0].len();
        for wheel in self.readings {
            if wheel.len() != n {
                return Err(Error::Length {
                    name: "wheel",
                    expected: n,
                    got: wheel.len(),
                });
            }
            let bad = |r: &Option<f64>| r.is_some_and(|r| !r.is_finite());
            if let Some(index) = wheel.iter().position(bad) {
                return Err(Error::NotFinite {
                    name: "wheel",
                    index,
                });
            }
        }
        check::positive("sample time", self.sample_time)?;
        Ok(n)
    }
}

/// Sides on which so many wheels may stand: −1, 1 and 0 for the middle.
fn sides(count: usize) -> Vec<Vec<f64>> {
    match count {
        3 => vec![
            vec![0.0, -1.0, 1.0],
            vec![-1.0, 0.0, 1.0],
            vec![-1.0, 1.0, 0.0],
        ],
        4 => vec![
            vec![-1.0, 1.0, -1.0, 1.0],
            vec![-1.0, -1.0, 1.0, 1.0],
            vec![-1.0, 1.0, 1.0, -1.0],
        ],
        _ => {
            let alternate = |i: usize| match i {
                i if i + 1 == count && count % 2 == 1 => 0.0,
                i if i % 2 == 0 => -1.0,
                _ => 1.0,
            };
            vec![(0..count).map(alternate).collect()]
        }
    }
}

/// The rigid vehicle that all wheels show together, and what each has beyond it.
struct Rigid {
    sides: Vec<f64>,
    body: Vec<Body>,
    /// Of each wheel, per window.
    beyond: Vec<Vec<f64>>,
    /// Sum of the medians of what is left.
    typical: f64,
}

impl Rigid {
    fn new(speeds: &[Vec<f64>], sides: &[f64], moves: &[bool], w: usize) -> Self {
        let all = vec![true; sides.len()];
        let body: Vec<Body> = (0..moves.len())
            .map(|k| fitted(sides, &all, |i| speeds[i][k]).unwrap_or_default())
            .collect();
        let columns: Vec<[f64; 3]> = body
            .iter()
            .map(|b| {
                let quotient = b.turning * b.turning / b.ahead;
                let steered = if quotient.is_finite() { quotient } else { 0.0 };
                [b.ahead, b.turning, steered]
            })
            .collect();
        // Windows that hardly overlap are enough for three coefficients.
        let used: Vec<usize> = (0..moves.len())
            .step_by((w / 4).max(1))
            .filter(|k| moves[*k])
            .collect();
        let used = determining(speeds, sides, &body, used);
        let mut typical = 0.0;
        let beyond = speeds
            .iter()
            .zip(sides)
            .map(|(speed, side)| {
                let raw = |k: usize| speed[k] - body[k].ahead - side * body[k].turning;
                let coefficients = robust(&used, &columns, raw);
                let rest = |k: usize| raw(k) - proofmass_core::dot(coefficients, columns[k]);
                let mut sizes: Vec<f64> = used.iter().map(|k| rest(*k).abs()).collect();
                sizes.sort_by(f64::total_cmp);
                typical += sizes[sizes.len() / 2];
                (0..moves.len()).map(rest).collect()
            })
            .collect();
        Self {
            sides: sides.to_vec(),
            body,
            beyond,
            typical,
        }
    }

    /// The wheels that explain the change from window `k` to window `k + w`, and the first one's part in it.
    fn to_blame(
        &self,
        changes: &[Change],
        moves: &[bool],
        k: usize,
        w: usize,
    ) -> (Vec<usize>, f64) {
        let count = self.sides.len();
        let (before, after) = (self.body[k], self.body[k + w]);
        let body = Body {
            ahead: after.ahead - before.ahead,
            turning: after.turning - before.turning,
        };
        let change: Vec<f64> = (0..count)
            .map(|i| body.ahead + self.sides[i] * body.turning + changes[i].size(k))
            .collect();
        // A vehicle goes on as it did before the change began.
        let trend = match k.checked_sub(2 * w).filter(|j| moves[*j] && moves[*j + w]) {
            Some(j) => Body {
                ahead: self.body[j + w].ahead - self.body[j].ahead,
                turning: self.body[j + w].turning - self.body[j].turning,
            },
            None => Body::default(),
        };
        let total: f64 = (0..count).map(|i| changes[i].size(k).powi(2)).sum();
        // Departure from the trend, squares that are left, wheels and the first one's part.
        let explain = |wheels: Vec<usize>| {
            let keep: Vec<bool> = (0..count).map(|i| !wheels.contains(&i)).collect();
            let own = fitted(&self.sides, &keep, |i| change[i])?;
            let off = |i: usize| change[i] - own.ahead - self.sides[i] * own.turning;
            let left: f64 = (0..count)
                .filter(|i| keep[*i])
                .map(|i| off(i) * off(i))
                .sum();
            let away = (own.ahead - trend.ahead).hypot(own.turning - trend.turning);
            let part = off(wheels[0]);
            Some((away, left, wheels, part))
        };
        let least = |list: Vec<(f64, f64, Vec<usize>, f64)>| {
            list.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let single: Vec<_> = (0..count)
            .filter_map(|i| explain(vec![i]))
            .filter(|e| e.1 <= UNEXPLAINED * total)
            .collect();
        let pairs = || {
            let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
            pairs
                .filter(|(i, j)| self.sides[*i] != self.sides[*j])
                .filter_map(|(i, j)| explain(vec![i, j]))
                .collect()
        };
        match least(single).or_else(|| least(pairs())) {
            Some((_, _, wheels, part)) => (wheels, part),
            None => (Vec::new(), 0.0),
        }
    }
}

/// The windows that tell the coefficients: without those that turn more than three times as fast as half of them do, while
/// a wheel departs from that turning by more than the turning itself.
///
/// In a curve both axles turn, whatever their tracks; where one wheel spins on a straight road half of what it has more is
/// left beside a turning of a quarter, and a coefficient of the turning would take it for the vehicle's.
fn determining(speeds: &[Vec<f64>], sides: &[f64], body: &[Body], used: Vec<usize>) -> Vec<usize> {
    let median = |mut x: Vec<f64>| {
        x.sort_by(f64::total_cmp);
        x.get(x.len() / 2).copied().unwrap_or(0.0)
    };
    let raw = |i: usize, k: usize| speeds[i][k] - body[k].ahead - sides[i] * body[k].turning;
    let radii: Vec<f64> = (0..sides.len())
        .map(|i| {
            let ahead = used.iter().filter(|k| body[**k].ahead != 0.0);
            median(ahead.map(|&k| raw(i, k) / body[k].ahead).collect())
        })
        .collect();
    let turns = |k: usize| body[k].turning.abs();
    let often = median(used.iter().map(|k| turns(*k)).collect());
    let contradicts = |k: usize| {
        let mut off = (0..sides.len()).map(|i| (raw(i, k) - radii[i] * body[k].ahead).abs());
        turns(k) > 3.0 * often && off.any(|off| off > turns(k))
    };
    let kept: Vec<usize> = used.iter().copied().filter(|k| !contradicts(*k)).collect();
    // Below half of them nothing is typical any more.
    if 2 * kept.len() < used.len() {
        used
    } else {
        kept
    }
}

/// Change of what a wheel has beyond the vehicle, from one window to the next.
struct Change {
    /// `None` where the vehicle hardly moves.
    values: Vec<Option<f64>>,
    centre: f64,
    deviation: f64,
}

impl Change {
    fn of(beyond: &[f64], moves: &[bool], w: usize) -> Self {
        let values: Vec<Option<f64>> = (0..beyond.len() - w)
            .map(|k| (moves[k] && moves[k + w]).then(|| beyond[k + w] - beyond[k]))
            .collect();
        let known: Vec<f64> = values.iter().flatten().copied().collect();
        let (centre, deviation) = match known.len() {
            0 => (0.0, f64::INFINITY),
            _ => quiet(&known),
        };
        Self {
            values,
            centre,
            deviation,
        }
    }

    fn size(&self, k: usize) -> f64 {
        self.values[k].map_or(0.0, |c| c - self.centre)
    }

    /// In standard deviations of the quiet part; zero for what rounding can do.
    fn deviations(&self, k: usize, rounding: f64) -> f64 {
        let size = self.size(k).abs();
        if size > rounding {
            size / self.deviation
        } else {
            0.0
        }
    }
}

/// Least squares of the body's two speeds through the wheels that are kept.
fn fitted(sides: &[f64], keep: &[bool], value: impl Fn(usize) -> f64) -> Option<Body> {
    let (mut n, mut y, mut yy, mut v, mut yv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (i, side) in sides.iter().enumerate().filter(|(i, _)| keep[*i]) {
        let value = value(i);
        n += 1.0;
        y += side;
        yy += side * side;
        v += value;
        yv += side * value;
    }
    let determinant = n * yy - y * y;
    (determinant > 1e-9).then(|| Body {
        ahead: (yy * v - y * yv) / determinant,
        turning: (n * yv - y * v) / determinant,
    })
}

/// Coefficients of three columns with Huber's weights; those that nothing determines are zero.
fn robust(used: &[usize], columns: &[[f64; 3]], value: impl Fn(usize) -> f64) -> [f64; 3] {
    let size = |c: usize| {
        let sum: f64 = used.iter().map(|k| columns[*k][c].powi(2)).sum();
        (sum / used.len() as f64).sqrt()
    };
    let sizes: [f64; 3] = std::array::from_fn(|c| match size(c) {
        s if s > 0.0 => s,
        _ => 1.0,
    });
    let mut coefficients = [0.0; 3];
    let mut weights = vec![1.0; used.len()];
    for _ in 0..10 {
        let mut normal = Matrix3([[0.0; 3]; 3]);
        let mut right = [0.0; 3];
        for (k, weight) in used.iter().zip(&weights) {
            let x: [f64; 3] = std::array::from_fn(|c| columns[*k][c] / sizes[c]);
            for i in 0..3 {
                right[i] += weight * x[i] * value(*k);
                for j in 0..3 {
                    normal.0[i][j] += weight * x[i] * x[j];
                }
            }
        }
        // A drive straight ahead does not tell the coefficients of turning: a millionth of the weights holds them.
        let total: f64 = weights.iter().sum();
        for i in 0..3 {
            normal.0[i][i] += 1e-6 * total;
        }
        let Ok(inverse) = normal.inverse() else { break };
        let scaled = inverse.times(right);
        coefficients = std::array::from_fn(|c| (scaled[c] / sizes[c]).clamp(-MOST[c], MOST[c]));
        let rest: Vec<f64> = used
            .iter()
            .map(|k| (value(*k) - proofmass_core::dot(coefficients, columns[*k])).abs())
            .collect();
        let mut sorted = rest.clone();
        sorted.sort_by(f64::total_cmp);
        // Median of |normal| is 0.6745 σ.
        let sigma = (sorted[sorted.len() / 2] / 0.6745).max(f64::MIN_POSITIVE);
        for (weight, rest) in weights.iter_mut().zip(&rest) {
            *weight = (1.345 * sigma / rest.max(f64::MIN_POSITIVE)).min(1.0);
        }
    }
    coefficients
}

/// Smallest change of a reading; zero where it never changes.
pub(crate) fn smallest_step(readings: &[Option<f64>]) -> f64 {
    let known: Vec<f64> = readings.iter().flatten().copied().collect();
    let steps = known.windows(2).map(|w| (w[1] - w[0]).abs());
    let least = steps.filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// Smallest speed a sensor reads that also reads zero; zero for one that never does.
fn first_reading(readings: &[Option<f64>]) -> f64 {
    let known = || readings.iter().flatten().map(|r| r.abs());
    if !known().any(|r| r == 0.0) {
        return 0.0;
    }
    let least = known().filter(|r| *r > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests;

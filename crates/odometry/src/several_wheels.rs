//! Three wheels and more of a vehicle: a wheel that departs from what the others allow slips.

use crate::findings;
use crate::rigid_vehicle::{Change, Rigid, sides};
use proofmass_core::{Error, check};
use proofmass_motion::ReadingSource;
use proofmass_motion::episode::{Episode, episodes, held, largest, others, slope};
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
#[non_exhaustive]
pub struct Departure {
    /// The wheels, by their place among the readings: one, or where no single one explains it two of an axle.
    pub wheels: Vec<usize>,
    /// Stretch; `velocity` is how much faster the first of them became within one window than the others allow.
    pub episode: Episode,
}

/// Where wheels depart from the others.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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

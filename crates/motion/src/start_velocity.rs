//! Velocity at the first sample, where every method starts: the one that is stated, or that of the first readings.

use crate::floor::variance;
use crate::{MotionRecord, ReadingSource};
use proofmass_core::Error;
use proofmass_core::check::within;
use proofmass_uncertainty::adjustment::ScaledRoot;

/// Readings of the shortest fit; each next one takes twice as many.
const FEWEST: usize = 16;
/// Readings of the longest fit.
const MOST: usize = 8192;
/// Standard uncertainties by which a fit may differ from the one to half as many readings: beyond them the polynomial does not hold.
const HOLDS: f64 = 4.0;

/// A velocity with its standard uncertainty.
type Stated = (f64, f64);

impl MotionRecord {
    /// Starts at this velocity, with its standard uncertainty; zero for one that is exact.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for an uncertainty below zero.
    pub fn start_at(&mut self, velocity: f64, uncertainty: f64) -> Result<(), Error> {
        proofmass_core::check::finite("initial velocity", &[velocity])?;
        within(
            "uncertainty of the initial velocity",
            uncertainty,
            0.0,
            f64::MAX,
        )?;
        self.initial_velocity = Some(velocity);
        self.initial_velocity_uncertainty = uncertainty;
        Ok(())
    }

    /// Velocity at the first sample and its standard uncertainty: the one that is stated, or that of the first readings.
    ///
    /// Readings less the integral of the accelerometer are a polynomial of the start and of its offset: v₀ + b t of a speed,
    /// x₀ + v₀ t + ½ b t² of a position (without an accelerometer b is the acceleration of the axis). It is fitted by least squares to the
    /// first 16, 32, 64, … readings, as long as it holds; what a fit differs from the one to half as many adds to its uncertainty, and the fit
    /// with the least is used.
    ///
    /// **Assumes** white noise of both sensors; rounding counts as δ²/12 at least, and once while a count stays. The noise of an acceleration is taken from the differences
    /// of neighbours, which motion makes larger.
    /// **Accuracy** `coverage_start_of_moving_axes`.
    pub fn start_velocity(&self) -> Stated {
        match self.initial_velocity {
            Some(v) => (v, self.initial_velocity_uncertainty),
            None => self.start_of_readings(),
        }
    }

    pub(crate) fn start_of_readings(&self) -> Stated {
        let departures = self.departures();
        let total = departures.len();
        let mut sizes: Vec<usize> = std::iter::successors(Some(FEWEST), |n| Some(2 * n))
            .take_while(|n| *n < total.min(MOST))
            .collect();
        sizes.push(total.min(MOST));
        let mut best: Option<Stated> = None;
        let mut shorter: Option<Stated> = None;
        for n in sizes {
            let Some((v, own)) = self.fitted(&departures[..n]) else {
                continue;
            };
            let (moved, held, before) = shorter.map_or((0.0, true, own), |(other, u)| {
                let moved = v - other;
                (moved, moved.abs() <= HOLDS * u.max(own), u)
            });
            if !held {
                break;
            }
            shorter = Some((v, own));
            // Bending that the polynomial does not follow shows as a difference to the shorter fit first.
            // Without an accelerometer the axis bends as it likes: the shorter fit says how far that is known.
            let known = match self.accelerometer {
                true => own,
                false => own.max(before),
            };
            let u = known.hypot(moved);
            if best.is_none_or(|(_, least)| u < least) {
                best = Some((v, u));
            }
        }
        best.unwrap_or((0.0, 0.0))
    }

    /// Time, reading less what the accelerometer shows of the motion since the first sample, and the reading itself.
    fn departures(&self) -> Vec<(f64, f64, f64)> {
        let t = self.sample_time;
        let first = self.reading.iter().flatten().next().copied();
        let zero = match self.source {
            ReadingSource::Position => first.unwrap_or(0.0),
            ReadingSource::Speed => 0.0,
        };
        let (mut v, mut x, mut before) = (0.0, 0.0, None::<f64>);
        let mut list = Vec::new();
        for (k, (reading, &a)) in self.reading.iter().zip(&self.acceleration).enumerate() {
            if self.gapes(k, 0) && list.len() > 1 {
                break;
            }
            if let Some(b) = before {
                x += t * v + t * t * (b / 3.0 + a / 6.0);
                v += 0.5 * t * (b + a);
            }
            before = Some(a);
            if let Some(r) = reading {
                let moved = match self.source {
                    ReadingSource::Position => x,
                    ReadingSource::Speed => v,
                };
                list.push((t * k as f64, r - zero - moved, *r));
                if list.len() == MOST {
                    break;
                }
            }
        }
        list
    }

    /// The velocity of a polynomial through the departures, at the first sample.
    fn fitted(&self, departures: &[(f64, f64, f64)]) -> Option<Stated> {
        let n = departures.len();
        let span = departures.last()?.0.max(self.sample_time);
        let wanted = match self.source {
            ReadingSource::Position => 1,
            ReadingSource::Speed => 0,
        };
        // As many unknowns as leave a reading over, and never without the velocity.
        let unknowns = (wanted + 2).min((n - 1).max(wanted + 1));
        let row = |time: f64| {
            let s = time / span;
            [1.0, s, s * s]
        };
        let mut g = [[0.0; 3]; 3];
        let mut right = [0.0; 3];
        for &(time, departure, _) in departures {
            let row = row(time);
            for i in 0..unknowns {
                right[i] += row[i] * departure;
                for j in 0..unknowns {
                    g[i][j] += row[i] * row[j];
                }
            }
        }
        let root = ScaledRoot::new(unknowns, |i, j| g[i][j])?;
        let solved = |right: &[f64]| {
            let mut x: Vec<f64> = right.iter().zip(&root.scale).map(|(r, s)| r * s).collect();
            root.forward(&mut x);
            root.backward(&mut x);
            x.iter()
                .zip(&root.scale)
                .map(|(x, s)| x * s)
                .collect::<Vec<f64>>()
        };
        let found = solved(&right[..unknowns]);
        let unit: Vec<f64> = (0..unknowns)
            .map(|i| f64::from(u8::from(i == wanted)))
            .collect();
        let cofactor = solved(&unit)[wanted];
        let left: f64 = departures
            .iter()
            .map(|(time, departure, _)| {
                let fit: f64 = row(*time).iter().zip(&found).map(|(r, c)| r * c).sum();
                (departure - fit) * (departure - fit)
            })
            .sum();
        let mut noise = left / (n - unknowns).max(1) as f64;
        if let Some(increment) = self.increment {
            // While a count stays the same its rounding is no new one.
            let new = 1 + departures.windows(2).filter(|w| w[0].2 != w[1].2).count();
            noise = noise.max(increment * increment / 12.0) * n as f64 / new as f64;
        }
        // A velocity is the coefficient over the span where the readings are positions.
        let scale = if wanted == 1 { 1.0 / span } else { 1.0 };
        let walked = WALK * self.sample_time * span * self.sample_noise();
        let value = found[wanted] * scale;
        let variance = noise * cofactor * scale * scale + walked;
        value.is_finite().then_some((value, variance.sqrt()))
    }

    /// Variance of an acceleration sample by the differences of the first ones.
    fn sample_noise(&self) -> f64 {
        let end = self.acceleration.len().min(MOST);
        let steps: Vec<f64> = self.acceleration[..end]
            .windows(2)
            .map(|w| w[1] - w[0])
            .collect();
        0.5 * variance(&steps)
    }
}

/// Variance of the start over that of the integral of white noise at the end of a fit: 2/15 for the intercept of a straight line.
const WALK: f64 = 2.0 / 15.0;

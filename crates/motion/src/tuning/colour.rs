//! Noise of the readings that is correlated in time.

use super::{Point, Search, highest};
use crate::diffuse::{Noise, Unknowns};
use crate::{ReadingNoise, ReadingSource};
use proofmass_core::Error;

/// Maxima of ln L that differ by less are as likely.
const ALIKE: f64 = 6.0;

impl Search<'_> {
    /// The best coloured noise of the readings. The white part is the rounding, or what was found without colour.
    pub(super) fn coloured(&mut self, base: &Point) -> Result<Option<Point>, Error> {
        let r = self.known.or(self.rounding).unwrap_or(0.01 * base.noise.r);
        let before = self.known.replace(r);
        let found = self.coloured_beside(base, r);
        self.known = before;
        Ok(found?.filter(|p| {
            p.noise
                .colour
                .is_some_and(|(variance, _)| variance > self.least_colour(r))
        }))
    }

    /// Less is the increment's own sawtooth; that of a speed is a noise like others.
    fn least_colour(&self, r: f64) -> f64 {
        match self.record.source {
            ReadingSource::Position => 10.0 * r,
            ReadingSource::Speed => r,
        }
    }

    /// The best coloured noise of the readings beside a walk of the accelerometer's offset, as a vehicle has them: its tyres
    /// and filters colour the speed, slope and pitch walk in the acceleration. The white part of a reading is found with
    /// them, at least its rounding.
    pub(super) fn joint(
        &mut self,
        base: &Point,
        coloured: Option<&Point>,
    ) -> Result<Option<Point>, Error> {
        if !(self.record.accelerometer && self.ceiling.is_finite()) {
            return Ok(None);
        }
        let dt = self.record.sample_time;
        let duration = dt * self.record.reading.len() as f64;
        let least = self.rounding.unwrap_or(self.least);
        let subsets = self.subsets(Unknowns {
            offset: true,
            gain: base.unknowns.gain || coloured.is_some_and(|p| p.unknowns.gain),
            latency: base.unknowns.latency,
        });
        let subsets: Vec<Unknowns> = subsets.into_iter().filter(|u| u.offset).collect();
        let q = self.floor.unwrap_or(base.noise.q);
        let (short, long) = (3.0 * self.lasting(), (0.1 * duration).min(3.0));
        if long <= short {
            return Ok(None);
        }
        let level = base.noise.r.max(4.0 * least);
        let mut places: Vec<([f64; 5], f64)> = Vec::new();
        for i in 0..4 {
            let time = short * (long / short).powf(f64::from(i) / 3.0);
            let mut own: Option<([f64; 5], f64)> = None;
            for decade in -1..=2 {
                // An offset that walks by the size of the motion, by a tenth of it, or by a hundredth.
                for share in [1.0, 1e-2, 1e-4] {
                    let variance = level * 10f64.powi(decade);
                    let walk = share * self.ceiling / duration;
                    let x = [q, variance, time, walk, (0.1 * level).max(least)].map(f64::log10);
                    let point = self.joint_at(&x, &subsets, least)?;
                    let value = point.map_or(-1e300, |p| p.value);
                    if own.is_none_or(|(_, v)| value > v) {
                        own = Some((x, value));
                    }
                }
            }
            places.extend(own);
        }
        places.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut found: Vec<Point> = coloured.cloned().into_iter().collect();
        for (start, _) in places {
            found.extend(highest([start], (0.5, 400), |x| {
                self.joint_at(x, &subsets, least)
            })?);
        }
        let likely = |p: &Point| p.log_likelihood + self.prior(p.noise.q);
        found.sort_by(|a, b| likely(b).total_cmp(&likely(a)));
        let Some(mut best) = found.first().cloned() else {
            return Ok(None);
        };
        // Noise of the readings that lasts is hard to tell from a faster accelerometer: maxima that are as likely count too.
        let lasting = |n: &Noise| n.colour.map_or(0.0, |(variance, time)| variance * time);
        for other in &found[1..] {
            let alike = |n: &Noise| (lasting(n) / lasting(&other.noise)).log10().abs() < 0.2;
            let near = std::iter::once(&best.noise).chain(&best.alike).any(alike);
            if likely(other) > likely(&best) - ALIKE && !near {
                best.alike.push(other.noise);
            }
        }
        // Noise that lasts and an offset that walks are the rule beside a speed: it is their absence that has to be shown.
        Ok(Some(best).filter(|p| likely(p) > likely(base) - ALIKE))
    }

    /// Least correlation time beside a walk: five readings. What is shorter is white.
    fn lasting(&self) -> f64 {
        5.0 * self.record.sample_time * self.record.reading.len() as f64 / self.readings
    }

    /// log₁₀ of q, of the coloured variance and its time, of the walk and of the white part.
    fn joint_at(
        &mut self,
        x: &[f64; 5],
        subsets: &[Unknowns],
        least: f64,
    ) -> Result<Option<Point>, Error> {
        let dt = self.record.sample_time;
        let longest = 0.2 * dt * self.record.reading.len() as f64;
        let [q, variance, time, walk, r] = x.map(|x| 10f64.powf(x));
        let before = self.known;
        // The rounding alone is a bound here, not a value.
        let r = match self.tuning.reading_noise {
            ReadingNoise::Known { variance } => variance,
            ReadingNoise::Free => r,
        };
        if !(self.lasting()..longest).contains(&time) || r < 0.999 * least {
            return Ok(None);
        }
        self.known = Some(r);
        let noise = Noise {
            walk: Some(walk),
            colour: Some((variance, time)),
            ..self.white(q, r)
        };
        let point = self.best(&noise, subsets);
        self.known = before;
        point
    }

    pub(super) fn coloured_beside(&mut self, base: &Point, r: f64) -> Result<Option<Point>, Error> {
        let dt = self.record.sample_time;
        let duration = dt * self.record.reading.len() as f64;
        let (short, long) = (3.0 * dt, 0.1 * duration);
        if long <= short {
            return Ok(None);
        }
        let q = self.floor.unwrap_or(base.noise.q).log10();
        let unknowns = base.unknowns;
        // Best start of every correlation time.
        let mut starts: Vec<([f64; 3], f64)> = Vec::new();
        for i in 0..5 {
            let time = short.log10() + (long / short).log10() * f64::from(i) / 4.0;
            let mut own: Option<([f64; 3], f64)> = None;
            for decade in 0..7 {
                let x = [q, 0.5 + f64::from(decade) + r.log10(), time];
                let point = self.coloured_at(&x, r, unknowns)?;
                let value = point.map_or(-1e300, |p| p.value);
                if own.is_none_or(|(_, v)| value > v) {
                    own = Some((x, value));
                }
            }
            starts.extend(own);
        }
        starts.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut list: Vec<[f64; 3]> = starts.iter().take(2).map(|(x, _)| *x).collect();
        if let Some(first) = list.first() {
            // From one start alone two of six long records ended far below the maximum.
            list.push([first[0] - 1.0, first[1], first[2]]);
        }
        highest(list, (0.7, 150), |x| self.coloured_at(x, r, unknowns))
    }

    /// log₁₀ of q, of the variance and of the correlation time.
    pub(super) fn coloured_at(
        &mut self,
        x: &[f64; 3],
        r: f64,
        unknowns: Unknowns,
    ) -> Result<Option<Point>, Error> {
        let dt = self.record.sample_time;
        let longest = dt * self.record.reading.len() as f64;
        let time = 10f64.powf(x[2]);
        if !(0.1 * dt..longest).contains(&time) {
            return Ok(None);
        }
        let noise = Noise {
            colour: Some((10f64.powf(x[1]), time)),
            ..self.white(10f64.powf(x[0]), r)
        };
        self.best(&noise, &[unknowns])
    }
}

//! Noise of the readings that is correlated in time.

use super::{Point, Search};
use crate::diffuse::{Noise, Unknowns};
use crate::search::simplex;
use proofmass_core::Error;

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
                .is_some_and(|(variance, _)| variance > 10.0 * r)
        }))
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
        let mut best: Option<Point> = None;
        for start in list {
            simplex(start, 0.7, 150, |x| {
                let point = self.coloured_at(x, r, unknowns)?;
                let value = point.as_ref().map_or(-1e300, |p| p.value);
                if let Some(point) = point
                    && best.as_ref().is_none_or(|b| point.value > b.value)
                {
                    best = Some(point);
                }
                Ok(value)
            })?;
        }
        Ok(best)
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

//! Random walk of the accelerometer's offset.

use super::{Point, Search, highest};
use crate::diffuse::{Noise, Unknowns};
use proofmass_core::Error;

impl Search<'_> {
    /// The best random walk of the offset, from places over the whole plane.
    pub(super) fn walk(&mut self, base: &Point) -> Result<Option<Point>, Error> {
        let unknowns = Unknowns {
            offset: true,
            ..base.unknowns
        };
        let found = base.noise.q.log10();
        let floor = self.floor.map_or(found - 3.0, f64::log10);
        let mut start: Option<([f64; 2], f64)> = None;
        let (ratios, places) = match self.record.accelerometer {
            true => (
                [-8.0, -6.0, -4.0, -2.0, 0.0],
                [found, found - 1.0, found - 2.0, floor],
            ),
            // Nothing but the walk moves a smooth axis.
            false => (
                [-2.0, 0.0, 2.0, 4.0, 6.0],
                [found, found - 2.0, found - 4.0, found - 6.0],
            ),
        };
        for ratio in ratios {
            for q in places {
                let x = [q, ratio];
                let value = self
                    .walk_at(&x, base, unknowns)?
                    .map_or(-1e300, |p| p.value);
                if start.is_none_or(|(_, v)| value > v) {
                    start = Some((x, value));
                }
            }
        }
        let Some((start, _)) = start else {
            return Ok(None);
        };
        highest([start], (0.7, 150), |x| self.walk_at(x, base, unknowns))
    }

    /// log₁₀ q (where R is free: in units of the R that was found) and log₁₀ s/q.
    pub(super) fn walk_at(
        &mut self,
        x: &[f64; 2],
        base: &Point,
        unknowns: Unknowns,
    ) -> Result<Option<Point>, Error> {
        let q = 10f64.powf(x[0]);
        let noise = Noise {
            walk: Some(q * 10f64.powf(x[1])),
            ..self.white(q, base.noise.r)
        };
        self.best(&noise, &[unknowns])
    }
}

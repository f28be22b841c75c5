//! How far from the maximum noise is still likely: profile, interval, curvature.

use super::{Point, Search};
use crate::diffuse::Noise;
use proofmass_core::Error;

/// Half the 95 % point of χ²(1).
const FALL: f64 = 1.92;
pub(super) const LN10: f64 = std::f64::consts::LN_10;

impl Search<'_> {
    /// Value at noise whose parameters are moved by decades.
    pub(super) fn moved(&mut self, point: &Point, by: &[f64]) -> Result<f64, Error> {
        let noise = shifted(&point.noise, by);
        Ok(self
            .best(&noise, &[point.unknowns])?
            .map_or(-1e300, |p| p.value))
    }

    /// ln L + ln prior below its maximum over two decades of q either way, the other parameters held.
    pub(super) fn profile(&mut self, point: &Point) -> Result<Vec<(f64, f64)>, Error> {
        let mut list = Vec::new();
        for k in -16..=16 {
            let by = 0.125 * f64::from(k);
            let noise = shifted(&point.noise, &[by]);
            if let Some(p) = self.best(&noise, &[point.unknowns])? {
                list.push((p.noise.q, p.value - point.value));
            }
        }
        Ok(list)
    }

    /// Where ln L + ln prior has fallen by half the 95 % point of χ²(1).
    pub(super) fn interval(&mut self, point: &Point) -> Result<Option<(f64, f64)>, Error> {
        let fall = FALL * self.excess();
        let mut half = [0.0; 2];
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let (mut inside, mut outside) = (0.0, 0.02);
            while point.value - self.moved(point, &[sign * outside])? < fall {
                inside = outside;
                outside *= 2.0;
                if outside > 4.0 {
                    return Ok(None);
                }
            }
            for _ in 0..8 {
                let middle = 0.5 * (inside + outside);
                if point.value - self.moved(point, &[sign * middle])? < fall {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            half[side] = outside * LN10;
        }
        Ok(Some((half[0], half[1])))
    }

    /// Columns of a square root of the covariance of the log₁₀ parameters, from second differences over a tenth of a
    /// decade. No direction is taken as wider than half a decade. `None` where the maximum is none.
    pub(super) fn curvature(
        &mut self,
        point: &Point,
        d: usize,
    ) -> Result<Option<Vec<Vec<f64>>>, Error> {
        const STEP: f64 = 0.1;
        let unit = |i: usize, s: f64| {
            let mut x = vec![0.0; d];
            x[i] = s * STEP;
            x
        };
        let centre = self.moved(point, &vec![0.0; d])?;
        let mut h = vec![vec![0.0; d]; d];
        for i in 0..d {
            let up = self.moved(point, &unit(i, 1.0))?;
            let down = self.moved(point, &unit(i, -1.0))?;
            h[i][i] = -(up - 2.0 * centre + down) / (STEP * STEP);
            for j in 0..i {
                let mut corner = |a: f64, b: f64| {
                    let mut x = unit(i, a);
                    x[j] = b * STEP;
                    self.moved(point, &x)
                };
                let mixed = corner(1.0, 1.0)? - corner(1.0, -1.0)? - corner(-1.0, 1.0)?
                    + corner(-1.0, -1.0)?;
                h[i][j] = -mixed / (4.0 * STEP * STEP);
                h[j][i] = h[i][j];
            }
        }
        if h.iter()
            .flatten()
            .any(|x| !x.is_finite() || x.abs() > 1e200)
        {
            return Ok(None);
        }
        // What repeats tells the same again.
        let excess = self.excess();
        let (values, vectors) = jacobi(h);
        Ok(Some(
            (0..d)
                .map(|k| {
                    // Half a decade at most: 1/h ≤ ¼, also where the difference found no maximum.
                    let root = (1.0 / (values[k] / excess).max(4.0)).sqrt();
                    (0..d).map(|i| vectors[i][k] * root).collect()
                })
                .collect(),
        ))
    }
}

/// Number of parameters of the noise beside a common scale.
pub(super) fn parameters(noise: &Noise) -> usize {
    1 + usize::from(noise.walk.is_some()) + 2 * usize::from(noise.colour.is_some())
}

/// Noise with q, then the walk, then the coloured variance and time, as far as there are such, moved by decades.
pub(super) fn shifted(noise: &Noise, by: &[f64]) -> Noise {
    let factor = |i: usize| 10f64.powf(by.get(i).copied().unwrap_or(0.0));
    let colour = 1 + usize::from(noise.walk.is_some());
    Noise {
        q: noise.q * factor(0),
        // The walk keeps its place when q moves.
        walk: noise.walk.map(|s| s * factor(1)),
        colour: noise
            .colour
            .map(|(v, t)| (v * factor(colour), t * factor(colour + 1))),
        ..*noise
    }
}

/// Eigenvalues and vectors (in columns) of a small symmetric matrix by Jacobi's rotations.
fn jacobi(mut a: Vec<Vec<f64>>) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = a.len();
    let mut v: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
        .collect();
    for _ in 0..50 {
        let off: f64 = (0..n)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| a[i][j].abs())
            .sum();
        if off < 1e-300 {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                if a[p][q] == 0.0 {
                    continue;
                }
                let theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let t = if theta == 0.0 { 1.0 } else { t };
                let c = 1.0 / t.hypot(1.0);
                let s = t * c;
                for k in 0..n {
                    let (x, y) = (a[k][p], a[k][q]);
                    (a[k][p], a[k][q]) = (c * x - s * y, s * x + c * y);
                }
                for k in 0..n {
                    let (x, y) = (a[p][k], a[q][k]);
                    (a[p][k], a[q][k]) = (c * x - s * y, s * x + c * y);
                }
                for row in &mut v {
                    let (x, y) = (row[p], row[q]);
                    (row[p], row[q]) = (c * x - s * y, s * x + c * y);
                }
            }
        }
    }
    ((0..n).map(|i| a[i][i]).collect(), v)
}

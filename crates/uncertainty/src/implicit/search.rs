//! The search for a solution from a start that somebody wrote.

use super::{Root, Scaled, ValuesAndSlopes, scaled, sensitivities, slopes};
use crate::Implicit;
use proofmass_core::Error;

/// Steps, and the shortest part of one.
const STEPS: usize = 200;
const SHORTEST: f64 = 1e-9;

/// Why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Lost {
    /// At the start the equations do not tell where to go.
    Stationary,
    /// The search ends before it finds one.
    Ended,
}

/// A solution with the sizes that a change of its unknowns is measured by: |y| and what the inputs make of it, Σ |x ∂y/∂x|,
/// where y itself is near zero.
pub(crate) struct Found {
    pub(crate) y: Vec<f64>,
    pub(crate) scale: Vec<f64>,
}

impl Root {
    /// Newton's iteration from a start, with steps as short as it takes to stay on the side of the start: each makes the rest
    /// of the way shorter, and none crosses a fold, where det ∂h/∂y changes its sign. A step from near a fold, which would
    /// land anywhere, is cut to what the equations say nearby.
    ///
    /// **Source** `[Deuflhard2004] 3.3`.
    pub(crate) fn search<M: Implicit>(model: &M, start: &[f64], x: &[f64]) -> Result<Found, Lost> {
        let m = start.len();
        let at = slopes(model, m, x);
        let finite = |(h, s): &ValuesAndSlopes| h.iter().chain(s).all(|v| v.is_finite());
        let at = |y: &[f64]| at(y).ok().filter(finite);
        let (h, slope) = at(start).ok_or(Lost::Ended)?;
        let mut slope = scaled(&slope, m);
        let sign = slope.sign;
        let mut y = start.to_vec();
        let mut step = slope.solve(&h).map_err(|_| Lost::Stationary)?;
        // Largest unknowns met.
        let mut met: Vec<f64> = y.iter().map(|y| y.abs()).collect();
        for _ in 0..STEPS {
            let weight: Vec<f64> = (0..m).map(|k| y[k].abs().max(step[k].abs())).collect();
            let whole = size(&step, &weight);
            // The point after a part of the step, where the rest of the way is shorter from there.
            let after = |part: f64| {
                let next: Vec<f64> = (0..m).map(|k| y[k] - part * step[k]).collect();
                let (value, s) = at(&next)?;
                let s = scaled(&s, m);
                let rest = slope.solve(&value).ok()?;
                let near = size(&rest, &weight) <= (1.0 - 0.25 * part) * whole;
                (s.sign == sign && near).then_some((next, value, s))
            };
            let mut next = if whole > 1e-15 { after(1.0) } else { None };
            // Quadratic convergence ends in rounding noise, which no longer shrinks.
            if next.is_none() && (whole <= 1e-15 || size(&step, &met) < 1e-8) {
                let scale = own_scale(model, &y, x, &slope).map_err(|_| Lost::Ended)?;
                let small = |k: usize| step[k].abs() <= 1e-8 * scale[k] || scale[k] == 0.0;
                if (0..m).all(small) {
                    return Ok(Found { y, scale });
                }
            }
            let mut part = 1.0;
            while next.is_none() {
                part *= 0.5;
                if part < SHORTEST {
                    return Err(Lost::Ended);
                }
                next = after(part);
            }
            let Some((at_next, value, slope_there)) = next else {
                return Err(Lost::Ended);
            };
            (y, slope) = (at_next, slope_there);
            step = slope.solve(&value).map_err(|_| Lost::Ended)?;
            for (met, y) in met.iter_mut().zip(&y) {
                *met = met.max(y.abs());
            }
        }
        Err(Lost::Ended)
    }
}

/// The largest part of a step in units of these weights.
fn size(step: &[f64], weight: &[f64]) -> f64 {
    let parts = step.iter().zip(weight).filter(|(d, _)| **d != 0.0);
    parts.map(|(d, w)| d.abs() / w).fold(0.0, f64::max)
}

/// |y| and Σ |x ∂y/∂x| for each unknown, whichever is larger.
fn own_scale<M: Implicit>(
    model: &M,
    y: &[f64],
    x: &[f64],
    slope: &Scaled,
) -> Result<Vec<f64>, Error> {
    let jacobian = sensitivities(model, y, x, slope)?;
    let rows = (0..y.len()).map(|k| &jacobian[k * x.len()..(k + 1) * x.len()]);
    let sums = rows.map(|row| row.iter().zip(x).map(|(d, x)| (d * x).abs()).sum::<f64>());
    Ok(sums.zip(y).map(|(s, y)| s.max(y.abs())).collect())
}

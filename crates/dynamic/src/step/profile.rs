//! How far a parameter of a fitted step may go: intervals where the squares are no parabola.

use super::fit::{P, cost, settled};
use proofmass_core::Error;
use proofmass_uncertainty::adjustment::Equations;

/// Rounds in which the place is looked for where the squares have grown by what is asked.
const ROUNDS: usize = 8;
/// Weight by which a parameter is held, in heights: its step is a millionth of what the samples would have it.
const HELD: f64 = 1e6;

/// Distances from the minimum, downwards and upwards, at which the squares have grown by `growth` with all other parameters fitted anew;
/// infinite where they do not grow so far.
///
/// For a linear model both are the same, √growth times the standard uncertainty for unit variance.
///
/// **Source** `[BatesWatts1988] 6.1`.
pub(super) fn reach(
    minimum: &[f64],
    least: f64,
    parameter: usize,
    growth: f64,
    first: f64,
    equations: impl Fn(&[f64]) -> Result<Equations, Error>,
) -> [f64; 2] {
    [-1.0, 1.0].map(|side| {
        let mut start = minimum.to_vec();
        // Between a distance at which they have not grown so far and one at which they have.
        let (mut inside, mut outside) = ((0.0, 0.0), None::<(f64, f64)>);
        let mut distance = first;
        for _ in 0..ROUNDS {
            let place = minimum[parameter] + side * distance;
            let held = |p: &[f64]| {
                let mut e = equations(p)?;
                e.residual.push(HELD * (p[parameter] - place));
                let mut row = [0.0; P];
                row[parameter] = HELD;
                e.jacobian.extend(row);
                Ok(e)
            };
            start[parameter] = place;
            let grown = settled(&start, 40, held).map(|(p, e, _)| (cost(&e) - least, p));
            match grown {
                Some((grown, p)) if grown < growth => {
                    inside = (distance, grown.max(0.0));
                    start = p;
                }
                Some((grown, _)) => outside = Some((distance, grown)),
                // Where no fit may go, none can be told from the minimum.
                None => outside = Some((distance, f64::INFINITY)),
            }
            // The root of the growth is near a straight line.
            let root = growth.sqrt();
            distance = match outside {
                None if inside.1 > 0.0 => {
                    distance * (root / inside.1.sqrt()).clamp(1.02, 4.0) * 1.02
                }
                None => 4.0 * distance,
                Some((far, grown)) if grown.is_finite() => {
                    let (a, b) = (inside.1.sqrt(), grown.sqrt());
                    let share = ((root - a) / (b - a)).clamp(0.05, 0.95);
                    inside.0 + share * (far - inside.0)
                }
                Some((far, _)) => 0.5 * (inside.0 + far),
            };
            if let Some((far, grown)) = outside
                && grown.is_finite()
                && far - inside.0 < 0.02 * far
            {
                break;
            }
        }
        match outside {
            Some((far, grown)) if grown.is_finite() => far,
            _ => f64::INFINITY,
        }
    })
}

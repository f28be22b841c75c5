//! Maxima of functions that cost a pass over a record each.

use proofmass_core::Error;

/// A place and the value there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Maximum<X> {
    pub(crate) at: X,
    pub(crate) value: f64,
}

/// Grid between two ends in steps of at most `step`, then Brent's parabolas and golden sections one step around the
/// best point, to `tolerance`.
///
/// **Source** `[Brent73]` ch. 5.
pub(crate) fn line(
    low: f64,
    high: f64,
    step: f64,
    tolerance: f64,
    mut value: impl FnMut(f64) -> Result<f64, Error>,
) -> Result<Maximum<f64>, Error> {
    let n = ((high - low) / step).ceil().max(1.0) as usize;
    let mut best = Maximum {
        at: low,
        value: f64::NEG_INFINITY,
    };
    for k in 0..=n {
        let at = low + (high - low) * k as f64 / n as f64;
        let found = value(at)?;
        if found > best.value {
            best = Maximum { at, value: found };
        }
    }
    let golden = 0.5 * (3.0 - 5f64.sqrt());
    let (mut a, mut b) = ((best.at - step).max(low), (best.at + step).min(high));
    // x: the best so far, w the second, v the one before w.
    let (mut x, mut w, mut v) = (best, best, best);
    let (mut last, mut before) = (0.0f64, 0.0f64);
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if (x.at - middle).abs() + 0.5 * (b - a) <= 2.0 * tolerance {
            break;
        }
        let mut parabola = None;
        if before.abs() > tolerance {
            let r = (x.at - w.at) * (x.value - v.value);
            let q = (x.at - v.at) * (x.value - w.value);
            let p = (x.at - v.at) * q - (x.at - w.at) * r;
            let q = 2.0 * (q - r);
            let d = -p / q;
            let inside = x.at + d > a && x.at + d < b;
            if d.is_finite() && inside && d.abs() < 0.5 * before.abs() {
                parabola = Some(d);
            }
        }
        let d = match parabola {
            Some(d) => {
                before = last;
                d
            }
            None => {
                let side = if x.at < middle { b - x.at } else { a - x.at };
                before = side;
                golden * side
            }
        };
        last = d;
        let d = if d.abs() < tolerance {
            tolerance.copysign(if d == 0.0 { middle - x.at } else { d })
        } else {
            d
        };
        let at = (x.at + d).clamp(low, high);
        let new = Maximum {
            at,
            value: value(at)?,
        };
        if new.value >= x.value {
            if at >= x.at {
                a = x.at;
            } else {
                b = x.at;
            }
            (v, w, x) = (w, x, new);
        } else {
            if at < x.at {
                a = at;
            } else {
                b = at;
            }
            if new.value >= w.value || w.at == x.at {
                (v, w) = (w, new);
            } else if new.value >= v.value || v.at == x.at || v.at == w.at {
                v = new;
            }
        }
    }
    Ok(x)
}

/// Nelder and Mead's simplex, from corners `step` away along each axis.
///
/// Ends after `passes` values, or when the corners differ by less than 0.005 in every coordinate.
///
/// **Source** `[NelderMead65]`.
pub(crate) fn simplex<const D: usize>(
    start: [f64; D],
    step: f64,
    passes: usize,
    mut value: impl FnMut(&[f64; D]) -> Result<f64, Error>,
) -> Result<Maximum<[f64; D]>, Error> {
    let mut used = 0;
    let mut at = |x: [f64; D]| -> Result<Maximum<[f64; D]>, Error> {
        used += 1;
        Ok(Maximum {
            at: x,
            value: value(&x)?,
        })
    };
    let mut corners = vec![at(start)?];
    for i in 0..D {
        let mut x = start;
        x[i] += step;
        corners.push(at(x)?);
    }
    let mut count = D + 1;
    while count < passes {
        corners.sort_by(|a, b| b.value.total_cmp(&a.value));
        let spread = (0..D).fold(0.0f64, |m, i| {
            corners
                .iter()
                .fold(m, |m, c| m.max((c.at[i] - corners[0].at[i]).abs()))
        });
        if spread < 0.005 {
            break;
        }
        let worst = corners[D];
        let centre: [f64; D] =
            std::array::from_fn(|i| corners[..D].iter().map(|c| c.at[i]).sum::<f64>() / D as f64);
        let along = |t: f64| std::array::from_fn(|i| centre[i] + t * (worst.at[i] - centre[i]));
        let reflected = at(along(-1.0))?;
        count += 1;
        if reflected.value > corners[0].value {
            let expanded = at(along(-2.0))?;
            count += 1;
            corners[D] = if expanded.value > reflected.value {
                expanded
            } else {
                reflected
            };
        } else if reflected.value > corners[D - 1].value {
            corners[D] = reflected;
        } else {
            let inside = if reflected.value > worst.value {
                at(along(-0.5))?
            } else {
                at(along(0.5))?
            };
            count += 1;
            if inside.value > worst.value.max(reflected.value) {
                corners[D] = inside;
            } else {
                for j in 1..=D {
                    let x = std::array::from_fn(|i| 0.5 * (corners[j].at[i] + corners[0].at[i]));
                    corners[j] = at(x)?;
                }
                count += D;
            }
        }
    }
    corners.sort_by(|a, b| b.value.total_cmp(&a.value));
    Ok(corners[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_maximum_of_one_variable() {
        let mut passes = 0;
        let found = line(-6.0, 4.0, 1.0, 0.01, |x| {
            passes += 1;
            Ok(-(x - 1.2345).powi(2) - 0.1 * (x - 1.2345).powi(3).abs())
        })
        .unwrap();
        assert!((found.at - 1.2345).abs() < 0.02, "{found:?}");
        assert!(passes < 25, "{passes}");
        // At an end.
        let found = line(0.0, 1.0, 0.5, 0.01, |x| Ok(-x)).unwrap();
        assert!(found.at < 0.02);
    }

    #[test]
    fn known_maximum_of_three_variables() {
        let found = simplex([0.0; 3], 0.7, 400, |x| {
            Ok(-(x[0] - 1.0).powi(2)
                - 4.0 * (x[1] + 0.5).powi(2)
                - (x[2] - x[0]).powi(2)
                - 0.3 * x[0] * x[1])
        })
        .unwrap();
        // The gradient vanishes at x₂ = x₀, 2(x₀ − 1) + 0.3 x₁ = 0, 8(x₁ + ½) + 0.3 x₀ = 0.
        let x0 = (2.0 + 0.15) / (2.0 - 0.09 / 8.0);
        let x1 = -0.5 - 0.3 * x0 / 8.0;
        for (ours, due) in found.at.iter().zip([x0, x1, x0]) {
            assert!((ours - due).abs() < 0.02, "{found:?}");
        }
    }
}

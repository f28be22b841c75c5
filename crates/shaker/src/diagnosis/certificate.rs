//! One frequency at which the certificate of the reference does not fit the others.

use super::super::budget::Budget;
use super::super::fit::{Fit, FrequencyFit};
use crate::findings;
use faer::Mat;
use num_complex::Complex64;
use proofmass_uncertainty::algebra::{cholesky, product};
use proofmass_uncertainty::{Effect, Finding};

/// Frequencies below which the model takes all there is to see.
const FEWEST: usize = 5;
/// Gain in χ² with which a frequency is named.
const GAIN: f64 = 20.0;
/// What a device departs from the model at one frequency, relative and in radians: all axes together, and each alone.
const TOGETHER: f64 = 1.5e-3;
const ALONE: f64 = 5e-4;
/// A model that leaves more than this per degree of freedom does not describe the device.
const DESCRIBED: f64 = 9.0;

/// Parameters of an axis: ln c, 1/f₀² and damping of the resonance, corner of the high-pass.
const PARAMETERS: usize = 4;

/// ln |S_jj| and arg S_jj of the model, and its derivatives.
///
/// S = c/(1 − p f² + j d f)/(1 − j h/f)
fn model(parameters: &[f64], frequency: f64) -> ([f64; 2], [[f64; 2]; PARAMETERS]) {
    let [c, p, d, h] = [parameters[0], parameters[1], parameters[2], parameters[3]];
    let j = Complex64::new(0.0, 1.0);
    let below = Complex64::new(1.0, 0.0) - p * frequency * frequency + j * d * frequency;
    let above = Complex64::new(1.0, 0.0) - j * (h / frequency);
    let value = Complex64::new(c, 0.0) - below.ln() - above.ln();
    let pair = |z: Complex64| [z.re, z.im];
    (
        pair(value),
        [
            [1.0, 0.0],
            pair(Complex64::new(frequency * frequency, 0.0) / below),
            pair(-j * frequency / below),
            pair(j / frequency / above),
        ],
    )
}

/// ln S_jj of three axes at a frequency, real and imaginary, and what is uncertain of it at this frequency alone.
fn observed(f: &FrequencyFit, budget: &Budget) -> Option<([f64; 6], [[f64; 6]; 6])> {
    let mut y = [0.0; 6];
    let mut jacobian = [[0.0; 18]; 6];
    for axis in 0..3 {
        let s = f.sensitivity[axis][axis];
        if s.norm() == 0.0 {
            return None;
        }
        // An inverted channel has the same response.
        let ln = if s.re < 0.0 { (-s).ln() } else { s.ln() };
        (y[2 * axis], y[2 * axis + 1]) = (ln.re, ln.im);
        let g = s.inv();
        let p = 2 * (4 * axis);
        jacobian[2 * axis][p] = g.re;
        jacobian[2 * axis][p + 1] = -g.im;
        jacobian[2 * axis + 1][p] = g.im;
        jacobian[2 * axis + 1][p + 1] = g.re;
    }
    let shared = |key: &str| {
        let mut inputs = budget.inputs.iter();
        inputs.any(|i| i.key == key && i.shared_by_frequencies())
    };
    let mut v = [[0.0; 6]; 6];
    for influence in f.estimate.influences() {
        let Effect::Joint { covariance } = &influence.effect else {
            continue;
        };
        if shared(&influence.key) {
            continue;
        }
        for a in 0..6 {
            for b in 0..6 {
                for p in 0..18 {
                    for q in 0..18 {
                        if jacobian[a][p] != 0.0 && jacobian[b][q] != 0.0 {
                            v[a][b] += jacobian[a][p] * jacobian[b][q] * covariance[(p, q)];
                        }
                    }
                }
            }
        }
    }
    for a in 0..6 {
        for b in 0..6 {
            if a % 2 == b % 2 {
                v[a][b] += TOGETHER * TOGETHER;
            }
        }
        v[a][a] += ALONE * ALONE;
    }
    Some((y, v))
}

/// The frequency at which all main terms together depart from a resonance and a high-pass fitted to all frequencies.
///
/// T = (gᵀV⁻¹r)²/(gᵀPg) is the gain in χ² when the modulus of the reference is free at that frequency; the scatter
/// that is left without it widens the limit.
pub(super) fn finding(fit: &Fit, budget: &Budget) -> Option<Finding> {
    let count = fit.frequencies.len();
    if count < FEWEST {
        return None;
    }
    let mut observations = vec![];
    for f in &fit.frequencies {
        let (y, v) = observed(f, budget)?;
        let llt = cholesky(&Mat::from_fn(6, 6, |a, b| v[a][b])).ok()?;
        observations.push((f.frequency, y, llt.inverse()));
    }
    let unknowns = 3 * PARAMETERS;
    let mut parameters = vec![0.0; unknowns];
    for axis in 0..3 {
        let mut level: Vec<f64> = observations.iter().map(|o| o.1[2 * axis]).collect();
        level.sort_by(f64::total_cmp);
        parameters[PARAMETERS * axis] = level[count / 2];
    }
    let residuals = |parameters: &[f64]| {
        let at = |(frequency, y, _): &(f64, [f64; 6], Mat<f64>)| {
            let mut r = Mat::<f64>::zeros(6, 1);
            let mut x = Mat::<f64>::zeros(6, unknowns);
            for axis in 0..3 {
                let first = PARAMETERS * axis;
                let (value, slopes) = model(&parameters[first..first + PARAMETERS], *frequency);
                for part in 0..2 {
                    r[(2 * axis + part, 0)] = y[2 * axis + part] - value[part];
                    for (k, slope) in slopes.iter().enumerate() {
                        x[(2 * axis + part, first + k)] = slope[part];
                    }
                }
            }
            (r, x)
        };
        observations.iter().map(at).collect::<Vec<_>>()
    };
    let cost = |rows: &[(Mat<f64>, Mat<f64>)]| -> f64 {
        let parts = rows.iter().zip(&observations);
        parts
            .map(|((r, _), (.., w))| product([r.transpose(), w.as_ref(), r.as_ref()])[(0, 0)])
            .sum()
    };
    let mut rows = residuals(&parameters);
    let mut inverse = Mat::<f64>::zeros(unknowns, unknowns);
    for _ in 0..50 {
        let mut normal = Mat::<f64>::zeros(unknowns, unknowns);
        let mut right = Mat::<f64>::zeros(unknowns, 1);
        for ((r, x), (.., w)) in rows.iter().zip(&observations) {
            normal += product([x.transpose(), w.as_ref(), x.as_ref()]);
            right += product([x.transpose(), w.as_ref(), r.as_ref()]);
        }
        // Units of the parameters differ by many powers of ten.
        let size: Vec<f64> = (0..unknowns).map(|k| normal[(k, k)].sqrt()).collect();
        if size.iter().any(|s| !(*s > 0.0)) {
            return None;
        }
        let scaled = Mat::from_fn(unknowns, unknowns, |a, b| {
            normal[(a, b)] / (size[a] * size[b])
        });
        let llt = cholesky(&scaled).ok()?;
        let own = llt.inverse();
        inverse = Mat::from_fn(unknowns, unknowns, |a, b| own[(a, b)] / (size[a] * size[b]));
        let step = product([inverse.as_ref(), right.as_ref()]);
        let gain = product([right.transpose(), step.as_ref()])[(0, 0)];
        let before = cost(&rows);
        let mut share = 1.0;
        loop {
            let trial: Vec<f64> = (0..unknowns)
                .map(|k| parameters[k] + share * step[(k, 0)])
                .collect();
            let next = residuals(&trial);
            let after = cost(&next);
            if after.is_finite() && after <= before * (1.0 + 1e-12) {
                (parameters, rows) = (trial, next);
                break;
            }
            share *= 0.5;
            if share < 1e-6 {
                break;
            }
        }
        if gain < 1e-6 || share < 1e-6 {
            break;
        }
    }
    let chi_squared = cost(&rows);
    let g = Mat::from_fn(6, 1, |a, _| f64::from(a % 2 == 0));
    let mut judged: Vec<(f64, f64, f64, f64)> = rows
        .iter()
        .zip(&observations)
        .filter_map(|((r, x), (frequency, _, w))| {
            let along = product([g.transpose(), w.as_ref(), r.as_ref()])[(0, 0)];
            let h = product([x.transpose(), w.as_ref(), g.as_ref()]);
            let square = product([g.transpose(), w.as_ref(), g.as_ref()])[(0, 0)]
                - product([h.transpose(), inverse.as_ref(), h.as_ref()])[(0, 0)];
            if !(square > 1.0) {
                return None;
            }
            let gain = along * along / square;
            let left = (chi_squared - gain) / (6.0 * count as f64 - unknowns as f64 - 1.0);
            (left < DESCRIBED).then(|| {
                (
                    gain / left.max(1.0),
                    *frequency,
                    along / square,
                    1.0 / square.sqrt(),
                )
            })
        })
        .collect();
    judged.sort_by(|a, b| b.0.total_cmp(&a.0));
    let &(gain, frequency, departure, u) = judged.first()?;
    if gain < GAIN {
        return None;
    }
    let second = judged
        .get(1)
        .filter(|s| s.0 > gain - 6.0)
        .map_or_else(String::new, |s| format!(", or at {} Hz", s.1));
    Some(findings::certificate_off(
        frequency,
        &second,
        count,
        100.0 * departure,
        100.0 * u,
        gain,
    ))
}

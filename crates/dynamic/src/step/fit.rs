//! The least-squares fit of a step to samples.

use super::response::Oscillator;
use proofmass_core::Error;
use proofmass_uncertainty::adjustment::{Equations, cholesky, solve};

/// Parameters of the fit: baseline, height, instant, logarithm of the frequency, damping, variance of the rise.
pub(super) const P: usize = 6;

/// Samples of a record, and the units in which its parameters are of order one.
#[derive(Clone)]
pub(super) struct Samples {
    /// In heights.
    pub(super) values: Vec<f64>,
    /// Samples per second.
    pub(super) rate: f64,
    /// When the first is, s.
    pub(super) begin: f64,
}

/// Time by a frequency, from an instant.
#[derive(Clone, Copy)]
pub(super) struct Unit {
    pub(super) instant: f64,
    pub(super) frequency: f64,
}

impl Unit {
    pub(super) fn instant(&self, p: &[f64]) -> f64 {
        self.instant + p[2] / self.frequency
    }

    pub(super) fn frequency(&self, p: &[f64]) -> f64 {
        self.frequency * p[3].exp()
    }

    pub(super) fn variance(&self, p: &[f64]) -> f64 {
        p[5] / self.frequency.powi(2)
    }

    /// The response to a unit step on the samples' times.
    pub(super) fn response<'a>(
        &self,
        samples: &'a Samples,
        p: &[f64],
    ) -> impl Iterator<Item = f64> + use<'a> {
        let oscillator = Oscillator::new(self.frequency(p), p[4]);
        let (instant, variance) = (self.instant(p), self.variance(p));
        (0..samples.values.len())
            .map(move |k| samples.begin + k as f64 / samples.rate - instant)
            .map(move |t| oscillator.risen(t, variance))
    }

    /// The samples in which the acceleration still rises, or a filter behind the device has not settled.
    pub(super) fn rising(&self, samples: &Samples, p: &[f64]) -> std::ops::Range<usize> {
        let period = self.frequency(p).recip();
        let sample = |t: f64| {
            let k = ((self.instant(p) + t - samples.begin) * samples.rate).ceil();
            (k.max(0.0) as usize).min(samples.values.len())
        };
        sample(-period / 20.0)..sample(period / 6.0)
    }

    /// Whether a fit may go there: below a second of zero damping nothing swings up, and a rise of two periods hides the swing.
    fn allows(&self, p: &[f64]) -> bool {
        p.iter().all(|v| v.is_finite())
            && p[3].abs() < 4.0
            && (-0.5..30.0).contains(&p[4])
            && p[5].abs() < 0.3
    }

    pub(super) fn equations(&self, samples: &Samples, p: &[f64]) -> Result<Equations, Error> {
        // Of a period, of the logarithm, of the damping; the last is a variance, to which a small rise is proportional.
        const STEP: [f64; P] = [0.0, 0.0, 1e-6, 1e-6, 1e-6, 1e-5];
        if !self.allows(p) {
            return Err(Error::NotConverged {
                name: "step fit",
                iterations: 0,
                step: f64::INFINITY,
            });
        }
        let n = samples.values.len();
        let mut equations = Equations {
            residual: Vec::with_capacity(n),
            jacobian: vec![1.0; P * n],
        };
        for (k, share) in self.response(samples, p).enumerate() {
            equations
                .residual
                .push(p[0] + p[1] * share - samples.values[k]);
            equations.jacobian[P * k + 1] = share;
        }
        for (j, step) in STEP.iter().enumerate().skip(2) {
            let [low, high] = [-step, *step].map(|h| {
                let mut q = p.to_vec();
                q[j] += h;
                q
            });
            let pairs = self
                .response(samples, &low)
                .zip(self.response(samples, &high));
            for (k, (low, high)) in pairs.enumerate() {
                equations.jacobian[P * k + j] = p[1] * (high - low) / (2.0 * step);
            }
        }
        Ok(equations)
    }
}

/// Equations without those of some samples.
pub(super) fn left_out(mut equations: Equations, samples: &std::ops::Range<usize>) -> Equations {
    equations.residual[samples.clone()].fill(0.0);
    equations.jacobian[P * samples.start..P * samples.end].fill(0.0);
    equations
}

/// Baseline and height by least squares, with the squares that they leave, where the response to a unit step is known.
pub(super) fn levels(samples: &Samples, response: &[f64]) -> Option<([f64; 2], f64)> {
    let n = response.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
    let (x, y) = (mean(response), mean(&samples.values));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (a, b) in response.iter().zip(&samples.values) {
        xx += (a - x) * (a - x);
        xy += (a - x) * (b - y);
        yy += (b - y) * (b - y);
    }
    if !(xx > 1e-12 * n) {
        return None;
    }
    let height = xy / xx;
    Some(([y - height * x, height], (yy - height * xy).max(0.0)))
}

pub(super) fn cost(e: &Equations) -> f64 {
    e.residual.iter().map(|r| r * r).sum()
}

/// Damped Gauss–Newton until the squares fall no further, and whether they settled. With a few samples a period the second derivative
/// jumps where the instant passes a sample, so that the last digits of the step need not settle.
///
/// **Source** `[Marquardt1963]`.
pub(super) fn settled(
    start: &[f64],
    most: usize,
    equations: impl Fn(&[f64]) -> Result<Equations, Error>,
) -> Option<(Vec<f64>, Equations, bool)> {
    let mut parameters = start.to_vec();
    let mut here = equations(&parameters).ok()?;
    let mut before = cost(&here);
    let mut damping = 1e-3;
    for _ in 0..most {
        let plain = normal(&here);
        let mut gradient = vec![0.0; P];
        for (row, r) in here.jacobian.chunks_exact(P).zip(&here.residual) {
            gradient.iter_mut().zip(row).for_each(|(g, j)| *g += j * r);
        }
        loop {
            let mut factor = plain.clone();
            (0..P).for_each(|a| factor[a * P + a] = factor[a * P + a] * (1.0 + damping) + 1e-300);
            let mut step = gradient.clone();
            let known = cholesky(&mut factor, P).is_some();
            if known {
                solve(&factor, &mut step);
            }
            let trial: Vec<f64> = parameters.iter().zip(&step).map(|(x, s)| x - s).collect();
            let there = if known { equations(&trial).ok() } else { None };
            let lower = there.map(|e| (cost(&e), e)).filter(|(c, _)| *c < before);
            if let Some((squares, e)) = lower {
                let fallen = before - squares;
                (parameters, here, before) = (trial, e, squares);
                damping = (0.2 * damping).max(1e-12);
                if fallen <= 1e-10 * before {
                    return Some((parameters, here, true));
                }
                break;
            }
            damping *= 5.0;
            if damping > 1e6 {
                return Some((parameters, here, true));
            }
        }
    }
    Some((parameters, here, false))
}

/// JᵀJ.
fn normal(equations: &Equations) -> Vec<f64> {
    let mut normal = vec![0.0; P * P];
    for row in equations.jacobian.chunks_exact(P) {
        for a in 0..P {
            for b in 0..P {
                normal[a * P + b] += row[a] * row[b];
            }
        }
    }
    normal
}

/// (JᵀJ)⁻¹, row by row.
fn inverse(equations: &Equations) -> Option<Vec<f64>> {
    let mut factor = normal(equations);
    cholesky(&mut factor, P)?;
    let columns = (0..P).flat_map(|a| {
        let mut unit = vec![0.0; P];
        unit[a] = 1.0;
        solve(&factor, &mut unit);
        unit
    });
    Some(columns.collect())
}

/// (JᵀJ)⁻¹ JᵀΩJ (JᵀJ)⁻¹ with the residuals' autocovariance under Bartlett's window, (JᵀJ)⁻¹ itself, and the degrees of freedom with which
/// the first is known.
///
/// Each autocovariance has what the fit takes of it added, as it is for white noise: σ² Σ hₖ,ₖ₋ₗ, h of the hat matrix.
pub(super) fn sandwich(equations: &Equations) -> Option<(Vec<f64>, Vec<f64>, f64)> {
    let n = equations.residual.len();
    // As many lags as leave little of the correlation of neighbours out; what their number costs is in the degrees of freedom.
    let lags = ((n as f64).sqrt() as usize).min(100).min(n / 4);
    let window = |l: usize| 1.0 - l as f64 / (lags + 1) as f64;
    let r = &equations.residual;
    let rows: Vec<&[f64]> = equations.jacobian.chunks_exact(P).collect();
    let inverse = inverse(equations)?;
    let variance = cost(equations) / (n - P) as f64;
    let mut meat = [0.0; P * P];
    for l in 0..=lags {
        let mut products = [0.0; P * P];
        for k in l..n {
            let (x, y) = (rows[k], rows[k - l]);
            for a in 0..P {
                for b in 0..P {
                    products[a * P + b] += x[a] * y[b];
                }
            }
        }
        let taken: f64 = products.iter().zip(&inverse).map(|(p, i)| p * i).sum();
        let seen: f64 = r[l..].iter().zip(r).map(|(a, b)| a * b).sum();
        let c = window(l) * (seen + variance * taken) / n as f64;
        for a in 0..P {
            for b in 0..P {
                meat[a * P + b] += match l {
                    0 => c * products[a * P + b],
                    _ => c * (products[a * P + b] + products[b * P + a]),
                };
            }
        }
    }
    let mut result = vec![0.0; P * P];
    for a in 0..P {
        for b in 0..P {
            for c in 0..P {
                for d in 0..P {
                    result[a * P + b] += inverse[a * P + c] * meat[c * P + d] * inverse[d * P + b];
                }
            }
        }
    }
    // A density from lags under a window is known as n over the sum of the window's squares.
    let spread = 1.0 + 2.0 * (1..=lags).map(|l| window(l).powi(2)).sum::<f64>();
    let freedom = ((n - P) as f64 / spread).max(1.0);
    (0..P)
        .all(|a| result[a * P + a] > 0.0)
        .then_some((result, inverse, freedom))
}

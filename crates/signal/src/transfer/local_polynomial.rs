//! Frequency response of one long record, a sweep above all, by local polynomials.

use super::ResponseEstimate;
use crate::fourier;
use num_complex::Complex64;
use proofmass_core::{Error, Watch};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The local polynomial method: around each line the response and the transient of the record's ends are smooth, the input
/// is not, so that Y(k + r) = G(r) X(k + r) + T(r), G and T parabolas, is a regression over the 2n + 1 lines around k.
///
/// No window, no leakage bias of the first kind, and the noise is seen in the residuals: 2n + 1 − 6 complex degrees of freedom
/// per line. Lines are given at every (2n + 1)th of the record's own, so that they are independent.
///
/// **Assumes** noise on the output; an input with some energy in every line of the band.
///
/// **Source** `[Pintelon2010]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct LocalPolynomial {
    /// Lines to either side, n.
    pub half_width: usize,
    /// Lowest and highest frequency, Hz.
    pub band: [f64; 2],
    /// Most lines that are given; beyond, neighbours are joined evenly in the logarithm of frequency by a wider window.
    pub lines: usize,
}

impl Default for LocalPolynomial {
    fn default() -> Self {
        Self {
            half_width: 8,
            band: [0.0, f64::INFINITY],
            lines: 400,
        }
    }
}

const ORDER: usize = 3;

impl LocalPolynomial {
    /// Estimates the response of `output` to `input`.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::NotFinite`]; [`Error::TooFew`] when the record has too few lines in the band.
    pub fn estimate(
        &self,
        input: &[f64],
        output: &[f64],
        rate: f64,
        watch: &dyn Watch,
    ) -> Result<ResponseEstimate, Error> {
        crate::shock_spectrum::positive("sample rate", rate)?;
        if input.len() != output.len() {
            return Err(Error::Length {
                name: "output",
                expected: input.len(),
                got: output.len(),
            });
        }
        for (name, signal) in [("input", input), ("output", output)] {
            if let Some(index) = signal.iter().position(|v| !v.is_finite()) {
                return Err(Error::NotFinite { name, index });
            }
        }
        watch.step("transform", 0, 2)?;
        let n = input.len();
        let half = self.half_width.max(ORDER + 1);
        let (x, y) = (fourier::forward(input), fourier::forward(output));
        watch.step("transform", 1, 2)?;
        let line = rate / n.max(1) as f64;
        if x.len() < 4 * half {
            return Err(Error::TooFew {
                name: "lines of the record",
                needed: 4 * half,
                got: x.len(),
            });
        }
        let first = (self.band[0] / line).ceil().max(1.0) as usize;
        let last = ((self.band[1] / line).floor() as usize).min(x.len() - 2);
        let (low, high) = (first + half, last.saturating_sub(half));
        if low > high {
            return Err(Error::TooFew {
                name: "lines of the record within the band",
                needed: 2 * half + 1,
                got: (last + 1).saturating_sub(first),
            });
        }
        // Windows side by side; where they are more than asked for, some are left out evenly in the logarithm.
        let mut centres: Vec<usize> = (low..=high).step_by(2 * half + 1).collect();
        if centres.len() > self.lines.max(2) {
            let ratio = (high as f64 / low as f64).powf(1.0 / (self.lines as f64 - 1.0));
            let mut kept = Vec::new();
            let mut next = low as f64;
            for c in centres {
                if c as f64 >= next {
                    kept.push(c);
                    next = (next * ratio).max(c as f64 + 1.0);
                }
            }
            centres = kept;
        }
        let results: Vec<Option<(Complex64, f64, f64)>> = centres
            .par_iter()
            .map(|c| regress(&x[c - half..=c + half], &y[c - half..=c + half]))
            .collect();
        watch.step("transform", 2, 2)?;
        let mut estimate = ResponseEstimate {
            independent_every: 1,
            ..ResponseEstimate::default()
        };
        for (c, result) in centres.iter().zip(results) {
            let Some((value, variance, coherence)) = result else {
                continue;
            };
            estimate.frequency.push(*c as f64 * line);
            estimate.value.push(value);
            estimate
                .covariance
                .push([0.5 * variance, 0.0, 0.5 * variance]);
            estimate.dof.push(2.0 * (2 * half + 1 - 2 * ORDER) as f64);
            estimate.coherence.push(coherence);
            estimate.leakage.push(Complex64::new(0.0, 0.0));
        }
        if estimate.frequency.is_empty() {
            return Err(Error::Constant {
                name: "input",
                value: input[0],
            });
        }
        Ok(estimate)
    }
}

/// G(0), its variance E|δ|², and the share of the output's power that the regression explains.
fn regress(x: &[Complex64], y: &[Complex64]) -> Option<(Complex64, f64, f64)> {
    let n = x.len();
    let half = (n - 1) as f64 / 2.0;
    let r = |k: usize| (k as f64 - half) / half;
    let scale = (x.iter().map(|v| v.norm_sqr()).sum::<f64>() / n as f64).sqrt();
    if !(scale > 0.0) {
        return None;
    }
    // Columns: T parabola first, then those of G, the constant of G last: its row of R gives value and variance at once.
    let mut columns: Vec<Vec<Complex64>> = Vec::with_capacity(2 * ORDER);
    for d in 0..ORDER {
        columns.push(
            (0..n)
                .map(|k| Complex64::new(r(k).powi(d as i32), 0.0))
                .collect(),
        );
    }
    for d in (0..ORDER).rev() {
        columns.push((0..n).map(|k| x[k] / scale * r(k).powi(d as i32)).collect());
    }
    let mut right = y.to_vec();
    let total: f64 = right.iter().map(|v| v.norm_sqr()).sum();
    let dot = |a: &[Complex64], b: &[Complex64]| -> Complex64 {
        a.iter().zip(b).map(|(p, q)| p.conj() * q).sum()
    };
    let count = columns.len();
    let mut last = (Complex64::new(0.0, 0.0), 0.0);
    for j in 0..count {
        // Twice is enough.
        for _ in 0..2 {
            for i in 0..j {
                let (done, rest) = columns.split_at_mut(j);
                let c = dot(&done[i], &rest[0]);
                for (v, q) in rest[0].iter_mut().zip(&done[i]) {
                    *v -= c * q;
                }
            }
        }
        let norm = columns[j].iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        if !(norm > 1e-9) {
            return None;
        }
        columns[j].iter_mut().for_each(|v| *v /= norm);
        let c = dot(&columns[j], &right);
        for (v, q) in right.iter_mut().zip(&columns[j]) {
            *v -= c * q;
        }
        last = (c / norm, norm);
    }
    let residual: f64 = right.iter().map(|v| v.norm_sqr()).sum();
    let noise = residual / (n - count) as f64;
    let (value, norm) = last;
    Some((
        value / scale,
        noise / (norm * norm * scale * scale),
        if total > 0.0 {
            1.0 - residual / total
        } else {
            0.0
        },
    ))
}

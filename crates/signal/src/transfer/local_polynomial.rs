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
/// What a sweep drives in the first or last (2n + 1)th of the record looks as smooth as the transient of that end: G and T are hardly told
/// apart there. Lines at which less than a hundredth of the input's power tells them apart, and of which nothing better than half of their
/// modulus is known, are not given. The coherence is the share of the output's power beyond the transient that the input explains.
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
        proofmass_core::check::positive("sample rate", rate)?;
        if input.len() != output.len() {
            return Err(Error::Length {
                name: "output",
                expected: input.len(),
                got: output.len(),
            });
        }
        for (name, signal) in [("input", input), ("output", output)] {
            proofmass_core::check::finite(name, signal)?;
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
        let results: Vec<Option<Line>> = centres
            .par_iter()
            .map(|c| regress(&x[c - half..=c + half], &y[c - half..=c + half]))
            .collect();
        watch.step("transform", 2, 2)?;
        let driven = results.iter().any(Option::is_some);
        let mut estimate = ResponseEstimate {
            independent_every: 1,
            ..ResponseEstimate::default()
        };
        for (c, result) in centres.iter().zip(results) {
            let Some(result) = result.filter(Line::is_known) else {
                continue;
            };
            let Line {
                value,
                variance,
                coherence,
                ..
            } = result;
            estimate.frequency.push(*c as f64 * line);
            estimate.value.push(value);
            estimate
                .covariance
                .push([0.5 * variance, 0.0, 0.5 * variance]);
            estimate.dof.push(2.0 * (2 * half + 1 - 2 * ORDER) as f64);
            estimate.coherence.push(coherence);
            estimate.leakage.push(Complex64::new(0.0, 0.0));
        }
        if estimate.frequency.is_empty() && driven {
            return Err(Error::Unobservable {
                parameter: "response beside the transients of the record's ends",
                condition: f64::INFINITY,
            });
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

/// What the regression gives for one line.
struct Line {
    /// G(0).
    value: Complex64,
    /// E|δ|² of it.
    variance: f64,
    /// Share of the output's power beyond the transient that the input explains.
    coherence: f64,
    /// Share of the input's power that is neither in the transient nor in the slope and curvature of G.
    told_apart: f64,
}

impl Line {
    fn is_known(&self) -> bool {
        // Student's t at 95 % with the sixteen degrees of freedom and more of a line: 2.1.
        self.told_apart >= 0.01 || 2.1 * (0.5 * self.variance).sqrt() <= 0.5 * self.value.norm()
    }
}

fn regress(x: &[Complex64], y: &[Complex64]) -> Option<Line> {
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
    // Of the output, what is no transient.
    let mut beyond = 0.0;
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
        if j + 1 == ORDER {
            beyond = right.iter().map(|v| v.norm_sqr()).sum::<f64>();
        }
    }
    let residual: f64 = right.iter().map(|v| v.norm_sqr()).sum();
    let noise = residual / (n - count) as f64;
    let (value, norm) = last;
    Some(Line {
        value: value / scale,
        variance: noise / (norm * norm * scale * scale),
        coherence: if beyond > 0.0 {
            1.0 - residual / beyond
        } else {
            0.0
        },
        told_apart: norm * norm / n as f64,
    })
}

//! Frequency response from recorded input and output: cross-spectra, estimators, coherence, what noise makes of them.

mod cross;
mod local_polynomial;
mod smearing;
#[cfg(test)]
mod tests;

pub use cross::{CrossSpectra, Hit, OutputSpectra};
pub use local_polynomial::LocalPolynomial;
pub use smearing::Smearing;

use num_complex::Complex64;
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// Where the noise is, and with that the estimator that has no bias from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Estimator {
    /// H₁ = Gxy/Gxx: noise on the output alone; noise on the input makes it small.
    #[default]
    H1,
    /// H₂ = Gyy/Gyx: noise on the input alone; noise on the output makes it large.
    H2,
    /// Hv: noise on both, with a known ratio of densities of output to input noise, in (output unit/input unit)².
    Hv {
        /// That ratio.
        noise_ratio: f64,
    },
}

/// A frequency response by lines, with what the data say of its uncertainty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResponseEstimate {
    /// Hz.
    pub frequency: Vec<f64>,
    /// Output over input.
    pub value: Vec<Complex64>,
    /// Covariance of real and imaginary part of each: rr, ri, ii.
    pub covariance: Vec<[f64; 3]>,
    /// Degrees of freedom of the noise in it.
    pub dof: Vec<f64>,
    /// Coherence γ², where there are averages.
    pub coherence: Vec<f64>,
    /// Systematic error by the width of the lines, as estimated from the curvature; already within `covariance`.
    pub leakage: Vec<Complex64>,
    /// Every how many lines two are independent: a window joins its neighbours. 1 when they all are.
    pub independent_every: usize,
}

impl ResponseEstimate {
    /// Lines that have a frequency, a value, a covariance and degrees of freedom.
    pub fn lines(&self) -> usize {
        [
            self.frequency.len(),
            self.value.len(),
            self.covariance.len(),
            self.dof.len(),
        ]
        .into_iter()
        .min()
        .unwrap_or(0)
    }

    /// Standard uncertainties of modulus and phase (rad) of a line, to first order.
    pub fn polar_uncertainty(&self, line: usize) -> (f64, f64) {
        polar(self.value[line], self.covariance[line])
    }

    /// Lines within a band, both ends included.
    #[must_use]
    pub fn within(&self, low: f64, high: f64) -> Self {
        let keep: Vec<usize> = (0..self.frequency.len())
            .filter(|k| (low..=high).contains(&self.frequency[*k]))
            .collect();
        Self {
            frequency: keep.iter().map(|k| self.frequency[*k]).collect(),
            value: keep.iter().map(|k| self.value[*k]).collect(),
            covariance: keep.iter().map(|k| self.covariance[*k]).collect(),
            dof: keep.iter().map(|k| self.dof[*k]).collect(),
            coherence: keep
                .iter()
                .filter_map(|k| self.coherence.get(*k).copied())
                .collect(),
            leakage: keep
                .iter()
                .filter_map(|k| self.leakage.get(*k).copied())
                .collect(),
            independent_every: self.independent_every,
        }
    }
}

/// Standard uncertainties of modulus and phase (rad) of z with the covariance rr, ri, ii of its parts.
pub fn polar(z: Complex64, [rr, ri, ii]: [f64; 3]) -> (f64, f64) {
    let r = z.norm();
    if r == 0.0 {
        return ((0.5 * (rr + ii)).max(0.0).sqrt(), std::f64::consts::PI);
    }
    let (c, s) = (z.re / r, z.im / r);
    let along = c * c * rr + 2.0 * c * s * ri + s * s * ii;
    let across = s * s * rr - 2.0 * c * s * ri + c * c * ii;
    (along.max(0.0).sqrt(), across.max(0.0).sqrt() / r)
}

/// Covariance rr, ri, ii of a complex number after its multiplication by another.
pub fn turned([rr, ri, ii]: [f64; 3], s: Complex64) -> [f64; 3] {
    let (c, d) = (s.re, s.im);
    [
        c * c * rr - 2.0 * c * d * ri + d * d * ii,
        c * d * (rr - ii) + (c * c - d * d) * ri,
        d * d * rr + 2.0 * c * d * ri + c * c * ii,
    ]
}

impl CrossSpectra {
    /// The frequency response of one output.
    ///
    /// With K independent averages (overlap counted by the window's own correlation) and coherence γ², the complex H₁ has
    /// E|δ|² = (1 − γ²) Gyy/((K − 1) Gxx), the same in both parts, with 2(K − 1) degrees of freedom: given the input, it is
    /// a regression. H₂ is the same with the roles exchanged. Hv is the regression with errors in both variables,
    /// E|δ|² = [(Gx + Gm) Gv − |H|² Gm²]/(K Gx²), Gv = Gn + |H|² Gm.
    ///
    /// **Leakage** a window smooths: E Gxy/Gxx = H + c H″, and E Gyy/Gxx = |E Gxy/Gxx|² + 2c|H′|². So E Ĥ₁ = H + c H″, E Ĥ₂ = H +
    /// c(H″ + 2|H′|²/H*), E Ĥv = H + c(H″ + 2|H′|² H/(ρ + |H|²)) with ρ the ratio of the noises: differences of neighbouring lines show
    /// it. It is given for each line, and its square is in the covariance, along its own direction.
    ///
    /// **Errors** [`Error::OutOfRange`] for an output that is not there or a ratio that is not positive,
    /// [`Error::TooFew`] below two independent averages.
    ///
    /// **Accuracy** intervals of real and imaginary part cover at 95 % under noise on output, input and both
    /// (`coverage_frf_*`).
    ///
    /// **Source** `[BendatPiersol2010] ch. 9`; Hv with its variance `[Fuller1987] 1.3`.
    pub fn response(&self, output: usize, estimator: Estimator) -> Result<ResponseEstimate, Error> {
        let Some(channel) = self.outputs.get(output) else {
            return Err(Error::OutOfRange {
                name: "number of the output",
                value: output as f64,
                min: 0.0,
                max: self.outputs.len() as f64 - 1.0,
            });
        };
        if let Estimator::Hv { noise_ratio } = estimator {
            proofmass_core::check::positive("ratio of the noises", noise_ratio)?;
        }
        let k = self.independent;
        if !(k >= 1.5) {
            return Err(Error::TooFew {
                name: "independent averages",
                needed: 2,
                got: k as usize,
            });
        }
        let mut result = ResponseEstimate {
            // Under a Hann window the errors of neighbours correlate by 4/9, of the next but one by 1/36.
            independent_every: if self.smoothing > 0.0 { 2 } else { 1 },
            ..ResponseEstimate::default()
        };
        for line in 0..self.frequency.len() {
            let (gxx, gyy, gxy) = (self.input[line], channel.auto[line], channel.cross[line]);
            if !(gxx > 0.0 && gyy > 0.0) {
                continue;
            }
            let coherence = (gxy.norm_sqr() / (gxx * gyy)).min(1.0);
            if coherence == 0.0 {
                continue;
            }
            let spread = |gain: f64| (1.0 - coherence) * gain / (k - 1.0);
            let (value, variance) = match estimator {
                Estimator::H1 => (gxy / gxx, spread(gyy / gxx)),
                Estimator::H2 => {
                    let h = gyy / gxy.conj();
                    (h, spread(h.norm_sqr().powi(2) * gxx / gyy))
                }
                Estimator::Hv { noise_ratio } => in_both(gxx, gyy, gxy, noise_ratio, k),
            };
            result.frequency.push(self.frequency[line]);
            result.value.push(value);
            result
                .covariance
                .push([0.5 * variance, 0.0, 0.5 * variance]);
            result.dof.push(2.0 * (k - 1.0));
            result.coherence.push(coherence);
        }
        let n = result.value.len();
        for line in 0..n {
            let (before, after) = (line.saturating_sub(1), (line + 1).min(n.max(1) - 1));
            let h = result.value[line];
            let second = result.value[after] - 2.0 * h + result.value[before];
            let slope = 0.5 * (result.value[after] - result.value[before]);
            // What the slope within a line adds to the output's power is none of the input's: noise to the estimator.
            let spread = match estimator {
                Estimator::H1 => Complex64::new(0.0, 0.0),
                Estimator::H2 => slope.norm_sqr() / h.conj(),
                Estimator::Hv { noise_ratio } => {
                    slope.norm_sqr() * h / (noise_ratio + h.norm_sqr())
                }
            };
            let bias = if after - before == 2 {
                self.smoothing * (second + 2.0 * spread)
            } else {
                Complex64::new(0.0, 0.0)
            };
            result.leakage.push(bias);
        }
        // Whole, not its third: the second difference of what is smoothed already shows too little of a sharp resonance.
        for (c, b) in result.covariance.iter_mut().zip(&result.leakage) {
            c[0] += b.re * b.re;
            c[1] += b.re * b.im;
            c[2] += b.im * b.im;
        }
        Ok(result)
    }
}

/// Regression with errors in both variables, the ratio of their variances known.
fn in_both(gxx: f64, gyy: f64, gxy: Complex64, ratio: f64, k: f64) -> (Complex64, f64) {
    let scale = ratio.sqrt();
    let (syy, sxy) = (gyy / ratio, gxy / scale);
    let difference = syy - gxx;
    let root = (difference * difference + 4.0 * sxy.norm_sqr()).sqrt();
    // The larger of two equal forms, so that nothing cancels.
    let h = if difference >= 0.0 {
        (difference + root) / (2.0 * sxy.conj())
    } else {
        2.0 * sxy / (root - difference)
    };
    let unbiased = if k.is_finite() { k / (k - 1.0) } else { 1.0 };
    let least = 0.5 * (gxx + syy - root).max(0.0) * unbiased;
    let signal = (gxx - least).max(f64::MIN_POSITIVE);
    let both = least * (1.0 + h.norm_sqr());
    let variance = ((signal + least) * both - h.norm_sqr() * least * least).max(0.0)
        / ((k - 1.0) * signal * signal);
    (h * scale, variance * ratio)
}

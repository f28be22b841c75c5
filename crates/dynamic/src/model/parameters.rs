//! The parameters of a model with their covariance, as far as they act on a response.

use super::response::{ModelStructure, TransducerModel};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{Covariance, Estimate};

/// What its parameters leave open of a model: models a step to either side of each, and their covariance.
pub(crate) struct Device {
    pub(crate) shifted: Vec<[TransducerModel; 2]>,
    pub(crate) covariance: Covariance,
}

/// Step of the derivative, in the parameters' natural units of order one.
pub(crate) const STEP: f64 = 1e-5;

impl Device {
    pub(crate) fn new(
        model: &TransducerModel,
        structure: &ModelStructure,
        estimate: &Estimate,
        time: f64,
    ) -> Result<Self, Error> {
        let vector = model.to_vector(structure, time);
        let named = model.named(structure, "", time);
        let p = vector.len();
        let indices: Vec<usize> = named
            .iter()
            .map(|(name, ..)| {
                estimate.index_of(name).ok_or(Error::Length {
                    name: "parameters of the estimate",
                    expected: p,
                    got: estimate.components().len(),
                })
            })
            .collect::<Result<_, _>>()?;
        let mut rows = vec![0.0; p * p];
        for a in 0..p {
            for b in 0..p {
                // From parameters to natural units.
                rows[a * p + b] =
                    estimate.covariance()[(indices[a], indices[b])] / (named[a].3 * named[b].3);
            }
        }
        let sign = model.sensitivity.signum();
        let shifted = (0..p)
            .map(|j| {
                [-STEP, STEP].map(|h| {
                    let mut v = vector.clone();
                    v[j] += h;
                    TransducerModel::from_vector(&v, structure, sign, time)
                })
            })
            .collect();
        Ok(Self {
            shifted,
            covariance: Covariance::try_from_rows(p, &rows)?,
        })
    }

    /// Covariance rr, ri, ii of the response at a frequency.
    pub(super) fn covariance_of(&self, f: f64) -> [f64; 3] {
        let slopes: Vec<Complex64> = self
            .shifted
            .iter()
            .map(|[low, high]| (high.response(f) - low.response(f)) / (2.0 * STEP))
            .collect();
        let mut sum = [0.0; 3];
        for (a, p) in slopes.iter().enumerate() {
            for (b, q) in slopes.iter().enumerate() {
                let c = self.covariance[(a, b)];
                sum[0] += c * p.re * q.re;
                sum[1] += c * p.re * q.im;
                sum[2] += c * p.im * q.im;
            }
        }
        sum
    }
}

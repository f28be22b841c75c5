//! How uncertain a compensated reading is, in any direction of the sphere.

use super::{BIAS, ELEMENT, MultiPositionFit};
use crate::Triple;
use crate::direction_coverage::spiral;
use serde::{Deserialize, Serialize};

/// The uncertainty of compensated readings under 1 g over all directions, m/s².
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CompensatedReading {
    /// Largest expanded uncertainty along the axis of the error that is worst.
    pub largest: f64,
    /// The direction of the specific force in which it occurs.
    pub worst_direction: Triple,
    /// Median over the sphere of that largest axis.
    pub median: f64,
    /// Smallest.
    pub smallest: f64,
}

/// Directions tried: none is further than 6° from any.
const DIRECTIONS: usize = 500;

impl MultiPositionFit {
    /// Covariance of the compensated reading K⁻¹(ã − b) of an exact output under a specific force a, (m/s²)².
    ///
    /// δa = −K⁻¹(δK a + δb).
    pub fn compensated_covariance(&self, a: Triple) -> [Triple; 3] {
        let estimate = self.estimate();
        let k = self.sensor.k().0;
        let inverse = self.sensor.k_inverse();
        let components = estimate.components();
        let columns: Vec<Triple> = components
            .iter()
            .map(|component| {
                let mut output = [0.0; 3];
                for i in 0..3 {
                    if component.name == BIAS[i] {
                        output[i] = 1.0;
                    }
                    for l in 0..3 {
                        if component.name != ELEMENT[i][l] {
                            continue;
                        }
                        // K_il = misalignment_il · scale_i: a scale factor moves its whole row.
                        output[i] = if l == i {
                            (0..3).map(|m| k[i][m] / k[i][i] * a[m]).sum()
                        } else {
                            k[i][i] * a[l]
                        };
                    }
                }
                inverse.times(output)
            })
            .collect();
        let covariance = estimate.covariance();
        std::array::from_fn(|r| {
            std::array::from_fn(|s| {
                let mut sum = 0.0;
                for (i, u) in columns.iter().enumerate() {
                    for (j, v) in columns.iter().enumerate() {
                        sum += u[r] * v[s] * covariance[(i, j)];
                    }
                }
                sum
            })
        })
    }

    /// Expanded uncertainty of a compensated reading under 1 g in a direction, along its worst axis, m/s².
    pub fn expanded_at(&self, direction: Triple) -> Option<f64> {
        let a = crate::direction_coverage::unit(direction)?.map(|u| u * self.gravity.value());
        let covariance = self.compensated_covariance(a);
        let factor = self
            .quantities
            .iter()
            .map(|q| q.coverage_factor(self.probability))
            .fold(0.0, f64::max);
        let variance = (0..3).map(|i| covariance[i][i]).fold(0.0, f64::max);
        Some(factor * variance.sqrt())
    }

    /// Over the whole sphere.
    pub fn compensated_reading(&self) -> CompensatedReading {
        let mut all: Vec<(f64, Triple)> = spiral(DIRECTIONS)
            .filter_map(|d| Some((self.expanded_at(d)?, d)))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let at = |i: usize| all.get(i).copied().unwrap_or((0.0, [0.0, 0.0, 1.0]));
        let (largest, worst_direction) = at(all.len().saturating_sub(1));
        CompensatedReading {
            largest,
            worst_direction,
            median: at(all.len() / 2).0,
            smallest: at(0).0,
        }
    }
}

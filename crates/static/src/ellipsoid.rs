//! Ellipsoid and sphere through a cloud of mean outputs: direct algebraic fits, where geometric ones start.

use crate::Triple;
use faer::Mat;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::{cholesky, least_squares, symmetric_eigen, thin_svd};

/// The surface on which all outputs of a resting sensor lie: centre b and symmetric shape matrix.
///
/// Points m satisfy ‖P (m − b)‖ = 1 with P symmetric positive definite; P⁻¹ has the semi-axes as eigenvalues.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ellipsoid {
    /// Centre, output units.
    pub centre: Triple,
    /// P⁻¹: symmetric, semi-axes as eigenvalues, output units.
    pub shape: [Triple; 3],
}

impl Ellipsoid {
    /// Direct least squares on the quadric x² + y² + z² + c₁(x² + y² − 2z²) + … = 0, in centred coordinates.
    ///
    /// Linear, without a start value. The algebraic distance weighs points unevenly, so this is a start for
    /// [`MultiPosition`](crate::MultiPosition), which refines it to the geometric distance with covariance.
    ///
    /// **Source** `[LiGriffiths2004]`, parametrised after `[Turner1999]` so that no scaling constraint is needed.
    ///
    /// # Errors
    /// [`Error::TooFew`] below nine points; [`Error::NotPositiveDefinite`] when the quadric is no ellipsoid.
    pub fn algebraic(points: &[Triple]) -> Result<Self, Error> {
        if points.len() < 9 {
            return Err(Error::TooFew {
                name: "standstills",
                needed: 9,
                got: points.len(),
            });
        }
        let (pedestal, scale) = centroid_and_spread(points)?;
        let rows: Vec<Triple> = points
            .iter()
            .map(|p| std::array::from_fn(|i| (p[i] - pedestal[i]) / scale))
            .collect();
        let design = Mat::from_fn(rows.len(), 9, |i, j| {
            let [x, y, z] = rows[i];
            match j {
                0 => x * x + y * y - 2.0 * z * z,
                1 => x * x + z * z - 2.0 * y * y,
                2 => 2.0 * x * y,
                3 => 2.0 * x * z,
                4 => 2.0 * y * z,
                5 => 2.0 * x,
                6 => 2.0 * y,
                7 => 2.0 * z,
                _ => 1.0,
            }
        });
        let target = Mat::from_fn(rows.len(), 1, |i, _| {
            let [x, y, z] = rows[i];
            x * x + y * y + z * z
        });
        let c = least_squares(&design, &target);
        let c = |i: usize| c[(i, 0)];
        // (1 − c₀ − c₁) x² + (1 − c₀ + 2c₁) y² + (1 + 2c₀ − c₁) z² − 2c₂xy − … = c₈ + 2c₅x + …
        let a = Mat::from_fn(3, 3, |i, j| match (i.min(j), i.max(j)) {
            (0, 0) => 1.0 - c(0) - c(1),
            (1, 1) => 1.0 - c(0) + 2.0 * c(1),
            (2, 2) => 1.0 + 2.0 * c(0) - c(1),
            (0, 1) => -c(2),
            (0, 2) => -c(3),
            _ => -c(4),
        });
        let no_ellipsoid = |value| Error::NotPositiveDefinite {
            name: "quadric through the standstills",
            row: 0,
            column: 0,
            value,
        };
        let llt = cholesky(&a).map_err(|_| no_ellipsoid(a[(0, 0)]))?;
        let centre = llt.solve(&Mat::from_fn(3, 1, |i, _| c(5 + i)));
        let centred: Triple = std::array::from_fn(|i| centre[(i, 0)]);
        let level = c(8) + (0..3).map(|i| c(5 + i) * centred[i]).sum::<f64>();
        if !(level > 0.0 && level.is_finite()) {
            return Err(no_ellipsoid(level));
        }
        // A/level = P²; P⁻¹ by eigenvalues.
        let eigen =
            symmetric_eigen(&a, "eigenvalues of the ellipsoid").map_err(|_| no_ellipsoid(0.0))?;
        let shape = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                (0..3)
                    .map(|k| {
                        eigen.U()[(i, k)]
                            * eigen.U()[(j, k)]
                            * (level / eigen.S()[k]).sqrt()
                            * scale
                    })
                    .sum()
            })
        });
        Ok(Self {
            centre: std::array::from_fn(|i| pedestal[i] + scale * centred[i]),
            shape,
        })
    }

    /// The sphere nearest to the points; what they do not determine is taken through their centroid.
    ///
    /// Singular directions (all points in a plane, fewer than four points) are left out by singular values, so
    /// there is always an answer to judge directions by, not to calibrate with.
    ///
    /// # Errors
    /// [`Error::TooFew`] for less than two points or points that all coincide.
    pub fn sphere(points: &[Triple]) -> Result<Self, Error> {
        let (pedestal, scale) = centroid_and_spread(points)?;
        let rows: Vec<Triple> = points
            .iter()
            .map(|p| std::array::from_fn(|i| (p[i] - pedestal[i]) / scale))
            .collect();
        let square = |r: &Triple| r.iter().map(|v| v * v).sum::<f64>();
        let mean_square = rows.iter().map(square).sum::<f64>() / rows.len() as f64;
        let design = Mat::from_fn(rows.len(), 3, |i, j| 2.0 * rows[i][j]);
        let svd = thin_svd(&design, "singular values")?;
        let (u, s, v) = (svd.U(), svd.S(), svd.V());
        let mut centre = [0.0; 3];
        for k in 0..s.dim() {
            if s[k] > 0.05 * s[0] {
                let projection: f64 = rows
                    .iter()
                    .enumerate()
                    .map(|(i, r)| u[(i, k)] * (square(r) - mean_square))
                    .sum();
                for (axis, c) in centre.iter_mut().enumerate() {
                    *c += v[(axis, k)] * projection / s[k];
                }
            }
        }
        let radius = scale * (mean_square + square(&centre)).sqrt();
        let mut shape = [[0.0; 3]; 3];
        for (i, row) in shape.iter_mut().enumerate() {
            row[i] = radius;
        }
        Ok(Self {
            centre: std::array::from_fn(|i| pedestal[i] + scale * centre[i]),
            shape,
        })
    }

    /// Mean of the semi-axes along x, y and z, output units.
    pub fn radius(&self) -> f64 {
        (self.shape[0][0] + self.shape[1][1] + self.shape[2][2]) / 3.0
    }
}

fn centroid_and_spread(points: &[Triple]) -> Result<(Triple, f64), Error> {
    let n = points.len().max(1) as f64;
    let centroid: Triple = std::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / n);
    let spread = points
        .iter()
        .map(|p| (0..3).map(|i| (p[i] - centroid[i]).powi(2)).sum::<f64>())
        .sum::<f64>()
        / n;
    if !(spread > 0.0 && spread.is_finite()) {
        return Err(Error::TooFew {
            name: "distinct attitudes",
            needed: 2,
            got: usize::from(!points.is_empty()),
        });
    }
    Ok((centroid, spread.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> Vec<Triple> {
        let mut list = Vec::new();
        for x in [-1.0f64, 0.0, 1.0] {
            for y in [-1.0, 0.0, 1.0] {
                for z in [-1.0, 0.0, 1.0] {
                    let norm = (x * x + y * y + z * z).sqrt();
                    if norm > 0.0 {
                        list.push([x / norm, y / norm, z / norm]);
                    }
                }
            }
        }
        list
    }

    #[test]
    fn law_algebraic_fit_is_exact_on_an_exact_ellipsoid() {
        let shape = [
            [4070.0, 12.0, -8.0],
            [12.0, 4040.0, 5.0],
            [-8.0, 5.0, 4075.0],
        ];
        let centre = [33123.0, 33276.0, 32360.0];
        let points: Vec<Triple> = directions()
            .iter()
            .map(|d| {
                std::array::from_fn(|i| centre[i] + (0..3).map(|j| shape[i][j] * d[j]).sum::<f64>())
            })
            .collect();
        let fit = Ellipsoid::algebraic(&points).unwrap();
        for i in 0..3 {
            // 3e4 counts at ε, amplified by the condition of the nine-column design (below 100).
            assert!((fit.centre[i] - centre[i]).abs() < 1e-8);
            for j in 0..3 {
                assert!((fit.shape[i][j] - shape[i][j]).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn law_sphere_of_a_plane_keeps_the_plane() {
        let points = [
            [5.0, 1.0, 2.0],
            [3.0, 1.0, 2.0],
            [4.0, 2.0, 2.0],
            [4.0, 0.0, 2.0],
        ];
        let sphere = Ellipsoid::sphere(&points).unwrap();
        assert!((sphere.radius() - 1.0).abs() < 1e-12);
        for (got, expected) in sphere.centre.iter().zip([4.0, 1.0, 2.0]) {
            assert!((got - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn refuses_few_points_and_one_point() {
        assert!(matches!(
            Ellipsoid::algebraic(&[[1.0; 3]; 8]),
            Err(Error::TooFew { .. })
        ));
        assert!(matches!(
            Ellipsoid::sphere(&[[1.0; 3]; 5]),
            Err(Error::TooFew { .. })
        ));
    }
}

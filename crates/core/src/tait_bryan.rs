//! The frame of a sensor in the frame of the machine or vehicle that carries it.

use crate::{Error, Float, Matrix3};

/// Roll φ, pitch θ and yaw ψ that turn the frame of a machine into that of a sensor on it.
///
/// The frame of the machine is turned about its z axis by yaw, about its new y axis by pitch, and about its new x axis by roll, each
/// right-handed; then it is that of the sensor. With the axes of ISO 8855 (x forward, y to the left, z up) these are the angles of that
/// standard. A vector that the sensor has by components is in the frame of the machine
///
/// ```text
/// a_machine = R a_sensor,   R = R_z(ψ) R_y(θ) R_x(φ)
/// ```
///
/// **Units** rad. **Source** `[ISO8855]`, axes and angles.
///
/// ```
/// use proofmass_core::TaitBryan;
/// // A sensor that stands upright on its back edge: pitched up by 90°, it has its own x axis along the vertical of the machine.
/// let mounting = TaitBryan::new(0.0, -90f64.to_radians(), 0.0)?;
/// let a = mounting.matrix::<f64>().times([9.8, 0.0, 0.0]);
/// assert!(a[0].abs() < 1e-15 && (a[2] - 9.8).abs() < 1e-14);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias("Euler angles", "mounting angles", "alignment"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaitBryan {
    roll: f64,
    pitch: f64,
    yaw: f64,
}

impl TaitBryan {
    /// From roll, pitch and yaw in rad.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for more than a turn, which is no angle in radians that anybody means.
    pub fn new(roll: f64, pitch: f64, yaw: f64) -> Result<Self, Error> {
        for (index, value) in [roll, pitch, yaw].into_iter().enumerate() {
            if !value.is_finite() {
                return Err(Error::NotFinite {
                    name: "angles of a rotation",
                    index,
                });
            }
            let turn = core::f64::consts::TAU;
            if !(-turn..=turn).contains(&value) {
                return Err(Error::OutOfRange {
                    name: "angle of a rotation, rad",
                    value,
                    min: -turn,
                    max: turn,
                });
            }
        }
        Ok(Self { roll, pitch, yaw })
    }

    /// The angles of a rotation R from the frame of the sensor to that of the machine; pitched up or down by 90° roll and yaw are one turn, of
    /// which yaw has what is left of rounding.
    pub fn of_matrix(r: &Matrix3<f64>) -> Self {
        let r = &r.0;
        Self {
            roll: libm::atan2(r[2][1], r[2][2]),
            pitch: libm::asin((-r[2][0]).clamp(-1.0, 1.0)),
            yaw: libm::atan2(r[1][0], r[0][0]),
        }
    }

    /// Roll, pitch and yaw, rad.
    pub fn angles(&self) -> [f64; 3] {
        [self.roll, self.pitch, self.yaw]
    }

    /// R, from the frame of the sensor to that of the machine.
    pub fn matrix<F: Float>(&self) -> Matrix3<F> {
        let (sr, cr) = (libm::sin(self.roll), libm::cos(self.roll));
        let (sp, cp) = (libm::sin(self.pitch), libm::cos(self.pitch));
        let (sy, cy) = (libm::sin(self.yaw), libm::cos(self.yaw));
        Matrix3([
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ])
        .cast()
    }

    /// Largest standard uncertainty of a component of R a over |a|, for any direction of both, from the standard uncertainties of roll,
    /// pitch and yaw in rad.
    ///
    /// A small error of the angles turns by δ = ψ' z + θ' y' + φ' x'' about the axes of the three turns, and moves a vector by δ × a:
    /// at most the square root of the largest eigenvalue of the covariance of δ. The axis of pitch is perpendicular to both others, whose
    /// scalar product is −sin θ.
    ///
    /// **Assumes** angles without correlation.
    pub fn largest_uncertainty(&self, [roll, pitch, yaw]: [f64; 3]) -> f64 {
        let (r, p, y) = (roll * roll, pitch * pitch, yaw * yaw);
        let s = libm::sin(self.pitch);
        let both = 0.5 * (r + y + libm::sqrt((r - y) * (r - y) + 4.0 * r * y * s * s));
        libm::sqrt(if both > p { both } else { p })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angles() -> TaitBryan {
        TaitBryan::new(0.3, -0.7, 2.0).unwrap()
    }

    /// Three turns one after the other, as the definition says them.
    #[test]
    fn law_matrix_is_the_product_of_three_turns() {
        let (s, c) = (f64::sin, f64::cos);
        let x = |t| Matrix3([[1.0, 0.0, 0.0], [0.0, c(t), -s(t)], [0.0, s(t), c(t)]]);
        let y = |t| Matrix3([[c(t), 0.0, s(t)], [0.0, 1.0, 0.0], [-s(t), 0.0, c(t)]]);
        let z = |t| Matrix3([[c(t), -s(t), 0.0], [s(t), c(t), 0.0], [0.0, 0.0, 1.0]]);
        let product = z(2.0).product(&y(-0.7)).product(&x(0.3));
        let r: Matrix3<f64> = angles().matrix();
        let one = r.product(&r.transpose());
        for i in 0..3 {
            for j in 0..3 {
                // Products of three numbers up to one, two sums: a few roundings.
                assert!((r.0[i][j] - product.0[i][j]).abs() < 8.0 * f64::EPSILON);
                let unit = if i == j { 1.0 } else { 0.0 };
                assert!((one.0[i][j] - unit).abs() < 8.0 * f64::EPSILON);
            }
        }
    }

    #[test]
    fn law_angles_come_back_from_the_matrix() {
        let back = TaitBryan::of_matrix(&angles().matrix()).angles();
        for (found, stated) in back.into_iter().zip([0.3, -0.7, 2.0]) {
            assert!((found - stated).abs() < 4.0 * f64::EPSILON, "{found}");
        }
    }

    /// Each turn by itself carries an axis to where a right hand says.
    #[test]
    fn known_quarter_turns() {
        let quarter = core::f64::consts::FRAC_PI_2;
        let turned = |roll, pitch, yaw, v| {
            let r: Matrix3<f64> = TaitBryan::new(roll, pitch, yaw).unwrap().matrix();
            r.times(v).map(f64::round)
        };
        assert_eq!(turned(quarter, 0.0, 0.0, [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(turned(0.0, quarter, 0.0, [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
        assert_eq!(turned(0.0, 0.0, quarter, [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
    }

    /// The stated uncertainty is what the worst of many directions shows by differences.
    #[test]
    fn crosscheck_largest_uncertainty_by_differences() {
        let u = [2e-3, 1e-3, 3e-3];
        for pitch in [0.0, -0.7, 1.5] {
            let at = |d: [f64; 3]| -> Matrix3<f64> {
                TaitBryan::new(0.3 + d[0], pitch + d[1], 2.0 + d[2])
                    .unwrap()
                    .matrix()
            };
            let step = 1e-6;
            let mut derivatives = [Matrix3([[0.0; 3]; 3]); 3];
            for (k, derivative) in derivatives.iter_mut().enumerate() {
                let mut d = [0.0; 3];
                d[k] = step;
                let (up, down) = (at(d), at(d.map(|v| -v)));
                for i in 0..3 {
                    for j in 0..3 {
                        derivative.0[i][j] = (up.0[i][j] - down.0[i][j]) / (2.0 * step);
                    }
                }
            }
            let unit = |i: usize, n: usize| {
                let (t, p) = (
                    core::f64::consts::PI * (i as f64 + 0.5) / n as f64,
                    core::f64::consts::TAU * (0.618_034 * i as f64),
                );
                [t.sin() * p.cos(), t.sin() * p.sin(), t.cos()]
            };
            let mut worst = 0.0f64;
            for i in 0..300 {
                let a = unit(i, 300);
                // The worst direction to look in lies along the change itself: the largest eigenvalue, by trying directions.
                for j in 0..300 {
                    let n = unit(j, 300);
                    let variance: f64 = (0..3)
                        .map(|k| (u[k] * crate::dot(derivatives[k].times(a), n)).powi(2))
                        .sum();
                    worst = worst.max(variance.sqrt());
                }
            }
            let stated = TaitBryan::new(0.3, pitch, 2.0)
                .unwrap()
                .largest_uncertainty(u);
            // Three hundred directions of each lie within 0.1 rad of the worst: 1 % below at most for either.
            assert!(
                worst <= stated * (1.0 + 1e-6) && worst > 0.97 * stated,
                "{pitch}: {worst} {stated}"
            );
        }
    }

    #[test]
    fn refuses_angles_that_are_none() {
        assert!(matches!(
            TaitBryan::new(0.0, f64::NAN, 0.0),
            Err(Error::NotFinite { index: 1, .. })
        ));
        assert!(TaitBryan::new(90.0, 0.0, 0.0).is_err());
    }
}

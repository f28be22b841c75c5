//! Frames of the bench and directions seen by the device.

/// How the device is mounted: the inclination of its wedge and its rotation on the wedge face, in radians.
///
/// Bench frame (right-handed): z′ up along the excitation, x′ horizontal in the plane of inclination, y′ across
/// it. A positive inclination α tips the wedge face about y′; a positive rotation ω turns the device about its
/// own z. What the device sees of a motion e = (x′, y′, z′) of the table is R e with
///
/// ```text
///         ⎡ cos α cos ω   −sin ω   sin α cos ω ⎤
/// R =     ⎢ cos α sin ω    cos ω   sin α sin ω ⎥   =   R_z(ω) R_y(α)
///         ⎣   −sin α         0        cos α    ⎦
/// ```
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Configuration {
    /// Inclination α in radians.
    pub inclination: f64,
    /// Rotation ω in radians.
    pub rotation: f64,
}

impl Configuration {
    /// From angles in degrees, as plans are written.
    ///
    /// ```
    /// use proofmass_calibration::shaker::Configuration;
    /// let d = Configuration::degrees(90.0, 90.0).direction();
    /// assert!((d[1] - 1.0).abs() < 1e-15); // the table moves the device along its y
    /// ```
    pub fn degrees(inclination: f64, rotation: f64) -> Self {
        Self {
            inclination: inclination.to_radians(),
            rotation: rotation.to_radians(),
        }
    }

    /// The rotation matrix R, rows x, y, z of the device.
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        let ((sa, ca), (sw, cw)) = (self.inclination.sin_cos(), self.rotation.sin_cos());
        [
            [ca * cw, -sw, sa * cw],
            [ca * sw, cw, sa * sw],
            [-sa, 0.0, ca],
        ]
    }

    /// ∂R/∂α.
    pub fn inclination_derivative(&self) -> [[f64; 3]; 3] {
        let ((sa, ca), (sw, cw)) = (self.inclination.sin_cos(), self.rotation.sin_cos());
        [
            [-sa * cw, 0.0, ca * cw],
            [-sa * sw, 0.0, ca * sw],
            [-ca, 0.0, -sa],
        ]
    }

    /// ∂R/∂ω.
    pub fn rotation_derivative(&self) -> [[f64; 3]; 3] {
        let ((sa, ca), (sw, cw)) = (self.inclination.sin_cos(), self.rotation.sin_cos());
        [
            [-ca * sw, -cw, -sa * sw],
            [ca * cw, -sw, sa * cw],
            [0.0, 0.0, 0.0],
        ]
    }

    /// Signed direction of the excitation z′ in the device frame: (sin α cos ω, sin α sin ω, cos α).
    pub fn direction(&self) -> [f64; 3] {
        let m = self.matrix();
        [m[0][2], m[1][2], m[2][2]]
    }

    /// The same configuration within 1e-6 rad, rotations taken modulo a full turn.
    pub fn same_as(&self, other: &Self) -> bool {
        let turn = std::f64::consts::TAU;
        let rotation = (self.rotation - other.rotation).rem_euclid(turn);
        (self.inclination - other.inclination).abs() < 1e-6 && rotation.min(turn - rotation) < 1e-6
    }
}

/// The published 44 configurations: eight rotations on wedges of 15, 35, 55, 75 and 90°, four on the bare table.
///
/// **Source** `[Murgia2022]` 3.1.
pub fn published_plan() -> Vec<Configuration> {
    let mut plan: Vec<_> = (0..4)
        .map(|i| Configuration::degrees(0.0, 90.0 * f64::from(i)))
        .collect();
    for inclination in [15.0, 35.0, 55.0, 75.0, 90.0] {
        plan.extend((0..8).map(|i| Configuration::degrees(inclination, 45.0 * f64::from(i))));
    }
    plan
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_the_frame_is_right_handed_and_orthonormal() {
        for c in published_plan() {
            let r = c.matrix();
            for i in 0..3 {
                for j in 0..3 {
                    let dot: f64 = (0..3).map(|k| r[i][k] * r[j][k]).sum();
                    assert!((dot - f64::from(i == j)).abs() < 1e-15);
                }
            }
            let cross = [
                r[0][1] * r[1][2] - r[0][2] * r[1][1],
                r[0][2] * r[1][0] - r[0][0] * r[1][2],
                r[0][0] * r[1][1] - r[0][1] * r[1][0],
            ];
            for k in 0..3 {
                assert!((cross[k] - r[2][k]).abs() < 1e-15, "x × y = z");
            }
        }
    }

    #[test]
    fn law_directions_are_signed() {
        let d = |a, w| Configuration::degrees(a, w).direction();
        let close = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-15);
        assert!(close(d(0.0, 90.0), [0.0, 0.0, 1.0]));
        assert!(close(d(90.0, 0.0), [1.0, 0.0, 0.0]));
        assert!(close(d(90.0, 180.0), [-1.0, 0.0, 0.0]));
        assert!(close(d(90.0, 270.0), [0.0, -1.0, 0.0]));
        // On the flat table a horizontal motion along x′ is along the device's x, and along y after a quarter turn.
        let flat = Configuration::degrees(0.0, 90.0).matrix();
        assert!((flat[1][0] - 1.0).abs() < 1e-15 && (flat[0][1] + 1.0).abs() < 1e-15);
    }

    #[test]
    fn law_derivatives_are_differences() {
        let h = 1e-6;
        for c in published_plan() {
            let shifted = |da: f64, dw: f64| {
                Configuration {
                    inclination: c.inclination + da,
                    rotation: c.rotation + dw,
                }
                .matrix()
            };
            for i in 0..3 {
                for j in 0..3 {
                    let da = (shifted(h, 0.0)[i][j] - shifted(-h, 0.0)[i][j]) / (2.0 * h);
                    let dw = (shifted(0.0, h)[i][j] - shifted(0.0, -h)[i][j]) / (2.0 * h);
                    assert!((c.inclination_derivative()[i][j] - da).abs() < 1e-9);
                    assert!((c.rotation_derivative()[i][j] - dw).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn published_the_plan_has_44_configurations() {
        let plan = published_plan();
        assert_eq!(plan.len(), 44);
        assert!(plan[8].same_as(&Configuration::degrees(15.0, 180.0)));
        assert!(plan[43].same_as(&Configuration::degrees(90.0, -45.0)));
    }
}

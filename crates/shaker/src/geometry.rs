//! Frames of the bench and directions seen by the device.

use super::budget::Acts;

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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// use proofmass_shaker::Configuration;
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

/// A configuration with everything by which it is not what the drawing says.
///
/// What the device sees of a motion e of the table is M e with
///
/// ```text
/// M = exp(−[θ]×) R_z(ω) R_y(α) Q(ℓ)
/// ```
///
/// ℓ is the lateral lean of the wedge, a turn of its face about x′ (positive when the +y′ side climbs); θ = (θ_x, θ_y, 0)
/// the rotation vector of the device in its adhesive (θ_x: the +y side climbs off the face, θ_y: the +x side sinks).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seat {
    pub(crate) configuration: Configuration,
    pub(crate) lean: f64,
    pub(crate) tilt: [f64; 2],
}

type Rotation = [[f64; 3]; 3];

fn times(a: &Rotation, b: &Rotation) -> Rotation {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// exp(−[θ]×) for θ = (x, y, 0).
pub(crate) fn tilted([x, y]: [f64; 2]) -> Rotation {
    let t = x.hypot(y);
    // Below this the series agree to rounding.
    let (a, b) = if t < 1e-4 {
        (1.0 - t * t / 6.0, 0.5 - t * t / 24.0)
    } else {
        (t.sin() / t, (1.0 - t.cos()) / (t * t))
    };
    [
        [1.0 - b * y * y, b * x * y, -a * y],
        [b * x * y, 1.0 - b * x * x, a * x],
        [a * y, -a * x, 1.0 - b * t * t],
    ]
}

impl Seat {
    /// As drawn.
    pub(crate) fn drawn(configuration: Configuration) -> Self {
        Self {
            configuration,
            lean: 0.0,
            tilt: [0.0; 2],
        }
    }

    fn between(&self, wedge: &Rotation, lean: &Rotation) -> Rotation {
        times(&tilted(self.tilt), &times(wedge, lean))
    }

    fn leaning(&self) -> Rotation {
        let (s, c) = self.lean.sin_cos();
        [[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]
    }

    /// M.
    pub(crate) fn matrix(&self) -> Rotation {
        self.between(&self.configuration.matrix(), &self.leaning())
    }

    /// ∂M by an angle; `part` is the axis of a tilt, 0 for x and 1 for y, to first order in it.
    pub(crate) fn derivative(&self, acts: Acts, part: usize) -> Rotation {
        match acts {
            Acts::Inclination => self.between(
                &self.configuration.inclination_derivative(),
                &self.leaning(),
            ),
            Acts::Rotation => {
                self.between(&self.configuration.rotation_derivative(), &self.leaning())
            }
            Acts::Lean => {
                let (s, c) = self.lean.sin_cos();
                let turn = [[0.0; 3], [0.0, -s, c], [0.0, -c, -s]];
                self.between(&self.configuration.matrix(), &turn)
            }
            Acts::Tilt => {
                // d × e_x = (0, d_z, −d_y), d × e_y = (−d_z, 0, d_x), for every column.
                let [x, y, z] = self.matrix();
                let minus = |v: [f64; 3]| v.map(|v| -v);
                if part == 0 {
                    [[0.0; 3], z, minus(y)]
                } else {
                    [minus(z), [0.0; 3], x]
                }
            }
            _ => [[0.0; 3]; 3],
        }
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
    fn crosscheck_the_complete_seat() {
        let degrees = |v: f64| v.to_radians();
        let seat = Seat {
            configuration: Configuration::degrees(35.1, 46.0),
            lean: degrees(0.3),
            tilt: [degrees(0.2), degrees(-0.1)],
        };
        // Axes of a body turned step by step, to six decimals.
        let expected = [
            [0.567328, -0.721430, 0.397086],
            [0.586515, 0.692466, 0.420108],
            [-0.578047, -0.005442, 0.815985],
        ];
        let m = seat.matrix();
        for i in 0..3 {
            for j in 0..3 {
                assert!((m[i][j] - expected[i][j]).abs() < 6e-7, "{m:?}");
            }
        }
    }

    #[test]
    fn law_derivatives_of_the_seat_are_differences() {
        let seat = Seat {
            configuration: Configuration::degrees(35.0, 45.0),
            lean: 0.004,
            tilt: [0.002, -0.003],
        };
        let h = 1e-6;
        for (acts, part) in [
            (Acts::Inclination, 0),
            (Acts::Rotation, 0),
            (Acts::Lean, 0),
            (Acts::Tilt, 0),
            (Acts::Tilt, 1),
        ] {
            let at = |h: f64| {
                let mut s = seat;
                match acts {
                    Acts::Inclination => s.configuration.inclination += h,
                    Acts::Rotation => s.configuration.rotation += h,
                    Acts::Lean => s.lean += h,
                    _ => s.tilt[part] += h,
                }
                s.matrix()
            };
            let (up, down, d) = (at(h), at(-h), seat.derivative(acts, part));
            for i in 0..3 {
                for j in 0..3 {
                    let difference = (up[i][j] - down[i][j]) / (2.0 * h);
                    // A tilt is differentiated to first order: half its size.
                    let within = if acts == Acts::Tilt { 2.5e-3 } else { 1e-9 };
                    assert!((difference - d[i][j]).abs() < within, "{acts:?} {part}");
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

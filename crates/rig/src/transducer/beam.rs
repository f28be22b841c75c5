//! Beams that carry a proof mass, bend under it and are stretched by it.

use proofmass_core::{Error, check};
use std::f64::consts::{PI, TAU};

/// A straight beam of rectangular cross-section after Euler and Bernoulli.
///
/// **Units** SI. **Assumes** small displacements, and a beam slender enough that shear does not matter.
/// **Source** `[TimoshenkoGoodier1970]`, `[Bao2005]` ch. 2.
///
/// ```
/// use proofmass_rig::Beam;
/// let beam = Beam { length: 1e-3, width: 2e-4, thickness: 2e-5, young: 169e9, density: 2330.0 };
/// // 3EI/L³ with I = b h³/12.
/// assert!((beam.cantilever() / 67.6 - 1.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// L, m.
    pub length: f64,
    /// b, m.
    pub width: f64,
    /// h, along the bending, m.
    pub thickness: f64,
    /// E, Pa.
    pub young: f64,
    /// ρ, kg/m³.
    pub density: f64,
}

/// A rigid plate behind the end of a cantilever, moved by a force at its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TipPlate {
    /// Stiffness at the centre of the plate, N/m.
    pub stiffness: f64,
    /// Rotation per displacement of the centre, rad/m.
    pub turn: f64,
}

impl Beam {
    /// Refuses what is not positive.
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn check(&self) -> Result<(), Error> {
        check::positive("length of the beam", self.length)?;
        check::positive("width of the beam", self.width)?;
        check::positive("thickness of the beam", self.thickness)?;
        check::positive("Young's modulus of the beam", self.young)?;
        check::positive("density of the beam", self.density)?;
        Ok(())
    }

    /// EI, N·m².
    fn rigidity(&self) -> f64 {
        self.young * self.width * self.thickness.powi(3) / 12.0
    }

    /// ρ b h L, kg.
    pub fn mass(&self) -> f64 {
        self.density * self.width * self.thickness * self.length
    }

    /// Stiffness at the end of a cantilever, 3EI/L³, N/m; 33/140 of its mass moves with the end.
    pub fn cantilever(&self) -> f64 {
        3.0 * self.rigidity() / self.length.powi(3)
    }

    /// Strain of the surface of a cantilever at a distance from its root, per displacement of its end: 3h(L − s)/(2L³), 1/m.
    pub fn cantilever_strain(&self, from_root: f64) -> f64 {
        1.5 * self.thickness * (self.length - from_root) / self.length.powi(3)
    }

    /// Stiffness across of a beam whose other end is guided, 12EI/L³, N/m; 13/35 of its mass moves with that end.
    pub fn guided(&self) -> f64 {
        12.0 * self.rigidity() / self.length.powi(3)
    }

    /// Strain of the surface of a guided beam at a distance from its root, per displacement of its end: 3h(L − 2s)/L³, 1/m.
    pub fn guided_strain(&self, from_root: f64) -> f64 {
        3.0 * self.thickness * (self.length - 2.0 * from_root) / self.length.powi(3)
    }

    /// A rigid plate of this length behind the end: with s half of it, 1/k = L³/3EI + sL²/EI + s²L/EI, and the end turns by
    /// (L²/2 + sL)/EI for a force of one.
    pub fn tip_plate(&self, plate: f64) -> TipPlate {
        let (l, s, ei) = (self.length, 0.5 * plate, self.rigidity());
        let flexibility = (l.powi(3) / 3.0 + s * l * l + s * s * l) / ei;
        TipPlate {
            stiffness: 1.0 / flexibility,
            turn: (0.5 * l * l + s * l) / ei / flexibility,
        }
    }

    /// First natural frequency of a beam clamped at both ends, Hz: (4.7300²/2πL²) √(EI/ρbh).
    pub fn clamped_frequency(&self) -> f64 {
        let density = self.density * self.width * self.thickness;
        4.730_040_745_f64.powi(2) / (TAU * self.length.powi(2)) * (self.rigidity() / density).sqrt()
    }

    /// Relative change of the square of that frequency by an axial force of one: 0.97 L²/(4π²EI), 1/N.
    ///
    /// **Source** `[Bokaian1990]`: 0.97 holds for both ends clamped, within 1 % up to the force that buckles the beam.
    pub fn pull(&self) -> f64 {
        0.97 * self.length.powi(2) / (4.0 * PI.powi(2) * self.rigidity())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEAM: Beam = Beam {
        length: 1e-3,
        width: 2e-4,
        thickness: 2e-5,
        young: 169e9,
        density: 2330.0,
    };

    /// The plate by integrating M(s) = F (L − s + p/2) along the beam.
    #[test]
    fn crosscheck_plate_by_integration() {
        let plate = 6e-4;
        let (ei, n) = (BEAM.young * 2e-4 * 8e-15 / 12.0, 20_000);
        let ds = BEAM.length / f64::from(n);
        let (mut slope, mut end) = (0.0, 0.0);
        for k in 0..n {
            let s = (f64::from(k) + 0.5) * ds;
            let moment = BEAM.length - s + 0.5 * plate;
            slope += moment / ei * ds;
            // Contribution of this bend at the end.
            end += moment / ei * ds * (BEAM.length - s);
        }
        let centre = end + slope * 0.5 * plate;
        let found = BEAM.tip_plate(plate);
        assert!((found.stiffness * centre - 1.0).abs() < 1e-8);
        assert!((found.turn / (slope / centre) - 1.0).abs() < 1e-8);
        let none = BEAM.tip_plate(0.0);
        assert!((none.stiffness / BEAM.cantilever() - 1.0).abs() < 1e-12);
        assert!((none.turn * BEAM.length - 1.5).abs() < 1e-12);
    }

    /// Strain at the root: σ = F L h/(2I), F = k x; it falls to zero at a free end, in the middle of a guided beam.
    #[test]
    fn known_strains() {
        let i = 2e-4 * 8e-15 / 12.0;
        let root = BEAM.cantilever() * BEAM.length * 1e-5 / (BEAM.young * i);
        assert!((BEAM.cantilever_strain(0.0) / root - 1.0).abs() < 1e-12);
        let half = BEAM.guided() * 0.5 * BEAM.length * 1e-5 / (BEAM.young * i);
        assert!((BEAM.guided_strain(0.0) / half - 1.0).abs() < 1e-12);
        assert_eq!(BEAM.cantilever_strain(1e-3), 0.0);
        assert_eq!(BEAM.guided_strain(5e-4), 0.0);
    }
}

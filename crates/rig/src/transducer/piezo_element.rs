//! Piezoelectric discs between a mass and its base.

use super::plates::VACUUM;
use proofmass_core::{Error, check};
use serde::{Deserialize, Serialize};

/// How the mass loads the element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum PiezoCut {
    /// Along its thickness, by d₃₃ and E: elements are stacked.
    Compression,
    /// Along its face, by d₁₅ and G: elements stand around a post and share the force.
    Shear,
}

/// Elements of one kind, electrically in parallel.
///
/// Compression: k = EA/(nt), q = ndF. Shear: k = nGA/t, q = dF. Both: C = n ε₀ε_r A/t.
///
/// **Units** SI. **Source** `[Fraden2016]` ch. 4, 9.
///
/// ```
/// use proofmass_rig::{PiezoCut, PiezoElement};
/// // One disc of PZT, 1 cm² and 1 mm: C = 1.59 nF, k = 6.3 GN/m.
/// let disc = PiezoElement { cut: PiezoCut::Compression, coefficient: 374e-12, area: 1e-4, thickness: 1e-3,
///     permittivity: 1800.0, modulus: 63e9, elements: 1.0 };
/// assert!((disc.capacitance() / 1.5938e-9 - 1.0).abs() < 1e-4);
/// assert!((disc.stiffness() / 6.3e9 - 1.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PiezoElement {
    /// How it is loaded.
    pub cut: PiezoCut,
    /// d, C/N.
    pub coefficient: f64,
    /// A of the electrodes of one, m².
    pub area: f64,
    /// t of one, m.
    pub thickness: f64,
    /// ε_r.
    pub permittivity: f64,
    /// E of a compressed, G of a sheared one, Pa.
    pub modulus: f64,
    /// n.
    pub elements: f64,
}

impl PiezoElement {
    /// Refuses what is not positive.
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn check(&self) -> Result<(), Error> {
        check::positive("charge constant", self.coefficient)?;
        check::positive("area of the element", self.area)?;
        check::positive("thickness of the element", self.thickness)?;
        check::positive("permittivity of the element", self.permittivity)?;
        check::positive("modulus of the element", self.modulus)?;
        check::positive("number of elements", self.elements)?;
        Ok(())
    }

    /// Of all elements, N/m.
    pub fn stiffness(&self) -> f64 {
        let one = self.modulus * self.area / self.thickness;
        match self.cut {
            PiezoCut::Compression => one / self.elements,
            PiezoCut::Shear => one * self.elements,
        }
    }

    /// Of all elements, F.
    pub fn capacitance(&self) -> f64 {
        self.elements * VACUUM * self.permittivity * self.area / self.thickness
    }

    /// Charge of all per force, C/N.
    pub fn charge(&self) -> f64 {
        match self.cut {
            PiezoCut::Compression => self.elements * self.coefficient,
            PiezoCut::Shear => self.coefficient,
        }
    }
}

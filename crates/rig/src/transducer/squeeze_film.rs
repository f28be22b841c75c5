//! Damping by the gas between two plates.

use proofmass_core::{Error, check};
use std::f64::consts::PI;

/// Gas between a moving plate and a fixed one.
///
/// The moving plate presses the gas out at the sides: c = μ a b³/d³ [1 − (192 b/(π⁵ a)) Σ tanh(nπa/2b)/n⁵], n = 1, 3, 5, …, a ≥ b.
///
/// **Units** SI; c in N·s/m.
/// **Assumes** motion small against the gap, edges at the pressure around, no slip, and a gas that is not compressed: well below
/// [`SqueezeFilm::cut_off`].
/// **Source** `[Bao2005]` ch. 3.
///
/// ```
/// use proofmass_rig::SqueezeFilm;
/// // A square plate: c = 0.4217 μ a⁴/d³.
/// let film = SqueezeFilm { length: 1e-3, width: 1e-3, gap: 5e-6, viscosity: 18.5e-6, pressure: 101_325.0 };
/// let square = 18.5e-6 * 1e-12 / 125e-18;
/// assert!((film.damping().unwrap() / square - 0.4217).abs() < 1e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SqueezeFilm {
    /// Of the plate, m.
    pub length: f64,
    /// Of the plate, m.
    pub width: f64,
    /// d, m.
    pub gap: f64,
    /// μ of the gas, Pa·s.
    pub viscosity: f64,
    /// Of the gas around, Pa.
    pub pressure: f64,
}

impl SqueezeFilm {
    /// Refuses what is not positive.
    fn check(&self) -> Result<(), Error> {
        check::positive("length of the plate", self.length)?;
        check::positive("width of the plate", self.width)?;
        check::positive("gap of the film", self.gap)?;
        check::positive("viscosity of the gas", self.viscosity)?;
        check::positive("pressure of the gas", self.pressure)?;
        Ok(())
    }

    /// c, N·s/m.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for what is not positive.
    pub fn damping(&self) -> Result<f64, Error> {
        self.check()?;
        let (a, b) = (self.length.max(self.width), self.length.min(self.width));
        let sum: f64 = (0..40)
            .map(|k| f64::from(2 * k + 1))
            .map(|n| libm::tanh(0.5 * n * PI * a / b) / n.powi(5))
            .sum();
        let form = 1.0 - 192.0 * b / (PI.powi(5) * a) * sum;
        Ok(self.viscosity * a * b.powi(3) / self.gap.powi(3) * form)
    }

    /// The same of plates that slide along each other: c = μ a b/d.
    ///
    /// # Errors
    /// As [`SqueezeFilm::damping`].
    pub fn sliding(&self) -> Result<f64, Error> {
        self.check()?;
        Ok(self.viscosity * self.length * self.width / self.gap)
    }

    /// Frequency at which the gas begins to be compressed and turns into a spring, Hz: π d² p (1/a² + 1/b²)/(24 μ).
    ///
    /// # Errors
    /// As [`SqueezeFilm::damping`].
    pub fn cut_off(&self) -> Result<f64, Error> {
        self.check()?;
        let form = self.length.powi(-2) + self.width.powi(-2);
        Ok(PI * self.gap.powi(2) * self.pressure * form / (24.0 * self.viscosity))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(length: f64, width: f64) -> SqueezeFilm {
        SqueezeFilm {
            length,
            width,
            gap: 2e-6,
            viscosity: 18e-6,
            pressure: 1e5,
        }
    }

    /// A long strip: c = μ a b³/d³ (1 − 0.630 b/a), the torsion constant of a rectangle.
    #[test]
    fn known_strip_and_symmetry() {
        let c = film(1e-3, 1e-4).damping().unwrap();
        let strip = 18e-6 * 1e-3 * 1e-12 / 8e-18;
        assert!((c / strip - (1.0 - 0.630_2 * 0.1)).abs() < 1e-4);
        assert_eq!(c, film(1e-4, 1e-3).damping().unwrap());
        assert!((film(1e-3, 1e-4).sliding().unwrap() / 9e-7 - 1.0).abs() < 1e-12);
    }

    /// A strip: squeeze number 12 μ b² ω/(p d²) of π² where springs and damping are equal.
    #[test]
    fn known_cut_off_of_a_strip() {
        let f = film(1.0, 1e-4).cut_off().unwrap();
        let number = 12.0 * 18e-6 * 1e-8 * 2.0 * PI * f / (1e5 * 4e-12);
        assert!((number / PI.powi(2) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn refuses_a_film_without_gap() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let film = SqueezeFilm {
                gap: bad,
                ..film(1e-3, 1e-3)
            };
            assert!(film.damping().is_err() && film.cut_off().is_err());
        }
    }
}

//! A laser interferometer with quadrature outputs as the reference of a primary calibration.
//!
//! Two photo signals u₁ and u₂ tell the phase φ of the interference, which turns once for every half wavelength that the surface
//! moves: s = λ φ/4π. The ellipse of the two is made a circle ([`Quadrature`]), the phase is followed from sample to sample
//! ([`unwrap`]), and sines are fitted to it and to the output of the sensor ([`SineApproximationMethod`]). Fringe counting
//! ([`count_fringes`]) and the zeros of J₁ ([`minimum_point`]) tell the amplitude in other ways.

mod ellipse;
mod fringe_counting;
mod minimum_point;
mod sine_approximation;
mod unwrapping;

pub use ellipse::{Quadrature, QuadratureFit};
pub use fringe_counting::count_fringes;
pub use minimum_point::minimum_point;
pub use sine_approximation::{
    AmplitudeCheck, CheckMethod, InterferometerRun, SineApproximationMethod,
};
pub use unwrapping::unwrap;

use proofmass_core::Error;

/// Wavelength of the red line of a helium-neon laser in air, m.
pub const HELIUM_NEON: f64 = 632.8e-9;
/// Relative standard uncertainty of that number for a laser of which nothing more is known: vacuum or air, and its three decimals.
pub const HELIUM_NEON_UNCERTAINTY: f64 = 5e-5;

/// Why a recording of an interferometer gives no phase.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Unusable {
    /// A channel (0 or 1) has one value throughout.
    Constant(usize),
    /// The two are no quadrature pair: root mean square of the distance from the circle, relative to its radius.
    NoCircle(f64),
    /// The samples lie on too short a part of the ellipse: degrees that they cover, and the relative standard uncertainty of the
    /// motion that the correction would leave.
    Arc(f64, f64),
    /// The light was lost: number of samples, and the first of them.
    Dropout(usize, usize),
    /// The phase turns too fast for the sampling: largest step, rad, and the factor by which the sampling has to be faster.
    TooFast(f64, f64),
    /// The record is too short: periods in it, and periods that are needed.
    Short(f64, f64),
    /// The mathematics of the fits refused.
    Fit(Error),
}

impl From<Error> for Unusable {
    fn from(error: Error) -> Self {
        Self::Fit(error)
    }
}

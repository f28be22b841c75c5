//! Static tests of an accelerometer: inclination, sensitivity, bias, orthogonality, linearity, centrifuge, stability.

mod centrifuge;
mod departures;
mod drift;
mod harmonics;
mod jump;
mod known_angles;
mod linearity;
mod mounting;
mod orthogonality;
mod readings;
mod recalibration;
mod sensitivity;
mod stability;
mod tilt;
mod zero_g;

pub use centrifuge::Centrifuge;
pub use departures::Departure;
pub use drift::{DatedValue, Drift, DriftQuestion};
pub use harmonics::Harmonic;
pub use jump::Jump;
pub use known_angles::{Counts, KnownAngles};
pub use linearity::Linearity;
pub use mounting::{MountedTurn, Mounting};
pub use orthogonality::Orthogonality;
pub use readings::{CommonError, PolynomialOrder, ReadingResidual, StaticFit};
pub use recalibration::RecalibrationRule;
pub use sensitivity::Sensitivity;
pub use stability::{DatedEstimate, MONTH, Stability, StabilityFit};
pub use tilt::Tilt;
pub use zero_g::ZeroG;

//! Static tests of an accelerometer: inclination, sensitivity, bias, orthogonality, linearity, centrifuge, stability.

mod centrifuge;
mod linearity;
mod orthogonality;
mod readings;
mod sensitivity;
mod stability;
mod tilt;
mod zero_g;

pub use centrifuge::Centrifuge;
pub use linearity::Linearity;
pub use orthogonality::Orthogonality;
pub use readings::{CommonError, PolynomialOrder, ReadingResidual, StaticFit};
pub use sensitivity::Sensitivity;
pub use stability::{DatedEstimate, Drift, MONTH, Stability, StabilityFit};
pub use tilt::Tilt;
pub use zero_g::ZeroG;

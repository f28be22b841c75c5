//! Digital calibration certificates (DCC) with their quantities (D-SI): read in the versions 2.3 to 3.3, written in 3.3.0.
//!
//! The schema sees neither lists of unequal length nor a wrong unit, NaN or a frequency that stands twice; all of these are refused here
//! with element and line.
//!
//! **Source** `[DCC]`, `[DSI]`.

mod head;
mod quantity;
mod sensitivity;
mod uncertainty;
mod unit;

pub use head::DigitalCertificate;
pub use quantity::DccQuantity;
pub use sensitivity::{DccSensitivity, SensitivityRow};
pub use uncertainty::DccUncertainty;
pub use unit::{DsiUnit, dsi_text};

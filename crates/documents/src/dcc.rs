//! Digital calibration certificates (DCC) with their quantities (D-SI): read in the versions 2.3 to 3.3, written in 3.3.0.
//!
//! The schema sees neither lists of unequal length nor a wrong unit, NaN or a frequency that stands twice; all of these are refused here
//! with element and line.
//!
//! **Source** `[DCC]`, `[DSI]`.

mod head;
mod new;
mod quantity;
mod sensitivity;
mod uncertainty;
mod unit;
mod writing;

pub use head::DigitalCertificate;
pub use new::{
    NewAttachment, NewCertificate, NewComplex, NewConformity, NewContact, NewEquipment, NewItem,
    NewMethod, NewNumber, NewQuantity, NewRange, NewResult, NewStatement, NewText,
};
pub use quantity::DccQuantity;
pub use sensitivity::{DccSensitivity, SensitivityRow};
pub use uncertainty::DccUncertainty;
pub use unit::{DsiUnit, dsi_squared, dsi_text};

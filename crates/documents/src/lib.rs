//! Documents of proofmass: what is read whole and written whole.
//!
//! Calibrations and results, certificates of laboratories, models and budgets, coefficients and code for a chip, meshes of finite
//! elements. Recordings, which stream, are the business of [`proofmass_io`], and so is every file that is opened or written here.
//!
//! ```
//! use proofmass_documents::ResultDocument;
//!
//! let bytes = ResultDocument::new("noise").to_json()?;
//! assert_eq!(ResultDocument::from_json(&bytes)?.kind, "noise");
//! # Ok::<(), proofmass_io::Error>(())
//! ```
//!
//! # Conventions
//! - A document of another form or version is refused with the remedy.
//! - Errors are those of [`proofmass_io`]: they name file, line or field.
//!
//! # Not covered
//! The signature inside a certificate is not checked, which a finding says.

mod any_calibration;
mod base64;
mod calibration_file;
mod calibration_memory;
mod dcc;
mod device;
mod export;
mod findings;
mod foreign_coefficients;
mod frequency_response_file;
mod gmsh;
mod imu_yaml;
mod model_file;
mod result_document;
mod trial_file;
mod verification;
mod vtu;
mod xml;

pub use any_calibration::{AnyCalibration, CALIBRATION_SCHEMA, CALIBRATION_VERSION};
pub use base64::base64;
pub use calibration_file::{
    CalibrationFile, CurvatureBlock, EnvironmentBlock, SINGLE_AXIS, TRIAXIAL, ThermalBlock,
};
pub use calibration_memory::{
    MemoryContent, MemoryCurvature, MemoryTemperature, is_calibration_memory,
};
pub use dcc::{
    DccQuantity, DccSensitivity, DccUncertainty, DigitalCertificate, DsiUnit, NewAttachment,
    NewCertificate, NewComplex, NewConformity, NewContact, NewEquipment, NewItem, NewMethod,
    NewNumber, NewQuantity, NewRange, NewResult, NewStatement, NewText, SensitivityRow,
    dsi_squared, dsi_text,
};
pub use device::{Ambient, Device};
pub use export::{
    ExportForm, ExportNumber, ExportOptions, FirmwareBlock, LONGEST_AVERAGE, LowPassBehind,
    SelfCheck, export, export_block, export_chain, export_memory,
};
pub use findings::CATALOGUE;
pub use foreign_coefficients::{CoefficientForm, import_coefficients};
pub use frequency_response_file::{FREQUENCY_RESPONSE, FrequencyResponseFile};
pub use gmsh::GmshMesh;
pub use imu_yaml::{ImuSensorNoise, ImuValue, ImuYaml};
pub use model_file::{
    ColumnTrouble, check as check_model, explain as explain_model, fill_columns,
    parse as parse_model, read_budget, read_model,
};
pub use result_document::{
    NamedCovariance, RESULT_VERSION, ResultDocument, StatedQuantity, at_frequency, is_result,
};
pub use trial_file::{TRIALS, TRIALS_SECTION, TrialFile};
pub use verification::{Fate, Link, Verification, Vouching};
pub use vtu::{VtuField, vtu};

/// The example of the README, so that it stays true.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

//! How the uncertainties of a calibration on the shaker are stated.

use super::CampaignFile;
use proofmass_io::Result;
use serde::Deserialize;

/// `[method]` of a comparison and of a transverse test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct StatementTable {
    /// Coverage factor of the stated U, such as 2; else that of 95 %.
    pub(crate) coverage_factor: Option<f64>,
}

/// Refuses a coverage factor that is none.
pub(super) fn coverage_factor(source: &CampaignFile, k: Option<f64>) -> Result<()> {
    match k {
        Some(k) if !(k > 0.0 && k <= 10.0) => Err(source
            .refuse(
                "method",
                "coverage_factor",
                format!("{k} is no coverage factor"),
            )
            .with_hint("such as 2; without it U is stated at 95 %")),
        _ => Ok(()),
    }
}

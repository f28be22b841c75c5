//! How the uncertainties of a calibration are stated.

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

/// Refuses a probability that no interval is stated with.
pub(super) fn confidence(source: &CampaignFile, probability: f64) -> Result<()> {
    match probability > 0.5 && probability < 1.0 {
        true => Ok(()),
        false => Err(source
            .refuse(
                "method",
                "confidence",
                format!("a probability of {probability} is out of range: above 0.5 and below 1"),
            )
            .with_hint("give a number such as 0.95")),
    }
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

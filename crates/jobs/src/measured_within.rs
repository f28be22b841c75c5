//! Levels and temperatures within which a result was measured: a certificate states them beside its numbers.

use crate::outcome::section;
use crate::trouble::Result;
use crate::value_range::widened;
use num_complex::Complex64;
use proofmass_dynamic::reference_table::ReferenceTable;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Its section in result.json.
pub(crate) const MEASURED_WITHIN: &str = "measured_within";

/// Levels and temperatures within which a result was measured, as far as its job knows them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct MeasuredWithin {
    /// Amplitude of the acceleration, lowest and highest, m/s².
    #[serde(rename = "acceleration_m/s2", skip_serializing_if = "Option::is_none")]
    pub(crate) acceleration: Option<[f64; 2]>,
    /// Temperature of the item, lowest and highest, °C.
    #[serde(rename = "temperature_degC", skip_serializing_if = "Option::is_none")]
    pub(crate) temperature: Option<[f64; 2]>,
    /// Temperature at which coefficients of the temperature are zero, °C.
    #[serde(
        rename = "reference_temperature_degC",
        skip_serializing_if = "Option::is_none"
    )]
    pub(crate) reference_temperature: Option<f64>,
}

impl MeasuredWithin {
    /// Amplitudes of the acceleration of some runs, m/s².
    pub(crate) fn amplitudes(all: impl IntoIterator<Item = f64>) -> Self {
        Self {
            acceleration: widened(None, all),
            ..Self::default()
        }
    }

    /// Amplitudes of runs against a reference: its frequencies and phasors, in m/s² where it has no table.
    pub(crate) fn runs(
        table: Option<&ReferenceTable>,
        all: impl IntoIterator<Item = (f64, Complex64)>,
    ) -> Self {
        // Runs beyond the table were left out, with a finding.
        let acceleration = |(frequency, phasor): (f64, Complex64)| match table {
            Some(table) => Some(table.acceleration(phasor, frequency).ok()?.norm()),
            None => Some(phasor.norm()),
        };
        Self::amplitudes(all.into_iter().filter_map(acceleration))
    }

    /// The section of result.json.
    ///
    /// # Errors
    /// A number that is not finite.
    pub(crate) fn section(&self) -> Result<(&'static str, Value)> {
        section(MEASURED_WITHIN, self)
    }
}

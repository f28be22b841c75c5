//! Which device, under which conditions: what every result repeats.

use serde::{Deserialize, Serialize};

/// Who made a device and which one it is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Device {
    /// Maker.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub manufacturer: Option<String>,
    /// Type.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Serial number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Anything else worth filing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
}

impl Device {
    /// Maker, type and serial number in a line; empty where nothing is said.
    pub fn line(&self) -> String {
        let words = [&self.manufacturer, &self.model, &self.serial];
        let words: Vec<&str> = words.into_iter().flatten().map(String::as_str).collect();
        words.join(" ")
    }
}

/// Conditions of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Ambient {
    /// Temperature, °C.
    #[serde(
        rename = "temperature_degC",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub temperature_deg_c: Option<f64>,
    /// Anything else worth filing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
}

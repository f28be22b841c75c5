//! What a triaxial device gives, and the units of its matrices.

use serde::{Deserialize, Serialize};

/// Unit of the outputs of a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum OutputUnit {
    /// V.
    #[default]
    Volt,
    /// m/s²: a digital sensor that scales its samples itself.
    Acceleration,
    /// Counts of a converter.
    Count,
}

impl OutputUnit {
    /// Of an output.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Volt => "V",
            Self::Acceleration => "m/s²",
            Self::Count => "count",
        }
    }

    /// Of the sensitivity S.
    pub fn sensitivity(self) -> &'static str {
        match self {
            Self::Volt => "V/(m/s²)",
            Self::Acceleration => "(m/s²)/(m/s²)",
            Self::Count => "count/(m/s²)",
        }
    }

    /// Of the exploitation A = S⁻¹.
    pub fn exploitation(self) -> &'static str {
        match self {
            Self::Volt => "(m/s²)/V",
            Self::Acceleration => "(m/s²)/(m/s²)",
            Self::Count => "(m/s²)/count",
        }
    }
}

//! What a device gives: volts, an acceleration, counts.

use crate::campaign::PhasorQuantity;
use proofmass_io::Unit;
use proofmass_shaker::OutputUnit;
use serde::{Deserialize, Serialize};

/// What a device gives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum DeviceOutput {
    /// Volts.
    #[default]
    Volt,
    /// An acceleration: a digital sensor that scales its samples itself.
    Acceleration,
    /// Counts of a converter.
    Count,
}

impl DeviceOutput {
    /// Unit of the sensitivity.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Volt => "V/(m/s²)",
            Self::Acceleration => "(m/s²)/(m/s²)",
            Self::Count => "count/(m/s²)",
        }
    }

    /// Unit of what the device gives.
    pub fn of_device(self) -> Unit {
        match self {
            Self::Volt => Unit::Volt,
            Self::Acceleration => Unit::MetrePerSecondSquared,
            Self::Count => Unit::Count,
        }
    }

    /// The same as unit of the outputs of a triaxial device.
    pub(crate) fn triaxial(self) -> OutputUnit {
        match self {
            Self::Volt => OutputUnit::Volt,
            Self::Acceleration => OutputUnit::Acceleration,
            Self::Count => OutputUnit::Count,
        }
    }

    /// Of the amplitudes of a channel; recordings say nothing and are volts.
    pub(crate) fn of(quantity: Option<PhasorQuantity>) -> Self {
        match quantity {
            Some(PhasorQuantity::Acceleration) => Self::Acceleration,
            Some(PhasorQuantity::Count) => Self::Count,
            _ => Self::Volt,
        }
    }
}

//! The classical shock pulses.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Shape of a nominal shock pulse of duration D and peak A.
///
/// **Source** `[IEC60068-2-27]`; the haversine is what a rubber pad gives.
///
/// ```
/// use proofmass_signal::PulseShape;
/// assert_eq!(PulseShape::HalfSine.at(0.5), 1.0);
/// assert!((PulseShape::HalfSine.area() - 0.636_619_772).abs() < 1e-9);
/// assert_eq!(PulseShape::Trapezoid { rise: 0.1 }.at(0.05), 0.5);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum PulseShape {
    /// sin πs.
    #[default]
    HalfSine,
    /// sin² πs.
    Haversine,
    /// Rises straight to the peak at the end, then drops.
    TerminalPeakSawtooth,
    /// Level top with straight flanks, each a share of the duration below one half.
    Trapezoid {
        /// Share of the duration that each flank takes.
        rise: f64,
    },
}

impl PulseShape {
    /// The shape at s = t/D, as a share of the peak; zero outside the pulse.
    pub fn at(self, s: f64) -> f64 {
        if !(0.0..=1.0).contains(&s) {
            return 0.0;
        }
        match self {
            Self::HalfSine => (PI * s).sin(),
            Self::Haversine => (PI * s).sin().powi(2),
            Self::TerminalPeakSawtooth => s,
            Self::Trapezoid { rise } => {
                let flank = rise.clamp(1e-9, 0.5);
                (s.min(1.0 - s) / flank).min(1.0)
            }
        }
    }

    /// Velocity change divided by A D.
    pub fn area(self) -> f64 {
        match self {
            Self::HalfSine => 2.0 / PI,
            Self::Haversine | Self::TerminalPeakSawtooth => 0.5,
            Self::Trapezoid { rise } => 1.0 - rise.clamp(1e-9, 0.5),
        }
    }

    /// Duration between the passages through a tenth of the peak, divided by D.
    pub fn tenth_duration(self) -> f64 {
        match self {
            Self::HalfSine => 1.0 - 2.0 * 0.1f64.asin() / PI,
            Self::Haversine => 1.0 - 2.0 * 0.1f64.sqrt().asin() / PI,
            Self::TerminalPeakSawtooth => 0.9,
            Self::Trapezoid { rise } => 1.0 - 0.2 * rise.clamp(1e-9, 0.5),
        }
    }

    /// Samples of the pulse from `start` seconds on, in a record of n samples.
    pub fn record(self, peak: f64, duration: f64, start: f64, n: usize, rate: f64) -> Vec<f64> {
        (0..n)
            .map(|k| peak * self.at((k as f64 / rate - start) / duration))
            .collect()
    }
}

//! Known biases of the total family and of THEO1, relative to the Allan (Hadamard, modified) variance.

use crate::steps::Steps;
use crate::{NoiseType, Statistic, theo};
use serde::{Deserialize, Serialize};

/// Whether a statistic with a known bias is corrected.
///
/// TOTDEV, MTOTDEV and HTOTDEV estimate something slightly different from the variance they stand for. Programs
/// differ in correcting it; so does one program in its own tables (Stable32: TOTDEV never, HTOTDEV always,
/// MTOTDEV in some releases, THEO1 from the record itself when the noise type is chosen automatically).
/// Other statistics have no bias and are not touched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Bias {
    /// As the defining formula gives it.
    AsDefined,
    /// Divided by the published ratio for the noise type at each τ.
    #[default]
    ByNoiseType,
    /// THEO1 only: scaled to the Allan variance of the same record (ThêoBR). Others as by noise type.
    FromRecord,
}

/// Ratio ⟨statistic²⟩ / ⟨parent variance⟩ of the published tables at factor m.
///
/// TOTVAR 1 − a τ/T with a = 0, 0.481, 0.750 for α = 0, −1, −2 (`[SP1065] table 7`); MTOTVAR 0.94, 0.83, 0.73,
/// 0.70, 0.69 for α = 2 … −2; HTOTVAR 0.995, 0.851, 0.771, 0.717, 0.679 for α = 0 … −4 (`[SP1065] 5.5`); THEO1
/// 1/(a + b/m^c) (`[SP1065] table 2`). One where nothing is published.
pub(crate) fn ratio(statistic: Statistic, noise: NoiseType, m: usize, phase_points: usize) -> f64 {
    let alpha = noise.alpha();
    match statistic {
        Statistic::Total => {
            let a = match alpha {
                -1 => 1.0 / (3.0 * std::f64::consts::LN_2),
                -2 => 0.75,
                _ => 0.0,
            };
            1.0 - a * m as f64 / (phase_points as f64 - 1.0)
        }
        Statistic::ModifiedTotal | Statistic::TimeTotal => match alpha {
            2 => 0.94,
            1 => 0.83,
            0 => 0.73,
            -1 => 0.70,
            -2 => 0.69,
            _ => 1.0,
        },
        // At m = 1 it is the Hadamard variance itself.
        Statistic::HadamardTotal if m > 1 => match alpha {
            0 => 0.995,
            -1 => 0.851,
            -2 => 0.771,
            -3 => 0.717,
            -4 => 0.679,
            _ => 1.0,
        },
        Statistic::Theo1 => {
            let (a, b, c) = match alpha {
                2 => (0.09, 0.74, 0.40),
                1 => (0.14, 0.82, 0.30),
                -1 => (1.87, -1.05, 0.79),
                -2 => (2.70, -1.53, 0.85),
                _ => return 1.0,
            };
            1.0 / (a + b / (m as f64).powf(c))
        }
        _ => 1.0,
    }
}

/// The ratio that joins THEO1 to the Allan variance of the same record, inverted as [`ratio`] is.
pub(crate) fn record_ratio(phase: &[f64], steps: &Steps<'_>) -> Option<f64> {
    theo::record_bias(phase, steps).map(|ratio| 1.0 / ratio)
}

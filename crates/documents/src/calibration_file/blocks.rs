//! What a calibration knows beyond the linear model: temperature and curvature.

use super::axis_names;
use proofmass_core::{Curvature, THERMAL_ORDER, ThermalTerms};
use serde::{Deserialize, Serialize};

/// How bias and scale of each axis follow the temperature T: with d = T − T₀ in K,
/// b_i(T) = b_i + Σ β_ik dᵏ and K(T) = diag(1 + Σ γ_ik dᵏ) K, k = 1 … 3.
///
/// In the estimate the coefficients are named `bias.x.T1`, `scale.x.T1`, … (`bias.T1`, … of a single axis); one that was not
/// fitted is zero here and missing there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ThermalBlock {
    /// T₀, °C.
    #[serde(rename = "reference_degC")]
    pub reference: f64,
    /// β: per axis the coefficients of d, d², d³, input unit per Kᵏ.
    pub bias: Vec<[f64; THERMAL_ORDER]>,
    /// γ: per axis the coefficients of d, d², d³, 1/Kᵏ.
    pub scale: Vec<[f64; THERMAL_ORDER]>,
    /// Temperatures between which they were measured, °C.
    #[serde(rename = "range_degC")]
    pub range: [f64; 2],
    /// Standard uncertainty per axis from what heating and cooling do differently, input unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hysteresis: Option<Vec<f64>>,
}

impl ThermalBlock {
    /// As the compensation of N axes takes them; `None` where they are those of another number of axes.
    pub fn terms<const N: usize>(&self) -> Option<ThermalTerms<f64, N>> {
        Some(ThermalTerms {
            reference: self.reference,
            range: self.range,
            bias: self.bias.as_slice().try_into().ok()?,
            scale: self.scale.as_slice().try_into().ok()?,
        })
    }

    /// d: a temperature less the reference, held within the range.
    pub(super) fn deviation(&self, temperature: f64) -> f64 {
        temperature.clamp(self.range[0], self.range[1]) - self.reference
    }

    /// What the bias of an axis, input unit, and its relative scale change by over d.
    pub(super) fn changes(&self, i: usize, d: f64) -> [f64; 2] {
        [self.bias[i], self.scale[i]].map(|[a, b, c]| d * (a + d * (b + d * c)))
    }

    pub(super) fn is_of(&self, axes: usize) -> bool {
        let hysteresis = self.hysteresis.as_ref().map_or(axes, Vec::len);
        [self.bias.len(), self.scale.len(), hysteresis] == [axes; 3]
    }

    /// Whether the coefficients were measured at this temperature, °C.
    pub fn covers(&self, temperature: f64) -> bool {
        (self.range[0]..=self.range[1]).contains(&temperature)
    }

    pub(super) fn numbers(&self) -> Vec<f64> {
        let polynomials = self.bias.iter().chain(&self.scale).flatten();
        let mut all: Vec<f64> = polynomials.copied().collect();
        all.push(self.reference);
        all.extend(self.range);
        all.extend(self.hysteresis.iter().flatten());
        all
    }

    /// Names of the coefficients of an axis in the estimate, with their values here.
    pub(super) fn named(&self, i: usize) -> Vec<(String, f64)> {
        let axis = axis_names(self.bias.len())[i];
        let of = |kind: &'static str, c: [f64; THERMAL_ORDER]| {
            let powers = c.into_iter().enumerate();
            powers.map(move |(k, v)| (format!("{kind}{axis}.T{}", k + 1), v))
        };
        of("bias", self.bias[i])
            .chain(of("scale", self.scale[i]))
            .collect()
    }
}

/// Curvature of each channel along its own sensitive axis: with x = (K a)_i / K_ii the channel gives
/// b_i + K_ii (x + k₂ x² + k₃ x³).
///
/// In the estimate the coefficients are named `curvature.x.2` and `curvature.x.3` (`curvature.2` and `curvature.3` of a single axis).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CurvatureBlock {
    /// k₂ per axis, 1/(m/s²).
    pub quadratic: Vec<f64>,
    /// k₃ per axis, 1/(m/s²)².
    pub cubic: Vec<f64>,
    /// Largest acceleration at which they were measured, m/s².
    pub reach: f64,
}

impl CurvatureBlock {
    /// As the compensation of N axes takes them; `None` where they are those of another number of axes.
    pub fn terms<const N: usize>(&self) -> Option<Curvature<f64, N>> {
        Some(Curvature {
            quadratic: self.quadratic.as_slice().try_into().ok()?,
            cubic: self.cubic.as_slice().try_into().ok()?,
        })
    }

    pub(super) fn is_of(&self, axes: usize) -> bool {
        [self.quadratic.len(), self.cubic.len()] == [axes; 2]
    }

    pub(super) fn named(&self, i: usize) -> Vec<(String, f64)> {
        let axis = axis_names(self.quadratic.len())[i];
        vec![
            (format!("curvature{axis}.2"), self.quadratic[i]),
            (format!("curvature{axis}.3"), self.cubic[i]),
        ]
    }
}

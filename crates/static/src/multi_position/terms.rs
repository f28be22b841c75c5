//! Terms beyond ã = K a + b: what follows the temperature, and curvature.

use crate::Pose;
use proofmass_core::{Curvature, Error, THERMAL_ORDER, ThermalTerms};
use serde::{Deserialize, Serialize};

/// Orders of what is added to ã = K a + b; nothing unless told.
///
/// ```text
/// ã_i = b_i + Σ β_ik dᵏ + (1 + Σ γ_ik dᵏ) K_ii (x_i + k₂ x_i² + k₃ x_i³),   x_i = (K a)_i / K_ii,   d = T − T₀
/// ```
///
/// The temperature is that of each standstill; β, γ and k are fitted beside K and b, with one covariance.
///
/// **Source** `[IEEE1293]` (model equation), the compensation `proofmass_core::Compensation`.
#[doc(alias("model equation", "K2", "temperature coefficient"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Terms {
    /// Largest power of d in the biases, 0 to 3.
    pub bias: u8,
    /// Largest power of d in the scale factors, 0 to 3.
    pub scale: u8,
    /// Largest power of the acceleration: 2, 3, or 0 for none but the first.
    pub curvature: u8,
    /// T₀, °C; the middle of the temperatures unless told.
    #[serde(rename = "reference_degC", skip_serializing_if = "Option::is_none")]
    pub reference: Option<f64>,
}

const BIAS_T: [[&str; 3]; THERMAL_ORDER] = [
    ["bias.x.T1", "bias.y.T1", "bias.z.T1"],
    ["bias.x.T2", "bias.y.T2", "bias.z.T2"],
    ["bias.x.T3", "bias.y.T3", "bias.z.T3"],
];
const SCALE_T: [[&str; 3]; THERMAL_ORDER] = [
    ["scale.x.T1", "scale.y.T1", "scale.z.T1"],
    ["scale.x.T2", "scale.y.T2", "scale.z.T2"],
    ["scale.x.T3", "scale.y.T3", "scale.z.T3"],
];
const CURVATURE: [[&str; 3]; 2] = [
    ["curvature.x.2", "curvature.y.2", "curvature.z.2"],
    ["curvature.x.3", "curvature.y.3", "curvature.z.3"],
];

/// One added parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Term {
    /// Power of d in the bias of an axis.
    Bias(usize, usize),
    /// Power of d in the scale factor of an axis.
    Scale(usize, usize),
    /// Power of the acceleration along an axis.
    Curvature(usize, usize),
}

impl Term {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Bias(axis, power) => BIAS_T[power - 1][axis],
            Self::Scale(axis, power) => SCALE_T[power - 1][axis],
            Self::Curvature(axis, power) => CURVATURE[power - 2][axis],
        }
    }

    /// Its unit, where outputs are in `unit`.
    pub(super) fn unit_name(self, unit: &str) -> String {
        let exponent = |power: usize| ["", "", "²", "³"][power];
        match self {
            Self::Bias(_, power) => format!("{unit}/K{}", exponent(power)),
            Self::Scale(_, power) => format!("1/K{}", exponent(power)),
            Self::Curvature(_, 2) => "1/(m/s²)".to_owned(),
            Self::Curvature(..) => "1/(m/s²)²".to_owned(),
        }
    }
}

impl Terms {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.list().is_empty()
    }

    /// Whether any follows the temperature.
    pub fn follow_temperature(&self) -> bool {
        self.bias > 0 || self.scale > 0
    }

    /// The parameters behind those of the matrix model, in order.
    pub(crate) fn list(&self) -> Vec<Term> {
        let axes = |of: fn(usize, usize) -> Term, powers: std::ops::RangeInclusive<u8>| {
            powers.flat_map(move |p| (0..3).map(move |axis| of(axis, usize::from(p))))
        };
        axes(Term::Bias, 1..=self.bias)
            .chain(axes(Term::Scale, 1..=self.scale))
            .chain(axes(Term::Curvature, 2..=self.curvature))
            .collect()
    }

    /// # Errors
    /// [`Error::OutOfRange`] for a power that the compensation does not have.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let orders = [
            ("order of the temperature in the bias", self.bias),
            ("order of the temperature in the scale", self.scale),
            ("order of the curvature", self.curvature),
        ];
        for (name, order) in orders {
            if order > 3 {
                return Err(Error::OutOfRange {
                    name,
                    value: f64::from(order),
                    min: 0.0,
                    max: 3.0,
                });
            }
        }
        match self.reference {
            Some(t) if !(-273.15..=1e4).contains(&t) => Err(Error::OutOfRange {
                name: "reference temperature, °C",
                value: t,
                min: -273.15,
                max: 1e4,
            }),
            _ => Ok(()),
        }
    }
}

/// Terms with the temperatures of the standstills they are fitted to.
#[derive(Clone, Debug, Default)]
pub(crate) struct TermsAt {
    pub(crate) list: Vec<Term>,
    pub(crate) curvature: bool,
    /// T₀, °C.
    pub(crate) reference: f64,
    /// Half the range of the temperatures, K: the unit of z = (T − T₀)/half.
    pub(crate) half: f64,
    /// Lowest and highest temperature, °C.
    pub(crate) range: [f64; 2],
    /// z of each standstill; zeros where nothing follows the temperature.
    pub(crate) z: Vec<f64>,
}

impl TermsAt {
    /// Largest power of the acceleration that is fitted beyond the first; 0 for none.
    pub(super) fn curvature_order(&self) -> usize {
        let powers = self.list.iter().map(|t| match t {
            Term::Curvature(_, power) => *power,
            _ => 0,
        });
        powers.max().unwrap_or(0)
    }

    pub(crate) fn new(terms: &Terms, poses: &[Pose]) -> Result<Self, Error> {
        terms.check()?;
        let mut at = Self {
            list: terms.list(),
            curvature: terms.curvature > 1,
            half: 1.0,
            z: vec![0.0; poses.len()],
            ..Self::default()
        };
        if !terms.follow_temperature() {
            return Ok(at);
        }
        let temperatures: Option<Vec<f64>> = poses.iter().map(|p| p.temperature).collect();
        let temperatures = temperatures.ok_or(Error::Unobservable {
            parameter: "a temperature coefficient: no temperatures were recorded",
            condition: f64::INFINITY,
        })?;
        const POSSIBLE: std::ops::RangeInclusive<f64> = -273.15..=1e3;
        if let Some(wrong) = temperatures.iter().find(|t| !POSSIBLE.contains(t)) {
            return Err(Error::OutOfRange {
                name: "temperature of a standstill, °C",
                value: *wrong,
                min: *POSSIBLE.start(),
                max: *POSSIBLE.end(),
            });
        }
        let low = temperatures.iter().copied().fold(f64::INFINITY, f64::min);
        let high = temperatures
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        if !(high - low > 1e-3) {
            return Err(Error::Constant {
                name: "temperature",
                value: low,
            });
        }
        at.half = 0.5 * (high - low);
        at.reference = terms.reference.unwrap_or(0.5 * (low + high));
        if !(at.reference >= low - at.half && at.reference <= high + at.half) {
            return Err(Error::OutOfRange {
                name: "reference temperature, °C",
                value: at.reference,
                min: low - at.half,
                max: high + at.half,
            });
        }
        at.range = [low, high];
        at.z = temperatures
            .iter()
            .map(|t| (t - at.reference) / at.half)
            .collect();
        Ok(at)
    }

    /// β and γ in powers of z, k in units of g, from the parameters behind those of the matrix.
    pub(super) fn coefficients(&self, extra: &[f64]) -> (ThermalTerms<f64>, Curvature<f64>) {
        let mut thermal = ThermalTerms {
            reference: 0.0,
            range: [f64::NEG_INFINITY, f64::INFINITY],
            bias: [[0.0; THERMAL_ORDER]; 3],
            scale: [[0.0; THERMAL_ORDER]; 3],
        };
        let mut curvature = Curvature {
            quadratic: [0.0; 3],
            cubic: [0.0; 3],
        };
        for (term, value) in self.list.iter().zip(extra) {
            match *term {
                Term::Bias(axis, power) => thermal.bias[axis][power - 1] = *value,
                Term::Scale(axis, power) => thermal.scale[axis][power - 1] = *value,
                Term::Curvature(axis, 2) => curvature.quadratic[axis] = *value,
                Term::Curvature(axis, _) => curvature.cubic[axis] = *value,
            }
        }
        (thermal, curvature)
    }

    /// The unit of a parameter: what one of it in natural units is. `radius`: s g in output units; `gravity`: g, m/s².
    pub(crate) fn unit(&self, term: Term, radius: f64, gravity: f64) -> f64 {
        match term {
            Term::Bias(_, power) => radius / self.half.powi(power as i32),
            Term::Scale(_, power) => 1.0 / self.half.powi(power as i32),
            Term::Curvature(_, power) => 1.0 / gravity.powi(power as i32 - 1),
        }
    }
}

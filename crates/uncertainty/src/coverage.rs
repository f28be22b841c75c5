//! Degrees of freedom and coverage factors.

use crate::student;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Degrees of freedom: how well a standard uncertainty is itself known. Positive, infinite allowed.
///
/// Serialised as a number, or as the word `"infinite"`.
#[doc(alias("Welch-Satterthwaite", "effective degrees of freedom"))]
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct DegreesOfFreedom(f64);

impl DegreesOfFreedom {
    /// A standard uncertainty that is taken as exactly known (a certificate, a type B bound).
    pub const INFINITE: Self = Self(f64::INFINITY);

    /// Degrees of freedom from a positive number; `None` for zero, negative and NaN.
    pub fn new(nu: f64) -> Option<Self> {
        (nu > 0.0).then_some(Self(nu))
    }

    /// The number, `f64::INFINITY` when infinite.
    pub fn get(self) -> f64 {
        self.0
    }

    /// Whether they are infinite.
    pub fn is_infinite(self) -> bool {
        self.0.is_infinite()
    }

    /// Coverage factor k of the two-sided interval that holds the measurand with `probability`.
    ///
    /// k = t_{(1+p)/2}(ν); the normal quantile when ν is infinite. **Source** `[GUM] G.3.4`; unlike the GUM's
    /// table, ν is not truncated to an integer.
    ///
    /// ```
    /// use proofmass_uncertainty::DegreesOfFreedom;
    /// let k = DegreesOfFreedom::new(4.0).unwrap().coverage_factor(0.95);
    /// assert!((k - 2.776).abs() < 5e-4); // `[GUM]` table G.2
    /// ```
    pub fn coverage_factor(self, probability: f64) -> f64 {
        student::two_sided_quantile(probability, self.0)
    }

    /// Probability that the two-sided interval ±k u holds the measurand: the inverse of
    /// [`coverage_factor`](Self::coverage_factor).
    ///
    /// ```
    /// use proofmass_uncertainty::DegreesOfFreedom;
    /// let p = |nu| DegreesOfFreedom::new(nu).unwrap().coverage_probability(2.0);
    /// assert!((p(f64::INFINITY) - 0.9545).abs() < 5e-5); // `[GUM]` table G.1
    /// assert!((p(4.0) - 0.8839).abs() < 5e-5);
    /// ```
    pub fn coverage_probability(self, k: f64) -> f64 {
        student::two_sided_probability(k, self.0)
    }
}

impl fmt::Display for DegreesOfFreedom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_infinite() {
            f.write_str("∞")
        } else if self.0 > 9999.0 {
            f.write_str("> 9999")
        } else if self.0 < 100.0 {
            write!(f, "{:.1}", self.0)
        } else {
            write!(f, "{:.0}", self.0)
        }
    }
}

impl Serialize for DegreesOfFreedom {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.is_infinite() {
            serializer.serialize_str("infinite")
        } else {
            serializer.serialize_f64(self.0)
        }
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for DegreesOfFreedom {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "DegreesOfFreedom".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "Degrees of freedom: a positive number or \"infinite\".",
            "anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"const": "infinite"}]
        })
    }
}

impl<'de> Deserialize<'de> for DegreesOfFreedom {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Form {
            Number(f64),
            Word(String),
        }
        match Form::deserialize(deserializer)? {
            Form::Number(nu) => Self::new(nu).ok_or_else(|| {
                serde::de::Error::custom(format!("degrees of freedom {nu} are not positive"))
            }),
            Form::Word(word) if word == "infinite" => Ok(Self::INFINITE),
            Form::Word(word) => Err(serde::de::Error::custom(format!(
                "degrees of freedom {word:?}: a positive number or \"infinite\""
            ))),
        }
    }
}

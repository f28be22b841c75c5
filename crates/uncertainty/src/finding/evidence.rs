//! Evidence of a finding, value by value.

use serde::{Deserialize, Serialize};
use std::fmt;

/// One value of the evidence: a finite number, or a text. A number that is not finite is kept as a text.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum EvidenceValue {
    /// A finite number.
    Number(f64),
    /// A name or a sentence.
    Text(String),
}

impl PartialEq for EvidenceValue {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => a.to_bits() == b.to_bits(),
            (Self::Text(a), Self::Text(b)) => a == b,
            _ => false,
        }
    }
}

impl Eq for EvidenceValue {}

impl From<f64> for EvidenceValue {
    fn from(value: f64) -> Self {
        match value.is_finite() {
            true => Self::Number(value),
            false => Self::Text(value.to_string()),
        }
    }
}

macro_rules! from_whole_numbers {
    ($($whole:ty),*) => {$(
        impl From<$whole> for EvidenceValue {
            fn from(value: $whole) -> Self {
                Self::Number(value as f64)
            }
        }
    )*};
}

from_whole_numbers!(usize, u64, u32, i64, i32);

impl From<&str> for EvidenceValue {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for EvidenceValue {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

impl From<Figure> for EvidenceValue {
    fn from(value: Figure) -> Self {
        value.0.into()
    }
}

/// A number that is printed with four significant digits, as a person writes them; the evidence keeps all digits.
///
/// ```
/// use proofmass_uncertainty::Figure;
///
/// assert_eq!(Figure(31.6667).to_string(), "31.67");
/// assert_eq!(Figure(0.00001337).to_string(), "1.337×10⁻⁵");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure(pub f64);

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.0;
        if value == 0.0 || !value.is_finite() {
            return write!(f, "{value}");
        }
        let rounded = format!("{value:.3e}");
        let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
        match exponent.parse::<i32>() {
            Ok(e @ -3..=5) => write!(f, "{value:.*}", usize::try_from(3 - e).unwrap_or(0)),
            _ => {
                let digit = |c: char| match c {
                    '-' => '⁻',
                    '0' => '⁰',
                    '1' => '¹',
                    '2' => '²',
                    '3' => '³',
                    _ => char::from_u32('⁰' as u32 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
                };
                write!(
                    f,
                    "{mantissa}×10{}",
                    exponent.chars().map(digit).collect::<String>()
                )
            }
        }
    }
}

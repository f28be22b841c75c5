//! A sensitivity as a person states it: `0.5 mV/(m/s²)`, `102 mV/g`, `16384 LSB/g`.

use crate::Unit;
use crate::sheet::{COUNT_SENSITIVITY, SENSITIVITY, plain};
use std::fmt;
use std::str::FromStr;

/// What one m/s² gives, in volts or counts.
///
/// ```
/// use proofmass_io::{Sensitivity, Unit};
///
/// let s: Sensitivity = "98.0665 mV/g".parse()?;
/// assert!((s.value - 0.01).abs() < 1e-15 && s.unit == Unit::Volt);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sensitivity {
    /// V/(m/s²) or count/(m/s²).
    pub value: f64,
    /// Unit of the output: V or count.
    pub unit: Unit,
    /// As it was stated.
    words: String,
}

impl FromStr for Sensitivity {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let end = text
            .find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)))
            .unwrap_or(text.len());
        let (number, unit) = text.split_at(end);
        let number: f64 = number
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite() && *v != 0.0)
            .ok_or_else(|| format!("{text:?} is no sensitivity such as \"0.5 mV/(m/s²)\""))?;
        let ending = plain(unit.trim());
        let kinds = [(Unit::Volt, SENSITIVITY), (Unit::Count, COUNT_SENSITIVITY)];
        for (unit, endings) in kinds {
            if let Some((_, factor)) = endings.iter().find(|(e, _)| *e == ending) {
                return Ok(Self {
                    value: number * factor,
                    unit,
                    words: text.to_owned(),
                });
            }
        }
        let valid: Vec<&str> = kinds
            .iter()
            .flat_map(|(_, e)| e.iter())
            .map(|(e, _)| *e)
            .collect();
        Err(format!(
            "{:?} is no unit of a sensitivity; valid are {}",
            unit.trim(),
            valid.join(", ")
        ))
    }
}

impl fmt::Display for Sensitivity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_sensitivities() {
        for (text, value, unit) in [
            ("0.5 mV/(m/s²)", 5e-4, Unit::Volt),
            ("0.5mV/(m/s2)", 5e-4, Unit::Volt),
            ("-102 mV/g", -0.102 / 9.80665, Unit::Volt),
            ("16384 LSB/g", 16384.0 / 9.80665, Unit::Count),
        ] {
            let s: Sensitivity = text.parse().unwrap();
            assert!((s.value / value - 1.0).abs() < 1e-14, "{text}");
            assert_eq!((s.unit, s.to_string()), (unit, text.to_owned()));
        }
    }

    #[test]
    fn refuses_what_is_none() {
        for text in ["", "mV/g", "0 mV/g", "5", "5 mV", "5 g/V", "inf V/g"] {
            assert!(text.parse::<Sensitivity>().is_err(), "{text}");
        }
    }
}

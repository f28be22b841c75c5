//! The unit of a frequency response: one unit over another, `V/(m/s²)`, `mg/g`, `N/(m/s²)`.

use crate::Unit;
use std::fmt;
use std::str::FromStr;

/// A unit over another; over one it is a unit by itself.
///
/// ```
/// use proofmass_io::UnitRatio;
///
/// let unit: UnitRatio = "mV/g".parse()?;
/// let (si, factor) = unit.si();
/// assert_eq!(si.to_string(), "V/(m/s²)");
/// assert!((factor * 9806.65 - 1.0).abs() < 1e-15);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct UnitRatio {
    /// Of the output.
    pub over: Unit,
    /// Of the input.
    pub under: Unit,
}

impl UnitRatio {
    /// Reads a usual spelling; a unit with a stroke of its own stands in brackets behind the stroke. `None` when it is none.
    pub fn recognise(text: &str) -> Option<Self> {
        let text = text.trim();
        if let Some(over) = Unit::recognise(text) {
            let under = Unit::One;
            return Some(Self { over, under });
        }
        let bare = |text: &str| {
            let inner = text.trim().strip_prefix('(')?.strip_suffix(')')?;
            Unit::recognise(inner)
        };
        text.match_indices('/').find_map(|(at, _)| {
            let (over, under) = (&text[..at], &text[at + 1..]);
            let over = bare(over).or_else(|| Unit::recognise(over))?;
            let plain = || Unit::recognise(under).filter(|_| !under.contains('/'));
            let under = bare(under).or_else(plain)?;
            Some(Self { over, under })
        })
    }

    /// Both in SI, and the factor: value in SI = factor × value.
    pub fn si(self) -> (Self, f64) {
        let ((over, times), (under, by)) = (self.over.si(), self.under.si());
        (Self { over, under }, times / by)
    }

    /// Splits a heading into its name and the unit over another that it carries: `s_V/(m/s2)`, `s (mV/g)`, `s [V/g]`; none with a unit by
    /// itself, which [`split_heading`](crate::split_heading) reads.
    pub fn split_heading(heading: &str) -> Option<(&str, Self)> {
        let heading = heading.trim();
        let marks = heading
            .char_indices()
            .filter(|(_, c)| matches!(c, '_' | ' ' | ',' | '(' | '[' | '{' | '<'));
        for (at, mark) in marks.filter(|(at, _)| *at > 0) {
            let rest = &heading[at + 1..];
            let unit = match mark {
                '(' => rest.strip_suffix(')'),
                '[' => rest.strip_suffix(']'),
                '{' => rest.strip_suffix('}'),
                '<' => rest.strip_suffix('>'),
                _ => Some(rest),
            };
            let name = heading[..at].trim_end_matches([' ', '_', ',']);
            let unit = unit.and_then(Self::recognise);
            if let Some(unit) = unit.filter(|u| u.under != Unit::One && !name.is_empty()) {
                return Some((name, unit));
            }
        }
        None
    }
}

impl fmt::Display for UnitRatio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = |unit: Unit| match unit.to_string() {
            text if text.contains('/') => format!("({text})"),
            text => text,
        };
        match self.under {
            Unit::One => write!(f, "{}", self.over),
            under => write!(f, "{}/{}", shown(self.over), shown(under)),
        }
    }
}

impl FromStr for UnitRatio {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::recognise(text).ok_or_else(|| {
            format!("{text:?} is no known unit of a response (V/(m/s2), mV/g, count/g, g/g, pC/N, …; 1 for a pure number)")
        })
    }
}

impl serde::Serialize for UnitRatio {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> serde::Deserialize<'de> for UnitRatio {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for UnitRatio {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "UnitRatio".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "A unit over another, such as V/(m/s²), mV/g, count/g.",
            "type": "string"
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::split_heading;

    #[test]
    fn known_headings_of_a_response() {
        for (heading, name, unit) in [
            ("s_V/(m/s2)", "s", "V/(m/s²)"),
            ("s V/(m/s²)", "s", "V/(m/s²)"),
            ("sensitivity (mV/g)", "sensitivity", "mV/g"),
            ("sensitivity_[mV/(m/s^2)]", "sensitivity", "mV/(m/s²)"),
            ("s (V/(m/s2))", "s", "V/(m/s²)"),
            ("q_pC/ms-2", "q", "pC/(m/s²)"),
            ("ratio_m/s2/(m/s2)", "ratio", "(m/s²)/(m/s²)"),
            ("accelerance ((m/s2)/N)", "accelerance", "(m/s²)/N"),
            ("u_s_LSB/g", "u_s", "count/g"),
        ] {
            let (found, read) = UnitRatio::split_heading(heading).expect(heading);
            assert_eq!((found, read.to_string().as_str()), (name, unit));
            assert_eq!(read.to_string().parse::<UnitRatio>().unwrap(), read);
            // A column is found by its name alone, whoever asks.
            assert_eq!(split_heading(heading), (name, None), "{heading}");
        }
        // A unit by itself, no unit, and the first of two strokes without brackets.
        for heading in ["a_m/s2", "a/(m/s2)", "s", "V/g", "x_V/m/s2", "force / N"] {
            assert_eq!(UnitRatio::split_heading(heading), None, "{heading}");
        }
    }

    #[test]
    fn known_factors_to_si() {
        for (text, si, factor) in [
            ("mV/g", "V/(m/s²)", 1e-3 / 9.80665),
            ("g/(m/s2)", "(m/s²)/(m/s²)", 9.80665),
            ("LSB/g", "count/(m/s²)", 1.0 / 9.80665),
            ("mV/N", "V/N", 1e-3),
            ("mV", "V", 1e-3),
            ("1", "1", 1.0),
        ] {
            let (unit, of) = text.parse::<UnitRatio>().unwrap().si();
            assert_eq!(unit.to_string(), si);
            assert!((of / factor - 1.0).abs() < 1e-15, "{text}: {of}");
        }
    }
}

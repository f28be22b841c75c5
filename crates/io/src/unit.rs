//! Units of recorded columns and their conversion to SI.

use crate::UnitRatio;
use proofmass_core::STANDARD_GRAVITY;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// Unit of a column of a recording.
///
/// `count` and volts are raw outputs whose scale is a result of a fit; they are never converted to acceleration here.
///
/// ```
/// use proofmass_io::Unit;
///
/// let unit: Unit = "mg".parse()?;
/// assert_eq!(unit.si(), (Unit::MetrePerSecondSquared, 9.80665e-3));
/// assert_eq!("m/s^2".parse::<Unit>()?.to_string(), "m/s²");
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Unit {
    /// m/s².
    MetrePerSecondSquared,
    /// mm/s².
    MillimetrePerSecondSquared,
    /// Standard gravity, 9.80665 m/s².
    StandardGravity,
    /// 10⁻³ of standard gravity.
    MilliGravity,
    /// 10⁻⁶ of standard gravity.
    MicroGravity,
    /// Gal, 10⁻² m/s².
    Gal,
    /// in/s², 0.0254 m/s².
    InchPerSecondSquared,
    /// ft/s², 0.3048 m/s².
    FootPerSecondSquared,
    /// Number out of a converter.
    Count,
    /// V.
    Volt,
    /// mV.
    Millivolt,
    /// µV.
    Microvolt,
    /// A.
    Ampere,
    /// mA.
    Milliampere,
    /// µA.
    Microampere,
    /// nA.
    Nanoampere,
    /// pC: charge of a piezoelectric element.
    Picocoulomb,
    /// pF: capacitance of a comb.
    Picofarad,
    /// s.
    Second,
    /// ms.
    Millisecond,
    /// µs.
    Microsecond,
    /// ns.
    Nanosecond,
    /// min.
    Minute,
    /// h.
    Hour,
    /// d.
    Day,
    /// Hz.
    Hertz,
    /// °C.
    DegreeCelsius,
    /// °F; a difference of one is 5/9 K, and zero is not that of °C.
    DegreeFahrenheit,
    /// K.
    Kelvin,
    /// °.
    Degree,
    /// rad.
    Radian,
    /// rad/s.
    RadianPerSecond,
    /// °/s.
    DegreePerSecond,
    /// °/h.
    DegreePerHour,
    /// m.
    Metre,
    /// mm.
    Millimetre,
    /// cm.
    Centimetre,
    /// µm.
    Micrometre,
    /// m/s.
    MetrePerSecond,
    /// mm/s.
    MillimetrePerSecond,
    /// cm/s.
    CentimetrePerSecond,
    /// µm/s.
    MicrometrePerSecond,
    /// km/h.
    KilometrePerHour,
    /// International mile per hour, 0.44704 m/s.
    MilePerHour,
    /// Whole turns of a shaft.
    Turn,
    /// Turns per minute.
    TurnPerMinute,
    /// N.
    Newton,
    /// Pound-force, 4.448 221 615 260 5 N.
    PoundForce,
    /// Pa.
    Pascal,
    /// Pound-force per square inch.
    PoundPerSquareInch,
    /// V/√Hz.
    VoltPerRootHertz,
    /// µV/√Hz.
    MicrovoltPerRootHertz,
    /// A pure number.
    One,
}

use Unit::*;

/// Unit, how it is printed, how it is written in plain ASCII column names, and what else is understood.
/// Compared without blanks, with `²` as `2`, `^` dropped, `µ`/`μ` as `u`; case counts only where it must (`mV`, `MHz`).
const SPELLINGS: &[(Unit, &str, &str, &[&str])] = &[
    (
        MetrePerSecondSquared,
        "m/s²",
        "m/s2",
        &[
            "m/s/s", "m/s**2", "mps2", "ms2", "ms-2", "m.s-2", "m·s-2", "m*s-2", "m_s2",
            "m_per_s2", "m/sec2", "meter/s2",
        ],
    ),
    (
        MillimetrePerSecondSquared,
        "mm/s²",
        "mm/s2",
        &["mm/s/s", "mm/s**2", "mm_s2", "mm_per_s2"],
    ),
    (StandardGravity, "g", "g", &["G", "g0", "gn", "g_n", "g_0"]),
    (
        MilliGravity,
        "mg",
        "mg",
        &["milli-g", "millig", "mG", "mg0"],
    ),
    (MicroGravity, "µg", "ug", &["micro-g", "microg", "ug0"]),
    (Gal, "Gal", "Gal", &["gal", "cm/s2", "cm/s/s", "cm/s**2"]),
    (
        InchPerSecondSquared,
        "in/s²",
        "in/s2",
        &["in/s/s", "in/s**2", "inch/s2", "in/sec2", "ips2"],
    ),
    (
        FootPerSecondSquared,
        "ft/s²",
        "ft/s2",
        &["ft/s/s", "ft/s**2", "ft/sec2"],
    ),
    (
        Count,
        "count",
        "count",
        &[
            "counts", "LSB", "lsb", "digit", "digits", "adc", "ADC", "raw", "Count", "Counts",
            "cts",
        ],
    ),
    (Volt, "V", "V", &["volt", "volts", "Volt", "Volts"]),
    (Millivolt, "mV", "mV", &["millivolt", "millivolts"]),
    (Microvolt, "µV", "uV", &["microvolt", "microvolts"]),
    (Ampere, "A", "A", &["ampere", "amperes"]),
    (Milliampere, "mA", "mA", &["milliampere", "milliamperes"]),
    (Microampere, "µA", "uA", &["microampere", "microamperes"]),
    (Nanoampere, "nA", "nA", &["nanoampere", "nanoamperes"]),
    (Picocoulomb, "pC", "pC", &["picocoulomb", "picocoulombs"]),
    (Picofarad, "pF", "pF", &["picofarad", "picofarads"]),
    (
        Second,
        "s",
        "s",
        &["sec", "secs", "second", "seconds", "Seconds", "Sec"],
    ),
    (
        Millisecond,
        "ms",
        "ms",
        &["msec", "millisecond", "milliseconds", "millis"],
    ),
    (
        Microsecond,
        "µs",
        "us",
        &["usec", "microsecond", "microseconds", "micros"],
    ),
    (
        Nanosecond,
        "ns",
        "ns",
        &["nsec", "nanosecond", "nanoseconds", "nanos"],
    ),
    (Minute, "min", "min", &["minute", "minutes", "mins"]),
    (Hour, "h", "h", &["hour", "hours", "hr", "hrs"]),
    (Day, "d", "d", &["day", "days"]),
    (Hertz, "Hz", "Hz", &["hz", "1/s"]),
    (
        DegreeCelsius,
        "°C",
        "degC",
        &["C", "celsius", "Celsius", "deg_C", "degc", "oC"],
    ),
    (
        DegreeFahrenheit,
        "°F",
        "degF",
        &["F", "fahrenheit", "Fahrenheit", "deg_F", "degf", "oF"],
    ),
    (Kelvin, "K", "K", &["kelvin", "Kelvin"]),
    (Degree, "°", "deg", &["degree", "degrees"]),
    (Radian, "rad", "rad", &["radian", "radians"]),
    (
        RadianPerSecond,
        "rad/s",
        "rad/s",
        &[
            "rad_s", "radps", "rad/sec", "rads-1", "rad.s-1", "rad·s-1", "rad*s-1",
        ],
    ),
    (
        DegreePerSecond,
        "°/s",
        "deg/s",
        &["dps", "deg_s", "deg/sec", "degs-1", "deg.s-1"],
    ),
    (
        DegreePerHour,
        "°/h",
        "deg/h",
        &["dph", "deg_h", "deg/hr", "deg/hour", "°/hr", "°/hour"],
    ),
    (Metre, "m", "m", &["metre", "metres", "meter"]),
    (Millimetre, "mm", "mm", &["millimetre", "millimetres"]),
    (
        Centimetre,
        "cm",
        "cm",
        &["centimetre", "centimetres", "centimeter"],
    ),
    (
        Micrometre,
        "µm",
        "um",
        &[
            "micrometre",
            "micrometres",
            "micrometer",
            "micron",
            "microns",
        ],
    ),
    (
        MetrePerSecond,
        "m/s",
        "m/s",
        &["mps", "m_s", "m_per_s", "m/sec"],
    ),
    (MillimetrePerSecond, "mm/s", "mm/s", &["mm_s", "mm_per_s"]),
    (CentimetrePerSecond, "cm/s", "cm/s", &["cm_s", "cm_per_s"]),
    (MicrometrePerSecond, "µm/s", "um/s", &["um_s", "um_per_s"]),
    (
        KilometrePerHour,
        "km/h",
        "km/h",
        &[
            "kmh", "kph", "kmph", "KPH", "Km/h", "KM/H", "km/hr", "km_h", "km_per_h",
        ],
    ),
    (
        MilePerHour,
        "mi/h",
        "mi/h",
        &["mph", "MPH", "mi_h", "mi_per_h"],
    ),
    (
        Turn,
        "turn",
        "turn",
        &["turns", "rev", "revs", "revolution", "revolutions"],
    ),
    (
        TurnPerMinute,
        "r/min",
        "r/min",
        &["rpm", "RPM", "rev/min", "turn/min", "1/min"],
    ),
    (Newton, "N", "N", &["newton", "newtons"]),
    (PoundForce, "lbf", "lbf", &["lb_f", "pound-force"]),
    (Pascal, "Pa", "Pa", &["pascal", "pascals"]),
    (PoundPerSquareInch, "psi", "psi", &["PSI", "lbf/in2"]),
    (
        VoltPerRootHertz,
        "V/√Hz",
        "V/sqrt(Hz)",
        &["V/rtHz", "V/Hz1/2", "V/sqrtHz"],
    ),
    (
        MicrovoltPerRootHertz,
        "µV/√Hz",
        "uV/sqrt(Hz)",
        &["uV/rtHz", "uV/Hz1/2", "uV/sqrtHz"],
    ),
    (One, "1", "1", &["-", "none", "dimensionless", "s/s"]),
];

fn plain(text: &str) -> String {
    text.chars()
        .filter(|c| !c.is_whitespace() && *c != '^')
        .map(|c| match c {
            '²' => '2',
            'µ' | 'μ' => 'u',
            '⁻' | '−' => '-',
            c => c,
        })
        .collect()
}

impl Unit {
    /// The unit of acceleration in which gravity is so large, `within` a part of it.
    ///
    /// ```
    /// use proofmass_io::Unit;
    /// assert_eq!(Unit::of_gravity(998.0, 0.02), Some(Unit::MilliGravity));
    /// assert_eq!(Unit::of_gravity(42.0, 0.15), None);
    /// ```
    pub fn of_gravity(norm: f64, within: f64) -> Option<Self> {
        let units = [
            Self::MetrePerSecondSquared,
            Self::StandardGravity,
            Self::MilliGravity,
            Self::Gal,
            Self::MillimetrePerSecondSquared,
        ];
        let near = |unit: &Self| (norm * unit.si().1 / STANDARD_GRAVITY - 1.0).abs() < within;
        units.into_iter().find(near)
    }

    /// Every unit.
    pub fn all() -> impl Iterator<Item = Self> {
        SPELLINGS.iter().map(|(unit, ..)| *unit)
    }

    /// Reads a usual spelling; `None` when it is not one.
    pub fn recognise(text: &str) -> Option<Self> {
        let text = plain(text);
        if text.is_empty() {
            return None;
        }
        SPELLINGS
            .iter()
            .find(|(_, printed, ascii, others)| {
                text == plain(printed) || text == *ascii || others.iter().any(|o| text == plain(o))
            })
            .map(|&(unit, ..)| unit)
    }

    /// The unit of a header's suffix, such as `acc_x_g`; stricter than [`Unit::recognise`] because single letters
    /// that name axes or channels must not turn into units.
    fn recognise_suffix(name: &str, text: &str) -> Option<Self> {
        let unit = Self::recognise(text)?;
        // A letter that is more often something else is a unit where the name says the quantity.
        let begins = |words: &[&str]| {
            let name = name.to_lowercase();
            words.iter().any(|word| name.starts_with(word))
        };
        match unit {
            Newton | PoundForce => {
                return (text != "N" || begins(&["force", "load", "hammer", "impact"]))
                    .then_some(unit);
            }
            Metre if text == "m" => {
                let lengths = ["position", "displacement", "distance", "way", "travel"];
                return begins(&lengths).then_some(unit);
            }
            Minute | Hour | Day => {
                return begins(&["time", "t_", "elapsed", "uptime"]).then_some(unit);
            }
            _ => {}
        }
        let ambiguous = matches!(
            text,
            "1" | "-" | "none" | "A" | "C" | "F" | "G" | "raw" | "adc" | "K" | "gn" | "g0"
        );
        (!ambiguous).then_some(unit)
    }

    /// The SI unit this one converts to, and the factor: value in SI = factor × value.
    ///
    /// Units without one (count, °C, °F, pure numbers) return themselves and one, as do pC and pF, whose SI units share a letter with
    /// temperatures.
    pub fn si(self) -> (Self, f64) {
        match self {
            MillimetrePerSecondSquared => (MetrePerSecondSquared, 1e-3),
            StandardGravity => (MetrePerSecondSquared, STANDARD_GRAVITY),
            // Written out: 1e-3 * 9.80665 rounds twice.
            MilliGravity => (MetrePerSecondSquared, 9.806_65e-3),
            MicroGravity => (MetrePerSecondSquared, 9.806_65e-6),
            Gal => (MetrePerSecondSquared, 1e-2),
            Millivolt => (Volt, 1e-3),
            Microvolt => (Volt, 1e-6),
            Milliampere => (Ampere, 1e-3),
            Microampere => (Ampere, 1e-6),
            Nanoampere => (Ampere, 1e-9),
            Millisecond => (Second, 1e-3),
            Microsecond => (Second, 1e-6),
            Nanosecond => (Second, 1e-9),
            Minute => (Second, 60.0),
            Hour => (Second, 3600.0),
            Day => (Second, 86_400.0),
            InchPerSecondSquared => (MetrePerSecondSquared, 0.0254),
            FootPerSecondSquared => (MetrePerSecondSquared, 0.3048),
            // Exact: pound of 0.453 592 37 kg, standard gravity, inch of 0.0254 m.
            PoundForce => (Newton, 4.448_221_615_260_5),
            PoundPerSquareInch => (Pascal, 4.448_221_615_260_5 / 0.000_645_16),
            MicrovoltPerRootHertz => (VoltPerRootHertz, 1e-6),
            Degree => (Radian, std::f64::consts::PI / 180.0),
            DegreePerSecond => (RadianPerSecond, std::f64::consts::PI / 180.0),
            DegreePerHour => (RadianPerSecond, std::f64::consts::PI / 648_000.0),
            Millimetre => (Metre, 1e-3),
            Centimetre => (Metre, 1e-2),
            Micrometre => (Metre, 1e-6),
            MillimetrePerSecond => (MetrePerSecond, 1e-3),
            CentimetrePerSecond => (MetrePerSecond, 1e-2),
            MicrometrePerSecond => (MetrePerSecond, 1e-6),
            KilometrePerHour => (MetrePerSecond, 1.0 / 3.6),
            MilePerHour => (MetrePerSecond, 0.447_04),
            Turn => (Radian, std::f64::consts::TAU),
            TurnPerMinute => (RadianPerSecond, std::f64::consts::TAU / 60.0),
            other => (other, 1.0),
        }
    }

    /// Whether it is a unit of acceleration.
    pub fn is_acceleration(self) -> bool {
        self.si().0 == MetrePerSecondSquared
    }

    /// Whether it is a unit of time.
    pub fn is_time(self) -> bool {
        self.si().0 == Second
    }

    /// Whether it is a raw output (counts, volts, currents, charge, capacitance), whose scale only a calibration knows.
    pub fn is_raw(self) -> bool {
        matches!(self.si().0, Count | Volt | Ampere | Picocoulomb | Picofarad)
    }

    /// Plain ASCII spelling, for column names.
    pub fn ascii(self) -> &'static str {
        self.entry().2
    }

    /// What else is read as this unit, beside how it is printed and [`ascii`](Self::ascii).
    pub fn aliases(self) -> &'static [&'static str] {
        self.entry().3
    }

    fn entry(self) -> &'static (Unit, &'static str, &'static str, &'static [&'static str]) {
        SPELLINGS
            .iter()
            .find(|(unit, ..)| *unit == self)
            .expect("every unit has its spelling (checked by a test)")
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.entry().1)
    }
}

impl FromStr for Unit {
    type Err = String;

    /// By any of its spellings.
    fn from_str(text: &str) -> Result<Self, String> {
        Self::recognise(text).ok_or_else(|| {
            format!(
                "{text:?} is no known unit (m/s², g, mg, µg, in/s², m/s, km/h, m, mm, rad, °, turn, rad/s, °/s, °/h, r/min, N, lbf, Pa, psi, °C, °F, V, mV, µV/√Hz, mA, pC, pF, count, 1 for fractional frequencies, …)"
            )
        })
    }
}

impl Serialize for Unit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Unit {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Unit".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "Unit, such as m/s², g, mg, count, V, mV, pC.",
            "type": "string"
        })
    }
}

impl<'de> Deserialize<'de> for Unit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::recognise(&text).ok_or_else(|| {
            serde::de::Error::custom(format!(
                "unknown unit \"{text}\"; known: m/s², mm/s², in/s², g, mg, µg, Gal, count, V, mV, µV, mA, nA, pC, pF"
            ))
        })
    }
}

/// Splits a column heading into its name and the unit it carries.
///
/// `acc_x (m/s²)`, `acc_x [g]`, `acc_x, mg`, `acc_x_m/s2`, `T_degC` are understood. The name keeps no trailing
/// separator; a heading without a known unit is returned whole.
///
/// ```
/// use proofmass_io::{Unit, split_heading};
/// assert_eq!(split_heading("acc_x_m/s2"), ("acc_x", Some(Unit::MetrePerSecondSquared)));
/// assert_eq!(split_heading("t (ms)"), ("t", Some(Unit::Millisecond)));
/// assert_eq!(split_heading("acc_x"), ("acc_x", None));
/// assert_eq!(split_heading("acc[1]"), ("acc[1]", None));
/// ```
pub fn split_heading(heading: &str) -> (&str, Option<Unit>) {
    let heading = heading.trim();
    for (open, close) in [('(', ')'), ('[', ']'), ('{', '}'), ('<', '>')] {
        if let Some(inner) = heading.strip_suffix(close)
            && let Some((at, unit)) = inner
                .match_indices(open)
                .find_map(|(at, _)| Some((at, Unit::recognise(&inner[at + open.len_utf8()..])?)))
        {
            // `acc[1]` is the second of several, `ratio [1]` a ratio.
            let index = open == '[' && unit == Unit::One;
            if index && inner[..at].ends_with(|c: char| c.is_alphanumeric() || c == ']') {
                return (heading, None);
            }
            // `s_V/(m/s2)`: of the quotient of two units none is known.
            if inner[..at].ends_with('/') {
                break;
            }
            return (inner[..at].trim_end_matches([' ', '_']), Some(unit));
        }
    }
    // `_m_s2` before `_s2`: the longest suffix that is a unit wins.
    for (at, mark) in heading
        .char_indices()
        .filter(|(_, c)| matches!(c, '_' | ',' | ' ' | '/'))
    {
        if at == 0 || mark == '/' {
            continue;
        }
        if let Some(unit) = Unit::recognise_suffix(heading, &heading[at + mark.len_utf8()..]) {
            return (
                heading[..at].trim_end_matches([' ', '_', ',', '/']),
                Some(unit),
            );
        }
    }
    // The name of `s (mV/g)`, too, stands alone.
    let ratio = UnitRatio::split_heading(heading);
    (ratio.map_or(heading, |(name, _)| name), None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    #[test]
    fn law_every_spelling_reads_back() {
        for (unit, printed, ascii, others) in SPELLINGS {
            for text in [printed, ascii].into_iter().chain(others.iter()) {
                assert_eq!(Unit::recognise(text), Some(*unit), "{text}");
            }
            assert_eq!(unit.to_string().parse::<Unit>().ok(), Some(*unit));
        }
    }

    /// The units of a model file (crate uncertainty) are composed of symbols, these are labels of columns: two tables. Where
    /// both know a label, either the factor is the same or the model file says that the dimensions do not fit: `g` is the
    /// gram there.
    #[test]
    fn crosscheck_units_of_model_files() {
        use proofmass_uncertainty::{Evaluate, Trials, UncertaintyModel};
        let mut same = 0;
        let mut said = Vec::new();
        for (unit, printed, ascii, others) in SPELLINGS {
            let (si, factor) = unit.si();
            for label in [printed, ascii].into_iter().chain(others.iter()) {
                let text = format!(
                    "units = \"convert\"\n[[input]]\nname = \"x\"\nunit = \"{label}\"\nvalue = 1\nu = 0.1\n\
                     [[output]]\nname = \"y\"\nunit = \"{si}\"\nexpression = \"x\"\n"
                );
                let model: UncertaintyModel = toml::from_str(&text).unwrap();
                let options = Evaluate {
                    trials: Trials::Fixed(10_000),
                    ..Evaluate::default()
                };
                // A label that is no unit there is refused.
                let Ok(result) = model.evaluate(&options, &mut |_| ControlFlow::Continue(()))
                else {
                    continue;
                };
                if result
                    .findings
                    .iter()
                    .any(|f| f.code() == "units-do-not-fit")
                {
                    said.push(*label);
                    continue;
                }
                let value = result.outputs[0].linear.as_ref().unwrap().quantity.value;
                // Per minute is a speed of rotation only in a recording.
                if *label == "1/min" {
                    assert!((value * 60.0 - 1.0).abs() < 1e-12);
                    continue;
                }
                assert!(
                    (value / factor - 1.0).abs() < 1e-12,
                    "{label}: {value} there, {factor} here"
                );
                same += 1;
            }
        }
        assert!(same >= 60, "{same}");
        let grams = ["g", "g", "g0", "mg", "mg", "mg0", "µg", "ug", "ug0"];
        assert_eq!(said[2..said.len() - 1], grams);
        assert_eq!(said[..2], ["ms2", "ms-2"]);
        assert_eq!(said[said.len() - 1], "C");
    }

    #[test]
    fn headings_of_all_shapes() {
        for (heading, name, unit) in [
            ("acc_x_m/s2", "acc_x", Some(MetrePerSecondSquared)),
            ("acc_x (m/s²)", "acc_x", Some(MetrePerSecondSquared)),
            ("acc_x [g]", "acc_x", Some(StandardGravity)),
            ("acc_x_g", "acc_x", Some(StandardGravity)),
            ("time_s", "time", Some(Second)),
            ("t (ms)", "t", Some(Millisecond)),
            ("frequency_Hz", "frequency", Some(Hertz)),
            ("T_degC", "T", Some(DegreeCelsius)),
            ("temperature_deg_C", "temperature", Some(DegreeCelsius)),
            ("inclination_deg", "inclination", Some(Degree)),
            ("acc_x_m_s2", "acc_x", Some(MetrePerSecondSquared)),
            ("ax_ms2", "ax", Some(MetrePerSecondSquared)),
            ("acc_x", "acc_x", None),
            ("g", "g", None),
            ("channel 1", "channel 1", None),
            ("Voltage (V)", "Voltage", Some(Volt)),
            ("gyr_x_rad/s", "gyr_x", Some(RadianPerSecond)),
            ("force_N", "force", Some(Newton)),
            ("force (N)", "force", Some(Newton)),
            ("force / N", "force", Some(Newton)),
            ("position_m", "position", Some(Metre)),
            ("acc_m", "acc_m", None),
            ("acc_N", "acc_N", None),
            ("acc_min", "acc_min", None),
            ("time_h", "time", Some(Hour)),
            ("p [psi]", "p", Some(PoundPerSquareInch)),
            ("hammer_lbf", "hammer", Some(PoundForce)),
            ("a (in/s²)", "a", Some(InchPerSecondSquared)),
            ("T (°F)", "T", Some(DegreeFahrenheit)),
            ("noise (µV/√Hz)", "noise", Some(MicrovoltPerRootHertz)),
            ("noise (uV/sqrt(Hz))", "noise", Some(MicrovoltPerRootHertz)),
            ("acc_x_LSB", "acc_x", Some(Count)),
            ("s_V/(m/s2)", "s", None),
            ("s V/(m/s²)", "s", None),
            ("a/(m/s2)", "a/(m/s2)", None),
        ] {
            assert_eq!(split_heading(heading), (name, unit), "{heading}");
        }
    }
}

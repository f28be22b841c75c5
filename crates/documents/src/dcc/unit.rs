//! Units in the notation of D-SI: `\milli\volt\second\tothe{2}\metre\tothe{-1}`.

use proofmass_io::Unit;
use proofmass_io::sheet::{ACCELERATION_RATIO, COUNT_SENSITIVITY, Endings, SENSITIVITY};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Word and symbol of the units; those of the SI brochure, and the standard acceleration of free fall.
const UNITS: &[(&str, &str)] = &[
    ("metre", "m"),
    ("kilogram", "kg"),
    ("gram", "gram"),
    ("second", "s"),
    ("ampere", "A"),
    ("kelvin", "K"),
    ("mole", "mol"),
    ("candela", "cd"),
    ("one", ""),
    ("hertz", "Hz"),
    ("volt", "V"),
    ("coulomb", "C"),
    ("radian", "rad"),
    ("degree", "°"),
    ("steradian", "sr"),
    ("newton", "N"),
    ("pascal", "Pa"),
    ("joule", "J"),
    ("watt", "W"),
    ("farad", "F"),
    ("ohm", "Ω"),
    ("siemens", "S"),
    ("weber", "Wb"),
    ("tesla", "T"),
    ("henry", "H"),
    ("lumen", "lm"),
    ("lux", "lx"),
    ("degreecelsius", "°C"),
    ("degreeCelsius", "°C"),
    ("percent", "%"),
    ("ppm", "ppm"),
    ("minute", "min"),
    ("hour", "h"),
    ("day", "d"),
    ("litre", "l"),
    ("tonne", "t"),
    ("bar", "bar"),
    ("electronvolt", "eV"),
    ("decibel", "dB"),
    ("neper", "Np"),
    ("bit", "bit"),
    ("byte", "B"),
    ("arcminute", "′"),
    ("arcsecond", "″"),
    ("gn", "gₙ"),
    ("standardgravity", "gₙ"),
];

const PREFIXES: &[(&str, &str, i32)] = &[
    ("deca", "da", 1),
    ("hecto", "h", 2),
    ("kilo", "k", 3),
    ("mega", "M", 6),
    ("giga", "G", 9),
    ("deci", "d", -1),
    ("centi", "c", -2),
    ("milli", "m", -3),
    ("micro", "µ", -6),
    ("nano", "n", -9),
    ("pico", "p", -12),
    ("femto", "f", -15),
];

/// One factor of a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Factor {
    prefix: Option<usize>,
    symbol: &'static str,
    power: i32,
}

/// Powers of units, and the power of ten in front.
type Powers = (BTreeMap<&'static str, i32>, i32);

/// A unit as a certificate states it.
#[derive(Clone, Debug, PartialEq)]
pub struct DsiUnit {
    text: String,
    /// The one or two ways to read it: behind `\per` stands one unit, or all up to the next.
    readings: Vec<Vec<Factor>>,
}

impl DsiUnit {
    /// Reads a unit; of a text in another notation the text alone is known.
    pub(crate) fn new(text: &str) -> Self {
        let mut readings = Vec::new();
        for all in [false, true] {
            match factors(text, all) {
                Some(reading) if !readings.contains(&reading) => readings.push(reading),
                _ => {}
            }
        }
        Self {
            text: text.to_owned(),
            readings,
        }
    }

    /// As it stands in the certificate.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// As people write it: `mV·s²/m` for `\milli\volt\second\tothe{2}\metre\tothe{-1}`; a text in another notation as it stands.
    pub fn symbol(&self) -> String {
        // As the one unit that is read in two ways is told from the other, its text is shown.
        let [reading] = &self.readings[..] else {
            return self.text.clone();
        };
        let mut above = Vec::new();
        let mut below = Vec::new();
        for f in reading.iter().filter(|f| !f.symbol.is_empty()) {
            let prefix = f.prefix.map_or("", |p| PREFIXES[p].1);
            let mut word = format!("{prefix}{}", f.symbol);
            if f.power.abs() != 1 {
                word += &proofmass_uncertainty::superscript(f.power.abs());
            }
            if f.power < 0 { &mut below } else { &mut above }.push(word);
        }
        let numerator = match above.is_empty() {
            true => "1".to_owned(),
            false => above.join("·"),
        };
        match &below[..] {
            [] => numerator,
            [one] => format!("{numerator}/{one}"),
            many => format!("{numerator}/({})", many.join("·")),
        }
    }

    fn powers(&self) -> impl Iterator<Item = Powers> {
        self.readings.iter().map(|reading| {
            let mut powers = BTreeMap::new();
            let mut ten = 0;
            for f in reading.iter().filter(|f| !f.symbol.is_empty()) {
                *powers.entry(f.symbol).or_insert(0) += f.power;
                ten += f.prefix.map_or(0, |p| PREFIXES[p].2) * f.power;
            }
            powers.retain(|_, power| *power != 0);
            (powers, ten)
        })
    }

    /// The power of ten in front of exactly this product of units.
    fn times(&self, wanted: &[(&'static str, i32)]) -> Option<i32> {
        let wanted: BTreeMap<_, _> = wanted.iter().copied().collect();
        let mut found = self.powers().filter(|(powers, _)| *powers == wanted);
        found.next().map(|(_, ten)| ten)
    }

    /// What a number in this unit is multiplied with to stand in the product of two others; `None` where it is another quantity.
    pub(crate) fn factor_to_product(&self, a: &Self, b: &Self) -> Option<f64> {
        let products = a.powers().flat_map(|(a, ten_a)| {
            b.powers().map(move |(b, ten_b)| {
                let mut both = a.clone();
                for (symbol, power) in b {
                    *both.entry(symbol).or_insert(0) += power;
                }
                both.retain(|_, power| *power != 0);
                (both, ten_a + ten_b)
            })
        });
        let products: Vec<Powers> = products.collect();
        self.powers().find_map(|(own, own_ten)| {
            let (_, of_both) = products.iter().find(|(powers, _)| *powers == own)?;
            Some(ten(own_ten - of_both))
        })
    }

    /// Factor to Hz.
    pub(crate) fn frequency(&self) -> Option<f64> {
        self.times(&[("Hz", 1)]).map(ten)
    }

    /// Factor to rad.
    pub(crate) fn angle(&self) -> Option<f64> {
        let degrees = self.times(&[("°", 1)]).filter(|t| *t == 0);
        let degrees = degrees.map(|_| proofmass_io::sheet::DEGREE);
        degrees.or_else(|| self.times(&[("rad", 1)]).map(ten))
    }

    /// Whether it is that of a charge per acceleration: the sensitivity of a sensor without its amplifier.
    pub(crate) fn is_charge_per_acceleration(&self) -> bool {
        self.times(&[("C", 1), ("m", -1), ("s", 2)]).is_some()
    }

    /// What a device with this sensitivity gives, and the factor to that per m/s²: the factor of a table of a laboratory in the same unit.
    pub(crate) fn sensitivity(&self) -> Option<(Unit, f64)> {
        let named =
            |endings: Endings, name: &str| endings.iter().find(|e| e.0 == name).map(|e| e.1);
        // A unit that is none of the SI stands behind a bar, as people write it.
        if let Some(word) = self.text.strip_prefix('|') {
            let word = word.replace('²', "2").replace(['_', ' '], "");
            let word = word.replace("gₙ", "g").replace("gn", "g");
            let kinds = [
                (Unit::Volt, SENSITIVITY),
                (Unit::MetrePerSecondSquared, ACCELERATION_RATIO),
                (Unit::Count, COUNT_SENSITIVITY),
            ];
            let mut found = kinds
                .into_iter()
                .filter_map(|(unit, endings)| Some((unit, named(endings, &word)?)));
            return found.next();
        }
        let volt = |of: &[(&'static str, i32)], one: &str, milli: &str| match self.times(of)? {
            0 => named(SENSITIVITY, one),
            -3 => named(SENSITIVITY, milli),
            other => Some(ten(other) * named(SENSITIVITY, one)?),
        };
        if let Some(factor) = volt(&[("V", 1), ("m", -1), ("s", 2)], "V/(m/s2)", "mV/(m/s2)") {
            return Some((Unit::Volt, factor));
        }
        if let Some(factor) = volt(&[("V", 1), ("gₙ", -1)], "V/g", "mV/g") {
            return Some((Unit::Volt, factor));
        }
        if let Some(power) = self.times(&[("m", -1), ("s", 2)]) {
            return Some((Unit::Count, ten(power)));
        }
        self.times(&[])
            .map(|power| (Unit::MetrePerSecondSquared, ten(power)))
    }
}

/// A power of ten as the nearest double.
fn ten(power: i32) -> f64 {
    format!("1e{power}").parse().unwrap_or(1.0)
}

/// The factors of a text, `None` for one in another notation.
fn factors(text: &str, per_takes_all: bool) -> Option<Vec<Factor>> {
    let mut words = text.strip_prefix('\\')?.split('\\').peekable();
    let mut factors: Vec<Factor> = Vec::new();
    let mut sign = 1;
    while let Some(word) = words.next() {
        if word == "per" {
            sign = -1;
            // It is followed by a unit.
            words.peek()?;
            continue;
        }
        let prefix = PREFIXES.iter().position(|p| p.0 == word);
        let word = match prefix {
            Some(_) => words.next()?,
            None => word,
        };
        let symbol = UNITS.iter().find(|u| u.0 == word)?.1;
        let mut power = 1;
        if let Some(next) = words.peek()
            && let Some(digits) = next.strip_prefix("tothe{")
        {
            power = digits.strip_suffix('}')?.parse().ok()?;
            if !(-24..=24).contains(&power) {
                return None;
            }
            words.next();
        }
        factors.push(Factor {
            prefix,
            symbol,
            power: sign * power,
        });
        if !per_takes_all {
            sign = 1;
        }
    }
    (!factors.is_empty()).then_some(factors)
}

/// Units of results as D-SI writes them, `None` for one that it does not know; counts are pure numbers.
///
/// ```
/// use proofmass_documents::dsi_text;
/// assert_eq!(dsi_text("mV/(m/s²)").unwrap(), "\\milli\\volt\\second\\tothe{2}\\metre\\tothe{-1}");
/// assert_eq!(dsi_text("°").unwrap(), "\\degree");
/// assert_eq!(dsi_text("parsec"), None);
/// ```
pub fn dsi_text(unit: &str) -> Option<String> {
    let unit = unit.trim();
    // In the order of the examples for accelerometers: the unit of the output, then s²/m.
    let text = match unit.strip_suffix("/(m/s²)") {
        Some("(m/s²)") => String::new(),
        Some(output) => format!(
            "{}\\second\\tothe{{2}}\\metre\\tothe{{-1}}",
            product(output, 1)?
        ),
        None => product(unit, 1)?,
    };
    Some(match text.is_empty() {
        true => "\\one".to_owned(),
        false => text,
    })
}

/// The factors of a unit, each to its power or, with a `sign` of −1, to the opposite of it. What stands behind a stroke is below it up to
/// the end of the unit: m/s²/K is m/(s²·K).
fn product(unit: &str, sign: i32) -> Option<String> {
    let (mut text, mut part, mut depth, mut below) = (String::new(), String::new(), 0, false);
    let mut add = |part: &mut String, below: bool| -> Option<()> {
        let sign = if below { -sign } else { sign };
        let whole = std::mem::take(part);
        // A power may stand behind brackets: (m/s²)².
        let powers = [(")", 1), (")²", 2), (")³", 3)];
        let inner = whole.strip_prefix('(').and_then(|rest| {
            let mut found = powers.iter();
            found.find_map(|(end, power)| Some((rest.strip_suffix(end)?, power)))
        });
        text += &match (inner, whole.as_str()) {
            (Some((inner, power)), _) => product(inner, sign * power)?,
            (None, "" | "1" | "count") => String::new(),
            (None, one) => word(one, sign)?,
        };
        Some(())
    };
    for c in unit.chars() {
        depth += i32::from(c == '(') - i32::from(c == ')');
        match c {
            '/' | '·' if depth == 0 => {
                add(&mut part, below)?;
                below |= c == '/';
            }
            c => part.push(c),
        }
    }
    add(&mut part, below)?;
    (depth == 0).then_some(text)
}

/// The square of a unit in the notation of D-SI, `None` for a text in another one.
///
/// ```
/// let square = proofmass_documents::dsi_squared("\\milli\\volt\\second\\tothe{2}").unwrap();
/// assert_eq!(square, "\\milli\\volt\\tothe{2}\\second\\tothe{4}");
/// ```
pub fn dsi_squared(text: &str) -> Option<String> {
    let mut square = String::new();
    for f in factors(text, false)? {
        let name = UNITS.iter().find(|u| u.1 == f.symbol)?.0;
        let prefix = f
            .prefix
            .map_or(String::new(), |p| format!("\\{}", PREFIXES[p].0));
        match f.symbol {
            "" => square.push_str("\\one"),
            _ => square.push_str(&format!("{prefix}\\{name}\\tothe{{{}}}", 2 * f.power)),
        }
    }
    Some(square)
}

/// A symbol with prefix and power.
fn word(symbol: &str, sign: i32) -> Option<String> {
    let (symbol, power) = match symbol.chars().last()? {
        '²' => (symbol.trim_end_matches('²'), 2),
        '³' => (symbol.trim_end_matches('³'), 3),
        _ => (symbol, 1),
    };
    let unit = |s: &str| {
        let found = UNITS.iter().find(|u| u.1 == s && !s.is_empty());
        found.map(|u| u.0)
    };
    let mut text = match unit(symbol) {
        Some(name) => format!("\\{name}"),
        None => {
            let mut prefixed = PREFIXES.iter().filter_map(|p| {
                let rest = symbol.strip_prefix(p.1)?;
                Some(format!("\\{}\\{}", p.0, unit(rest)?))
            });
            prefixed.next_back()?
        }
    };
    if sign * power != 1 {
        let _ = write!(text, "\\tothe{{{}}}", sign * power);
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_units_of_the_examples_for_accelerometers() {
        // The same quantity in two orders of its factors; [DSI-Acceleration] examples 7, 8, 12.
        for (text, symbol) in [
            ("\\hertz", "Hz"),
            ("\\degree", "°"),
            ("\\metre\\second\\tothe{-2}", "m/s²"),
            (
                "\\milli\\volt\\second\\tothe{2}\\metre\\tothe{-1}",
                "mV·s²/m",
            ),
            (
                "\\pico\\coulomb\\metre\\tothe{-1}\\second\\tothe{2}",
                "pC·s²/m",
            ),
            ("\\volt\\milli\\volt\\tothe{-1}", "V/mV"),
            ("\\one", "1"),
            ("mV/g", "mV/g"),
        ] {
            assert_eq!(DsiUnit::new(text).symbol(), symbol);
        }
    }

    #[test]
    fn known_sensitivities_have_the_factors_of_tables() {
        let g = proofmass_core::STANDARD_GRAVITY;
        for (text, unit, factor) in [
            (
                "\\volt\\second\\tothe{2}\\metre\\tothe{-1}",
                Unit::Volt,
                1.0,
            ),
            (
                "\\milli\\volt\\metre\\tothe{-1}\\second\\tothe{2}",
                Unit::Volt,
                1e-3,
            ),
            (
                "\\micro\\volt\\second\\tothe{2}\\per\\metre",
                Unit::Volt,
                1e-6,
            ),
            (
                "\\milli\\volt\\per\\metre\\second\\tothe{2}",
                Unit::Volt,
                1e-3,
            ),
            (
                "\\milli\\volt\\per\\metre\\second\\tothe{-2}",
                Unit::Volt,
                1e-3,
            ),
            (
                "\\milli\\volt\\per\\metre\\per\\second\\tothe{-2}",
                Unit::Volt,
                1e-3,
            ),
            ("\\milli\\volt\\gn\\tothe{-1}", Unit::Volt, 1e-3 / g),
            ("|mV/g", Unit::Volt, 1e-3 / g),
            ("|mV/gn", Unit::Volt, 1e-3 / g),
            ("|mV/(m/s²)", Unit::Volt, 1e-3),
            ("\\one", Unit::MetrePerSecondSquared, 1.0),
            ("\\metre\\tothe{-1}\\second\\tothe{2}", Unit::Count, 1.0),
        ] {
            assert_eq!(
                DsiUnit::new(text).sensitivity(),
                Some((unit, factor)),
                "{text}"
            );
        }
        for text in [
            "\\volt\\metre\\tothe{-1}",
            "\\pico\\coulomb\\second\\tothe{2}\\metre\\tothe{-1}",
            "\\volt",
            "mV/g",
            "\\volt\\per",
            "\\milli",
            "\\volt\\tothe{99999}",
            "",
            "|",
            "\\",
        ] {
            assert_eq!(DsiUnit::new(text).sensitivity(), None, "{text}");
        }
        assert_eq!(DsiUnit::new("\\kilo\\hertz").frequency(), Some(1e3));
        assert_eq!(DsiUnit::new("\\second\\tothe{-1}").frequency(), None);
        assert_eq!(DsiUnit::new("\\radian").angle(), Some(1.0));
        assert_eq!(DsiUnit::new("\\milli\\radian").angle(), Some(1e-3));
        assert_eq!(
            DsiUnit::new("\\degree").angle(),
            Some(proofmass_io::sheet::DEGREE)
        );
    }

    #[test]
    fn law_units_of_results_are_read_as_they_were_written() {
        for (unit, symbol) in [
            ("mV/(m/s²)", "mV·s²/m"),
            ("V/(m/s²)", "V·s²/m"),
            ("(m/s²)/(m/s²)", "1"),
            ("count/(m/s²)", "s²/m"),
            ("count", "1"),
            ("1/K", "1/K"),
            ("(m/s²)/V", "m/(s²·V)"),
            ("V/°C", "V/°C"),
            ("m/s²/K", "m/(s²·K)"),
            ("(m/s²)/K", "m/(s²·K)"),
            ("(m/s²)/K²", "m/(s²·K²)"),
            ("m/(s²·K)", "m/(s²·K)"),
            ("V/(m/s²)/K", "V·s²/(m·K)"),
            ("1/(m/s²)", "s²/m"),
            ("1/(m/s²)²", "s⁴/m²"),
            ("1/K", "1/K"),
            ("", "1"),
            ("1", "1"),
            ("mV", "mV"),
            ("m/s²", "m/s²"),
            ("rad", "rad"),
            ("mrad", "mrad"),
            ("°C", "°C"),
            ("%", "%"),
            ("kHz", "kHz"),
        ] {
            let text = dsi_text(unit).expect(unit);
            assert_eq!(DsiUnit::new(&text).symbol(), symbol, "{unit}");
        }
        for no in ["parsec", "m/(s²", "m)/s", "m^2", "mV/g", "m/s²)"] {
            assert_eq!(dsi_text(no), None, "{no}");
        }
    }
}

//! How a result is printed: GUM 7.2, with digits that say what is known and no more.

use crate::Quantity;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Write as _};

/// How the uncertainty stands beside the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Notation {
    /// `0.0312(14) m/s²`: the standard uncertainty in units of the last digit. **Source** `[GUM] 7.2.2`.
    Concise,
    /// `0.0312 ± 0.0028 m/s² (k = 2.03, 95 %)`: the expanded uncertainty. **Source** `[GUM] 7.2.4`.
    Expanded {
        /// Coverage probability, between 0 and 1.
        probability: f64,
    },
}

/// Characters that may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alphabet {
    /// `±`, `×10⁻⁶`, `m/s²`.
    Unicode,
    /// `+/-`, `e-6`, `m/s^2`: for logs, old terminals and instruments.
    Ascii,
}

/// The mark between the whole number and its decimals. **Source** `[ISO80000-1] 7.3.2` admits both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum DecimalMark {
    /// `0.5`
    #[serde(rename = "point", alias = ".")]
    Point,
    /// `0,5`
    #[serde(rename = "comma", alias = ",")]
    Comma,
}

impl fmt::Display for DecimalMark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Point => "point",
            Self::Comma => "comma",
        })
    }
}

/// Whether the degrees of freedom stand beside k in the expanded notation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShowDof {
    /// `(k = 2.03, 95 %)`
    No,
    /// `(k = 2.03, ν = 36.1, 95 %)`
    Yes,
}

/// How to print a quantity; the default is `0.0312(14) m/s²`.
///
/// The uncertainty is rounded to `digits` significant digits (half to even, as decimal numbers a person can
/// check, so 0.0996 becomes 0.10) and the value to the same place. Powers of ten appear when the rounding place
/// lies left of the decimal mark or the number would begin with more than three zeros.
///
/// ```
/// use proofmass_uncertainty::{DegreesOfFreedom, Format, Quantity};
///
/// let bias = Quantity {
///     name: "bias.x".into(),
///     unit: "m/s²".into(),
///     value: 0.03124,
///     standard_uncertainty: 0.00139,
///     dof: DegreesOfFreedom::new(36.0).unwrap(),
/// };
/// assert_eq!(bias.to_string(), "0.0312(14) m/s²");
/// assert_eq!(
///     bias.display(&Format::expanded(0.95)).to_string(),
///     "0.0312 ± 0.0028 m/s² (k = 2.03, 95 %)"
/// );
/// assert_eq!(
///     bias.display(&Format::concise().ascii().decimal_comma()).to_string(),
///     "0,0312(14) m/s^2"
/// );
/// ```
///
/// **Source** `[GUM] 7.2.2, 7.2.4, 7.2.6`; rounding `[ISO80000-1] B.3`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Format {
    /// Significant digits of the uncertainty, 1 to 15.
    pub(crate) digits: usize,
    /// Concise or expanded.
    pub(crate) notation: Notation,
    /// Unicode or ASCII.
    pub(crate) alphabet: Alphabet,
    /// Point or comma.
    pub(crate) decimal: DecimalMark,
    /// Degrees of freedom beside k.
    pub(crate) dof: ShowDof,
}

impl Default for Format {
    fn default() -> Self {
        Self::concise()
    }
}

impl Format {
    /// Value with the standard uncertainty in parentheses.
    pub fn concise() -> Self {
        Self {
            digits: 2,
            notation: Notation::Concise,
            alphabet: Alphabet::Unicode,
            decimal: DecimalMark::Point,
            dof: ShowDof::No,
        }
    }

    /// Value ± expanded uncertainty for a coverage probability such as 0.95.
    pub fn expanded(probability: f64) -> Self {
        Self {
            notation: Notation::Expanded { probability },
            ..Self::concise()
        }
    }

    /// Another number of significant digits of the uncertainty; kept between 1 and 15.
    #[must_use]
    pub fn digits(self, digits: usize) -> Self {
        Self {
            digits: digits.clamp(1, 15),
            ..self
        }
    }

    /// Only ASCII characters.
    #[must_use]
    pub fn ascii(self) -> Self {
        Self {
            alphabet: Alphabet::Ascii,
            ..self
        }
    }

    /// Decimal comma.
    #[must_use]
    pub fn decimal_comma(self) -> Self {
        Self {
            decimal: DecimalMark::Comma,
            ..self
        }
    }

    /// Degrees of freedom beside k.
    #[must_use]
    pub fn with_dof(self) -> Self {
        Self {
            dof: ShowDof::Yes,
            ..self
        }
    }

    fn mark(&self, text: String) -> String {
        match self.decimal {
            DecimalMark::Point => text,
            DecimalMark::Comma => text.replace('.', ","),
        }
    }

    fn unit(&self, unit: &str) -> String {
        match (unit, self.alphabet) {
            ("" | "1", _) => String::new(),
            (unit, Alphabet::Unicode) => format!(" {unit}"),
            (unit, Alphabet::Ascii) => format!(" {}", ascii_unit(unit)),
        }
    }

    fn power(&self, exponent: i32) -> String {
        match (exponent, self.alphabet) {
            (0, _) => String::new(),
            (e, Alphabet::Ascii) => format!("e{e}"),
            (e, Alphabet::Unicode) => format!("×10{}", crate::superscript(e)),
        }
    }

    /// An uncertainty by itself, with its digits and its power of ten.
    fn alone(&self, u: f64) -> String {
        match Rounded::new(u, u, self.digits) {
            Some(r) => format!("{}{}", self.mark(r.value), self.power(r.exponent)),
            None => u.to_string(),
        }
    }

    fn render(&self, quantity: &Quantity) -> String {
        let unit = self.unit(&quantity.unit);
        let u = quantity.standard_uncertainty;
        if u == 0.0 {
            let value = shortest(quantity.value);
            return format!("{}{unit} (exact)", self.mark(value));
        }
        match self.notation {
            Notation::Concise => match Rounded::new(quantity.value, u, self.digits) {
                Some(rounded) => format!(
                    "{}({}){}{unit}",
                    self.mark(rounded.value.clone()),
                    self.mark(rounded.last_digits()),
                    self.power(rounded.exponent)
                ),
                None => {
                    let value = self.mark(shortest(quantity.value));
                    format!("{value}{unit} (u = {}{unit})", self.alone(u))
                }
            },
            Notation::Expanded { probability } => {
                let k = quantity.coverage_factor(probability);
                let (plus_minus, nu) = match self.alphabet {
                    Alphabet::Unicode => ("±", "ν"),
                    Alphabet::Ascii => ("+/-", "nu"),
                };
                let body = match Rounded::new(quantity.value, k * u, self.digits) {
                    Some(r) if r.exponent == 0 => {
                        format!("{} {plus_minus} {}", r.value, r.uncertainty)
                    }
                    Some(r) => format!(
                        "({} {plus_minus} {}){}",
                        r.value,
                        r.uncertainty,
                        self.power(r.exponent)
                    ),
                    None => format!(
                        "{} {plus_minus} {}",
                        shortest(quantity.value),
                        self.alone(k * u)
                    ),
                };
                let dof = match (self.dof, self.alphabet) {
                    (ShowDof::No, _) => String::new(),
                    (ShowDof::Yes, Alphabet::Ascii) if quantity.dof.is_infinite() => {
                        format!("{nu} = inf, ")
                    }
                    (ShowDof::Yes, _) => format!("{nu} = {}, ", quantity.dof),
                };
                // Two comma-separated numbers in a locale with a decimal comma need the semicolon.
                let note = match self.decimal {
                    DecimalMark::Point => format!("(k = {k:.2}, {dof}{} %)", percent(probability)),
                    DecimalMark::Comma => {
                        let dof = dof.replace(", ", "; ");
                        format!("(k = {k:.2}; {dof}{} %)", percent(probability))
                    }
                };
                self.mark(format!("{body}{unit} {note}"))
            }
        }
    }
}

/// A value and an uncertainty rounded to the same decimal place, as text, times a common power of ten.
///
/// ```
/// use proofmass_uncertainty::Rounded;
/// let r = Rounded::new(123_456.0, 1_300.0, 2).unwrap();
/// assert_eq!((r.value.as_str(), r.uncertainty.as_str(), r.exponent), ("1.235", "0.013", 5));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Rounded {
    /// The value, decimal point, without the power of ten.
    pub value: String,
    /// The uncertainty, decimal point, without the power of ten.
    pub uncertainty: String,
    /// Common power of ten; 0 when none is needed.
    pub exponent: i32,
}

impl Rounded {
    /// Rounds a value to the place that `digits` significant digits of its uncertainty give.
    ///
    /// `None` when the value is not finite, the uncertainty not finite and positive, or so small that the value would need
    /// more digits than a double has: 1 with an uncertainty of 10⁻¹⁷.
    pub fn new(value: f64, uncertainty: f64, digits: usize) -> Option<Self> {
        if !(value.is_finite() && uncertainty.is_finite() && uncertainty > 0.0) {
            return None;
        }
        let digits = digits.clamp(1, 15) as i32;
        let (u, v) = (Decimal::of(uncertainty), Decimal::of(value));
        let mut place = u.leading() - digits + 1;
        let mut u_digits = u.rounded(place);
        if u_digits.len() as i32 > digits {
            place += 1; // 0.0996 → 0.10
            u_digits = u.rounded(place);
        }
        let v_digits = v.rounded(place);
        if v_digits.len() > DOUBLE {
            return None;
        }
        let top = place + (u_digits.len().max(v_digits.len()) as i32) - 1;
        let exponent = if place <= 0 && top >= -4 { 0 } else { top };
        let decimals = (exponent - place) as usize;
        let negative = value < 0.0 && v_digits != "0";
        Some(Self {
            value: format!(
                "{}{}",
                if negative { "-" } else { "" },
                with_point(&v_digits, decimals)
            ),
            uncertainty: with_point(&u_digits, decimals),
            exponent,
        })
    }

    /// The uncertainty in units of the last digit, `14` for 0.0014; with its point, `1.4`, when it reaches past
    /// the decimal mark, since 5.3(14) would be read as 5.3 ± 0.14 by some and ± 1.4 by others.
    fn last_digits(&self) -> String {
        match self.uncertainty.strip_prefix("0.") {
            Some(decimals) => decimals.trim_start_matches('0').to_owned(),
            None => self.uncertainty.clone(),
        }
    }
}

/// Digits that name any double; more say nothing.
const DOUBLE: usize = 17;

/// Shortest decimal digits that name a double: d₀d₁… × 10^exponent, the last digit at 10^exponent.
struct Decimal {
    digits: Vec<u8>,
    exponent: i32,
}

impl Decimal {
    fn of(x: f64) -> Self {
        let text = format!("{:e}", x.abs());
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let digits: Vec<u8> = mantissa
            .bytes()
            .filter(u8::is_ascii_digit)
            .map(|b| b - b'0')
            .collect();
        let exponent = exponent.parse::<i32>().unwrap_or(0) - (digits.len() as i32 - 1);
        Self { digits, exponent }
    }

    fn leading(&self) -> i32 {
        self.exponent + self.digits.len() as i32 - 1
    }

    /// The integer nearest to x / 10^place, half to even, as digits without leading zeros.
    fn rounded(&self, place: i32) -> String {
        let keep = self.leading() - place + 1;
        let mut kept: Vec<u8> = (0..keep.max(0) as usize)
            .map(|i| self.digits.get(i).copied().unwrap_or(0))
            .collect();
        let dropped = match keep {
            0.. => self.digits.get(keep as usize..).unwrap_or(&[]),
            _ => &[], // below half a unit of the place
        };
        let odd = kept.last().is_some_and(|d| d % 2 == 1);
        let up = match dropped.first() {
            Some(d) if *d > 5 => true,
            Some(5) => odd || dropped[1..].iter().any(|d| *d > 0),
            _ => false,
        };
        if up {
            let mut carry = true;
            for digit in kept.iter_mut().rev() {
                *digit += 1;
                carry = *digit == 10;
                if !carry {
                    break;
                }
                *digit = 0;
            }
            if carry {
                kept.insert(0, 1);
            }
        }
        let text: String = kept.iter().map(|d| char::from(b'0' + d)).collect();
        let trimmed = text.trim_start_matches('0');
        if trimmed.is_empty() { "0" } else { trimmed }.to_owned()
    }
}

fn with_point(digits: &str, decimals: usize) -> String {
    if decimals == 0 {
        return digits.to_owned();
    }
    let padded = format!("{digits:0>width$}", width = decimals + 1);
    let (whole, fraction) = padded.split_at(padded.len() - decimals);
    format!("{whole}.{fraction}")
}

fn shortest(x: f64) -> String {
    if x != 0.0 && !(1e-4..1e15).contains(&x.abs()) {
        format!("{x:e}")
    } else {
        format!("{x}")
    }
}

fn percent(probability: f64) -> String {
    // Through nine digits, so that neither 0.955 shows rounding nor 0.9999999 becomes 100 %.
    let text = format!("{:.7}", 100.0 * probability);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn ascii_unit(unit: &str) -> String {
    let mut text = String::new();
    let mut in_power = false;
    for c in unit.chars() {
        let power = match c {
            '⁻' => Some('-'),
            '⁰' => Some('0'),
            '¹' => Some('1'),
            '²' => Some('2'),
            '³' => Some('3'),
            '⁴'..='⁹' => char::from_digit(c as u32 - '⁰' as u32, 10),
            _ => None,
        };
        if let Some(digit) = power {
            if !in_power {
                text.push('^');
            }
            text.push(digit);
        } else {
            match c {
                'µ' | 'μ' => text.push('u'),
                'Ω' => text.push_str("ohm"),
                '°' => text.push_str("deg"),
                '·' | '⋅' | '×' => text.push('*'),
                '√' => text.push_str("sqrt"),
                '‰' => text.push_str("1e-3"),
                c if c.is_ascii() => text.push(c),
                _ => text.push('?'),
            }
        }
        in_power = power.is_some();
    }
    text
}

/// A quantity with the format it is to be printed in.
pub struct Formatted<'a> {
    quantity: &'a Quantity,
    format: Format,
}

impl fmt::Display for Formatted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.format.render(self.quantity))
    }
}

impl Quantity {
    /// Prints in a chosen format.
    pub fn display(&self, format: &Format) -> Formatted<'_> {
        Formatted {
            quantity: self,
            format: *format,
        }
    }
}

/// `{}` is concise, `{:#}` expanded at 95 %; a precision gives the digits of the uncertainty: `{:.1}`.
impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let format = if f.alternate() {
            Format::expanded(0.95)
        } else {
            Format::concise()
        };
        let format = f.precision().map_or(format, |digits| format.digits(digits));
        let text = format.render(self);
        let width = f.width().unwrap_or(0);
        let padding = width.saturating_sub(text.chars().count());
        match f.align() {
            Some(fmt::Alignment::Right) => {
                (0..padding).try_for_each(|_| f.write_char(' '))?;
                f.write_str(&text)
            }
            _ => {
                f.write_str(&text)?;
                (0..padding).try_for_each(|_| f.write_char(' '))
            }
        }
    }
}

/// δ = ½·10^l, half a unit of the last of the digits of u that count. **Source** `[S1] 7.9.2`.
///
/// ```
/// use proofmass_uncertainty::numerical_tolerance;
/// assert!((numerical_tolerance(0.00035, 2) - 0.000_005).abs() < 1e-15); // `[S1]` 7.9.2 example 1
/// assert!((numerical_tolerance(2.0, 1) - 0.5).abs() < 1e-15); // `[S1]` 7.9.2 example 2
/// ```
pub fn numerical_tolerance(u: f64, digits: u32) -> f64 {
    if u <= 0.0 {
        return 0.0;
    }
    let text = format!("{:.*e}", digits.clamp(1, 15) as usize - 1, u);
    let exponent: i32 = text
        .split_once('e')
        .and_then(|(_, e)| e.parse().ok())
        .unwrap_or(0);
    0.5 * 10f64.powi(exponent - digits.clamp(1, 15) as i32 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DegreesOfFreedom;

    fn quantity(value: f64, u: f64, unit: &str) -> Quantity {
        Quantity {
            name: "x".into(),
            unit: unit.into(),
            value,
            standard_uncertainty: u,
            dof: DegreesOfFreedom::INFINITE,
        }
    }

    #[test]
    fn published_concise_forms() {
        for (value, u, unit, expected) in [
            (100.02147, 0.00035, "g", "100.02147(35) g"), // [GUM] 7.2.2
            (127.732, 0.0711, "Ω", "127.732(71) Ω"),      // [GUM] H.2
            (10.05762, 0.027, "Ω", "10.058(27) Ω"),       // [GUM] 7.2.6
            (-0.1712, 0.0029, "°C", "-0.1712(29) °C"),    // [GUM] H.3
            (0.050_000_838, 31.664e-9, "m", "0.050000838(32) m"), // [GUM] H.1
        ] {
            assert_eq!(quantity(value, u, unit).to_string(), expected);
        }
    }

    #[test]
    fn known_concise_forms() {
        for (value, u, expected) in [
            (0.5, 0.0996, "0.50(10)"),
            (9.996, 0.0123, "9.996(12)"),
            (9.996, 0.123, "10.00(12)"),
            (0.996, 0.996, "1.0(1.0)"),
            (123_456.0, 1_300.0, "1.235(13)×10⁵"),
            (3.0, 1_200.0, "0.0(1.2)×10³"),
            (5.3, 1.2, "5.3(1.2)"),
            (838.0, 36.0, "838(36)"),
            (1.234e-6, 0.014e-6, "1.234(14)×10⁻⁶"),
            (0.0, 1.4e-9, "0.0(1.4)×10⁻⁹"),
            (-0.000_01, 0.1, "0.00(10)"),
            (6.62607015e-34, 0.0, "6.62607015e-34 (exact)"),
            (9.80665, 0.0, "9.80665 (exact)"),
            (1.25, 1.0, "1.2(1.0)"), // half to even
            (1.35, 1.0, "1.4(1.0)"),
            (0.05, 1.0, "0.0(1.0)"),
            (0.051, 1.0, "0.1(1.0)"),
            (1e300, 1e298, "1.000(10)×10³⁰⁰"),
            (5e-324, 5e-324, "5.0(5.0)×10⁻³²⁴"),
            // More digits than a double has would be made up.
            (9.80665, 1e-17, "9.80665 (u = 1.0×10⁻¹⁷)"),
            (0.0, 1e-17, "0.0(1.0)×10⁻¹⁷"),
            (1.0, 1.2e-15, "1.0000000000000000(12)"),
        ] {
            assert_eq!(quantity(value, u, "1").to_string(), expected, "{value} {u}");
        }
    }

    #[test]
    fn known_expanded_forms() {
        let q = quantity(123_456.0, 1_300.0, "µm/s²");
        let show = |f: Format| q.display(&f).to_string();
        assert_eq!(
            show(Format::expanded(0.95)),
            "(1.235 ± 0.025)×10⁵ µm/s² (k = 1.96, 95 %)"
        );
        assert_eq!(
            show(Format::expanded(0.9545).ascii().with_dof()),
            "(1.235 +/- 0.026)e5 um/s^2 (k = 2.00, nu = inf, 95.45 %)"
        );
        assert_eq!(
            show(Format::expanded(0.95).decimal_comma()),
            "(1,235 ± 0,025)×10⁵ µm/s² (k = 1,96; 95 %)"
        );
        assert_eq!(format!("{q:.1}"), "1.23(1)×10⁵ µm/s²");
        assert_eq!(
            format!(
                "{:>12}|{:<12}|",
                quantity(1.0, 0.1, ""),
                quantity(1.0, 0.1, "")
            ),
            "    1.00(10)|1.00(10)    |"
        );
    }

    #[test]
    fn known_ascii_units() {
        assert_eq!(ascii_unit("m·s⁻²"), "m*s^-2");
        assert_eq!(ascii_unit("(m/s²)²/Hz"), "(m/s^2)^2/Hz");
        assert_eq!(ascii_unit("V/√Hz"), "V/sqrtHz");
    }
}

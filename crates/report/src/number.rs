//! Numbers as text: minus signs, decimal points, exponents, uncertainty in parentheses.

use crate::{Cell, Column, Error};
pub use proofmass_uncertainty::scientific;
pub(crate) use proofmass_uncertainty::superscript;
use proofmass_uncertainty::{DegreesOfFreedom, Format, Quantity};

/// A value with its standard uncertainty in parentheses, as `proofmass_uncertainty` rounds it: `0.0312(14)`.
///
/// The rule is that of [`Format::concise`]; only the hyphen becomes a minus sign. An uncertainty of zero prints
/// the value as exact.
///
/// ```
/// use proofmass_report::concise;
/// assert_eq!(concise(0.031_24, 0.001_38), "0.0312(14)");
/// assert_eq!(concise(-45_678.0, 1_234.0), "−4.57(12)×10⁴");
/// assert_eq!(concise(-1e-9, 0.5), "0.00(50)");
/// assert_eq!(concise(9.80665, 0.0), "9.80665 (exact)");
/// ```
pub fn concise(value: f64, standard_uncertainty: f64) -> String {
    let bare = Quantity {
        name: String::new(),
        unit: String::new(),
        value,
        standard_uncertainty,
        dof: DegreesOfFreedom::INFINITE,
    };
    minus(&bare.display(&Format::concise()).to_string())
}

/// A value and its expanded uncertainty, rounded to the same place: two digits of the uncertainty.
pub fn rounded(value: f64, expanded: f64) -> (String, String) {
    if !(expanded > 0.0 && expanded.is_finite()) {
        return (value.to_string(), "0".to_owned());
    }
    let places = decimals(expanded);
    (format!("{value:.places$}"), format!("{expanded:.places$}"))
}

/// A value and its expanded uncertainty as a certificate states them: U rounded up to two significant digits, the value to the same place.
///
/// ```
/// use proofmass_report::number::rounded_up;
/// assert_eq!(rounded_up(9.876_54, 0.0521), ("9.877".into(), "0.053".into()));
/// assert_eq!(rounded_up(9.876_54, 0.0995), ("9.88".into(), "0.10".into()));
/// assert_eq!(rounded_up(-33_120.18, 1_234.0), ("-33100".into(), "1300".into()));
/// // What is two digits already stays.
/// assert_eq!(rounded_up(1.0, 0.3 - 0.1), ("1.00".into(), "0.20".into()));
/// ```
///
/// **Source** `[EA4/02]` 6.3.
pub fn rounded_up(value: f64, expanded: f64) -> (String, String) {
    if !(expanded > 0.0 && expanded.is_finite() && value.is_finite()) {
        return (value.to_string(), "0".to_owned());
    }
    let text = format!("{expanded:e}");
    let exponent = text.split_once('e').and_then(|(_, e)| e.parse().ok());
    let mut place: i32 = exponent.unwrap_or(0) - 1;
    // Doubles that are two digits but for their last bits are these digits.
    let digits = expanded / 10f64.powi(place);
    let mut digits = (digits * (1.0 - 1e-9)).ceil();
    if digits >= 100.0 {
        (digits, place) = (10.0, place + 1);
    }
    if place < 0 {
        let decimals = place.unsigned_abs() as usize;
        let up = digits * 10f64.powi(place);
        return (
            unsigned_zero(format!("{value:.decimals$}")),
            format!("{up:.decimals$}"),
        );
    }
    let step = 10f64.powi(place);
    let whole = (value / step).round() * step;
    (
        unsigned_zero(format!("{whole:.0}")),
        format!("{:.0}", digits * step),
    )
}

/// A number of which only zeros are printed has no sign.
fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(size) if size.chars().all(|c| matches!(c, '0' | '.')) => size.to_owned(),
        _ => text,
    }
}

/// A number as tables and plans give it, three decimals at most and no needless zeros: `31.5`, `160`.
pub fn plain(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A number with two significant digits.
pub fn two_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let places = decimals(value);
    format!("{value:.places$}")
}

/// Decimals that leave two significant digits after rounding: 0.0996 becomes 0.10.
fn decimals(value: f64) -> usize {
    let text = format!("{:.1e}", value.abs());
    let exponent = text.split_once('e').and_then(|(_, e)| e.parse().ok());
    (1 - exponent.unwrap_or(0)).clamp(0, 12) as usize
}

/// A printed number with a true minus sign, no sign where only zeros are printed, and `e-5` as a power of ten.
pub fn minus(text: &str) -> String {
    let size = text.strip_prefix('-').unwrap_or(text);
    if !size.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
        return text.to_string();
    }
    let mantissa = size.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let (digits, rest) = size.split_at(size.len() - mantissa.len());
    let zero = digits.chars().all(|c| matches!(c, '0' | '.'));
    let sign = if size.len() < text.len() && !zero {
        "−"
    } else {
        ""
    };
    let power = rest.strip_prefix('e').and_then(|after| {
        let end = after
            .find(|c: char| !(c.is_ascii_digit() || c == '-'))
            .unwrap_or(after.len());
        let exponent: i32 = after[..end].parse().ok()?;
        Some(match exponent {
            0 => after[end..].to_string(),
            e => format!("×10{}{}", superscript(e), &after[end..]),
        })
    });
    format!("{sign}{digits}{}", power.unwrap_or_else(|| rest.into()))
}

/// Degrees of freedom; above 9999 no digit of them says anything.
pub fn freedom(nu: f64) -> String {
    DegreesOfFreedom::new(nu).map_or_else(|| nu.to_string(), |nu| nu.to_string())
}

/// A sentence whose numbers have true minus signs: a hyphen before a digit, at the beginning or behind a space or bracket.
pub fn minus_signs(text: impl Into<String>) -> String {
    let text = text.into();
    if !text.contains('-') {
        return text;
    }
    let mut out = String::with_capacity(text.len() + 4);
    let mut before = ' ';
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let number = rest.peek().is_some_and(char::is_ascii_digit);
        let begins = before.is_whitespace() || matches!(before, '(' | '±');
        out.push(if c == '-' && number && begins {
            '−'
        } else {
            c
        });
        before = c;
    }
    out
}

/// Quantity over unit, as headings and axes state it: brackets around a compound unit, square ones around round
/// ones, nothing over an empty unit. **Source** `[SIBrochure] 5.4.1`.
pub(crate) fn quotient(quantity: &str, unit: &str) -> String {
    if unit.is_empty() {
        quantity.into()
    } else if unit.contains('(') {
        format!("{quantity} / [{unit}]")
    } else if unit.contains(['/', '·', ' ']) {
        format!("{quantity} / ({unit})")
    } else {
        format!("{quantity} / {unit}")
    }
}

/// The text of a cell under its column.
pub(crate) fn cell_text(cell: &Cell, column: &Column, row: usize) -> Result<String, Error> {
    Ok(match cell {
        Cell::Value(value) => {
            let value = finite(*value, column, row)? * column.scale.unwrap_or(1.0);
            minus(&column.rounding.text(value))
        }
        Cell::Estimate(value, u) => {
            let scale = column.scale.unwrap_or(1.0);
            concise(
                finite(*value, column, row)? * scale,
                finite(*u, column, row)? * scale.abs(),
            )
        }
        Cell::Text(text) | Cell::Linked { text, .. } => text.clone(),
        Cell::Worded { file, text } if file.is_text() => text.clone(),
        Cell::Number { text } | Cell::Worded { text, .. } => minus(text),
        Cell::Quantity(quantity) => quantity_text(quantity, column, row)?,
        Cell::Empty => String::new(),
    })
}

fn finite(value: f64, column: &Column, row: usize) -> Result<f64, Error> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(Error::NotFinite {
        series: column.heading.clone(),
        index: row,
        value,
    })
}

fn quantity_text(quantity: &Quantity, column: &Column, row: usize) -> Result<String, Error> {
    for value in [quantity.value, quantity.standard_uncertainty] {
        if !value.is_finite() {
            return Err(Error::NotFinite {
                series: quantity.name.clone(),
                index: row,
                value,
            });
        }
    }
    let plain = |unit: &str| unit.is_empty() || unit == "1";
    if quantity.unit == column.unit {
        return Ok(concise(quantity.value, quantity.standard_uncertainty));
    }
    let text = minus(&quantity.to_string());
    // A pure number under a column with a unit must not be read in that unit.
    Ok(if plain(&quantity.unit) && !plain(&column.unit) {
        format!("{text} [1]")
    } else {
        text
    })
}

/// A printed number cut before its decimal point: what stands left of the alignment line, and the rest.
///
/// Without a decimal point the cut is after the leading sign and digits, so that `12(3)` and `0.5(1)` align.
pub(crate) fn split_at_point(text: &str) -> (&str, &str) {
    let end = text
        .char_indices()
        .find(|&(i, c)| {
            !(c.is_ascii_digit() || (i == 0 && matches!(c, '−' | '-' | '+' | '<' | '≤' | '±')))
        })
        .map_or(text.len(), |(i, _)| i);
    text.split_at(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_minus_signs_of_sentences() {
        for (text, printed) in [
            (
                "-0.004 mg since the beginning",
                "−0.004 mg since the beginning",
            ),
            (
                "from -18.0 to 74.0 °C (-3 K)",
                "from −18.0 to 74.0 °C (−3 K)",
            ),
            (
                "on 2026-11-22, run-2, 3-5, --columns x, a - 1",
                "on 2026-11-22, run-2, 3-5, --columns x, a - 1",
            ),
        ] {
            assert_eq!(minus_signs(text), printed);
        }
    }

    #[test]
    fn law_u_is_rounded_up_and_never_down() {
        let mut x = 1.0_f64;
        for i in 0..4000 {
            x = (x * 1.037).rem_euclid(9.7) + 0.13;
            let u = x * 10f64.powi(i % 15 - 9);
            let (value, up) = rounded_up(123.456 * u, u);
            let printed: f64 = up.parse().unwrap();
            assert!(
                printed >= u * (1.0 - 2e-9) && printed < u * 1.11,
                "{u} {up}"
            );
            let digits = up.trim_start_matches(['0', '.']).replace('.', "");
            assert!(digits.trim_end_matches('0').len() <= 2, "{up}");
            let decimals = |t: &str| t.split_once('.').map_or(0, |(_, d)| d.len());
            assert_eq!(decimals(&value), decimals(&up), "{value} {up}");
            assert!((value.parse::<f64>().unwrap() - 123.456 * u).abs() <= 0.0501 * printed);
        }
        assert_eq!(rounded_up(-0.001, 1.0), ("0.0".into(), "1.0".into()));
    }

    #[test]
    fn law_decimal_split_is_lossless_and_cuts_at_the_point() {
        for (text, head) in [
            ("−12.5", "−12"),
            ("0.0312(14)", "0"),
            ("45678(12)", "45678"),
            ("", ""),
            ("n/a", ""),
            ("4.57(12)×10⁴", "4"),
        ] {
            let (a, b) = split_at_point(text);
            assert_eq!(a, head);
            assert_eq!(format!("{a}{b}"), text);
        }
    }

    #[test]
    fn law_a_printed_cell_shows_its_text() {
        let column = Column::number("p", "");
        for (cell, shown) in [
            (Cell::printed(1e-5, "< 0.001"), "< 0.001"),
            (Cell::printed(-0.25, "-0.3"), "−0.3"),
            (Cell::printed(None, "∞"), "∞"),
        ] {
            assert_eq!(cell_text(&cell, &column, 0), Ok(shown.to_owned()));
        }
    }

    #[test]
    fn law_signs_and_powers_are_printed_as_such() {
        assert_eq!(minus("-0.00"), "0.00");
        assert_eq!(minus("-0.01"), "−0.01");
        assert_eq!(minus("-x"), "-x");
        assert_eq!(minus("-0.00(50) m"), "0.00(50) m");
        assert_eq!(minus("-2.50e-5"), "−2.50×10⁻⁵");
        assert_eq!(minus("3.1e0 m"), "3.1 m");
        assert_eq!(minus("3 e"), "3 e");
        assert_eq!(scientific(-0.0, 3), "0");
    }

    #[test]
    fn law_a_cell_shows_what_the_quantity_prints() {
        for (value, u, unit) in [
            (100.021_47, 0.000_35, "g"),
            (-9.81, 0.0996, "m/s²"),
            (1.234e-9, 5.6e-11, "(m/s²)/√Hz"),
            (3.0, 1200.0, "count/(m/s²)"),
            (6.626_070_15e-34, 0.0, "J·s"),
            (1.0, 0.0, "1"),
        ] {
            let quantity = Quantity {
                name: "q".into(),
                unit: unit.into(),
                value,
                standard_uncertainty: u,
                dof: DegreesOfFreedom::INFINITE,
            };
            let printed = minus(&quantity.to_string());
            let cell = cell_text(&Cell::quantity(quantity), &Column::number("", ""), 0);
            assert_eq!(cell, Ok(printed));
        }
    }
}

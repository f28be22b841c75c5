//! Numbers as text: minus signs, decimal points, exponents, uncertainty in parentheses.

use crate::{Cell, Column, Error};
use proofmass_uncertainty::Quantity;

/// A number with `digits` significant digits; in powers of ten outside 0.001 to 100 000.
///
/// ```
/// use proofmass_report::scientific;
/// assert_eq!(scientific(0.000_031_24, 3), "3.12·10⁻⁵");
/// assert_eq!(scientific(-12.345, 4), "−12.35");
/// ```
pub fn scientific(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let digits = digits.max(1);
    // The exponent after rounding: 9.996 with three digits is 10.0.
    let text = format!("{:.*e}", digits - 1, value);
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-3..5).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        minus(&format!("{value:.decimals$}"))
    } else {
        format!("{}·10{}", minus(mantissa), superscript(exponent))
    }
}

/// A value with its standard uncertainty in parentheses, two significant digits of it: `0.0312(14)`.
///
/// The digits in parentheses are those of the last digits of the value. Powers of ten are used where the value
/// would otherwise show digits it does not have or a long row of zeros. An uncertainty of zero prints the value
/// alone. **Source** `[GUM] 7.2.2`.
///
/// ```
/// use proofmass_report::concise;
/// assert_eq!(concise(0.031_24, 0.001_38), "0.0312(14)");
/// assert_eq!(concise(45_678.0, 1_234.0), "4.57(12)·10⁴");
/// assert_eq!(concise(-1e-9, 0.5), "0.00(50)");
/// ```
pub fn concise(value: f64, standard_uncertainty: f64) -> String {
    let u = standard_uncertainty;
    if u == 0.0 || !u.is_finite() || !value.is_finite() {
        return scientific(value, 10);
    }
    let exponent_of = |v: f64| -> i32 {
        format!("{v:.1e}")
            .split_once('e')
            .and_then(|(_, e)| e.parse().ok())
            .unwrap_or(0)
    };
    let last = exponent_of(u) - 1; // place of the last printed digit
    let leading = if value == 0.0 {
        last + 1
    } else {
        exponent_of(value.abs()).max(last + 1)
    };
    let digits = format!("{u:.1e}")
        .split_once('e')
        .map(|(m, _)| m.replace('.', ""))
        .unwrap_or_default();
    if last <= 0 && (-4..6).contains(&leading) {
        return format!(
            "{}({digits})",
            minus(&format!("{value:.*}", (-last) as usize))
        );
    }
    // Dividing by a power of ten beyond the range of a double would lose the value: done in two steps.
    let half = leading / 2;
    let mantissa = value / 10f64.powi(half) / 10f64.powi(leading - half);
    format!(
        "{}({digits})·10{}",
        minus(&format!("{mantissa:.*}", (leading - last) as usize)),
        superscript(leading)
    )
}

/// A printed number with a true minus sign, and no sign where only zeros are printed.
pub(crate) fn minus(text: &str) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit() || c == '.') => {
            let digits = rest.split(['e', '·', '(']).next().unwrap_or(rest);
            if digits.chars().all(|c| matches!(c, '0' | '.')) {
                rest.to_string()
            } else {
                format!("−{rest}")
            }
        }
        _ => text.to_string(),
    }
}

/// An exponent in superscript characters.
pub(crate) fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            c => char::from_u32('⁰' as u32 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
        })
        .collect()
}

/// The text of a cell under its column.
pub(crate) fn cell_text(cell: &Cell, column: &Column, row: usize) -> Result<String, Error> {
    Ok(match cell {
        Cell::Text(text) => text.clone(),
        Cell::Number { text } => minus(text),
        Cell::Quantity(quantity) => quantity_text(quantity, column, row)?,
        Cell::Empty => String::new(),
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
    let text = concise(quantity.value, quantity.standard_uncertainty);
    let plain = |unit: &str| unit.is_empty() || unit == "1";
    // A pure number under a column with a unit must not be read in that unit.
    Ok(
        if quantity.unit == column.unit || (plain(&quantity.unit) && plain(&column.unit)) {
            text
        } else if plain(&quantity.unit) {
            format!("{text} [1]")
        } else {
            format!("{text} {}", quantity.unit)
        },
    )
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
    fn law_decimal_split_is_lossless_and_cuts_at_the_point() {
        for (text, head) in [
            ("−12.5", "−12"),
            ("0.0312(14)", "0"),
            ("45678(12)", "45678"),
            ("", ""),
            ("n/a", ""),
            ("4.57(12)·10⁴", "4"),
        ] {
            let (a, b) = split_at_point(text);
            assert_eq!(a, head);
            assert_eq!(format!("{a}{b}"), text);
        }
    }

    #[test]
    fn law_negative_zero_has_no_sign() {
        assert_eq!(minus("-0.00"), "0.00");
        assert_eq!(minus("-0.01"), "−0.01");
        assert_eq!(minus("-x"), "-x");
        assert_eq!(scientific(-0.0, 3), "0");
    }

    #[test]
    fn published_concise_examples_of_the_gum() {
        // [GUM] 7.2.2: m_S = 100,021 47(35) g.
        assert_eq!(concise(100.021_47, 0.000_35), "100.02147(35)");
        assert_eq!(concise(0.0, 0.0), "0");
        assert_eq!(concise(9.81, 0.0996), "9.81(10)");
        assert_eq!(concise(1.234e-9, 5.6e-11), "1.234(56)·10⁻⁹");
        assert_eq!(concise(3.0, 1200.0), "0.0(1.2)·10³".replace("1.2", "12"));
    }
}

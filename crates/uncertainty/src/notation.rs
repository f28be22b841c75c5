//! Single numbers as text for people.

/// A number with `digits` significant digits and a true minus sign; in powers of ten outside 0.001 to 100 000.
///
/// ```
/// use proofmass_uncertainty::scientific;
/// assert_eq!(scientific(0.000_031_24, 3), "3.12×10⁻⁵");
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
    let text = if (-3..5).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{mantissa}×10{}", superscript(exponent))
    };
    text.replacen('-', "−", 1)
}

/// An exponent in superscript characters.
///
/// ```
/// assert_eq!(proofmass_uncertainty::superscript(-12), "⁻¹²");
/// ```
pub fn superscript(exponent: i32) -> String {
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

//! Numbers as options.

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err(format!("{text:?} is no positive number")),
    }
}

pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v >= 0.0 && v.is_finite() => Ok(v),
        _ => Err(format!("{text:?} is no number from zero on")),
    }
}

/// Two numbers, the second larger: `10,2000`.
pub(crate) fn band(text: &str) -> Result<[f64; 2], String> {
    let refused = || format!("{text:?} is no band such as 10,2000");
    let (low, high) = text.split_once(',').ok_or_else(refused)?;
    let number = |t: &str| positive(t.trim()).map_err(|_| refused());
    let (low, high) = (number(low)?, number(high)?);
    if low < high {
        Ok([low, high])
    } else {
        Err(refused())
    }
}

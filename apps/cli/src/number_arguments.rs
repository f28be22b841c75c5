//! Numbers as options.

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err(format!("{text:?} is no positive number")),
    }
}

/// A probability of false alarms: neither 0 nor 1.
pub(crate) fn false_alarm_rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(p) if p > 0.0 && p < 1.0 => Ok(p),
        _ => Err("a false-alarm rate lies between 0 and 1".to_owned()),
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

/// A coverage factor: any positive number.
pub(crate) fn coverage_factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(k) if k > 0.0 && k.is_finite() => Ok(k),
        _ => Err("a number above 0 is needed, such as 2".to_owned()),
    }
}

/// A coverage probability: neither 0 nor 1.
pub(crate) fn probability(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(p) if p > 0.0 && p < 1.0 => Ok(p),
        _ => Err("a number between 0 and 1 is needed, such as 0.95".to_owned()),
    }
}

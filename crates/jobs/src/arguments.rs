//! Words of a command line that are no numbers and no types of their own.

/// A stretch of time, `FROM,TO` in seconds.
pub(crate) fn stretch(text: &str) -> Result<[f64; 2], String> {
    let wrong = || format!("{text:?} is no stretch of time: write FROM,TO in seconds");
    let (from, to) = text.split_once(',').ok_or_else(wrong)?;
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match (number(from), number(to)) {
        (Some(from), Some(to)) if from < to => Ok([from, to]),
        _ => Err(wrong()),
    }
}

/// A number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err(format!("{text:?} is no positive number")),
    }
}

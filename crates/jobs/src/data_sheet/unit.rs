//! Units of data sheets, in which g is standard gravity and LSB a count of a converter.

use proofmass_uncertainty::unit_ratio;

/// A unit as the units of models spell it.
fn spelled(unit: &str) -> String {
    let mut text = String::new();
    let mut word = String::new();
    let close = |word: &mut String, text: &mut String| {
        text.push_str(match word.as_str() {
            "g" | "g0" => "gn",
            "mg" => "mgn",
            "µg" | "μg" | "ug" => "µgn",
            "LSB" | "lsb" | "counts" | "digit" | "digits" => "count",
            other => other,
        });
        word.clear();
    };
    for c in unit.trim().chars() {
        if c.is_alphanumeric() && !matches!(c, '²' | '³')
            || matches!(c, 'µ' | 'μ' | '°' | '%' | '‰')
        {
            word.push(c);
        } else {
            close(&mut word, &mut text);
            text.push(c);
        }
    }
    close(&mut word, &mut text);
    text
}

/// A unit without its time of a calendar, and how many months that time has.
fn per_calendar(unit: &str) -> (String, Option<f64>) {
    for (word, months) in [("/month", 1.0), ("/year", 12.0)] {
        if let Some(before) = unit.strip_suffix(word) {
            return (before.to_owned(), Some(months));
        }
    }
    (unit.to_owned(), None)
}

/// How many of one unit are one of another; `None` where one is no unit, or where they are of two kinds. A count, which only a
/// calibration gives a size, is no number.
///
/// ```
/// use proofmass_jobs::data_sheet::unit_ratio;
/// assert_eq!(unit_ratio("V/(m/s²)", "mV/g").map(f64::round), Some(9807.0));
/// assert_eq!(unit_ratio("count", "mg"), None);
/// ```
pub fn ratio(from: &str, to: &str) -> Option<f64> {
    let ((from, from_months), (to, to_months)) = (per_calendar(from), per_calendar(to));
    let calendar = match (from_months, to_months) {
        (None, None) => 1.0,
        (Some(from), Some(to)) => to / from,
        _ => return None,
    };
    let (from, to) = (spelled(&from), spelled(&to));
    if from == to {
        return Some(calendar);
    }
    let counts = |unit: &str| unit.matches("count").count();
    if counts(&from) != counts(&to) || [&from, &to].iter().any(|u| u.contains("dB")) {
        return None;
    }
    Some(calendar * unit_ratio(&from, &to)?)
}

/// Whether a text is a unit at all.
pub(crate) fn is_unit(unit: &str) -> bool {
    let (unit, _) = per_calendar(unit);
    !unit.contains("dB") && unit_ratio(&spelled(&unit), &spelled(&unit)).is_some()
}

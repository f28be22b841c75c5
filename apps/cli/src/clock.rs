//! The date of a report.

use proofmass::io::Input;
use proofmass::jobs::Record;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

/// Today's date, UTC, as ISO 8601; `SOURCE_DATE_EPOCH` (seconds) takes the place of the clock where results must
/// be the same every time.
pub(crate) fn today() -> String {
    let seconds = std::env::var("SOURCE_DATE_EPOCH")
        .ok()
        .and_then(|v| v.parse().ok())
        .unwrap_or_else(|| {
            let since = SystemTime::now().duration_since(UNIX_EPOCH);
            since.map_or(0, |d| d.as_secs())
        });
    date(seconds / 86_400)
}

/// A file as a title names it: without its folder, which stands in the line of what was read.
pub(crate) fn named(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// What a result of today from these files is filed with.
pub(crate) fn record(title: String, inputs: Vec<Input>) -> Record {
    Record {
        title: Some(title),
        date: Some(today()),
        inputs,
        ..Record::default()
    }
}

/// Civil date of a day counted from 1970-01-01: Gregorian calendar in years that begin in March.
fn date(days: u64) -> String {
    let z = days + 719_468;
    let era = z / 146_097;
    let day_of_era = z % 146_097;
    let year_of_era =
        (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_dates() {
        assert_eq!(date(0), "1970-01-01");
        assert_eq!(date(11_016), "2000-02-29");
        assert_eq!(date(20_454), "2026-01-01");
    }
}

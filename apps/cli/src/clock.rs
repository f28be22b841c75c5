//! The date of a report.

use proofmass::io::Input;
use proofmass::io::formats::calendar::date_time;
use proofmass::jobs::Record;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

/// Today's date, UTC, as ISO 8601; `SOURCE_DATE_EPOCH` (seconds) takes the place of the clock where results must
/// be the same every time.
pub fn today() -> String {
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

/// Date of a day counted from 1970-01-01.
fn date(days: u64) -> String {
    let time = date_time((days * 86_400) as i64);
    time.split('T').next().unwrap_or_default().to_owned()
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

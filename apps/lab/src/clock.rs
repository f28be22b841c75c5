//! The date, in universal time.

use proofmass::io::formats::calendar::date_time;
use std::time::{SystemTime, UNIX_EPOCH};

/// Now, as 2026-01-31T12:00:00Z.
pub fn utc() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    written(since.map_or(0, |d| d.as_secs()))
}

/// Today, as 2026-01-31.
pub fn today() -> String {
    utc()[..10].to_owned()
}

/// Seconds since 1970.
fn written(seconds: u64) -> String {
    format!("{}Z", date_time(i64::try_from(seconds).unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    #[test]
    fn known_dates() {
        assert_eq!(super::written(0), "1970-01-01T00:00:00Z");
        assert_eq!(super::written(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(super::written(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(super::written(1_798_761_600), "2027-01-01T00:00:00Z");
    }
}

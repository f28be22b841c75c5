//! The date, in universal time.

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

/// Seconds since 1970 as a date of the Gregorian calendar, whose years begin in March here.
fn written(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let of_month = of_year - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 {
        (month + 3, 0)
    } else {
        (month - 9, 1)
    };
    let (h, m, s) = (rest / 3600, rest / 60 % 60, rest % 60);
    let year = era * 400 + year + next;
    format!("{year:04}-{month:02}-{of_month:02}T{h:02}:{m:02}:{s:02}Z")
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

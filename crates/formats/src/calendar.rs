//! Days of dates.

/// Days from 1970-01-01 to a date of the Gregorian calendar.
pub fn days(year: i64, month: i64, day: i64) -> i64 {
    // Months from March on, so that the day of the leap year is the last one.
    let (year, month) = match month > 2 {
        true => (year, month - 3),
        false => (year - 1, month + 9),
    };
    let leaps = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    365 * year + leaps + (153 * month + 2) / 5 + day - BEFORE_1970
}

/// Days from 1970-01-01 to a date written as 2026-03-31; `None` for another form, or a day that is not in the calendar.
pub fn day_of(date: &str) -> Option<i64> {
    let mut parts = date.split('-');
    let mut number = |digits: usize| -> Option<i64> {
        let part = parts.next()?;
        let plain = part.len() == digits && part.bytes().all(|b| b.is_ascii_digit());
        plain.then(|| part.parse().ok())?
    };
    let (year, month, day) = (number(4)?, number(2)?, number(2)?);
    let days = days(year, month, day);
    let back = date_time(days.checked_mul(86_400)?);
    (back.split('T').next() == Some(date)).then_some(days)
}

/// Days that the count of years from zero on has at 1970-01-01.
const BEFORE_1970: i64 = 719_469;

/// Date and time to the second of a day in the Gregorian calendar, in the form of ISO 8601; of so many seconds since 1970.
pub fn date_time(seconds: i64) -> String {
    let day = seconds.div_euclid(86_400);
    let second = seconds.rem_euclid(86_400);
    // By the mean length of a year, at most one too many.
    let mut year = 1971 + (400 * day).div_euclid(146_097);
    while days(year, 1, 1) > day {
        year -= 1;
    }
    let month = (2..=12).find(|month| days(year, *month, 1) > day);
    let month = month.map_or(12, |next| next - 1);
    let of_month = day - days(year, month, 1) + 1;
    let (hour, minute) = (second / 3600, second / 60 % 60);
    let second = second % 60;
    format!("{year:04}-{month:02}-{of_month:02}T{hour:02}:{minute:02}:{second:02}")
}

#[cfg(test)]
mod tests {
    use super::{date_time, day_of, days};

    #[test]
    fn published_times_since_1970() {
        // RFC 3339, section 5.8, and POSIX.
        for (seconds, text) in [
            (0, "1970-01-01T00:00:00"),
            (482_196_050, "1985-04-12T23:20:50"),
            (951_782_400, "2000-02-29T00:00:00"),
            (946_684_799, "1999-12-31T23:59:59"),
            (1_709_251_199, "2024-02-29T23:59:59"),
            (-1, "1969-12-31T23:59:59"),
        ] {
            assert_eq!(date_time(seconds), text);
        }
    }

    #[test]
    fn known_dates_and_what_is_none() {
        for (date, day) in [
            ("1970-01-01", 0),
            ("2000-02-29", 11_016),
            ("2026-01-01", 20_454),
        ] {
            assert_eq!(day_of(date), Some(day));
        }
        for wrong in [
            "2026-02-30",
            "2026-1-1",
            "1.1.2026",
            "2026-13-01",
            "",
            "2026-01-01-01",
            "+026-01-01",
        ] {
            assert_eq!(day_of(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn known_days_between_dates() {
        assert_eq!(days(1970, 1, 1), 0);
        assert_eq!(days(2000, 2, 29), 11_016);
        assert_eq!(days(2001, 3, 1), 11_382);
        assert_eq!(days(2025, 3, 17), 20_164);
        assert_eq!(days(1900, 3, 1) - days(1900, 2, 28), 1);
    }
}

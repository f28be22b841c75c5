//! Days: ISO 8601 outside, a number inside.

use proofmass_io::formats::calendar;
use proofmass_jobs::{Result, Trouble};

/// Days from 1970-01-01 to a date such as 2026-03-31.
///
/// # Errors
/// Another form, or a day that is not in the calendar.
pub fn day_of(date: &str) -> Result<i64> {
    let refuse = || {
        Trouble::request(format!("{date:?} is no date"))
            .with_hint("write year, month and day as in 2026-03-31")
    };
    let date_alone = date.split('T').next().unwrap_or_default();
    let parts: Vec<&str> = date_alone.split('-').collect();
    let [year, month, day] = parts[..] else {
        return Err(refuse());
    };
    let number = |text: &str, digits: usize| -> Result<i64> {
        match text.len() == digits && text.bytes().all(|b| b.is_ascii_digit()) {
            true => text.parse().map_err(|_| refuse()),
            false => Err(refuse()),
        }
    };
    let days = calendar::days(number(year, 4)?, number(month, 2)?, number(day, 2)?);
    match date_of(days) == date_alone {
        true => Ok(days),
        false => Err(refuse()),
    }
}

/// The date of a day from 1970-01-01.
pub fn date_of(day: i64) -> String {
    let time = calendar::date_time(day * 86_400);
    time.split('T').next().unwrap_or_default().to_owned()
}

/// Days as dates in JSON.
pub(crate) mod as_date {
    use super::date_of;
    use serde::{Serialize, Serializer};

    pub(crate) fn one<S: Serializer>(day: &i64, to: S) -> Result<S::Ok, S::Error> {
        date_of(*day).serialize(to)
    }

    pub(crate) fn option<S: Serializer>(day: &Option<i64>, to: S) -> Result<S::Ok, S::Error> {
        day.map(date_of).serialize(to)
    }

    pub(crate) fn pair<S: Serializer>(days: &[i64; 2], to: S) -> Result<S::Ok, S::Error> {
        days.map(|day| (day > -1_000_000).then(|| date_of(day)))
            .serialize(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_days_come_back() {
        for (date, day) in [
            ("1970-01-01", 0),
            ("2000-02-29", 11_016),
            ("2026-01-01", 20_454),
        ] {
            assert_eq!(day_of(date).unwrap(), day);
            assert_eq!(date_of(day), date);
        }
        for wrong in [
            "2026-02-30",
            "2026-1-1",
            "1.1.2026",
            "2026-13-01",
            "",
            "heute",
        ] {
            assert!(day_of(wrong).is_err(), "{wrong}");
        }
    }
}

//! Days: ISO 8601 outside, a number inside.

use proofmass_io::formats::calendar;
use proofmass_jobs::{Result, Trouble};

/// Days from 1970-01-01 to a date such as 2026-03-31.
///
/// # Errors
/// Another form, or a day that is not in the calendar.
pub fn day_of(date: &str) -> Result<i64> {
    let date_alone = date.split('T').next().unwrap_or_default();
    calendar::day_of(date_alone).ok_or_else(|| {
        Trouble::request(format!("{date:?} is no date"))
            .with_hint("write year, month and day as in 2026-03-31")
    })
}

/// The date of a day from 1970-01-01.
pub fn date_of(day: i64) -> String {
    let time = calendar::date_time(day * 86_400);
    time.split('T').next().unwrap_or_default().to_owned()
}

/// Days for an axis from one to another, with their dates: first days of years, of months, or what there is; at most eight.
pub(crate) fn round_days(first: i64, last: i64) -> Vec<(f64, String)> {
    const MOST: usize = 8;
    // Some more on both sides, since a plot has margins.
    let around = (last - first).max(2) / 8 + 1;
    let (first, last) = (first - around, last + around);
    let year = |day: i64| {
        date_of(day)
            .split('-')
            .next()
            .and_then(|y| y.parse::<i64>().ok())
    };
    let (Some(from), Some(to)) = (year(first), year(last)) else {
        return Vec::new();
    };
    let marks = |step: i64| -> Vec<(f64, String)> {
        let months = (12 * from..=12 * to + 11).filter(|m| m % step == 0);
        let days = months.map(|m| calendar::days(m.div_euclid(12), m.rem_euclid(12) + 1, 1));
        let inside = days.filter(|day| (first..=last).contains(day));
        inside
            .map(|day| {
                let date = date_of(day);
                let label = if step % 12 == 0 {
                    &date[..4]
                } else {
                    &date[..7]
                };
                (day as f64, label.to_owned())
            })
            .collect()
    };
    let steps = [1, 2, 3, 6, 12, 24, 60, 120, 240];
    let found = steps
        .map(marks)
        .into_iter()
        .find(|m| m.len() <= MOST)
        .unwrap_or_default();
    match found.len() {
        0 | 1 => [first + around, last - around]
            .into_iter()
            .map(|day| (day as f64, date_of(day)))
            .collect(),
        _ => found,
    }
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
    fn law_marks_of_an_axis_are_few_and_round() {
        let labels = |first: &str, last: &str| -> Vec<String> {
            let marks = round_days(day_of(first).unwrap(), day_of(last).unwrap());
            marks.into_iter().map(|(_, label)| label).collect()
        };
        assert_eq!(
            labels("2015-03-01", "2020-03-01"),
            ["2015", "2016", "2017", "2018", "2019", "2020"]
        );
        assert_eq!(
            labels("2026-01-10", "2026-05-20"),
            [
                "2026-01", "2026-02", "2026-03", "2026-04", "2026-05", "2026-06"
            ]
        );
        assert_eq!(
            labels("2026-01-10", "2026-01-12"),
            ["2026-01-10", "2026-01-12"]
        );
        assert_eq!(
            labels("1950-01-01", "2026-01-01"),
            ["1960", "1980", "2000", "2020"]
        );
    }

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

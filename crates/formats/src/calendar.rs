//! Days of dates.

/// Days from some day on to a date of the Gregorian calendar.
pub(crate) fn days(year: i64, month: i64, day: i64) -> i64 {
    // Months from March on, so that the day of the leap year is the last one.
    let (year, month) = match month > 2 {
        true => (year, month - 3),
        false => (year - 1, month + 9),
    };
    let leaps = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    365 * year + leaps + (153 * month + 2) / 5 + day
}

#[cfg(test)]
mod tests {
    use super::days;

    #[test]
    fn known_days_between_dates() {
        let since_1970 = |y, m, d| days(y, m, d) - days(1970, 1, 1);
        assert_eq!(since_1970(2000, 2, 29), 11_016);
        assert_eq!(since_1970(2001, 3, 1), 11_382);
        assert_eq!(since_1970(2025, 3, 17), 20_164);
        assert_eq!(days(1900, 3, 1) - days(1900, 2, 28), 1);
    }
}

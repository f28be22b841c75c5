//! One time stamp, exactly as it stands: nanoseconds since 1970 lose nothing.

use crate::field::parse_number;
use proofmass_formats::calendar::days;
use proofmass_uncertainty::DecimalMark;

/// Parts of a unit that are told apart: 10⁻¹⁵.
pub(crate) const PARTS: i128 = 1_000_000_000_000_000;
const DECIMALS: u32 = 15;
/// Powers of ten up to that of [`DECIMALS`].
const POWERS: [i64; 16] = {
    let mut powers = [1; 16];
    let mut i = 1;
    while i < 16 {
        powers[i] = 10 * powers[i - 1];
        i += 1;
    }
    powers
};
/// Largest stamp in units, so that sums and differences stay within 128 bits.
const LARGEST: i128 = 10_i128.pow(21);

/// A time stamp as a whole number of 10⁻¹⁵ units of its column; of seconds since 1970 for a date with a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stamp {
    /// In 10⁻¹⁵ units.
    pub(crate) parts: i128,
    /// Decimals that were written, at most 15.
    pub(crate) decimals: u8,
    /// A date with a time, or hours, minutes and seconds, so that the unit is the second.
    pub(crate) dated: bool,
}

impl Stamp {
    /// Reads a decimal number of any common form, a date with a time after ISO 8601 or as `01.03.2026 12:00:00` (the day first), or hours,
    /// minutes and seconds.
    ///
    /// `2026-03-01T12:00:00.25Z`, with a blank for the `T`, with `+01:00` for the `Z` or with nothing (taken as UTC:
    /// only differences count); `23:59:59.25` are seconds since midnight, or of a clock that was started. Decimals beyond the
    /// fifteenth are rounded.
    pub fn parse(field: &[u8], decimal: DecimalMark) -> Option<Self> {
        let field = field.trim_ascii();
        let field = match field.strip_prefix(b"\"") {
            Some(inside) => inside.strip_suffix(b"\"")?.trim_ascii(),
            None => field,
        };
        plain(field, decimal)
            .or_else(|| dated(field))
            .or_else(|| clock(field))
            .or_else(|| rare(field, decimal))
    }

    /// A number of units, to fifteen decimals. Where a decimal of few digits has this double, it is meant: 4.996 is 4.996.
    pub(crate) fn of(value: f64) -> Option<Self> {
        if value.is_nan() || value.abs() >= LARGEST as f64 {
            return None;
        }
        let meant = |decimals: u32| {
            let unit = power(decimals);
            let digits = (value * unit as f64).round();
            // Both are doubles, so that the quotient is rounded once.
            let is_meant = digits.abs() < (1_i64 << 53) as f64 && digits / unit as f64 == value;
            is_meant.then(|| (digits as i128 * (PARTS / i128::from(unit)), decimals))
        };
        let whole = value.trunc();
        let nearest = || whole as i128 * PARTS + ((value - whole) * PARTS as f64).round() as i128;
        let (parts, decimals) = [6, 9, 12]
            .into_iter()
            .find_map(meant)
            .unwrap_or_else(|| (nearest(), DECIMALS));
        Some(Self {
            parts,
            decimals: decimals as u8,
            dated: false,
        })
    }

    /// The stamp in units, rounded to the nearest double.
    pub fn value(self) -> f64 {
        // Nearly all stamps have fewer digits than a double, and no more decimals than were written.
        let digits = match i64::try_from(self.parts) {
            Ok(parts) => digits(parts, self.decimals),
            Err(_) => {
                let unit = i128::from(power(DECIMALS - u32::from(self.decimals).min(DECIMALS)));
                i64::try_from(self.parts / unit)
                    .ok()
                    .filter(|d| i128::from(*d) * unit == self.parts)
            }
        };
        match digits {
            // Both are doubles, so that the quotient is rounded once.
            Some(digits) if digits.unsigned_abs() < 1 << 53 => {
                digits as f64 / power(u32::from(self.decimals)) as f64
            }
            _ => self.value_of_all_digits(),
        }
    }

    fn value_of_all_digits(self) -> f64 {
        let (mut digits, mut scale) = (self.parts, PARTS);
        while scale > 1 && digits % 10 == 0 {
            digits /= 10;
            scale /= 10;
        }
        if digits.unsigned_abs() < 1 << 53 {
            // Both are doubles, so that the quotient is rounded once.
            digits as f64 / scale as f64
        } else {
            (self.parts / PARTS) as f64 + (self.parts % PARTS) as f64 / PARTS as f64
        }
    }

    /// Units from another stamp to this one, rounded once from the exact difference.
    pub fn since(self, other: Self) -> f64 {
        Self {
            parts: self.parts - other.parts,
            decimals: self.decimals.max(other.decimals),
            dated: self.dated,
        }
        .value()
    }
}

/// 10 to a power of at most [`DECIMALS`].
fn power(of_ten: u32) -> i64 {
    POWERS[of_ten.min(DECIMALS) as usize]
}

/// Parts as a whole number of the last of so many decimals, where they are one. The divisors are constants, since a
/// division by a variable would take most of the time of reading a stamp.
fn digits(parts: i64, decimals: u8) -> Option<i64> {
    fn of<const DECIMALS: usize>(parts: i64) -> Option<i64> {
        let unit = const { POWERS[15 - DECIMALS] };
        (parts % unit == 0).then_some(parts / unit)
    }
    match decimals {
        0 => of::<0>(parts),
        1 => of::<1>(parts),
        2 => of::<2>(parts),
        3 => of::<3>(parts),
        4 => of::<4>(parts),
        5 => of::<5>(parts),
        6 => of::<6>(parts),
        7 => of::<7>(parts),
        8 => of::<8>(parts),
        9 => of::<9>(parts),
        10 => of::<10>(parts),
        11 => of::<11>(parts),
        12 => of::<12>(parts),
        13 => of::<13>(parts),
        14 => of::<14>(parts),
        _ => Some(parts),
    }
}

/// Digits with at most one decimal mark, as nearly all stamps are.
fn plain(field: &[u8], decimal: DecimalMark) -> Option<Stamp> {
    let (negative, digits) = match field {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        all => (false, all),
    };
    let mark = match decimal {
        DecimalMark::Point => b'.',
        DecimalMark::Comma => b',',
    };
    let (mut whole, mut decimals, mut seen, mut any) = (0_u64, 0_u32, false, false);
    // Nineteen digits fit 64 bits.
    if digits.len() > 20 {
        return None;
    }
    for &b in digits {
        if b.is_ascii_digit() {
            whole = whole.checked_mul(10)?.checked_add(u64::from(b - b'0'))?;
            decimals += u32::from(seen);
            any = true;
        } else if b == mark && !seen {
            seen = true;
        } else {
            return None;
        }
    }
    if !any || decimals > DECIMALS {
        return None;
    }
    let parts = i128::from(whole) * i128::from(power(DECIMALS - decimals));
    Some(Stamp {
        parts: if negative { -parts } else { parts },
        decimals: decimals as u8,
        dated: false,
    })
}

/// More digits than 64 bits hold, an exponent: digits by hand where there is none, else the nearest double.
fn rare(field: &[u8], decimal: DecimalMark) -> Option<Stamp> {
    let value = parse_number(field, decimal)?;
    let mark = match decimal {
        DecimalMark::Point => b'.',
        DecimalMark::Comma => b',',
    };
    let digits: &[u8] = match field {
        [b'-' | b'+', rest @ ..] => rest,
        all => all,
    };
    if !value.is_finite() || value.abs() >= LARGEST as f64 {
        return None;
    }
    if !digits.iter().all(|b| b.is_ascii_digit() || *b == mark) || digits.len() > 60 {
        return Stamp::of(value);
    }
    let (whole, fraction) = match digits.iter().position(|b| *b == mark) {
        Some(at) => (&digits[..at], &digits[at + 1..]),
        None => (digits, &[][..]),
    };
    let number = |digits: &[u8]| {
        digits
            .iter()
            .fold(0_i128, |n, b| n * 10 + i128::from(b - b'0'))
    };
    let kept = &fraction[..fraction.len().min(DECIMALS as usize)];
    let up = fraction.get(DECIMALS as usize).is_some_and(|b| *b >= b'5');
    let parts = number(whole) * PARTS
        + number(kept) * i128::from(power(DECIMALS - kept.len() as u32))
        + i128::from(up);
    Some(Stamp {
        parts: if field.first() == Some(&b'-') {
            -parts
        } else {
            parts
        },
        decimals: kept.len() as u8,
        dated: false,
    })
}

/// `YYYY-MM-DD` or, with points, `DD.MM.YYYY`; `T` or a blank, `hh:mm:ss`, a fraction, `Z` or an offset.
fn dated(field: &[u8]) -> Option<Stamp> {
    let digits = |range: std::ops::Range<usize>| -> Option<i64> {
        field.get(range)?.iter().try_fold(0, |n: i64, b| {
            b.is_ascii_digit().then(|| n * 10 + i64::from(b - b'0'))
        })
    };
    let sign = |at: usize, b: u8| (field.get(at) == Some(&b)).then_some(());
    let (year, month, day) = if sign(2, b'.').is_some() {
        sign(5, b'.')?;
        (digits(6..10)?, digits(3..5)?, digits(0..2)?)
    } else {
        sign(4, b'-')?;
        sign(7, b'-')?;
        (digits(0..4)?, digits(5..7)?, digits(8..10)?)
    };
    matches!(field.get(10), Some(b'T' | b't' | b' ')).then_some(())?;
    let (hour, minute, second) = (digits(11..13)?, digits(14..16)?, digits(17..19)?);
    sign(13, b':')?;
    sign(16, b':')?;
    let month_length = match month {
        4 | 6 | 9 | 11 => 30,
        2 if year % 4 == 0 && (year % 100 != 0 || year % 400 == 0) => 29,
        2 => 28,
        _ => 31,
    };
    // A leap second is counted as the first second of the next minute, as computers do.
    let valid = (1..=12).contains(&month)
        && (1..=month_length).contains(&day)
        && hour < 24
        && minute < 60
        && second <= 60;
    valid.then_some(())?;
    let (fraction, decimals, at) = decimals_of(field, 19);
    let offset = match field.get(at..)? {
        [] | [b'Z' | b'z'] => 0,
        [s @ (b'+' | b'-'), h1, h2, rest @ ..] => {
            let minutes: &[u8] = match rest {
                [] => b"00",
                [b':', m1, m2] => &[*m1, *m2],
                [m1, m2] => &[*m1, *m2],
                _ => return None,
            };
            let two = |a: u8, b: u8| -> Option<i64> {
                (a.is_ascii_digit() && b.is_ascii_digit())
                    .then(|| i64::from(a - b'0') * 10 + i64::from(b - b'0'))
            };
            let seconds = two(*h1, *h2)? * 3600 + two(minutes[0], minutes[1])? * 60;
            if *s == b'-' { -seconds } else { seconds }
        }
        _ => return None,
    };
    let seconds = days(year, month, day) * 86_400 + hour * 3600 + minute * 60 + second - offset;
    Some(Stamp {
        parts: i128::from(seconds) * PARTS + fraction,
        decimals,
        dated: true,
    })
}

/// `hh:mm:ss` with a fraction: seconds of a day, or of a clock that was started and has up to four digits of hours.
fn clock(field: &[u8]) -> Option<Stamp> {
    let colon = field.iter().position(|b| *b == b':')?;
    let number = |digits: &[u8]| -> Option<i64> {
        let digit = |n: i64, b: &u8| b.is_ascii_digit().then(|| n * 10 + i64::from(b - b'0'));
        digits.iter().try_fold(0, digit)
    };
    let (hours, rest) = (&field[..colon], &field[colon + 1..]);
    let two = |at: usize| rest.get(at..at + 2).and_then(number);
    let (minutes, seconds) = (two(0)?, two(3)?);
    let form = (1..=4).contains(&hours.len()) && rest[2] == b':' && minutes < 60 && seconds <= 60;
    form.then_some(())?;
    let (fraction, decimals, end) = decimals_of(rest, 5);
    (end == rest.len()).then_some(())?;
    let whole = number(hours)? * 3600 + minutes * 60 + seconds;
    Some(Stamp {
        parts: i128::from(whole) * PARTS + fraction,
        decimals,
        dated: true,
    })
}

/// The parts of a second behind a point or a comma, their decimals, and where they end.
fn decimals_of(field: &[u8], mut at: usize) -> (i128, u8, usize) {
    let (mut fraction, mut decimals) = (0_i128, 0_u32);
    if matches!(field.get(at), Some(b'.' | b',')) {
        at += 1;
        while let Some(b) = field.get(at).filter(|b| b.is_ascii_digit()) {
            if decimals < DECIMALS {
                fraction = fraction * 10 + i128::from(b - b'0');
                decimals += 1;
            }
            at += 1;
        }
    }
    let parts = fraction * i128::from(power(DECIMALS - decimals));
    (parts, decimals as u8, at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Option<Stamp> {
        Stamp::parse(text.as_bytes(), DecimalMark::Point)
    }

    #[test]
    fn known_stamps_are_exact() {
        let at = |text: &str| parse(text).unwrap();
        // Neighbouring nanoseconds since 1970, which a double cannot tell apart.
        let (a, b) = (at("1700000000123456789"), at("1700000000123456790"));
        assert_eq!(b.since(a), 1.0);
        let (a, b) = (at("1700000000.123456789"), at("1700000000.123456790"));
        assert_eq!(b.since(a), 1e-9);
        assert_eq!(at("-0.25").value(), -0.25);
        // Dates with points have the day first.
        assert_eq!(at("01.03.2026 12:00:00,25"), at("2026-03-01T12:00:00.25Z"));
        assert_eq!(parse("30.02.2026 12:00:00"), None);
        assert_eq!(at("+3").decimals, 0);
        assert_eq!(at("1.5e-3").value(), 1.5e-3);
        assert_eq!(at("\"7\"").value(), 7.0);
        assert_eq!(at("0.30000000000000004").value(), 0.3);
        assert_eq!(
            Stamp::parse(b"2,5", DecimalMark::Comma).unwrap().value(),
            2.5
        );
        for text in [
            "", "nan", "inf", "1e30", "abc", "1.2.3", "-", ".", "--1", "1e99999",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    #[test]
    fn published_iso_8601() {
        // RFC 3339, section 5.8, and POSIX seconds since the epoch for them.
        for (text, seconds) in [
            ("1985-04-12T23:20:50.52Z", 482_196_050.52),
            ("1996-12-19T16:39:57-08:00", 851_042_397.0),
            ("1990-12-31T23:59:60Z", 662_688_000.0),
            ("1937-01-01T12:00:27.87+00:20", -1_041_337_172.13),
            ("2000-02-29 00:00:00", 951_782_400.0),
            ("1970-01-01T00:00:00+0000", 0.0),
        ] {
            let stamp = parse(text).unwrap();
            assert!(stamp.dated);
            assert_eq!(stamp.value(), seconds, "{text}");
        }
        for text in [
            "2026-02-29T00:00:00",
            "2026-13-01T00:00:00",
            "2026-01-01T24:00:00",
            "2026-01-01",
            "2026-01-01T00:00:00X",
            "2026-01-01T00:00:00+1",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    #[test]
    fn known_times_of_day_are_seconds() {
        for (text, seconds) in [
            ("00:00:00", 0.0),
            ("12:34:56.25", 45_296.25),
            ("7:05:09,5", 25_509.5),
            ("123:00:00.010", 442_800.01),
        ] {
            let stamp = parse(text).unwrap();
            assert!(stamp.dated);
            assert_eq!(stamp.value(), seconds, "{text}");
        }
        for text in [
            "12:34",
            "12:60:00",
            "12:00:61",
            "12:00:00.5s",
            ":00:00",
            "1:2:3",
            "12:34:56:78",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    #[test]
    fn law_a_value_does_not_depend_on_the_decimals_that_are_said() {
        let mut state = 7_u64;
        for i in 0..20_000_u32 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let digits = i128::from(state >> (i % 60)) - i128::from(state >> 33);
            let parts = digits * i128::from(power(state as u32 % 16));
            for decimals in [0, 3, 9, 15] {
                let stamp = Stamp {
                    parts,
                    decimals,
                    dated: false,
                };
                assert_eq!(stamp.value(), stamp.value_of_all_digits(), "{stamp:?}");
            }
        }
    }

    #[test]
    fn law_a_double_of_a_decimal_is_that_decimal() {
        for i in 0..200_000_i64 {
            for (stored, text) in [
                (i as f64 / 250.0, i * 4_000_000),
                (i as f64 / 1e9, i),
                (
                    1_700_000_000.0 + i as f64 / 1e6,
                    1_700_000_000_000_000_000 + i * 1000,
                ),
            ] {
                let stamp = Stamp::of(stored).unwrap();
                assert_eq!(stamp.parts, i128::from(text) * 1_000_000, "{stored:?}");
                assert_eq!(stamp.value(), stored);
            }
        }
        assert_eq!(Stamp::of(0.1 + 0.2).unwrap().parts, 300_000_000_000_000);
    }

    #[test]
    fn law_the_value_is_that_of_the_number_reader() {
        let mut state = 1_u64;
        for _ in 0..20_000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let decimals = (state >> 60) as usize;
            let text = format!("{:.*}", decimals.min(9), (state >> 40) as f64 * 1.234e-4);
            assert_eq!(
                parse(&text).unwrap().value(),
                text.parse::<f64>().unwrap(),
                "{text}"
            );
        }
    }
}

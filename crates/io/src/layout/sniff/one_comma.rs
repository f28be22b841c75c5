//! Rows of digits with one comma: two columns of whole numbers, or one of decimal fractions.

use super::{Line, is_comment, is_whole};
use crate::{Error, ErrorKind, Result};
use std::collections::BTreeSet;

/// Rows from which on fractions without a leading zero are no chance: nine in ten have another digit there.
const MANY: usize = 100;
/// Leading digits that make a wide range of fractions.
const WIDE: usize = 5;

/// Whether the one comma of each row is the decimal mark.
///
/// A comma in the heading, a sign behind the comma and many fractions that never begin with a zero speak for two columns; a fraction that
/// begins with a zero, and a heading without a comma, for one.
///
/// # Errors
/// Both are plausible.
pub(super) fn is_decimal_mark(
    lines: &[Line],
    content: &[&Line],
    comment: &[String],
) -> Result<bool> {
    let first = content.iter().position(|l| halves(l.text).is_some());
    let Some(first) = first else { return Ok(false) };
    let rows: Option<Vec<(&[u8], &[u8])>> =
        content[first..].iter().map(|l| halves(l.text)).collect();
    let Some(rows) = rows else { return Ok(false) };
    let above = match first {
        0 => {
            // A remark is no heading, but where it has a comma it is one of two columns.
            let before = lines.iter().rfind(|l| l.number < content[0].number);
            before.filter(|l| is_comment(l.text, comment) && l.text.contains(&b','))
        }
        n => Some(content[n - 1]),
    };
    let behind = || rows.iter().map(|r| r.1);
    if above.is_some_and(|l| l.text.contains(&b',')) || behind().any(|f| !f[0].is_ascii_digit()) {
        return Ok(false);
    }
    if behind().any(|f| f.len() > 1 && f[0] == b'0') {
        return Ok(true);
    }
    let leading: BTreeSet<u8> = behind().map(|f| f[0]).collect();
    if rows.len() >= MANY && leading.len() >= WIDE {
        return Ok(false);
    }
    let value = |digits: &[u8]| std::str::from_utf8(digits).ok()?.parse::<f64>().ok();
    let rises = rows.windows(2).all(|w| value(w[0].0) < value(w[1].0));
    if above.is_some() && !rises {
        return Ok(true);
    }
    if above.is_none() && rises && rows.len() > 1 {
        return Ok(false);
    }
    Err(Error::new(
        ErrorKind::Row,
        "it is not known whether the comma separates two columns or is the decimal mark",
    )
    .line(content[first].number)
    .with_hint(
        "say --decimal comma (`decimal = \"comma\"` in a campaign) where it is the decimal mark, --separator comma (`separator = \"comma\"` in a campaign) where it separates",
    ))
}

/// What stands before and behind the one comma of a row of digits.
fn halves(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let at = memchr::memchr(b',', text)?;
    let (before, behind) = (text[..at].trim_ascii(), text[at + 1..].trim_ascii());
    (is_whole(before) && is_whole(behind)).then_some((before, behind))
}

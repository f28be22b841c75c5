//! What the first rows of a column hold: enough to tell in what unit it may be.

use crate::layout::Separator;
use crate::layout::sniff::{is_comment, split};
use crate::stamp::Stamp;
use proofmass_uncertainty::DecimalMark;

/// Rows that are looked at.
const ROWS: usize = 4000;

/// The head of one column.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ColumnHead {
    /// The first stamp or number.
    pub(crate) first: Option<Stamp>,
    /// Typical step from row to row, in units of the column; `None` where it never rises.
    pub(crate) step: Option<f64>,
    /// Whether it rises with every row.
    pub(crate) rises: bool,
    /// Whether every number is a whole one.
    pub(crate) whole: bool,
    /// Mean of the squares.
    pub(crate) mean_square: f64,
    /// A number of a column in which every mark may be one of thousands: `37,162`.
    pub(crate) grouped: Option<String>,
}

/// The heads of all columns of the rows that begin in `text`.
pub(crate) fn of<'a>(
    lines: impl Iterator<Item = &'a [u8]>,
    separator: Separator,
    decimal: DecimalMark,
    comment: &[String],
    columns: usize,
) -> Vec<ColumnHead> {
    let mut stamps: Vec<Vec<Stamp>> = vec![Vec::new(); columns];
    let mut groups = vec![Groups::default(); columns];
    let rows = lines.filter(|l| !l.trim_ascii().is_empty() && !is_comment(l, comment));
    for line in rows.take(ROWS) {
        for ((column, groups), field) in stamps
            .iter_mut()
            .zip(&mut groups)
            .zip(split(line, separator))
        {
            column.extend(Stamp::parse(field, decimal));
            groups.see(field.trim_ascii(), decimal);
        }
    }
    let heads = stamps
        .iter()
        .zip(groups)
        .map(|(stamps, groups)| ColumnHead {
            grouped: groups.example.filter(|_| !groups.never),
            ..ColumnHead::of(stamps)
        });
    heads.collect()
}

/// Whether the marks of a column may be those of thousands.
#[derive(Clone, Debug, Default)]
struct Groups {
    /// The first number with such a mark.
    example: Option<String>,
    /// A number that is not written so.
    never: bool,
}

impl Groups {
    fn see(&mut self, field: &[u8], decimal: DecimalMark) {
        let digits = field
            .strip_prefix(b"-")
            .or(field.strip_prefix(b"+"))
            .unwrap_or(field);
        if digits.is_empty() {
            return;
        }
        let mark = match decimal {
            DecimalMark::Point => b'.',
            DecimalMark::Comma => b',',
        };
        let mut parts = digits.split(|b| *b == mark);
        let first = parts.next().unwrap_or_default();
        let is_number = digits.iter().all(|b| b.is_ascii_digit() || *b == mark);
        let fits = |part: &[u8]| part.len() == 3;
        let has_marks = digits.contains(&mark);
        // Below one thousand there is no mark, and no number begins with a zero.
        let begins = (1..=3).contains(&first.len()) && (!has_marks || first[0] != b'0');
        if !(is_number && begins && parts.all(fits)) {
            self.never = true;
        } else if has_marks && self.example.is_none() {
            self.example = Some(String::from_utf8_lossy(field).into_owned());
        }
    }
}

impl ColumnHead {
    pub(crate) fn of(stamps: &[Stamp]) -> Self {
        let values = || stamps.iter().map(|s| s.value());
        let steps: Vec<f64> = stamps.windows(2).map(|w| w[1].since(w[0])).collect();
        let mut rising: Vec<f64> = steps.iter().copied().filter(|s| *s > 0.0).collect();
        rising.sort_by(f64::total_cmp);
        // Steps over gaps, and those back, are no steps from sample to sample; stamps that repeat are.
        let step = rising.get(rising.len() / 2).map(|middle| {
            let usual = || steps.iter().filter(|s| (0.0..=5.0 * middle).contains(*s));
            usual().sum::<f64>() / usual().count() as f64
        });
        Self {
            first: stamps.first().copied(),
            step,
            rises: steps.len() > 1 && steps.iter().all(|s| *s > 0.0),
            whole: values().all(|v| v.fract() == 0.0),
            mean_square: values().map(|v| v * v).sum::<f64>() / stamps.len().max(1) as f64,
            grouped: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grouped(fields: &[&str], decimal: DecimalMark) -> Option<String> {
        let mut groups = Groups::default();
        fields
            .iter()
            .for_each(|f| groups.see(f.as_bytes(), decimal));
        groups.example.filter(|_| !groups.never)
    }

    #[test]
    fn known_marks_of_thousands() {
        let comma = |fields: &[&str]| grouped(fields, DecimalMark::Comma);
        assert_eq!(comma(&["37,162", "33,703"]).as_deref(), Some("37,162"));
        assert_eq!(comma(&["995", "-1,003", ""]).as_deref(), Some("-1,003"));
        assert_eq!(
            grouped(&["37.162", "1.002"], DecimalMark::Point).as_deref(),
            Some("37.162")
        );
        for no in [
            ["0,012", "1,003"],
            ["12,5", "12,125"],
            ["33120,181", "33121,002"],
            ["9,80665", "9,807"],
            ["1e3", "1,003"],
            ["12", "999"],
            ["1000", "1,003"],
        ] {
            assert_eq!(comma(&no), None, "{no:?}");
        }
    }
}

//! Numbers above the data that are none of it: how many rows there are, their interval, the rate.

use super::{DecimalMark, Line, Separator, fits, is_number, is_whole, split};
use crate::Unit;
use crate::field::parse_number;

/// Rows that tell how the numbers of a column are written.
const ROWS: usize = 20;
/// A number above the data is so many times as large as any of them.
const LARGER: f64 = 10.0;

/// How the columns are written, as far as lines above them are told by it.
pub(super) struct Shape {
    separator: Separator,
    decimal: DecimalMark,
    columns: usize,
    /// Largest magnitude of each column whose numbers all have a fraction.
    fractions: Vec<Option<f64>>,
}

impl Shape {
    pub(super) fn of(
        voters: &[&Line],
        separator: Separator,
        decimal: DecimalMark,
        columns: usize,
    ) -> Self {
        // The first of few is what is asked about.
        let rows: Vec<Vec<&[u8]>> = voters
            .iter()
            .skip(1)
            .map(|l| split(l.text, separator))
            .filter(|f| fits(f, columns))
            .collect();
        let largest = |k: usize| {
            let mut values = rows.iter().map(|row| {
                let whole = is_whole(row[k]);
                parse_number(row[k], decimal).filter(|_| !whole)
            });
            values.try_fold(0.0f64, |most, v| Some(most.max(v?.abs())))
        };
        let enough = rows.len() >= ROWS;
        Self {
            separator,
            decimal,
            columns,
            fractions: (0..columns)
                .map(|k| largest(k).filter(|_| enough))
                .collect(),
        }
    }

    /// Whether a line is numbers of another kind than the rows: more of them than the one column, one with its unit, or a
    /// whole number ten times as large as all the fractions below it.
    pub(super) fn is_above_data(&self, text: &[u8]) -> bool {
        let pieces = pieces(text);
        let number = |p: &&[u8]| is_number(p, self.decimal);
        if self.columns == 1 && pieces.len() > 1 {
            let unit = |p: &[u8]| Unit::recognise(&String::from_utf8_lossy(p)).is_some();
            return self.is_several_numbers(text)
                || (pieces.len() == 2 && number(&pieces[0]) && unit(pieces[1]));
        }
        let fields = split(text, self.separator);
        fits(&fields, self.columns)
            && fields.iter().all(number)
            && fields.iter().zip(&self.fractions).any(|(f, most)| {
                let value = parse_number(f, self.decimal).map_or(0.0, f64::abs);
                most.is_some_and(|most| is_whole(f) && value > LARGER * most)
            })
    }

    /// Whether a line above one column holds several numbers, as the number of rows and their interval.
    pub(super) fn is_several_numbers(&self, text: &[u8]) -> bool {
        let pieces = pieces(text);
        self.columns == 1 && pieces.len() > 1 && pieces.iter().all(|p| is_number(p, self.decimal))
    }
}

/// What stands between blanks, semicolons and strokes.
fn pieces(text: &[u8]) -> Vec<&[u8]> {
    text.split(|b| b.is_ascii_whitespace() || matches!(b, b';' | b'|'))
        .filter(|p| !p.is_empty())
        .collect()
}

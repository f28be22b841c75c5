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
    let rows = lines.filter(|l| !l.trim_ascii().is_empty() && !is_comment(l, comment));
    for line in rows.take(ROWS) {
        for (column, field) in stamps.iter_mut().zip(split(line, separator)) {
            column.extend(Stamp::parse(field, decimal));
        }
    }
    stamps.iter().map(|s| ColumnHead::of(s)).collect()
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
        }
    }
}

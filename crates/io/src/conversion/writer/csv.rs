//! Comma-separated text: headings with units, numbers with the fewest digits that read back as the same double.

use super::super::timed_rows::TimedLayout;
use super::times::Times;
use crate::rewriter::{PIECE, push_text};
use crate::stamp::Stamp;
use crate::{Unit, split_heading};
use rayon::prelude::*;
use std::ops::Range;

/// Heading of the times.
pub(super) const TIME: &str = "time_s";
/// Decimals of the parts of a stamp.
const DECIMALS: usize = 15;

/// The line of headings.
pub(super) fn head(layout: &TimedLayout, timed: bool) -> Vec<u8> {
    let mut line = Vec::new();
    if timed {
        line.extend(TIME.as_bytes());
    }
    for (name, unit) in layout.names.iter().zip(&layout.units) {
        let first = line.is_empty();
        if !first {
            line.push(b',');
        }
        push_text(&mut line, heading(name, *unit).as_bytes(), first);
    }
    line.push(b'\n');
    line
}

/// A heading from which name and unit are read again.
pub(in crate::conversion) fn heading(name: &str, unit: Option<Unit>) -> String {
    let Some(unit) = unit else {
        return name.to_owned();
    };
    let plain = format!("{name}_{}", unit.ascii());
    match split_heading(&plain) == (name, Some(unit)) {
        true => plain,
        false => format!("{name} ({})", unit.ascii()),
    }
}

/// Rows, in pieces that follow one another.
pub(super) fn rows(times: &Times, columns: &[&[f64]]) -> Vec<Vec<u8>> {
    let count = columns.first().map_or(0, |c| c.len());
    (0..count.div_ceil(PIECE))
        .into_par_iter()
        .map(|i| piece(times, columns, i * PIECE..count.min((i + 1) * PIECE)))
        .collect()
}

fn piece(times: &Times, columns: &[&[f64]], rows: Range<usize>) -> Vec<u8> {
    let mut out = Vec::with_capacity(rows.len() * 20 * (columns.len() + 1));
    let mut digits = ryu::Buffer::new();
    let timed = !matches!(times, Times::None);
    // A row of nothing would be an empty line, which is passed over when it is read.
    let alone = !timed && columns.len() == 1;
    for row in rows {
        match times {
            Times::None => {}
            Times::Seconds(seconds) => push_number(&mut out, &mut digits, seconds[row]),
            Times::Stamps {
                stamps, per_second, ..
            } => push_stamp(&mut out, &mut digits, stamps[row], *per_second),
        }
        for (i, column) in columns.iter().enumerate() {
            if timed || i > 0 {
                out.push(b',');
            }
            match column[row] {
                v if !v.is_nan() => push_number(&mut out, &mut digits, v),
                _ if alone => out.extend(b"NaN"),
                _ => {}
            }
        }
        out.push(b'\n');
    }
    out
}

fn push_number(out: &mut Vec<u8>, digits: &mut ryu::Buffer, number: f64) {
    let text = digits.format_finite(number);
    out.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
}

/// A stamp in seconds: all of its digits where its unit is a power of ten of a second.
fn push_stamp(out: &mut Vec<u8>, digits: &mut ryu::Buffer, stamp: Stamp, per_second: f64) {
    let shift = match per_second {
        1.0 => 0,
        1e3 => 3,
        1e6 => 6,
        1e9 => 9,
        _ => usize::MAX,
    };
    if shift == usize::MAX || usize::from(stamp.decimals) >= DECIMALS {
        return push_number(out, digits, stamp.value() / per_second);
    }
    if stamp.parts < 0 {
        out.push(b'-');
    }
    let scale = 10_u128.pow((DECIMALS + shift) as u32);
    let parts = stamp.parts.unsigned_abs();
    let (whole, fraction) = (parts / scale, parts % scale);
    out.extend(whole.to_string().as_bytes());
    if fraction > 0 {
        let text = format!(".{fraction:0width$}", width = DECIMALS + shift);
        out.extend(text.trim_end_matches('0').as_bytes());
    }
}

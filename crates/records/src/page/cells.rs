//! What stands in the cells of these pages.

use crate::day::date_of;
use proofmass_report::Cell;

pub(super) fn date(day: Option<i64>) -> Cell {
    day.map(date_of).into()
}

pub(super) fn number(n: i64) -> Cell {
    Cell::number(n.to_string())
}

/// A digest as it is shown.
pub(super) fn short(sha256: &str) -> String {
    match sha256.get(..12) {
        Some(start) => format!("{start}…"),
        None => sha256.to_owned(),
    }
}

pub(super) fn integer(row: &[crate::engine::Value], i: usize) -> Option<i64> {
    row[i].integer()
}

pub(super) fn real(row: &[crate::engine::Value], i: usize) -> Option<f64> {
    row[i].real()
}

pub(super) fn text(row: &[crate::engine::Value], i: usize) -> Cell {
    row[i].text().map(str::to_owned).into()
}

/// A value with the standard uncertainty behind it.
pub(super) fn pair(row: &[crate::engine::Value], i: usize) -> Cell {
    match (row[i].real(), row[i + 1].real()) {
        (Some(value), Some(u)) => Cell::Estimate(value, u),
        (value, _) => value.into(),
    }
}

/// The name of a device, which leads to its page.
pub(super) fn device(number: i64, name: &str) -> Cell {
    Cell::linked(name, format!("device-{number}.html"))
}

//! Columns that tables of many jobs have.

use proofmass_report::{Cell, Field, Rounding};

/// A number of the file alone.
pub(crate) fn filed<'a, R, V: Into<Cell>>(
    name: impl Into<String>,
    get: impl Fn(&R) -> V + 'a,
) -> Field<'a, R> {
    Field::new(name, move |row| get(row).into())
}

/// A number of file and page; without a name of the page alone.
pub(crate) fn number<'a, R, V: Into<Cell>>(
    name: impl Into<String>,
    (heading, unit): (&str, &str),
    rounding: Rounding,
    get: impl Fn(&R) -> V + 'a,
) -> Field<'a, R> {
    filed(name, get).page(heading, unit).rounded(rounding)
}

/// The frequency.
pub(crate) fn frequency<'a, R>(get: impl Fn(&R) -> f64 + 'a) -> Field<'a, R> {
    number("frequency_Hz", ("f", "Hz"), Rounding::Plain, get)
}

/// A ratio, in per cent with two significant digits.
pub(crate) fn percent<'a, R>(
    name: &str,
    heading: &str,
    get: impl Fn(&R) -> f64 + 'a,
) -> Field<'a, R> {
    number(name, (heading, "%"), Rounding::TwoDigits, move |row| {
        100.0 * get(row)
    })
}

/// An angle, in degrees with two significant digits.
pub(crate) fn degrees<'a, R, V: Into<Option<f64>>>(
    name: &str,
    heading: &str,
    get: impl Fn(&R) -> V + 'a,
) -> Field<'a, R> {
    number(name, (heading, "°"), Rounding::TwoDigits, move |row| {
        get(row).into().map(f64::to_degrees)
    })
}

/// The factor by which an expanded uncertainty is larger than its standard uncertainty; without a name of the page alone.
pub(crate) fn coverage_factor<'a, R, V: Into<Cell>>(
    name: &str,
    get: impl Fn(&R) -> V + 'a,
) -> Field<'a, R> {
    number(name, ("k", ""), Rounding::Decimals(2), get)
}

/// The ratio of a difference to its expanded uncertainty.
pub(crate) fn e_n<'a, R, V: Into<Cell>>(name: &str, get: impl Fn(&R) -> V + 'a) -> Field<'a, R> {
    number(name, ("E_n", ""), Rounding::Decimals(2), get)
}

/// A number of the page alone, as printed by the caller.
pub(crate) fn printed<'a, R, V: Into<Option<String>>>(
    heading: impl Into<String>,
    unit: &str,
    get: impl Fn(&R) -> V + 'a,
) -> Field<'a, R> {
    Field::shown(heading, unit, move |row| {
        get(row).into().map(Cell::number).into()
    })
}

/// Words of the page alone.
pub(crate) fn words<'a, R, V: Into<String>>(
    heading: &str,
    get: impl Fn(&R) -> V + 'a,
) -> Field<'a, R> {
    Field::shown(heading, "", move |row| get(row).into().into())
}

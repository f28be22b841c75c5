//! Fitted parameters with their intervals.

use super::columns::coverage_factor;
use proofmass_documents::StatedQuantity;
use proofmass_report::number::freedom;
use proofmass_report::{Cell, Field, Rounding, Table};
use proofmass_uncertainty::Quantity;

/// A row for each parameter, as the pages of dynamic tests show them.
pub(crate) fn parameters(caption: &str, quantities: &[Quantity]) -> Table {
    let fields = [
        Field::shown("parameter", "", |q: &Quantity| q.name.as_str().into()),
        Field::estimate("", "", |q: &Quantity| {
            Some((q.value, q.standard_uncertainty))
        })
        .page("value", ""),
        Field::shown("U (95 %)", "", |q: &Quantity| q.expanded(0.95).into())
            .rounded(Rounding::TwoDigits),
        coverage_factor("", |q: &Quantity| q.coverage_factor(0.95)),
        Field::shown("unit", "", |q: &Quantity| q.unit.as_str().into()),
    ];
    Table::of(caption, fields, quantities)
}

/// Parameters of a calibration, in `parameters.csv` too; the page has the texts that are given for value and U.
pub(crate) fn stated_parameters(
    caption: String,
    quantities: &[StatedQuantity],
    printed: impl Fn(&StatedQuantity) -> [String; 2],
) -> Table {
    let nu = |q: &StatedQuantity| {
        let nu = q.nu_eff.map_or(f64::INFINITY, |nu| nu.get());
        Cell::printed(Some(nu).filter(|nu| nu.is_finite()), freedom(nu))
    };
    let value = |q: &StatedQuantity| Cell::printed(q.value, printed(q)[0].as_str());
    let expanded = |q: &StatedQuantity| Cell::printed(q.expanded, printed(q)[1].as_str());
    let fields = [
        Field::new("quantity", |q: &StatedQuantity| q.name.as_str().into()).page("quantity", ""),
        Field::new("value", value).page("value", ""),
        Field::new("unit", |q: &StatedQuantity| q.unit.as_str().into()),
        Field::new("u", |q: &StatedQuantity| q.u.into()),
        Field::new("U", expanded).page("U", ""),
        Field::shown("unit", "", |q: &StatedQuantity| q.unit.as_str().into()),
        coverage_factor("k", |q: &StatedQuantity| q.k),
        Field::new("nu_eff", nu).page("ν_eff", ""),
    ];
    Table::of(caption, fields, quantities).file("parameters.csv")
}

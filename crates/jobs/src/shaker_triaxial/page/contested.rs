//! The result with the runs that contradict the others beside the one without.

use super::digits::{TERMS, Unit};
use super::sign;
use crate::page::columns::{frequency, printed, words};
use proofmass_report::{Section, Table};
use proofmass_shaker::{Contested, ShakerCalibration};

/// Frequencies with runs that contradict the others, with them and without.
pub(super) fn section(calibration: &ShakerCalibration, unit: Unit) -> Option<Section> {
    if calibration.contested.is_empty() {
        return None;
    }
    type Row<'a> = (f64, String, &'a [[f64; 2]]);
    let several = |c: &Contested| {
        let mut others = calibration.contested.iter();
        others.any(|o| o.correction != c.correction)
    };
    let rows = calibration.contested.iter().flat_map(|c| {
        let correction = match several(c) {
            true => format!(" ({})", c.correction),
            false => String::new(),
        };
        let row = |words: &str, s| (c.frequency, format!("{words}{correction}"), s);
        let with = c.with.as_ref().map(|with| row("with", &with[..]));
        let without: Row<'_> = row("without", &c.without[..]);
        std::iter::once(without).chain(with)
    });
    let mut fields = vec![
        frequency(|r: &Row<'_>| r.0),
        words("result", |r: &Row<'_>| r.1.clone()),
    ];
    for (k, term) in TERMS.into_iter().enumerate() {
        fields.push(printed(
            format!("S_{term}"),
            unit.name,
            move |r: &Row<'_>| Some(sign(format!("{:.4}", unit.factor * r.2.get(k)?[0]))),
        ));
    }
    let table = Table::of(
        "Real parts of S with and without the runs in question",
        fields,
        rows,
    );
    let runs = calibration.contested.iter().flat_map(|c| &c.runs);
    let mut names: Vec<&str> = runs.map(String::as_str).collect();
    names.sort_unstable();
    names.dedup();
    Some(
        Section::new("Result with and without the runs in question")
            .paragraph(format!(
                "Run {} contradicts the others. The result is without; at these frequencies its intervals reach the result with \
                 every run (of that frequency alone), U² = (k u)² + ΔS², until somebody has decided. Other frequencies are not \
                 touched. Where only one line stands, no angles reconcile the runs with the others.",
                names.join(", ")
            ))
            .table(table),
    )
}

//! One result with all it rests on.

use super::cells::{number, short};
use crate::entry::{Content, FiledQuantity};
use crate::ledger::Records;
use crate::rests::Rest;
use proofmass_jobs::{Result, Trouble};
use proofmass_report::{Cell, Field, Report, Rounding, Section, Table};

/// A result: its quantities, and what it rests on.
///
/// # Errors
/// There is no such result, or the database refuses.
pub fn result(records: &mut Records, result: i64) -> Result<Report> {
    let Content::Result(filed) = records.entry(result)?.content else {
        return Err(Trouble::request(format!("entry {result} is no result"))
            .with_hint("`proofmass records list` has the results"));
    };
    let device = records.filed_device(filed.device)?;
    let mut page = Report::new(format!("Result {result} of {}", device.line()))
        .meta("kind", filed.result_kind.clone())
        .meta("day", filed.date.clone())
        .meta("computed by", filed.source.clone());
    if let Some(number) = &filed.number {
        page = page.meta("certificate", number.clone());
    }
    page = page.question(match records.superseded(result)? {
        Some((Some(new), reason)) => format!("Superseded by result {new}: {reason}."),
        Some((None, reason)) => format!("It no longer counts: {reason}."),
        None => "It counts.".to_owned(),
    });
    let fields = [
        Field::new("quantity", |q: &FiledQuantity| q.name.as_str().into()).page("quantity", ""),
        Field::new("value", |q: &FiledQuantity| {
            q.u.map_or(q.value.into(), |u| Cell::Estimate(q.value, u))
        })
        .page("value", ""),
        Field::new("U", |q: &FiledQuantity| q.expanded.into())
            .page("U", "")
            .rounded(Rounding::Power(2)),
        Field::new("k", |q: &FiledQuantity| q.k.into())
            .page("k", "")
            .decimals(2),
        Field::new("unit", |q: &FiledQuantity| q.unit.as_str().into()).page("unit", ""),
        Field::new("u_standard", |q: &FiledQuantity| q.u_standard.into())
            .page("u of the standard", "")
            .rounded(Rounding::Power(1)),
    ];
    let table = Table::of("", fields, &filed.quantities);
    page = page.findings(records.doubts_about(&filed, result)?);
    let rests = records.rests_on(result)?;
    page = page.section(Section::new("Quantities").table(table).summarised());
    if !rests.is_empty() {
        page = page.section(
            Section::new("What it rests on")
                .table(rests_table(&rests))
                .summarised(),
        );
    }
    Ok(page)
}

pub(super) fn rests_table(rests: &[Rest]) -> Table {
    let fields = [
        Field::new("depth", |r: &Rest| number(r.depth as i64)).page("depth", ""),
        Field::new("result", |r: &Rest| number(r.result)).page("named by", ""),
        Field::new("name", |r: &Rest| r.name.as_str().into()).page("file", ""),
        Field::new("sha256", |r: &Rest| r.sha256.as_str().into()),
        Field::shown("SHA-256", "", |r: &Rest| short(&r.sha256).into()),
        Field::shown("kept as", "", |r: &Rest| {
            match (r.kept, r.from) {
                (_, Some(from)) => format!("of result {from}"),
                (true, None) => "kept".to_owned(),
                (false, None) => "its digest alone".to_owned(),
            }
            .into()
        }),
    ];
    Table::of("", fields, rests).file("rests_on.csv")
}

//! Every promise of the datasheet, with every correction.

use super::super::tables::{judgement_word, word};
use super::comparison::correction_name;
use super::digits::{MAIN, TERMS, Unit, plus_minus};
use crate::page::AXES;
use crate::page::columns::{frequency, printed, words};
use proofmass_report::number::{plain, two_digits};
use proofmass_report::{Axis, Block, Section, Series, Table, XyPlot};
use proofmass_shaker::datasheet::{Datasheet, Promise, SheetDeviation};
use proofmass_shaker::{MethodResult, ShakerCalibration};

pub(super) fn section(
    calibration: &ShakerCalibration,
    result: &MethodResult,
    unit: Unit,
    sheet: &Datasheet,
) -> Option<Section> {
    if result.datasheet.is_empty() {
        return None;
    }
    let mut section = Section::new("Against the datasheet").paragraph(format!(
        "{}{}",
        stated(result, unit, sheet),
        "E_n = (|S_jj| − S_p)/√(U² + U_p²), S_p what |S_jj| should be and U_p its tolerance; beyond ±1 the two disagree at 95 %. \
         The verdict looks at the limits alone: pass where the whole interval lies within them, fail where it lies beyond, undecided \
         between."
    ));
    if let Some(plot) = departures(result) {
        section = section.figure(
            "Main terms as departures from the datasheet; bars are the intervals of the calibration at 95 %",
            plot,
        );
    }
    let named = correction_name(&result.correction);
    section = section.table(promises(
        &format!(
            "What the datasheet promises, {named}, {} method",
            word(result.method)
        ),
        &[result],
    ));
    let others: Vec<&MethodResult> = calibration
        .results
        .iter()
        .filter(|r| !std::ptr::eq(*r, result) && !r.datasheet.is_empty())
        .collect();
    if others.is_empty() {
        return Some(section);
    }
    let table = promises("What the datasheet promises, the other results", &others);
    Some(section.folded(
        "With the other corrections and methods",
        [Block::Table(table)],
    ))
}

/// The sheet in words, and from where its bands count.
fn stated(result: &MethodResult, unit: Unit, sheet: &Datasheet) -> String {
    let mut text = String::new();
    let value = |k: usize| {
        let s = sheet.axes[k]?;
        let value = unit.factor * s.value;
        Some(match s.tolerance {
            Some(t) => plus_minus(value, unit.factor * t),
            None => plain(value),
        })
    };
    if sheet.axes.windows(2).all(|pair| pair[0] == pair[1]) {
        if let Some(value) = value(0) {
            text += &format!("The datasheet states {value} {}. ", unit.name);
        }
    } else {
        let each: Vec<String> = (0..3)
            .filter_map(|k| Some(format!("{} for {}", value(k)?, AXES[k])))
            .collect();
        text += &format!(
            "The datasheet states, in {}, {}. ",
            unit.name,
            each.join(", ")
        );
    }
    if !sheet.bands.is_empty() {
        let bands: Vec<String> = sheet
            .bands
            .iter()
            .map(|b| {
                let of: Vec<&str> = b.axes.iter().map(|k| AXES[*k]).collect();
                let of = match of.is_empty() {
                    true => String::new(),
                    false => format!(" ({})", of.join(", ")),
                };
                format!(
                    "± {} % from {} Hz to {} Hz{of}",
                    two_digits(100.0 * b.tolerance),
                    plain(b.from),
                    plain(b.to)
                )
            })
            .collect();
        let frequencies = result.frequencies.iter().map(|f| f.frequency);
        let from = match (sheet.reference, sheet.reference_among(frequencies)) {
            (None, _) => {
                "from the sensitivity of the sheet, as no reference_Hz is stated".to_owned()
            }
            (Some(f), Some(near)) if f == near => {
                format!("from the sensitivity measured at {} Hz", plain(f))
            }
            (Some(f), Some(near)) => format!(
                "from the sensitivity measured at {} Hz, the nearest to the {} Hz of the sheet",
                plain(near),
                plain(f)
            ),
            (Some(f), None) => format!("from {} Hz, near which nothing was measured", plain(f)),
        };
        text += &format!("Its bands are {}, counted {from}. ", bands.join(", "));
    }
    if let Some(limit) = sheet.transverse {
        text += &format!(
            "Its transverse sensitivity is {} % at most. ",
            two_digits(100.0 * limit)
        );
    }
    text
}

fn departures(result: &MethodResult) -> Option<XyPlot> {
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::linear("departure from the datasheet", "%"),
    )
    .horizontal(0.0, "datasheet");
    let mut any = false;
    for (number, k) in MAIN.into_iter().enumerate() {
        let own = |d: &&SheetDeviation| d.promise == Promise::Sensitivity && d.axis == AXES[number];
        let points: Vec<_> = result
            .datasheet
            .iter()
            .filter(own)
            .map(|d| (d.frequency, 100.0 * d.value, 100.0 * d.expanded))
            .collect();
        if !points.is_empty() {
            any = true;
            plot = plot.series(Series::intervals(format!("S_{}", TERMS[k]), &points).look(number));
        }
    }
    any.then_some(plot)
}

fn promises(caption: &str, results: &[&MethodResult]) -> Table {
    type R<'a> = (&'a MethodResult, &'a SheetDeviation);
    let rows = results
        .iter()
        .flat_map(|r| r.datasheet.iter().map(move |d| -> R<'_> { (r, d) }));
    let mut fields = Vec::new();
    if results.len() > 1 {
        fields.extend([
            words("correction", |r: &R<'_>| {
                correction_name(&r.0.correction).to_owned()
            }),
            words("method", |r: &R<'_>| word(r.0.method).to_owned()),
        ]);
    }
    fields.push(frequency(|r: &R<'_>| r.1.frequency));
    fields.extend([
        words("quantity", |r: &R<'_>| {
            let axis = r.1.axis;
            match r.1.promise {
                Promise::Response => format!("|S_{axis}{axis}| against the reference frequency"),
                Promise::Transverse => format!("transverse sensitivity {axis}"),
                _ => format!("|S_{axis}{axis}| against the sheet"),
            }
        }),
        printed("value", "%", |r: &R<'_>| {
            plus_minus(100.0 * r.1.value, 100.0 * r.1.expanded)
        }),
        printed("k", "", |r: &R<'_>| format!("{:.2}", r.1.coverage_factor)),
        printed("limit", "%", |r: &R<'_>| {
            let sign = match r.1.promise {
                Promise::Transverse => "",
                _ => "± ",
            };
            Some(format!("{sign}{}", two_digits(100.0 * r.1.tolerance?)))
        }),
        printed("E_n", "", |r: &R<'_>| {
            r.1.e_n.map(|e| super::sign(format!("{e:.2}")))
        }),
        words("verdict", |r: &R<'_>| {
            judgement_word(r.1.judgement).to_owned()
        }),
    ]);
    Table::of(caption, fields, rows)
}

//! Results side by side: corrections, methods.

use super::super::tables::word;
use super::digits::{CROSS, MAIN, TERMS, Unit, plus_minus};
use crate::page::columns::{frequency, printed, words};
use proofmass_report::{Axis, Block, Section, Series, Table, XyPlot};
use proofmass_shaker::{MethodResult, ShakerCalibration, ShakerMethod, TermDifference};

/// Value and expanded uncertainty of |S_k|, whatever the method.
fn modulus(result: &MethodResult, frequency: f64, k: usize) -> Option<(f64, f64)> {
    let same = |f: f64| (f / frequency - 1.0).abs() < 1e-9;
    if result.method == ShakerMethod::PublishedMagnitude {
        let p = result.published.iter().find(|p| same(p.frequency))?;
        return Some((
            p.fit.sensitivity[k / 3][k % 3].abs(),
            p.fit.sensitivity_expanded[k / 3][k % 3]?,
        ));
    }
    let f = result.frequencies.iter().find(|f| same(f.frequency))?;
    let m = &f.sensitivity[k].modulus;
    Some((m.value, m.expanded))
}

fn frequencies(result: &MethodResult) -> Vec<f64> {
    let rigorous = result.frequencies.iter().map(|f| f.frequency);
    let published = result.published.iter().map(|p| p.frequency);
    rigorous.chain(published).collect()
}

/// Departure of the main terms of some results from the first of them, in per cent, one panel per axis.
fn departures(results: &[(&str, &MethodResult)]) -> XyPlot {
    let mut plot = XyPlot::new(Axis::log("frequency", "Hz"), Axis::default());
    plot.panels.clear();
    for (panel, &k) in MAIN.iter().enumerate() {
        plot = plot.below(Axis::linear(format!("Δ|S_{}|", TERMS[k]), "%"));
        plot = plot.horizontal(0.0, "");
        for (number, (name, result)) in results.iter().enumerate() {
            let apart = 1.025f64.powf(number as f64 - 0.5 * (results.len() - 1) as f64);
            let points: Vec<_> = frequencies(results[0].1)
                .into_iter()
                .filter_map(|f| {
                    let (base, _) = modulus(results[0].1, f, k)?;
                    let (value, expanded) = modulus(result, f, k)?;
                    (expanded.is_finite()).then(|| {
                        (
                            f * apart,
                            100.0 * (value / base - 1.0),
                            100.0 * expanded / base,
                        )
                    })
                })
                .collect();
            if !points.is_empty() {
                let name = if panel == 0 { *name } else { "" };
                plot = plot.series(Series::intervals(name, &points).look(number));
            }
        }
    }
    plot
}

/// Corrections of one method, when there are several.
pub(super) fn corrections(
    calibration: &ShakerCalibration,
    principal: &MethodResult,
    unit: Unit,
) -> Option<Section> {
    let mut same: Vec<(&str, &MethodResult)> = calibration
        .results
        .iter()
        .filter(|r| r.method == principal.method)
        .map(|r| (r.correction.as_str(), r))
        .collect();
    if same.len() < 2 {
        return None;
    }
    // What was measured without any correction is what the others are held against.
    same.sort_by_key(|(label, _)| *label != "none");
    let named: Vec<(&str, &MethodResult)> = same
        .iter()
        .map(|&(label, r)| (correction_name(label), r))
        .collect();
    let caption = format!(
        "Main terms by the {} method with each correction",
        word(principal.method)
    );
    let values = side_by_side(&caption, principal, &named, &MAIN, unit);
    type D = TermDifference;
    let fields = [
        words("between", |d: &D| {
            let [one, other] = [1, 0].map(|k| correction_name(&d.between[k]));
            format!("{one} – {other}")
        }),
        frequency(|d: &D| d.frequency),
        words("term", |d: &D| format!("|S_{}|", d.term)),
        printed("difference", "%", |d: &D| {
            format!("{:.2}", 100.0 * d.relative)
        }),
        printed("E_n", "", |d: &D| d.e_n.map(|e| format!("{e:.2}"))),
    ];
    let caption = "Differences of the main terms between two corrections";
    let differences = Table::of(caption, fields, &calibration.differences).note(
        "E_n is the difference over the expanded uncertainty that the measurements of the spurious motion alone give it: \
         everything else is common to both. Above 1 the two corrections disagree.",
    );
    Some(
        Section::new("Corrections compared")
            .paragraph(
                "The motion of the bench beside the excitation, measured with laser vibrometers, corrects what the device \
                 is taken to have seen. Each measurement of it gives a result of its own.",
            )
            .figure(
                format!(
                    "Main terms with each correction, as departures from the first in the legend ({} method); bars are \
                     intervals at {}",
                    word(principal.method),
                    super::curves::at(&principal.frequencies)
                ),
                departures(&named),
            )
            .table(values)
            .folded(
                "Differences between the corrections, with E_n",
                [Block::Table(differences)],
            ),
    )
}

pub(super) fn correction_name(label: &str) -> &str {
    if label == "none" {
        "uncorrected"
    } else {
        label
    }
}

/// Methods with one correction, when there are several.
pub(super) fn methods(
    calibration: &ShakerCalibration,
    principal: &MethodResult,
    unit: Unit,
) -> Option<Section> {
    let mut same: Vec<(&str, &MethodResult)> = calibration
        .results
        .iter()
        .filter(|r| r.correction == principal.correction)
        .map(|r| (word(r.method), r))
        .collect();
    if same.len() < 2 {
        return None;
    }
    same.sort_by_key(|(_, r)| match r.method {
        ShakerMethod::Joint => 0,
        ShakerMethod::Complex => 1,
        ShakerMethod::PublishedMagnitude => 2,
    });
    let mut section = Section::new("Methods side by side").paragraph(format!(
        "The same runs ({}) by each method. Complex: signed phasors with the joint covariance of everything, frequency by \
         frequency. Joint: the same for all frequencies at once, with the mounting angles in common.{}",
        correction_name(&principal.correction),
        if same.iter().any(|(_, r)| r.method == ShakerMethod::PublishedMagnitude) {
            " Published: least squares on magnitudes with element-wise uncertainties (k = 2), for comparison only: it \
             loses the signs of cross terms and averages common errors away."
        } else {
            ""
        }
    ));
    section = section.figure(
        format!(
            "Main terms by each method, as departures from the first in the legend; bars are intervals at {} (k = 2 for \
             the published method)",
            super::curves::at(&principal.frequencies)
        ),
        departures(&same),
    );
    let table = |which: &str, terms: &[usize]| {
        let caption = format!("{which} terms by each method, value ± U");
        side_by_side(&caption, principal, &same, terms, unit)
    };
    Some(section.table(table("Main", &MAIN)).folded(
        "Cross terms by each method",
        [Block::Table(table("Cross", &CROSS))],
    ))
}

/// Terms of several results at every frequency, value ± U.
fn side_by_side(
    caption: &str,
    principal: &MethodResult,
    results: &[(&str, &MethodResult)],
    terms: &[usize],
    unit: Unit,
) -> Table {
    type Row = (f64, usize);
    let mut fields = vec![
        frequency(|r: &Row| r.0),
        words("term", |r: &Row| format!("|S_{}|", TERMS[r.1])),
    ];
    fields.extend(results.iter().map(|&(name, result)| {
        printed(name, unit.name, move |r: &Row| {
            let (v, u) = modulus(result, r.0, r.1).filter(|(_, u)| u.is_finite())?;
            Some(plus_minus(unit.factor * v, unit.factor * u))
        })
    }));
    let rows = frequencies(principal)
        .into_iter()
        .flat_map(|f| terms.iter().map(move |&k| -> Row { (f, k) }));
    Table::of(caption, fields, rows)
}

//! Sensitivity against frequency.

use super::digits::{CROSS, MAIN, TERMS, Unit, degrees, degrees_of_freedom, plus_minus, scaled};
use crate::page::columns::{frequency, printed};
use crate::page::coverage::stated_at;
use proofmass_report::{Axis, Section, Series, Table, XyPlot};
use proofmass_shaker::{FrequencyResult, MethodResult};

/// Points of several series at one frequency are drawn this far apart, so that their bars can be told.
const APART: f64 = 1.02;

pub(super) fn section(result: &MethodResult, unit: Unit) -> Section {
    Section::new("Sensitivity against frequency")
        .figure(
            format!(
                "Main terms: modulus and phase with their intervals at {}",
                at(&result.frequencies)
            ),
            terms_plot(result, &MAIN, unit),
        )
        .figure(
            format!(
                "Cross terms: modulus and phase with their intervals at {}; points of one frequency are drawn beside each \
                 other, and a phase is shown where the modulus exceeds its uncertainty",
                at(&result.frequencies)
            ),
            terms_plot(result, &CROSS, unit),
        )
        .table(phases(result))
}

/// What U of the terms is stated at.
pub(super) fn at(frequencies: &[FrequencyResult]) -> String {
    let terms = frequencies.iter().flat_map(|f| &f.sensitivity);
    stated_at(terms.flat_map(|t| std::iter::once(&t.modulus).chain(&t.phase)))
}

/// The table a reader takes away: main terms at every frequency.
pub(super) fn main_table(frequencies: &[FrequencyResult], unit: Unit) -> Table {
    type R = FrequencyResult;
    let mut fields = vec![frequency(|f: &R| f.frequency)];
    for k in MAIN {
        fields.push(printed(
            format!("|S_{}|", TERMS[k]),
            unit.name,
            move |f: &R| scaled(&f.sensitivity[k].modulus, unit.factor),
        ));
        fields.push(printed("U", "%", move |f: &R| {
            let m = &f.sensitivity[k].modulus;
            format!("{:.2}", 100.0 * m.expanded / m.value)
        }));
    }
    let caption = format!(
        "Main terms with their expanded uncertainty at {}",
        at(frequencies)
    );
    Table::of(caption, fields, frequencies)
}

fn phases(result: &MethodResult) -> Table {
    type R = FrequencyResult;
    let mut fields = vec![frequency(|f: &R| f.frequency)];
    for k in MAIN {
        fields.extend([
            printed(format!("phase of S_{}", TERMS[k]), "°", move |f: &R| {
                degrees(&f.sensitivity[k]).map(|(v, u)| plus_minus(v, u))
            }),
            printed("k", "", move |f: &R| {
                format!("{:.2}", f.sensitivity[k].modulus.coverage_factor)
            }),
            printed("ν_eff", "", move |f: &R| {
                degrees_of_freedom(f.sensitivity[k].modulus.dof)
            }),
        ]);
    }
    Table::of(
        "Phases of the main terms with their expanded uncertainty; coverage factor and effective degrees of freedom of \
         the modulus",
        fields,
        &result.frequencies,
    )
}

fn terms_plot(result: &MethodResult, which: &[usize], unit: Unit) -> XyPlot {
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::linear("modulus", unit.name),
    );
    let place = |number: usize, f: f64| {
        if which.len() > 3 {
            f * APART.powf(number as f64 - 0.5 * (which.len() - 1) as f64)
        } else {
            f
        }
    };
    for (number, &k) in which.iter().enumerate() {
        let points: Vec<_> = result
            .frequencies
            .iter()
            .map(|f| {
                let m = &f.sensitivity[k].modulus;
                (
                    place(number, f.frequency),
                    unit.factor * m.value,
                    unit.factor * m.expanded,
                )
            })
            .collect();
        plot = plot.series(Series::intervals(format!("S_{}", TERMS[k]), &points).look(number));
    }
    plot = plot.below(Axis::linear("phase", "°"));
    for (number, &k) in which.iter().enumerate() {
        let points: Vec<_> = result
            .frequencies
            .iter()
            .filter_map(|f| {
                let (value, expanded) = degrees(&f.sensitivity[k])?;
                Some((place(number, f.frequency), value, expanded))
            })
            .collect();
        if !points.is_empty() {
            plot = plot.series(Series::intervals(String::new(), &points).look(number));
        }
    }
    plot
}

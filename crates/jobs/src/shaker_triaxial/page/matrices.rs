//! The matrices of every frequency, as tables of three by three.

use super::digits::{Unit, degrees, plus_minus, representative, scaled};
use crate::page::AXES;
use crate::page::columns::{printed, words};
use proofmass_report::number::plain;
use proofmass_report::{Block, Section, Table};
use proofmass_shaker::{FrequencyResult, MethodResult};

pub(super) fn section(result: &MethodResult, unit: Unit) -> Section {
    let shown = representative(result).map(|f| f.frequency);
    let mut section = Section::new("Matrices").paragraph(format!(
        "Rows of observations: o = a S and a = o A, o the outputs in {}, a the acceleration in m/s². S_ij is the output j per \
         unit acceleration along i; A = S⁻¹. Normalised: S*_ij = Re(S_ij/S_ii), A*_ij = Re(A_ij/A_ii), with the sign \
         of the cross term. Each value stands with its expanded uncertainty U at {}, both to two digits of U. A phase is \
         given where the modulus exceeds its U; elsewhere every phase is compatible. These are the matrices at {}.",
        unit.output.symbol(),
        super::curves::at(&result.frequencies),
        shown.map_or("one frequency".to_owned(), |f| format!("{} Hz", plain(f)))
    ));
    for f in &result.frequencies {
        if Some(f.frequency) == shown {
            section = section.beside(tables(f, unit));
        }
    }
    for f in &result.frequencies {
        if Some(f.frequency) != shown {
            section = section.looked_up(
                format!("Matrices at {} Hz", plain(f.frequency)),
                [Block::Beside(tables(f, unit))],
            );
        }
    }
    section
}

fn tables(f: &FrequencyResult, unit: Unit) -> Vec<Table> {
    let phase = |terms: &[proofmass_shaker::derived::SensitivityTerm], k: usize| {
        degrees(&terms[k]).map_or("–".to_owned(), |(v, u)| plus_minus(v, u))
    };
    let relative = |terms: &[proofmass_shaker::derived::SensitivityTerm], k: usize| {
        let m = &terms[k].modulus;
        percent(m.expanded / m.value)
    };
    vec![
        square(format!("|S| in {}", unit.name), "a", "o", |k| {
            scaled(&f.sensitivity[k].modulus, unit.factor)
        }),
        square("Phase of S in °".into(), "a", "o", |k| {
            phase(&f.sensitivity, k)
        }),
        square(
            format!("|A| in {}", unit.output.exploitation()),
            "o",
            "a",
            |k| scaled(&f.exploitation[k].modulus, 1.0),
        ),
        square("Phase of A in °".into(), "o", "a", |k| {
            phase(&f.exploitation, k)
        }),
        square("Normalised S* in %".into(), "a", "o", |k| {
            normalised(k, &f.normalised[k])
        }),
        square("Normalised A* in %".into(), "o", "a", |k| {
            normalised(k, &f.normalised_exploitation[k])
        }),
        square("Relative U of |S| in %".into(), "a", "o", |k| {
            relative(&f.sensitivity, k)
        }),
        square("Relative U of |A| in %".into(), "o", "a", |k| {
            relative(&f.exploitation, k)
        }),
    ]
}

/// The diagonal of a normalised matrix is one by definition.
fn normalised(k: usize, q: &proofmass_shaker::derived::Expanded) -> String {
    if k.is_multiple_of(4) {
        "100".to_owned()
    } else {
        scaled(q, 100.0)
    }
}

fn percent(ratio: f64) -> String {
    let percent = 100.0 * ratio;
    match percent {
        p if !p.is_finite() || p > 999.0 => "> 999".to_owned(),
        p if p >= 10.0 => format!("{p:.0}"),
        p if p >= 1.0 => format!("{p:.1}"),
        p => format!("{p:.2}"),
    }
}

fn square(caption: String, row: &str, column: &str, cell: impl Fn(usize) -> String) -> Table {
    let cell = &cell;
    let mut fields = vec![words("", |i: &usize| format!("{row}_{}", AXES[*i]))];
    fields.extend(AXES.into_iter().enumerate().map(|(j, axis)| {
        printed(format!("{column}_{axis}"), "", move |i: &usize| {
            cell(3 * i + j)
        })
    }));
    Table::of(caption, fields, 0..3)
}

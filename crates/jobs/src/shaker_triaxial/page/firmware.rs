//! The constant matrix of each frequency and of the whole range, as it is typed into firmware.

use super::ShakerTriaxialOutcome;
use crate::page::AXES;
use crate::page::columns::{printed, words};
use proofmass_dynamic::frequency_response::BandMatrix;
use proofmass_report::number::plain;
use proofmass_report::{Block, Section, Table};
use proofmass_shaker::MethodResult;

/// Nothing where the calibration is no response over frequency.
pub(super) fn section(
    outcome: &ShakerTriaxialOutcome,
    result: &MethodResult,
    shown: Option<f64>,
) -> Option<Section> {
    let response = outcome.response().ok()??;
    let all: Vec<f64> = result.frequencies.iter().map(|f| f.frequency).collect();
    let range = [*all.first()?, *all.last()?];
    let bands = all.iter().map(|f| [*f, *f]);
    let bands = bands.chain((range[0] < range[1]).then_some(range));
    let matrices: Vec<BandMatrix> = bands
        .filter_map(|band| response.band_matrix(band).ok())
        .collect();
    let shown = matrices
        .iter()
        .find(|m| Some(m.error.band[0]) == shown)
        .or_else(|| matrices.first())?;
    let section = Section::new("Matrix for firmware")
        .paragraph(format!(
            "a = M⁻¹ o: the three outputs in {} as a column, the acceleration in m/s². M⁻¹ is real and constant; it is that of {}. \
             Error of the acceleration at most {} of its size (95 %), after a delay of {} µs. A shaker measures no bias: take the \
             mean at rest off the outputs. The same as C, Rust, Python or JSON, for any band: proofmass export RESULT --c --band LOW,HIGH.",
            outcome.budget.output.symbol(),
            range_of(shown),
            percent(shown.error.stated),
            microseconds(shown),
        ))
        .table(typed(shown));
    Some(section.looked_up(
        "Matrix of every frequency and of the whole range",
        [Block::Table(list(&matrices))],
    ))
}

/// Three rows as they are typed.
fn typed(matrix: &BandMatrix) -> Table {
    let mut fields = vec![words("", |i: &usize| format!("a_{}", AXES[*i]))];
    fields.extend(AXES.into_iter().enumerate().map(|(j, axis)| {
        words(&format!("o_{axis}"), move |i: &usize| {
            digits(matrix.inverse[3 * i + j])
        })
    }));
    Table::of("M⁻¹", fields, 0..3)
}

fn list(matrices: &[BandMatrix]) -> Table {
    let mut fields = vec![words("band", range_of)];
    for k in 0..9 {
        let name = format!("{}{}", AXES[k / 3], AXES[k % 3]);
        fields.push(words(&name, move |m: &BandMatrix| digits(m.inverse[k])));
    }
    fields.push(printed("delay", "µs", |m: &BandMatrix| microseconds(m)));
    fields.push(words("error at most", |m: &BandMatrix| {
        percent(m.error.stated)
    }));
    Table::of("M⁻¹, row by row", fields, matrices)
}

fn range_of(m: &BandMatrix) -> String {
    let [low, high] = m.error.band;
    match low == high {
        true => format!("{} Hz", plain(low)),
        false => format!("{} to {} Hz", plain(low), plain(high)),
    }
}

/// Seven digits, which single precision holds, as source code has them.
fn digits(v: f64) -> String {
    format!("{v:.6e}")
}

fn microseconds(m: &BandMatrix) -> String {
    format!("{:.2}", 1e6 * m.error.delay + 0.0)
}

fn percent(ratio: f64) -> String {
    format!("{:.2} %", 100.0 * ratio)
}

//! What the page of a primary calibration says beside its sensitivities.

use super::{ShakerPrimaryOutcome, ShakerPrimaryRun};
use crate::page::columns::{degrees, e_n, filed, frequency, number, percent};
use crate::shaker_single::page::with;
use proofmass_report::Rounding::{Decimals, Significant};
use proofmass_report::{Field, Report, Section, Table};
use proofmass_shaker::interferometer::CheckMethod;
use proofmass_shaker::primary::MethodCheck;

pub(super) fn add(page: Report, outcome: &ShakerPrimaryOutcome) -> Report {
    let mut sections = Vec::new();
    if !outcome.checks.is_empty() {
        sections.push(
            Section::new("Other methods")
                .paragraph(
                    "The amplitude of the same motions by fringe counting (method 1, to 800 Hz) and at a zero of J₁ (method 2, above), \
                     where the data allow. They state no phase and are no part of the result.",
                )
                .table(checks(&outcome.checks)),
        );
    }
    sections.push(Section::new("Interferometer").table(ellipses(&outcome.runs)));
    sections.push(Section::new("Method").paragraph(
        "Primary calibration by laser interferometry with quadrature outputs, sine approximation (ISO 16063-11, method 3): the \
         ellipse of the two signals corrected for offsets, gains and phase error (Heydemann), the phase unwrapped, sines fitted to \
         displacement and output, a = −Ω² s. Uncertainty by the law of propagation, coverage factors from Student's t (JCGM 100:2008).",
    ));
    with(
        page,
        &outcome.stated,
        "Primary calibration by laser interferometry",
        sections,
    )
}

fn checks(checks: &[MethodCheck]) -> Table {
    type C = MethodCheck;
    let fields = [
        frequency(|c: &C| c.frequency),
        Field::new("method", |c: &C| {
            match c.method {
                CheckMethod::FringeCounting => "fringe counting",
                CheckMethod::MinimumPoint => "minimum point",
            }
            .into()
        })
        .page("method", ""),
        number("runs", ("runs", ""), Decimals(0), |c: &C| c.runs as f64),
        filed("modulus_V/(m/s2)", |c: &C| c.modulus),
        filed("u_V/(m/s2)", |c: &C| c.uncertainty),
        percent("departure_%", "departure from method 3", |c: &C| {
            c.departure
        }),
        percent("u_departure_%", "u", |c: &C| c.departure_uncertainty),
        e_n("E_n", MethodCheck::e_n),
    ];
    let caption =
        "Modulus of the sensitivity by other methods, against that of the sine approximation";
    Table::of(caption, fields, checks).file("methods.csv")
}

fn ellipses(runs: &[ShakerPrimaryRun]) -> Table {
    type R = ShakerPrimaryRun;
    let fields = [
        Field::new("run", |r: &R| r.run.run.as_str().into()).page("run", ""),
        frequency(|r: &R| r.run.frequency),
        number(
            "acceleration_m/s2",
            ("acceleration", "m/s²"),
            Significant(4),
            |r: &R| r.run.acceleration.norm(),
        ),
        number(
            "displacement_nm",
            ("displacement", "nm"),
            Significant(4),
            |r: &R| {
                let omega = std::f64::consts::TAU * r.run.frequency;
                1e9 * r.run.acceleration.norm() / (omega * omega)
            },
        ),
        filed("offset_cosine_V", |r: &R| r.quadrature.quadrature.offset[0]),
        filed("offset_sine_V", |r: &R| r.quadrature.quadrature.offset[1]),
        filed("amplitude_cosine_V", |r: &R| {
            r.quadrature.quadrature.amplitude[0]
        }),
        filed("amplitude_sine_V", |r: &R| {
            r.quadrature.quadrature.amplitude[1]
        }),
        degrees("quadrature_error_deg", "phase error", |r: &R| {
            r.quadrature.quadrature.phase
        }),
        number("arc_deg", ("turn covered", "°"), Decimals(0), |r: &R| {
            r.quadrature.arc
        }),
        percent("residual_%", "residual of the circle", |r: &R| {
            r.quadrature.residual
        }),
    ];
    let caption = "Motion and ellipse of every run";
    Table::of(caption, fields, runs).file("interferometer.csv")
}

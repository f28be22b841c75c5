//! The report of a triaxial calibration on a shaker.

mod agreement;
mod budget;
mod comparison;
mod contested;
mod curves;
mod datasheet;
mod digits;
mod firmware;
mod matrices;
mod mounting;
mod transverse;

use super::ShakerTriaxialOutcome;
use super::tables::{tables, word};
use crate::page::AXES;
use crate::page::columns::{frequency, printed};
use crate::sensor_clock::SensorClock;
use digits::{Unit, plus_minus, representative};
use proofmass_report::number::{plain, two_digits};
use proofmass_report::plot::SeatPlot;
use proofmass_report::{Block, Figure, KeyFigure, Report, Section, Table};
use proofmass_shaker::{MethodResult, Reproducibility, ShakerCalibration, ShakerMethod};
use proofmass_uncertainty::{Finding, Severity};

pub(super) fn add(mut page: Report, outcome: &ShakerTriaxialOutcome) -> Report {
    let calibration = &outcome.calibration;
    let reference = outcome.reference.iter();
    page.meta
        .extend(reference.map(|r| ("Reference".to_owned(), r.clone())));
    page.meta
        .extend(outcome.clock.iter().flat_map(SensorClock::lines));
    page = page.meta("Runs recorded", outcome.runs.len().to_string());
    if let Some(principal) = principal(calibration) {
        let unit = Unit::of(calibration);
        // Where single runs are set aside the intervals reach the result with them.
        let open = gravest(&outcome.findings).filter(|_| calibration.set_aside.is_empty());
        page = page
            .subtitle(subtitle(principal))
            .verdict(verdict(principal, open))
            .answers(answer(principal, unit));
        let sections = sections(outcome, principal, unit);
        page.sections.extend(sections.into_iter().flatten());
    }
    page.section(Section::new("Method").paragraph(
        "Phasors by least-squares sine approximation (ISO 16063-11, method 3); reference transducer and checks as in ISO \
         16063-21; transverse sensitivity as in ISO 16063-31. Sensitivity matrices by generalised least squares with \
         mounting angles as errors in variables; uncertainty by the law of propagation, coverage factors from Student's \
         t at the effective degrees of freedom (JCGM 100:2008, JCGM 102:2011).",
    ))
    .section(Section::filed(tables(outcome)))
}

/// The sections of the result that is reported.
fn sections(
    outcome: &ShakerTriaxialOutcome,
    result: &MethodResult,
    unit: Unit,
) -> Vec<Option<Section>> {
    let calibration = &outcome.calibration;
    let rigorous = result.method != ShakerMethod::PublishedMagnitude;
    let joint = result.method == ShakerMethod::Joint;
    let mut list = vec![Some(self::result(result, unit).summarised())];
    if rigorous {
        list.push(Some(curves::section(result, unit)));
        list.push(Some(matrices::section(result, unit)));
        let shown = representative(result).map(|f| f.frequency);
        list.push(firmware::section(outcome, result, shown));
    }
    list.extend([
        Some(frame()),
        comparison::corrections(calibration, result, unit).map(Section::off_paper),
        comparison::methods(calibration, result, unit).map(Section::off_paper),
        outcome
            .datasheet
            .as_ref()
            .and_then(|sheet| datasheet::section(calibration, result, unit, sheet))
            .map(Section::off_paper),
    ]);
    if rigorous {
        list.extend([
            Some(budget::section(result, unit)),
            agreement::monte_carlo(&outcome.monte_carlo).map(Section::off_paper),
            Some(transverse::section(result)),
            Some(transverse::axes(result, unit).off_paper()),
            contested::section(calibration, unit),
            Some(agreement::residuals(calibration, result).off_paper()),
            sessions_of(calibration, result).map(agreement::sessions),
            joint
                .then(|| mounting::angles(result).map(Section::off_paper))
                .flatten(),
        ]);
    }
    list
}

/// The sessions against each other, by the result that is reported or else by the first that compares them.
fn sessions_of<'a>(
    calibration: &'a ShakerCalibration,
    result: &'a MethodResult,
) -> Option<&'a Reproducibility> {
    let mut results = std::iter::once(result).chain(&calibration.results);
    results.find_map(|r| r.reproducibility.as_ref())
}

fn subtitle(result: &MethodResult) -> String {
    let count = result.frequencies.len().max(result.published.len());
    let runs = match result.runs.len() {
        0 => String::new(),
        n => format!(", {n} runs"),
    };
    format!(
        "Triaxial calibration on a shaker: {} method, {}, {count} {}{runs}",
        word(result.method),
        match result.correction.as_str() {
            "none" => "not corrected for spurious motion".to_owned(),
            label => format!("corrected for spurious motion ({label})"),
        },
        if count == 1 {
            "frequency"
        } else {
            "frequencies"
        },
    )
}

/// How well the sensitivities along the axes are known.
///
/// While somebody has to decide about channels, senses or units, U is none of the sensitivities: the gravest of these stands first.
fn verdict(result: &MethodResult, open: Option<&Finding>) -> String {
    if let Some(open) = open {
        return format!(
            "The sensitivities are not known before it is decided: {}. The values below, with their U, are those of the tables as they are.",
            open.what()
        );
    }
    let main = result
        .frequencies
        .iter()
        .flat_map(|f| digits::MAIN.map(|k| &f.sensitivity[k].modulus));
    let shares = main.map(|m| 100.0 * (m.expanded / m.value).abs());
    let (least, most) = shares.fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
    let from_to = || {
        Some((
            result.frequencies.first()?.frequency,
            result.frequencies.last()?.frequency,
        ))
    };
    match from_to() {
        Some((from, to)) if least.is_finite() => format!(
            "{} the three main sensitivities are known to U = {}.",
            match from == to {
                true => format!("At {} Hz", plain(from)),
                false => format!("From {} Hz to {} Hz", plain(from), plain(to)),
            },
            match [two_digits(least), two_digits(most)] {
                [least, most] if least == most => format!("{most} %"),
                [least, most] => format!("{least} % to {most} %"),
            }
        ),
        _ => "The sensitivities are those of the published method, with U = 2 u.".to_owned(),
    }
}

/// The gravest decision about the campaign as a whole: what was connected, in which sense and unit it was read, and whether it is
/// that device.
fn gravest(findings: &[Finding]) -> Option<&Finding> {
    const WHOLE: [&str; 10] = [
        "phases-not-measured",
        "radians-as-degrees",
        "swapped-channels",
        "phases-conjugated",
        "mask-reversed",
        "reference-inverted",
        "angle-sense",
        "spurious-sign",
        "inverted-channel",
        "off-datasheet",
    ];
    WHOLE.iter().find_map(|code| {
        let open = |f: &&Finding| f.severity() == Severity::Decision && f.code() == *code;
        findings.iter().find(open)
    })
}

/// Main sensitivities and the largest transverse one, at the frequency that is usually stated.
fn answer(result: &MethodResult, unit: Unit) -> Vec<KeyFigure> {
    let mut figures = vec![];
    if let Some(f) = representative(result) {
        for (axis, k) in AXES.iter().zip(digits::MAIN) {
            let m = &f.sensitivity[k].modulus;
            figures.push(
                KeyFigure::new(
                    format!("sensitivity {axis} at {} Hz", plain(f.frequency)),
                    plus_minus(unit.factor * m.value, unit.factor * m.expanded),
                    unit.name,
                )
                .note(format!(
                    "± {} %, k = {:.2}",
                    two_digits((100.0 * m.expanded / m.value).abs()),
                    m.coverage_factor
                )),
            );
        }
        let largest = f
            .transverse
            .iter()
            .filter(|q| !q.name.ends_with("angle"))
            .max_by(|a, b| a.value.total_cmp(&b.value));
        if let Some(q) = largest {
            figures.push(
                KeyFigure::new(
                    "largest transverse sensitivity",
                    plus_minus(100.0 * q.value, 100.0 * q.expanded),
                    "%",
                )
                .note(format!(
                    "output {} at {} Hz, k = {:.2}",
                    q.name.trim_start_matches("transverse."),
                    plain(f.frequency),
                    q.coverage_factor
                )),
            );
        }
    }
    figures
}

fn result(result: &MethodResult, unit: Unit) -> Section {
    let section = Section::new("Result");
    match result.method {
        ShakerMethod::PublishedMagnitude => section.table(published_table(result, unit)),
        _ => section.table(curves::main_table(&result.frequencies, unit)),
    }
}

/// What the axes of the matrices and the angles of the configurations mean.
fn frame() -> Section {
    Section::new("Frame and senses")
        .paragraph(
            "Both frames are right-handed: x′ × y′ = z′ for the table, x × y = z for the device. z′ is the excitation, x′ \
             lies in the plane of inclination. α is positive where the +x′ side of the face climbs: z leans to −x′, a \
             right-hand turn by −α about y′. ω is positive clockwise, seen from above on the device: a right-hand turn by \
             −ω about the normal of the face. At α = ω = 0 the axes of the device are those of the table.",
        )
        .looked_up(
            "Drawing of the axes and angles",
            [Block::Figure(Figure::new(
                "Axes of the table and of the device, and positive angles",
                SeatPlot,
            ))],
        )
}

/// The result that is reported: the first of a rigorous method, else the first.
pub(super) fn principal(calibration: &ShakerCalibration) -> Option<&MethodResult> {
    let mut results = calibration.results.iter();
    let rigorous = |r: &&MethodResult| r.method != ShakerMethod::PublishedMagnitude;
    results.find(rigorous).or(calibration.results.first())
}

/// True minus signs in a text of numbers.
fn sign(text: String) -> String {
    text.replace('-', "−")
}

fn published_table(result: &MethodResult, unit: Unit) -> Table {
    type R = proofmass_shaker::PublishedResult;
    let mut fields = vec![frequency(|p: &R| p.frequency)];
    for (k, term) in digits::TERMS.into_iter().enumerate() {
        fields.push(printed(format!("S_{term}"), unit.name, move |p: &R| {
            let value = unit.factor * p.fit.sensitivity[k / 3][k % 3];
            match p.fit.sensitivity_expanded[k / 3][k % 3] {
                Some(u) => plus_minus(value, unit.factor * u),
                None => format!("{value:.3}"),
            }
        }));
    }
    let caption = "Sensitivity matrix by the published method, value ± U (k = 2)";
    Table::of(caption, fields, &result.published)
}

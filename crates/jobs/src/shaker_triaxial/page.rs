//! The report of a triaxial calibration on a shaker.

mod agreement;
mod budget;
mod comparison;
mod contested;
mod curves;
mod digits;
mod matrices;
mod mounting;
mod transverse;

use digits::{Unit, plus_minus, representative, scaled};
use proofmass_report::number::plain;
use proofmass_report::plot::SeatPlot;
use proofmass_report::{Cell, Column, Head, KeyFigure, Report, Section, Table};
use proofmass_shaker::{FrequencyCheck, MethodResult, ShakerCalibration, ShakerMethod};

/// What the report tells beside the calibration itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct ShakerReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Sensitivity on the datasheet and its expanded uncertainty, V/(m/s²).
    pub datasheet: Option<(f64, f64)>,
    /// Law of propagation against Monte Carlo; empty when it was not asked for.
    pub checks: &'a [FrequencyCheck],
}

impl ShakerReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self, calibration: &ShakerCalibration) -> Report {
        let unit = Unit::of(calibration);
        let Some(result) = principal(calibration) else {
            return self.head(calibration, None).section(self.provenance());
        };
        let mut report = self
            .head(calibration, Some(result))
            .section(self.result(result, unit));
        let mut add = |section: Option<Section>| {
            if let Some(section) = section {
                report = std::mem::take(&mut report).section(section);
            }
        };
        let rigorous = result.method != ShakerMethod::PublishedMagnitude;
        if rigorous {
            add(Some(curves::section(result, unit)));
            add(Some(matrices::section(result, unit)));
        }
        add(Some(frame()));
        add(comparison::corrections(calibration, result, unit));
        add(comparison::methods(calibration, result, unit));
        add(comparison::datasheet(result, unit, self.datasheet));
        if rigorous {
            add(Some(budget::section(result, unit)));
            add(agreement::monte_carlo(self.checks));
            add(Some(transverse::section(result)));
            add(Some(transverse::axes(result, unit)));
            add(contested::section(calibration, unit));
            add(Some(agreement::residuals(calibration, result)));
            if result.method == ShakerMethod::Joint {
                add(mounting::angles(result));
            }
        }
        report
            .section(self.provenance())
            .footer(self.head.footer.clone())
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, calibration: &ShakerCalibration) -> Report {
        let unit = Unit::of(calibration);
        match principal(calibration) {
            Some(result) => self
                .head(calibration, Some(result))
                .section(self.result(result, unit)),
            None => self.head(calibration, None),
        }
    }

    fn head(&self, calibration: &ShakerCalibration, result: Option<&MethodResult>) -> Report {
        let mut report = self.head.open();
        if let Some(result) = result {
            let count = result.frequencies.len().max(result.published.len());
            let runs = match result.runs.len() {
                0 => String::new(),
                n => format!(", {n} runs"),
            };
            report = report.subtitle(format!(
                "Triaxial calibration on a shaker: {} method, {}, {count} {}{runs}",
                method_name(result.method),
                match result.correction.as_str() {
                    "none" => "not corrected for spurious motion".to_owned(),
                    label => format!("corrected for spurious motion ({label})"),
                },
                if count == 1 {
                    "frequency"
                } else {
                    "frequencies"
                },
            ));
        }
        let mut findings = self.head.findings.to_vec();
        let own = result.map_or(&[][..], |r| &r.findings);
        for finding in calibration.findings.iter().chain(own) {
            if !findings.contains(finding) {
                findings.push(finding.clone());
            }
        }
        report.findings(findings)
    }

    fn result(&self, result: &MethodResult, unit: Unit) -> Section {
        let mut section = Section::new("Result");
        if result.method == ShakerMethod::PublishedMagnitude {
            return section.table(published_table(result, unit));
        }
        if let Some(f) = representative(result) {
            let mut figures = vec![];
            for (axis, k) in ["x", "y", "z"].iter().zip(digits::MAIN) {
                let m = &f.sensitivity[k].modulus;
                figures.push(
                    KeyFigure::new(
                        format!("sensitivity {axis} at {} Hz", plain(f.frequency)),
                        scaled(m, unit.factor),
                        unit.name,
                    )
                    .note(format!(
                        "U = {:.2} %, k = {:.2}",
                        100.0 * m.expanded / m.value,
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
                        "output {} at {} Hz",
                        q.name.trim_start_matches("transverse."),
                        plain(f.frequency)
                    )),
                );
            }
            section = section.key_figures(figures);
        }
        section.table(curves::main_table(&result.frequencies, unit))
    }

    fn provenance(&self) -> Section {
        Section::new("Inputs and method").inputs(&self.head.inputs).paragraph(
            "Phasors by least-squares sine approximation (ISO 16063-11, method 3); reference transducer and checks as in ISO \
             16063-21; transverse sensitivity as in ISO 16063-31. Sensitivity matrices by generalised least squares with \
             mounting angles as errors in variables; uncertainty by the law of propagation, coverage factors from Student's \
             t at the effective degrees of freedom (JCGM 100:2008, JCGM 102:2011).",
        )
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
        .figure("Axes of the table and of the device, and positive angles", SeatPlot)
}

/// The result that is reported: the first of a rigorous method, else the first.
fn principal(calibration: &ShakerCalibration) -> Option<&MethodResult> {
    let mut results = calibration.results.iter();
    let rigorous = |r: &&MethodResult| r.method != ShakerMethod::PublishedMagnitude;
    results.find(rigorous).or(calibration.results.first())
}

fn method_name(method: ShakerMethod) -> &'static str {
    match method {
        ShakerMethod::PublishedMagnitude => "published",
        ShakerMethod::Complex => "complex",
        ShakerMethod::Joint => "joint",
    }
}

/// True minus signs in a text of numbers.
fn sign(text: String) -> String {
    text.replace('-', "−")
}

fn published_table(result: &MethodResult, unit: Unit) -> Table {
    let mut columns = vec![Column::number("f", "Hz")];
    columns.extend(digits::TERMS.map(|t| Column::number(format!("S_{t}"), unit.name)));
    let mut table = Table::new(
        "Sensitivity matrix by the published method, value ± U (k = 2)",
        columns,
    );
    for p in &result.published {
        let mut cells = vec![Cell::number(plain(p.frequency))];
        cells.extend((0..9).map(|k| {
            let (value, u) = (
                p.fit.sensitivity[k / 3][k % 3],
                p.fit.sensitivity_expanded[k / 3][k % 3],
            );
            match u {
                Some(u) => Cell::number(plus_minus(unit.factor * value, unit.factor * u)),
                None => Cell::number(format!("{:.3}", unit.factor * value)),
            }
        }));
        table = table.row(cells);
    }
    table
}

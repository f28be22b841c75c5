//! The report of a validation.

use proofmass_report::{
    Axis, Cell, Column, Head, KeyFigure, Report, Section, Series, SpherePlot, Table, XyPlot,
};
use proofmass_static::Validation;

/// What the report tells beside the validation itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct ValidationReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
}

impl ValidationReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self, validation: &Validation) -> Report {
        let attitudes = &validation.attitudes;
        let number: Vec<f64> = (1..=attitudes.len()).map(|i| i as f64).collect();
        let value: Vec<f64> = attitudes.iter().map(|a| 1e3 * a.residual).collect();
        let low: Vec<f64> = attitudes
            .iter()
            .map(|a| 1e3 * (a.residual - 2.0 * a.standard_uncertainty))
            .collect();
        let high: Vec<f64> = attitudes
            .iter()
            .map(|a| 1e3 * (a.residual + 2.0 * a.standard_uncertainty))
            .collect();
        let plot = XyPlot::new(
            Axis::linear("standstill", "").range(0.0, attitudes.len() as f64 + 1.0),
            Axis::linear("‖a‖ − g", "mm/s²"),
        )
        .horizontal(0.0, "")
        .series(Series::markers("", &number, &value).bars(&low, &high));
        let mut sphere = SpherePlot::new("‖a‖ − g", "mm/s²");
        for (i, a) in attitudes.iter().enumerate() {
            sphere = sphere.point(a.acceleration, 1e3 * a.residual, format!("{}", i + 1));
        }
        self.summary(validation)
            .section(
                Section::new("Residuals")
                    .figure("Residual of each standstill; bars are two standard uncertainties (calibration, noise, gravity)", plot)
                    .figure("Directions of the specific force, coloured by the residual", sphere),
            )
            .foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, validation: &Validation) -> Report {
        let report = self.head.open();
        let within = validation
            .attitudes
            .iter()
            .filter(|a| a.within_rule)
            .count();
        let before = validation
            .rms_before_mg
            .map_or("–".to_owned(), |v| format!("{v:.3}"));
        let figures = [
            KeyFigure::new(
                "within 0.1 % of g",
                format!("{within} of {}", validation.attitudes.len()),
                "",
            ),
            KeyFigure::new("RMS before", before, "mg").note("uncompensated"),
            KeyFigure::new("RMS after", format!("{:.3}", validation.rms_after_mg), "mg")
                .note("compensated"),
            KeyFigure::new("χ²", format!("{:.1}", validation.chi_square), "").note(format!(
                "{} degrees of freedom, p = {:.2}",
                validation.degrees_of_freedom, validation.p_value
            )),
        ];
        let mut table = Table::new(
            "Standstills",
            [
                Column::text("standstill"),
                Column::number("a_x", "m/s²"),
                Column::number("a_y", "m/s²"),
                Column::number("a_z", "m/s²"),
                Column::number("‖a‖ − g", "mm/s²"),
                Column::number("u", "mm/s²"),
                Column::number("│‖a‖ − g│/g", "%"),
                Column::text("0.1 % rule"),
            ],
        );
        for a in &validation.attitudes {
            table = table.row([
                Cell::text(a.name.clone()),
                Cell::number(format!("{:.4}", a.acceleration[0])),
                Cell::number(format!("{:.4}", a.acceleration[1])),
                Cell::number(format!("{:.4}", a.acceleration[2])),
                Cell::number(format!("{:.2}", 1e3 * a.residual)),
                Cell::number(format!("{:.2}", 1e3 * a.standard_uncertainty)),
                Cell::number(format!("{:.4}", 1e2 * a.relative)),
                Cell::text(if a.within_rule { "met" } else { "missed" }),
            ]);
        }
        report
            .findings(self.head.findings.iter().cloned())
            .section(Section::new("Result").key_figures(figures).table(table))
    }
}

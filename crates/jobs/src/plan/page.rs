//! The report of a plan: what a campaign will achieve before anything is measured.

use proofmass_report::number::{plain, two_digits};
use proofmass_report::plot::Style;
use proofmass_report::{
    Axis, Cell, Column, Head, KeyFigure, Report, Section, Series, SpherePlot, Table, XyPlot,
};
use proofmass_shaker::Configuration;
use proofmass_shaker::plan::{Conditioning, PlanCost, Predicted};

/// What the report tells about a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlanReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// The configurations of the plan, or the candidates.
    pub candidates: &'a [Configuration],
    /// Indices of the candidates a search chose; `None` when the plan is all of them.
    pub chosen: Option<&'a [usize]>,
    /// What fewer configurations cost, ascending; empty when it was not asked for.
    pub costs: &'a [PlanCost],
}

impl PlanReport<'_> {
    /// The whole report for the conditioning and the predicted uncertainties of the plan.
    pub(crate) fn full(&self, conditioning: &Conditioning, predicted: &[Predicted]) -> Report {
        let mut report = self.summary(conditioning, predicted);
        report = report.section(self.configurations());
        if !self.head.inputs.is_empty() {
            report = report.section(Section::new("Inputs").inputs(&self.head.inputs));
        }
        report.footer(self.head.footer.clone())
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, conditioning: &Conditioning, predicted: &[Predicted]) -> Report {
        let mut report = self.head.open().subtitle(format!(
            "What a plan of {} configurations will achieve",
            conditioning.count
        ));
        report = report
            .findings(self.head.findings.iter().cloned())
            .section(prediction(conditioning, predicted));
        if !self.costs.is_empty() {
            report = report.section(costs(self.costs));
        }
        report
    }

    fn configurations(&self) -> Section {
        let mut table = Table::new(
            "Configurations",
            [
                Column::number("number", ""),
                Column::number("inclination α", "°"),
                Column::number("rotation ω", "°"),
                Column::number("a_x", "a_ref"),
                Column::number("a_y", "a_ref"),
                Column::number("a_z", "a_ref"),
            ],
        );
        let mut sphere = SpherePlot::new("", "");
        let all: Vec<usize> = (0..self.candidates.len()).collect();
        for &index in self.chosen.unwrap_or(&all) {
            let Some(c) = self.candidates.get(index) else {
                continue;
            };
            let d = c.direction();
            sphere = sphere.point(d, 1.0, "");
            let mut cells = vec![
                Cell::number((index + 1).to_string()),
                Cell::number(plain(c.inclination.to_degrees())),
                Cell::number(plain(c.rotation.to_degrees())),
            ];
            cells.extend(d.map(|v| Cell::number(format!("{v:.3}"))));
            table = table.row(cells);
        }
        let words = match self.chosen {
            Some(_) => "The chosen configurations, numbered as the candidates are.",
            None => "The configurations in the order of the plan.",
        };
        Section::new("Configurations")
            .paragraph(words)
            .figure(
                "Directions of the excitation in the axes of the device",
                sphere,
            )
            .folded(
                "Table of the configurations",
                [proofmass_report::Block::Table(table)],
            )
    }
}

fn largest(predicted: &[Predicted], main: bool) -> f64 {
    predicted
        .iter()
        .filter(|p| (p.term.chars().next() == p.term.chars().nth(1)) == main)
        .map(|p| p.relative_real)
        .fold(0.0, f64::max)
}

fn prediction(conditioning: &Conditioning, predicted: &[Predicted]) -> Section {
    let percent = |u: f64| format!("{:.2}", 200.0 * u);
    let mut table = Table::new(
        "Predicted standard uncertainty of every term of S, relative to the mean main sensitivity",
        [
            Column::text("term"),
            Column::number("real part", "%"),
            Column::number("imaginary part", "%"),
        ],
    );
    for p in predicted {
        table = table.row([
            Cell::text(format!("S_{}", p.term)),
            Cell::number(two_digits(100.0 * p.relative_real)),
            Cell::number(two_digits(100.0 * p.relative_imaginary)),
        ]);
    }
    let [xy, yz, zx] = conditioning.correlation;
    // Rounding of sines of whole turns is no correlation.
    let printed = |c: f64| proofmass_report::number::minus(&format!("{c:.2}"));
    Section::new("Prediction")
        .key_figures([
            KeyFigure::new(
                "U of the main terms",
                percent(largest(predicted, true)),
                "%",
            )
            .note("k = 2, the largest of three"),
            KeyFigure::new(
                "U of the cross terms",
                percent(largest(predicted, false)),
                "%",
            )
            .note("of the main sensitivity, k = 2"),
            KeyFigure::new(
                "condition number",
                format!("{:.3}", conditioning.condition),
                "",
            ),
            KeyFigure::new(
                "D-efficiency",
                format!("{:.3}", conditioning.d_efficiency),
                "",
            )
            .note("1: directions cover the sphere evenly"),
            KeyFigure::new(
                "A-efficiency",
                format!("{:.3}", conditioning.a_efficiency),
                "",
            ),
        ])
        .paragraph(format!(
            "Correlation of the regressors: a_x with a_y {}, a_y with a_z {}, a_z with a_x {}.",
            printed(xy),
            printed(yz),
            printed(zx)
        ))
        .table(table)
}

fn costs(costs: &[PlanCost]) -> Section {
    let mut table = Table::new(
        "The best plans of fewer configurations (largest determinant), and what they cost",
        [
            Column::number("configurations", ""),
            Column::number("U main", "%"),
            Column::number("U cross", "%"),
            Column::number("condition", ""),
            Column::number("D-efficiency", ""),
            Column::number("A-efficiency", ""),
        ],
    )
    .note("U = 2 u of the worst term, relative to the mean main sensitivity.");
    let count: Vec<f64> = costs.iter().map(|c| c.conditioning.count as f64).collect();
    for c in costs {
        table = table.row([
            Cell::number(c.conditioning.count.to_string()),
            Cell::number(format!("{:.2}", 200.0 * c.main)),
            Cell::number(format!("{:.2}", 200.0 * c.cross)),
            Cell::number(format!("{:.2}", c.conditioning.condition)),
            Cell::number(format!("{:.3}", c.conditioning.d_efficiency)),
            Cell::number(format!("{:.3}", c.conditioning.a_efficiency)),
        ]);
    }
    let main: Vec<f64> = costs.iter().map(|c| 200.0 * c.main).collect();
    let cross: Vec<f64> = costs.iter().map(|c| 200.0 * c.cross).collect();
    let plot = XyPlot::new(
        Axis::linear("configurations", ""),
        Axis::linear("predicted U of the worst term", "%"),
    )
    .series(Series::line("main terms", &count, &main).style(Style::LineAndMarkers))
    .series(Series::line("cross terms", &count, &cross).style(Style::LineAndMarkers));
    Section::new("What fewer configurations cost")
        .figure(
            "Predicted expanded uncertainty (k = 2) of the worst main and the worst cross term",
            plot,
        )
        .table(table)
}

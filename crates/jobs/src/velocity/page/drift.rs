//! The report of what a velocity from an accelerometer alone drifts.

use proofmass_motion::{DriftBudget, DriftSources};
use proofmass_report::plot::{Axis, Series, XyPlot};
use proofmass_report::{Cell, Column, Head, Report, Section, Table, scientific};

/// What a report of a drift tells.
#[derive(Clone, Debug, Default)]
pub(crate) struct DriftReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
}

/// Causes with what each brings after a time: name, and the part of a budget.
type Cause = (&'static str, fn(&DriftBudget) -> f64);

const CAUSES: [Cause; 8] = [
    ("offset, known", |b| b.offset),
    ("inclination, known", |b| b.orientation),
    ("gain, known", |b| b.gain),
    ("u of the offset", |b| b.offset_uncertainty),
    ("u of the inclination", |b| b.orientation_uncertainty),
    ("u of the gain", |b| b.gain_uncertainty),
    ("white noise", |b| b.noise),
    ("walk of the offset", |b| b.walk),
];

impl DriftReport<'_> {
    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, budgets: &[DriftBudget]) -> Report {
        let used: Vec<Cause> = CAUSES
            .into_iter()
            .filter(|(_, part)| budgets.iter().any(|b| part(b) != 0.0))
            .collect();
        let columns = std::iter::once(Column::number("after", "s"))
            .chain(used.iter().map(|(name, _)| Column::number(*name, "m/s")))
            .chain([
                Column::number("drift", "m/s"),
                Column::number("U, 95 %", "m/s"),
            ]);
        let mut table = Table::new(
            "Velocity from the accelerometer alone, in excess of the true one",
            columns,
        );
        for budget in budgets {
            let parts = used.iter().map(|(_, part)| part(budget));
            let cells = std::iter::once(budget.time)
                .chain(parts)
                .chain([budget.known(), 1.96 * budget.combined])
                .map(|x| Cell::number(scientific(x, 3)));
            table = table.row(cells);
        }
        self.head
            .open()
            .findings(self.head.findings.iter().cloned())
            .section(Section::new("Drift").table(table))
    }

    /// The whole report.
    pub(crate) fn full(&self, sources: &DriftSources, budgets: &[DriftBudget]) -> Report {
        let report = self.summary(budgets);
        let last = budgets.iter().fold(0.0f64, |m, b| m.max(b.time));
        let time: Vec<f64> = (1..=200).map(|k| last * f64::from(k) / 200.0).collect();
        let curve: Vec<DriftBudget> = time.iter().map(|t| sources.after(*t)).collect();
        let known: Vec<f64> = curve.iter().map(DriftBudget::known).collect();
        let edge = |sign: f64| -> Vec<f64> {
            let pairs = curve.iter();
            pairs
                .map(|b| b.known() + sign * 1.96 * b.combined)
                .collect()
        };
        let plot = XyPlot::new(
            Axis::linear("time since the integration began", "s"),
            Axis::linear("drift", "m/s"),
        )
        .series(Series::line("", &time, &known).band(&edge(-1.0), &edge(1.0)))
        .horizontal(0.0, "");
        report
            .section(Section::new("Drift over time").figure(
                "The known drift, with the interval that holds it in 95 of 100 cases",
                plot,
            ))
            .footer(self.head.footer.clone())
    }
}

//! The report of a recorded motion.

use proofmass_report::number::plain;
use proofmass_report::{Axis, Cell, Column, Head, Report, Section, Series, Table, XyPlot};
use proofmass_signal::Trace;
use proofmass_uncertainty::Quantity;

/// What the report tells of a recorded motion.
#[derive(Clone, Debug)]
pub(crate) struct MotionReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Figures by name.
    pub quantities: Vec<Quantity>,
    /// Damping ratio of the response spectrum.
    pub damping: f64,
    /// Acceleration, velocity, displacement.
    pub traces: &'a [Trace; 3],
    /// Periods, s.
    pub period: &'a [f64],
    /// m/s².
    pub pseudo_acceleration: Vec<f64>,
    /// m/s².
    pub acceleration: &'a [f64],
    /// m.
    pub displacement: &'a [f64],
    /// 5–75 %, 5–95 %, bracketed, s.
    pub durations: [Option<f64>; 3],
}

impl MotionReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self) -> Report {
        let [a, v, x] = self.traces;
        let history = XyPlot::new(
            Axis::linear("time", "s"),
            Axis::linear("acceleration", "m/s²"),
        )
        .series(Series::line("", &a.x, &a.y))
        .below(Axis::linear("velocity", "m/s"))
        .series(Series::line("", &v.x, &v.y))
        .below(Axis::linear("displacement", "m"))
        .series(Series::line("", &x.x, &x.y));
        let positive = |y: &[f64]| -> (Vec<f64>, Vec<f64>) {
            let pairs = self.period.iter().copied().zip(y.iter().copied());
            pairs.filter(|(_, y)| *y > 0.0).unzip()
        };
        let (tp, p) = positive(&self.pseudo_acceleration);
        let (ta, a) = positive(self.acceleration);
        let (tx, x) = positive(self.displacement);
        let spectrum = XyPlot::new(Axis::log("period", "s"), Axis::log("acceleration", "m/s²"))
            .series(Series::line("pseudo-acceleration", &tp, &p))
            .series(Series::line("absolute acceleration", &ta, &a))
            .below(Axis::log("relative displacement", "m"))
            .series(Series::line("", &tx, &x));
        self.summary()
            .section(Section::new("Time history").figure(
                "Acceleration as corrected, and its integrals from rest",
                history,
            ))
            .section(Section::new("Response spectrum").figure(
                format!(
                    "Greatest response within the record of oscillators with a damping ratio of {} %",
                    plain(100.0 * self.damping)
                ),
                spectrum,
            ))
            .foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self) -> Report {
        let report = self.head.open();
        let mut table = Table::new(
            "Figures of the record",
            [
                Column::text("figure"),
                Column::number("value", ""),
                Column::text("unit"),
            ],
        );
        for q in &self.quantities {
            // Without an uncertainty of the acceleration none of its figures has one: six digits then, and no claim.
            let value = if q.standard_uncertainty > 0.0 {
                proofmass_report::number::concise(q.value, q.standard_uncertainty)
            } else {
                format!("{:.5e}", q.value)
            };
            table = table.row([
                Cell::text(q.name.replace('_', " ")),
                Cell::number(value),
                Cell::text(q.unit.clone()),
            ]);
        }
        for (name, duration) in ["duration 5–75 %", "duration 5–95 %", "bracketed duration"]
            .into_iter()
            .zip(self.durations)
        {
            if let Some(d) = duration {
                table = table.row([
                    Cell::text(name),
                    Cell::number(format!("{d:.3}")),
                    Cell::text("s"),
                ]);
            }
        }
        report
            .findings(self.head.findings.iter().cloned())
            .section(Section::new("Result").table(table))
    }
}

//! The report of a bias over time.

use proofmass_core::STANDARD_GRAVITY;
use proofmass_core::velocity::BiasModel;
use proofmass_report::{
    Axis, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot, concise,
    scientific,
};
use proofmass_static::{AxisTrack, BiasEstimate, BiasTrack};

const AXES: [&str; 3] = ["x", "y", "z"];
const MG: f64 = 1e3 / STANDARD_GRAVITY;
/// Points of a curve with a band.
const POINTS: usize = 1200;

/// One rest.
#[derive(Clone, Debug)]
pub(crate) struct BiasLine {
    /// Name or number.
    pub name: String,
    /// First and last time, s.
    pub span: [f64; 2],
}

/// What the report tells beside the track itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct BiasReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Coverage probability.
    pub probability: f64,
    /// Gravity that was known, m/s²; `None` where the readings are free of it.
    pub gravity: Option<f64>,
    /// The rests.
    pub rests: Vec<BiasLine>,
    /// Samples per second.
    pub rate: f64,
    /// φ, Q, R at that rate.
    pub coefficients: &'a [[f64; 3]],
}

impl BiasReport<'_> {
    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, track: &BiasTrack) -> Report {
        let updates = track.rest.iter().flatten().count();
        let [from, to] = [track.time.first(), track.time.last()].map(|t| t.copied().unwrap_or(0.0));
        let report = self.head.open().subtitle(format!(
            "{} rests, {updates} means, {:.1} s",
            self.rests.len(),
            to - from
        ));
        let figures = track.quantities.iter().zip(&track.axes).map(|(q, axis)| {
            let change = axis.smoothed.last().zip(axis.smoothed.first());
            KeyFigure::new(
                format!("{} at the end", q.name.replace('.', " of ")),
                concise(q.value * MG, q.standard_uncertainty * MG),
                "mg",
            )
            .note(change.map_or(String::new(), |(last, first)| {
                format!(
                    "{:+.3} mg since the beginning",
                    (last.bias - first.bias) * MG
                )
            }))
        });
        let mut table = Table::new(
            "Bias at the end of the recording",
            [
                Column::text("quantity"),
                Column::number("value", "m/s²"),
                Column::number(format!("U ({:.0} %)", 1e2 * self.probability), "m/s²"),
                Column::number("from the known acceleration", "m/s²"),
            ],
        );
        for (q, axis) in track.quantities.iter().zip(&track.axes) {
            table = table.row([
                Cell::text(q.name.clone()),
                Cell::number(concise(q.value, q.standard_uncertainty)),
                Cell::number(scientific(q.expanded(self.probability), 2)),
                Cell::number(scientific(axis.known_part, 2)),
            ]);
        }
        let what = match self.gravity {
            Some(g) => format!(
                "At rest the sensor reads gravity, {g:.5} m/s², in the stated attitude. An error of the scale in that direction is part of the bias."
            ),
            None => "At rest the sensor reads zero: its readings are free of gravity.".to_owned(),
        };
        report.findings(self.head.findings.iter().cloned()).section(
            Section::new("Result")
                .paragraph(what)
                .key_figures(figures)
                .table(table)
                .table(consistency(track)),
        )
    }

    /// The whole report.
    pub(crate) fn full(&self, track: &BiasTrack) -> Report {
        let mut section = Section::new("Bias over time");
        for (axis, name) in track.axes.iter().zip(AXES) {
            section = section.figure(
                format!("{name}: smoothed over the whole recording with two standard uncertainties, and as the filter had it on line"),
                curve(track, axis),
            );
        }
        let at: Vec<f64> = track
            .time
            .iter()
            .zip(&track.rest)
            .filter(|(_, rest)| rest.is_some())
            .map(|(t, _)| *t)
            .collect();
        let mut plot = XyPlot::new(Axis::linear("time", "s"), Axis::linear("innovation", "σ"))
            .horizontal(2.0, "")
            .horizontal(-2.0, "");
        for (axis, name) in track.axes.iter().zip(AXES) {
            let (t, z) = thinned(&at, &axis.normalised);
            plot = plot.series(Series::markers(name, &t, &z));
        }
        let mut rests = Table::new(
            "Rests",
            [
                Column::text("rest"),
                Column::number("from", "s"),
                Column::number("to", "s"),
                Column::number("bias of x", "m/s²"),
                Column::number("bias of y", "m/s²"),
                Column::number("bias of z", "m/s²"),
            ],
        )
        .note("Smoothed, in the middle of each rest.");
        for (number, rest) in self.rests.iter().enumerate() {
            let members: Vec<usize> = (0..track.rest.len())
                .filter(|i| track.rest[*i] == Some(number))
                .collect();
            let Some(middle) = members.get(members.len() / 2) else {
                continue;
            };
            let mut cells = vec![
                Cell::text(rest.name.clone()),
                Cell::number(format!("{:.2}", rest.span[0])),
                Cell::number(format!("{:.2}", rest.span[1])),
            ];
            cells.extend(track.axes.iter().map(|axis| {
                let BiasEstimate { bias, u } = axis.smoothed[*middle];
                Cell::number(concise(bias, u))
            }));
            rests = rests.row(cells);
        }
        self.summary(track)
            .section(section)
            .section(Section::new("Innovations").figure(
                "What each mean lies beside its prediction, in standard deviations",
                plot,
            ))
            .section(Section::new("On the chip").table(self.firmware()))
            .section(Section::new("Rests").table(rests))
            .foot(&self.head)
    }

    fn firmware(&self) -> Table {
        let mut table = Table::new(
            format!("Coefficients of the filter at {} Hz", proofmass_report::number::plain(self.rate)),
            [
                Column::text("axis"),
                Column::number("φ", ""),
                Column::number("Q", "(m/s²)²"),
                Column::number("R", "(m/s²)²"),
            ],
        )
        .note("b ← φ b, P ← φ² P + Q at every sample; K = P/(P + R), b ← b + K (ã − a − b) while a is known.");
        for (c, name) in self.coefficients.iter().zip(AXES) {
            table = table.row([
                Cell::text(name),
                Cell::number(format!("{:.9}", c[0])),
                Cell::number(format!("{:.4e}", c[1])),
                Cell::number(format!("{:.4e}", c[2])),
            ]);
        }
        table
    }
}

fn consistency(track: &BiasTrack) -> Table {
    let mut table = Table::new(
        "Are the innovations what the noise lets expect?",
        [
            Column::text("axis"),
            Column::number("white noise", "(m/s²)/√Hz"),
            Column::text("bias"),
            Column::number("innovations over σ", ""),
            Column::text("by chance"),
            Column::number("Ljung–Box", ""),
            Column::number("limit", ""),
            Column::number("rests out of line", ""),
        ],
    );
    for (axis, name) in track.axes.iter().zip(AXES) {
        let model = match axis.noise.model {
            BiasModel::RandomWalk { density, .. } => {
                format!("walk, {} (m/s²)·√Hz", scientific(density.sqrt(), 3))
            }
            BiasModel::GaussMarkov { deviation, time } => {
                format!(
                    "Gauss–Markov, {} m/s², {time:.4} s",
                    scientific(deviation, 3)
                )
            }
        };
        let c = &axis.consistency;
        let [statistic, limit] = match c.whiteness {
            Some(pair) => pair.map(|v| Cell::number(format!("{v:.1}"))),
            None => [Cell::Empty, Cell::Empty],
        };
        table = table.row([
            Cell::text(name),
            Cell::number(scientific(axis.noise.white, 3)),
            Cell::text(model),
            Cell::number(format!("{:.3}", c.ratio)),
            Cell::text(format!("{:.3} to {:.3}", c.limits[0], c.limits[1])),
            statistic,
            limit,
            Cell::number(c.deviating.len().to_string()),
        ]);
    }
    table
}

/// Every so many points, the last one among them.
fn thinned(x: &[f64], y: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let n = x.len().min(y.len());
    let step = n.div_ceil(POINTS).max(1);
    let kept = (0..n).filter(|i| i % step == 0 || i + 1 == n);
    kept.map(|i| (x[i], y[i])).unzip()
}

fn curve(track: &BiasTrack, axis: &AxisTrack) -> XyPlot {
    let part = |estimates: &[BiasEstimate], k: f64| -> Vec<f64> {
        let values = estimates.iter().map(|e| (e.bias + k * e.u) * MG);
        thinned(&track.time, &values.collect::<Vec<f64>>()).1
    };
    let (time, _) = thinned(&track.time, &track.time);
    // Before its first update the filter knows nothing: that is no part of the picture.
    let first = track.rest.iter().position(Option::is_some).unwrap_or(0);
    let (on_line_time, _) = thinned(&track.time[first..], &track.time[first..]);
    let on_line: Vec<f64> = axis.filtered[first..].iter().map(|e| e.bias * MG).collect();
    let (_, on_line) = thinned(&track.time[first..], &on_line);
    XyPlot::new(Axis::linear("time", "s"), Axis::linear("bias", "mg"))
        .series(
            Series::line("smoothed", &time, &part(&axis.smoothed, 0.0))
                .band(&part(&axis.smoothed, -2.0), &part(&axis.smoothed, 2.0)),
        )
        .series(Series::line("on line", &on_line_time, &on_line))
}

//! The report of a single-axis comparison with a reference.

use crate::page::coverage::stated_at;
use proofmass_report::number::{minus, plain, rounded};
use proofmass_report::{
    Axis, BarPlot, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot,
};
use proofmass_shaker::check_standard::CheckPoint;
use proofmass_shaker::derived::Expanded;
use proofmass_shaker::single_axis::{ComparisonRow, SingleAxis, transverse_limit};
use proofmass_uncertainty::DegreesOfFreedom;

/// What the report tells beside the comparison itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct SingleAxisReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// The runs, for the transverse motion; in the order of the results.
    pub runs: &'a [ComparisonRow],
    /// A check standard against what is known of it.
    pub check_standard: &'a [CheckPoint],
    /// A coverage factor that U is stated with, instead of that of 95 %.
    pub coverage_factor: Option<f64>,
}

impl SingleAxisReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self, results: &[SingleAxis]) -> Report {
        let mut report = self
            .summary(results)
            .section(self.curves(results))
            .section(budget(results));
        if self.runs.iter().any(|r| r.transverse.is_some()) {
            report = report.section(self.transverse());
        }
        if !self.check_standard.is_empty() {
            report = report.section(self.check_standard());
        }
        let section = Section::new("Inputs and method").inputs(&self.head.inputs);
        report
            .section(section.paragraph(
                "Comparison with a reference transducer (ISO 16063-21): S₂ = (X₂/X₁) S₁, φ₂ = φ₂,₁ + φ₁. Uncertainty by the \
                 law of propagation, coverage factors from Student's t (JCGM 100:2008).",
            ))
            .footer(self.head.footer.clone())
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, results: &[SingleAxis]) -> Report {
        let report = self.head.open().subtitle(format!(
            "Single-axis calibration by comparison with a reference: {} runs",
            results.len()
        ));
        report
            .findings(self.head.findings.iter().cloned())
            .section(self.result(results))
    }

    fn quantity(
        &self,
        result: &SingleAxis,
        name: &str,
        factor: f64,
    ) -> Option<(f64, f64, Expanded)> {
        let q = Expanded::of(result.estimate.get(name)?, self.coverage_factor);
        Some((factor * q.value, factor * q.expanded, q))
    }

    /// What U is stated at.
    fn at(&self, results: &[SingleAxis]) -> String {
        let all = results.iter().flat_map(|r| {
            let names = ["modulus", "phase"].into_iter();
            names.filter_map(|name| Some(self.quantity(r, name, 1.0)?.2))
        });
        stated_at(&all.collect::<Vec<_>>())
    }

    fn result(&self, results: &[SingleAxis]) -> Section {
        let (unit, factor) = unit(results);
        let mut table = Table::new(
            format!(
                "Sensitivity with its expanded uncertainty at {}",
                self.at(results)
            ),
            [
                Column::number("f", "Hz"),
                Column::number("modulus", unit),
                Column::number("U", unit),
                Column::number("U relative", "%"),
                Column::number("phase", "°"),
                Column::number("U phase", "°"),
                Column::number("k", ""),
                Column::number("ν_eff", ""),
            ],
        );
        let mut section = Section::new("Result");
        for r in results {
            let Some((m, u, q)) = self.quantity(r, "modulus", factor) else {
                continue;
            };
            let (value, expanded) = rounded(m, u);
            // A device with a clock of its own has none.
            let [phase, u_phase] = match self.quantity(r, "phase", 180.0 / std::f64::consts::PI) {
                Some((phase, u, _)) => {
                    let (phase, u) = rounded(phase, u);
                    [Cell::number(phase), Cell::number(u)]
                }
                None => [Cell::Empty, Cell::Empty],
            };
            table = table.row([
                Cell::number(plain(r.frequency)),
                Cell::number(value),
                Cell::number(expanded),
                Cell::number(format!("{:.2}", 100.0 * u / m)),
                phase,
                u_phase,
                Cell::number(format!("{:.2}", q.coverage_factor)),
                Cell::number(
                    q.dof
                        .and_then(DegreesOfFreedom::new)
                        .unwrap_or(DegreesOfFreedom::INFINITE)
                        .to_string(),
                ),
            ]);
        }
        let nearest = results.iter().min_by(|a, b| {
            let far = |r: &SingleAxis| (r.frequency / 160.0).ln().abs();
            far(a).total_cmp(&far(b))
        });
        if let Some((r, (m, u, _))) =
            nearest.and_then(|r| Some((r, self.quantity(r, "modulus", factor)?)))
        {
            let (value, expanded) = rounded(m, u);
            section = section.key_figures([KeyFigure::new(
                format!("sensitivity at {} Hz", plain(r.frequency)),
                format!("{} ± {expanded}", minus(&value)),
                unit,
            )
            .note(format!("U = {:.2} %", 100.0 * u / m))]);
        }
        section.table(table)
    }

    fn curves(&self, results: &[SingleAxis]) -> Section {
        let (unit, factor) = unit(results);
        let points = |name: &str, factor: f64| -> Vec<(f64, f64, f64)> {
            let mut points: Vec<_> = results
                .iter()
                .filter_map(|r| {
                    self.quantity(r, name, factor)
                        .map(|(v, u, _)| (r.frequency, v, u))
                })
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points
        };
        let mut plot = XyPlot::new(Axis::log("frequency", "Hz"), Axis::linear("modulus", unit))
            .series(Series::intervals("", &points("modulus", factor)));
        let phases = points("phase", 180.0 / std::f64::consts::PI);
        let caption = if phases.is_empty() {
            "Modulus"
        } else {
            plot = plot
                .below(Axis::linear("phase", "°"))
                .series(Series::intervals("", &phases).look(0));
            "Modulus and phase"
        };
        for panel in &mut plot.panels {
            panel.height = 220.0;
        }
        Section::new("Sensitivity against frequency").figure(
            format!(
                "{caption} of the sensitivity with intervals at {}",
                self.at(results)
            ),
            plot,
        )
    }

    fn check_standard(&self) -> Section {
        let points = |of: fn(&CheckPoint) -> (f64, f64), factor: f64| -> Vec<(f64, f64, f64)> {
            let list = self.check_standard.iter();
            list.map(|p| {
                let (d, u) = of(p);
                (p.frequency, factor * d, 2.0 * factor * u)
            })
            .collect()
        };
        let modulus = points(|p| (p.modulus, p.modulus_uncertainty), 100.0);
        let phase = points(
            |p| (p.phase, p.phase_uncertainty),
            180.0 / std::f64::consts::PI,
        );
        let mut plot = XyPlot::new(
            Axis::log("frequency", "Hz"),
            Axis::linear("departure of the modulus", "%"),
        )
        .series(Series::intervals("", &modulus))
        .horizontal(0.0, "")
        .below(Axis::linear("departure of the phase", "°"))
        .series(Series::intervals("", &phase).look(0))
        .horizontal(0.0, "");
        for panel in &mut plot.panels {
            panel.height = 160.0;
        }
        let worst = |k: usize| -> String {
            let list = self.check_standard.iter();
            list.filter_map(|p| p.e_n()[k])
                .max_by(|a, b| a.abs().total_cmp(&b.abs()))
                .map_or("–".to_owned(), |e| minus(&format!("{e:.2}")))
        };
        Section::new("Check standard")
            .key_figures([
                KeyFigure::new("largest E_n of the modulus", worst(0), ""),
                KeyFigure::new("largest E_n of the phase", worst(1), ""),
            ])
            .figure(
                "Departure of the check standard from its known sensitivity, with twice the standard uncertainty of both",
                plot,
            )
    }

    fn transverse(&self) -> Section {
        let mut table = Table::new(
            "Transverse motion against the limits of ISO 16063-21",
            [
                Column::text("run"),
                Column::number("f", "Hz"),
                Column::number("transverse motion", "%"),
                Column::number("limit", "%"),
                Column::text(""),
            ],
        );
        for run in self.runs {
            let limit = transverse_limit(run.frequency);
            let cells = match run.transverse {
                Some(t) => [
                    Cell::number(format!("{:.2}", 100.0 * t)),
                    Cell::number(format!("{:.0}", 100.0 * limit)),
                    Cell::text(if t > limit { "exceeds" } else { "within" }),
                ],
                None => [
                    Cell::Empty,
                    Cell::number(format!("{:.0}", 100.0 * limit)),
                    Cell::text("not measured"),
                ],
            };
            let mut row = vec![
                Cell::text(run.run.clone()),
                Cell::number(plain(run.frequency)),
            ];
            row.extend(cells);
            table = table.row(row);
        }
        Section::new("Transverse motion").table(table)
    }
}

/// The prefix that suits the largest modulus; only volts take one.
fn unit(results: &[SingleAxis]) -> (&str, f64) {
    let own = results
        .iter()
        .filter_map(|r| r.estimate.components().first())
        .map(|c| c.unit.as_str())
        .next();
    if let Some(other) = own.filter(|unit| *unit != "V/(m/s²)") {
        return (other, 1.0);
    }
    let largest = results.iter().map(|r| r.sensitivity.norm());
    match largest.fold(0.0, f64::max) {
        v if v >= 0.5 => ("V/(m/s²)", 1.0),
        v if v >= 0.5e-3 => ("mV/(m/s²)", 1e3),
        _ => ("µV/(m/s²)", 1e6),
    }
}

fn budget(results: &[SingleAxis]) -> Section {
    let mut shares: Vec<(String, f64)> = vec![];
    for r in results {
        for line in r.estimate.budget("modulus").unwrap_or_default() {
            let share = line.share / results.len() as f64;
            match shares.iter_mut().find(|s| s.0 == line.description) {
                Some(s) => s.1 += share,
                None => shares.push((line.description, share)),
            }
        }
    }
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let bars = shares.into_iter().fold(
        BarPlot::shares("share of the variance"),
        |bars, (name, share)| bars.bar(name, share, ""),
    );
    Section::new("Uncertainty").figure(
        "Causes of the uncertainty of the modulus, mean over the runs",
        bars,
    )
}

//! The report of a transverse sensitivity test.

use crate::page::coverage::stated_at;
use proofmass_report::number::{plain, rounded, two_digits};
use proofmass_report::{
    Axis, BarPlot, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot,
};
use proofmass_shaker::transverse::{Motion, TransverseRow, TransverseSensitivity};

/// What the report tells beside the results themselves.
#[derive(Clone, Debug, Default)]
pub(crate) struct TransverseReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// The runs that were used.
    pub runs: &'a [TransverseRow],
    /// Largest transverse sensitivity of the datasheet, relative.
    pub limit: Option<f64>,
}

impl TransverseReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self, results: &[TransverseSensitivity]) -> Report {
        let mut report = self.summary(results);
        if results.len() > 1 {
            report = report.section(self.over_frequency(results));
        }
        let section = Section::new("Inputs and method").inputs(&self.head.inputs);
        report
            .section(self.over_rotation(results))
            .section(budget(results))
            .section(section.paragraph(
                "The device is shaken across its axis and turned about it by ω (ISO 16063-31): y(ω) = c + S_x cos ω + S_y sin ω, \
                 with complex S_x, S_y by least squares. T is the largest |S_x cos ω + S_y sin ω| over |S|, the sensitivity along \
                 the axis. c is what the motion along the axis makes; from three directions on it is fitted. A base that does \
                 not sit flat turns with the device, so that its tilt enters T undiminished. ω is counted clockwise, seen from \
                 above on the device: the direction of the vibration in the base, from x towards y. Near zero the interval is \
                 the set of values that the measured one does not contradict.",
            ))
            .footer(self.head.footer.clone())
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, results: &[TransverseSensitivity]) -> Report {
        let across: usize = results.iter().map(|r| r.runs).sum();
        let report = self.head.open().subtitle(format!(
            "Transverse sensitivity at {}: {across} runs across the axis",
            if results.len() == 1 {
                "one frequency".to_owned()
            } else {
                format!("{} frequencies", results.len())
            }
        ));
        report
            .findings(self.head.findings.iter().cloned())
            .section(self.result(results))
    }

    fn result(&self, results: &[TransverseSensitivity]) -> Section {
        let mut table = Table::new(
            format!(
                "Transverse sensitivity relative to that along the axis, with its expanded uncertainty at {}",
                at(results)
            ),
            [
                Column::number("f", "Hz"),
                Column::number("T", "%"),
                Column::number("U", "%"),
                Column::number("k", ""),
                Column::number("direction", "°"),
                Column::number("U", "°"),
                Column::number("directions", ""),
                Column::number("scatter", "%"),
            ],
        )
        .note(
            "The direction is that of the largest response, modulo 180°; it is stated where T exceeds U. \
             Scatter is that of one run about the fit, relative to the sensitivity along the axis.",
        );
        for r in results {
            let (value, expanded) = rounded(100.0 * r.ratio.value, 100.0 * r.ratio.expanded);
            let (angle, u) = match &r.direction {
                Some(d) => {
                    let (a, u) = rounded(
                        d.value.to_degrees().rem_euclid(180.0),
                        d.expanded.to_degrees(),
                    );
                    (Cell::number(a), Cell::number(u))
                }
                None => (Cell::Empty, Cell::Empty),
            };
            table = table.row([
                Cell::number(plain(r.frequency)),
                Cell::number(value),
                Cell::number(expanded),
                Cell::number(format!("{:.2}", r.ratio.coverage_factor)),
                angle,
                u,
                Cell::number(r.directions.to_string()),
                r.scatter
                    .map_or(Cell::Empty, |s| Cell::number(two_digits(100.0 * s))),
            ]);
        }
        let mut section = Section::new("Result");
        let largest = results
            .iter()
            .max_by(|a, b| a.ratio.value.total_cmp(&b.ratio.value));
        if let Some(r) = largest {
            let (value, expanded) = rounded(100.0 * r.ratio.value, 100.0 * r.ratio.expanded);
            let mut figures = vec![
                KeyFigure::new(
                    "largest transverse sensitivity",
                    format!("{value} ± {expanded}"),
                    "%",
                )
                .note(format!("at {} Hz", plain(r.frequency))),
            ];
            if let Some(limit) = self.limit {
                figures.push(KeyFigure::new(
                    "limit of the datasheet",
                    plain(100.0 * limit),
                    "%",
                ));
            }
            section = section.key_figures(figures);
        }
        section.table(table)
    }

    fn over_frequency(&self, results: &[TransverseSensitivity]) -> Section {
        let points: Vec<(f64, f64, f64)> = results
            .iter()
            .map(|r| (r.frequency, 100.0 * r.ratio.value, 100.0 * r.ratio.expanded))
            .collect();
        let mut plot = XyPlot::new(
            Axis::log("frequency", "Hz"),
            Axis::linear("transverse sensitivity", "%"),
        )
        .height(220.0)
        .series(Series::intervals("", &points));
        if let Some(limit) = self.limit {
            plot = plot.horizontal(100.0 * limit, "datasheet");
        }
        Section::new("Transverse sensitivity against frequency").figure(
            format!(
                "Transverse sensitivity relative to that along the axis, with its intervals at {}",
                at(results)
            ),
            plot,
        )
    }

    /// At most four frequencies, spread over all of them.
    fn over_rotation(&self, results: &[TransverseSensitivity]) -> Section {
        let mut section = Section::new("Output against direction");
        let shown = results.len().min(4);
        for k in 0..shown {
            let r = &results[if shown > 1 {
                k * (results.len() - 1) / (shown - 1)
            } else {
                0
            }];
            let [s, x, y] = r.sensitivities();
            let angles: Vec<f64> = (0..=360).step_by(2).map(f64::from).collect();
            let at = |degrees: f64| {
                let (sin, cos) = degrees.to_radians().sin_cos();
                100.0 * ((x * cos + y * sin) / s + r.constant)
            };
            let seen: Vec<(f64, num_complex::Complex64)> = self
                .runs
                .iter()
                .filter(|row| row.frequency == r.frequency)
                .filter_map(|row| match row.motion {
                    Motion::Transverse { rotation } => Some((
                        rotation.to_degrees().rem_euclid(360.0),
                        100.0 * row.ratio / s,
                    )),
                    Motion::Axial => None,
                })
                .collect();
            let x: Vec<f64> = seen.iter().map(|p| p.0).collect();
            let real: Vec<f64> = seen.iter().map(|p| p.1.re).collect();
            let imaginary: Vec<f64> = seen.iter().map(|p| p.1.im).collect();
            let fit: Vec<num_complex::Complex64> = angles.iter().map(|a| at(*a)).collect();
            let part = |of: fn(&num_complex::Complex64) -> f64| -> Vec<f64> {
                fit.iter().map(of).collect()
            };
            let plot = XyPlot::new(
                Axis::linear("direction ω", "°"),
                Axis::linear("output over that along the axis", "%"),
            )
            .height(220.0)
            .series(Series::line("in phase, fit", &angles, &part(|z| z.re)).look(0))
            .series(Series::markers("in phase", &x, &real).look(0))
            .series(Series::line("in quadrature, fit", &angles, &part(|z| z.im)).look(1))
            .series(Series::markers("in quadrature", &x, &imaginary).look(1));
            section = section.figure(
                format!(
                    "{} Hz: runs and the fitted cosine, relative to the output along the axis",
                    plain(r.frequency)
                ),
                plot,
            );
        }
        section
    }
}

/// What U is stated at.
fn at(results: &[TransverseSensitivity]) -> String {
    stated_at(
        results
            .iter()
            .flat_map(|r| std::iter::once(&r.ratio).chain(&r.direction)),
    )
}

fn budget(results: &[TransverseSensitivity]) -> Section {
    let mut shares: Vec<(String, f64)> = vec![];
    for r in results {
        // Of the two parts of both transverse sensitivities together.
        let mut all = 0.0;
        let mut own: Vec<(String, f64)> = vec![];
        for name in ["x.re", "x.im", "y.re", "y.im"] {
            let u = r.estimate.get(name).map_or(0.0, |q| q.standard_uncertainty);
            for line in r.estimate.budget(name).unwrap_or_default() {
                all += line.share * u * u;
                own.push((line.description, line.share * u * u));
            }
        }
        for (description, variance) in own {
            let share = if all > 0.0 {
                variance / all / results.len() as f64
            } else {
                0.0
            };
            match shares.iter_mut().find(|s| s.0 == description) {
                Some(s) => s.1 += share,
                None => shares.push((description, share)),
            }
        }
    }
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let bars = shares.into_iter().fold(
        BarPlot::shares("share of the variance"),
        |bars, (name, share)| bars.bar(name, share, ""),
    );
    Section::new("Uncertainty").figure(
        "Causes of the uncertainty of S_x and S_y, mean over the frequencies",
        bars,
    )
}

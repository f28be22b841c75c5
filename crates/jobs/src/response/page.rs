//! The report of a frequency response.

use crate::page::parameters::parameters;
use proofmass_dynamic::model::{ModelFit, ResponseFigures};
use proofmass_dynamic::modes::Resonance;
use proofmass_report::number::{concise, plain, two_digits};
use proofmass_report::plot::Style;
use proofmass_report::{
    Axis, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot,
};
use proofmass_signal::transfer::ResponseEstimate;
use proofmass_uncertainty::student_quantile;

/// Frequencies, densities of input and output over them, root mean squares of both.
pub(crate) type Power<'a> = (&'a [f64], &'a [f64], &'a [f64], [f64; 2]);

/// What the report tells of a frequency response.
#[derive(Clone, Debug)]
pub(crate) struct ResponseReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Name and unit of input and output.
    pub channels: &'a [(String, String); 2],
    /// Unit of the response.
    pub unit: &'a str,
    /// Independent averages; zero where there are none.
    pub independent: f64,
    /// The response.
    pub response: &'a ResponseEstimate,
    /// Power of both channels.
    pub power: Option<Power<'a>>,
    /// Resonances.
    pub modes: &'a [Resonance],
    /// Bandwidths, resonance, dampings.
    pub figures: Option<&'a ResponseFigures>,
    /// Fitted model.
    pub fit: Option<&'a ModelFit>,
}

/// Lines that a figure shows; beyond, every n-th.
const SHOWN: usize = 1500;
/// Points up to which they are drawn one by one.
const FEW: usize = 100;
/// Steps of the curve of a model beside them.
const DENSE: usize = 600;

impl ResponseReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self) -> Report {
        let mut report = self.summary().section(self.bode()).section(self.nyquist());
        if let Some((f, x, y, _)) = self.power {
            let step = f.len().div_ceil(SHOWN).max(1);
            let positive = |v: &[f64]| -> (Vec<f64>, Vec<f64>) {
                f.iter()
                    .zip(v)
                    .step_by(step)
                    .filter(|(f, v)| **f > 0.0 && **v > 0.0)
                    .unzip()
            };
            let [(input, unit_in), (output, unit_out)] = self.channels;
            let (fx, x) = positive(x);
            let (fy, y) = positive(y);
            let plot = XyPlot::new(
                Axis::log("frequency", "Hz"),
                Axis::log(input.as_str(), format!("({unit_in})²/Hz")),
            )
            .series(Series::line("", &fx, &x))
            .below(Axis::log(output.as_str(), format!("({unit_out})²/Hz")))
            .series(Series::line("", &fy, &y));
            report = report.section(
                Section::new("Densities").figure("One-sided densities of input and output", plot),
            );
        }
        if let Some(fit) = self.fit {
            report = report.section(residuals(fit));
        }
        report.foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self) -> Report {
        let report = self.head.open();
        let r = self.response;
        let lines = if self.single() { "points" } else { "lines" };
        let mut figures = vec![KeyFigure::new(lines, r.lines().to_string(), "")];
        if let (Some(low), Some(high)) = (r.frequency.first(), r.frequency.last()) {
            figures[0] =
                figures[0]
                    .clone()
                    .note(format!("{} Hz to {} Hz", plain(*low), plain(*high)));
        }
        if self.independent > 0.0 {
            figures.push(KeyFigure::new(
                "independent averages",
                format!("{:.1}", self.independent),
                "",
            ));
        }
        if let (Some(low), Some(high)) = (
            r.coherence.iter().copied().min_by(f64::total_cmp),
            r.coherence.iter().copied().max_by(f64::total_cmp),
        ) {
            figures.push(KeyFigure::new(
                "coherence",
                format!("{low:.4} … {high:.4}"),
                "",
            ));
        }
        if let Some((_, _, _, [x, y])) = self.power {
            let [(_, unit_in), (_, unit_out)] = self.channels;
            figures.push(KeyFigure::new(
                "RMS of the input",
                format!("{x:.4}"),
                unit_in.as_str(),
            ));
            figures.push(KeyFigure::new(
                "RMS of the output",
                format!("{y:.4}"),
                unit_out.as_str(),
            ));
        }
        let mut section = Section::new("Result").key_figures(figures);
        if let Some(fit) = self.fit {
            section = section.table(fitted(fit));
        }
        if !self.modes.is_empty() {
            section = section.table(modes(self.modes));
        }
        if let Some(figures) = self.figures {
            section = section.table(bandwidths(figures, self.unit));
            if !figures.damping.is_empty() {
                let mut table = Table::new(
                    "Damping ratio, each way by itself",
                    [Column::text("from"), Column::number("ζ", "")],
                );
                for d in &figures.damping {
                    table = table.row([
                        Cell::text(d.method.clone()),
                        Cell::number(concise(d.damping, d.standard_uncertainty)),
                    ]);
                }
                section = section.table(table);
            }
        }
        report
            .findings(self.head.findings.iter().cloned())
            .section(section)
    }

    fn kept(&self) -> Vec<usize> {
        let n = self.response.lines();
        (0..n)
            .step_by(n.div_ceil(SHOWN).max(1))
            .filter(|k| self.response.value[*k].norm() > 0.0)
            .collect()
    }

    fn bode(&self) -> Section {
        let r = self.response;
        let kept = self.kept();
        let f: Vec<f64> = kept.iter().map(|k| r.frequency[*k]).collect();
        let modulus: Vec<f64> = kept.iter().map(|k| r.value[*k].norm()).collect();
        let expanded: Vec<(f64, f64)> = kept
            .iter()
            .map(|k| {
                let (u, turn) = r.polar_uncertainty(*k);
                let t = student_quantile(0.975, r.dof[*k]);
                (t * u, t * turn.to_degrees())
            })
            .collect();
        let phase: Vec<f64> = kept
            .iter()
            .map(|k| r.value[*k].arg().to_degrees())
            .collect();
        let band = |y: &[f64], pick: fn(&(f64, f64)) -> f64, sign: f64| -> Vec<f64> {
            y.iter()
                .zip(&expanded)
                .map(|(y, u)| y + sign * pick(u))
                .collect()
        };
        let single = self.single();
        let drawn = |name: &str, y: &[f64], low: &[f64], high: &[f64]| {
            if single {
                Series::markers(name, &f, y).bars(low, high)
            } else {
                Series::line(name, &f, y).band(low, high)
            }
        };
        let mut plot = XyPlot::new(
            Axis::log("frequency", "Hz"),
            Axis::log("modulus", self.unit),
        )
        .series(drawn(
            "measured",
            &modulus,
            &band(&modulus, |u| u.0, -1.0),
            &band(&modulus, |u| u.0, 1.0),
        ));
        // Between few points a model is looked at more closely than they lie.
        let at: Vec<f64> = match (f.first(), f.last()) {
            (Some(low), Some(high)) if single => (0..=DENSE)
                .map(|k| low * (high / low).powf(k as f64 / DENSE as f64))
                .collect(),
            _ => f.clone(),
        };
        let fitted: Option<Vec<_>> = self
            .fit
            .map(|fit| at.iter().map(|f| fit.model.response(*f)).collect());
        if let Some(fitted) = &fitted {
            let y: Vec<f64> = fitted.iter().map(|s| s.norm()).collect();
            plot = plot.series(Series::line("model", &at, &y));
        }
        plot = plot.below(Axis::linear("phase", "°")).series(drawn(
            "",
            &phase,
            &band(&phase, |u| u.1.min(180.0), -1.0),
            &band(&phase, |u| u.1.min(180.0), 1.0),
        ));
        if let Some(fitted) = &fitted {
            let y: Vec<f64> = fitted.iter().map(|s| s.arg().to_degrees()).collect();
            plot = plot.series(Series::line("", &at, &y));
        }
        let coherence = r.coherence.len() == r.lines();
        if coherence {
            let y: Vec<f64> = kept.iter().map(|k| r.coherence[*k]).collect();
            plot = plot
                .below(Axis::linear("coherence", "").range(0.0, 1.05))
                .series(Series::line("", &f, &y));
        }
        let shown = if coherence {
            "Modulus, phase and coherence"
        } else {
            "Modulus and phase"
        };
        let bands = if single {
            "bars are 95 % intervals of each point"
        } else {
            "bands are 95 % intervals of each line"
        };
        Section::new("Frequency response").figure(format!("{shown}; {bands}"), plot)
    }

    /// Whether these are points of their own and not lines of a spectrum: nothing is drawn between them.
    fn single(&self) -> bool {
        self.response.coherence.is_empty() && self.response.lines() <= FEW
    }

    fn nyquist(&self) -> Section {
        let kept = self.kept();
        let part = |pick: fn(&num_complex::Complex64) -> f64| -> Vec<f64> {
            kept.iter()
                .map(|k| pick(&self.response.value[*k]))
                .collect()
        };
        let plot = XyPlot::new(
            Axis::linear("real part", self.unit),
            Axis::linear("imaginary part", self.unit),
        )
        .series(Series::line("", &part(|z| z.re), &part(|z| z.im)).style(
            if self.single() {
                Style::Markers
            } else {
                Style::LineAndMarkers
            },
        ));
        Section::new("Nyquist plot").figure("The response in the complex plane", plot)
    }
}

fn fitted(fit: &ModelFit) -> Table {
    let table = parameters("Parameters of the model", &fit.estimate.quantities());
    table.note(format!(
        "χ² = {:.1} with {} degrees of freedom, {} at most; misfit {} % of the modulus.",
        fit.chi_square,
        fit.freedom,
        plain(fit.limit),
        two_digits(100.0 * fit.misfit)
    ))
}

fn modes(modes: &[Resonance]) -> Table {
    let mut table = Table::new(
        "Resonances",
        [
            Column::number("frequency", "Hz"),
            Column::number("damping ratio", "%"),
            Column::number("coherence", ""),
        ],
    );
    for m in modes {
        table = table.row([
            Cell::number(concise(m.frequency, m.frequency_uncertainty)),
            Cell::number(concise(100.0 * m.damping, 100.0 * m.damping_uncertainty)),
            m.coherence
                .map_or(Cell::Empty, |c| Cell::number(format!("{c:.4}"))),
        ]);
    }
    table
}

fn bandwidths(figures: &ResponseFigures, unit: &str) -> Table {
    let mut table = Table::new(
        "Band within a departure",
        [
            Column::text("departure"),
            Column::number("from", "Hz"),
            Column::number("to", "Hz"),
        ],
    );
    for b in &figures.bandwidths {
        let name = if b.departure < 0.0 {
            "−3 dB".to_owned()
        } else {
            format!("±{:.0} %", 100.0 * b.departure)
        };
        let cell = |v: Option<f64>| v.map_or(Cell::Empty, |v| Cell::number(plain(v)));
        table = table.row([Cell::text(name), cell(b.lower), cell(b.upper)]);
    }
    let mut note = format!(
        "Of the modulus {:.6} {unit} at {} Hz; an empty place: the band is not left there.",
        figures.reference,
        plain(figures.reference_frequency)
    );
    if let Some((f, gain)) = figures.resonance {
        note.push_str(&format!(
            " Greatest modulus {gain:.2} times that, at {} Hz.",
            plain(f)
        ));
    }
    table.note(note)
}

fn residuals(fit: &ModelFit) -> Section {
    let column = |i: usize, sign: f64| -> Vec<f64> {
        fit.residuals.iter().map(|r| sign * 100.0 * r[i]).collect()
    };
    let f: Vec<f64> = fit.residuals.iter().map(|r| r[0]).collect();
    let zero = vec![0.0; f.len()];
    let plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::linear("measured − model", "% of modulus"),
    )
    .series(
        Series::line("two standard uncertainties of a line", &f, &zero)
            .band(&column(3, -1.0), &column(3, 1.0)),
    )
    .series(Series::markers("real part", &f, &column(1, 1.0)))
    .series(Series::markers("imaginary part", &f, &column(2, 1.0)));
    Section::new("Residuals of the model").figure("Residuals of the model", plot)
}

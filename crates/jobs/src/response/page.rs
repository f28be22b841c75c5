//! The report of a frequency response.

use super::ResponseOutcome;
use crate::page::columns::{filed, number};
use crate::page::parameters::parameters;
use crate::page::polar::continuous;
use proofmass_dynamic::measured::ResponsePower;
use proofmass_dynamic::model::{Bandwidth, DampingReading, ModelFit, ResponseFigures};
use proofmass_dynamic::modes::Resonance;
use proofmass_report::Rounding::Plain;
use proofmass_report::number::{plain, scientific, two_digits};
use proofmass_report::plot::Style;
use proofmass_report::{Axis, Field, KeyFigure, Report, Section, Series, Table, XyPlot};
use proofmass_signal::Trace;
use proofmass_uncertainty::student_quantile;

/// Points that a curve in the complex plane shows.
const SHOWN: usize = 1500;
/// Points up to which they are drawn one by one.
const FEW: usize = 100;
/// Steps of the curve of a model beside them.
const DENSE: usize = 600;

pub(super) fn add(page: Report, outcome: &ResponseOutcome) -> Report {
    let judged = outcome.judged.as_ref();
    let mut page = match judged {
        Some(judged) => page
            .verdict(format!("{} {}", judged.verdict(), outcome.verdict()))
            .section(judged.section()),
        None => page.verdict(outcome.verdict()),
    };
    page = page
        .section(outcome.result())
        .section(outcome.bode())
        .section(outcome.nyquist());
    let mut files = vec![outcome.lines()];
    files.extend(judged.map(|j| j.table()));
    if let Some(power) = &outcome.power {
        page = page.section(outcome.densities(power));
        files.push(
            Table::of(
                "",
                [
                    Field::series("frequency_Hz", &power.frequency),
                    Field::series("input_U2/Hz", &power.input),
                    Field::series("output_U2/Hz", &power.output),
                ],
                0..power.frequency.len(),
            )
            .file("densities.csv"),
        );
    }
    if let Some(fit) = &outcome.fit {
        page = page.section(residuals(fit));
    }
    page.section(Section::filed(files))
}

impl ResponseOutcome {
    /// Whether the model describes the response, or what was read from it without one.
    fn verdict(&self) -> String {
        if let Some(fit) = &self.fit {
            let (word, sign) = match fit.chi_square <= fit.limit {
                true => ("describes", "within"),
                false => ("does not describe", "above"),
            };
            return format!(
                "The model {word} the response: χ² = {:.1}, {sign} the limit of {:.1} (one in a thousand by chance).",
                fit.chi_square, fit.limit
            );
        }
        self.what_was_read()
    }

    fn result(&self) -> Section {
        let r = &self.response;
        let lines = if self.single() { "points" } else { "lines" };
        let mut count = KeyFigure::new(lines, r.lines().to_string(), "");
        if let (Some(low), Some(high)) = (r.frequency.first(), r.frequency.last()) {
            count = count.note(format!("{} Hz to {} Hz", plain(*low), plain(*high)));
        }
        let mut figures = vec![count];
        if self.independent > 0.0 {
            let averages = format!("{:.1}", self.independent);
            figures.push(KeyFigure::new("independent averages", averages, ""));
        }
        let coherence = || r.coherence.iter().copied();
        if let (Some(low), Some(high)) = (
            coherence().min_by(f64::total_cmp),
            coherence().max_by(f64::total_cmp),
        ) {
            let range = format!("{low:.4} … {high:.4}");
            figures.push(KeyFigure::new("coherence", range, ""));
        }
        if let Some(power) = &self.power {
            let sides = ["RMS of the input", "RMS of the output"].into_iter();
            for ((side, rms), (_, unit)) in sides.zip(power.rms).zip(&self.channels) {
                figures.push(KeyFigure::new(side, format!("{rms:.4}"), unit));
            }
        }
        let mut section = Section::new("Result").key_figures(figures).summarised();
        if let Some(fit) = &self.fit {
            section = section.table(fitted(fit));
        }
        if !self.modes.is_empty() {
            section = section.table(self.resonances());
        }
        if let Some(figures) = &self.figures {
            section = section.table(bandwidths(figures, &self.unit));
            if !figures.damping.is_empty() {
                section = section.table(damping(figures));
            }
        }
        section
    }

    /// Every line, with the uncertainty of the input.
    fn lines(&self) -> Table {
        let (r, unit) = (&self.response, &self.unit);
        let modulus = |k: &usize| r.value[*k].norm();
        let u = |k: &usize| self.modulus_uncertainty(*k);
        let fields = [
            Field::series("frequency_Hz", &r.frequency),
            filed(format!("modulus_{unit}"), modulus),
            filed("phase_deg", |k: &usize| r.value[*k].arg().to_degrees()),
            filed(format!("modulus_u_{unit}"), u),
            filed("phase_u_deg", |k: &usize| {
                r.polar_uncertainty(*k).1.to_degrees()
            }),
            filed(format!("modulus_U95_{unit}"), move |k: &usize| {
                student_quantile(0.975, r.dof[*k]) * u(k)
            }),
            Field::series("coherence", &r.coherence),
            Field::series("dof", &r.dof),
        ];
        Table::of("", fields, 0..r.lines()).file("response.csv")
    }

    fn densities(&self, power: &ResponsePower) -> Section {
        let f = &power.frequency;
        let positive = |v: &[f64]| -> (Vec<f64>, Vec<f64>) {
            f.iter()
                .zip(v)
                .filter(|(f, v)| **f > 0.0 && **v > 0.0)
                .unzip()
        };
        let [(input, unit_in), (output, unit_out)] = &self.channels;
        let (fx, x) = positive(&power.input);
        let (fy, y) = positive(&power.output);
        let plot = XyPlot::new(
            Axis::log("frequency", "Hz"),
            Axis::log(input, format!("({unit_in})²/Hz")),
        )
        .series(Series::line("", &fx, &x))
        .below(Axis::log(output, format!("({unit_out})²/Hz")))
        .series(Series::line("", &fy, &y));
        Section::new("Densities").figure("One-sided densities of input and output", plot)
    }

    fn kept(&self) -> Vec<usize> {
        let drawn = |k: &usize| self.response.value[*k].norm() > 0.0;
        (0..self.response.lines()).filter(drawn).collect()
    }

    fn bode(&self) -> Section {
        let r = &self.response;
        let kept = self.kept();
        let f: Vec<f64> = kept.iter().map(|k| r.frequency[*k]).collect();
        let modulus: Vec<f64> = kept.iter().map(|k| r.value[*k].norm()).collect();
        let expanded: Vec<(f64, f64)> = kept
            .iter()
            .map(|k| {
                let (u, turn) = (self.modulus_uncertainty(*k), r.polar_uncertainty(*k).1);
                let t = student_quantile(0.975, r.dof[*k]);
                (t * u, t * turn.to_degrees())
            })
            .collect();
        let phase: Vec<f64> = kept
            .iter()
            .map(|k| r.value[*k].arg().to_degrees())
            .collect();
        // What the input does not explain turns no further.
        let phase = continuous(&phase, |k| {
            let coherence = r.coherence.get(kept[k]).copied();
            match super::answer::explained(coherence, self.independent) {
                true => expanded[k].1,
                false => f64::INFINITY,
            }
        });
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
            Axis::log("modulus", &self.unit),
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
            .as_ref()
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
            plot = plot.series(Series::line("", &at, &continuous(&y, |_| 0.0)));
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
        // Of each run of lines the ends and the extremes of the modulus: a resonance is a loop with its top.
        let kept = self.kept();
        let modulus: Vec<f64> = kept
            .iter()
            .map(|k| self.response.value[*k].norm())
            .collect();
        let number: Vec<f64> = kept.iter().map(|k| *k as f64).collect();
        let thinned = Trace::new(&number, &modulus, SHOWN / 4).x;
        let kept: Vec<usize> = thinned.into_iter().map(|k| k as usize).collect();
        let part = |pick: fn(&num_complex::Complex64) -> f64| -> Vec<f64> {
            kept.iter()
                .map(|k| pick(&self.response.value[*k]))
                .collect()
        };
        let plot = XyPlot::new(
            Axis::linear("real part", &self.unit),
            Axis::linear("imaginary part", &self.unit),
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

impl ResponseOutcome {
    fn resonances(&self) -> Table {
        let fields = [
            Field::estimate("frequency_Hz", "u_Hz", |m: &Resonance| {
                Some((m.frequency, m.frequency_uncertainty))
            })
            .page("frequency", "Hz"),
            Field::estimate("damping", "u", |m: &Resonance| {
                Some((m.damping, m.damping_uncertainty))
            })
            .page("damping ratio", "%")
            .scaled(100.0),
            filed("coherence", |m: &Resonance| m.coherence)
                .page("coherence", "")
                .decimals(4),
            Field::shown("supported by the data", "", |m: &Resonance| {
                if self.supported(m) { "yes" } else { "no" }.into()
            }),
        ];
        Table::of("Resonances", fields, &self.modes).file("modes.csv")
    }
}

fn damping(figures: &ResponseFigures) -> Table {
    let fields = [
        Field::shown("from", "", |d: &DampingReading| d.method.as_str().into()),
        Field::estimate("", "", |d: &DampingReading| {
            Some((d.damping, d.standard_uncertainty))
        })
        .page("ζ", ""),
    ];
    let caption = "Damping ratio, each way by itself";
    Table::of(caption, fields, &figures.damping)
}

fn bandwidths(figures: &ResponseFigures, unit: &str) -> Table {
    let departure = |b: &Bandwidth| match b.departure < 0.0 {
        true => "−3 dB".to_owned(),
        false => format!("±{:.0} %", 100.0 * b.departure),
    };
    let fields = [
        Field::shown("departure", "", |b: &Bandwidth| departure(b).into()),
        number("", ("from", "Hz"), Plain, |b: &Bandwidth| b.lower),
        number("", ("to", "Hz"), Plain, |b: &Bandwidth| b.upper),
    ];
    let table = Table::of("Band within a departure", fields, &figures.bandwidths);
    let mut note = format!(
        "Of the modulus {} {unit} at {} Hz; an empty place: the band is not left there.",
        scientific(figures.reference, 4),
        plain(figures.reference_frequency)
    );
    if let Some((f, gain)) = figures.resonance {
        note.push_str(&format!(
            " Greatest modulus {} times that, at {} Hz.",
            scientific(gain, 3),
            scientific(f, 4)
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

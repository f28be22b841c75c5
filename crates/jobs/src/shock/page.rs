//! The report of a shock.

use proofmass_dynamic::shock::{
    Pulse, PulseMeasures, ShockCalibration, SpectrumToleranceResult, ToleranceResult,
};
use proofmass_report::number::{concise, plain, two_digits};
use proofmass_report::{
    Axis, Cell, Column, Head, KeyFigure, Report, Section, Series, Table, XyPlot,
};
use proofmass_signal::{Extremes, Trace};
use std::f64::consts::TAU;

/// Shock response spectra of one channel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShockSpectrumCurves<'a> {
    /// Channel.
    pub name: &'a str,
    /// Unit of the acceleration.
    pub unit: &'a str,
    /// Natural frequencies, Hz.
    pub frequency: &'a [f64],
    /// Extremes of the absolute acceleration.
    pub acceleration: &'a [Extremes],
    /// Extremes of the relative displacement.
    pub displacement: &'a [Extremes],
    /// Standard uncertainties of the greatest absolute values; none where they are not known.
    pub uncertainty: &'a [f64],
}

/// What the report tells of a shock.
#[derive(Clone, Debug)]
pub(crate) struct ShockReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Samples per second.
    pub rate: f64,
    /// Quality factor of the oscillators.
    pub quality: f64,
    /// Name, unit, trace of each channel, the reference first.
    pub traces: Vec<(&'a str, &'a str, &'a Trace)>,
    /// Where the pulse lies in the first channel.
    pub pulse: &'a Pulse,
    /// Its measures.
    pub measures: &'a PulseMeasures,
    /// Calibration, where there is a reference.
    pub calibration: Option<&'a ShockCalibration>,
    /// Verdict on the tolerance, where there is one.
    pub tolerance: Option<&'a ToleranceResult>,
    /// What is required of the first spectrum at its frequencies (zero where nothing is), and the verdict.
    pub spectrum_tolerance: Option<(&'a [f64], &'a SpectrumToleranceResult)>,
    /// Spectra, the reference first.
    pub spectra: Vec<ShockSpectrumCurves<'a>>,
}

impl ShockReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self) -> Report {
        let mut report = self.summary().section(self.time());
        for (k, spectra) in self.spectra.iter().enumerate() {
            let judged = self.spectrum_tolerance.filter(|_| k == 0);
            report = report.section(self.spectrum(spectra, judged));
        }
        if let Some(calibration) = self.calibration
            && calibration.lines.len() > 1
        {
            report = report.section(lines(calibration));
        }
        report.foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self) -> Report {
        let report = self.head.open();
        let unit = self.traces.first().map_or("", |t| t.1);
        let m = self.measures;
        let peak = match m.peak_uncertainty {
            Some(u) => concise(m.peak, u),
            None => plain(m.peak),
        };
        let mut figures = vec![KeyFigure::new("peak", peak, unit)];
        if let Some(d) = m.duration {
            figures.push(
                KeyFigure::new("duration", format!("{:.4}", 1e3 * d), "ms")
                    .note("at a tenth of the peak"),
            );
        }
        if let Some(v) = m.velocity_change {
            figures.push(KeyFigure::new(
                "velocity change",
                format!("{v:.5}"),
                format!("{unit}·s").replace("m/s²·s", "m/s"),
            ));
        }
        let mut section = Section::new("Result").key_figures(figures);
        if let Some(calibration) = self.calibration {
            section = section.table(sensitivities(calibration));
        }
        section = section.table(self.table());
        report
            .findings(self.head.findings.iter().cloned())
            .section(section)
    }

    fn table(&self) -> Table {
        let unit = self.traces.first().map_or("", |t| t.1);
        let m = self.measures;
        let mut table = Table::new(
            "Measures of the pulse",
            [
                Column::text("measure"),
                Column::number("value", ""),
                Column::text("unit"),
            ],
        );
        let mut row = |name: &str, value: Option<String>, unit: &str| {
            let value = value.map_or(Cell::Empty, Cell::number);
            table = std::mem::take(&mut table).row([Cell::text(name), value, Cell::text(unit)]);
        };
        row(
            "instant of the peak",
            Some(format!("{:.6}", m.peak_time)),
            "s",
        );
        row(
            "rise from 10 % to 90 %",
            m.rise_time.map(|t| format!("{:.4}", 1e3 * t)),
            "ms",
        );
        row(
            "overshoot to the other side",
            m.overshoot.map(|o| format!("{:.2}", 100.0 * o)),
            "% of peak",
        );
        row("zero shift", m.zero_shift.map(|(z, u)| concise(z, u)), unit);
        row(
            "ringing after the pulse",
            m.ringing.map(|r| format!("{:.1}", 100.0 * r.0)),
            "% of peak",
        );
        row(
            "its frequency",
            m.ringing.map(|r| format!("{:.0}", r.1)),
            "Hz",
        );
        row(
            "noise before the pulse",
            Some(two_digits(self.pulse.noise)),
            unit,
        );
        row("samples within the pulse", Some(m.samples.to_string()), "");
        if let Some(t) = self.tolerance {
            row(
                "largest departure from the nominal pulse",
                Some(format!("{:.1}", 100.0 * t.largest_departure)),
                "% of peak",
            );
            row(
                "velocity change against the nominal one",
                t.velocity_departure.map(|d| format!("{:+.1}", 100.0 * d)),
                "%",
            );
            let verdict = if t.kept { "kept" } else { "missed" };
            table = table.row([Cell::text("tolerance"), Cell::text(verdict), Cell::Empty]);
        }
        if let Some((_, t)) = self.spectrum_tolerance {
            let [low, high] = t.departure;
            let [from, to] = t.tolerance.band;
            let rows = [
                (
                    "least departure of the spectrum",
                    format!("{low:+.2}"),
                    "dB",
                ),
                (
                    "greatest departure of the spectrum",
                    format!("{high:+.2}"),
                    "dB",
                ),
                (
                    "frequencies within its band",
                    format!("{} of {}", t.within, t.compared),
                    "",
                ),
                (
                    "within their uncertainty of a limit",
                    t.close.to_string(),
                    "",
                ),
            ];
            for (name, value, unit) in rows {
                table = table.row([Cell::text(name), Cell::number(value), Cell::text(unit)]);
            }
            let verdict = if t.kept { "kept" } else { "missed" };
            table = table
                .row([
                    Cell::text("tolerance of the spectrum"),
                    Cell::text(verdict),
                    Cell::Empty,
                ])
                .note(
                    format!(
                        "Tolerance of the spectrum: {from:+} dB to {to:+} dB at {} % of the frequencies at least, {:+} dB to {:+} dB at the others.",
                        100.0 * t.tolerance.share,
                        t.tolerance.rest[0],
                        t.tolerance.rest[1]
                    )
                    .replace('-', "−"),
                );
        }
        table
    }

    fn time(&self) -> Section {
        let mut section = Section::new("Time history");
        let (from, to) = self.window();
        let mut plot: Option<XyPlot> = None;
        for (name, unit, trace) in &self.traces {
            let axis = Axis::linear(*name, *unit);
            let series = Series::line("", &trace.x, &trace.y);
            plot = Some(match plot {
                None => XyPlot::new(Axis::linear("time", "s"), axis).series(series),
                Some(plot) => plot.below(axis).series(series),
            });
        }
        if let Some(mut plot) = plot {
            if let Some(t) = self.tolerance {
                plot = self.with_band(plot, t);
            }
            section = section.figure("The whole record", plot.clone());
            plot.x = plot.x.range(from, to);
            section = section.figure("The pulse", plot);
        }
        section
    }

    fn with_band(&self, mut plot: XyPlot, t: &ToleranceResult) -> XyPlot {
        let tolerance = t.tolerance;
        let x: Vec<f64> = (0..=240)
            .map(|k| t.nominal_start + tolerance.duration * (f64::from(k) / 100.0 - 0.4))
            .collect();
        let y: Vec<f64> = x
            .iter()
            .map(|x| {
                let s = (x - t.nominal_start) / tolerance.duration;
                self.pulse.baseline + self.pulse.sign * tolerance.peak * tolerance.shape.at(s)
            })
            .collect();
        let half = tolerance.band * tolerance.peak;
        let low: Vec<f64> = y.iter().map(|y| y - half).collect();
        let high: Vec<f64> = y.iter().map(|y| y + half).collect();
        if let Some(panel) = plot.panels.first_mut() {
            panel
                .series
                .push(Series::line("nominal pulse and tolerance", &x, &y).band(&low, &high));
        }
        plot
    }

    fn window(&self) -> (f64, f64) {
        let last = self
            .traces
            .first()
            .and_then(|t| t.2.x.last().copied())
            .unwrap_or(1.0);
        let start = self.pulse.start.map_or(0.0, |s| s / self.rate);
        let end = self.pulse.end.map_or(last, |e| e / self.rate);
        let duration = (end - start).max(1.0 / self.rate);
        (
            (start - duration).max(0.0),
            (end + 4.0 * duration).min(last).max(end),
        )
    }

    fn spectrum(
        &self,
        s: &ShockSpectrumCurves<'_>,
        judged: Option<(&[f64], &SpectrumToleranceResult)>,
    ) -> Section {
        let positive = |values: Vec<f64>| -> (Vec<f64>, Vec<f64>) {
            s.frequency
                .iter()
                .copied()
                .zip(values)
                .filter(|(_, v)| *v > 0.0)
                .unzip()
        };
        let of =
            |f: &dyn Fn(&Extremes) -> f64| -> Vec<f64> { s.acceleration.iter().map(f).collect() };
        let line = |name: &str, values: Vec<f64>| {
            let (x, y) = positive(values);
            Series::line(name, &x, &y)
        };
        let (peaks, u) = (of(&Extremes::maximax), s.uncertainty);
        let mut maximax = line("maximax", peaks.clone());
        if u.len() == peaks.len() && peaks.iter().all(|p| *p > 0.0) {
            let edge = |sign: f64| -> Vec<f64> {
                let pairs = peaks.iter().zip(u);
                // Nothing below a hundredth, which a logarithmic axis has no place for.
                pairs
                    .map(|(p, u)| (p + sign * 1.96 * u).max(0.01 * p))
                    .collect()
            };
            maximax = maximax.band(&edge(-1.0), &edge(1.0));
        }
        let pseudo: Vec<f64> = s
            .frequency
            .iter()
            .zip(s.displacement)
            .map(|(f, x)| TAU * f * x.maximax())
            .collect();
        let mut plot = XyPlot::new(
            Axis::log("natural frequency", "Hz"),
            Axis::log("absolute acceleration", s.unit),
        )
        .series(maximax);
        if let Some((required, verdict)) = judged {
            let (x, y) = positive(required.to_vec());
            let edge = |limit: f64| -> Vec<f64> {
                y.iter().map(|r| r * 10f64.powf(limit / 20.0)).collect()
            };
            let [low, high] = verdict.tolerance.band;
            plot = plot.series(Series::line("required", &x, &y).band(&edge(low), &edge(high)));
        }
        let plot = plot
            .series(line("primary", of(&Extremes::primary_maximax)))
            .series(line("residual", of(&Extremes::residual_maximax)))
            .series(line("negative", of(&|e| -e.min())))
            .below(Axis::log(
                "pseudo-velocity",
                format!("{}·s", s.unit).replace("m/s²·s", "m/s"),
            ))
            .series(line("", pseudo));
        let shares = s.acceleration.iter().zip(s.uncertainty);
        let shares: Vec<f64> = shares
            .filter(|(e, _)| e.maximax() > 0.0)
            .map(|(e, u)| 196.0 * u / e.maximax())
            .collect();
        let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
        let most = shares.iter().copied().fold(0.0, f64::max);
        let mut section = Section::new(format!("Shock response spectrum of {}", s.name));
        if least.is_finite() {
            section = section.paragraph(format!(
                "Expanded uncertainty (95 %) of the maximax from scale, noise and sampling: {} % to {} %, point by point in the table.",
                two_digits(least),
                two_digits(most)
            ));
        }
        section.figure(
            format!("Extremes of oscillators with Q = {}", plain(self.quality)),
            plot,
        )
    }
}

fn sensitivities(calibration: &ShockCalibration) -> Table {
    let unit = calibration
        .estimate
        .components()
        .first()
        .map_or("", |c| c.unit.as_str());
    let mut table = Table::new(
        "Sensitivity",
        [
            Column::text("by"),
            Column::number("S", unit),
            Column::number("U (95 %)", "%"),
        ],
    );
    for q in calibration.estimate.quantities() {
        let relative = 100.0 * (q.expanded(0.95) / q.value).abs();
        let name = q.name.trim_start_matches("sensitivity.").to_owned();
        table = table.row([
            Cell::text(name),
            Cell::Quantity(q),
            Cell::number(two_digits(relative)),
        ]);
    }
    if let Some((delay, u)) = calibration.delay {
        table = table.note(format!(
            "The output follows the reference by {} µs.",
            concise(1e6 * delay, 1e6 * u)
        ));
    }
    table
}

fn lines(calibration: &ShockCalibration) -> Section {
    let frequency: Vec<f64> = calibration.lines.iter().map(|l| l.frequency).collect();
    let modulus: Vec<f64> = calibration.lines.iter().map(|l| l.value().norm()).collect();
    let band = |sign: f64| -> Vec<f64> {
        calibration
            .lines
            .iter()
            .map(|l| l.value().norm() * (1.0 + sign * 2.0 * l.relative_uncertainty))
            .collect()
    };
    let phase: Vec<f64> = calibration
        .lines
        .iter()
        .map(|l| l.value().arg().to_degrees())
        .collect();
    let unit = calibration
        .estimate
        .components()
        .first()
        .map_or("", |c| c.unit.as_str());
    let plot = XyPlot::new(Axis::log("frequency", "Hz"), Axis::linear("|S|", unit))
        .series(Series::line("", &frequency, &modulus).band(&band(-1.0), &band(1.0)))
        .below(Axis::linear("phase", "°"))
        .series(Series::line("", &frequency, &phase));
    Section::new("Sensitivity over the pulse's spectrum").figure(
        "Output over reference at the lines of the pulse's spectrum; the band is two standard uncertainties of the noise",
        plot,
    )
}

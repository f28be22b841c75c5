//! The page of a shock.

use super::{ShockOutcome, ShockSpectra, SpectrumVerdict, integral_unit};
use crate::page::columns::{coverage_factor, filed};
use crate::page::measures::measures;
use crate::page::polar::continuous;
use proofmass_dynamic::shock::{ShockCalibration, SpectrumLine, ToleranceResult};
use proofmass_report::number::{concise, plain, two_digits};
use proofmass_report::{
    Axis, Cell, Field, KeyFigure, Report, Section, Series, Table, XyPlot, scientific,
};
use proofmass_signal::Extremes;
use proofmass_uncertainty::Quantity;
use std::f64::consts::TAU;

pub(super) fn add(page: Report, shock: &ShockOutcome) -> Report {
    let mut page = page
        .verdict(verdict(shock))
        .section(result(shock).summarised())
        .section(time(shock));
    let names: &[&str] = match shock.spectra().len() {
        1 => &["srs.csv"],
        _ => &["srs_reference.csv", "srs_output.csv"],
    };
    for (k, spectra) in shock.spectra().iter().enumerate() {
        let judged = shock.spectrum_tolerance().filter(|_| k == 0);
        page = page.section(spectrum(spectra, judged, shock.request.quality));
    }
    let spectra = shock.spectra().iter().zip(names);
    page = page.section(Section::filed(spectra.map(|(s, name)| srs(s).file(*name))));
    if let Some(c) = shock.shock_calibration().filter(|c| !c.lines.is_empty()) {
        if c.lines.len() > 1 {
            page = page.section(lines(c));
        }
        page = page.section(Section::filed([line_table(c)]));
    }
    page
}

/// The unit in which the pulse was measured, and the unit of its integral.
fn units(shock: &ShockOutcome) -> (&str, String) {
    let unit = shock.channels.first().map_or("", |c| c.unit.as_str());
    (unit, integral_unit(unit))
}

fn result(shock: &ShockOutcome) -> Section {
    let (unit, integral) = units(shock);
    let m = shock.measures();
    let peak = match m.peak_uncertainty {
        Some(u) if u > 0.0 => concise(m.peak, u),
        // Nobody states an uncertainty: four digits, and no claim.
        _ => scientific(m.peak, 4),
    };
    let mut figures = vec![KeyFigure::new("peak", peak, unit)];
    figures.extend(m.duration.map(|d| {
        KeyFigure::new("duration", scientific(1e3 * d, 4), "ms").note("at a tenth of the peak")
    }));
    let change = m.velocity_change;
    figures.extend(change.map(|v| KeyFigure::new("velocity change", scientific(v, 4), integral)));
    let mut section = Section::new("Result").key_figures(figures);
    if let Some(calibration) = shock.shock_calibration() {
        section = section.table(sensitivities(calibration));
    }
    section.table(pulse(shock))
}

/// A tolerance that was asked for and could not be judged: a finding says why.
const NOT_JUDGED: &str = "not judged";

/// Whether the tolerances that were asked for are kept, and whether the ways to the sensitivity agree.
fn verdict(shock: &ShockOutcome) -> String {
    let mut says = Vec::new();
    let kept = |kept: bool| if kept { "kept" } else { "missed" };
    // A nominal pulse asks for both.
    if shock.request.tolerance.is_some() {
        let of_pulse = shock.tolerance().map_or(NOT_JUDGED, |t| kept(t.kept));
        says.push(format!("Tolerance of the pulse: {of_pulse}"));
    }
    if shock.request.tolerance.is_some() || !shock.request.required.is_empty() {
        let of_spectrum = shock.spectrum_tolerance();
        let of_spectrum = of_spectrum.map_or(NOT_JUDGED, |t| kept(t.result.kept));
        let the = if says.is_empty() {
            "Tolerance"
        } else {
            "tolerance"
        };
        says.push(format!("{the} of the shock spectrum: {of_spectrum}"));
    }
    let ways = shock.shock_calibration().map(|c| c.estimate.quantities());
    if let Some([first, others @ ..]) = ways.as_deref() {
        let of = match shock.request.reference.relative_uncertainty {
            0.0 => "of noise alone: no uncertainty of the reference is stated",
            _ => "of noise and reference",
        };
        says.push(format!(
            "Sensitivity by peak known to U = {} % (95 %), {of}",
            two_digits(100.0 * (first.expanded(0.95) / first.value).abs())
        ));
        // What the three have of the device itself is no error of one of them.
        let apart = others.iter().map(|q| (q.value / first.value - 1.0).abs());
        let apart = apart.fold(0.0, f64::max);
        if !others.is_empty() {
            says.push(format!(
                "by integral or spectrum it differs by up to {} %, since they weigh what the device does not follow otherwise",
                two_digits(100.0 * apart)
            ));
        }
    }
    match says.is_empty() {
        true => String::new(),
        false => format!("{}.", says.join("; ")),
    }
}

fn pulse(shock: &ShockOutcome) -> Table {
    let (unit, _) = units(shock);
    let m = shock.measures();
    let maybe = |text: Option<String>| text.map_or(Cell::Empty, Cell::number);
    let percent = |share: Option<f64>, digits: usize| {
        maybe(share.map(|s| format!("{:.*}", digits, 100.0 * s)))
    };
    let verdict = |kept: bool| Cell::text(if kept { "kept" } else { "missed" });
    let share = "% of peak";
    let instant = Cell::number(format!("{:.6}", m.peak_time));
    let rise = maybe(m.rise_time.map(|t| format!("{:.4}", 1e3 * t)));
    let overshoot = percent(m.overshoot, 2);
    let shift = maybe(shock.zero_shift().map(|(z, u)| concise(z, u)));
    let of_device = shock.channels.last().map_or("", |c| c.unit.as_str());
    let back = shock.return_to_baseline();
    let returned = back.map_or(Cell::Empty, |b| match b.time {
        Some(t) => Cell::number(format!("{:.3}", 1e3 * t)),
        None => Cell::text(format!("not within {} ms", two_digits(1e3 * b.looked))),
    });
    let between = back.and_then(|b| b.interval);
    let between = maybe(between.map(|[a, b]| format!("{:.3} to {:.3}", 1e3 * a, 1e3 * b)));
    let band = maybe(back.map(|b| format!("± {}", two_digits(b.band))));
    let ringing = percent(m.ringing.map(|r| r.0), 1);
    // An oscillation within the noise has no frequency.
    let above = |(share, _): &(f64, f64)| share * m.peak.abs() > shock.pulse().noise;
    let frequency = m.ringing.filter(above);
    let frequency = maybe(frequency.map(|r| scientific(r.1, 3)));
    let noise = Cell::number(two_digits(shock.pulse().noise));
    let mut rows = vec![
        ("instant of the peak", instant, "s"),
        ("rise from 10 % to 90 %", rise, "ms"),
        ("overshoot to the other side", overshoot, share),
        ("zero shift of the device", shift, of_device),
        ("time to return to the baseline", returned, "ms"),
        ("with the noise", between, "ms"),
        ("into the band", band, of_device),
        ("ringing after the pulse", ringing, share),
        ("its frequency", frequency, "Hz"),
        ("noise before the pulse", noise, unit),
        ("samples within the pulse", m.samples.into(), ""),
    ];
    if let Some(t) = shock.tolerance() {
        let largest = percent(Some(t.largest_departure), 1);
        let change = t.velocity_departure.map(|d| format!("{:+.1}", 100.0 * d));
        let of_change = "velocity change against the nominal one";
        rows.extend([
            ("largest departure from the nominal pulse", largest, share),
            (of_change, maybe(change), "%"),
            ("tolerance", verdict(t.kept), ""),
        ]);
    }
    let mut note = None;
    if let Some(SpectrumVerdict { result: t, .. }) = shock.spectrum_tolerance() {
        let [low, high] = t.departure.map(|d| Cell::number(format!("{d:+.2}")));
        let within = Cell::number(format!("{} of {}", t.within, t.compared));
        rows.extend([
            ("least departure of the spectrum", low, "dB"),
            ("greatest departure of the spectrum", high, "dB"),
            ("frequencies within its band", within, ""),
            ("within their uncertainty of a limit", t.close.into(), ""),
            ("tolerance of the spectrum", verdict(t.kept), ""),
        ]);
        let ([from, to], [low, high]) = (t.tolerance.band, t.tolerance.rest);
        let text = format!(
            "Tolerance of the spectrum: {from:+} dB to {to:+} dB at {} % of the frequencies at least, {low:+} dB to {high:+} dB at the others.",
            100.0 * t.tolerance.share
        );
        note = Some(text.replace('-', "−"));
    }
    let mut table = measures("Measures of the pulse", "measure", rows);
    table.notes.extend(note);
    table
}

fn time(shock: &ShockOutcome) -> Section {
    let section = Section::new("Time history");
    let mut plot: Option<XyPlot> = None;
    for channel in &shock.channels {
        let axis = Axis::linear(&channel.name, &channel.unit);
        let series = Series::line("", &channel.trace.x, &channel.trace.y);
        plot = Some(match plot {
            None => XyPlot::new(Axis::linear("time", "s"), axis).series(series),
            Some(plot) => plot.below(axis).series(series),
        });
    }
    let Some(mut plot) = plot else {
        return section;
    };
    if let Some(t) = shock.tolerance() {
        plot = with_band(plot, shock, t);
    }
    // The first and last times of what was cut out.
    let times = || shock.channels.first().map(|c| &c.pulse.x);
    let ends = times().and_then(|x| Some((*x.first()?, *x.last()?)));
    let (from, to) = ends.filter(|(from, to)| from < to).unwrap_or((0.0, 1.0));
    let whole = plot.clone();
    for (panel, channel) in plot.panels.iter_mut().zip(&shock.channels) {
        // Thinned by itself: what stands for a pixel of the whole record would round the pulse off.
        if let Some(series) = panel.series.first_mut() {
            *series = Series::line("", &channel.pulse.x, &channel.pulse.y);
        }
    }
    plot.x = plot.x.range(from, to);
    section
        .figure("The pulse", plot)
        .figure("The whole record", whole)
}

fn with_band(mut plot: XyPlot, shock: &ShockOutcome, t: &ToleranceResult) -> XyPlot {
    let (pulse, tolerance) = (shock.pulse(), t.tolerance);
    let x: Vec<f64> = (0..=240)
        .map(|k| t.nominal_start + tolerance.duration * (f64::from(k) / 100.0 - 0.4))
        .collect();
    let nominal = |x: &f64| {
        let s = (x - t.nominal_start) / tolerance.duration;
        pulse.baseline + pulse.sign * tolerance.peak * tolerance.shape.at(s)
    };
    let y: Vec<f64> = x.iter().map(nominal).collect();
    let half = tolerance.band * tolerance.peak;
    let low: Vec<f64> = y.iter().map(|y| y - half).collect();
    let high: Vec<f64> = y.iter().map(|y| y + half).collect();
    if let Some(panel) = plot.panels.first_mut() {
        let series = Series::line("nominal pulse and tolerance", &x, &y);
        panel.series.push(series.band(&low, &high));
    }
    plot
}

fn pseudo_velocity(s: &ShockSpectra) -> Vec<f64> {
    let pairs = s.frequency.iter().zip(&s.relative_displacement);
    pairs.map(|(f, x)| TAU * f * x.maximax()).collect()
}

fn extremes(list: &[Extremes], of: impl Fn(&Extremes) -> f64) -> Vec<f64> {
    list.iter().map(of).collect()
}

fn srs(s: &ShockSpectra) -> Table {
    let unit = &s.unit;
    let a = |name: &str, of: fn(&Extremes) -> f64| {
        let values = extremes(&s.absolute_acceleration, of);
        Field::series(format!("{name}_{unit}"), values)
    };
    let u: Vec<f64> = s.maximax_uncertainty.iter().map(|u| 1.96 * u).collect();
    let fields = [
        Field::series("frequency_Hz", &s.frequency),
        a("maximax", Extremes::maximax),
        a("maximum", Extremes::max),
        a("minimum", Extremes::min),
        a("primary", Extremes::primary_maximax),
        a("residual", Extremes::residual_maximax),
        Field::series(
            format!("relative_displacement_{unit}*s2"),
            extremes(&s.relative_displacement, Extremes::maximax),
        ),
        Field::series(format!("pseudo_velocity_{unit}*s"), pseudo_velocity(s)),
        Field::series(format!("maximax_U95_{unit}"), u),
    ];
    Table::of("", fields, 0..s.frequency.len())
}

fn spectrum(s: &ShockSpectra, judged: Option<&SpectrumVerdict>, quality: f64) -> Section {
    let positive = |values: Vec<f64>| -> (Vec<f64>, Vec<f64>) {
        let pairs = s.frequency.iter().copied().zip(values);
        pairs.filter(|(_, v)| *v > 0.0).unzip()
    };
    let line = |name: &str, values: Vec<f64>| {
        let (x, y) = positive(values);
        Series::line(name, &x, &y)
    };
    let of = |f: fn(&Extremes) -> f64| extremes(&s.absolute_acceleration, f);
    let (peaks, u) = (of(Extremes::maximax), &s.maximax_uncertainty);
    let mut maximax = line("maximax", peaks.clone());
    if u.len() == peaks.len() && peaks.iter().all(|p| *p > 0.0) {
        // Nothing below a hundredth, which a logarithmic axis has no place for.
        let edge = |sign: f64| -> Vec<f64> {
            let pairs = peaks.iter().zip(u);
            pairs
                .map(|(p, u)| (p + sign * 1.96 * u).max(0.01 * p))
                .collect()
        };
        maximax = maximax.band(&edge(-1.0), &edge(1.0));
    }
    let mut plot = XyPlot::new(
        Axis::log("natural frequency", "Hz"),
        Axis::log("absolute acceleration", &s.unit),
    )
    .series(maximax);
    if let Some(SpectrumVerdict { required, result }) = judged {
        let (x, y) = positive(required.clone());
        let edge =
            |limit: f64| -> Vec<f64> { y.iter().map(|r| r * 10f64.powf(limit / 20.0)).collect() };
        let [low, high] = result.tolerance.band.map(edge);
        plot = plot.series(Series::line("required", &x, &y).band(&low, &high));
    }
    let plot = plot
        .series(line("primary", of(Extremes::primary_maximax)))
        .series(line("residual", of(Extremes::residual_maximax)))
        .series(line("negative", of(|e| -e.min())))
        .below(Axis::log("pseudo-velocity", integral_unit(&s.unit)))
        .series(line("", pseudo_velocity(s)));
    let shares = peaks.iter().zip(u).filter(|(p, _)| **p > 0.0);
    let (least, most) = shares
        .map(|(p, u)| 196.0 * u / p)
        .fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
    let mut section = Section::new(format!("Shock response spectrum of {}", s.name));
    if least.is_finite() {
        section = section.paragraph(format!(
            "Expanded uncertainty (95 %) of the maximax from scale, noise and sampling: {} % to {} %, point by point in the table.",
            two_digits(least),
            two_digits(most)
        ));
    }
    section.figure(
        format!("Extremes of oscillators with Q = {}", plain(quality)),
        plot,
    )
}

/// Unit of the sensitivity.
fn unit(calibration: &ShockCalibration) -> &str {
    let first = calibration.estimate.components().first();
    first.map_or("", |c| c.unit.as_str())
}

fn sensitivities(calibration: &ShockCalibration) -> Table {
    let name = |q: &Quantity| q.name.trim_start_matches("sensitivity.").to_owned();
    let relative = |q: &Quantity| two_digits(100.0 * (q.expanded(0.95) / q.value).abs());
    let fields = [
        Field::shown("by", "", |q: &Quantity| name(q).into()),
        Field::shown("S", unit(calibration), |q: &Quantity| {
            Cell::quantity(q.clone())
        }),
        Field::shown("U (95 %)", "%", |q: &Quantity| Cell::number(relative(q))),
        coverage_factor("", |q: &Quantity| q.coverage_factor(0.95)),
    ];
    let table = Table::of("Sensitivity", fields, calibration.estimate.quantities());
    match calibration.delay {
        Some((delay, u)) => table.note(format!(
            "The output follows the reference by {} µs.",
            concise(1e6 * delay, 1e6 * u)
        )),
        None => table,
    }
}

fn line_table(calibration: &ShockCalibration) -> Table {
    let fields = [
        filed("frequency_Hz", |l: &SpectrumLine| l.frequency),
        filed("modulus", |l: &SpectrumLine| l.value().norm()),
        filed("phase_deg", |l: &SpectrumLine| l.value().arg().to_degrees()),
        filed("relative_u", |l: &SpectrumLine| l.relative_uncertainty),
        filed("reference_spectrum_m/s", |l: &SpectrumLine| l.reference),
    ];
    Table::of("", fields, &calibration.lines).file("sensitivity_spectrum.csv")
}

fn lines(calibration: &ShockCalibration) -> Section {
    let of = |f: &dyn Fn(&SpectrumLine) -> f64| -> Vec<f64> {
        calibration.lines.iter().map(f).collect()
    };
    let band = |sign: f64| of(&|l| l.value().norm() * (1.0 + sign * 2.0 * l.relative_uncertainty));
    let frequency = of(&|l| l.frequency);
    let modulus = Series::line("", &frequency, &of(&|l| l.value().norm()));
    let phase = of(&|l| l.value().arg().to_degrees());
    let phase = continuous(&phase, |k| {
        (2.0 * calibration.lines[k].relative_uncertainty).to_degrees()
    });
    let plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::linear("|S|", unit(calibration)),
    )
    .series(modulus.band(&band(-1.0), &band(1.0)))
    .below(Axis::linear("phase", "°"))
    .series(Series::line("", &frequency, &phase));
    Section::new("Sensitivity over the pulse's spectrum").figure(
        "Output over reference at the lines of the pulse's spectrum; the band is two standard uncertainties of the noise",
        plot,
    )
}

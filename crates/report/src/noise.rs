//! The report of a noise analysis.

use crate::{Axis, Cell, Column, Head, Report, Section, Series, Table, XyPlot, scientific};
use proofmass_noise::{
    Analysis, ChannelAnalysis, Coefficient, DeviationCurve, Disturbance, DisturbanceKind,
    FittedPoint, NoiseType, Reason, TemperatureSensitivity, Term, Verdict,
};
use proofmass_signal::Trace;

/// What the report tells beside the analysis itself.
#[derive(Clone, Debug, Default)]
pub struct NoiseReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// What is drawn of each channel against time, in the order of the analysis.
    pub traces: &'a [Trace],
}

impl NoiseReport<'_> {
    /// The whole report.
    pub fn full(&self, analysis: &Analysis) -> Report {
        let mut report = self.summary(analysis);
        if let Some(section) = together(analysis) {
            report = report.section(section);
        }
        if let Some(section) = separated(analysis) {
            report = report.section(section);
        }
        for (i, channel) in analysis.channels.iter().enumerate() {
            report = report.section(channel_section(channel, self.traces.get(i)));
        }
        report.foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub fn summary(&self, analysis: &Analysis) -> Report {
        let channel = analysis.channels.first();
        let samples = channel.map_or(analysis.rows.1 - analysis.rows.0, |c| c.samples);
        let report = self.head.open().subtitle(format!(
            "{samples} samples at {} Hz, {} s",
            scientific(analysis.sample_rate, 6),
            scientific(samples as f64 / analysis.sample_rate, 5),
        ));
        let mut section = Section::new("Coefficients").table(coefficients(analysis));
        if let Some(table) = robust(analysis) {
            section = section.table(table);
        }
        report
            .section(section)
            .findings(self.head.findings.iter().cloned())
    }
}

/// The curves of all channels of one unit in one figure.
fn together(analysis: &Analysis) -> Option<Section> {
    let mut section = Section::new("All channels");
    let mut drawn = false;
    let mut seen: Vec<(&str, &str)> = Vec::new();
    for channel in &analysis.channels {
        let Some(curve) = &channel.curve else {
            continue;
        };
        let kind = (channel.unit.as_str(), curve.statistic.abbreviation());
        if seen.contains(&kind) {
            continue;
        }
        seen.push(kind);
        let same: Vec<(&ChannelAnalysis, &DeviationCurve)> = analysis
            .channels
            .iter()
            .filter(|c| c.unit == channel.unit)
            .filter_map(|c| Some((c, c.curve.as_ref()?)))
            .collect();
        if same.len() < 2 {
            continue;
        }
        let mut plot = XyPlot::new(
            Axis::log("averaging time τ", "s"),
            Axis::log(kind.1, deviation_unit(channel, curve)),
        )
        .height(380.0);
        for (channel, curve) in same {
            let points: Vec<_> = curve.points.iter().filter(|p| p.deviation > 0.0).collect();
            let tau: Vec<f64> = points.iter().map(|p| p.tau).collect();
            let value: Vec<f64> = points.iter().map(|p| p.deviation).collect();
            let side = |pick: fn((f64, f64)) -> f64| -> Vec<f64> {
                let of =
                    |p: &&proofmass_noise::DeviationPoint| p.interval.map_or(p.deviation, pick);
                points.iter().map(of).collect()
            };
            plot = plot.series(
                Series::line(channel.name.clone(), &tau, &value)
                    .bars(&side(|i| i.0), &side(|i| i.1)),
            );
        }
        section = section.figure(format!("{} of all channels in {}", kind.1, kind.0), plot);
        drawn = true;
    }
    drawn.then_some(section)
}

/// Three sensors by themselves.
fn separated(analysis: &Analysis) -> Option<Section> {
    let points = &analysis.separated;
    points.first()?;
    let unit = analysis.channels.first()?.unit.clone();
    let mut plot = XyPlot::new(
        Axis::log("averaging time τ", "s"),
        Axis::log("OADEV by itself", unit.clone()),
    );
    let mut table = Table::new(
        "Allan variance of each sensor by itself, with its standard uncertainty",
        [
            Column::text("sensor"),
            Column::number("τ", "s"),
            Column::number("variance", format!("({unit})²")),
            Column::number("u", format!("({unit})²")),
        ],
    );
    for k in 0..3 {
        let channel = analysis.channels.get(k);
        let name = channel.map_or_else(|| "reference".to_owned(), |c| c.name.clone());
        let positive: Vec<(f64, f64)> = points
            .iter()
            .filter_map(|p| Some((p.tau, p.deviation(k)?)))
            .collect();
        let (tau, value): (Vec<f64>, Vec<f64>) = positive.into_iter().unzip();
        plot = plot.series(Series::markers(name.clone(), &tau, &value));
        for p in points {
            table = table.row([
                Cell::text(name.clone()),
                Cell::number(scientific(p.tau, 4)),
                Cell::number(scientific(p.variances[k], 4)),
                Cell::number(scientific(p.uncertainties[k], 2)),
            ]);
        }
    }
    Some(
        Section::new("Sensors by themselves")
            .paragraph(
                "What all three share is left out: the covariance of the differences of one sensor to the two others. A variance below zero \
                 says that the sensor is quieter than its uncertainty.",
            )
            .figure("Allan deviations of the sensors by themselves", plot)
            .table(table),
    )
}

/// The curve over time: one line for every averaging time that all windows have, at most eight.
fn over_time(channel: &ChannelAnalysis) -> Option<XyPlot> {
    let windows = &channel.windows;
    let fewest = windows.iter().map(|w| w.curve.points.len()).min()?;
    let first = windows.first()?;
    let step = fewest.div_ceil(8).max(1);
    let mut plot = XyPlot::new(
        Axis::linear("middle of the window", "s"),
        Axis::log("OADEV", channel.unit.clone()),
    );
    let middle: Vec<f64> = windows.iter().map(|w| 0.5 * (w.from + w.to)).collect();
    for i in (0..fewest).step_by(step) {
        let at = |f: &dyn Fn(&proofmass_noise::DeviationPoint) -> f64| -> Vec<f64> {
            windows.iter().map(|w| f(&w.curve.points[i])).collect()
        };
        if at(&|p| p.deviation).iter().any(|v| *v <= 0.0) {
            continue;
        }
        let name = format!("τ = {} s", scientific(first.curve.points[i].tau, 3));
        plot = plot.series(Series::line(name, &middle, &at(&|p| p.deviation)).bars(
            &at(&|p| p.interval.map_or(p.deviation, |v| v.0)),
            &at(&|p| p.interval.map_or(p.deviation, |v| v.1)),
        ));
    }
    Some(plot)
}

/// Every coefficient of every channel: a number with its interval, or why there is none.
fn coefficients(analysis: &Analysis) -> Table {
    let fits = || analysis.channels.iter().filter_map(|c| c.whittle.as_ref());
    let probability = fits().next().map_or(0.95, |f| f.probability);
    let rate = fits().next().map_or(0.002, |f| f.false_alarm_rate);
    let mut table = Table::new(
        format!(
            "Noise coefficients with their {} % intervals, by maximum likelihood on the spectrum",
            scientific(100.0 * probability, 3).trim_end_matches(".0")
        ),
        [
            Column::text("channel"),
            Column::text("coefficient"),
            Column::text("value"),
            Column::text("interval, or limit"),
            Column::text("unit"),
            Column::text("in usual units"),
            Column::text("what it is"),
        ],
    );
    for channel in &analysis.channels {
        let Some(fit) = &channel.whittle else {
            table = table.row([
                Cell::text(channel.name.clone()),
                Cell::text("–"),
                Cell::text("none"),
                Cell::text("see the findings"),
                Cell::Empty,
                Cell::Empty,
                Cell::Empty,
            ]);
            continue;
        };
        for c in &fit.coefficients {
            let (value, interval, word) = words(&c.verdict);
            table = table.row([
                Cell::text(channel.name.clone()),
                Cell::text(name(c)),
                Cell::text(value),
                Cell::text(interval),
                Cell::text(c.unit.clone()),
                Cell::text(usual(channel, c)),
                Cell::text(word),
            ]);
        }
        if let Some(t) = &fit.temperature {
            let (value, interval, word) = words(&t.verdict);
            let lag = if t.lag > 0.0 {
                format!(", lag {} s", scientific(t.lag, 3))
            } else {
                String::new()
            };
            table = table.row([
                Cell::text(channel.name.clone()),
                Cell::text(format!("K_T sensitivity to temperature{lag}")),
                Cell::text(value),
                Cell::text(interval),
                Cell::text(t.unit.clone()),
                Cell::text(per_kelvin(t)),
                Cell::text(word),
            ]);
        }
    }
    table
        .note(
            "N is the Allan deviation at 1 s, a two-sided root density; the one-sided amplitude density of data \
             sheets is √2 N.",
        )
        .note("B is the coefficient; the floor of the Allan deviation is 0.664 B.")
        .note(format!(
            "All terms are fitted together and each interval allows for all others. Identified: one record in {} without the \
             term would show it so; present: its interval excludes zero; not identifiable: zero lies in the interval, whose upper \
             end is the limit.",
            scientific(1.0 / rate, 1).trim_end_matches(".0")
        ))
}

/// The sensitivity as data sheets give it.
fn per_kelvin(t: &TemperatureSensitivity) -> String {
    let (unit, factor) = match t.unit.as_str() {
        "(m/s²)/K" => ("mg/K", 1e3 / 9.806_65),
        "(rad/s)/K" => ("(°/h)/K", 3600.0_f64.to_degrees()),
        _ => return String::new(),
    };
    t.verdict.value().map_or(String::new(), |v| {
        format!("{} {unit}", scientific(factor * v, 3))
    })
}

/// The fit without gross outliers beside the ordinary one.
fn robust(analysis: &Analysis) -> Option<Table> {
    analysis.channels.iter().find(|c| c.robust.is_some())?;
    let mut table = Table::new(
        "The fit without gross outliers beside the ordinary one",
        [
            Column::text("channel"),
            Column::number("replaced", "samples"),
            Column::text("coefficient"),
            Column::text("ordinary"),
            Column::text("robust"),
            Column::text("interval, or limit"),
            Column::text("unit"),
            Column::number("difference", "u"),
        ],
    );
    for channel in &analysis.channels {
        let (Some(robust), Some(fit)) = (&channel.robust, &channel.whittle) else {
            continue;
        };
        for c in &robust.fit.coefficients {
            if !matches!(c.term, Term::White | Term::Flicker | Term::RandomWalk) {
                continue;
            }
            let (value, interval, _) = words(&c.verdict);
            let ordinary = fit.value(c.term);
            let difference = robust.differences.iter().find(|d| d.0 == c.term);
            table = table.row([
                Cell::text(channel.name.clone()),
                Cell::number(robust.replaced.to_string()),
                Cell::text(name(c)),
                Cell::text(ordinary.map_or("–".to_owned(), |v| scientific(v, 4))),
                Cell::text(value),
                Cell::text(interval),
                Cell::text(c.unit.clone()),
                difference.map_or(Cell::Empty, |d| Cell::number(format!("{:+.1}", d.1))),
            ]);
        }
    }
    Some(table.note(
        "Samples further than four robust standard deviations from what their neighbours predict were replaced by that prediction; the          difference is ordinary less robust, in standard uncertainties of the robust value.",
    ))
}

/// The value as data sheets give it.
fn usual(channel: &ChannelAnalysis, c: &Coefficient) -> String {
    let wanted: &[&str] = match c.term {
        Term::White => &["one-sided amplitude density", "angle random walk"],
        Term::Flicker => &["floor of the Allan deviation, 0.664 B"],
        Term::RandomWalk => &["growth of the bias", "rate random walk"],
        Term::Ramp => &["drift"],
        _ => return String::new(),
    };
    let units = channel
        .units
        .iter()
        .find(|u| u.term == c.term && c.verdict.value().is_some());
    units
        .and_then(|u| {
            u.units.iter().find(|u| {
                wanted.contains(&u.meaning.as_str()) && (u.unit.contains(['µ', '°', 'h']))
            })
        })
        .map_or(String::new(), |u| {
            let kind = match u.meaning.as_str() {
                "one-sided amplitude density" => " one-sided",
                "floor of the Allan deviation, 0.664 B" => " floor",
                _ => "",
            };
            format!("{} {}{kind}", scientific(u.value, 3), u.unit)
        })
}

/// Value, interval or limit, and the word for what is known of a coefficient.
fn words(verdict: &Verdict) -> (String, String, String) {
    match *verdict {
        Verdict::Identified {
            value, interval, ..
        } => (
            scientific(value, 4),
            range(interval),
            "identified".to_owned(),
        ),
        Verdict::Present {
            value, interval, ..
        } => (scientific(value, 4), range(interval), "present".to_owned()),
        Verdict::Fixed { value } => (scientific(value, 4), String::new(), "given".to_owned()),
        Verdict::NotIdentifiable {
            reason,
            upper_limit,
            ..
        } => (
            "–".to_owned(),
            upper_limit.map_or(String::new(), |l| format!("below {}", scientific(l, 3))),
            match reason {
                Reason::NoSupport { .. } => "not identifiable".to_owned(),
                _ => reason.to_string(),
            },
        ),
    }
}

/// `N white noise`, with its parameter where the term has one.
fn name(c: &Coefficient) -> String {
    let parameter = match (c.term, c.parameter) {
        (Term::GaussMarkov, Some(t)) => match t.interval {
            Some(interval) => {
                format!(", T = {} s ({} s)", scientific(t.value, 3), range(interval))
            }
            None => format!(", T = {} s", scientific(t.value, 3)),
        },
        (Term::Sinusoid, Some(f)) => match f.interval {
            Some(interval) => {
                format!(
                    ", f = {} Hz ({} Hz)",
                    scientific(f.value, 4),
                    range(interval)
                )
            }
            None => format!(", f = {} Hz", scientific(f.value, 4)),
        },
        _ => String::new(),
    };
    format!("{} {}{parameter}", c.term.symbol(), c.term.name())
}

fn range((low, high): (f64, f64)) -> String {
    format!("{} to {}", scientific(low, 4), scientific(high, 4))
}

fn channel_section(channel: &ChannelAnalysis, trace: Option<&Trace>) -> Section {
    let unit = &channel.unit;
    let mut section = Section::new(format!("Channel {}", channel.name)).paragraph(format!(
        "Mean {} {unit}, standard deviation {} {unit}, slope of the straight line {} {}.",
        scientific(channel.mean, 6),
        scientific(channel.standard_deviation, 4),
        scientific(channel.trend.slope, 3),
        Term::Ramp.unit(unit),
    ));
    if let Some(plot) = stability(channel) {
        section = section.figure(
            "Stability of the channel with its intervals; dotted, the power laws of the identified coefficients",
            plot,
        );
    }
    if let Some(plot) = over_time(channel) {
        section = section.figure(
            "Dynamic Allan deviation: the curve of every window, with its intervals",
            plot,
        );
    }
    for curve in channel.curve.iter().chain(&channel.further) {
        section = section.table(deviations(channel, curve, ""));
    }
    if let Some(curve) = &channel.compensated {
        section = section.table(deviations(
            channel,
            curve,
            " without what follows the temperature",
        ));
    }
    if let Some(plot) = spectrum(channel) {
        section = section.figure(
            "One-sided amplitude density of the whole record with its confidence band; below, its ratio to the fitted model; shaded, what the fit \
             leaves out",
            plot,
        );
    }
    if let Some(trace) = trace.filter(|t| t.x.len() > 1) {
        section = section.figure(
            "The record, smallest and largest values of short stretches, with its straight line",
            time(channel, trace),
        );
    }
    if !channel.disturbances.is_empty() {
        section = section.table(disturbances(&channel.disturbances));
    }
    if !channel.units.is_empty() {
        section = section.table(units(channel));
    }
    match &channel.kalman {
        Some(k) if channel.whittle.as_ref().is_some_and(|f| f.model.white > 0.0) => section
            .paragraph(format!(
                "Kalman filter at this rate: measurement variance R = {}; process noise of (integral, bias) over one \
                 step Q = [[{}, {}], [{}, {}]], in ({unit})² times s², s and 1{}.",
                scientific(k.measurement_variance, 4),
                scientific(k.process[0][0], 4),
                scientific(k.process[0][1], 4),
                scientific(k.process[1][0], 4),
                scientific(k.process[1][1], 4),
                if k.random_walk_is_limit {
                    "; K is its upper limit, because its most likely value is zero"
                } else {
                    ""
                },
            )),
        _ => section,
    }
}

/// The stability curve with its intervals, the fitted curve, and one named power law per identified coefficient.
fn stability(channel: &ChannelAnalysis) -> Option<XyPlot> {
    let curve = channel.curve.as_ref()?;
    let points: Vec<_> = curve.points.iter().filter(|p| p.deviation > 0.0).collect();
    points.first()?;
    let tau: Vec<f64> = points.iter().map(|p| p.tau).collect();
    let value: Vec<f64> = points.iter().map(|p| p.deviation).collect();
    let limit = |side: fn((f64, f64)) -> f64| -> Vec<f64> {
        let of = |p: &&proofmass_noise::DeviationPoint| p.interval.map_or(p.deviation, side);
        points.iter().map(of).collect()
    };
    let unit = deviation_unit(channel, curve);
    let mut plot = XyPlot::new(
        Axis::log("averaging time τ", "s"),
        Axis::log(curve.statistic.abbreviation(), unit),
    )
    .height(380.0)
    .series(
        Series::markers(curve.statistic.abbreviation(), &tau, &value)
            .bars(&limit(|i| i.0), &limit(|i| i.1)),
    );
    if let Some(compensated) = &channel.compensated {
        let points: Vec<_> = compensated
            .points
            .iter()
            .filter(|p| p.deviation > 0.0)
            .collect();
        let tau: Vec<f64> = points.iter().map(|p| p.tau).collect();
        let value: Vec<f64> = points.iter().map(|p| p.deviation).collect();
        let limit = |side: fn((f64, f64)) -> f64| -> Vec<f64> {
            let of = |p: &&proofmass_noise::DeviationPoint| p.interval.map_or(p.deviation, side);
            points.iter().map(of).collect()
        };
        plot = plot.series(
            Series::markers("without temperature", &tau, &value)
                .bars(&limit(|i| i.0), &limit(|i| i.1)),
        );
    }
    let Some(model) = channel.whittle.as_ref().map(|f| &f.model) else {
        return Some(plot);
    };
    let fitted: Vec<_> = channel
        .fitted
        .iter()
        .filter(|p| p.deviation > 0.0)
        .collect();
    if fitted.is_empty() {
        return Some(plot);
    }
    let at: Vec<f64> = fitted.iter().map(|p| p.tau).collect();
    let model_value: Vec<f64> = fitted.iter().map(|p| p.deviation).collect();
    plot = plot.series(Series::line("fitted model", &at, &model_value));
    let outside = outside(&fitted);
    if !outside.is_empty() {
        plot = plot.shade("model outside the limits of the curve", &outside);
    }
    // Where a power law takes the value of its coefficient: N at 1 s, K at 3 s, Q at √3 s, R at √2 s.
    let root = f64::sqrt;
    let laws = [
        (Term::Quantisation, root(3.0), model.quantisation, "τ⁻¹"),
        (Term::White, 1.0, model.white, "τ⁻¹ᐟ²"),
        (Term::Flicker, 1.0, 0.664_28 * model.flicker, "τ⁰"),
        (Term::RandomWalk, 3.0, model.random_walk, "τ¹ᐟ²"),
        (Term::Ramp, root(2.0), model.ramp, "τ"),
    ];
    for (term, at, value, law) in laws {
        let given = channel.whittle.as_ref().and_then(|f| f.value(term));
        if let (true, Some(_), Some(slope)) = (value > 0.0, given, term.slope()) {
            plot = plot.slope(
                format!("{} {law}", label(channel, term)),
                (at, value),
                slope,
            );
        }
    }
    Some(plot)
}

/// Ranges of τ where the model lies outside the limits of the curve, half an octave to either side.
fn outside(fitted: &[&FittedPoint]) -> Vec<(f64, f64)> {
    let half = std::f64::consts::SQRT_2;
    let mut ranges: Vec<(f64, f64)> = Vec::new();
    for p in fitted.iter().filter(|p| !p.inside) {
        let (low, high) = (p.tau / half, p.tau * half);
        match ranges.last_mut() {
            Some(last) if low <= last.1 * 1.01 => last.1 = high,
            _ => ranges.push((low, high)),
        }
    }
    ranges
}

/// `N = 0.002489`.
fn label(channel: &ChannelAnalysis, term: Term) -> String {
    let value = channel.whittle.as_ref().and_then(|f| f.value(term));
    value.map_or_else(
        || term.symbol().to_owned(),
        |v| format!("{} = {},", term.symbol(), scientific(v, 3)),
    )
}

/// Amplitude density in the unit of data sheets.
fn spectrum(channel: &ChannelAnalysis) -> Option<XyPlot> {
    let points: Vec<_> = channel
        .spectrum
        .iter()
        .filter(|p| p.frequency > 0.0 && p.density > 0.0)
        .collect();
    if points.len() < 2 {
        return None;
    }
    let (unit, factor) = amplitude_unit(&channel.unit);
    let amplitude = |s: f64| factor * s.max(0.0).sqrt();
    let pick = |f: &dyn Fn(&proofmass_noise::SpectrumPoint) -> f64| -> Vec<f64> {
        points.iter().map(|p| amplitude(f(p))).collect()
    };
    let x: Vec<f64> = points.iter().map(|p| p.frequency).collect();
    let y = pick(&|p| p.density);
    let low = pick(&|p| p.interval.map_or(p.density, |i| i.0));
    let high = pick(&|p| p.interval.map_or(p.density, |i| i.1));
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::log("amplitude density", unit),
    )
    .series(Series::line("record", &x, &y).band(&low, &high));
    let modelled: Vec<f64> = points
        .iter()
        .filter_map(|p| p.model.map(amplitude))
        .collect();
    if modelled.len() == x.len() {
        plot = plot.series(Series::line("fitted model", &x, &modelled));
    }
    let band = channel.whittle.as_ref().map(|f| f.band.highest_frequency);
    let left = match (band, x.last()) {
        (Some(highest), Some(last)) if highest < *last => vec![(highest, *last)],
        _ => Vec::new(),
    };
    if !left.is_empty() {
        plot = plot.shade("not fitted", &left);
    }
    if modelled.len() == x.len() {
        let over =
            |v: &[f64]| -> Vec<f64> { v.iter().zip(&modelled).map(|(a, m)| a / m).collect() };
        plot = plot
            .below(Axis::log("record over model", ""))
            .series(Series::line("", &x, &over(&y)).band(&over(&low), &over(&high)))
            .horizontal(1.0, "");
        if !left.is_empty() {
            plot = plot.shade("", &left);
        }
        plot.panels[0].height = 260.0;
    }
    Some(plot)
}

/// Unit of an amplitude density, and what one SI unit of it is there.
fn amplitude_unit(unit: &str) -> (String, f64) {
    match unit {
        "m/s²" => ("µg/√Hz".to_owned(), 1e6 / 9.806_65),
        "rad/s" => ("(°/h)/√Hz".to_owned(), 3600.0_f64.to_degrees()),
        _ => (Term::White.unit(unit), 1.0),
    }
}

fn time(channel: &ChannelAnalysis, trace: &Trace) -> XyPlot {
    let start = trace.x.first().copied().unwrap_or(0.0);
    let end = trace.x.last().copied().unwrap_or(0.0);
    let half = 0.5 * channel.trend.slope * (end - start);
    let mut plot = XyPlot::new(
        Axis::linear("time", "s"),
        Axis::linear(channel.name.clone(), channel.unit.clone()),
    )
    .series(Series::line(channel.name.clone(), &trace.x, &trace.y))
    .series(Series::line(
        "straight line",
        &[start, end],
        &[channel.trend.mean - half, channel.trend.mean + half],
    ));
    if !channel.disturbances.is_empty() {
        let places: Vec<(f64, f64)> = channel.disturbances.iter().map(|d| d.seconds).collect();
        plot = plot.shade("disturbance", &places);
    }
    plot
}

fn disturbances(found: &[Disturbance]) -> Table {
    let mut worst: Vec<&Disturbance> = found.iter().collect();
    worst.sort_by(|a, b| b.displacement.total_cmp(&a.displacement));
    let mut table = Table::new(
        "Disturbances, the worst first",
        [
            Column::text("kind"),
            Column::number("from", "s"),
            Column::number("to", "s"),
            Column::number("strength", "σ"),
            Column::number("needed", "σ"),
            Column::number("raises the Allan variance by", "%"),
        ],
    );
    for d in worst.iter().take(20) {
        table = table.row([
            Cell::text(match d.kind {
                DisturbanceKind::Step => "step",
                DisturbanceKind::Burst => "burst",
                DisturbanceKind::Lull => "lull",
                DisturbanceKind::Spike => "spike",
            }),
            Cell::number(format!("{:.2}", d.seconds.0)),
            Cell::number(format!("{:.2}", d.seconds.1)),
            Cell::number(format!("{:.1}", d.strength)),
            Cell::number(format!("{:.1}", d.threshold)),
            Cell::number(format!("{:.1}", 100.0 * d.influence)),
        ]);
    }
    if found.len() > 20 {
        table = table.note(format!("{} more are in result.json.", found.len() - 20));
    }
    table
}

/// Rows of a table of deviations; more stand in `deviation.csv`.
const TABLE_ROWS: usize = 40;

/// The numbers of a curve.
fn deviations(channel: &ChannelAnalysis, curve: &DeviationCurve, without: &str) -> Table {
    let unit = deviation_unit(channel, curve);
    let name = curve.statistic.abbreviation();
    let mut table = Table::new(
        format!(
            "{name}{without} with {} % intervals",
            scientific(100.0 * curve.probability, 3).trim_end_matches(".0")
        ),
        [
            Column::number("τ", "s"),
            Column::number(name, unit.clone()),
            Column::number("from", unit.clone()),
            Column::number("to", unit),
            Column::number("degrees of freedom", ""),
            Column::text("noise at this τ"),
        ],
    );
    for p in curve.points.iter().take(TABLE_ROWS) {
        let limit = |side: fn((f64, f64)) -> f64| {
            let value = p.interval.map(side);
            value.map_or(Cell::Empty, |v| Cell::number(scientific(v, 4)))
        };
        table = table.row([
            Cell::number(scientific(p.tau, 4)),
            Cell::number(scientific(p.deviation, 4)),
            limit(|i| i.0),
            limit(|i| i.1),
            p.edf
                .map_or(Cell::Empty, |edf| Cell::number(scientific(edf, 3))),
            Cell::text(noise_name(p.noise)),
        ]);
    }
    if curve.points.len() > TABLE_ROWS {
        let more = curve.points.len() - TABLE_ROWS;
        table = table.note(format!("{more} more are in deviation.csv."));
    }
    table
}

fn noise_name(noise: NoiseType) -> &'static str {
    match noise {
        NoiseType::RandomRun => "random run",
        NoiseType::FlickerWalk => "flicker walk",
        NoiseType::RandomWalk => "random walk",
        NoiseType::Flicker => "flicker",
        NoiseType::White => "white",
        NoiseType::FlickerPhase => "flicker of the integral",
        NoiseType::WhitePhase => "quantisation",
    }
}

fn deviation_unit(channel: &ChannelAnalysis, curve: &DeviationCurve) -> String {
    if curve.statistic.is_time() {
        Term::Quantisation.unit(&channel.unit)
    } else {
        channel.unit.clone()
    }
}

fn units(channel: &ChannelAnalysis) -> Table {
    let mut table = Table::new(
        "The coefficients in the units in use",
        [
            Column::text("coefficient"),
            Column::text("value"),
            Column::text("unit"),
            Column::text("meaning"),
        ],
    );
    for term in &channel.units {
        for unit in &term.units {
            table = table.row([
                Cell::text(term.term.symbol()),
                Cell::text(scientific(unit.value, 4)),
                Cell::text(unit.unit.clone()),
                Cell::text(unit.meaning.clone()),
            ]);
        }
    }
    table
}

//! The report of a noise analysis.

mod figures;
mod tables;

use crate::page::answer::stated_as;
use crate::page::stability::stability as with_intervals;
use figures::{over_time, spectrum, stability, time};
use proofmass_documents::StatedQuantity;
use proofmass_noise::{Analysis, ChannelAnalysis, DeviationCurve, Term, Verdict};
use proofmass_report::{Axis, Block, KeyFigure, Report, Section, Series, XyPlot, scientific};
use proofmass_signal::Trace;
use tables::{coefficients, deviations, disturbances, readings, robust, units};

/// Coefficients that open the page.
const ANSWERS: usize = 9;

pub(super) fn add(
    page: Report,
    analysis: &Analysis,
    traces: &[Trace],
    thermometer: Option<&Trace>,
    stated: &[StatedQuantity],
) -> Report {
    let channel = analysis.channels.first();
    let samples = channel.map_or(analysis.rows.1 - analysis.rows.0, |c| c.samples);
    let mut section = Section::new("Coefficients")
        .table(coefficients(analysis))
        .summarised();
    if let Some(table) = robust(analysis) {
        section = section.table(table);
    }
    if let Some(table) = readings(analysis) {
        section = section.folded("Read off the curve", [Block::Table(table)]);
    }
    let page = page
        .verdict(verdict(analysis))
        .answers(answer(analysis, stated))
        .subtitle(format!(
            "{samples} samples at {} Hz, {} s",
            scientific(analysis.sample_rate, 6),
            scientific(samples as f64 / analysis.sample_rate, 5),
        ));
    let channels = analysis.channels.iter().enumerate();
    let sections = [
        Some(section),
        Some(Section::filed(tables::files(analysis))),
        together(analysis),
        separated(analysis),
        thermometer.and_then(temperature),
    ]
    .into_iter()
    .flatten()
    .chain(channels.map(|(i, channel)| {
        let section = channel_section(channel, traces.get(i));
        // Paper has the first in full: the others are alike, and their coefficients stand in the table.
        match i {
            0 => section,
            _ => section.off_paper(),
        }
    }));
    sections.fold(page, Report::section)
}

/// Which coefficients are told from zero, by channel, in the words of the table.
fn verdict(analysis: &Analysis) -> String {
    let identified = named(analysis, |v| matches!(v, Verdict::Identified { .. }));
    let present = named(analysis, |v| {
        matches!(v, Verdict::Present { .. } | Verdict::Reported { .. })
    });
    let parts = [("Identified", identified), ("Present", present)];
    let told = parts.into_iter().filter(|(_, of)| !of.is_empty());
    let told: String = told.map(|(word, of)| format!("{word}: {of}. ")).collect();
    let told = match told.is_empty() {
        true => {
            "No coefficient differs significantly from zero; each has an upper limit.".to_owned()
        }
        false => format!("{told}The others have an upper limit."),
    };
    let off = |c: &&ChannelAnalysis| c.whittle.as_ref().is_some_and(|f| f.slow_misfit.is_some());
    let doubtful = analysis.channels.iter().filter(off);
    let doubtful: Vec<&str> = doubtful.map(|c| c.name.as_str()).collect();
    match doubtful.is_empty() {
        true => told,
        false => format!(
            "{told} K of {} is doubtful: its slowest cycles do not follow the fit.",
            doubtful.join(", ")
        ),
    }
}

/// The coefficients with a verdict, each with its channels: `N in all 3 channels, B of acc_z`.
fn named(analysis: &Analysis, wanted: impl Fn(&Verdict) -> bool) -> String {
    let mut found: Vec<(&str, Vec<&str>)> = Vec::new();
    for channel in &analysis.channels {
        for c in channel.whittle.iter().flat_map(|f| &f.coefficients) {
            if !wanted(&c.verdict) {
                continue;
            }
            let symbol = c.term.symbol();
            match found.iter_mut().find(|(s, _)| *s == symbol) {
                Some((_, channels)) if channels.contains(&channel.name.as_str()) => {}
                Some((_, channels)) => channels.push(&channel.name),
                None => found.push((symbol, vec![&channel.name])),
            }
        }
    }
    let all = analysis.channels.len();
    let told = found.iter().map(|(symbol, channels)| match channels.len() {
        n if n == all && all > 1 => format!("{symbol} in all {all} channels"),
        n if n <= 3 => format!("{symbol} of {}", channels.join(", ")),
        n => format!("{symbol} in {n} of {all} channels"),
    });
    told.collect::<Vec<_>>().join(", ")
}

/// The white noise of every channel, else what else is known of them.
fn answer(analysis: &Analysis, stated: &[StatedQuantity]) -> Vec<KeyFigure> {
    let symbols = [
        Term::White.symbol(),
        Term::Flicker.symbol(),
        Term::RandomWalk.symbol(),
    ];
    let mut figures = Vec::new();
    for symbol in symbols {
        for channel in &analysis.channels {
            let name = format!("{}.{symbol}", channel.name);
            let quantity = stated.iter().find(|q| q.name == name);
            // The name of a channel may hold points and brackets, which are no part of a quantity's own.
            let label = format!("{} {symbol}", channel.name.replace('_', " "));
            figures.extend(quantity.map(|q| stated_as(&label, q)));
        }
    }
    figures.truncate(ANSWERS);
    figures
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
            Axis::log(kind.1, curve.statistic.unit(&channel.unit)),
        )
        .height(320.0);
        for (channel, curve) in same {
            plot = plot.series(with_intervals(&channel.name, curve));
        }
        section = section.figure(format!("{} of all channels in {}", kind.1, kind.0), plot);
        drawn = true;
    }
    drawn.then_some(section)
}

/// What the thermometer read.
fn temperature(trace: &Trace) -> Option<Section> {
    let finite = || trace.y.iter().copied().filter(|t| t.is_finite());
    let (low, high) = (finite().reduce(f64::min)?, finite().reduce(f64::max)?);
    Some(
        Section::new("Temperature")
            .paragraph(format!(
                "From {} to {}, in kelvins above the zero of the thermometer: of °C, unless its heading says K or °F.",
                scientific(low, 4),
                scientific(high, 4)
            ))
            .figure(
                "The temperature beside the record",
                XyPlot::new(
                    Axis::linear("time", "s"),
                    Axis::linear("temperature above the zero of its scale", "K"),
                )
                .series(Series::line("temperature", &trace.x, &trace.y)),
            ),
    )
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
    let names = [0, 1, 2].map(|k| {
        let channel = analysis.channels.get(k);
        channel.map_or_else(|| "reference".to_owned(), |c| c.name.clone())
    });
    for (k, name) in names.iter().enumerate() {
        let positive: Vec<(f64, f64)> = points
            .iter()
            .filter_map(|p| Some((p.tau, p.deviation(k)?)))
            .collect();
        let (tau, value): (Vec<f64>, Vec<f64>) = positive.into_iter().unzip();
        plot = plot.series(Series::markers(name, &tau, &value));
    }
    Some(
        Section::new("Sensors by themselves")
            .paragraph(
                "What all three share is left out: the covariance of the differences of one sensor to the two others. A variance below zero \
                 says that the sensor is quieter than its uncertainty.",
            )
            .figure("Allan deviations of the sensors by themselves", plot)
            .table(tables::separated(points, &names, &unit)),
    )
}

fn channel_section(channel: &ChannelAnalysis, trace: Option<&Trace>) -> Section {
    let unit = &channel.unit;
    let mut section = Section::new(format!("Channel {}", channel.name)).paragraph(format!(
        "Mean {} {unit}, standard deviation {} {unit}, slope of the straight line {} {}.",
        scientific(channel.mean, 3),
        scientific(channel.standard_deviation, 3),
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
    let further = channel.further.iter().chain(&channel.compensated);
    for curve in channel.curve.iter().chain(further) {
        section = section.table(deviations(channel, curve));
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

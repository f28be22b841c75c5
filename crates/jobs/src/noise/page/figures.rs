//! Figures of a noise analysis.

use crate::page::stability::stability as with_intervals;
use proofmass_noise::{ChannelAnalysis, FittedPoint, Term};
use proofmass_report::plot::Style;
use proofmass_report::{Axis, Series, XyPlot, scientific};
use proofmass_signal::Trace;

/// The curve over time: one line for every averaging time that all windows have, at most eight.
pub(super) fn over_time(channel: &ChannelAnalysis) -> Option<XyPlot> {
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

/// The stability curve with its intervals, the fitted curve, and one named power law per identified coefficient.
pub(super) fn stability(channel: &ChannelAnalysis) -> Option<XyPlot> {
    let curve = channel.curve.as_ref()?;
    curve.points.iter().find(|p| p.deviation > 0.0)?;
    let series = |name: &str, curve| with_intervals(name, curve).style(Style::Markers);
    let name = curve.statistic.abbreviation();
    let unit = curve.statistic.unit(&channel.unit);
    let mut plot = XyPlot::new(Axis::log("averaging time τ", "s"), Axis::log(name, unit))
        .height(320.0)
        .series(series(name, curve));
    if let Some(compensated) = &channel.compensated {
        let name = format!("without {}", channel.taken_off());
        plot = plot.series(series(&name, compensated));
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
pub(super) fn spectrum(channel: &ChannelAnalysis) -> Option<XyPlot> {
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

pub(super) fn time(channel: &ChannelAnalysis, trace: &Trace) -> XyPlot {
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

//! The report of a noise analysis.

use crate::{Axis, Cell, Column, Report, Section, Series, Table, XyPlot, scientific};
use proofmass_noise::{
    Analysis, ChannelAnalysis, Coefficient, DeviationCurve, Disturbance, DisturbanceKind,
    NoiseType, Reason, Statistic, Term, Verdict,
};
use proofmass_uncertainty::Finding;

/// Points of a time plot: a smallest and a largest value for each of half as many stretches.
const TIME_POINTS: usize = 4000;

/// What the report tells beside the analysis itself.
#[derive(Clone, Debug, Default)]
pub struct NoiseReport<'a> {
    /// Title.
    pub title: String,
    /// Label and value.
    pub meta: Vec<(String, String)>,
    /// Name and SHA-256 of each input file.
    pub inputs: Vec<(String, String)>,
    /// All findings, those of the recording and of every channel included.
    pub findings: &'a [Finding],
    /// The samples of each channel that were analysed, in the order of the analysis.
    pub samples: Vec<&'a [f64]>,
    /// Last line.
    pub footer: String,
}

impl NoiseReport<'_> {
    /// The whole report.
    pub fn full(&self, analysis: &Analysis) -> Report {
        let mut report = self.summary(analysis);
        for (i, channel) in analysis.channels.iter().enumerate() {
            let samples = self.samples.get(i).copied().unwrap_or_default();
            // Rate of what spectrum and time plot show.
            let rate = analysis.sample_rate / analysis.averaged as f64;
            report = report.section(channel_section(channel, samples, rate));
        }
        report
            .section(Section::new("Inputs").inputs(&self.inputs))
            .footer(self.footer.clone())
    }

    /// What is worth a look in the terminal.
    pub fn summary(&self, analysis: &Analysis) -> Report {
        let channel = analysis.channels.first();
        let samples = channel.map_or(analysis.rows.1 - analysis.rows.0, |c| c.samples);
        let mut report = Report::new(self.title.clone()).subtitle(format!(
            "{samples} samples at {} Hz, {} s",
            scientific(analysis.sample_rate, 6),
            scientific(samples as f64 / analysis.sample_rate, 5),
        ));
        for (label, value) in &self.meta {
            report = report.meta(label.clone(), value.clone());
        }
        report
            .findings(self.findings.iter().cloned())
            .section(Section::new("Coefficients").table(coefficients(analysis)))
    }
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
        (Term::Sinusoid, Some(f)) => format!(", f = {} Hz", scientific(f.value, 4)),
        _ => String::new(),
    };
    format!("{} {}{parameter}", c.term.symbol(), c.term.name())
}

fn range((low, high): (f64, f64)) -> String {
    format!("{} to {}", scientific(low, 4), scientific(high, 4))
}

fn channel_section(channel: &ChannelAnalysis, samples: &[f64], sample_rate: f64) -> Section {
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
    for curve in channel.curve.iter().chain(&channel.further) {
        section = section.table(deviations(channel, curve));
    }
    if let Some(plot) = spectrum(channel, sample_rate) {
        section = section.figure(
            "One-sided power spectral density of the whole record with its confidence band",
            plot,
        );
    }
    if !samples.is_empty() {
        section = section.figure(
            "The record, smallest and largest values of short stretches, with its straight line",
            time(channel, samples, sample_rate),
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
    let (first, last) = (points.first()?.tau, points.last()?.tau);
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
    let two_samples = matches!(
        curve.statistic,
        Statistic::Allan | Statistic::OverlappingAllan | Statistic::Total
    );
    let model = channel.whittle.as_ref().map(|f| &f.model)?;
    // The model is that of the Allan variance; other statistics have other factors.
    if !two_samples || model.allan_variance(first) <= 0.0 {
        return Some(plot);
    }
    let grid: Vec<f64> = (0..=200)
        .map(|i| first * (last / first).powf(f64::from(i) / 200.0))
        .collect();
    let fitted: Vec<f64> = grid
        .iter()
        .map(|&t| model.allan_variance(t).sqrt())
        .collect();
    plot = plot.series(Series::line("fitted model", &grid, &fitted));
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

/// `N = 0.002489`.
fn label(channel: &ChannelAnalysis, term: Term) -> String {
    let value = channel.whittle.as_ref().and_then(|f| f.value(term));
    value.map_or_else(
        || term.symbol().to_owned(),
        |v| format!("{} = {},", term.symbol(), scientific(v, 3)),
    )
}

fn spectrum(channel: &ChannelAnalysis, sample_rate: f64) -> Option<XyPlot> {
    let points: Vec<_> = channel
        .spectrum
        .iter()
        .filter(|p| p.frequency > 0.0 && p.density > 0.0)
        .collect();
    if points.len() < 2 {
        return None;
    }
    let x: Vec<f64> = points.iter().map(|p| p.frequency).collect();
    let y: Vec<f64> = points.iter().map(|p| p.density).collect();
    let low: Vec<f64> = points
        .iter()
        .map(|p| p.interval.map_or(p.density, |i| i.0))
        .collect();
    let high: Vec<f64> = points
        .iter()
        .map(|p| p.interval.map_or(p.density, |i| i.1))
        .collect();
    let unit = if channel.unit.contains(['/', '·']) {
        format!("({})²/Hz", channel.unit)
    } else {
        format!("{}²/Hz", channel.unit)
    };
    let mut plot = XyPlot::new(
        Axis::log("frequency", "Hz"),
        Axis::log("power spectral density", unit),
    )
    .series(Series::line("record", &x, &y).band(&low, &high));
    if let Some(fit) = &channel.whittle {
        let fitted: Vec<f64> = x
            .iter()
            .map(|&f| fit.model.density(f, sample_rate))
            .collect();
        if fitted.iter().all(|s| *s > 0.0) {
            plot = plot.series(Series::line("fitted model", &x, &fitted));
        }
    }
    Some(plot)
}

fn time(channel: &ChannelAnalysis, samples: &[f64], sample_rate: f64) -> XyPlot {
    let (x, y) = outline(samples, sample_rate);
    let end = (samples.len() - 1) as f64 / sample_rate;
    let half = 0.5 * channel.trend.slope * end;
    let mut plot = XyPlot::new(
        Axis::linear("time", "s"),
        Axis::linear(channel.name.clone(), channel.unit.clone()),
    )
    .series(Series::line(channel.name.clone(), &x, &y))
    .series(Series::line(
        "straight line",
        &[0.0, end],
        &[channel.trend.mean - half, channel.trend.mean + half],
    ));
    if !channel.disturbances.is_empty() {
        let places: Vec<(f64, f64)> = channel.disturbances.iter().map(|d| d.seconds).collect();
        plot = plot.shade("disturbance", &places);
    }
    plot
}

/// Smallest and largest value of each stretch, in the order in which they occur: a line that looks like the record.
fn outline(samples: &[f64], sample_rate: f64) -> (Vec<f64>, Vec<f64>) {
    let stretch = (2 * samples.len()).div_ceil(TIME_POINTS).max(1);
    let mut points: Vec<usize> = Vec::with_capacity(TIME_POINTS);
    for (k, part) in samples.chunks(stretch).enumerate() {
        let (mut low, mut high) = (0, 0);
        for (i, v) in part.iter().enumerate() {
            if *v < part[low] {
                low = i;
            }
            if *v > part[high] {
                high = i;
            }
        }
        points.push(k * stretch + low.min(high));
        if low != high {
            points.push(k * stretch + low.max(high));
        }
    }
    points
        .into_iter()
        .map(|i| (i as f64 / sample_rate, samples[i]))
        .unzip()
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
fn deviations(channel: &ChannelAnalysis, curve: &DeviationCurve) -> Table {
    let unit = deviation_unit(channel, curve);
    let name = curve.statistic.abbreviation();
    let mut table = Table::new(
        format!(
            "{name} with {} % intervals",
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
    match curve.statistic {
        Statistic::Time | Statistic::TimeTotal => Term::Quantisation.unit(&channel.unit),
        _ => channel.unit.clone(),
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

//! Tables of a noise analysis.

use proofmass_noise::{
    Analysis, ChannelAnalysis, Coefficient, DeviationCurve, Disturbance, DisturbanceKind,
    NoiseType, Reason, TemperatureSensitivity, Term, Verdict,
};
use proofmass_report::{Cell, Column, Table, scientific};

/// Every coefficient of every channel: a number with its interval, or why there is none.
pub(super) fn coefficients(analysis: &Analysis) -> Table {
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
            let (value, interval, word) = words(&c.verdict, c.term.is_signed());
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
            let (value, interval, word) = words(&t.verdict, true);
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
pub(super) fn robust(analysis: &Analysis) -> Option<Table> {
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
            let (value, interval, _) = words(&c.verdict, c.term.is_signed());
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
fn words(verdict: &Verdict, signed: bool) -> (String, String, String) {
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
        Verdict::Reported {
            value, interval, ..
        } => (
            scientific(value, 4),
            range(interval),
            "reported as asked; zero lies in the interval".to_owned(),
        ),
        Verdict::Fixed { value } => (scientific(value, 4), String::new(), "given".to_owned()),
        Verdict::NotIdentifiable {
            reason,
            upper_limit,
            ..
        } => (
            "–".to_owned(),
            upper_limit.map_or(String::new(), |l| {
                let limit = scientific(l, 3);
                if signed {
                    format!("within ±{limit}")
                } else {
                    format!("below {limit}")
                }
            }),
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

pub(super) fn disturbances(found: &[Disturbance]) -> Table {
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
pub(super) fn deviations(
    channel: &ChannelAnalysis,
    curve: &DeviationCurve,
    without: &str,
) -> Table {
    let unit = curve.statistic.unit(&channel.unit);
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

pub(super) fn units(channel: &ChannelAnalysis) -> Table {
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

//! Tables of a noise analysis.

use crate::page::columns::{filed, number};
use crate::page::words::words;
use proofmass_noise::{
    Analysis, ChannelAnalysis, Coefficient, CoefficientFit, Course, CourseShape, CurveReading,
    DeviationCurve, DeviationPoint, Disturbance, DisturbanceKind, DynamicWindow, FittedPoint,
    NoiseType, Reason, RobustFit, SeparatedPoint, SpectrumPoint, TemperatureSensitivity, Term,
    Verdict, curve_readings,
};
use proofmass_report::Rounding::{Decimals, Freedom, Signed, Significant};
use proofmass_report::{Cell, Field, Table, scientific};

/// What is known of a coefficient of a channel; no verdict where nothing was fitted.
#[derive(Default)]
struct Line<'a> {
    channel: &'a str,
    symbol: String,
    name: String,
    verdict: Option<&'a Verdict>,
    signed: bool,
    unit: &'a str,
    usual: String,
    parameter: Option<f64>,
}

impl<'a> Line<'a> {
    fn of(channel: &'a ChannelAnalysis, c: &'a Coefficient) -> Self {
        Self {
            channel: &channel.name,
            symbol: c.term.symbol().to_owned(),
            name: name(c),
            verdict: Some(&c.verdict),
            signed: c.term.is_signed(),
            unit: &c.unit,
            usual: usual(channel, c),
            parameter: c.parameter.map(|p| p.value),
        }
    }

    fn of_temperature(channel: &'a ChannelAnalysis, t: &'a TemperatureSensitivity) -> Self {
        let figure = |v: f64| scientific(v, 3);
        let lag = match t.lag_interval {
            Some((low, Some(high))) if high > 0.0 => {
                format!(
                    ", lag {} s ({} to {} s)",
                    figure(t.lag),
                    figure(low),
                    figure(high)
                )
            }
            Some((low, None)) => format!(", lag above {} s", figure(low)),
            _ if t.lag > 0.0 => format!(", lag {} s", figure(t.lag)),
            _ => String::new(),
        };
        Self {
            channel: &channel.name,
            symbol: "K_T".to_owned(),
            name: format!("K_T sensitivity to temperature{lag}"),
            verdict: Some(&t.verdict),
            signed: true,
            unit: &t.unit,
            usual: per_kelvin(t),
            parameter: Some(t.lag),
        }
    }

    fn of_course(channel: &'a ChannelAnalysis, course: &'a Course, unit: &'a str) -> Self {
        let figure = |v: f64| scientific(v, 3);
        let at = match (course.shape, course.interval) {
            (CourseShape::Exponential { time }, Some((low, high))) => {
                let (time, low, high) = (figure(time), figure(low), figure(high));
                format!(", T = {time} s ({low} to {high} s)")
            }
            (CourseShape::Step { at }, Some((low, high))) => {
                let (at, low, high) = (figure(at), figure(low), figure(high));
                format!(" at {at} s ({low} to {high} s)")
            }
            _ => String::new(),
        };
        let symbol = match course.shape {
            CourseShape::Exponential { .. } => "warm-up",
            CourseShape::Step { .. } => "step",
            _ => "day",
        };
        Self {
            channel: &channel.name,
            symbol: symbol.to_owned(),
            name: format!("{}{at}", course.shape),
            verdict: Some(&course.size),
            signed: true,
            unit,
            usual: String::new(),
            parameter: course.shape.time(),
        }
    }

    /// A channel without a fit.
    fn none(channel: &'a ChannelAnalysis) -> Self {
        Self {
            channel: &channel.name,
            name: "–".to_owned(),
            ..Self::default()
        }
    }

    fn all(channel: &'a ChannelAnalysis) -> Vec<Self> {
        let Some(fit) = &channel.whittle else {
            return Vec::new();
        };
        let coefficients = fit.coefficients.iter().map(|c| Self::of(channel, c));
        let temperature = fit.temperature.iter();
        coefficients
            .chain(temperature.map(|t| Self::of_temperature(channel, t)))
            .chain(
                fit.courses
                    .iter()
                    .map(|c| Self::of_course(channel, c, &channel.unit)),
            )
            .collect()
    }

    /// Of the fit without gross outliers, which only the file has among the others.
    fn robust(channel: &'a ChannelAnalysis) -> impl Iterator<Item = Self> {
        let coefficients = channel.robust.iter().flat_map(|r| &r.fit.coefficients);
        coefficients.map(move |c| Self {
            symbol: format!("{} robust", c.term.symbol()),
            ..Self::of(channel, c)
        })
    }

    /// Value, interval or limit, and the word for what is known.
    fn words(&self) -> [String; 3] {
        match self.verdict {
            Some(verdict) => in_words(verdict, self.signed),
            None => ["none", "see the findings", ""].map(str::to_owned),
        }
    }

    /// Ends of the interval; a limit of what may have either sign is one of its size.
    fn ends(&self) -> [Option<f64>; 2] {
        match self.verdict.and_then(Verdict::interval) {
            Some((low, high)) => [Some(low), Some(high)],
            None => {
                let limit = self.verdict.and_then(Verdict::upper);
                [limit.filter(|_| self.signed).map(|l| -l), limit]
            }
        }
    }
}

fn coefficient_fields<'a>() -> [Field<'a, Line<'a>>; 11] {
    [
        Field::new("channel", |l: &Line<'_>| l.channel.into()).page("channel", ""),
        Field::new("term", |l: &Line<'_>| {
            Cell::from(l.symbol.as_str()).worded(l.name.as_str())
        })
        .page("coefficient", ""),
        Field::new("verdict", |l: &Line<'_>| {
            let [.., word] = l.words();
            l.verdict
                .map(|v| Cell::from(single_word(v)).worded(word))
                .into()
        })
        .page("what it is", ""),
        Field::new("value", |l: &Line<'_>| {
            let [value, ..] = l.words();
            Cell::printed(l.verdict.and_then(Verdict::value), value)
        })
        .page("value", ""),
        Field::shown("interval, or limit", "", |l: &Line<'_>| {
            l.words()[1].as_str().into()
        }),
        Field::new("unit", |l: &Line<'_>| l.unit.into()).page("unit", ""),
        Field::shown("in usual units", "", |l: &Line<'_>| l.usual.as_str().into()),
        filed("u", |l: &Line<'_>| {
            l.verdict.and_then(Verdict::standard_uncertainty)
        }),
        filed("low", |l: &Line<'_>| l.ends()[0]),
        filed("high", |l: &Line<'_>| l.ends()[1]),
        filed("parameter", |l: &Line<'_>| l.parameter),
    ]
}

/// Every coefficient of every channel: a number with its interval, or why there is none.
pub(super) fn coefficients(analysis: &Analysis) -> Table {
    let fits = || analysis.channels.iter().filter_map(|c| c.whittle.as_ref());
    let probability = fits().next().map_or(0.95, |f| f.probability);
    let rate = fits().next().map_or(0.002, |f| f.false_alarm_rate);
    let lines = analysis
        .channels
        .iter()
        .flat_map(|channel| match channel.whittle {
            Some(_) => Line::all(channel),
            None => vec![Line::none(channel)],
        });
    let caption = format!(
        "Noise coefficients with their {} % intervals, by maximum likelihood on the spectrum",
        scientific(100.0 * probability, 3).trim_end_matches(".0")
    );
    Table::of(caption, coefficient_fields(), lines)
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

/// A reading of the curve with the coefficient that the likelihood states.
type ReadLine<'a> = (&'a ChannelAnalysis, CurveReading, Option<&'a Verdict>);

fn read_lines(analysis: &Analysis) -> Vec<ReadLine<'_>> {
    let of = |channel: &'_ ChannelAnalysis| channel.curve.as_ref().map(curve_readings);
    let mut lines = Vec::new();
    for channel in &analysis.channels {
        for reading in of(channel).unwrap_or_default() {
            let mut fitted = channel.whittle.iter().flat_map(|fit| &fit.coefficients);
            let stated = fitted.find(|c| c.term == reading.term);
            lines.push((channel, reading, stated.map(|c| &c.verdict)));
        }
    }
    lines
}

/// What is read off the curve by its slopes, as data sheets quote it; `None` where nothing is.
pub(super) fn readings(analysis: &Analysis) -> Option<Table> {
    let lines = read_lines(analysis);
    if lines.is_empty() {
        return None;
    }
    let fields = [
        Field::new("channel", |(c, ..): &ReadLine<'_>| c.name.as_str().into()).page("channel", ""),
        Field::new("term", |(_, r, _): &ReadLine<'_>| r.term.symbol().into())
            .page("coefficient", ""),
        Field::new("value", |(_, r, _): &ReadLine<'_>| r.value.into())
            .page("read off the curve", "")
            .rounded(Significant(3)),
        Field::shown("by likelihood", "", |(_, _, v): &ReadLine<'_>| {
            v.map(|v| Cell::printed(v.value(), in_words(v, false)[0].as_str()))
                .unwrap_or_default()
        }),
        Field::new("unit", |(c, r, _): &ReadLine<'_>| {
            r.term.unit(&c.unit).into()
        })
        .page("unit", ""),
        Field::new("from_s", |(_, r, _): &ReadLine<'_>| r.taus[0].into())
            .page("from", "s")
            .rounded(Significant(3)),
        Field::new("to_s", |(_, r, _): &ReadLine<'_>| r.taus[1].into())
            .page("to", "s")
            .rounded(Significant(3)),
    ];
    let table = Table::of(
        "Read off the Allan curve by its slopes, as data sheets quote it",
        fields,
        lines,
    );
    Some(table.file("readings.csv").note(
        "N: stretch of slope −½, at 1 s. B: minimum over 0.664. K: stretch of slope +½, at 3 s (IEEE 952). Without intervals, and with whatever \
         else bends the curve there; a stretch that the curve does not show is left out.",
    ))
}

/// Tables that only files have.
pub(super) fn files(analysis: &Analysis) -> Vec<Table> {
    let channels = &analysis.channels;
    let lines = channels
        .iter()
        .flat_map(|c| Line::all(c).into_iter().chain(Line::robust(c)));
    let curves = channels.iter().flat_map(|channel| {
        let all = channel
            .curve
            .iter()
            .chain(&channel.compensated)
            .chain(&channel.further);
        all.flat_map(move |curve| points(channel, curve))
    });
    let mut list = vec![
        Table::of("", coefficient_fields(), lines).file("coefficients.csv"),
        Table::of("", deviation_fields("", ""), curves).file("deviation.csv"),
        spectra(channels),
    ];
    if channels.iter().any(|c| !c.windows.is_empty()) {
        list.push(windows(channels));
    }
    list
}

fn spectra(channels: &[ChannelAnalysis]) -> Table {
    type Row<'a> = (&'a ChannelAnalysis, &'a SpectrumPoint);
    let fields = [
        Field::new("channel", |(c, _): &Row<'_>| c.name.as_str().into()),
        Field::new("unit", |(c, _): &Row<'_>| {
            format!("({})²/Hz", c.unit).into()
        }),
        filed("frequency_Hz", |(_, p): &Row<'_>| p.frequency),
        filed("density_one_sided", |(_, p): &Row<'_>| p.density),
        filed("low", |(_, p): &Row<'_>| p.interval.map(|i| i.0)),
        filed("high", |(_, p): &Row<'_>| p.interval.map(|i| i.1)),
        filed("model", |(_, p): &Row<'_>| p.model),
    ];
    let rows = channels
        .iter()
        .flat_map(|c| c.spectrum.iter().map(move |p| (c, p)));
    Table::of("", fields, rows).file("spectrum.csv")
}

/// The curve of every window.
fn windows(channels: &[ChannelAnalysis]) -> Table {
    type Row<'a> = ((&'a ChannelAnalysis, &'a DynamicWindow), &'a DeviationPoint);
    let fields = [
        Field::new("channel", |((c, _), _): &Row<'_>| c.name.as_str().into()),
        Field::new("unit", |((c, _), _): &Row<'_>| c.unit.as_str().into()),
        filed("from_s", |((_, w), _): &Row<'_>| w.from),
        filed("to_s", |((_, w), _): &Row<'_>| w.to),
        filed("factor", |(_, p): &Row<'_>| p.factor),
        filed("tau_s", |(_, p): &Row<'_>| p.tau),
        filed("deviation", |(_, p): &Row<'_>| p.deviation),
        filed("low", |(_, p): &Row<'_>| p.interval.map(|i| i.0)),
        filed("high", |(_, p): &Row<'_>| p.interval.map(|i| i.1)),
    ];
    let all = channels
        .iter()
        .flat_map(|c| c.windows.iter().map(move |w| (c, w)));
    let rows = all.flat_map(|(c, w)| w.curve.points.iter().map(move |p| ((c, w), p)));
    Table::of("", fields, rows).file("dynamic.csv")
}

/// The variance of each of three sensors by itself.
pub(super) fn separated(points: &[SeparatedPoint], names: &[String; 3], unit: &str) -> Table {
    type Row<'a> = (usize, &'a SeparatedPoint);
    let square = format!("({unit})²");
    let variance = |(k, p): &Row<'_>| p.variances[*k];
    let fields = [
        Field::new("sensor", |(k, _): &Row<'_>| names[*k].as_str().into()).page("sensor", ""),
        filed("factor", |(_, p): &Row<'_>| p.factor),
        number("tau_s", ("τ", "s"), Significant(4), |(_, p): &Row<'_>| {
            p.tau
        }),
        number("variance", ("variance", &square), Significant(4), variance),
        number(
            "u_variance",
            ("u", &square),
            Significant(2),
            |(k, p): &Row<'_>| p.uncertainties[*k],
        ),
        filed("deviation", |(k, p): &Row<'_>| p.deviation(*k)),
    ];
    let caption = "Allan variance of each sensor by itself, with its standard uncertainty";
    let rows = (0..3).flat_map(|k| points.iter().map(move |p| (k, p)));
    Table::of(caption, fields, rows).file("separated.csv")
}

fn single_word(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Identified { .. } => "identified",
        Verdict::Present { .. } => "present",
        Verdict::Reported { .. } => "reported",
        Verdict::NotIdentifiable { .. } => "not identifiable",
        Verdict::Fixed { .. } => "given",
    }
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
    type Row<'a> = (Line<'a>, &'a RobustFit, &'a CoefficientFit, Term);
    analysis.channels.iter().find(|c| c.robust.is_some())?;
    let rows = analysis.channels.iter().flat_map(|channel| {
        let both = channel.robust.as_ref().zip(channel.whittle.as_ref());
        both.into_iter().flat_map(move |(robust, fit)| {
            let wanted = |t| matches!(t, Term::White | Term::Flicker | Term::RandomWalk);
            let terms = robust
                .fit
                .coefficients
                .iter()
                .filter(move |c| wanted(c.term));
            terms.map(move |c| (Line::of(channel, c), robust, fit, c.term))
        })
    });
    let fields = [
        Field::shown("channel", "", |(l, ..): &Row<'_>| l.channel.into()),
        Field::shown("replaced", "samples", |(_, r, ..): &Row<'_>| {
            r.replaced.into()
        }),
        Field::shown("coefficient", "", |(l, ..): &Row<'_>| {
            l.name.as_str().into()
        }),
        Field::shown("ordinary", "", |(.., fit, term): &Row<'_>| {
            let value = fit.value(*term);
            Cell::printed(value, value.map_or("–".to_owned(), |v| scientific(v, 4)))
        }),
        Field::shown("robust", "", |(l, ..): &Row<'_>| {
            Cell::number(&l.words()[0])
        }),
        Field::shown("interval, or limit", "", |(l, ..): &Row<'_>| {
            l.words()[1].as_str().into()
        }),
        Field::shown("unit", "", |(l, ..): &Row<'_>| l.unit.into()),
        number(
            "",
            ("difference", "u"),
            Signed(1),
            |(_, r, _, term): &Row<'_>| r.differences.iter().find(|d| d.0 == *term).map(|d| d.1),
        ),
    ];
    let caption = "The fit without gross outliers beside the ordinary one";
    Some(Table::of(caption, fields, rows).note(
        "Samples further than four robust standard deviations from what their neighbours predict were replaced by that prediction; the \
         difference is ordinary less robust, in standard uncertainties of the robust value.",
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
fn in_words(verdict: &Verdict, signed: bool) -> [String; 3] {
    let value = verdict.value().map_or("–".to_owned(), |v| scientific(v, 4));
    let interval = || verdict.interval().map_or_else(String::new, range);
    match *verdict {
        Verdict::Identified { .. } | Verdict::Present { .. } => {
            [value, interval(), single_word(verdict).to_owned()]
        }
        Verdict::Reported { .. } => {
            let word = "reported as asked; zero lies in the interval";
            [value, interval(), word.to_owned()]
        }
        Verdict::Fixed { .. } => [value, String::new(), "given".to_owned()],
        Verdict::NotIdentifiable {
            reason,
            upper_limit,
            ..
        } => {
            let side = if signed { "within ±" } else { "below " };
            let limit = |l| format!("{side}{}", scientific(l, 3));
            let word = match reason {
                Reason::NoSupport { .. } => single_word(verdict).to_owned(),
                _ => reason.to_string(),
            };
            [value, upper_limit.map_or_else(String::new, limit), word]
        }
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
    let rises = "raises the Allan variance by";
    let fields = [
        Field::shown("kind", "", |d: &Disturbance| {
            Cell::from(match d.kind {
                DisturbanceKind::Step => "step",
                DisturbanceKind::Burst => "burst",
                DisturbanceKind::Lull => "lull",
                DisturbanceKind::Spike => "spike",
            })
        }),
        number("", ("from", "s"), Decimals(2), |d: &Disturbance| {
            d.seconds.0
        }),
        number("", ("to", "s"), Decimals(2), |d: &Disturbance| d.seconds.1),
        number("", ("strength", "σ"), Decimals(1), |d: &Disturbance| {
            d.strength
        }),
        number("", ("needed", "σ"), Decimals(1), |d: &Disturbance| {
            d.threshold
        }),
        number("", (rises, "%"), Decimals(1), |d: &Disturbance| {
            100.0 * d.influence
        }),
    ];
    let shown = worst.into_iter().take(20);
    let table = Table::of("Disturbances, the worst first", fields, shown);
    match found.len().saturating_sub(20) {
        0 => table,
        more => table.note(format!("{more} more are in result.json.")),
    }
}

/// Rows of a table of deviations; more stand in `deviation.csv`.
const TABLE_ROWS: usize = 40;

/// A point of a curve of a channel, with the fitted one beside it.
type Deviation<'a> = (
    (&'a ChannelAnalysis, &'a DeviationCurve, bool),
    (&'a DeviationPoint, Option<&'a FittedPoint>),
);

/// The points of a curve: the model stands beside the one that it was fitted to.
fn points<'a>(
    channel: &'a ChannelAnalysis,
    curve: &'a DeviationCurve,
) -> impl Iterator<Item = Deviation<'a>> {
    let is = |other: &Option<DeviationCurve>| {
        other
            .as_ref()
            .is_some_and(|other| std::ptr::eq(other, curve))
    };
    let compensated = is(&channel.compensated);
    let modelled = compensated || channel.compensated.is_none() && is(&channel.curve);
    let points = curve.points.iter().enumerate();
    points.map(move |(k, p)| {
        let fitted = channel.fitted.get(k).filter(|_| modelled);
        ((channel, curve, compensated), (p, fitted))
    })
}

fn deviation_fields<'a>(name: &str, unit: &str) -> [Field<'a, Deviation<'a>>; 12] {
    type Row<'a> = Deviation<'a>;
    [
        Field::new("channel", |((c, ..), _): &Row<'_>| c.name.as_str().into()),
        Field::new("unit", |((c, curve, _), _): &Row<'_>| {
            curve.statistic.unit(&c.unit).into()
        }),
        Field::new("statistic", |((c, curve, compensated), _): &Row<'_>| {
            let name = curve.statistic.abbreviation();
            let without = match *compensated {
                true => format!(" without {}", c.taken_off()),
                false => String::new(),
            };
            format!("{name}{without}").into()
        }),
        filed("factor", |(_, (p, _)): &Row<'_>| p.factor),
        number(
            "tau_s",
            ("τ", "s"),
            Significant(4),
            |(_, (p, _)): &Row<'_>| p.tau,
        ),
        number(
            "deviation",
            (name, unit),
            Significant(4),
            |(_, (p, _)): &Row<'_>| p.deviation,
        ),
        number(
            "low",
            ("from", unit),
            Significant(4),
            |(_, (p, _)): &Row<'_>| p.interval.map(|i| i.0),
        ),
        number(
            "high",
            ("to", unit),
            Significant(4),
            |(_, (p, _)): &Row<'_>| p.interval.map(|i| i.1),
        ),
        number(
            "edf",
            ("degrees of freedom", ""),
            Freedom,
            |(_, (p, _)): &Row<'_>| p.edf,
        ),
        Field::shown("noise at this τ", "", |(_, (p, _)): &Row<'_>| {
            noise_name(p.noise).into()
        }),
        filed("model", |(_, (_, fitted)): &Row<'_>| {
            fitted.map(|f| f.deviation)
        }),
        filed("inside", |(_, (_, fitted)): &Row<'_>| {
            fitted.map(|f| f64::from(u8::from(f.inside)))
        }),
    ]
}

/// The numbers of a curve.
pub(super) fn deviations(channel: &ChannelAnalysis, curve: &DeviationCurve) -> Table {
    let name = curve.statistic.abbreviation();
    let compensated = channel.compensated.as_ref();
    let without = match compensated.is_some_and(|c| std::ptr::eq(c, curve)) {
        true => format!(" without {}", channel.taken_off()),
        false => String::new(),
    };
    let caption = format!(
        "{name}{without} with {} % intervals",
        scientific(100.0 * curve.probability, 3).trim_end_matches(".0")
    );
    let fields = deviation_fields(name, &curve.statistic.unit(&channel.unit));
    let table = Table::of(caption, fields, points(channel, curve).take(TABLE_ROWS));
    match curve.points.len().saturating_sub(TABLE_ROWS) {
        0 => table,
        more => table.note(format!("{more} more are in deviation.csv.")),
    }
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
    let rows = channel.units.iter().flat_map(|term| {
        term.units.iter().map(|unit| {
            let (symbol, value) = (term.term.symbol().to_owned(), scientific(unit.value, 4));
            [symbol, value, unit.unit.clone(), unit.meaning.clone()]
        })
    });
    let headings = ["coefficient", "value", "unit", "meaning"];
    words("The coefficients in the units in use", headings, rows)
}

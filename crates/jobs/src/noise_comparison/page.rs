//! The report of the noise of several units or runs.

use super::NoiseComparisonOutcome;
use crate::page::columns::{filed, number};
use crate::page::stability::stability;
use proofmass_noise::{
    CheckedLimit, ComparedChannel, ComparedTerm, Conformity, LimitCheck, TermComparison, TermSlope,
    Verdict,
};
use proofmass_report::Rounding::{Decimals, Significant};
use proofmass_report::{
    Axis, Block, Cell, Field, HistogramPlot, KeyFigure, Report, Section, Table, XyPlot, scientific,
};

/// Rows of a table that is not folded away.
const MOST: usize = 60;

/// Curves of a figure that are named.
const NAMED: usize = 8;

pub(super) fn add(mut page: Report, outcome: &NoiseComparisonOutcome) -> Report {
    let (channels, limits) = (&outcome.comparison.channels, &outcome.comparison.limits);
    page = page.verdict(outcome.verdict()).answers(outcome.answer());
    if !limits.is_empty() {
        let section = Section::new("Limits").table(outcome.conformity());
        page = page.section(section.summarised());
    }
    if !channels.is_empty() {
        let section = Section::new("Units beside each other").table(outcome.common());
        let rows = channels.iter().flat_map(|c| outcome.coefficients(c));
        let all = Table::of("", coefficient_fields(), rows).file("coefficients.csv");
        page = page
            .section(section.summarised())
            .section(Section::filed([all]));
    }
    if !outcome.slopes.is_empty() {
        let section = Section::new("Over the temperature").table(outcome.over_temperature());
        page = page.section(section.summarised());
    }
    for channel in channels {
        page = page.section(outcome.channel(channel));
    }
    if !limits.is_empty() {
        page = page.section(outcome.limits());
    }
    page
}

/// What is known of a coefficient of a unit.
type Coefficient<'a> = (&'a ComparedChannel, &'a ComparedTerm, &'a str, &'a Verdict);
/// A unit against a limit.
type Check<'a> = (&'a CheckedLimit, &'a str, Option<LimitCheck>);

fn coefficient_fields<'a>() -> [Field<'a, Coefficient<'a>>; 12] {
    type Row<'a> = Coefficient<'a>;
    fn equal<'a, T>(get: fn(&TermComparison) -> T) -> impl Fn(&Row<'a>) -> Option<T> {
        move |(_, term, ..)| term.equal.as_ref().map(get)
    }
    [
        Field::new("channel", |(c, ..): &Row<'a>| c.name.as_str().into()),
        Field::new("coefficient", |(_, t, ..): &Row<'a>| t.term.symbol().into())
            .page("coefficient", ""),
        Field::new("unit_of_coefficient", |(_, t, ..): &Row<'a>| {
            t.unit.as_str().into()
        })
        .page("unit", ""),
        Field::new("name", |(.., name, _): &Row<'a>| (*name).into()).page("unit under test", ""),
        Field::new("value", |(.., verdict): &Row<'a>| {
            Cell::from(verdict.estimate()).worded(value(verdict.value()))
        })
        .page("value", ""),
        Field::shown("interval, or limit", "", |(.., verdict): &Row<'a>| {
            interval(verdict).into()
        }),
        filed("low", |(.., verdict): &Row<'a>| {
            verdict.interval().map(|i| i.0)
        }),
        filed("high", |(.., verdict): &Row<'a>| match verdict.interval() {
            Some((_, high)) => Some(high),
            None => verdict.upper(),
        }),
        filed("common", equal(|e| e.common)),
        filed("chi_squared", equal(|e| e.statistic)),
        filed("freedom", equal(|e| e.freedom)),
        filed("chance", equal(|e| e.chance)),
    ]
}

/// A table, folded away when it is long.
fn listed(section: Section, title: &str, table: Table) -> Section {
    if table.rows.len() > MOST {
        section.folded(title, [Block::Table(table)])
    } else {
        section.table(table)
    }
}

impl NoiseComparisonOutcome {
    fn percent(&self) -> String {
        let percent = scientific(100.0 * self.probability, 3);
        percent.trim_end_matches(".0").to_owned()
    }

    /// Units within and beyond the limits, all limits together.
    fn counts(&self) -> [usize; 3] {
        let limits = self.comparison.limits.iter().map(CheckedLimit::counts);
        limits.fold([0; 3], |sum, c| [0, 1, 2].map(|k| sum[k] + c[k]))
    }

    /// Comparisons of units, and those that chance alone hardly makes.
    fn differing(&self) -> (usize, usize) {
        let terms = self.comparison.channels.iter().flat_map(|c| &c.terms);
        let chances: Vec<f64> = terms
            .filter_map(|t| Some(t.equal.as_ref()?.chance))
            .collect();
        let rate = self.comparison.false_alarm_rate;
        (chances.len(), chances.iter().filter(|c| **c < rate).count())
    }

    fn verdict(&self) -> String {
        let mut says = Vec::new();
        if !self.comparison.limits.is_empty() {
            says.push(match self.counts() {
                [pass, 0, 0] => format!("Passed: all {pass} coefficients lie within their limits"),
                [pass, 0, n] => format!(
                    "Undecided: {n} of {} coefficients have their limit inside the interval",
                    pass + n
                ),
                [pass, fail, n] => format!(
                    "Failed: {fail} of {} coefficients lie beyond their limits",
                    pass + fail + n
                ),
            });
        }
        match self.differing() {
            (0, _) => {}
            (all, 0) => says.push(format!(
                "the units agree in all {all} coefficients that can be compared"
            )),
            (all, n) => says.push(format!(
                "the units differ by more than chance in {n} of {all} coefficients"
            )),
        }
        let text = says.join("; ");
        match text.chars().next() {
            None => String::new(),
            Some(first) => format!("{}{}.", first.to_uppercase(), &text[first.len_utf8()..]),
        }
    }

    fn answer(&self) -> Vec<KeyFigure> {
        let mut figures = vec![KeyFigure::new("units", self.names.len().to_string(), "")];
        if !self.comparison.limits.is_empty() {
            let words = ["pass", "fail", "undecided"].into_iter().zip(self.counts());
            figures.extend(words.map(|(word, n)| {
                KeyFigure::new(word, n.to_string(), "").note("coefficients against limits")
            }));
        }
        let (all, differing) = self.differing();
        if all > 0 {
            figures.push(
                KeyFigure::new("coefficients that differ", differing.to_string(), "")
                    .note(format!("of {all}, by more than chance")),
            );
        }
        let first = crate::outcome::Outcome::quantities(self)
            .into_iter()
            .find(|q| q.expanded > 0.0);
        figures.extend(first.as_ref().map(crate::page::answer::stated));
        figures
    }

    /// One row to a limit: how many pass.
    fn conformity(&self) -> Table {
        let mut fields = vec![
            Field::shown("channel", "", |l: &CheckedLimit| l.channel.as_str().into()),
            Field::shown("coefficient", "", |l: &CheckedLimit| {
                l.limit.term.symbol().into()
            }),
            Field::shown("limit", "", |l: &CheckedLimit| most(l).into()),
            Field::shown("meaning", "", |l: &CheckedLimit| l.meaning.as_str().into()),
        ];
        let counts = ["pass", "fail", "undecided"].into_iter().enumerate();
        fields.extend(
            counts.map(|(k, word)| {
                Field::shown(word, "", move |l: &CheckedLimit| l.counts()[k].into())
            }),
        );
        Table::of("Coefficients against their limits", fields, &self.comparison.limits).note(format!(
            "Pass: the whole {} % interval lies within the limit; fail: all of it lies beyond; undecided: the limit lies in it. A unit beyond \
             its limit passes with a probability of at most {} %.",
            self.percent(),
            scientific(50.0 * (1.0 - self.probability), 2)
        ))
    }

    /// One row to a coefficient: what suits all units, and whether chance explains their differences.
    fn common(&self) -> Table {
        type Row<'a> = (&'a str, &'a ComparedTerm, &'a TermComparison);
        let fields = [
            Field::shown("channel", "", |(channel, ..): &Row<'_>| (*channel).into()),
            Field::shown("coefficient", "", |(_, t, _): &Row<'_>| {
                t.term.symbol().into()
            }),
            number(
                "",
                ("common value", ""),
                Significant(4),
                |(.., e): &Row<'_>| e.common,
            ),
            Field::shown("interval", "", |(.., e): &Row<'_>| range(e.interval).into()),
            Field::shown("unit", "", |(_, t, _): &Row<'_>| t.unit.as_str().into()),
            number("", ("χ²", ""), Decimals(1), |(.., e): &Row<'_>| {
                e.statistic
            }),
            Field::shown("degrees of freedom", "", |(.., e): &Row<'_>| {
                e.freedom.into()
            }),
            Field::shown("chance", "", |(.., e): &Row<'_>| match e.chance < 1e-6 {
                true => "below 10⁻⁶".into(),
                false => scientific(e.chance, 2).into(),
            }),
        ];
        let channels = self.comparison.channels.iter();
        let terms = channels.flat_map(|c| c.terms.iter().map(move |t| (c.name.as_str(), t)));
        let rows = terms.filter_map(|(channel, t)| Some((channel, t, t.equal.as_ref()?)));
        let caption = "The value that suits all units, and whether they may be equal";
        Table::of(caption, fields, rows).note(format!(
            "Chance: how often equal units differ so much. One coefficient of all is called different where equal ones would be in {} % of \
             comparisons.",
            scientific(100.0 * self.comparison.false_alarm_rate, 2).trim_end_matches(".0")
        ))
    }

    /// One row to a coefficient: its line over the temperature.
    fn over_temperature(&self) -> Table {
        type Row = (String, TermSlope);
        let fields = [
            Field::new("channel", |(channel, _): &Row| channel.as_str().into()).page("channel", ""),
            Field::new("coefficient", |(_, l): &Row| l.term.symbol().into())
                .page("coefficient", ""),
            filed("temperature_degC", |(_, l): &Row| l.temperature),
            number(
                "value",
                ("at the mean temperature", ""),
                Significant(4),
                |(_, l): &Row| l.value,
            ),
            number(
                "slope",
                ("per kelvin", ""),
                Significant(3),
                |(_, l): &Row| l.slope,
            ),
            Field::shown("interval", "", |(_, l): &Row| range(l.interval).into()),
            filed("slope_low", |(_, l): &Row| l.interval.0),
            filed("slope_high", |(_, l): &Row| l.interval.1),
            Field::new("unit_of_coefficient", |(_, l): &Row| l.unit.as_str().into())
                .page("unit", ""),
            Field::new("chance", |(_, l): &Row| {
                Cell::from(l.chance).worded(l.chance.map_or("–".to_owned(), |c| scientific(c, 2)))
            })
            .page("chance of the line", ""),
        ];
        Table::of("Straight lines of the coefficients over the temperature", fields, &self.slopes)
            .note("Chance of the line: how often recordings whose coefficient follows a line depart from it so much; of two recordings nothing can be said.")
            .file("temperature.csv")
    }

    fn coefficients<'a>(
        &'a self,
        channel: &'a ComparedChannel,
    ) -> impl Iterator<Item = Coefficient<'a>> {
        channel.terms.iter().flat_map(move |term| {
            let units = channel.units.iter().zip(&term.verdicts);
            units.map(move |(unit, verdict)| (channel, term, self.names[*unit].as_str(), verdict))
        })
    }

    fn channel(&self, channel: &ComparedChannel) -> Section {
        let mut section = Section::new(format!("Channel {}", channel.name));
        if let Some(plot) = self.curves(channel) {
            section = section.figure("Allan deviations of all units with their intervals", plot);
        }
        let caption = format!("Coefficients with their {} % intervals", self.percent());
        let table = Table::of(caption, coefficient_fields(), self.coefficients(channel));
        listed(section, "All coefficients", table)
    }

    fn curves(&self, channel: &ComparedChannel) -> Option<XyPlot> {
        let first = channel.curves.iter().flatten().next()?;
        let mut plot = XyPlot::new(
            Axis::log("averaging time τ", "s"),
            Axis::log(first.statistic.abbreviation(), channel.unit.clone()),
        )
        .height(320.0);
        for (unit, curve) in channel.units.iter().zip(&channel.curves) {
            let Some(curve) = curve else { continue };
            let named = channel.units.len() <= NAMED;
            let mut series = stability(if named { &self.names[*unit] } else { "" }, curve);
            if !named {
                series.bars = None;
            }
            plot = plot.series(series);
        }
        Some(plot)
    }

    fn limits(&self) -> Section {
        let mut section = Section::new("Units against the limits");
        for limit in &self.comparison.limits {
            if let Some(plot) = histogram(limit) {
                let (channel, symbol) = (&limit.channel, limit.limit.term.symbol());
                let caption = format!("{channel} {symbol}, most likely values of all units");
                section = section.figure(caption, plot);
            }
        }
        let fields = [
            Field::new("channel", |(l, ..): &Check<'_>| l.channel.as_str().into())
                .page("channel", ""),
            Field::new("coefficient", |(l, ..): &Check<'_>| {
                l.limit.term.symbol().into()
            })
            .page("coefficient", ""),
            Field::new("limit", |(l, ..): &Check<'_>| {
                Cell::printed(l.limit.most, most(l))
            })
            .page("limit", ""),
            Field::new("unit", |(l, ..): &Check<'_>| l.limit.unit.as_str().into()),
            Field::new("meaning", |(l, ..): &Check<'_>| l.meaning.as_str().into()),
            Field::new("name", |(_, name, _): &Check<'_>| (*name).into())
                .page("unit under test", ""),
            Field::new("value", |(.., check): &Check<'_>| {
                let known = check.and_then(|c| c.value);
                Cell::from(known).worded(value(known))
            })
            .page("value", ""),
            Field::shown("interval", "", |(.., c): &Check<'_>| {
                c.map(|c| range(c.interval)).into()
            }),
            filed("low", |(.., c): &Check<'_>| c.map(|c| c.interval.0)),
            filed("high", |(.., c): &Check<'_>| c.map(|c| c.interval.1)),
            Field::new("conformity", |(.., c): &Check<'_>| {
                Cell::from(match c.map(|c| c.conformity) {
                    Some(Conformity::Pass) => "pass",
                    Some(Conformity::Fail) => "fail",
                    _ => "undecided",
                })
            })
            .page("verdict", ""),
        ];
        let limits = self.comparison.limits.iter();
        let checks = limits.flat_map(|l| l.checks.iter().map(move |check| (l, check)));
        let rows = checks.map(|(l, (unit, check))| (l, self.names[*unit].as_str(), *check));
        let caption = format!("Every unit with its {} % interval", self.percent());
        let table = Table::of(caption, fields, rows).file("limits.csv");
        listed(section, "All units", table)
    }
}

fn range((low, high): (f64, f64)) -> String {
    format!("{} to {}", scientific(low, 4), scientific(high, 4))
}

fn most(limit: &CheckedLimit) -> String {
    let limit = &limit.limit;
    format!("{} {}", scientific(limit.most, 4), limit.unit)
}

fn value(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |v| scientific(v, 4))
}

fn interval(verdict: &Verdict) -> String {
    match (verdict.value(), verdict.interval(), verdict.upper()) {
        (Some(_), Some(interval), _) => range(interval),
        (Some(_), None, _) => "given".to_owned(),
        (None, _, Some(limit)) => format!("below {}", scientific(limit, 3)),
        (None, _, None) => String::new(),
    }
}

/// Most likely values of the units, the limit marked.
fn histogram(limit: &CheckedLimit) -> Option<HistogramPlot> {
    let (edges, counts) = limit.histogram()?;
    let name = format!("{} of {}", limit.limit.term.symbol(), limit.channel);
    Some(
        HistogramPlot::new(
            Axis::linear(name, limit.limit.unit.clone()),
            Axis::linear("units", ""),
            &edges,
            &counts,
        )
        .mark(limit.limit.most, "limit"),
    )
}

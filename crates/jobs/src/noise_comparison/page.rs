//! The report of the noise of several units or runs.

use proofmass_noise::{CheckedLimit, ComparedChannel, Conformity, UnitComparison, Verdict};
use proofmass_report::{
    Axis, Block, Cell, Column, Head, HistogramPlot, Report, Section, Series, Table, XyPlot,
    scientific,
};

/// What the report tells of units beside each other.
#[derive(Clone, Debug)]
pub(crate) struct NoiseComparisonReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// What the units are called.
    pub names: &'a [String],
    /// Probability of the intervals.
    pub probability: f64,
    /// What was compared.
    pub comparison: &'a UnitComparison,
}

/// Rows of a table that is not folded away.
const MOST: usize = 60;

/// Curves of a figure that are named.
const NAMED: usize = 8;

impl NoiseComparisonReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self) -> Report {
        let mut report = self.summary();
        for channel in &self.comparison.channels {
            report = report.section(self.channel(channel));
        }
        if !self.comparison.limits.is_empty() {
            report = report.section(self.limits());
        }
        report.foot(&self.head)
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self) -> Report {
        let mut report = self.head.open();
        if !self.comparison.limits.is_empty() {
            report = report.section(Section::new("Limits").table(self.conformity()));
        }
        if !self.comparison.channels.is_empty() {
            report = report.section(Section::new("Units beside each other").table(self.common()));
        }
        report.findings(self.head.findings.iter().cloned())
    }

    fn percent(&self) -> String {
        let percent = scientific(100.0 * self.probability, 3);
        percent.trim_end_matches(".0").to_owned()
    }

    /// One row to a limit: how many pass.
    fn conformity(&self) -> Table {
        let mut table = Table::new(
            "Coefficients against their limits",
            [
                Column::text("channel"),
                Column::text("coefficient"),
                Column::text("limit"),
                Column::text("meaning"),
                Column::number("pass", ""),
                Column::number("fail", ""),
                Column::number("undecided", ""),
            ],
        );
        for limit in &self.comparison.limits {
            let [pass, fail, undecided] = limit.counts();
            table = table.row([
                Cell::text(limit.channel.clone()),
                Cell::text(limit.limit.term.symbol()),
                Cell::text(format!(
                    "{} {}",
                    scientific(limit.limit.most, 4),
                    limit.limit.unit
                )),
                Cell::text(limit.meaning.clone()),
                Cell::number(pass.to_string()),
                Cell::number(fail.to_string()),
                Cell::number(undecided.to_string()),
            ]);
        }
        table.note(format!(
            "Pass: the whole {} % interval lies within the limit; fail: all of it lies beyond; undecided: the limit lies in it. A unit beyond \
             its limit passes with a probability of at most {} %.",
            self.percent(),
            scientific(50.0 * (1.0 - self.probability), 2)
        ))
    }

    /// One row to a coefficient: what suits all units, and whether chance explains their differences.
    fn common(&self) -> Table {
        let mut table = Table::new(
            "The value that suits all units, and whether they may be equal",
            [
                Column::text("channel"),
                Column::text("coefficient"),
                Column::text("common value"),
                Column::text("interval"),
                Column::text("unit"),
                Column::number("χ²", ""),
                Column::number("degrees of freedom", ""),
                Column::text("chance"),
            ],
        );
        for channel in &self.comparison.channels {
            for term in &channel.terms {
                let Some(equal) = &term.equal else { continue };
                table = table.row([
                    Cell::text(channel.name.clone()),
                    Cell::text(term.term.symbol()),
                    Cell::text(scientific(equal.common, 4)),
                    Cell::text(range(equal.interval)),
                    Cell::text(term.unit.clone()),
                    Cell::number(format!("{:.1}", equal.statistic)),
                    Cell::number(equal.freedom.to_string()),
                    Cell::text(if equal.chance < 1e-6 {
                        "below 10⁻⁶".to_owned()
                    } else {
                        scientific(equal.chance, 2)
                    }),
                ]);
            }
        }
        table.note(format!(
            "Chance: how often equal units differ so much. One coefficient of all is called different where equal ones would be in {} % of \
             comparisons.",
            scientific(100.0 * self.comparison.false_alarm_rate, 2).trim_end_matches(".0")
        ))
    }

    fn channel(&self, channel: &ComparedChannel) -> Section {
        let mut section = Section::new(format!("Channel {}", channel.name));
        if let Some(plot) = self.curves(channel) {
            section = section.figure("Allan deviations of all units with their intervals", plot);
        }
        let mut table = Table::new(
            format!("Coefficients with their {} % intervals", self.percent()),
            [
                Column::text("coefficient"),
                Column::text("unit under test"),
                Column::text("value"),
                Column::text("interval, or limit"),
                Column::text("unit"),
            ],
        );
        let mut rows = 0;
        for term in &channel.terms {
            for (unit, verdict) in channel.units.iter().zip(&term.verdicts) {
                let (value, interval) = words(verdict);
                table = table.row([
                    Cell::text(term.term.symbol()),
                    Cell::text(self.names[*unit].clone()),
                    Cell::text(value),
                    Cell::text(interval),
                    Cell::text(term.unit.clone()),
                ]);
                rows += 1;
            }
        }
        if rows > MOST {
            section.folded("All coefficients", [Block::Table(table)])
        } else {
            section.table(table)
        }
    }

    fn curves(&self, channel: &ComparedChannel) -> Option<XyPlot> {
        let first = channel.curves.iter().flatten().next()?;
        let mut plot = XyPlot::new(
            Axis::log("averaging time τ", "s"),
            Axis::log(first.statistic.abbreviation(), channel.unit.clone()),
        )
        .height(380.0);
        for (unit, curve) in channel.units.iter().zip(&channel.curves) {
            let points: Vec<_> = curve
                .iter()
                .flat_map(|c| &c.points)
                .filter(|p| p.deviation > 0.0)
                .collect();
            let tau: Vec<f64> = points.iter().map(|p| p.tau).collect();
            let value: Vec<f64> = points.iter().map(|p| p.deviation).collect();
            let side = |pick: fn((f64, f64)) -> f64| -> Vec<f64> {
                let of =
                    |p: &&proofmass_noise::DeviationPoint| p.interval.map_or(p.deviation, pick);
                points.iter().map(of).collect()
            };
            let name = match channel.units.len() {
                0..=NAMED => self.names[*unit].as_str(),
                _ => "",
            };
            let series = Series::line(name, &tau, &value);
            plot = plot.series(match channel.units.len() {
                0..=NAMED => series.bars(&side(|i| i.0), &side(|i| i.1)),
                _ => series,
            });
        }
        Some(plot)
    }

    fn limits(&self) -> Section {
        let mut section = Section::new("Units against the limits");
        let mut table = Table::new(
            format!("Every unit with its {} % interval", self.percent()),
            [
                Column::text("unit under test"),
                Column::text("channel"),
                Column::text("coefficient"),
                Column::text("value"),
                Column::text("interval"),
                Column::text("limit"),
                Column::text("verdict"),
            ],
        );
        let mut rows = 0;
        for limit in &self.comparison.limits {
            if let Some(plot) = histogram(limit) {
                section = section.figure(
                    format!(
                        "{} {}, most likely values of all units",
                        limit.channel,
                        limit.limit.term.symbol()
                    ),
                    plot,
                );
            }
            for (unit, check) in &limit.checks {
                table = table.row([
                    Cell::text(self.names[*unit].clone()),
                    Cell::text(limit.channel.clone()),
                    Cell::text(limit.limit.term.symbol()),
                    Cell::text(
                        check
                            .and_then(|c| c.value)
                            .map_or("–".to_owned(), |v| scientific(v, 4)),
                    ),
                    Cell::text(check.map_or(String::new(), |c| range(c.interval))),
                    Cell::text(format!(
                        "{} {}",
                        scientific(limit.limit.most, 4),
                        limit.limit.unit
                    )),
                    Cell::text(match check.map(|c| c.conformity) {
                        Some(Conformity::Pass) => "pass",
                        Some(Conformity::Fail) => "fail",
                        _ => "undecided",
                    }),
                ]);
                rows += 1;
            }
        }
        if rows > MOST {
            section.folded("All units", [Block::Table(table)])
        } else {
            section.table(table)
        }
    }
}

fn range((low, high): (f64, f64)) -> String {
    format!("{} to {}", scientific(low, 4), scientific(high, 4))
}

fn words(verdict: &Verdict) -> (String, String) {
    match (verdict.value(), verdict.interval(), verdict.upper()) {
        (Some(value), Some(interval), _) => (scientific(value, 4), range(interval)),
        (Some(value), None, _) => (scientific(value, 4), "given".to_owned()),
        (None, _, Some(limit)) => ("–".to_owned(), format!("below {}", scientific(limit, 3))),
        (None, _, None) => ("–".to_owned(), String::new()),
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

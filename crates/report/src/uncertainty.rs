//! The report of a measurement model: result, budget, Monte Carlo check.

use crate::{
    Axis, BarPlot, Cell, Column, HistogramPlot, KeyFigure, MatrixPlot, Report, Section, Series,
    Table, scientific,
};
use proofmass_uncertainty::{ModelResult, OutputResult, Rounded, Verdict};

/// What the report tells beside the result itself.
#[derive(Clone, Debug, Default)]
pub struct UncertaintyReport {
    /// Title.
    pub title: String,
    /// Label and value.
    pub meta: Vec<(String, String)>,
    /// Name and SHA-256 of each input file.
    pub inputs: Vec<(String, String)>,
    /// Name and formula of the intermediate quantities.
    pub intermediate: Vec<(String, String)>,
    /// The inputs as the model states them.
    pub given: Vec<GivenInput>,
    /// Last line.
    pub footer: String,
}

/// One input as the model states it.
#[derive(Clone, Debug, Default)]
pub struct GivenInput {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// What it is.
    pub description: String,
    /// Distribution with its parameters, or the observations.
    pub known: String,
}

impl UncertaintyReport {
    /// The whole report.
    pub fn full(&self, result: &ModelResult) -> Report {
        let mut report = self.head(result).section(
            Section::new("Result")
                .key_figures(key_figures(result))
                .table(results(result))
                .table(self.equations(result)),
        );
        for output in &result.outputs {
            report = report.section(detail(result, output));
        }
        if result.outputs.len() > 1 {
            report = report.section(joint(result));
        }
        report
            .section(self.provenance(result))
            .footer(self.footer.clone())
    }

    /// What is worth a look in the terminal.
    pub fn summary(&self, result: &ModelResult) -> Report {
        let mut section = Section::new("Result").table(results(result));
        for output in &result.outputs {
            section = section
                .table(budget(output))
                .table(comparison(result, output));
        }
        self.head(result).section(section)
    }

    fn head(&self, result: &ModelResult) -> Report {
        let mut report = Report::new(self.title.clone());
        for (label, value) in &self.meta {
            report = report.meta(label.clone(), value.clone());
        }
        report.findings(result.findings.iter().cloned())
    }

    fn equations(&self, result: &ModelResult) -> Table {
        let mut table = Table::new(
            "Equations",
            [Column::text("quantity"), Column::text("formula")],
        );
        for (name, formula) in &self.intermediate {
            table = table.row([Cell::text(name.clone()), Cell::text(formula.clone())]);
        }
        for output in &result.outputs {
            table = table.row([
                Cell::text(output.quantity.name.clone()),
                Cell::text(output.expression.clone()),
            ]);
        }
        table
    }

    fn provenance(&self, result: &ModelResult) -> Section {
        let mut table = Table::new("Files", [Column::text("file"), Column::text("SHA-256")]);
        for (name, digest) in &self.inputs {
            table = table.row([Cell::text(name.clone()), Cell::text(digest.clone())]);
        }
        let mut given = Table::new(
            "What is known of the inputs",
            [
                Column::text("input"),
                Column::text("unit"),
                Column::text("distribution or observations"),
                Column::text("description"),
            ],
        );
        for input in &self.given {
            given = given.row([
                Cell::text(input.name.clone()),
                Cell::text(input.unit.clone()),
                Cell::text(input.known.clone()),
                Cell::text(input.description.clone()),
            ]);
        }
        let mut section = Section::new("Inputs and method").table(given);
        if !result.input_correlations.is_empty() {
            let mut pairs = Table::new(
                "Correlations of the inputs, given or observed",
                [
                    Column::text("between"),
                    Column::text("and"),
                    Column::number("coefficient", ""),
                ],
            );
            for pair in &result.input_correlations {
                let [first, second] = &pair.between;
                pairs = pairs.row([
                    Cell::text(first.clone()),
                    Cell::text(second.clone()),
                    Cell::number(scientific(pair.coefficient, 3)),
                ]);
            }
            section = section.table(pairs);
        }
        section
            .table(table)
            .paragraph(format!(
                "Law of propagation of uncertainty with the joint covariance of the inputs, coverage factors from \
                 Student's t at the effective degrees of freedom (JCGM 100:2008). Propagation of distributions by \
                 {} Monte Carlo trials, seed {} (JCGM 101:2008 and 102:2011).",
                result.trials, result.options.seed
            ))
    }
}

fn key_figures(result: &ModelResult) -> Vec<KeyFigure> {
    let held = result
        .outputs
        .iter()
        .filter(|o| o.validation.verdict == Verdict::Validated)
        .count();
    let mut figures = Vec::new();
    if let [output] = result.outputs.as_slice() {
        let q = &output.quantity;
        figures.push(if use_trials(output) {
            let interval = output.monte_carlo.symmetric;
            let end = |v| at_place(v, q.standard_uncertainty, result.options.digits);
            KeyFigure::new(
                q.name.clone(),
                format!("{} to {}", end(interval.lower), end(interval.upper)),
                shown(&q.unit),
            )
            .note(format!(
                "{} % interval by Monte Carlo",
                percent(result.options.probability)
            ))
        } else {
            KeyFigure::new(
                q.name.clone(),
                crate::concise(q.value, q.standard_uncertainty),
                shown(&q.unit),
            )
            .note("standard uncertainty in parentheses")
        });
    }
    figures.push(
        KeyFigure::new(
            "linear result",
            if held == result.outputs.len() {
                "validated".to_owned()
            } else if let [output] = result.outputs.as_slice() {
                verdict(output).to_owned()
            } else {
                format!("validated for {held} of {}", result.outputs.len())
            },
            "",
        )
        .note("by Monte Carlo, JCGM 101 clause 8"),
    );
    figures.push(KeyFigure::new("trials", result.trials.to_string(), ""));
    figures
}

/// Each output by the method that may be used: the law of propagation, or Monte Carlo where that is not validated.
fn results(result: &ModelResult) -> Table {
    let mut table = Table::new(
        format!(
            "Results with intervals at {} %, by the law of propagation where Monte Carlo does not contradict it",
            percent(result.options.probability)
        ),
        [
            Column::text("quantity"),
            Column::number("value", ""),
            Column::number("u", ""),
            Column::number("lower end", ""),
            Column::number("upper end", ""),
            Column::text("unit"),
            Column::number("k", ""),
            Column::number("ν_eff", ""),
            Column::text("linear result"),
        ],
    );
    for output in &result.outputs {
        let q = &output.quantity;
        let u = q.standard_uncertainty;
        let number = |v: f64| Cell::number(at_place(v, u, result.options.digits));
        let numbers = if use_trials(output) {
            let sampled = &output.monte_carlo;
            let interval = sampled.symmetric;
            [
                sampled.mean,
                sampled.standard_uncertainty,
                interval.lower,
                interval.upper,
            ]
        } else {
            let expanded = output.expanded_uncertainty;
            [q.value, u, q.value - expanded, q.value + expanded]
        };
        let [value, u, lower, upper] = numbers.map(number);
        let [k, nu] = if use_trials(output) {
            [Cell::Empty, Cell::Empty]
        } else {
            [
                Cell::number(format!("{:.2}", output.coverage_factor)),
                Cell::number(degrees(q.dof.get())),
            ]
        };
        table = table.row([
            Cell::text(q.name.clone()),
            value,
            u,
            lower,
            upper,
            Cell::text(shown(&q.unit)),
            k,
            nu,
            Cell::text(verdict(output)),
        ]);
    }
    table
}

/// Whether the result to report is that of the trials.
fn use_trials(output: &OutputResult) -> bool {
    output.validation.verdict == Verdict::NotValidated
}

fn detail(result: &ModelResult, output: &OutputResult) -> Section {
    let mut bars = BarPlot::shares(format!("share of the variance of {}", output.quantity.name));
    for line in &output.budget {
        bars = bars.bar(line.key.clone(), line.share, "");
    }
    let mut section = Section::new(format!("Uncertainty of {}", output.quantity.name))
        .figure("Causes of uncertainty", bars)
        .table(budget(output))
        .table(comparison(result, output));
    if let Some(plot) = histogram(output) {
        section = section.figure(
            format!(
                "Distribution of {} from {} trials, with the density that the law of propagation implies; marks: \
                 ends of the linear interval and of the symmetric Monte Carlo interval at {} %",
                output.quantity.name,
                result.trials,
                percent(result.options.probability)
            ),
            plot,
        );
    }
    section
}

fn budget(output: &OutputResult) -> Table {
    let unit = &output.quantity.unit;
    let mut table = Table::new(
        format!("Budget of {}", output.quantity.name),
        [
            Column::text("input"),
            Column::number("estimate", ""),
            Column::number("u", ""),
            Column::text("unit"),
            Column::text("distribution"),
            Column::number("ν", ""),
            Column::number("sensitivity", ""),
            Column::number("contribution", shown(unit)),
            Column::number("share", "%"),
        ],
    );
    for line in &output.budget {
        let [estimate, u, unit, sensitivity] = match &line.input {
            Some(input) => [
                Cell::number(at_place(input.value, input.standard_uncertainty, 2)),
                Cell::number(scientific(input.standard_uncertainty, 2)),
                Cell::text(shown(&input.unit)),
                Cell::number(scientific(input.sensitivity, 3)),
            ],
            None => [Cell::Empty, Cell::Empty, Cell::Empty, Cell::Empty],
        };
        table = table.row([
            Cell::text(line.key.clone()),
            estimate,
            u,
            unit,
            Cell::text(line.distribution.clone()),
            Cell::number(degrees(line.dof.get())),
            sensitivity,
            Cell::number(scientific(line.contribution.abs(), 2)),
            Cell::number(format!("{:.1}", 100.0 * line.share)),
        ]);
    }
    let causes: Vec<String> = output
        .budget
        .iter()
        .filter(|line| line.description != line.key)
        .map(|line| format!("{}: {}", line.key, line.description))
        .collect();
    if causes.is_empty() {
        table
    } else {
        table.note(format!("{}.", causes.join("; ")))
    }
}

fn comparison(result: &ModelResult, output: &OutputResult) -> Table {
    let q = &output.quantity;
    let sampled = &output.monte_carlo;
    let digits = result.options.digits;
    let mut table = Table::new(
        format!("Law of propagation and Monte Carlo for {}", q.name),
        [
            Column::text("method"),
            Column::number("value", shown(&q.unit)),
            Column::number("u", shown(&q.unit)),
            Column::number("lower end", shown(&q.unit)),
            Column::number("upper end", shown(&q.unit)),
        ],
    );
    let u = if q.standard_uncertainty > 0.0 {
        q.standard_uncertainty
    } else {
        sampled.standard_uncertainty
    };
    let number = |v: f64| Cell::number(at_place(v, u, digits));
    let mut row = |name: &str, value: f64, spread: f64, lower: f64, upper: f64| {
        table = std::mem::take(&mut table).row([
            Cell::text(name),
            number(value),
            number(spread),
            number(lower),
            number(upper),
        ]);
    };
    let expanded = output.expanded_uncertainty;
    row(
        "law of propagation",
        q.value,
        q.standard_uncertainty,
        q.value - expanded,
        q.value + expanded,
    );
    let second = &output.second_order;
    let centre = q.value + second.shift;
    let spread = output.coverage_factor * second.standard_uncertainty;
    row(
        "with terms of second order",
        centre,
        second.standard_uncertainty,
        centre - spread,
        centre + spread,
    );
    for (name, interval) in [
        ("Monte Carlo, symmetric interval", sampled.symmetric),
        ("Monte Carlo, shortest interval", sampled.shortest),
    ] {
        row(
            name,
            sampled.mean,
            sampled.standard_uncertainty,
            interval.lower,
            interval.upper,
        );
    }
    table.note(statement(output))
}

/// The comparison of clause 8 in words.
fn statement(output: &OutputResult) -> String {
    let validation = &output.validation;
    let unit = shown(&output.quantity.unit);
    format!(
        "The ends of the linear and the symmetric Monte Carlo interval differ by {} and {} {unit}; δ = {} {unit} is \
         allowed: the linear result is {}.",
        scientific(validation.lower, 2),
        scientific(validation.upper, 2),
        scientific(validation.tolerance, 1),
        match validation.verdict {
            Verdict::Validated => "validated",
            Verdict::NotValidated => "not validated; use the Monte Carlo interval",
            Verdict::Undecided => "neither validated nor refuted, for the trials scatter too much",
        }
    )
    .replace(" ;", ";")
    .replace(" :", ":")
}

fn verdict(output: &OutputResult) -> &'static str {
    match output.validation.verdict {
        Verdict::Validated => "validated",
        Verdict::NotValidated => "not validated",
        Verdict::Undecided => "undecided",
    }
}

/// Density of the trials with the linear density over it; `None` for an output that does not vary.
fn histogram(output: &OutputResult) -> Option<HistogramPlot> {
    let q = &output.quantity;
    let counted = &output.monte_carlo.histogram;
    if !(counted.width > 0.0) || counted.counts.is_empty() {
        return None;
    }
    // Empty bins at both sides would only make the picture small.
    let first = counted.counts.iter().position(|c| *c > 0)?;
    let last = counted.counts.iter().rposition(|c| *c > 0)?;
    let bins = &counted.counts[first..=last];
    let edge = |i: usize| counted.start + (first + i) as f64 * counted.width;
    let edges: Vec<f64> = (0..=bins.len()).map(edge).collect();
    let all = counted.counts.iter().sum::<u64>() + counted.outside.0 + counted.outside.1;
    let heights: Vec<f64> = bins
        .iter()
        .map(|c| *c as f64 / (all as f64 * counted.width))
        .collect();
    let per_unit = match shown(&q.unit) {
        "" => String::new(),
        unit => format!("1/({unit})"),
    };
    let mut plot = HistogramPlot::new(
        Axis::linear(q.name.clone(), shown(&q.unit)),
        Axis::linear("density", per_unit),
        &edges,
        &heights,
    );
    let steps = 400;
    let curve: Option<(Vec<f64>, Vec<f64>)> = (0..=steps)
        .map(|i| {
            let x = edges[0] + (edges[bins.len()] - edges[0]) * i as f64 / steps as f64;
            Some((x, q.density(x)?))
        })
        .collect();
    if let Some((x, y)) = curve {
        let name = if q.dof.is_infinite() {
            "normal density".to_owned()
        } else {
            format!("Student t density, ν = {}", degrees(q.dof.get()))
        };
        plot = plot.curve(Series::line(name, &x, &y));
    }
    let expanded = output.expanded_uncertainty;
    let symmetric = output.monte_carlo.symmetric;
    for (at, label) in [
        (q.value - expanded, "linear"),
        (q.value + expanded, "linear"),
        (symmetric.lower, "Monte Carlo"),
        (symmetric.upper, "Monte Carlo"),
    ] {
        plot = plot.mark(at, label);
    }
    Some(plot)
}

fn joint(result: &ModelResult) -> Section {
    let names: Vec<&str> = result
        .outputs
        .iter()
        .map(|o| o.quantity.name.as_str())
        .collect();
    let mut section = Section::new("Joint result").figure(
        "Correlation of the quantities by the law of propagation",
        MatrixPlot::correlation(&names, result.estimate.covariance()),
    );
    if let Some(region) = &result.region {
        section = section.paragraph(format!(
            "The joint {} % region from the trials is the ellipsoid with k = {:.2} (area or volume {}{}).",
            percent(result.options.probability),
            region.ellipsoid_factor,
            scientific(region.ellipsoid_content, 3),
            match region.smallest_content {
                Some(content) => format!("; the smallest region has {}", scientific(content, 3)),
                None => String::new(),
            }
        ));
    }
    section
}

/// A value rounded to the place that the digits of u give.
fn at_place(value: f64, u: f64, digits: u32) -> String {
    match Rounded::new(value, u, digits as usize) {
        Some(rounded) if rounded.exponent == 0 => rounded.value,
        Some(rounded) => format!("{}e{}", rounded.value, rounded.exponent),
        None => scientific(value, 6),
    }
}

fn degrees(nu: f64) -> String {
    if nu.is_infinite() || nu > 1e6 {
        "∞".to_owned()
    } else if nu < 100.0 && nu.fract().abs() > 1e-9 {
        format!("{nu:.2}")
    } else {
        format!("{nu:.0}")
    }
}

/// A pure number has no unit to show.
fn shown(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

/// A percentage without trailing zeros.
fn percent(probability: f64) -> String {
    let text = format!("{:.7}", 100.0 * probability);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

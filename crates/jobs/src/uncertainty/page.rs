//! The report of a measurement model: result, budget, Monte Carlo check.

use proofmass_report::{
    Axis, BarPlot, Cell, Column, Head, HistogramPlot, KeyFigure, MatrixPlot, Report, Section,
    Series, Table, scientific,
};
use proofmass_uncertainty::{
    BudgetLine, LinearOutput, ModelResult, OutputResult, Rounded, Statement, StatementMethod,
    Verdict,
};

/// What the report tells beside the result itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct UncertaintyReport<'a> {
    /// Title, device, inputs, findings.
    pub head: Head<'a>,
    /// Name and formula of the intermediate quantities.
    pub intermediate: Vec<(String, String)>,
    /// The inputs as the model states them.
    pub given: Vec<GivenInput>,
}

/// One input as the model states it.
#[derive(Clone, Debug, Default)]
pub(crate) struct GivenInput {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// What it is.
    pub description: String,
    /// Distribution with its parameters, or the observations.
    pub known: String,
}

impl UncertaintyReport<'_> {
    /// The whole report.
    pub(crate) fn full(&self, result: &ModelResult) -> Report {
        let mut report = self.head().section(
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
            .footer(self.head.footer.clone())
    }

    /// What is worth a look in the terminal.
    pub(crate) fn summary(&self, result: &ModelResult) -> Report {
        let mut section = Section::new("Result").table(results(result));
        for output in &result.outputs {
            if let Some(linear) = &output.linear {
                section = section.table(budget(linear));
            }
            section = section.table(comparison(result, output));
            if let Some(table) = effects(output) {
                section = section.table(table);
            }
        }
        if let Some(table) = correlations(result) {
            section = section.table(table);
        }
        self.head().section(section)
    }

    fn head(&self) -> Report {
        let report = self.head.open();
        report.findings(self.head.findings.iter().cloned())
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
                Cell::text(output.name.clone()),
                Cell::text(output.expression.clone()),
            ]);
        }
        table
    }

    fn provenance(&self, result: &ModelResult) -> Section {
        let mut table = Table::new("Files", [Column::text("file"), Column::text("SHA-256")]);
        for (name, digest) in &self.head.inputs {
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
    let checked = |o: &&OutputResult| {
        let validation = o.validation.as_ref();
        validation.is_some_and(|v| v.verdict == Verdict::Validated)
    };
    let held = result.outputs.iter().filter(checked).count();
    let mut figures = Vec::new();
    if let [output] = result.outputs.as_slice() {
        let stated = &output.stated;
        let digits = result.options.digits;
        let note = format!(
            "{} % interval by {}",
            percent(stated.probability),
            road(stated.method)
        );
        figures.push(
            KeyFigure::new(
                stated.name.clone(),
                statement(stated, digits),
                shown(&stated.unit),
            )
            .note(match stated.coverage_factor {
                Some(k) if stated.method == StatementMethod::LawOfPropagation => {
                    format!("{note}, k = {k:.2}")
                }
                _ => note,
            }),
        );
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

/// `10000.025 ± 0.059` by the law of propagation, `1.084 to 1.383` by Monte Carlo.
fn statement(stated: &Statement, digits: u32) -> String {
    let half = stated.expanded_uncertainty;
    match (
        stated.method,
        Rounded::new(stated.value, half, digits as usize),
    ) {
        (StatementMethod::LawOfPropagation, Some(rounded)) if half > 0.0 => {
            let both = format!("{} ± {}", rounded.value, rounded.uncertainty);
            if rounded.exponent == 0 {
                both
            } else {
                format!("({both})e{}", rounded.exponent)
            }
        }
        (StatementMethod::LawOfPropagation, _) => scientific(stated.value, 6),
        _ => {
            let end = |v| at_place(v, half, digits);
            format!(
                "{} to {}",
                end(stated.interval.lower),
                end(stated.interval.upper)
            )
        }
    }
}

fn road(method: StatementMethod) -> &'static str {
    match method {
        StatementMethod::LawOfPropagation => "the law of propagation",
        _ => "Monte Carlo",
    }
}

/// Each output as it is stated.
fn results(result: &ModelResult) -> Table {
    // A stated factor has another probability at each number of degrees of freedom.
    let fixed = result.options.coverage_factor;
    let road = "by the law of propagation where Monte Carlo does not contradict it";
    let mut columns = vec![
        Column::text("quantity"),
        Column::number("value", ""),
        Column::number("u", ""),
        Column::number("U", ""),
        Column::number("lower end", ""),
        Column::number("upper end", ""),
        Column::text("unit"),
        Column::number("k", ""),
        Column::number("ν_eff", ""),
    ];
    if fixed.is_some() {
        columns.push(Column::number("p", "%"));
    }
    columns.push(Column::text("linear result"));
    let mut table = Table::new(
        match fixed {
            Some(k) => {
                format!("Results with k = {k}, {road}; p is the probability of the interval")
            }
            None => format!(
                "Results with intervals at {} %, {road}",
                percent(result.options.probability)
            ),
        },
        columns,
    );
    for output in &result.outputs {
        let stated = &output.stated;
        let scale = stated
            .standard_uncertainty
            .filter(|u| *u > 0.0)
            .unwrap_or(0.5 * stated.expanded_uncertainty);
        let number = |v: f64| Cell::number(at_place(v, scale, result.options.digits));
        let half = match stated.method {
            StatementMethod::LawOfPropagation => number(stated.expanded_uncertainty),
            _ => Cell::Empty,
        };
        let [k, nu] = match stated.dof {
            None => [Cell::Empty, Cell::Empty],
            Some(dof) => [
                Cell::number(
                    stated
                        .coverage_factor
                        .map_or_else(String::new, |k| format!("{k:.2}")),
                ),
                Cell::number(degrees(dof.get())),
            ],
        };
        let mut row = vec![
            Cell::text(stated.name.clone()),
            number(stated.value),
            stated.standard_uncertainty.map_or(Cell::Empty, number),
            half,
            number(stated.interval.lower),
            number(stated.interval.upper),
            Cell::text(shown(&stated.unit)),
            k,
            nu,
        ];
        if fixed.is_some() {
            row.push(Cell::number(format!("{:.1}", 100.0 * stated.probability)));
        }
        row.push(Cell::text(verdict(output)));
        table = table.row(row);
    }
    table
}

/// Correlation coefficients of the outputs by the law of propagation.
fn correlations(result: &ModelResult) -> Option<Table> {
    let estimate = result.estimate.as_ref()?;
    let components = estimate.components();
    if components.len() < 2 || components.len() > 12 {
        return None;
    }
    let mut columns = vec![Column::text("")];
    columns.extend(
        components
            .iter()
            .map(|c| Column::number(c.name.clone(), "")),
    );
    let mut table = Table::new(
        "Correlation of the quantities by the law of propagation",
        columns,
    );
    for (i, component) in components.iter().enumerate() {
        let mut row = vec![Cell::text(component.name.clone())];
        row.extend((0..components.len()).map(|j| {
            let r = estimate.covariance().correlation(i, j);
            r.map_or(Cell::Empty, |r| Cell::number(format!("{r:.3}")))
        }));
        table = table.row(row);
    }
    Some(table)
}

fn detail(result: &ModelResult, output: &OutputResult) -> Section {
    let mut section = Section::new(format!("Uncertainty of {}", output.name));
    if let Some(linear) = &output.linear {
        let mut bars = BarPlot::shares(format!("share of the variance of {}", output.name));
        for line in &linear.budget {
            bars = bars.bar(line.key.clone(), line.share, "");
        }
        section = section
            .figure("Causes of uncertainty", bars)
            .table(budget(linear));
    }
    section = section.table(comparison(result, output));
    if let Some(table) = effects(output) {
        section = section.table(table);
    }
    if let Some(plot) = histogram(output) {
        section = section.figure(
            format!(
                "Distribution of {} from {} trials, with the density that the law of propagation implies; marks: \
                 ends of the linear interval and of the symmetric Monte Carlo interval at {} %",
                output.name,
                result.trials,
                percent(result.options.probability)
            ),
            plot,
        );
    }
    section
}

fn budget(output: &LinearOutput) -> Table {
    let q = &output.quantity;
    let unit = &q.unit;
    let mut table = Table::new(
        format!("Budget of {}", q.name),
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
    // Members of a vector that are constants say nothing; budget.csv has them.
    let says = |line: &&BudgetLine| {
        let constant = line
            .input
            .as_ref()
            .is_some_and(|i| i.standard_uncertainty == 0.0);
        !(constant && line.key.ends_with(']'))
    };
    for line in output.budget.iter().filter(says) {
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
            Cell::text(match &line.input {
                Some(input) if input.standard_uncertainty == 0.0 => "constant",
                _ => line.distribution.as_ref(),
            }),
            Cell::number(degrees(line.dof.get())),
            sensitivity,
            Cell::number(scientific(line.contribution.abs(), 2)),
            Cell::number(format!("{:.1}", 100.0 * line.share)),
        ]);
    }
    table = table.row([
        Cell::text(q.name.clone()),
        Cell::number(at_place(q.value, q.standard_uncertainty, 2)),
        Cell::number(scientific(q.standard_uncertainty, 2)),
        Cell::text(shown(unit)),
        Cell::Empty,
        Cell::number(degrees(q.dof.get())),
        Cell::Empty,
        Cell::number(scientific(q.standard_uncertainty, 2)),
        Cell::number(format!(
            "{:.1}",
            100.0 * output.budget.iter().map(|line| line.share).sum::<f64>()
        )),
    ]);
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

/// What each cause does by Monte Carlo, where that was looked at.
fn effects(output: &OutputResult) -> Option<Table> {
    if output.effects.is_empty() {
        return None;
    }
    let mut table = Table::new(
        format!("Budget of {} by Monte Carlo", output.name),
        [
            Column::text("cause"),
            Column::number("u alone", shown(&output.unit)),
            Column::number("share by itself", "%"),
            Column::number("share in all", "%"),
        ],
    );
    let percent = |share: f64| Cell::number(format!("{:.0}", (100.0 * share).max(0.0)));
    for cause in &output.effects {
        table = table.row([
            Cell::text(cause.inputs.join(", ")),
            Cell::number(scientific(cause.alone, 2)),
            percent(cause.first),
            percent(cause.total),
        ]);
    }
    Some(table.note(
        "u alone: only this cause varies (JCGM 101 annex B). Shares of the variance: what goes when the cause is known, and what \
         stays when only it is unknown (Sobol); the second exceeds the first where causes act through each other.",
    ))
}

fn comparison(result: &ModelResult, output: &OutputResult) -> Table {
    let unit = shown(&output.unit);
    let digits = result.options.digits;
    let mut table = Table::new(
        format!("Law of propagation and Monte Carlo for {}", output.name),
        [
            Column::text("method"),
            Column::number("value", unit),
            Column::number("u", unit),
            Column::number("lower end", unit),
            Column::number("upper end", unit),
        ],
    );
    let linear = output.linear.as_ref();
    let sampled = output.monte_carlo.as_ref();
    let scale = linear
        .map(|l| l.quantity.standard_uncertainty)
        .filter(|u| *u > 0.0)
        .or(sampled.and_then(|s| s.standard_uncertainty))
        .unwrap_or(0.5 * output.stated.expanded_uncertainty);
    let number = |v: f64| Cell::number(at_place(v, scale, digits));
    let mut row = |name: &str, value: f64, spread: Option<f64>, lower: f64, upper: f64| {
        table = std::mem::take(&mut table).row([
            Cell::text(name),
            number(value),
            spread.map_or(Cell::Empty, number),
            number(lower),
            number(upper),
        ]);
    };
    if let Some(linear) = linear {
        let q = &linear.quantity;
        let expanded = linear.expanded_uncertainty;
        row(
            "law of propagation",
            q.value,
            Some(q.standard_uncertainty),
            q.value - expanded,
            q.value + expanded,
        );
        if let Some(second) = &linear.second_order {
            let centre = q.value + second.shift;
            let spread = linear.coverage_factor * second.standard_uncertainty;
            row(
                "with terms of second order, for normal inputs",
                centre,
                Some(second.standard_uncertainty),
                centre - spread,
                centre + spread,
            );
        }
    }
    if let Some(sampled) = sampled {
        let u = sampled.standard_uncertainty;
        let value = if u.is_some() {
            sampled.mean
        } else {
            sampled.median
        };
        for (name, interval) in [
            ("Monte Carlo, symmetric interval", sampled.symmetric),
            ("Monte Carlo, shortest interval", sampled.shortest),
        ] {
            row(name, value, u, interval.lower, interval.upper);
        }
    }
    table.note(comparison_in_words(output))
}

/// The comparison of clause 8 in words.
fn comparison_in_words(output: &OutputResult) -> String {
    let unit = shown(&output.unit);
    let Some(validation) = &output.validation else {
        return "There is only one result, which is not checked by the other.".to_owned();
    };
    format!(
        "The ends of the linear and the symmetric Monte Carlo interval differ by {} and {} {unit}, {:.0} % of the \
         half-width; δ = {} {unit} is allowed: the linear result is {}.",
        scientific(validation.lower, 2),
        scientific(validation.upper, 2),
        100.0 * validation.relative,
        scientific(validation.tolerance, 1),
        match validation.verdict {
            Verdict::Validated => "validated",
            Verdict::NotValidated => "not validated; use the Monte Carlo interval",
            Verdict::Undecided => "neither validated nor refuted, for the trials scatter too much",
        }
    )
    .replace(" ;", ";")
    .replace(" :", ":")
    .replace(" ,", ",")
}

fn verdict(output: &OutputResult) -> &'static str {
    match output.validation.as_ref().map(|v| v.verdict) {
        Some(Verdict::Validated) => "validated",
        Some(Verdict::NotValidated) => "not validated",
        Some(Verdict::Undecided) => "undecided",
        None if output.linear.is_none() => "none",
        None => "not checked",
    }
}

/// Density of the trials with the linear density over it; `None` for an output that does not vary.
fn histogram(output: &OutputResult) -> Option<HistogramPlot> {
    let sampled = output.monte_carlo.as_ref()?;
    let counted = &sampled.histogram;
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
    let linear = output.linear.as_ref();
    let per_unit = match shown(&output.unit) {
        "" => String::new(),
        unit => format!("1/({unit})"),
    };
    let mut plot = HistogramPlot::new(
        Axis::linear(output.name.clone(), shown(&output.unit)),
        Axis::linear("density", per_unit),
        &edges,
        &heights,
    );
    let steps = 400;
    let curve: Option<(Vec<f64>, Vec<f64>)> = (0..=steps)
        .map(|i| {
            let x = edges[0] + (edges[bins.len()] - edges[0]) * i as f64 / steps as f64;
            Some((x, linear?.quantity.density(x)?))
        })
        .collect();
    if let (Some((x, y)), Some(q)) = (curve, linear.map(|l| &l.quantity)) {
        let name = if q.dof.is_infinite() {
            "normal density".to_owned()
        } else {
            format!("Student t density, ν = {}", degrees(q.dof.get()))
        };
        plot = plot.curve(Series::line(name, &x, &y));
    }
    if let Some(linear) = linear {
        let (value, half) = (linear.quantity.value, linear.expanded_uncertainty);
        plot = plot
            .mark(value - half, "linear")
            .mark(value + half, "linear");
    }
    let symmetric = sampled.symmetric;
    plot = plot
        .mark(symmetric.lower, "Monte Carlo")
        .mark(symmetric.upper, "Monte Carlo");
    Some(plot)
}

fn joint(result: &ModelResult) -> Section {
    let mut section = Section::new("Joint result");
    if let Some(estimate) = &result.estimate {
        let names: Vec<&str> = estimate
            .components()
            .iter()
            .map(|c| c.name.as_str())
            .collect();
        section = section.figure(
            "Correlation of the quantities by the law of propagation",
            MatrixPlot::correlation(&names, estimate.covariance()),
        );
        section = correlations(result)
            .into_iter()
            .fold(section, Section::table);
    }
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
    } else if nu < 100.0 && (nu - nu.round()).abs() > 1e-9 {
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

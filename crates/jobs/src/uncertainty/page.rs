//! The report of a measurement model: result, budget, Monte Carlo check.

mod requests;

use super::UncertaintyOutcome;
use crate::page::words::words;
use Rounding::{Decimals, Significant};
use proofmass_report::number::freedom;
use proofmass_report::{
    Axis, BarPlot, Cell, Field, HistogramPlot, KeyFigure, MatrixPlot, Report, Rounding, Section,
    Series, Table, scientific,
};
use proofmass_uncertainty::{
    BudgetLine, CauseEffect, CorrelationEntry, LinearOutput, Method, ModelResult, OutputResult,
    Rounded, Statement, Validation, Verdict,
};

pub(super) fn add(page: Report, outcome: &UncertaintyOutcome) -> Report {
    let result = &outcome.result;
    let mut page = page.verdict(sentence(result)).section(
        Section::new("Result")
            .key_figures(key_figures(result))
            .paragraph(in_a_line(result))
            .table(results(result))
            .table(by_the_law(result))
            .summarised(),
    );
    if let Some((caption, plot)) = result.outputs.first().and_then(|o| drawn(result, o)) {
        page = page.shown_by(caption, plot);
    }
    page = requests::add(page, outcome);
    for output in &result.outputs {
        if let Some(linear) = &output.linear {
            let section = Section::new(format!("Uncertainty components of {}", output.name));
            page = page.section(section.table(budget(output, linear)).summarised());
        }
    }
    for output in &result.outputs {
        page = page.section(detail(result, output));
    }
    if result.outputs.len() > 1 {
        page = page.section(joint(result));
    }
    let rows = result.outputs.iter().filter_map(causes).flatten();
    let mut tables = vec![Table::of("", budget_fields(""), rows).file("budget.csv")];
    if result.outputs.iter().any(|o| !o.effects.is_empty()) {
        let rows = result.outputs.iter().flat_map(effects);
        tables.push(Table::of("", effect_fields(""), rows).file("effects.csv"));
    }
    page.section(method(outcome))
        .section(Section::filed(tables))
}

fn method(outcome: &UncertaintyOutcome) -> Section {
    let result = &outcome.result;
    let outputs = result.outputs.iter();
    let formulas = outputs.map(|o| [o.name.clone(), o.expression.clone()]);
    let mut section = Section::new("Model and method")
        .table(words(
            "Equations",
            ["quantity", "formula"],
            outcome.parts().into_iter().chain(formulas),
        ))
        .table(words(
            "What is known of the inputs",
            [
                "input",
                "unit",
                "distribution or observations",
                "description",
            ],
            outcome.model.input.iter().map(super::given),
        ));
    if !result.input_correlations.is_empty() {
        let fields = [
            Field::shown("between", "", |p: &CorrelationEntry| {
                p.between[0].as_str().into()
            }),
            Field::shown("and", "", |p: &CorrelationEntry| {
                p.between[1].as_str().into()
            }),
            Field::shown("coefficient", "", |p: &CorrelationEntry| {
                p.coefficient.into()
            })
            .rounded(Significant(3)),
        ];
        section = section.table(Table::of(
            "Correlations of the inputs, given or observed",
            fields,
            &result.input_correlations,
        ));
    }
    section.paragraph(format!(
        "Law of propagation of uncertainty with the joint covariance of the inputs, coverage factors from \
         Student's t at the effective degrees of freedom (JCGM 100:2008). Propagation of distributions by \
         {} Monte Carlo trials, seed {} (JCGM 101:2008 and 102:2011).",
        result.trials, result.options.seed
    ))
}

/// Whether the linear result may be used, by Monte Carlo.
fn sentence(result: &ModelResult) -> String {
    let judged = || result.outputs.iter().filter_map(|o| o.validation.as_ref());
    let all = judged().count();
    let held = judged().filter(|v| v.holds()).count();
    match held {
        _ if all == 0 => "The linear result was not checked by Monte Carlo.".to_owned(),
        n if n < all && !judged().any(Validation::refutes) => {
            "The trials are too few to tell whether the law of propagation holds.".to_owned()
        }
        n if n < all && all == 1 => {
            "The linear result is not validated: Monte Carlo says something else.".to_owned()
        }
        n if n < all => {
            format!("The linear result is validated for {n} of {all} quantities by Monte Carlo.")
        }
        _ if judged().all(|v| v.verdict == Verdict::Validated) => {
            "The law of propagation holds: Monte Carlo validates the linear result.".to_owned()
        }
        _ => {
            "The law of propagation holds: Monte Carlo differs from it for few degrees of freedom \
              alone."
                .to_owned()
        }
    }
}

fn key_figures(result: &ModelResult) -> Vec<KeyFigure> {
    let checked = |o: &&OutputResult| {
        let validation = o.validation.as_ref();
        validation.is_some_and(|v| v.holds())
    };
    let held = result.outputs.iter().filter(checked).count();
    let mut figures = Vec::new();
    if let [output] = result.outputs.as_slice() {
        let stated = &output.stated;
        let digits = result.options.digits;
        let note = format!(
            "{} % interval by {}",
            percent((1e4 * stated.probability).round() / 1e4),
            stated.method.words()
        );
        figures.push(
            KeyFigure::new(
                stated.name.clone(),
                statement(stated, digits),
                shown(&stated.unit),
            )
            .note(match stated.coverage_factor {
                Some(k) => format!("{note}, k = {k:.2}"),
                None => note,
            }),
        );
    }
    figures.push(
        KeyFigure::new(
            "linear result",
            if let [output] = result.outputs.as_slice() {
                verdict(output).to_owned()
            } else if held == result.outputs.len() {
                "validated".to_owned()
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

/// `10000.025 ± 0.059`, or `1.084 to 1.383` where the interval is not value ± U.
fn statement(stated: &Statement, digits: u32) -> String {
    let Some(half) = stated.expanded_uncertainty else {
        let end = |v| at_place(v, stated.reach(), digits);
        return format!(
            "{} to {}",
            end(stated.interval.lower),
            end(stated.interval.upper)
        );
    };
    match Rounded::new(stated.value, half, digits as usize) {
        Some(rounded) if half > 0.0 => {
            let both = format!("{} ± {}", rounded.value, rounded.uncertainty);
            if rounded.exponent == 0 {
                both
            } else {
                format!("({both})e{}", rounded.exponent)
            }
        }
        None if half > 0.0 => {
            format!("{} ± {}", scientific(stated.value, 15), scientific(half, 2))
        }
        _ => scientific(stated.value, 6),
    }
}

/// Each result in a line: y ± U, k, p, ν, method.
fn in_a_line(result: &ModelResult) -> String {
    let line = |output: &OutputResult| {
        let stated = &output.stated;
        let digits = result.options.digits;
        let unit = match shown(&stated.unit) {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let interval = statement(stated, digits);
        let p = percent((1e4 * stated.probability).round() / 1e4);
        let mut words = match stated.expanded_uncertainty {
            Some(_) if unit.is_empty() => vec![format!("{} = {interval}", stated.name)],
            Some(_) => vec![format!("{} = ({interval}){unit}", stated.name)],
            None => {
                let scale = stated.standard_uncertainty.unwrap_or(stated.reach());
                let value = at_place(stated.value, scale, digits);
                let mut words = vec![format!("{} = {value}{unit}", stated.name)];
                if let Some(u) = stated.standard_uncertainty {
                    words.push(format!("u = {}{unit}", at_place(u, u, digits)));
                }
                words.push(format!("interval {interval}{unit}"));
                words
            }
        };
        if let Some(k) = stated.coverage_factor {
            words.push(format!("k = {k:.2}"));
        }
        words.push(format!("p = {p} %"));
        if let Some(nu) = stated.dof {
            words.push(format!("ν = {}", degrees(nu.get())));
        }
        words.push(format!("by {}", stated.method.words()));
        words.join(", ")
    };
    let lines: Vec<String> = result.outputs.iter().map(line).collect();
    lines.join("; ") + "."
}

/// What the law of propagation says of each output, for information where another method states it.
fn by_the_law(result: &ModelResult) -> Table {
    type Row<'a> = (&'a OutputResult, &'a LinearOutput);
    let digits = result.options.digits;
    let number = move |r: &Row<'_>, value: f64| {
        Cell::number(at_place(value, r.1.quantity.standard_uncertainty, digits))
    };
    let factor = result.options.coverage_factor;
    let k = move |r: &Row<'_>| factor.unwrap_or(r.1.coverage_factor);
    let fields = [
        Field::shown("quantity", "", |r: &Row<'_>| r.0.name.as_str().into()),
        Field::shown("y", "", move |r: &Row<'_>| number(r, r.1.quantity.value)),
        Field::shown("u_c", "", move |r: &Row<'_>| {
            number(r, r.1.quantity.standard_uncertainty)
        }),
        Field::shown("U", "", move |r: &Row<'_>| {
            number(r, k(r) * r.1.quantity.standard_uncertainty)
        }),
        Field::shown("unit", "", |r: &Row<'_>| shown(&r.0.unit).into()),
        Field::shown("k", "", move |r: &Row<'_>| k(r).into()).rounded(Decimals(2)),
        Field::shown("ν_eff", "", |r: &Row<'_>| {
            Cell::number(degrees(r.1.quantity.dof.get()))
        }),
        Field::shown("Monte Carlo says", "", |r: &Row<'_>| verdict(r.0).into()),
    ];
    let rows = result.outputs.iter();
    Table::of(
        "By the law of propagation",
        fields,
        rows.filter_map(|o| Some((o, o.linear.as_ref()?))),
    )
}

/// Each output as it is stated.
fn results(result: &ModelResult) -> Table {
    // A stated factor has another probability at each number of degrees of freedom.
    let fixed = result.options.coverage_factor;
    let road = match result.options.method.unwrap_or_default() {
        Method::Linear => "by the law of propagation",
        Method::SecondOrder => "by the law of propagation with terms of second order",
        Method::MonteCarlo => "by Monte Carlo",
        _ => "by the law of propagation where Monte Carlo does not contradict it",
    };
    let caption = match fixed {
        Some(k) => format!("Results with k = {k}, {road}; p is the probability of the interval"),
        None => format!(
            "Results with intervals at {} %, {road}",
            percent(result.options.probability)
        ),
    };
    let number = |output: &OutputResult, value: f64| {
        let stated = &output.stated;
        let known = stated.standard_uncertainty.filter(|u| *u > 0.0);
        let scale = known.unwrap_or(0.5 * stated.reach());
        Cell::number(at_place(value, scale, result.options.digits))
    };
    let half = |o: &OutputResult| {
        let half = o.stated.expanded_uncertainty;
        half.map(|half| number(o, half))
    };
    let k = |o: &OutputResult| o.stated.coverage_factor;
    let mut fields = vec![
        Field::shown("quantity", "", |o: &OutputResult| {
            o.stated.name.as_str().into()
        }),
        Field::shown("value", "", |o: &OutputResult| number(o, o.stated.value)),
        Field::shown("u", "", |o: &OutputResult| {
            o.stated.standard_uncertainty.map(|u| number(o, u)).into()
        }),
        Field::shown("U", "", |o: &OutputResult| half(o).into()),
        Field::shown("lower end", "", |o: &OutputResult| {
            number(o, o.stated.interval.lower)
        }),
        Field::shown("upper end", "", |o: &OutputResult| {
            number(o, o.stated.interval.upper)
        }),
        Field::shown("unit", "", |o: &OutputResult| shown(&o.stated.unit).into()),
        Field::shown("k", "", |o: &OutputResult| k(o).into()).rounded(Decimals(2)),
        Field::shown("ν_eff", "", |o: &OutputResult| {
            o.stated
                .dof
                .map(|nu| Cell::number(degrees(nu.get())))
                .into()
        }),
    ];
    if fixed.is_some() {
        let p = |o: &OutputResult| (100.0 * o.stated.probability).into();
        fields.push(Field::shown("p", "%", p).rounded(Decimals(1)));
    }
    fields.push(Field::shown("linear result", "", |o: &OutputResult| {
        verdict(o).into()
    }));
    Table::of(caption, fields, &result.outputs)
}

/// Correlation coefficients of the outputs by the law of propagation.
fn correlations(result: &ModelResult) -> Option<Table> {
    let estimate = result.estimate.as_ref()?;
    let components = estimate.components();
    let n = components.len();
    if !(2..=12).contains(&n) {
        return None;
    }
    let mut fields = vec![Field::shown("", "", |i: &usize| {
        components[*i].name.as_str().into()
    })];
    fields.extend((0..n).map(|j| {
        let r = move |i: &usize| estimate.covariance().correlation(*i, j).into();
        Field::shown(components[j].name.clone(), "", r).rounded(Decimals(3))
    }));
    let caption = "Correlation of the quantities by the law of propagation";
    Some(Table::of(caption, fields, 0..n))
}

fn detail(result: &ModelResult, output: &OutputResult) -> Section {
    let name = &output.name;
    let mut section = Section::new(format!("Uncertainty of {name}"));
    if let Some(linear) = &output.linear {
        let mut bars = BarPlot::shares(format!("share of the variance of {name}"));
        for line in &linear.budget {
            bars = bars.bar(line.key.clone(), line.share, "");
        }
        section = section.figure("Causes of uncertainty", bars);
    }
    section = section.table(comparison(result, output));
    if !output.effects.is_empty() {
        section = section.table(
            Table::of(
                format!("Budget of {name} by Monte Carlo"),
                effect_fields(shown(&output.unit)),
                effects(output),
            )
            .note(
                "u alone: only this cause varies (JCGM 101 annex B). Shares of the variance: what goes when the cause is known, and what \
                 stays when only it is unknown (Sobol); the second exceeds the first where causes act through each other.",
            ),
        );
    }
    match output.name == result.outputs[0].name {
        true => section,
        false => drawn(result, output)
            .into_iter()
            .fold(section, |section, (caption, plot)| {
                section.figure(caption, plot)
            }),
    }
}

/// The distribution of an output; that of the first opens the page.
fn drawn(result: &ModelResult, output: &OutputResult) -> Option<(String, HistogramPlot)> {
    let caption = format!(
        "Distribution of {} from {} trials, with the density that the law of propagation implies; marks: ends of the linear \
         interval and of the symmetric Monte Carlo interval at {} %",
        output.name,
        result.trials,
        percent(result.options.probability)
    );
    Some((caption, histogram(output)?))
}

/// A cause of an output; none where the row closes the budget.
type Cause<'a> = (&'a OutputResult, &'a LinearOutput, Option<&'a BudgetLine>);

/// One row per cause, and one that closes the budget.
fn causes(output: &OutputResult) -> Option<impl Iterator<Item = Cause<'_>>> {
    let linear = output.linear.as_ref()?;
    let lines = linear.budget.iter().map(Some).chain([None]);
    Some(lines.map(move |line| (output, linear, line)))
}

/// The columns of a budget: its contributions are in this unit.
fn budget_fields<'a>(unit: &str) -> [Field<'a, Cause<'a>>; 12] {
    // Value, standard uncertainty, unit.
    fn input<'a>((output, linear, line): &Cause<'a>) -> Option<(f64, f64, &'a str)> {
        let q = &linear.quantity;
        match line {
            None => Some((q.value, q.standard_uncertainty, &output.unit)),
            Some(line) => {
                let input = line.input.as_ref()?;
                Some((input.value, input.standard_uncertainty, &input.unit))
            }
        }
    }
    [
        Field::new("output", |(o, ..): &Cause<'a>| o.name.as_str().into()),
        Field::new("unit", |(o, ..): &Cause<'a>| o.unit.as_str().into()),
        Field::new("input", |(o, _, l): &Cause<'a>| {
            l.map_or(&o.name, |l| &l.key).as_str().into()
        })
        .page("input", ""),
        Field::new("description", |(.., l): &Cause<'a>| {
            l.map_or("combined", |l| &l.description).into()
        }),
        Field::new("input_unit", |c: &Cause<'a>| {
            input(c).map(|i| Cell::from(i.2).worded(shown(i.2))).into()
        })
        .page("unit", ""),
        Field::new("estimate", |c: &Cause<'a>| {
            input(c)
                .map(|i| Cell::from(i.0).worded(at_place(i.0, i.1, 2)))
                .into()
        })
        .page("estimate", ""),
        Field::new("u", |c: &Cause<'a>| input(c).map(|i| i.1).into())
            .page("u", "")
            .rounded(Significant(2)),
        Field::new("distribution", |c: &Cause<'a>| {
            let constant = input(c).is_some_and(|i| i.1 == 0.0);
            let word = |l: &BudgetLine| match constant {
                true => Cell::from(l.distribution.as_str()).worded("constant"),
                false => l.distribution.as_str().into(),
            };
            c.2.map(word).into()
        })
        .page("distribution", ""),
        // Infinite degrees of freedom are an empty field.
        Field::new("dof", |(_, linear, l): &Cause<'a>| {
            let nu = l.map_or(linear.quantity.dof, |l| l.dof);
            let finite = (!nu.is_infinite()).then(|| nu.get());
            Cell::from(finite).worded(degrees(nu.get()))
        })
        .page("ν", ""),
        Field::new("sensitivity", |(.., l): &Cause<'a>| {
            l.and_then(|l| Some(l.input.as_ref()?.sensitivity)).into()
        })
        .page("sensitivity", "")
        .rounded(Significant(3)),
        Field::new("contribution", |(_, linear, l): &Cause<'a>| {
            let part = l.map_or(linear.quantity.standard_uncertainty, |l| l.contribution);
            Cell::from(part).worded(scientific(part.abs(), 2))
        })
        .page("contribution", unit),
        Field::new("share", |(_, linear, l): &Cause<'a>| {
            let all = || linear.budget.iter().map(|line| line.share).sum();
            l.map_or_else(all, |l| l.share).into()
        })
        .page("share", "%")
        .scaled(100.0)
        .rounded(Decimals(1)),
    ]
}

fn budget(output: &OutputResult, linear: &LinearOutput) -> Table {
    // Members of a vector that are constants say nothing; budget.csv has them.
    let says = |(.., line): &Cause<'_>| {
        line.is_none_or(|line| {
            let input = line.input.as_ref();
            let constant = input.is_some_and(|i| i.standard_uncertainty == 0.0);
            !(constant && line.key.ends_with(']'))
        })
    };
    let name = &linear.quantity.name;
    let table = Table::of(
        format!("Budget of {name}"),
        budget_fields(shown(&linear.quantity.unit)),
        causes(output).into_iter().flatten().filter(says),
    );
    let described = linear
        .budget
        .iter()
        .filter(|line| line.description != line.key);
    let causes: Vec<String> = described
        .map(|line| format!("{}: {}", line.key, line.description))
        .collect();
    if causes.is_empty() {
        table
    } else {
        table.note(format!("{}.", causes.join("; ")))
    }
}

/// What a cause does to an output by Monte Carlo, where that was looked at.
type Effect<'a> = (&'a OutputResult, &'a CauseEffect);

fn effects(output: &OutputResult) -> impl Iterator<Item = Effect<'_>> {
    output.effects.iter().map(move |cause| (output, cause))
}

fn effect_fields<'a>(unit: &str) -> [Field<'a, Effect<'a>>; 6] {
    let percent = |share: f64| Cell::from(share).worded(format!("{:.0}", (100.0 * share).max(0.0)));
    [
        Field::new("output", |(o, _): &Effect<'a>| o.name.as_str().into()),
        Field::new("unit", |(o, _): &Effect<'a>| o.unit.as_str().into()),
        Field::new("cause", |(_, c): &Effect<'a>| {
            Cell::from(c.inputs.join(" ")).worded(c.inputs.join(", "))
        })
        .page("cause", ""),
        Field::new("u_alone", |(_, c): &Effect<'a>| c.alone.into())
            .page("u alone", unit)
            .rounded(Significant(2)),
        Field::new("share_first", move |(_, c): &Effect<'a>| percent(c.first))
            .page("share by itself", "%"),
        Field::new("share_total", move |(_, c): &Effect<'a>| percent(c.total))
            .page("share in all", "%"),
    ]
}

fn comparison(result: &ModelResult, output: &OutputResult) -> Table {
    let linear = output.linear.as_ref();
    let sampled = output.monte_carlo.as_ref();
    let mut rows: Vec<(&str, f64, Option<f64>, [f64; 2])> = Vec::new();
    if let Some(linear) = linear {
        let q = &linear.quantity;
        let expanded = linear.expanded_uncertainty;
        let ends = [q.value - expanded, q.value + expanded];
        rows.push((
            "law of propagation",
            q.value,
            Some(q.standard_uncertainty),
            ends,
        ));
        if let Some(second) = &linear.second_order {
            let centre = q.value + second.shift;
            let u = second.standard_uncertainty;
            let spread = linear.coverage_factor * u;
            let name = "with terms of second order, for normal inputs";
            rows.push((name, centre, Some(u), [centre - spread, centre + spread]));
        }
    }
    if let Some(sampled) = sampled {
        let u = sampled.standard_uncertainty;
        let value = u.map_or(sampled.median, |_| sampled.mean);
        for (name, interval) in [
            ("Monte Carlo, symmetric interval", sampled.symmetric),
            ("Monte Carlo, shortest interval", sampled.shortest),
        ] {
            rows.push((name, value, u, [interval.lower, interval.upper]));
        }
    }
    let scale = linear
        .map(|l| l.quantity.standard_uncertainty)
        .filter(|u| *u > 0.0)
        .or(sampled.and_then(|s| s.standard_uncertainty))
        .unwrap_or(0.5 * output.stated.reach());
    let number = |v: f64| Cell::number(at_place(v, scale, result.options.digits));
    let unit = shown(&output.unit);
    type Row = (&'static str, f64, Option<f64>, [f64; 2]);
    let fields = [
        Field::shown("method", "", |r: &Row| r.0.into()),
        Field::shown("value", unit, |r: &Row| number(r.1)),
        Field::shown("u", unit, |r: &Row| r.2.map(number).into()),
        Field::shown("lower end", unit, |r: &Row| number(r.3[0])),
        Field::shown("upper end", unit, |r: &Row| number(r.3[1])),
    ];
    let caption = format!("Law of propagation and Monte Carlo for {}", output.name);
    Table::of(caption, fields, rows).note(comparison_in_words(output))
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
            Verdict::NotValidated | Verdict::Undecided if validation.few_degrees_of_freedom => "validated but for few degrees of freedom, of which Monte Carlo makes Student's t",
            Verdict::NotValidated => "not validated; use the Monte Carlo interval",
            Verdict::Undecided => "neither validated nor refuted, for the trials scatter too much",
        }
    )
    .replace(" ;", ";")
    .replace(" :", ":")
    .replace(" ,", ",")
}

fn verdict(output: &OutputResult) -> &'static str {
    let validation = output.validation.as_ref();
    let few = validation.is_some_and(|v| v.few_degrees_of_freedom);
    match validation.map(|v| v.verdict) {
        Some(Verdict::NotValidated | Verdict::Undecided) if few => "differs for few ν",
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
    if let Some(estimate) = result
        .estimate
        .as_ref()
        .filter(|_| result.outputs.len() > 1)
    {
        let components = estimate.components().iter();
        let names: Vec<&str> = components.map(|c| c.name.as_str()).collect();
        section = section.figure(
            "Correlation of the quantities by the law of propagation",
            MatrixPlot::correlation(&names, estimate.covariance()),
        );
    }
    if let Some(table) = correlations(result) {
        section = section.table(table);
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
        // More digits than a double has.
        None if u > 0.0 => scientific(value, 15),
        None => scientific(value, 6),
    }
}

fn degrees(nu: f64) -> String {
    if nu.is_infinite() || nu > 9999.0 {
        freedom(nu)
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

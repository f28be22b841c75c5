//! What a model asks beside its outputs: conformity, sweeps, target uncertainties.

use super::{at_place, percent, shown};
use crate::uncertainty::UncertaintyOutcome;
use proofmass_report::Rounding::{Decimals, Significant};
use proofmass_report::{Cell, Field, Report, Section, Table, scientific};
use proofmass_uncertainty::{
    ModelResult, OutputConformity, Statement, StatementMethod, Sweep, SweepPoint, Target,
    TargetInput,
};

pub(super) fn add(mut page: Report, outcome: &UncertaintyOutcome) -> Report {
    let result = &outcome.result;
    if !result.conformity.is_empty() {
        page = page.section(
            Section::new("Conformity")
                .table(conformity(result))
                .summarised(),
        );
    }
    for target in &result.targets {
        page = page.section(
            Section::new(format!("Target uncertainty of {}", target.output))
                .table(targets(target, outcome))
                .summarised(),
        );
    }
    for sweep in &result.sweeps {
        let table = Table::of(
            format!("Outputs for estimates of {}", sweep.input),
            sweep_fields(),
            rows(sweep),
        );
        page = page.section(
            Section::new(format!("Sweep of {}", sweep.input))
                .table(table)
                .summarised(),
        );
    }
    if result.sweeps.is_empty() {
        return page;
    }
    let all = result.sweeps.iter().flat_map(rows);
    page.section(Section::filed([
        Table::of("", sweep_fields(), all).file("sweep.csv")
    ]))
}

fn unit<'a>(result: &'a ModelResult, output: &str) -> &'a str {
    result.get(output).map_or("", |o| shown(&o.unit))
}

fn conformity(result: &ModelResult) -> Table {
    type Row = OutputConformity;
    let scale = |r: &Row| {
        let stated = result.get(&r.output).map(|o| &o.stated);
        stated.map_or(0.0, |s| 0.5 * s.interval.width())
    };
    let number = move |r: &Row, v: Option<f64>| -> Cell {
        v.map(|v| Cell::from(v).worded(at_place(v, scale(r), 2)))
            .into()
    };
    let fields = [
        Field::new("output", |r: &Row| r.output.as_str().into()).page("quantity", ""),
        Field::new("lower", |r: &Row| r.limits.lower.into()).page("lower limit", ""),
        Field::new("upper", |r: &Row| r.limits.upper.into()).page("upper limit", ""),
        Field::new("guard_band", move |r: &Row| {
            number(r, r.decision.guard_band)
        })
        .page("guard band", ""),
        Field::new("accepted_from", move |r: &Row| {
            number(r, r.decision.acceptance.lower)
        })
        .page("accepted from", ""),
        Field::new("accepted_to", move |r: &Row| {
            number(r, r.decision.acceptance.upper)
        })
        .page("to", ""),
        Field::new("unit", |r: &Row| unit(result, &r.output).into()).page("unit", ""),
        Field::new("decision", |r: &Row| {
            if r.decision.accepted {
                "accepted"
            } else {
                "rejected"
            }
            .into()
        })
        .page("decision", ""),
        Field::new("probability", |r: &Row| r.decision.probability.into())
            .page("probability of conformity", "%")
            .scaled(100.0)
            .rounded(Decimals(2)),
        Field::new("risk_of", |r: &Row| {
            if r.decision.accepted {
                "consumer"
            } else {
                "producer"
            }
            .into()
        })
        .page("risk of the", ""),
        Field::new("specific_risk", |r: &Row| r.decision.risk.into())
            .page("specific risk", "%")
            .scaled(100.0)
            .rounded(Significant(3)),
        Field::new("global_risk_consumer", |r: &Row| {
            r.decision.global.map(|g| g.consumer).into()
        })
        .page("global risk, consumer", "%")
        .scaled(100.0)
        .rounded(Significant(3)),
        Field::new("global_risk_producer", |r: &Row| {
            r.decision.global.map(|g| g.producer).into()
        })
        .page("global risk, producer", "%")
        .scaled(100.0)
        .rounded(Significant(3)),
    ];
    Table::of("Decisions", fields, &result.conformity)
        .note(
            "The specific risk is the probability that this decision is wrong; the global risks are the shares of all items that are \
             accepted and do not conform, and that are rejected and do (JCGM 106:2012).",
        )
        .file("conformity.csv")
}

fn targets(target: &Target, outcome: &UncertaintyOutcome) -> Table {
    type Row = TargetInput;
    let of_output = unit(&outcome.result, &target.output);
    let of_input = |r: &Row| {
        let input = outcome.model.input.iter().find(|i| i.name == r.input);
        input.map_or("", |i| shown(&i.unit))
    };
    let fields = [
        Field::new("input", |r: &Row| r.input.as_str().into()).page("input", ""),
        Field::new("unit", move |r: &Row| of_input(r).into()).page("unit", ""),
        Field::new("u", |r: &Row| r.standard_uncertainty.into())
            .page("u now", "")
            .rounded(Significant(3)),
        Field::new("u_needed", |r: &Row| match r.needed {
            Some(u) => u.into(),
            None => Cell::from(None::<f64>).worded("not by this input"),
        })
        .page("u that is needed", "")
        .rounded(Significant(3)),
        Field::new("expanded", |r: &Row| r.expanded.into())
            .page("U with it", of_output)
            .rounded(Significant(3)),
    ];
    let say = |u: f64| scientific(u, 3);
    let options = &outcome.result.options;
    let road = match options.coverage_factor {
        Some(k) => format!("k = {k}"),
        None => format!("{} %", percent(options.probability)),
    };
    Table::of(
        format!(
            "What each input alone would need for U = {} {of_output}",
            say(target.wanted)
        )
        .trim_end(),
        fields,
        &target.inputs,
    )
    .note(format!(
        "U ({road}) is {} {of_output} now. Where the target is not reached, U is that with the input known, or 1000 times as uncertain.",
        say(target.expanded)
    ))
    .file(format!("target_{}.csv", target.output.replace(|c: char| !c.is_alphanumeric(), "_")))
}

/// A point of a sweep with one of its outputs; without one where the model could not be evaluated.
type Row<'a> = (&'a str, &'a SweepPoint, Option<&'a Statement>);

fn rows(sweep: &Sweep) -> impl Iterator<Item = Row<'_>> {
    sweep.points.iter().flat_map(move |point| {
        let none = point.outputs.is_empty().then_some(None);
        let outputs = point.outputs.iter().map(Some).chain(none);
        outputs.map(move |output| (sweep.input.as_str(), point, output))
    })
}

fn sweep_fields<'a>() -> [Field<'a, Row<'a>>; 9] {
    fn number(row: &Row<'_>, pick: impl Fn(&Statement) -> Option<f64>) -> Cell {
        let Some(stated) = row.2 else {
            return Cell::from(None::<f64>);
        };
        let scale = stated
            .standard_uncertainty
            .unwrap_or(0.25 * stated.interval.width());
        pick(stated)
            .map(|v| Cell::from(v).worded(at_place(v, scale, 2)))
            .into()
    }
    [
        Field::new("input", |r: &Row<'a>| r.0.into()),
        Field::new("estimate", |r: &Row<'a>| r.1.estimate.into())
            .page("estimate", "")
            .rounded(Significant(6)),
        Field::new("output", |r: &Row<'a>| match (r.2, &r.1.refused) {
            (Some(stated), _) => stated.name.as_str().into(),
            (None, Some(why)) => why.as_str().into(),
            (None, None) => "".into(),
        })
        .page("quantity", ""),
        Field::new("value", |r: &Row<'a>| number(r, |s| Some(s.value))).page("value", ""),
        Field::new("u", |r: &Row<'a>| number(r, |s| s.standard_uncertainty)).page("u", ""),
        Field::new("lower", |r: &Row<'a>| number(r, |s| Some(s.interval.lower)))
            .page("lower end", ""),
        Field::new("upper", |r: &Row<'a>| number(r, |s| Some(s.interval.upper)))
            .page("upper end", ""),
        Field::new("unit", |r: &Row<'a>| {
            r.2.map_or("", |s| shown(&s.unit)).into()
        })
        .page("unit", ""),
        Field::new("method", |r: &Row<'a>| {
            match r.2.map(|s| s.method) {
                None => "",
                Some(StatementMethod::LawOfPropagation) => "law of propagation",
                Some(StatementMethod::MonteCarlo) => "Monte Carlo",
                Some(_) => "second order",
            }
            .into()
        })
        .page("method", ""),
    ]
}

//! Where the uncertainty of every term comes from.

use super::digits::{CROSS, MAIN, TERMS, Unit, degrees_of_freedom, representative};
use crate::page::columns::{printed, words};
use proofmass_report::number::{plain, two_digits};
use proofmass_report::{BarPlot, Block, Section, Table};
use proofmass_shaker::derived::Expanded;
use proofmass_shaker::{FrequencyResult, MethodResult, UnmeasuredAt, VarianceComponent};

/// What a budget line is about, in the order of the budget.
fn causes(result: &MethodResult) -> Vec<(String, String, String)> {
    let mut causes: Vec<(String, String, String)> = vec![];
    for line in result
        .frequencies
        .iter()
        .flat_map(|f| f.sensitivity.iter().flat_map(|t| &t.budget))
    {
        if !causes.iter().any(|c| c.0 == line.key) {
            causes.push((
                line.key.clone(),
                line.description.clone(),
                format!("{:?}", line.evaluation),
            ));
        }
    }
    causes
}

fn share(f: &FrequencyResult, k: usize, key: &str) -> f64 {
    let mine = |l: &&proofmass_uncertainty::BudgetLine| l.key == key;
    f.sensitivity[k]
        .budget
        .iter()
        .find(mine)
        .map_or(0.0, |l| l.share)
}

fn mean_share(result: &MethodResult, terms: &[usize], key: &str) -> f64 {
    let all = result
        .frequencies
        .iter()
        .flat_map(|f| terms.iter().map(move |&k| share(f, k, key)));
    let count = (result.frequencies.len() * terms.len()).max(1) as f64;
    all.sum::<f64>() / count
}

pub(super) fn section(result: &MethodResult, unit: Unit) -> Section {
    let mut causes = causes(result);
    let main = |key: &str| mean_share(result, &MAIN, key);
    let cross = |key: &str| mean_share(result, &CROSS, key);
    causes.sort_by(|a, b| {
        let weight = |key: &str| main(key) + cross(key);
        weight(&b.0).total_cmp(&weight(&a.0))
    });
    let mut section = Section::new("Uncertainty").paragraph(
        "Law of propagation with one joint covariance: each cause is drawn once for everything that shares it (the \
         calibration of the reference for all runs of a frequency, a wedge face for all rotations on it, a gluing for all \
         frequencies), so that common errors are not averaged away. Contributions add in squares; terms are correlated, \
         so combine them through the joint covariance of result.json.",
    );
    for (caption, which) in [
        (
            "Causes of the uncertainty of the main terms, mean over frequencies and axes",
            &main as &dyn Fn(&str) -> f64,
        ),
        (
            "Causes of the uncertainty of the cross terms, mean over frequencies and terms",
            &cross,
        ),
    ] {
        let mut bars = BarPlot::shares("share of the variance");
        let mut sorted: Vec<_> = causes.iter().map(|c| (c, which(&c.0))).collect();
        sorted.sort_by(|a, b| b.1.total_cmp(&a.1));
        for (cause, share) in sorted {
            bars = bars.bar(cause.1.clone(), share, "");
        }
        section = section.figure(caption, bars);
    }
    if let Some(f) = representative(result) {
        section = section.table(table(f, &causes, unit));
        let others: Vec<Block> = result
            .frequencies
            .iter()
            .filter(|g| g.frequency != f.frequency)
            .map(|g| Block::Table(table(g, &causes, unit)))
            .collect();
        if !others.is_empty() {
            section = section.looked_up("Budgets of every term at the other frequencies", others);
        }
    }
    if !result.components.is_empty() {
        let told = supported(&result.components, &causes);
        section = section.looked_up(
            "What the runs tell of the declared uncertainties",
            [Block::Table(told)],
        );
    }
    if !result.motion.is_empty() {
        section = section.table(motion(&result.motion));
    }
    section
}

/// How large the motion of the bench is taken to be that nobody measured.
fn motion(motion: &[UnmeasuredAt]) -> Table {
    let percent = |u: Option<f64>| u.map(|u| two_digits(100.0 * u));
    let fields = [
        printed("f", "Hz", |m: &UnmeasuredAt| plain(m.frequency)),
        printed("u across the excitation", "%", move |m: &UnmeasuredAt| {
            percent(m.across)
        }),
        printed("u along it", "%", move |m: &UnmeasuredAt| percent(m.along)),
    ];
    Table::of("Motion of the bench that was not measured, as the runs have it", fields, motion)
        .note("Standard uncertainty of the real and of the imaginary part of its ratio to the excitation.")
}

/// What the runs tell of the declared uncertainties.
fn supported(components: &[VarianceComponent], causes: &[(String, String, String)]) -> Table {
    let dof = |nu: f64| degrees_of_freedom(Some(nu).filter(|nu| nu.is_finite()));
    type R = VarianceComponent;
    let cause = |c: &R| match causes.iter().find(|k| k.0 == c.key) {
        _ if c.key == "readings" => "readings and their noise".to_owned(),
        Some(named) => named.1.clone(),
        None => c.key.clone(),
    };
    let fields = [
        words("cause", cause),
        printed("f", "Hz", |c: &R| c.frequency.map(plain)),
        printed("û/u", "", |c: &R| format!("{:.2}", c.estimated)),
        printed("ν of û", "", |c: &R| dof(c.freedom)),
        printed("used/u", "", |c: &R| format!("{:.2}", c.used)),
        printed("ν used", "", |c: &R| dof(c.dof.get())),
    ];
    Table::of("Declared uncertainties as the runs have them", fields, components).note(
        "u as declared, û by restricted maximum likelihood with the degrees of freedom that the runs (and the declaration, \
         where it has any) have for it. Used is the larger \
         of the two; U is the larger of t(ν)·û and of what is declared. Causes that are not here are told by no run.",
    )
}

/// One row per cause, one column per term.
fn table(f: &FrequencyResult, causes: &[(String, String, String)], unit: Unit) -> Table {
    // Contributions to sensitivities in per mille of the largest main term: one unit for all columns.
    let largest = MAIN
        .iter()
        .map(|&k| f.sensitivity[k].modulus.value)
        .fold(0.0, f64::max);
    let (small, factor) = match unit.name {
        "V/(m/s²)" => ("mV/(m/s²)", 1e3),
        "mV/(m/s²)" => ("µV/(m/s²)", 1e6),
        "count/(m/s²)" => ("10⁻³ count/(m/s²)", 1e3),
        "(m/s²)/(m/s²)" => ("10⁻³", 1e3),
        _ => ("nV/(m/s²)", 1e9),
    };
    type Row = (String, [String; 9]);
    let contributions = |(key, description, evaluation): &(String, String, String)| -> Row {
        let of = |k: usize| {
            let line = f.sensitivity[k].budget.iter().find(|l| l.key == *key);
            // A millionth of the sensitivity is rounding, not a contribution.
            match line.map_or(0.0, |l| l.contribution) {
                value if value < 1e-6 * largest => "0".to_owned(),
                value => two_digits(factor * value),
            }
        };
        (
            format!("{description} ({evaluation})"),
            std::array::from_fn(of),
        )
    };
    let total = |name: &str, value: &dyn Fn(&Expanded) -> String| -> Row {
        let of = |k: usize| value(&f.sensitivity[k].modulus);
        (name.to_owned(), std::array::from_fn(of))
    };
    let totals = [
        total("u", &|m| two_digits(factor * m.standard_uncertainty)),
        total("ν_eff", &|m| degrees_of_freedom(m.dof)),
        total("k", &|m| format!("{:.2}", m.coverage_factor)),
        total("U", &|m| two_digits(factor * m.expanded)),
    ];
    let mut fields = vec![words("cause (type)", |r: &Row| r.0.clone())];
    let terms = TERMS.into_iter().enumerate();
    fields.extend(terms.map(|(k, term)| printed(term, "", move |r: &Row| r.1[k].clone())));
    let caption = format!(
        "Budget of |S| at {} Hz: contribution of each cause to the standard uncertainty in {small}",
        plain(f.frequency)
    );
    Table::of(
        caption,
        fields,
        causes.iter().map(contributions).chain(totals),
    )
}

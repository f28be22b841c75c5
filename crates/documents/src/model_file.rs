//! Model and budget files (TOML) of the uncertainty calculation.

mod columns;
mod place;

pub use columns::{ColumnTrouble, fill_columns};

use place::Place;
use proofmass_uncertainty::{BudgetEntries, Refusal, UncertaintyModel};
use serde::Deserialize;

/// Reads `budget.toml`: the inputs of a campaign.
///
/// ```
/// let wrong = proofmass_documents::read_budget("[[input]]\nname = \"a\"\nunit = \"1\"\ncolour = \"red\"\n").unwrap_err();
/// assert!(wrong.to_string().starts_with("line 4: unknown field `colour`"));
/// ```
///
/// # Errors
/// [`Refusal::File`] with line and field.
pub fn read_budget(text: &str) -> Result<BudgetEntries, Refusal> {
    let budget: BudgetEntries = read(text)?;
    // Distributions are judged here, where the line is still known.
    budget
        .inputs()
        .and_then(|inputs| inputs.single())
        .map_err(|refusal| {
            Place::of(&refusal, &budget.input, &budget.correlation, &[]).explain(text, refusal)
        })?;
    Ok(budget)
}

/// Reads `MODEL.toml`: the equations of one measurement and what is known of its inputs.
///
/// # Errors
/// [`Refusal::File`] with line and field, also for an expression that cannot be read.
pub fn read_model(text: &str) -> Result<UncertaintyModel, Refusal> {
    let model = parse(text)?;
    check(&model, text)?;
    Ok(model)
}

/// Reads a model file without looking at what it says: the estimates of its earlier results are still to be put in.
///
/// # Errors
/// [`Refusal::File`] with line and field.
pub fn parse(text: &str) -> Result<UncertaintyModel, Refusal> {
    read(text)
}

/// Whether a model can be evaluated, as far as that can be told before it is.
///
/// # Errors
/// [`Refusal::File`] with line and field, also for an expression that cannot be read.
pub fn check(model: &UncertaintyModel, text: &str) -> Result<(), Refusal> {
    if model.output.is_empty() {
        return Err(Refusal::File {
            line: None,
            reason: "no [[output]]: a model states at least one quantity to compute".into(),
        });
    }
    model
        .inputs()
        .and_then(|inputs| inputs.single())
        .and_then(|_| model.prepared())
        .map_err(|refusal| explain(model, text, refusal))?;
    Ok(())
}

/// A refusal of this model with the line of its text that it speaks of.
pub fn explain(model: &UncertaintyModel, text: &str, refusal: Refusal) -> Refusal {
    let mut formulas: Vec<place::Formula<'_>> = Vec::new();
    let label = |table, key, labels: Vec<String>| (table, key, labels);
    let labels = [
        label(
            "conformity",
            "output",
            model.conformity.iter().map(|c| c.label()).collect(),
        ),
        label(
            "sweep",
            "input",
            model.sweep.iter().map(|s| s.label()).collect(),
        ),
        label(
            "target",
            "output",
            model.target.iter().map(|t| t.label()).collect(),
        ),
    ];
    for (table, key, labels) in &labels {
        for (number, name) in labels.iter().enumerate() {
            formulas.push(place::Formula::new(table, number, name, key, ""));
        }
    }
    for (number, part) in model.intermediate.iter().enumerate() {
        let (name, text) = (&part.name, &part.expression);
        formulas.push(place::Formula::new(
            "intermediate",
            number,
            name,
            "expression",
            text,
        ));
    }
    for (number, fit) in model.fit.iter().enumerate() {
        formulas.push(place::Formula::new("fit", number, &fit.name, "x", &fit.x));
        formulas.push(place::Formula::new("fit", number, &fit.name, "y", &fit.y));
        if let Some(curve) = &fit.curve {
            formulas.push(place::Formula::new(
                "fit", number, &fit.name, "curve", curve,
            ));
        }
        for name in &fit.parameters {
            formulas.push(place::Formula::new("fit", number, name, "parameters", ""));
        }
    }
    for (number, solve) in model.solve.iter().enumerate() {
        for name in &solve.unknown {
            formulas.push(place::Formula::new("solve", number, name, "unknown", ""));
        }
        for text in &solve.equations {
            formulas.push(place::Formula::new("solve", number, "", "equations", text));
        }
    }
    for (number, earlier) in model.earlier.iter().enumerate() {
        formulas.push(place::Formula::new(
            "earlier",
            number,
            &earlier.file,
            "file",
            "",
        ));
        for name in earlier.quantities.keys() {
            formulas.push(place::Formula::new(
                "earlier",
                number,
                name,
                "quantities",
                "",
            ));
        }
    }
    for (number, output) in model.output.iter().enumerate() {
        let (name, text) = (&output.name, &output.expression);
        formulas.push(place::Formula::new(
            "output",
            number,
            name,
            "expression",
            text,
        ));
    }
    Place::of(&refusal, &model.input, &model.correlation, &formulas).explain(text, refusal)
}

fn read<'de, T: Deserialize<'de>>(text: &'de str) -> Result<T, Refusal> {
    toml::from_str(text).map_err(|error| Refusal::File {
        line: error.span().map(|span| place::line_at(text, span.start)),
        reason: error.message().to_owned(),
    })
}

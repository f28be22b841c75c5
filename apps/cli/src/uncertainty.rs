//! `proofmass uncertainty`: from a formula and what is known of its inputs to a result with its budget.

use crate::delivery::{Delivery, Results};
use crate::{Failure, Outcome, clock, console};
use indicatif::ProgressStyle;
use proofmass::io::{Cell, Input, OutputFolder, ResultDocument, Software, Table};
use proofmass::report::{GivenInput, UncertaintyReport};
use proofmass::uncertainty::{
    Evaluate, InputEntry, ModelResult, Refusal, Trials, UncertaintyModel,
};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Evaluate the uncertainty of a measurement from its equations.
///
/// The model file states formulas, inputs and their distributions. The result is computed twice: by the law of
/// propagation (with budget and effective degrees of freedom) and by Monte Carlo, which says whether the first may
/// be used. docs/uncertainty.md describes the model file, examples/uncertainty/ holds some.
#[derive(clap::Args)]
pub(crate) struct Uncertainty {
    /// Model file (TOML)
    model: PathBuf,
    /// Coverage probability of the intervals, between 0 and 1
    #[arg(long, value_name = "P", default_value_t = 0.95, value_parser = probability, allow_negative_numbers = true)]
    probability: f64,
    /// Significant digits of u that are printed and checked
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=6))]
    digits: u32,
    /// Monte Carlo trials, rounded up to whole blocks [default: until the digits are stable, 5 000 000 at most]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    trials: Option<u64>,
    /// Seed of the random numbers: the same seed gives the same result
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    delivery: Delivery,
}

impl Uncertainty {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let input = Input::of(&self.model)?;
        let text = std::fs::read_to_string(&self.model)
            .map_err(|e| Failure::new(format!("{}: {e}", self.model.display())))?;
        let model = UncertaintyModel::parse(&text).map_err(|e| refused(&self.model, &e))?;
        let folder = self.delivery.begin(&[&self.model])?;
        let result = self.evaluate(&text, &model)?;
        self.write(folder, input, &model, &result)
    }

    fn evaluate(&self, text: &str, model: &UncertaintyModel) -> Result<ModelResult, Failure> {
        let options = Evaluate {
            probability: self.probability,
            digits: self.digits,
            seed: self.seed,
            trials: match self.trials {
                Some(n) => Trials::Fixed(usize::try_from(n).unwrap_or(usize::MAX)),
                None => Trials::Adaptive {
                    digits: self.digits,
                    max: 5_000_000,
                },
            },
        };
        let bar = console::progress(0, "trials");
        if let Ok(style) = ProgressStyle::with_template("{msg} [{wide_bar}] {pos}/{len} {eta}") {
            bar.set_style(style);
        }
        let result = model.evaluate(&options, &mut |progress| {
            bar.set_length(progress.most as u64);
            bar.set_position(progress.done as u64);
            ControlFlow::Continue(())
        });
        bar.finish_and_clear();
        result.map_err(|e| refused(&self.model, &model.explain(text, e)))
    }

    fn write(
        &self,
        folder: Option<OutputFolder>,
        input: Input,
        model: &UncertaintyModel,
        result: &ModelResult,
    ) -> Result<Outcome, Failure> {
        let title = if model.title.is_empty() {
            "Uncertainty of a measurement".to_owned()
        } else {
            model.title.clone()
        };
        let json = ResultDocument::new("uncertainty")
            .title(title.clone())
            .input(input.clone())
            .findings(&result.findings)
            .estimate(&result.estimate, self.probability)
            .section("date", &clock::today())?
            .section("model", model)?
            .section("options", &result.options)?
            .section("outputs", &result.outputs)?
            .section("trials", &result.trials)?
            .section("monte_carlo_covariance", &result.monte_carlo_covariance)?
            .section("region", &result.region)?
            .to_json()?;
        let text = UncertaintyReport {
            title,
            meta: vec![("Evaluated on".to_owned(), clock::today())],
            inputs: vec![(input.path, input.sha256)],
            intermediate: model
                .intermediate
                .iter()
                .map(|i| (i.name.clone(), i.expression.clone()))
                .collect(),
            given: model.input.iter().map(given).collect(),
            footer: Software::default().to_string(),
        };
        self.delivery.hand_over(
            folder,
            &Results {
                json,
                summary: &|| text.summary(result),
                report: &|| text.full(result),
                files: vec![("budget.csv", budget(result)?.to_csv()?)],
                findings: &result.findings,
            },
        )
    }
}

/// One row per output and input.
fn budget(result: &ModelResult) -> Result<Table, Failure> {
    let mut table = Table::new([
        "output",
        "unit",
        "input",
        "description",
        "input_unit",
        "estimate",
        "u",
        "distribution",
        "dof",
        "sensitivity",
        "contribution",
        "share",
    ]);
    for output in &result.outputs {
        for line in &output.budget {
            let input = line.input.as_ref();
            table.push([
                Cell::from(output.quantity.name.as_str()),
                Cell::from(output.quantity.unit.as_str()),
                Cell::from(line.key.as_str()),
                Cell::from(line.description.as_str()),
                input.map_or(Cell::Missing, |i| Cell::from(i.unit.as_str())),
                Cell::from(input.map(|i| i.value)),
                Cell::from(input.map(|i| i.standard_uncertainty)),
                Cell::from(line.distribution.as_str()),
                // Infinite degrees of freedom are an empty field.
                Cell::from((!line.dof.is_infinite()).then(|| line.dof.get())),
                Cell::from(input.map(|i| i.sensitivity)),
                Cell::from(line.contribution),
                Cell::from(line.share),
            ])?;
        }
    }
    Ok(table)
}

/// An input in words, as far as its file states it.
fn given(entry: &InputEntry) -> GivenInput {
    let mut known = match (&entry.distribution, &entry.observations) {
        (Some(distribution), _) => distribution.to_string(),
        (None, Some(values)) if values.len() <= 12 => {
            let values: Vec<String> = values.iter().map(f64::to_string).collect();
            values.join(", ")
        }
        (None, Some(values)) => format!("{} observations", values.len()),
        (None, None) => String::new(),
    };
    if let Some(dof) = entry.dof {
        known += &format!("; ν = {}", dof.get());
    }
    if let Some(word) = &entry.together {
        known += &format!("; together as {word}");
    }
    GivenInput {
        name: entry.name.clone(),
        unit: entry.unit.clone(),
        description: entry.description.clone().unwrap_or_default(),
        known,
    }
}

fn probability(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(p) if p > 0.0 && p < 1.0 => Ok(p),
        _ => Err("a number between 0 and 1 is needed, such as 0.95".to_owned()),
    }
}

/// `file:line: what`, and what to do.
fn refused(path: &Path, refusal: &Refusal) -> Failure {
    let place = path.display();
    match refusal {
        Refusal::File {
            line: Some(line),
            reason,
        } => Failure::new(format!("{place}:{line}: {reason}"))
            .hint("docs/uncertainty.md describes the model file, examples/uncertainty/ holds some"),
        Refusal::File { line: None, reason } => Failure::new(format!("{place}: {reason}"))
            .hint("docs/uncertainty.md describes the model file, examples/uncertainty/ holds some"),
        other => Failure::new(format!("{place}: {other}")).hint(
            "the formulas must be finite for every value that the distributions of the inputs allow",
        ),
    }
}

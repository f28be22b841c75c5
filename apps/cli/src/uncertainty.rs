//! `proofmass uncertainty`: from a formula and what is known of its inputs to a result with its budget.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock};
use proofmass::io::Source;
use proofmass::jobs::uncertainty::{ModelText, UncertaintyOutcome};
use proofmass::jobs::{Outcome as _, Record, StoredResult};
use proofmass::uncertainty::{Evaluate, Method, Trials};
use std::path::PathBuf;

/// Evaluate the uncertainty of a measurement from its equations.
///
/// The model file states formulas, inputs and their distributions. The result is computed twice: by the law of
/// propagation (with budget and effective degrees of freedom) and by Monte Carlo, which says whether the first may
/// be used. docs/uncertainty.md describes the model file, examples/uncertainty/ holds some.
#[derive(clap::Args)]
pub(crate) struct Uncertainty {
    /// Model file (TOML)
    model: PathBuf,
    /// Method that states the result: auto is the law of propagation where Monte Carlo does not contradict it [default: that of
    /// the model file, auto where it says none]
    #[arg(long, value_name = "METHOD", value_parser = ["auto", "linear", "second-order", "monte-carlo"])]
    method: Option<String>,
    /// Coverage probability of the intervals, between 0 and 1
    #[arg(long, value_name = "P", default_value_t = 0.95, value_parser = probability, allow_negative_numbers = true)]
    probability: f64,
    /// Coverage factor of the result, such as 2 [default: from the probability and the degrees of freedom]
    #[arg(short = 'k', long, value_name = "K", value_parser = coverage_factor)]
    coverage_factor: Option<f64>,
    /// Significant digits of u that are printed
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=6))]
    digits: u32,
    /// Significant digits of u to which both methods must agree
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=6))]
    check_digits: u32,
    /// Monte Carlo trials, rounded up to whole blocks [default: until the digits are stable, 5 000 000 at most]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    trials: Option<u64>,
    /// Seed of the random numbers: the same seed gives the same result
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Make the budget by Monte Carlo for every output, not only for those whose linear result does not stand
    #[arg(long)]
    effects: bool,
    #[command(flatten)]
    delivery: Delivery,
}

impl Uncertainty {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let model = ModelText::read(Source::open(&self.model)?)?;
        let folder = self
            .delivery
            .begin(UncertaintyOutcome::KIND, &[&self.model])?;
        let outcome = model.evaluate(self.options(), &Progress::new())?;
        let record = Record {
            date: Some(clock::today()),
            inputs: model.inputs(),
            ..Record::default()
        };
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }

    fn options(&self) -> Evaluate {
        Evaluate {
            method: self.method.as_deref().map(|method| match method {
                "linear" => Method::Linear,
                "second-order" => Method::SecondOrder,
                "monte-carlo" => Method::MonteCarlo,
                _ => Method::Auto,
            }),
            probability: self.probability,
            coverage_factor: self.coverage_factor,
            digits: self.digits,
            check_digits: self.check_digits,
            seed: self.seed,
            trials: match self.trials {
                Some(n) => Trials::Fixed(usize::try_from(n).unwrap_or(usize::MAX)),
                None => Trials::Adaptive {
                    digits: self.digits,
                    max: 5_000_000,
                },
            },
            effects: self.effects,
        }
    }
}

pub(crate) fn coverage_factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(k) if k > 0.0 && k.is_finite() => Ok(k),
        _ => Err("a number above 0 is needed, such as 2".to_owned()),
    }
}

fn probability(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(p) if p > 0.0 && p < 1.0 => Ok(p),
        _ => Err("a number between 0 and 1 is needed, such as 0.95".to_owned()),
    }
}

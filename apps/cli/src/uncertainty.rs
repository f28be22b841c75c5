//! `proofmass uncertainty`: from a formula and what is known of its inputs to a result with its budget.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::{coverage_factor, probability};
use crate::{Failure, Outcome, clock};
use proofmass::io::Source;
use proofmass::jobs::uncertainty::{ModelText, UncertaintyOutcome};
use proofmass::jobs::{Outcome as _, Record, StoredResult};
use proofmass::uncertainty::{Evaluate, Trials};
use std::path::PathBuf;

/// Evaluate the uncertainty of a measurement from its equations (GUM)
///
/// The model file states formulas, inputs and their distributions.
/// The result is computed by the law of propagation of uncertainty (with budget and effective degrees of freedom) and by
/// Monte Carlo, which shows whether the first may be used. A model file:
///
///     [[input]]
///     name = "U"
///     unit = "V"
///     value = 5.0
///     u = 0.01
///
///     [[input]]
///     name = "I"
///     unit = "A"
///     observations = [0.01997, 0.02002, 0.02001]
///
///     [[output]]
///     name = "R"
///     unit = "Ω"
///     expression = "U / I"
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Uncertainty {
    /// Model file (TOML)
    model: PathBuf,
    /// Coverage probability of the intervals, between 0 and 1
    #[arg(long, value_name = "P", default_value_t = 0.95, value_parser = probability, allow_negative_numbers = true)]
    probability: f64,
    /// Coverage factor of the linear result, such as 2 [default: from the probability and the degrees of freedom]
    #[arg(short = 'k', long, alias = "coverage", value_name = "K", value_parser = coverage_factor)]
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
    /// Budget by Monte Carlo for every output, not only where the linear result is not validated
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

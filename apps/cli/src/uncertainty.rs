//! `proofmass uncertainty`: from a formula and what is known of its inputs to a result with its budget.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::number_arguments::{coverage_factor, probability};
use crate::{Failure, Outcome, clock, console};
use proofmass::io::Source;
use proofmass::jobs::uncertainty::{ModelText, UncertaintyOutcome};
use proofmass::jobs::{Outcome as _, Record, StoredResult};
use proofmass::uncertainty::{Evaluate, Method, SweepEntry, TargetEntry, Trials};
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
    /// Method that states the result: auto is the law of propagation where Monte Carlo does not contradict it [default: that of
    /// the model file, auto where it says none]
    #[arg(long, value_name = "METHOD", value_parser = ["auto", "linear", "second-order", "monte-carlo"])]
    method: Option<String>,
    /// Coverage probability of the intervals, between 0 and 1
    #[arg(long, value_name = "P", default_value_t = 0.95, value_parser = probability, allow_negative_numbers = true)]
    probability: f64,
    /// Coverage factor of the result, such as 2 [default: from the probability and the degrees of freedom]
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
    /// State the outputs also for STEPS estimates of an input, such as T=10:30:21; may be given again
    #[arg(long, value_name = "INPUT=FROM:TO:STEPS", value_parser = sweep)]
    sweep: Vec<SweepEntry>,
    /// Say which u of each input alone would bring an output to this U, such as y=0.5; may be given again
    #[arg(long, value_name = "OUTPUT=U", value_parser = target)]
    target: Vec<TargetEntry>,
    /// Write the Monte Carlo trials to this file (CSV), a column per output
    #[arg(long, value_name = "FILE")]
    draws: Option<PathBuf>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Uncertainty {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let mut model = ModelText::read(Source::open(&self.model)?)?;
        model.ask(self.sweep.clone(), self.target.clone());
        if let Some(file) = &self.draws {
            self.delivery.keep(file)?;
        }
        let folder = self
            .delivery
            .begin(UncertaintyOutcome::KIND, &[&self.model])?;
        let outcome = model.evaluate(self.options(), &Progress::new())?;
        if let Some(file) = &self.draws {
            let left_out = model.write_draws(&self.options(), &outcome, file)?;
            if left_out > 0 {
                console::note(format!(
                    "{left_out} of {} trials are not in {}: an output is no finite number in them",
                    outcome.result.trials,
                    file.display()
                ));
            }
        }
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

/// `T=10:30:21`
fn sweep(text: &str) -> Result<SweepEntry, String> {
    let parse = || {
        let (input, rest) = text.split_once('=')?;
        let mut parts = rest.split(':');
        let entry = SweepEntry {
            input: input.trim().to_owned(),
            from: parts.next()?.trim().parse().ok()?,
            to: parts.next()?.trim().parse().ok()?,
            steps: parts.next()?.trim().parse().ok()?,
        };
        parts.next().is_none().then_some(entry)
    };
    parse().ok_or_else(|| "INPUT=FROM:TO:STEPS is needed, such as T=10:30:21".to_owned())
}

/// `y=0.5`
fn target(text: &str) -> Result<TargetEntry, String> {
    let parse = || {
        let (output, expanded) = text.rsplit_once('=')?;
        Some(TargetEntry {
            output: output.trim().to_owned(),
            expanded: expanded.trim().parse().ok()?,
        })
    };
    parse().ok_or_else(|| "OUTPUT=U is needed, such as y=0.5".to_owned())
}

//! Random chains: models whose results are read by a second model, against one Monte Carlo through both.
//!
//! Each chain goes through files, as on the command line: one or two first models, their folders of results, a second model with
//! `[[earlier]]`. The same equations in one model are the truth. Held against each other are the trials of the second model
//! (u, both ends), and what it states. `random_chains [COUNT] [SEED] [TRIALS OF THE TRUTH]`; each departure is named by its seed.

use proofmass_io::Source;
use proofmass_jobs::Unwatched;
use proofmass_jobs::uncertainty::{ModelText, UncertaintyOutcome};
use proofmass_jobs::{Record, StoredResult};
use proofmass_uncertainty::{Evaluate, Severity, StatementMethod, Trials, Verdict};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::error::Error;
use std::path::Path;

type Random = Xoshiro256PlusPlus;
type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Text of an input; whether its degrees of freedom are more than 4.
fn input(rng: &mut Random, name: &str, share: f64) -> (String, bool) {
    let value = rng.random_range(0.5..3.0);
    let u = value * share * rng.random_range(0.5..1.5);
    let a = u * 3f64.sqrt();
    let (statement, many) = match rng.random_range(0..8) {
        0..=2 => (format!("value = {value}\nu = {u}"), true),
        3 => {
            let nu = rng.random_range(3..30);
            (format!("value = {value}\nu = {u}\ndof = {nu}"), nu > 4)
        }
        4 => (format!("value = {value}\nhalf_width = {a}"), true),
        5 => (
            format!("value = {value}\nhalf_width = {a}\nshape = \"triangular\""),
            true,
        ),
        6 => (
            format!(
                "distribution = {{ kind = \"lognormal\", median = {value}, sigma = {} }}",
                (u / value).min(0.5)
            ),
            true,
        ),
        _ => {
            let n = rng.random_range(4..12);
            let readings: Vec<String> = (0..n)
                .map(|_| {
                    format!(
                        "{}",
                        value + a * (n as f64).sqrt() * rng.random_range(-1.0..1.0)
                    )
                })
                .collect();
            (format!("observations = [{}]", readings.join(", ")), n > 5)
        }
    };
    let text = format!("[[input]]\nname = \"{name}\"\nunit = \"1\"\n{statement}\n");
    (text, many)
}

/// A formula of these names.
fn formula(rng: &mut Random, names: &[String], depth: usize) -> String {
    if depth == 0 {
        return names.choose(rng).cloned().unwrap_or_default();
    }
    let a = formula(rng, names, depth - 1);
    match rng.random_range(0..12) {
        0 => format!("({a})^2"),
        1 => format!("sin({a})"),
        2 => format!("exp(0.3 * ({a}))"),
        3 => format!("sqrt(1 + ({a})^2)"),
        4 => format!("atan({a})"),
        5 => format!("({a} - {})^2", rng.random_range(0.5..3.0)),
        n => {
            let b = formula(rng, names, depth - 1);
            match n {
                6 | 7 => format!("({a} + {b})"),
                8 => format!("({a} - {b})"),
                9 | 10 => format!("({a}) * ({b})"),
                _ => format!("({a}) / (2 + ({b})^2)"),
            }
        }
    }
}

struct Chain {
    /// First models.
    first: Vec<String>,
    second: String,
    /// Both in one.
    whole: String,
    /// Every ν above 4.
    many: bool,
}

fn chain(rng: &mut Random) -> Chain {
    let share = *[0.01, 0.05, 0.1, 0.3].choose(rng).unwrap_or(&0.1);
    let mut many = true;
    let mut add = |rng: &mut Random, name: &str| {
        let (text, enough) = input(rng, name, share);
        many &= enough;
        text
    };
    let results = rng.random_range(1..=2);
    let shared = (results == 2 && rng.random_bool(0.5)).then(|| add(rng, "shared"));
    let mut whole = shared.clone().unwrap_or_default();
    let mut parts = String::new();
    let (mut first, mut second, mut names) = (Vec::new(), String::new(), Vec::new());
    for k in 0..results {
        let mut text = shared.clone().unwrap_or_default();
        let mut own: Vec<String> = shared.iter().map(|_| "shared".to_owned()).collect();
        for i in 0..rng.random_range(1..=3) {
            let name = format!("x{k}{i}");
            let input = add(rng, &name);
            text += &input;
            whole += &input;
            own.push(name);
        }
        let outputs = rng.random_range(1..=2);
        let mut wanted = Vec::new();
        for o in 0..outputs {
            let name = format!("y{k}{o}");
            let depth = rng.random_range(1..=2);
            let expression = formula(rng, &own, depth);
            text += &format!(
                "[[output]]\nname = \"{name}\"\nunit = \"1\"\nexpression = \"{expression}\"\n"
            );
            parts +=
                &format!("[[intermediate]]\nname = \"{name}\"\nexpression = \"{expression}\"\n");
            wanted.push(format!("{name} = \"{name}\""));
            names.push(name);
        }
        second += &format!(
            "[[earlier]]\nfile = \"first{k}/result.json\"\nquantities = {{ {} }}\n",
            wanted.join(", ")
        );
        first.push(text);
    }
    for i in 0..rng.random_range(0..=2) {
        let name = format!("z{i}");
        let input = add(rng, &name);
        second += &input;
        whole += &input;
        names.push(name);
    }
    let depth = rng.random_range(1..=3);
    let mut expression = formula(rng, &names, depth);
    // Every result has a say.
    for name in names.iter().filter(|n| n.starts_with('y')) {
        if !expression.contains(name.as_str()) {
            expression += &format!(" + {name}");
        }
    }
    let output = format!("[[output]]\nname = \"w\"\nunit = \"1\"\nexpression = \"{expression}\"\n");
    Chain {
        first,
        second: second + &output,
        whole: whole + &parts + &output,
        many,
    }
}

fn model(folder: &Path, name: &str, text: &str) -> Result<ModelText> {
    let path = folder.join(format!("{name}.toml"));
    std::fs::write(&path, text)?;
    Ok(ModelText::read(Source::open(&path)?)?)
}

fn evaluate(folder: &Path, name: &str, text: &str, trials: Trials) -> Result<UncertaintyOutcome> {
    let options = Evaluate {
        trials,
        seed: 1 + name.len() as u64,
        ..Evaluate::default()
    };
    let outcome = model(folder, name, text)?.evaluate(options, &Unwatched)?;
    let into = folder.join(name);
    std::fs::create_dir_all(&into)?;
    for (file, bytes) in StoredResult::new(Record::default(), &outcome)?.files()? {
        std::fs::write(into.join(file), bytes)?;
    }
    Ok(outcome)
}

/// Whether u of as many trials of another seed is the same to 1 %: where a distribution has no fourth moment it is not.
fn settles(folder: &Path, text: &str, trials: usize, u: f64) -> Result<bool> {
    let model = model(folder, "whole", text)?;
    for seed in [101, 102, 103] {
        let options = Evaluate {
            trials: Trials::Fixed(trials),
            seed,
            ..Evaluate::default()
        };
        let again = model.evaluate(options, &Unwatched)?;
        let of_trials = again.result.outputs[0].monte_carlo.as_ref();
        let other = of_trials.and_then(|m| m.standard_uncertainty);
        if !other.is_some_and(|other| (other / u - 1.0).abs() < 0.01) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// What became of the chains.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) chains: usize,
    pub(crate) refused: usize,
    /// Firsts stated by their trials.
    pub(crate) by_trials: usize,
    /// What is said and not counted below: a decision is asked for (causes shared by two tables of trials, trials without a
    /// number), or a first result is drawn by the law of propagation for what it shares.
    pub(crate) said: usize,
    /// u that does not settle in the trials of the truth: compared by the ends.
    pub(crate) unsettled: usize,
    pub(crate) u_beyond: usize,
    pub(crate) ends_beyond: usize,
    pub(crate) validated: usize,
    pub(crate) validated_wrongly: usize,
    pub(crate) stated_beyond: usize,
    pub(crate) worst_u: f64,
    pub(crate) worst_end: f64,
}

fn compare(rng: &mut Random, seed: u64, trials: usize, tally: &mut Tally) -> Result<()> {
    let chain = chain(rng);
    let folder = tempfile::tempdir()?;
    let adaptive = Evaluate::default().trials;
    let whole = evaluate(folder.path(), "whole", &chain.whole, Trials::Fixed(trials));
    let Ok(whole) = whole else {
        tally.refused += 1;
        return Ok(());
    };
    let mut by_trials = false;
    for (k, text) in chain.first.iter().enumerate() {
        let first = evaluate(folder.path(), &format!("first{k}"), text, adaptive)?;
        let trials = |o: &proofmass_uncertainty::OutputResult| {
            o.stated.method == StatementMethod::MonteCarlo
        };
        by_trials |= first.result.outputs.iter().any(trials);
    }
    let second = evaluate(folder.path(), "second", &chain.second, adaptive)?;
    let (whole, output) = (&whole.result.outputs[0], &second.result.outputs[0]);
    let (Some(truth), Some(got)) = (&whole.monte_carlo, &output.monte_carlo) else {
        tally.refused += 1;
        return Ok(());
    };
    tally.chains += 1;
    tally.by_trials += usize::from(by_trials);
    let mut findings = second.result.findings.iter();
    if findings.any(|f| match f.code() {
        // What the chain itself is compared by.
        "linear-result-not-validated" => false,
        "earlier-result-linearised" => true,
        _ => f.severity() == Severity::Decision,
    }) {
        tally.said += 1;
        return Ok(());
    }
    let half = 0.5 * truth.symmetric.width();
    let off = |lower: f64, upper: f64| {
        (lower - truth.symmetric.lower)
            .abs()
            .max((upper - truth.symmetric.upper).abs())
            / half
    };
    // Three standard deviations of what chance does to the ends of both.
    let chance = 3.0 * truth.symmetric_scatter.hypot(got.symmetric_scatter) / half;
    let ends = (off(got.symmetric.lower, got.symmetric.upper) - chance).max(0.0);
    let stated = off(output.stated.interval.lower, output.stated.interval.upper);
    let u = truth.standard_uncertainty.zip(got.standard_uncertainty);
    let mut u = u
        .map(|(truth, got)| (got / truth - 1.0).abs())
        .filter(|_| chain.many);
    let of_truth = truth.standard_uncertainty.unwrap_or_default();
    if u.is_some_and(|u| u > 0.02) && !settles(folder.path(), &chain.whole, trials, of_truth)? {
        tally.unsettled += 1;
        u = None;
    }
    let beyond = match u {
        Some(u) => {
            tally.worst_u = tally.worst_u.max(u);
            tally.u_beyond += usize::from(u > 0.02);
            u > 0.02
        }
        None => {
            tally.worst_end = tally.worst_end.max(ends);
            tally.ends_beyond += usize::from(ends > 0.05);
            ends > 0.05
        }
    };
    let verdict = output.validation.as_ref().map(|v| v.verdict);
    let validated = verdict == Some(Verdict::Validated);
    tally.validated += usize::from(validated);
    // The verdict allows half a unit of the first digit; beside it what a chain may add, 5 % of the half-width.
    let linear = output.linear.as_ref().map(|l| {
        let (y, expanded) = (l.quantity.value, l.expanded_uncertainty);
        off(y - expanded, y + expanded)
    });
    let delta = output
        .validation
        .as_ref()
        .map_or(0.0, |v| v.tolerance / half);
    let wrongly = validated && linear.is_some_and(|off| off > delta + 0.05);
    tally.validated_wrongly += usize::from(wrongly);
    let few = output
        .validation
        .as_ref()
        .is_some_and(|v| v.few_degrees_of_freedom);
    let by_law = output.stated.method == StatementMethod::LawOfPropagation;
    let far = stated > 0.05 + if by_law { delta } else { 0.05 } && !few;
    tally.stated_beyond += usize::from(far);
    if beyond || wrongly || far {
        println!(
            "seed {seed}: u {}, ends {:.1} %, stated {:.1} % by {}, {verdict:?}\n{}---\n{}",
            u.map_or_else(
                || "not compared".to_owned(),
                |u| format!("{:.1} %", 100.0 * u)
            ),
            100.0 * ends,
            100.0 * stated,
            output.stated.method.words(),
            chain.first.join("--\n"),
            chain.second
        );
    }
    Ok(())
}

/// Chains of these seeds.
pub(crate) fn run(count: u64, start: u64, truth: usize) -> Result<Tally> {
    let mut tally = Tally::default();
    for seed in start..start + count {
        let mut rng = Random::seed_from_u64(seed);
        compare(&mut rng, seed, truth, &mut tally).map_err(|e| format!("seed {seed}: {e}"))?;
    }
    Ok(tally)
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map(|a| a.parse::<u64>());
    let mut next = |default: u64| arguments.next().transpose().map(|n| n.unwrap_or(default));
    let (count, start, truth) = (next(500)?, next(1)?, next(1_000_000)? as usize);
    let tally = run(count, start, truth)?;
    println!(
        "| chains | refused | a first result by trials | said by a finding | u of the truth does not settle | u beyond 2 % (worst) | ends beyond 5 % (worst) | validated | wrongly | stated beyond what is allowed |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    println!(
        "| {} | {} | {} | {} | {} | {} ({:.1} %) | {} ({:.1} %) | {} | {} | {} |",
        tally.chains,
        tally.refused,
        tally.by_trials,
        tally.said,
        tally.unsettled,
        tally.u_beyond,
        100.0 * tally.worst_u,
        tally.ends_beyond,
        100.0 * tally.worst_end,
        tally.validated,
        tally.validated_wrongly,
        tally.stated_beyond
    );
    Ok(())
}

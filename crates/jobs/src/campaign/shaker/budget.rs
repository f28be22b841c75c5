//! `[[budget]]` or a budget file: what is uncertain on the bench, what it acts on, with what it varies.

use crate::campaign::CampaignFile;
use crate::device_output::DeviceOutput;
use proofmass_io::{Error, ErrorKind, Input, Result};
use proofmass_shaker::{Acts, Key};
use proofmass_uncertainty::{Distribution, Evaluation, InputEntry};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::path::Path;

/// `[[budget]]` entries, or `[budget]` with a file or the name of a known bench.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct BudgetTable {
    /// File of the budget, relative to the campaign.
    pub(crate) file: Option<String>,
    /// Name of a bench whose budget is known: `published`.
    pub(crate) bench: Option<String>,
}

/// Where a budget is written.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum BudgetSource {
    Entries(Vec<InputEntry>),
    Table(BudgetTable),
    #[default]
    Missing,
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for BudgetSource {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "BudgetSource".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let entries = generator.subschema_for::<Vec<InputEntry>>();
        let table = generator.subschema_for::<BudgetTable>();
        schemars::json_schema!({"anyOf": [entries, table]})
    }
}

impl<'de> Deserialize<'de> for BudgetSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct Written;
        impl<'de> Visitor<'de> for Written {
            type Value = BudgetSource;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("[[budget]] entries or one table [budget]")
            }

            fn visit_seq<A: SeqAccess<'de>>(
                self,
                entries: A,
            ) -> std::result::Result<BudgetSource, A::Error> {
                let entries = SeqAccessDeserializer::new(entries);
                Vec::deserialize(entries).map(BudgetSource::Entries)
            }

            fn visit_map<A: MapAccess<'de>>(
                self,
                table: A,
            ) -> std::result::Result<BudgetSource, A::Error> {
                let table = MapAccessDeserializer::new(table);
                BudgetTable::deserialize(table).map(BudgetSource::Table)
            }
        }
        deserializer.deserialize_any(Written)
    }
}

/// The budget of a campaign on the shaker.
#[derive(Clone, Debug, PartialEq)]
pub enum ShakerBudget {
    /// Inputs one by one, with the file they came from when it is not the campaign itself.
    Inputs(proofmass_shaker::Budget, Option<Input>),
    /// That of the published bench, known by name.
    Published,
}

impl ShakerBudget {
    /// Budgets known by name.
    pub const BENCHES: &[&str] = &["published"];

    /// Every input is stated at these frequencies, Hz.
    ///
    /// # Errors
    /// The first whose uncertainty over frequency does not reach one of them.
    pub(crate) fn reaches(
        &self,
        source: &CampaignFile,
        frequencies: impl IntoIterator<Item = f64>,
    ) -> Result<()> {
        let Self::Inputs(budget, file) = self else {
            return Ok(());
        };
        for f in frequencies {
            let Some(input) = budget.inputs.iter().find(|i| !i.reaches(f)) else {
                continue;
            };
            let list = &input.at_frequencies;
            let ends = list.first().zip(list.last()).map(|(a, b)| (a.0, b.0));
            let (low, high) = ends.unwrap_or_default();
            let path = file
                .as_ref()
                .map_or(source.path.as_path(), |i| Path::new(&i.path));
            return Err(Error::new(
                ErrorKind::Configuration,
                format!(
                    "input \"{}\" states its uncertainty from {low} to {high} Hz, and a run is at {f} Hz",
                    input.key
                ),
            )
            .at(path)
            .column("over_frequency")
            .with_hint("add the uncertainty there: between the stated frequencies it is linear in log f, beyond them nobody knows it"));
        }
        Ok(())
    }

    fn between_sessions(&self) -> Option<&proofmass_shaker::ShakerInput> {
        match self {
            Self::Inputs(budget, _) => {
                let mut inputs = budget.inputs.iter();
                inputs.find(|i| i.varies_with.contains(&Key::Session))
            }
            Self::Published => None,
        }
    }

    /// The runs name their sessions where an input varies with them.
    ///
    /// # Errors
    /// They do not.
    pub(crate) fn finds_sessions(
        &self,
        source: &CampaignFile,
        table: &Path,
        named: bool,
    ) -> Result<()> {
        let Some(input) = self.between_sessions().filter(|_| !named) else {
            return Ok(());
        };
        let what = format!(
            "input \"{}\" varies with the session, and the runs name none",
            input.key
        );
        let hint = format!(
            "add a column `session` to {} with a word for each run, such as its date, or take \"session\" out of varies_with",
            table.display()
        );
        Err(match self {
            Self::Inputs(_, Some(file)) => Error::new(ErrorKind::Configuration, what)
                .at(Path::new(&file.path))
                .column("varies_with"),
            _ => {
                let error = Error::new(ErrorKind::Configuration, what)
                    .at(&source.path)
                    .column("varies_with");
                match line_of(&source.text, &input.key) {
                    Some(line) => error.line(line),
                    None => error,
                }
            }
        }
        .with_hint(hint))
    }

    /// The inputs. Where a certificate is at hand it counts, and not the one that was printed.
    pub fn budget(&self, certificate: bool) -> proofmass_shaker::Budget {
        match self {
            Self::Inputs(budget, _) => budget.clone(),
            Self::Published => {
                let mut budget = proofmass_shaker::Budget::published_bench();
                if certificate {
                    budget.inputs.retain(|i| i.acts != Acts::ReferenceModulus);
                }
                budget
            }
        }
    }
}

/// Units an action admits, with their factors to SI.
type Units = &'static [(&'static str, f64)];
const RELATIVE: Units = &[("1", 1.0), ("%", 0.01)];
const ANGULAR: Units = &[
    ("rad", 1.0),
    ("mrad", 1e-3),
    ("deg", std::f64::consts::PI / 180.0),
    ("°", std::f64::consts::PI / 180.0),
];
const ELECTRIC: Units = &[("V", 1.0), ("mV", 1e-3), ("µV", 1e-6), ("uV", 1e-6)];

const COUNTS: Units = &[("count", 1.0)];
const ACCELERATIONS: Units = &[
    ("m/s²", 1.0),
    ("m/s2", 1.0),
    ("g", proofmass_core::STANDARD_GRAVITY),
    ("mg", 1e-3 * proofmass_core::STANDARD_GRAVITY),
];

/// Of an action on outputs of this kind.
fn units(acts: Acts, output: DeviceOutput) -> Units {
    match (acts.unit(), output) {
        ("1", _) => RELATIVE,
        ("V", DeviceOutput::Volt) => ELECTRIC,
        ("V", DeviceOutput::Count) => COUNTS,
        ("V", DeviceOutput::Acceleration) => ACCELERATIONS,
        _ => ANGULAR,
    }
}

/// What is wrong with an entry, and what to do.
type Complaint = (String, String);

fn input(
    entry: &InputEntry,
    output: DeviceOutput,
) -> std::result::Result<proofmass_shaker::ShakerInput, Complaint> {
    let choice = |what: &str, word: &str, valid: &[&str]| {
        let near = proofmass_io::spelling::nearest(word, valid.iter().copied())
            .map_or(String::new(), |k| format!("did you mean \"{k}\"? "));
        (
            format!("input \"{}\": unknown {what} \"{word}\"", entry.name),
            format!("{near}valid here: {}", valid.join(", ")),
        )
    };
    let actions = Acts::ALL.map(Acts::name);
    let Some(word) = &entry.acts else {
        return Err((
            format!("input \"{}\" does not say what it acts on", entry.name),
            format!("add acts = \"…\": {}", actions.join(", ")),
        ));
    };
    let Some(acts) = Acts::ALL.into_iter().find(|a| a.name() == word) else {
        return Err(choice("action", word, &actions));
    };
    let varies_with = entry
        .varies_with
        .iter()
        .map(|word| {
            Key::ALL
                .into_iter()
                .find(|k| k.name() == word)
                .ok_or_else(|| choice("grouping key", word, &Key::ALL.map(Key::name)))
        })
        .collect::<std::result::Result<Vec<_>, _>>()?;
    let units = units(acts, output);
    let Some(&(_, factor)) = units.iter().find(|(u, _)| *u == entry.unit) else {
        let valid: Vec<&str> = units.iter().map(|u| u.0).collect();
        return Err(choice("unit", &entry.unit, &valid));
    };
    let impossible = |e: proofmass_core::Error| {
        (
            format!("input \"{}\": {e}", entry.name),
            "write value and u, or distribution = { kind = \"rectangular\", lower = …, upper = … }; other kinds are normal, triangular, arcsine, student-t, trapezoidal".to_owned(),
        )
    };
    let list = match &entry.over_frequency {
        Some(list) => over_frequency(entry, acts, list)?,
        None => Vec::new(),
    };
    let distribution = match (&entry.distribution, &entry.observations) {
        (None, None) if !list.is_empty() => Distribution::Normal {
            mean: 0.0,
            u: list.iter().fold(0.0, |a: f64, (_, u)| a.max(*u)),
        },
        (Some(_), _) | (_, Some(_)) if !list.is_empty() => {
            return Err((
                format!(
                    "input \"{}\": over_frequency says u, and a distribution or observations say it again",
                    entry.name
                ),
                "keep one of the two; over_frequency holds standard uncertainties of a normal distribution"
                    .to_owned(),
            ));
        }
        (Some(distribution), None) => {
            distribution.check().map_err(impossible)?;
            let mean = distribution.estimate();
            if mean.abs() > 1e-9 * distribution.standard_uncertainty() {
                return Err((
                    format!(
                        "input \"{}\" has the mean {mean}, and an error has none",
                        entry.name
                    ),
                    "correct the data for what is known, and state what is left about zero"
                        .to_owned(),
                ));
            }
            distribution.clone()
        }
        // Of observations only the scatter is an error; their mean is for the operator to correct.
        (None, Some(values)) => Distribution::from_observations(values).map_err(impossible)?,
        _ => {
            return Err((
                format!(
                    "input \"{}\": one of `distribution`, `observations` and `over_frequency` is needed",
                    entry.name
                ),
                "such as distribution = { kind = \"normal\", mean = 0.0, u = 0.002 }".to_owned(),
            ));
        }
    };
    let description = entry.description.as_ref().unwrap_or(&entry.name);
    let mut input = proofmass_shaker::ShakerInput::new(&entry.name, acts, 0.0, &varies_with)
        .described(description);
    input.evaluation = entry.evaluation.unwrap_or(match distribution {
        Distribution::StudentT { .. } => Evaluation::A,
        _ => Evaluation::B,
    });
    input.dof = entry.dof.unwrap_or(distribution.dof());
    input.distribution = distribution.scaled(factor, -factor * distribution.estimate());
    input.at_frequencies = list.iter().map(|(f, u)| (*f, u * factor)).collect();
    Ok(input)
}

/// Standard uncertainties over frequency, (Hz, u in the unit of the entry).
fn over_frequency(
    entry: &InputEntry,
    acts: Acts,
    list: &[[f64; 2]],
) -> std::result::Result<Vec<(f64, f64)>, Complaint> {
    let refuse = |what: String, hint: &str| {
        Err((format!("input \"{}\": {what}", entry.name), hint.to_owned()))
    };
    if acts.is_angle() {
        return refuse(
            "an angle is the same at every frequency".to_owned(),
            "state it by `distribution`, and what changes with the frequency as an error of an output or of the reference",
        );
    }
    if list.is_empty() {
        return refuse(
            "over_frequency is empty".to_owned(),
            "pairs of frequency in Hz and standard uncertainty: over_frequency = [[5, 0.4], [160, 0.2]]",
        );
    }
    for pair in list {
        let [f, u] = *pair;
        if !(f.is_finite() && f > 0.0 && u.is_finite() && u >= 0.0) {
            return refuse(
                format!(
                    "[{f}, {u}] in over_frequency is out of range: the frequency must be above 0 Hz, the standard uncertainty must not be negative"
                ),
                "write pairs of frequency in Hz and standard uncertainty: over_frequency = [[5, 0.4], [160, 0.2]]",
            );
        }
    }
    if let Some(pair) = list.windows(2).find(|p| p[1][0] <= p[0][0]) {
        return refuse(
            format!(
                "over_frequency has {} Hz behind {} Hz",
                pair[1][0], pair[0][0]
            ),
            "list each frequency once, in ascending order",
        );
    }
    Ok(list.iter().map(|[f, u]| (*f, *u)).collect())
}

impl ShakerBudget {
    pub(crate) fn read(
        source: &CampaignFile,
        budget: &BudgetSource,
        output: DeviceOutput,
    ) -> Result<Self> {
        match budget {
            BudgetSource::Missing => Err(source
                .refuse("", "budget", "the campaign states no budget of uncertainty")
                .with_hint("add [[budget]] entries, [budget] file = \"budget.toml\", or [budget] bench = \"published\"")),
            BudgetSource::Entries(entries) => {
                Ok(Self::Inputs(convert(entries, &source.path, &source.text, output)?, None))
            }
            BudgetSource::Table(BudgetTable { file: Some(file), bench: None }) => {
                let path = source.resolve(file);
                let (text, input) = source.text(file)?;
                let budget = proofmass_documents::read_budget(&text).map_err(|refusal| {
                    let (line, what) = match refusal {
                        proofmass_uncertainty::Refusal::File { line, reason } => (line, reason),
                        other => (None, other.to_string()),
                    };
                    let error = Error::new(ErrorKind::Configuration, what)
                        .at(&path)
                        .with_hint("a budget is TOML: one [[input]] table for each input, with name, acts, unit, and u or a distribution");
                    match line {
                        Some(line) => error.line(line as u64),
                        None => error,
                    }
                })?;
                if let Some(correlation) = budget.correlation.first() {
                    return Err(Error::new(
                        ErrorKind::Configuration,
                        format!("correlations are not accepted in a shaker budget: between {} and {}", correlation.between[0], correlation.between[1]),
                    )
                    .at(&path)
                    .with_hint("make the common part an input of its own, with the keys it varies with"));
                }
                Ok(Self::Inputs(convert(&budget.input, &path, &text, output)?, Some(input)))
            }
            BudgetSource::Table(BudgetTable { file: None, bench: Some(bench) }) => {
                if Self::BENCHES.contains(&bench.as_str()) {
                    return Ok(Self::Published);
                }
                Err(source
                    .refuse("budget", "bench", format!("unknown bench \"{bench}\""))
                    .with_hint(format!("known: {}", Self::BENCHES.join(", "))))
            }
            BudgetSource::Table(_) => Err(source
                .refuse("budget", "file", "[budget] names either `file` or `bench`")
                .with_hint("[budget] file = \"budget.toml\", or bench = \"published\"")),
        }
    }
}

/// Line of an entry, by its name.
fn line_of(text: &str, name: &str) -> Option<u64> {
    let quoted = format!("\"{name}\"");
    let of = |l: &str| l.trim_start().starts_with("name") && l.contains(&quoted);
    text.lines().position(of).map(|line| line as u64 + 1)
}

fn convert(
    entries: &[InputEntry],
    path: &Path,
    text: &str,
    output: DeviceOutput,
) -> Result<proofmass_shaker::Budget> {
    let mut inputs: Vec<proofmass_shaker::ShakerInput> = Vec::new();
    for entry in entries {
        let refuse = |what: String, hint: String| {
            let line = line_of(text, &entry.name);
            let error = Error::new(ErrorKind::Configuration, what)
                .at(path)
                .column("budget")
                .with_hint(hint);
            match line {
                Some(line) => error.line(line),
                None => error,
            }
        };
        let input = input(entry, output).map_err(|(what, hint)| refuse(what, hint))?;
        if inputs.iter().any(|i| i.key == input.key) {
            return Err(refuse(
                format!("input \"{}\" stands twice in the budget", input.key),
                "give every input a name of its own".to_owned(),
            ));
        }
        inputs.push(input);
    }
    let budget = proofmass_shaker::Budget::new(inputs).map_err(|e| {
        Error::new(ErrorKind::Configuration, e.to_string())
            .at(path)
            .column("budget")
    })?;
    Ok(budget.of_outputs(output.triaxial()))
}

//! Whether stated numbers meet limits, by a rule that is printed.

use super::laboratory::{CertificateFile, ConformityEntry, RuleWord};
use super::results::StatedResults;
use super::texts::{Language, Text};
use crate::StoredResult;
use crate::trouble::{Result, Trouble};
use proofmass_documents::StatedQuantity;
use proofmass_report::number::plain;
use proofmass_uncertainty::{DecisionRule, DegreesOfFreedom, Measured, Quantity};
use serde::{Deserialize, Serialize};

/// One decision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Decided {
    /// Name of the quantity.
    pub quantity: String,
    /// Whether it passes.
    pub pass: bool,
    /// Probability that the decision is wrong, rounded.
    pub risk: String,
}

/// The decisions of one entry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DecidedEntry {
    pub(crate) entry: ConformityEntry,
    /// Unit of the limits.
    pub(crate) unit: String,
    /// One for each number.
    pub decisions: Vec<Decided>,
}

/// Decides every entry of a file.
///
/// # Errors
/// A quantity that the result does not state or states without a standard uncertainty; limits or a rule that cannot be.
pub(crate) fn decide(
    file: &CertificateFile,
    result: &StoredResult,
    stated: &StatedResults,
) -> Result<Vec<DecidedEntry>> {
    file.conformity
        .iter()
        .map(|entry| decide_one(entry, result, stated))
        .collect()
}

fn decide_one(
    entry: &ConformityEntry,
    result: &StoredResult,
    stated: &StatedResults,
) -> Result<DecidedEntry> {
    let (limits, rule) = (entry.limits()?, entry.decision_rule()?);
    let columns = stated.tables.iter().flat_map(|t| &t.columns);
    let column = columns.clone().find(|c| c.name == entry.quantity);
    let single = stated.singles.iter().find(|s| s.name == entry.quantity);
    let (unit, factor) = match (column, single) {
        (Some(column), _) => (column.unit.clone(), column.factor),
        (None, Some(single)) => {
            let of = result.quantities().iter().find(|q| q.name == single.name);
            let factor = of.map_or(1.0, |q| single.factor(q));
            (single.unit.clone(), factor)
        }
        (None, None) => {
            let names = columns
                .map(|c| c.name.as_str())
                .chain(stated.singles.iter().map(|s| s.name.as_str()));
            let names: Vec<&str> = names.collect();
            let near = proofmass_io::spelling::nearest(&entry.quantity, names.iter().copied());
            let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
            return Err(Trouble::request(format!(
                "conformity: the result states no {}",
                entry.quantity
            ))
            .with_hint(format!("{near}it states {}", names.join(", "))));
        }
    };
    let is_of = |q: &&StatedQuantity| {
        q.expanded > 0.0
            && (q.name == entry.quantity
                || proofmass_documents::at_frequency(&q.name)
                    .is_some_and(|(name, _)| name == entry.quantity))
    };
    let mut decisions = Vec::new();
    for q in result.quantities().iter().filter(is_of) {
        let u = q.u.ok_or_else(|| {
            Trouble::data(format!(
                "conformity: {} has no standard uncertainty, so no risk can be stated",
                q.name
            ))
        })?;
        let measured = Measured::of(&Quantity {
            name: q.name.clone(),
            unit: unit.clone(),
            value: q.value * factor,
            standard_uncertainty: u * factor,
            dof: q.nu_eff.unwrap_or(DegreesOfFreedom::INFINITE),
        });
        if let (DecisionRule::GuardBand { factor: r }, Some(lower), Some(upper)) =
            (rule, entry.lower, entry.upper)
            && 2.0 * r * q.expanded * factor >= upper - lower
        {
            return Err(Trouble::data(format!(
                "conformity: between {lower} and {upper} {unit} nothing is left behind guard bands of {r} U of {}",
                q.name
            ))
            .with_hint("the uncertainty is too large for these limits: state them in the unit of the certificate, or choose another r"));
        }
        let decision = limits.decide(&measured, q.expanded * factor, rule, None)?;
        decisions.push(Decided {
            quantity: q.name.clone(),
            pass: decision.accepted,
            risk: risk(decision.risk),
        });
    }
    Ok(DecidedEntry {
        entry: entry.clone(),
        unit,
        decisions,
    })
}

/// A probability in per cent, upwards to a tenth.
fn risk(p: f64) -> String {
    match 100.0 * p {
        small if small < 0.1 => "< 0.1 %".to_owned(),
        other => format!("{:.1} %", (10.0 * other - 1e-9).ceil() / 10.0),
    }
}

impl DecidedEntry {
    /// Limits, where they come from, and the rule, in one sentence each.
    pub(crate) fn declaration(&self, language: Language) -> String {
        let limit = |text: Text, limit: Option<f64>| {
            limit.map(|l| format!("{}: {l} {}. ", text.of(language), self.unit))
        };
        let source = self.entry.source.as_ref();
        let source = source.map(|s| format!("{}: {s}. ", Text::LimitsFrom.of(language)));
        let parts = [
            limit(Text::LowerLimit, self.entry.lower),
            limit(Text::UpperLimit, self.entry.upper),
            source,
        ];
        let before: String = parts.into_iter().flatten().collect();
        format!(
            "{before}{}: {}",
            Text::Rule.of(language),
            self.rule(language, str::to_owned)
        )
    }

    /// The rule in words, with its number in the digits of the certificate.
    pub(crate) fn rule(&self, language: Language, digits: impl Fn(&str) -> String) -> String {
        match self.entry.rule {
            RuleWord::Simple => Text::SimpleRule.of(language).to_owned(),
            RuleWord::GuardBand => {
                let r = digits(&plain(self.entry.r.unwrap_or_default()));
                Text::GuardRule.with(language, &[("r", &r)])
            }
        }
    }
}

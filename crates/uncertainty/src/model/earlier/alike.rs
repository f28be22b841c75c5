//! Causes that two earlier results name alike and state almost alike: rounding, or a certificate copied with fewer digits, makes two
//! causes of one.

use super::EarlierEntry;
use crate::{DegreesOfFreedom, Effect, Estimate};

/// Standard uncertainties that differ by less are perhaps meant to be the same.
const NEARLY: f64 = 0.01;

/// A cause as a result states it.
struct Stated<'a> {
    key: &'a str,
    unit: &'a str,
    u: f64,
    dof: DegreesOfFreedom,
}

impl Stated<'_> {
    /// Whether the other is this cause but for a little of u, or for ν.
    fn nearly(&self, other: &Self) -> bool {
        let apart = (self.u - other.u).abs() / self.u.max(other.u);
        let same = crate::estimate::same(self.u, other.u) && self.dof == other.dof;
        self.key == other.key && self.unit == other.unit && apart < NEARLY && !same
    }

    fn text(&self, file: &str) -> String {
        let unit = match self.unit {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        let nu = match self.dof.is_infinite() {
            true => String::new(),
            false => format!(" with ν = {}", self.dof.get()),
        };
        format!("{}{unit}{nu} in {file}", self.u)
    }
}

impl EarlierEntry {
    /// The causes that another result may share.
    fn stated(&self) -> Vec<Stated<'_>> {
        let own = |key: &str| self.independent.iter().any(|k| k == key);
        let mut causes = Vec::new();
        if let Some(table) = self.drawn() {
            for c in table.columns.iter().filter(|c| c.cause && !own(&c.name)) {
                causes.extend(c.dof.map(|dof| Stated {
                    key: &c.name,
                    unit: &c.unit,
                    u: c.scale,
                    dof,
                }));
            }
            return causes;
        }
        for influence in self.estimate.iter().flat_map(Estimate::influences) {
            if let Effect::Scalar {
                unit,
                standard_uncertainty,
                ..
            } = &influence.effect
                && *standard_uncertainty > 0.0
                && !own(&influence.key)
            {
                causes.push(Stated {
                    key: &influence.key,
                    unit,
                    u: *standard_uncertainty,
                    dof: influence.dof,
                });
            }
        }
        causes
    }
}

/// What two results name alike and state almost alike, in words.
pub(super) fn nearly_alike(entries: &[EarlierEntry]) -> Vec<String> {
    let mut told = Vec::new();
    for (k, entry) in entries.iter().enumerate() {
        let causes = entry.stated();
        for other in &entries[..k] {
            for theirs in other.stated() {
                let near = causes.iter().filter(|c| c.nearly(&theirs));
                told.extend(near.map(|ours| {
                    let (first, second) = (theirs.text(&other.file), ours.text(&entry.file));
                    format!("{}: u = {first}, {second}", ours.key)
                }));
            }
        }
    }
    told
}

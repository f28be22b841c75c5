//! What inputs must agree in before they are drawn together.

use super::{Draw, Inputs};
use crate::Refusal;
use proofmass_core::Error;

impl Inputs {
    /// Degrees of freedom that can be drawn from, and one number of them per set that was estimated as a whole.
    pub(super) fn check_degrees_of_freedom(&self) -> Result<(), Refusal> {
        for input in &self.inputs {
            // One observation more than parameters gives 1; pooled values may fall a little below.
            if input.dof.get() < 0.5 {
                return Err(Refusal::Input {
                    name: input.name.clone(),
                    source: Error::OutOfRange {
                        name: "dof",
                        value: input.dof.get(),
                        min: 0.5,
                        max: f64::MAX,
                    },
                });
            }
        }
        for set in &self.rows {
            let name = |i: usize| self.inputs[i].name.as_str();
            let inside = |other: &str| set.iter().any(|&i| name(i) == other);
            let mixed = self
                .correlations
                .iter()
                .find(|(a, b, _)| inside(a) != inside(b));
            if let Some((a, b, _)) = mixed {
                return Err(Refusal::Contradiction {
                    name: if inside(a) { a.clone() } else { b.clone() },
                    what: "samples drawn together say their correlation themselves; none with another input can be added",
                });
            }
            if let Some(&i) = set.iter().find(|&&i| {
                !self.inputs[i].dof.is_infinite() || !self.inputs[i].varies_with.is_empty()
            }) {
                return Err(Refusal::Contradiction {
                    name: name(i).to_owned(),
                    what: "samples drawn together have neither `dof` nor `varies_with`",
                });
            }
        }
        for set in &self.together {
            let first = set.first().map(|&i| self.inputs[i].dof);
            if let Some(&other) = set.iter().find(|&&i| Some(self.inputs[i].dof) != first) {
                return Err(Refusal::Incomplete {
                    name: self.inputs[other].name.clone(),
                    needed: "the same number of degrees of freedom as the inputs it was observed together with",
                });
            }
        }
        Ok(())
    }

    /// Coefficients by draw; a bare input name pairs the draws with equal labels.
    pub(super) fn resolve(&self, draws: &[Draw]) -> Result<Vec<(usize, usize, f64)>, Refusal> {
        let mut resolved = Vec::new();
        for (k, (first, second, r)) in self.correlations.iter().enumerate() {
            let same = |(a, b, _): &(String, String, f64)| {
                (a == first && b == second) || (a == second && b == first)
            };
            let what = if !(-1.0..=1.0).contains(r) {
                Some("lies outside −1 to 1")
            } else if first == second {
                Some("is that of a quantity with itself, which is 1")
            } else if self.correlations[..k].iter().any(same) {
                Some("is given twice")
            } else {
                None
            };
            if let Some(what) = what {
                return Err(Refusal::Pair {
                    first: first.clone(),
                    second: second.clone(),
                    coefficient: *r,
                    what,
                });
            }
            let matching = |name: &str| -> Result<Vec<usize>, Refusal> {
                let found: Vec<usize> = (0..draws.len())
                    .filter(|&d| draws[d].name == name || self.inputs[draws[d].input].name == name)
                    .collect();
                let absent = found.is_empty()
                    && !self.inputs.iter().any(|i| {
                        name == i.name
                            || name
                                .strip_prefix(&i.name)
                                .is_some_and(|rest| rest.starts_with('['))
                    });
                if absent {
                    return Err(Refusal::Unknown {
                        what: "input",
                        name: name.to_owned(),
                    });
                }
                Ok(found)
            };
            let (a, b) = (matching(first)?, matching(second)?);
            let named_draws = first.contains('[') || second.contains('[');
            for &i in &a {
                for &j in &b {
                    if i != j && (named_draws || draws[i].labels == draws[j].labels) {
                        resolved.push((i, j, *r));
                    }
                }
            }
        }
        Ok(resolved)
    }
}

//! Which line of a budget or model file a refusal speaks of.

use proofmass_uncertainty::{CorrelationEntry, InputEntry, Refusal};

/// Keys of the uncertainty of an input.
const SPREADS: [&str; 5] = ["u", "U", "half_width", "resolution", "accuracy"];

/// One formula and where it stands in the file.
pub(super) struct Formula<'a> {
    pub(crate) table: &'static str,
    pub(crate) number: usize,
    pub(crate) name: &'a str,
    pub(crate) key: &'static str,
    pub(crate) text: &'a str,
}

impl<'a> Formula<'a> {
    pub fn new(
        table: &'static str,
        number: usize,
        name: &'a str,
        key: &'static str,
        text: &'a str,
    ) -> Self {
        Self {
            table,
            number,
            name,
            key,
            text,
        }
    }

    /// The key under which its name stands.
    fn named(&self) -> &'static str {
        match self.table {
            "fit" | "solve" | "earlier" => self.key,
            _ => "name",
        }
    }
}

/// Line of a byte, from 1.
pub(super) fn line_at(text: &str, byte: usize) -> usize {
    let before = &text.as_bytes()[..byte.min(text.len())];
    1 + before.iter().filter(|b| **b == b'\n').count()
}

/// A key of the `number`-th table of an array, as far as a refusal names one.
pub(super) struct Place(Option<(&'static str, usize, &'static str)>);

impl Place {
    /// Finds what a refusal speaks of among the entries of its file.
    pub fn of(
        refusal: &Refusal,
        inputs: &[InputEntry],
        correlations: &[CorrelationEntry],
        formulas: &[Formula<'_>],
    ) -> Self {
        // The draw `a[frequency=10]` belongs to the input `a`.
        let input = |wanted: &str| {
            let name = wanted.split('[').next().unwrap_or(wanted);
            inputs.iter().position(|i| i.name == name)
        };
        let pair = |named: &dyn Fn(&CorrelationEntry) -> bool, key| {
            let found = correlations.iter().position(named);
            found.map(|number| ("correlation", number, key))
        };
        Self(match refusal {
            Refusal::Input { name, .. } => input(name).map(|number| {
                let entry = &inputs[number];
                let key = if entry.observations.is_some() {
                    "observations"
                } else if entry.distribution.is_some() {
                    "distribution"
                } else {
                    "value"
                };
                ("input", number, key)
            }),
            Refusal::Contradiction { name, what } => {
                let about = SPREADS.iter().find(|key| {
                    let rest = what.strip_prefix('`').and_then(|w| w.strip_prefix(**key));
                    rest.is_some_and(|r| r.starts_with("` must") || r.starts_with("` needs"))
                });
                let key = about.copied().unwrap_or("name");
                input(name).map(|number| ("input", number, key))
            }
            Refusal::Incomplete { name, .. } => input(name).map(|number| ("input", number, "name")),
            Refusal::Name { name, .. } => {
                let formula = formulas.iter().find(|f| f.name == name);
                let place = formula.map(|f| (f.table, f.number, f.named()));
                place.or_else(|| {
                    let first = inputs.iter().position(|i| &i.name == name);
                    first.map(|number| ("input", number, "name"))
                })
            }
            Refusal::Output { name, .. } => {
                // `re(Z)` and `w[2]` belong to the outputs `Z` and `w`.
                let own = |f: &&Formula<'_>| {
                    let mut parts = name.split(['(', ')', '[']);
                    f.table == "output" && (f.name == name || parts.any(|part| part == f.name))
                };
                let formula = formulas.iter().find(own);
                formula.map(|f| (f.table, f.number, "expression"))
            }
            Refusal::Duplicate { name } => {
                let formula = formulas.iter().rev().find(|f| f.name == name);
                formula.map(|f| (f.table, f.number, f.named())).or_else(|| {
                    let last = inputs.iter().rposition(|i| &i.name == name);
                    last.map(|number| ("input", number, "name"))
                })
            }
            Refusal::Expression { text, .. } => {
                let formula = formulas.iter().find(|f| f.text == text);
                formula.map(|f| (f.table, f.number, f.key))
            }
            Refusal::Equation { name, .. } => {
                // Several unknowns are named together.
                let first = name.split(", ").next().unwrap_or(name);
                let formula = formulas.iter().find(|f| f.name == first);
                let place = formula.map(|f| (f.table, f.number, f.key));
                place.or_else(|| input(name).map(|number| ("input", number, "unit")))
            }
            Refusal::Unknown { name, .. } => pair(&|c| c.between.contains(name), "between"),
            Refusal::Pair {
                first,
                second,
                coefficient,
                ..
            } => {
                // The last one: of two it is the second that is one too many.
                let found = correlations.iter().rposition(|c| {
                    c.between.contains(first)
                        && c.between.contains(second)
                        && c.coefficient.to_bits() == coefficient.to_bits()
                });
                found.map(|number| ("correlation", number, "coefficient"))
            }
            Refusal::Correlation { first, second, .. } => pair(
                &|c| c.between.contains(first) && c.between.contains(second),
                "coefficient",
            )
            .or_else(|| input(first).map(|number| ("input", number, "observations"))),
            _ => None,
        })
    }

    /// The refusal with line and key.
    pub fn explain(&self, text: &str, refusal: Refusal) -> Refusal {
        match self.0 {
            Some((table, _, key)) => Refusal::File {
                line: self.line(text),
                reason: format!("`{key}` of [[{table}]]: {refusal}"),
            },
            None => refusal,
        }
    }

    /// Line of the key, else of the head of its table, from 1.
    fn line(&self, text: &str) -> Option<usize> {
        let (table, number, key) = self.0?;
        let is_head = |line: &str| {
            let inner = line.trim_start().strip_prefix("[[");
            inner.is_some_and(|rest| rest.split("]]").next().map(str::trim) == Some(table))
        };
        let mut heads = text.lines().enumerate().filter(|(_, line)| is_head(line));
        let (start, _) = heads.nth(number)?;
        let own = text
            .lines()
            .enumerate()
            .skip(start + 1)
            .take_while(|(_, line)| !line.trim_start().starts_with('['));
        let mut keys = own.filter(|(_, line)| {
            let after = line.trim_start().strip_prefix(key);
            after.is_some_and(|rest| rest.trim_start().starts_with(['=', '.']))
        });
        Some(1 + keys.next().map_or(start, |(line, _)| line))
    }
}

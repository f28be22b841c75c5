//! Why a set of inputs, an expression or a budget file is refused, with the names its author gave.

use proofmass_core::Error;
use std::fmt;

/// What cannot be evaluated, by name.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Refusal {
    /// A rule of the mathematics was broken.
    Core(Error),
    /// One input breaks a rule.
    Input {
        /// Name of the input.
        name: String,
        /// Which rule.
        source: Error,
    },
    /// What is said of an input does not suffice, or contradicts itself.
    Incomplete {
        /// Name of the input.
        name: String,
        /// What is needed.
        needed: &'static str,
    },
    /// What is said of an input contradicts itself or can mean nothing.
    Contradiction {
        /// Name of the input.
        name: String,
        /// What is wrong.
        what: &'static str,
    },
    /// An output is no finite number somewhere among the inputs.
    Output {
        /// Name of the output.
        name: String,
        /// What is not finite, and where.
        what: &'static str,
    },
    /// A name that is not defined.
    Unknown {
        /// What kind of thing was looked for: an input, a key, a function.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// The same name twice.
    Duplicate {
        /// The name.
        name: String,
    },
    /// The correlation coefficients contradict each other: no joint distribution has them.
    Correlation {
        /// First of the two groups that weigh most in the contradiction.
        first: String,
        /// Second of them.
        second: String,
        /// The coefficient between them.
        coefficient: f64,
    },
    /// A correlation coefficient that no pair can have.
    Pair {
        /// First of the pair.
        first: String,
        /// Second of the pair.
        second: String,
        /// The coefficient.
        coefficient: f64,
        /// What is wrong with it.
        what: &'static str,
    },
    /// A correlation coefficient that two inputs of these distributions cannot have.
    Unreachable {
        /// First of the pair.
        first: String,
        /// Second of the pair.
        second: String,
        /// The coefficient.
        coefficient: f64,
        /// The least that they can have.
        least: f64,
        /// The largest.
        most: f64,
    },
    /// A name that a formula could not speak of.
    Name {
        /// The name.
        name: String,
        /// What is wrong with it.
        what: &'static str,
    },
    /// An expression cannot be read.
    Expression {
        /// The expression.
        text: String,
        /// Character at which reading stopped, from 1.
        column: usize,
        /// What was expected.
        expected: String,
    },
    /// Equations to solve, a fit or a unit that cannot be used.
    Equation {
        /// What it is called.
        name: String,
        /// What is wrong.
        what: String,
    },
    /// A budget file cannot be read; the text names line and field.
    File {
        /// Line, from 1, when known.
        line: Option<usize>,
        /// What is wrong with which field.
        reason: String,
    },
    /// The caller asked to stop.
    Cancelled,
}

impl From<Error> for Refusal {
    fn from(error: Error) -> Self {
        Self::Core(error)
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Core(error) => error.fmt(f),
            Self::Input { name, source } => write!(f, "input {name}: {source}"),
            Self::Incomplete { name, needed } => write!(f, "input {name}: {needed} is needed"),
            Self::Contradiction { name, what } => write!(f, "input {name}: {what}"),
            Self::Output { name, what } => write!(f, "output {name}: {what}"),
            Self::Equation { name, what } => write!(f, "{name}: {what}"),
            Self::Unknown { what, name } => write!(f, "no {what} is called {name}"),
            Self::Duplicate { name } => write!(f, "{name} is defined twice"),
            Self::Correlation {
                first,
                second,
                coefficient,
            } => write!(
                f,
                "no joint distribution has these correlations: {coefficient} between {first} and {second} \
                 contradicts the others"
            ),
            Self::Pair {
                first,
                second,
                coefficient,
                what,
            } => write!(
                f,
                "the correlation {coefficient} between {first} and {second} {what}"
            ),
            Self::Unreachable {
                first,
                second,
                coefficient,
                least,
                most,
            } => write!(
                f,
                "{first} and {second} cannot have the correlation {coefficient}: their distributions allow {least:.3} to {most:.3}"
            ),
            Self::Name { name, what } => write!(f, "the name {name:?} {what}"),
            Self::Expression {
                text,
                column,
                expected,
            } => {
                write!(
                    f,
                    "expression `{}`, character {column}: {expected}",
                    around(text, *column)
                )
            }
            Self::File {
                line: Some(line),
                reason,
            } => write!(f, "line {line}: {reason}"),
            Self::File { line: None, reason } => f.write_str(reason),
            Self::Cancelled => f.write_str("cancelled"),
        }
    }
}

/// A long text as the part about one of its characters.
fn around(text: &str, column: usize) -> String {
    let (before, after) = (40, 40);
    let start = column.saturating_sub(before + 1);
    let part: String = text.chars().skip(start).take(before + after).collect();
    let cut = text.chars().nth(start + before + after).is_some();
    format!(
        "{}{part}{}",
        if start > 0 { "…" } else { "" },
        if cut { "…" } else { "" }
    )
}

impl std::error::Error for Refusal {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Core(error) | Self::Input { source: error, .. } => Some(error),
            _ => None,
        }
    }
}

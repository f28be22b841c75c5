//! The one error of the mathematics crates: which rule was broken, by which argument, with the numbers.

use core::fmt;

/// What a numerical routine refuses, and why.
///
/// `Copy`, without allocation, shared by every mathematics crate so that `?` composes. Names are the ones a
/// user of the called function sees. Crates that know files add the path, the line and the field.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// An argument has the wrong number of elements.
    Length {
        /// Name of the argument.
        name: &'static str,
        /// Number of elements that was needed.
        expected: usize,
        /// Number of elements that came.
        got: usize,
    },
    /// Fewer data than the method can work with.
    TooFew {
        /// What there is too little of.
        name: &'static str,
        /// The smallest number that would do.
        needed: usize,
        /// The number that came.
        got: usize,
    },
    /// More than is worked on: beyond it time or memory would not suffice.
    TooMany {
        /// What there is too much of.
        name: &'static str,
        /// The largest number that is taken.
        most: usize,
        /// The number that came.
        got: usize,
    },
    /// An argument is NaN or infinite.
    NotFinite {
        /// Name of the argument.
        name: &'static str,
        /// Index of the first offending element, zero for a scalar.
        index: usize,
    },
    /// A sequence that must increase, time above all, does not.
    NotIncreasing {
        /// Name of the sequence.
        name: &'static str,
        /// Index of the first element that is not larger than the one before.
        index: usize,
    },
    /// An argument lies outside the interval in which the method is defined.
    OutOfRange {
        /// Name of the argument.
        name: &'static str,
        /// The value that came.
        value: f64,
        /// Smallest admissible value.
        min: f64,
        /// Largest admissible value.
        max: f64,
    },
    /// A matrix that must be positive (semi-)definite is not.
    NotPositiveDefinite {
        /// Name of the matrix.
        name: &'static str,
        /// First row of the offending element or pair.
        row: usize,
        /// Second row of the offending pair; equal to `row` for a diagonal element.
        column: usize,
        /// The offending value: an eigenvalue, a pivot or a correlation coefficient.
        value: f64,
    },
    /// A matrix that must be invertible is singular to working precision.
    Singular {
        /// Name of the matrix.
        name: &'static str,
        /// Condition number that was found.
        condition: f64,
    },
    /// A signal never changes.
    Constant {
        /// Name of the signal.
        name: &'static str,
        /// The one value it has.
        value: f64,
    },
    /// The data do not determine a parameter.
    Unobservable {
        /// Dotted name of the parameter.
        parameter: &'static str,
        /// Condition number of the scaled problem.
        condition: f64,
    },
    /// The data determine a parameter so badly that the linear theory of its uncertainty fails.
    TooUncertain {
        /// Dotted name of the parameter.
        parameter: &'static str,
        /// Relative standard uncertainty (angles in rad, biases in units of g).
        uncertainty: f64,
        /// Largest value at which a result is given.
        limit: f64,
    },
    /// An iteration ended without meeting its criterion.
    NotConverged {
        /// Name of the iteration.
        name: &'static str,
        /// Number of iterations made.
        iterations: usize,
        /// Last relative step.
        step: f64,
    },
    /// The onlooker of a long calculation stopped it.
    Cancelled {
        /// Where it was.
        stage: &'static str,
    },
}

impl Error {
    /// All [codes](Self::code).
    pub const CODES: [&str; 13] = [
        "length",
        "too-few",
        "too-many",
        "not-finite",
        "not-increasing",
        "out-of-range",
        "not-positive-definite",
        "singular",
        "constant",
        "unobservable",
        "too-uncertain",
        "not-converged",
        "cancelled",
    ];

    /// What kind it is, as a word that stays.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Length { .. } => "length",
            Self::TooFew { .. } => "too-few",
            Self::TooMany { .. } => "too-many",
            Self::NotFinite { .. } => "not-finite",
            Self::NotIncreasing { .. } => "not-increasing",
            Self::OutOfRange { .. } => "out-of-range",
            Self::NotPositiveDefinite { .. } => "not-positive-definite",
            Self::Singular { .. } => "singular",
            Self::Constant { .. } => "constant",
            Self::Unobservable { .. } => "unobservable",
            Self::TooUncertain { .. } => "too-uncertain",
            Self::NotConverged { .. } => "not-converged",
            Self::Cancelled { .. } => "cancelled",
        }
    }

    /// The caller passed an argument that no data could make right (length, range).
    pub fn is_input(&self) -> bool {
        matches!(
            self,
            Self::Length { .. } | Self::OutOfRange { .. } | Self::TooMany { .. }
        )
    }

    /// The data are at fault: too few, not finite, or they do not determine what was asked.
    pub fn is_data(&self) -> bool {
        matches!(
            self,
            Self::TooFew { .. }
                | Self::NotFinite { .. }
                | Self::NotIncreasing { .. }
                | Self::Unobservable { .. }
                | Self::TooUncertain { .. }
                | Self::Constant { .. }
        )
    }

    /// Nothing is wrong: the caller wanted it to stop.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled { .. })
    }

    /// Arithmetic could not go on: a singular or indefinite matrix, an iteration without end.
    pub fn is_numerical(&self) -> bool {
        matches!(
            self,
            Self::NotPositiveDefinite { .. } | Self::Singular { .. } | Self::NotConverged { .. }
        )
    }
}

/// A unit behind a number, with its space.
struct Unit(&'static str);

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            "" => Ok(()),
            "°" => f.write_str("°"),
            unit => write!(f, " {unit}"),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Length {
                name,
                expected,
                got,
            } => {
                write!(f, "{name} has {got} elements, {expected} are needed")
            }
            Self::TooFew { name, needed, got } => {
                write!(
                    f,
                    "too few {name}: {got} given, at least {needed} are needed"
                )
            }
            Self::TooMany { name, most, got } => {
                write!(f, "too many {name}: {got} given, {most} at most")
            }
            Self::NotFinite { name, index } => {
                write!(
                    f,
                    "{name} is not a finite number (element {index}, counted from 0)"
                )
            }
            Self::NotIncreasing { name, index } => {
                write!(
                    f,
                    "{name} does not increase (element {index} is not larger than the one before)"
                )
            }
            Self::OutOfRange {
                name,
                value,
                min,
                max,
            } => {
                // A name with its unit, `corner frequency, Hz`: the unit belongs to the numbers.
                let (name, unit) = match name.rsplit_once(", ") {
                    Some((bare, unit)) if !unit.contains(' ') => (bare, Unit(unit)),
                    _ => (name, Unit("")),
                };
                // The ends of the number range are no bounds a person has set.
                if !value.is_finite() {
                    write!(f, "{name} = {value} is not a finite number")
                } else if max < f64::MAX && min == f64::MIN_POSITIVE {
                    write!(
                        f,
                        "{name} = {value}{unit} is not above 0 and at most {max}{unit}"
                    )
                } else if max < f64::MAX && min > f64::MIN {
                    write!(
                        f,
                        "{name} = {value}{unit} is not between {min}{unit} and {max}{unit}"
                    )
                } else if max < f64::MAX {
                    write!(f, "{name} = {value}{unit} is larger than {max}{unit}")
                } else if min == f64::MIN_POSITIVE {
                    write!(f, "{name} = {value}{unit} is not positive")
                } else if min == 0.0 {
                    write!(f, "{name} = {value}{unit} is negative")
                } else {
                    write!(f, "{name} = {value}{unit} is smaller than {min}{unit}")
                }
            }
            Self::NotPositiveDefinite {
                name,
                row,
                column,
                value,
            } => {
                if row == column {
                    write!(
                        f,
                        "{name} is not positive definite (row {row}: {value:.6e})"
                    )
                } else {
                    write!(
                        f,
                        "{name} is not positive semi-definite (rows {row} and {column}: {value:.6})"
                    )
                }
            }
            Self::Singular { name, condition } => {
                write!(f, "{name} is singular (condition number {condition:.3e})")
            }
            Self::Constant { name, value } => {
                write!(f, "{name} never changes: every sample is {value}")
            }
            Self::Unobservable {
                parameter,
                condition,
            } if condition.is_infinite() => {
                write!(f, "the data do not determine {parameter}")
            }
            Self::Unobservable {
                parameter,
                condition,
            } => write!(
                f,
                "the data do not determine {parameter} (condition number {condition:.3e})"
            ),
            Self::TooUncertain {
                parameter,
                uncertainty,
                limit,
            } => write!(
                f,
                "the data leave {parameter} too uncertain to be a result ({:.1} %, at most {:.1} %)",
                1e2 * uncertainty,
                1e2 * limit
            ),
            Self::NotConverged {
                name,
                iterations,
                step,
            } => write!(
                f,
                "{name} did not converge in {iterations} iterations (last relative step {step:.1e})"
            ),
            Self::Cancelled { stage } => write!(f, "cancelled during {stage}"),
        }
    }
}

impl core::error::Error for Error {}

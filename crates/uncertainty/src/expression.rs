//! Measurement equations as text: `V / I * cos(phi)`.

#[cfg(feature = "model")]
mod columns;
mod function;
mod parser;
mod program;
mod value;

#[cfg(feature = "model")]
pub(crate) use function::Function;
pub(crate) use program::{Op, Program};
pub(crate) use value::{Scalar, Value};

use crate::{Number, Refusal};
use function::FUNCTIONS;
use parser::{Parser, RESERVED};
use std::collections::HashMap;

/// What the names in a formula stand for.
pub(crate) type Scope = HashMap<String, Value>;

/// A formula over named variables, ready to be evaluated on any [`Number`].
///
/// Numbers, names, `+ − * / ^` (also `**`), parentheses, `pi`; the functions sin cos tan asin acos atan sinh cosh tanh
/// exp ln log10 log2 sqrt cbrt abs degrees radians of one argument; atan2(y, x) and hypot(a, b, …); min, max,
/// sum, mean of any number; and `if(a < b, then, else)` with `< <= > >=`. `^` binds tighter than a sign and groups from
/// the right, as on paper. Angles are radians. An integer exponent keeps negative bases allowed.
///
/// Complex quantities are made by complex(re, im), polar(magnitude, angle) or `2j`, and looked at by re, im, abs, arg,
/// conj; vectors by `[a, b, c]`, `v[1]`, sum, mean, min, max, dot, count, and element by element. The value of the whole
/// formula is real here.
///
/// ```
/// use proofmass_uncertainty::Expression;
/// let z = Expression::parse("V / I * cos(phi)", &["V", "I", "phi"])?;
/// let r: f64 = z.evaluate(&[4.999, 19.661e-3, 1.04446]);
/// assert!((r - 127.73).abs() < 0.01); // `[GUM]` H.2
/// let x = Expression::parse("im(polar(V / I, phi))", &["V", "I", "phi"])?;
/// assert!((x.evaluate(&[4.999, 19.661e-3, 1.04446]) - 219.85).abs() < 0.01);
/// assert_eq!(
///     Expression::parse("V / J", &["V", "I"]).unwrap_err().to_string(),
///     "expression `V / J`, character 5: no variable is called J"
/// );
/// # Ok::<(), proofmass_uncertainty::Refusal>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    text: String,
    program: Program,
    result: u32,
}

/// Results of most formulas: they live on the stack.
const SHORT: usize = 24;
/// Bytes of a formula at most: every trial evaluates all of it.
const LONGEST: usize = 20_000;

impl Expression {
    /// Reads a formula; `variables` are looked up by name and later given by position.
    ///
    /// # Errors
    /// [`Refusal::Expression`] with the character at which reading stopped.
    pub fn parse<S: AsRef<str>>(text: &str, variables: &[S]) -> Result<Self, Refusal> {
        let mut program = Program::default();
        let mut scope = Scope::new();
        for (i, name) in variables.iter().enumerate() {
            let place = program.push(Op::Input(i));
            scope
                .entry(name.as_ref().to_owned())
                .or_insert(Value::real(place));
        }
        match compile(text, &scope, &mut program)? {
            Value::One(Scalar::Real(result)) => Ok(Self {
                text: text.into(),
                program,
                result,
            }),
            _ => Err(Refusal::Expression {
                text: text.into(),
                column: 1,
                expected: "one real quantity was expected".into(),
            }),
        }
    }

    /// Whether a formula can speak of a quantity by this name.
    ///
    /// # Errors
    /// [`Refusal::Name`] for a name that does not begin with a letter or an underscore and go on with letters, digits
    /// and underscores, or that means something else in a formula.
    pub fn check_name(name: &str) -> Result<(), Refusal> {
        let mut letters = name.chars();
        let begins = letters
            .next()
            .is_some_and(|c| c.is_alphabetic() || c == '_');
        let what = if !begins || !letters.all(|c| c.is_alphanumeric() || c == '_') {
            "must be a letter or underscore followed by letters, digits and underscores"
        } else if name == "pi" || name == "π" {
            "means a constant in formulas"
        } else if RESERVED.contains(&name) || FUNCTIONS.iter().any(|(known, _)| *known == name) {
            "means a function in formulas"
        } else {
            return Ok(());
        };
        Err(Refusal::Name {
            name: name.to_owned(),
            what,
        })
    }

    /// The text it was read from.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The value, with variables in the order of [`Expression::parse`]; a variable that is not given counts as NaN.
    pub fn evaluate<T: Number>(&self, variables: &[T]) -> T {
        let mut near = [T::from(0.0); SHORT];
        let mut far = Vec::new();
        let length = self.program.ops.len();
        let results: &mut [T] = if length <= SHORT {
            &mut near[..length]
        } else {
            far.resize(length, T::from(0.0));
            &mut far
        };
        self.program
            .run(variables, results, |_, angle| angle, |_, _, _| ());
        results[self.result as usize]
    }
}

/// Reads a formula into a program.
pub(crate) fn compile(text: &str, scope: &Scope, program: &mut Program) -> Result<Value, Refusal> {
    parser(text, scope, program)?.all()
}

/// Reads `left = right`, or an expression that is to be 0, into a program.
#[cfg(feature = "model")]
pub(crate) fn compile_equation(
    text: &str,
    scope: &Scope,
    program: &mut Program,
) -> Result<(Value, Option<Value>), Refusal> {
    parser(text, scope, program)?.equation()
}

fn parser<'a>(
    text: &'a str,
    scope: &'a Scope,
    program: &'a mut Program,
) -> Result<Parser<'a>, Refusal> {
    if text.len() > LONGEST {
        return Err(Refusal::Expression {
            text: text.into(),
            column: 1,
            expected: format!(
                "the formula has {} bytes, {LONGEST} at most; split it with intermediate quantities",
                text.len()
            ),
        });
    }
    Ok(Parser {
        text,
        place: 0,
        scope,
        program,
        nesting: 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        let x: [f64; 2] = [3.0, -2.0];
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("-2^2", -4.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("(1 - 2) - 3", -4.0),
            ("8 / 4 / 2", 1.0),
            ("a ** 2 - b", 11.0),
            ("b^3", -8.0),
            ("--a", 3.0),
            ("1.5e1 + .5", 15.5),
            ("2e", f64::NAN),
            ("atan2(b, -a)", (-2f64).atan2(-3.0)),
            ("sqrt(abs(b) * 2) + exp(0) + ln(1) + log10(100)", 5.0),
            ("a^0.5 · a^0.5", 3.0),
            ("cos(pi)", -1.0),
            ("min(a, b, 7) + max(a, b)", 1.0),
            ("hypot(3, 4, 12)", 13.0),
            ("sum(1, 2, 3) + mean(2, 4)", 9.0),
            ("if(a > b, a, b / 0)", 3.0),
            ("if(a <= b, sqrt(b), if(a < 4, 5, 6))", 5.0),
            ("degrees(pi) - deg(rad(180))", 0.0),
            ("cbrt(-8) + cbrt(27) + log2(8)", 4.0),
            ("b^(1+1)", 4.0),
            ("re((1 + 2j) * (3 - 4j)) + im((1 + 2j) / 2j)", 10.5),
            ("abs(complex(a, 4)) + arg(polar(2, 0.5))", 5.5),
            ("re(exp(ln(1 + 2j))) + im(conj(sqrt(-4 + 0j)))", -1.0),
            ("abs((1 + 1j)^-2 - (1 + 1j)^(-2 + 0j))", 0.0),
            (
                "im(sin(1 + 2j)) - 0.5403023058681398 * 3.626860407847019",
                0.0,
            ),
            (
                "abs(tanh(0.3 + 0.2j) - sinh(0.3 + 0.2j) / cosh(0.3 + 0.2j))",
                0.0,
            ),
            ("sum([1, 2, 3] * a) + mean([a, b]) + count([1, 1])", 20.5),
            ("[4, 5, 6][2]", f64::NAN),
            ("dot([1, 2], [a, b]) + max([1, 2], 0)", 1.0),
            ("im(sum([1j, 2j]))", 3.0),
            ("2 [mm] * a", 6.0),
            ("re(if(a > b, 1j, 2))", 0.0),
        ] {
            match Expression::parse(text, &["a", "b"]) {
                Ok(e) => assert!((e.evaluate(&x) - expected).abs() < 2e-14, "{text}"),
                Err(_) => assert!(expected.is_nan(), "{text}"),
            }
        }
    }

    #[test]
    fn refuses_with_the_place() {
        for (text, column) in [
            ("1 +", 4),
            ("(1", 3),
            ("a b", 3),
            ("f(a)", 1),
            ("1 + x", 5),
            ("atan2(a)", 8),
            ("", 1),
            ("a ^", 4),
            ("µ + a", 1),
            ("1 + 2j", 1),
            ("[1, 2] + [1, 2, 3]", 19),
            ("min(1j, 2)", 10),
            ("a[1]", 3),
        ] {
            match Expression::parse(text, &["a"]) {
                Err(Refusal::Expression { column: c, .. }) => assert_eq!(c, column, "{text}"),
                other => panic!("{text}: {other:?}"),
            }
        }
        assert!(Expression::parse(&"(".repeat(10_000), &["a"]).is_err());
        assert!(Expression::parse(&"2^".repeat(10_000), &["a"]).is_err());
    }
}

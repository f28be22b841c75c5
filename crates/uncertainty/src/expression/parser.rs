//! Recursive descent: sum → product → sign → power → atom.

use super::Scope;
use super::function::{FUNCTIONS, RELATIONS};
use super::program::{Op, Program};
use super::value::{Binary, Complexes, Obstacle, Scalar, Value, each, pairs};
use crate::Refusal;

/// Functions of several arguments, of complex quantities and of vectors.
const SEVERAL: [&str; 15] = [
    "atan2", "hypot", "min", "max", "sum", "mean", "if", "complex", "polar", "re", "im", "conj",
    "arg", "dot", "count",
];
/// Those of them that a quantity cannot be called; the others are functions only before a parenthesis.
pub(super) const RESERVED: [&str; 8] = ["atan2", "hypot", "min", "max", "sum", "mean", "if", "log"];

/// Nesting of parentheses, signs and powers.
const NESTING: usize = 256;
/// Operations of all formulas together: every trial does all of them.
const MOST_OPERATIONS: usize = 500_000;

pub(super) struct Parser<'a> {
    pub(crate) text: &'a str,
    pub(crate) place: usize,
    pub(crate) scope: &'a Scope,
    pub(crate) program: &'a mut Program,
    pub(crate) nesting: usize,
}

impl Parser<'_> {
    /// The whole text.
    pub fn all(&mut self) -> Result<Value, Refusal> {
        let value = self.sum()?;
        self.end()?;
        Ok(value)
    }

    /// Both sides of an equation; the right one is 0 where there is none.
    #[cfg(feature = "model")]
    pub fn equation(&mut self) -> Result<(Value, Option<Value>), Refusal> {
        let left = self.sum()?;
        let right = if self.take("=") {
            Some(self.sum()?)
        } else {
            None
        };
        self.end()?;
        Ok((left, right))
    }

    fn end(&mut self) -> Result<(), Refusal> {
        self.space();
        if self.place < self.text.len() {
            return Err(self.refuse("an operator or the end was expected"));
        }
        Ok(())
    }

    fn rest(&self) -> &str {
        &self.text[self.place..]
    }

    fn space(&mut self) {
        self.place = self.text.len() - self.rest().trim_start().len();
    }

    fn take(&mut self, token: &str) -> bool {
        self.space();
        let found = self.rest().starts_with(token);
        if found {
            self.place += token.len();
        }
        found
    }

    pub fn refuse(&self, expected: impl Into<String>) -> Refusal {
        Refusal::Expression {
            text: self.text.into(),
            column: self.text[..self.place].chars().count() + 1,
            expected: expected.into(),
        }
    }

    fn at_place<T>(&self, result: Result<T, Obstacle>) -> Result<T, Refusal> {
        result.map_err(|what| self.refuse(what))
    }

    fn binary(&mut self, operation: Binary, a: &Value, b: &Value) -> Result<Value, Refusal> {
        let program = &mut *self.program;
        let result = pairs(a, b, |a, b| program.binary(operation, a, b));
        if self.program.ops.len() > MOST_OPERATIONS {
            return Err(self.refuse(format!(
                "the formulas take more than {MOST_OPERATIONS} operations; shorten the vectors"
            )));
        }
        self.at_place(result)
    }

    fn sum(&mut self) -> Result<Value, Refusal> {
        self.nesting += 1;
        if self.nesting > NESTING {
            return Err(self.refuse("parentheses are nested too deeply"));
        }
        let mut value = self.product()?;
        loop {
            let operation = if self.take("+") {
                Binary::Add
            } else if self.take("-") || self.take("−") {
                Binary::Subtract
            } else {
                self.nesting -= 1;
                return Ok(value);
            };
            let other = self.product()?;
            value = self.binary(operation, &value, &other)?;
        }
    }

    fn product(&mut self) -> Result<Value, Refusal> {
        let mut value = self.sign()?;
        loop {
            let operation = if self.take("*") || self.take("·") || self.take("×") {
                Binary::Multiply
            } else if self.take("/") {
                Binary::Divide
            } else {
                return Ok(value);
            };
            let other = self.sign()?;
            value = self.binary(operation, &value, &other)?;
        }
    }

    fn sign(&mut self) -> Result<Value, Refusal> {
        let mut negative = false;
        loop {
            if self.take("-") || self.take("−") {
                negative = !negative;
            } else if !self.take("+") {
                break;
            }
        }
        let value = self.power()?;
        if !negative {
            return Ok(value);
        }
        let program = &mut *self.program;
        let result = each(&value, |a| Ok(program.negate(a)));
        self.at_place(result)
    }

    fn power(&mut self) -> Result<Value, Refusal> {
        self.nesting += 1;
        if self.nesting > NESTING {
            return Err(self.refuse("powers are nested too deeply"));
        }
        let mut value = self.atom()?;
        if self.take("**") || self.take("^") {
            let exponent = self.sign()?;
            value = self.binary(Binary::Power, &value, &exponent)?;
        }
        self.nesting -= 1;
        Ok(value)
    }

    fn atom(&mut self) -> Result<Value, Refusal> {
        self.space();
        let start = self.place;
        match self.rest().chars().next() {
            Some('(') => {
                self.place += 1;
                let value = self.sum()?;
                self.close()?;
                Ok(value)
            }
            Some('[') => {
                self.place += 1;
                let mut members = Vec::new();
                loop {
                    members.extend(self.sum()?.scalars());
                    if !self.take(",") {
                        break;
                    }
                }
                if !self.take("]") {
                    return Err(self.refuse("a comma or a closing bracket was expected"));
                }
                Ok(Value::Many(members))
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => {
                let length = self
                    .rest()
                    .find(|c: char| !(c.is_alphanumeric() || c == '_'))
                    .unwrap_or(self.rest().len());
                let name = self.rest()[..length].to_owned();
                self.place += length;
                if self.take("(") {
                    return self.call(&name, start);
                }
                let value = if let Some(value) = self.scope.get(&name) {
                    value.clone()
                } else if name == "pi" || name == "π" {
                    Value::real(self.program.push(Op::Constant(std::f64::consts::PI)))
                } else {
                    self.place = start;
                    return Err(self.refuse(format!("no variable is called {name}")));
                };
                self.member(value)
            }
            _ => Err(self.refuse("a number, a name or a parenthesis was expected")),
        }
    }

    /// `2.5`, `2.5j` (imaginary), `2.5 [mm]` (with a unit).
    fn number(&mut self) -> Result<Value, Refusal> {
        let length = number_length(self.rest());
        let value = match self.rest()[..length].parse::<f64>() {
            Ok(value) if value.is_finite() => value,
            _ => return Err(self.refuse("a number was expected")),
        };
        self.place += length;
        let mut letters = self.rest().chars();
        if letters.next() == Some('j')
            && !letters
                .next()
                .is_some_and(|c| c.is_alphanumeric() || c == '_')
        {
            self.place += 1;
            let (zero, im) = (
                self.program.push(Op::Constant(0.0)),
                self.program.push(Op::Constant(value)),
            );
            return Ok(Value::One(Scalar::Complex(zero, im)));
        }
        let k = self.program.push(Op::Constant(value));
        if self.take("[") {
            let Some(end) = self.rest().find(']') else {
                return Err(
                    self.refuse("a closing bracket was expected after the unit of a number")
                );
            };
            let unit = self.rest()[..end].trim().to_owned();
            self.place += end + 1;
            self.program.labels.push((k, unit));
        }
        Ok(Value::real(k))
    }

    /// `x[3]`: a member of a vector, counted from 1.
    fn member(&mut self, value: Value) -> Result<Value, Refusal> {
        if !self.take("[") {
            return Ok(value);
        }
        let Value::Many(many) = value else {
            return Err(self.refuse("only a vector has members"));
        };
        self.space();
        let digits = number_length(self.rest());
        let number = self.rest()[..digits].parse::<usize>().ok();
        let Some(one) = number.and_then(|n| many.get(n.checked_sub(1)?)) else {
            return Err(self.refuse(format!(
                "the number of a member was expected, 1 to {}",
                many.len()
            )));
        };
        self.place += digits;
        if !self.take("]") {
            return Err(self.refuse("a closing bracket was expected"));
        }
        Ok(Value::One(*one))
    }

    fn call(&mut self, name: &str, start: usize) -> Result<Value, Refusal> {
        if let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) {
            let value = self.sum()?;
            self.close()?;
            let program = &mut *self.program;
            let result = each(&value, |a| program.call(*function, a));
            return self.at_place(result);
        }
        // Natural in most programs, decadic on paper: a wrong guess is off by a factor of 2.3.
        if name == "log" {
            self.place = start;
            return Err(self.refuse("log is ambiguous; write ln (base e) or log10"));
        }
        if !SEVERAL.contains(&name) {
            self.place = start;
            return Err(self.refuse(format!("no function is called {name}")));
        }
        if name == "if" {
            let value = self.condition()?;
            self.close()?;
            return Ok(value);
        }
        let arguments = self.arguments(name)?;
        let value = self.of_arguments(name, &arguments)?;
        self.close()?;
        Ok(value)
    }

    /// Arguments between commas, as many as the function takes.
    fn arguments(&mut self, name: &str) -> Result<Vec<Value>, Refusal> {
        let (needed, expected) = match name {
            "atan2" => (Some(2), "a comma was expected: atan2(y, x)"),
            "complex" => (Some(2), "a comma was expected: complex(real, imaginary)"),
            "polar" => (Some(2), "a comma was expected: polar(magnitude, angle)"),
            "dot" => (Some(2), "a comma was expected: dot(a, b)"),
            "re" | "im" | "conj" | "arg" | "count" => (Some(1), "one argument was expected"),
            _ => (None, ""),
        };
        let mut arguments = vec![self.sum()?];
        while Some(arguments.len()) != needed && self.take(",") {
            arguments.push(self.sum()?);
        }
        if needed.is_some_and(|n| n != arguments.len()) {
            return Err(self.refuse(expected));
        }
        Ok(arguments)
    }

    fn of_arguments(&mut self, name: &str, arguments: &[Value]) -> Result<Value, Refusal> {
        let members: Vec<Scalar> = arguments.iter().flat_map(Value::scalars).collect();
        let program = &mut *self.program;
        let result = match (name, arguments) {
            ("atan2" | "complex" | "polar", [a, b]) => pairs(a, b, |a, b| {
                let (a, b) = (real(a)?, real(b)?);
                Ok(match name {
                    "atan2" => Scalar::Real(program.angle(a, b)),
                    "complex" => Scalar::Complex(a, b),
                    _ => program.polar(a, b),
                })
            }),
            ("re" | "im" | "conj" | "arg", [z]) => each(z, |z| {
                if name == "arg" {
                    return Ok(Scalar::Real(program.argument(z)));
                }
                let (re, im) = program.parts(z);
                Ok(match name {
                    "re" => Scalar::Real(re),
                    "im" => Scalar::Real(im),
                    _ => Scalar::Complex(re, program.push(Op::Negate(im))),
                })
            }),
            ("count", [v]) => Ok(Value::real(
                program.push(Op::Constant(v.scalars().len() as f64)),
            )),
            ("dot", [a, b]) => pairs(a, b, |a, b| program.binary(Binary::Multiply, a, b))
                .and_then(|products| total(program, &products.scalars())),
            ("hypot", _) if members.len() < 2 => {
                Err("two arguments at least: hypot(a, b)".to_owned())
            }
            ("hypot" | "min" | "max", _) => {
                let reals: Result<Vec<u32>, Obstacle> = members.iter().map(|m| real(*m)).collect();
                reals.map(|reals| {
                    let mut found = reals[0];
                    for &other in &reals[1..] {
                        found = program.push(match name {
                            "hypot" => Op::Hypotenuse(found, other),
                            "min" => Op::Minimum(found, other),
                            _ => Op::Maximum(found, other),
                        });
                    }
                    Value::real(found)
                })
            }
            ("sum", _) => total(program, &members),
            _ => total(program, &members).and_then(|sum| {
                let count = Scalar::Real(program.push(Op::Constant(members.len() as f64)));
                each(&sum, |sum| program.binary(Binary::Divide, sum, count))
            }),
        };
        self.at_place(result)
    }

    /// `a < b, then, else`
    fn condition(&mut self) -> Result<Value, Refusal> {
        let expected = "a condition was expected: if(a < b, then, else)";
        let left = self.sum()?;
        let Some((_, relation)) = RELATIONS.iter().find(|(sign, _)| self.take(sign)) else {
            return Err(self.refuse(expected));
        };
        let right = self.sum()?;
        let mut branches = Vec::new();
        for _ in 0..2 {
            if !self.take(",") {
                return Err(self.refuse(expected));
            }
            branches.push(self.sum()?);
        }
        let program = &mut *self.program;
        let holds = pairs(&left, &right, |a, b| {
            Ok(Scalar::Real(program.push(Op::Compare(
                *relation,
                real(a)?,
                real(b)?,
            ))))
        });
        let holds = match holds {
            Ok(Value::One(Scalar::Real(holds))) => holds,
            Ok(_) => return Err(self.refuse("a condition compares two single quantities")),
            Err(what) => return Err(self.refuse(what)),
        };
        let result = pairs(&branches[0], &branches[1], |a, b| {
            Ok(match (a, b) {
                (Scalar::Real(a), Scalar::Real(b)) => {
                    Scalar::Real(program.push(Op::Select(holds, a, b)))
                }
                (a, b) => {
                    let ((ar, ai), (br, bi)) = (program.parts(a), program.parts(b));
                    Scalar::Complex(
                        program.push(Op::Select(holds, ar, br)),
                        program.push(Op::Select(holds, ai, bi)),
                    )
                }
            })
        });
        self.at_place(result)
    }

    fn close(&mut self) -> Result<(), Refusal> {
        if self.take(")") {
            Ok(())
        } else {
            Err(self.refuse("a closing parenthesis was expected"))
        }
    }
}

fn total(program: &mut Program, members: &[Scalar]) -> Result<Value, Obstacle> {
    let mut sum = members[0];
    for other in &members[1..] {
        sum = program.binary(Binary::Add, sum, *other)?;
    }
    Ok(Value::One(sum))
}

fn real(a: Scalar) -> Result<u32, Obstacle> {
    match a {
        Scalar::Real(a) => Ok(a),
        Scalar::Complex(..) => {
            Err("a complex quantity cannot stand here; take re, im, abs or arg of it".to_owned())
        }
    }
}

/// Digits, point, and an exponent only where digits follow the e.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let run = |mut i: usize| {
        while bytes.get(i).is_some_and(u8::is_ascii_digit) {
            i += 1;
        }
        i
    };
    let mut end = run(0);
    if bytes.get(end) == Some(&b'.') {
        end = run(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let digits = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let stop = run(digits);
        if stop > digits {
            end = stop;
        }
    }
    end
}

//! Measurement equations as text: `V / I * cos(phi)`.

use crate::{Number, Refusal};

/// A formula over named variables, ready to be evaluated on any [`Number`].
///
/// Numbers, names, `+ − * / ^` (also `**`), parentheses, `pi`; the functions sin cos tan asin acos atan sinh cosh tanh
/// exp ln log10 log2 sqrt cbrt abs degrees radians of one argument; atan2(y, x) and hypot(a, b, …); min, max,
/// sum, mean of any number; and `if(a < b, then, else)` with `< <= > >=`. `^` binds tighter than a sign and groups from
/// the right, as on paper. Angles are radians. An integer exponent keeps negative bases allowed.
///
/// ```
/// use proofmass_uncertainty::Expression;
/// let z = Expression::parse("V / I * cos(phi)", &["V", "I", "phi"])?;
/// let r: f64 = z.evaluate(&[4.999, 19.661e-3, 1.04446]);
/// assert!((r - 127.73).abs() < 0.01); // `[GUM]` H.2
/// assert_eq!(
///     Expression::parse("V / J", &["V", "I"]).unwrap_err().to_string(),
///     "expression `V / J`, character 5: no variable is called J"
/// );
/// # Ok::<(), proofmass_uncertainty::Refusal>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    text: String,
    code: Vec<Step>,
    /// Operands that wait at once.
    depth: usize,
}

/// One step of the formula in reverse Polish order.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Constant(f64),
    Variable(usize),
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    IntegerPower(i32),
    Call(Function),
    /// Number of this angle in the formula.
    Atan2(usize),
    Minimum,
    Maximum,
    /// √(a² + b²)
    Hypotenuse,
    /// Which relation: 1 where it holds, else 0.
    Compare(Relation),
    /// Of condition, then, else.
    Select,
}

impl Step {
    /// Operands it takes.
    fn operands(self) -> usize {
        match self {
            Self::Constant(_) | Self::Variable(_) => 0,
            Self::Negate | Self::IntegerPower(_) | Self::Call(_) => 1,
            Self::Select => 3,
            _ => 2,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Relation {
    Less,
    LessOrEqual,
    More,
    MoreOrEqual,
}

const RELATIONS: [(&str, Relation); 6] = [
    ("<=", Relation::LessOrEqual),
    ("≤", Relation::LessOrEqual),
    (">=", Relation::MoreOrEqual),
    ("≥", Relation::MoreOrEqual),
    ("<", Relation::Less),
    (">", Relation::More),
];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Log10,
    Log2,
    Sqrt,
    Cbrt,
    Abs,
    Degrees,
    Radians,
}

const FUNCTIONS: [(&str, Function); 20] = [
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("asin", Function::Asin),
    ("acos", Function::Acos),
    ("atan", Function::Atan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
    ("exp", Function::Exp),
    ("ln", Function::Ln),
    ("log10", Function::Log10),
    ("log2", Function::Log2),
    ("sqrt", Function::Sqrt),
    ("cbrt", Function::Cbrt),
    ("abs", Function::Abs),
    ("degrees", Function::Degrees),
    ("deg", Function::Degrees),
    ("radians", Function::Radians),
    ("rad", Function::Radians),
];

/// Functions of several arguments.
const SEVERAL: [&str; 7] = ["atan2", "hypot", "min", "max", "sum", "mean", "if"];

/// Operands that may wait at once; a formula on paper stays far below.
const DEPTH: usize = 128;
/// Operands of most formulas: a smaller stack to clear in each trial.
const SHALLOW: usize = 12;
/// Nesting of parentheses, signs and powers.
const NESTING: usize = 256;
/// Bytes of a formula at most: every trial evaluates all of it.
const LONGEST: usize = 20_000;

impl Expression {
    /// Reads a formula; `variables` are looked up by name and later given by position.
    ///
    /// # Errors
    /// [`Refusal::Expression`] with the character at which reading stopped.
    pub fn parse<S: AsRef<str>>(text: &str, variables: &[S]) -> Result<Self, Refusal> {
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
        let mut parser = Parser {
            text,
            place: 0,
            variables: variables.iter().map(AsRef::as_ref).collect(),
            code: Vec::new(),
            nesting: 0,
            angles: 0,
        };
        parser.sum()?;
        parser.space();
        if parser.place < text.len() {
            return Err(parser.refuse("an operator or the end was expected"));
        }
        let code = parser.code;
        let (mut depth, mut deepest) = (0usize, 0);
        for step in &code {
            depth = depth + 1 - step.operands();
            deepest = deepest.max(depth);
        }
        if deepest > DEPTH {
            return Err(Refusal::Expression {
                text: text.into(),
                column: 1,
                expected: "the formula is nested too deeply; split it with intermediate quantities"
                    .into(),
            });
        }
        Ok(Self {
            text: text.into(),
            code,
            depth: deepest,
        })
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
        } else if name == "log"
            || SEVERAL.contains(&name)
            || FUNCTIONS.iter().any(|(known, _)| *known == name)
        {
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
        self.evaluate_with(variables, |_, angle| angle)
    }

    /// The value, where `angle` may replace the result of each `atan2`, by its number in the formula.
    pub(crate) fn evaluate_with<T: Number>(
        &self,
        variables: &[T],
        angle: impl FnMut(usize, T) -> T,
    ) -> T {
        if self.depth <= SHALLOW {
            self.run::<T, SHALLOW>(variables, angle)
        } else {
            self.run::<T, DEPTH>(variables, angle)
        }
    }

    fn run<T: Number, const N: usize>(
        &self,
        variables: &[T],
        mut angle: impl FnMut(usize, T) -> T,
    ) -> T {
        let mut stack = [T::from(0.0); N];
        let mut top = 0;
        for step in &self.code {
            match *step {
                Step::Constant(c) => {
                    stack[top] = T::from(c);
                    top += 1;
                }
                Step::Variable(i) => {
                    stack[top] = variables.get(i).copied().unwrap_or(T::from(f64::NAN));
                    top += 1;
                }
                Step::Negate => stack[top - 1] = -stack[top - 1],
                Step::IntegerPower(n) => stack[top - 1] = stack[top - 1].powi(n),
                Step::Call(function) => stack[top - 1] = function.apply(stack[top - 1]),
                Step::Select => {
                    top -= 2;
                    let holds = stack[top - 1].value() != 0.0;
                    stack[top - 1] = stack[if holds { top } else { top + 1 }];
                }
                binary => {
                    let (a, b) = (stack[top - 2], stack[top - 1]);
                    top -= 1;
                    stack[top - 1] = match binary {
                        Step::Add => a + b,
                        Step::Subtract => a - b,
                        Step::Multiply => a * b,
                        Step::Divide => a / b,
                        Step::Power => a.powf(b),
                        Step::Minimum if b.value() < a.value() || b.value().is_nan() => b,
                        Step::Maximum if b.value() > a.value() || b.value().is_nan() => b,
                        Step::Minimum | Step::Maximum => a,
                        Step::Hypotenuse => hypotenuse(a, b),
                        Step::Compare(relation) => {
                            T::from(f64::from(u8::from(relation.holds(a.value(), b.value()))))
                        }
                        Step::Atan2(number) => angle(number, a.atan2(b)),
                        _ => T::from(f64::NAN),
                    };
                }
            }
        }
        stack[0]
    }
}

/// √(a² + b²) without overflow; at the origin its derivative is that of |a|.
fn hypotenuse<T: Number>(a: T, b: T) -> T {
    let (large, small) = if a.value().abs() >= b.value().abs() {
        (a.abs(), b)
    } else {
        (b.abs(), a)
    };
    if large.value() == 0.0 {
        return large;
    }
    let ratio = small / large;
    large * (T::from(1.0) + ratio * ratio).sqrt()
}

impl Relation {
    fn holds(self, a: f64, b: f64) -> bool {
        match self {
            Self::Less => a < b,
            Self::LessOrEqual => a <= b,
            Self::More => a > b,
            Self::MoreOrEqual => a >= b,
        }
    }
}

impl Function {
    fn apply<T: Number>(self, x: T) -> T {
        match self {
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => x.tanh(),
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Log10 => x.log10(),
            Self::Log2 => x.ln() / T::from(std::f64::consts::LN_2),
            Self::Sqrt => x.sqrt(),
            Self::Cbrt if x.value() < 0.0 => -(-x).powf(T::from(1.0 / 3.0)),
            Self::Cbrt => x.powf(T::from(1.0 / 3.0)),
            Self::Abs => x.abs(),
            Self::Degrees => x * T::from(180.0 / std::f64::consts::PI),
            Self::Radians => x * T::from(std::f64::consts::PI / 180.0),
        }
    }
}

/// What one step does to units.
#[cfg(feature = "model")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operation {
    /// A number in the text.
    Number(f64),
    /// A variable by its position.
    Variable(usize),
    /// Of two: they must be alike.
    Sum,
    /// The unit stays.
    Keep,
    /// Of two.
    Product,
    /// Of two.
    Quotient,
    /// Base and exponent.
    Power,
    /// By a whole number.
    IntegerPower(i32),
    /// Square root.
    Root,
    /// Sine, cosine, tangent.
    Trigonometric,
    /// A function of a pure number.
    OfNumber,
    /// A function whose unit the rules do not follow.
    Other,
    /// Angle of two that are alike.
    Angle,
    /// From radians.
    ToDegrees,
    /// From degrees.
    ToRadians,
    /// Of two that are alike.
    Comparison,
    /// Condition, and two that are alike.
    Choice,
}

#[cfg(feature = "model")]
impl Expression {
    /// Its steps in reverse Polish order, as far as units are concerned.
    pub(crate) fn operations(&self) -> impl Iterator<Item = Operation> + '_ {
        self.code.iter().map(|step| match *step {
            Step::Constant(c) => Operation::Number(c),
            Step::Variable(i) => Operation::Variable(i),
            Step::Negate => Operation::Keep,
            Step::Add | Step::Subtract | Step::Minimum | Step::Maximum | Step::Hypotenuse => {
                Operation::Sum
            }
            Step::Multiply => Operation::Product,
            Step::Divide => Operation::Quotient,
            Step::Power => Operation::Power,
            Step::IntegerPower(n) => Operation::IntegerPower(n),
            Step::Atan2(_) => Operation::Angle,
            Step::Compare(_) => Operation::Comparison,
            Step::Select => Operation::Choice,
            Step::Call(function) => match function {
                Function::Sin | Function::Cos | Function::Tan => Operation::Trigonometric,
                Function::Sqrt => Operation::Root,
                Function::Abs => Operation::Keep,
                Function::Cbrt => Operation::Other,
                Function::Degrees => Operation::ToDegrees,
                Function::Radians => Operation::ToRadians,
                _ => Operation::OfNumber,
            },
        })
    }
}

/// Recursive descent: sum → product → sign → power → atom.
struct Parser<'a> {
    text: &'a str,
    place: usize,
    variables: Vec<&'a str>,
    code: Vec<Step>,
    nesting: usize,
    angles: usize,
}

impl Parser<'_> {
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

    fn refuse(&self, expected: impl Into<String>) -> Refusal {
        Refusal::Expression {
            text: self.text.into(),
            column: self.text[..self.place].chars().count() + 1,
            expected: expected.into(),
        }
    }

    fn sum(&mut self) -> Result<(), Refusal> {
        self.nesting += 1;
        if self.nesting > NESTING {
            return Err(self.refuse("parentheses are nested too deeply"));
        }
        self.product()?;
        loop {
            if self.take("+") {
                self.product()?;
                self.code.push(Step::Add);
            } else if self.take("-") || self.take("−") {
                self.product()?;
                self.code.push(Step::Subtract);
            } else {
                self.nesting -= 1;
                return Ok(());
            }
        }
    }

    fn product(&mut self) -> Result<(), Refusal> {
        self.sign()?;
        loop {
            if self.take("*") || self.take("·") || self.take("×") {
                self.sign()?;
                self.code.push(Step::Multiply);
            } else if self.take("/") {
                self.sign()?;
                self.code.push(Step::Divide);
            } else {
                return Ok(());
            }
        }
    }

    fn sign(&mut self) -> Result<(), Refusal> {
        let mut negative = false;
        loop {
            if self.take("-") || self.take("−") {
                negative = !negative;
            } else if !self.take("+") {
                break;
            }
        }
        self.power()?;
        if negative {
            self.code.push(Step::Negate);
        }
        Ok(())
    }

    fn power(&mut self) -> Result<(), Refusal> {
        self.nesting += 1;
        if self.nesting > NESTING {
            return Err(self.refuse("powers are nested too deeply"));
        }
        self.atom()?;
        if self.take("**") || self.take("^") {
            let start = self.code.len();
            self.sign()?;
            match self.code[start..] {
                [Step::Constant(n)] if is_small_integer(n) => {
                    self.code.truncate(start);
                    self.code.push(Step::IntegerPower(n as i32));
                }
                [Step::Constant(n), Step::Negate] if is_small_integer(n) => {
                    self.code.truncate(start);
                    self.code.push(Step::IntegerPower(-(n as i32)));
                }
                _ => self.code.push(Step::Power),
            }
        }
        self.nesting -= 1;
        Ok(())
    }

    fn atom(&mut self) -> Result<(), Refusal> {
        self.space();
        let start = self.place;
        match self.rest().chars().next() {
            Some('(') => {
                self.place += 1;
                self.sum()?;
                self.close()
            }
            Some(c) if c.is_ascii_digit() || c == '.' => {
                let length = number_length(self.rest());
                match self.rest()[..length].parse::<f64>() {
                    Ok(value) if value.is_finite() => {
                        self.place += length;
                        self.code.push(Step::Constant(value));
                        Ok(())
                    }
                    _ => Err(self.refuse("a number was expected")),
                }
            }
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
                if let Some(i) = self.variables.iter().position(|v| *v == name) {
                    self.code.push(Step::Variable(i));
                } else if name == "pi" || name == "π" {
                    self.code.push(Step::Constant(std::f64::consts::PI));
                } else {
                    self.place = start;
                    return Err(self.refuse(format!("no variable is called {name}")));
                }
                Ok(())
            }
            _ => Err(self.refuse("a number, a name or a parenthesis was expected")),
        }
    }

    fn call(&mut self, name: &str, start: usize) -> Result<(), Refusal> {
        if let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) {
            self.sum()?;
            self.close()?;
            self.code.push(Step::Call(*function));
            return Ok(());
        }
        match name {
            "atan2" => {
                self.arguments("a comma was expected: atan2(y, x)", 2..=2, None)?;
                self.code.push(Step::Atan2(self.angles));
                self.angles += 1;
            }
            "hypot" => {
                self.arguments(
                    "two arguments at least: hypot(a, b)",
                    2..=99,
                    Some(Step::Hypotenuse),
                )?;
            }
            "min" => {
                self.arguments(
                    "a comma was expected: min(a, b)",
                    1..=9999,
                    Some(Step::Minimum),
                )?;
            }
            "max" => {
                self.arguments(
                    "a comma was expected: max(a, b)",
                    1..=9999,
                    Some(Step::Maximum),
                )?;
            }
            "sum" => {
                self.arguments("a comma was expected: sum(a, b)", 1..=9999, Some(Step::Add))?;
            }
            "mean" => {
                let n = self.arguments(
                    "a comma was expected: mean(a, b)",
                    1..=9999,
                    Some(Step::Add),
                )?;
                self.code.push(Step::Constant(n as f64));
                self.code.push(Step::Divide);
            }
            "if" => self.condition()?,
            // Natural in most programs, decadic on paper: a wrong guess is off by a factor of 2.3.
            "log" => {
                self.place = start;
                return Err(self.refuse("log is ambiguous; write ln (base e) or log10"));
            }
            _ => {
                self.place = start;
                return Err(self.refuse(format!("no function is called {name}")));
            }
        }
        self.close()
    }

    /// Arguments between commas, joined one by one by a step; how many there were.
    fn arguments(
        &mut self,
        expected: &str,
        allowed: std::ops::RangeInclusive<usize>,
        joined_by: Option<Step>,
    ) -> Result<usize, Refusal> {
        self.sum()?;
        let mut count = 1;
        while count < *allowed.end() && self.take(",") {
            self.sum()?;
            self.code.extend(joined_by);
            count += 1;
        }
        if allowed.contains(&count) {
            Ok(count)
        } else {
            Err(self.refuse(expected))
        }
    }

    /// `a < b, then, else`
    fn condition(&mut self) -> Result<(), Refusal> {
        let expected = "a condition was expected: if(a < b, then, else)";
        self.sum()?;
        let Some((_, relation)) = RELATIONS.iter().find(|(sign, _)| self.take(sign)) else {
            return Err(self.refuse(expected));
        };
        self.sum()?;
        self.code.push(Step::Compare(*relation));
        for _ in 0..2 {
            if !self.take(",") {
                return Err(self.refuse(expected));
            }
            self.sum()?;
        }
        self.code.push(Step::Select);
        Ok(())
    }

    fn close(&mut self) -> Result<(), Refusal> {
        if self.take(")") {
            Ok(())
        } else {
            Err(self.refuse("a closing parenthesis was expected"))
        }
    }
}

fn is_small_integer(x: f64) -> bool {
    x.fract() == 0.0 && x.abs() <= 64.0
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
        ] {
            match Expression::parse(text, &["a", "b"]) {
                Ok(e) => assert!((e.evaluate(&x) - expected).abs() < 1e-14, "{text}"),
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

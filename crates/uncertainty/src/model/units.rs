//! Do the units of a model fit together? What an expression does to the dimensions of its inputs.

mod temperature;

use super::UncertaintyModel;
use super::compile::Compiled;
use super::equations::Block;
use crate::dimension::{CELSIUS, Dimension};
use crate::expression::{Function, Op};
use crate::findings;
use crate::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// What is known of the unit of a value on the way through a formula.
#[derive(Clone, Copy, Debug)]
enum Unit {
    /// A number written in the formula: it takes whatever unit the formula needs.
    Number(f64),
    /// A dimension.
    Known(Dimension),
    /// A plane angle in degrees, with what it has been multiplied by.
    Degrees(f64),
    /// A label that is no unit, or something the rules do not follow.
    Unknown,
}

/// Below this factor an angle in degrees has been converted: π/180 is 0.017.
const CONVERTED: f64 = 0.2;

/// Whether the units of a model are looked at or also converted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum UnitRule {
    /// Formulas compute with the numbers as they are stated; what does not fit is a finding.
    #[default]
    AsWritten,
    /// Formulas compute in the coherent units of the SI, angles in radians: inputs and numbers with a unit are brought to
    /// them, outputs to their own unit. A temperature in °C keeps its zero.
    Convert,
}

impl UncertaintyModel {
    /// Findings about units: degrees in a trigonometric function, sums of different kinds or sizes, dimensions where a
    /// number is needed, an output whose formula has another dimension, a label that is no unit.
    ///
    /// A label that is no unit excludes what depends on it from the check.
    pub fn doubtful_units(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        let Ok(compiled) = self.compiled() else {
            return findings;
        };
        let convert = self.units == UnitRule::Convert;
        let mut labels: Vec<String> = Vec::new();
        let mut stated = |text: &str, name: &str| {
            let unit = unit_of(text, name, &mut labels);
            if convert { coherent(unit) } else { unit }
        };
        let mut variables: Vec<Unit> = Vec::new();
        let mut names: Vec<String> = Vec::new();
        let mut temperatures: Vec<&str> = Vec::new();
        for input in &self.input {
            let unit = stated(&input.unit, &input.name);
            if matches!(unit, Unit::Degrees(_)) {
                names.push(input.name.clone());
            }
            let members = input.length().unwrap_or(1);
            variables.extend(std::iter::repeat_n(unit, members));
            temperatures.extend(std::iter::repeat_n(input.name.as_str(), members));
        }
        let ops = &compiled.program.ops;
        let mut units: Vec<Unit> = Vec::with_capacity(ops.len());
        let mut walk = Walk {
            name: "",
            degrees: names,
            inputs: &temperatures,
            findings: &mut findings,
        };
        let first = compiled.formulas.first().map_or(ops.len(), |f| f.from);
        for (k, op) in ops.iter().enumerate().take(first) {
            let of_earlier = compiled
                .stated
                .iter()
                .find(|(place, _)| *place as usize == k);
            units.push(match op {
                _ if of_earlier.is_some() => of_earlier.map_or(Unit::Unknown, |(_, label)| {
                    stated(label, "an earlier result")
                }),
                Op::Input(i) => variables.get(*i).copied().unwrap_or(Unit::Unknown),
                // The factor to the coherent unit, which the variable has already.
                Op::Multiply(a, _) => units[*a as usize],
                _ => Unit::Unknown,
            });
        }
        let mut formulas = compiled.formulas.iter().peekable();
        while let Some(formula) = formulas.next() {
            walk.name = &formula.name;
            // Between two formulas stand the results of a block and the factors of outputs.
            let to = formulas.peek().map_or(ops.len(), |next| next.from);
            for k in units.len()..to {
                let unit = walk.step(&compiled, k, &units, &variables, &mut stated);
                units.push(unit);
            }
            if let Some(label) = &formula.unit {
                let said = stated(label, &formula.name);
                for &k in &formula.results {
                    walk.compare(units[k as usize], said, label);
                    walk.compare_zeros(&compiled.program.ops, k, &units, said, label);
                    if matches!(said, Unit::Known(_) | Unit::Degrees(_)) {
                        units[k as usize] = temperature::kept(units[k as usize], said);
                    }
                }
            }
        }
        if convert {
            findings.extend(self.two_zeros(&compiled));
        }
        if !labels.is_empty() {
            findings.push(findings::unknown_unit(&labels.join(", ")));
        }
        findings
    }
}

impl UncertaintyModel {
    /// Temperatures on two scales: °C is converted as a difference, so that its zero stays where it is.
    fn two_zeros(&self, compiled: &Compiled) -> Option<Finding> {
        let inputs = self.input.iter().map(|i| i.unit.as_str());
        let labels = inputs
            .chain(self.output.iter().map(|o| o.unit.as_str()))
            .chain(
                compiled
                    .program
                    .labels
                    .iter()
                    .map(|(_, label)| label.as_str()),
            )
            .chain(compiled.stated.iter().map(|(_, label)| label.as_str()));
        let labels: Vec<&str> = labels.map(str::trim).collect();
        let celsius = labels.iter().any(|l| CELSIUS.contains(l));
        (celsius && labels.contains(&"K")).then(findings::two_zeros_of_temperature)
    }
}

/// The unit that the formulas compute in after conversion.
fn coherent(unit: Unit) -> Unit {
    match unit {
        Unit::Known(dimension) => Unit::Known(dimension.coherent()),
        Unit::Degrees(_) => Unit::Known(Dimension::one()),
        other => other,
    }
}

fn unit_of(text: &str, name: &str, labels: &mut Vec<String>) -> Unit {
    if ["°", "deg", "degree", "degrees"].contains(&text.trim()) {
        return Unit::Degrees(1.0);
    }
    match Dimension::parse(text) {
        Some(dimension) => Unit::Known(dimension),
        None => {
            labels.push(format!("{text:?} of {name}"));
            Unit::Unknown
        }
    }
}

struct Walk<'a> {
    name: &'a str,
    /// Inputs that are angles in degrees.
    degrees: Vec<String>,
    /// Names of the inputs.
    inputs: &'a [&'a str],
    findings: &'a mut Vec<Finding>,
}

impl Walk<'_> {
    fn say(&mut self, finding: Finding) {
        let same = |f: &Finding| f.code() == finding.code() && f.what() == finding.what();
        if !self.findings.iter().any(same) {
            self.findings.push(finding);
        }
    }

    /// The formula contradicts units.
    fn contradict(&mut self, contradiction: &str, remedy: &str) {
        self.say(findings::units_do_not_fit(self.name, contradiction, remedy));
    }

    /// The unit of one result, from those before it.
    fn step(
        &mut self,
        compiled: &Compiled,
        k: usize,
        units: &[Unit],
        variables: &[Unit],
        stated: &mut dyn FnMut(&str, &str) -> Unit,
    ) -> Unit {
        let of = |k: u32| units[k as usize];
        let ops = &compiled.program.ops;
        match ops[k] {
            Op::Constant(x) => {
                let labels = &compiled.program.labels;
                match labels.iter().find(|(place, _)| *place as usize == k) {
                    Some((_, label)) => stated(label, self.name),
                    None => Unit::Number(x),
                }
            }
            Op::Input(i) => variables.get(i).copied().unwrap_or(Unit::Unknown),
            Op::Negate(a) => of(a),
            Op::Add(a, b)
            | Op::Subtract(a, b)
            | Op::Minimum(a, b)
            | Op::Maximum(a, b)
            | Op::Hypotenuse(a, b) => {
                let sum = self.alike(of(a), of(b));
                temperature::of_sum(ops[k], sum, of(a), of(b))
            }
            Op::Multiply(a, b) => {
                let found = product(of(a), of(b), 1);
                self.zeros_of_product(ops, k, units, found)
            }
            Op::Divide(a, b) => {
                let found = product(of(a), of(b), -1);
                self.zeros_of_product(ops, k, units, found)
            }
            Op::Power(a, b) => {
                self.zeros_of_power(ops, a, units, of(b));
                power(of(a), of(b))
            }
            Op::IntegerPower(a, n) => {
                let exponent = Unit::Number(f64::from(n));
                self.zeros_of_power(ops, a, units, exponent);
                power(of(a), exponent)
            }
            Op::Call(function, a) => {
                if function == Function::Sqrt {
                    self.zeros_of_power(ops, a, units, Unit::Number(0.5));
                }
                self.call(function, of(a))
            }
            Op::Atan2(a, b, _) => {
                self.alike(of(a), of(b));
                Unit::Known(Dimension::one())
            }
            Op::Compare(_, a, b) => {
                self.alike(of(a), of(b));
                Unit::Number(1.0)
            }
            Op::Select(_, a, b) => self.alike(of(a), of(b)),
            Op::Block(number) => parameter(compiled, number, 0, units),
            Op::Further => {
                let ops = &compiled.program.ops[..k];
                let back = ops.iter().rposition(|op| matches!(op, Op::Block(_)));
                match back.map(|place| (place, ops[place])) {
                    Some((place, Op::Block(number))) => {
                        parameter(compiled, number, (k - place) as i8, units)
                    }
                    _ => Unit::Unknown,
                }
            }
        }
    }

    fn call(&mut self, function: Function, x: Unit) -> Unit {
        match function {
            Function::Sin | Function::Cos | Function::Tan => self.angle(x),
            Function::Sqrt => power(x, Unit::Number(0.5)),
            Function::Abs => x,
            Function::Cbrt => Unit::Unknown,
            Function::Degrees => Unit::Degrees(1.0),
            Function::Radians => Unit::Known(Dimension::one()),
            _ => self.number(x),
        }
    }

    /// The unit of a sum.
    fn alike(&mut self, a: Unit, b: Unit) -> Unit {
        match (a, b) {
            (Unit::Unknown, _) | (_, Unit::Unknown) => Unit::Unknown,
            (Unit::Number(x), Unit::Number(y)) => Unit::Number(x + y),
            (Unit::Number(_), other) | (other, Unit::Number(_)) => other,
            (Unit::Degrees(x), Unit::Degrees(_)) => Unit::Degrees(x),
            (Unit::Degrees(x), Unit::Known(d)) | (Unit::Known(d), Unit::Degrees(x)) => {
                // A converted angle is a number like any other.
                if x.abs() >= CONVERTED || !d.is_number() {
                    self.contradict(
                        "adds an angle in degrees to something else",
                        "convert it with radians(…)",
                    );
                }
                Unit::Unknown
            }
            (Unit::Known(x), Unit::Known(y)) => {
                let sizes = x.factor.zip(y.factor);
                if !x.is_like(&y) {
                    self.contradict(
                        "adds or compares quantities of different dimensions",
                        "check the formula and the units of its inputs",
                    );
                    return Unit::Unknown;
                }
                if sizes.is_some_and(|(f, g)| (f / g - 1.0).abs() > 1e-9) {
                    self.contradict("adds or compares quantities in units of different size", "keep to one unit, or let the units be converted: units = \"convert\" at the head of the file");
                    return Unit::Unknown;
                }
                Unit::Known(if x.factor.is_some() { x } else { y })
            }
        }
    }

    fn angle(&mut self, angle: Unit) -> Unit {
        match angle {
            Unit::Degrees(factor) if factor.abs() >= CONVERTED => {
                self.say(findings::degrees_in_trigonometry(
                    self.name,
                    &self.degrees.join(", "),
                ));
                Unit::Known(Dimension::one())
            }
            Unit::Degrees(_) => Unit::Known(Dimension::one()),
            other => self.number(other),
        }
    }

    /// A function that only a pure number has.
    fn number(&mut self, x: Unit) -> Unit {
        if let Unit::Known(dimension) = x
            && !dimension.is_number()
        {
            self.say(
                findings::units_do_not_fit(self.name, "takes a function of a quantity with a dimension that is defined for pure numbers", "divide by a unit or a reference value first").at(Severity::Warning),
            );
        }
        Unit::Known(Dimension::one())
    }

    /// What the formula gives against what the output states.
    fn compare(&mut self, found: Unit, stated: Unit, label: &str) {
        let (what, advice) = match (found, stated) {
            (Unit::Known(x), Unit::Known(y)) if !x.is_like(&y) => (
                format!("has another dimension than its unit {label}"),
                "check formula and units",
            ),
            (Unit::Known(x), Unit::Known(y))
                if x.factor
                    .zip(y.factor)
                    .is_some_and(|(f, g)| (f / g - 1.0).abs() > 1e-9) =>
            {
                let factor = x.factor.zip(y.factor).map_or(1.0, |(f, g)| f / g);
                (
                    format!(
                        "gives a unit {} times its unit {label}",
                        crate::scientific(factor, 6)
                    ),
                    "write the factor into the formula, state the unit it gives, or let the units be converted: units = \"convert\" \
                     at the head of the file",
                )
            }
            (Unit::Known(x), Unit::Degrees(_)) if !x.is_number() => {
                ("is no angle".to_owned(), "check formula and units")
            }
            (Unit::Degrees(f), Unit::Known(y)) if f.abs() >= CONVERTED && y.is_number() => (
                format!("is an angle in degrees, its unit is {label}"),
                "write radians(…) about it, or state its unit as °",
            ),
            (Unit::Degrees(_), Unit::Known(y)) if !y.is_number() => (
                format!("is an angle, its unit is {label}"),
                "check formula and units",
            ),
            _ => return,
        };
        self.contradict(&what, advice);
    }
}

/// The unit of a parameter of a fit, y/xᵏ; that of an unknown is not followed.
fn parameter(compiled: &Compiled, block: usize, k: i8, units: &[Unit]) -> Unit {
    let Some(Block::Fit(fit)) = compiled.blocks.get(block) else {
        return Unit::Unknown;
    };
    if fit.curve.is_some() {
        return Unit::Unknown;
    }
    let of = |places: &[u32]| {
        places
            .first()
            .map_or(Unit::Unknown, |&place| units[place as usize])
    };
    match (of(&fit.y), of(&fit.x)) {
        (Unit::Known(y), Unit::Known(x)) => y.times(&x, -k).map_or(Unit::Unknown, Unit::Known),
        (y, _) if k == 0 => y,
        _ => Unit::Unknown,
    }
}

/// a · b^power
fn product(a: Unit, b: Unit, sign: i8) -> Unit {
    let scaled = |x: f64, by: f64| if sign > 0 { x * by } else { x / by };
    match (a, b) {
        (Unit::Number(x), Unit::Number(y)) => Unit::Number(scaled(x, y)),
        (Unit::Degrees(x), Unit::Number(y)) => Unit::Degrees(scaled(x, y)),
        (Unit::Number(x), Unit::Degrees(y)) if sign > 0 => Unit::Degrees(x * y),
        (Unit::Degrees(x), Unit::Known(d)) if d.is_number() => Unit::Degrees(x),
        (Unit::Known(d), Unit::Degrees(x)) if d.is_number() && sign > 0 => Unit::Degrees(x),
        (Unit::Degrees(_), Unit::Degrees(_)) if sign < 0 => Unit::Known(Dimension::one()),
        // Any other number may carry a unit that is not written: 11.5e-6 per kelvin, 1000 for a conversion.
        (Unit::Known(_), Unit::Number(x)) | (Unit::Number(x), Unit::Known(_)) if !is_pure(x) => {
            Unit::Unknown
        }
        (Unit::Known(d), Unit::Number(_)) => Unit::Known(d),
        (Unit::Number(_), Unit::Known(d)) => Dimension::one()
            .times(&d, sign)
            .map_or(Unit::Unknown, Unit::Known),
        (Unit::Known(x), Unit::Known(y)) => x.times(&y, sign).map_or(Unit::Unknown, Unit::Known),
        _ => Unit::Unknown,
    }
}

/// A number as geometry and counting have it: a ratio of integers below ten, perhaps times π.
fn is_pure(x: f64) -> bool {
    let pi = std::f64::consts::PI;
    [1.0, pi, pi * pi].iter().any(|unit| {
        (1..10).any(|m| {
            let k = x / unit * f64::from(m);
            k.abs() < 9.5 && k.abs() > 0.5 && (k - k.round()).abs() < 1e-12
        })
    })
}

fn power(base: Unit, exponent: Unit) -> Unit {
    match (base, exponent) {
        (Unit::Number(x), Unit::Number(y)) => Unit::Number(x.powf(y)),
        (Unit::Known(d), Unit::Number(n)) if n.fract() == 0.0 && n.abs() < 100.0 => {
            Dimension::one()
                .times(&d, n as i8)
                .map_or(Unit::Unknown, Unit::Known)
        }
        (Unit::Known(d), Unit::Number(0.5)) => d.root().map_or(Unit::Unknown, Unit::Known),
        (Unit::Known(d), _) if d.is_number() => Unit::Known(Dimension::one()),
        _ => Unit::Unknown,
    }
}

//! Do the units of a model fit together? What an expression does to the dimensions of its inputs.

use super::UncertaintyModel;
use crate::dimension::Dimension;
use crate::expression::{Expression, Operation};
use crate::{Finding, Severity};

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

impl UncertaintyModel {
    /// Findings about units: degrees in a trigonometric function, sums of different kinds or sizes, dimensions where a
    /// number is needed, an output whose formula has another dimension, a label that is no unit.
    ///
    /// Nothing is converted. A label that is no unit excludes what depends on it from the check.
    pub fn doubtful_units(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        let mut names: Vec<String> = Vec::new();
        let mut units: Vec<Unit> = Vec::new();
        let mut labels: Vec<String> = Vec::new();
        for input in &self.input {
            units.push(unit_of(&input.unit, &input.name, &mut labels));
            names.push(input.name.clone());
        }
        let parts = self
            .intermediate
            .iter()
            .map(|i| (&i.name, &i.expression, None));
        let outputs = self
            .output
            .iter()
            .map(|o| (&o.name, &o.expression, Some(&o.unit)));
        for (name, text, unit) in parts.chain(outputs) {
            let Ok(expression) = Expression::parse(text, &names) else {
                return findings;
            };
            let mut walk = Walk {
                name,
                names: &names,
                units: &units,
                findings: &mut findings,
            };
            let mut found = walk.through(&expression);
            if let Some(unit) = unit {
                let stated = unit_of(unit, name, &mut labels);
                walk.compare(found, stated, unit);
                if matches!(stated, Unit::Known(_) | Unit::Degrees(_)) {
                    found = stated;
                }
            }
            units.push(found);
            names.push(name.clone());
        }
        if !labels.is_empty() {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "unknown-unit",
                    "labels that are no unit this program knows; formulas with them are not checked for their units",
                )
                .evidence(labels.join(", ")),
            );
        }
        findings
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
    names: &'a [String],
    units: &'a [Unit],
    findings: &'a mut Vec<Finding>,
}

impl Walk<'_> {
    fn say(&mut self, severity: Severity, code: &str, what: String, advice: &str) {
        let known = self
            .findings
            .iter()
            .any(|f| f.code() == code && f.what() == what);
        if !known {
            self.findings
                .push(Finding::new(severity, code, what).advice(advice));
        }
    }

    fn through(&mut self, expression: &Expression) -> Unit {
        let mut stack: Vec<Unit> = Vec::new();
        for operation in expression.operations() {
            let mut take = || stack.pop().unwrap_or(Unit::Unknown);
            let result = match operation {
                Operation::Number(x) => Unit::Number(x),
                Operation::Variable(i) => self.units.get(i).copied().unwrap_or(Unit::Unknown),
                Operation::Sum => {
                    let (b, a) = (take(), take());
                    self.alike(a, b)
                }
                Operation::Keep => take(),
                Operation::Product => {
                    let (b, a) = (take(), take());
                    product(a, b, 1)
                }
                Operation::Quotient => {
                    let (b, a) = (take(), take());
                    product(a, b, -1)
                }
                Operation::Power => {
                    let (exponent, base) = (take(), take());
                    power(base, exponent)
                }
                Operation::IntegerPower(n) => power(take(), Unit::Number(f64::from(n))),
                Operation::Root => power(take(), Unit::Number(0.5)),
                Operation::Other => {
                    take();
                    Unit::Unknown
                }
                Operation::Trigonometric => {
                    let angle = take();
                    self.angle(angle)
                }
                Operation::OfNumber => {
                    let x = take();
                    self.number(x)
                }
                Operation::Angle => {
                    let (b, a) = (take(), take());
                    self.alike(a, b);
                    Unit::Known(Dimension::one())
                }
                Operation::ToDegrees => {
                    take();
                    Unit::Degrees(1.0)
                }
                Operation::ToRadians => {
                    take();
                    Unit::Known(Dimension::one())
                }
                Operation::Comparison => {
                    let (b, a) = (take(), take());
                    self.alike(a, b);
                    Unit::Number(1.0)
                }
                Operation::Choice => {
                    let (b, a) = (take(), take());
                    take();
                    self.alike(a, b)
                }
            };
            stack.push(result);
        }
        stack.pop().unwrap_or(Unit::Unknown)
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
                    self.say(
                        Severity::Decision,
                        "units-do-not-fit",
                        format!(
                            "the formula of {} adds an angle in degrees to something else",
                            self.name
                        ),
                        "convert it with radians(…)",
                    );
                }
                Unit::Unknown
            }
            (Unit::Known(x), Unit::Known(y)) => {
                let sizes = x.factor.zip(y.factor);
                if !x.is_like(&y) {
                    self.say(
                        Severity::Decision,
                        "units-do-not-fit",
                        format!(
                            "the formula of {} adds or compares quantities of different dimensions",
                            self.name
                        ),
                        "check the formula and the units of its inputs",
                    );
                    return Unit::Unknown;
                }
                if sizes.is_some_and(|(f, g)| (f / g - 1.0).abs() > 1e-9) {
                    self.say(
                        Severity::Decision,
                        "units-do-not-fit",
                        format!(
                            "the formula of {} adds or compares quantities in units of different size",
                            self.name
                        ),
                        "keep to one unit, or convert by a factor in the formula: units are not converted",
                    );
                    return Unit::Unknown;
                }
                Unit::Known(if x.factor.is_some() { x } else { y })
            }
        }
    }

    fn angle(&mut self, angle: Unit) -> Unit {
        match angle {
            Unit::Degrees(factor) if factor.abs() >= CONVERTED => {
                let degrees: Vec<&str> = self
                    .names
                    .iter()
                    .zip(self.units)
                    .filter(|(_, u)| matches!(u, Unit::Degrees(_)))
                    .map(|(name, _)| name.as_str())
                    .collect();
                let what = format!(
                    "the formula of {} takes the sine, cosine or tangent of degrees as if they were radians ({})",
                    self.name,
                    degrees.join(", ")
                );
                self.say(
                    Severity::Decision,
                    "degrees-in-trigonometry",
                    what,
                    "write radians(…) about the angle, or state it in rad",
                );
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
                Severity::Warning,
                "units-do-not-fit",
                format!(
                    "the formula of {} takes a function of a quantity with a dimension that is defined for pure numbers",
                    self.name
                ),
                "divide by a unit or a reference value first",
            );
        }
        Unit::Known(Dimension::one())
    }

    /// What the formula gives against what the output states.
    fn compare(&mut self, found: Unit, stated: Unit, label: &str) {
        let (what, advice) = match (found, stated) {
            (Unit::Known(x), Unit::Known(y)) if !x.is_like(&y) => (
                format!(
                    "the formula of {} has another dimension than its unit {label}",
                    self.name
                ),
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
                        "the formula of {} gives a unit {} times its unit {label}",
                        self.name,
                        crate::scientific(factor, 6)
                    ),
                    "write the factor into the formula, or state the unit it gives: units are not converted",
                )
            }
            (Unit::Known(x), Unit::Degrees(_)) if !x.is_number() => (
                format!("the formula of {} is no angle", self.name),
                "check formula and units",
            ),
            (Unit::Degrees(f), Unit::Known(y)) if f.abs() >= CONVERTED && y.is_number() => (
                format!(
                    "the formula of {} is an angle in degrees, its unit is {label}",
                    self.name
                ),
                "write radians(…) about it, or state its unit as °",
            ),
            (Unit::Degrees(_), Unit::Known(y)) if !y.is_number() => (
                format!(
                    "the formula of {} is an angle, its unit is {label}",
                    self.name
                ),
                "check formula and units",
            ),
            _ => return,
        };
        self.say(Severity::Decision, "units-do-not-fit", what, advice);
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

//! Temperatures in °C, whose zero is not that of the kelvin: in a product, a quotient or a power it matters which is meant.
//!
//! An input in °C is a point of the scale. The difference of two is the same in K, and so is a change that is multiplied by
//! a coefficient per °C or by a relative one, 1/K. What is left is told: a point of the scale against another unit with K
//! (R T, the law of radiation), a power of it without a coefficient per °C, and whatever is divided by it.

use super::{Unit, Walk, is_pure};
use crate::Severity;
use crate::dimension::{Dimension, Kelvins};
use crate::expression::Op;
use crate::findings;

/// Kelvins between the zeros of both scales.
const ZERO: f64 = 273.15;

/// The unit of a result that states one itself: a difference stays one, whatever scale its unit is written in.
pub(super) fn kept(found: Unit, stated: Unit) -> Unit {
    match (found, stated) {
        (Unit::Known(found), Unit::Known(stated)) if found.is_like(&stated) => {
            Unit::Known(stated.meaning(found.kelvins))
        }
        _ => stated,
    }
}

/// A sum or difference on the scale that it stands on.
pub(super) fn of_sum(op: Op, sum: Unit, a: Unit, b: Unit) -> Unit {
    let Unit::Known(sum) = sum else {
        return sum;
    };
    if !sum.is_temperature() {
        // A sum of powers is on whatever scale one of them is.
        let (x, y) = (of_unit(a), of_unit(b));
        let kelvins = if x.celsius == 0 { y } else { x };
        return Unit::Known(sum.meaning(kelvins));
    }
    let subtracts = matches!(op, Op::Subtract(..));
    let scale = match (a, b) {
        (Unit::Known(a), Unit::Number(x)) => Scale::of(a).with_number(x, subtracts),
        (Unit::Number(x), Unit::Known(b)) if !subtracts => Scale::of(b).with_number(x, false),
        (Unit::Known(a), Unit::Known(b)) => match op {
            Op::Add(..) => Scale::of(a).plus(Scale::of(b)),
            Op::Subtract(..) => Scale::of(a).minus(Scale::of(b)),
            Op::Hypotenuse(..) => Scale::Difference,
            _ if Scale::of(a) == Scale::Difference => Scale::of(b),
            _ => Scale::of(a),
        },
        _ => Scale::Difference,
    };
    Unit::Known(sum.meaning(Kelvins {
        celsius: i8::from(scale == Scale::Celsius),
        absolute: i8::from(scale == Scale::Absolute),
    }))
}

/// What a temperature counts from.
#[derive(Clone, Copy, PartialEq)]
enum Scale {
    Celsius,
    Absolute,
    Difference,
}

impl Scale {
    fn of(dimension: Dimension) -> Self {
        let Kelvins { celsius, absolute } = dimension.kelvins;
        match (celsius, absolute) {
            (1, 0) => Self::Celsius,
            (0, 1) => Self::Absolute,
            _ => Self::Difference,
        }
    }

    /// With a number that has no unit: the distance of the zeros, a correction or another temperature.
    fn with_number(self, number: f64, subtracts: bool) -> Self {
        let zero = (number - ZERO).abs() < 0.5;
        match (self, subtracts) {
            (Self::Celsius, false) if zero => Self::Absolute,
            (Self::Absolute, true) if zero => Self::Celsius,
            (scale, false) => scale,
            (_, true) => Self::Difference,
        }
    }

    fn plus(self, other: Self) -> Self {
        match (self, other) {
            (Self::Difference, scale) | (scale, Self::Difference) => scale,
            (a, b) if a == b => a,
            // One of them is a change, or the zero of the other scale.
            _ => Self::Difference,
        }
    }

    fn minus(self, other: Self) -> Self {
        match other {
            Self::Difference => self,
            _ => Self::Difference,
        }
    }
}

fn of_unit(unit: Unit) -> Kelvins {
    match unit {
        Unit::Known(dimension) => dimension.kelvins,
        _ => Kelvins::default(),
    }
}

/// Lets kelvins cancel, first those that are differences; whether °C is left against K.
fn cancelled(dimension: &mut Dimension) -> bool {
    // Takes from both what they have with opposite signs.
    let meet = |a: i8, b: i8| {
        if a.signum() * b.signum() < 0 {
            let common = a.abs().min(b.abs());
            (a - a.signum() * common, b - b.signum() * common)
        } else {
            (a, b)
        }
    };
    let Kelvins { celsius, absolute } = dimension.kelvins;
    let difference = dimension.of_temperature() - celsius - absolute;
    let (celsius, difference) = meet(celsius, difference);
    let (absolute, _) = meet(absolute, difference);
    let clash = celsius.signum() * absolute.signum() < 0;
    let (celsius, absolute) = meet(celsius, absolute);
    dimension.kelvins = Kelvins { celsius, absolute };
    clash
}

impl Walk<'_> {
    /// The inputs in °C behind a result.
    fn celsius_behind(&self, ops: &[Op], k: u32, units: &[Unit]) -> String {
        let mut names: Vec<&str> = Vec::new();
        let mut open = vec![k];
        while let Some(k) = open.pop() {
            if of_unit(units[k as usize]).celsius == 0 {
                continue;
            }
            if let Op::Input(i) = ops[k as usize]
                && let Some(name) = self.inputs.get(i)
                && !names.contains(name)
            {
                names.push(name);
            }
            open.extend(ops[k as usize].operands().into_iter().flatten());
        }
        names.reverse();
        match names.is_empty() {
            true => "a temperature".to_owned(),
            false => names.join(", "),
        }
    }

    /// A product or quotient in which a temperature in °C stands where one in K is meant.
    pub(super) fn zeros_of_product(
        &mut self,
        ops: &[Op],
        k: usize,
        units: &[Unit],
        found: Unit,
    ) -> Unit {
        let (a, b, divides) = match ops[k] {
            Op::Multiply(a, b) => (a, b, false),
            Op::Divide(a, b) => (a, b, true),
            _ => return found,
        };
        let (x, y) = (units[a as usize], units[b as usize]);
        // A number with a unit is the size of a degree: t / 100 [°C].
        let number = matches!(ops[b as usize], Op::Constant(_));
        if divides && of_unit(y).celsius > 0 && !number {
            let name = self.celsius_behind(ops, b, units);
            self.zero(&format!("divides by {name} in °C"), None);
            // Once is enough.
            return match found {
                Unit::Known(d) => Unit::Known(d.meaning(Kelvins::default())),
                other => other,
            };
        }
        for (power, by, place) in [(x, y, a), (y, x, b)] {
            if of_unit(power).celsius > 1 && matches!(by, Unit::Number(n) if !is_pure(n)) {
                let name = self.celsius_behind(ops, place, units);
                let what = "by a number without a unit";
                self.zero(
                    &format!("multiplies a power of {name} in °C {what}"),
                    Some(Severity::Warning),
                );
            }
        }
        let Unit::Known(mut dimension) = found else {
            return found;
        };
        if cancelled(&mut dimension) {
            let in_celsius = [a, b].into_iter().filter(|&k| {
                let celsius = of_unit(units[k as usize]).celsius;
                celsius != 0
            });
            let names: Vec<String> = in_celsius
                .map(|k| self.celsius_behind(ops, k, units))
                .collect();
            let names = names.join(", ");
            self.zero(&format!("multiplies {names} in °C by a unit with K"), None);
        }
        Unit::Known(dimension)
    }

    /// A root, or an inverse, of a temperature in °C.
    pub(super) fn zeros_of_power(&mut self, ops: &[Op], a: u32, units: &[Unit], exponent: Unit) {
        let whole = matches!(exponent, Unit::Number(n) if n.fract() == 0.0 && n > 0.0);
        if of_unit(units[a as usize]).celsius > 0 && !whole {
            let name = self.celsius_behind(ops, a, units);
            self.zero(&format!("raises {name} in °C to a power"), None);
        }
    }

    /// What is stated in K and computed in °C, or the other way round.
    pub(super) fn compare_zeros(
        &mut self,
        ops: &[Op],
        k: u32,
        units: &[Unit],
        stated: Unit,
        label: &str,
    ) {
        let (found, said) = (of_unit(units[k as usize]), of_unit(stated));
        let zero = if found.celsius > 0 && said.absolute > 0 {
            let names = self.celsius_behind(ops, k, units);
            format!("is computed from {names} in °C")
        } else if found.celsius == 0 && found.absolute > 0 && said.celsius > 0 {
            "is computed in K".to_owned()
        } else {
            return;
        };
        self.zero(&format!("{zero}, its unit is {label}"), None);
    }

    fn zero(&mut self, contradiction: &str, severity: Option<Severity>) {
        let finding = findings::units_do_not_fit(
            self.name,
            contradiction,
            "give the temperature in K (t + 273.15), a change of temperature in K or as the difference of two, and a coefficient \
             that is meant for °C with its unit: 5.8e-7 [1/°C^2]",
        );
        self.say(match severity {
            Some(severity) => finding.at(severity),
            None => finding,
        });
    }
}

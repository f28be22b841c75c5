//! Formulas as a list of operations on numbered results: complex quantities and vectors are already taken apart.

use super::function::{Function, Relation, hypotenuse};
use crate::Number;

/// One operation; its operands are earlier results by their number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Op {
    Constant(f64),
    /// A variable by its position.
    Input(usize),
    Negate(u32),
    Add(u32, u32),
    Subtract(u32, u32),
    Multiply(u32, u32),
    Divide(u32, u32),
    Power(u32, u32),
    IntegerPower(u32, i32),
    Call(Function, u32),
    /// With the number of this angle in the program.
    Atan2(u32, u32, usize),
    Minimum(u32, u32),
    Maximum(u32, u32),
    /// √(a² + b²)
    Hypotenuse(u32, u32),
    /// 1 where the relation holds, else 0.
    Compare(Relation, u32, u32),
    /// Condition, then, else.
    Select(u32, u32, u32),
    /// The first result of a block: equations that are solved, a fit.
    #[cfg(feature = "model")]
    Block(usize),
    /// A further result of the block before it.
    #[cfg(feature = "model")]
    Further,
}

/// Operations in the order of evaluation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Program {
    pub(crate) ops: Vec<Op>,
    /// How many angles of `atan2` it has.
    pub(crate) angles: usize,
    /// Units of numbers in the text: result, unit.
    pub(crate) labels: Vec<(u32, String)>,
}

impl Program {
    /// Fills `results`, one per operation, from the variables; a variable that is not given counts as NaN.
    ///
    /// `angle` may replace the result of each `atan2`, by its number; `block` computes the results of a block from those
    /// before it.
    pub fn run<T: Number>(
        &self,
        variables: &[T],
        results: &mut [T],
        mut angle: impl FnMut(usize, T) -> T,
        mut block: impl FnMut(usize, &[T], &mut [T]),
    ) {
        // Without blocks there is nothing to call.
        let _ = &mut block;
        for (place, op) in self.ops.iter().enumerate().take(results.len()) {
            let (done, ahead) = results.split_at_mut(place);
            let of = |k: u32| done[k as usize];
            ahead[0] = match *op {
                Op::Constant(c) => T::from(c),
                Op::Input(i) => variables.get(i).copied().unwrap_or(T::from(f64::NAN)),
                Op::Negate(a) => -of(a),
                Op::Add(a, b) => of(a) + of(b),
                Op::Subtract(a, b) => of(a) - of(b),
                Op::Multiply(a, b) => of(a) * of(b),
                Op::Divide(a, b) => of(a) / of(b),
                Op::Power(a, b) => of(a).powf(of(b)),
                Op::IntegerPower(a, n) => of(a).powi(n),
                Op::Call(function, a) => function.apply(of(a)),
                Op::Atan2(a, b, number) => angle(number, of(a).atan2(of(b))),
                Op::Minimum(a, b) => {
                    let (a, b) = (of(a), of(b));
                    if b.value() < a.value() || b.value().is_nan() {
                        b
                    } else {
                        a
                    }
                }
                Op::Maximum(a, b) => {
                    let (a, b) = (of(a), of(b));
                    if b.value() > a.value() || b.value().is_nan() {
                        b
                    } else {
                        a
                    }
                }
                Op::Hypotenuse(a, b) => hypotenuse(of(a), of(b)),
                Op::Compare(relation, a, b) => T::from(f64::from(u8::from(
                    relation.holds(of(a).value(), of(b).value()),
                ))),
                Op::Select(condition, a, b) => {
                    if of(condition).value() != 0.0 {
                        of(a)
                    } else {
                        of(b)
                    }
                }
                #[cfg(feature = "model")]
                Op::Block(number) => {
                    let width = 1 + self.ops[place + 1..]
                        .iter()
                        .take_while(|op| matches!(op, Op::Further))
                        .count();
                    let width = width.min(ahead.len());
                    block(number, done, &mut ahead[..width]);
                    continue;
                }
                #[cfg(feature = "model")]
                Op::Further => continue,
            };
        }
    }

    /// Appends an operation; the number of its result. Arithmetic of constants is done at once.
    pub fn push(&mut self, op: Op) -> u32 {
        let constant = |k: u32| match self.ops.get(k as usize) {
            Some(Op::Constant(c)) if !self.labels.iter().any(|(place, _)| *place == k) => Some(*c),
            _ => None,
        };
        let two = |a, b| constant(a).zip(constant(b));
        let folded = match op {
            Op::Negate(a) => constant(a).map(|a| -a),
            Op::Add(a, b) => two(a, b).map(|(a, b)| a + b),
            Op::Subtract(a, b) => two(a, b).map(|(a, b)| a - b),
            Op::Multiply(a, b) => two(a, b).map(|(a, b)| a * b),
            Op::Divide(a, b) => two(a, b).map(|(a, b)| a / b),
            _ => None,
        };
        let op = match folded {
            Some(value) if value.is_finite() => Op::Constant(value),
            _ => op,
        };
        self.ops.push(op);
        (self.ops.len() - 1) as u32
    }

    /// The number that a result is, where it is one.
    pub fn constant(&self, k: u32) -> Option<f64> {
        match self.ops.get(k as usize) {
            Some(Op::Constant(c)) => Some(*c),
            _ => None,
        }
    }
}

//! A list of operations on many trials at once: each operation goes over its columns before the next one begins.

use super::function::hypotenuse;
use super::program::{Op, Program};
use crate::Number;

/// Values of all results that stay in the second-level cache.
const NEAR: usize = 1 << 14;

impl Program {
    /// Trials that are best taken at a time.
    pub fn columns_width(&self, trials: usize) -> usize {
        let width = NEAR / self.ops.len().max(1);
        (width & !7).clamp(8, 256).min(trials.max(1))
    }

    /// Fills `results`, `width` numbers per operation, as [`Program::run`] does for each trial; the same numbers.
    pub fn run_columns(
        &self,
        variables: &[&[f64]],
        results: &mut [f64],
        width: usize,
        mut angle: impl FnMut(usize, f64) -> f64,
        mut block: impl FnMut(usize, &[f64], &mut [f64]),
    ) {
        for (place, op) in self.ops.iter().enumerate() {
            let (done, ahead) = results.split_at_mut(place * width);
            let of = |k: u32| &done[k as usize * width..][..width];
            let out = &mut ahead[..width];
            let mut each = |a: u32, f: &mut dyn FnMut(f64) -> f64| {
                for (y, a) in out.iter_mut().zip(of(a)) {
                    *y = f(*a);
                }
            };
            match *op {
                Op::Constant(c) => out.fill(c),
                Op::Input(i) => match variables.get(i) {
                    Some(column) => out.copy_from_slice(&column[..width]),
                    None => out.fill(f64::NAN),
                },
                Op::Negate(a) => {
                    for (y, a) in out.iter_mut().zip(of(a)) {
                        *y = -a;
                    }
                }
                Op::Add(a, b) => two(out, of(a), of(b), |a, b| a + b),
                Op::Subtract(a, b) => two(out, of(a), of(b), |a, b| a - b),
                Op::Multiply(a, b) => two(out, of(a), of(b), |a, b| a * b),
                Op::Divide(a, b) => two(out, of(a), of(b), |a, b| a / b),
                Op::Power(a, b) => two(out, of(a), of(b), Number::powf),
                Op::IntegerPower(a, n) => each(a, &mut |a| Number::powi(a, n)),
                Op::Call(function, a) => each(a, &mut |a| function.apply(a)),
                Op::Atan2(a, b, number) => {
                    two(out, of(a), of(b), |a, b| angle(number, a.atan2(b)));
                }
                Op::Minimum(a, b) => {
                    two(
                        out,
                        of(a),
                        of(b),
                        |a, b| {
                            if b < a || b.is_nan() { b } else { a }
                        },
                    )
                }
                Op::Maximum(a, b) => {
                    two(
                        out,
                        of(a),
                        of(b),
                        |a, b| {
                            if b > a || b.is_nan() { b } else { a }
                        },
                    )
                }
                Op::Hypotenuse(a, b) => two(out, of(a), of(b), hypotenuse),
                Op::Compare(relation, a, b) => two(out, of(a), of(b), |a, b| {
                    f64::from(u8::from(relation.holds(a, b)))
                }),
                Op::Select(condition, a, b) => {
                    let sides = of(condition).iter().zip(of(a).iter().zip(of(b)));
                    for (y, (condition, (a, b))) in out.iter_mut().zip(sides) {
                        *y = if *condition != 0.0 { *a } else { *b };
                    }
                }
                Op::Block(number) => {
                    let further = self.ops[place + 1..].iter();
                    let rows = 1 + further.take_while(|op| matches!(op, Op::Further)).count();
                    let mut before = vec![0.0; place];
                    let mut solved = vec![0.0; rows];
                    for trial in 0..width {
                        for (k, x) in before.iter_mut().enumerate() {
                            *x = done[k * width + trial];
                        }
                        block(number, &before, &mut solved);
                        for (k, y) in solved.iter().enumerate() {
                            ahead[k * width + trial] = *y;
                        }
                    }
                }
                Op::Further => {}
            }
        }
    }
}

fn two(out: &mut [f64], a: &[f64], b: &[f64], mut f: impl FnMut(f64, f64) -> f64) {
    for (y, (a, b)) in out.iter_mut().zip(a.iter().zip(b)) {
        *y = f(*a, *b);
    }
}

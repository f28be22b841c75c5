//! What a part of a formula stands for while it is read: a real or complex quantity, or a vector of them.

use super::function::{FUNCTIONS, Function};
use super::program::{Op, Program};

/// One quantity by the numbers of its results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scalar {
    Real(u32),
    /// Real and imaginary part.
    Complex(u32, u32),
}

/// What a name or a part of a formula stands for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    One(Scalar),
    Many(Vec<Scalar>),
}

/// Why an operation cannot be done with its operands.
pub(super) type Obstacle = String;

/// The operations of arithmetic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

impl Value {
    pub fn real(k: u32) -> Self {
        Self::One(Scalar::Real(k))
    }

    /// Its quantities in order.
    pub fn scalars(&self) -> Vec<Scalar> {
        match self {
            Self::One(one) => vec![*one],
            Self::Many(many) => many.clone(),
        }
    }
}

/// f of every quantity.
pub(super) fn each(
    value: &Value,
    mut f: impl FnMut(Scalar) -> Result<Scalar, Obstacle>,
) -> Result<Value, Obstacle> {
    Ok(match value {
        Value::One(one) => Value::One(f(*one)?),
        Value::Many(many) => Value::Many(many.iter().map(|s| f(*s)).collect::<Result<_, _>>()?),
    })
}

/// f of the pairs; a single quantity goes with every quantity of a vector.
pub(super) fn pairs(
    a: &Value,
    b: &Value,
    mut f: impl FnMut(Scalar, Scalar) -> Result<Scalar, Obstacle>,
) -> Result<Value, Obstacle> {
    match (a, b) {
        (Value::One(a), _) => each(b, |b| f(*a, b)),
        (_, Value::One(b)) => each(a, |a| f(a, *b)),
        (Value::Many(a), Value::Many(b)) if a.len() == b.len() => Ok(Value::Many(
            a.iter()
                .zip(b)
                .map(|(a, b)| f(*a, *b))
                .collect::<Result<_, _>>()?,
        )),
        (Value::Many(a), Value::Many(b)) => Err(format!(
            "the vectors have different lengths, {} and {}",
            a.len(),
            b.len()
        )),
    }
}

/// Complex arithmetic as operations on real numbers.
pub(super) trait Complexes {
    fn parts(&mut self, a: Scalar) -> (u32, u32);
    fn binary(&mut self, operation: Binary, a: Scalar, b: Scalar) -> Result<Scalar, Obstacle>;
    fn negate(&mut self, a: Scalar) -> Scalar;
    fn call(&mut self, function: Function, a: Scalar) -> Result<Scalar, Obstacle>;
    fn magnitude(&mut self, a: Scalar) -> u32;
    fn argument(&mut self, a: Scalar) -> u32;
    fn polar(&mut self, magnitude: u32, angle: u32) -> Scalar;
    fn complex_power(&mut self, a: Scalar, b: Scalar) -> Result<Scalar, Obstacle>;
    fn angle(&mut self, y: u32, x: u32) -> u32;
}

impl Complexes for Program {
    fn parts(&mut self, a: Scalar) -> (u32, u32) {
        match a {
            Scalar::Real(a) => (a, self.push(Op::Constant(0.0))),
            Scalar::Complex(re, im) => (re, im),
        }
    }

    fn binary(&mut self, operation: Binary, a: Scalar, b: Scalar) -> Result<Scalar, Obstacle> {
        use Scalar::{Complex, Real};
        Ok(match (operation, a, b) {
            (Binary::Add, Real(a), Real(b)) => Real(self.push(Op::Add(a, b))),
            (Binary::Multiply, Real(a), Real(b)) => Real(self.push(Op::Multiply(a, b))),
            (Binary::Divide, Real(a), Real(b)) => Real(self.push(Op::Divide(a, b))),
            (Binary::Power, a, Real(b)) if self.constant(b).is_some_and(is_small_integer) => {
                let n = self.constant(b).map_or(1, |n| n as i32);
                match a {
                    Real(a) => Real(self.push(Op::IntegerPower(a, n))),
                    complex => {
                        let mut result = complex;
                        for _ in 1..n.unsigned_abs() {
                            result = self.binary(Binary::Multiply, result, complex)?;
                        }
                        let one = Real(self.push(Op::Constant(1.0)));
                        match n {
                            0 => one,
                            n if n < 0 => self.binary(Binary::Divide, one, result)?,
                            _ => result,
                        }
                    }
                }
            }
            (Binary::Power, Real(a), Real(b)) => Real(self.push(Op::Power(a, b))),
            (Binary::Power, a, b) => self.complex_power(a, b)?,
            (Binary::Subtract, a, b) => self.difference(a, b),
            (Binary::Add, a, b) => {
                let ((ar, ai), (br, bi)) = (self.parts(a), self.parts(b));
                Complex(self.push(Op::Add(ar, br)), self.push(Op::Add(ai, bi)))
            }
            (Binary::Multiply, Real(k), Complex(re, im))
            | (Binary::Multiply, Complex(re, im), Real(k)) => Complex(
                self.push(Op::Multiply(k, re)),
                self.push(Op::Multiply(k, im)),
            ),
            (Binary::Divide, Complex(re, im), Real(k)) => {
                Complex(self.push(Op::Divide(re, k)), self.push(Op::Divide(im, k)))
            }
            (Binary::Multiply, Complex(ar, ai), Complex(br, bi)) => {
                let (rr, ii) = (
                    self.push(Op::Multiply(ar, br)),
                    self.push(Op::Multiply(ai, bi)),
                );
                let (ri, ir) = (
                    self.push(Op::Multiply(ar, bi)),
                    self.push(Op::Multiply(ai, br)),
                );
                Complex(self.push(Op::Subtract(rr, ii)), self.push(Op::Add(ri, ir)))
            }
            (Binary::Divide, a, Complex(br, bi)) => {
                // a · b̄ / |b|, divided by |b| again: no square that overflows.
                let size = self.magnitude(b);
                let (cr, ci) = (
                    self.push(Op::Divide(br, size)),
                    self.push(Op::Divide(bi, size)),
                );
                let ci = self.push(Op::Negate(ci));
                let product = self.binary(Binary::Multiply, a, Complex(cr, ci))?;
                self.binary(Binary::Divide, product, Real(size))?
            }
        })
    }

    fn negate(&mut self, a: Scalar) -> Scalar {
        match a {
            Scalar::Real(a) => Scalar::Real(self.push(Op::Negate(a))),
            Scalar::Complex(re, im) => {
                Scalar::Complex(self.push(Op::Negate(re)), self.push(Op::Negate(im)))
            }
        }
    }

    fn call(&mut self, function: Function, a: Scalar) -> Result<Scalar, Obstacle> {
        let (re, im) = match a {
            Scalar::Real(a) => return Ok(Scalar::Real(self.push(Op::Call(function, a)))),
            Scalar::Complex(re, im) => (re, im),
        };
        let of = |p: &mut Self, f, x| p.push(Op::Call(f, x));
        Ok(match function {
            Function::Abs => Scalar::Real(self.magnitude(a)),
            Function::Exp => {
                let size = of(self, Function::Exp, re);
                self.polar(size, im)
            }
            Function::Ln => {
                let size = self.magnitude(a);
                let (ln, arg) = (of(self, Function::Ln, size), self.argument(a));
                Scalar::Complex(ln, arg)
            }
            Function::Sqrt => {
                let (size, arg) = (self.magnitude(a), self.argument(a));
                let (size, two) = (of(self, Function::Sqrt, size), self.push(Op::Constant(2.0)));
                let half = self.push(Op::Divide(arg, two));
                self.polar(size, half)
            }
            Function::Sin | Function::Cos | Function::Sinh | Function::Cosh => {
                let circular = matches!(function, Function::Sin | Function::Cos);
                // Of the angle and of the other part.
                let (angle, other) = if circular { (re, im) } else { (im, re) };
                let (s, c) = (
                    of(self, Function::Sin, angle),
                    of(self, Function::Cos, angle),
                );
                let (sh, ch) = (
                    of(self, Function::Sinh, other),
                    of(self, Function::Cosh, other),
                );
                let (first, second) = match function {
                    Function::Sin => ((s, ch), (c, sh)),
                    Function::Cos => ((c, ch), (s, sh)),
                    Function::Sinh => ((c, sh), (s, ch)),
                    _ => ((c, ch), (s, sh)),
                };
                let real = self.push(Op::Multiply(first.0, first.1));
                let mut imaginary = self.push(Op::Multiply(second.0, second.1));
                if function == Function::Cos {
                    imaginary = self.push(Op::Negate(imaginary));
                }
                Scalar::Complex(real, imaginary)
            }
            Function::Tan | Function::Tanh => {
                let (over, under) = if function == Function::Tan {
                    (Function::Sin, Function::Cos)
                } else {
                    (Function::Sinh, Function::Cosh)
                };
                let (over, under) = (self.call(over, a)?, self.call(under, a)?);
                self.binary(Binary::Divide, over, under)?
            }
            other => {
                let name = FUNCTIONS.iter().find(|(_, f)| *f == other);
                return Err(format!(
                    "{} of a complex quantity is not offered",
                    name.map_or("this function", |(name, _)| name)
                ));
            }
        })
    }

    fn magnitude(&mut self, a: Scalar) -> u32 {
        match a {
            Scalar::Real(a) => self.push(Op::Call(Function::Abs, a)),
            Scalar::Complex(re, im) => self.push(Op::Hypotenuse(re, im)),
        }
    }

    fn argument(&mut self, a: Scalar) -> u32 {
        let (re, im) = self.parts(a);
        self.angle(im, re)
    }

    fn polar(&mut self, magnitude: u32, angle: u32) -> Scalar {
        let (c, s) = (
            self.push(Op::Call(Function::Cos, angle)),
            self.push(Op::Call(Function::Sin, angle)),
        );
        Scalar::Complex(
            self.push(Op::Multiply(magnitude, c)),
            self.push(Op::Multiply(magnitude, s)),
        )
    }

    /// exp(b ln a)
    fn complex_power(&mut self, a: Scalar, b: Scalar) -> Result<Scalar, Obstacle> {
        let (size, arg) = (self.magnitude(a), self.argument(a));
        let ln = Scalar::Complex(self.push(Op::Call(Function::Ln, size)), arg);
        let exponent = self.binary(Binary::Multiply, b, ln)?;
        let (re, im) = self.parts(exponent);
        let size = self.push(Op::Call(Function::Exp, re));
        Ok(self.polar(size, im))
    }

    fn angle(&mut self, y: u32, x: u32) -> u32 {
        let number = self.angles;
        self.angles += 1;
        self.push(Op::Atan2(y, x, number))
    }
}

impl Program {
    /// a − b
    pub fn difference(&mut self, a: Scalar, b: Scalar) -> Scalar {
        if let (Scalar::Real(a), Scalar::Real(b)) = (a, b) {
            return Scalar::Real(self.push(Op::Subtract(a, b)));
        }
        let ((ar, ai), (br, bi)) = (self.parts(a), self.parts(b));
        Scalar::Complex(
            self.push(Op::Subtract(ar, br)),
            self.push(Op::Subtract(ai, bi)),
        )
    }
}

pub(super) fn is_small_integer(x: f64) -> bool {
    x.fract() == 0.0 && x.abs() <= 64.0
}

//! Operators and functions of numbers with uncertainty, also with plain numbers.

use super::Uncertain;
use crate::Number;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

impl From<f64> for Uncertain {
    fn from(value: f64) -> Self {
        Self::exact(value)
    }
}

/// One operator for every pair of owned and borrowed numbers, and for plain numbers on either side.
macro_rules! operator {
    ($Op:ident, $op:ident, $Assign:ident, $assign:ident) => {
        impl $Op<&Uncertain> for &Uncertain {
            type Output = Uncertain;
            fn $op(self, other: &Uncertain) -> Uncertain {
                Uncertain::function([self, other], |[a, b]| $Op::$op(a, b))
            }
        }
        impl $Op<Uncertain> for Uncertain {
            type Output = Uncertain;
            fn $op(self, other: Uncertain) -> Uncertain {
                $Op::$op(&self, &other)
            }
        }
        impl $Op<&Uncertain> for Uncertain {
            type Output = Uncertain;
            fn $op(self, other: &Uncertain) -> Uncertain {
                $Op::$op(&self, other)
            }
        }
        impl $Op<Uncertain> for &Uncertain {
            type Output = Uncertain;
            fn $op(self, other: Uncertain) -> Uncertain {
                $Op::$op(self, &other)
            }
        }
        impl $Op<f64> for Uncertain {
            type Output = Uncertain;
            fn $op(self, other: f64) -> Uncertain {
                $Op::$op(&self, &Uncertain::exact(other))
            }
        }
        impl $Op<f64> for &Uncertain {
            type Output = Uncertain;
            fn $op(self, other: f64) -> Uncertain {
                $Op::$op(self, &Uncertain::exact(other))
            }
        }
        impl $Op<Uncertain> for f64 {
            type Output = Uncertain;
            fn $op(self, other: Uncertain) -> Uncertain {
                $Op::$op(&Uncertain::exact(self), &other)
            }
        }
        impl $Op<&Uncertain> for f64 {
            type Output = Uncertain;
            fn $op(self, other: &Uncertain) -> Uncertain {
                $Op::$op(&Uncertain::exact(self), other)
            }
        }
        impl<T> $Assign<T> for Uncertain
        where
            for<'a> &'a Uncertain: $Op<T, Output = Uncertain>,
        {
            fn $assign(&mut self, other: T) {
                *self = $Op::$op(&*self, other);
            }
        }
    };
}

operator!(Add, add, AddAssign, add_assign);
operator!(Sub, sub, SubAssign, sub_assign);
operator!(Mul, mul, MulAssign, mul_assign);
operator!(Div, div, DivAssign, div_assign);

impl Neg for Uncertain {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Neg for &Uncertain {
    type Output = Uncertain;
    fn neg(self) -> Uncertain {
        self * -1.0
    }
}

impl Sum for Uncertain {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::exact(0.0), |sum, term| sum + term)
    }
}

impl<'a> Sum<&'a Uncertain> for Uncertain {
    fn sum<I: Iterator<Item = &'a Uncertain>>(terms: I) -> Self {
        terms.fold(Self::exact(0.0), |sum, term| sum + term)
    }
}

macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident),+ $(,)?) => {
        impl Uncertain {
            $($(#[$doc])*
            #[must_use]
            pub fn $name(&self) -> Self {
                self.map(Number::$name)
            })+
        }
    };
}

functions! {
    /// eˣ
    exp,
    /// Natural logarithm.
    ln,
    /// Decimal logarithm.
    log10,
    /// Square root.
    sqrt,
    /// Sine, radians.
    sin,
    /// Cosine, radians.
    cos,
    /// Tangent, radians.
    tan,
    /// Arc sine.
    asin,
    /// Arc cosine.
    acos,
    /// Arc tangent.
    atan,
    /// Hyperbolic sine.
    sinh,
    /// Hyperbolic cosine.
    cosh,
    /// Hyperbolic tangent.
    tanh,
    /// Magnitude.
    abs,
}

impl Uncertain {
    /// Integer power.
    #[must_use]
    pub fn powi(&self, n: i32) -> Self {
        self.map(|x| x.powi(n))
    }

    /// Power.
    #[must_use]
    pub fn powf(&self, exponent: &Self) -> Self {
        Self::function([self, exponent], |[x, p]| x.powf(p))
    }

    /// Angle of the vector (x, y) = (`other`, `self`).
    #[must_use]
    pub fn atan2(&self, other: &Self) -> Self {
        Self::function([self, other], |[y, x]| y.atan2(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DegreesOfFreedom;

    #[test]
    fn law_arithmetic_keeps_what_is_common() {
        let x = Uncertain::new("x", 2.0, 0.1).unwrap();
        let zero = &x - &x;
        assert_eq!((zero.value(), zero.standard_uncertainty()), (0.0, 0.0));
        let one = &x / &x;
        assert!((one.value() - 1.0).abs() < 1e-15 && one.standard_uncertainty() < 1e-16);
        let mut y = 3.0 * &x;
        y += 1.0;
        y -= &x;
        y *= 2.0;
        y /= 4.0;
        assert!((y.value() - 2.5).abs() < 1e-15 && (y.standard_uncertainty() - 0.1).abs() < 1e-15);
        let parts: Vec<Uncertain> = (0..4)
            .map(|i| Uncertain::new(format!("part {i}"), 1.0, 0.5).unwrap())
            .collect();
        let sum: Uncertain = parts.iter().sum();
        assert!((sum.standard_uncertainty() - 1.0).abs() < 1e-15);
        assert!((sum.correlation(&parts[0]).unwrap() - 0.5).abs() < 1e-15);
        let e = (-&x).exp().ln() + x.clone();
        assert!(e.value().abs() < 1e-15 && e.standard_uncertainty() < 1e-15);
        let apart = &x - x.independent("another");
        assert!((apart.standard_uncertainty() - 0.1 * 2f64.sqrt()).abs() < 1e-15);
        let four = DegreesOfFreedom::new(4.0).unwrap();
        let v = Uncertain::new("v", 1.0, 0.1).unwrap().dof(four);
        assert_eq!((2.0 * &v).effective_dof(), four);
        assert!(
            Uncertain::new("v", f64::NAN, 0.1).is_err() && Uncertain::new("v", 1.0, -0.1).is_err()
        );
    }
}

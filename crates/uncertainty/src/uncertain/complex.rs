//! Complex numbers with uncertainty.

use super::Uncertain;
use crate::{Dual, Number};
use serde::{Deserialize, Serialize};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A complex number whose parts carry their causes.
///
/// ```
/// use proofmass_uncertainty::{DegreesOfFreedom, Uncertain, UncertainComplex};
/// // V e^{jφ}/I of `[GUM] H.2`, with uncorrelated readings for short.
/// let v = Uncertain::new("V", 4.9990, 0.0032)?;
/// let i = Uncertain::new("I", 19.6610e-3, 9.5e-6)?;
/// let phi = Uncertain::new("phi", 1.04446, 7.5e-4)?;
/// let z = UncertainComplex::from_polar(&v, &phi) / UncertainComplex::from(i);
/// assert!((z.re.value() - 127.732).abs() < 5e-4 && (z.im.value() - 219.847).abs() < 5e-4);
/// // Identity is kept: z·ī/(z·ī) has no uncertainty.
/// let one = &z * z.conj() / (&z * z.conj());
/// assert!(one.re.standard_uncertainty() < 1e-15 && one.im.standard_uncertainty() < 1e-15);
/// // Also through a file.
/// let filed: UncertainComplex = serde_json::from_str(&serde_json::to_string(&z).unwrap()).unwrap();
/// let difference = z - filed;
/// assert_eq!(difference.re.standard_uncertainty(), 0.0);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
///
/// The joint effective degrees of freedom of both parts: [`Estimate::complex_dof`](crate::Estimate::complex_dof).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct UncertainComplex {
    /// Real part.
    pub re: Uncertain,
    /// Imaginary part.
    pub im: Uncertain,
}

impl UncertainComplex {
    /// From its parts.
    pub fn new(re: Uncertain, im: Uncertain) -> Self {
        Self { re, im }
    }

    /// From magnitude and phase in radians.
    pub fn from_polar(magnitude: &Uncertain, phase: &Uncertain) -> Self {
        Self {
            re: Uncertain::function([magnitude, phase], |[r, p]| r * p.cos()),
            im: Uncertain::function([magnitude, phase], |[r, p]| r * p.sin()),
        }
    }

    /// Complex conjugate.
    #[must_use]
    pub fn conj(&self) -> Self {
        Self {
            re: self.re.clone(),
            im: -&self.im,
        }
    }

    /// Magnitude.
    pub fn abs(&self) -> Uncertain {
        let size = self.re.value().hypot(self.im.value());
        if size == 0.0 {
            // As |a| is taken from the right at zero.
            return Uncertain::function([&self.re, &self.im], |[a, _]| a);
        }
        Uncertain::function([&self.re, &self.im], |[a, b]| {
            let (a, b) = (a / Dual::from(size), b / Dual::from(size));
            (a * a + b * b).sqrt() * Dual::from(size)
        })
    }

    /// Phase in radians.
    pub fn arg(&self) -> Uncertain {
        self.im.atan2(&self.re)
    }

    /// eᶻ
    #[must_use]
    pub fn exp(&self) -> Self {
        Self::from_polar(&self.re.exp(), &self.im)
    }

    /// Principal natural logarithm.
    #[must_use]
    pub fn ln(&self) -> Self {
        Self {
            re: self.abs().ln(),
            im: self.arg(),
        }
    }

    /// Principal square root.
    #[must_use]
    pub fn sqrt(&self) -> Self {
        Self::from_polar(&self.abs().sqrt(), &(self.arg() * 0.5))
    }

    /// Integer power.
    #[must_use]
    pub fn powi(&self, n: i32) -> Self {
        let one = || Self::from(Uncertain::exact(1.0));
        let product = (0..n.unsigned_abs()).fold(one(), |product, _| &product * self);
        if n < 0 { one() / product } else { product }
    }
}

impl From<Uncertain> for UncertainComplex {
    fn from(re: Uncertain) -> Self {
        Self {
            re,
            im: Uncertain::exact(0.0),
        }
    }
}

impl Neg for UncertainComplex {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            re: -self.re,
            im: -self.im,
        }
    }
}

/// An operator for every pair of owned and borrowed numbers.
macro_rules! operator {
    ($Op:ident, $op:ident, |$a:ident, $b:ident| $result:expr) => {
        impl $Op<&UncertainComplex> for &UncertainComplex {
            type Output = UncertainComplex;
            fn $op(self, other: &UncertainComplex) -> UncertainComplex {
                let ($a, $b) = (self, other);
                $result
            }
        }
        impl $Op<UncertainComplex> for &UncertainComplex {
            type Output = UncertainComplex;
            fn $op(self, other: UncertainComplex) -> UncertainComplex {
                $Op::$op(self, &other)
            }
        }
        impl $Op<&UncertainComplex> for UncertainComplex {
            type Output = UncertainComplex;
            fn $op(self, other: &UncertainComplex) -> UncertainComplex {
                $Op::$op(&self, other)
            }
        }
        impl $Op<UncertainComplex> for UncertainComplex {
            type Output = UncertainComplex;
            fn $op(self, other: UncertainComplex) -> UncertainComplex {
                $Op::$op(&self, &other)
            }
        }
    };
}

operator!(Add, add, |a, b| UncertainComplex {
    re: &a.re + &b.re,
    im: &a.im + &b.im,
});
operator!(Sub, sub, |a, b| UncertainComplex {
    re: &a.re - &b.re,
    im: &a.im - &b.im,
});
operator!(Mul, mul, |a, b| UncertainComplex {
    re: &a.re * &b.re - &a.im * &b.im,
    im: &a.re * &b.im + &a.im * &b.re,
});
operator!(Div, div, |a, b| {
    // By the larger part first, so that no square overflows.
    let size = b.re.value().abs().max(b.im.value().abs());
    let (c, d) = (&b.re / size, &b.im / size);
    let square = (&c * &c + &d * &d) * size;
    UncertainComplex {
        re: (&a.re * &c + &a.im * &d) / &square,
        im: (&a.im * &c - &a.re * &d) / &square,
    }
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_functions_of_a_complex_number() {
        let z = UncertainComplex::new(
            Uncertain::new("a", 3.0, 0.01).unwrap(),
            Uncertain::new("b", -4.0, 0.02).unwrap(),
        );
        let close = |a: &UncertainComplex, re: f64, im: f64| {
            assert!(
                (a.re.value() - re).abs() < 1e-14 && (a.im.value() - im).abs() < 1e-14,
                "{a:?}"
            );
        };
        close(&z.sqrt(), 2.0, -1.0);
        close(&z.powi(2), -7.0, -24.0);
        close(&z.powi(-1), 0.12, 0.16);
        close(&(z.ln().exp() - &z), 0.0, 0.0);
        assert!((z.ln().exp() - &z).re.standard_uncertainty() < 1e-15);
        // u²(|z|) = (3·0.01/5)² + (4·0.02/5)²
        let u = z.abs().standard_uncertainty();
        assert!((u - 0.006f64.hypot(0.016)).abs() < 1e-15);
        // dz²/da = 2z: contributions 6·0.01 and 8·0.02 to the real part.
        let u = z.powi(2).re.standard_uncertainty();
        assert!((u - 0.06f64.hypot(0.16)).abs() < 1e-15);
    }
}

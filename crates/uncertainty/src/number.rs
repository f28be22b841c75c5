//! The number a model is written in: plain, or carrying its derivatives along.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// xⁿ by squaring; `one` is the 1 of its kind.
fn power<T: Copy + Mul<Output = T> + Div<Output = T>>(x: T, one: T, n: i32) -> T {
    let mut result = one;
    let mut base = x;
    let mut left = n.unsigned_abs();
    while left > 0 {
        if left & 1 == 1 {
            result = result * base;
        }
        left >>= 1;
        if left > 0 {
            base = base * base;
        }
    }
    if n < 0 { one / result } else { result }
}

/// What arithmetic a model may use. Write the model once over `T: Number`; it then runs on `f64` for its value
/// and for Monte Carlo, and on [`Dual`] for its derivatives.
///
/// ```
/// use proofmass_uncertainty::{Dual, Number};
/// fn f<T: Number>(x: T) -> T { x * x.sin() }
/// let y = f(Dual::<f64, 1>::variable(2.0, 0));
/// assert!((y.partials[0] - (2f64.sin() + 2.0 * 2f64.cos())).abs() < 1e-15);
/// ```
pub trait Number:
    Copy
    + Send
    + Sync
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + From<f64>
{
    /// The plain value, for comparisons.
    fn value(self) -> f64;
    /// Whether it is zero with all of its derivatives.
    fn vanishes(self) -> bool {
        self.value() == 0.0
    }

    /// eˣ
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine, radians.
    fn sin(self) -> Self;
    /// Cosine, radians.
    fn cos(self) -> Self;
    /// Arc sine.
    fn asin(self) -> Self;
    /// Arc cosine.
    fn acos(self) -> Self;
    /// Arc tangent.
    fn atan(self) -> Self;
    /// Hyperbolic sine.
    fn sinh(self) -> Self;
    /// Hyperbolic cosine.
    fn cosh(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Decimal logarithm.
    fn log10(self) -> Self {
        self.ln() / Self::from(std::f64::consts::LN_10)
    }
    /// Tangent, radians.
    fn tan(self) -> Self {
        self.sin() / self.cos()
    }
    /// Angle of the vector (x, y) = (`other`, `self`), in all four quadrants.
    fn atan2(self, other: Self) -> Self {
        // The branch with the smaller quotient has a finite derivative; a constant takes it to its quadrant.
        let angle = self.value().atan2(other.value());
        let smooth = if other.value().abs() >= self.value().abs() {
            (self / other).atan()
        } else {
            -(other / self).atan()
        };
        smooth + Self::from(angle - smooth.value())
    }
    /// Magnitude; at zero its derivative is taken from the right.
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }
    /// Integer power.
    fn powi(self, n: i32) -> Self {
        power(self, Self::from(1.0), n)
    }
    /// Real power of a positive number.
    fn powf(self, exponent: Self) -> Self {
        (exponent * self.ln()).exp()
    }
}

impl Number for f64 {
    #[inline]
    fn value(self) -> f64 {
        self
    }
    #[inline]
    fn exp(self) -> Self {
        f64::exp(self)
    }
    #[inline]
    fn ln(self) -> Self {
        f64::ln(self)
    }
    #[inline]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline]
    fn sin(self) -> Self {
        f64::sin(self)
    }
    #[inline]
    fn cos(self) -> Self {
        f64::cos(self)
    }
    #[inline]
    fn asin(self) -> Self {
        f64::asin(self)
    }
    #[inline]
    fn acos(self) -> Self {
        f64::acos(self)
    }
    #[inline]
    fn atan(self) -> Self {
        f64::atan(self)
    }
    #[inline]
    fn sinh(self) -> Self {
        f64::sinh(self)
    }
    #[inline]
    fn cosh(self) -> Self {
        f64::cosh(self)
    }
    #[inline]
    fn tanh(self) -> Self {
        f64::tanh(self)
    }
    fn atan2(self, other: Self) -> Self {
        f64::atan2(self, other)
    }
    fn tan(self) -> Self {
        f64::tan(self)
    }
    fn log10(self) -> Self {
        f64::log10(self)
    }
    fn powf(self, exponent: Self) -> Self {
        f64::powf(self, exponent)
    }
}

/// A number with N partial derivatives: forward automatic differentiation.
///
/// `Dual<f64, N>` carries first derivatives; `Dual<Dual<f64, 1>, 1>` second ones.
#[doc(alias("automatic differentiation"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Dual<T, const N: usize> {
    /// The value.
    pub real: T,
    /// Its partial derivatives.
    pub partials: [T; N],
}

impl<T: Number, const N: usize> Dual<T, N> {
    /// The variable whose derivative stands at place `index`; a constant when `index` ≥ N.
    #[inline]
    pub fn variable(real: T, index: usize) -> Self {
        let partials = std::array::from_fn(|i| T::from(if i == index { 1.0 } else { 0.0 }));
        Self { real, partials }
    }

    #[inline]
    fn map(self, real: T, factor: T) -> Self {
        Self {
            real,
            partials: self.partials.map(|p| p * factor),
        }
    }
}

/// Element by element, in place: a loop over a copied array is what the compiler vectorises best.
#[inline(always)]
fn zip<T: Copy, const N: usize>(mut a: [T; N], b: &[T; N], f: impl Fn(T, T) -> T) -> [T; N] {
    for (a, b) in a.iter_mut().zip(b) {
        *a = f(*a, *b);
    }
    a
}

impl<T: Number, const N: usize> From<f64> for Dual<T, N> {
    #[inline(always)]
    fn from(x: f64) -> Self {
        Self {
            real: T::from(x),
            partials: [T::from(0.0); N],
        }
    }
}

impl<T: Number, const N: usize> Neg for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            real: -self.real,
            partials: self.partials.map(|p| -p),
        }
    }
}

impl<T: Number, const N: usize> Add for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            real: self.real + other.real,
            partials: zip(self.partials, &other.partials, |a, b| a + b),
        }
    }
}

impl<T: Number, const N: usize> Sub for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            real: self.real - other.real,
            partials: zip(self.partials, &other.partials, |a, b| a - b),
        }
    }
}

#[allow(
    clippy::suspicious_arithmetic_impl,
    reason = "the product rule is a sum"
)]
impl<T: Number, const N: usize> Mul for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self {
            real: self.real * other.real,
            partials: zip(self.partials, &other.partials, |a, b| {
                a * other.real + self.real * b
            }),
        }
    }
}

impl<T: Number, const N: usize> Div for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = T::from(1.0) / other.real;
        let real = self.real * inverse;
        Self {
            real,
            partials: zip(self.partials, &other.partials, |a, b| {
                (a - real * b) * inverse
            }),
        }
    }
}

impl<T: Number, const N: usize> Number for Dual<T, N> {
    #[inline(always)]
    fn value(self) -> f64 {
        self.real.value()
    }
    fn vanishes(self) -> bool {
        self.real.vanishes() && self.partials.iter().all(|p| p.vanishes())
    }
    fn exp(self) -> Self {
        let e = self.real.exp();
        self.map(e, e)
    }
    fn ln(self) -> Self {
        self.map(self.real.ln(), T::from(1.0) / self.real)
    }
    fn sqrt(self) -> Self {
        let root = self.real.sqrt();
        self.map(root, T::from(0.5) / root)
    }
    fn sin(self) -> Self {
        self.map(self.real.sin(), self.real.cos())
    }
    fn cos(self) -> Self {
        self.map(self.real.cos(), -self.real.sin())
    }
    fn asin(self) -> Self {
        let slope = T::from(1.0) / (T::from(1.0) - self.real * self.real).sqrt();
        self.map(self.real.asin(), slope)
    }
    fn acos(self) -> Self {
        let slope = T::from(1.0) / (T::from(1.0) - self.real * self.real).sqrt();
        self.map(self.real.acos(), -slope)
    }
    fn atan(self) -> Self {
        self.map(
            self.real.atan(),
            T::from(1.0) / (T::from(1.0) + self.real * self.real),
        )
    }
    fn sinh(self) -> Self {
        self.map(self.real.sinh(), self.real.cosh())
    }
    fn cosh(self) -> Self {
        self.map(self.real.cosh(), self.real.sinh())
    }
    fn tanh(self) -> Self {
        let t = self.real.tanh();
        self.map(t, T::from(1.0) - t * t)
    }
    fn powi(self, n: i32) -> Self {
        if n == 0 {
            return Self::from(1.0);
        }
        let lower = self.real.powi(n.saturating_sub(1));
        self.map(lower * self.real, lower * T::from(f64::from(n)))
    }
    fn powf(self, exponent: Self) -> Self {
        let p = exponent.real;
        let constant = exponent.partials.iter().all(|p| p.vanishes());
        if constant || self.value() <= 0.0 {
            // xᵖ has a derivative at x ≤ 0 for whole p, and at 0 for p ≥ 1, although ln x has none.
            let lower = p * self.real.powf(p - T::from(1.0));
            let value = self.real.powf(p);
            let by_exponent = value * self.real.ln();
            let mut result = self.map(value, lower);
            for (out, by) in result.partials.iter_mut().zip(exponent.partials) {
                if !by.vanishes() {
                    *out = *out + by * by_exponent;
                }
            }
            return result;
        }
        (exponent * self.ln()).exp()
    }
}

/// A complex number over any [`Number`]: two real components whose derivatives are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Complex<T> {
    /// Real part.
    pub re: T,
    /// Imaginary part.
    pub im: T,
}

impl<T: Number> Complex<T> {
    /// From real and imaginary parts.
    pub fn new(re: T, im: T) -> Self {
        Self { re, im }
    }
    /// From magnitude and angle.
    pub fn from_polar(magnitude: T, angle: T) -> Self {
        Self::new(magnitude * angle.cos(), magnitude * angle.sin())
    }
    /// Complex conjugate.
    pub fn conj(self) -> Self {
        Self::new(self.re, -self.im)
    }
    /// Squared magnitude.
    pub fn norm_squared(self) -> T {
        self.re * self.re + self.im * self.im
    }
    /// Magnitude.
    pub fn abs(self) -> T {
        self.norm_squared().sqrt()
    }
    /// Angle in radians.
    pub fn arg(self) -> T {
        self.im.atan2(self.re)
    }
    /// e to this power.
    pub fn exp(self) -> Self {
        Self::from_polar(self.re.exp(), self.im)
    }
    /// Natural logarithm, its imaginary part in (−π, π].
    pub fn ln(self) -> Self {
        Self::new(self.norm_squared().ln() * T::from(0.5), self.arg())
    }
    /// Square root, its real part not negative; it has no derivative at zero.
    pub fn sqrt(self) -> Self {
        let half = T::from(0.5);
        let size = self.abs();
        // The larger part without cancellation, the other from 2 re im = Im z.
        if self.re.value() >= 0.0 {
            let re = ((size + self.re) * half).sqrt();
            Self::new(re, self.im * half / re)
        } else {
            let im = ((size - self.re) * half).sqrt();
            let im = if self.im.value() < 0.0 { -im } else { im };
            Self::new(self.im * half / im, im)
        }
    }
    /// Integer power.
    pub fn powi(self, n: i32) -> Self {
        power(self, Self::new(T::from(1.0), T::from(0.0)), n)
    }
}

impl<T: Number> Neg for Complex<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.re, -self.im)
    }
}

impl<T: Number> Mul<T> for Complex<T> {
    type Output = Self;
    fn mul(self, factor: T) -> Self {
        Self::new(self.re * factor, self.im * factor)
    }
}

impl<T: Number> Div<T> for Complex<T> {
    type Output = Self;
    fn div(self, divisor: T) -> Self {
        Self::new(self.re / divisor, self.im / divisor)
    }
}

impl<T: Number> Add for Complex<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }
}

impl<T: Number> Sub for Complex<T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.re - other.re, self.im - other.im)
    }
}

impl<T: Number> Mul for Complex<T> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::new(
            self.re * other.re - self.im * other.im,
            self.re * other.im + self.im * other.re,
        )
    }
}

impl<T: Number> Div for Complex<T> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let scale = other.norm_squared();
        let product = self * other.conj();
        Self::new(product.re / scale, product.im / scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Second = Dual<Dual<f64, 1>, 1>;

    /// Every function against central differences: step h leaves h² f‴/6 + ε/h, below 1e-8 at h = 1e-5.
    #[test]
    fn law_derivatives_equal_differences() {
        fn functions<T: Number>(x: T) -> Vec<T> {
            vec![
                x.exp(),
                x.ln(),
                x.log10(),
                x.sqrt(),
                x.sin(),
                x.cos(),
                x.tan(),
                x.asin(),
                x.acos(),
                x.atan(),
                x.sinh(),
                x.cosh(),
                x.tanh(),
                x.atan2(T::from(2.0)),
                T::from(-0.2).atan2(-x),
                x.powi(3),
                x.powi(-2),
                x.powf(T::from(2.5)),
                x.powf(x),
                (T::from(0.0) - x).abs(),
                T::from(1.0) / (x * x - x),
            ]
        }
        let (x, h) = (0.4, 1e-5);
        let dual = functions(Dual::<f64, 1>::variable(x, 0));
        let second = functions(Second::variable(Dual::variable(x, 0), 0));
        let (up, mid, down) = (functions(x + h), functions(x), functions(x - h));
        let (slope_up, slope_down) = (
            functions(Dual::<f64, 1>::variable(x + h, 0)),
            functions(Dual::<f64, 1>::variable(x - h, 0)),
        );
        for i in 0..mid.len() {
            let first = (up[i] - down[i]) / (2.0 * h);
            let scale = 1.0 + mid[i].abs() + first.abs();
            assert!((dual[i].real - mid[i]).abs() < 1e-14 * scale, "{i}");
            assert!((dual[i].partials[0] - first).abs() < 1e-6 * scale, "{i}");
            let curvature = (slope_up[i].partials[0] - slope_down[i].partials[0]) / (2.0 * h);
            let got = second[i].partials[0].partials[0];
            assert!(
                (got - curvature).abs() < 1e-5 * (scale + curvature.abs()),
                "{i}: {got} {curvature}"
            );
        }
    }

    #[test]
    fn known_complex_arithmetic() {
        let z = Complex::new(3.0, 4.0);
        assert_eq!((z.abs(), (z / z).re, (z / z).im), (5.0, 1.0, 0.0));
        assert!((Complex::from_polar(2.0, 0.5).arg() - 0.5).abs() < 1e-15);
        for z in [z, -z, z.conj(), -z.conj(), Complex::new(-2.0, 1e-9)] {
            let root = z.sqrt();
            assert!((root * root / z - Complex::new(1.0, 0.0)).abs() < 1e-15 && root.re >= 0.0);
            assert!((z.ln().exp() / z - Complex::new(1.0, 0.0)).abs() < 1e-15);
            assert!((z.powi(3) * z.powi(-2) / z - Complex::new(1.0, 0.0)).abs() < 1e-14);
        }
        assert_eq!((z * 2.0).im, 8.0);
    }
}

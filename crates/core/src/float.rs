//! The two floating-point types everything in this crate runs on.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32` on a chip with a single-precision unit, `f64` on the desk.
///
/// Functions come from `libm`, so that the same bits come out on the desk and on the chip.
pub trait Float:
    sealed::Sealed
    + Copy
    + Debug
    + Default
    + PartialOrd
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + SubAssign
    + Mul<Output = Self>
    + MulAssign
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Distance from one to the next larger number.
    const EPSILON: Self;

    /// The nearest number of this type.
    fn from_f64(value: f64) -> Self;
    /// The number in double precision.
    fn to_f64(self) -> f64;
    /// The nearest number of this type, without a detour over double precision.
    fn from_i32(value: i32) -> Self;
    /// The nearest number of this type, without a detour over double precision.
    fn from_u32(value: u32) -> Self;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine of an angle in radians.
    fn sin(self) -> Self;
    /// Cosine of an angle in radians.
    fn cos(self) -> Self;
    /// Sine and cosine of an angle in radians.
    ///
    /// In single precision without a detour over double precision, which a chip's single-precision unit does not have.
    ///
    /// **Accuracy** of `f32` 1.2e-7 up to 8192 rad, beyond as [`Float::sin`]. **Source** `[Moshier89]`.
    fn sin_cos(self) -> (Self, Self);
    /// Tangent of an angle in radians.
    fn tan(self) -> Self;
    /// Angle of the point (`x`, `self`) in radians.
    fn atan2(self, x: Self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
}

macro_rules! float {
    ($type:ty, $sqrt:path, $fabs:path, $sin:path, $cos:path, $both:path, $tan:path, $atan2:path, $exp:path) => {
        impl Float for $type {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = <$type>::EPSILON;

            fn from_f64(value: f64) -> Self {
                value as $type
            }
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            fn from_i32(value: i32) -> Self {
                value as $type
            }
            fn from_u32(value: u32) -> Self {
                value as $type
            }
            fn is_finite(self) -> bool {
                <$type>::is_finite(self)
            }
            fn abs(self) -> Self {
                $fabs(self)
            }
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            fn sin(self) -> Self {
                $sin(self)
            }
            fn cos(self) -> Self {
                $cos(self)
            }
            fn sin_cos(self) -> (Self, Self) {
                $both(self)
            }
            fn tan(self) -> Self {
                $tan(self)
            }
            fn atan2(self, x: Self) -> Self {
                $atan2(self, x)
            }
            fn exp(self) -> Self {
                $exp(self)
            }
        }
    };
}

float!(
    f32,
    libm::sqrtf,
    libm::fabsf,
    libm::sinf,
    libm::cosf,
    sin_cos_single,
    libm::tanf,
    libm::atan2f,
    libm::expf
);
float!(
    f64,
    libm::sqrt,
    libm::fabs,
    libm::sin,
    libm::cos,
    libm::sincos,
    libm::tan,
    libm::atan2,
    libm::exp
);

/// Sine and cosine by polynomials within an eighth of a turn, the angle reduced by quarter turns in three parts.
fn sin_cos_single(x: f32) -> (f32, f32) {
    const PARTS: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
    // Beyond it the first two products are not exact.
    if !(x.abs() <= 8192.0) {
        return (libm::sinf(x), libm::cosf(x));
    }
    let half = if x < 0.0 { -0.5 } else { 0.5 };
    let quarters = (x * core::f32::consts::FRAC_2_PI + half) as i32;
    let n = quarters as f32;
    let r = ((x - n * PARTS[0]) - n * PARTS[1]) - n * PARTS[2];
    let z = r * r;
    let sine = r + r * z * (-1.666_665_5e-1 + z * (8.332_161e-3 - z * 1.951_529_6e-4));
    let cosine =
        1.0 - 0.5 * z + z * z * (4.166_664_6e-2 + z * (-1.388_731_6e-3 + z * 2.443_315_7e-5));
    match quarters & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crosscheck_single_sine_and_cosine() {
        let mut worst = 0.0f64;
        for k in -400_000i32..=400_000 {
            for x in [k as f32 * 1e-5, k as f32 * 0.020_48] {
                let (s, c) = Float::sin_cos(x);
                let angle = f64::from(x);
                worst = worst
                    .max((f64::from(s) - angle.sin()).abs())
                    .max((f64::from(c) - angle.cos()).abs());
            }
        }
        assert!(worst < 1.2e-7, "{worst:e}");
        assert_eq!(Float::sin_cos(0.0f32), (0.0, 1.0));
        for x in [9000.0f32, -1e30] {
            assert_eq!(Float::sin_cos(x), (libm::sinf(x), libm::cosf(x)));
        }
        assert!(Float::sin_cos(f32::NAN).0.is_nan() && Float::sin_cos(f32::INFINITY).1.is_nan());
    }
}

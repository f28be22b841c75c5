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
    /// Tangent of an angle in radians.
    fn tan(self) -> Self;
    /// Angle of the point (`x`, `self`) in radians.
    fn atan2(self, x: Self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
}

macro_rules! float {
    ($type:ty, $sqrt:path, $fabs:path, $sin:path, $cos:path, $tan:path, $atan2:path, $exp:path) => {
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
    libm::tan,
    libm::atan2,
    libm::exp
);

//! Trials side by side: numbers and complex numbers of as many trials as a vector register holds.
//!
//! No operation reaches from one trial into another and none is fused, so that the bits of a trial depend neither on
//! its neighbours nor on the width of the register.

use num_complex::Complex64;
use pulp::Simd;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// Trials in the widest register there is.
pub(super) const WIDEST: usize = 8;
/// Angles up to which the series below hold, rad.
const SMALL: f64 = 0.1;

/// A real number of every trial.
#[derive(Clone, Copy)]
pub(super) struct Real<S: Simd> {
    simd: S,
    lanes: S::f64s,
}

/// A complex number of every trial.
#[derive(Clone, Copy)]
pub(super) struct Complex<S: Simd> {
    pub(super) re: Real<S>,
    pub(super) im: Real<S>,
}

/// A rotation of axes.
pub(super) type Rotation<S> = [[Real<S>; 3]; 3];

/// What a motion along one axis is: a complex number, or a real one where everything moves in phase with the table.
///
/// Inner products with a real motion need nothing but the real part of the other side.
pub(super) trait Motion<S: Simd>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Real<S>, Output = Self>
{
    /// As much of a complex number as there is of a motion.
    fn of(z: Complex<S>) -> Self;
    /// The product.
    fn times(self, z: Complex<S>) -> Complex<S>;
    /// Real part of the product.
    fn inner(self, other: Self) -> Real<S>;
}

impl<S: Simd> Motion<S> for Real<S> {
    #[inline(always)]
    fn of(z: Complex<S>) -> Self {
        z.re
    }
    #[inline(always)]
    fn times(self, z: Complex<S>) -> Complex<S> {
        z * self
    }
    #[inline(always)]
    fn inner(self, other: Self) -> Self {
        self * other
    }
}

impl<S: Simd> Motion<S> for Complex<S> {
    #[inline(always)]
    fn of(z: Self) -> Self {
        z
    }
    #[inline(always)]
    fn times(self, z: Self) -> Self {
        self * z
    }
    #[inline(always)]
    fn inner(self, other: Self) -> Real<S> {
        self.re * other.re - self.im * other.im
    }
}

impl<S: Simd> Real<S> {
    /// The same in every trial.
    #[inline(always)]
    pub(super) fn new(simd: S, x: f64) -> Self {
        let lanes = simd.splat_f64s(x);
        Self { simd, lanes }
    }

    /// One value per trial; where there are fewer than a register holds, zeros follow.
    #[inline(always)]
    pub(super) fn load(simd: S, x: &[f64]) -> Self {
        let lanes = match S::as_simd_f64s(x).0 {
            [whole, ..] => *whole,
            [] => simd.partial_load_f64s(x),
        };
        Self { simd, lanes }
    }

    /// The values of the first trials.
    #[inline(always)]
    pub(super) fn store(self, x: &mut [f64]) {
        match S::as_mut_simd_f64s(x).0 {
            [whole, ..] => *whole = self.lanes,
            [] => self.simd.partial_store_f64s(x, self.lanes),
        }
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        let lanes = self.simd.abs_f64s(self.lanes);
        Self { lanes, ..self }
    }

    #[inline(always)]
    pub(super) fn max(self, other: Self) -> Self {
        let lanes = self.simd.max_f64s(self.lanes, other.lanes);
        Self { lanes, ..self }
    }

    /// Of two numbers this one in the trials where `choice` is zero, else the other.
    #[inline(always)]
    pub(super) fn unless(self, choice: Self, other: Self) -> Self {
        let zero = self.simd.splat_f64s(0.0);
        let mine = self.simd.equal_f64s(choice.lanes, zero);
        let lanes = self.simd.select_f64s(mine, self.lanes, other.lanes);
        Self { lanes, ..self }
    }

    /// Two functions of an angle by their series, and exactly in the trials in which the angle is not small.
    #[inline(always)]
    fn exact(self, series: Complex<S>, exact: fn(f64) -> Complex64) -> Complex<S> {
        let simd = self.simd;
        let large =
            simd.not_m64s(simd.less_than_or_equal_f64s(self.abs().lanes, simd.splat_f64s(SMALL)));
        if simd.first_true_m64s(large) < S::F64_LANES {
            return self.one_by_one(series, exact);
        }
        series
    }

    #[cold]
    #[inline(never)]
    fn one_by_one(self, series: Complex<S>, exact: fn(f64) -> Complex64) -> Complex<S> {
        let [mut x, mut re, mut im] = [[0.0; WIDEST]; 3];
        self.store(&mut x[..S::F64_LANES]);
        series.re.store(&mut re[..S::F64_LANES]);
        series.im.store(&mut im[..S::F64_LANES]);
        for ((x, re), im) in x.iter().zip(&mut re).zip(&mut im) {
            if !(x.abs() <= SMALL) {
                let z = exact(*x);
                (*re, *im) = (z.re, z.im);
            }
        }
        Complex {
            re: Self::load(self.simd, &re[..S::F64_LANES]),
            im: Self::load(self.simd, &im[..S::F64_LANES]),
        }
    }

    /// e^{jx}; by its series to 2e-11 where x is as small as an error is.
    #[inline(always)]
    pub(super) fn turn(self) -> Complex<S> {
        let q = self * self;
        let series = Complex {
            re: ((q * (-1.0 / 720.0) + 1.0 / 24.0) * q + -0.5) * q + 1.0,
            im: ((q * (1.0 / 120.0) + -1.0 / 6.0) * q + 1.0) * self,
        };
        self.exact(series, |x| Complex64::from_polar(1.0, x))
    }
}

impl<S: Simd> Complex<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, z: Complex64) -> Self {
        Self {
            re: Real::new(simd, z.re),
            im: Real::new(simd, z.im),
        }
    }

    #[inline(always)]
    pub(super) fn conj(self) -> Self {
        Self {
            im: -self.im,
            ..self
        }
    }

    /// Adds c x.
    #[inline(always)]
    pub(super) fn add_times(&mut self, c: Complex64, x: Real<S>) {
        self.re += x * c.re;
        self.im += x * c.im;
    }

    /// 1/z.
    #[inline(always)]
    pub(super) fn reciprocal(self) -> Self {
        let square = self.re * self.re + self.im * self.im;
        let one = Real::new(square.simd, 1.0);
        let lanes = square.simd.div_f64s(one.lanes, square.lanes);
        self.conj() * Real { lanes, ..square }
    }
}

/// The same motion in every trial.
#[inline(always)]
pub(super) fn motion<S: Simd, M: Motion<S>>(simd: S, [x, y, z]: [Complex64; 3]) -> [M; 3] {
    [
        M::of(Complex::new(simd, x)),
        M::of(Complex::new(simd, y)),
        M::of(Complex::new(simd, z)),
    ]
}

/// e · m.
#[inline(always)]
fn along<S: Simd, M: Motion<S>>(e: &[M; 3], m: &[Real<S>; 3]) -> M {
    e[0] * m[0] + e[1] * m[1] + e[2] * m[2]
}

/// m e.
#[inline(always)]
pub(super) fn turned<S: Simd, M: Motion<S>>(m: &Rotation<S>, e: &[M; 3]) -> [M; 3] {
    [along(e, &m[0]), along(e, &m[1]), along(e, &m[2])]
}

/// mᵀ e.
#[inline(always)]
pub(super) fn turned_back<S: Simd, M: Motion<S>>(m: &Rotation<S>, e: &[M; 3]) -> [M; 3] {
    let [x, y, z] = m;
    let m = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
    turned(&m, e)
}

/// e · s, complex.
#[inline(always)]
pub(super) fn response<S: Simd, M: Motion<S>>(e: &[M; 3], s: [Complex<S>; 3]) -> Complex<S> {
    e[0].times(s[0]) + e[1].times(s[1]) + e[2].times(s[2])
}

/// Sine and cosine of an angle, given those of the angle as drawn, with an error x.
#[inline(always)]
fn plus<S: Simd>((s, c): (f64, f64), x: Real<S>) -> (Real<S>, Real<S>) {
    let d = x.turn();
    (d.re * s + d.im * c, d.re * c - d.im * s)
}

/// Rotation of a wedge and a gluing, of which sine and cosine of the angles as drawn are given, with errors of both.
#[inline(always)]
pub(super) fn wedge<S: Simd>(
    drawn: [(f64, f64); 2],
    alpha: Real<S>,
    omega: Real<S>,
) -> Rotation<S> {
    let ((sa, ca), (sw, cw)) = (plus(drawn[0], alpha), plus(drawn[1], omega));
    [
        [ca * cw, -sw, sa * cw],
        [ca * sw, cw, sa * sw],
        [-sa, Real::new(alpha.simd, 0.0), ca],
    ]
}

/// Q(ℓ) e for e^{jℓ}: a wedge that leans.
#[inline(always)]
pub(super) fn leaning<S: Simd, M: Motion<S>>(w: Complex<S>, e: &[M; 3]) -> [M; 3] {
    [e[0], e[1] * w.re + e[2] * w.im, e[2] * w.re - e[1] * w.im]
}

/// exp(−[θ]×) for θ = (x, y, 0), as [`crate::geometry`] has it.
#[inline(always)]
pub(super) fn tilted<S: Simd>([x, y]: [Real<S>; 2]) -> Rotation<S> {
    let q = x * x + y * y;
    let t = Real {
        lanes: q.simd.sqrt_f64s(q.lanes),
        ..q
    };
    let series = Complex {
        re: ((q * (-1.0 / 5040.0) + 1.0 / 120.0) * q + -1.0 / 6.0) * q + 1.0,
        im: ((q * (-1.0 / 40320.0) + 1.0 / 720.0) * q + -1.0 / 24.0) * q + 0.5,
    };
    let Complex { re: a, im: b } = t.exact(series, |t| {
        Complex64::new(t.sin() / t, (1.0 - t.cos()) / (t * t))
    });
    [
        [-(b * y * y) + 1.0, b * x * y, -(a * y)],
        [b * x * y, -(b * x * x) + 1.0, a * x],
        [a * y, -(a * x), -(b * q) + 1.0],
    ]
}

macro_rules! elementwise {
    ($($of:ident $name:ident $f:ident),*) => {$(
        impl<S: Simd> $of for Real<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let lanes = self.simd.$f(self.lanes, other.lanes);
                Self { lanes, ..self }
            }
        }
        impl<S: Simd> $of<f64> for Real<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: f64) -> Self {
                let lanes = self.simd.$f(self.lanes, self.simd.splat_f64s(other));
                Self { lanes, ..self }
            }
        }
    )*};
}

elementwise!(Add add add_f64s, Sub sub sub_f64s, Mul mul mul_f64s);

impl<S: Simd> Neg for Real<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let lanes = self.simd.neg_f64s(self.lanes);
        Self { lanes, ..self }
    }
}

impl<S: Simd> AddAssign for Real<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> Add for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }
}

impl<S: Simd> Sub for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            re: self.re - other.re,
            im: self.im - other.im,
        }
    }
}

impl<S: Simd> Mul for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

impl<S: Simd> Mul<Real<S>> for Complex<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Real<S>) -> Self {
        Self {
            re: self.re * other,
            im: self.im * other,
        }
    }
}

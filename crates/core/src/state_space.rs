//! The filter behind every estimator that knows a covariance, and the way back of its smoother: models give F, Q, h and R.
//!
//! x' = F x + u + w with w of covariance Q; readings are scalars z = hᵀ x + v with v of variance R. States are few and their number
//! is fixed, so that all of it runs on a chip.
//!
//! **Source** `[BarShalom01]` ch. 5; `[Bierman73]` for the smoother.

// Matrix algebra reads by its indices.
#![allow(clippy::needless_range_loop)]

use crate::Float;

/// What a scalar reading shows of a state: hᵀ x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading<T, const N: usize> {
    /// One state as it is: h is a unit vector.
    State(usize),
    /// The combination with this h.
    Combination([T; N]),
}

impl<T: Float, const N: usize> Reading<T, N> {
    /// hᵀ x.
    #[inline(always)]
    pub fn of(&self, x: &[T; N]) -> T {
        match self {
            Self::State(c) => x[*c],
            Self::Combination(h) => (0..N).fold(T::ZERO, |s, i| s + x[i] * h[i]),
        }
    }

    /// x + h · `by`.
    #[inline]
    fn add(&self, x: &mut [T; N], by: T) {
        match self {
            Self::State(c) => x[*c] += by,
            Self::Combination(h) => (0..N).for_each(|i| x[i] += h[i] * by),
        }
    }
}

/// What a reading said about the prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Innovation<T> {
    /// Reading minus its prediction.
    pub value: T,
    /// Its variance S as predicted.
    pub variance: T,
}

impl<T: Float> Innovation<T> {
    /// ν²/S: chi-square with one degree of freedom for a matched model.
    pub fn normalised_squared(&self) -> T {
        self.value * self.value / self.variance
    }
}

/// The mean one step later, F x + u.
#[inline]
pub fn predict<T: Float, const N: usize>(f: &[[T; N]; N], x: &[T; N], input: [T; N]) -> [T; N] {
    let mut next = input;
    for i in 0..N {
        for k in 0..N {
            next[i] += f[i][k] * x[k];
        }
    }
    next
}

/// The covariance one step later, F P Fᵀ + Q.
#[inline]
pub fn predict_covariance<T: Float, const N: usize>(
    f: &[[T; N]; N],
    p: &[[T; N]; N],
    q: &[[T; N]; N],
) -> [[T; N]; N] {
    let mut fp = [[T::ZERO; N]; N];
    for i in 0..N {
        for k in 0..N {
            for j in 0..N {
                fp[i][j] += f[i][k] * p[k][j];
            }
        }
    }
    let mut next = *q;
    for i in 0..N {
        for j in 0..=i {
            for k in 0..N {
                next[i][j] += fp[i][k] * f[j][k];
            }
            next[j][i] = next[i][j];
        }
    }
    next
}

/// A reading with its gain K = P h/S, S = hᵀ P h + R.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Gain<T, const N: usize> {
    reading: Reading<T, N>,
    /// P h.
    column: [T; N],
    /// Gain K.
    pub k: [T; N],
    /// Variance S of the innovation.
    pub variance: T,
    /// Variance R of the reading.
    r: T,
}

impl<T: Float, const N: usize> Gain<T, N> {
    /// Of a reading with variance R at a covariance P.
    ///
    /// # Panics
    /// When the state that is read is not below N.
    #[inline(always)]
    pub fn new(reading: Reading<T, N>, p: &[[T; N]; N], r: T) -> Self {
        let (column, variance) = match &reading {
            Reading::State(c) => (p[*c], p[*c][*c] + r),
            Reading::Combination(h) => {
                let column: [T; N] = core::array::from_fn(|i| reading.of(&p[i]));
                (column, (0..N).fold(r, |s, i| s + h[i] * column[i]))
            }
        };
        let inverse = T::ONE / variance;
        Self {
            reading,
            column,
            k: column.map(|p| p * inverse),
            variance,
            r,
        }
    }

    /// The mean after the reading: x + K ν.
    #[inline(always)]
    pub fn correct(&self, x: &mut [T; N], innovation: T) {
        for i in 0..N {
            x[i] += self.k[i] * innovation;
        }
    }

    /// The covariance after the reading: P − K hᵀ P; row and column of a state that is read are K R, which a
    /// difference would lose of an exact reading.
    ///
    /// **Accuracy** in single precision that of Joseph's form: `law_single_precision_loses_no_more_than_josephs_form`.
    #[inline(always)]
    pub fn reduce(&self, p: &mut [[T; N]; N]) {
        for i in 0..N {
            for j in 0..=i {
                let after = match self.reading {
                    Reading::State(c) if i == c => self.k[j] * self.r,
                    Reading::State(c) if j == c => self.k[i] * self.r,
                    _ => p[i][j] - self.k[i] * self.column[j],
                };
                p[i][j] = after;
                p[j][i] = after;
            }
        }
    }

    /// (I − K hᵀ)ᵀ x.
    #[inline]
    fn back(&self, x: &mut [T; N]) {
        match self.reading {
            Reading::State(c) => {
                // 1 − K is R/S: the difference loses all digits of an exact reading.
                let rest = self.r / self.variance;
                let others = (0..N).filter(|i| *i != c);
                x[c] = others.fold(rest * x[c], |s, i| s - self.k[i] * x[i]);
            }
            Reading::Combination(_) => {
                let dot = (0..N).fold(T::ZERO, |s, i| s + self.k[i] * x[i]);
                self.reading.add(x, -dot);
            }
        }
    }
}

/// Mean and covariance after a reading of variance R.
///
/// ```
/// use proofmass_core::state_space::{Reading, update};
/// let (mut x, mut p) = ([0.0, 1.0], [[3.0, 1.0], [1.0, 1.0]]);
/// let innovation = update(&mut x, &mut p, Reading::State(0), 2.0, 1.0);
/// assert_eq!((x, innovation.variance), ([1.5, 1.5], 4.0));
/// assert_eq!(p, [[0.75, 0.25], [0.25, 0.75]]);
/// ```
#[inline(always)]
pub fn update<T: Float, const N: usize>(
    x: &mut [T; N],
    p: &mut [[T; N]; N],
    reading: Reading<T, N>,
    value: T,
    r: T,
) -> Innovation<T> {
    let gain = Gain::new(reading, p, r);
    let value = value - reading.of(x);
    gain.correct(x, value);
    gain.reduce(p);
    Innovation {
        value,
        variance: gain.variance,
    }
}

/// What the readings after a sample say of its state: the way back of the fixed-interval smoother.
///
/// Rauch, Tung and Striebel's estimate in Bryson and Frazier's modified form. Backward through the readings
/// λ̃ = (I − K hᵀ)ᵀ λ − h ν/S and through the steps λ = Fᵀ λ̃, Λ likewise; x_s = x⁻ − P⁻ λ̃, P_s = P⁻ − P⁻ Λ̃ P⁻. No matrix is
/// inverted, so a singular covariance (a known start) is no trouble. `C` means may share the covariance, as the data and
/// the columns of unknown constants do.
///
/// ```
/// use proofmass_core::state_space::{Adjoint, Gain, Reading};
/// // A constant that is read twice: before the readings the smoother knows what the filter knows after them.
/// let (mut x, mut p, mut seen) = ([0.0], [[4.0]], Vec::new());
/// for z in [1.0, 3.0] {
///     let (gain, innovation) = (Gain::new(Reading::State(0), &p, 1.0), z - x[0]);
///     gain.correct(&mut x, innovation);
///     gain.reduce(&mut p);
///     seen.push((gain, innovation));
/// }
/// let mut back = Adjoint::<f64, 1>::default();
/// for (gain, innovation) in seen.iter().rev() { back.update(gain, &[*innovation]); }
/// assert!((back.value(0, 0, &[0.0], &[[4.0]]) - x[0]).abs() < 1e-15);
/// assert!((back.variance(0, &[[4.0]]) - p[0][0]).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adjoint<T, const N: usize, const C: usize = 1> {
    /// λ of each mean.
    vectors: [[T; N]; C],
    /// Λ.
    matrix: [[T; N]; N],
}

impl<T: Float, const N: usize, const C: usize> Default for Adjoint<T, N, C> {
    /// After the last reading.
    fn default() -> Self {
        Self {
            vectors: [[T::ZERO; N]; C],
            matrix: [[T::ZERO; N]; N],
        }
    }
}

impl<T: Float, const N: usize, const C: usize> Adjoint<T, N, C> {
    /// Back over a reading with the innovation of each mean; of fewer innovations than means those of the first ones.
    #[inline]
    pub fn update(&mut self, gain: &Gain<T, N>, innovations: &[T]) {
        let inverse = T::ONE / gain.variance;
        for (vector, innovation) in self.vectors.iter_mut().zip(innovations) {
            gain.back(vector);
            gain.reading.add(vector, -(*innovation * inverse));
        }
        for row in &mut self.matrix {
            gain.back(row);
        }
        for j in 0..N {
            let mut column: [T; N] = core::array::from_fn(|i| self.matrix[i][j]);
            gain.back(&mut column);
            let weight = match &gain.reading {
                Reading::State(c) if *c == j => T::ONE,
                Reading::State(_) => T::ZERO,
                Reading::Combination(h) => h[j],
            };
            gain.reading.add(&mut column, weight * inverse);
            for i in 0..N {
                self.matrix[i][j] = column[i];
            }
        }
    }

    /// Back over a step with this F, for the first `means` of the means.
    #[inline]
    pub fn predict(&mut self, f: &[[T; N]; N], means: usize) {
        let (mut half, mut matrix) = ([[T::ZERO; N]; N], [[T::ZERO; N]; N]);
        for vector in self.vectors.iter_mut().take(means) {
            let mut x = [T::ZERO; N];
            for i in 0..N {
                for l in 0..N {
                    x[i] += f[l][i] * vector[l];
                }
            }
            *vector = x;
        }
        for i in 0..N {
            for l in 0..N {
                for j in 0..N {
                    half[i][j] += self.matrix[i][l] * f[l][j];
                }
            }
        }
        for i in 0..N {
            for l in 0..N {
                for j in 0..N {
                    matrix[i][j] += f[l][i] * half[l][j];
                }
            }
        }
        self.matrix = matrix;
    }

    /// One state of a smoothed mean from the mean and covariance before the readings of its sample.
    #[inline]
    pub fn value(&self, mean: usize, state: usize, x: &[T; N], p: &[[T; N]; N]) -> T {
        let change = (0..N).fold(T::ZERO, |s, j| s + p[state][j] * self.vectors[mean][j]);
        x[state] - change
    }

    /// Its smoothed variance.
    #[inline]
    pub fn variance(&self, state: usize, p: &[[T; N]; N]) -> T {
        let row = &p[state];
        let mut variance = row[state];
        for i in 0..N {
            for j in 0..N {
                variance -= row[i] * self.matrix[i][j] * row[j];
            }
        }
        // A difference resolves no less of what it is taken from.
        let least = T::from_f64(1e-12) * row[state];
        if variance > least { variance } else { least }
    }
}

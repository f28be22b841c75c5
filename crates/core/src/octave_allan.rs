//! Allan deviation at octave averaging times, sample by sample, in memory that does not grow.

use crate::{Error, Float};

/// Block sums in one averaging time beyond the first octaves.
const PER_TAU: usize = 8;

/// Block sums a level remembers: two averaging times.
const HISTORY: usize = 2 * PER_TAU;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
    impl Sealed for i64 {}
}

/// In what the sums of samples are formed: `f32` or `f64` for a rate in SI, `i64` for counts, of which nothing is lost.
pub trait AllanSum: sealed::Sealed + Copy + Default {
    /// A sample: `f32`, `f64`, or an `i32` of counts.
    type Sample: Copy;
    /// In what deviations come out.
    type Value: Float;

    /// The sample as a sum of one; `None` when it is not finite.
    fn from_sample(sample: Self::Sample) -> Option<Self>;
    /// The sum of two.
    fn plus(self, other: Self) -> Self;
    /// The difference of two.
    fn minus(self, other: Self) -> Self;
    /// The nearest number.
    fn value(self) -> Self::Value;
}

macro_rules! rate {
    ($float:ty) => {
        impl AllanSum for $float {
            type Sample = $float;
            type Value = $float;

            fn from_sample(sample: $float) -> Option<Self> {
                sample.is_finite().then_some(sample)
            }
            fn plus(self, other: Self) -> Self {
                self + other
            }
            fn minus(self, other: Self) -> Self {
                self - other
            }
            fn value(self) -> $float {
                self
            }
        }
    };
}

rate!(f32);
rate!(f64);

impl AllanSum for i64 {
    type Sample = i32;
    type Value = f32;

    fn from_sample(sample: i32) -> Option<Self> {
        Some(Self::from(sample))
    }
    // No overflow: 2³² times the 2³¹ samples of two averaging times at the last of 28 levels.
    fn plus(self, other: Self) -> Self {
        self.wrapping_add(other)
    }
    fn minus(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }
    fn value(self) -> f32 {
        self as f32
    }
}

/// Overlapping Allan deviation of a rate at m = 1, 2, 4, … 2^(LEVELS + 2) samples, on the chip.
///
/// Level j holds the last sixteen sums of 2^j samples. Its differences of neighbouring eights are those of m = 8·2^j, started
/// every τ/8; level 0 also gives m = 1, 2 and 4. With ȳ the means over m samples
///
/// ```text
/// σ²(m) = Σ (ȳ_{i+m} − ȳ_i)² / 2M        M the number of differences
/// ```
///
/// For m ≤ 8 that is the overlapping Allan deviation; beyond, every (m/8)-th of its differences, which costs 1 % of the degrees of
/// freedom for white noise and less for redder noise. They are the differences of `StreamingAllan` on the desk.
///
/// Squares are summed with what rounding left over, so that a difference that is 10⁻⁷ of the sum still counts, and what comes
/// after a month weighs as much as what came first. The work of a sample is some sixty additions, whatever LEVELS is; once in
/// 2^j samples level j is reached as well.
///
/// **Units** deviations are in the unit of the samples; τ = m over the sample rate. **Accuracy** equal to the desk's to rounding:
/// 10⁻¹² in `f64`; 10⁻⁵ in `f32` and 10⁻⁶ of counts (`crosscheck_chip_and_desk` of the noise crate). **Source** `[SP1065] 5.2.4`.
///
/// ```
/// use proofmass_core::OctaveAllan;
///
/// // Counts of a converter, LEVELS = 10: averaging times up to 4096 samples, in two kilobytes.
/// let mut allan = OctaveAllan::<i64, 10>::new();
/// for k in 0..100_000_i32 {
///     allan.push(2048 + (k * 7919 % 1009) / 64)?;
/// }
/// let eight = allan.deviation(3).unwrap();
/// assert_eq!((eight.factor, eight.terms), (8, 100_000 - 15));
/// assert!(allan.deviation(13).is_none());
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct OctaveAllan<S: AllanSum, const LEVELS: usize> {
    samples: u64,
    reference: Option<S>,
    levels: [Level<S>; LEVELS],
    /// m = 1, 2 and 4.
    shortest: [Squares<S::Value>; 3],
}

/// The deviation of one averaging time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct OctaveDeviation<F> {
    /// Averaging factor m: samples in one averaging time.
    pub factor: u64,
    /// Its Allan deviation, in the unit of the samples.
    pub deviation: F,
    /// Differences it is the mean square of. Neighbours overlap: degrees of freedom are fewer.
    pub terms: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Level<S: AllanSum> {
    /// Sums of 2^j samples: the next takes the place at `at`.
    history: [S; HISTORY],
    at: usize,
    filled: usize,
    /// First of a pair that waits for its second.
    pending: Option<S>,
    squares: Squares<S::Value>,
}

/// A sum, what rounding left over of it, and its number of terms.
#[derive(Clone, Copy, Debug, Default)]
struct Squares<F> {
    sum: F,
    left: F,
    terms: u64,
}

impl<F: Float> Squares<F> {
    fn add(&mut self, square: F) {
        let term = square + self.left;
        let sum = self.sum + term;
        self.left = term - (sum - self.sum);
        self.sum = sum;
        self.terms += 1;
    }
}

impl<S: AllanSum, const LEVELS: usize> Default for OctaveAllan<S, LEVELS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: AllanSum, const LEVELS: usize> OctaveAllan<S, LEVELS> {
    /// Nothing seen yet. LEVELS from 1 to 28, which the compiler checks.
    pub fn new() -> Self {
        const { assert!(LEVELS >= 1 && LEVELS <= 28, "LEVELS is from 1 to 28") };
        Self {
            samples: 0,
            reference: None,
            levels: [Level::default(); LEVELS],
            shortest: [Squares::default(); 3],
        }
    }

    /// Samples taken in so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Takes in a sample.
    ///
    /// **Errors** [`Error::NotFinite`]; the sample is not taken in. Call [`OctaveAllan::gap`] and go on.
    #[inline]
    pub fn push(&mut self, sample: S::Sample) -> Result<(), Error> {
        let value = S::from_sample(sample).ok_or(Error::NotFinite {
            name: "sample",
            index: 0,
        })?;
        // A constant changes nothing; without it the sums of a sensor in gravity keep more digits.
        let mut carried = value.minus(*self.reference.get_or_insert(value));
        self.samples += 1;
        for (j, level) in self.levels.iter_mut().enumerate() {
            level.take_in(carried);
            if j == 0 {
                for (k, squares) in self.shortest.iter_mut().enumerate() {
                    if let Some(square) = level.square(1 << k, 1 << k) {
                        squares.add(square);
                    }
                }
            }
            if let Some(square) = level.square(PER_TAU, PER_TAU << j) {
                level.squares.add(square);
            }
            match level.pending.take() {
                Some(first) => carried = first.plus(carried),
                None => {
                    level.pending = Some(carried);
                    break;
                }
            }
        }
        Ok(())
    }

    /// Samples are missing here: no difference reaches across.
    pub fn gap(&mut self) {
        for level in &mut self.levels {
            level.filled = 0;
            level.pending = None;
        }
    }

    /// The deviation at m = 2^octave; `None` before the first difference and beyond the last level.
    pub fn deviation(&self, octave: usize) -> Option<OctaveDeviation<S::Value>> {
        let squares = match self.shortest.get(octave) {
            Some(squares) => squares,
            None => &self.levels.get(octave - self.shortest.len())?.squares,
        };
        if squares.terms == 0 {
            return None;
        }
        let terms = S::Value::from_f64(squares.terms as f64);
        let half = S::Value::from_f64(0.5);
        Some(OctaveDeviation {
            factor: 1 << octave,
            deviation: (half * (squares.sum + squares.left) / terms).sqrt(),
            terms: squares.terms,
        })
    }
}

impl<S: AllanSum> Level<S> {
    fn take_in(&mut self, sum: S) {
        self.history[self.at % HISTORY] = sum;
        self.at = (self.at + 1) % HISTORY;
        self.filled = (self.filled + 1).min(HISTORY);
    }

    /// Squared difference of the means of the last `lag` sums, of `samples` samples, and of the `lag` before.
    fn square(&self, lag: usize, samples: usize) -> Option<S::Value> {
        if self.filled < 2 * lag {
            return None;
        }
        let back = |k: usize| self.history[(self.at + HISTORY - k) % HISTORY];
        let mut difference = S::default();
        for k in 1..=lag {
            difference = difference.plus(back(k).minus(back(k + lag)));
        }
        // Two numbers of 32 bits hold 2³⁰ samples; the division is exact: a power of two.
        let mean = difference.value() / S::Value::from_u32(samples as u32);
        Some(mean * mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nine frequency values of NBS.
    #[test]
    fn published_nine_values() {
        let mut allan = OctaveAllan::<f64, 1>::new();
        for y in [
            892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0,
        ] {
            allan.push(y).unwrap();
        }
        let at = |octave| allan.deviation(octave).unwrap();
        assert!((at(0).deviation - 91.22945).abs() < 5e-6);
        assert!((at(1).deviation - 85.95287).abs() < 5e-6);
        assert_eq!((at(1).factor, at(1).terms), (2, 6));
        assert!(allan.deviation(3).is_none() && allan.deviation(4).is_none());
    }

    /// In single precision 2²⁶ equal squares add up: the plain sum stands still at 2²⁴ of them.
    #[test]
    fn law_single_precision_does_not_stand_still() {
        let mut squares = Squares::<f32>::default();
        for _ in 0..1_u32 << 26 {
            squares.add(0.7);
        }
        let expected = f64::from(0.7_f32) * f64::from(1_u32 << 26);
        assert!((f64::from(squares.sum) / expected - 1.0).abs() < 1e-6);
    }

    /// Counts far from zero and the largest numbers there are: the same deviation as near zero.
    #[test]
    fn law_counts_lose_nothing() {
        let pattern = |k: u32| (k.wrapping_mul(2_654_435_761) >> 20) as i32;
        let of = |offset: i32| {
            let mut allan = OctaveAllan::<i64, 8>::new();
            (0..20_000).for_each(|k| allan.push(offset + pattern(k)).unwrap());
            (0..11)
                .map(|o| allan.deviation(o).unwrap().deviation)
                .collect::<Vec<f32>>()
        };
        assert_eq!(of(0), of(i32::MIN));
        assert_eq!(of(0), of(i32::MAX - 4096));
        let mut square = OctaveAllan::<i64, 28>::new();
        for k in 0..64 {
            let rail = if k % 32 < 16 { i32::MAX } else { i32::MIN };
            square.push(rail).unwrap();
        }
        // Started every second sample the differences are ±2³² (1, ¾, ½, ¼, 0, …): Σ of their squares is 6.5 in 17 terms.
        let full = square.deviation(4).unwrap();
        let expected = 2f64.powi(32) * (6.5_f64 / 34.0).sqrt();
        assert!((f64::from(full.deviation) / expected - 1.0).abs() < 1e-6);
    }

    /// No difference crosses a gap, and a value that is none is refused without a trace.
    #[test]
    fn refuses_what_is_not_finite_and_gaps() {
        let mut allan = OctaveAllan::<f32, 4>::new();
        for k in 0..40_u8 {
            if k == 20 {
                assert!(allan.push(f32::NAN).is_err());
                allan.gap();
            }
            allan
                .push(f32::from(k % 3) + if k < 20 { 0.0 } else { 1e6 })
                .unwrap();
        }
        assert_eq!(allan.samples(), 40);
        assert_eq!(allan.deviation(0).unwrap().terms, 38);
        assert!(allan.deviation(0).unwrap().deviation < 2.0);
    }
}

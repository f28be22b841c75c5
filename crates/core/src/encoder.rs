//! Position sensors read sample by sample: quadrature, Hall sensors, Gray code, rolling counters, resolver.

mod hall;

pub use hall::{Hall, HallSectors, HallSpacing};

use crate::Float;

/// How many edges of a line period are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Decoding {
    /// Rising edges of A: N per turn.
    Single,
    /// Both edges of A: 2N per turn.
    Double,
    /// Every edge: 4N per turn.
    #[default]
    Quadruple,
}

impl core::str::FromStr for Decoding {
    type Err = &'static str;

    /// By the edges counted per line: 1, 2 or 4.
    fn from_str(text: &str) -> Result<Self, &'static str> {
        match text {
            "1" => Ok(Self::Single),
            "2" => Ok(Self::Double),
            "4" => Ok(Self::Quadruple),
            _ => Err("1, 2 or 4 edges of a line can be counted"),
        }
    }
}

impl Decoding {
    /// Counts per line.
    pub fn counts_per_line(self) -> u32 {
        match self {
            Self::Single => 1,
            Self::Double => 2,
            Self::Quadruple => 4,
        }
    }
}

/// Quadrature decoder: count, direction, illegal transitions and index from the levels of A, B and Z.
///
/// The sense is positive when A leads B: (A, B) runs 00 → 10 → 11 → 01. Both channels changing between two
/// samples is a transition that cannot be counted: its direction is unknown. It is left uncounted and counted
/// as illegal; two quarters are lost or gained with each.
///
/// Single and double decoding count a place, not an event: an axis that trembles on one edge goes up and down
/// and does not drift.
///
/// ```
/// use proofmass_core::encoder::{Decoding, Quadrature};
/// let mut decoder = Quadrature::new(Decoding::Quadruple, false, false);
/// for (a, b) in [(true, false), (true, true), (false, true), (false, false)] { decoder.update(a, b, false); }
/// assert_eq!(decoder.count(), 4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quadrature {
    decoding: Decoding,
    phase: u8,
    index_level: bool,
    count: i32,
    illegal: u32,
    indexed: Option<i32>,
}

/// Place of (A, B) in the cycle 00, 10, 11, 01.
fn phase(a: bool, b: bool) -> u8 {
    match (a, b) {
        (false, false) => 0,
        (true, false) => 1,
        (true, true) => 2,
        (false, true) => 3,
    }
}

impl Quadrature {
    /// Starts at count zero with these levels.
    pub fn new(decoding: Decoding, a: bool, b: bool) -> Self {
        Self {
            decoding,
            phase: phase(a, b),
            index_level: false,
            count: 0,
            illegal: 0,
            indexed: None,
        }
    }

    /// Takes the levels of one sample; returns the step of the count, or `None` for an illegal transition.
    pub fn update(&mut self, a: bool, b: bool, index: bool) -> Option<i32> {
        let from = self.phase;
        let to = phase(a, b);
        self.phase = to;
        let step = match (4 + to - from) % 4 {
            0 => Some(0),
            1 => Some(self.counted(from)),
            3 => Some(-self.counted(to)),
            _ => {
                self.illegal = self.illegal.saturating_add(1);
                None
            }
        };
        self.count = self.count.wrapping_add(step.unwrap_or(0));
        if index && !self.index_level {
            self.indexed = Some(self.count);
        }
        self.index_level = index;
        step
    }

    /// Whether the forward transition out of this phase is a counted one.
    fn counted(&self, from: u8) -> i32 {
        i32::from(match self.decoding {
            Decoding::Quadruple => true,
            Decoding::Double => from.is_multiple_of(2), // A changes
            Decoding::Single => from == 0,              // A rises going forward
        })
    }

    /// Counts since the start, modulo 2³².
    pub fn count(&self) -> i32 {
        self.count
    }

    /// Illegal transitions since the start.
    pub fn illegal(&self) -> u32 {
        self.illegal
    }

    /// Count at the last rise of the index, once there was one.
    pub fn indexed(&self) -> Option<i32> {
        self.indexed
    }
}

/// Binary value of a Gray code word: bit i is the parity of the bits at and above i.
///
/// ```
/// use proofmass_core::encoder::gray_to_binary;
/// assert_eq!([0b000, 0b001, 0b011, 0b010, 0b110].map(gray_to_binary), [0, 1, 2, 3, 4]);
/// ```
pub fn gray_to_binary(gray: u32) -> u32 {
    let mut binary = gray;
    for shift in [1, 2, 4, 8, 16] {
        binary ^= binary >> shift;
    }
    binary
}

/// Gray code word of a binary value.
pub fn binary_to_gray(binary: u32) -> u32 {
    binary ^ (binary >> 1)
}

/// Continues a counter of a few bits (or an absolute encoder over turns) beyond its rollover.
///
/// The step is the one of least magnitude modulo 2^bits: right as long as the axis moves by less than half the
/// range between two samples.
///
/// ```
/// use proofmass_core::encoder::Unwrap;
/// let mut counter = Unwrap::new(16, 65_530);
/// assert_eq!(counter.update(4), 65_540);
/// assert_eq!(counter.update(65_535), 65_535);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unwrap {
    bits: u32,
    total: i64,
}

impl Unwrap {
    /// Starts at this word of 1 to 32 bits; more bits are taken as 32.
    pub fn new(bits: u32, word: u32) -> Self {
        let bits = bits.clamp(1, 32);
        let mask = (1i64 << bits) - 1;
        Self {
            bits,
            total: i64::from(word) & mask,
        }
    }

    /// Continuous count at this word.
    pub fn update(&mut self, word: u32) -> i64 {
        let range = 1i64 << self.bits;
        let mut step = (i64::from(word) - self.total) & (range - 1);
        if step >= range / 2 {
            step -= range;
        }
        self.total += step;
        self.total
    }
}

/// Angle of a resolver from its two demodulated voltages, V sin θ and V cos θ, in −π…π; `None` without signal.
///
/// The amplitude √(sin² + cos²) comes with it: a falling amplitude is a broken winding. For a tracking loop on a
/// resolver use [`resolver_error`] as the position error.
pub fn resolver_angle<T: Float>(sine: T, cosine: T) -> Option<(T, T)> {
    let square = sine * sine + cosine * cosine;
    let ok = square.is_finite() && square > T::ZERO;
    ok.then(|| (sine.atan2(cosine), square.sqrt()))
}

/// An error of an encoder that repeats with its reading: c cos(2π n r/turn) + s sin(2π n r/turn) too much at the reading r.
///
/// `proofmass velocity map` finds c and s from a recording; a reading less the sum of its lines is what an encoder without
/// them shows. They belong to the zero of the reading: an incremental encoder is set to zero at its index.
///
/// ```
/// use proofmass_core::encoder::ErrorLine;
/// // A disc that is 0.01 rad off its axis, read in radians.
/// const MAP: [ErrorLine<f32>; 1] = [ErrorLine { order: 1.0, cosine: 0.006, sine: 0.008 }];
/// let reading = 1.25_f32;
/// let turns = reading / core::f32::consts::TAU;
/// let error: f32 = MAP.iter().map(|line| line.at(turns)).sum();
/// assert!((error - 0.01 * (reading - 0.927_295).cos()).abs() < 1e-8);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ErrorLine<T> {
    /// Cycles per turn, n.
    pub order: T,
    /// c, in the unit of the readings.
    pub cosine: T,
    /// s, in the unit of the readings.
    pub sine: T,
}

impl<T: Float> ErrorLine<T> {
    /// What it adds to the reading after so many turns from zero; single precision keeps its digits within the first few.
    pub fn at(&self, turns: T) -> T {
        let angle = T::from_f64(core::f64::consts::TAU) * (self.order * turns);
        let (sine, cosine) = angle.sin_cos();
        self.cosine * cosine + self.sine * sine
    }
}

/// sin(θ − θ̂) times the amplitude: the phase detector of a resolver tracking loop.
pub fn resolver_error<T: Float>(sine: T, cosine: T, estimate: T) -> T {
    let (s, c) = estimate.sin_cos();
    sine * c - cosine * s
}

/// Demodulates a resolver voltage sampled synchronously with its carrier: 2/n Σ u sin(ω_e t).
///
/// Over whole carrier periods the quadrature part (speed voltage) drops out.
pub fn demodulate<T: Float>(voltage: &[T], carrier: &[T]) -> Option<T> {
    let n = voltage.len();
    if n == 0 || n != carrier.len() {
        return None;
    }
    let mut sum = T::ZERO;
    for (u, c) in voltage.iter().zip(carrier) {
        sum += *u * *c;
    }
    Some(sum * T::from_f64(2.0 / n as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: [(bool, bool); 4] = [(false, false), (true, false), (true, true), (false, true)];

    #[test]
    fn law_every_decoding_counts_its_edges_forth_and_back() {
        for decoding in [Decoding::Single, Decoding::Double, Decoding::Quadruple] {
            let mut decoder = Quadrature::new(decoding, false, false);
            for n in 1..=40usize {
                let (a, b) = CYCLE[n % 4];
                decoder.update(a, b, n == 9);
            }
            assert_eq!(decoder.count(), 10 * decoding.counts_per_line() as i32);
            assert!(decoder.indexed().is_some());
            for n in (0..40usize).rev() {
                let (a, b) = CYCLE[n % 4];
                decoder.update(a, b, false);
            }
            assert_eq!((decoder.count(), decoder.illegal()), (0, 0));
        }
    }

    #[test]
    fn law_trembling_on_an_edge_does_not_drift() {
        for decoding in [Decoding::Single, Decoding::Double] {
            let mut decoder = Quadrature::new(decoding, false, false);
            for n in 0..1000 {
                decoder.update(n % 2 == 0, false, false);
            }
            assert!(decoder.count().abs() <= 1);
        }
    }

    #[test]
    fn law_a_jump_of_two_is_illegal_and_uncounted() {
        let mut decoder = Quadrature::new(Decoding::Quadruple, false, false);
        assert_eq!(decoder.update(true, true, false), None);
        assert_eq!((decoder.count(), decoder.illegal()), (0, 1));
    }

    #[test]
    fn law_gray_is_a_bijection_with_one_bit_per_step() {
        for n in 0..4096u32 {
            assert_eq!(gray_to_binary(binary_to_gray(n)), n);
            assert_eq!((binary_to_gray(n) ^ binary_to_gray(n + 1)).count_ones(), 1);
        }
        assert_eq!(gray_to_binary(binary_to_gray(u32::MAX)), u32::MAX);
    }

    #[test]
    fn law_unwrapping_follows_any_path_of_small_steps() {
        for bits in [10, 16, 32] {
            let mask = ((1u64 << bits) - 1) as u32;
            let start = i64::from(mask) - 3;
            let (mut total, mut counter) = (start, Unwrap::new(bits, start as u32));
            for n in 0..5000i64 {
                total += (n * 7919) % 301 - 130;
                assert_eq!(counter.update(total as u32 & mask), total);
            }
        }
    }

    #[test]
    fn law_resolver_gives_back_its_angle() {
        for k in -30..30 {
            let theta = 0.1 * f64::from(k);
            let (angle, v) = resolver_angle(2.5 * theta.sin(), 2.5 * theta.cos()).unwrap();
            assert!((angle - theta).abs() < 1e-14 && (v - 2.5).abs() < 1e-14);
            let e = resolver_error(theta.sin(), theta.cos(), theta - 0.01);
            assert!((e - 0.01f64.sin()).abs() < 1e-15);
        }
        assert!(resolver_angle(0.0f32, 0.0).is_none());
        let carrier: Vec<f64> = (0..16)
            .map(|k| (core::f64::consts::TAU * k as f64 / 16.0).sin())
            .collect();
        let voltage: Vec<f64> = carrier.iter().map(|c| 0.7 * c).collect();
        assert!((demodulate(&voltage, &carrier).unwrap() - 0.7).abs() < 1e-15);
    }
}

//! Room for the draws of several trials.

use super::STRIP;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// From one column to the next: not a power of two, at which the columns would fight for the same lines of the cache.
const STRIDE: usize = STRIP + 8;

/// The draws of [`STRIP`] trials, a column per draw.
pub(crate) struct Strips {
    values: Vec<f64>,
    draws: usize,
    words: Words,
}

/// Random words that wait for their use.
pub(super) struct Words {
    pub first: [u64; STRIP],
    pub second: [u64; STRIP],
}

impl Words {
    pub fn new() -> Self {
        Self {
            first: [0; STRIP],
            second: [0; STRIP],
        }
    }

    /// New words, all of the first before those of the second.
    pub fn fill(&mut self, rng: &mut Xoshiro256PlusPlus) {
        fill_words(&mut self.first, rng);
        fill_words(&mut self.second, rng);
    }
}

impl Strips {
    pub fn new(draws: usize) -> Self {
        Self {
            values: vec![0.0; draws * STRIDE],
            draws,
            words: Words::new(),
        }
    }

    /// The first trials of every draw.
    pub fn columns(&self, trials: usize) -> Vec<&[f64]> {
        (0..self.draws)
            .map(|draw| &self.values[draw * STRIDE..][..trials.min(STRIP)])
            .collect()
    }

    /// All trials of one draw, and room for random words.
    pub(super) fn column(&mut self, draw: usize) -> (&mut [f64], &mut Words) {
        let column = &mut self.values[draw * STRIDE..][..STRIP];
        (column, &mut self.words)
    }

    /// One draw of one trial.
    pub(super) fn set(&mut self, draw: usize, trial: usize, x: f64) {
        self.values[draw * STRIDE + trial] = x;
    }
}

/// Fills with random words. The generator is copied out and back, so that its state stays in registers.
pub(super) fn fill_words(words: &mut [u64; STRIP], rng: &mut Xoshiro256PlusPlus) {
    let mut state = rng.clone();
    for word in words {
        *word = state.next_u64();
    }
    *rng = state;
}

/// The upper 53 bits as a number in [0, 1).
pub(super) fn fraction(word: u64) -> f64 {
    // Through the signed type, whose conversion is one instruction.
    (word >> 11) as i64 as f64 * (1.0 / (1u64 << 53) as f64)
}

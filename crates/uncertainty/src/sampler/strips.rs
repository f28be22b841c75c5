//! Room for the draws of several trials.

use super::STRIP;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// What is added from one column to the next: at powers of two the columns would fight for the same lines of the cache.
const APART: usize = 8;
/// Draws up to which those of [`STRIP`] trials stay in the second-level cache.
const MANY: usize = 512;

/// The draws of some trials, a column per draw.
pub(crate) struct Strips {
    values: Vec<f64>,
    draws: usize,
    /// Trials in a column.
    pub trials: usize,
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

    /// New words for some trials, all of the first before those of the second.
    pub fn fill(&mut self, trials: usize, rng: &mut Xoshiro256PlusPlus) {
        fill_words(&mut self.first[..trials], rng);
        fill_words(&mut self.second[..trials], rng);
    }
}

impl Strips {
    /// As many trials as the cache holds.
    pub fn new(draws: usize) -> Self {
        let trials = if draws > MANY { STRIP / 4 } else { STRIP };
        Self::of(draws, trials)
    }

    /// So many trials, [`STRIP`] at most.
    pub fn of(draws: usize, trials: usize) -> Self {
        Self {
            values: vec![0.0; draws * (trials + APART)],
            draws,
            trials,
            words: Words::new(),
        }
    }

    /// The first trials of every draw.
    pub fn columns(&self, trials: usize) -> Vec<&[f64]> {
        (0..self.draws)
            .map(|draw| &self.values[self.place(draw)..][..trials.min(self.trials)])
            .collect()
    }

    /// All trials of one draw, and room for random words.
    pub(super) fn column(&mut self, draw: usize) -> (&mut [f64], &mut Words) {
        let place = self.place(draw);
        let column = &mut self.values[place..place + self.trials];
        (column, &mut self.words)
    }

    /// One draw of one trial.
    pub(super) fn set(&mut self, draw: usize, trial: usize, x: f64) {
        let place = self.place(draw);
        self.values[place + trial] = x;
    }

    fn place(&self, draw: usize) -> usize {
        draw * (self.trials + APART)
    }
}

/// Fills with random words. The generator is copied out and back, so that its state stays in registers.
pub(super) fn fill_words(words: &mut [u64], rng: &mut Xoshiro256PlusPlus) {
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

//! Room for the draws of several trials.

use super::STRIP;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// What is added from one column to the next: at powers of two the columns would fight for the same lines of the cache.
const APART: usize = 8;
/// Draws up to which those of [`STRIP`] trials stay in the second-level cache, and those of a quarter of them.
const MANY: [usize; 2] = [512, 2048];
/// Trials beyond: as many as the widest register holds, one line of the cache per draw.
const LINE: usize = 8;

/// The draws of some trials, a column per draw; where there are very many, group by group of trials, so that those of a
/// group stand one after the other.
pub(crate) struct Strips {
    values: Vec<f64>,
    draws: usize,
    /// Trials in all.
    pub(crate) trials: usize,
    /// Trials in a column.
    pub(crate) group: usize,
    /// Numbers from one column to the next.
    apart: usize,
    /// A whole column while it is filled.
    whole: Vec<f64>,
    words: Words,
}

/// Random words that wait for their use.
pub(super) struct Words {
    pub(crate) first: [u64; STRIP],
    pub(crate) second: [u64; STRIP],
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
        match draws {
            _ if draws <= MANY[0] => Self::of(draws, STRIP),
            _ if draws <= MANY[1] => Self::of(draws, STRIP / 4),
            _ => Self::grouped(draws, STRIP / 4, LINE, LINE),
        }
    }

    /// So many trials, [`STRIP`] at most.
    pub fn of(draws: usize, trials: usize) -> Self {
        Self::grouped(draws, trials, trials, trials + APART)
    }

    fn grouped(draws: usize, trials: usize, group: usize, apart: usize) -> Self {
        Self {
            values: vec![0.0; trials / group * draws * apart],
            draws,
            trials,
            group,
            apart,
            whole: vec![0.0; trials],
            words: Words::new(),
        }
    }

    /// The draws of a group, its first trials.
    pub fn columns(&self, group: usize, trials: usize) -> Vec<&[f64]> {
        let all = self.draws * self.apart;
        let here = &self.values[group * all..][..all];
        here.chunks_exact(self.apart)
            .map(|column| &column[..trials.min(self.group)])
            .collect()
    }

    /// Fills all trials of one draw, with room for random words.
    pub(super) fn fill(&mut self, draw: usize, fill: impl FnOnce(&mut [f64], &mut Words)) {
        if self.group == self.trials {
            let place = draw * self.apart;
            fill(
                &mut self.values[place..place + self.trials],
                &mut self.words,
            );
            return;
        }
        fill(&mut self.whole, &mut self.words);
        for (group, trials) in self.whole.chunks_exact(self.group).enumerate() {
            let place = (group * self.draws + draw) * self.apart;
            self.values[place..place + self.group].copy_from_slice(trials);
        }
    }

    /// One draw of one trial.
    pub(super) fn set(&mut self, draw: usize, trial: usize, x: f64) {
        let (group, trial) = (trial / self.group, trial % self.group);
        self.values[(group * self.draws + draw) * self.apart + trial] = x;
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

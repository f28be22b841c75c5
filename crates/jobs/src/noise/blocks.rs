//! Samples that arrive block by block.

use crate::trouble::Result;

/// Consecutive samples of every channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NoiseBlock {
    /// Whether samples are missing before this block.
    pub behind_gap: bool,
    /// One vector per channel, all of one length, every number finite.
    pub columns: Vec<Vec<f64>>,
}

/// A recording that is seen once.
pub trait NoiseBlocks {
    /// The next block, `None` at the end.
    ///
    /// # Errors
    /// What cannot be read.
    fn next_block(&mut self) -> Result<Option<NoiseBlock>>;

    /// Samples per second, once every block was seen.
    fn rate(&self) -> Option<f64>;

    /// Gaps so far.
    fn gaps(&self) -> u64 {
        0
    }

    /// How much was read, of how much (zero where that is not known).
    fn progress(&self) -> (u64, u64) {
        (0, 0)
    }
}

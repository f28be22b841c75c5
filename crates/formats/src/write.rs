//! Recordings written in formats of others: what stands before the samples, and the samples, block by block.

mod npy;
mod uff;
mod wav;

pub use npy::npy_head;
pub use uff::{UFF_END, UffSignal, uff_head, uff_name, uff_stored};
pub use wav::{WavForm, wav_head};

/// Appends numbers as little-endian doubles.
pub fn put_doubles(numbers: impl IntoIterator<Item = f64>, to: &mut Vec<u8>) {
    for number in numbers {
        to.extend(number.to_le_bytes());
    }
}

#[cfg(test)]
mod tests;

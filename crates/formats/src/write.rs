//! Recordings written in formats of others: what stands before the samples, and the samples, block by block.

mod column;
#[cfg(not(feature = "parquet"))]
mod no_parquet;
mod npy;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "parquet")]
mod parquet_table;
mod uff;
mod wav;

pub use column::{ParquetColumn, ParquetKind, TableCells, TableColumn};
#[cfg(not(feature = "parquet"))]
pub use no_parquet::{PARQUET, ParquetWriter, parquet_table};
pub use npy::npy_head;
#[cfg(feature = "parquet")]
pub use parquet::{PARQUET, ParquetWriter};
#[cfg(feature = "parquet")]
pub use parquet_table::parquet_table;
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

//! In place of the writer of Parquet, where it was not built.

use super::{ParquetColumn, TableColumn};
use crate::{Error, Result};
use std::convert::Infallible;

/// Whether Parquet can be written.
pub const PARQUET: bool = false;

/// A Parquet file in the making; of this build there is none.
pub struct ParquetWriter(Infallible);

impl ParquetWriter {
    /// Refuses.
    ///
    /// # Errors
    /// Always.
    pub fn new(_columns: Vec<ParquetColumn>) -> Result<Self> {
        Err(refusal())
    }

    /// Never comes to this.
    ///
    /// # Errors
    /// None.
    pub fn rows(&mut self, _words: &[String], _numbers: &[Vec<f64>]) -> Result<Vec<u8>> {
        match self.0 {}
    }

    /// Never comes to this.
    ///
    /// # Errors
    /// None.
    pub fn end(self, _recordings: &[(String, usize)]) -> Result<Vec<u8>> {
        match self.0 {}
    }
}

/// Refuses.
///
/// # Errors
/// Always.
pub fn parquet_table(_columns: &[TableColumn]) -> Result<Vec<u8>> {
    Err(refusal())
}

fn refusal() -> Error {
    Error::new("this build does not write Parquet")
        .with_hint("build it from the source with the feature parquet, or write csv")
}

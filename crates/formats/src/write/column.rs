//! A column of a Parquet file.

/// What stands in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParquetKind {
    /// Times, of which none is absent.
    Time,
    /// Numbers, of which some may be absent.
    Signal,
    /// Words, one for all rows of a row group.
    Word,
}

/// A column of a Parquet file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParquetColumn {
    /// Its name.
    pub name: String,
    /// Word for its unit.
    pub unit: Option<String>,
    /// What stands in it.
    pub kind: ParquetKind,
}

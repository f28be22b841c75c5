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

/// A column of a table that is no recording; a cell that is not there is `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct TableColumn {
    /// Heading.
    pub name: String,
    /// What stands in it.
    pub cells: TableCells,
}

/// The cells of a column, all of one kind.
#[derive(Clone, Debug, PartialEq)]
pub enum TableCells {
    /// Text.
    Text(Vec<Option<String>>),
    /// Numbers.
    Number(Vec<Option<f64>>),
    /// Whole numbers.
    Integer(Vec<Option<i64>>),
    /// Days from 1970-01-01.
    Date(Vec<Option<i32>>),
}

impl TableCells {
    /// Number of rows.
    #[cfg(feature = "parquet")]
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Text(cells) => cells.len(),
            Self::Number(cells) => cells.len(),
            Self::Integer(cells) => cells.len(),
            Self::Date(cells) => cells.len(),
        }
    }
}

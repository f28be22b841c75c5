//! Tables of results as CSV, and rows of numbers written as fast as they come.

use crate::field::parse_number;
use crate::output::AtomicFile;
use crate::{Error, ErrorKind, Result};
use proofmass_core::Visible;
use proofmass_uncertainty::DecimalMark;
use std::path::Path;

/// A field of a [`Table`].
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A finite number, written so that it reads back as the same double.
    Number(f64),
    /// Text.
    Text(String),
    /// Nothing: an empty field.
    Missing,
}

impl From<f64> for Cell {
    fn from(v: f64) -> Self {
        Self::Number(v)
    }
}

impl From<Option<f64>> for Cell {
    fn from(v: Option<f64>) -> Self {
        v.map_or(Self::Missing, Self::Number)
    }
}

impl From<usize> for Cell {
    fn from(v: usize) -> Self {
        Self::Text(v.to_string())
    }
}

impl From<&str> for Cell {
    fn from(v: &str) -> Self {
        Self::Text(v.to_string())
    }
}

/// A small table: column names with their units, and rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table with these column names, units included (`bias_m/s2`).
    pub fn new(columns: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self {
            columns: columns.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// Another number of fields than columns, or a number that is not finite.
    pub fn push(&mut self, row: impl IntoIterator<Item = impl Into<Cell>>) -> Result<()> {
        let row: Vec<Cell> = row.into_iter().map(Into::into).collect();
        if row.len() != self.columns.len() {
            return Err(Error::new(
                ErrorKind::Output,
                format!(
                    "row {} of the table has {} fields, the table has {} columns",
                    self.rows.len() + 1,
                    row.len(),
                    self.columns.len()
                ),
            ));
        }
        for (cell, name) in row.iter().zip(&self.columns) {
            if let Cell::Number(v) = cell {
                finite(*v, name)?;
            }
        }
        self.rows.push(row);
        Ok(())
    }

    /// The table as CSV text.
    ///
    /// # Errors
    /// None in practice; the CSV writer's own.
    pub fn to_csv(&self) -> Result<Vec<u8>> {
        let fail = |e: csv::Error| Error::new(ErrorKind::Output, e.to_string()).because(e);
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer
            .write_record(self.columns.iter().map(|c| harmless(c)))
            .map_err(fail)?;
        let mut buffer = ryu::Buffer::new();
        for row in &self.rows {
            for cell in row {
                match cell {
                    Cell::Number(v) => writer.write_field(buffer.format_finite(*v)),
                    Cell::Text(t) => writer.write_field(harmless(t)),
                    Cell::Missing => writer.write_field(""),
                }
                .map_err(fail)?;
            }
            writer.write_record(None::<&[u8]>).map_err(fail)?;
        }
        writer
            .into_inner()
            .map_err(|e| Error::new(ErrorKind::Output, e.to_string()))
    }
}

/// Text that no spreadsheet takes for a formula: an apostrophe stands before what would be one, and control
/// characters are escapes. Signs of full width count, since some spreadsheets read them as the narrow ones. Numbers stay, and
/// directions such as `+x` and `-z up`: words without a digit behind a letter, which would name a cell.
fn harmless(text: &str) -> String {
    let unseen = |c: char| c.is_whitespace() || c.is_control() || c == '\u{feff}';
    let seen = text.trim_start_matches(unseen);
    let mut rest = seen.chars();
    let formula = text.starts_with(['\t', '\r', '\n'])
        || match rest.next() {
            Some('=' | '@' | '＝' | '＠' | '＋' | '－') => true,
            Some('+' | '-') => {
                let mut before = ' ';
                parse_number(seen.as_bytes(), DecimalMark::Point).is_none()
                    && !rest.all(|c| {
                        let cell = before.is_alphabetic() && c.is_numeric();
                        before = c;
                        !cell && (c.is_alphanumeric() || matches!(c, ' ' | '.' | '_'))
                    })
            }
            _ => false,
        };
    let shown = Visible(text);
    if formula {
        format!("'{shown}")
    } else {
        shown.to_string()
    }
}

fn finite(v: f64, name: &str) -> Result<()> {
    if v.is_finite() {
        return Ok(());
    }
    Err(Error::new(
        ErrorKind::Output,
        format!("{v} may not be written; a missing value is an empty field"),
    )
    .column(name))
}

/// Rows of numbers, with text in front, written to a file that appears whole or not at all.
#[derive(Debug)]
pub struct RowWriter {
    file: AtomicFile,
    columns: Vec<String>,
    buffer: Vec<u8>,
}

impl RowWriter {
    /// Begins a comma-separated file; `inputs` are files that may not be overwritten.
    ///
    /// # Errors
    /// As [`AtomicFile::create`].
    pub fn create(path: &Path, columns: &[String], inputs: &[&Path]) -> Result<Self> {
        let mut file = AtomicFile::create(path, inputs)?;
        let mut header = csv::Writer::from_writer(Vec::new());
        let fail = |e: String| Error::new(ErrorKind::Output, e);
        header
            .write_record(columns.iter().map(|c| harmless(c)))
            .map_err(|e| fail(e.to_string()))?;
        file.write_all(&header.into_inner().map_err(|e| fail(e.to_string()))?)?;
        Ok(Self {
            file,
            columns: columns.to_vec(),
            buffer: Vec::with_capacity(1 << 16),
        })
    }

    /// Writes one row of finite numbers.
    ///
    /// # Errors
    /// Another number of fields than columns, a number that is not finite, or a disk that refuses.
    pub fn row(&mut self, numbers: &[f64]) -> Result<()> {
        if numbers.len() != self.columns.len() {
            return Err(Error::new(
                ErrorKind::Output,
                format!(
                    "the row has {} fields, the file has {} columns",
                    numbers.len(),
                    self.columns.len()
                ),
            )
            .at(self.file.target()));
        }
        let mut digits = ryu::Buffer::new();
        for (i, (&v, name)) in numbers.iter().zip(&self.columns).enumerate() {
            finite(v, name).map_err(|e| e.at(self.file.target()))?;
            if i > 0 {
                self.buffer.push(b',');
            }
            self.buffer
                .extend_from_slice(digits.format_finite(v).as_bytes());
        }
        self.buffer.push(b'\n');
        if self.buffer.len() > (1 << 16) - 1024 {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<()> {
        self.file.write_all(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn commit(mut self) -> Result<()> {
        self.flush()?;
        self.file.commit()
    }
}

//! Parquet: numbers in columns, row group by row group, packed by snappy.
//!
//! **Source** `[PARQUET]`.

use super::{ParquetColumn, ParquetKind};
use crate::parquet::RECORDINGS;
use crate::{Error, Result};
use ::parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use ::parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::{EnabledStatistics, WriterProperties};
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::{ColumnPath, Type, TypePtr};
use std::io::Write;
use std::sync::Arc;
use std::{io, mem};

/// Whether Parquet can be written.
pub const PARQUET: bool = true;

/// What wrote a file.
pub(super) const CREATED_BY: &str = concat!("proofmass ", env!("CARGO_PKG_VERSION"));

/// A Parquet file in the making: bytes come out as row groups are put in.
pub struct ParquetWriter {
    writer: SerializedFileWriter<Bytes>,
    columns: Vec<ParquetColumn>,
}

/// Bytes that wait to be taken.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Write for Bytes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl ParquetWriter {
    /// A file of these columns; the unit of each stands in its metadata as `unit.NAME`.
    ///
    /// # Errors
    /// Two columns of one name.
    pub fn new(columns: Vec<ParquetColumn>) -> Result<Self> {
        let mut names: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
        names.sort_unstable();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Error::new(format!(
                "two columns of a Parquet file cannot have one name: \"{}\"",
                pair[0]
            ))
            .with_hint("choose columns of different names with --columns"));
        }
        let units = columns.iter().filter_map(|column| {
            let unit = column.unit.clone()?;
            Some(KeyValue::new(format!("unit.{}", column.name), unit))
        });
        let mut properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(CREATED_BY.to_owned())
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_dictionary_enabled(false)
            .set_key_value_metadata(Some(units.collect()));
        for column in &columns {
            if column.kind == ParquetKind::Word {
                let path = ColumnPath::new(vec![column.name.clone()]);
                properties = properties.set_column_dictionary_enabled(path, true);
            }
        }
        let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>();
        let schema = fields.and_then(|fields| {
            Type::group_type_builder("recording")
                .with_fields(fields)
                .build()
        });
        let schema = Arc::new(schema.map_err(refusal)?);
        let properties = Arc::new(properties.build());
        let writer = SerializedFileWriter::new(Bytes::default(), schema, properties);
        Ok(Self {
            writer: writer.map_err(refusal)?,
            columns,
        })
    }

    /// Appends a row group: the word of each column of words, and the numbers of each other one, NaN where a number is absent. The bytes
    /// that follow those before.
    ///
    /// # Errors
    /// Columns that are not equally long.
    pub fn rows(&mut self, words: &[String], numbers: &[Vec<f64>]) -> Result<Vec<u8>> {
        let rows = numbers.first().map_or(0, Vec::len);
        if numbers.iter().any(|n| n.len() != rows) {
            return Err(Error::new("columns of one row group are not equally long"));
        }
        self.row_group(rows, words, numbers).map_err(refusal)?;
        Ok(self.taken())
    }

    fn row_group(
        &mut self,
        rows: usize,
        words: &[String],
        numbers: &[Vec<f64>],
    ) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        let (mut words, mut numbers) = (words.iter(), numbers.iter());
        for column in &self.columns {
            let Some(mut chunk) = group.next_column()? else {
                break;
            };
            match column.kind {
                ParquetKind::Word => {
                    let word = words.next().map_or("", String::as_str);
                    let words = vec![ByteArray::from(word); rows];
                    chunk
                        .typed::<ByteArrayType>()
                        .write_batch(&words, None, None)?;
                }
                ParquetKind::Time => {
                    let times = numbers.next().map_or(&[][..], Vec::as_slice);
                    chunk.typed::<DoubleType>().write_batch(times, None, None)?;
                }
                ParquetKind::Signal => {
                    let all = numbers.next().map_or(&[][..], Vec::as_slice);
                    let there: Vec<f64> = all.iter().copied().filter(|v| !v.is_nan()).collect();
                    let levels: Vec<i16> = all.iter().map(|v| i16::from(!v.is_nan())).collect();
                    chunk
                        .typed::<DoubleType>()
                        .write_batch(&there, Some(&levels), None)?;
                }
            }
            chunk.close()?;
        }
        group.close()?;
        Ok(())
    }

    /// The index at the end. Of a table of several recordings it says how many row groups each of them has, by the name that it is chosen
    /// by when the table is read.
    ///
    /// # Errors
    /// None but those of the crate behind it.
    pub fn end(mut self, recordings: &[(String, usize)]) -> Result<Vec<u8>> {
        if recordings.len() > 1 {
            let lines = recordings
                .iter()
                .map(|(name, groups)| format!("{groups}\t{name}"));
            let lines = lines.collect::<Vec<_>>().join("\n");
            let about = KeyValue::new(RECORDINGS.to_owned(), lines);
            self.writer.append_key_value_metadata(about);
        }
        self.writer.finish().map_err(refusal)?;
        Ok(self.taken())
    }

    fn taken(&mut self) -> Vec<u8> {
        mem::take(&mut self.writer.inner_mut().0)
    }
}

/// A signal may be absent in every file, so that files of a data set have one schema.
fn field(column: &ParquetColumn) -> Result<TypePtr, ParquetError> {
    let (kind, repetition) = match column.kind {
        ParquetKind::Word => (Physical::BYTE_ARRAY, Repetition::REQUIRED),
        ParquetKind::Time => (Physical::DOUBLE, Repetition::REQUIRED),
        ParquetKind::Signal => (Physical::DOUBLE, Repetition::OPTIONAL),
    };
    let text = (kind == Physical::BYTE_ARRAY).then_some(LogicalType::String);
    let field = Type::primitive_type_builder(&column.name, kind)
        .with_repetition(repetition)
        .with_logical_type(text);
    Ok(Arc::new(field.build()?))
}

pub(super) fn refusal(error: ParquetError) -> Error {
    Error::new(format!(
        "the Parquet file cannot be written: {}",
        crate::parquet::words(error)
    ))
}

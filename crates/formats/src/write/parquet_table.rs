//! A table of texts, numbers and dates as Parquet, in one row group.

use super::parquet::{CREATED_BY, refusal};
use super::{TableCells, TableColumn};
use crate::{Error, Result};
use ::parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use ::parquet::column::writer::ColumnWriter;
use ::parquet::data_type::ByteArray;
use ::parquet::errors::ParquetError;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::{Type, TypePtr};
use std::sync::Arc;

/// The bytes of a Parquet file with these columns; each cell may be absent.
///
/// # Errors
/// Columns that are not equally long, or of one name.
pub fn parquet_table(columns: &[TableColumn]) -> Result<Vec<u8>> {
    let length = columns.first().map_or(0, |c| c.cells.len());
    if columns.iter().any(|c| c.cells.len() != length) {
        return Err(Error::new("columns of one table are not equally long"));
    }
    written(columns).map_err(refusal)
}

fn written(columns: &[TableColumn]) -> Result<Vec<u8>, ParquetError> {
    let fields: Vec<TypePtr> = columns.iter().map(field).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("table")
        .with_fields(fields)
        .build()?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(CREATED_BY.to_owned());
    let properties = Arc::new(properties.build());
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), properties)?;
    let mut group = writer.next_row_group()?;
    for column in columns {
        let Some(mut chunk) = group.next_column()? else {
            break;
        };
        match (&column.cells, chunk.untyped()) {
            (TableCells::Text(cells), ColumnWriter::ByteArrayColumnWriter(to)) => {
                let (there, levels) = split(cells, |text| ByteArray::from(text.as_str()));
                to.write_batch(&there, Some(&levels), None)?
            }
            (TableCells::Number(cells), ColumnWriter::DoubleColumnWriter(to)) => {
                let (there, levels) = split(cells, |number| *number);
                to.write_batch(&there, Some(&levels), None)?
            }
            (TableCells::Integer(cells), ColumnWriter::Int64ColumnWriter(to)) => {
                let (there, levels) = split(cells, |number| *number);
                to.write_batch(&there, Some(&levels), None)?
            }
            (TableCells::Date(cells), ColumnWriter::Int32ColumnWriter(to)) => {
                let (there, levels) = split(cells, |day| *day);
                to.write_batch(&there, Some(&levels), None)?
            }
            _ => return Err(ParquetError::General("a column of another kind".to_owned())),
        };
        chunk.close()?;
    }
    group.close()?;
    writer.into_inner()
}

/// The cells that are there, and for every row whether one is.
fn split<C, T>(cells: &[Option<C>], value: impl Fn(&C) -> T) -> (Vec<T>, Vec<i16>) {
    let levels = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    (cells.iter().flatten().map(value).collect(), levels)
}

fn field(column: &TableColumn) -> Result<TypePtr, ParquetError> {
    let (kind, logical) = match column.cells {
        TableCells::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        TableCells::Number(_) => (Physical::DOUBLE, None),
        TableCells::Integer(_) => (Physical::INT64, None),
        TableCells::Date(_) => (Physical::INT32, Some(LogicalType::Date)),
    };
    let field = Type::primitive_type_builder(&column.name, kind)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical);
    Ok(Arc::new(field.build()?))
}

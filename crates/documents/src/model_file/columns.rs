//! Inputs of a model file whose numbers are a column of a table.

use proofmass_io::sheet::Sheet;
use proofmass_io::{Error, ErrorKind, Input, Source};
use proofmass_uncertainty::{Refusal, UncertaintyModel};
use std::path::Path;

/// Why the numbers of an input could not be put in.
#[derive(Debug)]
pub enum ColumnTrouble {
    /// The table, with file, line and column.
    Table(Error),
    /// The entry of the model.
    Entry(Refusal),
}

/// Puts the numbers of tables into the inputs that name a `file`, which is looked for from `folder`; the tables, each
/// once, with their digests.
///
/// # Errors
/// A table that cannot be read or has no such column, a field that is not a finite number; an input that is stated twice.
pub fn fill_columns(
    model: &mut UncertaintyModel,
    folder: &Path,
) -> Result<Vec<Input>, ColumnTrouble> {
    let mut tables: Vec<(String, Sheet)> = Vec::new();
    for entry in &mut model.input {
        let Some(file) = entry.file.clone() else {
            continue;
        };
        let Some(column) = entry.column.clone() else {
            return Err(ColumnTrouble::Entry(Refusal::Incomplete {
                name: entry.name.clone(),
                needed: "beside `file`, the heading of its `column`",
            }));
        };
        if !tables.iter().any(|(name, _)| *name == file) {
            let source = Source::open(folder.join(&file)).map_err(ColumnTrouble::Table)?;
            let sheet = Sheet::from_source(source, "table").map_err(ColumnTrouble::Table)?;
            tables.push((file.clone(), sheet));
        }
        let Some((_, sheet)) = tables.iter_mut().find(|(name, _)| *name == file) else {
            continue;
        };
        let numbers = column_of(sheet, &column).map_err(ColumnTrouble::Table)?;
        let u = entry.u_column.as_ref().map(|u| column_of(sheet, u));
        let u = u.transpose().map_err(ColumnTrouble::Table)?;
        entry.fill(numbers, u).map_err(ColumnTrouble::Entry)?;
    }
    Ok(tables.into_iter().map(|(_, sheet)| sheet.input).collect())
}

/// Every number of a column.
fn column_of(sheet: &mut Sheet, heading: &str) -> Result<Vec<f64>, Error> {
    let place = sheet.text(heading);
    let place = place.ok_or_else(|| {
        Error::new(ErrorKind::Column, "the table has no such column")
            .at(Path::new(&sheet.input.path))
            .line(sheet.header_line())
            .column(heading)
            .with_hint(format!("its columns are: {}", sheet.header().join(", ")))
    })?;
    sheet.rows().map(|row| row.number(place)).collect()
}

//! `trials.csv` beside a result.json: the trials of quantities that no covariance states.

use crate::{ResultDocument, StatedQuantity};
use proofmass_io::{Error, ErrorKind, Result, Source};
use proofmass_uncertainty::{TrialColumn, TrialTable};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Name of the file in a folder of results.
pub const TRIALS: &str = "trials.csv";
/// Section of result.json that names it.
pub const TRIALS_SECTION: &str = "trials";

/// What result.json says of the file: its digest, and what its columns are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TrialFile {
    /// Name, in the folder of result.json.
    pub file: String,
    /// SHA-256 in hexadecimal digits.
    pub sha256: String,
    /// Rows under the heading.
    pub rows: usize,
    /// Columns in order, without their trials.
    pub columns: Vec<TrialColumn>,
}

impl TrialFile {
    /// The file of a table, with its bytes.
    ///
    /// # Errors
    /// None in practice.
    pub fn of(table: &TrialTable) -> Result<(Self, Vec<u8>)> {
        let mut text = String::new();
        for (k, column) in table.columns.iter().enumerate() {
            let what = if column.cause { "cause" } else { "quantity" };
            let name = column.name.replace('"', "\"\"");
            let _ = write!(text, "{}\"{what} {name}\"", if k > 0 { "," } else { "" });
        }
        text.push('\n');
        for row in 0..table.rows() {
            for (k, column) in table.columns.iter().enumerate() {
                let z = column.trials[row];
                let _ = write!(text, "{}{z}", if k > 0 { "," } else { "" });
            }
            text.push('\n');
        }
        let bytes = text.into_bytes();
        let file = Self {
            file: TRIALS.to_owned(),
            sha256: Source::from_bytes(TRIALS, bytes.clone())?.finish()?.sha256,
            rows: table.rows(),
            columns: table
                .columns
                .iter()
                .map(|c| TrialColumn {
                    trials: Vec::new(),
                    ..c.clone()
                })
                .collect(),
        };
        Ok((file, bytes))
    }

    /// That of a result, where it has one.
    ///
    /// # Errors
    /// The section is damaged.
    pub fn in_result(document: &ResultDocument) -> Result<Option<Self>> {
        let Some(section) = document.extra.get(TRIALS_SECTION) else {
            return Ok(None);
        };
        let file = Self::deserialize(section).map_err(|e| {
            Error::new(
                ErrorKind::Format,
                format!("the section of its trials is damaged: {e}"),
            )
            .because(e)
        })?;
        if file.file.contains(['/', '\\', '\0']) || file.file == ".." {
            return Err(Error::new(
                ErrorKind::Format,
                format!("names a file outside of its folder: {:?}", file.file),
            ));
        }
        Ok(Some(file))
    }

    /// The table, from the bytes of the file, for the result that names it.
    ///
    /// # Errors
    /// Other bytes than those that were written with the result; trials that are not of what the result states.
    pub fn table(&self, bytes: Vec<u8>, result: &ResultDocument) -> Result<TrialTable> {
        let table = self.rows_of(bytes)?;
        for column in table.columns.iter().filter(|c| !c.cause) {
            let stated = result.quantities.iter().find(|q| q.name == column.name);
            if !stated.is_some_and(|q| is_of(column, q)) {
                return Err(Error::new(
                    ErrorKind::Format,
                    "its trials are not of what the result states",
                )
                .column(&column.name)
                .with_hint("one of both was changed: evaluate the result again"));
            }
        }
        Ok(table)
    }

    fn rows_of(&self, bytes: Vec<u8>) -> Result<TrialTable> {
        let wrong = |what: &str| Error::new(ErrorKind::Format, what);
        if Source::from_bytes(&*self.file, bytes.clone())?
            .finish()?
            .sha256
            != self.sha256
        {
            return Err(
                wrong("is not the file that was written with the result").with_hint(
                    "fetch both again from where they were computed, or compute them anew",
                ),
            );
        }
        let damaged = || wrong("does not hold the columns that the result names");
        let text = String::from_utf8(bytes).map_err(|_| damaged())?;
        let mut columns = self.columns.clone();
        for (k, line) in text.lines().enumerate().skip(1) {
            let mut fields = line.split(',');
            for column in &mut columns {
                let z: Option<f64> = fields.next().and_then(|field| field.parse().ok());
                let z = z.filter(|z| z.is_finite());
                column
                    .trials
                    .push(z.ok_or_else(|| damaged().line(k as u64 + 1))?);
            }
        }
        let table = TrialTable { columns };
        match table.rows() == self.rows && self.rows > 1 {
            true => Ok(table),
            false => Err(damaged()),
        }
    }
}

/// Trials that an interval rests on at least.
const LEAST: f64 = 10_000.0;

/// Whether these are trials of the quantity: its unit and value, by the road that states it; where Monte Carlo does, the stated
/// interval holds its share of them.
fn is_of(column: &TrialColumn, stated: &StatedQuantity) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * column.scale.abs() + 1e-12 * a.abs();
    let by_law = stated.method.as_deref() == Some("law-of-propagation");
    if column.unit != stated.unit
        || !near(column.value, stated.value)
        || !stated.u.is_none_or(|u| near(column.scale, u))
        || column.by_trials == by_law
    {
        return false;
    }
    if stated.method.as_deref() != Some("monte-carlo") {
        return true;
    }
    let reach = stated.expanded;
    let [low, high] = stated
        .interval
        .unwrap_or([stated.value - reach, stated.value + reach]);
    let inside = column.trials.iter().filter(|y| (low..=high).contains(*y));
    let share = inside.count() as f64 / column.trials.len() as f64;
    // Five standard deviations.
    let p = stated.probability;
    (share - p).abs() <= 5.0 * (p * (1.0 - p) / LEAST).sqrt()
}

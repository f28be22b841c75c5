//! The columns of a row type, declared once: file, page and terminal are made from it.

use crate::document::{Alignment, Cell, Column, Table};
use crate::number::{freedom, plain, scientific, two_digits};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// How the values of a column are printed on a page. A file holds them whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Rounding {
    /// As many digits as bring the number back.
    #[default]
    Exact,
    /// So many decimals.
    Decimals(u8),
    /// So many decimals, with a sign always.
    Signed(u8),
    /// So many significant digits, with a power of ten where it is shorter.
    Significant(u8),
    /// So many decimals of a number with a power of ten.
    Power(u8),
    /// Three decimals at most and no needless zeros.
    Plain,
    /// Two significant digits.
    TwoDigits,
    /// Degrees of freedom: `> 9999` where Student's t is the normal distribution.
    Freedom,
}

impl Rounding {
    /// A number as it is printed.
    pub fn text(self, value: f64) -> String {
        match self {
            Self::Exact => value.to_string(),
            Self::Decimals(n) => format!("{value:.*}", usize::from(n)),
            Self::Signed(n) => format!("{value:+.*}", usize::from(n)),
            Self::Significant(n) => scientific(value, usize::from(n)),
            Self::Power(n) => format!("{value:.*e}", usize::from(n)),
            Self::Plain => plain(value),
            Self::TwoDigits => two_digits(value),
            Self::Freedom => freedom(value),
        }
    }
}

/// One column of a row type: its name in a file, its heading on a page, and where its value comes from.
///
/// ```
/// use proofmass_report::{Cell, Field, Rounding, Table};
///
/// struct Reading { angle: f64, output: (f64, f64), label: &'static str }
/// let fields = [
///     Field::new("label", |r: &Reading| r.label.into()).page("reading", ""),
///     Field::new("angle_rad", |r: &Reading| r.angle.into()).page("angle", "°").scaled(57.29577951308232).rounded(Rounding::Decimals(1)),
///     Field::estimate("output_V", "u_output_V", |r: &Reading| Some(r.output)).page("output", "V"),
/// ];
/// let readings = [Reading { angle: 0.5, output: (0.98, 0.001), label: "a" }];
/// let table = Table::of("Readings", fields, &readings).file("readings.csv");
/// assert_eq!(table.rows[0][1], Cell::Value(0.5));
/// let (names, rows) = table.records();
/// assert_eq!(names, ["label", "angle_rad", "output_V", "u_output_V"]);
/// assert_eq!(rows[0][3], Cell::Value(0.001));
/// ```
pub struct Field<'a, R> {
    column: Column,
    get: Box<dyn Fn(&R) -> Cell + 'a>,
}

impl<'a, R> Field<'a, R> {
    /// A column of a file, with the name it has there (unit included: `bias_m/s2`); an empty name keeps it out of the file.
    ///
    /// Without [`page`](Self::page) no page shows it.
    pub fn new(name: impl Into<String>, get: impl Fn(&R) -> Cell + 'a) -> Self {
        Self {
            column: Column {
                name: name.into(),
                alignment: Alignment::Decimal,
                ..Column::default()
            },
            get: Box::new(get),
        }
    }

    /// Two columns of a file, a value and its standard uncertainty; one of a page, `value(u)`.
    pub fn estimate(
        name: impl Into<String>,
        uncertainty: impl Into<String>,
        get: impl Fn(&R) -> Option<(f64, f64)> + 'a,
    ) -> Self {
        let pair = move |row: &R| get(row).map_or(Cell::Empty, |(v, u)| Cell::Estimate(v, u));
        let mut field = Self::new(name, pair);
        field.column.uncertainty = uncertainty.into();
        field
    }

    /// A column of the page alone, under this heading and unit.
    pub fn shown(
        heading: impl Into<String>,
        unit: impl Into<String>,
        get: impl Fn(&R) -> Cell + 'a,
    ) -> Self {
        Self::new("", get).page(heading, unit)
    }

    /// Shows it on the page, under this heading and unit.
    #[must_use]
    pub fn page(mut self, heading: impl Into<String>, unit: impl Into<String>) -> Self {
        self.column.heading = heading.into();
        self.column.unit = unit.into();
        self
    }

    /// How the page rounds its values.
    #[must_use]
    pub fn rounded(mut self, rounding: Rounding) -> Self {
        self.column.rounding = rounding;
        self
    }

    /// The page rounds its values to so many decimals.
    #[must_use]
    pub fn decimals(self, count: u8) -> Self {
        self.rounded(Rounding::Decimals(count))
    }

    /// What the values are multiplied by to be in the unit of the page.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.column.scale = Some(factor);
        self
    }

    /// Aligned left, as text is.
    #[must_use]
    pub fn left(mut self) -> Self {
        self.column.alignment = Alignment::Left;
        self
    }
}

impl<'a> Field<'a, usize> {
    /// A column from a series, for tables whose rows are the places in several; empty where it has ended.
    pub fn series(name: impl Into<String>, values: impl Into<Cow<'a, [f64]>>) -> Self {
        let values = values.into();
        Self::new(name, move |k: &usize| values.get(*k).copied().into())
    }
}

impl Table {
    /// The table of these rows.
    pub fn of<'r, R: 'r>(
        caption: impl Into<String>,
        fields: impl IntoIterator<Item = Field<'r, R>>,
        rows: impl IntoIterator<Item = impl std::borrow::Borrow<R>>,
    ) -> Self {
        let fields: Vec<Field<'r, R>> = fields.into_iter().collect();
        let cells = |row: &R| fields.iter().map(|f| (f.get)(row)).collect();
        let rows: Vec<Vec<Cell>> = rows.into_iter().map(|row| cells(row.borrow())).collect();
        let mut columns: Vec<Column> = fields.into_iter().map(|f| f.column).collect();
        // A column of words stands left.
        for (i, column) in columns.iter_mut().enumerate() {
            let mut filled = rows.iter().map(|r| &r[i]).filter(|c| **c != Cell::Empty);
            if filled.clone().next().is_some() && filled.all(Cell::is_text) {
                column.alignment = Alignment::Left;
            }
        }
        Self {
            caption: caption.into(),
            columns,
            rows,
            ..Self::default()
        }
    }

    /// Names and rows as a file has them: numbers whole, a value and its uncertainty in two columns.
    pub fn records(&self) -> (Vec<String>, Vec<Vec<Cell>>) {
        let filed: Vec<usize> = (0..self.columns.len())
            .filter(|i| !self.columns[*i].name.is_empty())
            .collect();
        let mut names = Vec::new();
        for &i in &filed {
            let column = &self.columns[i];
            names.push(column.name.clone());
            if !column.uncertainty.is_empty() {
                names.push(column.uncertainty.clone());
            }
        }
        let record = |row: &Vec<Cell>| {
            let mut record = Vec::with_capacity(names.len());
            for &i in &filed {
                match &row[i] {
                    Cell::Estimate(value, u) => {
                        record.extend([Cell::Value(*value), Cell::Value(*u)]);
                    }
                    cell => {
                        record.push(match cell {
                            Cell::Worded { file, .. } => (**file).clone(),
                            Cell::Linked { text, .. } => Cell::Text(text.clone()),
                            cell => cell.clone(),
                        });
                        if !self.columns[i].uncertainty.is_empty() {
                            record.push(Cell::Empty);
                        }
                    }
                }
            }
            record
        };
        let rows = self.rows.iter().map(record).collect();
        (names, rows)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Value(value)
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        Self::Number {
            text: value.to_string(),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Empty, Into::into)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::cell_text;

    #[test]
    fn law_a_file_has_what_a_page_words() {
        let fields = [
            Field::new("limit_V", |v: &Option<f64>| {
                let limit = Cell::from(*v);
                limit.worded(if v.is_some() { "< -2" } else { "–" })
            })
            .page("limit", "V"),
            Field::shown("sure", "", |v: &Option<f64>| v.map(|_| "yes").into()),
        ];
        let table = Table::of("", fields, [Some(1.5), None]);
        let printed = |i: usize| cell_text(&table.rows[i][0], &table.columns[0], i);
        assert_eq!(printed(0), Ok("< -2".into()));
        assert_eq!(printed(1), Ok("–".into()));
        let (names, rows) = table.records();
        assert_eq!(names, ["limit_V"]);
        assert_eq!(rows, [[Cell::Value(1.5)], [Cell::Empty]]);
    }
}

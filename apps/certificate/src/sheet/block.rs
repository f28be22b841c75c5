//! The blocks of a sheet, as they follow each other on its pages.

use serde_json::Value;

use super::Reader;
use super::text::{filled, glyphs, text};
use crate::error::Result;
use crate::mathematics;
use crate::place::Place;

impl Reader {
    pub(super) fn block(&mut self, block: &Place) -> Result<()> {
        let kind = block.member("kind")?.one_of(&[
            "heading",
            "paragraph",
            "fields",
            "table",
            "figure",
            "signatures",
            "page_break",
            "end",
        ])?;
        match kind {
            "heading" => {
                block.only(&["kind", "level", "text"])?;
                filled(&block.member("text")?)?;
                self.heading(&block.member("level")?)
            }
            "paragraph" => {
                block.only(&["kind", "text"])?;
                self.runs(&block.member("text")?)
            }
            "fields" => {
                block.only(&["kind", "rows"])?;
                for row in block.member("rows")?.list()? {
                    let pair = row.list_of(2)?;
                    text(&pair[0])?;
                    self.runs(&pair[1])?;
                }
                Ok(())
            }
            "table" => self.table(block),
            "figure" => {
                block.only(&["kind", "caption", "label", "svg", "alternative"])?;
                text(&block.member("label")?)?;
                self.runs(&block.member("caption")?)?;
                filled(&block.member("alternative")?)?;
                self.drawing(&block.member("svg")?)
            }
            "signatures" => {
                block.only(&["kind", "rows"])?;
                for row in block.member("rows")?.list()? {
                    row.only(&["name", "role", "date"])?;
                    for name in ["name", "role", "date"] {
                        text(&row.member(name)?)?;
                    }
                }
                Ok(())
            }
            "page_break" => block.only(&["kind"]),
            _ => {
                block.only(&["kind", "text"])?;
                filled(&block.member("text")?)
            }
        }
    }

    /// Headings go down by one level at a time, as tagged PDF wants them.
    fn heading(&mut self, level: &Place) -> Result<()> {
        let n = level.integer()?;
        if !(1..=self.level + 1).contains(&n) || n > 3 {
            return Err(level.error(
                format!(
                    "a heading of level {n} cannot follow one of level {}",
                    self.level
                ),
                "begin with level 1, go down by one level at a time, and not below 3",
            ));
        }
        self.level = n;
        Ok(())
    }

    fn table(&mut self, table: &Place) -> Result<()> {
        table.only(&["kind", "caption", "label", "columns", "rows", "notes"])?;
        text(&table.member("label")?)?;
        self.runs(&table.member("caption")?)?;
        let columns = table.member("columns")?;
        let n = columns.list()?.len();
        if n == 0 {
            return Err(columns.error(
                "a table without columns",
                "give it columns, or leave the table out",
            ));
        }
        for column in columns.list()? {
            column.only(&["heading", "unit", "align"])?;
            self.runs(&column.member("heading")?)?;
            if let Some(unit) = column.optional("unit")? {
                text(&unit)?;
            }
            column.member("align")?.one_of(&["number", "text"])?;
        }
        for row in table.member("rows")?.list()? {
            for cell in row.list_of(n)? {
                match cell.value() {
                    Value::Array(_) => self.runs(&cell)?,
                    _ => text(&cell)?,
                }
            }
        }
        if let Some(notes) = table.optional("notes")? {
            for note in notes.list()? {
                self.runs(&note)?;
            }
        }
        Ok(())
    }

    fn runs(&mut self, runs: &Place) -> Result<()> {
        for run in runs.list()? {
            run.only(&["text", "math", "number"])?;
            let given = [
                run.optional("text")?,
                run.optional("math")?,
                run.optional("number")?,
            ];
            match given {
                [Some(words), None, None] | [None, None, Some(words)] => text(&words)?,
                [None, Some(formula), None] => {
                    glyphs(&formula)?;
                    mathematics::check(&formula)?;
                    self.formulas
                        .push((formula.text()?.to_owned(), formula.path().to_owned()));
                }
                _ => {
                    return Err(run.error(
                        "a run holds one of \"text\", \"math\" and \"number\"",
                        "make a run of its own of each",
                    ));
                }
            }
        }
        Ok(())
    }
}

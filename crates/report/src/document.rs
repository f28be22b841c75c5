//! The document: sections of blocks, without a word about how they look.

use crate::Plot;
use crate::number::minus_signs;
use proofmass_uncertainty::{Finding, Quantity};

/// A report as data.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Title, on top and in the window.
    pub title: String,
    /// One line under the title; empty for none.
    pub subtitle: String,
    /// Language of the text as a BCP 47 tag, `en` by default.
    pub language: String,
    /// Label and value of what a reader files it by: device, date, operator, version.
    pub meta: Vec<(String, String)>,
    /// What to doubt, shown before everything else.
    pub findings: Vec<Finding>,
    /// The sections, in order.
    pub sections: Vec<Section>,
    /// Last line; empty for none.
    pub footer: String,
}

/// A titled part of a report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Heading.
    pub title: String,
    /// What stands in it, in order.
    pub blocks: Vec<Block>,
}

/// One piece of a section.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// Running text.
    Paragraph(String),
    /// A table.
    Table(Table),
    /// A plot with its caption.
    Figure(Figure),
    /// Findings, boxed by severity.
    Findings(Vec<Finding>),
    /// The few numbers a reader came for.
    KeyFigures(Vec<KeyFigure>),
    /// Text in which every space counts.
    Code(String),
    /// Small tables beside each other, as many in a line as the page is wide.
    Beside(Vec<Table>),
    /// What only some readers open: a title and the blocks behind it. On paper it is open; in the terminal only
    /// its title is printed.
    Folded {
        /// What is inside.
        title: String,
        /// The blocks.
        blocks: Vec<Block>,
    },
}

/// One number a reader came for.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyFigure {
    /// What it is.
    pub label: String,
    /// The number as printed.
    pub value: String,
    /// Its unit; empty for none.
    pub unit: String,
    /// A small line below; empty for none.
    pub note: String,
}

/// Columns, rows and notes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Caption; empty for none.
    pub caption: String,
    /// The columns, left to right.
    pub columns: Vec<Column>,
    /// The rows; each as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
    /// Notes below the table.
    pub notes: Vec<String>,
}

/// Heading, unit and alignment of a table column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Heading.
    pub heading: String,
    /// Unit of all numbers in the column; empty for none or where units differ.
    pub unit: String,
    /// How cells are aligned.
    pub alignment: Alignment,
}

/// How the cells of a column are aligned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Alignment {
    /// Left, for text.
    #[default]
    Left,
    /// Centred.
    Centre,
    /// Right.
    Right,
    /// On the decimal point, the block of numbers centred under its heading.
    Decimal,
}

/// One entry of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Cell {
    /// Text.
    Text(String),
    /// A number as printed by the caller; a leading hyphen becomes a minus sign, `e-5` a power of ten.
    Number {
        /// The digits.
        text: String,
    },
    /// A quantity, printed as it prints itself, `value(u)` with two digits of standard uncertainty; its unit
    /// follows where the column does not state the same one.
    Quantity(Quantity),
    /// Nothing known; shown as an empty place.
    #[default]
    Empty,
}

/// A plot with its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Caption.
    pub caption: String,
    /// What is drawn.
    pub plot: Plot,
}

impl Report {
    /// An empty report in English.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            language: "en".into(),
            ..Self::default()
        }
    }

    /// Sets the line under the title.
    #[must_use]
    pub fn subtitle(mut self, text: impl Into<String>) -> Self {
        self.subtitle = minus_signs(text);
        self
    }

    /// Adds one label and value to the head.
    #[must_use]
    pub fn meta(mut self, label: impl Into<String>, value: impl Into<String>) -> Self {
        self.meta.push((label.into(), value.into()));
        self
    }

    /// Adds findings to the head.
    #[must_use]
    pub fn findings(mut self, findings: impl IntoIterator<Item = Finding>) -> Self {
        self.findings.extend(findings);
        self
    }

    /// Adds a section.
    #[must_use]
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// Sets the last line.
    #[must_use]
    pub fn footer(mut self, text: impl Into<String>) -> Self {
        self.footer = text.into();
        self
    }
}

impl Section {
    /// An empty section.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            blocks: Vec::new(),
        }
    }

    /// Adds any block.
    #[must_use]
    pub fn block(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }

    /// Adds running text.
    #[must_use]
    pub fn paragraph(self, text: impl Into<String>) -> Self {
        self.block(Block::Paragraph(text.into()))
    }

    /// Adds a table.
    #[must_use]
    pub fn table(self, table: Table) -> Self {
        self.block(Block::Table(table))
    }

    /// Adds a plot with its caption.
    #[must_use]
    pub fn figure(self, caption: impl Into<String>, plot: impl Into<Plot>) -> Self {
        self.block(Block::Figure(Figure {
            caption: caption.into(),
            plot: plot.into(),
        }))
    }

    /// Adds small tables beside each other.
    #[must_use]
    pub fn beside(self, tables: impl IntoIterator<Item = Table>) -> Self {
        self.block(Block::Beside(tables.into_iter().collect()))
    }

    /// Adds blocks that only some readers open.
    #[must_use]
    pub fn folded(self, title: impl Into<String>, blocks: impl IntoIterator<Item = Block>) -> Self {
        self.block(Block::Folded {
            title: title.into(),
            blocks: blocks.into_iter().collect(),
        })
    }

    /// Adds the names and digests of input files; a long list is folded.
    #[must_use]
    pub fn inputs(self, files: &[(String, String)]) -> Self {
        /// Files that are listed openly.
        const FEW: usize = 12;
        let mut table = Table::new("Inputs", [Column::text("file"), Column::text("SHA-256")]);
        for (name, digest) in files {
            table = table.row([Cell::text(name.clone()), Cell::text(digest.clone())]);
        }
        match files.len() {
            0 => self,
            n if n <= FEW => self.table(table),
            n => self.folded(
                format!("{n} input files with their SHA-256"),
                [Block::Table(table)],
            ),
        }
    }

    /// Adds key figures.
    #[must_use]
    pub fn key_figures(self, figures: impl IntoIterator<Item = KeyFigure>) -> Self {
        self.block(Block::KeyFigures(figures.into_iter().collect()))
    }
}

impl KeyFigure {
    /// A key figure without a note.
    pub fn new(
        label: impl Into<String>,
        value: impl Into<String>,
        unit: impl Into<String>,
    ) -> Self {
        Self {
            label: label.into(),
            value: value.into(),
            unit: unit.into(),
            note: String::new(),
        }
    }

    /// Sets the small line below.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = minus_signs(note);
        self
    }
}

impl Table {
    /// A table without rows.
    pub fn new(caption: impl Into<String>, columns: impl IntoIterator<Item = Column>) -> Self {
        Self {
            caption: caption.into(),
            columns: columns.into_iter().collect(),
            ..Self::default()
        }
    }

    /// Adds a row.
    #[must_use]
    pub fn row(mut self, cells: impl IntoIterator<Item = Cell>) -> Self {
        self.rows.push(cells.into_iter().collect());
        self
    }

    /// Adds a note below the table.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }
}

impl Column {
    /// A column of text, aligned left.
    pub fn text(heading: impl Into<String>) -> Self {
        Self {
            heading: heading.into(),
            unit: String::new(),
            alignment: Alignment::Left,
        }
    }

    /// A column of numbers, aligned on the decimal point.
    pub fn number(heading: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            heading: heading.into(),
            unit: unit.into(),
            alignment: Alignment::Decimal,
        }
    }

    /// Changes the alignment.
    #[must_use]
    pub fn aligned(mut self, alignment: Alignment) -> Self {
        self.alignment = alignment;
        self
    }

    /// Whether a unit is stated: `1`, the unit of pure numbers, is not printed.
    pub(crate) fn printed_unit(&self) -> Option<&str> {
        (!self.unit.is_empty() && self.unit != "1").then_some(self.unit.as_str())
    }
}

impl Cell {
    /// Text.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// A number as printed by the caller.
    pub fn number(text: impl Into<String>) -> Self {
        Self::Number { text: text.into() }
    }
}

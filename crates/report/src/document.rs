//! The document: sections of blocks, without a word about how they look.

use crate::columns::Rounding;
use crate::grouping::standing;
use crate::number::minus_signs;
use crate::{Plot, SeatPlot};
use proofmass_uncertainty::{Finding, Quantity};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A report as data.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Report {
    /// Title, on top and in the window.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// One line under the title; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) subtitle: String,
    /// What was read and how, in the first lines under both; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) read: String,
    /// Language of the text as a BCP 47 tag, `en` by default.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub language: String,
    /// Label and value of what a reader files it by: device, date, operator, version.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub meta: Vec<(String, String)>,
    /// What a reader came for; it opens the page.
    #[serde(default, skip_serializing_if = "is_default")]
    pub answer: Answer,
    /// What to doubt, one line each behind the answer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) findings: Vec<Finding>,
    /// The sections, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sections: Vec<Section>,
    /// Last line; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) footer: String,
}

/// What a reader came for, on the first screen: the result with its uncertainty, the verdict, the plot that shows it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Answer {
    /// What the result means, as a sentence; empty where the numbers say it all.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub verdict: String,
    /// Whether there is no result yet, so that no finding speaks for or against one.
    #[serde(default, skip_serializing_if = "is_default")]
    pub(crate) open: bool,
    /// The result.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<KeyFigure>,
    /// What is copied from the page, such as coefficients for firmware.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub blocks: Vec<Block>,
    /// The plot that shows it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub figure: Option<Figure>,
}

/// A titled part of a report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Section {
    /// Where it is printed.
    #[serde(default, skip_serializing_if = "is_default")]
    pub(crate) place: Place,
    /// Heading.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) title: String,
    /// What stands in it, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) blocks: Vec<Block>,
    /// Whether paper has the title alone.
    #[serde(default, skip_serializing_if = "is_default")]
    pub(crate) off_paper: bool,
}

/// Where a section is printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// On the page alone, folded behind its title.
    #[default]
    Page,
    /// On the page, open, and in the summary of a terminal.
    Both,
    /// In the summary of a terminal alone.
    Summary,
    /// Nowhere: only files have its tables.
    File,
}

/// One piece of a section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
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
    /// What only some readers open: a title and the blocks behind it. On paper it is open, or has its title alone; in the terminal only
    /// its title is printed.
    Folded {
        /// What is inside.
        title: String,
        /// The blocks.
        blocks: Vec<Block>,
        /// Whether paper has the title alone: what somebody looks a number up in who has the page or its files at hand.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        off_paper: bool,
    },
}

/// One number a reader came for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KeyFigure {
    /// What it is.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) label: String,
    /// The number as printed.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) value: String,
    /// Its unit; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) unit: String,
    /// A small line below; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) note: String,
}

/// Columns, rows and notes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Table {
    /// Name of the file that holds the table as CSV; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub file: String,
    /// Caption; empty for none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub caption: String,
    /// The columns, left to right.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<Column>,
    /// The rows; each as long as `columns`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<Vec<Cell>>,
    /// Notes below the table.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

impl Table {
    /// Whether every row is as long as the columns.
    fn is_whole(&self) -> bool {
        self.rows.iter().all(|row| row.len() == self.columns.len())
    }
}

/// Heading, unit and alignment of a table column, its name in a file and how its numbers are rounded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Column {
    /// Name in the file, unit included (`bias_m/s2`); empty where only the page shows the column.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) name: String,
    /// Name of the standard uncertainty in the file, where the cells are values with theirs.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) uncertainty: String,
    /// Heading on the page; empty where only the file has the column.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) heading: String,
    /// Unit of all numbers in the column; empty for none or where units differ.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) unit: String,
    /// How cells are aligned.
    #[serde(default, skip_serializing_if = "is_default")]
    pub(crate) alignment: Alignment,
    /// What a value of the file is multiplied by to be in the unit of the page.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) scale: Option<f64>,
    /// How values are printed on the page.
    #[serde(default, skip_serializing_if = "is_default")]
    pub(crate) rounding: Rounding,
}

/// How the cells of a column are aligned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Cell {
    /// A number as it is: a file holds it whole, a page rounds it as its column says.
    Value(f64),
    /// A value and its standard uncertainty: two columns of a file (`x`, `u_x`), `value(u)` on a page.
    Estimate(f64, f64),
    /// Text.
    Text(String),
    /// A number as printed by the caller; a leading hyphen becomes a minus sign, `e-5` a power of ten.
    Number {
        /// The digits.
        #[serde(rename = "number")]
        text: String,
    },
    /// A quantity, printed as it prints itself, `value(u)` with two digits of standard uncertainty; its unit
    /// follows where the column does not state the same one.
    Quantity(Box<Quantity>),
    /// A cell of a file that a page puts in other words: a limit of a number, the name behind a symbol.
    Worded {
        /// What the file has.
        file: Box<Self>,
        /// What the page prints.
        text: String,
    },
    /// Text that leads to another page of the same folder.
    Linked {
        /// The text.
        text: String,
        /// File name of the page.
        page: String,
    },
    /// Nothing known; shown as an empty place.
    #[default]
    Empty,
}

/// A plot with its caption.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Figure {
    /// Caption.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) caption: String,
    /// What is drawn.
    pub(crate) plot: Plot,
}

impl Figure {
    /// A plot with its caption.
    pub fn new(caption: impl Into<String>, plot: impl Into<Plot>) -> Self {
        Self {
            caption: caption.into(),
            plot: plot.into(),
        }
    }

    /// The drawing; `id` makes its names different from those of other drawings of a page.
    ///
    /// # Errors
    /// A number that cannot be drawn.
    pub fn svg(&self, id: &str) -> Result<String, crate::Error> {
        self.plot.svg(&self.caption, id)
    }
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

    /// What was read and how; a further call is a further line.
    #[must_use]
    pub fn reading(mut self, line: impl Into<String>) -> Self {
        if !self.read.is_empty() {
            self.read.push('\n');
        }
        self.read.push_str(&line.into());
        self
    }

    /// What was read, where no line says it yet.
    #[must_use]
    pub fn reading_at_least(self, line: impl Into<String>) -> Self {
        match self.read.is_empty() {
            true => self.reading(line),
            false => self,
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

    /// Says what the result means.
    #[must_use]
    pub fn verdict(mut self, sentence: impl Into<String>) -> Self {
        self.answer.verdict = minus_signs(sentence);
        self
    }

    /// Says what is missing to a result: findings speak neither for nor against one.
    #[must_use]
    pub fn question(mut self, sentence: impl Into<String>) -> Self {
        self.answer.open = true;
        self.verdict(sentence)
    }

    /// Adds the numbers that are the answer.
    #[must_use]
    pub fn answers(mut self, figures: impl IntoIterator<Item = KeyFigure>) -> Self {
        self.answer.figures.extend(figures);
        self
    }

    /// Adds to the answer what is copied from the page.
    #[must_use]
    pub fn copied(mut self, block: Block) -> Self {
        self.answer.blocks.push(block);
        self
    }

    /// Sets the plot that shows the answer.
    #[must_use]
    pub fn shown_by(mut self, caption: impl Into<String>, plot: impl Into<Plot>) -> Self {
        self.answer.figure = Some(Figure {
            caption: caption.into(),
            plot: plot.into(),
        });
        self
    }

    /// The report with its answer first: numbers and plot that nobody named are the first ones of the sections.
    #[must_use]
    pub fn answer_first(mut self) -> Self {
        if self.answer.figures.is_empty()
            && let Some(Block::KeyFigures(figures)) =
                self.taken(|b| matches!(b, Block::KeyFigures(_)))
        {
            self.answer.figures = figures;
        }
        if self.answer.figure.is_none()
            && let Some(Block::Figure(figure)) = self.taken(|b| matches!(b, Block::Figure(_)))
        {
            self.answer.figure = Some(figure);
        }
        self.sections.retain(|s| !s.blocks.is_empty());
        self
    }

    /// What the findings say of the result as a whole, where there is one.
    pub(crate) fn standing(&self) -> String {
        match self.answer.open {
            true => String::new(),
            false => standing(&self.findings),
        }
    }

    /// Whether there is neither an answer nor a finding: a collection of sections.
    pub(crate) fn says_nothing(&self) -> bool {
        is_default(&self.answer) && self.findings.is_empty()
    }

    /// Takes the first block of a kind out of the sections of the page.
    fn taken(&mut self, wanted: impl Fn(&Block) -> bool) -> Option<Block> {
        let sections = self.sections.iter_mut();
        let mut shown = sections.filter(|s| matches!(s.place, Place::Page | Place::Both));
        shown.find_map(|section| {
            let at = section.blocks.iter().position(&wanted)?;
            Some(section.blocks.remove(at))
        })
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

    /// The sections for a place: the page, or else the summary of a terminal, which has no figures.
    #[must_use]
    pub fn of(mut self, place: Place) -> Self {
        self.sections
            .retain(|s| s.place == Place::Both || s.place == place);
        if place == Place::Summary {
            self.footer.clear();
            self.answer.figure = None;
            for section in &mut self.sections {
                section.blocks.retain(|b| !matches!(b, Block::Figure(_)));
                if section.place == Place::Both {
                    section.blocks.iter_mut().for_each(cut);
                }
            }
            self.sections.retain(|s| !s.blocks.is_empty());
        }
        self
    }

    /// The report as it is kept with a result: plots with no more points and digits than can be seen.
    #[must_use]
    pub fn shortened(mut self) -> Self {
        fn shorten(blocks: &mut [Block]) {
            for block in blocks {
                match block {
                    Block::Figure(figure) => {
                        let plot = std::mem::replace(&mut figure.plot, Plot::Seat(SeatPlot));
                        figure.plot = plot.shortened();
                    }
                    Block::Folded { blocks, .. } => shorten(blocks),
                    _ => {}
                }
            }
        }
        if let Some(figure) = self.answer.figure.take() {
            self.answer.figure = Some(Figure {
                plot: figure.plot.shortened(),
                caption: figure.caption,
            });
        }
        for section in &mut self.sections {
            shorten(&mut section.blocks);
        }
        self
    }

    /// The report without the tables that only files have and that hold more cells than this.
    #[must_use]
    pub fn without_long_files(&self, cells: usize) -> Self {
        let long = |block: &&Block| match block {
            Block::Table(table) => table.rows.len() * table.columns.len() > cells,
            _ => false,
        };
        let kept = |section: &Section| Section {
            blocks: match section.place {
                Place::File => section
                    .blocks
                    .iter()
                    .filter(|b| !long(b))
                    .cloned()
                    .collect(),
                _ => section.blocks.clone(),
            },
            place: section.place,
            off_paper: section.off_paper,
            title: section.title.clone(),
        };
        Self {
            title: self.title.clone(),
            subtitle: self.subtitle.clone(),
            read: self.read.clone(),
            language: self.language.clone(),
            meta: self.meta.clone(),
            answer: self.answer.clone(),
            findings: self.findings.clone(),
            sections: self.sections.iter().map(kept).collect(),
            footer: self.footer.clone(),
        }
    }

    /// Every table that names a file, in the order of the page.
    pub fn filed_tables(&self) -> Vec<&Table> {
        fn collect<'a>(blocks: &'a [Block], list: &mut Vec<&'a Table>) {
            for block in blocks {
                match block {
                    Block::Table(table) => list.push(table),
                    Block::Beside(tables) => list.extend(tables),
                    Block::Folded { blocks, .. } => collect(blocks, list),
                    _ => {}
                }
            }
        }
        let mut list = Vec::new();
        collect(&self.answer.blocks, &mut list);
        for section in &self.sections {
            collect(&section.blocks, &mut list);
        }
        list.retain(|table| !table.file.is_empty());
        list
    }

    /// Whether every table has a cell for every column in each of its rows, which a page that was read may not have.
    pub fn is_whole(&self) -> bool {
        fn whole(blocks: &[Block]) -> bool {
            blocks.iter().all(|block| match block {
                Block::Table(table) => table.is_whole(),
                Block::Beside(tables) => tables.iter().all(Table::is_whole),
                Block::Folded { blocks, .. } => whole(blocks),
                _ => true,
            })
        }
        whole(&self.answer.blocks) && self.sections.iter().all(|s| whole(&s.blocks))
    }

    /// Sets the last line.
    #[must_use]
    pub fn footer(mut self, text: impl Into<String>) -> Self {
        self.footer = text.into();
        self
    }
}

impl Section {
    /// Input files that are listed openly; a longer list is folded and stays off paper.
    pub const FEW_INPUTS: usize = 12;

    /// An empty section.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            ..Self::default()
        }
    }

    /// A section whose tables only files have.
    pub fn filed(tables: impl IntoIterator<Item = Table>) -> Self {
        Self {
            place: Place::File,
            blocks: tables.into_iter().map(Block::Table).collect(),
            ..Self::default()
        }
    }

    /// Says where the section is printed: on the page, where nothing is said.
    #[must_use]
    pub fn at(mut self, place: Place) -> Self {
        self.place = place;
        self
    }

    /// Shows the section in the summary of a terminal too.
    #[must_use]
    pub fn summarised(self) -> Self {
        self.at(Place::Both)
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
        self.block(Block::Figure(Figure::new(caption, plot)))
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
            off_paper: false,
        })
    }

    /// The whole section to look numbers up in, which paper leaves to the page: there it has its title alone.
    #[must_use]
    pub fn off_paper(mut self) -> Self {
        self.off_paper = true;
        self
    }

    /// Adds blocks to look a number up in, which paper leaves to the page: there it has their title alone.
    #[must_use]
    pub fn looked_up(
        self,
        title: impl Into<String>,
        blocks: impl IntoIterator<Item = Block>,
    ) -> Self {
        self.block(Block::Folded {
            title: title.into(),
            blocks: blocks.into_iter().collect(),
            off_paper: true,
        })
    }

    /// Adds the names and digests of input files; a long list is folded, and stays off paper.
    #[must_use]
    pub fn inputs(self, files: &[(String, String)]) -> Self {
        let mut table = Table::new("Inputs", [Column::text("file"), Column::text("SHA-256")]);
        for (name, digest) in files {
            table = table.row([Cell::text(name.clone()), Cell::text(digest.clone())]);
        }
        match files.len() {
            0 => self,
            n if n <= Self::FEW_INPUTS => self.table(table),
            n => self.looked_up(
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

    /// Names the file that holds the table as CSV.
    #[must_use]
    pub fn file(mut self, name: impl Into<String>) -> Self {
        self.file = name.into();
        self
    }

    /// The table without the columns that only the file has.
    pub(crate) fn printed(&self) -> Cow<'_, Self> {
        let shown = |c: &Column| c.name.is_empty() || !c.heading.is_empty();
        if self.columns.iter().all(shown) {
            return Cow::Borrowed(self);
        }
        let kept: Vec<usize> = (0..self.columns.len())
            .filter(|i| shown(&self.columns[*i]))
            .collect();
        let of = |row: &Vec<Cell>| kept.iter().filter_map(|i| row.get(*i).cloned()).collect();
        Cow::Owned(Self {
            columns: kept.iter().map(|i| self.columns[*i].clone()).collect(),
            rows: self.rows.iter().map(of).collect(),
            ..self.clone()
        })
    }
}

impl Column {
    /// A column of text, aligned left.
    pub fn text(heading: impl Into<String>) -> Self {
        Self {
            heading: heading.into(),
            alignment: Alignment::Left,
            ..Self::default()
        }
    }

    /// A column of numbers, aligned on the decimal point.
    pub fn number(heading: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            heading: heading.into(),
            unit: unit.into(),
            alignment: Alignment::Decimal,
            ..Self::default()
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

    /// A quantity.
    pub fn quantity(quantity: Quantity) -> Self {
        Self::Quantity(Box::new(quantity))
    }

    /// A number as printed by the caller.
    pub fn number(text: impl Into<String>) -> Self {
        Self::Number { text: text.into() }
    }

    /// A number of a file, or none, that a page prints as the caller says, such as `< 0.001`, or `∞` for none.
    pub fn printed(value: impl Into<Option<f64>>, text: impl Into<String>) -> Self {
        Self::from(value.into()).worded(text)
    }

    /// What a file has, in the words of a page.
    #[must_use]
    pub fn worded(self, text: impl Into<String>) -> Self {
        Self::Worded {
            file: Box::new(self),
            text: text.into(),
        }
    }

    /// Text that leads to another page of the same folder, such as `device-12.html`.
    pub fn linked(text: impl Into<String>, page: impl Into<String>) -> Self {
        Self::Linked {
            text: text.into(),
            page: page.into(),
        }
    }

    /// The page that it leads to: a file name and nothing else.
    pub(crate) fn page(&self) -> Option<&str> {
        let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
        match self {
            Self::Linked { page, .. } => Some(page.as_str()).filter(|p| p.chars().all(plain)),
            _ => None,
        }
    }

    /// Whether it is text, which does not stand on a decimal point.
    pub(crate) fn is_text(&self) -> bool {
        match self {
            Self::Worded { file, .. } => file.is_text(),
            cell => matches!(cell, Self::Text(_) | Self::Linked { .. }),
        }
    }
}

/// Rows of a table that a summary prints; its file has all of them.
const SUMMARISED: usize = 24;

/// A long table for a summary.
fn cut(block: &mut Block) {
    let Block::Table(table) = block else { return };
    let left = table.rows.len().saturating_sub(SUMMARISED);
    if left > 0 {
        table.rows.truncate(SUMMARISED);
        let place = match table.file.as_str() {
            "" => "on the page",
            file => file,
        };
        table.notes = vec![format!("{left} more rows: {place}.")];
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

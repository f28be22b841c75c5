//! The sheet: every word that is printed, in its language and rounded. What lays it out computes, translates and rounds nothing.

use proofmass_report::{Cell, Column, Report, Section, Table};
use serde::{Deserialize, Serialize};

/// Version of the form.
const FORM: u32 = 1;

/// A piece of running text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub(crate) enum Run {
    /// Words.
    Text(String),
    /// A formula in the notation of the typesetter; never a text from outside.
    Math(String),
    /// A number, which is written from left to right.
    Number(String),
}

impl Run {
    pub(crate) fn text(text: impl Into<String>) -> Vec<Self> {
        vec![Self::Text(text.into())]
    }

    pub(crate) fn words(&self) -> &str {
        match self {
            Self::Text(t) | Self::Math(t) | Self::Number(t) => t,
        }
    }
}

fn words(runs: &[Run]) -> String {
    let is_arabic = |c: char| ('\u{600}'..='\u{6ff}').contains(&c) && c.is_alphabetic();
    let to_the_left = runs
        .iter()
        .any(|run| matches!(run, Run::Text(t) if t.contains(is_arabic)));
    let of = |run: &Run| match run {
        // Kept from left to right among letters from right to left.
        Run::Number(n) if to_the_left => format!("\u{2066}{n}\u{2069}"),
        run => run.words().to_owned(),
    };
    runs.iter().map(of).collect()
}

/// Heading, unit and alignment of a column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SheetColumn {
    pub(crate) heading: Vec<Run>,
    pub(crate) unit: String,
    pub(crate) align: SheetAlign,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum SheetAlign {
    Number,
    Text,
}

/// Who authorises.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SheetSignature {
    pub(crate) name: String,
    pub(crate) role: String,
    pub(crate) date: String,
}

/// A piece of the document.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(crate) enum SheetBlock {
    Heading {
        level: u8,
        text: String,
    },
    Paragraph {
        text: Vec<Run>,
    },
    Fields {
        rows: Vec<(String, Vec<Run>)>,
    },
    Table {
        caption: Vec<Run>,
        label: String,
        columns: Vec<SheetColumn>,
        rows: Vec<Vec<String>>,
        notes: Vec<Vec<Run>>,
    },
    Figure {
        caption: Vec<Run>,
        label: String,
        svg: String,
        alternative: String,
    },
    Signatures {
        rows: Vec<SheetSignature>,
    },
    End {
        text: String,
    },
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SheetRunning {
    pub(crate) head: [String; 2],
    pub(crate) foot: [String; 2],
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SheetIssuer {
    pub(crate) name: String,
    pub(crate) lines: Vec<String>,
    pub(crate) logo_svg: Option<String>,
    pub(crate) marks: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SheetAttachment {
    pub(crate) name: String,
    pub(crate) media_type: String,
    pub(crate) relationship: String,
    pub(crate) description: String,
    pub(crate) base64: String,
}

/// The document.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sheet {
    form: u32,
    pub(crate) language: String,
    pub(crate) direction: String,
    pub(crate) digits: String,
    pub(crate) issued: String,
    pub(crate) number: String,
    pub(crate) title: String,
    pub(crate) running: SheetRunning,
    pub(crate) page_of: String,
    pub(crate) watermark: Option<String>,
    pub(crate) issuer: SheetIssuer,
    pub(crate) blocks: Vec<SheetBlock>,
    pub(crate) attachments: Vec<SheetAttachment>,
}

impl Sheet {
    pub(crate) fn new(
        title: String,
        running: SheetRunning,
        issuer: SheetIssuer,
        blocks: Vec<SheetBlock>,
    ) -> Self {
        Self {
            form: FORM,
            language: String::new(),
            direction: String::new(),
            digits: String::new(),
            issued: String::new(),
            number: String::new(),
            title,
            running,
            page_of: String::new(),
            watermark: None,
            issuer,
            blocks,
            attachments: Vec::new(),
        }
    }

    /// The same on a page and in a terminal.
    pub(crate) fn report(&self, mut page: Report) -> Report {
        let mut head = vec![self.issuer.name.as_str()];
        head.extend(self.issuer.lines.iter().map(String::as_str));
        page.language.clone_from(&self.language);
        page = page.subtitle(format!("{} · {}", head.join(", "), self.number));
        let mut section: Option<Section> = None;
        for block in &self.blocks {
            if let SheetBlock::Heading { level: 1, text } = block {
                if let Some(done) = section.take() {
                    page = page.section(done);
                }
                section = Some(Section::new(text.clone()).summarised());
                continue;
            }
            let into = section
                .take()
                .unwrap_or_else(|| Section::new("").summarised());
            section = Some(block.put(into));
        }
        match section {
            Some(last) => page.section(last),
            None => page,
        }
    }
}

impl SheetBlock {
    fn put(&self, section: Section) -> Section {
        match self {
            Self::Heading { text, .. } | Self::End { text } => section.paragraph(text.clone()),
            Self::Paragraph { text } => section.paragraph(words(text)),
            Self::Fields { rows } => {
                let table = Table::new("", [Column::text(""), Column::text("")]);
                section.table(rows.iter().fold(table, |table, (label, value)| {
                    table.row([Cell::text(label.clone()), Cell::text(words(value))])
                }))
            }
            Self::Table {
                caption,
                columns,
                rows,
                notes,
                ..
            } => {
                let columns = columns.iter().map(|c| match c.align {
                    SheetAlign::Text => Column::text(words(&c.heading)),
                    SheetAlign::Number => Column::number(words(&c.heading), c.unit.clone()),
                });
                let mut table = Table::new(words(caption), columns);
                for row in rows {
                    table = table.row(row.iter().map(|cell| Cell::text(cell.clone())));
                }
                for note in notes {
                    table = table.note(words(note));
                }
                section.table(table)
            }
            // The page of the result itself has it.
            Self::Figure { .. } => section,
            Self::Signatures { rows } => rows.iter().fold(section, |s, r| {
                s.paragraph(format!("{}, {}, {}", r.name, r.role, r.date))
            }),
        }
    }
}

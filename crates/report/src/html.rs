//! One self-contained HTML page: style, plots and a small script inside, nothing fetched; made for screen and A4.
//!
//! It opens with the answer; then findings by line, the sections that a summary has too, and the rest folded. Without
//! the script, which only lets figures be read off and zoomed, the page says the same.

mod answer;
mod findings;

use crate::Error;
use crate::document::{
    Alignment, Block, Cell, Column, Figure, KeyFigure, Place, Report, Section, Table,
};
use crate::number::{cell_text, minus, split_at_point};
use crate::plot::{escape, text_width};
use crate::terminal::check_shape;
use std::fmt::Write;

const STYLE: &str = include_str!("html/style.css");
/// Languages that are written from right to left.
const RIGHT_TO_LEFT: [&str; 4] = ["ar", "fa", "he", "ur"];
const SCRIPT: &str = include_str!("html/figures.js");
/// A table of more rows than these is folded where it would stand open.
const LONG: usize = 24;
/// A table of at most this many rows is kept on one sheet of paper.
const SHORT: usize = 8;

/// The report as one HTML document.
///
/// # Errors
/// Those of the plots; [`Error::Length`] for a row that does not fit its columns; [`Error::NotFinite`] for a
/// quantity that is not a number.
pub fn render(report: &Report) -> Result<String, Error> {
    let mut page = Page::default();
    let language = if report.language.is_empty() {
        "en"
    } else {
        &report.language
    };
    let direction = match RIGHT_TO_LEFT.contains(&language) {
        true => " dir=\"rtl\"",
        false => "",
    };
    let _ = write!(
        page.out,
        "<!DOCTYPE html>\n<html lang=\"{}\"{direction}>\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<header>\n<h1>{}</h1>\n",
        escape(language),
        escape(&report.title),
        escape(&report.title)
    );
    if !report.subtitle.is_empty() {
        let _ = writeln!(
            page.out,
            "<p class=\"subtitle\">{}</p>",
            marked(&report.subtitle)
        );
    }
    for read in report.read.lines().map(escape) {
        let _ = writeln!(page.out, "<p class=\"read\"><span>Read</span> {read}</p>");
    }
    page.out.push_str("</header>\n");
    page.answer(report)?;
    page.meta(&report.meta);
    page.findings(&report.findings);
    let folded = |s: &&Section| s.place == Place::Page || s.blocks.iter().all(is_long);
    for section in report.sections.iter().filter(|s| !folded(s)) {
        page.section(section)?;
    }
    let rest = || report.sections.iter().filter(folded);
    if rest().next().is_some() {
        page.out
            .push_str("<div class=\"rest\">\n<h2>Details</h2>\n");
        for section in rest() {
            page.folded(section)?;
        }
        page.out.push_str("</div>\n");
    }
    if !report.footer.is_empty() {
        let _ = writeln!(page.out, "<footer>{}</footer>", escape(&report.footer));
    }
    page.out.push_str("</main>\n");
    if page.figures > 0 {
        let _ = writeln!(page.out, "<script>\n{SCRIPT}</script>");
    }
    page.out.push_str("</body>\n</html>\n");
    Ok(page.out)
}

/// Whether a block is a table for those who look a row up: on paper it stands in the appendix.
fn is_long(block: &Block) -> bool {
    matches!(block, Block::Table(table) if table.rows.len() > LONG)
}

#[derive(Default)]
struct Page {
    out: String,
    figures: usize,
    tables: usize,
}

impl Page {
    /// What a reader files it by.
    fn meta(&mut self, meta: &[(String, String)]) {
        if meta.is_empty() {
            return;
        }
        self.out.push_str("<dl class=\"meta\">\n");
        for (label, value) in meta {
            let _ = writeln!(
                self.out,
                "<div><dt>{}</dt><dd>{}</dd></div>",
                escape(label),
                escape(value)
            );
        }
        self.out.push_str("</dl>\n");
    }

    fn section(&mut self, section: &Section) -> Result<(), Error> {
        self.out.push_str("<section>\n");
        if !section.title.is_empty() {
            let _ = writeln!(self.out, "<h2>{}</h2>", marked(&section.title));
        }
        for block in &section.blocks {
            match block {
                Block::Table(table) if is_long(block) => {
                    let title = match table.caption.as_str() {
                        "" => section.title.as_str(),
                        caption => caption,
                    };
                    let summary = format!("{}: {} rows", marked(title), table.rows.len());
                    self.details(&summary, std::slice::from_ref(block))?;
                }
                block => self.block(block)?,
            }
        }
        self.out.push_str("</section>\n");
        Ok(())
    }

    /// A section that only some readers open.
    fn folded(&mut self, section: &Section) -> Result<(), Error> {
        let rows = match &section.blocks[..] {
            [block @ Block::Table(table)] if is_long(block) => {
                format!(": {} rows", table.rows.len())
            }
            _ => String::new(),
        };
        let summary = format!("<h3>{}</h3>{rows}", marked(&section.title));
        match section.off_paper {
            true => self.off_paper(&summary, &section.blocks),
            false => self.details(&summary, &section.blocks),
        }
    }

    /// What a number is looked up in: paper has the summary alone.
    fn off_paper(&mut self, summary: &str, blocks: &[Block]) -> Result<(), Error> {
        let _ = writeln!(
            self.out,
            "<details class=\"off-paper\">\n<summary>{summary}</summary>\n<div>"
        );
        self.blocks(blocks)?;
        self.out.push_str("</div>\n</details>\n");
        Ok(())
    }

    fn details(&mut self, summary: &str, blocks: &[Block]) -> Result<(), Error> {
        let _ = writeln!(self.out, "<details>\n<summary>{summary}</summary>");
        self.blocks(blocks)?;
        self.out.push_str("</details>\n");
        Ok(())
    }

    fn blocks(&mut self, blocks: &[Block]) -> Result<(), Error> {
        blocks.iter().try_for_each(|block| self.block(block))
    }

    fn block(&mut self, block: &Block) -> Result<(), Error> {
        match block {
            Block::Paragraph(text) => {
                let _ = writeln!(self.out, "<p>{}</p>", marked(text));
            }
            Block::Code(text) => {
                let _ = writeln!(self.out, "<pre><code>{}</code></pre>", escape(text));
            }
            Block::Findings(findings) => self.findings(findings),
            Block::KeyFigures(figures) => self.key_figures(figures),
            Block::Table(table) => self.table(table)?,
            Block::Beside(tables) => {
                self.out.push_str("<div class=\"beside\">\n");
                for table in tables {
                    self.grid(&table.printed(), None)?;
                }
                self.out.push_str("</div>\n");
            }
            Block::Folded {
                title,
                blocks,
                off_paper: false,
            } => self.details(&marked(title), blocks)?,
            Block::Folded { title, blocks, .. } => self.off_paper(&marked(title), blocks)?,
            Block::Figure(figure) => self.figure(figure),
        }
        Ok(())
    }

    /// The figure of the answer: on a phone all of it is seen at once.
    fn first_figure(&mut self, figure: &Figure) {
        let narrow = figure.plot.narrow().and_then(|plot| {
            let id = format!("figure-{}-narrow", self.figures + 1);
            plot.svg(&figure.caption, &id).ok()
        });
        self.figure_beside(figure, narrow);
    }

    fn figure(&mut self, figure: &Figure) {
        self.figure_beside(figure, None);
    }

    /// One figure that cannot be drawn does not take the result with it.
    fn figure_beside(&mut self, figure: &Figure, narrow: Option<String>) {
        self.figures += 1;
        let (number, caption) = (self.figures, marked(&figure.caption));
        let drawn = figure.svg(&format!("figure-{number}"));
        let (wide, narrow) = match narrow {
            Some(svg) => (" wide", format!("<div class=\"plot narrow\">{svg}</div>\n")),
            None => ("", String::new()),
        };
        let _ = match drawn {
            Ok(svg) => writeln!(
                self.out,
                "<figure{}>\n<div class=\"plot{wide}\">{svg}</div>\n{narrow}<figcaption><b>Figure {number}.</b> {caption}</figcaption>\n</figure>",
                if figure.plot.is_tall() {
                    " class=\"tall\""
                } else {
                    ""
                },
            ),
            Err(error) => writeln!(
                self.out,
                "<p class=\"undrawn\"><b>Figure {number}</b> cannot be drawn: {}. {caption}</p>",
                escape(&error.to_string()),
            ),
        };
    }

    fn key_figures(&mut self, figures: &[KeyFigure]) {
        // Many are a list, one line each, on a phone some are too.
        let class = match figures.len() {
            0..=4 => "key",
            5..=6 => "key some",
            _ => "key many",
        };
        let _ = writeln!(self.out, "<dl class=\"{class}\">");
        for figure in figures {
            let _ = write!(
                self.out,
                "<div><dt>{}</dt><dd><span class=\"size\"><span class=\"value\">{}</span>",
                marked(&figure.label),
                escape(&minus(&figure.value))
            );
            if !figure.unit.is_empty() && figure.unit != "1" {
                let _ = write!(
                    self.out,
                    " <span class=\"unit\">{}</span>",
                    escape(&figure.unit)
                );
            }
            self.out.push_str("</span>");
            if !figure.note.is_empty() {
                let _ = write!(self.out, " <small>{}</small>", marked(&figure.note));
            }
            self.out.push_str("</dd></div>\n");
        }
        self.out.push_str("</dl>\n");
    }

    fn table(&mut self, table: &Table) -> Result<(), Error> {
        let table = &*table.printed();
        let number = (!table.caption.is_empty()).then(|| {
            self.tables += 1;
            format!("Table {}.", self.tables)
        });
        self.grid(table, number)
    }

    /// Rows and columns; a table without a number has its whole caption set bold.
    fn grid(&mut self, table: &Table, number: Option<String>) -> Result<(), Error> {
        check_shape(table)?;
        let blocks = number_blocks(table)?;
        let narrowest = narrowest_width(table, &blocks)?;
        let _ = writeln!(
            self.out,
            "<div class=\"table{}\" style=\"--ch:{narrowest:.0}\">\n<table>",
            if table.rows.len() <= SHORT {
                " short"
            } else {
                ""
            }
        );
        let caption = marked(&table.caption);
        if let Some(number) = number {
            let _ = writeln!(self.out, "<caption><b>{number}</b> {caption}</caption>");
        } else if !caption.is_empty() {
            let _ = writeln!(self.out, "<caption><b>{caption}</b></caption>");
        }
        self.out.push_str("<thead><tr>");
        for column in &table.columns {
            let _ = write!(
                self.out,
                "<th scope=\"col\" class=\"{}\">{}",
                class(column.alignment),
                marked(&column.heading)
            );
            if let Some(unit) = column.printed_unit() {
                let _ = write!(
                    self.out,
                    "<br/><span class=\"unit\">{}</span>",
                    escape(unit)
                );
            }
            self.out.push_str("</th>");
        }
        self.out.push_str("</tr></thead>\n<tbody>\n");
        for (i, row) in table.rows.iter().enumerate() {
            self.out.push_str("<tr>");
            for ((cell, column), block) in row.iter().zip(&table.columns).zip(&blocks) {
                self.cell(cell, column, *block, i)?;
            }
            self.out.push_str("</tr>\n");
        }
        self.out.push_str("</tbody>\n</table>\n");
        for note in &table.notes {
            let _ = writeln!(self.out, "<p class=\"table-note\">{}</p>", marked(note));
        }
        self.out.push_str("</div>\n");
        Ok(())
    }

    fn cell(
        &mut self,
        cell: &Cell,
        column: &Column,
        (left, right): (f64, f64),
        row: usize,
    ) -> Result<(), Error> {
        let text = cell_text(cell, column, row)?;
        let is_text = cell.is_text();
        if column.alignment == Alignment::Decimal && !is_text && !text.is_empty() {
            // Two boxes of the same width in every row meet at the decimal point.
            let (whole, rest) = split_at_point(&text);
            let _ = write!(
                self.out,
                "<td class=\"decimal\"><span class=\"whole\" style=\"min-width:{left:.1}ch\">{}</span>\
                 <span class=\"tail\" style=\"min-width:{right:.1}ch\">{}</span></td>",
                escape(whole),
                escape(rest)
            );
        } else {
            let text = match cell.page() {
                Some(page) => format!("<a href=\"{page}\">{}</a>", marked(&text)),
                None => marked(&text),
            };
            let _ = write!(
                self.out,
                "<td class=\"{}\">{text}</td>",
                class(column.alignment)
            );
        }
        Ok(())
    }
}

/// Text for the page, with its indices set as such.
fn marked(text: &str) -> String {
    let pieces = crate::subscript::pieces(text).into_iter();
    let set = pieces.map(|(index, piece)| match index {
        true => format!("<sub>{}</sub>", escape(piece)),
        false => escape(piece),
    });
    set.collect()
}

/// Width of a text in widths of the digit 0.
fn in_digits(text: &str) -> f64 {
    text_width(text, 1.0) / text_width("0", 1.0)
}

/// For each column the widest part left and right of the decimal point, in widths of a digit.
fn number_blocks(table: &Table) -> Result<Vec<(f64, f64)>, Error> {
    let mut blocks = vec![(0.0_f64, 0.0_f64); table.columns.len()];
    for (i, row) in table.rows.iter().enumerate() {
        for ((cell, column), block) in row.iter().zip(&table.columns).zip(&mut blocks) {
            if !cell.is_text() {
                let text = cell_text(cell, column, i)?;
                let (whole, tail) = split_at_point(&text);
                *block = (
                    block.0.max(in_digits(whole) + 0.1),
                    block.1.max(in_digits(tail) + 0.1),
                );
            }
        }
    }
    Ok(blocks)
}

/// Width of the table with every text broken wherever it may be, in widths of a digit.
fn narrowest_width(table: &Table, blocks: &[(f64, f64)]) -> Result<f64, Error> {
    let padding = 2.0;
    let longest_word = |text: &str| {
        let words = text.split_whitespace().map(in_digits);
        words.fold(0.0, f64::max).min(24.0)
    };
    let mut sum = 10.0;
    for (c, column) in table.columns.iter().enumerate() {
        let unit = column.printed_unit().unwrap_or("");
        // Headings are set bold, a little wider.
        let mut widest = 1.1 * longest_word(&column.heading).max(in_digits(unit));
        for (i, row) in table.rows.iter().enumerate() {
            let text = cell_text(&row[c], column, i)?;
            widest = widest.max(match column.alignment {
                Alignment::Decimal if !row[c].is_text() => blocks[c].0 + blocks[c].1,
                Alignment::Decimal | Alignment::Right => in_digits(&text),
                Alignment::Left | Alignment::Centre => longest_word(&text).max(8.0),
            });
        }
        sum += widest + padding;
    }
    Ok(sum)
}

fn class(alignment: Alignment) -> &'static str {
    match alignment {
        Alignment::Left => "left",
        Alignment::Centre => "centre",
        Alignment::Right => "right",
        Alignment::Decimal => "decimal",
    }
}

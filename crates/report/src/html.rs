//! One self-contained HTML page: style and plots inside, nothing fetched, no script; made for screen and A4.

use crate::Error;
use crate::document::{Alignment, Block, Cell, Column, KeyFigure, Report, Table};
use crate::number::{cell_text, minus, split_at_point};
use crate::plot::escape;
use crate::terminal::check_shape;
use proofmass_uncertainty::{Finding, Severity};
use std::fmt::Write;

const STYLE: &str = include_str!("html/style.css");
/// From this many sections on the page opens with a table of contents.
const LONG: usize = 5;

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
    let _ = write!(
        page.out,
        "<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<header>\n<h1>{}</h1>\n",
        escape(language),
        escape(&report.title),
        escape(&report.title)
    );
    if !report.subtitle.is_empty() {
        let _ = writeln!(
            page.out,
            "<p class=\"subtitle\">{}</p>",
            escape(&report.subtitle)
        );
    }
    if !report.meta.is_empty() {
        page.out.push_str("<dl class=\"meta\">\n");
        for (label, value) in &report.meta {
            let _ = writeln!(
                page.out,
                "<div><dt>{}</dt><dd>{}</dd></div>",
                escape(label),
                escape(value)
            );
        }
        page.out.push_str("</dl>\n");
    }
    page.out.push_str("</header>\n");
    page.findings(&report.findings);
    if report.sections.len() >= LONG {
        page.contents(report);
    }
    for (i, section) in report.sections.iter().enumerate() {
        let _ = writeln!(page.out, "<section id=\"section-{}\">", i + 1);
        if !section.title.is_empty() {
            let _ = writeln!(page.out, "<h2>{}</h2>", escape(&section.title));
        }
        for block in &section.blocks {
            page.block(block)?;
        }
        page.out.push_str("</section>\n");
    }
    if !report.footer.is_empty() {
        let _ = writeln!(page.out, "<footer>{}</footer>", escape(&report.footer));
    }
    page.out.push_str("</main>\n</body>\n</html>\n");
    Ok(page.out)
}

#[derive(Default)]
struct Page {
    out: String,
    figures: usize,
    tables: usize,
}

impl Page {
    fn contents(&mut self, report: &Report) {
        self.out
            .push_str("<nav aria-label=\"Contents\"><h2>Contents</h2><ol>\n");
        for (i, section) in report.sections.iter().enumerate() {
            if !section.title.is_empty() {
                let _ = writeln!(
                    self.out,
                    "<li><a href=\"#section-{}\">{}</a></li>",
                    i + 1,
                    escape(&section.title)
                );
            }
        }
        self.out.push_str("</ol></nav>\n");
    }

    fn block(&mut self, block: &Block) -> Result<(), Error> {
        match block {
            Block::Paragraph(text) => {
                let _ = writeln!(self.out, "<p>{}</p>", escape(text));
            }
            Block::Code(text) => {
                let _ = writeln!(self.out, "<pre><code>{}</code></pre>", escape(text));
            }
            Block::Findings(findings) => self.findings(findings),
            Block::KeyFigures(figures) => self.key_figures(figures),
            Block::Table(table) => self.table(table)?,
            Block::Figure(figure) => {
                self.figures += 1;
                let svg = figure
                    .plot
                    .svg(&figure.caption, &format!("figure-{}", self.figures))?;
                let _ = writeln!(
                    self.out,
                    "<figure>\n<div class=\"plot\">{svg}</div>\n<figcaption><b>Figure {}.</b> {}</figcaption>\n</figure>",
                    self.figures,
                    escape(&figure.caption)
                );
            }
        }
        Ok(())
    }

    /// Boxes, the gravest first.
    fn findings(&mut self, findings: &[Finding]) {
        if findings.is_empty() {
            return;
        }
        let mut sorted: Vec<&Finding> = findings.iter().collect();
        sorted.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        self.out.push_str("<ul class=\"findings\">\n");
        for finding in sorted {
            let class = match finding.severity() {
                Severity::Decision => "decision",
                Severity::Warning => "warning",
                Severity::Note => "note",
            };
            let _ = write!(
                self.out,
                "<li class=\"{class}\"><p><b>{}</b> {} <code>{}</code></p>",
                capital(&finding.severity().to_string()),
                escape(&sentence(finding.what())),
                escape(finding.code())
            );
            for (word, text) in [
                ("evidence", finding.evidence_text()),
                ("advice", finding.advice_text()),
            ] {
                if !text.is_empty() {
                    let _ = write!(
                        self.out,
                        "<p class=\"{word}\">{}</p>",
                        escape(&sentence(text))
                    );
                }
            }
            self.out.push_str("</li>\n");
        }
        self.out.push_str("</ul>\n");
    }

    fn key_figures(&mut self, figures: &[KeyFigure]) {
        self.out.push_str("<dl class=\"key\">\n");
        for figure in figures {
            let _ = write!(
                self.out,
                "<div><dt>{}</dt><dd><span class=\"value\">{}</span>",
                escape(&figure.label),
                escape(&minus(&figure.value))
            );
            if !figure.unit.is_empty() && figure.unit != "1" {
                let _ = write!(
                    self.out,
                    " <span class=\"unit\">{}</span>",
                    escape(&figure.unit)
                );
            }
            if !figure.note.is_empty() {
                let _ = write!(self.out, "<small>{}</small>", escape(&figure.note));
            }
            self.out.push_str("</dd></div>\n");
        }
        self.out.push_str("</dl>\n");
    }

    fn table(&mut self, table: &Table) -> Result<(), Error> {
        check_shape(table)?;
        self.out.push_str("<div class=\"table\">\n<table>\n");
        if !table.caption.is_empty() {
            self.tables += 1;
            let _ = writeln!(
                self.out,
                "<caption><b>Table {}.</b> {}</caption>",
                self.tables,
                escape(&table.caption)
            );
        }
        self.out.push_str("<thead><tr>");
        for column in &table.columns {
            let _ = write!(
                self.out,
                "<th scope=\"col\" class=\"{}\">{}",
                class(column.alignment),
                escape(&column.heading)
            );
            if let Some(unit) = column.printed_unit() {
                let _ = write!(self.out, "<br><span class=\"unit\">{}</span>", escape(unit));
            }
            self.out.push_str("</th>");
        }
        self.out.push_str("</tr></thead>\n<tbody>\n");
        let tails = decimal_tails(table)?;
        for (i, row) in table.rows.iter().enumerate() {
            self.out.push_str("<tr>");
            for ((cell, column), tail) in row.iter().zip(&table.columns).zip(&tails) {
                self.cell(cell, column, *tail, i)?;
            }
            self.out.push_str("</tr>\n");
        }
        self.out.push_str("</tbody>\n</table>\n");
        for note in &table.notes {
            let _ = writeln!(self.out, "<p class=\"table-note\">{}</p>", escape(note));
        }
        self.out.push_str("</div>\n");
        Ok(())
    }

    fn cell(&mut self, cell: &Cell, column: &Column, tail: usize, row: usize) -> Result<(), Error> {
        let text = cell_text(cell, column, row)?;
        let is_text = matches!(cell, Cell::Text(_));
        if column.alignment == Alignment::Decimal && !is_text {
            let (whole, rest) = split_at_point(&text);
            let _ = write!(
                self.out,
                "<td class=\"decimal\">{}<span class=\"tail\" style=\"min-width:{}ch\">{}</span></td>",
                escape(whole),
                tail,
                escape(rest)
            );
        } else {
            let _ = write!(
                self.out,
                "<td class=\"{}\">{}</td>",
                class(column.alignment),
                escape(&text)
            );
        }
        Ok(())
    }
}

/// For each column the longest part right of the alignment line, in characters.
fn decimal_tails(table: &Table) -> Result<Vec<usize>, Error> {
    let mut tails = vec![0; table.columns.len()];
    for (i, row) in table.rows.iter().enumerate() {
        for ((cell, column), tail) in row.iter().zip(&table.columns).zip(&mut tails) {
            if !matches!(cell, Cell::Text(_)) {
                let text = cell_text(cell, column, i)?;
                *tail = (*tail).max(split_at_point(&text).1.chars().count());
            }
        }
    }
    Ok(tails)
}

fn class(alignment: Alignment) -> &'static str {
    match alignment {
        Alignment::Left => "left",
        Alignment::Centre => "centre",
        Alignment::Right => "right",
        Alignment::Decimal => "decimal",
    }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars
        .next()
        .map(|c| c.to_uppercase().chain(chars).collect())
        .unwrap_or_default()
}

/// Capital and full stop around a clause; a Greek or mathematical symbol at its head stays as it is.
fn sentence(text: &str) -> String {
    let mut text = if text.starts_with(|c: char| c.is_ascii_lowercase())
        && text.chars().take_while(|c| c.is_ascii_alphabetic()).count() > 1
    {
        capital(text)
    } else {
        text.to_string()
    };
    if !text.ends_with(['.', '!', '?', ':']) {
        text.push('.');
    }
    text
}

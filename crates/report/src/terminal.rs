//! Text for a terminal or a file: Unicode tables within a given width, colour only where it is asked for.

use crate::Error;
use crate::document::{Alignment, Block, Cell, KeyFigure, Report, Section, Table};
use crate::grouping::{Group, groups};
use crate::number::{cell_text, minus, quotient, split_at_point};
use proofmass_core::Visible;
use proofmass_uncertainty::{Finding, Severity};

/// How wide, and whether in colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Columns of the terminal; lines are at most this long unless a single number is longer.
    pub width: usize,
    /// Whether ANSI escapes may be written.
    pub colour: bool,
    /// Whether the result is written to a folder, so that evidence and advice stand there too.
    pub filed: bool,
    /// Whether every section is printed; else what does not fit behind the opening is named.
    pub details: bool,
}

/// Lines of result, verdict, findings and what was read, at most: a terminal shows them at once.
const SCREEN: usize = 25;
/// Rows of a table that stands behind the opening without being asked for, at most.
const BRIEF_TABLE: usize = 12;
/// A label and value of more characters have a line of their own.
const BRIEF: usize = 40;

/// The report as text; a figure is a line with its caption.
///
/// # Errors
/// [`Error::Length`] for a row that does not fit its columns; [`Error::NotFinite`] for a quantity that is not a
/// number.
pub fn render(report: &Report, options: &Options) -> Result<String, Error> {
    let mut text = Text {
        out: String::new(),
        width: options.width.max(20),
        colour: options.colour,
        filed: options.filed,
    };
    text.line(&text.bold(&clean(&report.title)));
    if !report.subtitle.is_empty() {
        text.wrapped(&report.subtitle, "");
    }
    for read in report.read.lines() {
        text.hanging("Read  ", read);
    }
    text.key_figures(&report.answer.figures);
    if !report.says_nothing() {
        let verdict = format!("{} {}", report.answer.verdict, report.standing());
        text.wrapped(verdict.trim(), "");
    }
    for block in &report.answer.blocks {
        text.out.push('\n');
        text.block(block)?;
    }
    if let Some(figure) = &report.answer.figure {
        text.hanging("figure: ", &figure.caption);
    }
    let mut head = Text {
        out: String::new(),
        ..text
    };
    head.meta(&report.meta);
    let taken = text.out.lines().count() + head.out.lines().count();
    text.findings(&report.findings, SCREEN.saturating_sub(taken));
    text.out.push_str(&head.out);
    text.sections(&report.sections, options.details)?;
    if !report.footer.is_empty() {
        text.out.push('\n');
        text.wrapped(&report.footer, "");
    }
    Ok(text.out)
}

struct Text {
    out: String,
    width: usize,
    colour: bool,
    filed: bool,
}

/// How much of a finding is said.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Detail {
    /// One line, cut where it is too long; a decision is said whole.
    Cut,
    /// The whole sentence.
    Whole,
    /// And, where a decision is needed, what to do.
    Advised,
}

/// A text of one line, cut at a word.
fn cut(text: &str, width: usize) -> String {
    if width_of(text) <= width {
        return text.to_owned();
    }
    let first = wrap(text, width.saturating_sub(1).max(1))
        .into_iter()
        .next();
    format!(
        "{}…",
        first.unwrap_or_default().trim_end_matches([',', ':', ';'])
    )
}

impl Text {
    fn styled(&self, text: &str, code: &str) -> String {
        if self.colour {
            format!("\u{1b}[{code}m{text}\u{1b}[0m")
        } else {
            text.to_string()
        }
    }

    fn bold(&self, text: &str) -> String {
        self.styled(text, "1")
    }

    fn line(&mut self, text: &str) {
        self.out.push_str(text.trim_end());
        self.out.push('\n');
    }

    fn wrapped(&mut self, text: &str, indent: &str) {
        for line in wrap(text, self.width.saturating_sub(width_of(indent)).max(10)) {
            self.line(&format!("{indent}{line}"));
        }
    }

    /// A text whose later lines stand under the first one.
    fn hanging(&mut self, head: &str, text: &str) {
        let indent = width_of(head);
        let lines = wrap(text, self.width.saturating_sub(indent).max(10));
        for (i, line) in lines.iter().enumerate() {
            let before = if i == 0 {
                head.to_string()
            } else {
                " ".repeat(indent)
            };
            self.line(&format!("{before}{line}"));
        }
    }

    fn block(&mut self, block: &Block) -> Result<(), Error> {
        match block {
            Block::Paragraph(text) => self.wrapped(text, ""),
            Block::Code(text) => {
                for line in text.lines() {
                    self.line(&format!("    {}", clean(line)));
                }
            }
            Block::Findings(findings) => self.findings(findings, usize::MAX),
            Block::KeyFigures(figures) => self.key_figures(figures),
            Block::Table(table) => self.table(table)?,
            Block::Beside(tables) => {
                for (i, table) in tables.iter().enumerate() {
                    if i > 0 {
                        self.line("");
                    }
                    self.table(table)?;
                }
            }
            Block::Folded { title, .. } => self.hanging("in the page: ", title),
            Block::Figure(figure) => self.hanging("figure: ", &figure.caption),
        }
        Ok(())
    }

    fn key_figures(&mut self, figures: &[KeyFigure]) {
        let label = figures
            .iter()
            .map(|f| width_of(&f.label))
            .max()
            .unwrap_or(0);
        for figure in figures {
            let unit = if figure.unit == "1" {
                ""
            } else {
                figure.unit.as_str()
            };
            let mut value = format!("{} {unit}", minus(&figure.value))
                .trim_end()
                .to_string();
            if !figure.note.is_empty() {
                value = format!("{value}  ({})", figure.note);
            }
            self.hanging(&format!("{}  ", pad(&figure.label, label)), &value);
        }
    }

    /// What stands behind the opening: all of it, or the first table that is small, with the names of the rest.
    fn sections(&mut self, sections: &[Section], details: bool) -> Result<(), Error> {
        let small = match details {
            true => None,
            false => self.first_small(sections)?,
        };
        let mut left: Vec<&str> = Vec::new();
        for (s, section) in sections.iter().enumerate() {
            let shown: Vec<&Block> = match (details, small) {
                (true, _) => section.blocks.iter().collect(),
                (false, Some((of, block))) if of == s => vec![&section.blocks[block]],
                (false, _) => Vec::new(),
            };
            if shown.len() < section.blocks.len() {
                let caption = section.blocks.iter().find_map(|block| match block {
                    Block::Table(table) if !table.caption.is_empty() => Some(&*table.caption),
                    _ => None,
                });
                left.extend(
                    [&*section.title]
                        .into_iter()
                        .chain(caption)
                        .find(|n| !n.is_empty()),
                );
            }
            if shown.is_empty() && !section.blocks.is_empty() {
                continue;
            }
            self.out.push('\n');
            if !section.title.is_empty() {
                self.line(&self.bold(&clean(&section.title)));
            }
            for (i, block) in shown.into_iter().enumerate() {
                if i > 0 {
                    self.out.push('\n');
                }
                self.block(block)?;
            }
        }
        if !left.is_empty() {
            self.out.push('\n');
            let place = match self.filed {
                true => "more in the page, or with --details: ",
                false => "more with --details: ",
            };
            self.wrapped(&format!("{place}{}", left.join(", ")), "");
        }
        Ok(())
    }

    /// The first table of few rows whose columns stand side by side, as section and block.
    fn first_small(&self, sections: &[Section]) -> Result<Option<(usize, usize)>, Error> {
        for (s, section) in sections.iter().enumerate() {
            for (b, block) in section.blocks.iter().enumerate() {
                let Block::Table(table) = block else { continue };
                let table = &*table.printed();
                check_shape(table)?;
                let grid = Grid::new(table)?;
                let fits = fitted(&grid.widths(), table, &grid, self.width).is_some();
                if fits && table.rows.len() <= BRIEF_TABLE {
                    return Ok(Some((s, b)));
                }
            }
        }
        Ok(None)
    }

    /// What a reader files it by: short ones share a line.
    fn meta(&mut self, meta: &[(String, String)]) {
        if !meta.is_empty() {
            self.out.push('\n');
        }
        let named = |(name, value): &(String, String)| format!("{}  {}", clean(name), clean(value));
        let (brief, long): (Vec<_>, Vec<_>) =
            meta.iter().partition(|m| width_of(&named(m)) <= BRIEF);
        for (name, value) in long {
            self.hanging(&format!("{}  ", clean(name)), value);
        }
        let brief: Vec<String> = brief
            .iter()
            .map(|m| named(m).replace(' ', "\u{a0}"))
            .collect();
        if !brief.is_empty() {
            self.wrapped(&brief.join(" · "), "");
            self.out = self.out.replace('\u{a0}', " ");
        }
    }

    /// One line for alike ones, and what is to be done where a decision is needed; shorter where that takes more than `room`
    /// lines.
    fn findings(&mut self, findings: &[Finding], room: usize) {
        let groups = groups(findings);
        if groups.is_empty() {
            return;
        }
        let says = |f: &Finding| !f.evidence_text().is_empty() || !f.advice_text().is_empty();
        let more = findings.iter().any(says);
        let told = |detail: Detail, shown: usize| {
            let mut text = Text {
                out: "\n".to_owned(),
                ..*self
            };
            for group in &groups[..shown] {
                text.group(group, detail);
            }
            if shown < groups.len() {
                let mut codes: Vec<&str> = groups[shown..].iter().map(|g| g.code()).collect();
                codes.sort_unstable();
                codes.dedup();
                let kinds = if codes.len() == 1 { "kind" } else { "kinds" };
                let line = format!("and {} more {kinds}: {}", codes.len(), codes.join(", "));
                text.line(&cut(&line, text.width));
            }
            if more {
                let where_to = match text.filed {
                    true => {
                        "Evidence and advice: in result.json and its page, or `proofmass explain CODE`."
                    }
                    false => "`proofmass explain CODE` says what each of these means.",
                };
                text.wrapped(where_to, "");
            }
            text.out
        };
        let whole = [Detail::Advised, Detail::Whole, Detail::Cut]
            .into_iter()
            .map(|detail| told(detail, groups.len()))
            .find(|text| text.lines().count() <= room);
        let text = whole.unwrap_or_else(|| {
            // What has to be decided is told whatever room it takes.
            let decisions = groups
                .iter()
                .filter(|g| g.severity() == Severity::Decision)
                .count();
            let shown = room.saturating_sub(3).max(decisions);
            let shown = shown.clamp(1, groups.len());
            told(Detail::Cut, shown)
        });
        self.out.push_str(&text);
    }

    fn group(&mut self, group: &Group<'_>, detail: Detail) {
        let code = match group.severity() {
            Severity::Decision => "1;31",
            Severity::Warning => "1;33",
            Severity::Note => "1;34",
        };
        let name = group.severity().to_string();
        let start = self.out.len();
        let head = format!("{name}: ");
        let tail = format!(" [{}]", group.code());
        match detail {
            Detail::Cut if group.severity() != Severity::Decision => {
                let room = self.width.saturating_sub(width_of(&head) + width_of(&tail));
                self.line(&format!("{head}{}{tail}", cut(&clean(&group.line), room)));
            }
            _ => {
                self.hanging(&head, &format!("{}{tail}", group.line));
            }
        }
        // Coloured after wrapping: an escape has no width.
        let coloured = self.styled(&name, code);
        self.out.replace_range(start..start + name.len(), &coloured);
        let advice = group.members[0].advice_text();
        let advised = detail == Detail::Advised && group.severity() == Severity::Decision;
        if advised && !advice.is_empty() {
            self.wrapped(advice, "    ");
        }
    }

    fn table(&mut self, table: &Table) -> Result<(), Error> {
        let table = &*table.printed();
        check_shape(table)?;
        if !table.caption.is_empty() {
            self.wrapped(&table.caption, "");
        }
        let grid = Grid::new(table)?;
        match fitted(&grid.widths(), table, &grid, self.width) {
            Some(widths) => self.columns(table, &grid, &widths),
            None => self.records(table, &grid),
        }
        for note in &table.notes {
            self.wrapped(note, "  ");
        }
        Ok(())
    }

    fn columns(&mut self, table: &Table, grid: &Grid, widths: &[usize]) {
        let rule = |cross: &str| {
            widths
                .iter()
                .map(|w| "─".repeat(w + 2))
                .collect::<Vec<_>>()
                .join(cross)
        };
        let heads: Vec<Vec<String>> = grid
            .heads
            .iter()
            .zip(widths)
            .map(|(h, &w)| wrap(h, w))
            .collect();
        self.row(table, &heads, widths, true);
        let line = rule("┼");
        self.line(&line);
        for row in &grid.rows {
            let cells: Vec<Vec<String>> = row
                .iter()
                .zip(widths)
                .map(|(cell, &w)| wrap(cell, w))
                .collect();
            self.row(table, &cells, widths, false);
        }
    }

    fn row(&mut self, table: &Table, cells: &[Vec<String>], widths: &[usize], head: bool) {
        let lines = cells.iter().map(Vec::len).max().unwrap_or(0);
        for i in 0..lines {
            let mut parts = Vec::new();
            for ((cell, &width), column) in cells.iter().zip(widths).zip(&table.columns) {
                let text = cell.get(i).map_or("", String::as_str);
                let space = width.saturating_sub(width_of(text));
                let left = match column.alignment {
                    Alignment::Left => 0,
                    // Decimal cells come padded to one length, a block under the middle of its heading.
                    Alignment::Centre | Alignment::Decimal => space / 2,
                    Alignment::Right => space,
                };
                let shown = if head {
                    self.bold(text)
                } else {
                    text.to_string()
                };
                parts.push(format!(
                    " {}{shown}{} ",
                    " ".repeat(left),
                    " ".repeat(space - left)
                ));
            }
            self.line(&parts.join("│"));
        }
    }

    /// One line per cell, for a table that is too wide for the terminal.
    fn records(&mut self, table: &Table, grid: &Grid) {
        let label = grid
            .heads
            .iter()
            .map(|h| width_of(h))
            .max()
            .unwrap_or(0)
            .min(self.width / 2);
        for (i, row) in grid.rows.iter().enumerate() {
            if i > 0 {
                self.out.push('\n');
            }
            for ((cell, head), _) in row.iter().zip(&grid.heads).zip(&table.columns) {
                if !cell.trim().is_empty() {
                    self.hanging(&format!("  {}  ", pad(head, label)), cell.trim());
                }
            }
        }
    }
}

/// Refuses a row that does not fit its columns.
pub(crate) fn check_shape(table: &Table) -> Result<(), Error> {
    for (i, row) in table.rows.iter().enumerate() {
        if row.len() != table.columns.len() {
            return Err(Error::Length {
                name: format!("row {i} of the table \"{}\"", table.caption),
                expected: table.columns.len(),
                got: row.len(),
            });
        }
    }
    Ok(())
}

/// A table as text, decimal points already under each other.
struct Grid {
    heads: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Grid {
    fn new(table: &Table) -> Result<Self, Error> {
        let heads = table
            .columns
            .iter()
            .map(|column| quotient(&column.heading, column.printed_unit().unwrap_or("")))
            .collect();
        let mut rows = Vec::new();
        for (i, row) in table.rows.iter().enumerate() {
            let mut cells = Vec::new();
            for (cell, column) in row.iter().zip(&table.columns) {
                cells.push(cell_text(cell, column, i)?);
            }
            rows.push(cells);
        }
        for (c, column) in table.columns.iter().enumerate() {
            if column.alignment == Alignment::Decimal {
                align(&mut rows, c, table);
            }
        }
        Ok(Self { heads, rows })
    }

    fn widths(&self) -> Vec<usize> {
        (0..self.heads.len()).map(|c| self.natural(c)).collect()
    }

    fn natural(&self, column: usize) -> usize {
        let cells = self.rows.iter().map(|row| width_of(&row[column]));
        cells
            .chain([width_of(&self.heads[column])])
            .max()
            .unwrap_or(0)
    }
}

/// Pads the numbers of a column on both sides, so that the decimal points stand under each other.
fn align(rows: &mut [Vec<String>], c: usize, table: &Table) {
    let number = |r: usize| table.rows[r][c] != Cell::Empty && !table.rows[r][c].is_text();
    let parts: Vec<Option<(usize, usize)>> = (0..rows.len())
        .map(|r| {
            number(r).then(|| {
                let (whole, tail) = split_at_point(&rows[r][c]);
                (width_of(whole), width_of(tail))
            })
        })
        .collect();
    let whole = parts.iter().flatten().map(|p| p.0).max().unwrap_or(0);
    let tail = parts.iter().flatten().map(|p| p.1).max().unwrap_or(0);
    for (row, part) in rows.iter_mut().zip(&parts) {
        if let Some((w, t)) = *part {
            row[c] = format!(
                "{}{}{}",
                " ".repeat(whole - w),
                row[c],
                "\u{a0}".repeat(tail - t)
            );
        }
    }
}

/// Widths of the columns within `total`: text columns give way, numbers never; `None` when that is not enough.
fn fitted(natural: &[usize], table: &Table, grid: &Grid, total: usize) -> Option<Vec<usize>> {
    let frame = 3 * natural.len();
    let mut widths = natural.to_vec();
    let least: Vec<usize> = (0..natural.len())
        .map(|c| {
            let longest_word = |s: &str| s.split_whitespace().map(width_of).max().unwrap_or(0);
            let head = longest_word(&grid.heads[c]);
            let cells = grid.rows.iter().map(|row| row[c].as_str());
            if table.columns[c].alignment == Alignment::Left {
                cells
                    .map(|s| longest_word(s).min(24))
                    .max()
                    .unwrap_or(0)
                    .max(head)
            } else {
                cells.map(width_of).max().unwrap_or(0).max(head)
            }
        })
        .collect();
    while widths.iter().sum::<usize>() + frame > total {
        let widest = (0..widths.len())
            .filter(|&c| widths[c] > least[c])
            .max_by_key(|&c| widths[c])?;
        widths[widest] -= 1;
    }
    Some(widths)
}

/// Characters that take a place; combining marks take none, East Asian wide ones two.
fn width_of(text: &str) -> usize {
    text.chars()
        .map(|c| match c as u32 {
            0x300..=0x36f | 0x200b..=0x200f | 0xfe00..=0xfe0f => 0,
            0x1100..=0x115f
            | 0x2e80..=0xa4cf
            | 0xac00..=0xd7a3
            | 0xf900..=0xfaff
            | 0xff00..=0xff60
            | 0x1f300..=0x1faff => 2,
            _ => 1,
        })
        .sum()
}

fn pad(text: &str, width: usize) -> String {
    format!("{text}{}", " ".repeat(width.saturating_sub(width_of(text))))
}

/// On one line, control characters as escapes: a name from a file must not steer the terminal.
fn clean(text: &str) -> String {
    let one_line: String = text
        .chars()
        .map(|c| if c == '\n' || c == '\t' { ' ' } else { c })
        .collect();
    Visible(&one_line).to_string()
}

/// Lines of at most `width`, broken at spaces, inside a word only where it is longer than a line. What is padded
/// to fit stays untouched.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let text = clean(text);
    if width_of(&text) <= width {
        return vec![text.replace('\u{a0}', " ")];
    }
    let mut lines = vec![String::new()];
    let mut used = 0;
    for word in text.split(' ').filter(|w| !w.is_empty()) {
        if used > 0 && used + 1 + width_of(word) <= width {
            lines.last_mut().expect("never empty").push(' ');
            used += 1;
        } else if used > 0 {
            lines.push(String::new());
            used = 0;
        }
        for c in word.chars() {
            let w = width_of(c.encode_utf8(&mut [0; 4]));
            if used + w > width && used > 0 {
                lines.push(String::new());
                used = 0;
            }
            lines.last_mut().expect("never empty").push(c);
            used += w;
        }
    }
    lines
}

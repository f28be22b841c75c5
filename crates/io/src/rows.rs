//! Reading the rows of a delimited text as numbers, block by block, in bounded memory.

use crate::field::{Fields, is_reading, other_mark, parse_number, shown};
use crate::findings;
use crate::layout::{Layout, sniff};
use crate::stamp::Stamp;
use crate::stream::StreamRows;
use crate::{Error, ErrorKind, Input, Result, Source, TimeWindow};
use proofmass_uncertainty::DecimalMark;
use proofmass_uncertainty::{Finding, Severity};
use rayon::prelude::*;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Bytes read at once. Two of these, and the numbers in one of them, are all the memory a reader needs.
const CHUNK: usize = 2 << 20;
/// Bytes that one thread converts at once; a constant, so that nothing depends on the number of threads.
const PIECE: usize = 128 << 10;
/// A line longer than this is not a row of a recording.
const LONGEST_LINE: usize = CHUNK / 2;

/// What a reader does with a field that is not a finite number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BadFields {
    /// The first one is an error.
    Refuse,
    /// Each is listed in [`RowBlock::bad`], and its number is NaN inside this crate only.
    Locate,
    /// As that; rows of another width are listed and passed over too.
    Survey,
}

/// A row that has not as many fields as the others.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct BadRow {
    /// Line, from one.
    pub line: u64,
    /// Fields that it has.
    pub fields: usize,
    /// Its beginning.
    pub text: String,
}

/// A field that is not a finite number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BadField {
    pub(crate) line: u64,
    pub(crate) selected: usize,
    pub(crate) text: String,
}

/// Consecutive rows of the selected columns.
#[derive(Clone, Debug, Default)]
pub struct RowBlock {
    pub(crate) columns: Vec<Vec<f64>>,
    /// (row, line): from this row on, line = line + (row' − row).
    pub(crate) lines: Vec<(usize, u64)>,
    pub(crate) rows: usize,
    pub(crate) text: Vec<u8>,
    pub(crate) ranges: Vec<Range<usize>>,
    pub(crate) stamps: Vec<Option<Stamp>>,
    pub(crate) bad: Vec<BadField>,
    pub(crate) bad_rows: Vec<BadRow>,
}

impl RowBlock {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Numbers of one selected column, in the order in which the columns were selected.
    pub fn column(&self, selected: usize) -> &[f64] {
        &self.columns[selected]
    }

    /// The same of some rows, multiplied by a factor after an offset was taken off.
    pub fn scaled(
        &self,
        selected: usize,
        rows: Range<usize>,
        offset: f64,
        factor: f64,
    ) -> Vec<f64> {
        self.columns[selected][rows]
            .iter()
            .map(|v| factor * (v - offset))
            .collect()
    }

    /// Line of the file on which a row stands.
    pub fn line(&self, row: usize) -> u64 {
        line_of(&self.lines, row)
    }

    /// The row as it stands in the file, where [`RowReader::keep_text`] asked for it.
    pub fn text(&self, row: usize) -> &[u8] {
        self.ranges.get(row).map_or(&[], |r| &self.text[r.clone()])
    }

    /// The stamps of the time column, exactly, where [`RowReader::stamps`] asked for them; `None` where a field is
    /// no stamp and that is not refused.
    pub fn stamps(&self) -> &[Option<Stamp>] {
        &self.stamps
    }

    /// Keeps some rows, which stand on these lines.
    fn keep(&mut self, inside: &[bool], lines: &[u64]) {
        fn chosen<T>(all: &mut Vec<T>, inside: &[bool]) {
            let mut inside = inside.iter();
            all.retain(|_| inside.next() == Some(&true));
        }
        self.columns.iter_mut().for_each(|c| chosen(c, inside));
        chosen(&mut self.ranges, inside);
        chosen(&mut self.stamps, inside);
        self.rows = lines.len();
        self.lines.clear();
        for (row, &line) in lines.iter().enumerate() {
            if row == 0 || lines[row - 1] + 1 != line {
                self.lines.push((row, line));
            }
        }
    }

    pub(crate) fn line_runs(&self) -> &[(usize, u64)] {
        &self.lines
    }
}

/// Line of a row from runs of consecutive lines.
pub(crate) fn line_of(runs: &[(usize, u64)], row: usize) -> u64 {
    let run = runs.partition_point(|&(first, _)| first <= row);
    match run.checked_sub(1).map(|i| runs[i]) {
        Some((first, line)) => line + (row - first) as u64,
        None => 0,
    }
}

/// Reads selected columns of a delimited text in blocks.
///
/// Memory is bounded by the block (2 MiB of text), whatever the size of the file. The SHA-256 of the whole file,
/// preamble included, is computed in the same pass.
pub struct RowReader {
    name: PathBuf,
    source: Source,
    layout: Layout,
    selected: Vec<usize>,
    /// For each file column up to the last selected one, where its number goes.
    plan: Vec<Option<usize>>,
    /// Text read but not yet turned into numbers.
    pending: Vec<u8>,
    next_line: u64,
    more: bool,
    /// A refusal met while reading ahead, due after the rows before it.
    late: Option<Error>,
    keep_text: bool,
    stamp_slot: Option<usize>,
    bad_fields: BadFields,
    window: Option<TimeWindow>,
    open_end: Option<OpenEnd>,
    /// In place of lines of text: the samples of another format.
    stream: Option<StreamRows>,
}

/// A last row without a line end.
#[derive(Clone, Debug)]
struct OpenEnd {
    line: u64,
    field: String,
    /// Fewer characters than every one of so many rows before it.
    shorter_than: Option<usize>,
}

impl RowReader {
    /// Opens a file with a known layout; `selected` are column indices from zero.
    ///
    /// The file is opened a second time, after the layout was found: for what can be read only once, such as a
    /// pipe, use [`Source`], [`Layout::of`] and [`RowReader::new`].
    ///
    /// # Errors
    /// The file cannot be opened; a column is selected twice or does not exist.
    pub fn open(path: &Path, layout: Layout, selected: &[usize]) -> Result<Self> {
        crate::layout::regular(path)?;
        Self::new(Source::open(path)?, layout, selected)
    }

    /// Reads the rows of a source whose layout [`Layout::of`] found; `selected` are column indices from zero.
    ///
    /// # Errors
    /// The source refuses; a column is selected twice or does not exist.
    pub fn new(mut source: Source, layout: Layout, selected: &[usize]) -> Result<Self> {
        let name = source.name().to_path_buf();
        let mut plan = vec![None; selected.iter().max().map_or(0, |m| m + 1)];
        for (to, &from) in selected.iter().enumerate() {
            if from >= layout.columns {
                return Err(Error::new(
                    ErrorKind::Column,
                    format!(
                        "there is no column {}; the file has {}",
                        from + 1,
                        layout.columns
                    ),
                )
                .at(&name));
            }
            if plan[from].replace(to).is_some() {
                return Err(
                    Error::new(ErrorKind::Column, "the same column is named twice")
                        .at(&name)
                        .column(layout.name(from))
                        .with_hint(
                            "every axis, the time and the temperature need a column of their own",
                        ),
                );
            }
        }
        let stream = match layout.stream {
            Some(_) => StreamRows::of(&mut source, selected).map_err(|e| e.at(&name))?,
            None => None,
        };
        let dated = |&column: &usize| layout.dated.get(column).is_some_and(|dated| *dated);
        let stamp_slot = selected.iter().position(dated);
        let mut preamble = Vec::new();
        source.fill(&mut preamble, layout.data_offset as usize)?;
        if preamble.len() as u64 != layout.data_offset {
            return Err(Error::new(
                ErrorKind::Format,
                "the file became shorter while it was read",
            )
            .at(&name)
            .with_hint("wait until it is complete, then run again"));
        }
        Ok(Self {
            name,
            source,
            next_line: layout.first_data_line,
            layout,
            selected: selected.to_vec(),
            plan,
            // Dates and times of day are no numbers; whoever selects them wants the times.
            stamp_slot,
            pending: Vec::new(),
            more: true,
            late: None,
            keep_text: false,
            bad_fields: BadFields::Refuse,
            window: None,
            open_end: None,
            stream,
        })
    }

    /// Keeps the text of every row beside its numbers.
    #[must_use]
    pub fn keep_text(mut self) -> Self {
        self.keep_text = true;
        if let Some(stream) = &mut self.stream
            && let Err(error) = stream.keep_text()
        {
            self.late = Some(error);
        }
        self
    }

    /// Reads one of the selected columns, counted from zero in their order, as time stamps: exactly, and not only where they are
    /// dates or times of day.
    #[must_use]
    pub fn stamps(mut self, selected: usize) -> Self {
        self.stamp_slot = Some(selected);
        self
    }

    /// Passes over every row outside of a window, damaged ones too.
    #[must_use]
    pub fn between(mut self, window: Option<TimeWindow>) -> Self {
        self.window = window;
        self
    }

    /// The window, where there is one.
    pub fn window(&self) -> Option<&TimeWindow> {
        self.window.as_ref()
    }

    pub(crate) fn locate_bad_fields(mut self) -> Self {
        self.bad_fields = BadFields::Locate;
        self
    }

    pub(crate) fn survey(mut self) -> Self {
        self.bad_fields = BadFields::Survey;
        self
    }

    /// The layout it reads by.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The next rows, `None` at the end of the file.
    ///
    /// # Errors
    /// A field that is not a finite number, a row of another width, a line of more than 1 MiB.
    pub fn next_block(&mut self) -> Result<Option<RowBlock>> {
        if self.stream.is_some() {
            return self.next_samples().map_err(|e| e.at(&self.name));
        }
        loop {
            if self.more && self.late.is_none() {
                let wanted = CHUNK.saturating_sub(self.pending.len());
                self.more = self.source.fill(&mut self.pending, wanted)?;
            }
            if self.pending.is_empty() || self.late.is_some() {
                return match self.late.take() {
                    Some(error) => Err(error),
                    None => Ok(None),
                };
            }
            let end = if self.more {
                memchr::memrchr(b'\n', &self.pending).map_or(0, |i| i + 1)
            } else {
                self.pending.len()
            };
            if self.pending.len() - end > LONGEST_LINE {
                let lines = memchr::memchr_iter(b'\n', &self.pending[..end]).count();
                return Err(self.refusal(&Fault {
                    line: lines as u64,
                    reason: Reason::Long,
                }));
            }
            let mut next = self.pending.split_off(end);
            let chunk = std::mem::take(&mut self.pending);
            let scan = Scan {
                layout: &self.layout,
                plan: &self.plan,
                selected: self.selected.len(),
                keep_text: self.keep_text,
                stamp_slot: self.stamp_slot,
                // What is damaged outside of the window is nobody's concern.
                bad_fields: match self.window {
                    Some(_) => BadFields::Survey,
                    None => self.bad_fields,
                },
            };
            let (source, more) = (&mut self.source, self.more);
            // The next text is read, unpacked and digested while this one is turned into numbers.
            let (ahead, pieces) = rayon::join(
                || {
                    if !more {
                        return Ok(false);
                    }
                    next.reserve_exact(CHUNK.saturating_sub(next.len()));
                    let wanted = CHUNK.saturating_sub(next.len());
                    source.fill(&mut next, wanted)
                },
                || {
                    pieces(&chunk)
                        .into_par_iter()
                        .map(|p| scan.piece(p))
                        .collect::<Vec<_>>()
                },
            );
            if !more {
                self.open_end = open_end(&chunk, &self.layout);
            }
            match ahead {
                Ok(more) => (self.pending, self.more) = (next, more),
                Err(error) => (self.late, self.more) = (Some(error), false),
            }
            let mut block = self.assemble(pieces, chunk)?;
            self.cut(&mut block)?;
            if let (false, Some(end)) = (more, &mut self.open_end) {
                end.line = self.next_line - 1;
            }
            if block.rows > 0 || !block.bad.is_empty() || !block.bad_rows.is_empty() {
                return Ok(Some(block));
            }
        }
    }

    /// The next rows of a stream of another format.
    fn next_samples(&mut self) -> Result<Option<RowBlock>> {
        if let Some(error) = self.late.take() {
            return Err(error);
        }
        let bad_fields = match self.window {
            Some(_) => BadFields::Survey,
            None => self.bad_fields,
        };
        while let Some(stream) = &mut self.stream {
            let Some(mut block) = stream.next_block(self.stamp_slot, bad_fields)? else {
                break;
            };
            self.cut(&mut block)?;
            if block.rows > 0 || !block.bad.is_empty() {
                return Ok(Some(block));
            }
        }
        Ok(None)
    }

    /// Takes out the rows outside of the window, and refuses what is damaged inside.
    fn cut(&mut self, block: &mut RowBlock) -> Result<()> {
        let Some(window) = &mut self.window else {
            return Ok(());
        };
        let inside = window.inside(block);
        let lines: Vec<u64> = (0..block.rows)
            .filter(|&row| inside[row])
            .map(|row| block.line(row))
            .collect();
        let (first, last) = (lines.first().copied(), lines.last().copied());
        let within = |line: u64| first.is_some_and(|f| f <= line) && Some(line) <= last;
        block.bad.retain(|b| within(b.line));
        block.bad_rows.retain(|b| within(b.line));
        block.keep(&inside, &lines);
        if self.bad_fields != BadFields::Survey
            && let Some(bad) = block.bad_rows.first()
        {
            return Err(self.refusal(&Fault {
                line: bad.line.wrapping_sub(self.next_line),
                reason: Reason::Width(bad.fields),
            }));
        }
        if self.bad_fields == BadFields::Refuse
            && let Some(bad) = block.bad.first()
        {
            return Err(bad_field(&bad.text, self.layout.decimal)
                .at(&self.name)
                .line(bad.line)
                .column(self.layout.name(self.selected[bad.selected])));
        }
        Ok(())
    }

    fn assemble(&mut self, pieces: Vec<Piece>, chunk: Vec<u8>) -> Result<RowBlock> {
        let mut block = RowBlock {
            columns: vec![Vec::new(); self.selected.len()],
            ..RowBlock::default()
        };
        for piece in pieces {
            if let Some(fault) = piece.fault {
                return Err(self.refusal(&fault));
            }
            for (row, line) in piece.runs {
                let run = (block.rows + row, self.next_line + line);
                if block.lines.is_empty() || line_of(&block.lines, run.0) != run.1 {
                    block.lines.push(run);
                }
            }
            block.bad.extend(piece.bad.into_iter().map(|b| BadField {
                line: self.next_line + b.line,
                ..b
            }));
            block
                .bad_rows
                .extend(piece.bad_rows.into_iter().map(|b| BadRow {
                    line: self.next_line + b.line,
                    ..b
                }));
            for (all, part) in block.columns.iter_mut().zip(&piece.columns) {
                all.extend_from_slice(part);
            }
            block.stamps.extend_from_slice(&piece.stamps);
            block.rows += piece.rows;
            block.ranges.extend(
                piece
                    .ranges
                    .into_iter()
                    .map(|r| r.start + piece.start..r.end + piece.start),
            );
            self.next_line += piece.lines;
        }
        if self.keep_text {
            block.text = chunk;
        }
        Ok(block)
    }

    fn refusal(&self, fault: &Fault) -> Error {
        let line = self.next_line.wrapping_add(fault.line);
        let at = |error: Error| error.at(&self.name).line(line);
        match &fault.reason {
            Reason::Width(got) => at(Error::new(
                ErrorKind::Row,
                format!("the row has {got} fields, the rows above have {}", self.layout.columns),
            ))
            .with_hint(
                "look at this line and the one before: a lost or doubled line, a separator inside a field, or a decimal \
                 comma; cut the damaged part out (or give `separator`, `decimal` or `skip_lines` in a campaign)",
            ),
            Reason::Long => at(Error::new(ErrorKind::Format, "a line is longer than 1 MiB"))
                .with_hint("a recording has one row per sample and a line end after each"),
            Reason::Field(column, text) => {
                let error = at(bad_field(text, self.layout.decimal)).column(self.layout.name(*column));
                let first = line == self.layout.first_data_line;
                if first && error.place_is_text() && !other_decimal_mark(text, self.layout.decimal) {
                    error.with_hint("if this line is a heading or a preamble, put # in front of it (or give `header = true` or `skip_lines` in a campaign); otherwise name a column of numbers")
                } else {
                    error
                }
            }
        }
    }

    /// Bytes of the file taken in so far, as they stand there, for a display of progress.
    pub fn bytes_read(&self) -> u64 {
        if let (Some(stream), Some(size)) = (&self.stream, self.size()) {
            return (stream.share() * size as f64) as u64;
        }
        self.source.bytes_read()
    }

    /// Size of the file, where it is known beforehand.
    pub fn size(&self) -> Option<u64> {
        self.source.size()
    }

    /// What is doubtful about the end of the file, once every block was read: a last row without a line end.
    ///
    /// A program that ends every row with a line end leaves such a row only when it was interrupted, perhaps inside
    /// the last number. It is a warning where the row is shorter than each of up to fifty before it: among n + 1
    /// rows of a complete file, equally distributed, the last is the shortest by itself with a probability of at
    /// most 1/(n + 1).
    pub fn findings(&self) -> Vec<Finding> {
        let Some(end) = &self.open_end else {
            return Vec::new();
        };
        let (severity, more) = match end.shorter_than {
            Some(n) => (
                Severity::Warning,
                format!(", and the row is shorter than each of the {n} before it"),
            ),
            None => (Severity::Note, String::new()),
        };
        vec![findings::last_row_open(end.line, &end.field, &more).at(severity)]
    }

    /// SHA-256 of the file in hexadecimal digits, once every block was read.
    ///
    /// # Errors
    /// The rest of the file cannot be read.
    pub fn sha256(self) -> Result<String> {
        Ok(self.finish()?.sha256)
    }

    /// Name and digest of what was read, once every block was.
    ///
    /// # Errors
    /// The rest of the file cannot be read.
    pub fn finish(self) -> Result<Input> {
        self.source.finish()
    }
}

/// Looks at the end of the last chunk; the line is filled in by the caller.
fn open_end(chunk: &[u8], layout: &Layout) -> Option<OpenEnd> {
    const BEFORE: usize = 50;
    if chunk
        .last()
        .is_none_or(|b| matches!(b, b'\n' | b'\r' | 0x1A))
    {
        return None;
    }
    let mut rows = chunk
        .rsplit(|b| *b == b'\n')
        .map(|l| l.strip_suffix(b"\r").unwrap_or(l))
        .filter(|l| !l.trim_ascii().is_empty() && !sniff::is_comment(l, &layout.comment));
    let last = rows.next()?;
    if !std::ptr::eq(last.as_ptr_range().end, chunk.as_ptr_range().end) {
        return None;
    }
    let before: Vec<usize> = rows.take(BEFORE).map(<[u8]>::len).collect();
    let shorter = before.len() >= 10 && before.iter().all(|&n| last.len() < n);
    let field = sniff::split(last, layout.separator).pop().unwrap_or(last);
    Some(OpenEnd {
        line: 0,
        field: shown(field),
        shorter_than: shorter.then_some(before.len()),
    })
}

impl Error {
    fn place_is_text(&self) -> bool {
        self.to_string().contains("is not a number")
    }
}

/// Whether a field would be a number with the other decimal mark.
fn other_decimal_mark(text: &str, decimal: DecimalMark) -> bool {
    parse_number(text.as_bytes(), other_mark(decimal)).is_some()
}

/// Whether the digits before the decimal mark stand in groups of three, and no other reading is left: `1,021.13`, `1.021.130,5`.
fn has_thousands(text: &str, decimal: DecimalMark) -> bool {
    let (mark, other) = match decimal {
        DecimalMark::Point => ('.', ','),
        DecimalMark::Comma => (',', '.'),
    };
    let number = text.trim().trim_start_matches(['+', '-']);
    let (whole, rest) = number.split_once(mark).unwrap_or((number, ""));
    let digits = |part: &str| part.bytes().all(|b| b.is_ascii_digit());
    [other, '\'', ' ', '\u{a0}', '\u{202f}']
        .into_iter()
        .any(|group| {
            let groups: Vec<&str> = whole.split(group).collect();
            let several = groups.len() > 2 || groups.len() == 2 && number.contains(mark);
            let first = (1..=3).contains(&groups[0].len());
            several
                && first
                && digits(rest)
                && groups.iter().all(|g| digits(g))
                && groups[1..].iter().all(|g| g.len() == 3)
        })
}

pub(crate) fn bad_field(text: &str, decimal: DecimalMark) -> Error {
    let lower = text
        .trim()
        .trim_start_matches(['+', '-'])
        .to_ascii_lowercase();
    if has_thousands(text, decimal) {
        return Error::new(
            ErrorKind::Field,
            format!("\"{text}\" has marks of thousands"),
        )
        .with_hint("export the numbers without them; only the decimal mark stands in a number");
    }
    let (what, hint) = if text.is_empty() {
        (
            "the field is empty".to_string(),
            "a sample is missing: cut the recording before or after this line; nothing is filled in silently",
        )
    } else if lower.starts_with("nan") {
        (
            format!("\"{text}\" is not a finite number"),
            "cut the recording before or after this line; missing samples are not filled in silently",
        )
    } else if lower.starts_with("inf") {
        (
            format!("\"{text}\" is not a finite number"),
            "the sensor or the converter overflowed here: cut this part out of the recording",
        )
    } else if text.bytes().any(|b| b.is_ascii_digit())
        && parse_number(text.as_bytes(), decimal).is_some()
    {
        (
            format!("\"{text}\" is too large for a reading, which is below 1e100"),
            "the sensor or the converter overflowed here: cut this part out of the recording",
        )
    } else if decimal == DecimalMark::Point && text.contains(',') {
        (
            format!("\"{text}\" is not a number"),
            "write all numbers of the file with the same decimal mark, the point or the comma (or give `decimal = \"comma\"` in a campaign)",
        )
    } else if decimal == DecimalMark::Comma
        && text.contains('.')
        && text.bytes().any(|b| b.is_ascii_digit())
    {
        (
            format!("\"{text}\" has a point, where the decimal mark is the comma"),
            "the point may be a decimal mark or group thousands: export the file with one decimal mark and no marks between thousands",
        )
    } else {
        (
            format!("\"{text}\" is not a number"),
            "correct the field or cut the line out; a column of text cannot be used as a signal",
        )
    };
    Error::new(ErrorKind::Field, what).with_hint(hint)
}

/// Cuts a chunk at line ends into pieces of about [`PIECE`] bytes: (offset, bytes).
fn pieces(chunk: &[u8]) -> Vec<(usize, &[u8])> {
    let mut pieces = Vec::new();
    let mut start = 0;
    while start < chunk.len() {
        let about = (start + PIECE).min(chunk.len());
        let end = memchr::memchr(b'\n', &chunk[about..]).map_or(chunk.len(), |i| about + i + 1);
        pieces.push((start, &chunk[start..end]));
        start = end;
    }
    pieces
}

#[derive(Default)]
struct Piece {
    start: usize,
    columns: Vec<Vec<f64>>,
    rows: usize,
    lines: u64,
    runs: Vec<(usize, u64)>,
    ranges: Vec<Range<usize>>,
    stamps: Vec<Option<Stamp>>,
    bad: Vec<BadField>,
    bad_rows: Vec<BadRow>,
    fault: Option<Fault>,
}

struct Fault {
    line: u64,
    reason: Reason,
}

enum Reason {
    Long,
    Width(usize),
    Field(usize, String),
}

struct Scan<'a> {
    layout: &'a Layout,
    plan: &'a [Option<usize>],
    selected: usize,
    keep_text: bool,
    stamp_slot: Option<usize>,
    bad_fields: BadFields,
}

impl Scan<'_> {
    fn piece(&self, (start, bytes): (usize, &[u8])) -> Piece {
        // Room for rows of eight bytes a field; grows where they are shorter.
        let room = bytes.len() / (8 * self.layout.columns.max(1)) + 1;
        let mut piece = Piece {
            start,
            columns: (0..self.selected)
                .map(|_| Vec::with_capacity(room))
                .collect(),
            ..Piece::default()
        };
        let mut numbers = vec![0.0; self.selected];
        let mut stamp = None;
        let mut at = 0;
        while at < bytes.len() {
            let end = memchr::memchr(b'\n', &bytes[at..]).map_or(bytes.len(), |i| at + i);
            let line = &bytes[at..end];
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            let number = piece.lines;
            piece.lines += 1;
            let range = at..at + line.len();
            at = end + 1;
            match line.iter().find(|b| !matches!(b, b' ' | b'\t')) {
                None => continue,
                // Data seldom start with these, so the full comparison is seldom made.
                Some(b)
                    if !matches!(b, b'0'..=b'9' | b'-' | b'+' | b'.')
                        && sniff::is_comment(line, &self.layout.comment) =>
                {
                    continue;
                }
                // End-of-file mark of old programs.
                Some(0x1A) if line.trim_ascii() == [0x1A] => continue,
                Some(_) => {}
            }
            match self.row(line, &mut numbers, &mut stamp) {
                Ok(()) => {}
                Err(Reason::Width(fields)) if self.bad_fields == BadFields::Survey => {
                    piece.bad_rows.push(BadRow {
                        line: number,
                        fields,
                        text: shown(line),
                    });
                    continue;
                }
                Err(Reason::Field(..)) if self.bad_fields != BadFields::Refuse => {
                    stamp = self.locate(line, number, &mut numbers, &mut piece.bad);
                }
                Err(reason) => {
                    piece.fault = Some(Fault {
                        line: number,
                        reason,
                    });
                    return piece;
                }
            }
            for (column, &number) in piece.columns.iter_mut().zip(&numbers) {
                column.push(number);
            }
            if piece.runs.is_empty() || line_of(&piece.runs, piece.rows) != number {
                piece.runs.push((piece.rows, number));
            }
            if self.keep_text {
                piece.ranges.push(range);
            }
            if self.stamp_slot.is_some() {
                piece.stamps.push(stamp);
            }
            piece.rows += 1;
        }
        piece
    }

    /// Converts one row. Fields are checked in order, then the width.
    fn row(
        &self,
        line: &[u8],
        numbers: &mut [f64],
        stamp: &mut Option<Stamp>,
    ) -> Result<(), Reason> {
        if line.len() > LONGEST_LINE {
            return Err(Reason::Long);
        }
        let separator = self.layout.separator;
        let decimal = self.layout.decimal;
        let mut fields = Fields::new(line, separator);
        let mut count = 0;
        let mut last_empty = false;
        let mut bad = None;
        loop {
            // The numbers are read where they stand, without first looking for the end of the field.
            let slot = self.plan.get(count).copied().flatten();
            let timed = slot.is_some() && slot == self.stamp_slot;
            if let (Some(slot), DecimalMark::Point) = (slot, decimal)
                && !timed
                && let Some(value) = fields.number()
            {
                numbers[slot] = value;
                last_empty = false;
                count += 1;
                continue;
            }
            let Some(field) = fields.next_field() else {
                break;
            };
            last_empty = field.is_empty();
            if timed {
                *stamp = Stamp::parse(field, decimal);
                match (slot, *stamp) {
                    (Some(slot), Some(stamp)) => numbers[slot] = stamp.value(),
                    _ if bad.is_none() => bad = Some((count, field)),
                    _ => {}
                }
            } else if let Some(slot) = slot {
                match parse_number(field, decimal) {
                    Some(value) if is_reading(value) => numbers[slot] = value,
                    _ if bad.is_none() => bad = Some((count, field)),
                    _ => {}
                }
            }
            count += 1;
        }
        let columns = self.layout.columns;
        if !(count == columns || count == columns + 1 && last_empty) {
            return Err(Reason::Width(count));
        }
        match bad {
            Some((column, field)) => Err(Reason::Field(column, shown(field))),
            None => Ok(()),
        }
    }

    /// Converts what can be converted of a row and lists the rest.
    fn locate(
        &self,
        line: &[u8],
        number: u64,
        numbers: &mut [f64],
        bad: &mut Vec<BadField>,
    ) -> Option<Stamp> {
        let decimal = self.layout.decimal;
        let mut stamp = None;
        let fields = sniff::split(line, self.layout.separator);
        for (field, slot) in fields.iter().zip(self.plan) {
            let Some(slot) = *slot else { continue };
            let value = if Some(slot) == self.stamp_slot {
                stamp = Stamp::parse(field, decimal);
                stamp.map(Stamp::value)
            } else {
                parse_number(field, decimal).filter(|v| is_reading(*v))
            };
            numbers[slot] = value.unwrap_or_else(|| {
                bad.push(BadField {
                    line: number,
                    selected: slot,
                    text: shown(field),
                });
                f64::NAN
            });
        }
        stamp
    }
}

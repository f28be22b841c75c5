//! A recording written again with some columns replaced: everything else goes through as it stands.

use crate::field::{Fields, parse_number};
use crate::layout::{Layout, Separator, sniff};
use crate::output::AtomicFile;
use crate::written::Written;
use crate::{Error, ErrorKind, Result, RowBlock, Unit, split_heading};
use proofmass_uncertainty::DecimalMark;
use rayon::prelude::*;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Rows that one thread formats at once; a constant, so that nothing depends on the number of threads.
pub(crate) const PIECE: usize = 2048;

/// Writes a recording again, block by block, with new numbers in some of its columns.
///
/// The output is comma-separated UTF-8 with one header line and one line per row. Fields of the other columns keep
/// their characters; only decimal commas become points, and a field that needs quotes gets them. A column without a
/// heading is called `column_1`; a unit that stood in a second header line is appended as ` (ms)`. Comments, blank
/// lines and the preamble are left out.
///
/// **Units** those of the new headings; numbers are written with the fewest digits that read back as the same double.
///
/// ```
/// use proofmass_io::{Layout, Rewriter, RowReader};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let (input, output) = (folder.path().join("raw.csv"), folder.path().join("compensated.csv"));
/// std::fs::write(&input, "t;acc;label\n0,10;3;still\n0,20;5;moved, then still\n").unwrap();
/// let layout = Layout::sniff(&input)?;
/// let mut reader = RowReader::open(&input, layout.clone(), &[1])?.keep_text();
/// let mut writer = Rewriter::create(&output, &layout, &[(1, "acc_m/s2".into())], &[&input])?;
/// while let Some(block) = reader.next_block()? {
///     let twice: Vec<f64> = block.column(0).iter().map(|v| 2.0 * v).collect();
///     writer.block(&block, &[&twice])?;
/// }
/// writer.commit()?;
/// assert_eq!(
///     std::fs::read_to_string(&output).unwrap(),
///     "t,acc_m/s2,label\n0.10,6.0,still\n0.20,10.0,\"moved, then still\"\n"
/// );
/// # Ok::<(), proofmass_io::Error>(())
/// ```
#[derive(Debug)]
pub struct Rewriter {
    to: Written,
    source: Option<PathBuf>,
    plan: Plan,
}

/// What the threads that format need to know.
#[derive(Debug)]
struct Plan {
    separator: Separator,
    decimal: DecimalMark,
    numeric: Vec<bool>,
    /// For each column of the file, which of the new columns takes its place.
    places: Vec<Option<usize>>,
    /// New headings, for messages.
    headings: Vec<String>,
}

impl Rewriter {
    /// Begins a file that will stand at `path`, from a recording of the given layout.
    ///
    /// `replaced` names the columns (from zero) that get new numbers, with their new headings. `inputs` are files
    /// that may not be overwritten, the recording itself first: messages name it.
    ///
    /// # Errors
    /// As [`AtomicFile::create`]; a column that does not exist or is replaced twice, a new heading that the file
    /// has already.
    pub fn create(
        path: &Path,
        layout: &Layout,
        replaced: &[(usize, String)],
        inputs: &[&Path],
    ) -> Result<Self> {
        let (plan, header) = Plan::new(path, layout, replaced)?;
        let mut to = Written::create(path, inputs)?;
        to.write_all(&header)?;
        Ok(Self {
            to,
            source: inputs.first().map(|p| p.to_path_buf()),
            plan,
        })
    }

    /// The same in memory; `source` is what messages call the recording. [`Rewriter::into_bytes`] gives the file.
    ///
    /// # Errors
    /// As [`Rewriter::create`], but for the place.
    pub fn in_memory(source: &Path, layout: &Layout, replaced: &[(usize, String)]) -> Result<Self> {
        let (plan, header) = Plan::new(source, layout, replaced)?;
        Ok(Self {
            to: Written::Bytes(header),
            source: Some(source.to_path_buf()),
            plan,
        })
    }

    /// Writes the rows of a block that was read with [`RowReader::keep_text`](crate::RowReader::keep_text).
    ///
    /// `values` holds one slice for each replaced column, in the order in which [`Rewriter::create`] named them.
    /// A block is written whole or, when it is refused, not at all.
    ///
    /// # Errors
    /// A number that is not finite (with the line of the recording), a block without text, slices of another
    /// number or length, a disk that refuses.
    pub fn block(&mut self, block: &RowBlock, values: &[&[f64]]) -> Result<()> {
        self.rows(block, 0..block.rows(), values)
    }

    /// Writes some rows of a block; `values` are those of these rows.
    ///
    /// # Errors
    /// As [`Rewriter::block`]; rows that the block does not have.
    pub fn rows(&mut self, block: &RowBlock, rows: Range<usize>, values: &[&[f64]]) -> Result<()> {
        self.every(block, rows, 1, values)
    }

    /// Writes every so many of some rows of a block, the first included; `values` are those of these.
    ///
    /// # Errors
    /// As [`Rewriter::rows`].
    pub fn every(
        &mut self,
        block: &RowBlock,
        rows: Range<usize>,
        step: usize,
        values: &[&[f64]],
    ) -> Result<()> {
        let step = step.max(1);
        let count = rows.len().div_ceil(step);
        let fits = values.len() == self.plan.headings.len()
            && values.iter().all(|v| v.len() == count)
            && rows.end <= block.rows()
            && (count == 0 || !block.text(rows.start).is_empty());
        if !fits {
            let lengths: Vec<usize> = values.iter().map(|v| v.len()).collect();
            return Err(self.to.refusal(format!(
                "{} columns of {count} rows, read with their text, are to be replaced; values came for {lengths:?} rows",
                self.plan.headings.len(),
            )));
        }
        let pieces: Vec<Result<Vec<u8>>> = (0..count.div_ceil(PIECE))
            .into_par_iter()
            .map(|i| {
                let piece = i * PIECE..count.min((i + 1) * PIECE);
                self.plan.rows(block, (rows.start, step), values, piece)
            })
            .collect();
        // The first refusal in the order of rows, and nothing written of its block.
        let pieces = pieces
            .into_iter()
            .collect::<Result<Vec<_>>>()
            .map_err(|e| match &self.source {
                Some(source) => e.at(source),
                None => e,
            })?;
        pieces.iter().try_for_each(|p| self.to.write_all(p))
    }

    /// The file that is written, for its digest; none in memory.
    pub fn file(&self) -> Option<&AtomicFile> {
        match &self.to {
            Written::File(file) => Some(file),
            Written::Bytes(_) => None,
        }
    }

    /// SHA-256 of what was written so far, in hexadecimal digits.
    pub fn sha256(&self) -> String {
        self.to.sha256()
    }

    /// Waits until all that was written is on the disk; the place is not touched yet.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn settle(&mut self) -> Result<()> {
        self.to.settle()
    }

    /// Puts the file in its place; what was written in memory is lost.
    ///
    /// # Errors
    /// The disk refuses; what stood there before is then still there.
    pub fn commit(self) -> Result<()> {
        self.to.commit()
    }

    /// What was written in memory; `None` for a file.
    pub fn into_bytes(self) -> Option<Vec<u8>> {
        self.to.into_bytes()
    }
}

impl Plan {
    /// The plan and the header line; messages name `path`.
    fn new(path: &Path, layout: &Layout, replaced: &[(usize, String)]) -> Result<(Self, Vec<u8>)> {
        let wrong = |what: String, name: &str| {
            Err(Error::new(ErrorKind::Column, what).at(path).column(name))
        };
        let mut places = vec![None; layout.columns];
        let mut header: Vec<String> = (0..layout.columns).map(|i| heading(layout, i)).collect();
        for (new, (column, name)) in replaced.iter().enumerate() {
            let Some(place) = places.get_mut(*column) else {
                let columns = layout.columns;
                return wrong(
                    format!("there is no column {}; the file has {columns}", column + 1),
                    name,
                );
            };
            if place.replace(new).is_some() {
                return wrong(format!("column {} is replaced twice", column + 1), name);
            }
            header[*column].clone_from(name);
        }
        for (column, name) in replaced {
            if let Some(other) = (0..header.len()).find(|&i| i != *column && header[i] == *name) {
                return wrong(
                    format!("column {} of the file has this name already", other + 1),
                    name,
                )
                .map_err(|e| e.with_hint("rename that column in the header of the recording"));
            }
        }
        let mut line = Vec::new();
        for (i, name) in header.iter().enumerate() {
            if i > 0 {
                line.push(b',');
            }
            push_text(&mut line, name.as_bytes(), i == 0);
        }
        line.push(b'\n');
        Ok((
            Self {
                separator: layout.separator,
                decimal: layout.decimal,
                numeric: layout.numeric.clone(),
                places,
                headings: replaced.iter().map(|(_, name)| name.clone()).collect(),
            },
            line,
        ))
    }

    /// Rows of a piece, counted in steps from row `first` of the block, which `values` begin with.
    fn rows(
        &self,
        block: &RowBlock,
        (first, step): (usize, usize),
        values: &[&[f64]],
        piece: Range<usize>,
    ) -> Result<Vec<u8>> {
        let texts = piece
            .clone()
            .map(|r| block.text(first + r * step).len() + 1);
        let room = texts.sum::<usize>();
        // A double takes up to 24 characters, and seldom fewer than 16 after a computation.
        let mut out = Vec::with_capacity(room + piece.len() * 20 * values.len());
        let mut digits = ryu::Buffer::new();
        for row in piece {
            let text = block.text(first + row * step);
            let line = block.line(first + row * step);
            let plain = self.is_plain(text);
            let mut fields = Fields::new(text, self.separator);
            for (column, place) in self.places.iter().enumerate() {
                let Some(field) = fields.next_field() else {
                    return Err(Error::new(
                        ErrorKind::Row,
                        format!(
                            "the row has {column} fields, the layout {}",
                            self.places.len()
                        ),
                    )
                    .line(line));
                };
                if column > 0 {
                    out.push(b',');
                }
                match *place {
                    Some(new) if values[new][row].is_finite() => {
                        out.extend_from_slice(digits.format_finite(values[new][row]).as_bytes());
                    }
                    Some(new) => {
                        return Err(Error::new(
                            ErrorKind::Output,
                            format!(
                                "the new value is {}, which may not be written",
                                values[new][row]
                            ),
                        )
                        .line(line)
                        .column(&self.headings[new])
                        .with_hint(
                            "look at this row of the recording: no finite number came out of it",
                        ));
                    }
                    None if plain => out.extend_from_slice(field),
                    None => self.push_field(&mut out, field, column),
                }
            }
            out.push(b'\n');
        }
        Ok(out)
    }

    /// Whether the fields of a row can be copied without a closer look, as nearly all can.
    fn is_plain(&self, row: &[u8]) -> bool {
        let special = match self.separator {
            Separator::Comma => memchr::memchr2(b'"', b'\r', row),
            _ => memchr::memchr3(b'"', b'\r', b',', row),
        };
        special.is_none()
            && row.is_ascii()
            && row
                .trim_ascii_start()
                .first()
                .is_none_or(|b| matches!(b, b'0'..=b'9' | b'-' | b'+' | b'.'))
    }

    fn push_field(&self, out: &mut Vec<u8>, field: &[u8], column: usize) {
        if self.decimal == DecimalMark::Comma
            && self.numeric.get(column) == Some(&true)
            && memchr::memchr(b',', field).is_some()
            && parse_number(field, DecimalMark::Comma).is_some()
        {
            let digits = field.iter().filter(|b| **b != b'"');
            out.extend(digits.map(|&b| if b == b',' { b'.' } else { b }));
        } else if is_quoted(field) && field.is_ascii() {
            out.extend_from_slice(field);
        } else {
            push_text(out, sniff::decode(field).as_bytes(), column == 0);
        }
    }
}

/// Text as a field, quoted where it must be.
pub(crate) fn push_text(out: &mut Vec<u8>, field: &[u8], first: bool) {
    // A row that begins like a comment would be passed over by readers, this crate's among them.
    let like_comment = first
        && ["#", "%", "//"]
            .iter()
            .any(|p| field.starts_with(p.as_bytes()));
    let special = memchr::memchr3(b',', b'"', b'\r', field).is_some();
    if !(special || like_comment) {
        out.extend_from_slice(field);
        return;
    }
    out.push(b'"');
    for &b in field {
        if b == b'"' {
            out.push(b'"');
        }
        out.push(b);
    }
    out.push(b'"');
}

/// Whether a field is in quotes as RFC 4180 has it: every quote inside doubled.
fn is_quoted(field: &[u8]) -> bool {
    let inside = field
        .strip_prefix(b"\"")
        .and_then(|f| f.strip_suffix(b"\""));
    inside.is_some_and(|f| {
        let mut quotes = memchr::memchr_iter(b'"', f);
        while let Some(i) = quotes.next() {
            if quotes.next() != Some(i + 1) {
                return false;
            }
        }
        true
    })
}

/// Heading of a column that is kept, with the unit that stood in a line of its own.
fn heading(layout: &Layout, column: usize) -> String {
    let own = layout.header.as_ref().and_then(|h| h.get(column));
    let name = match own.map(|h| h.trim()) {
        Some(h) if !h.is_empty() => h.to_string(),
        _ => format!("column_{}", column + 1),
    };
    match layout.unit(column) {
        Some(unit) if unit != Unit::One && split_heading(&name).1.is_none() => {
            format!("{name} ({})", unit.ascii())
        }
        _ => name,
    }
}

//! The shape of a delimited text: separator, decimal mark, header, comments. Sniffed, and every property can be given.

pub(crate) mod sniff;

use crate::column_head::ColumnHead;
use crate::findings;
use crate::{Error, ErrorKind, Result, Source, StreamLayout, Unit, UnitRatio, split_heading};
use proofmass_uncertainty::{DecimalMark, Finding};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// What stands between two fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Separator {
    /// `,`
    #[serde(rename = "comma", alias = ",")]
    Comma,
    /// `;`
    #[serde(rename = "semicolon", alias = ";")]
    Semicolon,
    /// Tabulator.
    #[serde(rename = "tab", alias = "\t")]
    Tab,
    /// `|`
    #[serde(rename = "pipe", alias = "|")]
    Pipe,
    /// Any run of blanks and tabulators.
    #[serde(rename = "whitespace", alias = " ", alias = "space", alias = "spaces")]
    Whitespace,
}

impl Separator {
    /// The separating byte; `None` for runs of white space.
    pub(crate) fn byte(self) -> Option<u8> {
        match self {
            Self::Comma => Some(b','),
            Self::Semicolon => Some(b';'),
            Self::Tab => Some(b'\t'),
            Self::Pipe => Some(b'|'),
            Self::Whitespace => None,
        }
    }
}

impl fmt::Display for Separator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Comma => "comma",
            Self::Semicolon => "semicolon",
            Self::Tab => "tab",
            Self::Pipe => "pipe",
            Self::Whitespace => "white space",
        })
    }
}

/// What the user knows about the text; everything that is `None` is sniffed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayoutOptions {
    /// Separator of fields.
    pub separator: Option<Separator>,
    /// Whether the first row of full width is a header.
    pub header: Option<bool>,
    /// Prefixes of lines to be passed over; `#`, `%` and `//` when not given.
    pub comment: Option<Vec<String>>,
    /// Decimal mark.
    pub decimal: Option<DecimalMark>,
    /// Number of lines to pass over at the top of the file.
    pub skip_lines: Option<usize>,
}

impl LayoutOptions {
    /// What these leave open, as the others say it.
    fn or(self, others: &Self) -> Self {
        Self {
            separator: self.separator.or(others.separator),
            header: self.header.or(others.header),
            comment: self.comment.or_else(|| others.comment.clone()),
            decimal: self.decimal.or(others.decimal),
            skip_lines: self.skip_lines.or(others.skip_lines),
        }
    }
}

/// The shape of one delimited text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Layout {
    /// Separator of fields.
    pub separator: Separator,
    /// Decimal mark.
    pub decimal: DecimalMark,
    /// Whether somebody said which one it is.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(crate) decimal_is_stated: bool,
    /// Prefixes of lines to be passed over.
    pub(crate) comment: Vec<String>,
    /// Column headings as they stand in the file; `None` without a header.
    pub header: Option<Vec<String>>,
    /// Units, where a second header line carries them.
    pub(crate) unit_line: Option<Vec<Option<Unit>>>,
    /// Lines above the data that are neither comment, nor heading, nor skipped by request: number, and the beginning of those that may be rows.
    pub passed_over: Vec<(u64, String)>,
    /// Number of columns of a row.
    pub columns: usize,
    /// Whether each column holds numbers, judged on the head of the file.
    pub numeric: Vec<bool>,
    /// Whether each column holds dates with times or times of day, judged on the head of the file.
    pub(crate) dated: Vec<bool>,
    /// Columns that hold numbers with another decimal mark than the rest of the file.
    #[serde(skip)]
    pub(crate) other_mark: Vec<usize>,
    /// Line of the first row of data, counted from one.
    pub first_data_line: u64,
    /// Byte at which that line begins.
    pub(crate) data_offset: u64,
    /// Where it is the stream of another format than text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stream: Option<Box<StreamLayout>>,
    /// What the first rows of every column hold.
    #[serde(skip)]
    pub(crate) head: Vec<ColumnHead>,
}

/// How much of a file is looked at.
const HEAD: usize = 64 << 10;
/// How much at most, where rows are long.
const LARGEST_HEAD: usize = 4 << 20;
/// Line ends that make a head long enough.
const ROWS_WANTED: usize = 8;

impl Layout {
    /// Looks at the beginning of a file.
    ///
    /// # Errors
    /// A file that is missing, empty, a folder, a pipe, binary, or holds no rows.
    pub fn sniff(path: &Path) -> Result<Self> {
        Self::sniff_with(path, &LayoutOptions::default())
    }

    /// Looks at the beginning of a file; what `options` says is taken as given.
    ///
    /// # Errors
    /// As [`Layout::sniff`].
    pub fn sniff_with(path: &Path, options: &LayoutOptions) -> Result<Self> {
        regular(path)?;
        Self::of(&mut Source::open(path)?, options)
    }

    /// Looks at what lies ahead in a source, 64 KiB or as much as a wide table needs; nothing is consumed.
    ///
    /// # Errors
    /// A source that is empty, binary, or holds no rows.
    pub fn of(source: &mut Source, options: &LayoutOptions) -> Result<Self> {
        let name = source.name().to_path_buf();
        if crate::stream::open(source).map_err(|e| e.at(&name))?
            && let Some(opened) = &source.opened
        {
            return opened.one().cloned().map_err(|e| e.at(&name));
        }
        let options = &options.clone().or(&source.layout);
        let mut size = HEAD;
        loop {
            // One byte more tells whether the head is the whole text.
            let (ahead, at_end) = source.ahead(size + 1)?;
            let complete = at_end && ahead.len() <= size;
            let head = &ahead[..ahead.len().min(size)];
            // A header of thousands of columns fills the head by itself.
            let few = memchr::memchr_iter(b'\n', head).take(ROWS_WANTED).count() < ROWS_WANTED;
            if !complete && few && size < LARGEST_HEAD && !sniff::is_binary(head) {
                size *= 4;
                continue;
            }
            return sniff::layout(head, complete, options).map_err(|e| e.at(&name));
        }
    }

    /// What is doubtful about the shape, or what the reader of another format noticed: lines that were passed over though nothing marks them as comments.
    ///
    /// A row that lost a part of itself at the top of a file looks like such a line.
    pub fn findings(&self) -> Vec<Finding> {
        if let Some(stream) = &self.stream {
            return stream.findings.clone();
        }
        let Some((line, text)) = self.passed_over.first() else {
            return Vec::new();
        };
        let n = self.passed_over.len();
        let more = match n {
            1 => String::new(),
            _ => format!(
                ", and {} more up to line {}",
                n - 1,
                self.passed_over[n - 1].0
            ),
        };
        let text = match text.as_str() {
            "" => String::new(),
            text => format!(", \"{text}\""),
        };
        vec![findings::preamble_skipped(*line, &text, &more)]
    }

    /// The rate behind a line above the data that holds the number of rows and their interval, as files of strong motion have it:
    /// the line, its text and the rate, Hz.
    pub(crate) fn counted_above(&self) -> Option<(u64, &str, f64)> {
        self.passed_over.iter().find_map(|(line, text)| {
            let mut words = text.split_whitespace();
            let (count, interval) = (words.next()?.parse::<u64>().ok()?, words.next()?);
            let interval = interval
                .parse::<f64>()
                .ok()
                .filter(|dt| 1e-6 < *dt && *dt < 1.0)?;
            (count > 1 && words.next().is_none()).then(|| (*line, text.as_str(), 1.0 / interval))
        })
    }

    /// Name of a column without its unit; `column 3` without a header.
    pub fn name(&self, index: usize) -> String {
        match self.header.as_ref().and_then(|h| h.get(index)) {
            Some(heading) if !heading.trim().is_empty() => {
                let (name, unit) = split_heading(heading);
                if name.is_empty() || unit.is_none() {
                    heading.trim().to_string()
                } else {
                    name.to_string()
                }
            }
            _ => format!("column {}", index + 1),
        }
    }

    /// Unit of a column where the heading or the line below it says so.
    pub fn unit(&self, index: usize) -> Option<Unit> {
        let line = self
            .unit_line
            .as_ref()
            .and_then(|u| u.get(index).copied().flatten());
        line.or_else(|| {
            self.header
                .as_ref()
                .and_then(|h| h.get(index))
                .and_then(|heading| match split_heading(heading) {
                    // A heading that is a unit of a raw output or of time and nothing else: `V`, `millis`, `seconds`.
                    (_, None) => Unit::recognise(heading).filter(|u| {
                        u.is_raw() || u.is_time() && *u != Unit::Minute && heading.trim().len() > 1
                    }),
                    (_, unit) => unit,
                })
        })
    }

    /// The unit of a column that may be one over another, as that of a sensitivity, where the heading says so.
    pub fn ratio(&self, index: usize) -> Option<UnitRatio> {
        let heading = self.header.as_ref().and_then(|h| h.get(index));
        let ratio = heading.and_then(|heading| UnitRatio::split_heading(heading));
        let itself = || {
            let (over, under) = (self.unit(index)?, Unit::One);
            Some(UnitRatio { over, under })
        };
        ratio.map(|(_, ratio)| ratio).or_else(itself)
    }

    /// The unit that outputs at rest may have, by the size of their norm in the head: some 9.8, 1 or 1000. Of more than three
    /// columns any three that stand side by side may be those of an accelerometer; fewer have gravity where they are called accelerations.
    pub fn likely_unit(&self, columns: &[usize]) -> Option<Unit> {
        if columns.len() > 3 {
            let threes = || columns.windows(3).map(|three| self.likely_unit(three));
            let acceleration = threes().flatten().find(|u| u.is_acceleration());
            return acceleration.or_else(|| threes().all(|u| u.is_some()).then_some(Unit::Count));
        }
        let norm = self.norm(columns);
        let whole = |&i: &usize| self.head.get(i).is_some_and(|h| h.whole);
        let called = |is: fn(&str) -> bool| columns.iter().all(|&i| is(&self.name(i)));
        let gravity = self
            .gravity_unit(columns)
            .filter(|_| columns.len() == 3 || called(is_called_acceleration));
        match norm > 0.0 && columns.iter().all(whole) {
            // 1024 counts a g are as usual as mg.
            true if COUNTS_PER_G.contains(&norm) && gravity.is_some() => None,
            // Whole numbers may be mg; of 9.8 m/s² nothing would be left.
            true => gravity.filter(|_| norm > 100.0).or(Some(Unit::Count)),
            false if !columns.is_empty() && called(is_called_force) => Some(Unit::Newton),
            false => gravity,
        }
    }

    /// The unit in which the norm of some columns is gravity, whatever they are called.
    pub fn gravity_unit(&self, columns: &[usize]) -> Option<Unit> {
        let within = if columns.len() == 3 { 0.15 } else { 0.02 };
        Unit::of_gravity(self.norm(columns), within)
    }

    /// Root of the mean of the squared norm of some columns, over the head.
    pub fn norm(&self, columns: &[usize]) -> f64 {
        let squares = columns.iter().filter_map(|&i| self.head.get(i));
        squares.map(|h| h.mean_square).sum::<f64>().sqrt()
    }

    /// In place of an option: the unit is said in a campaign.
    pub const CAMPAIGN: &'static str = "unit";

    /// Refuses columns in counts, whose every mark may be one of thousands: 37,162 is read as 37.162 or as 37162, and counts are whole
    /// numbers unless somebody took means of them. Where the decimal mark was stated it is one.
    ///
    /// # Errors
    /// Such a column, with a number of it.
    pub fn refuse_grouped(&self, columns: &[usize], unit: Option<Unit>) -> Result<()> {
        let Some((name, number)) = self.grouped(columns, unit) else {
            return Ok(());
        };
        let whole = number.replace(['.', ','], "");
        Err(Error::new(
            ErrorKind::Column,
            format!("{number} in {} may be {whole} or a number with decimals", Unit::Count),
        )
        .column(&name)
        .with_hint("export it without marks of thousands; where they are decimals, state the mark in a campaign: `decimal = \"comma\"` or \"point\""))
    }

    /// Refuses a file of which some columns have decimal commas and the others points, where every column of numbers is wanted: those would
    /// be passed over as text.
    ///
    /// # Errors
    /// There are such columns.
    pub fn refuse_mixed_marks(&self) -> Result<()> {
        if self.other_mark.is_empty() {
            return Ok(());
        }
        let names: Vec<String> = self.other_mark.iter().map(|&i| self.name(i)).collect();
        let (theirs, ours) = match self.decimal {
            DecimalMark::Point => ("comma", "point"),
            DecimalMark::Comma => ("point", "comma"),
        };
        Err(Error::new(
            ErrorKind::Column,
            format!(
                "the decimal mark of {} is the {theirs}, that of the other columns the {ours}",
                names.join(", ")
            ),
        )
        .with_hint("export the file with one decimal mark, or name the columns that are wanted with --columns"))
    }

    /// Such a column: its name and a number of it.
    pub(crate) fn grouped(&self, columns: &[usize], unit: Option<Unit>) -> Option<(String, &str)> {
        if self.decimal_is_stated {
            return None;
        }
        columns.iter().find_map(|&index| {
            let counts = self.unit(index).or(unit) == Some(Unit::Count);
            let number = self.head.get(index)?.grouped.as_deref()?;
            counts.then(|| (self.name(index), number))
        })
    }

    /// The question for the unit of columns that have none in their headings, each with the option that says it; the likely one
    /// is named.
    pub fn ask_units(&self, columns: &[(usize, &str)]) -> Error {
        let mut groups: Vec<(&str, Vec<usize>)> = Vec::new();
        for &(index, option) in columns {
            match groups.iter_mut().find(|group| group.0 == option) {
                Some(group) => group.1.push(index),
                None => groups.push((option, vec![index])),
            }
        }
        let (mut what, mut options, mut likely) = (Vec::new(), Vec::new(), Vec::new());
        for (option, indices) in &groups {
            let names: Vec<String> = indices.iter().map(|&i| self.name(i)).collect();
            let size = |columns: &[usize]| crate::time_unit::short(self.norm(columns));
            // Three are the axes of one sensor, others need not be alike.
            let size = match indices.as_slice() {
                [_] => format!(
                    "its root mean square at the beginning of the file is about {}",
                    size(indices)
                ),
                [_, _, _] => format!("their norm is about {}", size(indices)),
                several => {
                    let each: Vec<String> = several.iter().map(|i| size(&[*i])).collect();
                    format!(
                        "their root mean squares at the beginning of the file are about {}",
                        each.join(", ")
                    )
                }
            };
            what.push(format!(
                "the unit of {} is not said; {size}",
                names.join(", ")
            ));
            let unit = self.likely_unit(indices);
            likely.extend(unit);
            let word = unit.map_or("UNIT", Unit::ascii);
            options.push(match *option {
                Self::CAMPAIGN => format!("unit = \"{word}\""),
                option => format!("{option} {word}"),
            });
        }
        let options = options.join(" ");
        let hint = match (likely.as_slice(), groups.as_slice()) {
            (all, _) if all.len() < groups.len() => format!(
                "say {options}: m/s2, g, mg, rad/s, count, V, N, 1 for a pure number, …; the heading may say it too, as x_m/s2 or x (g)"
            ),
            ([unit], [(Self::CAMPAIGN, _)]) => {
                format!("likely it is {unit}: write {options} into the campaign, or what it is")
            }
            ([unit], _) => format!(
                "likely it is {unit}: say {options} (`unit = \"{}\"` in a campaign), or what it is",
                unit.ascii()
            ),
            _ => format!("likely so: say {options}, or what they are"),
        };
        Error::new(ErrorKind::Column, what.join("; and ")).with_hint(hint)
    }

    /// The same where one option says the unit of all of them.
    pub fn ask_unit(&self, columns: &[usize]) -> Error {
        let columns: Vec<(usize, &str)> = columns.iter().map(|&i| (i, "--unit")).collect();
        self.ask_units(&columns)
    }

    /// Whether a column counts the rows, one by one.
    pub fn counts_rows(&self, index: usize) -> bool {
        let counted = |h: &ColumnHead| h.whole && h.rises && h.step == Some(1.0);
        self.unit(index).is_none() && self.head.get(index).is_some_and(counted)
    }

    /// The first column whose heading says that it is the time, counted from zero.
    pub fn time_column(&self) -> Option<usize> {
        crate::recording::time_column(self)
    }

    /// The columns, each pattern in the place of those that it stands for: `acc_*` is every column whose name begins so, in the order of
    /// the file; the times are none of them.
    ///
    /// # Errors
    /// A pattern that no column matches.
    pub fn matching(&self, columns: &[ColumnRef]) -> Result<Vec<ColumnRef>> {
        let mut all = Vec::new();
        for column in columns {
            let pattern = match column {
                ColumnRef::Name(name) if name.contains('*') && self.find(column).is_err() => name,
                _ => {
                    all.push(column.clone());
                    continue;
                }
            };
            let time = self.time_column();
            let matches = |i: &usize| {
                if Some(*i) == time {
                    return false;
                }
                let heading = self.header.as_ref().and_then(|h| h.get(*i));
                heading.is_some_and(|heading| {
                    is_like(pattern.trim(), heading.trim())
                        || is_like(pattern.trim(), split_heading(heading).0)
                })
            };
            let found: Vec<usize> = (0..self.columns).filter(matches).collect();
            if found.is_empty() {
                // With the list of the columns.
                self.find(column)?;
            }
            all.extend(found.into_iter().map(|i| ColumnRef::Index(i + 1)));
        }
        Ok(all)
    }

    /// Indices of columns and of those that patterns stand for.
    ///
    /// # Errors
    /// As [`Layout::find`] and [`Layout::matching`].
    pub fn find_all(&self, columns: &[ColumnRef]) -> Result<Vec<usize>> {
        let columns = self.matching(columns)?;
        columns.iter().map(|column| self.find(column)).collect()
    }

    /// Index from zero of a column given by name or number.
    ///
    /// A name may be the whole heading or the heading without its unit; case counts only where two names differ
    /// by case alone.
    ///
    /// # Errors
    /// No such column (the hint lists what there is), or a name that stands for two columns.
    pub fn find(&self, column: &ColumnRef) -> Result<usize> {
        let available = || {
            let names: Vec<_> = (0..self.columns.min(24))
                .map(|i| match &self.header {
                    Some(h) if i < h.len() => format!("\"{}\"", h[i].trim()),
                    _ => (i + 1).to_string(),
                })
                .collect();
            format!("the file has the columns {}", names.join(", "))
        };
        match column {
            ColumnRef::Index(i) if (1..=self.columns).contains(i) => Ok(i - 1),
            ColumnRef::Index(i) => Err(Error::new(
                ErrorKind::Column,
                format!(
                    "there is no column {i}; columns are counted from 1 to {}",
                    self.columns
                ),
            )
            .with_hint(available())),
            ColumnRef::Name(name) => {
                let Some(header) = &self.header else {
                    return Err(Error::new(
                        ErrorKind::Column,
                        "the file has no header, so columns have no names",
                    )
                    .column(name)
                    .with_hint(format!(
                        "give the number of the column (1 to {}) instead of its name",
                        self.columns
                    )));
                };
                let same = |exact: bool, whole: bool| -> Vec<usize> {
                    (0..header.len().min(self.columns))
                        .filter(|&i| {
                            let heading = if whole {
                                header[i].trim()
                            } else {
                                split_heading(&header[i]).0
                            };
                            if exact {
                                heading == name.trim()
                            } else {
                                heading.eq_ignore_ascii_case(name.trim())
                            }
                        })
                        .collect()
                };
                let found = [(true, true), (true, false), (false, true), (false, false)]
                    .into_iter()
                    .map(|(exact, whole)| same(exact, whole))
                    .find(|f| !f.is_empty())
                    .unwrap_or_default();
                match found[..] {
                    [one] => Ok(one),
                    [] => {
                        let error =
                            Error::new(ErrorKind::Column, "there is no such column").column(name);
                        let nearest =
                            crate::spelling::nearest(name, header.iter().map(|h| h.trim()));
                        Err(match nearest {
                            Some(near) => {
                                error.with_hint(format!("did you mean \"{near}\"? {}", available()))
                            }
                            None => error.with_hint(available()),
                        })
                    }
                    _ => Err(Error::new(
                        ErrorKind::Column,
                        format!("the header has this name {} times", found.len()),
                    )
                    .column(name)
                    .with_hint(format!(
                        "give the number of the column instead, one of {}",
                        found
                            .iter()
                            .map(|i| (i + 1).to_string())
                            .collect::<Vec<_>>()
                            .join(", ")
                    ))),
                }
            }
        }
    }
}

/// Refuses what can be read only once, where a file is to be opened twice.
pub(crate) fn regular(path: &Path) -> Result<()> {
    if crate::is_lent(path) {
        return Ok(());
    }
    let meta = std::fs::metadata(path).map_err(|e| Error::access(path, "open", e))?;
    if meta.is_file() || meta.is_dir() {
        return Ok(());
    }
    Err(Error::new(
        ErrorKind::Format,
        "is a pipe or a device, which can be read only once",
    )
    .at(path)
    .with_hint("write it to a file first, and name that"))
}

/// A column by its name or by its number counted from one.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum ColumnRef {
    /// Number, the first column being 1.
    Index(usize),
    /// Name as in the header, with or without the unit.
    Name(String),
}

impl ColumnRef {
    /// From a command-line word: a whole number is an index, anything else a name.
    pub fn from_word(word: &str) -> Self {
        word.parse()
            .map_or_else(|_| Self::Name(word.to_string()), Self::Index)
    }
}

impl std::str::FromStr for ColumnRef {
    type Err = std::convert::Infallible;

    /// As [`ColumnRef::from_word`], without the blanks around it.
    fn from_str(word: &str) -> Result<Self, Self::Err> {
        Ok(Self::from_word(word.trim()))
    }
}

impl From<usize> for ColumnRef {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

impl From<&str> for ColumnRef {
    /// As [`ColumnRef::from_word`], without the blanks around it: readers of command lines take this before `FromStr`.
    fn from(word: &str) -> Self {
        Self::from_word(word.trim())
    }
}

impl fmt::Display for ColumnRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Index(i) => write!(f, "column {i}"),
            Self::Name(name) => write!(f, "\"{name}\""),
        }
    }
}

/// Whole numbers that are gravity in counts as well as in mg: nearer to 2¹⁰ than to 1000, and not above by more than five per cent.
const COUNTS_PER_G: std::ops::Range<f64> = 1012.0..1075.0;

/// Whether a name is one that accelerations have: `acc…`, `a`, `ax`, `a_z`, `x`.
fn is_called_acceleration(name: &str) -> bool {
    let name = name.to_lowercase();
    let axis = name.strip_prefix('a').unwrap_or(&name);
    let axis = axis.trim_start_matches(['_', '.', ' ', '-']);
    name.contains("acc") || matches!(axis, "" | "x" | "y" | "z")
}

/// Whether a name is one that forces have.
fn is_called_force(name: &str) -> bool {
    let name = name.to_lowercase();
    ["force", "load", "hammer"]
        .iter()
        .any(|word| name.contains(word))
}

/// Whether a name is what a pattern says, in which `*` stands for anything; capitals count for nothing.
fn is_like(pattern: &str, name: &str) -> bool {
    let (pattern, name) = (pattern.to_lowercase(), name.to_lowercase());
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| name.strip_prefix(first)) else {
        return false;
    };
    let parts: Vec<&str> = parts.collect();
    let Some((last, middle)) = parts.split_last() else {
        return rest.is_empty();
    };
    for part in middle {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

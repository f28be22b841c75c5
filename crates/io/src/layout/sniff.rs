//! Finding the shape of a text from its head.

mod head_line;
mod one_comma;

use super::{DecimalMark, LARGEST_HEAD, Layout, LayoutOptions, Separator};
use crate::field::{Fields, other_mark, parse_number};
use crate::stamp::Stamp;
use crate::{Error, ErrorKind, Result, Unit};

/// One line of the head: number from one, offset of its first byte, text without its end.
struct Line<'a> {
    number: u64,
    offset: usize,
    text: &'a [u8],
}

/// Rows at the end of the head that vote on separator and column types.
const VOTERS: usize = 200;

pub(super) fn layout(head: &[u8], complete: bool, options: &LayoutOptions) -> Result<Layout> {
    refuse_binary(head)?;
    let comment = options
        .comment
        .clone()
        .unwrap_or_else(|| ["#", "%", "//"].map(String::from).to_vec());
    let lines = lines(head, complete)?;
    let skip = options
        .skip_lines
        .unwrap_or(0)
        .max(labview_preamble(&lines));
    let is_comment = |line: &Line| is_comment(line.text, &comment);
    let content: Vec<&Line> = lines
        .iter()
        .skip(skip)
        .filter(|l| !is_comment(l) && !l.text.trim_ascii().is_empty())
        .collect();
    if content.is_empty() {
        let what = if head.trim_ascii().is_empty() {
            "the file is empty"
        } else {
            "the file holds no rows of data"
        };
        return Err(Error::new(ErrorKind::Format, what).with_hint(
            "a recording is text with one row per sample; check that the export was finished",
        ));
    }
    let voters = &content[content.len().saturating_sub(VOTERS)..];
    let (mut separator, mut decimal) = separator_and_decimal(voters, options);
    if separator == Separator::Comma
        && options.separator.is_none()
        && options.decimal.is_none()
        && one_comma::is_decimal_mark(&lines, &content, &comment)?
    {
        // No field has a semicolon, so that each line is one.
        (separator, decimal) = (Separator::Semicolon, DecimalMark::Comma);
    }
    let columns = width(voters, separator);
    let numeric = columns_that(voters, separator, columns, |f| is_number(f, decimal), 0);
    let dated = columns_that(
        voters,
        separator,
        columns,
        |f| Stamp::parse(f, decimal).is_some_and(|s| s.dated),
        1,
    );

    let other = other_mark(decimal);
    let marked = columns_that(
        voters,
        separator,
        columns,
        |f| f.iter().any(|b| matches!(b, b',' | b'.')) && is_number(f, other),
        1,
    );
    let other_mark: Vec<usize> = (0..columns)
        .filter(|&i| marked[i] && !numeric[i] && !dated[i])
        .collect();

    // What LabVIEW marks as its header, or the user skips, is no longer among the content here.
    let mut preamble: Vec<&Line> = Vec::new();
    // From the top: what is not of full width and not all numbers is preamble, then come headings, then data.
    let mut headings: Vec<&Line> = Vec::new();
    let mut first_data = None;
    let shape = head_line::Shape::of(voters, separator, decimal, columns);
    for line in &content {
        let fields = split(line.text, separator);
        if headings.is_empty() && options.header.is_none() && shape.is_above_data(line.text) {
            preamble.push(line);
            continue;
        }
        // A row of numbers is no heading, and what stands above it is a title.
        if options.header.is_none() && shape.is_several_numbers(line.text) {
            preamble.append(&mut headings);
            preamble.push(line);
            continue;
        }
        let full = fits(&fields, columns);
        let numbers = fields.iter().filter(|f| is_number(f, decimal)).count();
        if !full {
            let filled = fields.iter().filter(|f| !f.is_empty()).count();
            // Numbers alone make a row of the wrong width, which the reader refuses by its line.
            if headings.is_empty() && (numbers == 0 || numbers < filled) {
                // A header may be wider than the rows (a trailing `Comment` column without entries).
                let wider = numbers == 0
                    && fields.len() > columns
                    && fields.len() <= columns + 2
                    && options.header != Some(false)
                    && columns > 1;
                let nameless = |f: &&[u8]| {
                    let name = f.trim_ascii();
                    name.is_empty() || name.eq_ignore_ascii_case(b"comment")
                };
                if wider && fields[columns..].iter().all(nameless) {
                    headings.push(line);
                } else {
                    preamble.push(line);
                }
                continue;
            }
            first_data = Some(*line);
            break;
        }
        let is_data = match options.header {
            Some(false) => true,
            Some(true) if headings.is_empty() => false,
            _ => fields
                .iter()
                .zip(&numeric)
                .any(|(f, &n)| n && is_number(f, decimal)),
        };
        if is_data {
            first_data = Some(*line);
            break;
        }
        headings.push(line);
    }
    let Some(first_data) = first_data else {
        let begin = headings
            .first()
            .map_or(&b""[..], |l| l.text)
            .trim_ascii_start();
        let what = match begin {
            [b'{' | b'[', ..] => "is a JSON file, not a recording",
            [b'<', ..] => "is a page or an XML file, not a recording",
            _ => "the file has a header but no row of numbers",
        };
        return Err(Error::new(ErrorKind::Format, what).with_hint(
            "a recording is text with one row per sample; check that the export was finished",
        ));
    };

    if headings.is_empty() && options.header != Some(false) {
        refuse_other_width(&content, first_data, separator, decimal, columns)?;
    }

    let names = |line: &Line| -> Vec<String> {
        split(line.text, separator)
            .iter()
            .map(|f| decode(f))
            .collect()
    };
    let units = |line: &Line| -> Option<Vec<Option<Unit>>> {
        let fields: Vec<String> = names(line)
            .iter()
            .map(|f| f.trim_matches(['(', ')', '[', ']']).to_string())
            .collect();
        let known: Vec<Option<Unit>> = fields.iter().map(|f| Unit::recognise(f)).collect();
        (known.iter().any(Option::is_some)
            && known
                .iter()
                .zip(&fields)
                .all(|(u, f)| u.is_some() || f.is_empty() || f == "-"))
        .then_some(known)
    };
    let mut unit_line = None;
    let mut header = None;
    if let Some(last) = headings.last() {
        header = Some(names(last));
        if headings.len() > 1
            && let Some(found) = units(last)
        {
            unit_line = Some(found);
            header = Some(names(headings[headings.len() - 2]));
        }
    } else if options.header != Some(false) {
        header = commented_header(&lines, first_data, &comment, separator, decimal, columns);
    }
    // Full rows above the one or two that were taken as headings are passed over as well.
    let taken = usize::from(!headings.is_empty()) + usize::from(unit_line.is_some());
    preamble.extend(&headings[..headings.len() - taken]);
    preamble.sort_by_key(|l| l.number);
    let rows = lines.iter().filter(|l| l.number >= first_data.number);
    let rows = rows.map(|l| l.text);
    let head = crate::column_head::of(rows, separator, decimal, &comment, columns);
    let passed_over = preamble
        .iter()
        .map(|l| (l.number, row_like(l.text.trim_ascii())))
        .collect();
    Ok(Layout {
        separator,
        decimal,
        decimal_is_stated: options.decimal.is_some(),
        comment,
        header,
        unit_line,
        passed_over,
        stream: None,
        columns,
        numeric,
        dated,
        other_mark,
        first_data_line: first_data.number,
        data_offset: first_data.offset as u64,
        head,
    })
}

/// Refuses a line of names just above the data that are not as many as the columns: nobody knows which name is missing or too
/// much. Of names between blanks one may be of two words.
fn refuse_other_width(
    content: &[&Line],
    first_data: &Line,
    separator: Separator,
    decimal: DecimalMark,
    columns: usize,
) -> Result<()> {
    let above = content.iter().rfind(|l| l.number < first_data.number);
    let Some(line) = above.filter(|_| separator != Separator::Whitespace && columns > 1) else {
        return Ok(());
    };
    let names = split(line.text, separator);
    let whole = |f: &&[u8]| {
        f.iter()
            .all(|b| b.is_ascii_digit() || matches!(b, b'-' | b'+'))
    };
    if separator == Separator::Comma
        && (names.len() + 2..=2 * names.len()).contains(&columns)
        && !names.iter().any(|f| is_number(f, decimal))
        && split(first_data.text, separator).iter().all(whole)
    {
        return Err(Error::new(
            ErrorKind::Row,
            format!(
                "{} headings stand above {columns} columns of whole numbers: the comma seems to be separator and decimal mark at once",
                names.len()
            ),
        )
        .line(line.number)
        .with_hint("save it with semicolons between the columns, or with decimal points; a line that holds no headings is left out by a # before it"));
    }
    let near = match names.len() {
        n if n > columns => n <= columns + 2 && names[columns..].iter().any(|f| !f.is_empty()),
        n => n + 1 == columns && n >= 3,
    };
    if !near || names.iter().any(|f| is_number(f, decimal)) {
        return Ok(());
    }
    Err(Error::new(
        ErrorKind::Row,
        format!(
            "{} headings stand above {columns} columns",
            names.len()
        ),
    )
    .line(line.number)
    .with_hint(
        "it is not known which heading belongs to which column: give every column one heading, or make the line a comment with #",
    ))
}

fn control(head: &[u8]) -> Option<usize> {
    head.iter()
        .position(|&b| b < 0x20 && !matches!(b, b'\t' | b'\n' | b'\r' | 0x0C | 0x1A))
}

/// Whether the head cannot be that of a text.
pub(super) fn is_binary(head: &[u8]) -> bool {
    control(head).is_some()
}

/// What people bring that is neither text nor a format that is read: its first bytes, what it is, and how it becomes one.
const OTHERS: &[(&[u8], &str, &str)] = &[
    (
        b"#ROSBAG V",
        "a bag of ROS 1",
        "convert it: `mcap convert FILE.bag FILE.mcap`, or `rosbags-convert`; MCAP is read as it is",
    ),
    (
        b"SQLite format 3",
        "a database in SQLite, as bags of ROS 2 are (.db3)",
        "convert a bag: `mcap convert FILE.db3 FILE.mcap`; MCAP is read as it is",
    ),
    (
        b"PK\x03\x04",
        "an archive (zip), as workbooks of a spreadsheet are (.xlsx)",
        "save the sheet as CSV, or unpack the archive",
    ),
    (
        b"%PDF",
        "a document (PDF)",
        "ask for the data that it was printed from",
    ),
];

fn refuse_binary(head: &[u8]) -> Result<()> {
    // Latin letters in UTF-16 have a zero in every other byte, with a mark at the beginning or without.
    let zeros = |first: usize| {
        let mut bytes = head.iter().skip(first).step_by(2).take(32);
        head.len() > 64 && bytes.all(|b| *b == 0)
    };
    let marked = head.starts_with(&[0xFF, 0xFE]) || head.starts_with(&[0xFE, 0xFF]);
    if marked || zeros(0) != zeros(1) {
        return Err(Error::new(
            ErrorKind::Format,
            "the text is coded as UTF-16 without a byte order mark",
        )
        .with_hint("save it again as UTF-8, or as UTF-16 with a mark"));
    }
    if let Some((_, what, remedy)) = OTHERS.iter().find(|o| head.starts_with(o.0)) {
        return Err(Error::new(
            ErrorKind::Format,
            format!("is {what}, which is not read here"),
        )
        .with_hint(*remedy));
    }
    match control(head) {
        Some(at) => Err(Error::new(
            ErrorKind::Format,
            format!(
                "is a binary file, not text (byte {at} is 0x{:02X})",
                head[at]
            ),
        )
        .with_hint("export the recording as delimited text (CSV)")),
        None => Ok(()),
    }
}

fn lines(head: &[u8], complete: bool) -> Result<Vec<Line<'_>>> {
    let mut lines = Vec::new();
    let mut offset = if head.starts_with(b"\xEF\xBB\xBF") {
        3
    } else {
        0
    };
    let mut number = 1;
    for end in memchr::memchr_iter(b'\n', head) {
        let text = &head[offset..end];
        lines.push(Line {
            number,
            offset,
            text: text.strip_suffix(b"\r").unwrap_or(text),
        });
        offset = end + 1;
        number += 1;
    }
    // The last piece of a longer file may be half a line.
    if complete && offset < head.len() {
        lines.push(Line {
            number,
            offset,
            text: &head[offset..],
        });
    }
    if lines.is_empty() && !complete {
        return Err(Error::new(
            ErrorKind::Format,
            format!("the first line is longer than {} MiB", LARGEST_HEAD >> 20),
        )
        .line(1)
        .with_hint("a recording is text with one row per sample and a line end after each"));
    }
    Ok(lines)
}

/// Lines up to and including the last `***End_of_Header***` of a LabVIEW measurement file.
fn labview_preamble(lines: &[Line]) -> usize {
    if !lines
        .first()
        .is_some_and(|l| l.text.starts_with(b"LabVIEW Measurement"))
    {
        return 0;
    }
    lines
        .iter()
        .rposition(|l| l.text.starts_with(b"***End_of_Header***"))
        .map_or(0, |i| i + 1)
}

pub(crate) fn is_comment(line: &[u8], prefixes: &[String]) -> bool {
    let text = line.trim_ascii_start();
    prefixes
        .iter()
        .any(|p| !p.is_empty() && text.starts_with(p.as_bytes()))
}

/// Digits alone, with a sign or without.
fn is_whole(field: &[u8]) -> bool {
    let signed = field.strip_prefix(b"-").or(field.strip_prefix(b"+"));
    let digits = signed.unwrap_or(field);
    !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
}

fn separator_and_decimal(voters: &[&Line], options: &LayoutOptions) -> (Separator, DecimalMark) {
    use DecimalMark as D;
    use Separator as S;
    // In the order of preference where the vote is even.
    let candidates = [
        (S::Comma, D::Point),
        (S::Semicolon, D::Point),
        (S::Tab, D::Point),
        (S::Pipe, D::Point),
        (S::Whitespace, D::Point),
        (S::Semicolon, D::Comma),
        (S::Tab, D::Comma),
        (S::Pipe, D::Comma),
        (S::Whitespace, D::Comma),
    ];
    let mut best: Option<(f64, (S, D))> = None;
    for (separator, decimal) in candidates {
        if options.separator.is_some_and(|s| s != separator)
            || options.decimal.is_some_and(|d| d != decimal)
        {
            continue;
        }
        let columns = width(voters, separator);
        let score: f64 = voters
            .iter()
            .map(|line| {
                let fields = split(line.text, separator);
                if !fits(&fields, columns) {
                    // As bad as a header of two words, which the true separator has to bear.
                    return -1.0;
                }
                fields
                    .iter()
                    .take(columns)
                    .map(|f| match (f.is_empty(), is_number(f, decimal)) {
                        (true, _) => 0.0,
                        (_, true) => 1.0,
                        // What was cut at a comma and holds another separator was cut at the wrong mark.
                        _ if separator == S::Comma
                            && columns > 1
                            && f.iter().any(|b| matches!(b, b';' | b'\t' | b'|')) =>
                        {
                            -1.0
                        }
                        _ => -0.5,
                    })
                    .sum::<f64>()
            })
            .sum();
        if best.is_none_or(|(b, _)| score > b) {
            best = Some((score, (separator, decimal)));
        }
    }
    // Given separator "comma" with given decimal comma is no candidate: numbers in quotes.
    best.map_or(
        (
            options.separator.unwrap_or(S::Comma),
            options.decimal.unwrap_or(D::Point),
        ),
        |(_, found)| found,
    )
}

/// The most frequent number of fields, one trailing empty field not counted; the larger when even.
fn width(voters: &[&Line], separator: Separator) -> usize {
    let mut counts = std::collections::BTreeMap::<usize, usize>::new();
    for line in voters {
        let fields = split(line.text, separator);
        let n = fields.len()
            - usize::from(fields.len() > 1 && fields.last().is_some_and(|f| f.is_empty()));
        *counts.entry(n).or_default() += 1;
    }
    // Where the last column is often empty the wider form is the true one.
    let full = voters
        .iter()
        .map(|l| split(l.text, separator))
        .filter(|f| f.last().is_some_and(|x| !x.is_empty()))
        .map(|f| f.len())
        .max();
    let modal = counts
        .into_iter()
        .max_by_key(|&(n, count)| (count, n))
        .map_or(1, |(n, _)| n);
    match full {
        Some(full) if full == modal + 1 => {
            let wide = voters
                .iter()
                .filter(|l| split(l.text, separator).len() == full)
                .count();
            if wide == voters.len() { full } else { modal }
        }
        _ => modal,
    }
}

fn fits(fields: &[&[u8]], columns: usize) -> bool {
    fields.len() == columns
        || (fields.len() == columns + 1 && fields.last().is_some_and(|f| f.is_empty()))
}

/// Columns whose fields are mostly of a kind; `least` is the lead that a vote needs.
fn columns_that(
    voters: &[&Line],
    separator: Separator,
    columns: usize,
    kind: impl Fn(&[u8]) -> bool,
    least: i64,
) -> Vec<bool> {
    let mut votes = vec![0_i64; columns];
    for line in voters {
        let fields = split(line.text, separator);
        if fits(&fields, columns) {
            for (vote, field) in votes.iter_mut().zip(&fields) {
                *vote += if kind(field) { 1 } else { -1 };
            }
        }
    }
    // For numbers a tie is a header with one row below it.
    votes.iter().map(|&v| v >= least).collect()
}

/// Column names in the comment line just above the data, as numerical programs write them.
fn commented_header(
    lines: &[Line],
    first: &Line,
    comment: &[String],
    separator: Separator,
    decimal: DecimalMark,
    columns: usize,
) -> Option<Vec<String>> {
    let above = lines.iter().rfind(|l| l.number < first.number)?;
    let text = above.text.trim_ascii_start();
    let prefix = comment.iter().find(|p| text.starts_with(p.as_bytes()))?;
    let fields = split(text[prefix.len()..].trim_ascii_start(), separator);
    (columns > 1
        && fields.len() == columns
        && fields
            .iter()
            .all(|f| !f.is_empty() && !is_number(f, decimal)))
    .then(|| fields.iter().map(|f| decode(f)).collect())
}

/// Fields of a line, trimmed, quotes kept.
pub(crate) fn split(line: &[u8], separator: Separator) -> Vec<&[u8]> {
    let mut fields = Fields::new(line, separator);
    std::iter::from_fn(|| fields.next_field()).collect()
}

/// Whether a field reads as a number; NaN and infinity count, so that they are found as bad data and not as text.
fn is_number(field: &[u8], decimal: DecimalMark) -> bool {
    parse_number(field, decimal).is_some()
}

/// Text of a field without quotes; Latin-1 where it is not UTF-8.
pub(crate) fn decode(field: &[u8]) -> String {
    let text = |bytes: &[u8]| match std::str::from_utf8(bytes) {
        Ok(text) => text.to_string(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    };
    match field
        .strip_prefix(b"\"")
        .and_then(|f| f.strip_suffix(b"\""))
    {
        Some(inside) => text(inside).replace("\"\"", "\""),
        None => text(field),
    }
}

/// A line that may be a damaged row, which begins like a number; of words nothing is kept, since heads of files name persons.
fn row_like(line: &[u8]) -> String {
    match line.first() {
        Some(b'0'..=b'9' | b'-' | b'+' | b'.' | b',' | b';') => crate::field::shown(line),
        _ => String::new(),
    }
}

//! Unisens: a description (`unisens.xml`) of files of samples that lie beside it.
//!
//! Numbers are those of the file less `baseline`, times `lsbValue`, in text as in binary, as the reference implementation in Java reads them.

mod description;
mod joined;

use crate::bytes::Order;
use crate::names::shown;
use crate::raw::Kind;
use crate::recognise::Joint;
use crate::scaling::Scaling;
use crate::stream::{Beside, Clock, Column, Contents, Remark, SeekRead, Source, Stream};
use crate::text::{self, Lines};
use crate::{Error, Result};
use description::{Description, Entry, Form};
use joined::Joined;
use std::io::{Read, SeekFrom};

/// A longer description is none.
const LONGEST_DESCRIPTION: u64 = 16 << 20;

/// A file beside the description, by its place among the joined ones.
struct Part {
    start: u64,
    size: u64,
}

/// The streams of the files that a description names, and those files behind it as one.
pub(crate) fn read(mut file: Box<dyn SeekRead>, size: u64, beside: &mut Beside) -> Result<Joint> {
    if size > LONGEST_DESCRIPTION {
        return Err(Error::new(
            "is a description of a Unisens recording of more than 16 MiB, which is too large",
        ));
    }
    let mut text = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    (&mut file).take(size).read_to_end(&mut text)?;
    let description = Description::of(&text)?;
    let mut remarks = description.remarks;
    let mut streams = Vec::new();
    let mut missing = Vec::new();
    let described = description.entries.len();
    let mut joined = Joined::new(file, size);
    for entry in description.entries {
        let Some(other) = beside(&entry.file)? else {
            missing.push(format!("\"{}\"", entry.file));
            continue;
        };
        let (start, size) = joined.push(other)?;
        let part = Part { start, size };
        match stream(&entry, &part, &mut joined, &mut remarks) {
            Ok(mut stream) => {
                stream.origin_ns = description.start_ns;
                streams.push(stream);
            }
            Err(e) => remarks.push(Remark::damaged(format!("\"{}\": {e}", entry.file))),
        }
    }
    if !missing.is_empty() {
        let files = missing.join(", ");
        if missing.len() == described {
            return Err(Error::new(format!(
                "describes {files}, of which nothing lies beside it"
            ))
            .with_hint("keep unisens.xml in the folder of its files, and name it there"));
        }
        let gone = format!("{files}: described, and not beside the description");
        remarks.push(Remark::passed_over(gone));
    }
    Ok((Contents { streams, remarks }, Box::new(joined)))
}

fn stream(
    entry: &Entry,
    part: &Part,
    joined: &mut Joined,
    remarks: &mut Vec<Remark>,
) -> Result<Stream> {
    let columns = match entry.form {
        Form::Binary { kind, order } => binary(entry, part, kind, order, remarks),
        Form::Text { separator, decimal } => table(entry, part, joined, (separator, decimal))?,
    };
    let rows = columns.iter().map(Source::rows).min().unwrap_or(0);
    let clock = match entry.stamped {
        true => Clock::Times,
        false => Clock::Rate {
            hz: entry.rate_hz,
            start_s: 0.0,
        },
    };
    let mut stream = Stream::new(entry.file.clone(), clock, rows);
    let mut columns = columns.into_iter();
    let times = entry.stamped.then(|| columns.next()).flatten();
    for (name, column) in entry.channels.iter().zip(columns) {
        let scaling = match (entry.slope, entry.baseline) {
            (1.0, 0.0) => Scaling::none(),
            (slope, baseline) => Scaling::linear(slope, -baseline * slope),
        };
        stream.push(
            name.clone(),
            entry.unit.clone(),
            Column::scaled(column, scaling),
        );
    }
    if let Some(times) = times {
        stream.push_times(times);
    }
    Ok(stream)
}

/// Channels side by side.
fn binary(
    entry: &Entry,
    part: &Part,
    kind: Kind,
    order: Order,
    remarks: &mut Vec<Remark>,
) -> Vec<Source> {
    let stride = kind.size() * entry.channels.len() as u64;
    let rows = part.size / stride;
    if !part.size.is_multiple_of(stride) {
        remarks.push(Remark::cut(format!(
            "\"{}\" ends within sample {}",
            entry.file,
            rows + 1
        )));
    }
    let each = 0..entry.channels.len() as u64;
    each.map(|c| {
        let at = part.start + c * kind.size();
        Source::Raw(crate::raw::Raw::at(kind, order, at, stride, rows))
    })
    .collect()
}

/// The columns of a text; of one with stamps the times first.
fn table(
    entry: &Entry,
    part: &Part,
    joined: &mut Joined,
    (separator, decimal): (u8, u8),
) -> Result<Vec<Source>> {
    let width = entry.channels.len() + usize::from(entry.stamped);
    let mut columns = vec![Vec::new(); width];
    let mut lines = Lines::from(joined, part.start)?;
    let mut line_number = 0;
    while lines.place() < part.start + part.size {
        // The next file begins right behind this one.
        let left = part.start + part.size - lines.place();
        let Some(line) = lines.next_line()? else {
            break;
        };
        let line = &line[..line.len().min(left as usize)];
        line_number += 1;
        if line.trim_ascii().is_empty() {
            continue;
        }
        let mut fields = line.split(|b| *b == separator);
        for (c, column) in columns.iter_mut().enumerate() {
            let field = fields.next().unwrap_or_default();
            let number = match decimal {
                b'.' => text::number(field),
                _ => text::number(
                    &field
                        .iter()
                        .map(|b| if *b == decimal { b'.' } else { *b })
                        .collect::<Vec<u8>>(),
                ),
            };
            let number = number.ok_or_else(|| {
                Error::new(format!(
                    "line {line_number}: \"{}\" in column {} is no number",
                    shown(&String::from_utf8_lossy(field)),
                    c + 1
                ))
            })?;
            column.push(number);
        }
        // A separator may stand at the end of a line.
        if fields.any(|f| !f.trim_ascii().is_empty()) {
            return Err(Error::new(format!(
                "line {line_number} has more than the {width} columns that the description names"
            )));
        }
    }
    if entry.stamped {
        for stamp in &mut columns[0] {
            *stamp /= entry.rate_hz;
        }
    }
    Ok(columns.into_iter().map(Source::held).collect())
}

#[cfg(test)]
mod tests;

//! LVM, the text files of LabVIEW: a header, then segments with their own clocks, which differ from column to column.

use crate::bytes::text;
use crate::stream::{Clock, Column, Contents, Remark, SeekRead, Source, Stream};
use crate::text::Lines;
use crate::{Error, Result};
use std::collections::HashMap;

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let mut lines = Lines::from(file, 0)?;
    let mut form = Form::default();
    while let Some(line) = lines.next_line()? {
        if line.starts_with(b"***End_of_Header***") {
            break;
        }
        form.line(line);
    }
    let mut contents = Contents {
        streams: Vec::new(),
        remarks: Vec::new(),
    };
    let mut number = 0;
    while let Some(segment) = Segment::head(&mut lines, &form)? {
        number += 1;
        segment.read(&mut lines, &form, (number, size), &mut contents)?;
    }
    if number > 1 {
        // Streams of one segment alone are told by their step.
        for stream in contents
            .streams
            .iter_mut()
            .filter(|s| !s.name.starts_with("segment"))
        {
            stream.name = format!("segment 1, {}", stream.name);
        }
    }
    Ok(contents)
}

/// What stands in the header of the file.
#[derive(Clone, Copy, Debug)]
struct Form {
    separator: u8,
    comma: bool,
    times: Times,
}

/// Columns of times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Times {
    No,
    One,
    Each,
}

impl Default for Form {
    fn default() -> Self {
        Self {
            separator: b'\t',
            comma: false,
            times: Times::One,
        }
    }
}

impl Form {
    fn line(&mut self, line: &[u8]) {
        let is = |key: &[u8]| {
            let rest = line.strip_prefix(key)?;
            let (first, rest) = rest.split_first()?;
            matches!(first, b'\t' | b',' | b';').then(|| rest.trim_ascii().to_vec())
        };
        if let Some(word) = is(b"Separator") {
            self.separator = match &word[..] {
                w if w.starts_with(b"Comma") => b',',
                w if w.starts_with(b"Semicolon") => b';',
                _ => b'\t',
            };
        }
        if line.starts_with(b"Decimal_Separator") {
            self.comma =
                line.get(18) == Some(&b',') && is(b"Decimal_Separator").is_none_or(|w| w != b".");
        }
        if let Some(word) = is(b"X_Columns") {
            self.times = match &word[..] {
                w if w.starts_with(b"No") => Times::No,
                w if w.starts_with(b"Multi") => Times::Each,
                _ => Times::One,
            };
        }
    }

    fn number(&self, field: &[u8]) -> Option<f64> {
        let field = std::str::from_utf8(field.trim_ascii()).ok()?;
        match self.comma {
            true => field.replace(',', ".").parse().ok(),
            false => field.parse().ok(),
        }
    }

    fn fields<'a>(&self, line: &'a [u8]) -> impl Iterator<Item = &'a [u8]> + Clone {
        let separator = self.separator;
        line.split(move |b| *b == separator)
    }
}

/// What stands above the numbers of a segment.
#[derive(Debug, Default)]
struct Segment {
    channels: usize,
    samples: Vec<u64>,
    units: Vec<String>,
    dimensions: Vec<String>,
    starts: Vec<f64>,
    steps: Vec<f64>,
    /// A row that was read already, where the segment has no header.
    headings: Vec<String>,
}

/// Channels of a segment at most: fields of a line.
const MOST_CHANNELS: usize = 1 << 16;
/// Fields that lines may leave away, beside one for each byte of the file.
const MOST_LEFT_AWAY: u64 = 1 << 20;

impl Segment {
    fn head(lines: &mut Lines<'_>, form: &Form) -> Result<Option<Self>> {
        let mut segment = Self::default();
        let mut any = false;
        while let Some(line) = lines.next_line()? {
            if line.starts_with(b"***End_of_Header***") {
                let headings = lines.next_line()?.unwrap_or_default();
                segment.headings = form
                    .fields(headings)
                    .map(|f| text(f.trim_ascii()))
                    .collect();
                segment.channels = segment.channels.min(MOST_CHANNELS);
                return Ok(any.then_some(segment));
            }
            let mut fields = form.fields(line);
            let key = fields.next().unwrap_or_default().trim_ascii();
            let words = fields.clone().map(|f| text(f.trim_ascii()));
            let numbers = fields.map(|f| form.number(f));
            any |= !key.is_empty();
            match key {
                b"Channels" => {
                    let count = numbers.flatten().next();
                    segment.channels = count.map_or(0, |n| n as usize);
                }
                b"Samples" => segment.samples = numbers.flatten().map(|n| n as u64).collect(),
                b"Y_Unit_Label" => segment.units = words.collect(),
                b"X_Dimension" => segment.dimensions = words.collect(),
                b"X0" => segment.starts = numbers.flatten().collect(),
                b"Delta_X" => segment.steps = numbers.flatten().collect(),
                _ => {}
            }
        }
        Ok(None)
    }

    /// Column of the line that holds the numbers of a channel, and that of its times.
    fn places(&self, form: &Form, channel: usize) -> (usize, Option<usize>) {
        match form.times {
            Times::Each => (2 * channel + 1, Some(2 * channel)),
            Times::One => (channel + 1, Some(0)),
            Times::No => (channel + 1, None),
        }
    }

    fn read(
        self,
        lines: &mut Lines<'_>,
        form: &Form,
        (number, size): (usize, u64),
        contents: &mut Contents,
    ) -> Result<()> {
        let (columns, open_line) = self.columns(lines, form, size)?;
        if let Some(at) = open_line {
            contents.remarks.push(Remark::cut(format!(
                "the line at byte {at} has no end, and is left out"
            )));
        }
        // Programs that know no unit of a signal may put that of the time axis in its place.
        let of_axis = !self.units.is_empty()
            && self.units.iter().all(|u| u.is_empty() || u == "s")
            && self.units.iter().any(|u| u == "s");
        if of_axis {
            contents.remarks.push(Remark::passed_over(
                "the units of all channels, \"s\", which is that of the time axis: the units of the signals are not said",
            ));
        }
        let mut groups: HashMap<(u64, u64, u64), usize> = HashMap::new();
        let mut cut = Vec::new();
        for channel in 0..self.channels {
            let (place, times) = self.places(form, channel);
            let Some(numbers) = columns.get(place) else {
                continue;
            };
            let last = numbers.iter().rposition(|v| !v.is_nan());
            let numbers = &numbers[..last.map_or(0, |i| i + 1)];
            let rows = numbers.len() as u64;
            let name = self.headings.get(place).cloned().unwrap_or_default();
            let stated = self.samples.get(channel).copied().unwrap_or(0);
            if rows < stated {
                cut.push(format!("{name} holds {rows} of {stated} samples"));
            }
            if rows == 0 {
                continue;
            }
            let step = self
                .steps
                .get(channel)
                .copied()
                .filter(|s| s.is_finite() && *s > 0.0);
            let start = self.starts.get(channel).copied().unwrap_or(0.0);
            let time = self
                .dimensions
                .get(channel)
                .is_none_or(|d| d == "Time" || d.is_empty());
            let stamps = times
                .and_then(|t| columns.get(t))
                .map(|t| &t[..numbers.len()]);
            let stamps = stamps.filter(|t| t.iter().all(|v| v.is_finite()));
            let even = step.filter(|step| stamps.is_none_or(|t| even(t, start, *step)));
            let clock = match (even, stamps) {
                _ if !time => Clock::Unsaid,
                (Some(step), _) => Clock::Rate {
                    hz: 1.0 / step,
                    start_s: start,
                },
                (None, Some(_)) => Clock::Times,
                (None, None) => Clock::Unsaid,
            };
            let unit = self.units.get(channel).cloned();
            let unit = unit.filter(|u| !u.is_empty() && !of_axis);
            let column = Column::of(Source::held(numbers.to_vec()));
            let key = match clock {
                Clock::Rate { hz, start_s } => (hz.to_bits(), start_s.to_bits(), rows),
                // Those of one column of times are together.
                _ => (0, times.unwrap_or(0) as u64, rows),
            };
            if let Some(&known) = groups.get(&key) {
                let stream = &mut contents.streams[known];
                // Times stay last.
                let at = stream.columns.len() - usize::from(clock == Clock::Times);
                stream.insert(at, name, unit, column);
                continue;
            }
            groups.insert(key, contents.streams.len());
            let of_stream = match (number, clock, step) {
                (1, Clock::Rate { .. }, Some(step)) => format!("every {step} s"),
                (_, Clock::Rate { .. }, Some(step)) => format!("segment {number}, every {step} s"),
                _ => format!("segment {number}"),
            };
            let mut stream = Stream::new(of_stream, clock, rows);
            stream.push(name, unit, column);
            if let (Clock::Times, Some(stamps)) = (clock, stamps) {
                stream.push_times(Source::held(stamps.to_vec()));
            }
            contents.streams.push(stream);
        }
        if !cut.is_empty() {
            contents.remarks.push(Remark::cut(cut.join(", ")));
        }
        Ok(())
    }

    /// The numbers up to the next segment, column by column, not a number where a field is empty; and where a last line without
    /// an end begins, which may be cut within a number.
    fn columns(
        &self,
        lines: &mut Lines<'_>,
        form: &Form,
        size: u64,
    ) -> Result<(Vec<Vec<f64>>, Option<u64>)> {
        let width = match form.times {
            Times::Each => 2 * self.channels,
            _ => self.channels + 1,
        };
        // No more columns than a line has fields.
        let width = width.min(self.headings.len().max(1));
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); width];
        // Fields that lines leave away at their ends, without so much as a separator.
        let mut left_away = 0;
        let mut open_line = None;
        loop {
            let place = lines.place();
            let Some(line) = lines.next_line()? else {
                break;
            };
            if line.trim_ascii().is_empty() {
                continue;
            }
            let line = line.to_vec();
            if lines.is_open {
                open_line = Some(place);
                break;
            }
            let line = &line[..];
            let key = form.fields(line).next().unwrap_or_default().trim_ascii();
            // The header of the next segment.
            if key.first().is_some_and(u8::is_ascii_alphabetic) && form.number(key).is_none() {
                lines.go_to(place)?;
                break;
            }
            let mut fields = form.fields(line);
            for column in &mut columns {
                let field = fields.next();
                left_away += u64::from(field.is_none());
                let field = field.unwrap_or_default();
                let value = form.number(field);
                if value.is_none() && !field.trim_ascii().is_empty() {
                    return Err(Error::new(format!(
                        "\"{}\" in the line at byte {place} is not a number",
                        text(field).chars().take(40).collect::<String>()
                    ))
                    .with_hint("correct the field, or cut the line out"));
                }
                column.push(value.unwrap_or(f64::NAN));
            }
            if left_away > size.saturating_add(MOST_LEFT_AWAY) {
                return Err(Error::new(format!(
                    "the lines up to byte {place} have far fewer fields than the {width} columns that are announced"
                ))
                .with_hint("correct X_Columns and Channels of the header"));
            }
        }
        Ok((columns, open_line))
    }
}

/// Whether times follow start and step, within the six decimals in which LabVIEW writes them.
fn even(times: &[f64], start: f64, step: f64) -> bool {
    let mut places = times.iter().enumerate();
    places.all(|(i, t)| (t - start - i as f64 * step).abs() <= 0.6e-6 + 1e-9 * t.abs())
}

#[cfg(test)]
mod tests;

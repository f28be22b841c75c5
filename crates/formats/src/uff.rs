//! Universal files of modal analysis: data set 58, functions, as text and as bytes (58b).
//!
//! **Source** `[UFF58]`.

use crate::bytes::{Order, text};
use crate::raw::{Kind, Raw};
use crate::stream::{Clock, Column, Contents, Line, Remark, SeekRead, Source, Stream};
use crate::text::{Lines, columns, number};
use crate::{Error, Result};
use std::collections::{BTreeMap, HashMap};

/// A line of −1 in columns 5 and 6, and the number of a data set in the next.
pub(crate) fn is_universal(head: &[u8]) -> bool {
    let mut lines = head.split(|b| *b == b'\n').map(<[u8]>::trim_ascii_end);
    let number = |line: &[u8]| {
        let word = line.trim_ascii_start();
        let digits = word.iter().take_while(|b| b.is_ascii_digit()).count();
        (1..=4).contains(&digits) && line.len() > word.len()
    };
    lines.next() == Some(b"    -1") && lines.next().is_some_and(number)
}

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let mut found = Found::default();
    let mut lines = Lines::from(file, 0)?;
    while let Some(line) = lines.next_line()? {
        if line.trim_ascii() != b"-1" {
            continue;
        }
        let at = lines.place();
        let Some(head) = lines.next_line()? else {
            break;
        };
        let head = head.to_vec();
        let digits = head.trim_ascii_start();
        let count = digits.iter().take_while(|b| b.is_ascii_digit()).count();
        let kind = number(&digits[..count]).map_or(0, |n| n as u32);
        if kind == 58 {
            if !set(&mut lines, &head, at, size, &mut found)? {
                break;
            }
            continue;
        }
        *found.others.entry(kind).or_default() += 1;
        while let Some(line) = lines.next_line()? {
            if line.trim_ascii() == b"-1" {
                break;
            }
        }
    }
    if !found.others.is_empty() {
        let kinds = found.others.iter().map(|(kind, n)| match n {
            1 => kind.to_string(),
            n => format!("{kind} ({n} times)"),
        });
        let kinds: Vec<String> = kinds.collect();
        found.remarks.push(Remark::passed_over(format!(
            "data sets other than 58: {}",
            kinds.join(", ")
        )));
    }
    Ok(Contents {
        streams: found.streams,
        remarks: found.remarks,
    })
}

#[derive(Default)]
struct Found {
    streams: Vec<Stream>,
    /// Streams of even abscissas by kind, beginning, step and number.
    even: HashMap<(u32, u64, u64, u64), usize>,
    others: BTreeMap<u32, u32>,
    remarks: Vec<Remark>,
}

/// What the head of a data set says.
struct Head {
    name: String,
    complex: bool,
    double: bool,
    points: u64,
    even: bool,
    start: f64,
    step: f64,
    abscissa: u32,
    abscissa_name: String,
    abscissa_unit: Option<String>,
    unit: Option<String>,
}

impl Head {
    /// Of the lines 1 to 11 of the data set, the description of which is not passed on.
    fn of(lines: &[Vec<u8>]) -> Option<Self> {
        let [
            _,
            _,
            _,
            _,
            _,
            degrees,
            form,
            abscissa,
            ordinate,
            denominator,
            ..,
        ] = lines
        else {
            return None;
        };
        let whole = |line: &[u8], from, to| number(columns(line, from, to)).map(|n| n as u64);
        let label = |line: &[u8], from, to| {
            let label = text(columns(line, from, to));
            (!label.is_empty() && label != "NONE").then_some(label)
        };
        let function = match whole(degrees, 0, 5)? {
            1 => "response",
            2 => "auto spectrum",
            3 => "cross spectrum",
            4 => "frequency response",
            6 => "coherence",
            9 => "power spectral density",
            _ => "function",
        };
        let place = |from: usize| {
            let entity = label(degrees, from, from + 10);
            let node = whole(degrees, from + 10, from + 20).unwrap_or(0);
            let direction = number(columns(degrees, from + 20, from + 24)).unwrap_or(0.0);
            let axis = match direction.abs() as u32 {
                1 => "X",
                2 => "Y",
                3 => "Z",
                4 => "RX",
                5 => "RY",
                6 => "RZ",
                _ => "",
            };
            let sign = if direction < 0.0 { "-" } else { "" };
            let entity = entity.map_or(String::new(), |e| format!("{e} "));
            match (node, entity.is_empty()) {
                (0, true) => String::new(),
                (0, false) => format!(" {}{sign}{axis}", entity.trim_end().to_owned() + " ")
                    .trim_end()
                    .to_owned(),
                _ => format!(" {entity}{node}{sign}{axis}"),
            }
        };
        let mut name = format!("{function}{}", place(31));
        if matches!(
            function,
            "frequency response" | "cross spectrum" | "coherence"
        ) {
            let reference = place(56);
            if !reference.is_empty() {
                name = format!("{name} over{reference}");
            }
        }
        let (complex, double) = match whole(form, 0, 10)? {
            2 => (false, false),
            4 => (false, true),
            5 => (true, false),
            6 => (true, true),
            _ => return None,
        };
        let unit = match (label(ordinate, 47, 67), label(denominator, 47, 67)) {
            (Some(unit), Some(below)) => Some(format!("{unit}/{below}")),
            (unit, _) => unit,
        };
        Some(Self {
            name,
            complex,
            double,
            points: whole(form, 10, 20)?,
            even: whole(form, 20, 30)? != 0,
            start: number(columns(form, 30, 43)).unwrap_or(0.0),
            step: number(columns(form, 43, 56)).unwrap_or(0.0),
            abscissa: whole(abscissa, 0, 10).unwrap_or(0) as u32,
            abscissa_name: label(abscissa, 26, 46).unwrap_or_else(|| "abscissa".to_owned()),
            abscissa_unit: label(abscissa, 47, 67),
            unit,
        })
    }

    /// Numbers of a point.
    fn width(&self) -> u64 {
        1 + u64::from(self.complex) + u64::from(!self.even)
    }

    /// Bytes of a number of a binary data set.
    fn value(&self) -> u64 {
        if self.double { 8 } else { 4 }
    }

    /// Whether the abscissa is a time in seconds.
    fn is_time(&self) -> bool {
        let unit = self.abscissa_unit.as_deref();
        match self.abscissa {
            17 => unit.is_none_or(is_second),
            0 | 1 => unit.is_some_and(is_second),
            _ => false,
        }
    }
}

fn is_second(unit: &str) -> bool {
    ["s", "sec", "second", "seconds"].contains(&unit.to_lowercase().as_str())
}

/// Takes in one data set; `false` where the file ends within it.
fn set(lines: &mut Lines<'_>, first: &[u8], at: u64, size: u64, found: &mut Found) -> Result<bool> {
    let binary = columns(first, 6, 7).eq_ignore_ascii_case(b"b");
    let mut head_lines = Vec::new();
    for _ in 0..11 {
        let Some(line) = lines.next_line()? else {
            found.remarks.push(Remark::cut(format!(
                "the file ends inside the head of the data set at byte {at}"
            )));
            return Ok(false);
        };
        head_lines.push(line.to_vec());
    }
    let Some(mut head) = Head::of(&head_lines) else {
        let what = format!("the head of the data set at byte {at} is not that of a function");
        found.remarks.push(Remark::damaged(what));
        return Ok(true);
    };
    if binary
        && !head.even
        && claimed(first)
            == head
                .points
                .saturating_mul((head.width() - 1) * head.value())
        && head.points > 0
    {
        let what =
            format!("the data set at byte {at} says that its abscissa is uneven, and holds none");
        found.remarks.push(Remark::damaged(what));
        head.even = true;
        head.step = 0.0;
    }
    let (mut sources, whole) = match binary {
        true => bytes(lines, first, &head, size)?,
        false => numbers(lines, &head)?,
    };
    let rows = sources.iter().map(Source::rows).min().unwrap_or(0);
    if rows < head.points {
        found.remarks.push(Remark::cut(format!(
            "the data set at byte {at} holds {rows} of {} points",
            head.points
        )));
    }
    if rows == 0 {
        return Ok(whole);
    }
    let abscissa = (!head.even).then(|| sources.remove(0));
    found.put(head, abscissa, sources, rows);
    Ok(whole)
}

impl Found {
    fn put(&mut self, head: Head, abscissa: Option<Source>, ordinates: Vec<Source>, rows: u64) {
        let parts = if head.complex {
            &[" real", " imaginary"][..]
        } else {
            &[""]
        };
        let time = head.is_time();
        let step = head.step.is_finite() && head.step > 0.0 && head.start.is_finite();
        let clock = match (head.even, time) {
            (true, true) if step => Clock::Rate {
                hz: 1.0 / head.step,
                start_s: head.start,
            },
            (false, true) => Clock::Times,
            _ => Clock::Unsaid,
        };
        if head.even && time && !step {
            self.remarks.push(Remark::damaged(format!(
                "the time step of \"{}\", {} s, is not positive: the channel is read without times",
                head.name, head.step
            )));
        }
        let name = match (head.even, time) {
            (true, true) => format!("every {} s", head.step),
            (true, false) => format!("{} every {}", head.abscissa_name, head.step),
            (false, _) => head.name.clone(),
        };
        let key = (
            head.abscissa,
            head.start.to_bits(),
            head.step.to_bits(),
            rows,
        );
        let known = self.even.get(&key).filter(|_| head.even).copied();
        let number = known.unwrap_or_else(|| {
            self.streams.push(Stream::new(name, clock, rows));
            self.streams.len() - 1
        });
        if head.even {
            self.even.insert(key, number);
        }
        let stream = &mut self.streams[number];
        for (part, ordinate) in parts.iter().zip(ordinates) {
            let name = format!("{}{part}", head.name);
            stream.push(name, head.unit.clone(), Column::of(ordinate));
        }
        if head.even && !time && step && known.is_none() {
            let line = Line {
                count: rows,
                first: head.start,
                step: head.step,
            };
            let abscissa = Column::of(Source::lines(vec![line]));
            stream.push(
                head.abscissa_name.clone(),
                head.abscissa_unit.clone(),
                abscissa,
            );
        }
        match abscissa {
            Some(abscissa) if time => stream.push_times(abscissa),
            Some(abscissa) => {
                let name = head.abscissa_name;
                stream.push(name, head.abscissa_unit, Column::of(abscissa));
            }
            None => {}
        }
    }
}

/// Bytes of numbers that the first line of a binary data set says.
fn claimed(first: &[u8]) -> u64 {
    number(columns(first, 31, 43)).map_or(0, |n| n as u64)
}

/// The numbers of a binary data set, and whether it is whole.
fn bytes(
    lines: &mut Lines<'_>,
    first: &[u8],
    head: &Head,
    size: u64,
) -> Result<(Vec<Source>, bool)> {
    let order = match columns(first, 7, 13) {
        b"2" => Order::Big,
        _ => Order::Little,
    };
    if !matches!(columns(first, 13, 19), b"2" | b"") {
        return Err(Error::new(
            "the data set 58b holds floats of DEC VMS or of IBM, which are not read here",
        )
        .with_hint("write it with IEEE floats, or as text (58)"));
    }
    let at = lines.place();
    let there = size.saturating_sub(at);
    let value = head.value();
    let kind = match head.double {
        true => Kind::F64,
        false => Kind::F32,
    };
    // Some programs write the abscissa in single precision before doubles.
    let short = !head.even
        && head.double
        && claimed(first) == head.points.saturating_mul(head.width() * 8 - 4)
        && head.points > 0;
    let frame = head.width() * value - if short { 4 } else { 0 };
    let rows = head.points.min(there / frame);
    let mut sources = Vec::new();
    let mut offset = 0;
    for number in 0..head.width() {
        let kind = if short && number == 0 {
            Kind::F32
        } else {
            kind
        };
        sources.push(Source::Raw(Raw::at(kind, order, at + offset, frame, rows)));
        offset += kind.size();
    }
    let length = head.points.saturating_mul(frame);
    if length > there {
        return Ok((sources, false));
    }
    // What stands behind the numbers up to the end of the set is a line end or nothing.
    let end = at + length.max(claimed(first).min(there));
    lines.go_to(end)?;
    for _ in 0..3 {
        if lines.next_line()?.is_none_or(|l| l.trim_ascii() == b"-1") {
            break;
        }
    }
    Ok((sources, true))
}

/// The numbers of a data set of text, and whether the end of the file is not yet reached.
fn numbers(lines: &mut Lines<'_>, head: &Head) -> Result<(Vec<Source>, bool)> {
    let width = head.width() as usize;
    // Widths of the fields of a line, again and again.
    let fields: &[usize] = match (head.double, head.even) {
        (false, _) => &[13],
        (true, true) => &[20],
        (true, false) if head.complex => &[13, 20, 20],
        (true, false) => &[13, 20],
    };
    let wanted = head.points.saturating_mul(width as u64);
    let mut columns = vec![Vec::new(); width];
    let mut taken = 0;
    let mut values = Vec::new();
    while taken < wanted {
        let Some(line) = lines.next_line()? else {
            return Ok((held(columns), false));
        };
        if line.trim_ascii() == b"-1" {
            return Ok((held(columns), true));
        }
        let line = line.to_vec();
        if lines.is_open {
            return Ok((held(columns), false));
        }
        let line = &line[..];
        if !fixed(line, fields, &mut values) && !spaced(line, &mut values) {
            let what = format!("a line before byte {} holds no numbers", lines.place());
            return Err(Error::new(what).with_hint("the universal file is damaged there"));
        }
        for value in &values {
            if taken < wanted {
                columns[(taken % width as u64) as usize].push(*value);
                taken += 1;
            }
        }
    }
    // The end mark of the set, which the next one may lack.
    let place = lines.place();
    if lines.next_line()?.is_some_and(|l| l.trim_ascii() != b"-1") {
        lines.go_to(place)?;
    }
    Ok((held(columns), true))
}

fn held(mut columns: Vec<Vec<f64>>) -> Vec<Source> {
    let rows = columns.iter().map(Vec::len).min().unwrap_or(0);
    columns.iter_mut().for_each(|c| c.truncate(rows));
    columns.into_iter().map(Source::held).collect()
}

/// Numbers in fields of fixed width, which may touch.
fn fixed(line: &[u8], widths: &[usize], values: &mut Vec<f64>) -> bool {
    values.clear();
    let line = line.trim_ascii_end();
    let (mut at, mut field) = (0, 0);
    while at < line.len() {
        let width = widths[field % widths.len()];
        let Some(value) = number(&line[at..line.len().min(at + width)]) else {
            return false;
        };
        values.push(value);
        at += width;
        field += 1;
    }
    true
}

/// Numbers with blanks between them, as some programs write them.
fn spaced(line: &[u8], values: &mut Vec<f64>) -> bool {
    values.clear();
    let words = line
        .split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty());
    for word in words {
        match number(word) {
            Some(value) => values.push(value),
            None => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests;

//! Named arrays as streams: those that are as long as each other are together, the longer side of a matrix being the time.

use crate::bytes::Order;
use crate::held_rows::HeldRows;
use crate::names::shown;
use crate::raw::{Kind, Raw};
use crate::stream::{Clock, Column, Contents, Remark, Source, Stream};
use std::collections::HashMap;
use std::sync::Arc;

/// Columns that a matrix may have.
pub(crate) const MOST_COLUMNS: usize = 1 << 16;

/// An array of one or two dimensions.
pub(crate) struct Array {
    pub(crate) name: String,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    /// Row after row in place of column after column.
    pub(crate) by_rows: bool,
    pub(crate) real: Part,
    /// The imaginary parts of complex numbers.
    pub(crate) imaginary: Option<Part>,
}

/// Stored numbers one after the other; they are not unfolded before they are asked for.
#[derive(Clone)]
pub(crate) struct Part {
    pub(crate) bytes: Stored,
    /// First byte of the first number.
    pub(crate) at: usize,
    /// Bytes from one number to the next.
    pub(crate) width: usize,
    pub(crate) kind: Kind,
    pub(crate) order: Order,
}

/// Where numbers are stored.
#[derive(Clone)]
pub(crate) enum Stored {
    Held(Arc<Vec<u8>>),
    /// In the file, up to a byte of it.
    UpTo(usize),
}

impl Stored {
    fn end(&self) -> usize {
        match self {
            Self::Held(bytes) => bytes.len(),
            Self::UpTo(end) => *end,
        }
    }
}

/// Collects arrays.
#[derive(Default)]
pub(crate) struct Arrays {
    streams: Vec<Stream>,
    by_length: HashMap<u64, usize>,
    pub(crate) remarks: Vec<Remark>,
}

impl Part {
    /// Numbers side by side.
    pub(crate) fn of(bytes: Vec<u8>, kind: Kind, order: Order) -> Self {
        Self {
            bytes: Stored::Held(Arc::new(bytes)),
            at: 0,
            width: kind.size() as usize,
            kind,
            order,
        }
    }

    /// The same from so many bytes further on.
    pub(crate) fn behind(&self, bytes: usize) -> Self {
        Self {
            at: self.at + bytes,
            ..self.clone()
        }
    }

    /// Numbers that are there.
    fn count(&self) -> u64 {
        let bytes = self.bytes.end().saturating_sub(self.at) as u64;
        let (width, size) = (self.width as u64, self.kind.size());
        (bytes + width).saturating_sub(size) / width
    }

    /// So many numbers from one on, every so many; nothing where they are not all there.
    fn signal(&self, first: usize, step: usize, count: usize) -> Option<Source> {
        let at = first.checked_mul(self.width)?.checked_add(self.at)?;
        let width = step.checked_mul(self.width)?;
        match &self.bytes {
            Stored::Held(bytes) => {
                let form = (self.kind, self.order);
                HeldRows::apart(bytes, at, width, count, form).map(Source::HeldRows)
            }
            Stored::UpTo(end) => {
                let before = count.checked_sub(1)?.checked_mul(width)?;
                let behind = before.checked_add(at)?;
                let behind = behind.checked_add(self.kind.size() as usize)?;
                let (at, width, count) = (at as u64, width as u64, count as u64);
                let raw = Raw::at(self.kind, self.order, at, width, count);
                (width > 0 && behind <= *end).then_some(Source::Raw(raw))
            }
        }
    }
}

impl Arrays {
    /// Takes in an array; a single number is no signal.
    pub(crate) fn put(&mut self, array: &Array) {
        let (rows, columns) = (array.rows, array.columns);
        let name = shown(&array.name);
        let length = rows.max(columns);
        let signals = rows.min(columns);
        if length < 2 || signals == 0 {
            return;
        }
        let imaginary = array.imaginary.as_ref();
        let there = imaginary.map_or(u64::MAX, Part::count);
        let there = there.min(array.real.count());
        if signals > MOST_COLUMNS || rows.checked_mul(columns).is_none() {
            self.remarks.push(Remark::passed_over(format!(
                "{name}, a matrix of {rows} times {columns} numbers"
            )));
            return;
        }
        let across = columns > rows;
        // Numbers of a signal lie side by side, or one of every signal after the other.
        let beside = across == array.by_rows;
        let count = match beside {
            true => there.saturating_sub(((signals - 1) * length) as u64),
            false => there / signals as u64,
        };
        let count = count.min(length as u64) as usize;
        if count < length {
            self.remarks.push(Remark::cut(format!(
                "{there} of the {} numbers of {name} are there: {count} of {length} samples",
                rows * columns
            )));
        }
        if count == 0 {
            return;
        }
        let parts = [
            (Some(&array.real), " real"),
            (array.imaginary.as_ref(), " imaginary"),
        ];
        for signal in 0..signals {
            for (part, word) in &parts {
                let numbers = part.and_then(|part| match beside {
                    true => part.signal(signal * length, 1, count),
                    false => part.signal(signal, signals, count),
                });
                let Some(numbers) = numbers else { continue };
                let place = match (signals, across) {
                    (1, _) => String::new(),
                    (_, true) => format!("({},:)", signal + 1),
                    (_, false) => format!("(:,{})", signal + 1),
                };
                let word = if array.imaginary.is_some() { word } else { "" };
                let column = Column::of(numbers);
                let name = format!("{name}{place}{word}");
                self.column(name, None, count as u64, column);
            }
        }
    }

    /// Takes in a channel of so many samples.
    pub(crate) fn column(
        &mut self,
        name: String,
        unit: Option<String>,
        length: u64,
        column: Column,
    ) {
        let number = *self.by_length.entry(length).or_insert_with(|| {
            let stream = Stream::new(format!("{length} samples"), Clock::Unsaid, length);
            self.streams.push(stream);
            self.streams.len() - 1
        });
        self.streams[number].push(name, unit, column);
    }

    pub(crate) fn contents(self) -> Contents {
        Contents {
            streams: self.streams,
            remarks: self.remarks,
        }
    }
}

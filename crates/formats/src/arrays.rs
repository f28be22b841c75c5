//! Named arrays as streams: those that are as long as each other are together, the longer side of a matrix being the time.

use crate::bytes::Order;
use crate::raw::{Kind, numbers};
use crate::stream::{Clock, Column, Contents, Remark, Source, Stream};
use std::collections::HashMap;

/// Columns that a matrix may have.
pub(crate) const MOST_COLUMNS: usize = 1 << 16;

/// An array of one or two dimensions.
pub(crate) struct Array {
    pub(crate) name: String,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    /// Column after column, as far as they are there.
    pub(crate) real: Vec<f64>,
    /// The imaginary parts of complex numbers.
    pub(crate) imaginary: Option<Vec<f64>>,
}

/// Collects arrays.
#[derive(Default)]
pub(crate) struct Arrays {
    streams: Vec<Stream>,
    by_length: HashMap<u64, usize>,
    pub(crate) remarks: Vec<Remark>,
}

/// Stored numbers of a kind side by side.
pub(crate) fn values(kind: Kind, order: Order, bytes: &[u8]) -> Vec<f64> {
    let mut values = Vec::new();
    numbers(kind, order, bytes, kind.size() as usize, &mut values);
    values
}

impl Arrays {
    /// Takes in an array; a single number is no signal.
    pub(crate) fn put(&mut self, array: &Array) {
        let Array {
            name,
            rows,
            columns,
            real,
            imaginary,
        } = array;
        let (rows, columns) = (*rows, *columns);
        let length = rows.max(columns);
        let signals = rows.min(columns);
        if length < 2 || signals == 0 {
            return;
        }
        if signals > MOST_COLUMNS || rows.checked_mul(columns).is_none_or(|n| real.len() < n) {
            self.remarks.push(Remark::passed_over(format!(
                "{name}, a matrix of {rows} times {columns} numbers"
            )));
            return;
        }
        let across = columns > rows;
        let parts = [(Some(real), " real"), (imaginary.as_ref(), " imaginary")];
        for signal in 0..signals {
            for (values, part) in &parts {
                let Some(values) = values.filter(|v| v.len() >= length * signals) else {
                    continue;
                };
                let taken = match across {
                    true => values
                        .iter()
                        .skip(signal)
                        .step_by(rows)
                        .take(length)
                        .copied()
                        .collect(),
                    false => values[signal * rows..(signal + 1) * rows].to_vec(),
                };
                let place = match (signals, across) {
                    (1, _) => String::new(),
                    (_, true) => format!("({},:)", signal + 1),
                    (_, false) => format!("(:,{})", signal + 1),
                };
                let part = if imaginary.is_some() { part } else { "" };
                self.signal(format!("{name}{place}{part}"), taken);
            }
        }
    }

    fn signal(&mut self, name: String, values: Vec<f64>) {
        let length = values.len() as u64;
        self.column(name, None, length, Column::of(Source::held(values)));
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

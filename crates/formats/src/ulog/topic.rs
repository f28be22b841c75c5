//! The messages of one instance of a topic, and the stream that they make.

use super::layout::{Definitions, Layout, TOPICS, unit};
use crate::held_rows::HeldRows;
use crate::raw::Kind;
use crate::stream::{Clock, Column, Remark, Source, Stream};
use std::sync::Arc;

/// Instances of a topic that can be; PX4 has ten.
const INSTANCES: u8 = 16;

/// An instance of a topic.
pub(super) struct Topic {
    pub(super) name: String,
    pub(super) instance: u8,
    /// Place in the list of topics that are read, and the layout; nothing where it is not read.
    pub(super) read: Option<(usize, Layout)>,
    pub(super) rows: Vec<u8>,
    pub(super) messages: u64,
    /// Messages of another length than their definition.
    unfit: u64,
}

impl Topic {
    pub(super) fn new(name: &str, instance: u8, definitions: &Definitions) -> Self {
        let place = TOPICS.iter().position(|t| t.0 == name);
        let place = place.filter(|_| instance < INSTANCES);
        let layout = place.and_then(|_| definitions.layout(name));
        // Without a clock it is no stream.
        let timed = |l: &Layout| l.at("timestamp").is_some_and(|t| t.1 == Kind::U64);
        Self {
            name: name.to_owned(),
            instance,
            read: place.zip(layout.filter(timed)),
            rows: Vec::new(),
            messages: 0,
            unfit: 0,
        }
    }

    pub(super) fn message(&mut self, content: &[u8]) {
        self.messages += 1;
        let Some((_, layout)) = &self.read else {
            return;
        };
        match (layout.width..=layout.padded).contains(&content.len()) {
            true => self.rows.extend_from_slice(&content[..layout.width]),
            false => self.unfit += 1,
        }
    }

    /// The stream, whose times count from a stamp, µs.
    pub(super) fn stream(mut self, origin: u64, remarks: &mut Vec<Remark>) -> Option<Stream> {
        let (place, layout) = self.read?;
        let mut name = self.name;
        if self.instance > 0 {
            name = format!("{name}_{}", self.instance);
        }
        if self.unfit > 0 {
            remarks.push(Remark::damaged(format!(
                "{} messages of {name}, which do not fit their definition",
                self.unfit
            )));
        }
        let width = layout.width;
        let stamp = |row: &[u8], at: usize| row[at..].first_chunk().map(|b| u64::from_le_bytes(*b));
        // When the sample was taken rather than when it was published, where every message says so.
        let (published, _) = layout.at("timestamp")?;
        let sampled = layout.at("timestamp_sample").filter(|(at, kind)| {
            let said = |row: &[u8]| stamp(row, *at) != Some(0);
            *kind == Kind::U64 && self.rows.chunks_exact(width).all(said)
        });
        let clock = sampled.map_or(published, |(at, _)| at);
        for row in self.rows.chunks_exact_mut(width) {
            let us = stamp(row, clock)?.wrapping_sub(origin) as i64;
            let time = us as f64 / 1e6;
            row[clock..clock + 8].copy_from_slice(&time.to_le_bytes());
        }
        let units = TOPICS[place].1;
        let mut stream = match Fifo::of(&layout, clock) {
            Some(fifo) => {
                let mut stream = Stream::new(name, Clock::Times, 0);
                let [times, axes @ ..] = fifo.samples(&self.rows, width);
                stream.rows = times.len() as u64;
                for (axis, values) in ["x", "y", "z"].into_iter().zip(axes) {
                    stream.push(axis, unit(units, axis), Column::of(Source::held(values)));
                }
                stream.push_times(Source::held(times));
                stream
            }
            None => {
                let rows = Arc::new(self.rows);
                let mut stream = Stream::new(name, Clock::Times, (rows.len() / width) as u64);
                let column = |at, kind| Source::HeldRows(HeldRows::new(&rows, width, at, kind));
                let stamps = ["timestamp", "timestamp_sample"];
                for (name, at, kind) in &layout.numbers {
                    if !stamps.contains(&name.as_str()) {
                        stream.push(name, unit(units, name), Column::of(column(*at, *kind)));
                    }
                }
                stream.push_times(column(clock, Kind::F64));
                stream
            }
        };
        stream.origin_ns = origin.checked_mul(1000).and_then(|ns| ns.try_into().ok());
        Some(stream)
    }
}

/// Messages that hold several samples each, the last of which was taken at the stamp.
struct Fifo {
    clock: usize,
    /// Between samples, µs.
    step: usize,
    scale: usize,
    count: usize,
    axes: [usize; 3],
    /// Samples that fit.
    most: usize,
}

impl Fifo {
    fn of(layout: &Layout, clock: usize) -> Option<Self> {
        let of = |name: &str, kind| layout.at(name).filter(|n| n.1 == kind).map(|n| n.0);
        let axis = |name: &str| of(&format!("{name}[0]"), Kind::I16);
        let all = layout.numbers.iter();
        Some(Self {
            clock,
            step: of("dt", Kind::F32)?,
            scale: of("scale", Kind::F32)?,
            count: of("samples", Kind::U8)?,
            axes: [axis("x")?, axis("y")?, axis("z")?],
            most: all.filter(|n| n.0.starts_with("z[")).count(),
        })
    }

    /// Times and values on three axes of all samples.
    fn samples(&self, rows: &[u8], width: usize) -> [Vec<f64>; 4] {
        let mut all: [Vec<f64>; 4] = Default::default();
        for row in rows.chunks_exact(width) {
            let single = |at: usize| row[at..].first_chunk().map(|b| f32::from_le_bytes(*b));
            let double = |at: usize| row[at..].first_chunk().map(|b| f64::from_le_bytes(*b));
            let step = f64::from(single(self.step).unwrap_or_default()) / 1e6;
            let scale = f64::from(single(self.scale).unwrap_or_default());
            let last = double(self.clock).unwrap_or_default();
            let count = usize::from(row[self.count]).min(self.most);
            let [times, axes @ ..] = &mut all;
            times.extend((0..count).map(|i| last - (count - 1 - i) as f64 * step));
            for (at, to) in self.axes.iter().zip(axes) {
                let numbers = row[*at..].as_chunks::<2>().0.iter().take(count);
                to.extend(numbers.map(|b| f64::from(i16::from_le_bytes(*b)) * scale));
            }
        }
        all
    }
}

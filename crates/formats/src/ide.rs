//! IDE of enDAQ (Mide) recorders: blocks of samples of several channels, each with its time codes, and a description of the channels.
//!
//! **Source** `[IDE]`, `[EBML]`.

mod calibration;
mod elements;
mod properties;
mod scan;

use crate::raw::{Extent, Raw};
use crate::stream::{Clock, Column, Contents, Line, Remark, SeekRead, Source, Stream};
use crate::{Error, Result};
use calibration::Calibrations;
use properties::{Described, Properties, Sample};
use scan::{Block, Scan};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The element that describes the recording.
const PROPERTIES: u32 = 0x1852_6570;

/// Whether a file is EBML of the kind that recorders write, not a film.
pub(crate) fn is_ide(head: &[u8]) -> bool {
    let Some(content) = elements::head(head)
        .filter(|h| h.id == 0x1A45_DFA3)
        .and_then(|h| head.get(h.length as usize..))
    else {
        return false;
    };
    elements::children(content).any(|(id, content)| id == 0x4282 && content.starts_with(b"mide"))
}

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let Scan {
        properties,
        mut blocks,
        mut remarks,
        ..
    } = Scan::of(file, size)?;
    if properties.channels.is_empty() {
        return Err(
            Error::new("is an IDE file that does not describe its channels").with_hint(
                "recorders of old firmware wrote such files; export it as delimited text (CSV) with the program of the maker",
            ),
        );
    }
    let mut signals = BTreeMap::new();
    for (number, channel) in &properties.channels {
        let Some(blocks) = blocks.remove(number) else {
            continue;
        };
        match &channel.format {
            Ok(sample) => {
                let signal = Signal::of(channel, sample, &blocks);
                signals.insert(*number, signal);
            }
            Err(why) => remarks.push(Remark::passed_over(format!(
                "channel {:?}: {why}",
                channel.name
            ))),
        }
    }
    for (number, blocks) in blocks {
        remarks.push(Remark::passed_over(format!(
            "{} blocks of channel {number}, which the file does not describe",
            blocks.len()
        )));
    }
    streams(file, &properties, signals, remarks)
}

/// Stored numbers of a channel with their times.
struct Signal {
    /// One for each field.
    raws: Vec<Raw>,
    times: Vec<Line>,
}

impl Signal {
    fn of(channel: &Described, sample: &Sample, blocks: &[Block]) -> Self {
        let (mut extents, mut times) = (Vec::new(), Vec::new());
        let mut clock = Unwrapped::default();
        let mut step = 0.0;
        for (i, block) in blocks.iter().enumerate() {
            let modulus = channel.modulus.unwrap_or(block.modulus);
            let start = clock.of(block.start, modulus);
            let end = block.end.map(|end| clock.of(end, modulus));
            let announced = block.announced / sample.size;
            let count = block.bytes / sample.size;
            if count == 0 {
                continue;
            }
            // The time codes are those of the first sample and of the last one; a block without an end lasts until the next.
            let ticks = |ticks: u64| ticks as f64 * channel.tick;
            match (end, blocks.get(i + 1)) {
                (Some(end), _) if announced > 1 && end > start => {
                    step = ticks(end - start) / (announced - 1) as f64;
                }
                (None, Some(next)) if next.start > block.start => {
                    step = ticks(next.start - block.start) / announced as f64;
                }
                _ => {}
            }
            times.push(Line {
                count,
                first: ticks(start),
                step,
            });
            extents.push(Extent {
                at: block.at,
                stride: sample.size,
                count,
                chunks: 1,
                step: 0,
            });
        }
        let extents = Arc::new(extents);
        let fields = sample.fields.iter();
        let raws = fields.map(|(kind, place)| Raw::behind(&extents, *kind, sample.order, *place));
        Self {
            raws: raws.collect(),
            times,
        }
    }
}

/// Time codes that begin again, in a row.
#[derive(Default)]
struct Unwrapped {
    last: u64,
    turns: u64,
}

impl Unwrapped {
    /// A code before the one that came last is of the next turn; one beyond the modulus has not been shortened.
    fn of(&mut self, code: u64, modulus: u64) -> u64 {
        let mut within = code;
        if code >= modulus {
            self.turns = code / modulus;
            within = code % modulus;
        } else if code < self.last {
            self.turns += 1;
        }
        self.last = within;
        self.turns.saturating_mul(modulus).saturating_add(within)
    }
}

fn streams(
    file: &mut dyn SeekRead,
    properties: &Properties,
    signals: BTreeMap<u64, Signal>,
    mut remarks: Vec<Remark>,
) -> Result<Contents> {
    let mut calibrations = Calibrations::new(properties, &signals);
    let mut scalings = BTreeMap::new();
    for number in signals.keys() {
        for field in properties.channels[number].subchannels.keys() {
            let scaling = calibrations.scaling(file, *number, *field)?;
            scalings.insert((*number, *field), scaling);
        }
    }
    remarks.append(&mut calibrations.remarks);
    let mut streams = Vec::new();
    for (number, signal) in signals {
        let channel = &properties.channels[&number];
        let same = properties.channels.values();
        let name = match same.filter(|c| c.name == channel.name).count() {
            1 => channel.name.clone(),
            _ => format!("{} {number}", channel.name),
        };
        let rows = signal.times.iter().map(|l| l.count).sum();
        let mut stream = Stream::new(name, Clock::Times, rows);
        for (field, raw) in (0..).zip(signal.raws) {
            let about = channel.subchannels.get(&field);
            let name = about.and_then(|a| a.name.clone());
            let name = name.unwrap_or_else(|| format!("field {field}"));
            let found = scalings.remove(&(number, field)).unwrap_or_default();
            let unit = about.and_then(|a| a.unit.clone());
            stream.push(name, unit, Column::scaled(Source::Raw(raw), found.scaling));
            if let (Some(at), Some(channel)) = (found.at, stream.channels.last_mut()) {
                channel.scaling = channel.scaling.take().map(|words| words + &at);
            }
        }
        stream.push_times(Source::lines(signal.times));
        streams.push(stream);
    }
    Ok(Contents { streams, remarks })
}

#[cfg(test)]
mod tests;

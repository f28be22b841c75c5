//! TDMS of LabVIEW: segments of metadata and raw data, of which each adds to those before.
//!
//! **Source** `[TDMS]`.

mod index;
mod properties;
mod scales;

use crate::raw::{Extent, Raw, bytes_at};
use crate::stream::{Clock, Column, Contents, Remark, SeekRead, Source, Stream};
use crate::{Error, Result};
use index::{Layout, Metadata, Object, RawIndex};
use std::collections::{BTreeMap, HashMap};

/// Lead-in of a segment.
const LEAD: u64 = 28;
const METADATA: u32 = 1 << 1;
const NEW_OBJECTS: u32 = 1 << 2;
const RAW: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG: u32 = 1 << 6;
/// Most segments of a file; each costs its place in memory.
const MOST_SEGMENTS: usize = 4 << 20;

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let mut found = Found::default();
    let mut at = 0;
    for _ in 0..MOST_SEGMENTS {
        if at >= size {
            break;
        }
        match segment(file, at, size, &mut found)? {
            Some(next) => at = next,
            None => break,
        }
    }
    Ok(found.contents())
}

/// What the segments so far hold.
#[derive(Default)]
struct Found {
    objects: Vec<Object>,
    by_path: HashMap<String, usize>,
    /// Objects with raw data in a segment, in their order, and the place of each object in it.
    active: BTreeMap<u64, usize>,
    turns: Vec<Option<u64>>,
    next_turn: u64,
    /// Numbers of each object, by its scalers.
    data: Vec<Vec<(u32, Raw)>>,
    /// What stands of each object in a last chunk that is not whole.
    partial: HashMap<usize, Partial>,
    texts: BTreeMap<String, u64>,
    remarks: Vec<Remark>,
}

/// Numbers of an object in a chunk that was cut.
#[derive(Clone, Copy, Debug)]
struct Partial {
    /// There.
    left: u64,
    /// Announced.
    values: u64,
}

/// Takes in one segment; where the next one begins.
fn segment(file: &mut dyn SeekRead, at: u64, size: u64, found: &mut Found) -> Result<Option<u64>> {
    let cut = |found: &mut Found, what: &str| {
        found
            .remarks
            .push(Remark::cut(format!("{what} at byte {at} of {size}")));
        Ok(None)
    };
    let lead = bytes_at(file, at, LEAD)?;
    if lead.len() < LEAD as usize {
        return cut(found, "the file ends inside the head of a segment");
    }
    if !lead.starts_with(b"TDSm") {
        if at == 0 {
            return Err(Error::new("is no TDMS file"));
        }
        return cut(found, "what should be a segment does not begin as one");
    }
    let mut fixed = crate::bytes::Bytes::new(&lead[4..], crate::bytes::Order::Little);
    let flags = fixed.u32().unwrap_or(0);
    let order = match flags & BIG {
        0 => crate::bytes::Order::Little,
        _ => crate::bytes::Order::Big,
    };
    fixed.order = order;
    fixed.u32();
    let (next, raw) = (fixed.u64().unwrap_or(0), fixed.u64().unwrap_or(0));
    let begin = at + LEAD;
    let mut end = match next {
        // The program was stopped before it knew where the segment ends.
        u64::MAX => size,
        n => begin.saturating_add(n),
    };
    let open = next == u64::MAX || end > size;
    end = end.min(size);
    let data = begin.saturating_add(raw);
    if data > end {
        return cut(found, "the file ends inside the description of a segment");
    }
    if flags & METADATA != 0 {
        let bytes = bytes_at(file, begin, raw)?;
        let fresh = flags & NEW_OBJECTS != 0;
        if Metadata::read(&bytes, order, fresh, found).is_none() {
            return cut(found, "the description of a segment is damaged");
        }
    }
    if flags & RAW != 0 && end > data {
        let whole = chunks(flags, order, data, end, found)?;
        if !whole && open {
            found.remarks.push(Remark::cut(format!(
                "the file ends inside the last samples of the segment at byte {at}"
            )));
        }
    }
    if open && next != u64::MAX {
        found.remarks.push(Remark::cut(format!(
            "the segment at byte {at} is longer than the file of {size} bytes"
        )));
    }
    Ok((end > at).then_some(end))
}

/// Takes in the raw data of a segment; whether its last chunk is whole.
fn chunks(
    flags: u32,
    order: crate::bytes::Order,
    data: u64,
    end: u64,
    found: &mut Found,
) -> Result<bool> {
    let there = end - data;
    let active = found.active.values();
    let layouts: Vec<(usize, RawIndex)> = active
        .filter_map(|&i| Some((i, found.objects[i].index.clone()?)))
        .collect();
    let daqmx = layouts
        .iter()
        .any(|(_, l)| matches!(l.layout, Layout::Daqmx { .. }));
    let mut put = |object: usize, scaler: u32, raw: Raw| {
        let all = &mut found.data[object];
        match all
            .iter_mut()
            .find(|(id, r)| *id == scaler && r.kind == raw.kind && r.order == raw.order)
        {
            Some((_, known)) => raw.extents.iter().for_each(|e| known.push(*e)),
            None => all.push((scaler, raw)),
        }
    };
    if daqmx {
        return Ok(index::daqmx(&layouts, order, data, there, &mut put));
    }
    if flags & INTERLEAVED != 0 {
        return Ok(interleaved(&layouts, order, data, there, &mut put));
    }
    // One object after the other, each with all its values of the chunk.
    let chunk = layouts
        .iter()
        .try_fold(0_u64, |sum, (_, l)| sum.checked_add(l.bytes()?));
    let Some(chunk) = chunk else {
        return Err(Error::new(
            "a segment of the TDMS file states impossible sizes",
        ));
    };
    if chunk == 0 {
        return Ok(true);
    }
    let (whole, rest) = (there / chunk, there % chunk);
    let mut offset = 0;
    let mut partial = HashMap::new();
    for (object, layout) in &layouts {
        let bytes = layout.bytes().unwrap_or(0);
        if let Layout::Numbers(kind) = layout.layout {
            let stride = kind.size();
            let mut raw = Raw::new(kind, order);
            raw.push(Extent {
                at: data.saturating_add(offset),
                stride,
                count: layout.values,
                chunks: whole,
                step: chunk,
            });
            // What stands of the last chunk: the objects of the front are there, the others are not.
            let left = rest.saturating_sub(offset).min(bytes) / stride;
            raw.push(Extent {
                at: (data + whole * chunk).saturating_add(offset),
                stride,
                count: left,
                chunks: 1,
                step: 0,
            });
            put(*object, u32::MAX, raw);
            let values = layout.values;
            partial.insert(*object, Partial { left, values });
        }
        offset += bytes;
    }
    if rest > 0 {
        found.partial = partial;
    }
    Ok(rest == 0)
}

/// One value of each object after the other.
fn interleaved(
    layouts: &[(usize, RawIndex)],
    order: crate::bytes::Order,
    data: u64,
    there: u64,
    put: &mut dyn FnMut(usize, u32, Raw),
) -> bool {
    let width = |l: &RawIndex| match l.layout {
        Layout::Numbers(kind) => kind.size(),
        Layout::Other(width) => width,
        Layout::Text | Layout::Daqmx { .. } => 0,
    };
    let frame: u64 = layouts.iter().map(|(_, l)| width(l)).sum();
    if frame == 0 {
        return true;
    }
    let mut offset = 0;
    for (object, layout) in layouts {
        if let Layout::Numbers(kind) = layout.layout {
            put(
                *object,
                u32::MAX,
                Raw::at(kind, order, data + offset, frame, there / frame),
            );
        }
        offset += width(layout);
    }
    there.is_multiple_of(frame)
}

impl Found {
    /// The streams: channels of a group that are as long as each other and have the same clock.
    fn contents(mut self) -> Contents {
        let mut streams: Vec<Stream> = Vec::new();
        let mut places: HashMap<(String, u64, [u64; 2]), usize> = HashMap::new();
        let order: Vec<usize> = (0..self.objects.len()).collect();
        for i in order {
            let Some((group, name)) = self.objects[i].names() else {
                continue;
            };
            let data = std::mem::take(&mut self.data[i]);
            if data.is_empty() {
                continue;
            }
            let above = |path: &str| self.by_path.get(path).map(|&i| &self.objects[i].properties);
            let own = &self.objects[i].properties;
            let of_group = above(&index::group_path(&group));
            let of_file = above("/");
            let scaling = scales::scaling(own, &data)
                .or_else(|| of_group.and_then(|p| scales::scaling(p, &data)))
                .or_else(|| of_file.and_then(|p| scales::scaling(p, &data)));
            let scaling = match scaling.unwrap_or_else(|| scales::stored(&data)) {
                Ok(scaling) => scaling,
                Err(what) => {
                    self.remarks.push(Remark::passed_over(format!(
                        "channel {name} of group {group}: {what}"
                    )));
                    continue;
                }
            };
            let rows = data.iter().map(|(_, raw)| raw.rows()).min().unwrap_or(0);
            if rows == 0 {
                continue;
            }
            let clock = own.clock();
            if let (Clock::Unsaid, Some(step)) = (clock, own.number("wf_increment"))
                && step != 0.0
            {
                self.remarks.push(Remark::damaged(format!(
                    "the time step of channel {name}, {step} s, is not positive: the channel is read without times"
                )));
            }
            let unit = own.text("unit_string").filter(|u| !u.trim().is_empty());
            let column = Column {
                sources: data.into_iter().map(|(_, raw)| Source::Raw(raw)).collect(),
                scaling,
            };
            // Channels of a file that was cut would be as long as each other.
            let alike = match self.partial.get(&i) {
                Some(p) => (rows - p.left.min(rows)).saturating_add(p.values),
                None => rows,
            };
            let place = (group.clone(), alike, clock_bits(clock));
            let number = *places.entry(place).or_insert_with(|| {
                streams.push(Stream::new(group, clock, rows));
                streams.len() - 1
            });
            let stream = &mut streams[number];
            stream.rows = stream.rows.min(rows);
            stream.push(name, unit, column);
        }
        for (kind, objects) in self.texts {
            self.remarks.push(Remark::passed_over(format!(
                "{objects} channels of {kind} are no samples"
            )));
        }
        Contents {
            streams,
            remarks: self.remarks,
        }
    }
}

/// A clock as something to be compared.
fn clock_bits(clock: Clock) -> [u64; 2] {
    match clock {
        Clock::Rate { hz, start_s } => [hz.to_bits(), start_s.to_bits()],
        Clock::Times | Clock::Unsaid => [u64::MAX; 2],
    }
}

#[cfg(test)]
mod tests;

//! The topics of a log, and the rows that their messages give.

use super::kind;
use super::message::{Encoding, LAYOUTS, Layout};
use crate::bytes::{Bytes, Order, text};
use crate::held_rows::HeldRows;
use crate::input::Input;
use crate::raw::Kind;
use crate::stream::{Clock, Column, Contents, Remark, Source, Stream};
use crate::{Error, Result};
use std::collections::HashMap;
use std::sync::Arc;

/// A message of a type that is read is no longer than this, and of a definition no more is looked at.
const LONGEST: u64 = 1 << 20;
/// Rows may take so many bytes, and so many more for each byte of the file.
const HELD: u64 = 32 << 20;
const FOR_EACH_BYTE: u64 = 16;
/// Topics that a remark names.
const NAMED: usize = 12;

/// Schemas and channels by their numbers.
#[derive(Default)]
struct Definitions {
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, Channel>,
}

struct Channel {
    schema: u16,
    topic: String,
    encoding: String,
}

struct Topic {
    name: String,
    schema: String,
    encoding: String,
    read: Option<(&'static Layout, Encoding)>,
    rows: Vec<u8>,
    count: Count,
}

#[derive(Clone, Copy, Default)]
struct Count {
    messages: u64,
    /// Those that do not fit their type.
    unfit: u64,
    /// Those without a group of numbers, for each group.
    absent: [u64; 4],
}

/// Collects definitions and messages.
pub(super) struct Topics {
    defined: Definitions,
    /// What the summary repeats.
    aside: Definitions,
    /// Definitions since the last mark: whether of a schema, and its number.
    latest: Vec<(bool, u16)>,
    topics: Vec<Topic>,
    /// Topic of a channel.
    routes: HashMap<u16, usize>,
    /// Stamp of the first message, ns.
    origin: Option<i64>,
    /// Messages of channels that are not defined.
    homeless: u64,
    /// Records of kinds that are not known.
    unknown: u64,
    held: u64,
    most: u64,
}

/// A state to which it can be gone back.
pub(super) struct Mark {
    topics: Vec<(usize, Count)>,
    origin: Option<i64>,
    homeless: u64,
    held: u64,
}

impl Topics {
    pub(super) fn new(size: u64) -> Self {
        Self {
            defined: Definitions::default(),
            aside: Definitions::default(),
            latest: Vec::new(),
            topics: Vec::new(),
            routes: HashMap::new(),
            origin: None,
            homeless: 0,
            unknown: 0,
            held: 0,
            most: HELD.saturating_add(FOR_EACH_BYTE.saturating_mul(size)),
        }
    }

    pub(super) fn mark(&mut self) -> Mark {
        self.latest.clear();
        Mark {
            topics: self
                .topics
                .iter()
                .map(|t| (t.rows.len(), t.count))
                .collect(),
            origin: self.origin,
            homeless: self.homeless,
            held: self.held,
        }
    }

    /// Forgets what came since.
    pub(super) fn back_to(&mut self, mark: Mark) {
        self.topics.truncate(mark.topics.len());
        for (topic, (length, count)) in self.topics.iter_mut().zip(mark.topics) {
            topic.rows.truncate(length);
            topic.count = count;
        }
        for (is_schema, id) in self.latest.drain(..) {
            match is_schema {
                true => drop(self.defined.schemas.remove(&id)),
                false => drop(self.defined.channels.remove(&id)),
            }
        }
        self.routes.clear();
        (self.origin, self.homeless, self.held) = (mark.origin, mark.homeless, mark.held);
    }

    /// What was defined so far is used where nothing else defines it.
    pub(super) fn set_aside(&mut self) {
        self.aside = std::mem::take(&mut self.defined);
        self.routes.clear();
    }

    /// Takes in a record; nothing where it is not all there.
    pub(super) fn record(
        &mut self,
        op: u8,
        length: u64,
        input: &mut Input<'_>,
    ) -> Result<Option<()>> {
        match op {
            kind::MESSAGE if length >= 22 => self.message(length - 22, input),
            kind::SCHEMA | kind::CHANNEL => {
                let looked = length.min(LONGEST);
                let Some(content) = input.bytes(looked as usize) else {
                    return Ok(None);
                };
                let defined = self.define(op, content);
                self.latest.extend(defined);
                Ok(input.skip(length - looked))
            }
            _ => {
                self.unknown += u64::from(op > kind::DATA_END);
                Ok(input.skip(length))
            }
        }
    }

    fn define(&mut self, op: u8, content: &[u8]) -> Option<(bool, u16)> {
        let mut b = Bytes::new(content, Order::Little);
        let word = |b: &mut Bytes<'_>| {
            let length = b.u32()?;
            Some(text(b.take(length as usize)?))
        };
        let id = b.u16()?;
        if op == kind::SCHEMA {
            self.defined.schemas.insert(id, word(&mut b)?);
        } else {
            let channel = Channel {
                schema: b.u16()?,
                topic: word(&mut b)?,
                encoding: word(&mut b)?,
            };
            self.defined.channels.insert(id, channel);
            self.routes.remove(&id);
        }
        Some((op == kind::SCHEMA, id))
    }

    /// Number of the topic of a channel.
    fn route(&mut self, id: u16) -> Option<usize> {
        if let Some(topic) = self.routes.get(&id) {
            return Some(*topic);
        }
        let both = [&self.defined, &self.aside];
        let channel = both.iter().find_map(|d| d.channels.get(&id))?;
        let schema = both.iter().find_map(|d| d.schemas.get(&channel.schema));
        let schema = schema.map_or("", String::as_str);
        let same = |t: &Topic| {
            (&t.name, t.schema.as_str(), &t.encoding) == (&channel.topic, schema, &channel.encoding)
        };
        let topic = match self.topics.iter().position(same) {
            Some(topic) => topic,
            None => {
                self.topics.push(Topic {
                    name: channel.topic.clone(),
                    schema: schema.to_owned(),
                    encoding: channel.encoding.clone(),
                    read: Layout::of(schema).zip(Encoding::of(&channel.encoding)),
                    rows: Vec::new(),
                    count: Count::default(),
                });
                self.topics.len() - 1
            }
        };
        self.routes.insert(id, topic);
        Some(topic)
    }

    fn message(&mut self, length: u64, input: &mut Input<'_>) -> Result<Option<()>> {
        let Some(id) = input.bytes(22).and_then(|b| b.first_chunk::<2>()) else {
            return Ok(None);
        };
        let Some(topic) = self.route(u16::from_le_bytes(*id)) else {
            self.homeless += 1;
            return Ok(input.skip(length));
        };
        let topic = &mut self.topics[topic];
        let Some((layout, encoding)) = topic.read.filter(|_| length <= LONGEST) else {
            topic.count.unfit += u64::from(topic.read.is_some());
            topic.count.messages += 1;
            return Ok(input.skip(length));
        };
        let Some(message) = input.bytes(length as usize) else {
            return Ok(None);
        };
        topic.count.messages += 1;
        let before = topic.rows.len();
        match layout.row(encoding, message, &mut topic.rows, &mut topic.count.absent) {
            Some(()) => {
                let stamp = topic.rows[before..].first_chunk::<8>();
                self.origin = self.origin.or(stamp.map(|s| i64::from_le_bytes(*s)));
                self.held += layout.width() as u64;
            }
            None => topic.count.unfit += 1,
        }
        if self.held > self.most {
            return Err(Error::new(format!(
                "unpacks to more than {} MiB of numbers, which is out of proportion to its length",
                self.most >> 20
            ))
            .with_hint("write it again without compression (`mcap compress --compression none`), or filter the topics that are needed"));
        }
        Ok(Some(()))
    }

    pub(super) fn contents(self, mut remarks: Vec<Remark>) -> Result<Contents> {
        if self.homeless > 0 {
            remarks.push(Remark::damaged(format!(
                "{} messages of channels that no whole record describes",
                self.homeless
            )));
        }
        if self.unknown > 0 {
            let what = format!("{} records of kinds that are not known", self.unknown);
            remarks.push(Remark::passed_over(what));
        }
        let (read, other): (Vec<Topic>, Vec<Topic>) =
            self.topics.into_iter().partition(|t| !t.rows.is_empty());
        let others = listed(&other);
        if read.is_empty() && !other.is_empty() {
            let names: Vec<&str> = LAYOUTS.iter().map(|l| l.name).collect();
            return Err(Error::new(format!(
                "is an MCAP log without a topic that is read here; it holds {others}"
            ))
            .with_hint(format!(
                "types that are read, in ros1 or cdr: {}",
                names.join(", ")
            )));
        }
        let origin = self.origin.unwrap_or_default();
        let streams = read.into_iter();
        let streams = streams.map(|t| t.stream(origin, &mut remarks)).collect();
        if !other.is_empty() {
            remarks.push(Remark::passed_over(others));
        }
        Ok(Contents { streams, remarks })
    }
}

/// Topics in words.
fn listed(topics: &[Topic]) -> String {
    let mut words: Vec<String> = topics.iter().take(NAMED).map(Topic::words).collect();
    if topics.len() > NAMED {
        words.push(format!("and {} more topics", topics.len() - NAMED));
    }
    words.join(", ")
}

impl Topic {
    /// Its name, its type and its messages, and how they are written where that is why they are not read.
    fn words(&self) -> String {
        let schema = match self.schema.as_str() {
            "" => "no type",
            schema => schema,
        };
        let how = match (Encoding::of(&self.encoding), self.read) {
            (_, Some(_)) => " that do not fit it".to_owned(),
            (None, _) => format!(" in {}", self.encoding),
            _ => String::new(),
        };
        let (name, count) = (&self.name, self.count.messages);
        format!("{name} ({schema}, {count} messages{how})")
    }

    fn stream(self, origin: i64, remarks: &mut Vec<Remark>) -> Stream {
        let Self {
            name,
            read,
            mut rows,
            count,
            ..
        } = self;
        let (layout, _) = read.expect("a topic with rows is read");
        let width = layout.width();
        for row in rows.chunks_exact_mut(width) {
            if let Some(stamp) = row.first_chunk_mut::<8>() {
                let ns = i64::from_le_bytes(*stamp) - origin;
                *stamp = (ns as f64 / 1e9).to_le_bytes();
            }
        }
        if count.unfit > 0 {
            remarks.push(Remark::damaged(format!(
                "{} messages of {name}, which do not fit their type",
                count.unfit
            )));
        }
        rows.shrink_to_fit();
        let rows = Arc::new(rows);
        let column = |at| Source::HeldRows(HeldRows::new(&rows, width, at, Kind::F64));
        let number = (rows.len() / width) as u64;
        let mut stream = Stream::new(name, Clock::Times, number);
        stream.origin_ns = Some(origin);
        let mut at = 0;
        for (group, absent) in layout.groups.iter().zip(count.absent) {
            if absent > 0 && absent < number {
                remarks.push(Remark::passed_over(format!(
                    "{} in {absent} of {number} messages of {}, which say that they have none",
                    group.name, stream.name
                )));
            }
            for axis in group.axes {
                at += 8;
                if absent < number {
                    let name = format!("{}{axis}", group.name);
                    stream.push(name, group.unit.map(str::to_owned), Column::of(column(at)));
                }
            }
        }
        stream.push_times(column(0));
        stream
    }
}

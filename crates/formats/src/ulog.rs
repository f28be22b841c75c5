//! ULog of PX4: definitions of messages, then messages of topics one after the other.
//!
//! **Source** `[ULOG]`.

use crate::bytes::{Bytes, Order, text};
use crate::input::Input;
use crate::stream::{Contents, Remark, SeekRead};
use crate::{Error, Result};
use layout::{Definitions, TOPICS};
use std::collections::HashMap;
use std::io::SeekFrom;
use topic::Topic;

mod layout;
mod topic;

/// Bytes of the header.
const HEADER: usize = 16;
/// Kinds of messages.
const KINDS: &[u8] = b"BFIMPQARDLCSO";
/// A whole synchronisation message, by which the place of messages is found again.
const SYNC: &[u8] = b"\x08\0S\x2F\x73\x13\x20\x25\x0C\xBB\x12";
/// Topics that a remark names.
const NAMED: usize = 12;

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    file.seek(SeekFrom::Start(0))?;
    let mut input = Input::new(file, 0);
    let mut log = Log::default();
    match input.bytes(HEADER).and_then(|h| h.last_chunk::<8>()) {
        Some(start) => log.origin = u64::from_le_bytes(*start),
        None => log.cut_at = Some(0),
    }
    while log.cut_at.is_none() && input.peek().is_some() {
        log.message(&mut input)?;
    }
    if let Some(error) = input.failed {
        return Err(error.into());
    }
    log.contents(size)
}

#[derive(Default)]
struct Log {
    /// When logging began, µs.
    origin: u64,
    definitions: Definitions,
    topics: Vec<Topic>,
    /// Topic of a number.
    routes: HashMap<u16, usize>,
    /// Where data were appended after the log, rising.
    appended: Vec<u64>,
    /// Messages of numbers that stand for no topic.
    homeless: u64,
    dropouts: u64,
    dropped_ms: u64,
    /// Stretches that are no messages: how many, bytes in all, the first.
    damage: Option<(u64, u64, u64)>,
    cut_at: Option<u64>,
}

impl Log {
    fn message(&mut self, input: &mut Input<'_>) -> Result<()> {
        let at = input.place();
        let head = input.ahead(3);
        let length = head.first_chunk::<2>().map(|b| u16::from_le_bytes(*b));
        let kind = head.get(2).copied();
        let end = at + 3 + u64::from(length.unwrap_or_default());
        // A message that was being written when data were appended ends there.
        if let Some(next) = self.appended.first().copied().filter(|next| *next < end) {
            self.appended.remove(0);
            if next > at {
                input.skip(next - at);
                return Ok(());
            }
        }
        let (Some(length), Some(kind)) = (length.map(usize::from), kind) else {
            self.cut_at = Some(at);
            return Ok(());
        };
        if !KINDS.contains(&kind) {
            let next = input.ahead(length + 6).get(length + 5).copied();
            let is_message = kind.is_ascii_alphabetic() && next.is_some_and(|k| KINDS.contains(&k));
            if is_message {
                input.skip(3 + length as u64);
            } else {
                input.find(SYNC);
                self.no_message(at, input.place());
            }
            return Ok(());
        }
        if input.ahead(3 + length).len() < 3 + length {
            // No message goes beyond the next synchronisation.
            match input.find(SYNC) {
                true => self.no_message(at, input.place()),
                false => self.cut_at = Some(at),
            }
            return Ok(());
        }
        let content = input.bytes(3 + length).map_or(&[][..], |m| &m[3..]);
        match kind {
            b'B' if at == HEADER as u64 => self.flags(content)?,
            b'F' => drop(self.definitions.define(&text(content))),
            b'A' => drop(self.subscribe(content)),
            b'D' => self.data(content),
            b'O' => {
                self.dropouts += 1;
                let ms = content.first_chunk().map(|b| u16::from_le_bytes(*b));
                self.dropped_ms += u64::from(ms.unwrap_or_default());
            }
            _ => {}
        }
        Ok(())
    }

    /// Bytes between two places are no messages.
    fn no_message(&mut self, from: u64, to: u64) {
        let (count, bytes, _) = self.damage.get_or_insert((0, 0, from));
        *count += 1;
        *bytes += to - from;
    }

    /// What a reader must know to read the file.
    fn flags(&mut self, content: &[u8]) -> Result<()> {
        let mut b = Bytes::new(content, Order::Little);
        b.take(8);
        let flags = b.u64().unwrap_or_default();
        if flags & !1 != 0 {
            return Err(Error::new(format!(
                "is a ULog that must be read otherwise (incompatible flags {flags:#x}), in a way that is not known here"
            ))
            .with_hint("export it as delimited text (CSV): a later `ulog2csv` may do"));
        }
        let places = (0..3).filter_map(|_| b.u64()).filter(|at| *at > 0);
        self.appended = places.filter(|_| flags == 1).collect();
        self.appended.sort_unstable();
        Ok(())
    }

    fn subscribe(&mut self, content: &[u8]) -> Option<()> {
        let mut b = Bytes::new(content, Order::Little);
        let (instance, id, name) = (b.u8()?, b.u16()?, text(b.rest()));
        let same = |t: &Topic| t.name == name && t.instance == instance;
        let topic = self.topics.iter().position(same).unwrap_or_else(|| {
            let topic = Topic::new(&name, instance, &self.definitions);
            self.topics.push(topic);
            self.topics.len() - 1
        });
        self.routes.insert(id, topic);
        Some(())
    }

    fn data(&mut self, content: &[u8]) {
        let topic = content.split_first_chunk::<2>().and_then(|(id, content)| {
            let topic = self.routes.get(&u16::from_le_bytes(*id))?;
            Some((&mut self.topics[*topic], content))
        });
        match topic {
            Some((topic, content)) => topic.message(content),
            None => self.homeless += 1,
        }
    }

    fn contents(self, size: u64) -> Result<Contents> {
        let mut remarks = Vec::new();
        if let Some(at) = self.cut_at {
            remarks.push(Remark::cut(format!(
                "the log ends at byte {size}, inside the message that begins at byte {at}"
            )));
        }
        if let Some((count, bytes, first)) = self.damage {
            remarks.push(Remark::damaged(format!(
                "{bytes} bytes that are no messages, in {count} places, the first at byte {first}"
            )));
        }
        if self.homeless > 0 {
            let what = format!(
                "{} messages of topics that nothing describes",
                self.homeless
            );
            remarks.push(Remark::damaged(what));
        }
        if self.dropouts > 0 {
            remarks.push(Remark::damaged(format!(
                "what the logger could not write in time: {} dropouts, {} ms in all",
                self.dropouts, self.dropped_ms
            )));
        }
        let heard = self.topics.into_iter().filter(|t| t.messages > 0);
        let (mut read, other): (Vec<Topic>, Vec<Topic>) = heard.partition(|t| !t.rows.is_empty());
        let others = listed(&other);
        if read.is_empty() && !other.is_empty() {
            let names: Vec<&str> = TOPICS.iter().map(|t| t.0).collect();
            return Err(Error::new(format!(
                "is a ULog without a topic that is read here; it holds {others}"
            ))
            .with_hint(format!("topics that are read: {}", names.join(", "))));
        }
        read.sort_by_key(|t| (t.read.as_ref().map(|r| r.0), t.instance));
        let streams = read.into_iter();
        let streams = streams.filter_map(|t| t.stream(self.origin, &mut remarks));
        let streams = streams.collect();
        if !other.is_empty() {
            remarks.push(Remark::passed_over(others));
        }
        Ok(Contents { streams, remarks })
    }
}

/// Topics in words.
fn listed(topics: &[Topic]) -> String {
    let mut names: Vec<&str> = topics.iter().map(|t| t.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let more = names.len().saturating_sub(NAMED);
    names.truncate(NAMED);
    match more {
        0 => format!("the topics {}", names.join(", ")),
        _ => format!("the topics {} and {more} more", names.join(", ")),
    }
}

#[cfg(test)]
mod tests;

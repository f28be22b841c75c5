//! Through the elements of an IDE file: what describes the recording is taken in, of samples their place and time codes.

use super::PROPERTIES;
use super::elements::{HEAD, Head, head, unsigned};
use super::properties::Properties;
use crate::Result;
use crate::raw::{Window, bytes_at};
use crate::stream::{Remark, SeekRead};
use std::collections::BTreeMap;

const SESSION: u32 = 0x1853_8067;
const CALIBRATIONS: u32 = 0x4B00;
const SIMPLE_BLOCK: u32 = 0xA0;
const BLOCK: u32 = 0xA1;
const SYNC: u32 = 0xFA;
/// Elements of a block.
const CHANNEL: u32 = 0xB0;
const PAYLOAD: u32 = 0xB2;
/// What stands at a sync, so that reading can go on behind damage.
const SYNC_WORD: &[u8] = b"\xFA\x84ZZZZ";
/// Longest description that is read.
const LONGEST: u64 = 1 << 24;
/// Beyond so many damaged places a file is given up.
const PLACES: u64 = 1000;

/// Samples of one channel that stand together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Block {
    /// Byte of the first sample.
    pub(super) at: u64,
    /// Bytes of samples that the block announces.
    pub(super) announced: u64,
    /// Bytes of them that are there.
    pub(super) bytes: u64,
    /// Time code of the first sample.
    pub(super) start: u64,
    /// Time code of the last sample.
    pub(super) end: Option<u64>,
    /// Time codes of such a block begin again from here on, where the channel does not say it.
    pub(super) modulus: u64,
}

/// What stands in a file.
#[derive(Debug, Default)]
pub(super) struct Scan {
    pub(super) properties: Properties,
    /// By the number of the channel.
    pub(super) blocks: BTreeMap<u64, Vec<Block>>,
    pub(super) remarks: Vec<Remark>,
    size: u64,
    cut: Option<u64>,
    damaged: u64,
    first_damaged: Option<u64>,
}

/// How an element was met.
enum Met {
    /// Whole: the next one stands at this byte.
    Whole(u64),
    /// The file ends inside.
    Cut,
    Damaged,
}

impl Scan {
    pub(super) fn of(file: &mut dyn SeekRead, size: u64) -> Result<Self> {
        let mut scan = Self {
            size,
            ..Self::default()
        };
        let mut window = Window::default();
        let mut at = 0;
        while at < size {
            match scan.element(file, &mut window, at)? {
                Met::Whole(next) => at = next,
                Met::Cut => {
                    scan.cut = Some(at);
                    break;
                }
                Met::Damaged => {
                    scan.damaged += 1;
                    scan.first_damaged.get_or_insert(at);
                    if scan.damaged > PLACES {
                        scan.cut = Some(at);
                        break;
                    }
                    match next_sound(file, at + 1, size)? {
                        Some(next) => at = next,
                        None => break,
                    }
                }
            }
        }
        if let Some(at) = scan.cut {
            let what = match scan.damaged > PLACES {
                true => "is damaged in more than 1000 places, and not read from byte",
                false => "the file ends inside the element at byte",
            };
            scan.remarks.push(Remark::cut(format!("{what} {at}")));
        }
        if let Some(first) = scan.first_damaged {
            let places = scan.damaged;
            scan.remarks.push(Remark::damaged(format!(
                "{places} places that are no element, the first at byte {first}, up to the next block or sync"
            )));
        }
        Ok(scan)
    }

    /// The element at a byte, outside of others.
    fn element(&mut self, file: &mut dyn SeekRead, window: &mut Window, at: u64) -> Result<Met> {
        let Some(head) = self.head(file, window, at)? else {
            return Ok(match self.size - at < HEAD {
                true => Met::Cut,
                false => Met::Damaged,
            });
        };
        let begin = at + head.length;
        if head.id == SESSION {
            return Ok(Met::Whole(begin));
        }
        let known = matches!(
            head.id,
            0x1A45_DFA3 | PROPERTIES | CALIBRATIONS | BLOCK | SIMPLE_BLOCK | SYNC | 0xEC | 0xFC
        ) || head.id > 0x3FFF
            || head.id > 0xFF && head.id < 0x8000;
        let Some(size) = head.size.filter(|_| known) else {
            return Ok(Met::Damaged);
        };
        let end = begin.saturating_add(size);
        match head.id {
            BLOCK => return self.block(file, window, begin, end),
            SIMPLE_BLOCK => self.simple_block(file, window, begin, end)?,
            PROPERTIES | CALIBRATIONS => {
                let content = bytes_at(file, begin, size.min(LONGEST))?;
                self.properties.take(head.id, &content);
            }
            _ => {}
        }
        Ok(match end {
            end if end <= self.size => Met::Whole(end),
            // Nothing but samples and the description is so long that a file ends in it.
            _ if matches!(head.id, BLOCK | SIMPLE_BLOCK | PROPERTIES | CALIBRATIONS)
                || self.size - begin < 4096 =>
            {
                Met::Cut
            }
            _ => Met::Damaged,
        })
    }

    fn head(&self, file: &mut dyn SeekRead, window: &mut Window, at: u64) -> Result<Option<Head>> {
        let length = HEAD.min(self.size - at);
        Ok(head(window.get(file, at, length, 128)?))
    }

    /// A block with elements in it.
    fn block(
        &mut self,
        file: &mut dyn SeekRead,
        window: &mut Window,
        begin: u64,
        end: u64,
    ) -> Result<Met> {
        let (mut channel, mut start, mut last, mut payload) = (None, None, None, None);
        let mut at = begin;
        while at < end && at < self.size {
            let Some(head) = self.head(file, window, at)? else {
                return Ok(match self.size - at < HEAD && end > self.size {
                    true => Met::Cut,
                    false => Met::Damaged,
                });
            };
            let content = at + head.length;
            let Some(size) = head.size else {
                return Ok(Met::Damaged);
            };
            at = content.saturating_add(size);
            // What only stands between blocks, or runs out of this one: its size is not what it was.
            if at > end || matches!(head.id, BLOCK | SIMPLE_BLOCK | SYNC | PROPERTIES | SESSION) {
                return Ok(Met::Damaged);
            }
            if head.id == PAYLOAD {
                payload = Some((content, size));
            } else if size <= 8 && at <= self.size {
                let number = unsigned(window.get(file, content, size, 128)?);
                match head.id {
                    CHANNEL => channel = number,
                    // Shortened by a modulus or not, the codes are the same in kind.
                    0xB8 | 0xBA => start = number,
                    0xB9 | 0xBB => last = number,
                    _ => {}
                }
            }
        }
        if let (Some(channel), Some(start), Some((payload, size))) = (channel, start, payload) {
            let block = Block {
                at: payload,
                announced: size,
                bytes: size.min(self.size.saturating_sub(payload)),
                start,
                end: last,
                modulus: 1 << 24,
            };
            self.blocks.entry(channel).or_default().push(block);
        } else if end <= self.size {
            return Ok(Met::Damaged);
        }
        Ok(match end <= self.size {
            true => Met::Whole(end),
            false => Met::Cut,
        })
    }

    /// A block of the short kind: a time code of 16 bits, the channel and samples.
    fn simple_block(
        &mut self,
        file: &mut dyn SeekRead,
        window: &mut Window,
        begin: u64,
        end: u64,
    ) -> Result<()> {
        if end - begin < 3 || self.size < begin + 3 {
            return Ok(());
        }
        let bytes = window.get(file, begin, 3, 128)?;
        let (start, channel) = (u64::from(bytes[0]) << 8 | u64::from(bytes[1]), bytes[2]);
        let at = begin + 3;
        self.blocks.entry(channel.into()).or_default().push(Block {
            at,
            announced: end - at,
            bytes: end.min(self.size) - at,
            start,
            end: None,
            modulus: 1 << 16,
        });
        Ok(())
    }
}

/// The next byte at which a block or a sync seems to stand.
fn next_sound(file: &mut dyn SeekRead, from: u64, size: u64) -> Result<Option<u64>> {
    const AT_ONCE: u64 = 1 << 16;
    let mut at = from;
    while at < size {
        let bytes = bytes_at(file, at, AT_ONCE + 16)?;
        let found = (0..bytes.len().min(AT_ONCE as usize)).find(|&i| {
            let here = &bytes[i..];
            here.starts_with(SYNC_WORD)
                || head(here).is_some_and(|block| {
                    let inside = here.get(block.length as usize..).unwrap_or_default();
                    block.id == BLOCK
                        && block.size.is_some_and(|s| at + i as u64 + s < size)
                        && head(inside).is_some_and(|channel| {
                            channel.id == CHANNEL && channel.size.is_some_and(|s| s <= 8)
                        })
                })
        });
        if let Some(i) = found {
            return Ok(Some(at + i as u64));
        }
        at += AT_ONCE;
    }
    Ok(None)
}

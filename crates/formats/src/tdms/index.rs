//! The description of a segment: its objects, where their raw data lie, their properties.

use super::Found;
use super::properties::Properties;
use crate::bytes::{Bytes, Order, text};
use crate::raw::{Extent, Kind, Raw};

/// A file, group or channel.
#[derive(Debug, Default)]
pub(super) struct Object {
    pub(super) path: String,
    pub(super) properties: Properties,
    /// Where its raw data lie in the segments that have some of it.
    pub(super) index: Option<RawIndex>,
}

/// Raw data of an object in a chunk.
#[derive(Clone, Debug)]
pub(super) struct RawIndex {
    pub(super) layout: Layout,
    /// Values in a chunk.
    pub(super) values: u64,
    /// Bytes in a chunk, where the width of a value does not tell.
    total: Option<u64>,
}

#[derive(Clone, Debug)]
pub(super) enum Layout {
    Numbers(Kind),
    /// Values of so many bytes that are no numbers.
    Other(u64),
    Text,
    Daqmx {
        scalers: Vec<Scaler>,
        /// Bytes of a sample of each buffer.
        widths: Vec<u64>,
    },
}

/// What one channel takes of a buffer of the converter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaler {
    kind: Kind,
    buffer: usize,
    offset: u64,
    id: u32,
}

impl RawIndex {
    pub(super) fn bytes(&self) -> Option<u64> {
        match self.layout {
            Layout::Numbers(kind) => self.values.checked_mul(kind.size()),
            Layout::Other(width) => self.values.checked_mul(width),
            Layout::Text => self.total,
            Layout::Daqmx { .. } => Some(0),
        }
    }
}

/// Reads descriptions.
pub(super) struct Metadata;

impl Metadata {
    /// Takes in the objects of a segment; nothing where they are damaged.
    pub(super) fn read(bytes: &[u8], order: Order, fresh: bool, found: &mut Found) -> Option<()> {
        let mut b = Bytes::new(bytes, order);
        if fresh {
            for number in std::mem::take(&mut found.active).into_values() {
                found.turns[number] = None;
            }
        }
        let objects = b.u32()?;
        for _ in 0..objects {
            let path = string(&mut b)?;
            let number = found.object(path);
            match b.u32()? {
                // No raw data here.
                u32::MAX => {
                    if let Some(turn) = found.turns[number].take() {
                        found.active.remove(&turn);
                    }
                }
                // As in the segment before.
                0 => found.activate(number),
                length => {
                    let index = raw_index(&mut b, length)?;
                    if let Layout::Other(_) | Layout::Text = index.layout
                        && found.objects[number].index.is_none()
                    {
                        let kind = match index.layout {
                            Layout::Text => "text",
                            _ => "times or complex numbers",
                        };
                        *found.texts.entry(kind.to_owned()).or_default() += 1;
                    }
                    found.objects[number].index = Some(index);
                    found.activate(number);
                }
            }
            let properties = b.u32()?;
            for _ in 0..properties {
                found.objects[number].properties.read(&mut b)?;
            }
        }
        Some(())
    }
}

impl Found {
    fn object(&mut self, path: String) -> usize {
        if let Some(&known) = self.by_path.get(&path) {
            return known;
        }
        let number = self.objects.len();
        self.by_path.insert(path.clone(), number);
        self.objects.push(Object {
            path,
            ..Object::default()
        });
        self.data.push(Vec::new());
        self.turns.push(None);
        number
    }

    fn activate(&mut self, number: usize) {
        if self.turns[number].is_none() {
            self.turns[number] = Some(self.next_turn);
            self.active.insert(self.next_turn, number);
            self.next_turn += 1;
        }
    }
}

pub(super) fn string(b: &mut Bytes<'_>) -> Option<String> {
    let length = b.u32()?;
    Some(text(b.take(length as usize)?))
}

fn raw_index(b: &mut Bytes<'_>, length: u32) -> Option<RawIndex> {
    // Two marks in place of a length tell the data of a converter card.
    let line = match length {
        0x1269 => Some(false),
        // The second as the description of the format prints it; cards write the first.
        0x126A | 0x1369 => Some(true),
        _ => None,
    };
    let code = b.u32()?;
    let dimension = b.u32()?;
    let values = b.u64()?;
    if dimension != 1 {
        return None;
    }
    let Some(line) = line else {
        let layout = layout(code)?;
        let total = match layout {
            Layout::Text => Some(b.u64()?),
            _ => None,
        };
        return Some(RawIndex {
            layout,
            values,
            total,
        });
    };
    let mut scalers = Vec::new();
    for _ in 0..b.u32()? {
        let kind = match b.u32()? {
            0 => Kind::U8,
            1 => Kind::I8,
            2 => Kind::U16,
            3 => Kind::I16,
            4 => Kind::U32,
            5 => Kind::I32,
            _ => return None,
        };
        let buffer = b.u32()? as usize;
        let offset = u64::from(b.u32()?);
        if line {
            b.u8()?;
        } else {
            b.u32()?;
        }
        let id = b.u32()?;
        scalers.push(match line {
            false => Scaler {
                kind,
                buffer,
                offset,
                id,
            },
            // Counted in bits.
            true => Scaler {
                kind: Kind::Bit((offset % 8) as u8),
                buffer,
                offset: offset / 8,
                id,
            },
        });
    }
    let mut widths = Vec::new();
    for _ in 0..b.u32()? {
        widths.push(u64::from(b.u32()?));
    }
    Some(RawIndex {
        layout: Layout::Daqmx { scalers, widths },
        values,
        total: None,
    })
}

fn layout(code: u32) -> Option<Layout> {
    Some(match code {
        1 => Layout::Numbers(Kind::I8),
        2 => Layout::Numbers(Kind::I16),
        3 => Layout::Numbers(Kind::I32),
        4 => Layout::Numbers(Kind::I64),
        5 | 0x21 => Layout::Numbers(Kind::U8),
        6 => Layout::Numbers(Kind::U16),
        7 => Layout::Numbers(Kind::U32),
        8 => Layout::Numbers(Kind::U64),
        9 | 0x19 => Layout::Numbers(Kind::F32),
        10 | 0x1A => Layout::Numbers(Kind::F64),
        0x20 => Layout::Text,
        // Times, complex numbers of two widths.
        0x44 | 0x0010_000D => Layout::Other(16),
        0x0008_000C => Layout::Other(8),
        _ => return None,
    })
}

/// The buffers of a card one after the other, each with a sample of its width for every time; whether the last chunk is whole.
pub(super) fn daqmx(
    layouts: &[(usize, RawIndex)],
    order: Order,
    data: u64,
    there: u64,
    put: &mut dyn FnMut(usize, u32, Raw),
) -> bool {
    let Some((widths, values)) = layouts.iter().find_map(|(_, l)| match &l.layout {
        Layout::Daqmx { widths, .. } => Some((widths.clone(), l.values)),
        _ => None,
    }) else {
        return true;
    };
    let sample: u64 = widths.iter().sum();
    let Some(chunk) = sample.checked_mul(values).filter(|c| *c > 0) else {
        return true;
    };
    let (whole, rest) = (there / chunk, there % chunk);
    // Of a chunk that was cut off the samples of a single buffer are there; those of several are not beside each other.
    let left = match widths[..] {
        [width] if width > 0 => rest / width,
        _ => 0,
    };
    for (object, layout) in layouts {
        let Layout::Daqmx { scalers, .. } = &layout.layout else {
            continue;
        };
        for scaler in scalers {
            let Some(&width) = widths.get(scaler.buffer) else {
                continue;
            };
            if scaler.offset + scaler.kind.size() > width {
                continue;
            }
            let before: u64 = widths[..scaler.buffer].iter().sum::<u64>() * values;
            let at = data + before + scaler.offset;
            let mut raw = Raw::new(scaler.kind, order);
            raw.push(Extent {
                at,
                stride: width,
                count: values,
                chunks: whole,
                step: chunk,
            });
            raw.push(Extent {
                at: at + whole * chunk,
                stride: width,
                count: left,
                chunks: 1,
                step: 0,
            });
            put(*object, scaler.id, raw);
        }
    }
    rest == 0
}

impl Object {
    /// Group and channel of the path `/'group'/'channel'`, in which a quote stands twice.
    pub(super) fn names(&self) -> Option<(String, String)> {
        let mut names = Vec::new();
        let mut rest = self.path.as_str();
        while let Some(inside) = rest.strip_prefix("/'") {
            let mut name = String::new();
            let mut letters = inside.char_indices().peekable();
            let mut end = inside.len();
            while let Some((at, letter)) = letters.next() {
                if letter == '\'' {
                    if letters.peek().is_some_and(|(_, next)| *next == '\'') {
                        letters.next();
                    } else {
                        end = at + 1;
                        break;
                    }
                }
                name.push(letter);
            }
            names.push(name);
            rest = &inside[end..];
        }
        let [group, channel] = <[String; 2]>::try_from(names).ok()?;
        Some((group, channel))
    }
}

/// Path of a group.
pub(super) fn group_path(group: &str) -> String {
    format!("/'{}'", group.replace('\'', "''"))
}

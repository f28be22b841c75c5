//! CWA of Axivity loggers (AX3, AX6): blocks of 512 bytes, each with a time and a check sum.
//!
//! **Source** `[CWA]`.

use crate::bytes::{Bytes, Order};
use crate::calendar::days;
use crate::raw::{Kind, Raw, filled};
use crate::scaling::Scaling;
use crate::stream::{Clock, Column, Contents, Line, Remark, SeekRead, Source, Stream};
use crate::{Error, Result};
use std::io::SeekFrom;

const HEADER: u64 = 1024;
const BLOCK: u64 = 512;
/// Blocks that are fetched at once.
const AT_ONCE: u64 = 1024;

/// What a block says.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Block {
    form: Form,
    /// Time of the first sample, s.
    time: f64,
    sequence: u32,
    count: u64,
    /// Nominal, Hz.
    rate: f64,
    temperature: f64,
}

/// How the samples of a block are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Form {
    axes: u8,
    packed: bool,
    scale: u8,
    gyroscope: u8,
}

impl Form {
    fn width(self) -> u64 {
        if self.packed {
            4
        } else {
            2 * u64::from(self.axes)
        }
    }
}

impl Block {
    /// Nothing where the block is damaged.
    fn of(bytes: &[u8]) -> Option<Self> {
        let words = bytes.as_chunks::<2>().0;
        let sum = words
            .iter()
            .fold(0_u16, |sum, w| sum.wrapping_add(u16::from_le_bytes(*w)));
        let mut b = Bytes::new(bytes, Order::Little);
        if b.take(2)? != b"AX" || b.u16()? != 508 || bytes.len() as u64 != BLOCK {
            return None;
        }
        let fraction = b.u16()?;
        b.u32();
        let (sequence, stamp, light, temperature) = (b.u32()?, b.u32()?, b.u16()?, b.u16()?);
        b.u16();
        let (code, form) = (b.u8()?, b.u8()?);
        let (offset, count) = (b.i16()?, u64::from(b.u16()?));
        // Very old files have neither a code nor a check sum.
        let (rate, offset) = match code {
            0 => (f64::from(offset), 0),
            code => (
                3200.0 / f64::from(1_u32 << (15 - u32::from(code & 15))),
                offset,
            ),
        };
        let form = Form {
            axes: form >> 4,
            packed: form & 15 == 0,
            scale: (light >> 13) as u8,
            gyroscope: (light >> 10 & 7) as u8,
        };
        let known = matches!((form.axes, form.packed), (3, _) | (6, false));
        let fits = count > 0 && count * form.width() <= 480;
        if !known || !fits || !rate.is_finite() || rate < 1.0 || (code != 0 && sum != 0) {
            return None;
        }
        let whole = seconds(stamp)?;
        let (part, shift) = match fraction & 0x8000 {
            0 => (0.0, f64::from(offset)),
            _ => {
                let part = 2 * i64::from(fraction & 0x7FFF);
                let late = (part * rate.floor() as i64) >> 16;
                (part as f64 / 65_536.0, f64::from(offset) + late as f64)
            }
        };
        Some(Self {
            form,
            time: whole + part - shift / rate,
            sequence,
            count,
            rate,
            temperature: f64::from(temperature & 0x3FF) * 75.0 / 256.0 - 50.0,
        })
    }

    /// Whether another block goes on where this one ends: the next number, and a time within a tenth of its length.
    fn goes_on(&self, next: &Self) -> bool {
        let length = self.count as f64 / self.rate;
        let step = next.time - self.time;
        next.sequence == self.sequence.wrapping_add(1) && (step - length).abs() < 0.1 * length
    }
}

/// Seconds from the year 2000 of a packed date and time.
fn seconds(stamp: u32) -> Option<f64> {
    let part = |shift: u32, bits: u32| i64::from(stamp >> shift & ((1 << bits) - 1));
    let (year, month, day) = (part(26, 6), part(22, 4), part(17, 5));
    if !(1..=12).contains(&month) || day == 0 {
        return None;
    }
    let days = days(2000 + year, month, day) - days(2000, 1, 1);
    Some(((days * 24 + part(12, 5)) * 3600 + part(6, 6) * 60 + part(0, 6)) as f64)
}

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let mut found = Found::default();
    let mut at = HEADER;
    let mut bytes = vec![0; size.min(AT_ONCE * BLOCK) as usize];
    file.seek(SeekFrom::Start(at))?;
    while at < size {
        let there = filled(file, &mut bytes)?;
        for (i, block) in bytes[..there].chunks(BLOCK as usize).enumerate() {
            found.block(block, at + i as u64 * BLOCK);
        }
        at += AT_ONCE * BLOCK;
    }
    found.contents(size)
}

#[derive(Default)]
struct Found {
    form: Option<Form>,
    raws: Vec<Raw>,
    times: Vec<Line>,
    temperatures: Vec<Line>,
    /// The last good block.
    last: Option<Block>,
    first_time: f64,
    damaged: u64,
    first_damaged: Option<u64>,
    cut: bool,
}

impl Found {
    fn block(&mut self, bytes: &[u8], at: u64) {
        if (bytes.len() as u64) < BLOCK {
            self.cut = true;
            return;
        }
        let read = Block::of(bytes).filter(|b| self.form.is_none_or(|f| f == b.form));
        let Some(block) = read else {
            // What was never written is no damage.
            if bytes.iter().any(|b| *b != 0xFF) && bytes.iter().any(|b| *b != 0) {
                self.damaged += 1;
                self.first_damaged.get_or_insert(at);
            }
            return;
        };
        let axes = match block.form.packed {
            true => 3,
            false => usize::from(block.form.axes),
        };
        if self.form.is_none() {
            self.form = Some(block.form);
            self.first_time = block.time;
            let kind = |i: usize| match block.form.packed {
                true => Kind::Packed(i as u8),
                false => Kind::I16,
            };
            self.raws = (0..axes)
                .map(|i| Raw::new(kind(i), Order::Little))
                .collect();
        }
        let width = block.form.width();
        for (i, raw) in self.raws.iter_mut().enumerate() {
            let offset = if block.form.packed { 0 } else { 2 * i as u64 };
            raw.push_block(at + 30 + offset, width, block.count, BLOCK);
        }
        // The samples of a block lie evenly up to the time of the next one.
        if let (Some(last), Some(line)) = (self.last, self.times.last_mut())
            && last.goes_on(&block)
        {
            line.step = (block.time - last.time) / last.count as f64;
        }
        let step = match (self.last, self.times.last()) {
            (Some(last), Some(line)) if last.rate == block.rate => line.step,
            _ => 1.0 / block.rate,
        };
        self.times.push(Line {
            count: block.count,
            first: block.time - self.first_time,
            step,
        });
        self.temperatures.push(Line {
            count: block.count,
            first: block.temperature,
            step: 0.0,
        });
        self.last = Some(block);
    }

    fn contents(self, size: u64) -> Result<Contents> {
        let mut remarks = Vec::new();
        if self.cut {
            remarks.push(Remark::cut(format!(
                "the last block ends at byte {size}, inside"
            )));
        }
        if let Some(first) = self.first_damaged {
            let count = self.damaged;
            remarks.push(Remark::damaged(format!(
                "{count} blocks of 512 bytes, the first at byte {first}"
            )));
        }
        let Some(form) = self.form else {
            return Err(
                Error::new("is a recording of an Axivity logger without a whole block")
                    .with_hint("fetch the file again from the logger"),
            );
        };
        let rows = self.times.iter().map(|l| l.count).sum();
        let mut stream = Stream::new("samples", Clock::Times, rows);
        let since_1970 = days(2000, 1, 1) as f64 * 86_400.0 + self.first_time;
        stream.origin_ns = Some((since_1970 * 1e9) as i64);
        let acceleration = match form.packed {
            true => 1.0 / 256.0,
            false => 2_f64.powi(-8 - i32::from(form.scale)),
        };
        let rotation = 8000.0 / 2_f64.powi(i32::from(form.gyroscope)) / 32_768.0;
        let several = self.raws.len() > 3;
        for (i, raw) in self.raws.into_iter().enumerate() {
            let (name, unit, slope) = match several && i < 3 {
                true => ("gyro", "deg/s", rotation),
                false => ("acc", "g", acceleration),
            };
            let name = format!("{name}_{}", ["x", "y", "z"][i % 3]);
            let column = Column::scaled(Source::Raw(raw), Scaling::linear(slope, 0.0));
            stream.push(name, Some(unit.to_owned()), column);
        }
        let temperatures = Column::of(Source::lines(self.temperatures));
        stream.push("temperature", Some("°C".to_owned()), temperatures);
        stream.push_times(Source::lines(self.times));
        Ok(Contents {
            streams: vec![stream],
            remarks,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::RemarkKind;
    use crate::stream::tests::{columns, open, survives};

    /// A block of packed samples at 100 Hz, 1 s after the one before.
    fn block(sequence: u32, second: u32, words: &[u32]) -> Vec<u8> {
        let mut b = b"AX\xFC\x01".to_vec();
        b.extend([0_u16.to_le_bytes(), [0; 2], [0; 2]].concat());
        b.extend(sequence.to_le_bytes());
        b.extend((26_u32 << 26 | 3 << 22 | 1 << 17 | 10 << 12 | second).to_le_bytes());
        b.extend([0, 0, 0x0A, 0x01, 0, 0, 0x4A, 0x30, 0, 0]);
        b.extend((words.len() as u16).to_le_bytes());
        b.extend(words.iter().flat_map(|w| w.to_le_bytes()));
        b.resize(510, 0);
        let sum = b
            .as_chunks::<2>()
            .0
            .iter()
            .fold(0_u16, |s, w| s.wrapping_add(u16::from_le_bytes(*w)));
        b.extend(sum.wrapping_neg().to_le_bytes());
        b
    }

    #[test]
    fn known_blocks_and_a_damaged_one() {
        // (84, 252, 52)/256 g, shifted by two bits: the example of the layout.
        let words = [0x80D0_FC15; 100];
        let mut header = b"MD\xFC\x03".to_vec();
        header.resize(1024, 0xFF);
        let mut file = header;
        for i in 0..4 {
            file.extend(block(i, i, &words));
        }
        let container = open(&file).unwrap();
        assert!(container.remarks().is_empty());
        let all = columns(container, 0);
        assert_eq!(all.len(), 5);
        assert_eq!(
            [all[0][0], all[1][0], all[2][399]],
            [84.0 / 256.0, 252.0 / 256.0, 52.0 / 256.0]
        );
        assert!((all[3][0] - (266.0 * 75.0 / 256.0 - 50.0)).abs() < 1e-12);
        assert!((all[4][399] - 3.99).abs() < 1e-9 && all[4][100] == 1.0);
        // A byte of the second block is not what it was: its second is a gap.
        file[1024 + 512 + 100] ^= 1;
        let container = open(&file).unwrap();
        assert_eq!(container.remarks()[0].kind, RemarkKind::Damaged);
        let all = columns(container, 0);
        assert_eq!((all[4].len(), all[4][100]), (300, 2.0));
        survives(&file[..1024 + 600]);
    }
}

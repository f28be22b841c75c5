//! gt3x of ActiGraph: a ZIP archive of a text about the recording and of its records.
//!
//! **Source** `[GT3X]`.

use crate::bytes::{Bytes, Order, text};
use crate::held_rows::HeldRows;
use crate::names::shown;
use crate::raw::Kind;
use crate::scaling::Scaling;
use crate::stream::{Clock, Column, Contents, Line, Remark, SeekRead, Source, Stream};
use crate::zip::Member;
use crate::{Error, Result};
use std::sync::Arc;

/// Begins a record.
const MARK: u8 = 0x1E;
/// Bytes of a sample as it is held.
const ROW: usize = 6;

pub(crate) fn read(
    file: &mut dyn SeekRead,
    info: &Member,
    data: &Member,
    left: &mut u64,
) -> Result<Contents> {
    let (info, _) = info.content(file, left)?;
    let info = text(&info);
    let (content, whole) = data.content(file, left)?;
    let mut remarks = Vec::new();
    if !whole {
        remarks.push(Remark::cut(format!(
            "{} is shorter than the archive says, or damaged",
            data.name
        )));
    }
    let number = |key: &str| value(&info, key)?.replace(',', ".").parse::<f64>().ok();
    let rate = number("Sample Rate").filter(|r| *r >= 1.0 && r.is_finite());
    let rate =
        rate.ok_or_else(|| Error::new("info.txt of the gt3x file does not say the sample rate"))?;
    let old = data.name == "activity.bin";
    let kind = value(&info, "Serial Number").unwrap_or_default();
    let usual = match old || kind.starts_with("NEO") || kind.starts_with("CLE") {
        true => 341.0,
        false => 256.0,
    };
    let scale = number("Acceleration Scale").filter(|s| *s > 1.0 && s.is_finite());
    if let (None, Some(said)) = (scale, value(&info, "Acceleration Scale")) {
        remarks.push(Remark::damaged(format!(
            "the scale that info.txt says, \"{}\", is not a number above zero: that of the device is taken, {usual} for 1 g",
            shown(said)
        )));
    }
    let per_g = scale.unwrap_or(usual);
    let mut axes = Axes::default();
    let clock = match old {
        true => {
            axes.packed(&content);
            let zeros = axes.without_zeros();
            if zeros > 0 {
                remarks.push(Remark::passed_over(format!(
                    "{zeros} rows of zeros at the end, which fill the memory page"
                )));
            }
            Clock::Rate {
                hz: rate,
                start_s: 0.0,
            }
        }
        false => {
            let damaged = axes.records(&content, rate);
            if let Some((count, first)) = damaged {
                remarks.push(Remark::damaged(format!(
                    "{count} places of log.bin that are no record whose check sum holds, the first at byte {first} of it"
                )));
            }
            axes.clock(rate)
        }
    };
    let rows = Arc::new(axes.rows);
    let mut stream = Stream::new("activity", clock, (rows.len() / ROW) as u64);
    stream.origin_ns = axes.begin.map(|begin| i64::from(begin) * 1_000_000_000);
    for (i, name) in ["acc_x", "acc_y", "acc_z"].into_iter().enumerate() {
        let values = Source::HeldRows(HeldRows::new(&rows, ROW, 2 * i, Kind::I16));
        let column = Column::scaled(values, Scaling::linear(1.0 / per_g, 0.0));
        stream.push(name, Some("g".to_owned()), column);
    }
    if clock == Clock::Times {
        stream.push_times(Source::lines(axes.times));
    }
    Ok(Contents {
        streams: vec![stream],
        remarks,
    })
}

/// The value of a key; persons and places are not looked for.
fn value<'a>(info: &'a str, key: &str) -> Option<&'a str> {
    info.lines().find_map(|line| {
        let (name, value) = line.split_once(':')?;
        (name.trim() == key).then(|| value.trim())
    })
}

#[derive(Default)]
struct Axes {
    /// x, y and z of each sample, two bytes each.
    rows: Vec<u8>,
    times: Vec<Line>,
    /// Seconds of the first record by the clock of the logger.
    begin: Option<u32>,
}

impl Axes {
    fn push(&mut self, xyz: [i16; 3]) {
        self.rows.extend(xyz.iter().flat_map(|v| v.to_le_bytes()));
    }

    /// Cuts off rows of zeros at the end, which no sensor gives on three axes; how many.
    fn without_zeros(&mut self) -> usize {
        let last = self.rows.iter().rposition(|b| *b != 0);
        let kept = last.map_or(0, |last| last / ROW + 1);
        let rows = self.rows.len() / ROW;
        self.rows.truncate(kept * ROW);
        rows - kept
    }

    /// Seconds that follow one another, each with as many samples as the rate says, tell nothing of the clock beside that rate.
    fn clock(&self, rate: f64) -> Clock {
        let on = |pair: &[Line]| pair[1].first - pair[0].first == 1.0;
        let even = self.times.windows(2).all(on)
            && self.times.iter().all(|second| second.count as f64 == rate);
        match even {
            true => Clock::Rate {
                hz: rate,
                start_s: 0.0,
            },
            false => Clock::Times,
        }
    }

    /// Samples of 36 bits: y, x, z of 12 bits, the most significant first.
    fn packed(&mut self, bytes: &[u8]) -> u64 {
        let nibble = |i: usize| i16::from(bytes[i / 2] >> (4 * (1 - i % 2)) & 15);
        let twelve = |i: usize| ((nibble(i) << 8 | nibble(i + 1) << 4 | nibble(i + 2)) << 4) >> 4;
        let samples = 2 * bytes.len() / 9;
        for i in 0..samples {
            let at = 9 * i;
            self.push([twelve(at + 3), twelve(at), twelve(at + 6)]);
        }
        samples as u64
    }

    /// Takes in records; how many are damaged, and where the first one begins.
    fn records(&mut self, bytes: &[u8], rate: f64) -> Option<(u64, usize)> {
        let sums = sums(bytes);
        let mut damaged: Option<(u64, usize)> = None;
        let mut last: Option<u32> = None;
        let mut at = 0;
        while at < bytes.len() {
            if bytes[at] != MARK {
                at += 1;
                continue;
            }
            let Some((kind, time, payload)) = record(bytes, at, &sums) else {
                damaged.get_or_insert((0, at)).0 += 1;
                at += 1;
                continue;
            };
            at += 9 + payload.len();
            // A record of one byte is an event.
            if !matches!(kind, 0 | 26) || payload.len() < 2 {
                continue;
            }
            let count = match kind {
                0 => self.packed(payload),
                _ => {
                    let count = payload.len() / ROW;
                    self.rows.extend_from_slice(&payload[..count * ROW]);
                    count as u64
                }
            };
            if count == 0 {
                continue;
            }
            // A second holds as many samples as its record, where the next one begins with the next second.
            if let (Some(before), Some(line)) = (last, self.times.last_mut())
                && time == before.wrapping_add(1)
            {
                line.step = 1.0 / line.count as f64;
            }
            let begin = *self.begin.get_or_insert(time);
            self.times.push(Line {
                count,
                first: f64::from(time) - f64::from(begin),
                step: 1.0 / rate,
            });
            last = Some(time);
        }
        damaged
    }
}

/// The check sums of the bytes before each byte, and of all: a record need not be gone through to be tried.
fn sums(bytes: &[u8]) -> Vec<u8> {
    let mut sums = vec![0; bytes.len() + 1];
    let mut sum = 0;
    for (to, byte) in sums[1..].iter_mut().zip(bytes) {
        sum ^= byte;
        *to = sum;
    }
    sums
}

/// Kind, time and content of the record that begins at a byte; nothing where its check sum does not hold.
fn record<'a>(bytes: &'a [u8], at: usize, sums: &[u8]) -> Option<(u8, u32, &'a [u8])> {
    let mut b = Bytes::new(&bytes[at..], Order::Little);
    b.u8()?;
    let (kind, time, length) = (b.u8()?, b.u32()?, b.u16()?);
    let payload = b.take(usize::from(length))?;
    let sum = sums[at] ^ sums[at + 8 + payload.len()];
    (b.u8()? == !sum).then_some((kind, time, payload))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RemarkKind;
    use crate::stream::tests::{columns, open, survives};
    use flate2::Compression;
    use flate2::Crc;
    use flate2::write::DeflateEncoder;
    use std::io::Write;

    /// An archive of deflated members.
    fn archive(members: &[(&str, &[u8])]) -> Vec<u8> {
        let (mut all, mut directory) = (Vec::new(), Vec::new());
        for (name, content) in members {
            let mut packed = DeflateEncoder::new(Vec::new(), Compression::default());
            packed.write_all(content).unwrap();
            let packed = packed.finish().unwrap();
            let mut crc = Crc::new();
            crc.update(content);
            let common = [
                &[20, 0, 0, 0, 8, 0, 0, 0, 0, 0][..],
                &crc.sum().to_le_bytes(),
                &(packed.len() as u32).to_le_bytes(),
                &(content.len() as u32).to_le_bytes(),
                &(name.len() as u16).to_le_bytes(),
                &[0, 0],
            ]
            .concat();
            let at = (all.len() as u32).to_le_bytes();
            directory.extend(
                [
                    &b"PK\x01\x02\x14\0"[..],
                    &common,
                    &[0; 10],
                    &at,
                    name.as_bytes(),
                ]
                .concat(),
            );
            all.extend([&b"PK\x03\x04"[..], &common, name.as_bytes(), &packed].concat());
        }
        let (at, length) = (all.len() as u32, directory.len() as u32);
        let count = (members.len() as u16).to_le_bytes();
        let end = [
            &b"PK\x05\x06\0\0\0\0"[..],
            &count,
            &count,
            &length.to_le_bytes(),
            &at.to_le_bytes(),
            &[0, 0],
        ];
        [all, directory, end.concat()].concat()
    }

    fn record(kind: u8, time: u32, payload: &[u8]) -> Vec<u8> {
        let mut r = vec![MARK, kind];
        r.extend(time.to_le_bytes());
        r.extend((payload.len() as u16).to_le_bytes());
        r.extend(payload);
        r.push(!r.iter().fold(0, |sum, v| sum ^ v));
        r
    }

    #[test]
    fn known_records_gaps_and_damage() {
        let info = b"Serial Number: MOS2D\r\nSample Rate: 2\r\nAcceleration Scale: 256,0\r\nSubject Name: nobody\r\n";
        let two = |v: i16| {
            [v, 0, 256, v, 0, -256]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect::<Vec<u8>>()
        };
        // Packed samples of the published example: y, x, z = (6, 8, -323), (7, 9, -321).
        let packed = [0x00, 0x60, 0x08, 0xEB, 0xD0, 0x07, 0x00, 0x9E, 0xBF];
        let log = [
            record(26, 100, &two(128)),
            record(6, 100, b"text"),
            record(26, 101, &two(64)),
            vec![0, 0],
            record(0, 110, &packed),
            record(0, 111, &[8]),
        ];
        let file = archive(&[("info.txt", info), ("log.bin", &log.concat())]);
        let container = open(&file).unwrap();
        assert!(container.remarks().is_empty());
        let all = columns(container, 0);
        assert_eq!(all[0], [0.5, 0.5, 0.25, 0.25, 8.0 / 256.0, 9.0 / 256.0]);
        assert_eq!(all[1][4..], [6.0 / 256.0, 7.0 / 256.0]);
        assert_eq!(all[2][4..], [-323.0 / 256.0, -321.0 / 256.0]);
        assert_eq!(all[3], [0.0, 0.5, 1.0, 1.5, 10.0, 10.5]);
        survives(&file);
        let mut broken = log.concat();
        broken[10] ^= 1;
        let container = open(&archive(&[("info.txt", info), ("log.bin", &broken)])).unwrap();
        let remark = &container.remarks()[0];
        assert_eq!(remark.kind, RemarkKind::Damaged);
        assert!(
            remark.text.contains("the first at byte 0 of it"),
            "{}",
            remark.text
        );
        let all = columns(container, 0);
        assert_eq!(all[0], [0.25, 0.25, 8.0 / 256.0, 9.0 / 256.0]);
        assert_eq!(all[3], [0.0, 0.5, 9.0, 9.5]);
        // Two seconds of two samples each: the rate is the one that is stated, and no times beside it.
        let even = [record(26, 100, &two(128)), record(26, 101, &two(64))].concat();
        let even = open(&archive(&[("info.txt", info), ("log.bin", &even)])).unwrap();
        let stated = Clock::Rate {
            hz: 2.0,
            start_s: 0.0,
        };
        let stream = &even.streams()[0];
        assert_eq!((stream.clock, stream.channels.len()), (stated, 3));
        let old = open(&archive(&[("info.txt", info), ("activity.bin", &packed)])).unwrap();
        assert_eq!(old.streams()[0].clock, stated);
        let other = open(&archive(&[("letter.txt", b"x")])).map(|_| ());
        assert!(other.is_err_and(|e| e.to_string().contains("none of them is a recording")));
    }

    #[test]
    fn known_arrays_of_numpy_in_an_archive() {
        let header = b"{'descr': '<i2', 'fortran_order': False, 'shape': (2,), }\n";
        let npy = [
            b"\x93NUMPY\x01\0",
            &(header.len() as u16).to_le_bytes()[..],
            header,
            &[1, 0, 2, 0],
        ]
        .concat();
        let container = open(&archive(&[("a.npy", &npy), ("b.npy", &npy)])).unwrap();
        assert_eq!(container.streams()[0].channels[1].name, "b");
        assert_eq!(columns(container, 0), [[1.0, 2.0], [1.0, 2.0]]);
    }
}

//! MAT, the files of MATLAB: level 4, and level 5 with compressed variables and fields of structures.
//!
//! **Source** `[MATFILE]`.

mod level4;

use crate::arrays::{Array, Arrays, Part, Stored};
use crate::bytes::{Bytes, Order, text};
use crate::names::{shown, unpacked_bytes};
use crate::raw::{Kind, bytes_at};
use crate::stream::{Contents, Remark, SeekRead};
use crate::{Error, Result};
use flate2::read::ZlibDecoder;
use std::io::Read;

pub(crate) use level4::{is_level4, read as read_level4};

/// Structures within structures.
const DEEPEST: usize = 16;
const HEADER: u64 = 128;
/// Bytes of a variable in which its sides and its name are looked for.
const HEAD: u64 = 4096;

pub(crate) fn is_level5(head: &[u8]) -> bool {
    order(head).is_some() && matches!(head.get(124..126), Some([0, 1] | [1, 0]))
}

fn order(head: &[u8]) -> Option<Order> {
    match head.get(126..128) {
        Some(b"IM") => Some(Order::Little),
        Some(b"MI") => Some(Order::Big),
        _ => None,
    }
}

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let head = bytes_at(file, 0, HEADER)?;
    let order = order(&head).ok_or_else(|| Error::new("is no MAT file"))?;
    let mut arrays = Arrays::default();
    let (mut at, mut left) = (HEADER, unpacked_bytes(size));
    let mut damaged = (0_u64, HEADER);
    while at + 8 <= size {
        let tag = bytes_at(file, at, 8)?;
        let mut tag = Bytes::new(&tag, order);
        let (kind, length) = (tag.u32().unwrap_or(0), u64::from(tag.u32().unwrap_or(0)));
        let is_cut = size - at - 8 < length;
        if is_cut {
            arrays.remarks.push(Remark::cut(format!(
                "the variable at byte {at} is longer than the file of {size} bytes"
            )));
        }
        let end = size.min(at.saturating_add(8).saturating_add(length));
        let plain = match kind {
            14 => plain(
                &bytes_at(file, at + 8, HEAD.min(end - at - 8))?,
                at + 8,
                end,
                order,
            ),
            _ => None,
        };
        let bytes = match plain {
            None => bytes_at(file, at + 8, length)?,
            Some(_) => Vec::new(),
        };
        let taken = match kind {
            14 if plain.is_some() => plain.map(|array| arrays.put(&array)),
            14 => matrix(Bytes::new(&bytes, order), "", 0, &mut arrays),
            15 => match unpacked(&bytes, is_cut, &mut left) {
                Unpacked::TooLong => {
                    arrays.remarks.push(Remark::passed_over(format!(
                        "the variable at byte {at}, which unpacks to more than a file of this size may: save it without compression"
                    )));
                    Some(())
                }
                Unpacked::Whole(bytes) => {
                    let mut b = Bytes::new(&bytes, order);
                    let element = element(&mut b);
                    element
                        .filter(|(kind, _)| *kind == 14)
                        .and_then(|(_, inner)| matrix(inner, "", 0, &mut arrays))
                }
                Unpacked::Damaged => None,
            },
            _ => None,
        };
        if taken.is_none() && !is_cut {
            if damaged.0 == 0 {
                damaged.1 = at;
            }
            damaged.0 += 1;
        }
        // Compressed variables follow one another without a gap.
        at += 8 + length;
        if kind != 15 {
            at = at.next_multiple_of(8);
        }
    }
    if at < size {
        arrays.remarks.push(Remark::cut(format!(
            "the file ends inside the head of the variable at byte {at}"
        )));
    }
    match damaged {
        (0, _) => {}
        (1, at) => arrays.remarks.push(Remark::damaged(format!(
            "the variable at byte {at} cannot be unpacked or read"
        ))),
        (count, at) => arrays.remarks.push(Remark::damaged(format!(
            "{count} variables, the first at byte {at}, cannot be unpacked or read"
        ))),
    }
    Ok(arrays.contents())
}

/// A matrix of real numbers, which are left in the file, by the bytes that it begins with; nothing where it is something else.
fn plain(head: &[u8], at: u64, end: u64, order: Order) -> Option<Array> {
    let mut b = Bytes::new(head, order);
    let flags = element(&mut b)?.1.u32()?;
    let mut sizes = element(&mut b)?.1;
    let sides = (sizes.i32()?, sizes.i32()?);
    let (_, name) = element(&mut b)?;
    let (tag, length) = (b.u32()?, b.u32()?);
    if !(6..=15).contains(&(flags & 0xFF)) || flags & 0x800 != 0 || !sizes.rest().is_empty() {
        return None;
    }
    let kind = kind(tag)?;
    let begin = at + (head.len() - b.rest().len()) as u64;
    let end = end.min(begin + u64::from(length));
    Some(Array {
        name: shown(&text(name.rest())),
        rows: usize::try_from(sides.0).ok()?,
        columns: usize::try_from(sides.1).ok()?,
        by_rows: false,
        real: Part {
            bytes: Stored::UpTo(end as usize),
            at: begin as usize,
            width: kind.size() as usize,
            kind,
            order,
        },
        imaginary: None,
    })
}

/// A compressed variable.
enum Unpacked {
    /// Its check sum holds, or what stands before a cut.
    Whole(Vec<u8>),
    /// It unpacks to more bytes than are left to the file.
    TooLong,
    Damaged,
}

fn unpacked(bytes: &[u8], is_cut: bool, left: &mut u64) -> Unpacked {
    let mut unpacked = Vec::new();
    let mut reader = ZlibDecoder::new(bytes).take(*left + 1);
    let done = reader.read_to_end(&mut unpacked);
    match left.checked_sub(unpacked.len() as u64) {
        None => Unpacked::TooLong,
        Some(_) if done.is_err() && !is_cut => Unpacked::Damaged,
        Some(rest) => {
            *left = rest;
            Unpacked::Whole(unpacked)
        }
    }
}

/// Kind and content of the next element, small or not.
fn element<'a>(b: &mut Bytes<'a>) -> Option<(u32, Bytes<'a>)> {
    let tag = b.u32()?;
    if tag >> 16 != 0 {
        let four = b.take(4)?;
        return Some((
            tag & 0xFFFF,
            Bytes::new(four.get(..(tag >> 16) as usize)?, b.order),
        ));
    }
    let length = b.u32()? as usize;
    // Of the last one of a variable that is cut, what is there.
    let content = b.take(length.min(b.rest().len()))?;
    b.take(length.next_multiple_of(8) - length)
        .unwrap_or_default();
    Some((tag, Bytes::new(content, b.order)))
}

/// Takes in a variable or a field; nothing where it is damaged.
fn matrix(mut b: Bytes<'_>, outside: &str, depth: usize, arrays: &mut Arrays) -> Option<()> {
    if b.rest().is_empty() {
        // An empty field.
        return Some(());
    }
    let (_, mut flags) = element(&mut b)?;
    let flags = flags.u32()?;
    let (_, mut sizes) = element(&mut b)?;
    let mut dimensions = Vec::new();
    while let Some(size) = sizes.i32() {
        dimensions.push(usize::try_from(size).ok()?);
    }
    let (_, name) = element(&mut b)?;
    let own = shown(&text(name.rest()));
    let name = match (outside.is_empty(), own.is_empty()) {
        (true, _) => own,
        (false, true) => outside.to_owned(),
        (false, false) => format!("{outside}.{own}"),
    };
    match flags & 0xFF {
        2 if depth < DEEPEST => fields(b, &name, &dimensions, depth, arrays),
        6..=15 => {
            let real = part(&mut b)?;
            let imaginary = match flags & 0x800 {
                0 => None,
                _ => Some(part(&mut b).unwrap_or_else(|| Part::of(Vec::new(), Kind::F64, b.order))),
            };
            match dimensions[..] {
                [rows, columns] => arrays.put(&Array {
                    name,
                    rows,
                    columns,
                    by_rows: false,
                    real,
                    imaginary,
                }),
                _ => arrays.remarks.push(Remark::passed_over(format!(
                    "{name}, an array of {} dimensions",
                    dimensions.len()
                ))),
            }
            Some(())
        }
        kind => {
            let what = match kind {
                1 => "cells",
                2 => "structures within structures",
                3 | 16 | 17 => "an object",
                // Texts are no samples, and may say who measured.
                4 => return Some(()),
                5 => "a sparse matrix",
                _ => "of an unknown kind",
            };
            arrays
                .remarks
                .push(Remark::passed_over(format!("{name}, {what}")));
            Some(())
        }
    }
}

/// The numbers of an element, which may be stored shorter than they are.
fn part(b: &mut Bytes<'_>) -> Option<Part> {
    let (tag, content) = element(b)?;
    let kind = kind(tag)?;
    Some(Part::of(content.rest().to_vec(), kind, content.order))
}

/// How the numbers of an element are stored, by its tag; nothing where it holds none, or is small.
fn kind(tag: u32) -> Option<Kind> {
    Some(match tag {
        1 => Kind::I8,
        2 => Kind::U8,
        3 => Kind::I16,
        4 => Kind::U16,
        5 => Kind::I32,
        6 => Kind::U32,
        7 => Kind::F32,
        9 => Kind::F64,
        12 => Kind::I64,
        13 => Kind::U64,
        _ => return None,
    })
}

/// The fields of a structure, of each of its elements.
fn fields(
    mut b: Bytes<'_>,
    name: &str,
    dimensions: &[usize],
    depth: usize,
    arrays: &mut Arrays,
) -> Option<()> {
    let (_, mut length) = element(&mut b)?;
    let length = usize::try_from(length.i32()?).ok().filter(|l| *l > 0)?;
    let (_, names) = element(&mut b)?;
    let names: Vec<String> = names
        .rest()
        .chunks(length)
        .map(|n| shown(&text(n.split(|b| *b == 0).next().unwrap_or_default())))
        .collect();
    if names.is_empty() {
        return Some(());
    }
    let several = dimensions.iter().any(|side| *side != 1);
    let mut number = 0;
    while let Some((kind, content)) = element(&mut b) {
        let (one, field) = (number / names.len(), &names[number % names.len()]);
        let place = match several {
            true => format!("{name}({}).{field}", one + 1),
            false => format!("{name}.{field}"),
        };
        if kind != 14 {
            return None;
        }
        matrix(content, &place, depth + 1, arrays)?;
        number += 1;
    }
    Some(())
}

#[cfg(test)]
mod tests;

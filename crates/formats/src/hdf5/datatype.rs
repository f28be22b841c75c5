//! Datatypes: which numbers stand where in an element.

use super::file::{little, number};
use crate::bytes::{Bytes, Order, text};
use crate::names::shown;
use crate::raw::Kind;

/// Types within types.
const DEEPEST: usize = 8;
/// Numbers of an element that are channels at most.
const MOST_NUMBERS: usize = 4096;

/// What an element is.
enum Form {
    Number(Kind, Order),
    Members(Vec<Member>),
    Other(String),
}

/// A part of an element.
struct Member {
    name: String,
    at: u64,
    form: Form,
}

/// A number in an element.
pub(super) struct Part {
    /// What follows the name of the dataset.
    pub(super) name: String,
    pub(super) at: u64,
    pub(super) kind: Kind,
    pub(super) order: Order,
}

/// An element of a dataset.
pub(super) struct Element {
    pub(super) bytes: u64,
    /// The numbers in it.
    pub(super) parts: Vec<Part>,
    /// What else is in it.
    pub(super) others: Vec<String>,
}

pub(super) fn element(data: &[u8]) -> Option<Element> {
    let (form, bytes) = form(&mut little(data), 0)?;
    let (mut parts, mut others) = (Vec::new(), Vec::new());
    form.put(String::new(), 0, &mut parts, &mut others);
    let inside = |part: &Part| part.at + part.kind.size() <= bytes;
    parts.iter().all(inside).then_some(Element {
        bytes,
        parts,
        others,
    })
}

fn form(b: &mut Bytes<'_>, depth: usize) -> Option<(Form, u64)> {
    let (head, size) = (b.u32()?, u64::from(b.u32()?));
    let (class, version, bits) = (head & 15, head >> 4 & 15, head >> 8);
    if depth > DEEPEST || size == 0 {
        return None;
    }
    let order = match bits & 1 {
        0 => Order::Little,
        _ => Order::Big,
    };
    let other = |what: &str| Some(Form::Other(what.to_owned()));
    let found = match class {
        0 | 4 => {
            let (shift, precision) = (b.u16()?, b.u16()?);
            whole(size, class == 0 && bits & 8 != 0, shift, precision)
                .map(|kind| Form::Number(kind, order))
                .or_else(|| other(&format!("integers of {precision} bits in {size} bytes")))
        }
        1 => {
            let layout = [b.u16()?, b.u16()?];
            let exponent = (u64::from(b.u8()?), b.u8()?, b.u8()?, b.u8()?, b.u32()?);
            let kind = match (size, layout, exponent) {
                (2, [0, 16], (10, 5, 0, 10, 15)) => Some(Kind::F16),
                (4, [0, 32], (23, 8, 0, 23, 127)) => Some(Kind::F32),
                (8, [0, 64], (52, 11, 0, 52, 1023)) => Some(Kind::F64),
                _ => None,
            };
            kind.filter(|_| bits & 0x40 == 0)
                .map(|kind| Form::Number(kind, order))
                .or_else(|| {
                    other(&format!(
                        "floats of {} bits in another form than IEEE 754",
                        layout[1]
                    ))
                })
        }
        2 => {
            b.take(2)?;
            other("times")
        }
        3 => other("texts"),
        5 => {
            b.take((bits & 0xFF) as usize)?;
            other("bytes without meaning")
        }
        6 => members(b, version, bits & 0xFFFF, size, depth),
        7 => other("references to other data"),
        8 => {
            let (base, width) = form(b, depth + 1)?;
            for _ in 0..bits & 0xFFFF {
                name(b, version < 3)?;
            }
            b.take(usize::try_from(width.checked_mul((bits & 0xFFFF).into())?).ok()?)?;
            Some(base)
        }
        9 => {
            form(b, depth + 1)?;
            other(if bits & 15 == 1 {
                "texts"
            } else {
                "lists of unequal length"
            })
        }
        10 => list(b, version, depth),
        11 => {
            let (base, width) = form(b, depth + 1)?;
            match base {
                Form::Number(kind, order) => Some(Form::Members(vec![
                    Member {
                        name: "r".to_owned(),
                        at: 0,
                        form: Form::Number(kind, order),
                    },
                    Member {
                        name: "i".to_owned(),
                        at: width,
                        form: Form::Number(kind, order),
                    },
                ])),
                _ => other("complex numbers of no kind that is known"),
            }
        }
        class => other(&format!("of the class {class} of types")),
    };
    Some((found?, size))
}

fn whole(size: u64, signed: bool, shift: u16, precision: u16) -> Option<Kind> {
    if shift != 0 || u64::from(precision) != size.checked_mul(8)? {
        return None;
    }
    Some(match (size, signed) {
        (1, false) => Kind::U8,
        (1, true) => Kind::I8,
        (2, false) => Kind::U16,
        (2, true) => Kind::I16,
        (3, true) => Kind::I24,
        (4, false) => Kind::U32,
        (4, true) => Kind::I32,
        (8, false) => Kind::U64,
        (8, true) => Kind::I64,
        _ => return None,
    })
}

/// A name up to its zero, filled up to eight bytes in older versions.
fn name(b: &mut Bytes<'_>, filled: bool) -> Option<String> {
    let length = b.rest().iter().position(|c| *c == 0)? + 1;
    let name = shown(&text(&b.take(length)?[..length - 1]));
    let behind = length.next_multiple_of(8) - length;
    b.take(if filled { behind } else { 0 })?;
    Some(name)
}

fn members(b: &mut Bytes<'_>, version: u32, count: u32, size: u64, depth: usize) -> Option<Form> {
    let width = (size.checked_ilog2().unwrap_or(0) / 8 + 1) as usize;
    let mut members = Vec::new();
    for _ in 0..count {
        let name = name(b, version < 3)?;
        let at = number(b, if version < 3 { 4 } else { width })?;
        let mut sides = 0;
        let mut lengths = [0; 4];
        if version == 1 {
            sides = usize::from(b.u8()?);
            b.take(11)?;
            for length in &mut lengths {
                *length = u64::from(b.u32()?);
            }
        }
        let (mut form, mut length) = form(b, depth + 1)?;
        if sides > 0 {
            let all = lengths.get(..sides)?.iter();
            let count = all.fold(1_u64, |n, side| n.saturating_mul(*side));
            form = repeated(form, length, count);
            length = length.checked_mul(count)?;
        }
        if at.checked_add(length)? > size {
            return None;
        }
        members.push(Member { name, at, form });
    }
    Some(Form::Members(members))
}

/// An array in an element.
fn list(b: &mut Bytes<'_>, version: u32, depth: usize) -> Option<Form> {
    let sides = usize::from(b.u8()?);
    b.take(if version < 3 { 3 } else { 0 })?;
    let mut count = 1_u64;
    for _ in 0..sides {
        count = count.saturating_mul(b.u32()?.into());
    }
    b.take(if version < 3 { 4 * sides } else { 0 })?;
    let (form, width) = form(b, depth + 1)?;
    Some(repeated(form, width, count))
}

/// The same number several times.
fn repeated(form: Form, width: u64, count: u64) -> Form {
    match form {
        Form::Number(kind, order) if count <= MOST_NUMBERS as u64 => {
            let member = |i| Member {
                name: format!("({})", i + 1),
                at: i * width,
                form: Form::Number(kind, order),
            };
            Form::Members((0..count).map(member).collect())
        }
        Form::Other(what) => Form::Other(what),
        _ => Form::Other(format!("arrays of {count} elements in an element")),
    }
}

impl Form {
    fn put(&self, outside: String, at: u64, parts: &mut Vec<Part>, others: &mut Vec<String>) {
        match self {
            Self::Number(kind, order) if parts.len() < MOST_NUMBERS => parts.push(Part {
                name: outside,
                at,
                kind: *kind,
                order: *order,
            }),
            Self::Number(..) => others.push(format!("{outside}, more numbers than {MOST_NUMBERS}")),
            Self::Other(what) => others.push(format!("{outside}, {what}")),
            Self::Members(members) => {
                let complex = self.is_complex();
                for (i, member) in members.iter().enumerate() {
                    let inside = match (complex, member.name.starts_with('(')) {
                        (true, _) => {
                            ["real", "imaginary"].map(|part| format!("{outside} {part}"))[i].clone()
                        }
                        (false, true) => format!("{outside}{}", member.name),
                        (false, false) => format!("{outside}.{}", member.name),
                    };
                    member.form.put(inside, at + member.at, parts, others);
                }
            }
        }
    }

    /// Two numbers that are a complex one, as MATLAB and h5py name them.
    fn is_complex(&self) -> bool {
        let Self::Members(members) = self else {
            return false;
        };
        let [re, im] = &members[..] else { return false };
        let names = (re.name.as_str(), im.name.as_str());
        let number = |m: &Member| matches!(m.form, Form::Number(..));
        matches!(names, ("r", "i") | ("real", "imag")) && number(re) && number(im)
    }
}

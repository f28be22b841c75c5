//! MAT of level 4: one matrix after the other, each with a head of twenty bytes.

use crate::arrays::{Array, Arrays, Part};
use crate::bytes::{Bytes, Order, text};
use crate::raw::{Kind, bytes_at};
use crate::stream::{Contents, Remark, SeekRead};
use crate::{Error, Result};

/// Letters of a name with its zero.
const LONGEST_NAME: u32 = 64;

/// What the head of a matrix says.
struct Head {
    kind: Kind,
    order: Order,
    text: bool,
    rows: u64,
    columns: u64,
    complex: bool,
    name: u32,
}

impl Head {
    fn of(bytes: &[u8]) -> Option<Self> {
        [Order::Little, Order::Big].into_iter().find_map(|order| {
            let mut b = Bytes::new(bytes, order);
            let form = b.u32()?;
            let (rows, columns, complex, name) = (b.u32()?, b.u32()?, b.u32()?, b.u32()?);
            let kind = match form / 10 % 10 {
                0 => Kind::F64,
                1 => Kind::F32,
                2 => Kind::I32,
                3 => Kind::I16,
                4 => Kind::U16,
                5 => Kind::U8,
                _ => return None,
            };
            let stated = match form / 100 {
                0 => Order::Little,
                10 => Order::Big,
                _ => return None,
            };
            let holds = stated == order
                && matches!(form % 10, 0 | 1)
                && complex < 2
                && (2..=LONGEST_NAME).contains(&name)
                && rows > 0
                && columns > 0;
            holds.then_some(Self {
                kind,
                order,
                text: form % 10 == 1,
                rows: u64::from(rows),
                columns: u64::from(columns),
                complex: complex == 1,
                name,
            })
        })
    }
}

pub(crate) fn is_level4(head: &[u8]) -> bool {
    let Some(found) = Head::of(head) else {
        return false;
    };
    let name = head.get(20..20 + found.name as usize);
    name.and_then(|n| n.split_last())
        .is_some_and(|(zero, name)| {
            let letter = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
            *zero == 0 && name[0].is_ascii_alphabetic() && name.iter().all(letter)
        })
}

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let mut arrays = Arrays::default();
    let mut at = 0;
    while at < size {
        let head = bytes_at(file, at, 20 + u64::from(LONGEST_NAME))?;
        let Some(found) = Head::of(&head) else {
            arrays.remarks.push(Remark::cut(format!(
                "what stands at byte {at} is no matrix of a MAT file of level 4"
            )));
            break;
        };
        let name = head.get(20..20 + found.name as usize).unwrap_or_default();
        let name = text(name.split(|b| *b == 0).next().unwrap_or_default());
        let numbers = found.rows * found.columns;
        let length = numbers
            .checked_mul(found.kind.size() * if found.complex { 2 } else { 1 })
            .ok_or_else(|| Error::new("the MAT file states an impossible size"))?;
        let begin = at + 20 + u64::from(found.name);
        let bytes = bytes_at(file, begin, length)?;
        if (bytes.len() as u64) < length {
            arrays.remarks.push(Remark::cut(format!(
                "the matrix {name} at byte {at} is longer than the file of {size} bytes"
            )));
        }
        at = begin.saturating_add(length);
        if found.text {
            continue;
        }
        let real = Part::of(bytes, found.kind, found.order);
        let half = (length / 2) as usize;
        let imaginary = found.complex.then(|| real.behind(half));
        arrays.put(&Array {
            name,
            rows: found.rows as usize,
            columns: found.columns as usize,
            by_rows: false,
            real,
            imaginary,
        });
    }
    Ok(arrays.contents())
}

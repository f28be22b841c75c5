//! npy, the arrays of numpy.
//!
//! **Source** `[NPY]`.

use crate::arrays::{Array, Arrays, Part, Stored};
use crate::bytes::{Bytes, Order};
use crate::raw::{Kind, bytes_at};
use crate::stream::{Contents, SeekRead};
use crate::{Error, Result};
use std::sync::Arc;

/// Bytes of a header at most.
const LONGEST_HEADER: u32 = 1 << 16;

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let mut arrays = Arrays::default();
    let head = bytes_at(file, 0, u64::from(LONGEST_HEADER) + 12)?;
    described(&head, Stored::UpTo(size as usize), "column", &mut arrays)?;
    Ok(arrays.contents())
}

/// Takes in the array that bytes hold.
pub(crate) fn array(bytes: Vec<u8>, name: &str, arrays: &mut Arrays) -> Result<()> {
    let bytes = Arc::new(bytes);
    described(&bytes, Stored::Held(Arc::clone(&bytes)), name, arrays)
}

/// Takes in the array that begins with a header.
fn described(bytes: &[u8], stored: Stored, name: &str, arrays: &mut Arrays) -> Result<()> {
    let damaged = || Error::new("the header of the npy file is damaged or cut short");
    let mut b = Bytes::new(bytes, Order::Little);
    b.take(6).ok_or_else(damaged)?;
    let version = b.u8().ok_or_else(damaged)?;
    b.u8();
    let length = match version {
        1 => b.u16().map(u32::from),
        _ => b.u32(),
    };
    let length = length
        .filter(|l| *l <= LONGEST_HEADER)
        .ok_or_else(damaged)?;
    let header = crate::bytes::text(b.take(length as usize).ok_or_else(damaged)?);
    let begin = bytes.len() - b.rest().len();
    let after = |key: &str| {
        let at = header.find(&format!("'{key}'"))?;
        let rest = header[at..].split_once(':')?.1;
        Some(rest.trim_start())
    };
    let form = after("descr").ok_or_else(damaged)?;
    let by_rows = after("fortran_order").is_some_and(|f| f.starts_with("False"));
    let shape = after("shape").and_then(|s| s.strip_prefix('(')?.split_once(')'));
    let shape = shape
        .ok_or_else(damaged)?
        .0
        .split(',')
        .filter(|n| !n.trim().is_empty());
    let shape: Option<Vec<usize>> = shape.map(|n| n.trim().parse().ok()).collect();
    let (rows, columns) = match shape.ok_or_else(damaged)?[..] {
        [] => (1, 1),
        [n] => (n, 1),
        [rows, columns] => (rows, columns),
        _ => {
            return Err(
                Error::new("the npy file holds an array of more than two dimensions")
                    .with_hint("save it as one column for each signal"),
            );
        }
    };
    if form.starts_with('[') {
        let nested = || {
            Error::new("the npy file holds records whose fields are no numbers side by side")
                .with_hint("save every field as an array of its own, such as numpy.savez")
        };
        let fields = fields(form).ok_or_else(nested)?;
        if columns > 1 {
            return Err(nested());
        }
        let width = fields
            .iter()
            .try_fold(0, |at: usize, f| at.checked_add(f.1.size));
        let width = width.ok_or_else(damaged)?;
        let mut at = begin;
        for (field, number) in fields {
            let real = |kind, order| Part {
                bytes: stored.clone(),
                at,
                width,
                kind,
                order,
            };
            if let Some((kind, order, complex)) = number.kind {
                let real = real(kind, order);
                let imaginary = complex.then(|| real.behind(kind.size() as usize));
                arrays.put(&Array {
                    name: field,
                    rows,
                    columns,
                    by_rows,
                    real,
                    imaginary,
                });
            }
            at += number.size;
        }
        return Ok(());
    }
    let form = form.strip_prefix('\'').and_then(|f| f.split_once('\''));
    let form = form.ok_or_else(damaged)?.0;
    let Some((kind, order, complex)) = stored_as(form) else {
        let word = form.trim_start_matches(['<', '>', '|', '=']);
        return Err(Error::new(format!(
            "the npy file holds values of the kind {word}, which are not read here"
        ))
        .with_hint("save them as float64"));
    };
    let width = kind.size() as usize * if complex { 2 } else { 1 };
    let real = Part {
        bytes: stored,
        at: begin,
        width,
        kind,
        order,
    };
    let imaginary = complex.then(|| real.behind(kind.size() as usize));
    arrays.put(&Array {
        name: name.to_owned(),
        rows,
        columns,
        by_rows,
        real,
        imaginary,
    });
    Ok(())
}

/// How numbers are stored, by the word of numpy, and whether they are complex; `None` for what holds no numbers.
fn stored_as(form: &str) -> Option<(Kind, Order, bool)> {
    let (order, word) = match form.split_at_checked(1) {
        Some((">", word)) => (Order::Big, word),
        Some(("<" | "|" | "=", word)) => (Order::Little, word),
        _ => (Order::Little, form),
    };
    let (kind, complex) = match word {
        "b1" | "u1" => (Kind::U8, false),
        "i1" => (Kind::I8, false),
        "u2" => (Kind::U16, false),
        "i2" => (Kind::I16, false),
        "u4" => (Kind::U32, false),
        "i4" => (Kind::I32, false),
        "u8" => (Kind::U64, false),
        "i8" => (Kind::I64, false),
        "f4" => (Kind::F32, false),
        "f8" => (Kind::F64, false),
        "c8" => (Kind::F32, true),
        "c16" => (Kind::F64, true),
        _ => return None,
    };
    Some((kind, order, complex))
}

/// A field of a record: how its number is stored, if it is one, and its bytes.
struct Field {
    kind: Option<(Kind, Order, bool)>,
    size: usize,
}

/// Names and forms of the fields of `[('x', '<f8'), ('y', '<f8')]`; `None` where one is a record or an array itself.
fn fields(list: &str) -> Option<Vec<(String, Field)>> {
    let mut fields = Vec::new();
    let mut rest = list.strip_prefix('[')?.trim_start();
    while let Some(inner) = rest.strip_prefix('(') {
        let (name, behind) = quoted(inner)?;
        let (form, behind) = quoted(behind.trim_start().strip_prefix(',')?.trim_start())?;
        fields.push((name.to_owned(), field(form)?));
        rest = behind.trim_start().strip_prefix(')')?.trim_start();
        rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
    }
    rest.starts_with(']').then_some(fields)
}

/// A text in quotes of either kind without escapes, and what is behind it.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| "'\"".contains(*c))?;
    let (inner, behind) = text[1..].split_once(quote)?;
    (!inner.contains('\\')).then_some((inner, behind))
}

fn field(form: &str) -> Option<Field> {
    if let Some((kind, order, complex)) = stored_as(form) {
        let size = kind.size() as usize * if complex { 2 } else { 1 };
        let kind = Some((kind, order, complex));
        return Some(Field { kind, size });
    }
    let word = form.trim_start_matches(['<', '>', '|', '=']);
    let (letter, count) = word.split_at_checked(1)?;
    let count: usize = count.parse().ok()?;
    let size = match letter {
        // Texts, bytes, what fills a record up.
        "S" | "V" | "a" => count,
        "U" => count.checked_mul(4)?,
        "f" | "i" | "u" | "c" if count <= 64 => count,
        _ => return None,
    };
    Some(Field { kind: None, size })
}

#[cfg(test)]
mod tests {
    use crate::stream::tests::{columns, open, survives};

    fn file(form: &str, by_columns: bool, shape: &str, data: &[u8]) -> Vec<u8> {
        let order = if by_columns { "True" } else { "False" };
        let header =
            format!("{{'descr': '{form}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let length = (header.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\0", &length[..], header.as_bytes(), data].concat()
    }

    #[test]
    fn known_arrays() {
        let big: Vec<u8> = [1_i16, 2, 3, 4, 5, 6]
            .iter()
            .flat_map(|v| v.to_be_bytes())
            .collect();
        let read = |file: &[u8]| columns(open(file).unwrap(), 0);
        // Three rows of two, by rows and by columns; two rows of three are two signals.
        assert_eq!(
            read(&file(">i2", false, "(3, 2)", &big)),
            [[1.0, 3.0, 5.0], [2.0, 4.0, 6.0]]
        );
        assert_eq!(
            read(&file(">i2", true, "(3, 2)", &big)),
            [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
        );
        assert_eq!(
            read(&file(">i2", false, "(2, 3)", &big)),
            [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
        );
        let complex: Vec<u8> = [1_f32, -1.0, 2.0, -2.0]
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        assert_eq!(
            read(&file("<c8", false, "(2,)", &complex)),
            [[1.0, 2.0], [-1.0, -2.0]]
        );
        let cut = open(&file(">i2", false, "(40, 2)", &big)).unwrap();
        assert_eq!((cut.streams()[0].rows, cut.remarks().len()), (3, 1));
        survives(&file(">i2", false, "(3, 2)", &big));
    }

    /// Records of fields, as `np.save` of a structured array has them: numbers by their names, texts and what fills up left out.
    #[test]
    fn known_records() {
        let file = |descr: &str, rows: usize, data: &[u8]| {
            let header =
                format!("{{'descr': {descr}, 'fortran_order': False, 'shape': ({rows},), }}\n");
            let length = (header.len() as u16).to_le_bytes();
            [b"\x93NUMPY\x01\0", &length[..], header.as_bytes(), data].concat()
        };
        let mut data = Vec::new();
        for k in 0..3_i16 {
            data.extend(f64::from(k).to_le_bytes());
            data.extend(b"abc");
            data.extend((10 * k).to_be_bytes());
        }
        let whole = file("[('x', '<f8'), ('who', '|S3'), (\"y's\", '>i2')]", 3, &data);
        let read = open(&whole).unwrap();
        let channels = read.streams()[0].channels.iter();
        let names: Vec<&str> = channels.map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["x", "y's"]);
        assert_eq!(columns(read, 0), [[0.0, 1.0, 2.0], [0.0, 10.0, 20.0]]);
        let nested = file("[('x', [('a', '<f8')]), ('y', '<f8')]", 3, &[0; 48]);
        assert!(open(&nested).is_err());
        let within = file("[('x', '<f8', (3,))]", 3, &[0; 72]);
        assert!(open(&within).is_err());
        survives(&whole);
    }
}

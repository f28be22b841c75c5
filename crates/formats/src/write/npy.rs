//! The head of an array of numpy, version 1.0 of the format.

/// Bytes at whose multiples the numbers begin.
const ALIGNED: usize = 64;

/// What stands before `rows` times `columns` little-endian doubles, row by row.
pub fn npy_head(rows: u64, columns: usize) -> Vec<u8> {
    let shape = match columns {
        1 => format!("({rows},)"),
        _ => format!("({rows}, {columns})"),
    };
    let mut words = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    let before = 10;
    let length = (before + words.len() + 1).next_multiple_of(ALIGNED) - before;
    words.push_str(&" ".repeat(length - words.len() - 1));
    words.push('\n');
    let mut head = b"\x93NUMPY\x01\0".to_vec();
    head.extend((length as u16).to_le_bytes());
    head.extend(words.into_bytes());
    head
}

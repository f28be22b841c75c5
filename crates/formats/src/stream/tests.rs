use crate::{Container, Result};
use std::io::Cursor;

pub(crate) fn open(bytes: &[u8]) -> Result<Container> {
    Container::open(Box::new(Cursor::new(bytes.to_vec())))
}

/// Every channel of a stream.
pub(crate) fn columns(container: Container, stream: usize) -> Vec<Vec<f64>> {
    let chosen: Vec<usize> = (0..container.streams()[stream].channels.len()).collect();
    let mut rows = container.rows(stream, &chosen).unwrap();
    let mut all = vec![Vec::new(); chosen.len()];
    let mut block = all.clone();
    while rows.next_block(&mut block).unwrap() > 0 {
        for (all, part) in all.iter_mut().zip(&block) {
            all.extend(part);
        }
    }
    all
}

/// Cut at every byte and with every byte inverted: an answer or a refusal.
pub(crate) fn survives(file: &[u8]) {
    let read = |bytes: &[u8]| {
        let Ok(container) = open(bytes) else { return };
        for stream in 0..container.streams().len() {
            if let Ok(container) = open(bytes) {
                columns(container, stream);
            }
        }
    };
    for at in 0..file.len() {
        read(&file[..at]);
        let mut inverted = file.to_vec();
        inverted[at] ^= 0xFF;
        read(&inverted);
    }
}

/// Writes numbers in the order of a file.
#[derive(Clone, Copy)]
pub(crate) struct Writer {
    pub(crate) big: bool,
}

macro_rules! numbers {
    ($($name:ident),*) => {
        $(pub(crate) fn $name(self, v: $name) -> Vec<u8> {
            match self.big {
                true => v.to_be_bytes().to_vec(),
                false => v.to_le_bytes().to_vec(),
            }
        })*
    };
}

impl Writer {
    numbers!(i16, u32, u64, f64);
}

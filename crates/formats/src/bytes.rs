//! Numbers out of bytes, in either order; nothing is read beyond the end.

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Order {
    /// The least significant byte first.
    #[default]
    Little,
    /// The most significant byte first.
    Big,
}

/// A place in bytes that are held; every reading is `None` at the end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bytes<'a> {
    rest: &'a [u8],
    pub(crate) order: Order,
}

macro_rules! numbers {
    ($($name:ident $type:ty),*) => {
        $(pub(crate) fn $name(&mut self) -> Option<$type> {
            let (bytes, rest) = self.rest.split_first_chunk()?;
            self.rest = rest;
            Some(match self.order {
                Order::Little => <$type>::from_le_bytes(*bytes),
                Order::Big => <$type>::from_be_bytes(*bytes),
            })
        })*
    };
}

impl<'a> Bytes<'a> {
    pub(crate) fn new(bytes: &'a [u8], order: Order) -> Self {
        Self { rest: bytes, order }
    }

    numbers!(u8 u8, i8 i8, u16 u16, i16 i16, u32 u32, i32 i32, u64 u64, i64 i64, f32 f32, f64 f64);

    /// All that is left.
    pub(crate) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// The next so many bytes.
    pub(crate) fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(n)?;
        self.rest = rest;
        Some(taken)
    }
}

/// Bytes as text: UTF-8 where they are, else each byte a character of Latin-1.
pub(crate) fn text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    }
}

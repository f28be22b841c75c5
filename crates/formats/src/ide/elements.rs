//! Elements of EBML (RFC 8794): an identifier, a size and the content.

/// Longest head of an element: 4 bytes of identifier, 8 of size.
pub(super) const HEAD: u64 = 12;

/// How an element begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Head {
    pub(super) id: u32,
    /// Bytes of the content; `None` where it is not said.
    pub(super) size: Option<u64>,
    /// Bytes of the head itself.
    pub(super) length: u64,
}

/// The head that begins here; nothing where there is none.
pub(super) fn head(bytes: &[u8]) -> Option<Head> {
    let width = 1 + bytes.first()?.leading_zeros() as usize;
    if width > 4 {
        return None;
    }
    let id = unsigned(bytes.get(..width)?)? as u32;
    let rest = bytes.get(width..)?;
    let first = *rest.first()?;
    let wide = 1 + first.leading_zeros() as usize;
    if wide > 8 {
        return None;
    }
    // The mark of the width goes; ones in every other place mean that the size is not said.
    let all = (1_u64 << (7 * wide)) - 1;
    let size = unsigned(rest.get(..wide)?)? & all;
    Some(Head {
        id,
        size: (size != all).then_some(size),
        length: (width + wide) as u64,
    })
}

/// Identifier and content of the elements that stand in bytes, as far as they are whole.
pub(super) fn children(mut rest: &[u8]) -> impl Iterator<Item = (u32, &[u8])> {
    std::iter::from_fn(move || {
        let head = head(rest)?;
        let content = rest.get(head.length as usize..)?;
        let size = usize::try_from(head.size?).ok()?;
        let (content, after) = content.split_at_checked(size)?;
        rest = after;
        Some((head.id, content))
    })
}

/// A whole number, the most significant byte first; no byte at all is zero.
pub(super) fn unsigned(bytes: &[u8]) -> Option<u64> {
    (bytes.len() <= 8).then(|| bytes.iter().fold(0, |v, b| v << 8 | u64::from(*b)))
}

/// A number of 4 or 8 bytes; no byte at all is zero.
pub(super) fn float(bytes: &[u8]) -> Option<f64> {
    let v = match bytes.len() {
        0 => 0.0,
        4 => f64::from(f32::from_be_bytes(bytes.try_into().ok()?)),
        8 => f64::from_be_bytes(bytes.try_into().ok()?),
        _ => return None,
    };
    v.is_finite().then_some(v)
}

/// A text up to its first zero byte.
pub(super) fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    crate::bytes::text(&bytes[..end]).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_heads() {
        let of = |id, size, length| Some(Head { id, size, length });
        assert_eq!(head(b"\x1A\x45\xDF\xA3\x9F"), of(0x1A45_DFA3, Some(31), 5));
        assert_eq!(head(b"\x52\x70\x41\x2A"), of(0x5270, Some(298), 4));
        assert_eq!(head(b"\xA1\xFF"), of(0xA1, None, 2));
        assert_eq!(
            head(b"\xA1\x01\xFF\xFF\xFF\xFF\xFF\xFF\xFF"),
            of(0xA1, None, 9)
        );
        for bad in [
            &b""[..],
            b"\x08\0\0\0\0\x81",
            b"\xA1",
            b"\xA1\x40",
            b"\xA1\0",
        ] {
            assert_eq!(head(bad), None);
        }
    }
}

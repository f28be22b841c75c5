//! What a file claims for itself and what is believed of it: names of any length, sizes of what is packed.

/// Letters of a name that are kept.
const LONGEST: usize = 200;
/// A file may unpack to so many bytes, and to so many more for each of its bytes: recordings pack to a tenth of their size, a
/// file made to fill the memory to a thousandth.
const UNPACKED: u64 = 8 << 20;
const FOR_EACH_BYTE: u64 = 64;

/// A name as it is kept and shown: without control characters, its end left away where it is long.
pub(crate) fn shown(name: &str) -> String {
    shortened(name, LONGEST)
}

/// A text without control characters, of at most so many letters.
pub(crate) fn shortened(text: &str, longest: usize) -> String {
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    match text.char_indices().nth(longest) {
        None => text.chars().map(plain).collect(),
        Some(_) => text
            .chars()
            .take(longest - 1)
            .map(plain)
            .chain(['…'])
            .collect(),
    }
}

/// Bytes that so many packed ones may unpack to.
pub(crate) fn unpacked_bytes(packed: u64) -> u64 {
    FOR_EACH_BYTE
        .saturating_mul(packed)
        .saturating_add(UNPACKED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_names() {
        assert_eq!(shown("acc_x <b>µ</b>"), "acc_x <b>µ</b>");
        assert_eq!(shown("a\u{1b}[31m\nb"), "a [31m b");
        let long = shown(&"ä".repeat(10_000));
        assert_eq!(long.chars().count(), LONGEST);
        assert!(long.ends_with("ä…"));
        assert_eq!(unpacked_bytes(u64::MAX), u64::MAX);
    }
}

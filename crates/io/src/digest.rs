//! SHA-256, and bytes in hexadecimal digits.

use sha2::{Digest, Sha256};

/// SHA-256 of parts, one behind the other, in hexadecimal digits.
///
/// ```
/// let [whole, parts] = [&[b"ab".as_slice()] as &[&[u8]], &[b"a", b"b"]].map(proofmass_io::sha256);
/// assert_eq!(whole, parts);
/// assert!(proofmass_io::sha256(&[b"abc"]).starts_with("ba7816bf"));
/// ```
pub fn sha256(parts: &[&[u8]]) -> String {
    let mut hash = Sha256::new();
    parts.iter().for_each(|part| hash.update(part));
    hexadecimal(&hash.finalize())
}

/// Bytes in hexadecimal digits.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes
        .iter()
        .fold(String::with_capacity(2 * bytes.len()), |mut text, b| {
            let _ = write!(text, "{b:02x}");
            text
        })
}

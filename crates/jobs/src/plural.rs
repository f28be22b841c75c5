//! Numbers of things in English.

/// `1 standstill`, `2 standstills`.
pub(crate) fn count(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

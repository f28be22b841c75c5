//! Numbers of things in English.

/// `1 standstill`, `2 standstills`.
pub(crate) fn count(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

/// `1 sample lies`, `2 samples lie`.
pub(crate) fn count_lying(n: usize, noun: &str) -> String {
    format!("{} {}", count(n, noun), if n == 1 { "lies" } else { "lie" })
}

//! Where a recording goes that a job writes.

use proofmass_io::Input;
use std::path::Path;

/// Where a recording goes that a job writes.
#[non_exhaustive]
pub enum Destination<'a> {
    /// A file, which appears whole or not at all; the inputs are never overwritten.
    File {
        /// Its place.
        path: &'a Path,
        /// Files that may not be overwritten, the recordings first.
        inputs: &'a [&'a Path],
        /// Told the recordings, the digest of the whole file and the steps of a chain before that stands in its place.
        beside: &'a dyn Fn(&[Input], &str, &[String]) -> proofmass_io::Result<()>,
    },
    /// Memory.
    Bytes(&'a mut Vec<u8>),
}

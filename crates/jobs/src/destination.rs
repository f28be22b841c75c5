//! Where a recording goes that a job writes.

use proofmass_io::Input;
use std::path::Path;

/// Told the recordings, the digest of what was written, and the steps of a chain.
pub type Beside<'a> = dyn Fn(&[Input], &str, &[String]) -> proofmass_io::Result<()> + 'a;

/// Where a recording goes that a job writes.
#[non_exhaustive]
pub enum Destination<'a> {
    /// A file, which appears whole or not at all; the inputs are never overwritten.
    File {
        /// Its place.
        path: &'a Path,
        /// Files that may not be overwritten, the recordings first.
        inputs: &'a [&'a Path],
        /// Called with the digest of the whole file before that stands in its place.
        beside: &'a Beside<'a>,
    },
    /// Memory.
    Bytes(&'a mut Vec<u8>),
}

//! Where what is written goes: a file that appears whole, or memory.

use crate::output::AtomicFile;
use crate::{Error, ErrorKind, Result};
use std::path::Path;

/// A file in the making, or bytes in memory.
#[derive(Debug)]
pub enum Written {
    /// A file that appears with [`Written::commit`].
    File(Box<AtomicFile>),
    /// Bytes, which [`Written::into_bytes`] gives.
    Bytes(Vec<u8>),
}

impl Written {
    /// Begins a file that will stand at `path`; `inputs` are never overwritten.
    ///
    /// # Errors
    /// As [`AtomicFile::create`].
    pub fn create(path: &Path, inputs: &[&Path]) -> Result<Self> {
        Ok(Self::File(Box::new(AtomicFile::create(path, inputs)?)))
    }

    pub(crate) fn write_all(&mut self, bytes: &[u8]) -> Result<()> {
        match self {
            Self::File(file) => file.write_all(bytes),
            Self::Bytes(all) => {
                all.extend_from_slice(bytes);
                Ok(())
            }
        }
    }

    pub(crate) fn refusal(&self, what: impl Into<String>) -> Error {
        Error::new(ErrorKind::Output, what).at(self.target())
    }

    pub(crate) fn target(&self) -> &Path {
        match self {
            Self::File(file) => file.target(),
            Self::Bytes(_) => Path::new("the output"),
        }
    }

    /// Whether a file will stand at the place afterwards, and not only go through a pipe; so for memory.
    pub fn is_kept(&self) -> bool {
        match self {
            Self::File(file) => file.is_kept(),
            Self::Bytes(_) => true,
        }
    }

    /// SHA-256 of what was written so far, in hexadecimal digits.
    pub fn sha256(&self) -> String {
        match self {
            Self::File(file) => file.sha256(),
            Self::Bytes(bytes) => crate::digest::sha256(&[bytes]),
        }
    }

    /// Waits until all that was written is on the disk; the place is not touched yet.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn settle(&mut self) -> Result<()> {
        match self {
            Self::File(file) => file.settle(),
            Self::Bytes(_) => Ok(()),
        }
    }

    /// Puts the file in its place; what was written in memory is lost.
    ///
    /// # Errors
    /// The disk refuses; what stood there before is then still there.
    pub fn commit(self) -> Result<()> {
        match self {
            Self::File(file) => file.commit(),
            Self::Bytes(_) => Ok(()),
        }
    }

    /// What was written in memory; `None` for a file.
    pub fn into_bytes(self) -> Option<Vec<u8>> {
        match self {
            Self::File(_) => None,
            Self::Bytes(bytes) => Some(bytes),
        }
    }
}

//! A text that only grows: locked while it is open, on the disk when a line was added.

use crate::{Error, ErrorKind, Result};
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// Bytes of such a text at most.
const LARGEST: u64 = 64 << 20;

/// A file to whose end lines are added, by one process at a time.
#[derive(Debug)]
pub struct AppendLog {
    file: File,
    path: PathBuf,
}

impl AppendLog {
    /// Opens and locks a file, and gives its text; it is made where it is not there yet.
    ///
    /// # Errors
    /// Another process has it open, no permission, no text in UTF-8.
    pub fn open(path: &Path) -> Result<(Self, String)> {
        let access = |e| Error::access(path, "write", e);
        let file = std::fs::OpenOptions::new()
            .read(true)
            .append(true)
            .create(true)
            .open(path)
            .map_err(access)?;
        if file.try_lock().is_err() {
            return Err(Error::new(
                ErrorKind::Access,
                "another process has it open, and would write the same lines",
            )
            .at(path)
            .with_hint("wait until that one has ended, and try again"));
        }
        let mut text = String::new();
        (&file)
            .take(LARGEST + 1)
            .read_to_string(&mut text)
            .map_err(access)?;
        if text.len() as u64 > LARGEST {
            return Err(
                Error::new(ErrorKind::Format, "is larger than such a file can be").at(path),
            );
        }
        let path = path.to_path_buf();
        Ok((Self { file, path }, text))
    }

    /// Adds a text; it is on the disk when this returns.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn append(&mut self, text: &str) -> Result<()> {
        self.file
            .write_all(text.as_bytes())
            .and_then(|()| self.file.sync_all())
            .map_err(|e| Error::access(&self.path, "write", e))
    }
}

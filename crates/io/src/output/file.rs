//! One file in the making.

use super::place::{Place, sync};
use super::unfinished::{Unfinished, in_place, sweep};
use crate::{Error, ErrorKind, Result};
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Bytes that are collected before they are written.
const BUFFER: usize = 1 << 18;

/// A file in the making, in the folder of its place. Dropped without [`AtomicFile::commit`] it leaves no trace.
///
/// What is no regular file — a device, a pipe, standard output as `-` — is written into and never replaced; a
/// symbolic link stays, and the file it leads to is replaced.
#[derive(Debug)]
pub struct AtomicFile {
    target: PathBuf,
    to: Destination,
    hash: Sha256,
}

#[derive(Debug)]
enum Destination {
    Replaced {
        unfinished: Unfinished,
        place: Place,
        file: BufWriter<File>,
    },
    Stream(BufWriter<Stream>),
}

#[derive(Debug)]
enum Stream {
    File(File),
    Standard(std::io::Stdout),
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match self {
            Self::File(file) => file.write(bytes),
            Self::Standard(out) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        match self {
            Self::File(file) => file.flush(),
            Self::Standard(out) => out.flush(),
        }
    }
}

/// Refuses an output that is one of the inputs, by whatever name.
///
/// # Errors
/// It is one of them.
pub fn not_an_input(target: &Path, inputs: &[&Path]) -> Result<()> {
    // Links and dots resolved: the same file may have two names.
    if let Ok(there) = target.canonicalize()
        && inputs
            .iter()
            .any(|i| i.canonicalize().is_ok_and(|i| i == there))
    {
        return Err(Error::new(
            ErrorKind::Output,
            "the output is the input itself, which is never overwritten",
        )
        .at(target)
        .with_hint("name another file for the output"));
    }
    Ok(())
}

impl AtomicFile {
    /// Begins a file that will stand at `path`; an existing file is replaced on commit, one of `inputs` never.
    ///
    /// # Errors
    /// The place is a folder or one of the inputs, or the folder cannot be written.
    pub fn create(path: impl AsRef<Path>, inputs: &[&Path]) -> Result<Self> {
        let target = path.as_ref().to_path_buf();
        let stream = |stream| Self {
            target: target.clone(),
            hash: Sha256::new(),
            to: Destination::Stream(BufWriter::with_capacity(BUFFER, stream)),
        };
        if target == Path::new("-") {
            return Ok(stream(Stream::Standard(std::io::stdout())));
        }
        if target.is_dir() {
            return Err(Error::new(ErrorKind::Output, "is a folder, not a file")
                .at(&target)
                .with_hint("name the file to be written"));
        }
        not_an_input(&target, inputs)?;
        if fs::metadata(&target).is_ok_and(|m| !m.is_file()) {
            let file = File::options()
                .write(true)
                .open(&target)
                .map_err(|e| Error::access(&target, "write", e))?;
            return Ok(stream(Stream::File(file)));
        }
        let place = Place::of(&target, false)?;
        sweep(&place.parent, &place.name);
        let (unfinished, file) = Unfinished::file(&place.parent, &place.name)?;
        Ok(Self {
            target,
            hash: Sha256::new(),
            to: Destination::Replaced {
                place,
                unfinished,
                file: BufWriter::with_capacity(BUFFER, file),
            },
        })
    }

    /// Where the file will stand.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Writes bytes.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn write_all(&mut self, bytes: &[u8]) -> Result<()> {
        self.hash.update(bytes);
        match &mut self.to {
            Destination::Replaced { file, .. } => file.write_all(bytes),
            Destination::Stream(stream) => stream.write_all(bytes),
        }
        .map_err(|e| Error::access(&self.target, "write", e))
    }

    /// SHA-256 of what was written so far, in hexadecimal digits.
    pub fn sha256(&self) -> String {
        crate::digest::hexadecimal(&self.hash.clone().finalize())
    }

    /// Whether a file will stand at the place afterwards: not so for a device, a pipe, standard output.
    pub fn is_kept(&self) -> bool {
        matches!(self.to, Destination::Replaced { .. })
    }

    /// Waits until all that was written is on the disk; the place is not touched yet.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn settle(&mut self) -> Result<()> {
        match &mut self.to {
            Destination::Replaced { file, .. } => {
                file.flush().and_then(|()| file.get_ref().sync_all())
            }
            Destination::Stream(stream) => stream.flush(),
        }
        .map_err(|e| Error::access(&self.target, "write", e))
    }

    /// Puts the file in its place, once it is on the disk.
    ///
    /// # Errors
    /// The disk refuses; what stood there before is then still there.
    pub fn commit(self) -> Result<()> {
        let target = self.target;
        match self.to {
            Destination::Stream(mut stream) => stream
                .flush()
                .map_err(|e| Error::access(&target, "write", e)),
            Destination::Replaced {
                place,
                unfinished,
                file,
            } => {
                file.into_inner()
                    .map_err(std::io::IntoInnerError::into_error)
                    .and_then(|file| file.sync_all())
                    .map_err(|e| Error::access(&target, "write", e))?;
                let waiting = in_place();
                let renamed = fs::rename(unfinished.path(), &place.path);
                drop(waiting);
                renamed.map_err(|e| Error::access(&target, "put the file in place", e))?;
                unfinished.release();
                // The file is there; only after a power cut might it be the old one.
                let _ = sync(&place.parent);
                Ok(())
            }
        }
    }
}

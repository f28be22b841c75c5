//! Files that are whole or not there, and messages that name them.

use proofmass::io::AtomicFile;
use std::error::Error;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// What is wrong, where, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    place: PathBuf,
    what: String,
    hint: String,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.place.display(), self.what)?;
        match self.hint.is_empty() {
            true => Ok(()),
            false => write!(f, "; {}", self.hint),
        }
    }
}

impl Error for Refusal {}

/// A refusal of a file.
pub fn refuse(place: &Path, what: impl Into<String>, hint: impl Into<String>) -> Refusal {
    Refusal {
        place: place.to_owned(),
        what: what.into(),
        hint: hint.into(),
    }
}

/// What to do where a disk refuses.
const LOOK: &str = "look at the disk and the rights of the folder";

/// What a disk says.
pub fn disk(place: &Path) -> impl Fn(io::Error) -> Refusal {
    move |e| refuse(place, e.to_string(), LOOK)
}

/// Puts a file in the place of another in one go: a reader sees the old one or the new one.
///
/// # Errors
/// A disk that refuses.
pub fn replace(place: &Path, bytes: &[u8]) -> Result<(), Refusal> {
    let write = || {
        let mut file = AtomicFile::create(place, &[])?;
        file.write_all(bytes)?;
        file.commit()
    };
    write().map_err(|e: proofmass::io::Error| {
        let said = e.source().map_or_else(|| e.to_string(), |s| s.to_string());
        refuse(place, said, LOOK)
    })
}

/// Makes the names of a folder last.
pub(crate) fn sync_folder(place: &Path) -> io::Result<()> {
    match place.parent() {
        Some(folder) if cfg!(unix) => File::open(folder)?.sync_all(),
        _ => Ok(()),
    }
}

//! Files that are whole or not there, and messages that name them.

use std::fs::{self, File};
use std::io::{self, Write};
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

impl std::error::Error for Refusal {}

/// A refusal of a file.
pub fn refuse(place: &Path, what: impl Into<String>, hint: impl Into<String>) -> Refusal {
    Refusal {
        place: place.to_owned(),
        what: what.into(),
        hint: hint.into(),
    }
}

/// What a disk says.
pub fn disk(place: &Path) -> impl Fn(io::Error) -> Refusal {
    move |e| {
        refuse(
            place,
            e.to_string(),
            "look at the disk and the rights of the folder",
        )
    }
}

/// Puts a file in the place of another in one go: a reader sees the old one or the new one.
///
/// # Errors
/// A disk that refuses.
pub fn replace(place: &Path, bytes: &[u8]) -> Result<(), Refusal> {
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    let temporary = place.with_file_name(format!(".{name}.part"));
    let write = || {
        let mut file = File::create(&temporary)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&temporary, place)?;
        sync_folder(place)
    };
    write().map_err(disk(place))
}

/// Makes the names of a folder last.
pub(crate) fn sync_folder(place: &Path) -> io::Result<()> {
    match place.parent() {
        Some(folder) if cfg!(unix) => File::open(folder)?.sync_all(),
        _ => Ok(()),
    }
}

//! What is being written: named so that a later run knows it, locked so that it leaves it alone while it lives.

use super::place::{Lock, remove_flat};
use crate::{Error, Result};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Ending of the names of what is being written.
const ENDING: &str = ".unfinished";

/// Everything that this process is writing.
static LIVE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn live() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes everything that this process has begun to write and not finished: for a handler of Ctrl-C that ends the
/// process afterwards.
///
/// Returns once nothing is being put in place any more, so that the end of the process leaves either the old results
/// or the new ones; whoever puts something in place later waits for ever.
pub fn discard_unfinished() {
    let mut all = live();
    for path in std::mem::take(&mut *all) {
        let _ = if path.is_dir() {
            remove_flat(&path)
        } else {
            fs::remove_file(&path)
        };
    }
    // Held until the process ends.
    std::mem::forget(all);
}

/// Keeps [`discard_unfinished`] waiting while files are put in place.
pub(super) fn in_place() -> impl Drop {
    live()
}

/// A file or folder in the making; removed when it is dropped.
#[derive(Debug)]
pub(super) struct Unfinished {
    path: PathBuf,
    released: bool,
    /// The lock, which tells other runs that this one lives.
    _lock: Lock,
}

/// Beginning of the names of what will stand as `name`; long names would leave no room for the rest.
fn prefix(name: &str) -> String {
    let short: String = name.chars().take(100).collect();
    format!(".{short}-")
}

impl Unfinished {
    /// A folder that will come to stand as `name` in `parent`.
    pub fn folder(parent: &Path, name: &str) -> Result<Self> {
        Self::begin(parent, || {
            builder(&prefix(name), 0o777)
                .tempdir_in(parent)
                .map(tempfile::TempDir::keep)
        })
    }

    /// A file that will come to stand as `name` in `parent`, open for writing.
    pub fn file(parent: &Path, name: &str) -> Result<(Self, File)> {
        let mut open = None;
        let begun = Self::begin(parent, || {
            let file = builder(&prefix(name), 0o666).tempfile_in(parent)?;
            let (file, path) = file.keep().map_err(|e| e.error)?;
            open = Some(file);
            Ok(path)
        })?;
        let file = match open {
            Some(file) => file,
            None => File::options()
                .write(true)
                .open(&begun.path)
                .map_err(|e| Error::access(&begun.path, "write", e))?,
        };
        Ok((begun, file))
    }

    fn begin(parent: &Path, mut make: impl FnMut() -> std::io::Result<PathBuf>) -> Result<Self> {
        let fail = |e| Error::access(parent, "write into the folder", e);
        loop {
            // Made and listed in one: whoever discards in between would leave it behind.
            let path = {
                let mut all = live();
                let path = make().map_err(fail)?;
                all.insert(path.clone());
                path
            };
            // A run that sweeps may have come first; then there is another name.
            if let Ok(Some(lock)) = Lock::take(&path)
                && path.exists()
            {
                return Ok(Self {
                    path,
                    released: false,
                    _lock: lock,
                });
            }
            live().remove(&path);
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Forgets it without removing: it stands in its place, or something else stands where it was.
    pub fn release(mut self) {
        live().remove(&self.path);
        self.released = true;
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if self.released {
            return;
        }
        live().remove(&self.path);
        let _ = if self.path.is_dir() {
            remove_flat(&self.path)
        } else {
            fs::remove_file(&self.path)
        };
    }
}

fn builder(prefix: &str, mode: u32) -> tempfile::Builder<'_, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(ENDING);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Less the umask, as every new file.
        builder.permissions(fs::Permissions::from_mode(mode));
    }
    #[cfg(not(unix))]
    let _ = mode;
    builder
}

/// Removes what runs that were killed left of `name` in `parent`; returns what it removed.
pub(super) fn sweep(parent: &Path, name: &str) -> Vec<PathBuf> {
    let prefix = prefix(name);
    let Ok(entries) = fs::read_dir(parent) else {
        return Vec::new();
    };
    let mut swept = Vec::new();
    for entry in entries.flatten() {
        let found = entry.file_name();
        let found = found.to_string_lossy();
        let middle = found
            .strip_prefix(&prefix)
            .and_then(|rest| rest.strip_suffix(ENDING));
        // Six letters, as the names are made.
        if !middle.is_some_and(|m| m.len() == 6 && m.bytes().all(|b| b.is_ascii_alphanumeric())) {
            continue;
        }
        let path = entry.path();
        let removed = Lock::is_abandoned(&path)
            && if path.is_dir() {
                remove_flat(&path).is_ok()
            } else {
                fs::remove_file(&path).is_ok()
            };
        if removed {
            swept.push(path);
        }
    }
    swept
}

//! Places in the file system: resolved once, synchronised, locked.

use crate::{Error, ErrorKind, Result};
use std::fs;
#[cfg(unix)]
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// A place with its folder resolved, links and dots gone: later renames above it do not matter.
#[derive(Debug)]
pub(super) struct Place {
    /// Where it is.
    pub(crate) path: PathBuf,
    /// The folder it stands in.
    pub(crate) parent: PathBuf,
    /// Its last part.
    pub(crate) name: String,
    /// Folders that had to be made for it, the innermost first; removed again when nothing comes into them.
    made: Vec<PathBuf>,
}

impl Place {
    /// Resolves a path; folders above it are made where `make` says so.
    pub fn of(given: &Path, make: bool) -> Result<Self> {
        let refuse = |what: &str| {
            Err(Error::new(ErrorKind::Output, what)
                .at(given)
                .with_hint("name a new place, such as `results`"))
        };
        if let Ok(path) = given.canonicalize() {
            return match (path.parent(), path.file_name()) {
                (Some(parent), Some(name)) => Ok(Self {
                    parent: parent.to_path_buf(),
                    name: name.to_string_lossy().into_owned(),
                    path,
                    made: Vec::new(),
                }),
                _ => refuse("is no place for results"),
            };
        }
        if fs::symlink_metadata(given).is_ok_and(|m| m.is_symlink()) {
            return refuse("is a link to nothing");
        }
        let Some(name) = given.file_name() else {
            return refuse("is no place for results");
        };
        let above = match given.parent() {
            Some(p) if !p.as_os_str().is_empty() => p.to_path_buf(),
            _ => PathBuf::from("."),
        };
        let mut made = Vec::new();
        if make {
            make_folders(&above, &mut made)
                .map_err(|e| Error::access(&above, "create the folder", e))?;
        }
        let parent = above
            .canonicalize()
            .map_err(|e| Error::access(&above, "write into the folder", e))?;
        Ok(Self {
            path: parent.join(name),
            name: name.to_string_lossy().into_owned(),
            parent,
            made,
        })
    }

    /// Keeps the folders that were made.
    pub fn keep(&mut self) {
        self.made.clear();
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        for folder in &self.made {
            // Only while they are empty.
            let _ = fs::remove_dir(folder);
        }
    }
}

fn make_folders(path: &Path, made: &mut Vec<PathBuf>) -> io::Result<()> {
    if path.is_dir() || path.as_os_str().is_empty() {
        return Ok(());
    }
    if let Some(above) = path.parent() {
        make_folders(above, made)?;
    }
    match fs::create_dir(path) {
        Ok(()) => {
            made.insert(0, path.canonicalize()?);
            Ok(())
        }
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists && path.is_dir() => Ok(()),
        Err(e) => Err(e),
    }
}

/// Waits until a file, or the entries of a folder, are on the disk.
pub(super) fn sync(path: &Path) -> io::Result<()> {
    // Where there is no Unix a folder is not opened, and a file is synchronised by whoever may write it.
    if !cfg!(unix) && path.is_dir() {
        return Ok(());
    }
    let file = fs::OpenOptions::new()
        .read(true)
        .write(!cfg!(unix))
        .open(path)?;
    match file.sync_all() {
        // Some network file systems know no synchronisation of folders.
        Err(e) if path.is_dir() && e.kind() == io::ErrorKind::InvalidInput => Ok(()),
        other => other,
    }
}

/// A lock on a file or folder that ends with the process, however it ends. Nothing is held where there is no Unix: folders cannot be locked there.
#[derive(Debug)]
pub(super) struct Lock {
    #[cfg(unix)]
    _file: File,
}

impl Lock {
    /// Takes it; `None` while another process holds it.
    #[cfg(unix)]
    pub(super) fn take(path: &Path) -> io::Result<Option<Self>> {
        use rustix::fs::FlockOperation;
        let file = File::open(path)?;
        match rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => {}
            Err(rustix::io::Errno::WOULDBLOCK) => return Ok(None),
            // A file system without locks: as if nobody else were there.
            Err(rustix::io::Errno::NOTSUP | rustix::io::Errno::NOSYS) => {}
            Err(e) => return Err(e.into()),
        }
        Ok(Some(Self { _file: file }))
    }

    #[cfg(not(unix))]
    pub(super) fn take(_: &Path) -> io::Result<Option<Self>> {
        Ok(Some(Self {}))
    }

    /// Waits for that of a folder, so that two runs do not put their files in place at once.
    #[cfg(unix)]
    pub(super) fn wait(folder: &Path) -> io::Result<Self> {
        let file = File::open(folder)?;
        match rustix::fs::flock(&file, rustix::fs::FlockOperation::LockExclusive) {
            Ok(()) | Err(rustix::io::Errno::NOTSUP | rustix::io::Errno::NOSYS) => {
                Ok(Self { _file: file })
            }
            Err(e) => Err(e.into()),
        }
    }

    #[cfg(not(unix))]
    pub(super) fn wait(_: &Path) -> io::Result<Self> {
        Ok(Self {})
    }

    /// Whether the process that held it has ended. Where nothing is held nobody can tell, and it counts as alive.
    pub(super) fn is_abandoned(path: &Path) -> bool {
        cfg!(unix) && matches!(Self::take(path), Ok(Some(_)))
    }
}

/// Puts two folders in each other's place at once; `false` where the system cannot.
pub(super) fn exchange(a: &Path, b: &Path) -> bool {
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE).is_ok()
    }
    #[cfg(not(target_os = "linux"))]
    {
        let _ = (a, b);
        false
    }
}

/// Renames, or copies and synchronises where the two places are on different disks.
pub(super) fn move_file(from: &Path, to: &Path) -> io::Result<()> {
    match fs::rename(from, to) {
        Err(e) if e.kind() == io::ErrorKind::CrossesDevices => {
            fs::copy(from, to)?;
            sync(to)?;
            fs::remove_file(from)
        }
        other => other,
    }
}

/// Removes a folder and the files directly in it; folders inside are left, and it with them.
pub(super) fn remove_flat(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if !entry.file_type()?.is_dir() {
            fs::remove_file(entry.path())?;
        }
    }
    fs::remove_dir(folder)
}

//! Results appear whole or not at all: a folder or a file is written beside its place and renamed into it.

use crate::result_document::RESULT_SCHEMA;
use crate::{Error, ErrorKind, Result};
use serde::Deserialize;
use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A folder of results in the making. Dropped without [`OutputFolder::commit`] it leaves no trace.
#[derive(Debug)]
pub struct OutputFolder {
    target: PathBuf,
    temporary: tempfile::TempDir,
}

/// What a folder of results may hold, so that replacing one destroys nothing else.
const OURS: &[&str] = &[
    "json", "html", "csv", "pdf", "xml", "svg", "rs", "h", "yaml", "toml",
];

impl OutputFolder {
    /// Begins a folder that will stand at `path`.
    ///
    /// A folder that is empty, or holds earlier results of this program and nothing else, is replaced on commit.
    /// Any other is replaced only with `overwrite`, and one that holds a campaign never.
    ///
    /// # Errors
    /// The place is taken, or the folder above it cannot be written.
    pub fn create(path: impl AsRef<Path>, overwrite: bool) -> Result<Self> {
        let target = path.as_ref().to_path_buf();
        may_replace(&target, overwrite)?;
        let parent = parent(&target);
        fs::create_dir_all(&parent).map_err(|e| Error::access(&parent, "create the folder", e))?;
        let name = target
            .file_name()
            .map(|n| n.to_string_lossy().into_owned())
            .unwrap_or_default();
        let temporary = tempfile::Builder::new()
            .prefix(&format!(".{name}-"))
            .suffix(".unfinished")
            .tempdir_in(&parent)
            .map_err(|e| Error::access(&parent, "write into the folder", e))?;
        Ok(Self { target, temporary })
    }

    /// Where a file of the result is to be written before the commit. `name` must stand directly in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.temporary.path().join(name)
    }

    /// Where the folder will stand.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Writes one file.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<()> {
        let path = self.file(name);
        fs::write(&path, bytes).map_err(|e| Error::access(&path, "write", e))
    }

    /// Puts the folder in its place and returns where that is.
    ///
    /// # Errors
    /// The place was taken meanwhile, or the disk refuses; what stood there before is then still there.
    pub fn commit(self) -> Result<PathBuf> {
        // Temporary folders are private to the user; a result has the permissions of an ordinary folder.
        #[cfg(unix)]
        {
            let _ = like_parent(self.temporary.path(), &parent(&self.target));
        }
        let new = self.temporary.keep();
        let fail = |e| {
            let _ = fs::remove_dir_all(&new);
            Error::access(&self.target, "put the results in place", e)
        };
        if self.target.exists() {
            let old = new.with_extension("replaced");
            fs::rename(&self.target, &old).map_err(fail)?;
            if let Err(e) = fs::rename(&new, &self.target) {
                let _ = fs::rename(&old, &self.target);
                return Err(fail(e));
            }
            fs::remove_dir_all(&old)
                .map_err(|e| Error::access(&old, "remove the replaced results", e))?;
        } else {
            fs::rename(&new, &self.target).map_err(fail)?;
        }
        Ok(self.target)
    }
}

#[cfg(unix)]
fn like_parent(path: &Path, parent: &Path) -> std::io::Result<()> {
    fs::set_permissions(path, fs::metadata(parent)?.permissions())
}

fn parent(path: &Path) -> PathBuf {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn may_replace(target: &Path, overwrite: bool) -> Result<()> {
    let taken = |what: &str, hint: &str| {
        Err(Error::new(ErrorKind::Output, what)
            .at(target)
            .with_hint(hint))
    };
    if target.file_name().is_none() {
        return taken(
            "is no place for results",
            "name a new folder, such as `results`",
        );
    }
    let meta = match fs::symlink_metadata(target) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(Error::access(target, "look at the place for results", e)),
        Ok(meta) => meta,
    };
    if !meta.is_dir() {
        return taken(
            "is there already and is not a folder",
            "name another folder for the results",
        );
    }
    let entries = fs::read_dir(target)
        .and_then(|all| all.collect::<std::io::Result<Vec<_>>>())
        .map_err(|e| Error::access(target, "look at the place for results", e))?;
    if entries.is_empty() {
        return Ok(());
    }
    if entries.iter().any(|e| e.file_name() == "campaign.toml") {
        return taken(
            "holds a campaign, which results may not replace",
            "name another folder, such as one inside it",
        );
    }
    if overwrite {
        return Ok(());
    }
    if !written_by_us(&target.join("result.json")) {
        return taken(
            "is not empty and was not written by proofmass",
            "name another folder, or replace it with --force",
        );
    }
    let foreign = entries.iter().find(|e| {
        let file = e.file_type().is_ok_and(|t| t.is_file());
        let known = e
            .path()
            .extension()
            .is_some_and(|x| OURS.iter().any(|o| x == *o));
        !(file && known)
    });
    match foreign {
        Some(entry) => taken(
            &format!(
                "holds earlier results and also \"{}\", which would be lost",
                entry.file_name().to_string_lossy()
            ),
            "move it away, name another folder, or replace it with --force",
        ),
        None => Ok(()),
    }
}

fn written_by_us(result: &Path) -> bool {
    #[derive(Deserialize)]
    struct Head {
        schema: crate::Schema,
    }
    fs::read(result)
        .ok()
        .and_then(|bytes| serde_json::from_slice::<Head>(&bytes).ok())
        .is_some_and(|head| head.schema.name == RESULT_SCHEMA)
}

/// A file in the making, in the folder of its place. Dropped without [`AtomicFile::commit`] it leaves no trace.
#[derive(Debug)]
pub struct AtomicFile {
    target: PathBuf,
    file: BufWriter<tempfile::NamedTempFile>,
}

impl AtomicFile {
    /// Begins a file that will stand at `path`; an existing file is replaced on commit, one of `inputs` never.
    ///
    /// # Errors
    /// The place is a folder or one of the inputs, or the folder cannot be written.
    pub fn create(path: impl AsRef<Path>, inputs: &[&Path]) -> Result<Self> {
        let target = path.as_ref().to_path_buf();
        if target.is_dir() {
            return Err(Error::new(ErrorKind::Output, "is a folder, not a file")
                .at(&target)
                .with_hint("name the file to be written"));
        }
        // Links and dots resolved: the same file may have two names.
        if let Ok(there) = target.canonicalize()
            && inputs
                .iter()
                .any(|i| i.canonicalize().is_ok_and(|i| i == there))
        {
            return Err(Error::new(
                ErrorKind::Output,
                "is the input itself, which is never overwritten",
            )
            .at(&target)
            .with_hint("name another file for the output"));
        }
        let parent = parent(&target);
        let file = tempfile::Builder::new()
            .prefix(".unfinished-")
            .tempfile_in(&parent)
            .map_err(|e| Error::access(&parent, "write into the folder", e))?;
        Ok(Self {
            target,
            file: BufWriter::with_capacity(1 << 18, file),
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
        self.file
            .write_all(bytes)
            .map_err(|e| Error::access(&self.target, "write", e))
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// The disk refuses; what stood there before is then still there.
    pub fn commit(self) -> Result<()> {
        let target = self.target;
        let file = self
            .file
            .into_inner()
            .map_err(|e| Error::access(&target, "write", e.into_error()))?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As an ordinary new file: readable as far as its folder is, never executable.
            if let Ok(meta) = fs::metadata(parent(&target)) {
                let mode = meta.permissions().mode() & 0o666;
                let _ = fs::set_permissions(file.path(), fs::Permissions::from_mode(mode));
            }
        }
        file.persist(&target)
            .map_err(|e| Error::access(&target, "put the file in place", e.error))?;
        Ok(())
    }
}

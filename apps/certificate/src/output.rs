//! Files that are written whole or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use crate::error::{Error, Result};

/// Writes all files beside their places, and moves them there when every one is whole.
///
/// # Errors
/// A place that cannot be written; nothing stands there then that was not there before.
pub fn write_all(files: &[(PathBuf, Vec<u8>)]) -> Result<()> {
    let mut waiting = Vec::new();
    for (path, bytes) in files {
        waiting.push((path, beside(path, bytes).map_err(|e| refused(path, &e))?));
    }
    for (path, file) in waiting {
        file.persist(path).map_err(|e| refused(path, &e.error))?;
    }
    Ok(())
}

fn beside(path: &Path, bytes: &[u8]) -> io::Result<NamedTempFile> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    let mut builder = Builder::new();
    builder.prefix(".certificate-");
    // What the umask leaves, as for any file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder.unwrap_or(Path::new(".")))?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(file)
}

/// The places of the pictures. A picture of a page that there is not would be taken for one of this certificate.
///
/// # Errors
/// A folder that cannot be made or read, or holds such a picture.
pub fn pictures(folder: &Path, pages: Vec<Vec<u8>>) -> Result<Vec<(PathBuf, Vec<u8>)>> {
    let entries = fs::create_dir_all(folder)
        .and_then(|()| fs::read_dir(folder))
        .map_err(|e| refused(folder, &e))?;
    for entry in entries.filter_map(io::Result::ok) {
        let name = entry.file_name().to_string_lossy().into_owned();
        let page = name
            .strip_prefix("page-")
            .and_then(|n| n.strip_suffix(".png"))
            .and_then(|n| n.parse::<usize>().ok());
        if page.is_some_and(|n| n == 0 || n > pages.len()) {
            return Err(Error::new(
                format!(
                    "{name} stands there already, and is no page of this certificate, which has {}",
                    pages.len()
                ),
                "empty the folder, or name another",
            )
            .at(&folder.display().to_string()));
        }
    }
    Ok(pages
        .into_iter()
        .enumerate()
        .map(|(i, page)| (folder.join(format!("page-{}.png", i + 1)), page))
        .collect())
}

fn refused(path: &Path, error: &io::Error) -> Error {
    Error::new(
        format!("it cannot be written: {error}"),
        "name a place that you may write to",
    )
    .at(&path.display().to_string())
}

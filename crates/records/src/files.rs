//! Files by their digest: small ones inside the database, larger ones in a folder beside it.

use crate::engine::{Engine, Value};
use crate::entry::sha256;
use proofmass_io::AtomicFile;
use proofmass_jobs::{Result, Trouble, TroubleKind};
use std::path::{Path, PathBuf};

/// Where a file with this digest stands in the folder.
pub(crate) fn place(folder: &Path, digest: &str) -> PathBuf {
    folder
        .join(digest.get(..2).unwrap_or_default())
        .join(digest)
}

/// Keeps bytes, once. A file beside the database is on the disk before an entry names it.
pub(crate) fn put(
    engine: &mut dyn Engine,
    beside: Option<&Path>,
    digest: &str,
    bytes: &[u8],
    inside: usize,
) -> Result<()> {
    let known = engine.rows("SELECT size FROM file WHERE digest = ?1", &[digest.into()])?;
    if !known.is_empty() {
        return Ok(());
    }
    let content = match beside {
        Some(folder) if bytes.len() > inside => {
            let place = place(folder, digest);
            if let Some(parent) = place.parent() {
                std::fs::create_dir_all(parent).map_err(|e| refused(parent, &e))?;
            }
            let mut file = AtomicFile::create(&place, &[])?;
            file.write_all(bytes)?;
            file.commit()?;
            Value::Null
        }
        _ => Value::Bytes(bytes.to_vec()),
    };
    engine.run(
        "INSERT INTO file (digest, size, content) VALUES (?1, ?2, ?3)",
        &[digest.into(), (bytes.len() as i64).into(), content],
    )?;
    Ok(())
}

/// The bytes of a digest, `None` where they are not kept.
pub(crate) fn get(
    engine: &mut dyn Engine,
    beside: Option<&Path>,
    digest: &str,
) -> Result<Option<Vec<u8>>> {
    let rows = engine.rows(
        "SELECT size, content FROM file WHERE digest = ?1",
        &[digest.into()],
    )?;
    let Some(row) = rows.into_iter().next() else {
        return Ok(None);
    };
    let bytes = match (&row[1], beside) {
        (Value::Bytes(bytes), _) => bytes.clone(),
        (_, Some(folder)) => {
            let place = place(folder, digest);
            std::fs::read(&place).map_err(|e| {
                Trouble::data(format!("{}: {e}", place.display())).with_hint(
                    "the folder of files belongs to the records: take it from the last backup",
                )
            })?
        }
        _ => return Ok(None),
    };
    if sha256(&[&bytes]) != digest || row[0].integer() != Some(bytes.len() as i64) {
        return Err(
            Trouble::data(format!("the kept file {digest} was changed or damaged"))
                .with_hint("take it from the last backup, or from where it came from"),
        );
    }
    Ok(Some(bytes))
}

/// Copies the files that are not there yet.
pub(crate) fn copy_folder(from: &Path, to: &Path) -> Result<()> {
    for group in std::fs::read_dir(from)
        .map_err(|e| refused(from, &e))?
        .flatten()
    {
        if !group.path().is_dir() {
            continue;
        }
        let folder = to.join(group.file_name());
        std::fs::create_dir_all(&folder).map_err(|e| refused(&folder, &e))?;
        for file in std::fs::read_dir(group.path())
            .map_err(|e| refused(&group.path(), &e))?
            .flatten()
        {
            // What is being written has another name than a digest.
            let name = file.file_name();
            let target = folder.join(&name);
            if name.len() == 64 && !target.exists() {
                let bytes = std::fs::read(file.path()).map_err(|e| refused(&file.path(), &e))?;
                let mut copy = AtomicFile::create(&target, &[])?;
                copy.write_all(&bytes)?;
                copy.commit()?;
            }
        }
    }
    Ok(())
}

/// What the disk refused.
pub(crate) fn refused(place: &Path, error: &std::io::Error) -> Trouble {
    Trouble::new(TroubleKind::Output, format!("{}: {error}", place.display()))
        .with_hint("make room on the disk, or ask for the permission to write there")
}

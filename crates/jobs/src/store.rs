//! Where the files of a job stand: a folder, memory, later an archive or an object store.

use crate::trouble::{Result, Trouble};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Files by name. Names are those of the campaign, relative to it, with `/` between folders.
pub trait Store {
    /// Opens a file for reading once, from its beginning.
    ///
    /// # Errors
    /// No such file, or it cannot be read.
    fn open(&self, name: &str) -> Result<Box<dyn Read + Send>>;

    /// The name of a file as it stands in messages and in lists of inputs.
    fn describe(&self, name: &str) -> PathBuf {
        PathBuf::from(name)
    }

    /// A whole small file, such as a table.
    ///
    /// # Errors
    /// As [`Store::open`].
    fn read(&self, name: &str) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.open(name)?.read_to_end(&mut bytes).map_err(|e| {
            Trouble::data(format!(
                "{}: cannot read: {e}",
                self.describe(name).display()
            ))
        })?;
        Ok(bytes)
    }
}

/// A folder of the file system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folder {
    root: PathBuf,
}

impl Folder {
    /// The folder that names are relative to.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }
}

impl Store for Folder {
    fn open(&self, name: &str) -> Result<Box<dyn Read + Send>> {
        let path = self.describe(name);
        let file = std::fs::File::open(&path)
            .map_err(|e| proofmass_io::Error::access(&path, "open", e))?;
        Ok(Box::new(file))
    }

    fn describe(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }
}

/// Files in memory: the parts of a request over a network, the cells of a notebook, a test.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    files: BTreeMap<String, Vec<u8>>,
}

impl Memory {
    /// Without files.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file.
    #[must_use]
    pub fn file(mut self, name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        self.files.insert(name.into(), bytes.into());
        self
    }
}

impl Store for Memory {
    fn open(&self, name: &str) -> Result<Box<dyn Read + Send>> {
        match self.files.get(name) {
            Some(bytes) => Ok(Box::new(std::io::Cursor::new(bytes.clone()))),
            None => {
                let names: Vec<&str> = self.files.keys().map(String::as_str).collect();
                Err(Trouble::data(format!("{name}: there is no such file"))
                    .with_hint(format!("files given: {}", names.join(", "))))
            }
        }
    }
}

//! Where the files of a job stand: a folder, memory, later an archive or an object store.

use proofmass_io::{Error, ErrorKind, OutputFolder, Result, Source};
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Mutex;

/// Files by name. Names are those of the campaign, relative to it, with `/` between folders.
pub trait Store: Send + Sync {
    /// Opens a file for reading once, from its beginning.
    ///
    /// # Errors
    /// No such file, or it cannot be read.
    fn open(&self, name: &str) -> Result<Source>;

    /// Whether there is such a file: a missing one is told before the work.
    fn holds(&self, name: &str) -> bool;

    /// The name of a file as it stands in messages and in lists of inputs.
    fn describe(&self, name: &str) -> PathBuf {
        PathBuf::from(name)
    }
}

/// Where files go one by one, from whatever thread.
pub trait Sink: Send + Sync {
    /// Writes a file.
    ///
    /// # Errors
    /// A name that cannot be, a disk that refuses.
    fn write(&self, name: &str, bytes: Vec<u8>) -> Result<()>;
}

impl Sink for OutputFolder {
    fn write(&self, name: &str, bytes: Vec<u8>) -> Result<()> {
        OutputFolder::write(self, name, bytes)
    }
}

/// Files that were written into memory.
#[derive(Debug, Default)]
pub struct Gathered {
    files: Mutex<BTreeMap<String, Vec<u8>>>,
}

impl Gathered {
    /// The files, to be read.
    pub fn into_memory(self) -> Memory {
        Memory {
            files: self.files.into_inner().unwrap_or_default(),
        }
    }
}

impl Sink for Gathered {
    fn write(&self, name: &str, bytes: Vec<u8>) -> Result<()> {
        match self.files.lock() {
            Ok(mut files) => {
                files.insert(name.to_owned(), bytes);
                Ok(())
            }
            Err(_) => Err(Error::new(
                ErrorKind::Output,
                "a writer of another thread ended while it wrote",
            )
            .at(Path::new(name))),
        }
    }
}

/// A folder of the file system.
///
/// An absolute name, `..` and links are followed wherever they lead: a campaign names any file that its reader may
/// read. [`Folder::contained`] follows them no further than the folder itself, for campaigns of strangers.
///
/// ```
/// use proofmass_jobs::{Folder, Store};
/// let folder = Folder::new("examples").contained();
/// let message = folder.open("../Cargo.toml").err().unwrap().to_string();
/// assert!(message.contains("outside of the folder of the campaign"), "{message}");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folder {
    root: PathBuf,
    contained: bool,
}

impl Folder {
    /// The folder that names are relative to.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self {
            root: root.into(),
            contained: false,
        }
    }

    /// Refuses every name that leads out of the folder: absolute ones, those with `..` and links.
    #[must_use]
    pub fn contained(mut self) -> Self {
        self.contained = true;
        self
    }

    /// Whether a name leads out of the folder, by itself or by a link.
    pub fn leads_out(&self, name: &str) -> bool {
        let plain = Path::new(name)
            .components()
            .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        // What is not there leads nowhere else.
        let linked = || {
            let root = match self.root.as_os_str().is_empty() {
                true => Path::new(".").canonicalize(),
                false => self.root.canonicalize(),
            };
            match (root, self.describe(name).canonicalize()) {
                (Ok(root), Ok(file)) => !file.starts_with(root),
                _ => false,
            }
        };
        !plain || linked()
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }
}

impl Store for Folder {
    fn open(&self, name: &str) -> Result<Source> {
        if self.contained && self.leads_out(name) {
            return Err(Error::new(
                ErrorKind::Access,
                "lies outside of the folder of the campaign",
            )
            .at(&self.describe(name))
            .with_hint(
                "copy the file into the folder of campaign.toml, or allow it where the campaign is trusted",
            ));
        }
        Source::open(self.describe(name))
    }

    fn holds(&self, name: &str) -> bool {
        let place = self.describe(name);
        proofmass_io::is_lent(&place) || place.exists()
    }

    fn describe(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }
}

/// Files in memory: the parts of a request over a network, the cells of a notebook, a test.
///
/// ```
/// use proofmass_jobs::{Memory, Store};
///
/// let store = Memory::new().file("runs.csv", "run,frequency_Hz\n");
/// assert!(store.holds("runs.csv"));
/// let message = store.open("reference.csv").err().unwrap().to_string();
/// assert_eq!(message, "reference.csv: there is no such file");
/// ```
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
    fn open(&self, name: &str) -> Result<Source> {
        match self.files.get(name) {
            Some(bytes) => Source::from_bytes(name, bytes.clone()),
            None => {
                let names: Vec<&str> = self.files.keys().map(String::as_str).collect();
                Err(Error::new(ErrorKind::NotFound, "there is no such file")
                    .at(Path::new(name))
                    .with_hint(format!("files given: {}", names.join(", "))))
            }
        }
    }

    fn holds(&self, name: &str) -> bool {
        self.files.contains_key(name)
    }
}

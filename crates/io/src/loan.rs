//! Bytes of the caller that stand under a name while they are lent: a recording that is in memory already.

use std::cell::RefCell;
use std::io::{self, Read, Seek, SeekFrom};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Content in two pieces, neither of which is copied: a head that describes, and the numbers of somebody else.
pub struct Content {
    head: Vec<u8>,
    body: Box<dyn AsRef<[u8]> + Send + Sync>,
}

impl Content {
    /// A head and what follows it.
    pub fn new(head: impl Into<Vec<u8>>, body: impl AsRef<[u8]> + Send + Sync + 'static) -> Self {
        Self {
            head: head.into(),
            body: Box::new(body),
        }
    }

    fn body(&self) -> &[u8] {
        (*self.body).as_ref()
    }

    /// Bytes in all.
    pub(crate) fn size(&self) -> u64 {
        (self.head.len() + self.body().len()) as u64
    }
}

/// Reads a content from its beginning.
pub(crate) struct ContentReader {
    content: Arc<Content>,
    at: u64,
}

impl ContentReader {
    pub(crate) fn new(content: Arc<Content>) -> Self {
        Self { content, at: 0 }
    }
}

impl Read for ContentReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let at = usize::try_from(self.at).unwrap_or(usize::MAX);
        let (head, body) = (&self.content.head, self.content.body());
        let left = match at.checked_sub(head.len()) {
            None => &head[at..],
            Some(at) => body.get(at..).unwrap_or_default(),
        };
        let n = buffer.len().min(left.len());
        buffer[..n].copy_from_slice(&left[..n]);
        self.at += n as u64;
        Ok(n)
    }
}

impl Seek for ContentReader {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let (from, by) = match to {
            SeekFrom::Start(at) => (at, 0),
            SeekFrom::Current(by) => (self.at, by),
            SeekFrom::End(by) => (self.content.size(), by),
        };
        let before = || io::Error::new(io::ErrorKind::InvalidInput, "before the beginning");
        self.at = from.checked_add_signed(by).ok_or_else(before)?;
        Ok(self.at)
    }
}

thread_local! {
    static LENT: RefCell<Vec<(PathBuf, Arc<Content>)>> = const { RefCell::new(Vec::new()) };
}

/// While it lives, its name opens the content in the thread that lent it.
#[must_use = "the loan ends when it is dropped"]
pub struct Loan {
    name: PathBuf,
    /// It belongs to the thread.
    _here: PhantomData<*const ()>,
}

impl Drop for Loan {
    fn drop(&mut self) {
        LENT.with_borrow_mut(|lent| {
            if let Some(k) = lent.iter().rposition(|(name, _)| *name == self.name) {
                lent.remove(k);
            }
        });
    }
}

/// Lends a content: [`Source::open`](crate::Source::open) of this name reads it, in this thread, in the place of a file.
///
/// ```
/// use proofmass_io::{Content, Source, lend};
///
/// let loan = lend("array", Content::new("time_s,acc_g\n", "0.00,1.0\n0.01,1.5\n"));
/// let (bytes, input) = Source::open("array")?.into_bytes(1000)?;
/// assert_eq!((bytes.len(), input.path.as_str()), (31, "array"));
/// drop(loan);
/// assert!(Source::open("array").is_err());
/// # Ok::<(), proofmass_io::Error>(())
/// ```
pub fn lend(name: impl Into<PathBuf>, content: Content) -> Loan {
    let name = name.into();
    LENT.with_borrow_mut(|lent| lent.push((name.clone(), Arc::new(content))));
    Loan {
        name,
        _here: PhantomData,
    }
}

/// The content that is lent under a name.
pub(crate) fn lent(name: &Path) -> Option<Arc<Content>> {
    LENT.with_borrow(|lent| {
        let found = lent.iter().rev().find(|(known, _)| known == name);
        found.map(|(_, content)| Arc::clone(content))
    })
}

/// Whether a content is lent under a name.
pub fn is_lent(name: &Path) -> bool {
    lent(name).is_some()
}

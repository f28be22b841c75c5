//! Where bytes come from: a file, a pipe, standard input or memory, plain or compressed; read once, from front to end.

mod utf16;
mod zstd;

use crate::digest::hexadecimal;
use crate::layout::LayoutOptions;
use crate::loan::{self, Content, ContentReader};
use crate::provenance::doubt_of;
use crate::stream::Opened;
use crate::{Error, ErrorKind, Input, Result};
use flate2::read::MultiGzDecoder;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use utf16::Utf16Reader;
use zstd::ZstdReader;

/// Most bytes of a document that has to be held whole: a campaign, a table, a calibration, a result.
pub const LARGEST_DOCUMENT: u64 = 64 << 20;

/// Most bytes of content that are held to learn whether a source of unknown size is a long one.
const LONG: usize = 48 << 20;

/// Most bytes of a pipe or a packed file that are held for a reader that jumps.
const LARGEST_HELD: usize = 256 << 20;

/// A packed file that is held may unpack to so many bytes, and to so many more for each of its bytes.
const UNPACKED: usize = 8 << 20;
const FOR_EACH_BYTE: u64 = 64;

/// Bytes that are asked of the system at once.
const PIECE: usize = 1 << 16;

/// A stream of bytes with a name, opened once and read once.
///
/// gzip and zstd are recognised by their first bytes, whatever the name says, and come out unpacked; so is a text in UTF-16 with a byte
/// order mark, which comes out in UTF-8. The SHA-256
/// belongs to the bytes as they came, so that `sha256sum` of the file gives the same.
///
/// ```
/// use proofmass_io::{Recording, RecordingOptions, Source};
///
/// let text: &[u8] = b"time_s,acc_g\n0.00,1.0\n0.01,1.5\n";
/// let source = Source::new("measured over the wire", text)?;
/// let options = RecordingOptions { columns: vec!["acc".into()], ..RecordingOptions::default() };
/// let recording = Recording::from_source(source, &options)?;
/// assert_eq!(recording.columns[0].data, [1.0, 1.5]);
/// # Ok::<(), proofmass_io::Error>(())
/// ```
pub struct Source {
    name: PathBuf,
    size: Option<u64>,
    body: Body,
    /// Read ahead of the caller.
    head: Vec<u8>,
    at: usize,
    /// The end of the content was seen.
    at_end: bool,
    /// A file that can be opened a second time under its name.
    is_file: bool,
    /// Content in memory that can be read a second time.
    lent: Option<Arc<Content>>,
    /// Which stream of a file with several.
    pub(crate) stream: Option<String>,
    /// Numbers as stored, without the scaling that the file declares.
    pub(crate) as_stored: bool,
    /// What somebody says of its shape, where it is a text.
    pub(crate) layout: LayoutOptions,
    /// Files beside it that it names.
    beside: Vec<PathBuf>,
    /// What lies ahead, where it is no text and was looked at.
    pub(crate) opened: Option<Opened>,
}

enum Body {
    Plain(Tap),
    Gzip(Box<MultiGzDecoder<Tap>>),
    Zstd(Box<ZstdReader<Tap>>),
    /// Of a text in UTF-16 with a byte order mark, in UTF-8.
    Utf16(Box<Utf16Reader<Tap>>),
}

/// Counts and digests what passes.
struct Tap {
    reader: Box<dyn Read + Send>,
    /// The first bytes, taken for a look and given back.
    first: Vec<u8>,
    given: usize,
    hash: Sha256,
    bytes: u64,
    /// The system itself refused, so that the content is not to blame.
    refused: Option<io::ErrorKind>,
}

impl Tap {
    fn pull(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.reader.read(buffer) {
                Ok(n) => {
                    self.hash.update(&buffer[..n]);
                    self.bytes += n as u64;
                    return Ok(n);
                }
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => {
                    self.refused = Some(e.kind());
                    return Err(e);
                }
            }
        }
    }
}

impl Read for Tap {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.given < self.first.len() {
            let n = buffer.len().min(self.first.len() - self.given);
            buffer[..n].copy_from_slice(&self.first[self.given..self.given + n]);
            self.given += n;
            return Ok(n);
        }
        self.pull(buffer)
    }
}

impl Source {
    /// Opens a file, a named pipe, what is [lent](crate::lend) under the name or, for `-`, standard input.
    ///
    /// # Errors
    /// Nothing there, a folder, no permission.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        if path == Path::new("-") {
            return Self::new("-", io::stdin());
        }
        if let Some(content) = loan::lent(path) {
            let mut source = Self::new(path, ContentReader::new(Arc::clone(&content)))?;
            source.size = Some(content.size());
            source.lent = Some(content);
            return Ok(source);
        }
        let folder = || {
            Error::new(ErrorKind::Format, "is a folder, not a file")
                .at(path)
                .with_hint("name a file in it: calibration.json for a calibration, result.json for a result")
        };
        // Windows refuses to open one.
        let file = File::open(path).map_err(|e| match path.is_dir() {
            true => folder(),
            false => Error::access(path, "open", e),
        })?;
        let meta = file
            .metadata()
            .map_err(|e| Error::access(path, "open", e))?;
        if meta.is_dir() {
            return Err(folder());
        }
        let mut source = Self::new(path, file)?;
        source.size = meta.is_file().then_some(meta.len());
        source.is_file = meta.is_file();
        Ok(source)
    }

    /// From any reader; `name` stands in messages and in the list of inputs.
    ///
    /// # Errors
    /// The reader refuses its first bytes.
    pub fn new(name: impl Into<PathBuf>, reader: impl Read + Send + 'static) -> Result<Self> {
        Self::boxed(name.into(), Box::new(reader))
    }

    /// From bytes in memory.
    ///
    /// # Errors
    /// None in practice: memory does not refuse.
    pub fn from_bytes(name: impl Into<PathBuf>, bytes: impl Into<Vec<u8>>) -> Result<Self> {
        let bytes = bytes.into();
        let size = bytes.len() as u64;
        let mut source = Self::new(name, io::Cursor::new(bytes))?;
        source.size = Some(size);
        Ok(source)
    }

    fn boxed(name: PathBuf, reader: Box<dyn Read + Send>) -> Result<Self> {
        let mut tap = Tap {
            reader,
            first: Vec::new(),
            given: 0,
            hash: Sha256::new(),
            bytes: 0,
            refused: None,
        };
        let mut first = [0; 4];
        let mut known = 0;
        while known < first.len() {
            match tap.pull(&mut first[known..]) {
                Ok(0) => break,
                Ok(n) => known += n,
                Err(e) => return Err(Error::access(&name, "read", e)),
            }
        }
        tap.first = first[..known].to_vec();
        let body = match tap.first[..] {
            [0x1F, 0x8B, ..] => Body::Gzip(Box::new(MultiGzDecoder::new(tap))),
            // A frame, or one of the sixteen forms of a frame that is to be skipped.
            [0x28, 0xB5, 0x2F, 0xFD] | [0x50..=0x5F, 0x2A, 0x4D, 0x18] => {
                Body::Zstd(Box::new(ZstdReader::new(tap)))
            }
            // A byte order mark with a Latin character behind it.
            [0xFF, 0xFE, _, 0] => Body::Utf16(Box::new(Utf16Reader::new(tap, false))),
            [0xFE, 0xFF, 0, _] => Body::Utf16(Box::new(Utf16Reader::new(tap, true))),
            _ => Body::Plain(tap),
        };
        Ok(Self {
            name,
            size: None,
            body,
            head: Vec::new(),
            at: 0,
            at_end: false,
            is_file: false,
            lent: None,
            stream: None,
            as_stored: false,
            layout: LayoutOptions::default(),
            beside: Vec::new(),
            opened: None,
        })
    }

    /// Chooses one of the streams of a file that holds several, by its name; `as_stored` leaves off the scaling that the file declares.
    #[must_use]
    pub fn with_stream(mut self, name: Option<&str>, as_stored: bool) -> Self {
        if let Some(name) = name {
            self.stream = Some(name.to_owned());
            self.opened = None;
        }
        if as_stored {
            self.as_stored = true;
            self.opened = None;
        }
        self
    }

    /// States the shape of a text, for every look at it whose own options leave that open.
    pub fn state_layout(&mut self, layout: LayoutOptions) {
        self.layout = layout;
    }

    /// The content as something in which a reader can jump: the file opened a second time, or held in memory where it came through
    /// a pipe or was unpacked. What is read here stays ahead, for the digest.
    pub(crate) fn seekable(&mut self) -> Result<Box<dyn proofmass_formats::SeekRead>> {
        if self.is_file && matches!(self.body, Body::Plain(_)) {
            let file = File::open(&self.name).map_err(|e| Error::access(&self.name, "open", e))?;
            return Ok(Box::new(file));
        }
        if let (Some(content), Body::Plain(_)) = (&self.lent, &self.body) {
            return Ok(Box::new(ContentReader::new(Arc::clone(content))));
        }
        let mut wanted = UNPACKED;
        while !self.ahead(wanted)?.1 && wanted < LARGEST_HELD {
            let packed = !matches!(self.body, Body::Plain(_));
            let most = self.bytes_read().saturating_mul(FOR_EACH_BYTE);
            if packed && (wanted - UNPACKED) as u64 > most {
                let what = format!(
                    "unpacks to more than {}, {} times its size",
                    size_in_words(wanted as u64),
                    wanted as u64 / self.bytes_read().max(1)
                );
                return Err(Error::new(ErrorKind::Format, what)
                    .with_hint("unpack it, look at it, and name what came out"));
            }
            wanted = (wanted + UNPACKED).min(LARGEST_HELD);
        }
        let (content, at_end) = self.ahead(LARGEST_HELD)?;
        if !at_end && content.len() >= LARGEST_HELD {
            let what = format!(
                "is of a format in which a reader has to jump, and more than the {} that are held of a pipe or a packed file",
                size_in_words(LARGEST_HELD as u64)
            );
            return Err(Error::new(ErrorKind::Format, what)
                .with_hint("unpack it, or write it to a file, and name that"));
        }
        Ok(Box::new(io::Cursor::new(content.to_vec())))
    }

    /// A file beside this one, by its name alone; none where nothing is there, or where this one came through a pipe or packed.
    pub(crate) fn beside(
        &mut self,
        name: &str,
    ) -> io::Result<Option<Box<dyn proofmass_formats::SeekRead>>> {
        let place = self.name.with_file_name(name);
        if !self.is_file || !matches!(self.body, Body::Plain(_)) || !place.is_file() {
            return Ok(None);
        }
        // A link may lead to anything that the reader of the program may read.
        let folder = place.parent().filter(|p| !p.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize()?;
        if place.canonicalize()?.parent() != Some(&folder) {
            return Ok(None);
        }
        let file = File::open(&place)?;
        if !self.beside.contains(&place) {
            self.beside.push(place);
        }
        Ok(Some(Box::new(file)))
    }

    /// The name that stands in messages and in the list of inputs.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// Size of the file as it stands, where it is known beforehand.
    pub fn size(&self) -> Option<u64> {
        self.size
    }

    /// Bytes taken in so far, as they stand in the file: for a display of progress against [`Source::size`].
    pub fn bytes_read(&self) -> u64 {
        self.tap().bytes
    }

    /// About how many lines there are, by the length of those that lie ahead; `None` where the size is not known
    /// beforehand. Nothing is consumed.
    ///
    /// # Errors
    /// The system's own, damaged compression.
    pub fn lines_expected(&mut self) -> Result<Option<u64>> {
        // What cannot be opened is refused by whoever reads it.
        if let Ok(true) = crate::stream::open(self) {
            let streams = self.opened.iter().flat_map(|o| &o.streams);
            return Ok(streams.map(|s| s.rows).max());
        }
        let Some(size) = self.size else {
            return Ok(None);
        };
        let (ahead, at_end) = self.ahead(PIECE)?;
        let (seen, bytes) = (memchr::memchr_iter(b'\n', ahead).count(), ahead.len());
        if at_end || bytes == 0 {
            return Ok(Some(seen as u64));
        }
        // Packed bytes taken in so far gave so many lines.
        let taken = match self.body {
            Body::Plain(_) => bytes as u64,
            _ => self.bytes_read().max(1),
        };
        Ok(Some((seen as f64 * size as f64 / taken as f64) as u64))
    }

    /// Whether the recording is too long to be held: more than so many lines, by the size of the file. Nobody knows the
    /// size of what comes through a pipe: it is long where its content goes on beyond 48 MiB. Nothing is consumed.
    ///
    /// # Errors
    /// The system's own, damaged compression.
    pub fn is_longer_than(&mut self, lines: u64) -> Result<bool> {
        match self.lines_expected()? {
            Some(expected) => Ok(expected > lines),
            None => Ok(!self.ahead(LONG)?.1),
        }
    }

    /// The whole content, where it has no more than `limit` bytes, and its digest.
    ///
    /// # Errors
    /// More bytes than that, damaged compression, the system's own.
    pub fn into_bytes(mut self, limit: u64) -> Result<(Vec<u8>, Input)> {
        let mut bytes = Vec::new();
        loop {
            let more = self.fill(&mut bytes, PIECE)?;
            if bytes.len() as u64 > limit {
                return Err(Error::new(
                    ErrorKind::Format,
                    format!("holds more than {}, the most that is read of such a file", size_in_words(limit)),
                )
                .at(&self.name)
                .with_hint("name the right file: one that never ends, such as a device, has no content to read"));
            }
            if !more {
                break;
            }
        }
        let input = self.finish()?;
        Ok((bytes, input))
    }

    /// What lies ahead, at least `bytes` of it where there are so many; nothing is consumed. The flag tells whether
    /// that is all there is.
    pub(crate) fn ahead(&mut self, bytes: usize) -> Result<(&[u8], bool)> {
        while self.head.len() - self.at < bytes && !self.at_end {
            let mut head = std::mem::take(&mut self.head);
            let wanted = bytes - (head.len() - self.at);
            let read = self.read_content(&mut head, wanted);
            self.head = head;
            read?;
        }
        Ok((&self.head[self.at..], self.at_end))
    }

    /// Appends up to `bytes` bytes; `false` at the end of the content.
    pub(crate) fn fill(&mut self, to: &mut Vec<u8>, bytes: usize) -> Result<bool> {
        let mut wanted = bytes;
        if self.at < self.head.len() {
            let n = wanted.min(self.head.len() - self.at);
            to.extend_from_slice(&self.head[self.at..self.at + n]);
            self.at += n;
            wanted -= n;
            if self.at == self.head.len() {
                self.head = Vec::new();
                self.at = 0;
            }
        }
        if wanted > 0 && !self.at_end {
            self.read_content(to, wanted)?;
        }
        Ok(!(self.at_end && self.head.len() == self.at))
    }

    /// Reads `bytes` bytes of content, or to its end.
    fn read_content(&mut self, to: &mut Vec<u8>, bytes: usize) -> Result<()> {
        let reader: &mut dyn Read = match &mut self.body {
            Body::Plain(tap) => tap,
            Body::Gzip(gzip) => gzip,
            Body::Zstd(zstd) => zstd,
            Body::Utf16(text) => text,
        };
        match reader.take(bytes as u64).read_to_end(to) {
            Ok(got) => {
                self.at_end = got < bytes;
                Ok(())
            }
            Err(e) => Err(self.refusal(e)),
        }
    }

    fn refusal(&self, e: io::Error) -> Error {
        let form = match self.body {
            Body::Gzip(_) => "gzip",
            Body::Zstd(_) => "zstd",
            Body::Plain(_) | Body::Utf16(_) => return Error::access(&self.name, "read", e),
        };
        if self.tap().refused.is_some() {
            return Error::access(&self.name, "read", e);
        }
        Error::new(
            ErrorKind::Format,
            format!("the {form} data are damaged or cut short: {e}"),
        )
        .at(&self.name)
        .with_hint("fetch or pack the file again; nothing is taken from a damaged one")
        .because(e)
    }

    /// Name and digest of what was read, once all of it was.
    ///
    /// # Errors
    /// The rest cannot be read.
    pub fn finish(mut self) -> Result<Input> {
        let mut rest = Vec::new();
        while !self.at_end {
            rest.clear();
            self.read_content(&mut rest, PIECE)?;
        }
        let tap = match self.body {
            Body::Plain(tap) => tap,
            Body::Gzip(gzip) => gzip.into_inner(),
            Body::Zstd(zstd) => zstd.into_inner(),
            Body::Utf16(text) => text.into_inner(),
        };
        let sha256 = hexadecimal(&tap.hash.finalize());
        let beside = self.beside.iter().map(|path| Input::of(path));
        Ok(Input {
            beside: beside.collect::<Result<_>>()?,
            path: self.name.display().to_string(),
            reading: None,
            doubt: match self.is_file {
                true => doubt_of(&self.name, &sha256),
                false => None,
            },
            sha256,
        })
    }

    fn tap(&self) -> &Tap {
        match &self.body {
            Body::Plain(tap) => tap,
            Body::Gzip(gzip) => gzip.get_ref(),
            Body::Zstd(zstd) => zstd.get_ref(),
            Body::Utf16(text) => text.get_ref(),
        }
    }
}

impl Read for Source {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.at < self.head.len() {
            let n = buffer.len().min(self.head.len() - self.at);
            buffer[..n].copy_from_slice(&self.head[self.at..self.at + n]);
            self.at += n;
            return Ok(n);
        }
        if self.at_end || buffer.is_empty() {
            return Ok(0);
        }
        let n = match &mut self.body {
            Body::Plain(tap) => tap.read(buffer),
            Body::Gzip(gzip) => gzip.read(buffer),
            Body::Zstd(zstd) => zstd.read(buffer),
            Body::Utf16(text) => text.read(buffer),
        }?;
        self.at_end = n == 0;
        Ok(n)
    }
}

impl std::fmt::Debug for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Source")
            .field("name", &self.name)
            .field("size", &self.size)
            .finish_non_exhaustive()
    }
}

fn size_in_words(bytes: u64) -> String {
    match bytes {
        b if b >= 1 << 30 => format!("{} GiB", b >> 30),
        b if b >= 1 << 20 => format!("{} MiB", b >> 20),
        b => format!("{b} bytes"),
    }
}

//! What the typesetter sees: its layout, the sheet as a file of data, drawings and attachments. No other file, no package, no
//! font of the machine, no clock.

use std::collections::HashMap;

use typst::diag::{FileError, FileResult};
use typst::foundations::{Bytes, Datetime, Duration};
use typst::syntax::{FileId, RootedPath, Source, VirtualPath, VirtualRoot};
use typst::text::{Font, FontBook};
use typst::utils::LazyHash;
use typst::{Library, LibraryExt, World};

use crate::fonts::FONTS;
use crate::sheet::Sheet;

const LAYOUT: [(&str, &str); 5] = [
    ("main.typ", include_str!("../layout/main.typ")),
    ("page.typ", include_str!("../layout/page.typ")),
    ("runs.typ", include_str!("../layout/runs.typ")),
    ("table.typ", include_str!("../layout/table.typ")),
    ("blocks.typ", include_str!("../layout/blocks.typ")),
];

/// The files of one certificate.
pub struct Desk {
    library: LazyHash<Library>,
    book: LazyHash<FontBook>,
    main: FileId,
    sources: HashMap<FileId, Source>,
    files: HashMap<FileId, Bytes>,
}

impl Desk {
    /// With the layout of certificates.
    pub fn new(sheet: &Sheet) -> Self {
        let files = sheet
            .files
            .iter()
            .map(|file| (id(&file.name), Bytes::new(file.bytes.clone())));
        let data = Bytes::new(sheet.data.to_string().into_bytes());
        Self {
            library: LazyHash::new(Library::default()),
            book: LazyHash::new(FontBook::from_fonts(FONTS.iter())),
            main: id(LAYOUT[0].0),
            sources: LAYOUT
                .iter()
                .map(|(name, text)| (id(name), Source::new(id(name), (*text).to_owned())))
                .collect(),
            files: files.chain([(id("sheet.json"), data)]).collect(),
        }
    }

    /// With one formula or one drawing alone, to find the one that cannot be laid out. The layout `text` reads `probe` as data.
    pub fn probe(text: &str, probe: &[u8]) -> Self {
        let main = id("probe.typ");
        Self {
            library: LazyHash::new(Library::default()),
            book: LazyHash::new(FontBook::from_fonts(FONTS.iter())),
            main,
            sources: HashMap::from([(main, Source::new(main, text.to_owned()))]),
            files: HashMap::from([(id("probe"), Bytes::new(probe.to_vec()))]),
        }
    }
}

fn id(name: &str) -> FileId {
    let path = VirtualPath::new(name).expect("the names are plain");
    RootedPath::new(VirtualRoot::Project, path).intern()
}

impl World for Desk {
    fn library(&self) -> &LazyHash<Library> {
        &self.library
    }

    fn book(&self) -> &LazyHash<FontBook> {
        &self.book
    }

    fn main(&self) -> FileId {
        self.main
    }

    fn source(&self, id: FileId) -> FileResult<Source> {
        self.sources.get(&id).cloned().ok_or_else(|| missing(id))
    }

    fn file(&self, id: FileId) -> FileResult<Bytes> {
        self.files.get(&id).cloned().ok_or_else(|| missing(id))
    }

    fn font(&self, index: usize) -> Option<Font> {
        FONTS.get(index).cloned()
    }

    fn today(&self, _: Option<Duration>) -> Option<Datetime> {
        None
    }
}

fn missing(id: FileId) -> FileError {
    FileError::NotFound(id.vpath().get_without_slash().into())
}

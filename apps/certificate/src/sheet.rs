//! A sheet: a certificate as data, every word of it already written. Read once, checked throughout, handed to the layout as
//! data; nothing of it ever becomes markup.

use std::collections::HashSet;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use typst::foundations::Datetime;

use crate::error::{Error, Result};
use crate::place::Place;
use crate::{drawing, fonts, mathematics};

/// The one form that is known.
const FORM: i64 = 1;

/// A sheet that can be laid out.
pub struct Sheet {
    /// What the layout reads; drawings and attachments by the name of their file.
    pub data: Value,
    /// Drawings and attachments.
    pub files: Vec<File>,
    /// Formulas and where they stand.
    pub formulas: Vec<(String, String)>,
    /// Date of issue.
    pub issued: Datetime,
}

/// A file that the layout may open.
pub struct File {
    /// Name by which the layout opens it.
    pub name: String,
    /// What is in it.
    pub bytes: Vec<u8>,
    /// Where it stands in the sheet.
    pub place: String,
    /// Whether it is a drawing.
    pub drawing: bool,
}

impl Sheet {
    /// Reads and checks a sheet.
    ///
    /// # Errors
    /// What is no JSON, of another form, missing, of a wrong type, not known, not decodable, or has characters without a glyph.
    pub fn read(json: &[u8]) -> Result<Self> {
        let value: Value = serde_json::from_slice(json).map_err(|e| {
            Error::new(
                format!("the sheet is not JSON: {e}"),
                "write it anew with `proofmass certificate`",
            )
        })?;
        let root = Place::root(&value);
        let form = root.member("form")?;
        if form.integer()? != FORM {
            return Err(form.error(
                format!("the form {} is not known, only {FORM}", form.integer()?),
                "use the versions of `proofmass` and `proofmass-certificate` that belong together",
            ));
        }
        let mut reader = Reader::default();
        let issued = reader.sheet(&root)?;
        let mut data = value.clone();
        for file in &reader.files {
            *data
                .pointer_mut(&pointer(&file.place))
                .expect("the place was read") = Value::from(file.name.as_str());
        }
        Ok(Self {
            data,
            files: reader.files,
            formulas: reader.formulas,
            issued,
        })
    }
}

/// `blocks[3].svg` as a JSON pointer.
fn pointer(place: &str) -> String {
    format!("/{}", place.replace(']', "").replace(['[', '.'], "/"))
}

/// What is collected on the way through the sheet.
#[derive(Default)]
struct Reader {
    files: Vec<File>,
    formulas: Vec<(String, String)>,
    level: i64,
    /// Names of attachments.
    names: HashSet<String>,
}

impl Reader {
    fn sheet(&mut self, root: &Place) -> Result<Datetime> {
        root.only(&[
            "form",
            "language",
            "direction",
            "digits",
            "issued",
            "number",
            "title",
            "running",
            "page_of",
            "watermark",
            "issuer",
            "blocks",
            "attachments",
        ])?;
        language(&root.member("language")?)?;
        root.member("direction")?.one_of(&["ltr", "rtl"])?;
        root.member("digits")?.one_of(&["latin", "persian"])?;
        let issued = date(&root.member("issued")?)?;
        for name in ["number", "title"] {
            filled(&root.member(name)?)?;
        }
        let running = root.member("running")?;
        running.only(&["head", "foot"])?;
        for name in ["head", "foot"] {
            running
                .member(name)?
                .list_of(2)?
                .iter()
                .try_for_each(text)?;
        }
        let page_of = root.member("page_of")?;
        text(&page_of)?;
        for slot in ["{page}", "{pages}"] {
            if page_of.text()?.matches(slot).count() != 1 {
                return Err(page_of.error(
                    format!("{slot} must stand there once"),
                    "write it as \"Page {page} of {pages}\"",
                ));
            }
        }
        let watermark = root.member("watermark")?;
        if !watermark.is_null() {
            filled(&watermark)?;
        }
        self.issuer(&root.member("issuer")?)?;
        for block in root.member("blocks")?.list()? {
            self.block(&block)?;
        }
        for attachment in root.member("attachments")?.list()? {
            self.attachment(&attachment)?;
        }
        Ok(issued)
    }

    fn issuer(&mut self, issuer: &Place) -> Result<()> {
        issuer.only(&["name", "lines", "logo_svg", "marks"])?;
        filled(&issuer.member("name")?)?;
        for name in ["lines", "marks"] {
            issuer.member(name)?.list()?.iter().try_for_each(text)?;
        }
        if let Some(logo) = issuer.optional("logo_svg")? {
            self.drawing(&logo)?;
        }
        Ok(())
    }

    fn block(&mut self, block: &Place) -> Result<()> {
        let kind = block.member("kind")?.one_of(&[
            "heading",
            "paragraph",
            "fields",
            "table",
            "figure",
            "signatures",
            "page_break",
            "end",
        ])?;
        match kind {
            "heading" => {
                block.only(&["kind", "level", "text"])?;
                filled(&block.member("text")?)?;
                self.heading(&block.member("level")?)
            }
            "paragraph" => {
                block.only(&["kind", "text"])?;
                self.runs(&block.member("text")?)
            }
            "fields" => {
                block.only(&["kind", "rows"])?;
                for row in block.member("rows")?.list()? {
                    let pair = row.list_of(2)?;
                    text(&pair[0])?;
                    self.runs(&pair[1])?;
                }
                Ok(())
            }
            "table" => self.table(block),
            "figure" => {
                block.only(&["kind", "caption", "label", "svg", "alternative"])?;
                text(&block.member("label")?)?;
                self.runs(&block.member("caption")?)?;
                filled(&block.member("alternative")?)?;
                self.drawing(&block.member("svg")?)
            }
            "signatures" => {
                block.only(&["kind", "rows"])?;
                for row in block.member("rows")?.list()? {
                    row.only(&["name", "role", "date"])?;
                    for name in ["name", "role", "date"] {
                        text(&row.member(name)?)?;
                    }
                }
                Ok(())
            }
            "page_break" => block.only(&["kind"]),
            _ => {
                block.only(&["kind", "text"])?;
                filled(&block.member("text")?)
            }
        }
    }

    /// Headings go down by one level at a time, as tagged PDF wants them.
    fn heading(&mut self, level: &Place) -> Result<()> {
        let n = level.integer()?;
        if !(1..=self.level + 1).contains(&n) || n > 3 {
            return Err(level.error(
                format!(
                    "a heading of level {n} cannot follow one of level {}",
                    self.level
                ),
                "begin with level 1, go down by one level at a time, and not below 3",
            ));
        }
        self.level = n;
        Ok(())
    }

    fn table(&mut self, table: &Place) -> Result<()> {
        table.only(&["kind", "caption", "label", "columns", "rows", "notes"])?;
        text(&table.member("label")?)?;
        self.runs(&table.member("caption")?)?;
        let columns = table.member("columns")?;
        let n = columns.list()?.len();
        if n == 0 {
            return Err(columns.error(
                "a table without columns",
                "give it columns, or leave the table out",
            ));
        }
        for column in columns.list()? {
            column.only(&["heading", "unit", "align"])?;
            self.runs(&column.member("heading")?)?;
            if let Some(unit) = column.optional("unit")? {
                text(&unit)?;
            }
            column.member("align")?.one_of(&["number", "text"])?;
        }
        for row in table.member("rows")?.list()? {
            for cell in row.list_of(n)? {
                match cell.value() {
                    Value::Array(_) => self.runs(&cell)?,
                    _ => text(&cell)?,
                }
            }
        }
        if let Some(notes) = table.optional("notes")? {
            for note in notes.list()? {
                self.runs(&note)?;
            }
        }
        Ok(())
    }

    fn runs(&mut self, runs: &Place) -> Result<()> {
        for run in runs.list()? {
            run.only(&["text", "math", "number"])?;
            let given = [
                run.optional("text")?,
                run.optional("math")?,
                run.optional("number")?,
            ];
            match given {
                [Some(words), None, None] | [None, None, Some(words)] => text(&words)?,
                [None, Some(formula), None] => {
                    glyphs(&formula)?;
                    mathematics::check(&formula)?;
                    self.formulas
                        .push((formula.text()?.to_owned(), formula.path().to_owned()));
                }
                _ => {
                    return Err(run.error(
                        "a run holds one of \"text\", \"math\" and \"number\"",
                        "make a run of its own of each",
                    ));
                }
            }
        }
        Ok(())
    }

    fn drawing(&mut self, svg: &Place) -> Result<()> {
        drawing::check(svg)?;
        self.file(
            svg,
            format!("drawing-{}.svg", self.files.len()),
            svg.text()?.into(),
            true,
        );
        Ok(())
    }

    fn attachment(&mut self, attachment: &Place) -> Result<()> {
        attachment.only(&[
            "name",
            "media_type",
            "relationship",
            "description",
            "base64",
        ])?;
        let name = attachment.member("name")?;
        let plain = |c: char| !c.is_control() && !matches!(c, '/' | '\\' | ':');
        if name.text()?.is_empty()
            || name.text()?.starts_with('.')
            || !name.text()?.chars().all(plain)
        {
            return Err(name.error(
                format!("\"{}\" is no name of a file", name.text()?.escape_debug()),
                "use a name without folders, as result.json",
            ));
        }
        if !self.names.insert(name.text()?.to_owned()) {
            return Err(name.error(
                format!(
                    "the name \"{}\" is taken by another attachment",
                    name.text()?
                ),
                "give each attachment a name of its own",
            ));
        }
        let media_type = attachment.member("media_type")?;
        let word = |w: &str| {
            !w.is_empty()
                && w.bytes()
                    .all(|b| b.is_ascii_alphanumeric() || b"!#$&^_.+-".contains(&b))
        };
        if !media_type
            .text()?
            .split_once('/')
            .is_some_and(|(a, b)| word(a) && word(b))
        {
            return Err(media_type.error(
                format!("\"{}\" is no media type", media_type.text()?.escape_debug()),
                "write it as application/json",
            ));
        }
        attachment
            .member("relationship")?
            .one_of(&["Alternative", "Data", "Source"])?;
        filled(&attachment.member("description")?)?;
        let base64 = attachment.member("base64")?;
        let bytes = STANDARD.decode(base64.text()?).map_err(|e| {
            base64.error(
                format!("the attachment is not base64: {e}"),
                "encode the bytes of the file with the standard alphabet and padding, without line breaks",
            )
        })?;
        self.file(
            &base64,
            format!("attachment-{}", self.files.len()),
            bytes,
            false,
        );
        Ok(())
    }

    fn file(&mut self, place: &Place, name: String, bytes: Vec<u8>, drawing: bool) {
        self.files.push(File {
            name,
            bytes,
            place: place.path().to_owned(),
            drawing,
        });
    }
}

/// A text whose characters all have a glyph.
fn text(place: &Place) -> Result<()> {
    place.text()?;
    glyphs(place)
}

/// A text that is not empty.
fn filled(place: &Place) -> Result<()> {
    text(place)?;
    if place.text()?.trim().is_empty() {
        return Err(place.error("the text is empty", "write what is to be printed there"));
    }
    Ok(())
}

fn glyphs(place: &Place) -> Result<()> {
    for (i, character) in place.text()?.chars().enumerate() {
        let code = format!("U+{:04X}", u32::from(character));
        let position = i + 1;
        if character.is_control() {
            return Err(place.error(
                format!("character {position} is the control character {code}"),
                "make a paragraph or an entry of its own of what stands on a new line",
            ));
        }
        if matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}') {
            return Err(place.error(
                format!("character {position}, {code}, is invisible and turns the direction of what follows"),
                "leave it out: runs are kept apart, and a run \"number\" stays left to right",
            ));
        }
        if !fonts::have(character) {
            return Err(place.error(
                format!("character {position}, \"{character}\" ({code}), is in none of the fonts of this program"),
                "write it in Latin, Greek, Cyrillic or Persian script",
            ));
        }
    }
    Ok(())
}

/// Two or three letters, and a region of two if need be.
fn language(place: &Place) -> Result<()> {
    let (language, region) = place
        .text()?
        .split_once('-')
        .unwrap_or((place.text()?, "AA"));
    let good = (2..=3).contains(&language.len())
        && language.bytes().all(|b| b.is_ascii_lowercase())
        && region.len() == 2
        && region.bytes().all(|b| b.is_ascii_uppercase());
    if good {
        Ok(())
    } else {
        Err(place.error(
            format!("\"{}\" is no language", place.text()?),
            "write it as en, it, fa or en-GB",
        ))
    }
}

fn date(place: &Place) -> Result<Datetime> {
    let parts: Vec<&str> = place.text()?.split('-').collect();
    let digits = |part: &str, n: usize| part.len() == n && part.bytes().all(|b| b.is_ascii_digit());
    match parts[..] {
        [y, m, d] if digits(y, 4) && digits(m, 2) && digits(d, 2) => y
            .parse()
            .ok()
            .zip(m.parse().ok().zip(d.parse().ok()))
            .and_then(|(y, (m, d))| Datetime::from_ymd_hms(y, m, d, 0, 0, 0)),
        _ => None,
    }
    .ok_or_else(|| {
        place.error(
            format!("\"{}\" is no date", place.text().unwrap_or_default()),
            "write it as 2026-11-27",
        )
    })
}

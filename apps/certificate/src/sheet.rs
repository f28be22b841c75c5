//! A sheet: a certificate as data, every word of it already written. Read once, checked throughout, handed to the layout as
//! data; nothing of it ever becomes markup.

use std::collections::HashSet;

use serde_json::Value;
use typst::foundations::Datetime;

use crate::drawing;
use crate::error::{Error, Result};
use crate::place::Place;

mod attachment;
mod block;
mod text;

use text::{date, filled, language, text};

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

    fn file(&mut self, place: &Place, name: String, bytes: Vec<u8>, drawing: bool) {
        self.files.push(File {
            name,
            bytes,
            place: place.path().to_owned(),
            drawing,
        });
    }
}

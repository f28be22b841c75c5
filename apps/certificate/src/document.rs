//! A sheet laid out: its pages as PDF and as pictures.

use typst::diag::SourceDiagnostic;
use typst::foundations::Smart;
use typst_layout::PagedDocument;
use typst_pdf::{PdfOptions, PdfStandard, PdfStandards, Timestamp};
use typst_render::RenderOptions;

use crate::error::{Error, Result};
use crate::overflow;
use crate::sheet::Sheet;
use crate::world::Desk;

/// Pictures have 144 points per inch.
const SCALE: f64 = 2.0;

/// Pages that are laid out.
pub struct Document {
    pages: PagedDocument,
    options: PdfOptions,
}

impl Document {
    /// Lays a sheet out.
    ///
    /// # Errors
    /// A formula or a drawing that cannot be laid out, with its place.
    pub fn new(sheet: &Sheet) -> Result<Self> {
        let compiled = typst::compile::<PagedDocument>(&Desk::new(sheet));
        let pages = compiled
            .output
            .map_err(|errors| culprit(sheet).unwrap_or_else(|| inside(&errors)))?;
        // Page numbers that do not settle come as a warning.
        if !compiled.warnings.is_empty() {
            return Err(inside(&compiled.warnings));
        }
        overflow::check(&pages)?;
        let options = PdfOptions {
            ident: Smart::Custom(sheet.data.to_string()),
            creator: Smart::Custom(Some(format!(
                "proofmass-certificate {}",
                env!("CARGO_PKG_VERSION")
            ))),
            timestamp: Some(Timestamp::new_utc(sheet.issued)),
            standards: PdfStandards::new(&[PdfStandard::A_3a, PdfStandard::Ua_1])
                .expect("both are of PDF 1.7"),
            ..PdfOptions::default()
        };
        Ok(Self { pages, options })
    }

    /// As PDF/A-3a, tagged, with the attachments.
    ///
    /// # Errors
    /// What the standard does not allow.
    pub fn pdf(&self) -> Result<Vec<u8>> {
        typst_pdf::pdf(&self.pages, &self.options).map_err(|errors| inside(&errors))
    }

    /// Each page as a picture in PNG.
    ///
    /// # Errors
    /// A page that cannot be encoded.
    pub fn pictures(&self) -> Result<Vec<Vec<u8>>> {
        let options = RenderOptions {
            pixel_per_pt: SCALE.into(),
            render_bleed: false,
        };
        let pages = self.pages.pages().iter();
        pages
            .map(|page| {
                typst_render::render(page, &options)
                    .encode_png()
                    .map_err(|e| {
                        Error::new(format!("a page cannot be encoded: {e}"), "leave out --png")
                    })
            })
            .collect()
    }
}

/// The formula or drawing that cannot be laid out by itself.
fn culprit(sheet: &Sheet) -> Option<Error> {
    let formulas = sheet.formulas.iter().map(|(formula, place)| {
        (
            r#"#eval(read("probe"), mode: "math")"#,
            formula.as_bytes(),
            place,
            "formula",
            "correct the formula",
        )
    });
    let drawings = sheet.files.iter().filter(|file| file.drawing).map(|file| {
        let text = r#"#image(read("probe", encoding: none), format: "svg", alt: "")"#;
        (
            text,
            file.bytes.as_slice(),
            &file.place,
            "drawing",
            "give whole SVG with a width and a height",
        )
    });
    formulas
        .chain(drawings)
        .find_map(|(text, bytes, place, what, remedy)| {
            let output = typst::compile::<PagedDocument>(&Desk::probe(text, bytes)).output;
            let message = output.err()?.first()?.message.clone();
            Some(Error::new(format!("the {what} cannot be laid out: {message}"), remedy).at(place))
        })
}

/// What no check foresaw. The layout itself says what is wrong in three lines: place, what, remedy.
fn inside(messages: &[SourceDiagnostic]) -> Error {
    let first = messages
        .first()
        .map(|m| m.message.to_string())
        .unwrap_or_default();
    let lines: Vec<&str> = first
        .trim_start_matches("assertion failed: ")
        .lines()
        .collect();
    match lines[..] {
        [place, what, remedy] => Error::new(what, remedy).at(place),
        _ => Error::new(
            format!("the sheet cannot be laid out: {first}"),
            "simplify what is unusual about it; if nothing is, report it with the sheet",
        ),
    }
}

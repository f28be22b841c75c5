//! What a reader of the file finds in it beside the pages.

use std::collections::BTreeMap;
use std::fs;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use hayro_syntax::Pdf;
use hayro_syntax::object::{Dict, Name, Object, Stream, String as PdfString};

use crate::typesetter::{SHEETS, sheet, typeset};

fn text(dict: &Dict, key: &str) -> String {
    let bytes = dict.get::<PdfString>(key).unwrap().as_bytes().to_vec();
    match bytes.strip_prefix(&[0xfe, 0xff]) {
        Some(utf16) => String::from_utf16(
            &utf16
                .chunks(2)
                .map(|c| u16::from_be_bytes([c[0], c[1]]))
                .collect::<Vec<_>>(),
        )
        .unwrap(),
        None => String::from_utf8(bytes).unwrap(),
    }
}

fn name(dict: &Dict, key: &str) -> String {
    dict.get::<Name>(key).unwrap().as_str().to_owned()
}

#[test]
fn attachments_come_out_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    for sheet_name in SHEETS {
        let pdf = Pdf::new(fs::read(typeset(sheet_name, folder.path())).unwrap()).unwrap();
        let mut found = BTreeMap::new();
        for object in pdf.objects() {
            let Object::Dict(specification) = object else {
                continue;
            };
            let Some(files) = specification.get::<Dict>("EF") else {
                continue;
            };
            let file = files.get::<Stream>("F").unwrap();
            let entry = (
                name(&specification, "AFRelationship"),
                name(file.dict(), "Subtype"),
                text(&specification, "Desc"),
                file.decoded().unwrap().to_vec(),
            );
            found.insert(text(&specification, "UF"), entry);
        }
        let sheet = sheet(sheet_name);
        let attachments = sheet["attachments"].as_array().unwrap();
        assert_eq!(found.len(), attachments.len(), "{sheet_name}");
        for attachment in attachments {
            let word = |key: &str| attachment[key].as_str().unwrap().to_owned();
            let bytes = STANDARD.decode(word("base64")).unwrap();
            let expected = (
                word("relationship"),
                word("media_type"),
                word("description"),
                bytes,
            );
            assert_eq!(found[&word("name")], expected, "{sheet_name}");
        }
    }
}

#[test]
fn the_file_says_what_it_is_from_the_sheet_alone() {
    let folder = tempfile::tempdir().unwrap();
    for (sheet_name, language) in [("certificate-it", "it"), ("certificate-fa", "fa")] {
        let pdf = Pdf::new(fs::read(typeset(sheet_name, folder.path())).unwrap()).unwrap();
        let sheet = sheet(sheet_name);
        let mut catalogs = 0;
        for object in pdf.objects() {
            let Object::Dict(catalog) = object else {
                continue;
            };
            if catalog
                .get::<Name>("Type")
                .is_none_or(|kind| kind.as_str() != "Catalog")
            {
                continue;
            }
            catalogs += 1;
            assert_eq!(text(&catalog, "Lang"), language);
            assert!(
                catalog
                    .get::<Dict>("MarkInfo")
                    .unwrap()
                    .get::<bool>("Marked")
                    .unwrap()
            );
            let metadata = catalog.get::<Stream>("Metadata").unwrap();
            let xmp = String::from_utf8(metadata.decoded().unwrap().to_vec()).unwrap();
            for expected in [
                "<pdfaid:part>3</pdfaid:part>",
                "<pdfaid:conformance>A</pdfaid:conformance>",
                "<pdfuaid:part>1</pdfuaid:part>",
                "<xmp:CreateDate>2026-11-27T00:00:00+00:00</xmp:CreateDate>",
                sheet["title"].as_str().unwrap(),
                sheet["issuer"]["name"].as_str().unwrap(),
                sheet["number"].as_str().unwrap(),
            ] {
                assert!(xmp.contains(expected), "{expected} is not in {xmp}");
            }
        }
        assert_eq!(catalogs, 1);
    }
}

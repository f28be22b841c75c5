//! What is refused, where, and that nothing is written then.

use std::fs;

use serde_json::{Value, json};

use crate::typesetter::{path, program, run, sheet};

/// Changes the sheet of one page and expects the message to hold these parts.
fn refuses(change: impl Fn(&mut Value), parts: &[&str]) {
    let mut changed = sheet("one-page-en");
    change(&mut changed);
    refuses_bytes(changed.to_string().as_bytes(), parts);
}

fn refuses_bytes(sheet: &[u8], parts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let pdf = folder.path().join("certificate.pdf");
    fs::write(&pdf, "an older certificate").unwrap();
    let output = run(sheet, &["-o", pdf.to_str().unwrap()]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        message.starts_with("error: ") && message.contains("\nhint: "),
        "{message}"
    );
    for part in parts {
        assert!(message.contains(part), "{part} is not in: {message}");
    }
    assert_eq!(fs::read(&pdf).unwrap(), b"an older certificate");
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        1,
        "something was left behind"
    );
}

fn figure(svg: &str) -> impl Fn(&mut Value) {
    let block = json!({ "kind": "figure", "caption": [], "label": "Figure 1", "svg": svg, "alternative": "a plot" });
    move |sheet| sheet["blocks"] = json!([block])
}

fn formula(source: &str) -> impl Fn(&mut Value) {
    let block = json!({ "kind": "paragraph", "text": [{ "text": "so" }, { "math": source }] });
    move |sheet| sheet["blocks"] = json!([block])
}

#[test]
fn refuses_what_is_no_sheet() {
    refuses_bytes(b"", &["not JSON", "line 1 column 0"]);
    refuses_bytes(b"{ \"form\": 1, }", &["not JSON", "line 1 column 14"]);
    refuses_bytes(&b"[".repeat(100_000), &["not JSON"]);
    refuses_bytes(b"[]", &["an object is needed here, not a list"]);
    refuses(
        |s| s["form"] = json!(2),
        &["the form 2 is not known", "standard input: form"],
    );
    refuses(
        |s| s["form"] = json!("1"),
        &["a whole number is needed here, not a text", "form"],
    );
}

#[test]
fn refuses_missing_unknown_and_mistyped_fields() {
    let without =
        |name: &'static str| move |s: &mut Value| drop(s.as_object_mut().unwrap().remove(name));
    for name in [
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
    ] {
        refuses(
            without(name),
            &[&format!("the field \"{name}\" is missing")],
        );
    }
    refuses(
        |s| s["colour"] = json!("red"),
        &["\"colour\" is not known", "would not be printed"],
    );
    refuses(
        |s| s["title"] = json!(7),
        &["a text is needed here, not a number", ": title"],
    );
    refuses(
        |s| s["title"] = json!(" \u{200b}"),
        &["the text is empty", ": title"],
    );
    refuses(
        |s| s["watermark"] = json!(""),
        &["the text is empty", ": watermark"],
    );
    refuses(
        |s| s["blocks"][0]["kind"] = json!("poem"),
        &["\"poem\"", ": blocks[0].kind", "paragraph"],
    );
    refuses(
        |s| s["blocks"][0]["rows"][2] = json!(["Item"]),
        &["2 entries", "blocks[0].rows[2]"],
    );
    refuses(
        |s| s["blocks"][4]["rows"][1] = json!(["1", "2"]),
        &["5 entries", "blocks[4].rows[1]"],
    );
    refuses(
        |s| s["blocks"][4]["rows"][1][0] = json!(1.5),
        &["a text", "blocks[4].rows[1][0]"],
    );
    refuses(
        |s| s["blocks"][4]["columns"] = json!([]),
        &["without columns", "blocks[4].columns"],
    );
    refuses(
        |s| s["blocks"][1]["level"] = json!(2),
        &["level 2", "blocks[1].level"],
    );
    refuses(
        |s| s["blocks"][2]["text"][0] = json!({ "text": "a", "math": "b" }),
        &["one of", "blocks[2].text[0]"],
    );
    refuses(
        |s| s["page_of"] = json!("Page {page}"),
        &["{pages}", ": page_of"],
    );
    refuses(
        |s| s["issued"] = json!("2026-02-30"),
        &["is no date", ": issued"],
    );
    refuses(
        |s| s["language"] = json!("English"),
        &["is no language", ": language"],
    );
}

#[test]
fn refuses_attachments_that_cannot_be_attached() {
    let with = |name: &'static str, value: &'static str| {
        move |s: &mut Value| s["attachments"][1][name] = json!(value)
    };
    refuses(
        with("base64", "e30"),
        &["not base64", "attachments[1].base64"],
    );
    refuses(
        with("base64", "e3*="),
        &["not base64", "attachments[1].base64"],
    );
    refuses(
        with("name", "../result.json"),
        &["is no name of a file", "attachments[1].name"],
    );
    refuses(
        with("name", "certificate.xml"),
        &["is taken", "attachments[1].name"],
    );
    refuses(
        with("media_type", "json"),
        &["is no media type", "attachments[1].media_type"],
    );
    refuses(
        with("relationship", "Friend"),
        &["\"Friend\"", "Alternative, Data, Source"],
    );
}

#[test]
fn refuses_characters_without_a_glyph() {
    refuses(
        |s| s["blocks"][0]["rows"][0][1][0]["text"] = json!("Shenzhen 深圳"),
        &[
            "character 10",
            "深",
            "U+6DF1",
            "blocks[0].rows[0][1][0].text",
        ],
    );
    refuses(
        |s| s["title"] = json!("a\nb"),
        &["control character U+000A", ": title"],
    );
    // Would print a number that is not there.
    refuses(
        |s| s["number"] = json!("\u{202e}2400-6202"),
        &["U+202E", "direction", ": number"],
    );
    refuses(
        figure(
            "<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'>\n<text>漢</text></svg>",
        ),
        &["漢", "line 2", "blocks[0].svg"],
    );
}

#[test]
fn refuses_broken_drawings_and_those_that_reach_outside() {
    refuses(figure("<svg"), &["not readable", "blocks[0].svg"]);
    refuses(figure("<html/>"), &["<html>", "blocks[0].svg"]);
    refuses(
        figure("<svg xmlns='http://www.w3.org/2000/svg' width='0' height='0'/>"),
        &["width", "blocks[0].svg"],
    );
    refuses(
        figure("<!DOCTYPE svg [<!ENTITY a 'b'>]><svg>&a;</svg>"),
        &["DTD", "blocks[0].svg"],
    );
    for file in [
        "/etc/passwd",
        "https://example.org/logo.png",
        "attachment-2",
        "sheet.json",
    ] {
        let svg = format!(
            "<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'><image href='{file}'/></svg>"
        );
        refuses(figure(&svg), &[file, "blocks[0].svg"]);
    }
}

#[test]
fn refuses_formulas_that_are_more_than_mathematics() {
    for source in [
        "#read(\"sheet.json\")",
        "x #let y = 1",
        "std.read(\"sheet.json\")",
        "text(size: 1000pt, x)",
        "x // y",
        "$x$",
        "hat(x",
        "volt",
        "frac(a)",
    ] {
        refuses(formula(source), &["formula", "blocks[0].text[1].math"]);
    }
    refuses(
        formula(&"sqrt(".repeat(300)),
        &["formula", "blocks[0].text[1].math"],
    );
    refuses(
        formula(&format!("{}{}", "(".repeat(900), ")".repeat(900))),
        &["formula", "blocks[0].text[1].math"],
    );
}

#[test]
fn refuses_what_does_not_fit_on_the_page() {
    let column = json!({ "heading": [{ "text": "Sensitivity" }], "unit": "mV", "align": "number" });
    let table = json!({ "kind": "table", "caption": [], "label": "Table 1", "columns": vec![column; 30], "rows": [], "notes": [] });
    refuses(
        |s| s["blocks"][3] = table.clone(),
        &["30 columns do not fit", "blocks[3].columns"],
    );
    refuses(
        |s| s["blocks"][2]["text"][1]["number"] = json!("1 234".repeat(60)),
        &["does not fit on page 1"],
    );
}

#[test]
fn refuses_wrong_arguments_and_places() {
    let folder = tempfile::tempdir().unwrap();
    let pdf = folder.path().join("c.pdf");
    let says = |arguments: &[&str], part: &str| {
        let output = program().args(arguments).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(part), "{message}");
    };
    let (sheet, pdf) = (path("one-page-en"), pdf.to_str().unwrap().to_owned());
    let sheet = sheet.to_str().unwrap();
    says(&[], "the sheet is missing");
    says(&[sheet], "-o FILE.pdf is missing");
    says(&[sheet, "-o"], "-o needs a place");
    says(&[sheet, sheet, "-o", &pdf], "twice");
    says(&[sheet, "-o", &pdf, "--pgn", "x"], "--pgn is not known");
    says(&["nowhere.json", "-o", &pdf], "nowhere.json");
    says(
        &[sheet, "-o", &format!("{pdf}/no/c.pdf")],
        "cannot be written",
    );
    says(
        &[sheet, "-o", folder.path().to_str().unwrap()],
        "cannot be written",
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

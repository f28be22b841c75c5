//! Every word of a sheet stands on its pages, in reading order.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::typesetter::{SHEETS, run, sheet, typeset};

/// The pages as text, `None` where there is no pdftotext.
fn pages(pdf: &Path) -> Option<Vec<String>> {
    let output = Command::new("pdftotext").arg(pdf).arg("-").output().ok()?;
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    Some(
        text.trim_end_matches('\u{c}')
            .split('\u{c}')
            .map(bare)
            .collect(),
    )
}

/// Letters, digits, signs and decimal marks. Lines are broken elsewhere, and pdftotext leaves out the hyphen there; in a text
/// from right to left it puts punctuation to the other side of a number, and turns the parts of one glyph around, which
/// concerns lam with alef and marks above a letter.
fn bare(text: &str) -> String {
    let text: Vec<char> = text
        .replace("لا", "ال")
        .chars()
        .filter(|c| !('\u{64b}'..='\u{655}').contains(c))
        .collect();
    let digit = |i: usize| text.get(i).is_some_and(|c| c.is_numeric());
    let kept = |i: usize, c: char| {
        c.is_alphanumeric()
            || "−±×°%٪/=+<>#*$@\\".contains(c)
            || (".,٫".contains(c) && i > 0 && digit(i - 1) && digit(i + 1))
    };
    text.iter()
        .enumerate()
        .filter(|(i, c)| kept(*i, **c))
        .map(|(_, c)| *c)
        .collect()
}

/// Texts and numbers of a sheet that are printed, each with its place.
fn printed(value: &Value, place: &str, found: &mut Vec<(String, String)>) {
    match value {
        Value::String(text) => found.push((place.to_owned(), text.clone())),
        Value::Array(entries) => {
            for (i, entry) in entries.iter().enumerate() {
                printed(entry, &format!("{place}[{i}]"), found);
            }
        }
        Value::Object(members) => {
            for (name, member) in members {
                let silent = [
                    "kind",
                    "align",
                    "math",
                    "svg",
                    "logo_svg",
                    "alternative",
                    "attachments",
                    "language",
                    "direction",
                    "digits",
                    "issued",
                    "watermark",
                    "page_of",
                ];
                if !silent.contains(&name.as_str()) {
                    printed(member, &format!("{place}.{name}"), found);
                }
            }
        }
        _ => {}
    }
}

#[test]
fn every_word_is_printed_in_reading_order() {
    let folder = tempfile::tempdir().unwrap();
    for name in SHEETS {
        let Some(pages) = pages(&typeset(name, folder.path())) else {
            println!("skipped: pdftotext is not installed");
            return;
        };
        let all = pages.concat();
        let mut texts = Vec::new();
        printed(&sheet(name), "", &mut texts);
        assert!(texts.len() > 40);
        let missing: Vec<_> = texts
            .iter()
            .filter(|(_, text)| !all.contains(&bare(text)))
            .collect();
        assert!(missing.is_empty(), "{name}: {missing:#?}\n{all}");
    }
}

#[test]
fn every_page_has_its_head_and_foot_and_its_number() {
    let folder = tempfile::tempdir().unwrap();
    for (name, expected) in [
        ("one-page-en", 1),
        ("forty-frequencies-en", 3),
        ("certificate-fa", 3),
    ] {
        let Some(pages) = pages(&typeset(name, folder.path())) else {
            println!("skipped: pdftotext is not installed");
            return;
        };
        assert_eq!(pages.len(), expected, "{name}");
        let sheet = sheet(name);
        let digit = |n: usize| {
            let persian = sheet["digits"] == "persian";
            char::from_u32(n as u32 + if persian { 0x6f0 } else { 0x30 })
                .unwrap()
                .to_string()
        };
        for (i, page) in pages.iter().enumerate() {
            let running = &sheet["running"];
            for text in [
                &running["head"][0],
                &running["head"][1],
                &running["foot"][0],
                &running["foot"][1],
            ] {
                assert!(
                    page.contains(&bare(text.as_str().unwrap())),
                    "{name}, page {}: {text}",
                    i + 1
                );
            }
            let page_of = sheet["page_of"].as_str().unwrap();
            let page_of = page_of
                .replace("{page}", &digit(i + 1))
                .replace("{pages}", &digit(expected));
            assert!(page.contains(&bare(&page_of)), "{name}: {page_of}");
        }
    }
}

#[test]
fn a_draft_says_so_on_every_page() {
    // Letters that stand nowhere else: pdftotext takes a word that stands aslant apart.
    let mut draft = sheet("forty-frequencies-en");
    draft["watermark"] = "ЖЩЮ".into();
    let folder = tempfile::tempdir().unwrap();
    let pdf = folder.path().join("draft.pdf");
    assert!(
        run(draft.to_string().as_bytes(), &["-o", pdf.to_str().unwrap()])
            .status
            .success()
    );
    let Some(pages) = pages(&pdf) else {
        println!("skipped: pdftotext is not installed");
        return;
    };
    assert!(
        pages
            .iter()
            .all(|page| "ЖЩЮ".chars().all(|letter| page.contains(letter)))
    );
}

#[test]
fn law_no_page_has_a_signature_alone() {
    let folder = tempfile::tempdir().unwrap();
    let pdf = folder.path().join("c.pdf");
    let mut alone = 0;
    for lines in 0..24 {
        let mut sheet = sheet("one-page-en");
        let blocks = sheet["blocks"].as_array_mut().unwrap();
        let at = blocks
            .iter()
            .position(|b| b["text"] == "Uncertainty")
            .unwrap();
        for _ in 0..lines {
            blocks.insert(
                at,
                serde_json::json!({"kind": "paragraph", "text": [{"text": "A line."}]}),
            );
        }
        let made = run(sheet.to_string().as_bytes(), &["-o", pdf.to_str().unwrap()]);
        assert!(made.status.success());
        let Some(pages) = pages(&pdf) else {
            println!("skipped: pdftotext is not installed");
            return;
        };
        let last = pages.last().unwrap();
        assert!(last.contains("DrEleanorHartley"), "{lines}: {last}");
        assert!(last.contains("multipliedbythecove"), "{lines}: {last}");
        alone += usize::from(pages.len() > 1 && !last.contains("Aline"));
    }
    assert!(
        alone > 0,
        "in none of these the closing stands on a page of its own"
    );
}

#[test]
fn the_head_of_a_table_is_repeated() {
    let folder = tempfile::tempdir().unwrap();
    for (name, heading, first, last) in [
        (
            "forty-frequencies-en",
            "Acceleration amplitude",
            "0.62",
            "11.222",
        ),
        ("certificate-fa", "دامنهٔ شتاب", "۰٫۶۲", "۱۱٫۲۲۲"),
    ] {
        let Some(pages) = pages(&typeset(name, folder.path())) else {
            println!("skipped: pdftotext is not installed");
            return;
        };
        let page_with = |number: &str| pages.iter().position(|page| page.contains(number)).unwrap();
        assert_eq!(
            (page_with(first), page_with(last)),
            (0, 1),
            "{name}: the table goes over two pages"
        );
        assert!(
            pages[..2].iter().all(|page| page.contains(&bare(heading))),
            "{name}"
        );
    }
}

#[test]
fn formulas_are_set_and_not_spelled() {
    let folder = tempfile::tempdir().unwrap();
    let Some(pages) = pages(&typeset("certificate-fa", folder.path())) else {
        println!("skipped: pdftotext is not installed");
        return;
    };
    // Mathematical italics.
    assert!(pages[0].contains('𝑈') && pages[0].contains('𝑆'));
    assert!(!pages[0].contains("sqrt"));
}

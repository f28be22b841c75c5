//! Numbers of a column stand at their decimal mark.

use std::collections::BTreeMap;
use std::process::Command;

use crate::typesetter::typeset;

/// Left and right edge of each word that stands once, in points; `None` where there is no pdftotext.
fn edges(sheet: &str) -> Option<BTreeMap<String, (f64, f64)>> {
    let folder = tempfile::tempdir().unwrap();
    let pdf = typeset(sheet, folder.path());
    let output = Command::new("pdftotext")
        .arg("-bbox")
        .arg(&pdf)
        .arg("-")
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).unwrap();
    let attribute = |line: &str, name: &str| -> Option<f64> {
        line.split_once(&format!("{name}=\""))?
            .1
            .split_once('"')?
            .0
            .parse()
            .ok()
    };
    let words = text.lines().filter_map(|line| {
        let word = line.split_once('>')?.1.strip_suffix("</word>")?;
        // Marks of direction around it.
        let word: String = word
            .chars()
            .filter(|c| !matches!(c, '\u{202a}'..='\u{202e}'))
            .collect();
        Some((word, (attribute(line, "xMin")?, attribute(line, "xMax")?)))
    });
    Some(words.collect())
}

#[test]
fn numbers_stand_at_their_decimal_mark() {
    // Frequencies, and a whole number whose width gives that of a digit.
    for (sheet, whole, broken) in [
        (
            "forty-frequencies-en",
            "8000",
            ["1.25", "6.3", "12.5", "31.5"],
        ),
        ("certificate-fa", "۸۰۰۰", ["۱٫۲۵", "۶٫۳", "۱۲٫۵", "۳۱٫۵"]),
    ] {
        let Some(edges) = edges(sheet) else {
            println!("skipped: pdftotext is not installed");
            return;
        };
        let (left, mark) = edges[whole];
        let digit = (mark - left) / 4.0;
        assert!(digit > 3.0);
        for number in broken {
            let before = number.chars().position(|c| !c.is_numeric()).unwrap() as f64;
            // pdftotext prints micrometres and less.
            assert!(
                (edges[number].0 + before * digit - mark).abs() < 0.01,
                "{sheet}: {number}"
            );
        }
    }
}

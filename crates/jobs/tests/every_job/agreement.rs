//! What must hold for a result of any kind.

use crate::Answer;
use crate::support::{Steps, Stop};
use proofmass_documents::StatedQuantity;
use proofmass_jobs::{REPORT, StoredResult, TroubleKind, Watch};
use proofmass_report::terminal;
use std::f64::consts::TAU;
use std::path::PathBuf;

/// Stopped at the first call it gives nothing; else result.json, terminal, page and the table of the principal result
/// state the same, and the result read again gives every file to the byte.
pub fn check(kind: &str, answer: &dyn Fn(&dyn Watch) -> Answer) -> StoredResult {
    let Err(stopped) = answer(&Stop) else {
        panic!("{kind} goes on when it is stopped");
    };
    assert_eq!(stopped.kind(), TroubleKind::Cancelled, "{kind}: {stopped}");
    let steps = Steps::default();
    let result = answer(&steps).unwrap_or_else(|e| panic!("{kind}: {e} {:?}", e.place()));
    steps.law_they_go_up_to_the_end(kind);
    assert_eq!(result.kind(), kind);
    let bytes = result.to_json().expect("result.json");
    let again = StoredResult::from_json(&bytes).expect("read again");
    assert_eq!(again.kind(), kind);
    assert_eq!(again.record(), result.record());
    let (files, files_again) = (
        result.files().expect("files"),
        again.files().expect("files"),
    );
    assert_eq!(files.len(), files_again.len());
    for ((name, a), (other, b)) in files.iter().zip(&files_again) {
        assert!(
            name == other && a == b,
            "{kind}: {name} differs when it is read again"
        );
    }
    let document: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
    let quantities = result.quantities();
    let stated = document["quantities"].as_array().map_or(0, Vec::len);
    assert_eq!(stated, quantities.len(), "{kind}");
    for (q, d) in quantities
        .iter()
        .zip(document["quantities"].as_array().into_iter().flatten())
    {
        assert_eq!(d["name"], q.name.as_str());
        assert_eq!(d["value"].as_f64(), Some(q.value), "{kind}: {}", q.name);
        // An interval that is not value ± U stands in its place.
        let expanded = q.interval.is_none().then_some(q.expanded);
        assert_eq!(d["U"].as_f64(), expanded, "{kind}: {}", q.name);
    }
    let [summary, summary_again] = [&result, &again].map(in_the_terminal);
    assert_eq!(summary, summary_again, "{kind}");
    let file = |wanted: &str| {
        let found = files.iter().find(|(name, _)| name == wanted);
        let (_, bytes) = found.unwrap_or_else(|| panic!("{kind} without {wanted}"));
        String::from_utf8_lossy(bytes).into_owned()
    };
    lay_out(kind, &files, &result);
    crate::statements::law_numbers_say_how_well_they_are_known(kind, &result);
    crate::tables::remember(kind, &result);
    let page = words(&file(REPORT));
    assert!(summary.contains(document["title"].as_str().expect("a title")));
    opens_with_the_answer(kind, &result, &file(REPORT));
    law_the_opening_fits_a_terminal(kind, &result);
    // The first quantity is what a job was asked for: it stands in the terminal, on the page and in the table.
    if let Some(q) = quantities.first() {
        if q.value != 0.0 && q.expanded > 0.0 {
            for (place, text) in [("terminal", &summary), ("page", &page)] {
                assert!(
                    states(text, q.value),
                    "{kind}: {place} without {} = {}:\n{text}",
                    q.name,
                    q.value
                );
            }
        }
        let table = file(result.principal_table());
        assert!(
            in_a_row(&table, q),
            "{kind}: {} does not state {} = {} with U = {}",
            result.principal_table(),
            q.name,
            q.value,
            q.expanded
        );
    }
    // Whatever is larger than its uncertainty stands on the page, angles in whichever turn.
    for q in quantities.iter().filter(|q| q.value.abs() > q.expanded) {
        let turns: &[f64] = if q.unit == "rad" {
            &[0.0, -1.0, 1.0]
        } else {
            &[0.0]
        };
        let found = turns.iter().any(|n| states(&page, q.value + n * TAU));
        assert!(found, "{kind}: page without {} = {}", q.name, q.value);
    }
    // A table by that name states every quantity, and its name.
    if result.principal_table() == proofmass_jobs::QUANTITIES {
        for q in quantities {
            let table = file(proofmass_jobs::QUANTITIES);
            let row = table.lines().find(|l| {
                l.starts_with(&format!("{},", q.name)) || l.starts_with(&format!("\"{}\",", q.name))
            });
            let row = row.unwrap_or_else(|| panic!("{kind}: no row of {}", q.name));
            assert!(in_a_row(row, q), "{kind}: {row}");
        }
    }
    result
}

/// Result, verdict, findings and what was read take 25 lines of a hundred columns at most, before any detail.
fn law_the_opening_fits_a_terminal(kind: &str, result: &StoredResult) {
    let mut opening = result.summary();
    opening.sections.clear();
    let options = terminal::Options {
        width: 100,
        colour: false,
        filed: true,
        details: true,
    };
    let text = terminal::render(&opening, &options).expect("terminal");
    assert!(
        text.lines().count() <= 25,
        "{kind} opens with {} lines:\n{text}",
        text.lines().count()
    );
    assert!(
        text.lines().all(|l| l.chars().count() <= 100),
        "{kind}:\n{text}"
    );
}

/// Where `PROOFMASS_REPORTS` names a folder, the files of every result and its summary in a terminal of a hundred columns
/// are written there, for somebody who looks at the pages.
fn lay_out(kind: &str, files: &[(String, Vec<u8>)], result: &StoredResult) {
    let Some(all) = std::env::var_os("PROOFMASS_REPORTS").map(PathBuf::from) else {
        return;
    };
    std::fs::create_dir_all(&all).expect("a folder");
    let place = (1..)
        .map(|n| all.join(format!("{kind}-{n}")))
        .find(|place| std::fs::create_dir(place).is_ok());
    let place = place.expect("a name");
    for (name, bytes) in files {
        let path = place.join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, bytes).expect("a file");
    }
    std::fs::write(place.join("summary.txt"), in_a_terminal_of(100, result)).expect("a file");
}

/// The first block of a page has the result with U and k, a verdict, and the figure, before findings and all that is folded.
fn opens_with_the_answer(kind: &str, result: &StoredResult, page: &str) {
    let start = page.find("<section class=\"answer\">").expect("an answer");
    let end = start + page[start..].find("</section>").expect("its end");
    let block = &page[start..end];
    let folded = page.find("<details").unwrap_or(page.len());
    assert!(
        end < folded,
        "{kind}: something is folded before the answer"
    );
    let said = words(block);
    let verdict = block.find("<p class=\"verdict").expect("a verdict");
    let sentence = words(&block[verdict..verdict + block[verdict..].find("</p>").unwrap_or(0)]);
    assert!(
        sentence.trim().ends_with('.') && sentence.len() > 20,
        "{kind}: {sentence}"
    );
    assert!(
        block.contains("<span class=\"value\">"),
        "{kind}: no number opens the page:\n{said}"
    );
    if let Some(q) = result.quantities().iter().find(|q| q.expanded > 0.0) {
        assert!(
            said.contains('±') || said.contains("95 %"),
            "{kind}: {} without U:\n{said}",
            q.name
        );
        assert!(
            ["k = ", "95 %"].iter().any(|s| said.contains(s)),
            "{kind}: U without k or probability:\n{said}"
        );
    }
    // Whatever kind has a figure opens with one.
    let figures = page.matches("<figure").count();
    let first = page.find("<figure").unwrap_or(0);
    assert!(
        figures == 0 || (start < first && first < end),
        "{kind}: the figure is not in the answer"
    );
    let report = result.report();
    assert!(
        report.answer.figures.len() <= 12,
        "{kind}: {} numbers open the page",
        report.answer.figures.len()
    );
}

/// What a result of a kind without quantities is asked for stands in terminal and page as in its table.
pub fn figure(result: &StoredResult, table: &str, row: usize, column: &str) -> f64 {
    let value = cell(result, table, row, column);
    states_everywhere(result, value);
    value
}

/// A number stands in terminal and page.
pub fn states_everywhere(result: &StoredResult, value: f64) {
    let terminal = in_the_terminal(result);
    let kind = result.kind();
    assert!(states(&terminal, value), "{kind}: terminal without {value}");
    stands_on_the_page(result, value);
}

/// A number stands on the page.
pub fn stands_on_the_page(result: &StoredResult, value: f64) {
    let page = words(&result.html().expect("page"));
    let kind = result.kind();
    assert!(states(&page, value), "{kind}: page without {value}");
}

/// A number of a table.
pub fn cell(result: &StoredResult, table: &str, row: usize, column: &str) -> f64 {
    let files = result.files().expect("files");
    let found = files.iter().find(|(name, _)| name == table);
    let (_, bytes) = found.unwrap_or_else(|| panic!("{} without {table}", result.kind()));
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().expect("names of columns");
    let place = names.iter().position(|name| *name == column);
    let place = place.unwrap_or_else(|| panic!("{table} without {column}"));
    let row = lines.nth(row).expect("a row");
    row[place].parse().expect("a number")
}

pub fn in_the_terminal(result: &StoredResult) -> String {
    in_a_terminal_of(200, result)
}

fn in_a_terminal_of(width: usize, result: &StoredResult) -> String {
    let options = terminal::Options {
        width,
        colour: false,
        filed: true,
        details: true,
    };
    terminal::render(&result.summary(), &options).expect("terminal")
}

/// The words of a page: no figures, no style, the parts of a number aligned at its point put together.
fn words(page: &str) -> String {
    let (mut text, mut rest, mut inside) = (String::new(), page, None);
    while let Some(start) = rest.find('<') {
        let end = rest[start..]
            .find('>')
            .map_or(rest.len(), |e| start + e + 1);
        let tag = &rest[start..end];
        if inside.is_none() {
            text += &rest[..start];
            inside = ["svg", "style", "script"]
                .into_iter()
                .find(|name| tag[1..].starts_with(name));
            if !tag.starts_with("</span") && !tag.starts_with("<span class=\"tail\"") {
                text.push(' ');
            }
        } else if inside.is_some_and(|name| tag.trim_start_matches("</").starts_with(name)) {
            inside = None;
        }
        rest = &rest[end..];
    }
    text + rest
}

/// Factors between SI and the units that pages print.
const SCALES: [f64; 8] = [
    1.0,
    1e3,
    1e6,
    1e-3,
    1e2,
    180.0 / std::f64::consts::PI,
    1e9,
    1.0 / 9.80665e-3,
];

/// Whether a number of three digits or more in the text is the value, rounded, in some unit.
fn states(text: &str, value: f64) -> bool {
    let normal: String = text
        .chars()
        .map(|c| match c {
            '−' => '-',
            c => c,
        })
        .filter(|c| !matches!(c, '\u{202f}' | '\u{2009}' | '\u{a0}'))
        .collect();
    let numbers = normal.split(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-')));
    numbers
        .filter(|n| n.chars().filter(char::is_ascii_digit).count() >= 3)
        .filter_map(|n| {
            Some((
                n.parse::<f64>().ok()?,
                n.split_once('.').map_or(0, |p| p.1.len()),
            ))
        })
        .any(|(number, decimals)| {
            let half = 0.5001 * 0.1f64.powi(decimals as i32);
            // Powers of ten may stand beside the number.
            let scaled = |s: f64| {
                (-9..=9)
                    .any(|p| (number - value * s * 10f64.powi(p)).abs() <= half && number != 0.0)
            };
            SCALES.iter().any(|s| scaled(*s))
        })
}

/// Whether a row of a table holds the size of a quantity, to a hundredth of its uncertainty, and beside it that uncertainty,
/// standard or expanded, in some unit.
fn in_a_row(table: &str, q: &StatedQuantity) -> bool {
    let u = q.u.unwrap_or(0.5 * q.expanded);
    table.lines().any(|line| {
        let numbers: Vec<f64> = line.split(',').filter_map(|f| f.parse().ok()).collect();
        SCALES.iter().any(|s| {
            let has = |size: f64, within: f64| {
                let near = |n: &f64| (n.abs() - (size * s).abs()).abs() <= (within * s).abs();
                numbers.iter().any(near)
            };
            has(q.value, (0.01 * u).max(1e-9 * q.value.abs()))
                && (has(q.expanded, 0.01 * q.expanded) || q.u.is_some_and(|u| has(u, 0.01 * u)))
        })
    })
}

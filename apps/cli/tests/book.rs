//! The pages of `docs` as a book: every file in its contents, every link and anchor there, every command typed and its output compared.

mod support;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::*;

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

/// Every page with its path below `docs`.
fn pages() -> Vec<(PathBuf, String)> {
    fn gather(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => gather(&path, found),
                false if path.extension().is_some_and(|e| e == "md") => found.push(path),
                false => {}
            }
        }
    }
    let mut found = Vec::new();
    gather(&docs(), &mut found);
    found.sort();
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        (path.strip_prefix(docs()).unwrap().to_path_buf(), text)
    };
    found.into_iter().map(read).collect()
}

/// A fenced block: its first line, its text, and the line of the page that it begins in.
struct Fenced<'a> {
    info: &'a str,
    lines: Vec<&'a str>,
    line: usize,
}

/// Fenced blocks, and the lines outside of them.
fn parts(text: &str) -> (Vec<Fenced<'_>>, Vec<(usize, &str)>) {
    let (mut blocks, mut prose) = (Vec::new(), Vec::new());
    let mut open: Option<Fenced> = None;
    for (i, line) in text.lines().enumerate() {
        match (&mut open, line.trim_start().strip_prefix("```")) {
            (None, Some(info)) => {
                open = Some(Fenced {
                    info: info.trim(),
                    lines: Vec::new(),
                    line: i + 1,
                });
            }
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(block), None) => block.lines.push(line),
            (None, None) => prose.push((i + 1, line)),
        }
    }
    assert!(open.is_none(), "a block of code has no end");
    (blocks, prose)
}

/// Targets of the links of a line.
fn links(line: &str) -> Vec<&str> {
    // What stands in code is no link.
    let outside = line.split('`').step_by(2);
    outside
        .flat_map(|text| text.split("](").skip(1))
        .filter_map(|rest| rest.split([')', ' ']).next())
        .collect()
}

/// The anchors of the headings of a page, as repositories and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let (_, prose) = parts(text);
    let headings = prose.iter().filter(|(_, l)| l.starts_with('#'));
    let mut anchors = BTreeSet::new();
    for (_, heading) in headings {
        let heading = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = heading
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let anchor: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let again = (1..).map(|n| format!("{anchor}-{n}"));
        let mut names = std::iter::once(anchor.clone()).chain(again);
        anchors.extend(names.find(|n| !anchors.contains(n)));
    }
    anchors
}

#[test]
fn law_every_page_stands_in_the_contents_once() {
    let contents = std::fs::read_to_string(docs().join("SUMMARY.md")).unwrap();
    let listed: Vec<&str> = contents.lines().flat_map(links).collect();
    for (page, _) in pages() {
        let name = page.to_str().unwrap();
        let times = listed
            .iter()
            .filter(|l| l.trim_start_matches("./") == name)
            .count();
        assert_eq!(
            times,
            usize::from(name != "SUMMARY.md"),
            "{name} in SUMMARY.md"
        );
    }
}

/// Inside of the book, which has nothing but what stands in `docs`.
#[test]
fn law_every_link_leads_somewhere() {
    let root = docs().canonicalize().unwrap();
    let pages = pages();
    let mut wrong = Vec::new();
    for (page, text) in &pages {
        for (line, prose) in parts(text).1 {
            for link in links(prose) {
                if link.starts_with("http") || link.starts_with("mailto:") {
                    continue;
                }
                let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
                let target = match file {
                    "" => docs().join(page),
                    file => docs().join(page).parent().unwrap().join(file),
                };
                let inside = target.canonicalize().is_ok_and(|t| t.starts_with(&root));
                let known = || anchors(&std::fs::read_to_string(&target).unwrap());
                if !inside || (!anchor.is_empty() && !known().contains(anchor)) {
                    wrong.push(format!("docs/{}:{line}: {link}", page.display()));
                }
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "links that lead nowhere:\n{}",
        wrong.join("\n")
    );
}

#[test]
fn law_every_page_links_the_glossary() {
    let readme = std::fs::read_to_string(docs().join("../README.md")).unwrap();
    for (page, text) in pages().into_iter().chain([("README.md".into(), readme)]) {
        let itself = page.ends_with("glossary.md") || page.ends_with("SUMMARY.md");
        assert!(itself || text.contains("glossary.md"), "{}", page.display());
    }
}

#[test]
fn law_every_block_of_code_names_its_language() {
    for (page, text) in pages() {
        for block in parts(&text).0 {
            assert!(
                !block.info.is_empty(),
                "docs/{}:{}: a block of code in no language",
                page.display(),
                block.line
            );
        }
    }
}

#[test]
fn known_page_of_commands() {
    let written = std::fs::read_to_string(docs().join("commands.md")).unwrap();
    assert!(
        written == proofmass_cli::reference(),
        "docs/commands.md is not that of the commands: run `cargo run -p proofmass-cli --example commands_page`"
    );
}

/// Words of a command, with quotes as a shell has them.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quote = None;
    for c in line.trim().chars() {
        match (quote, c) {
            (Some(q), c) if q == c => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, ' ') => {
                if !words.last().unwrap().is_empty() {
                    words.push(String::new());
                }
            }
            (_, c) => words.last_mut().unwrap().push(c),
        }
    }
    words
}

/// What a command of a page prints, and whether it succeeds.
fn typed(folder: &Path, line: &str) -> (String, bool) {
    let words = words(line);
    let [program, arguments @ ..] = &words[..] else {
        panic!("no command");
    };
    match program.as_str() {
        "proofmass" => {
            let output: Output = Command::new(env!("CARGO_BIN_EXE_proofmass"))
                .args(arguments)
                .current_dir(folder)
                .env("NO_COLOR", "1")
                .output()
                .unwrap();
            let text = [output.stdout, output.stderr].concat();
            (String::from_utf8(text).unwrap(), output.status.success())
        }
        "cat" => (
            std::fs::read_to_string(folder.join(&arguments[0])).unwrap(),
            true,
        ),
        "head" => {
            let n: usize = arguments[1].parse().unwrap();
            let text = std::fs::read_to_string(folder.join(&arguments[2])).unwrap();
            let lines: Vec<&str> = text.lines().take(n).collect();
            (lines.join("\n"), true)
        }
        "ls" => (names(&folder.join(&arguments[0])).join("\n"), true),
        other => panic!("{other} is no command that a page may have"),
    }
}

/// Whether a text has these lines in turn; `…` stands for any number of lines.
fn matches(expected: &[&str], printed: &[&str]) -> bool {
    match expected {
        [] => printed.is_empty(),
        ["…", rest @ ..] => (0..=printed.len()).any(|n| matches(rest, &printed[n..])),
        [line, rest @ ..] => printed.first() == Some(line) && matches(rest, &printed[1..]),
    }
}

/// Types what a page says into a new folder, and compares what it says that is printed.
fn follow(page: &Path, text: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    copy(
        &docs().join("../examples"),
        &folder.join("examples"),
        Some("result"),
    );
    let mut wrong = Vec::new();
    for block in parts(text).0 {
        if let Some((_, name)) = block.info.split_once(" file=") {
            let place = folder.join(name);
            std::fs::create_dir_all(place.parent().unwrap()).unwrap();
            std::fs::write(place, block.lines.join("\n") + "\n").unwrap();
        }
        if block.info != "console" {
            continue;
        }
        let mut lines = block.lines.iter().enumerate().peekable();
        while let Some((i, line)) = lines.next() {
            let place = format!("docs/{}:{}", page.display(), block.line + i + 1);
            let Some(command) = line.strip_prefix("$ ") else {
                panic!("{place}: output without a command");
            };
            let (command, fails) = match command.strip_suffix("# fails") {
                Some(command) => (command, true),
                None => (command, false),
            };
            let mut expected = Vec::new();
            while let Some((_, line)) = lines.next_if(|(_, l)| !l.starts_with("$ ")) {
                expected.push(line.trim_end());
            }
            let (printed, succeeds) = typed(folder, command);
            let printed: Vec<&str> = printed.lines().map(str::trim_end).collect();
            let said = expected.is_empty() || matches(&expected, &printed);
            if succeeds == fails || !said {
                wrong.push(format!(
                    "{place}: {command}\nprints\n{}",
                    printed.join("\n")
                ));
            }
        }
    }
    wrong
}

#[test]
fn law_what_the_pages_say_is_printed() {
    let pages = pages();
    let typed = pages
        .iter()
        .filter(|(_, text)| parts(text).0.iter().any(|b| b.info == "console"));
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let runs: Vec<_> = typed
            .map(|(page, text)| scope.spawn(move || follow(page, text)))
            .collect();
        runs.into_iter().flat_map(|r| r.join().unwrap()).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

//! The pages of `docs` as a book: every file in its contents, every link and anchor there, every command of a block `console` typed and
//! its output compared, every other command line read as the program reads it.

mod support;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::*;

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn docs() -> PathBuf {
    project().join("docs")
}

/// What is read beside the book.
const BESIDE: &[&str] = &[
    "README.md",
    "CONTRIBUTING.md",
    "ARCHITECTURE.md",
    "DESIGN.md",
    "SECURITY.md",
    "python/README.md",
];

/// The pages beside the book, with their paths below the folder of the project.
fn beside() -> Vec<(PathBuf, String)> {
    let read = |name: &&str| {
        let text = std::fs::read_to_string(project().join(name)).unwrap();
        (PathBuf::from(name), text)
    };
    BESIDE.iter().map(read).collect()
}

/// Every page of the book and beside it, with its path below the folder of the project.
fn all_pages() -> Vec<(PathBuf, String)> {
    let book = pages().into_iter();
    let book = book.map(|(page, text)| (Path::new("docs").join(page), text));
    book.chain(beside()).collect()
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

/// Beginnings of code that is set off by blanks alone: four more than the text around it, after an empty line.
fn set_off_by_blanks(prose: &[(usize, &str)]) -> Vec<usize> {
    let mut found = Vec::new();
    // Where the text of the list begins that a line may belong to.
    let mut list: Option<usize> = None;
    let mut after_empty = true;
    for (number, line) in prose {
        let line = line.replace('\t', "    ");
        let text = line.trim_start();
        if text.is_empty() {
            after_empty = true;
            continue;
        }
        let blanks = line.len() - text.len();
        if after_empty && blanks >= list.unwrap_or(0) + 4 {
            found.push(*number);
        } else if let Some(width) = marker(text) {
            list = Some(blanks + width);
        } else if after_empty && blanks == 0 {
            list = None;
        }
        after_empty = false;
    }
    found
}

/// How wide the marker is with which an item of a list begins, its blanks with it.
fn marker(text: &str) -> Option<usize> {
    let behind = text.trim_start_matches(|c: char| c.is_ascii_digit());
    let behind = match behind.len() == text.len() {
        true => text.strip_prefix(['-', '*', '+']),
        false => behind.strip_prefix(['.', ')']),
    }?;
    let item = behind.trim_start_matches(' ');
    (item.len() < behind.len()).then(|| text.len() - item.len())
}

/// The anchors of a page: those of its headings, as repositories and mdBook make them, and those that it writes itself.
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
    for (_, line) in prose {
        let written = line.split("<a id=\"").skip(1);
        anchors.extend(written.filter_map(|rest| Some(rest.split_once('"')?.0.to_owned())));
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

/// Inside of the book, which has nothing but what stands in `docs`, and from the pages beside it inside of the project.
#[test]
fn law_every_link_leads_somewhere() {
    let project = project().canonicalize().unwrap();
    let mut wrong = Vec::new();
    for (page, text) in &all_pages() {
        let root = match page.starts_with("docs") {
            true => project.join("docs"),
            false => project.clone(),
        };
        for (line, prose) in parts(text).1 {
            for link in links(prose) {
                if link.starts_with("http") || link.starts_with("mailto:") {
                    continue;
                }
                let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
                let target = match file {
                    "" => project.join(page),
                    file => project.join(page).parent().unwrap().join(file),
                };
                let inside = target.canonicalize().is_ok_and(|t| t.starts_with(&root));
                let known = || {
                    let text = std::fs::read_to_string(&target);
                    text.is_ok_and(|text| anchors(&text).contains(anchor))
                };
                if !inside || (!anchor.is_empty() && !known()) {
                    wrong.push(format!("{}:{line}: {link}", page.display()));
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
    let readme = std::fs::read_to_string(project().join("README.md")).unwrap();
    for (page, text) in pages().into_iter().chain([("README.md".into(), readme)]) {
        let itself = page.ends_with("glossary.md") || page.ends_with("SUMMARY.md");
        assert!(itself || text.contains("glossary.md"), "{}", page.display());
    }
}

/// A reader who comes from a search engine meets a word for the first time on such a page.
#[test]
fn law_every_tutorial_and_guide_links_a_word_of_the_glossary() {
    for (page, text) in pages() {
        let taught = page.starts_with("tutorials") || page.starts_with("how-to");
        let prose = parts(&text).1;
        let mut links = prose.iter().flat_map(|(_, line)| links(line));
        assert!(
            !taught || links.any(|link| link.starts_with("../glossary.md#")),
            "docs/{} links no word: write [word](../glossary.md#anchor)",
            page.display()
        );
    }
}

#[test]
fn law_every_block_of_code_stands_between_fences() {
    for (page, text) in pages() {
        let first = set_off_by_blanks(&parts(&text).1).into_iter().next();
        assert!(
            first.is_none(),
            "docs/{}:{}: a block of code that is set off by blanks: put it between fences that name its language",
            page.display(),
            first.unwrap_or_default()
        );
    }
}

#[test]
fn known_beginnings_of_code_that_is_set_off_by_blanks() {
    let page = "text\n\n    code\n    code\n\n- item\n  goes on\n\n    its second paragraph\n\n      code\n\n\
        text\n    goes on\n\n10. item\n\n        code\n\n    ```sh\n        fenced\n    ```\n\ntext\n\n\tcode\n";
    assert_eq!(set_off_by_blanks(&parts(page).1), [3, 11, 18, 26]);
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

/// Words of a line, with quotes and comments as a shell has them.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quote = None;
    for c in line.trim().chars() {
        match (quote, c) {
            (Some(q), c) if q == c => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, '#') if words.last().unwrap().is_empty() => break,
            (None, ' ') => {
                if !words.last().unwrap().is_empty() {
                    words.push(String::new());
                }
            }
            (_, c) => words.last_mut().unwrap().push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Lines of a block, with what a line that ends with `\` goes on with, and the numbers of the lines that they begin in.
fn joined(block: &Fenced<'_>) -> Vec<(usize, String)> {
    let mut lines: Vec<(usize, String)> = Vec::new();
    let mut goes_on = false;
    for (i, line) in block.lines.iter().enumerate() {
        let line = line.trim();
        let (text, more) = match line.strip_suffix('\\') {
            Some(text) => (text, true),
            None => (line, false),
        };
        match lines.last_mut().filter(|_| goes_on) {
            Some((_, before)) => *before += text,
            None => lines.push((block.line + i + 1, text.to_owned())),
        }
        goes_on = more;
    }
    lines
}

/// Calls of the program in a line: alone, behind the `$` of a shell, in a pipe, or one after the other.
fn calls(line: &str) -> Vec<Vec<String>> {
    let words = words(line.strip_prefix("$ ").unwrap_or(line));
    let ends = |word: &String| ["|", "&&", ">"].contains(&word.as_str());
    let commands = words.split(ends);
    let own = commands.filter(|command| command.first().is_some_and(|word| word == "proofmass"));
    own.map(<[String]>::to_vec).collect()
}

/// What the program has against a call. `…` stands for what is left out: then something may be missing.
fn refused(program: &clap::Command, call: &[String]) -> Option<String> {
    let mut arguments = Vec::new();
    for word in call.iter().filter(|word| *word != "…") {
        match word.strip_prefix('@') {
            Some(file) => {
                let text = std::fs::read_to_string(project().join(file));
                let text = text.unwrap_or_else(|e| panic!("{file}: {e}"));
                arguments.extend(text.lines().flat_map(words));
            }
            None => arguments.push(word.clone()),
        }
    }
    let wrong = program.clone().try_get_matches_from(arguments).err()?;
    let left_out = call.iter().any(|word| word == "…");
    let missing = wrong.kind() == clap::error::ErrorKind::MissingRequiredArgument;
    // Help is no refusal.
    (wrong.use_stderr() && !(left_out && missing)).then(|| wrong.to_string())
}

/// What is not typed is read, so that no page names a command or an option that is not there.
#[test]
fn law_every_command_line_is_understood() {
    let program = proofmass_cli::commands();
    let mut understood = 0;
    let mut wrong = Vec::new();
    for (page, text) in all_pages() {
        let blocks = parts(&text).0;
        for block in blocks.iter().filter(|block| block.info != "console") {
            for (number, line) in joined(block) {
                for call in calls(&line) {
                    match refused(&program, &call) {
                        None => understood += 1,
                        Some(said) => {
                            wrong.push(format!("{}:{number}: {line}\n{said}", page.display()));
                        }
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(understood > 150, "{understood} command lines");
}

#[test]
fn known_calls_of_a_line() {
    for (line, expected) in [
        ("proofmass inspect a.csv   # what it holds", "inspect a.csv"),
        ("zcat a.gz | proofmass inspect - > 'the list'", "inspect -"),
        (
            "proofmass simulate axis -o a && proofmass formats",
            "simulate axis -o a;formats",
        ),
        (
            "$ proofmass explain \"Allan variance\"",
            "explain Allan variance",
        ),
        ("cargo run # proofmass formats", ""),
        ("proofmass.manifest 1", ""),
    ] {
        let calls: Vec<String> = calls(line).iter().map(|c| c[1..].join(" ")).collect();
        assert_eq!(calls.join(";"), expected, "{line}");
    }
    let program = proofmass_cli::commands();
    let said = |line: &str| refused(&program, &calls(line)[0]);
    assert_eq!(said("proofmass inspect a.csv --plot a.html"), None);
    assert_eq!(said("proofmass test shock a.csv …"), None);
    for line in [
        "proofmass test shock",
        "proofmass test shock a.csv … --colum a",
        "proofmass inspekt a.csv",
        "proofmass noise a.csv --rate fast",
    ] {
        assert!(said(line).is_some(), "{line}");
    }
}

/// The tasks are numbered through, each has a command, and the pages that say how many there are say the same.
#[test]
fn law_every_task_has_its_command() {
    let text = std::fs::read_to_string(docs().join("tasks.md")).unwrap();
    let (blocks, prose) = parts(&text);
    let task = |(number, line): &(usize, &str)| {
        let (count, _) = line.split_once(". ")?;
        Some((count.parse::<usize>().ok()?, *number))
    };
    let tasks: Vec<(usize, usize)> = prose.iter().filter_map(task).collect();
    for (k, (count, line)) in tasks.iter().enumerate() {
        assert_eq!(*count, k + 1, "docs/tasks.md:{line}");
        let next = tasks.get(k + 1).map_or(usize::MAX, |next| next.1);
        let mut own = blocks.iter().filter(|b| (*line..next).contains(&b.line));
        assert!(
            own.any(|block| block
                .lines
                .iter()
                .any(|line| !calls(line.trim()).is_empty())),
            "docs/tasks.md:{line}: a task without a command"
        );
    }
    let readme = std::fs::read_to_string(project().join("README.md")).unwrap();
    for (page, text) in [("docs/tasks.md", &text), ("README.md", &readme)] {
        let said = format!(" {} tasks", tasks.len());
        assert!(text.contains(&said), "{page} does not say {said}");
    }
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
        &project().join("examples"),
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
                let ends = match succeeds {
                    true => "succeeds",
                    false => "fails",
                };
                wrong.push(format!(
                    "{place}: {command}\n{ends}. The page says\n{}\nand this is printed\n{}",
                    expected.join("\n"),
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

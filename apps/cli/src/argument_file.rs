//! Arguments from a file: `@FILE` stands for its lines, an option or an argument to a line, or several options.

use crate::Failure;
use clap::error::{ContextKind, ContextValue};
use proofmass::io::{LARGEST_DOCUMENT, Source};
use std::ffi::OsString;

/// The arguments of a call, those of files in their places.
pub(crate) struct Expanded {
    pub(crate) arguments: Vec<OsString>,
    lines: Vec<Line>,
}

/// A line of a file that gave an argument.
struct Line {
    /// The file and the line's number.
    place: String,
    text: String,
}

/// Puts the lines of `@FILE` in its place; after `--` nothing is a file of arguments.
///
/// # Errors
/// A file that cannot be read or is no text; one that names another.
pub(crate) fn expand<T: Into<OsString>>(
    arguments: impl IntoIterator<Item = T>,
) -> Result<Expanded, Failure> {
    let mut expanded = Expanded {
        arguments: Vec::new(),
        lines: Vec::new(),
    };
    let mut plain = false;
    for (index, argument) in arguments
        .into_iter()
        .map(Into::<OsString>::into)
        .enumerate()
    {
        plain |= argument == "--";
        let file = argument.to_str().and_then(|text| text.strip_prefix('@'));
        match file {
            Some(file) if index > 0 && !plain => expanded.read(file)?,
            _ => expanded.arguments.push(argument),
        }
    }
    Ok(expanded)
}

impl Expanded {
    fn read(&mut self, file: &str) -> Result<(), Failure> {
        if file.is_empty() {
            return Err(Failure::new("`@` names no file of arguments")
                .hint("write @FILE; a recording whose name begins with @ is named ./@NAME"));
        }
        let source = Source::open(file).map_err(|error| {
            Failure::from(error).detail(format!("@{file} stands for the arguments in that file"))
        })?;
        let (bytes, _) = source.into_bytes(LARGEST_DOCUMENT)?;
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
        for (index, line) in bytes.split(|b| *b == b'\n').enumerate() {
            let place = format!("{file}:{}", index + 1);
            let line = std::str::from_utf8(line).map_err(|_| {
                Failure::new("a file of arguments is a text in UTF-8")
                    .detail(place.clone())
                    .hint("write one option with its value to a line, such as `--radius 0.3`")
            })?;
            let text = without_comment(line).trim();
            if text.is_empty() {
                continue;
            }
            if text.starts_with('@') {
                return Err(
                    Failure::new("a file of arguments does not name another one")
                        .detail(place)
                        .hint("name both in the call: @FILE @OTHER"),
                );
            }
            match text.split_once(char::is_whitespace) {
                Some((option, _)) if option.starts_with('-') && several(text) => {
                    let words = words(text).into_iter().map(|w| unquoted(w).into());
                    self.arguments.extend(words);
                }
                Some((option, value)) if option.starts_with('-') => {
                    self.arguments.push(option.into());
                    self.arguments.push(unquoted(value.trim()).into());
                }
                _ => self.arguments.push(unquoted(text).into()),
            }
            self.lines.push(Line {
                place,
                text: text.to_owned(),
            });
        }
        Ok(())
    }

    /// The line that an error of the arguments is about, where it stands in a file.
    pub(crate) fn line(&self, error: &clap::Error) -> Option<String> {
        let said = |kind| match error.get(kind) {
            Some(ContextValue::String(text)) => vec![text.as_str()],
            Some(ContextValue::Strings(texts)) => texts.iter().map(String::as_str).collect(),
            _ => Vec::new(),
        };
        let first = |text: &str| -> String {
            let end = text.find(|c: char| c.is_whitespace() || c == '=');
            text[..end.unwrap_or(text.len())].to_owned()
        };
        let options: Vec<String> = said(ContextKind::InvalidArg)
            .into_iter()
            .map(first)
            .collect();
        let values = said(ContextKind::InvalidValue);
        let has_option = |line: &&Line| options.contains(&first(&line.text));
        let has_value = |line: &&Line| {
            values
                .iter()
                .any(|v| !v.is_empty() && line.text.contains(v))
        };
        // The last line of an option is the one too many.
        let mut last = self.lines.iter().rev();
        let found = last
            .clone()
            .find(|line| has_option(line) && has_value(line));
        let found = found.or_else(|| last.clone().find(has_option));
        let found = found.or_else(|| last.find(has_value))?;
        Some(format!("{}: {}", found.place, found.text))
    }
}

/// A line up to a `#` at its beginning or after a space, outside of quotes.
fn without_comment(line: &str) -> &str {
    let mut quoted = false;
    let mut after_space = true;
    for (at, c) in line.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '#' if after_space && !quoted => return &line[..at],
            _ => {}
        }
        after_space = c.is_whitespace();
    }
    line
}

/// Whether a line has more than one option: its words are then arguments, and a value with a blank stands in quotes.
fn several(line: &str) -> bool {
    let option = |word: &&str| {
        let name = word.strip_prefix("--");
        name.is_some_and(|n| n.starts_with(|c: char| c.is_ascii_alphabetic()))
    };
    words(line).iter().skip(1).any(option)
}

/// What stands between blanks, outside of quotes.
fn words(line: &str) -> Vec<&str> {
    let mut quoted = false;
    let blank = |c: char| {
        quoted ^= c == '"';
        c.is_whitespace() && !quoted
    };
    line.split(blank).filter(|word| !word.is_empty()).collect()
}

/// A value without the quotes around it.
fn unquoted(value: &str) -> &str {
    let inner = value.strip_prefix('"').and_then(|v| v.strip_suffix('"'));
    inner.unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(expanded: &Expanded) -> Vec<&str> {
        let words = expanded.arguments.iter().filter_map(|a| a.to_str());
        words.collect()
    }

    #[test]
    fn known_lines_become_arguments_in_their_place() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("encoder.args");
        let lines = "\u{feff}# an encoder\r\n--position count   # its column\r\n\r\n--radius 0.3\n--edges\n--unit=m\n--title \"a # b\"\nrun 7.csv";
        std::fs::write(&file, lines).expect("a file");
        let at = format!("@{}", file.display());
        let found =
            expand(["proofmass", "velocity", &at, "--", "@x"]).expect("a file of arguments");
        assert_eq!(
            text(&found),
            [
                "proofmass",
                "velocity",
                "--position",
                "count",
                "--radius",
                "0.3",
                "--edges",
                "--unit=m",
                "--title",
                "a # b",
                "run 7.csv",
                "--",
                "@x"
            ]
        );
        assert!(found.lines[1].place.ends_with("encoder.args:4"));
    }

    #[test]
    fn known_options_on_one_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("line.args");
        let lines = "--position \"my count\" --radius 0.3 --reverse # of a wheel\n--title drive to -- and fro\n--latency -0.5";
        std::fs::write(&file, lines).expect("a file");
        let found = expand(["proofmass", &format!("@{}", file.display())]).expect("arguments");
        let told = [
            "proofmass",
            "--position",
            "my count",
            "--radius",
            "0.3",
            "--reverse",
            "--title",
            "drive to -- and fro",
            "--latency",
            "-0.5",
        ];
        assert_eq!(text(&found), told);
    }

    #[test]
    fn refuses_what_is_no_file_of_arguments() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = |name: &str, bytes: &[u8]| {
            let file = folder.path().join(name);
            std::fs::write(&file, bytes).expect("a file");
            format!("@{}", file.display())
        };
        for (argument, said) in [
            ("@".to_owned(), "names no file"),
            ("@/nowhere/x.args".to_owned(), "stands for the arguments"),
            (place("binary", b"--edges\n\xff\xfe\n"), "binary:2"),
            (place("nested", b"--edges\n@other\n"), "nested:2"),
        ] {
            let refused = expand(["proofmass", &argument])
                .err()
                .map(|f| f.to_string());
            assert!(
                refused.is_some_and(|text| text.contains(said)),
                "{argument}"
            );
        }
    }
}

//! The page of all commands with their options, from their declaration.

use clap::{Arg, Command};
use std::fmt::Write as _;

/// Markdown of `docs/commands.md`.
pub fn reference() -> String {
    let mut root = crate::commands().disable_help_subcommand(true);
    root.build();
    let mut page = "# Commands\n\n\
        Every command with its options. This page is written from the program (`cargo run -p proofmass-cli --example commands_page`).\n\
        `proofmass COMMAND -h` shows what is needed first, `--help` everything. Commands of features that are not in the default build are \
        marked in the README. The words are explained in the [glossary](glossary.md).\n"
        .to_owned();
    for command in root.get_subcommands() {
        describe(command, "proofmass", &mut page);
    }
    page
}

fn describe(command: &Command, before: &str, page: &mut String) {
    let name = format!("{before} {}", command.get_name());
    let _ = write!(page, "\n## {name}\n");
    let about = command.get_long_about().or(command.get_about());
    if let Some(about) = about {
        page.push_str(&description(&about.to_string()));
    }
    let shown: Vec<&Arg> = command
        .get_arguments()
        .filter(|a| !a.is_hide_set() && !matches!(a.get_id().as_str(), "help" | "version"))
        .collect();
    if !shown.is_empty() {
        page.push_str("\n| argument | what it is | default |\n|---|---|---|\n");
        for argument in shown {
            let _ = writeln!(
                page,
                "| {} | {} | {} |",
                spelled(argument),
                cell(argument),
                default(argument)
            );
        }
    }
    for inner in command.get_subcommands().filter(|c| !c.is_hide_set()) {
        describe(inner, &name, page);
    }
}

/// A description. What is set off by blanks in it is a file in TOML, which stands between fences on the page.
fn description(text: &str) -> String {
    let (mut page, mut file) = (String::new(), false);
    for paragraph in text.split("\n\n") {
        let lines: Option<Vec<&str>> = paragraph.lines().map(|l| l.strip_prefix("    ")).collect();
        page.push_str(match (file, lines.is_some()) {
            (false, true) => "\n```toml\n",
            (true, false) => "```\n\n",
            _ => "\n",
        });
        file = lines.is_some();
        page.push_str(&lines.map_or_else(|| escaped(paragraph), |lines| lines.join("\n")));
        page.push('\n');
    }
    if file {
        page.push_str("```\n");
    }
    page
}

/// The argument as it is typed.
fn spelled(argument: &Arg) -> String {
    let takes = argument.get_action().takes_values();
    let values: Vec<String> = argument
        .get_value_names()
        .unwrap_or_default()
        .iter()
        .map(|v| v.to_string())
        .filter(|_| takes)
        .collect();
    let long = argument.get_long().map(|l| format!("--{l}"));
    let names: Vec<String> = argument
        .get_short()
        .map(|s| format!("-{s}"))
        .into_iter()
        .chain(long)
        .collect();
    let words: Vec<String> = [names.join(", "), values.join(" ")]
        .into_iter()
        .filter(|w| !w.is_empty())
        .collect();
    format!("`{}`", words.join(" ").replace('|', "\\|"))
}

/// What the argument is, with the words that it takes.
fn cell(argument: &Arg) -> String {
    let help = argument.get_long_help().or(argument.get_help());
    let help = help.map(|h| escaped(&h.to_string())).unwrap_or_default();
    // The first paragraph is the short help, which ends without a full stop.
    let mut text = help.trim().replace(".\n\n", "\n\n").replace("\n\n", ". ");
    let words: Vec<String> = argument
        .get_possible_values()
        .iter()
        .filter(|v| !v.is_hide_set())
        .map(|v| format!("`{}`", v.get_name()))
        .collect();
    if !words.is_empty() && argument.get_action().takes_values() {
        let _ = write!(text, " ({})", words.join(", "));
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn default(argument: &Arg) -> String {
    let values: Vec<String> = argument
        .get_default_values()
        .iter()
        .map(|v| v.to_string_lossy().into_owned())
        .collect();
    match values.is_empty() || !argument.get_action().takes_values() {
        true if argument.is_required_set() => "needed".to_owned(),
        true => String::new(),
        false => format!("`{}`", values.join(",")),
    }
}

/// A text without what Markdown would take for its own.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut code = false;
    for c in text.chars() {
        code ^= c == '`';
        if !code && matches!(c, '<' | '>' | '*' | '_') || c == '|' {
            out.push('\\');
        }
        out.push(c);
    }
    out
}

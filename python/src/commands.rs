//! Every command with its options, for the code of the Python functions.

use clap::{Arg, ArgAction, Command, ValueHint};
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::any::TypeId;
use std::path::PathBuf;

/// What a shell is given, and Python has no use for; what help is about; what is a program of its own.
const OF_THE_SHELL: [&str; 4] = ["help", "completions", "manual", "lab"];

/// Every command that does something by itself, as JSON: its words, its help, its arguments.
#[pyfunction]
pub(crate) fn commands() -> String {
    let mut root = proofmass_cli::commands();
    root.build();
    let mut found = Vec::new();
    gather(&root, &[], &mut found);
    Value::from(found).to_string()
}

/// Every kind of result, as `kind` in result.json.
#[pyfunction]
pub(crate) fn result_kinds() -> Vec<&'static str> {
    proofmass::jobs::result_kinds()
}

fn gather(command: &Command, words: &[&str], found: &mut Vec<Value>) {
    let for_python = |c: &&Command| !OF_THE_SHELL.contains(&c.get_name());
    for inner in command.get_subcommands().filter(for_python) {
        let words = [words, &[inner.get_name()]].concat();
        // One that only leads to others is no function, whatever it hands down to them.
        let takes =
            !inner.is_subcommand_required_set() && inner.get_arguments().any(|a| !is_help(a));
        if takes || !inner.has_subcommands() {
            let arguments = inner
                .get_arguments()
                .filter(|a| !is_help(a) && !a.is_hide_set());
            let about = inner.get_about().map(ToString::to_string);
            let long = inner.get_long_about().map(ToString::to_string);
            found.push(json!({
                "words": words,
                "about": about,
                "long": long,
                "arguments": arguments.map(argument).collect::<Vec<_>>(),
            }));
        }
        gather(inner, &words, found);
    }
}

fn is_help(argument: &Arg) -> bool {
    matches!(argument.get_id().as_str(), "help" | "version" | "help_all")
}

fn argument(argument: &Arg) -> Value {
    let parser = argument.get_value_parser().type_id();
    let one = |id: TypeId| parser == id;
    let kind = if !argument.get_action().takes_values() {
        "bool"
    } else if one(TypeId::of::<PathBuf>()) || argument.get_value_hint() == ValueHint::FilePath {
        "path"
    } else if [TypeId::of::<f64>(), TypeId::of::<f32>()]
        .into_iter()
        .any(one)
    {
        "float"
    } else if [
        TypeId::of::<usize>(),
        TypeId::of::<u64>(),
        TypeId::of::<u32>(),
        TypeId::of::<u8>(),
        TypeId::of::<i64>(),
        TypeId::of::<i32>(),
    ]
    .into_iter()
    .any(one)
    {
        "int"
    } else {
        "str"
    };
    let defaults = argument.get_default_values().iter();
    let defaults: Vec<_> = defaults.map(|v| v.to_string_lossy()).collect();
    let range = argument.get_num_args();
    let several = range.is_some_and(|r| r.max_values() > 1);
    let choices = argument.get_possible_values();
    json!({
        "id": argument.get_id().as_str(),
        "long": argument.get_long(),
        "position": argument.get_index(),
        "kind": kind,
        "required": argument.is_required_set(),
        "repeated": matches!(argument.get_action(), ArgAction::Append),
        "several": several,
        "delimiter": argument.get_value_delimiter(),
        "defaults": defaults,
        "choices": choices.iter().map(|c| c.get_name()).collect::<Vec<_>>(),
        "help": argument.get_help().map(ToString::to_string),
        "long_help": argument.get_long_help().map(ToString::to_string),
    })
}

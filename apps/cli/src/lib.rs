//! `proofmass`: the open accelerometer laboratory on the command line, as a function of its arguments.

mod apply;
mod argument_file;
mod at_arguments;
mod bias;
mod calibrate;
mod certificate;
mod chain_arguments;
mod clock;
mod compare;
mod console;
mod convert;
mod delivery;
mod device;
mod draft_arguments;
mod exit_code;
mod explain;
mod export;
mod failure;
mod formats;
mod glossary;
mod gravity_arguments;
mod help;
mod host;
mod import;
mod init;
mod inspect;
mod keygen;
mod lab;
mod modes;
mod noise;
mod number_arguments;
mod plan;
#[cfg(feature = "records")]
mod records;
mod reference;
mod render;
mod schema;
mod shell;
mod simulate;
mod test;
mod uncertainty;
mod validate;
mod velocity;
mod verify;
mod written_file;

use clap::error::{ContextKind, ContextValue};
use clap::{FromArgMatches, Parser, Subcommand};
pub use clock::today;
use failure::Failure;
pub use host::{Host, call};
use proofmass::io::Addressee;
use proofmass::jobs::Trouble;
pub use reference::reference;
use std::ffi::OsString;

/// The open accelerometer laboratory: from a recording to a calibration with a defensible uncertainty, and to
/// compensated acceleration.
#[derive(Parser)]
#[command(
    name = "proofmass",
    version,
    arg_required_else_help = true,
    propagate_version = true
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Calibrate(Box<calibrate::Calibrate>),
    Init(init::Init),
    Plan(plan::Plan),
    Lab(lab::Lab),
    Apply(apply::Apply),
    Export(export::Export),
    Filter(export::Filter),
    Import(import::Import),
    Validate(validate::Validate),
    Compare(compare::Compare),
    Device(device::Device),
    Certificate(certificate::Certificate),
    Velocity(Box<velocity::Velocity>),
    Noise(Box<noise::Noise>),
    Bias(Box<bias::Bias>),
    Modes(modes::Modes),
    Test(test::Test),
    Inspect(inspect::Inspect),
    Formats(formats::Formats),
    Convert(Box<convert::Convert>),
    Simulate(simulate::Simulate),
    Render(render::Render),
    Explain(explain::Explain),
    Uncertainty(uncertainty::Uncertainty),
    Verify(verify::Verify),
    Keygen(keygen::Keygen),
    Schema(schema::Schema),
    Completions(shell::Completions),
    Manual(shell::Manual),
    #[cfg(feature = "records")]
    Records(Box<records::Records>),
}

impl Command {
    /// What says how recordings are read: a campaign, or options.
    fn typed_by(&self) -> Addressee {
        match self {
            Self::Calibrate(command) if command.is_of_a_campaign() => Addressee::Campaign,
            Self::Plan(_) => Addressee::Campaign,
            _ => Addressee::Options,
        }
    }
}

/// A program of the project beside this one, else wherever the system finds it.
pub(crate) fn beside(program: &str) -> std::path::PathBuf {
    let own = std::env::current_exe().ok();
    let beside =
        own.map(|own| own.with_file_name(format!("{program}{}", std::env::consts::EXE_SUFFIX)));
    beside
        .filter(|b| b.is_file())
        .unwrap_or_else(|| program.into())
}

/// What a command that came to an end tells the shell.
pub(crate) enum Outcome {
    /// Good.
    Done,
    /// Done, with findings that need a decision, and `--strict` was asked for.
    Doubtful,
}

impl Outcome {
    /// The more doubtful of two.
    pub(crate) fn or(self, other: Self) -> Self {
        match self {
            Self::Done => other,
            Self::Doubtful => self,
        }
    }

    /// What findings mean for the shell: with `strict`, one that needs a decision is not simply done.
    pub(crate) fn of(strict: bool, findings: &[proofmass::uncertainty::Finding]) -> Self {
        if strict && console::needs_decision(findings) {
            Self::Doubtful
        } else {
            Self::Done
        }
    }
}

fn execute(arguments: Arguments) -> Result<Outcome, Failure> {
    match arguments.command {
        Command::Calibrate(command) => command.run(),
        Command::Init(command) => command.run(),
        Command::Plan(command) => command.run(),
        Command::Lab(command) => command.run(),
        Command::Apply(command) => command.run(),
        Command::Export(command) => command.run(),
        Command::Filter(command) => command.run(),
        Command::Import(command) => command.run(),
        Command::Validate(command) => command.run(),
        Command::Compare(command) => command.run(),
        Command::Device(command) => command.run(),
        Command::Certificate(command) => command.run(),
        Command::Velocity(command) => command.run(),
        Command::Noise(command) => command.run(),
        Command::Bias(command) => command.run(),
        Command::Modes(command) => command.run(),
        Command::Test(command) => command.run(),
        Command::Inspect(command) => command.run(),
        Command::Formats(command) => command.run(),
        Command::Convert(command) => command.run(),
        Command::Simulate(command) => command.run(),
        Command::Render(command) => command.run(),
        Command::Explain(command) => command.run(),
        Command::Uncertainty(command) => command.run(),
        Command::Verify(command) => command.run(),
        Command::Keygen(command) => command.run(),
        Command::Schema(command) => command.run(),
        Command::Completions(command) => command.run(),
        Command::Manual(command) => command.run(),
        #[cfg(feature = "records")]
        Command::Records(command) => command.run(),
    }
}

/// Keeps quiet about panics that are caught and told as errors: those of the reader of Parquet over damaged pages.
pub fn handle_panics() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let is_caught = panic
            .location()
            .is_some_and(|at| at.file().contains("/parquet-"));
        if !is_caught {
            usual(panic);
        }
    }));
}

/// Removes what is being written when the user or the system ends the process, and ends it with 128 and the number of the
/// signal, as a shell tells it: 130 after Ctrl-C (SIGINT), 143 after SIGTERM, 129 after SIGHUP. Results in place are the old ones
/// or the new ones. Without it the next run would remove what was being written.
///
/// Call it before anything else: threads that are there already would take the signals themselves.
pub fn handle_interrupts() {
    let end = |code: i32| {
        proofmass::io::discard_unfinished();
        console::complain("interrupted: nothing was written\n");
        std::process::exit(code);
    };
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigSet, Signal};
        // A file above the limit of its size is then an error of the writing, like a full disk, and no end of the process.
        let _ = SigSet::from(Signal::SIGXFSZ).thread_block();
        let all: SigSet = [Signal::SIGINT, Signal::SIGTERM, Signal::SIGHUP]
            .into_iter()
            .collect();
        let waiter = move || {
            if let Ok(signal) = all.wait() {
                end(128 + signal as i32);
            }
        };
        // Blocked here and in every later thread, and taken by one; where there is none for it the signals end the process themselves.
        if all.thread_block().is_ok() && std::thread::Builder::new().spawn(waiter).is_err() {
            let _ = all.thread_unblock();
        }
    }
    #[cfg(not(unix))]
    {
        let _ = ctrlc::set_handler(move || end(130));
    }
}

/// Begins the threads of the calculation, which would otherwise be begun by the first that needs one, and panic there.
fn begin_threads() -> Result<(), Failure> {
    let Err(refused) = rayon::ThreadPoolBuilder::new().build_global() else {
        return Ok(());
    };
    // Without a source it says that an earlier call in this process began them.
    match std::error::Error::source(&refused) {
        None => Ok(()),
        Some(why) => Err(no_threads(why).into()),
    }
}

/// What is wrong where the system gives no threads, and what to do about it.
pub fn no_threads(why: impl std::fmt::Display) -> Trouble {
    Trouble::request(format!("the system gives no threads to calculate with: {why}"))
        .with_hint("raise the number of processes (`ulimit -u`) or the memory that this user may have, or end other programs")
}

/// Carries out a command, its threads begun.
fn begun(arguments: Arguments) -> Result<Outcome, Failure> {
    begin_threads().and_then(|()| execute(arguments))
}

/// Every command with its options, as it stands in the help: what a page, a completion or another language is made from.
pub fn commands() -> clap::Command {
    help::command()
}

/// The arguments, the name of the program first, as a request.
fn read<I, T>(command: &mut clap::Command, arguments: I) -> Result<Arguments, clap::Error>
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let mut matches = command.try_get_matches_from_mut(arguments)?;
    Arguments::from_arg_matches_mut(&mut matches)
}

/// A negative number that was taken for an option.
fn negative_value(wrong: &clap::Error) -> Option<String> {
    match wrong.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(word))
            if wrong.kind() == clap::error::ErrorKind::UnknownArgument =>
        {
            let number = word.starts_with('-') && word.contains(|c: char| c.is_ascii_digit());
            (number && word.parse::<f64>().is_ok()).then(|| word.clone())
        }
        _ => None,
    }
}

/// Where a term leads that was typed as a command: the word and as many behind it as the glossary has together.
fn no_command(word: &str, arguments: &[OsString], command: &clap::Command) -> Option<Failure> {
    let typed = arguments.iter().map(|a| a.to_string_lossy());
    let typed: Vec<_> = typed.skip_while(|a| a != word).take(3).collect();
    (1..=typed.len())
        .rev()
        .find_map(|n| glossary::no_command(&typed[..n].join(" "), command))
}

/// The arguments as a request, or the exit code after help, the version or an error was shown.
fn parsed<I, T>(arguments: I) -> Result<Arguments, u8>
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let expanded = argument_file::expand(arguments).map_err(|failure| {
        console::complain(&failure.to_string());
        exit_code::WRONG_USE
    })?;
    let mut command = commands();
    read(&mut command, &expanded.arguments).map_err(|mut wrong| {
        if let Some(ContextValue::String(word)) = wrong.get(ContextKind::InvalidSubcommand)
            && let Some(failure) = no_command(word, &expanded.arguments, &command)
        {
            console::complain(&failure.to_string());
            return exit_code::WRONG_USE;
        }
        if let Some(failure) = number_arguments::no_number(&wrong) {
            console::complain(&failure.to_string());
            if let Some(line) = expanded.line(&wrong) {
                console::note(line);
            }
            return exit_code::WRONG_USE;
        }
        let negative = negative_value(&wrong);
        // Nobody means an unknown option as a value.
        if wrong.kind() == clap::error::ErrorKind::UnknownArgument {
            wrong.remove(ContextKind::Suggested);
        }
        // Help and version come this way too, to standard output and with code 0.
        let _ = wrong.print();
        if let Some(value) = negative {
            console::note(format!(
                "a negative value is joined to its option by =, such as --option={value}"
            ));
        }
        if let Some(line) = expanded.line(&wrong) {
            console::note(format!("\n  {line}"));
        }
        u8::try_from(wrong.exit_code()).unwrap_or(exit_code::WRONG_USE)
    })
}

/// Runs one command, the name of the program first, and returns its exit code: 0 done, 1 failed, 2 wrong use, 3 done with
/// findings that need a decision under `--strict`.
pub fn run<I, T>(arguments: I) -> u8
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let arguments = match parsed(arguments) {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    let person = arguments.command.typed_by();
    match begun(arguments) {
        Ok(Outcome::Done) => exit_code::DONE,
        Ok(Outcome::Doubtful) => exit_code::DECISION,
        Err(failure) if failure.is_broken_pipe() => exit_code::DONE,
        Err(failure) => {
            console::complain(&failure.read_by(person).to_string());
            exit_code::FAILED
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INPUT_AND_OUTPUT: &[&str] = &[
        "columns",
        "unit",
        "input",
        "input-unit",
        "output-column",
        "output-unit",
    ];
    const AXIS: &[&str] = &[
        "columns",
        "position",
        "unit",
        "acceleration",
        "acceleration-unit",
    ];

    /// What each command that reads a recording calls its columns and their units.
    const READ: &[(&str, &[&str])] = &[
        ("calibrate", &["columns", "unit"]),
        ("init", &["columns", "unit"]),
        ("apply", &["columns", "unit"]),
        ("validate", &["columns", "unit"]),
        ("bias", &["columns", "unit"]),
        ("inspect", &["columns", "unit"]),
        ("convert", &["columns", "unit"]),
        ("noise", &["columns", "unit"]),
        ("test zero-g", &["columns", "unit"]),
        ("test mounting", &["columns", "unit"]),
        ("test temperature", &["columns", "unit"]),
        ("test random", INPUT_AND_OUTPUT),
        ("test impact", INPUT_AND_OUTPUT),
        ("test sweep", INPUT_AND_OUTPUT),
        ("test steps", INPUT_AND_OUTPUT),
        (
            "test shock",
            &["column", "unit", "reference", "reference-unit"],
        ),
        ("test step", &["column", "unit"]),
        ("test motion", &["column", "unit"]),
        ("test deconvolve", &["column", "unit"]),
        ("velocity estimate", AXIS),
        ("velocity compare", AXIS),
        ("velocity tune", AXIS),
        ("velocity map", AXIS),
    ];

    /// Every command and subcommand with the words that lead to it.
    fn commands(command: &clap::Command, words: &str, all: &mut Vec<(String, clap::Command)>) {
        for sub in command.get_subcommands() {
            let words = format!("{words} {}", sub.get_name()).trim().to_owned();
            all.push((words.clone(), sub.clone()));
            commands(sub, &words, all);
        }
    }

    #[test]
    fn law_every_command_that_reads_a_recording_takes_what_it_does_not_say() {
        let mut all = Vec::new();
        commands(&help::command(), "", &mut all);
        let reads = |command: &clap::Command| {
            let mut named = command.get_positionals().map(|a| a.get_id().as_str());
            named.any(|id| id == "recording" || id == "recordings")
        };
        for (words, command) in &all {
            let listed = READ.iter().any(|(name, _)| name == words);
            assert!(listed || !reads(command), "{words} reads a recording");
        }
        for (words, own) in READ {
            let found = all.iter().find(|(name, _)| name == words);
            let (_, command) = found.unwrap_or_else(|| panic!("there is no {words}"));
            let option = |name: &str| {
                let found = command.get_arguments().find(|a| a.get_long() == Some(name));
                found.unwrap_or_else(|| panic!("{words} has no --{name}"))
            };
            for name in *own {
                option(name);
            }
            for (name, values) in [
                ("time", &["COLUMN"][..]),
                ("time-unit", &["UNIT"]),
                ("rate", &["HZ"]),
                ("between", &["FROM", "TO"]),
            ] {
                let option = option(name);
                let names: Vec<&str> = option
                    .get_value_names()
                    .unwrap_or_default()
                    .iter()
                    .map(|name| name.as_str())
                    .collect();
                assert_eq!(names, values, "{words} --{name}");
                assert!(!option.is_required_set(), "{words} --{name}");
            }
        }
    }

    /// Whether the command of a call is in this build: the records are a feature.
    pub(crate) fn is_built(call: &str) -> bool {
        cfg!(feature = "records") || call.split(' ').nth(1) != Some("records")
    }
}

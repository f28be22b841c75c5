//! `proofmass`: the open accelerometer laboratory on the command line.

mod apply;
mod calibrate;
mod clock;
mod console;
mod delivery;
mod draft_arguments;
mod export;
mod failure;
mod init;
mod inspect;
mod modes;
mod noise;
mod plan;
mod plural;
mod recording_arguments;
mod render;
mod simulate;
mod test;
mod uncertainty;
mod validate;
mod velocity;
mod verify;

use clap::{Parser, Subcommand};
use failure::Failure;
use std::process::ExitCode;

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
    Apply(apply::Apply),
    Export(export::Export),
    Validate(validate::Validate),
    Velocity(Box<velocity::Velocity>),
    Noise(Box<noise::Noise>),
    Modes(modes::Modes),
    Test(test::Test),
    Inspect(inspect::Inspect),
    Simulate(simulate::Simulate),
    Render(render::Render),
    Uncertainty(uncertainty::Uncertainty),
    Verify(verify::Verify),
}

/// What a command that came to an end tells the shell.
pub(crate) enum Outcome {
    /// Good.
    Done,
    /// Done, with findings that need a decision, and `--strict` was asked for.
    Doubtful,
}

impl Outcome {
    /// What findings mean for the shell: with `strict`, one that needs a decision is not simply done.
    pub(crate) fn of(strict: bool, findings: &[proofmass::uncertainty::Finding]) -> Self {
        if strict && console::needs_decision(findings) {
            Self::Doubtful
        } else {
            Self::Done
        }
    }
}

fn run(arguments: Arguments) -> Result<Outcome, Failure> {
    match arguments.command {
        Command::Calibrate(command) => command.run(),
        Command::Init(command) => command.run(),
        Command::Plan(command) => command.run(),
        Command::Apply(command) => command.run(),
        Command::Export(command) => command.run(),
        Command::Validate(command) => command.run(),
        Command::Velocity(command) => command.run(),
        Command::Noise(command) => command.run(),
        Command::Modes(command) => command.run(),
        Command::Test(command) => command.run(),
        Command::Inspect(command) => command.run(),
        Command::Simulate(command) => command.run(),
        Command::Render(command) => command.run(),
        Command::Uncertainty(command) => command.run(),
        Command::Verify(command) => command.run(),
    }
}

fn main() -> ExitCode {
    // What is being written is removed first; results in place are the old ones or the new ones. Without a handler
    // the next run would remove it.
    let _ = ctrlc::set_handler(|| {
        proofmass::io::discard_unfinished();
        console::complain("interrupted: nothing was written\n");
        std::process::exit(130);
    });
    // clap ends wrong use with exit code 2.
    match run(Arguments::parse()) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Doubtful) => ExitCode::from(3),
        Err(failure) if failure.is_broken_pipe() => ExitCode::SUCCESS,
        Err(failure) => {
            console::complain(&failure.to_string());
            ExitCode::FAILURE
        }
    }
}

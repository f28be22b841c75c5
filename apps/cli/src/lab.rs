//! `proofmass lab`: the live bench, a program of its own, for it has a server inside.

use crate::{Failure, Outcome, host};
use std::ffi::OsString;
use std::process::Command;

const PROGRAM: &str = "proofmass-lab";

/// Measure shaker runs live, on a page in the browser.
///
/// Starts the program proofmass-lab with everything that stands behind `lab`. It walks the plan of a campaign, levels the shaker,
/// records an ordinary campaign folder, and shows the result so far. `proofmass lab --simulate` tries it without hardware;
/// `proofmass-lab --help` lists its options.
#[derive(clap::Args)]
pub(crate) struct Lab {
    /// What proofmass-lab is given: a campaign folder, its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

impl Lab {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        if host::host().is_some() {
            return Err(Failure::new(
                "the live bench is a program of its own and is not started from another",
            )
            .hint("start proofmass-lab in a terminal"));
        }
        let program = crate::beside(PROGRAM);
        start(Command::new(program).args(&self.arguments))
    }
}

fn missing(why: &std::io::Error) -> Failure {
    Failure::new(format!("the program {PROGRAM} cannot be started: {why}")).hint(
        "cargo install proofmass-lab, or put it beside proofmass or on the PATH (it is built from the same source)",
    )
}

/// It takes the place of this program, so that it gets the signals of the terminal itself.
#[cfg(unix)]
fn start(command: &mut Command) -> Result<Outcome, Failure> {
    use nix::sys::signal::{SigSet, Signal};
    use std::os::unix::process::CommandExt;
    // What this program waits for on a thread of its own is blocked, and a program in its place would stay deaf to it.
    let all: SigSet = [
        Signal::SIGINT,
        Signal::SIGTERM,
        Signal::SIGHUP,
        Signal::SIGXFSZ,
    ]
    .into_iter()
    .collect();
    let _ = all.thread_unblock();
    Err(missing(&command.exec()))
}

#[cfg(not(unix))]
fn start(command: &mut Command) -> Result<Outcome, Failure> {
    let ended = command.status().map_err(|e| missing(&e))?;
    match ended.success() {
        true => Ok(Outcome::Done),
        false => Err(Failure::new(format!("{PROGRAM} ended with an error"))),
    }
}

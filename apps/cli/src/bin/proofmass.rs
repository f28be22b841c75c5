//! `proofmass`: the open accelerometer laboratory on the command line.

use std::process::ExitCode;

fn main() -> ExitCode {
    proofmass_cli::handle_panics();
    proofmass_cli::handle_interrupts();
    ExitCode::from(proofmass_cli::run(std::env::args_os()))
}

//! `proofmass test`: tests of a device, one subcommand each.

mod temperature;

use crate::{Failure, Outcome};

/// Test a device: how it answers a shock, a vibration, a step, an inclination, a temperature.
#[derive(clap::Args)]
pub(crate) struct Test {
    #[command(subcommand)]
    kind: Kind,
}

#[derive(clap::Subcommand)]
enum Kind {
    Temperature(temperature::Temperature),
}

impl Test {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match self.kind {
            Kind::Temperature(test) => test.run(),
        }
    }
}

//! `proofmass test`: tests of a device, one subcommand each.

mod static_tests;
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
    Tilt(static_tests::TiltTest),
    Sensitivity(static_tests::SensitivityTest),
    #[command(name = "zero-g")]
    ZeroG(static_tests::ZeroGTest),
    Orthogonality(static_tests::OrthogonalityTest),
    Linearity(static_tests::LinearityTest),
    Centrifuge(static_tests::CentrifugeTest),
    Stability(static_tests::StabilityTest),
}

impl Test {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        match self.kind {
            Kind::Temperature(test) => test.run(),
            Kind::Tilt(test) => test.run(),
            Kind::Sensitivity(test) => test.run(),
            Kind::ZeroG(test) => test.run(),
            Kind::Orthogonality(test) => test.run(),
            Kind::Linearity(test) => test.run(),
            Kind::Centrifuge(test) => test.run(),
            Kind::Stability(test) => test.run(),
        }
    }
}

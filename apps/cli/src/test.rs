//! `proofmass test`: tests of a device, one subcommand each.

mod channel_arguments;
mod deconvolve;
mod levels;
mod model;
mod motion;
mod response;
mod shock;
mod static_tests;
mod step;
mod temperature;

use crate::{Failure, Outcome};

/// Test a device: by gravity, temperature, vibration, shock.
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
    Mounting(static_tests::MountingTest),
    Random(Box<response::Random>),
    Impact(Box<response::Impact>),
    Sweep(Box<response::Sweep>),
    Steps(Box<response::Steps>),
    Shock(Box<shock::Shock>),
    Step(Box<step::Step>),
    Motion(Box<motion::Motion>),
    Model(Box<model::Model>),
    Levels(Box<levels::Levels>),
    Deconvolve(Box<deconvolve::Deconvolve>),
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
            Kind::Mounting(test) => test.run(),
            Kind::Random(test) => test.run(),
            Kind::Impact(test) => test.run(),
            Kind::Sweep(test) => test.run(),
            Kind::Steps(test) => test.run(),
            Kind::Shock(test) => test.run(),
            Kind::Step(test) => test.run(),
            Kind::Motion(test) => test.run(),
            Kind::Model(test) => test.run(),
            Kind::Levels(test) => test.run(),
            Kind::Deconvolve(test) => test.run(),
        }
    }
}

//! Budgets that tests share.

// Each of them uses some.
#![allow(dead_code)]

use proofmass_shaker::{Acts, Budget, Key, ShakerInput};

/// The published bench, whose reference has a phase as well, with noise of the readings.
pub fn published_bench_with_noise() -> Budget {
    let mut budget = Budget::published_bench();
    budget.inputs.push(ShakerInput::new(
        "reference.phase",
        Acts::ReferencePhase,
        0.003,
        &[Key::Frequency],
    ));
    budget.inputs.push(noise());
    budget
}

/// 24 bits over ±10 V and the noise of the chain: 50 µV on a phasor, so that an output near zero has a noise.
pub fn noise() -> ShakerInput {
    ShakerInput::new(
        "noise",
        Acts::OutputAdditive,
        5e-5,
        &[Key::Run, Key::Channel],
    )
}

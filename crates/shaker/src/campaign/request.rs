//! What a campaign consists of, and which calculations are asked for.

use crate::budget::Budget;
use crate::datasheet::Datasheet;
use crate::geometry::Configuration;
use crate::observation::{Correction, OutputPhases, UnmeasuredMotion};
use crate::published::MagnitudeBudget;
use crate::recording::{QualityLimits, RunInput};
use proofmass_dynamic::reference_table::ReferenceTable;
use serde::{Deserialize, Serialize};

/// Which calculation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(transform = with_published)
)]
#[serde(rename_all = "kebab-case")]
pub enum ShakerMethod {
    /// Magnitudes, as published; for comparison only.
    #[serde(alias = "published")]
    PublishedMagnitude,
    /// Signed phasors, frequency by frequency.
    Complex,
    /// Signed phasors of all frequencies, with the mounting angles in common.
    Joint,
}

/// The short word of the published method, which campaigns write.
#[cfg(feature = "schema")]
fn with_published(schema: &mut schemars::Schema) {
    if let Some(words) = schema.get_mut("oneOf").and_then(|w| w.as_array_mut()) {
        words.push(schemars::json_schema!({ "const": "published" }).to_value());
    }
}

/// A campaign on the shaker.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ShakerCampaign {
    /// Runs.
    pub runs: Vec<RunInput>,
    /// Certificate of the reference; `None` when the runs carry accelerations already.
    pub reference: Option<ReferenceTable>,
    /// Corrections to set side by side; empty is no correction alone.
    pub corrections: Vec<Correction>,
    /// How large the motion of the bench may be where the corrections say nothing; [`UnmeasuredMotion::ASSUMED`] when `None`.
    pub unmeasured_motion: Option<UnmeasuredMotion>,
    /// Methods to set side by side.
    pub methods: Vec<ShakerMethod>,
    /// Budget. An input that acts on the reference modulus or phase is added from the certificate when none is
    /// there.
    pub budget: Budget,
    /// Budget of the published method.
    pub magnitude_budget: MagnitudeBudget,
    /// What should have been measured at every frequency.
    pub plan: Option<Vec<Configuration>>,
    /// Target amplitudes (Hz, m/s²).
    pub targets: Vec<(f64, f64)>,
    /// Rules of a sound run.
    pub limits: QualityLimits,
    /// What the maker states, per m/s².
    pub datasheet: Option<Datasheet>,
    /// Runs that somebody decided to leave out, by name.
    pub excluded: Vec<String>,
    /// What is known of the phases of the outputs.
    pub phases: OutputPhases,
}

impl ShakerCampaign {
    /// A campaign with every choice at its default: no correction, [`ShakerMethod::Joint`] and [`ShakerMethod::Complex`].
    pub fn new(runs: Vec<RunInput>, budget: Budget) -> Self {
        Self {
            runs,
            reference: None,
            corrections: vec![],
            unmeasured_motion: None,
            methods: vec![ShakerMethod::Complex, ShakerMethod::Joint],
            budget,
            magnitude_budget: MagnitudeBudget::published(0.0035),
            plan: None,
            targets: vec![],
            limits: QualityLimits::default(),
            datasheet: None,
            excluded: vec![],
            phases: OutputPhases::Measured,
        }
    }
}

//! Which run does not belong, what probably happened to it, and what is wrong throughout.

mod causes;
mod certificate;
mod completeness;
mod conventions;
mod explanation;
mod search;
mod trial;
mod words;

use super::budget::Budget;
use super::geometry::Configuration;
use super::observation::{OutputPhases, PhasorRow, SpuriousTable};
use crate::findings;
use proofmass_core::Error;
use proofmass_uncertainty::Finding;
use serde::Serialize;

/// What would explain a run that the others contradict.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Suspicion {
    /// Outputs read in another order and sign: output j of the device was found on channel `channel[j]` with
    /// `sign[j]`.
    Channels {
        /// Channel on which each output was found.
        channel: [usize; 3],
        /// Its sign.
        sign: [i8; 3],
    },
    /// The cables of the reference and of one output were swapped.
    ReferenceSwapped {
        /// The output.
        channel: usize,
    },
    /// The device was mounted as in another configuration of the plan, or a few degrees beside one.
    Mounting {
        /// That configuration.
        configuration: Configuration,
    },
    /// The run was taken at another frequency of the campaign.
    Frequency {
        /// That frequency in Hz.
        frequency: f64,
    },
    /// The phasors of another run, digit by digit.
    Copied {
        /// Name of that run.
        run: String,
    },
    /// One output, or all of them against the reference, read with another gain.
    Gain {
        /// The output; `None` for all.
        channel: Option<usize>,
        /// Read over true.
        factor: f64,
    },
    /// Outputs cut off at one level.
    Clipped {
        /// The level in V.
        level: f64,
    },
    /// An output without any signal.
    Dead {
        /// The output.
        channel: usize,
    },
    /// The device lay on its top.
    UpsideDown,
    /// One of two, which the run does not tell apart.
    Either(Box<Suspicion>, Box<Suspicion>),
    /// None of these.
    Unexplained,
}

/// A run that all others contradict.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SuspectRun {
    /// Index of the row.
    pub row: usize,
    /// Name of the run.
    pub run: String,
    /// χ² of its departure from what the other runs predict, six degrees of freedom.
    pub statistic: f64,
    /// The same under the explanation.
    pub explained: f64,
    /// The explanation.
    pub suspicion: Suspicion,
}

pub use search::{strangest, suspects};

/// Everything that can be said about a phasor table before its result is used: runs missing, twice or copied, phases in
/// the wrong unit or sense, runs that contradict the others, channels swapped or inverted throughout, the frequency at
/// which the certificate does not fit.
///
/// `plan` is what should have been measured at every frequency; without it, all configurations that occur. The runs are
/// put on trial under the conventions that fit them best, so that a slip of the whole table does not accuse every run.
///
/// # Errors
/// As [`super::complex`].
pub fn diagnose(
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
    plan: Option<&[Configuration]>,
) -> Result<(Vec<SuspectRun>, Vec<Finding>), Error> {
    let mut findings = completeness::completeness(rows, plan);
    let unread = rows.iter().any(|r| r.phases == OutputPhases::Unread);
    if unread {
        findings.push(findings::magnitudes_only(rows.len()));
    } else if let Some(finding) = conventions::phases_not_measured(rows) {
        // Without signs every run is suspect, and nothing fits.
        findings.push(finding);
        return Ok((vec![], findings));
    }
    let free = rows.iter().any(PhasorRow::is_free);
    let unit = if free {
        None
    } else {
        conventions::phase_unit(rows, spurious, budget)?
    };
    if let Some(finding) = unit {
        // With wrong phases every run is suspect; naming them all would hide the cause.
        findings.push(finding);
        return Ok((vec![], findings));
    }
    let read = conventions::Reading::of(rows, spurious, budget)?;
    let suspects = suspects(&read.rows, &read.spurious, budget)?;
    findings.extend(words::describe(&suspects, rows));
    findings.extend(completeness::copies(rows, &suspects));
    findings.extend(completeness::doubled(rows));
    let kept: Vec<PhasorRow> = read
        .rows
        .iter()
        .enumerate()
        .filter(|(i, _)| !suspects.iter().any(|s| s.row == *i))
        .map(|(_, r)| r.clone())
        .collect();
    let fit = super::complex(&kept, &read.spurious, budget)?;
    findings.extend(read.findings(&fit));
    // It looks at phases over frequency too.
    if !free {
        findings.extend(certificate::finding(&fit, budget));
    }
    Ok((suspects, findings))
}

//! What is said of a suspect run.

use super::super::geometry::Configuration;
use super::super::matrix::AXES;
use super::super::observation::PhasorRow;
use super::{SuspectRun, Suspicion};
use crate::findings;
use proofmass_uncertainty::Finding;

pub(super) fn degrees(c: &Configuration) -> String {
    let (a, w) = (c.inclination.to_degrees(), c.rotation.to_degrees());
    format!("inclination {a:.0}°, rotation {w:.0}°")
}

/// Makes a finding from what was observed and its evidence.
type Kind = fn(&str, &str) -> Finding;

fn clipped(observation: &str, evidence: &str) -> Finding {
    proofmass_uncertainty::findings::clipped(
        observation,
        evidence,
        "amplitudes of such a run are too small",
    )
}

impl Suspicion {
    /// Kind of the finding and what the run looks like, after "run … looks as if".
    fn words(&self) -> (Kind, String) {
        match self {
            Self::Channels { channel, sign } => {
                let swapped: Vec<&str> = (0..3)
                    .filter(|&j| channel[j] != j)
                    .map(|j| AXES[j])
                    .collect();
                let inverted: Vec<&str> =
                    (0..3).filter(|&j| sign[j] < 0).map(|j| AXES[j]).collect();
                match (swapped.is_empty(), inverted.len()) {
                    (true, 3) => (
                        findings::inverted_channel,
                        "the reference were inverted".to_owned(),
                    ),
                    (true, _) => (
                        findings::inverted_channel,
                        format!("channel {} were inverted", inverted.join(" and ")),
                    ),
                    (false, 0) => (
                        findings::swapped_channels,
                        format!("the cables of {} were swapped", swapped.join(" and ")),
                    ),
                    (false, _) => (
                        findings::swapped_channels,
                        format!(
                            "the cables of {} were swapped, and {} inverted",
                            swapped.join(" and "),
                            inverted.join(" and ")
                        ),
                    ),
                }
            }
            Self::ReferenceSwapped { channel } => (
                findings::swapped_channels,
                format!(
                    "the cables of the reference and of {} were swapped",
                    AXES[*channel]
                ),
            ),
            Self::Mounting { configuration } => (
                findings::wrong_configuration,
                format!("it were mounted at {}", degrees(configuration)),
            ),
            Self::Gain { channel, factor } => (
                findings::wrong_gain,
                match channel {
                    Some(j) => format!(
                        "output {} were read with {factor:.3} times its gain",
                        AXES[*j]
                    ),
                    None => format!(
                        "all outputs were read with {factor:.3} times their gain, or the reference with {:.3}",
                        1.0 / factor
                    ),
                },
            ),
            Self::Frequency { frequency } => (
                findings::wrong_frequency,
                format!("it were taken at {frequency} Hz"),
            ),
            Self::Copied { run } => (
                findings::copied_run,
                format!("its phasors were copied from run {run}"),
            ),
            Self::Clipped { level } => {
                (clipped, format!("its outputs were cut off at {level:.4} V"))
            }
            Self::Dead { channel } => (
                findings::dead_channel,
                format!("output {} carried no signal", AXES[*channel]),
            ),
            Self::UpsideDown => (
                findings::wrong_configuration,
                "the device lay upside down".to_owned(),
            ),
            Self::Either(a, b) => {
                let ((kind, a), (_, b)) = (a.words(), b.words());
                (kind, format!("{a}, or {b}"))
            }
            Self::Unexplained => (findings::outlier_configuration, String::new()),
        }
    }
}

/// Runs with the same cause in more than this number are told once.
const MANY: usize = 3;

/// One finding for each suspect, or for all that look alike when there are many of them.
pub(super) fn describe(suspects: &[SuspectRun], rows: &[PhasorRow]) -> Vec<Finding> {
    let mut groups: Vec<(&Suspicion, Vec<&SuspectRun>)> = vec![];
    for suspect in suspects {
        let alike = groups.iter_mut().find(|(s, _)| **s == suspect.suspicion);
        match alike {
            Some((_, runs)) => runs.push(suspect),
            None => groups.push((&suspect.suspicion, vec![suspect])),
        }
    }
    let mut found = vec![];
    for (suspicion, runs) in groups {
        if runs.len() <= MANY {
            found.extend(runs.iter().map(|s| one(s, &rows[s.row])));
            continue;
        }
        let (kind, words) = suspicion.words();
        let names: Vec<&str> = runs.iter().map(|s| s.run.as_str()).collect();
        let what = match suspicion {
            Suspicion::Unexplained => {
                format!(
                    "{} runs contradict all others of their frequency",
                    runs.len()
                )
            }
            _ => format!("{} runs look as if {words}", runs.len()),
        };
        let least = runs.iter().map(|s| s.statistic).fold(f64::MAX, f64::min);
        found.push(
            kind(
                &what,
                &format!(
                    "run {}: χ² = {least:.0} at least against the other runs with {} degrees of freedom each",
                    names.join(", "),
                    rows[runs[0].row].reals()
                ),
            ),
        );
    }
    found
}

fn one(s: &SuspectRun, row: &PhasorRow) -> Finding {
    let place = format!("{}, {} Hz", degrees(&row.configuration), row.frequency);
    let (kind, words) = s.suspicion.words();
    let (statistic, dof) = (s.statistic, row.reals());
    let against = format!(
        "{place}: χ² = {statistic:.0} against the other runs with {dof} degrees of freedom"
    );
    if s.suspicion == Suspicion::Unexplained {
        return kind(
            &format!("run {} contradicts all other runs of its frequency", s.run),
            &format!("{against}; no single cause explains it"),
        );
    }
    kind(
        &format!("run {} looks as if {words}", s.run),
        &format!(
            "{against}; {:.0} under this explanation{}",
            s.explained,
            corrected(&s.suspicion, row)
        ),
    )
}

/// What the run says when it is read as the cause would have it, where that is more than another name.
fn corrected(suspicion: &Suspicion, row: &PhasorRow) -> String {
    let Suspicion::ReferenceSwapped { channel } = suspicion else {
        return String::new();
    };
    let Some(read) = row.with_reference_on(*channel) else {
        return String::new();
    };
    let outputs: Vec<String> = AXES
        .iter()
        .zip(&read.outputs)
        .map(|(axis, o)| format!("{axis} {:.4} mV", 1e3 * o.norm()))
        .collect();
    format!(
        ", with which the table moves by {:.4} m/s² and the outputs are {}",
        read.reference.norm(),
        outputs.join(", ")
    )
}

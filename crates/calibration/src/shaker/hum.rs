//! Drives that cannot be told from the mains.

use super::recording::{CHANNELS, RunInput};
use proofmass_uncertainty::{Finding, Severity};

/// Frequencies of mains networks, Hz.
const MAINS: [f64; 2] = [50.0, 60.0];
/// Departure of a network from its frequency, relative.
const WANDERS: f64 = 2e-3;
/// Harmonics of the mains that are heard.
const HEARD: usize = 20;

/// The mains frequency whose harmonic is within a resolution and a half of a frequency.
fn within(frequency: f64, resolution: f64, mains: f64) -> bool {
    (1..=HEARD).any(|k| {
        let line = k as f64 * mains;
        (frequency - line).abs() < 1.5 * resolution + WANDERS * line
    })
}

/// Hum that was found beside other drives is in every run, also in those whose drive lies on a harmonic of the mains and
/// hides it: there a phasor is off by the hum in a direction that nobody knows, and each of its parts gets u = A/√2.
///
/// Returns the largest amplitude of the hum in each channel and what there is to say.
pub(super) fn hidden(runs: &[RunInput]) -> (Vec<(String, [f64; 4])>, Vec<Finding>) {
    // Which network it is, and how loud it is in each channel, the runs beside a line tell.
    let mut heard = [[0.0f64; 4]; 2];
    for tone in runs.iter().flat_map(|r| &r.quality.tones) {
        for (k, mains) in MAINS.into_iter().enumerate() {
            if within(tone.frequency, 0.0, mains) && tone.amplitudes.len() == 4 {
                for (most, a) in heard[k].iter_mut().zip(&tone.amplitudes) {
                    *most = most.max(*a);
                }
            }
        }
    }
    let (mut affected, mut findings) = (vec![], vec![]);
    for (mains, loud) in MAINS.into_iter().zip(heard) {
        let runs: Vec<&RunInput> = runs
            .iter()
            .filter(|r| {
                let resolution = r.quality.resolution;
                resolution.is_some_and(|resolution| within(r.frequency, resolution, mains))
            })
            .collect();
        let Some(first) = runs.first() else { continue };
        if loud == [0.0; 4] {
            continue;
        }
        let mut frequencies: Vec<f64> = runs.iter().map(|r| r.frequency).collect();
        frequencies.sort_by(f64::total_cmp);
        frequencies.dedup();
        let names: Vec<String> = frequencies.iter().map(|f| format!("{f} Hz")).collect();
        let parts: Vec<String> = CHANNELS
            .iter()
            .zip(loud)
            .map(|(channel, a)| format!("{channel} {:.1e} V", a / 2f64.sqrt()))
            .collect();
        findings.push(
            Finding::new(
                Severity::Warning,
                "drive-at-mains",
                format!(
                    "the drive at {} cannot be told from a harmonic of the mains at {mains} Hz",
                    names.join(", ")
                ),
            )
            .evidence(format!(
                "{} runs from {} on; hum beside other drives gives each part of their phasors u: {}",
                runs.len(),
                first.run,
                parts.join(", ")
            ))
            .advice("take a frequency beside the harmonic, or a record long enough to part them"),
        );
        affected.extend(runs.iter().map(|r| (r.run.clone(), loud)));
    }
    (affected, findings)
}

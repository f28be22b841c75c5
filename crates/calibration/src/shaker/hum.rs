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
/// Where no run hears any hum, a drive on a harmonic is noted: nothing can tell whether it has some.
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
    if heard == [[0.0; 4]; 2] {
        findings.extend(unheard(runs));
    }
    (affected, findings)
}

/// Drives on a harmonic of the mains, of 50 Hz or 60 Hz, while no run tells whether there is hum.
fn unheard(runs: &[RunInput]) -> Option<Finding> {
    let on_a_line = |r: &&RunInput| {
        r.quality.resolution.is_some_and(|resolution| {
            MAINS
                .iter()
                .any(|mains| within(r.frequency, resolution, *mains))
        })
    };
    let strongest = |r: &RunInput| r.outputs.iter().map(|o| o.norm()).fold(0.0, f64::max);
    let hidden: Vec<&RunInput> = runs.iter().filter(on_a_line).collect();
    let weakest = hidden
        .iter()
        .min_by(|a, b| strongest(a).total_cmp(&strongest(b)))?;
    let mut frequencies: Vec<f64> = hidden.iter().map(|r| r.frequency).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    let names: Vec<String> = frequencies.iter().map(|f| format!("{f} Hz")).collect();
    let amplitude = strongest(weakest);
    let size = if amplitude > 0.0 {
        format!(
            ", in run {} by {:.2} % for each millivolt in the strongest output",
            weakest.run,
            0.1 / amplitude
        )
    } else {
        String::new()
    };
    Some(
        Finding::new(
            Severity::Note,
            "drive-at-mains",
            format!(
                "hum of the mains could not be seen at {}, a harmonic of 50 Hz or 60 Hz",
                names.join(", ")
            ),
        )
        .evidence(format!(
            "{} runs; hum of amplitude h would change a ratio by h over the amplitude of the channel{size}",
            hidden.len()
        ))
        .advice("move the drive by a few resolutions, or record once with the drive off"),
    )
}

#[cfg(test)]
mod tests {
    use super::super::geometry::Configuration;
    use super::super::recording::{Quality, RunInput};
    use super::hidden;
    use num_complex::Complex64;
    use proofmass_uncertainty::Severity;

    fn run(frequency: f64, resolution: Option<f64>) -> RunInput {
        RunInput {
            run: "r1".to_owned(),
            frequency,
            configuration: Configuration::degrees(0.0, 0.0),
            reference: Complex64::new(0.1, 0.0),
            outputs: [0.001, 0.002, 0.1].map(|a| Complex64::new(a, 0.0)),
            covariance: [[0.0; 3]; 4],
            quality: Quality {
                resolution,
                ..Quality::default()
            },
        }
    }

    #[test]
    fn law_a_drive_on_a_harmonic_is_noted_where_no_run_hears_the_mains() {
        let (affected, findings) = hidden(&[run(180.0, Some(1.0))]);
        assert!(affected.is_empty() && findings.len() == 1);
        assert_eq!(findings[0].severity(), Severity::Note);
        assert!(findings[0].what().contains("180 Hz"));
        // A millivolt on a tenth of a volt.
        assert!(findings[0].evidence_text().contains("by 1.00 % for each"));
        for silent in [run(163.0, Some(1.0)), run(180.0, None)] {
            assert!(hidden(&[silent]).1.is_empty());
        }
    }
}

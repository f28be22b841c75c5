//! Drives that cannot be told from the mains.

use super::recording::{CHANNELS, RunInput};
use crate::findings;
use crate::observation::ascending;
use proofmass_uncertainty::{Finding, Severity};

/// Frequencies of mains networks, Hz.
pub(super) const MAINS: [f64; 2] = [50.0, 60.0];
/// Departure of a network from its frequency, relative.
pub(super) const WANDERS: f64 = 2e-3;
/// Harmonics of the mains that are heard.
pub(super) const HEARD: usize = 20;

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
/// How loud it is at a line, records of other drives tell that listened to that very line; where none did, the loudest line
/// that was heard at all stands for it. Where no run hears any hum and none could hear that line, a drive on a harmonic is
/// noted: nothing can tell whether it has some.
///
/// Returns the largest amplitude of the hum in each channel and what there is to say.
pub(super) fn hidden(runs: &[RunInput]) -> (Vec<(String, [f64; 4])>, Vec<Finding>) {
    // Which network it is, and how loud it is in each channel, the runs beside a line tell.
    let mut heard = [[0.0f64; 4]; 2];
    let tones = |r: &'_ RunInput| {
        r.quality
            .tones
            .iter()
            .chain(&r.quality.mains)
            .cloned()
            .collect::<Vec<_>>()
    };
    for tone in runs.iter().flat_map(tones) {
        for (k, mains) in MAINS.into_iter().enumerate() {
            if within(tone.frequency, 0.0, mains) && tone.amplitudes.len() == 4 {
                for (most, a) in heard[k].iter_mut().zip(&tone.amplitudes) {
                    *most = most.max(*a);
                }
            }
        }
    }
    let all = runs;
    let (mut affected, mut found) = (vec![], vec![]);
    for (mains, loud) in MAINS.into_iter().zip(heard) {
        let runs: Vec<&RunInput> = runs
            .iter()
            .filter(|r| {
                let resolution = r.quality.resolution;
                resolution.is_some_and(|resolution| within(r.frequency, resolution, mains))
            })
            .collect();
        if loud == [0.0; 4] {
            continue;
        }
        // At its own line where that was listened to; silence there leaves nothing to say.
        let amplitude = |r: &RunInput| listened(all, r.frequency).unwrap_or(loud);
        let runs: Vec<(&RunInput, [f64; 4])> = runs
            .into_iter()
            .map(|r| (r, amplitude(r)))
            .filter(|(_, a)| *a != [0.0; 4])
            .collect();
        let Some((first, _)) = runs.first() else {
            continue;
        };
        let mut most = [0.0f64; 4];
        for (_, a) in &runs {
            for (m, a) in most.iter_mut().zip(a) {
                *m = m.max(*a);
            }
        }
        let frequencies = ascending(runs.iter().map(|(r, _)| r.frequency));
        let names: Vec<String> = frequencies.iter().map(|f| format!("{f} Hz")).collect();
        let parts: Vec<String> = CHANNELS
            .iter()
            .zip(most)
            .map(|(channel, a)| format!("{channel} {:.1e} V", a / 2f64.sqrt()))
            .collect();
        found.push(
            findings::drive_at_mains(
                &names.join(", "),
                &format!("{mains} Hz"),
                &format!(
                    "{} runs from {} on; interference beside other drives gives each part of their phasors u: {}",
                    runs.len(),
                    first.run,
                    parts.join(", ")
                ),
            ),
        );
        affected.extend(runs.iter().map(|(r, a)| (r.run.clone(), *a)));
    }
    if heard == [[0.0; 4]; 2] {
        found.extend(unheard(runs));
    }
    (affected, found)
}

/// Largest amplitude in each channel that was heard at the line of the mains on which a drive lies, in records of other
/// drives; `None` where none listened to it.
fn listened(runs: &[RunInput], drive: f64) -> Option<[f64; 4]> {
    let mut most: Option<[f64; 4]> = None;
    for tone in runs.iter().flat_map(|r| &r.quality.mains) {
        // A line is a multiple of 50 Hz or 60 Hz, 10 Hz from the next.
        if (tone.frequency - drive).abs() < 2.0 + WANDERS * drive && tone.amplitudes.len() == 4 {
            let most = most.get_or_insert([0.0; 4]);
            for (m, a) in most.iter_mut().zip(&tone.amplitudes) {
                *m = m.max(*a);
            }
        }
    }
    most
}

/// Drives on a harmonic of the mains, of 50 Hz or 60 Hz, while no run tells whether there is hum.
fn unheard(runs: &[RunInput]) -> Option<Finding> {
    let on_a_line = |r: &&RunInput| {
        let near = r.quality.resolution.is_some_and(|resolution| {
            MAINS
                .iter()
                .any(|mains| within(r.frequency, resolution, *mains))
        });
        near && listened(runs, r.frequency).is_none()
    };
    let strongest = |r: &RunInput| r.outputs.iter().map(|o| o.norm()).fold(0.0, f64::max);
    let hidden: Vec<&RunInput> = runs.iter().filter(on_a_line).collect();
    let weakest = hidden
        .iter()
        .min_by(|a, b| strongest(a).total_cmp(&strongest(b)))?;
    let frequencies = ascending(hidden.iter().map(|r| r.frequency));
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
        findings::drive_at_mains(
            &names.join(", "),
            "50 Hz or 60 Hz",
            &format!(
                "{} runs, and interference could not be seen there; of amplitude h it would change a ratio by h over the \
                 amplitude of the channel{size}",
                hidden.len()
            ),
        )
        .at(Severity::Note),
    )
}

#[cfg(test)]
mod tests {
    use super::super::geometry::Configuration;
    use super::super::recording::{Quality, RecordedTone, RunInput};
    use super::hidden;
    use num_complex::Complex64;
    use proofmass_uncertainty::Severity;

    fn run(frequency: f64, resolution: Option<f64>) -> RunInput {
        RunInput {
            run: "r1".to_owned(),
            session: None,
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

    /// A run that listened to lines far from its drive: their frequency and amplitude in x.
    fn listening(frequency: f64, lines: &[(f64, f64)]) -> RunInput {
        let mut run = run(frequency, Some(1.0));
        let line = |(frequency, a): &(f64, f64)| RecordedTone {
            frequency: *frequency,
            amplitudes: vec![0.0, *a, 0.0, 0.0],
        };
        run.quality.mains = lines.iter().map(line).collect();
        run
    }

    #[test]
    fn law_hum_heard_far_from_the_drive_counts_where_it_is_hidden() {
        // Heard at 180 Hz beside a drive at 160 Hz: the drive at 180 Hz has it, as large as it was there and not as 60 Hz was.
        let beside = listening(160.0, &[(60.0, 1e-3), (120.0, 0.0), (180.0, 2e-5)]);
        let (affected, findings) = hidden(&[run(180.0, Some(1.0)), beside.clone()]);
        assert_eq!(affected, [("r1".to_owned(), [0.0, 2e-5, 0.0, 0.0])]);
        assert_eq!(findings[0].severity(), Severity::Warning);
        // Listened to and silent: nothing to say, though there is hum at 60 Hz.
        let (affected, findings) = hidden(&[run(120.0, Some(1.0)), beside]);
        assert!(affected.is_empty() && findings.is_empty());
        // Nobody listened to that line, but the same record hears 60 Hz: the loudest stands for it.
        let own = listening(180.0, &[(60.0, 1e-4), (120.0, 3e-5)]);
        let (affected, _) = hidden(&[own]);
        assert_eq!(affected[0].1, [0.0, 1e-4, 0.0, 0.0]);
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

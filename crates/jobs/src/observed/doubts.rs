//! What is doubtful about recordings, told with the runs they belong to.

use super::ObservedRun;
use crate::campaign::{RunTable, ShakerRun};
use crate::findings;
use proofmass_io::Input;
use proofmass_shaker::recording::{Line, UnevenStamps};
use proofmass_uncertainty::{Finding, Severity};

/// Findings of a reader, with the name of the run.
pub(super) fn named(run: &str, findings: &[Finding]) -> Vec<Finding> {
    let of = |f: &Finding| f.clone().of_part(format_args!("run {run}"));
    findings.iter().map(of).collect()
}

/// Why a run is not used; nothing of a line that was found.
pub(super) fn unusable<S>(run: &ShakerRun<S>, line: &Line, input: &Input) -> Option<Finding> {
    let (name, frequency, file) = (&run.run, run.frequency_hz, &input.path);
    match line {
        Line::Unresolved(other) => Some(findings::tones_unresolved(
            name,
            frequency,
            &other.to_string(),
            file,
        )),
        Line::Missing(why) => Some(findings::tone_missing(
            name,
            frequency,
            &why.to_string(),
            file,
        )),
        Line::Found(_) => None,
    }
}

/// Time stamps that are not even, told once each way.
pub(super) fn uneven(stamps: &[(String, UnevenStamps)]) -> Vec<Finding> {
    let mut findings = vec![];
    for used in [true, false] {
        let list: Vec<&(String, UnevenStamps)> =
            stamps.iter().filter(|s| s.1.used == used).collect();
        let largest = list.iter().max_by(|a, b| a.1.effect.total_cmp(&b.1.effect));
        let Some((run, worst)) = largest else {
            continue;
        };
        let evidence = format!(
            "{} of the recordings; in that of run {run} the stamps scatter by {:.2e} s about an even grid, which moves a phasor \
             by {:.1} u; residuals {:.3e} at the stamps and {:.3e} on the grid",
            list.len(),
            worst.scatter,
            worst.effect,
            worst.residuals[0],
            worst.residuals[1]
        );
        findings.push(if used {
            proofmass_uncertainty::findings::uneven_stamps(
                "the sine was fitted at the stamps",
                &evidence,
                "nothing is to be done when the stamps are those of the samples",
            )
        } else {
            proofmass_uncertainty::findings::uneven_stamps(
                "the samples were taken at even steps all the same, and the sine was fitted on the even grid",
                &evidence,
                "the time stamps are those of reading the samples: a shared clock is known only as well as they scatter",
            )
            .at(Severity::Warning)
        });
    }
    findings
}

/// A recording that ended early still gives a phasor; it is named.
pub(super) fn durations<S>(table: &RunTable<S>, runs: &[ObservedRun]) -> Vec<Finding> {
    let mut all: Vec<f64> = runs
        .iter()
        .filter_map(|r| r.recorded.as_ref().map(|r| r.duration))
        .collect();
    all.sort_by(f64::total_cmp);
    let Some(&median) = all.get(all.len() / 2) else {
        return Vec::new();
    };
    table
        .runs
        .iter()
        .zip(runs)
        .filter_map(|(run, seen)| {
            let recorded = seen.recorded.as_ref()?;
            (recorded.duration < 0.9 * median).then(|| {
                findings::short_recording(
                    &run.run,
                    recorded.duration,
                    recorded.rate,
                    &recorded.path,
                    median,
                )
            })
        })
        .collect()
}

//! What is doubtful about recordings, told with the runs they belong to.

use super::ObservedRun;
use crate::campaign::{RunTable, ShakerRun};
use proofmass_io::Input;
use proofmass_shaker::recording::{Line, UnevenStamps};
use proofmass_uncertainty::{Finding, Severity};

/// Findings of a reader, with the name of the run.
pub(super) fn named(run: &str, findings: &[Finding]) -> Vec<Finding> {
    let of = |finding: &Finding| {
        Finding::new(
            finding.severity(),
            finding.code(),
            format!("run {run}: {}", finding.what()),
        )
        .evidence(finding.evidence_text())
        .advice(finding.advice_text())
    };
    findings.iter().map(of).collect()
}

/// Why a run is not used.
pub(super) fn unusable<S>(run: &ShakerRun<S>, line: &Line, input: &Input) -> Finding {
    let (code, what, evidence, advice) = match line {
        Line::Unresolved(other) => (
            "tones-unresolved",
            format!(
                "run {} was left out: the record does not tell its tone from another",
                run.run
            ),
            format!("{} Hz and {other} Hz in {}", run.frequency_hz, input.path),
            "record for longer than two periods of their difference, or drive one of the two at a time",
        ),
        Line::Missing(why) => (
            "tone-missing",
            format!(
                "run {} was left out: its recording has no {} Hz",
                run.run, run.frequency_hz
            ),
            format!("{why}; {}", input.path),
            "check the list of frequencies against the generator; measure the run again, or take the frequency out",
        ),
        Line::Found(_) => ("tone", String::new(), String::new(), ""),
    };
    Finding::new(Severity::Decision, code, what)
        .evidence(evidence)
        .advice(advice)
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
            Finding::new(
                Severity::Note,
                "uneven-stamps",
                "samples were not taken at even steps; the sine was fitted at their time stamps",
            )
            .evidence(evidence)
            .advice("nothing is to be done when the stamps are those of the samples")
        } else {
            Finding::new(
                Severity::Warning,
                "late-stamps",
                "samples were taken at even steps, whatever their time stamps say; the sine was fitted on the even grid",
            )
            .evidence(evidence)
            .advice("the stamps are those of reading the samples: a clock that is shared is known no better than they scatter")
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
                Finding::new(
                    Severity::Warning,
                    "short-recording",
                    format!("the recording of run {} is shorter than the others", run.run),
                )
                .evidence(format!(
                    "{:.4} s at {} Hz in {}, {median:.4} s in the middle of all runs",
                    recorded.duration, recorded.rate, recorded.path
                ))
                .advice("it may have been cut short; its phasors were used with the uncertainty they have")
            })
        })
        .collect()
}

//! What is to be doubted about the times of a recording, with what it amounts to.

use crate::clock::{Clock, Gap, Wrap};
use crate::findings;
use proofmass_uncertainty::Finding;

/// Code of the finding about a counter that began again.
pub(crate) const WRAPPED: &str = "clock-wrapped";

/// Share of a sampling step from which on the resolution of the stamps is told.
const COARSE: f64 = 0.1;

/// What is to be doubted about times that went by and are the clock of a filter; where samples are missing says who counted them.
pub fn doubtful_times(clock: &proofmass_signal::clock::Clock) -> Vec<Finding> {
    of(&(*clock).into(), &[], &[], false)
}

/// Findings about a clock; `on_the_line` tells that its stamps were replaced by those of its line.
pub(crate) fn of(clock: &Clock, wraps: &[Wrap], gaps: &[Gap], on_the_line: bool) -> Vec<Finding> {
    let period = 1.0 / clock.rate_hz;
    let line = if on_the_line {
        "the times of the samples are those of the straight line through the stamps"
    } else {
        "the rate is that of the straight line through the stamps; single steps say little"
    };
    let mut findings = Vec::new();
    if let Some(first) = wraps.first() {
        findings.push(findings::clock_wrapped(
            clock.wraps,
            first.turn_s,
            first.line,
        ));
    }
    if let Some(change) = clock.change {
        findings.push(findings::rate_changes(
            change.before_hz,
            change.after_hz,
            change.row,
        ));
    }
    let varies = clock
        .jitter_s
        .is_some_and(|j| j > 1e-3 * clock.resolution_s);
    if clock.bursts {
        findings.push(findings::stamps_in_bursts(
            clock.scatter_s,
            period,
            &rate(clock),
            line,
        ));
    } else if clock.resolution_s > COARSE * period && varies {
        findings.push(findings::stamps_coarse(
            &short(clock.resolution_s),
            100.0 * clock.resolution_s / period,
            &rate(clock),
            line,
        ));
    }
    if clock.untested {
        findings.push(findings::rate_untested(
            100.0 * clock.rate_u_hz / clock.rate_hz,
            &rate(clock),
        ));
    }
    if clock.gaps == 0 && clock.missing > 0 {
        findings.push(findings::rows_missing_somewhere(
            clock.missing,
            100.0 * clock.missing as f64 / (clock.steps + clock.missing) as f64,
            &rate(clock),
        ));
    }
    findings.extend(missing(gaps, clock.missing));
    findings
}

/// The rate with its standard uncertainty.
fn rate(clock: &Clock) -> String {
    format!("{:.6} Hz, u = {:.1e} Hz", clock.rate_hz, clock.rate_u_hz)
}

/// A power of ten as such, everything else with three digits.
fn short(v: f64) -> String {
    let text = format!("{v:e}");
    if text.len() <= 6 {
        text
    } else {
        format!("{v:.2e}")
    }
}

fn missing(gaps: &[Gap], missing: u64) -> Option<Finding> {
    let longest = gaps.iter().max_by(|a, b| a.step_s.total_cmp(&b.step_s))?;
    // An hour and a sample.
    if gaps.len() == 1 && (longest.step_s - 3600.0).abs() < 5.0 {
        return Some(findings::clock_put_forward(
            longest.step_s,
            longest.at_s,
            longest.line,
        ));
    }
    Some(proofmass_uncertainty::findings::gaps_in_record(
        "",
        &format!(
            "{} gaps, about {missing} samples; the longest is {:.4} s after {:.4} s (line {})",
            gaps.len(),
            longest.step_s,
            longest.at_s,
            longest.line
        ),
        "a standstill that contains a gap counts fewer samples than it seems to",
    ))
}

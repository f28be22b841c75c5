//! What is to be doubted about the times of a recording, with what it amounts to.

use crate::clock::{Clock, Gap, Wrap};
use proofmass_uncertainty::{Finding, Severity};

/// Code of the finding about a counter that began again.
pub(crate) const WRAPPED: &str = "clock-wrapped";

/// Share of a sampling step from which on the resolution of the stamps is told.
const COARSE: f64 = 0.1;

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
        findings.push(
            Finding::new(
                Severity::Note,
                WRAPPED,
                "the counter behind the time stamps began again and was continued",
            )
            .evidence(format!(
                "{} times, one turn is {:.6} s, first in line {}",
                clock.wraps, first.turn_s, first.line
            ))
            .advice("nothing, unless two recordings were joined there"),
        );
    }
    let varies = clock
        .jitter_s
        .is_some_and(|j| j > 1e-3 * clock.resolution_s);
    if clock.bursts {
        findings.push(
            Finding::new(
                Severity::Warning,
                "stamps-in-bursts",
                "the time stamps come in bursts: they tell when samples were handed over, not when they were taken",
            )
            .evidence(format!(
                "stamps scatter by {:.3e} s about equal steps of {period:.3e} s; rate {}",
                clock.scatter_s,
                rate(clock)
            ))
            .advice(format!("{line}; take the stamps at the sensor for anything finer")),
        );
    } else if clock.resolution_s > COARSE * period && varies {
        findings.push(
            Finding::new(
                Severity::Note,
                "stamps-coarse",
                "the time stamps are rounded to a large part of a sampling step",
            )
            .evidence(format!(
                "resolution {} s, {:.0} % of a step; rate {}",
                short(clock.resolution_s),
                100.0 * clock.resolution_s / period,
                rate(clock)
            ))
            .advice(format!("{line}; export the time with more digits")),
        );
    }
    findings.extend(missing(gaps, clock.rate_hz));
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

fn missing(gaps: &[Gap], rate_hz: f64) -> Option<Finding> {
    let longest = gaps.iter().max_by(|a, b| a.step_s.total_cmp(&b.step_s))?;
    let missing: f64 = gaps
        .iter()
        .map(|g| (g.step_s * rate_hz).round() - 1.0)
        .sum();
    Some(
        Finding::new(
            Severity::Warning,
            "time-gaps",
            "samples are missing in the recording",
        )
        .evidence(format!(
            "{} gaps, about {missing:.0} samples; the longest is {:.4} s after {:.4} s (line {})",
            gaps.len(),
            longest.step_s,
            longest.at_s,
            longest.line
        ))
        .advice("check the transport of the data, and the clock for a leap; a standstill that contains a gap counts fewer samples than it seems to"),
    )
}

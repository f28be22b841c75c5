//! What the ends of the record of a sweep leave unknown.

#[cfg(test)]
mod tests;

use proofmass_dynamic::findings::{record_ends_early, record_starts_late};
use proofmass_dynamic::measured::SweepEnd;
use proofmass_report::number::plain;
use proofmass_signal::transfer::ResponseEstimate;
use proofmass_uncertainty::{Finding, Severity};

/// A record that ends before the response has decayed, and lines near its beginning and end that are not told from their transients.
pub(super) fn ends(
    [input, output]: [&[f64]; 2],
    rate: f64,
    band: [f64; 2],
    response: &ResponseEstimate,
    findings: &mut Vec<Finding>,
) {
    let (Some(low), Some(high)) = (response.frequency.first(), response.frequency.last()) else {
        return;
    };
    let Some(end) = SweepEnd::of(input, output, rate) else {
        return;
    };
    // Neighbouring lines are a few per cent apart.
    let lost = [*low > 1.1 * band[0], *high < band[1] / 1.1];
    let rises = end.frequency[1] > end.frequency[0];
    let [at_begin, at_end] = if rises { lost } else { [lost[1], lost[0]] };
    let stated = format!(
        "lines are stated from {} Hz to {} Hz, the sweep is recognised from {} Hz to {} Hz",
        plain(*low),
        plain(*high),
        plain(end.frequency[0]),
        plain(end.frequency[1])
    );
    if end.is_cut() {
        let swings = if end.level[0] > 0.1 {
            format!("the input still drives at {:.0} %", 100.0 * end.level[0])
        } else {
            format!("the output still swings at {:.0} %", 100.0 * end.level[1])
        };
        let evidence = match at_end {
            true => format!("{swings} of its level when the record ends; {stated}"),
            false => format!("{swings} of its level when the record ends"),
        };
        findings.push(
            record_ends_early(
                "the response to the sweep has decayed",
                &evidence,
                "the response to what was swept last can hardly be separated from the transient of the end; a tenth of the sweep's duration is enough",
            )
            .at(if at_end { Severity::Warning } else { Severity::Note }),
        );
    }
    if at_begin {
        findings.push(
            record_starts_late(
                "what was swept first cannot be separated from what was before",
                &stated,
            )
            .at(Severity::Note),
        );
    }
}

//! Blows of a hammer in recordings.

use super::ResponseData;
use crate::findings;
use crate::plural::count;
use crate::trouble::{Result, Trouble};
use proofmass_dynamic::blows::{BlowFault, Blows};
use proofmass_report::scientific;
use proofmass_uncertainty::{Finding, Severity};

/// Stretches of input and output, one for each blow, and their common length.
pub(super) struct Hits<'a> {
    pub(super) pieces: Vec<(&'a [f64], &'a [f64])>,
    pub(super) length: usize,
}

/// Finds the blows, leaves out doubled and unfinished ones, and says so.
pub(super) fn find<'a>(
    data: &ResponseData<'a>,
    wanted: Option<usize>,
    findings: &mut Vec<Finding>,
) -> Result<Hits<'a>> {
    if data
        .recordings
        .iter()
        .any(|[x, y]| x.data.len() != y.data.len())
    {
        return Err(Trouble::data("input and output have different lengths").detail(data.name));
    }
    let recordings: Vec<_> = data
        .recordings
        .iter()
        .map(|[x, y]| (x.data, y.data))
        .collect();
    let blows = Blows::find(&recordings).map_err(|e| {
        let name = data.recordings[e.recording][0].name;
        Trouble::data(format!("{name} holds no impact"))
            .detail(data.name)
            .detail(format!(
                "greatest {}, median {}",
                scientific(e.greatest, 4),
                scientific(e.noise, 4)
            ))
            .with_hint("the force comes first: check --input and --output-column")
    })?;
    let why = |fault| match fault {
        BlowFault::Short => "cut off or followed too soon by the next",
        BlowFault::Doubled => "doubled",
    };
    let dropped: Vec<String> = blows
        .dropped
        .iter()
        .map(|b| {
            let at = b.at as f64 / data.rate;
            format!("impact {} at {at:.4} s: {}", b.number, why(b.why))
        })
        .collect();
    let pieces = &blows.pieces;
    if !dropped.is_empty() {
        findings.push(findings::blows_left_out(
            dropped.len(),
            dropped.len() + pieces.len(),
            &dropped.join("; "),
        ));
    }
    if pieces.len() < 2 {
        return Err(Trouble::data(format!(
            "{}: two or more are needed",
            count(pieces.len(), "usable impact")
        ))
        .detail(data.name)
        .detail(dropped.join("; "))
        .with_hint("give several recordings, or one with several impacts"));
    }
    let length = blows.length(wanted);
    let undecayed = blows.undecayed(length);
    if undecayed > 0 {
        findings.push(
            proofmass_dynamic::findings::record_ends_early(
                "responses have decayed",
                &format!(
                    "{undecayed} of {} end above 5 % of their greatest value",
                    pieces.len()
                ),
                "what is cut off after an impact leaks into all lines",
            )
            .at(Severity::Warning),
        );
    }
    Ok(Hits {
        pieces: blows.pieces,
        length,
    })
}

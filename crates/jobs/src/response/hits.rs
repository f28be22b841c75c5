//! Blows of a hammer in recordings.

use super::ResponseData;
use crate::trouble::{Result, Trouble};
use proofmass_uncertainty::{Finding, Severity};

/// Stretches of input and output, one for each blow, and their common length.
pub(super) struct Hits<'a> {
    pub(super) pieces: Vec<(&'a [f64], &'a [f64])>,
    pub(super) length: usize,
}

/// Share of the greatest force from which on a blow is one.
const LEVEL: f64 = 0.2;

/// Finds the blows, leaves out doubled and unfinished ones, and says so.
pub(super) fn find<'a>(
    data: &ResponseData<'a>,
    wanted: Option<usize>,
    findings: &mut Vec<Finding>,
) -> Result<Hits<'a>> {
    let mut candidates: Vec<(&'a [f64], &'a [f64], usize)> = Vec::new();
    let mut strengths: Vec<f64> = Vec::new();
    for [x, y] in &data.recordings {
        if x.data.len() != y.data.len() {
            return Err(Trouble::data("input and output have different lengths").detail(data.name));
        }
        let greatest = x.data.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        // A pause of a hundredth of the record parts two blows; what comes sooner is one that bounced.
        let pause = (x.data.len() / 100).max(32);
        let mut starts: Vec<usize> = Vec::new();
        let mut last: Option<usize> = None;
        for (k, v) in x.data.iter().enumerate() {
            if v.abs() >= LEVEL * greatest && greatest > 0.0 {
                if last.is_none_or(|l| k - l > pause) {
                    starts.push(k);
                }
                last = Some(k);
            }
        }
        let noise = {
            let mut sorted: Vec<f64> = x.data.iter().map(|v| v.abs()).collect();
            let middle = sorted.len() / 2;
            *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
        };
        if greatest < 20.0 * noise {
            return Err(Trouble::data(format!("{} holds no blow", x.name))
                .detail(data.name)
                .detail(format!("greatest {greatest:.4e}, median {noise:.4e}"))
                .with_hint("the force comes first: check --input and --output-column"));
        }
        // As far before each blow as the first one has.
        let lead = starts.first().copied().unwrap_or(0).min(pause / 2);
        for (i, s) in starts.iter().enumerate() {
            let from = s - lead.min(*s);
            let to = starts.get(i + 1).map_or(x.data.len(), |n| n - lead);
            candidates.push((&x.data[from..to], &y.data[from..to], *s));
            let top = x.data[*s..to].iter().fold(0.0f64, |m, v| m.max(v.abs()));
            strengths.push(top);
        }
    }
    let mut lengths: Vec<usize> = candidates.iter().map(|c| c.0.len()).collect();
    lengths.sort_unstable();
    let median = lengths.get(lengths.len() / 2).copied().unwrap_or(0);
    let mut pieces = Vec::new();
    let mut dropped = Vec::new();
    for (number, (x, y, at)) in candidates.into_iter().enumerate() {
        let why = if x.len() < median / 2 {
            Some("cut off or followed too soon by the next")
        } else if doubled(x) {
            Some("doubled")
        } else {
            None
        };
        match why {
            Some(why) => dropped.push(format!(
                "blow {} at {:.4} s: {why}",
                number + 1,
                at as f64 / data.rate
            )),
            None => pieces.push((x, y)),
        }
    }
    if !dropped.is_empty() {
        findings.push(
            Finding::new(
                Severity::Warning,
                "blows-left-out",
                format!(
                    "{} of {} blows are left out",
                    dropped.len(),
                    strengths.len()
                ),
            )
            .evidence(dropped.join("; "))
            .advice("strike once, and let the response decay before the next blow"),
        );
    }
    if pieces.len() < 2 {
        return Err(Trouble::data(format!(
            "{} usable blows: two or more are needed",
            pieces.len()
        ))
        .detail(data.name)
        .detail(dropped.join("; "))
        .with_hint("give several recordings, or one with several blows"));
    }
    let shortest = pieces.iter().map(|p| p.0.len()).min().unwrap_or(0);
    let length = wanted.unwrap_or(shortest).max(16);
    let undecayed = pieces
        .iter()
        .filter(|(_, y)| !decayed(&y[..length.min(y.len())]))
        .count();
    if undecayed > 0 {
        findings.push(
            Finding::new(
                Severity::Warning,
                "response-not-decayed",
                "responses do not decay within their stretch",
            )
            .evidence(format!(
                "{undecayed} of {} end above 5 % of their greatest value",
                pieces.len()
            ))
            .advice("record longer after each blow: what is cut off leaks into all lines"),
        );
    }
    Ok(Hits { pieces, length })
}

/// Whether the force comes back after it has once gone.
fn doubled(x: &[f64]) -> bool {
    let greatest = x.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let above = |v: &f64| v.abs() >= 0.1 * greatest;
    let Some(first) = x.iter().position(above) else {
        return true;
    };
    let width = x[first..].iter().position(|v| !above(v)).unwrap_or(0);
    // Ringing of the force sensor dies within a few widths; a second blow comes later.
    let later = first + width + 6 * width.max(1);
    x.get(later..).is_some_and(|rest| rest.iter().any(above))
}

fn decayed(y: &[f64]) -> bool {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let greatest = y.iter().fold(0.0f64, |m, v| m.max((v - mean).abs()));
    let tail = &y[y.len() - y.len() / 20 - 1..];
    let level = tail.iter().sum::<f64>() / tail.len() as f64;
    tail.iter().all(|v| (v - level).abs() < 0.05 * greatest)
}

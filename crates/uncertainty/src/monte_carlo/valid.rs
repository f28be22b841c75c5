//! Trials that gave no number.

use crate::{Finding, Refusal, Severity};
use proofmass_core::Error;
use rayon::prelude::*;

/// The trials without those in which an output is not finite.
pub(super) struct Valid {
    pub outputs: Vec<(String, String)>,
    /// One column per output that keeps enough trials, and how many it lost.
    pub columns: Vec<(Vec<f64>, usize)>,
    /// The trials in which all of these are finite, where any was lost.
    pub joint: Option<Vec<Vec<f64>>>,
    pub findings: Vec<Finding>,
}

impl Valid {
    pub fn of(
        outputs: Vec<(String, String)>,
        columns: Vec<Vec<f64>>,
        p: f64,
    ) -> Result<Self, Refusal> {
        let trials = columns[0].len();
        // Ten trials outside the interval are the least that can place its ends.
        let needed = (10.0 / (1.0 - p)).ceil().max(2.0) as usize;
        let mut result = Self {
            outputs: Vec::new(),
            columns: Vec::new(),
            joint: None,
            findings: Vec::new(),
        };
        let mut kept = Vec::new();
        for ((name, unit), column) in outputs.into_iter().zip(columns) {
            let valid = column.par_iter().filter(|v| v.is_finite()).count();
            let invalid = trials - valid;
            result
                .findings
                .extend(left_out(&name, invalid, trials, p, valid >= needed));
            if valid >= needed {
                result.outputs.push((name, unit));
                kept.push((column, invalid));
            }
        }
        if kept.is_empty() {
            return Err(Error::NotFinite {
                name: "model output in a trial",
                index: 0,
            }
            .into());
        }
        if kept.iter().any(|(_, invalid)| *invalid > 0) {
            let whole: Vec<usize> = (0..trials)
                .filter(|&t| kept.iter().all(|(column, _)| column[t].is_finite()))
                .collect();
            let pick = |column: &Vec<f64>| whole.iter().map(|&t| column[t]).collect();
            result.joint = Some(kept.iter().map(|(column, _)| pick(column)).collect());
            for (column, _) in &mut kept {
                column.retain(|v| v.is_finite());
            }
        }
        result.columns = kept;
        Ok(result)
    }
}

/// Says how many trials had to be left out.
fn left_out(name: &str, invalid: usize, trials: usize, p: f64, enough: bool) -> Option<Finding> {
    if invalid == 0 {
        return None;
    }
    let share = invalid as f64 / trials as f64;
    // Below a hundredth of what lies outside the interval they cannot move its ends visibly.
    let severity = if share > 0.01 * (1.0 - p) {
        Severity::Decision
    } else {
        Severity::Note
    };
    let what = if enough {
        format!(
            "{name} is not a finite number in some trials; its Monte Carlo result is that of the others"
        )
    } else {
        format!("{name} is not a finite number in almost all trials; it has no Monte Carlo result")
    };
    Some(
        Finding::new(severity, "invalid-trials", what)
            .evidence(format!("{invalid} of {trials}, {} %", crate::scientific(100.0 * share, 2)))
            .advice(
                "state the distributions of the inputs so that they keep to what is possible: truncated, rectangular, \
                 lognormal",
            ),
    )
}

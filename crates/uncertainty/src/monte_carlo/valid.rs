//! Trials that gave no number.

use crate::findings;
use crate::{Finding, Refusal, Severity};
use proofmass_core::Error;
use rayon::prelude::*;

/// The trials without those in which an output is not finite.
pub(super) struct Valid {
    pub(crate) outputs: Vec<(String, String)>,
    /// One column per output that keeps enough trials, and how many it lost.
    pub(crate) columns: Vec<(Vec<f64>, usize)>,
    /// The trials in which all of these are finite, where any was lost.
    pub(crate) joint: Option<Vec<Vec<f64>>>,
    pub(crate) findings: Vec<Finding>,
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
    let (extent, consequence) = match enough {
        true => ("some", "its Monte Carlo result is that of the others"),
        false => ("almost all", "it has no Monte Carlo result"),
    };
    let percentage = crate::scientific(100.0 * share, 2);
    Some(
        findings::invalid_trials(name, extent, consequence, invalid, trials, &percentage)
            .at(severity),
    )
}

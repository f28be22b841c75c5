//! Runs that contradict the others while nobody has decided about them.

use super::{MethodResult, ShakerMethod, frequency_result};
use crate::budget::Budget;
use crate::diagnosis::SuspectRun;
use crate::findings;
use crate::fit::{FrequencyFit, complex};
use crate::geometry::Configuration;
use crate::matrix::{AXES, Matrix, from_real};
use crate::observation::{Correction, PhasorRow, ascending};
use crate::plan::conditioning;
use crate::screening::with_motion;
use proofmass_core::Error;
use proofmass_uncertainty::Finding;
use serde::Serialize;

/// One frequency with and without the runs that contradict the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Contested {
    /// Label of the correction.
    pub correction: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// The runs.
    pub runs: Vec<String>,
    /// S without them, row by row, real and imaginary part, V/(m/s²).
    pub without: Vec<[f64; 2]>,
    /// S with them, of this frequency alone; `None` where no angles reconcile them with the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub with: Option<Vec<[f64; 2]>>,
}

/// Rows without the suspects, and their names; all rows where the others do not determine every frequency.
pub(super) fn parted(rows: &[PhasorRow], suspects: &[SuspectRun]) -> (Vec<PhasorRow>, Vec<String>) {
    let names: Vec<String> = suspects.iter().map(|s| s.run.clone()).collect();
    let kept: Vec<PhasorRow> = rows
        .iter()
        .enumerate()
        .filter(|(i, _)| !suspects.iter().any(|s| s.row == *i))
        .map(|(_, r)| r.clone())
        .collect();
    let determined = suspects.iter().all(|s| {
        let here = kept
            .iter()
            .filter(|r| r.frequency == rows[s.row].frequency)
            .map(|r| r.configuration);
        conditioning(&here.collect::<Vec<Configuration>>()).is_ok_and(|c| c.count >= 3)
    });
    if determined {
        (kept, names)
    } else {
        (rows.to_vec(), vec![])
    }
}

/// The frequencies of these runs with them beside without, with one correction; its results get intervals there that
/// reach the result with them.
///
/// # Errors
/// As [`complex`], but for a fit that does not end.
pub(super) fn contested(
    correction: &Correction,
    rows: &[PhasorRow],
    set_aside: &[String],
    results: &mut [MethodResult],
    budget: &Budget,
) -> Result<Vec<Contested>, Error> {
    let budget = &with_motion(budget, &correction.table, rows)?;
    let doubted = |r: &&PhasorRow| set_aside.contains(&r.run);
    let frequencies = ascending(rows.iter().filter(doubted).map(|r| r.frequency));
    let mut list = vec![];
    for frequency in frequencies {
        let here: Vec<PhasorRow> = rows
            .iter()
            .filter(|r| r.frequency == frequency)
            .cloned()
            .collect();
        let with: Option<Matrix> = match complex(&here, &correction.table, budget) {
            Ok(fit) => Some(fit.frequencies[0].sensitivity),
            Err(Error::NotConverged { .. }) => None,
            Err(other) => return Err(other),
        };
        let runs: Vec<String> = here.iter().filter(doubted).map(|r| r.run.clone()).collect();
        let description = format!("run {}: in or out is not decided", runs.join(", "));
        let mut without = None;
        for result in results.iter_mut().filter(|r| {
            r.correction == correction.label && r.method != ShakerMethod::PublishedMagnitude
        }) {
            let Some(place) = result
                .frequencies
                .iter_mut()
                .find(|f| f.frequency == frequency)
            else {
                continue;
            };
            let of = |estimate: &proofmass_uncertainty::Estimate| {
                let values: Vec<f64> = estimate.components().iter().map(|c| c.value).collect();
                from_real(&values)
            };
            let fit = FrequencyFit {
                frequency,
                sensitivity: of(&place.estimate),
                exploitation: of(&place.inverse_estimate),
                estimate: place.estimate.clone(),
                inverse_estimate: place.inverse_estimate.clone(),
            };
            without = without.or(Some(fit.sensitivity));
            if let Some(with) = &with {
                *place = frequency_result(&fit.reaching(with, &description)?)?;
            }
        }
        let pairs = |s: &Matrix| s.iter().flatten().map(|z| [z.re, z.im]).collect::<Vec<_>>();
        if let Some(without) = without {
            list.push(Contested {
                correction: correction.label.clone(),
                frequency,
                runs,
                without: pairs(&without),
                with: with.as_ref().map(pairs),
            });
        }
    }
    Ok(list)
}

/// The runs, and what they would do.
pub(super) fn finding(set_aside: &[String], contested: &[Contested]) -> Finding {
    let runs = match set_aside.len() {
        1 => "one run that contradicts the others is".to_owned(),
        n => format!("{n} runs that contradict the others are"),
    };
    let first = contested.first().map(|c| c.correction.as_str());
    let of_first = contested
        .iter()
        .filter(|c| Some(c.correction.as_str()) == first);
    let changes: Vec<String> = of_first
        .map(|c| match &c.with {
            None => format!(
                "at {} Hz no angles reconcile them with the others",
                c.frequency
            ),
            Some(with) => {
                let size = |k: usize| c.without[k][0].hypot(c.without[k][1]);
                let main = [0, 4, 8].iter().map(|&k| size(k)).sum::<f64>() / 3.0;
                let change = |k: usize| {
                    (with[k][0] - c.without[k][0]).hypot(with[k][1] - c.without[k][1]) / main
                };
                let k = (0..9)
                    .max_by(|&a, &b| change(a).total_cmp(&change(b)))
                    .unwrap_or(0);
                format!(
                    "at {} Hz they change S_{}{} most, by {:.2} % of the main terms",
                    c.frequency,
                    AXES[k / 3],
                    AXES[k % 3],
                    100.0 * change(k)
                )
            }
        })
        .collect();
    findings::runs_set_aside(&runs, &set_aside.join(", "), &changes.join("; "))
}

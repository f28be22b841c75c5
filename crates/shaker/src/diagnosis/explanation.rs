//! Which cause explains a run best.

use super::Suspicion;
use super::causes::{Cause, causes};
use super::trial::Trial;
use crate::observation::PhasorRow;

/// A cause is named when its odds against the next are 20 to 1 …
const MARGIN: f64 = 3.0;
/// … and what it leaves is no more than this χ².
const EXPLAINED: f64 = 30.0;
/// Causes that are refitted, after a look at all of them by their distance.
const REFITTED: usize = 10;

impl Trial<'_> {
    /// The cause that explains the run best, when it is clearly the best, and the χ² it leaves. `trials` are those of all
    /// frequencies: a run may belong to another one.
    pub(super) fn explain(
        &self,
        row: &PhasorRow,
        statistic: f64,
        trials: &[&Trial<'_>],
    ) -> (Suspicion, f64) {
        let at = |row: &PhasorRow| {
            let mut trials = trials.iter();
            trials.find(|t| t.frequency == row.frequency).copied()
        };
        let others: Vec<f64> = trials
            .iter()
            .map(|t| t.frequency)
            .filter(|f| *f != self.frequency)
            .collect();
        let mut list: Vec<(f64, Cause)> = causes(self, row, &others)
            .into_iter()
            .filter_map(|mut cause| {
                let trial = at(&cause.row)?;
                if cause.row.is_free() {
                    let turned = cause.row.nearest(&trial.prediction(&cause.row));
                    cause.row.outputs = turned.map(|y| y * cause.row.reference);
                }
                let distance = trial.distance(&cause.row);
                Some((0.5 * distance - cause.prior.ln(), cause))
            })
            .collect();
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Of a family that differs by a number, only the nearest.
        let mut families: Vec<u8> = vec![];
        list.retain(|(_, cause)| match cause.family {
            None => true,
            Some(family) => {
                let first = !families.contains(&family);
                families.push(family);
                first
            }
        });
        list.truncate(REFITTED);
        let mut judged: Vec<(f64, f64, Suspicion)> = list
            .into_iter()
            .map(|(_, cause)| {
                let left = at(&cause.row).map_or(1e9, |t| t.increase(&cause.row));
                (0.5 * left - cause.prior.ln(), left, cause.suspicion)
            })
            .collect();
        // Something else, of whatever size it has: a normal error of all six reals as large as it looks.
        let half = 0.5 * row.reals();
        let unexplained =
            half + half * (statistic / row.reals()).max(1.0).ln() - (0.05f64 / 8.0).ln();
        judged.push((unexplained, statistic, Suspicion::Unexplained));
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        match judged.as_slice() {
            [(cost, left, suspicion), (next, ..), ..]
                if next - cost > MARGIN && *left <= EXPLAINED =>
            {
                (suspicion.clone(), *left)
            }
            [(_, left, a), (_, other, b), ..] if *left <= EXPLAINED && *other <= EXPLAINED => (
                Suspicion::Either(Box::new(a.clone()), Box::new(b.clone())),
                *left,
            ),
            _ => (Suspicion::Unexplained, statistic),
        }
    }
}

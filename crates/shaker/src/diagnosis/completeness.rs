//! Runs that are missing, there twice, or copies of another.

use super::super::geometry::Configuration;
use super::super::observation::{PhasorRow, ascending};
use super::words::degrees;
use super::{SuspectRun, Suspicion};
use crate::copied_readings::{self, Reading};
use crate::findings;
use proofmass_uncertainty::Finding;

/// Runs that are missing or there twice.
pub(super) fn completeness(rows: &[PhasorRow], plan: Option<&[Configuration]>) -> Vec<Finding> {
    let mut found = vec![];
    let plan: Vec<Configuration> = plan.map_or_else(
        || {
            let mut all: Vec<Configuration> = vec![];
            for row in rows {
                if !all.iter().any(|c| c.same_as(&row.configuration)) {
                    all.push(row.configuration);
                }
            }
            all
        },
        <[_]>::to_vec,
    );
    let frequencies = ascending(rows.iter().map(|r| r.frequency));
    for &f in &frequencies {
        let here: Vec<&PhasorRow> = rows.iter().filter(|r| r.frequency == f).collect();
        for c in &plan {
            let twice: Vec<&PhasorRow> = here
                .iter()
                .filter(|r| r.configuration.same_as(c))
                .copied()
                .collect();
            let measured = twice.len();
            // In another session it is a repeat.
            let in_session = |r: &&&PhasorRow| {
                let other = |o: &&&PhasorRow| o.session == r.session;
                twice.iter().filter(other).count() > 1
            };
            let twice: Vec<&PhasorRow> = match twice.len() {
                0 | 1 => twice,
                _ => twice.iter().filter(in_session).copied().collect(),
            };
            let same: Vec<&str> = twice.iter().map(|r| r.run.as_str()).collect();
            if measured == 0 {
                found.push(findings::missing_configuration(
                    &degrees(c),
                    f,
                    here.len(),
                    plan.len(),
                ));
            } else if same.len() > 1 && copied_readings::copies(&readings(&twice)).is_empty() {
                found.push(findings::duplicate_configuration(
                    &degrees(c),
                    f,
                    same.len(),
                    &same.join(", "),
                ));
            }
        }
        for r in &here {
            if !plan.iter().any(|c| c.same_as(&r.configuration)) {
                found.push(findings::unplanned_configuration(
                    &r.run,
                    &degrees(&r.configuration),
                ));
            }
        }
    }
    found
}

/// The rows as they were read; only those of one configuration are compared.
fn readings<'a>(rows: &[&'a PhasorRow]) -> Vec<Reading<'a>> {
    let of = |row: &&'a PhasorRow| {
        let [x, y, z] = row.outputs;
        Reading::new(&row.run, row.frequency, &[row.reference, x, y, z])
            .at(degrees(&row.configuration))
    };
    rows.iter().map(of).collect()
}

/// Runs of one configuration with the same readings, digit by digit.
pub(super) fn doubled(rows: &[PhasorRow]) -> Vec<Finding> {
    copied_readings::copies(&readings(&rows.iter().collect::<Vec<_>>()))
}

/// Relative difference below which two phasors are one and the same: two readings never agree so far.
const SAME: f64 = 1e-6;

/// Another row with the same phasors.
pub(super) fn twin(rows: &[PhasorRow], index: usize) -> Option<usize> {
    let row = &rows[index];
    // A calculated table may hold the same number twice; phases that were read do not.
    let phases = row.outputs.iter().chain([&row.reference]);
    if phases.filter(|z| z.im != 0.0).count() < 3 {
        return None;
    }
    (0..rows.len()).find(|&k| k != index && same(row, &rows[k]))
}

fn same(a: &PhasorRow, b: &PhasorRow) -> bool {
    let close = |a: num_complex::Complex64, b: num_complex::Complex64| {
        (a - b).norm() <= SAME * a.norm().max(b.norm())
    };
    close(a.reference, b.reference) && (0..3).all(|j| close(a.outputs[j], b.outputs[j]))
}

/// Pairs of runs with the same phasors of which neither contradicts the others.
pub(super) fn copies(rows: &[PhasorRow], suspects: &[SuspectRun]) -> Vec<Finding> {
    let named = |name: &str| {
        let mut suspects = suspects.iter();
        suspects.any(|s| s.run == name && matches!(s.suspicion, Suspicion::Copied { .. }))
    };
    // Sorted by the reference, copies are neighbours.
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|&a, &b| rows[a].reference.re.total_cmp(&rows[b].reference.re));
    let pairs = order.windows(2).filter(|w| same(&rows[w[0]], &rows[w[1]]));
    pairs
        .filter_map(|w| {
            let (a, b) = (&rows[w[0].min(w[1])], &rows[w[0].max(w[1])]);
            // The same configuration twice is told by itself.
            let double = a.frequency == b.frequency && a.configuration.same_as(&b.configuration);
            if double || named(&a.run) || named(&b.run) || twin(rows, w[0]).is_none() {
                return None;
            }
            Some(findings::copied_run(
                &format!(
                    "run {} has the phasors of run {}, digit by digit",
                    b.run, a.run
                ),
                &format!(
                    "{} at {} Hz and {} at {} Hz, all four within 1e-6",
                    degrees(&a.configuration),
                    a.frequency,
                    degrees(&b.configuration),
                    b.frequency
                ),
            ))
        })
        .collect()
}

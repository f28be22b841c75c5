//! Standstills that do not belong to the others: out of line, or under a wrong label.

use super::{Problem, Solved};
use crate::added_terms::WeighedTerms;
use crate::direction_coverage::unit;
use crate::{Direction, Pose, Triple};
use proofmass_core::{dot, norm};

/// A standstill that the others contradict.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Suspect {
    /// Its place among the standstills, counted from 0.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// By how much its mean output lies off what the others say, natural units (multiples of g).
    pub deviation: f64,
    /// Family-wise probability that a healthy recording shows a standstill as far off.
    pub p_value: f64,
    /// Where the others see the specific force, when it lies more than 10° from the given attitude.
    pub seen: Option<Triple>,
}

/// Family-wise probability of naming a standstill that is not out of line.
const LEVEL: f64 = 0.01;
/// A label is wrong, and not only rough, beyond this angle.
const OTHER_ATTITUDE_DEG: f64 = 10.0;

/// At most a fifth of all ([`AddedTerms::out_of_line`](crate::added_terms::AddedTerms::out_of_line)), beside errors of each standstill for itself.
pub(crate) fn of(problem: &Problem<'_>, solved: &Solved) -> Vec<Suspect> {
    let mut terms = solved.terms();
    accept(problem, solved, &mut terms)
}

/// As [`of`]; the suspects are taken out of the residuals of `terms`.
pub(super) fn accept(
    problem: &Problem<'_>,
    solved: &Solved,
    terms: &mut WeighedTerms<'_>,
) -> Vec<Suspect> {
    let n = problem.poses.len();
    let named = terms
        .independent()
        .map_or_else(Vec::new, |t| t.out_of_line(problem.each(), LEVEL));
    let mut suspects = Vec::with_capacity(named.len());
    for (index, test) in named {
        suspects.push(Suspect {
            index,
            name: problem.poses[index].name(index),
            deviation: test.amplitudes.iter().map(|a| a * a).sum::<f64>().sqrt(),
            p_value: (test.p_value * n as f64).min(1.0),
            seen: None,
        });
        terms.leave_out(index, problem.each());
    }
    label(problem, solved, &mut suspects);
    suspects.sort_by_key(|s| s.index);
    suspects
}

/// Where the sensor lay, by a fit to the standstills that are not suspected.
fn label(problem: &Problem<'_>, solved: &Solved, suspects: &mut [Suspect]) {
    let Some(attitudes) = &problem.attitudes else {
        return;
    };
    if suspects.is_empty() {
        return;
    }
    let mut weights: Vec<f64> = solved
        .weighting
        .variances
        .iter()
        .map(|v| 1.0 / (v + solved.excess))
        .collect();
    for suspect in suspects.iter() {
        let rows = suspect.index * 3..suspect.index * 3 + 3;
        weights[rows].fill(0.0);
    }
    let Ok(others) = problem.adjust(&solved.solution.parameters, &solved.weighting, &weights)
    else {
        return;
    };
    let Ok(accelerations) = problem.accelerations(&others.parameters) else {
        return;
    };
    for suspect in suspects {
        let a = accelerations[suspect.index];
        let given = attitudes[suspect.index];
        suspect.deviation = norm(std::array::from_fn(|i| a[i] - given[i]));
        suspect.seen =
            unit(a).filter(|seen| dot(*seen, given) < OTHER_ATTITUDE_DEG.to_radians().cos());
    }
}

/// A direction in words: a principal one where it is near, else its components.
pub(crate) fn in_words(direction: Triple) -> String {
    Direction::ALL
        .into_iter()
        .find(|d| dot(d.unit(), direction) > OTHER_ATTITUDE_DEG.to_radians().cos())
        .map_or_else(
            || {
                let [x, y, z] = direction;
                format!("({x:+.2}, {y:+.2}, {z:+.2})")
            },
            |d| d.to_string(),
        )
}

/// The standstills that are not suspected.
pub(crate) fn others(poses: &[Pose], suspects: &[Suspect]) -> Vec<Pose> {
    let kept = |i: &usize| suspects.iter().all(|s| s.index != *i);
    (0..poses.len())
        .filter(kept)
        .map(|i| {
            let mut pose = poses[i].clone();
            // Names stay those of the whole list.
            pose.segment.label = Some(pose.name(i));
            pose
        })
        .collect()
}

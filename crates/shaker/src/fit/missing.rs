//! Angles that a glued device on wedges has and the budget does not: what the runs say of them.

use super::upper_tail;
use crate::adjustment::{Adjustment, Group, Score};
use crate::budget::{Acts, Budget, ShakerInput};
use crate::observation::{PhasorRow, SpuriousTable};
use proofmass_uncertainty::{Finding, Severity};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Standard uncertainty that a missing angle is tried with: ±0.1° rectangular.
const TRIAL: f64 = 0.1 * std::f64::consts::PI / 180.0 / 1.732_050_807_568_877_2;
/// Probability below which the runs are said to want an angle.
const WANTED: f64 = 1e-4;

/// Tilt of the glued device, what all gluings have of it in common, and lean of the wedges.
///
/// A lean answers to a missing tilt too, so it is asked for where tilt is declared or the runs want none.
pub(super) fn missing_angles(
    adjustment: &Adjustment,
    rows: &[PhasorRow],
    spurious: &SpuriousTable,
    budget: &Budget,
) -> Vec<Finding> {
    let declared = |acts: Acts, of: &dyn Fn(&ShakerInput) -> bool| {
        let inputs = &mut budget.inputs.iter();
        inputs.any(|i| i.acts == acts && i.standard_uncertainty() > 0.0 && of(i))
    };
    let any = |_: &ShakerInput| true;
    // A budget without a gluing is not one of a glued device.
    if !declared(Acts::Rotation, &any) {
        return vec![];
    }
    let frequencies = adjustment.frequencies.iter();
    let few = frequencies
        .map(|f| spurious.dof_at(*f).get())
        .fold(f64::INFINITY, f64::min);
    let asked = |acts: Acts, group: Group| {
        let score = adjustment.score(acts, TRIAL, group, rows, spurious, budget)?;
        // Spurious motion of few repeats may be known worse than it says: F instead of χ².
        let p = match FisherSnedecor::new(score.dof, few) {
            Ok(f) if few.is_finite() => f.sf(score.statistic / score.dof),
            _ => upper_tail(score.statistic, score.dof),
        };
        Some((score, p))
    };
    let mut findings = vec![];
    let per_gluing = |i: &ShakerInput| !i.varies_with.is_empty();
    let (tilt, lean) = (
        declared(Acts::Tilt, &per_gluing),
        declared(Acts::Lean, &any),
    );
    let tilts = (!tilt)
        .then(|| asked(Acts::Tilt, Group::Configuration))
        .flatten();
    let leans = (!lean)
        .then(|| asked(Acts::Lean, Group::Inclination))
        .flatten();
    // Each answers to the other's error: the one that explains more of it is named.
    let leaning = |p: f64| leans.is_some_and(|(_, other)| other < p && other < WANTED);
    if let Some((score, p)) = tilts {
        findings.push(tilt_finding(score, p, p < WANTED && !leaning(p)));
    } else if tilt && !declared(Acts::Tilt, &|i| i.varies_with.is_empty()) {
        findings.push(
            Finding::new(
                Severity::Note,
                "missing-mean-tilt",
                "the budget has no tilt that all gluings have in common",
            )
            .evidence("the base of the device against its marked axes; no run can show it, in whatever number")
            .advice(
                "declare `device.tilt.mean` (acts = \"tilt\", varies_with = []); it enters S_xz, S_yz, S_zx, S_zy undiminished",
            ),
        );
    }
    if let Some((score, p)) = leans
        && p < WANTED
        && tilts.is_none_or(|(_, other)| leaning(other) || other >= WANTED)
    {
        findings.push(lean_finding(score, p));
    }
    findings
}

fn size(score: Score) -> String {
    format!(
        "u = {:.3}° (score χ² = {:.1}, ν = {:.1}",
        score.variance.max(0.0).sqrt().to_degrees(),
        score.statistic,
        score.dof
    )
}

fn tilt_finding(score: Score, p: f64, seen: bool) -> Finding {
    Finding::new(
        if seen {
            Severity::Decision
        } else {
            Severity::Note
        },
        "missing-gluing-tilt",
        if seen {
            "the budget has no tilt of the glued device, and the runs want one".to_owned()
        } else {
            "the budget has no tilt of the glued device".to_owned()
        },
    )
    .evidence(format!(
        "the device may turn on the wedge face but not tilt in its adhesive; the runs want {} per gluing, p = {p:.1e})",
        size(score)
    ))
    .advice(
        "declare `gluing.tilt` (acts = \"tilt\") with inclination and rotation, and `device.tilt.mean` with no key for \
         what all gluings have in common: no data can show that, and S_xz, S_yz, S_zx, S_zy carry it undiminished",
    )
}

fn lean_finding(score: Score, p: f64) -> Finding {
    Finding::new(
        Severity::Decision,
        "missing-wedge-lean",
        "the budget has no lateral lean of the wedges, and the runs want one",
    )
    .evidence(format!(
        "the wedges may be steeper or flatter than drawn but not lean sideways; the runs want {} per wedge, p = {p:.1e})",
        size(score)
    ))
    .advice(
        "declare `wedge.lean` (acts = \"lean\") with inclination, or with no key where it is the table that leans; it enters \
         S_xy and S_yx",
    )
}

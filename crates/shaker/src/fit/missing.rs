//! Errors that a glued device on wedges has and the budget does not: what the runs say of them.

use crate::adjustment::{Adjustment, Group, Score};
use crate::budget::{Acts, Budget, Key, ShakerInput};
use crate::findings;
use crate::observation::{PhasorRow, SpuriousTable};
use proofmass_uncertainty::chi_squared_chance;
use proofmass_uncertainty::{Finding, Severity};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Standard uncertainty that a missing angle is tried with: ±0.1° rectangular.
const TRIAL: f64 = 0.1 * std::f64::consts::PI / 180.0 / 1.732_050_807_568_877_2;
/// Relative standard uncertainty that a missing gain is tried with.
const TRIAL_GAIN: f64 = 1e-3;
/// Probability below which the runs are said to want an input.
const WANTED: f64 = 1e-4;
/// Probability below which the runs on a wedge are said to share an error: there are few wedges, so that a real one seldom goes
/// below [`WANTED`].
const SHARED: f64 = 2.5e-3;

/// Tilt of the glued device, what all gluings have of it in common, lean of the wedges, and what all runs on a wedge share: the
/// zero of its marks, and the gain.
///
/// A lean answers to a missing tilt too, so it is asked for where tilt is declared or the runs want none.
pub(super) fn missing_inputs(
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
        let trial = if acts.is_angle() { TRIAL } else { TRIAL_GAIN };
        let score = adjustment.score(acts, trial, group, rows, spurious, budget)?;
        // Spurious motion of few repeats may be known worse than it says: F instead of χ².
        let p = match FisherSnedecor::new(score.dof, few) {
            Ok(f) if few.is_finite() => f.sf(score.statistic / score.dof),
            _ => chi_squared_chance(score.statistic, score.dof),
        };
        Some((score, p))
    };
    let mut found = vec![];
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
        let finding = |seen| gluing_tilt(seen, &size(score), p);
        found.push(match p < WANTED && !leaning(p) {
            true => finding(", and the runs ask for one").at(Severity::Decision),
            false => finding(""),
        });
    } else if tilt && !declared(Acts::Tilt, &|i| i.varies_with.is_empty()) {
        found.push(mean_tilt());
    }
    if let Some((score, p)) = leans
        && p < WANTED
        && tilts.is_none_or(|(_, other)| leaning(other) || other >= WANTED)
    {
        found.push(wedge_lean(&size(score), p));
    }
    let per_wedge = |i: &ShakerInput| i.varies_with == [Key::Inclination];
    for (acts, told) in [
        (Acts::Rotation, wedge_marks as fn(Score, f64) -> Finding),
        (Acts::ReferenceModulus, wedge_gain),
    ] {
        if !declared(acts, &per_wedge)
            && let Some((score, p)) = asked(acts, Group::Inclination)
            && p < SHARED
        {
            let severity = match p < WANTED {
                true => Severity::Decision,
                false => Severity::Warning,
            };
            found.push(told(score, p).at(severity));
        }
    }
    found
}

fn gluing_tilt(seen: &str, size: &str, p_value: f64) -> Finding {
    findings::missing_input(
        &format!("tilt of the glued device{seen}"),
        &format!(
            "the device may turn on the wedge face but not tilt in its adhesive; the runs ask for {size} per gluing, p = {p_value:.1e})"
        ),
        "`gluing.tilt` (acts = \"tilt\") with inclination and rotation, and `device.tilt.mean` with no key for the tilt common to all mountings: the runs cannot determine it, and S_xz, S_yz, S_zx, S_zy carry it undiminished",
    )
}

fn mean_tilt() -> Finding {
    findings::missing_input(
        "tilt that all gluings have in common",
        "the base of the device against its marked axes; no run can show it, in whatever number",
        "`device.tilt.mean` (acts = \"tilt\", varies_with = []); it enters S_xz, S_yz, S_zx, S_zy undiminished",
    )
}

fn wedge_lean(size: &str, p_value: f64) -> Finding {
    findings::missing_input(
        "sideways tilt of the wedges, and the runs ask for one",
        &format!("the wedges may be steeper or flatter than drawn but not tilt sideways; the runs ask for {size} per wedge, p = {p_value:.1e})"),
        "`wedge.lean` (acts = \"lean\") with inclination, or with no key where it is the table that is inclined; it enters S_xy and S_yx",
    )
    .at(Severity::Decision)
}

fn wedge_marks(score: Score, p_value: f64) -> Finding {
    findings::missing_input(
        "error that all rotations on a wedge share, and the runs ask for one",
        &format!(
            "every rotation is drawn anew; the runs ask for {} per wedge, p = {p_value:.1e})",
            size(score)
        ),
        "`wedge.marks` (acts = \"rotation\") with inclination; it enters S_xy and S_yx",
    )
}

fn wedge_gain(score: Score, p_value: f64) -> Finding {
    let percent = 100.0 * score.variance.max(0.0).sqrt();
    findings::missing_input(
        "change of gain from wedge to wedge, and the runs ask for one",
        &format!(
            "the reference and the conditioner may not change between wedges; the runs ask for u = {percent:.2} % per wedge ({}, p = {p_value:.1e})",
            statistic(score)
        ),
        "`wedge.gain` (acts = \"reference-modulus\") with inclination, or find what changed between the wedges: warm-up, amplifier, another day",
    )
}

fn size(score: Score) -> String {
    let degrees = score.variance.max(0.0).sqrt().to_degrees();
    format!("u = {degrees:.3}° ({}", statistic(score))
}

fn statistic(score: Score) -> String {
    format!("score χ² = {:.1}, ν = {:.1}", score.statistic, score.dof)
}

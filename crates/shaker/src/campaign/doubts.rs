//! Doubts about a campaign as a whole.

use super::MethodResult;
use crate::datasheet::{Datasheet, OffDatasheet, Promise, SheetDeviation, off_datasheet};
use crate::findings;
use crate::observation::{Basis, Correction, PhasorRow, Spurious, UnmeasuredAt, UnmeasuredMotion};
use proofmass_uncertainty::Finding;

/// Places of the campaign that a correction says nothing about.
pub(super) fn gaps(correction: &Correction, rows: &[PhasorRow]) -> Option<Finding> {
    if correction.table.entries.is_empty() {
        return None;
    }
    let mut missing: Vec<String> = vec![];
    for row in rows {
        let inclination = row.configuration.inclination;
        if correction.table.get(inclination, row.frequency).is_none() {
            let place = format!("{:.4}° at {} Hz", inclination.to_degrees(), row.frequency);
            if !missing.contains(&place) {
                missing.push(place);
            }
        }
    }
    let first = missing.first()?;
    Some(findings::correction_incomplete(
        &correction.label,
        missing.len(),
        first,
    ))
}

/// Corrections whose measured ratios of an axis have no uncertainty, in one finding each.
pub(super) fn exact_motion(corrections: &[Correction]) -> Vec<Finding> {
    let exact = |c: &Correction, axis: usize| {
        let measured =
            |e: &&Spurious| e.basis[axis] == Basis::Measured && e.ratio[axis].norm() > 0.0;
        let mut measured = c.table.entries.iter().filter(measured).peekable();
        measured.peek().is_some() && measured.all(|e| e.covariance[axis] == [0.0; 3])
    };
    let mut found = Vec::new();
    for c in corrections {
        let axes = ["x′", "y′", "z′"].into_iter().enumerate();
        let axes: Vec<&str> = axes
            .filter(|(k, _)| exact(c, *k))
            .map(|(_, name)| name)
            .collect();
        if !axes.is_empty() {
            found.push(findings::motion_taken_as_exact(&c.label, &axes.join(", ")));
        }
    }
    found
}

/// Motion of the bench that nobody measured, of the first result: the largest across and along, with their frequencies.
pub(super) fn unmeasured_motion(
    results: &[MethodResult],
    stated: Option<UnmeasuredMotion>,
) -> Option<Finding> {
    let rigorous = |r: &&MethodResult| !r.frequencies.is_empty();
    let all = &results.iter().find(rigorous)?.motion;
    if all.is_empty() {
        return None;
    }
    let largest = |of: fn(&UnmeasuredAt) -> Option<f64>| {
        let sizes = all.iter().filter_map(|m| Some((of(m)?, m.frequency)));
        sizes.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (across, along) = (largest(|m| m.across), largest(|m| m.along));
    let words = |size: Option<(f64, f64)>, way: &str| {
        size.map(|(u, f)| format!("{:.2} % {way} the excitation at {f} Hz", 100.0 * u))
    };
    let sizes: Vec<String> = [words(across, "across"), words(along, "along")]
        .into_iter()
        .flatten()
        .collect();
    Some(match stated {
        Some(_) => findings::motion_declared(all.len(), &sizes.join(", ")),
        None => findings::motion_not_measured(all.len(), &sizes.join(", ")),
    })
}

/// A rise that announces a resonance, and adhesive where it begins to count.
pub(super) fn high_frequencies(results: &[MethodResult]) -> Vec<Finding> {
    let mut found = vec![];
    let Some(result) = results.iter().find(|r| r.frequencies.len() > 2) else {
        return found;
    };
    let Some(highest) = result.frequencies.last() else {
        return found;
    };
    for k in [0, 4, 8] {
        let mut low: Vec<f64> = result.frequencies[..result.frequencies.len() - 1]
            .iter()
            .map(|f| f.sensitivity[k].modulus.value)
            .collect();
        low.sort_by(f64::total_cmp);
        let (median, term) = (low[low.len() / 2], &highest.sensitivity[k]);
        let rise = term.modulus.value / median - 1.0;
        if rise > 0.03 && rise * median > term.modulus.expanded {
            // |S|/S₀ = 1/(1 − (f/f₀)²) below resonance.
            let resonance = highest.frequency / (1.0 - 1.0 / (1.0 + rise)).sqrt();
            found.push(findings::resonance_onset(
                &term.name,
                100.0 * rise,
                highest.frequency,
                resonance,
            ));
        }
    }
    if highest.frequency > 1000.0 {
        found.push(findings::adhesive_mounting(highest.frequency));
    }
    found
}

/// Main sensitivities that the datasheet does not know, at the frequency nearest to that of the sheet, or to 160 Hz, where datasheets are
/// made; and frequencies of which it says nothing.
pub(super) fn against_datasheet(sheet: &Datasheet, results: &[MethodResult]) -> Vec<Finding> {
    let Some(result) = results.first() else {
        return vec![];
    };
    let frequencies = || result.frequencies.iter().map(|f| f.frequency);
    let away = |f: f64| (f / sheet.reference.unwrap_or(160.0)).ln().abs();
    let here = frequencies().min_by(|a, b| away(*a).total_cmp(&away(*b)));
    let mut found = vec![];
    if let Some(here) = here {
        let of_here =
            |d: &&SheetDeviation| d.promise == Promise::Sensitivity && d.frequency == here;
        let all: Vec<OffDatasheet> = result
            .datasheet
            .iter()
            .filter(of_here)
            .filter_map(|d| {
                Some(OffDatasheet {
                    name: Some(d.axis.to_owned()),
                    relative: d.value,
                    allowed: d.allowed()?,
                })
            })
            .collect();
        found.extend(off_datasheet(here, &all));
    }
    let outside = sheet.beyond_the_bands(frequencies());
    let reference = sheet.reference.filter(|_| !sheet.bands.is_empty());
    let unmeasured = reference.filter(|_| sheet.reference_among(frequencies()).is_none());
    if !outside.is_empty() || unmeasured.is_some() {
        let names: Vec<String> = outside.iter().map(f64::to_string).collect();
        let mut evidence = Vec::new();
        if !names.is_empty() {
            evidence.push(format!("no band holds {} Hz", names.join(", ")));
        }
        evidence.extend(
            unmeasured.map(|f| {
                format!("no run is within an octave of {f} Hz, from which the bands count")
            }),
        );
        found.push(findings::datasheet_silent(&evidence.join("; ")));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::SpuriousTable;
    use num_complex::Complex64;
    use proofmass_uncertainty::DegreesOfFreedom;

    #[test]
    fn known_motion_without_an_uncertainty() {
        let correction = |covariance: [[f64; 3]; 3], basis| Correction {
            label: "first".into(),
            table: SpuriousTable::new(vec![Spurious {
                inclination: 0.0,
                frequency: 80.0,
                ratio: [0.01, 0.02, 0.0].map(|r| Complex64::new(r, 0.0)),
                covariance,
                dof: DegreesOfFreedom::INFINITE,
                basis: [basis; 3],
            }]),
        };
        let known = [1e-6, 0.0, 1e-6];
        let found = |covariance, basis| exact_motion(&[correction(covariance, basis)]);
        let one = found([known, [0.0; 3], known], Basis::Measured);
        assert_eq!(one[0].code(), "motion-taken-as-exact");
        assert!(one[0].to_string().contains("along y′:"), "{}", one[0]);
        assert!(found([known; 3], Basis::Measured).is_empty());
        assert!(found([[0.0; 3]; 3], Basis::Declared).is_empty());
    }
}

//! Reference and device on each other's cable in a comparison: the ratio is inverted.

use super::single_axis::{ComparisonRow, SingleAxis};
use crate::findings;
use num_complex::Complex64;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_uncertainty::Finding;

/// Difference of the logarithms from which on a sensitivity is another one: near a ratio of one an exchange changes nothing.
const OTHER: f64 = 0.25;
/// Difference within which it is the expected one.
const SAME: f64 = 0.05;

/// Runs whose ratio is inverted: what was recorded as the device is the reference, and the other way round. Each comes with
/// the sensitivity that it has with the cables exchanged, r²/S, r the sensitivity of the reference.
///
/// A run is judged by its repeats, three runs at its frequency at least; without them by the nominal sensitivity and
/// tolerance of the data sheet. A resonance raises the sensitivity too: where the data sheet is all there is, a run is
/// accused only if another one at its frequency or above fits the data sheet as it stands, or none of the campaign does.
pub fn swapped_cables(
    rows: &[ComparisonRow],
    results: &[SingleAxis],
    table: &ReferenceTable,
    datasheet: Option<(f64, f64)>,
) -> Vec<Finding> {
    let exchanged = |i: usize| -> Option<Complex64> {
        let point = table.at(results[i].frequency).ok()?;
        let r = Complex64::from_polar(point.sensitivity, point.phase);
        Some(r * r / results[i].sensitivity)
    };
    let far = |z: Complex64, expected: f64| (z.norm() / expected).ln().abs();
    let inverted = |i: usize, expected: f64, same: f64| {
        let other = exchanged(i)?;
        let looks = far(results[i].sensitivity, expected) > OTHER.max(3.0 * same)
            && far(other, expected) < same;
        looks.then_some((i, other, expected))
    };
    let by_repeats = |i: usize| -> Option<f64> {
        let here = (0..results.len()).filter(|&k| results[k].frequency == results[i].frequency);
        let mut moduli: Vec<f64> = here.map(|k| results[k].sensitivity.norm()).collect();
        moduli.sort_by(f64::total_cmp);
        // With more than half of the runs swapped the others would be accused.
        (moduli.len() > 2).then(|| moduli[(moduli.len() - 1) / 2])
    };
    let fits = |i: usize| {
        let (nominal, tolerance) = datasheet?;
        (far(results[i].sensitivity, nominal) < (tolerance / nominal).max(SAME))
            .then_some(results[i].frequency)
    };
    let sound: Vec<f64> = (0..results.len()).filter_map(fits).collect();
    let mut found = vec![];
    for i in 0..results.len() {
        let by_datasheet = || {
            let (nominal, tolerance) = datasheet?;
            let above = sound.iter().any(|f| *f >= results[i].frequency);
            (above || sound.is_empty())
                .then(|| inverted(i, nominal, (tolerance / nominal).max(SAME)))?
        };
        let repeats = by_repeats(i).and_then(|median| inverted(i, median, SAME));
        found.extend(repeats.or_else(by_datasheet));
    }
    if found.is_empty() {
        return vec![];
    }
    let what = if found.len() == results.len() {
        "the cables of the reference and of the device look swapped in every run".to_owned()
    } else {
        let names: Vec<&str> = found.iter().map(|f| rows[f.0].run.as_str()).collect();
        let runs = if names.len() == 1 { "run" } else { "runs" };
        format!(
            "the cables of the reference and of the device look swapped in {runs} {}",
            names.join(", ")
        )
    };
    let unit = results[0]
        .estimate
        .components()
        .first()
        .map_or("", |c| &c.unit);
    let values: Vec<String> = found
        .iter()
        .take(6)
        .map(|(i, other, expected)| {
            format!(
                "run {} at {} Hz: {:.4e} {unit} as recorded, {:.4e} with the cables exchanged, {expected:.4e} expected",
                rows[*i].run,
                results[*i].frequency,
                results[*i].sensitivity.norm(),
                other.norm()
            )
        })
        .collect();
    vec![findings::swapped_channels(&what, &values.join("; "))]
}

#[cfg(test)]
mod tests {
    use super::super::single_axis::{ComparisonBudget, compare};
    use super::*;
    use proofmass_dynamic::reference_table::ReferencePoint;
    use proofmass_uncertainty::DegreesOfFreedom;

    /// Runs of a device of 4 mV/(m/s²) with a resonance at 5 kHz against a reference of 10 mV/(m/s²).
    fn said(
        frequencies: &[f64],
        repeats: usize,
        swapped: &[usize],
        datasheet: Option<(f64, f64)>,
    ) -> Vec<Finding> {
        let point = |frequency| ReferencePoint {
            frequency,
            sensitivity: 0.01,
            phase: 0.1,
            modulus_uncertainty: 0.002,
            phase_uncertainty: 0.002,
        };
        let table = ReferenceTable::new(vec![point(10.0), point(20_000.0)]).unwrap();
        let mut rows = vec![];
        for &frequency in frequencies {
            let gain = 1.0 / (1.0 - (frequency / 5000f64).powi(2)).abs();
            for _ in 0..repeats {
                let i = rows.len();
                let noise = 1.0 + 1e-3 * (i as f64 * 2.4).sin();
                let mut pair = [0.1, 0.04 * gain * noise].map(|a| Complex64::from_polar(a, 0.3));
                if swapped.contains(&i) {
                    pair.swap(0, 1);
                }
                rows.push(ComparisonRow {
                    run: format!("r{i}"),
                    frequency,
                    reference: pair[0],
                    output: pair[1],
                    transverse: Some(0.01),
                    covariance: [[0.0; 3]; 2],
                });
            }
        }
        let budget = ComparisonBudget {
            ratio: 0.001,
            phase: 0.001,
            dof: DegreesOfFreedom::INFINITE,
            transverse: None,
            front_end: 0.0,
            free_phase: false,
        };
        let (results, _) = compare(&rows, Some(&table), "V/(m/s²)", &budget).unwrap();
        swapped_cables(&rows, &results, &table, datasheet)
    }

    #[test]
    fn known_swapped_cables_are_named_with_the_corrected_sensitivity() {
        let nominal = Some((0.004, 0.0004));
        for (frequencies, repeats, swapped, datasheet) in [
            (&[160.0][..], 3, &[1][..], None),
            (&[80.0, 160.0], 1, &[0], nominal),
            (&[80.0, 160.0, 500.0], 1, &[0, 1, 2], nominal),
        ] {
            let findings = said(frequencies, repeats, swapped, datasheet);
            assert_eq!(findings.len(), 1, "{swapped:?}");
            let said = match swapped.len() == repeats * frequencies.len() {
                true => "every run".to_owned(),
                false => format!("run r{}", swapped[0]),
            };
            assert!(findings[0].what().contains(&said), "{said}");
            // 0.01² / 0.004 recorded, 4 mV/(m/s²) true.
            let evidence = findings[0].evidence_text();
            assert!(evidence.contains("e-2 V/(m/s²) as recorded"), "{evidence}");
            assert!(
                evidence.contains(" 4.0") || evidence.contains(" 3.99"),
                "{evidence}"
            );
        }
    }

    #[test]
    fn law_sound_runs_and_resonances_are_not_accused() {
        let sweep = [80.0, 160.0, 1000.0, 3000.0, 4000.0, 4500.0, 4700.0];
        assert!(said(&sweep, 3, &[], None).is_empty());
        // Where the resonance makes r²/S the nominal value: gain (10/4)² = 6.25 at 4583 Hz.
        for top in (4400..4700).step_by(5) {
            let sweep = [80.0, 160.0, f64::from(top)];
            for repeats in [1, 3] {
                assert!(said(&sweep, repeats, &[], Some((0.004, 0.0004))).is_empty());
            }
        }
    }
}

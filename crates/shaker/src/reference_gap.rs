//! Frequencies between two points of a certificate that are far apart.

use crate::findings;
use crate::observation::ascending;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_uncertainty::Finding;

/// Ratio of two neighbours from which on nobody knows the curve between them. Certificates by thirds of an octave, by octaves and by 1, 2
/// and 5 (ratio 2.5) follow the course of an accelerometer; within three times the frequency a resonance that is at 5 % at the upper point is at half a per cent at
/// the lower, and its course is not that of the two.
const FAR: f64 = 2.6;

/// Whether some of these frequencies lie within a gap of the certificate: one finding, the widest gap first.
pub fn reference_gap(
    table: Option<&ReferenceTable>,
    frequencies: impl IntoIterator<Item = f64>,
) -> Option<Finding> {
    let table = table?;
    let mut gaps: Vec<([f64; 2], Vec<f64>)> = Vec::new();
    for frequency in ascending(frequencies) {
        let far = |ends: &[f64; 2]| ends[1] / ends[0] > FAR;
        let Some(ends) = table.neighbours(frequency).filter(far) else {
            continue;
        };
        match gaps.iter_mut().find(|g| g.0 == ends) {
            Some(gap) => gap.1.push(frequency),
            None => gaps.push((ends, vec![frequency])),
        }
    }
    gaps.sort_by(|a, b| (b.0[1] / b.0[0]).total_cmp(&(a.0[1] / a.0[0])));
    let ([low, high], within) = gaps.first()?;
    let list = |of: &[f64]| {
        let names: Vec<String> = of.iter().map(f64::to_string).collect();
        names.join(", ")
    };
    let others = gaps[1..].iter().map(|(ends, within)| {
        let [low, high] = ends;
        format!("; {} Hz between {low} Hz and {high} Hz", list(within))
    });
    let largest = within
        .iter()
        .map(|f| table.interpolation_at(*f)[0])
        .fold(0.0, f64::max);
    Some(findings::reference_gap(
        *low,
        *high,
        &list(within),
        high / low,
        100.0 * largest,
        &others.collect::<String>(),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_dynamic::reference_table::ReferencePoint;

    #[test]
    fn known_gap_of_a_certificate() {
        let table = |frequencies: &[f64]| {
            let point = |&frequency: &f64| ReferencePoint {
                frequency,
                sensitivity: 0.01,
                phase: 0.0,
                modulus_uncertainty: 0.002,
                phase_uncertainty: 0.001,
            };
            ReferenceTable::new(frequencies.iter().map(point).collect()).unwrap()
        };
        let far = table(&[10.0, 630.0]);
        let found = reference_gap(Some(&far), [10.0, 160.0, 630.0]).unwrap();
        assert_eq!(found.code(), "reference-gap");
        assert!(found.what().contains("10 Hz") && found.what().contains("630 Hz"));
        assert!(found.evidence_text().contains("160"), "{found:?}");
        assert!(reference_gap(Some(&far), [10.0, 630.0, 10.0005]).is_none());
        // Octaves, and one, two and five, are no gaps.
        let near = table(&[10.0, 20.0, 50.0, 100.0, 200.0]);
        assert!(reference_gap(Some(&near), [15.0, 30.0, 160.0]).is_none());
        assert!(reference_gap(None, [160.0]).is_none());
    }
}

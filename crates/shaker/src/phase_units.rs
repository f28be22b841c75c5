//! Phases of one of two channels that are radians and were declared as degrees.

use crate::findings;
use crate::single_axis::ComparisonRow;
use num_complex::Complex64;
use proofmass_uncertainty::Finding;
use std::f64::consts::PI;

/// Fewest runs from which something is said.
const FEWEST: usize = 4;
/// Spread of the differences of two phases, rad, below which nobody asks, and how much smaller it has to be as radians.
const SPREAD: (f64, f64) = (0.35, 0.1);

/// Largest phase that radians have when they are read as degrees, rad, with grace for rounding.
const LARGEST: f64 = 1.01 * PI * PI / 180.0;

/// Whether phases of which this is the largest, rad, may be radians that were declared as degrees.
pub(crate) fn may_be_radians(largest: f64) -> bool {
    (0.3 * LARGEST..=LARGEST).contains(&largest)
}

/// Output or reference whose phases all lie within ±π degrees while those of the other do not, and whose differences agree ten times
/// better when they are read as radians. Where the other has one phase in all runs, 0 mostly, nothing can be said.
pub(crate) fn phase_units(rows: &[ComparisonRow]) -> Option<Finding> {
    if rows.len() < FEWEST {
        return None;
    }
    let largest = |of: fn(&ComparisonRow) -> Complex64| {
        let all = rows.iter().map(|r| of(r).arg().abs());
        all.fold(0.0, f64::max)
    };
    let spread = |units: [f64; 2]| {
        let differences = rows
            .iter()
            .map(|r| Complex64::cis(units[1] * r.output.arg() - units[0] * r.reference.arg()));
        let all: Vec<Complex64> = differences.collect();
        let mean: Complex64 = all.iter().sum();
        let off = all.iter().map(|z| (z * mean.conj()).arg().abs());
        off.fold(0.0, f64::max)
    };
    let radians = 1f64.to_degrees();
    let as_given = spread([1.0; 2]);
    let of = |own: fn(&ComparisonRow) -> Complex64,
              other: fn(&ComparisonRow) -> Complex64,
              units,
              name| {
        let small = may_be_radians(largest(own)) && largest(other) > 5.0 * LARGEST;
        let as_radians = spread(units);
        (small && as_given > SPREAD.0 && as_radians < SPREAD.1 * as_given).then(|| {
            findings::radians_as_degrees(
                name,
                &format!(
                    "none of the {} exceeds {:.2}°; the phase between output and reference spreads by ±{:.0}° as declared and ±{:.1}° as radians",
                    rows.len(),
                    largest(own).to_degrees(),
                    as_given.to_degrees(),
                    as_radians.to_degrees()
                ),
                "declare this phase column in radians (_rad) and calibrate again",
            )
        })
    };
    let output = |r: &ComparisonRow| r.output;
    let reference = |r: &ComparisonRow| r.reference;
    of(output, reference, [1.0, radians], "phases of the output")
        .or_else(|| of(reference, output, [radians, 1.0], "phases of the reference"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Runs that were recorded from any phase on, with a device 3° behind that turns with frequency.
    fn rows(seed: u64, spoil: impl Fn(&mut ComparisonRow)) -> Vec<ComparisonRow> {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
        (0..12)
            .map(|k| {
                let start = rng.random_range(-PI..PI);
                let lag = 0.05 + 0.02 * f64::from(k);
                let mut row = ComparisonRow {
                    run: k.to_string(),
                    frequency: 10.0 * f64::from(1 + k),
                    reference: Complex64::from_polar(0.1, start),
                    output: Complex64::from_polar(0.2, start - lag),
                    transverse: None,
                    covariance: [[0.0; 3]; 2],
                };
                spoil(&mut row);
                row
            })
            .collect()
    }

    fn read(z: Complex64) -> Complex64 {
        Complex64::from_polar(z.norm(), z.arg().to_radians())
    }

    #[test]
    fn known_channel_in_radians() {
        let output = phase_units(&rows(1, |r| r.output = read(r.output))).unwrap();
        assert_eq!(output.code(), "radians-as-degrees");
        assert!(output.what().contains("phases of the output"));
        let reference = phase_units(&rows(2, |r| r.reference = read(r.reference))).unwrap();
        assert!(reference.what().contains("phases of the reference"));
        for seed in 0..1000 {
            assert!(phase_units(&rows(seed, |_| ())).is_none(), "{seed}");
            // Phases that count from the reference say nothing.
            let against = |r: &mut ComparisonRow| {
                r.output = read(r.output * r.reference.conj());
                r.reference = Complex64::from(r.reference.norm());
            };
            assert!(phase_units(&rows(seed, against)).is_none(), "{seed}");
        }
    }
}

//! Repeats that are copies: two readings of one frequency that agree to the last of many digits.

use crate::findings;
use crate::single_axis::ComparisonRow;
use num_complex::Complex64;
use proofmass_uncertainty::Finding;

/// Relative difference below which two readings are one and the same number.
const SAME: f64 = 1e-9;
/// Significant digits beyond which two readings never agree by chance: they scatter by 10⁻⁴ of their size or more, so that one pair
/// of a thousand agrees in modulus to seven digits, and fewer in the phase as well.
const DIGITS: i32 = 6;

/// Readings among `repeats` (positions of one frequency) that are the same in reference and output, digit by digit. Of readings of
/// six digits or fewer nothing is said: such repeats agree by chance.
pub(crate) fn copies(rows: &[ComparisonRow], repeats: &[usize]) -> Vec<Finding> {
    let mut found = Vec::new();
    for (place, &second) in repeats.iter().enumerate() {
        let b = &rows[second];
        let mut before = repeats[..place].iter().map(|&first| &rows[first]);
        let copied = before.find(|a| same(a.reference, b.reference) && same(a.output, b.output));
        if let Some(a) = copied.filter(|_| is_fine(b.output)) {
            found.push(findings::copied_run(
                &format!(
                    "run {} has the readings of run {}, digit by digit",
                    b.run, a.run
                ),
                &format!("reference and output at {} Hz, within 1e-9", b.frequency),
            ));
        }
    }
    found
}

fn same(a: Complex64, b: Complex64) -> bool {
    (a - b).norm() <= SAME * a.norm()
}

/// Whether modulus or phase (degrees, as it is typed) have more digits than [`DIGITS`].
fn is_fine(reading: Complex64) -> bool {
    [reading.norm(), reading.arg().to_degrees()]
        .into_iter()
        .filter(|x| *x != 0.0)
        .any(|x| {
            let step = 10f64.powi(x.abs().log10().floor() as i32 + 1 - DIGITS);
            ((x / step).round() * step - x).abs() > SAME * x.abs()
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(run: &str, modulus: f64, degrees: f64) -> ComparisonRow {
        ComparisonRow {
            run: run.to_owned(),
            frequency: 160.0,
            reference: Complex64::new(0.102, 0.0),
            output: Complex64::from_polar(modulus, degrees.to_radians()),
            transverse: None,
            covariance: [[0.0; 3]; 2],
        }
    }

    #[test]
    fn known_copies_are_told_by_their_digits() {
        let fine = [
            row("a", 0.099_983_333_3, -0.116_666_67),
            row("b", 0.099_966_666_7, -0.08),
            row("c", 0.099_983_333_3, -0.116_666_67),
        ];
        let found = copies(&fine, &[0, 1, 2]);
        assert_eq!(found.len(), 1);
        assert!(found[0].what().contains("run c has the readings of run a"));
        assert!(copies(&fine, &[0, 1]).is_empty());
        // Four digits agree by chance.
        let coarse = [row("a", 0.099_98, -0.12), row("b", 0.099_98, -0.12)];
        assert!(copies(&coarse, &[0, 1]).is_empty());
    }
}

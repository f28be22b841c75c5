//! Runs that are copies: two readings of one frequency that agree to the last of many digits.

use crate::findings;
use crate::screening::told_once;
use num_complex::Complex64;
use proofmass_uncertainty::Finding;

/// Relative difference below which two readings are one and the same number.
const SAME: f64 = 1e-9;
/// Significant digits beyond which two readings never agree by chance: they scatter by 10⁻⁴ of their size or more, so that one pair
/// of a thousand agrees in modulus to seven digits, and fewer in the phase as well.
const DIGITS: i32 = 6;

/// What was read in one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading<'a> {
    run: &'a str,
    frequency: f64,
    phasors: Vec<Complex64>,
    place: String,
}

impl<'a> Reading<'a> {
    /// The reference and then the outputs.
    pub fn new(run: &'a str, frequency: f64, phasors: &[Complex64]) -> Self {
        Self {
            run,
            frequency,
            phasors: phasors.to_vec(),
            place: String::new(),
        }
    }

    /// Only readings at one place are compared.
    #[must_use]
    pub fn at(self, place: String) -> Self {
        Self { place, ..self }
    }

    fn is_copy_of(&self, other: &Self) -> bool {
        let all = || self.phasors.iter().zip(&other.phasors);
        self.frequency == other.frequency
            && self.place == other.place
            && self.phasors.len() == other.phasors.len()
            && all().all(|(a, b)| same(*a, *b))
            && self.phasors.iter().skip(1).any(|z| is_fine(*z))
    }
}

/// Readings that are those of one before them, digit by digit. Of readings of six digits or fewer nothing is said: such repeats agree by
/// chance.
pub fn copies(readings: &[Reading<'_>]) -> Vec<Finding> {
    let mut sorted: Vec<usize> = (0..readings.len()).collect();
    let size = |i: usize| {
        let r = &readings[i];
        (r.frequency, r.phasors.first().map_or(0.0, |z| z.norm()))
    };
    sorted.sort_by(|&a, &b| {
        let (a, b) = (size(a), size(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (place, &second) in sorted.iter().enumerate() {
        // Sorted by frequency and reference, copies are near.
        let near = sorted[..place].iter().rev().take_while(|&&first| {
            let (a, b) = (size(first), size(second));
            a.0 == b.0 && b.1 - a.1 <= SAME * b.1
        });
        let mut before: Vec<usize> = near.copied().collect();
        before.sort_unstable();
        let copied = before
            .into_iter()
            .find(|&first| readings[second].is_copy_of(&readings[first]));
        pairs.extend(copied.map(|first| (first.min(second), first.max(second))));
    }
    pairs.sort_unstable();
    let about = |&(a, b): &(usize, usize)| {
        let (a, b) = (&readings[a], &readings[b]);
        findings::copied_run(
            &format!(
                "run {} has the readings of run {}, digit by digit",
                b.run, a.run
            ),
            &format!("reference and output at {} Hz, within 1e-9", b.frequency),
        )
    };
    told_once(
        pairs
            .iter()
            .map(|pair| (readings[pair.1].run, about(pair)))
            .collect(),
    )
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

    fn reading(run: &str, modulus: f64, degrees: f64) -> Reading<'_> {
        let output = Complex64::from_polar(modulus, degrees.to_radians());
        Reading::new(run, 160.0, &[Complex64::new(0.102, 0.0), output])
    }

    #[test]
    fn known_copies_are_told_by_their_digits() {
        let fine = [
            reading("a", 0.099_983_333_3, -0.116_666_67),
            reading("b", 0.099_966_666_7, -0.08),
            reading("c", 0.099_983_333_3, -0.116_666_67),
        ];
        let found = copies(&fine);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].code(), "copied-run");
        assert!(found[0].what().contains("run c has the readings of run a"));
        assert!(copies(&fine[..2]).is_empty());
        // Four digits agree by chance.
        let coarse = [reading("a", 0.099_98, -0.12), reading("b", 0.099_98, -0.12)];
        assert!(copies(&coarse).is_empty());
        // A table that is there twice is told once.
        let names: Vec<String> = (0..20).map(|i| format!("r{i}")).collect();
        let twice: Vec<Reading<'_>> = (0..20)
            .map(|i| {
                reading(
                    &names[i],
                    0.1 + 1.234_567_8e-5 * (i % 10) as f64,
                    0.123_456_78,
                )
            })
            .collect();
        let found = copies(&twice);
        assert_eq!(found.len(), 1);
        assert!(found[0].evidence_text().contains("r19"), "{found:?}");
    }
}

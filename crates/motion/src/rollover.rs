//! Counters and angles that begin anew after their range.

use proofmass_uncertainty::{Finding, Severity};

/// Values continued over every step of more than half a range.
pub fn continued(values: &[f64], range: f64) -> Vec<f64> {
    let mut turns = 0.0;
    let mut last = None::<f64>;
    values
        .iter()
        .map(|&v| {
            if let Some(last) = last {
                turns -= ((v - last) / range).round();
            }
            last = Some(v);
            v + turns * range
        })
        .collect()
}

/// The first step that a range makes as small as its neighbours: values within one range, steps of more than half of it, and
/// none of these, taken round the other way, beyond twice the largest of the others.
fn begins_anew(values: &[f64], range: f64) -> Option<usize> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let unsigned = low >= 0.0 && high <= range;
    let signed = low >= -0.5 * range && high <= 0.5 * range;
    if !(unsigned || signed) {
        return None;
    }
    let steps = || values.windows(2).map(|w| w[1] - w[0]);
    let first = steps().position(|d| d.abs() > 0.5 * range)?;
    let plain = steps().filter(|d| d.abs() <= 0.5 * range);
    let largest = plain.fold(0.0f64, |m, d| m.max(d.abs()));
    let around = steps()
        .filter(|d| d.abs() > 0.5 * range)
        .fold(0.0f64, |m, d| m.max(range - d.abs()));
    (around <= 2.0 * largest && largest < 0.5 * range).then_some(first)
}

/// Jumps like those of a counter of 8 to 32 bits, in counts that were said not to roll over.
pub fn rollover(counts: &[i64]) -> Option<Finding> {
    let values: Vec<f64> = counts.iter().map(|c| *c as f64).collect();
    let (bits, k) =
        (8..=32).find_map(|bits| begins_anew(&values, 2f64.powi(bits)).map(|k| (bits, k)))?;
    Some(
        Finding::new(
            Severity::Decision,
            "rollover-suspected",
            format!("the count jumps like a counter of {bits} bits that rolls over"),
        )
        .evidence(format!("from {} to {}", counts[k], counts[k + 1]))
        .advice(format!("add --bits {bits}")),
    )
}

/// Jumps by a turn, in angles that were said to go on.
pub fn turns_anew(angle: &[f64], turn: f64) -> Option<Finding> {
    let k = begins_anew(angle, turn)?;
    Some(
        Finding::new(
            Severity::Decision,
            "rollover-suspected",
            "the angle begins anew after each turn",
        )
        .evidence(format!("from {} to {}", angle[k], angle[k + 1]))
        .advice("add --wraps"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_words_of_any_width_are_suspected_and_continued() {
        for bits in [8u32, 10, 12, 14, 16, 20, 24, 32] {
            let range = 1i64 << bits;
            let path: Vec<i64> = (0..2000).map(|k| range - 40 + k / 3).collect();
            for low in [0, -range / 2] {
                let words: Vec<i64> = path
                    .iter()
                    .map(|c| (c - low).rem_euclid(range) + low)
                    .collect();
                let found = rollover(&words).unwrap();
                assert!(
                    found.advice_text().contains(&format!("--bits {bits}")),
                    "{found}"
                );
                let words: Vec<f64> = words.iter().map(|w| *w as f64).collect();
                let all = continued(&words, range as f64);
                for (a, c) in all.iter().zip(&path) {
                    assert_eq!(a - all[0], (c - path[0]) as f64);
                }
            }
        }
    }

    #[test]
    fn law_angles_of_a_turn_are_suspected_and_jumps_of_another_kind_are_not() {
        let angle: Vec<f64> = (0..900)
            .map(|k| (0.7 * f64::from(k)).rem_euclid(360.0))
            .collect();
        assert!(turns_anew(&angle, 360.0).is_some());
        let one_turn: Vec<f64> = (0..500).map(|k| 0.7 * f64::from(k)).collect();
        assert!(turns_anew(&one_turn, 360.0).is_none());
        // A glitch, a step of the axis, a reversing path.
        let mut glitch: Vec<i64> = (0..300).collect();
        glitch[150] = 4000;
        assert!(rollover(&glitch).is_none());
        let step: Vec<i64> = (0..200)
            .map(|k| if k < 100 { k / 10 } else { 200 + k / 10 })
            .collect();
        assert!(rollover(&step).is_none());
        let sine: Vec<i64> = (0..5000)
            .map(|k| (2000.0 * (0.003 * f64::from(k)).sin()) as i64)
            .collect();
        assert!(rollover(&sine).is_none());
        assert!(rollover(&[]).is_none() && rollover(&[1]).is_none());
    }
}

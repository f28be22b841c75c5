//! Counters and angles that begin anew after their range.

use crate::findings;
use proofmass_uncertainty::Finding;

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

/// Jumps like those of a counter of 8 to 32 bits, in counts that were said not to roll over, or as those of `stated` bits.
pub fn rollover(counts: &[i64], stated: Option<u32>) -> Option<Finding> {
    let values: Vec<f64> = counts.iter().map(|c| *c as f64).collect();
    // What a range of the stated width explains is continued; a smaller one is not.
    let mut widths = 8..stated.unwrap_or(33);
    let (bits, k) =
        widths.find_map(|bits| begins_anew(&values, f64::from(bits).exp2()).map(|k| (bits, k)))?;
    let instead = stated.map_or(String::new(), |n| format!(", not {n}"));
    Some(findings::rollover_suspected(
        &format!("count jumps like a counter of {bits} bits that rolls over{instead}"),
        counts[k] as f64,
        counts[k + 1] as f64,
        &format!("state the width of the counter: --bits {bits}{instead}"),
    ))
}

/// Jumps by a turn, in angles that were said to go on.
pub fn turns_anew(angle: &[f64], turn: f64) -> Option<Finding> {
    let k = begins_anew(angle, turn)?;
    Some(findings::rollover_suspected(
        "angle starts again after each turn",
        angle[k],
        angle[k + 1],
        "state that the angle restarts after each turn: --wraps",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_width_is_told_whatever_is_stated() {
        let wide: Vec<i64> = (0..2000i64).map(|k| 3 * k - k * k / 400).collect();
        for bits in [8u32, 10, 12] {
            let range = 1i64 << bits;
            let unsigned: Vec<i64> = wide.iter().map(|c| c.rem_euclid(range)).collect();
            let signed: Vec<i64> = unsigned
                .iter()
                .map(|c| if *c < range / 2 { *c } else { *c - range })
                .collect();
            for counts in [&unsigned, &signed] {
                for stated in [None, Some(bits + 1), Some(16), Some(32)] {
                    let found = rollover(counts, stated).expect("a jump");
                    assert!(found.advice_text().contains(&format!("--bits {bits}")));
                }
                assert_eq!(rollover(counts, Some(bits)), None, "{bits} bits");
            }
        }
        for stated in [None, Some(16)] {
            assert_eq!(rollover(&wide, stated), None);
        }
    }
}

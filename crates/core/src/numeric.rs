//! Small numerics that every room shares: sums of products, medians, a golden section.

/// Σ aᵢ bᵢ, from the first to the last.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The middle value, of an even number the upper of the two; reorders the values. `None` of none.
pub fn upper_median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The middle value, of an even number the mean of the two; reorders the values. `None` of none.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let n = values.len();
    let upper = upper_median(values)?;
    if n % 2 == 1 {
        return Some(upper);
    }
    let lower = values[..n / 2]
        .iter()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    Some(0.5 * (lower + upper))
}

/// (√5 − 1)/2.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Narrows a stretch around the one extreme of a function by golden sections: `better` tells whether the first of two places is, and
/// `goes_on` whether another step is wanted after so many, with the width that is left.
///
/// # Errors
/// Those of `better`.
pub fn golden_section<E>(
    [mut low, mut high]: [f64; 2],
    goes_on: impl Fn(usize, f64) -> bool,
    mut better: impl FnMut(f64, f64) -> Result<bool, E>,
) -> Result<f64, E> {
    let mut steps = 0;
    while goes_on(steps, high - low) {
        let (a, b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        if better(a, b)? {
            high = b;
        } else {
            low = a;
        }
        steps += 1;
    }
    Ok(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_medians() {
        assert_eq!(upper_median(&mut [3.0, 1.0, 2.0, 4.0]), Some(3.0));
        assert_eq!(median(&mut [3.0, 1.0, 2.0, 4.0]), Some(2.5));
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut []), None);
    }

    #[test]
    fn known_section_of_a_parabola() {
        assert_eq!(GOLDEN, 0.5 * (5f64.sqrt() - 1.0));
        let f = |x: f64| (x - 0.3).powi(2);
        let found = golden_section([0.0, 1.0], |k, _| k < 60, |a, b| Ok::<_, ()>(f(a) < f(b)));
        assert!((found.unwrap() - 0.3).abs() < 1e-7);
    }
}

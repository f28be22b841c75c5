//! The part of a record worth a closer look.

use std::ops::Range;

/// Range of samples in which a velocity changes most, some three swings long.
///
/// The length is three mean periods of the crossings of the mean, between 20 samples and a quarter of the record;
/// the place is that of the largest Σ (v_{k+1} − v_k)², which follows the acceleration's power.
pub fn excerpt(velocity: &[f64]) -> Range<usize> {
    let n = velocity.len();
    if n < 80 {
        return 0..n;
    }
    let mean = velocity.iter().sum::<f64>() / n as f64;
    let crossings = velocity
        .windows(2)
        .filter(|w| (w[0] - mean) * (w[1] - mean) < 0.0)
        .count();
    let period = 2 * n / crossings.max(1);
    let length = (3 * period).clamp(20, n / 4);
    let power: Vec<f64> = velocity.windows(2).map(|w| (w[1] - w[0]).powi(2)).collect();
    let mut sum: f64 = power[..length].iter().sum();
    let (mut best, mut from) = (sum, 0);
    for k in length..power.len() {
        sum += power[k] - power[k - length];
        if sum > best {
            (best, from) = (sum, k + 1 - length);
        }
    }
    from..from + length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_the_lively_part_is_found() {
        let v: Vec<f64> = (0..4000)
            .map(|k| {
                let t = f64::from(k);
                (-((t - 2500.0) / 200.0).powi(2)).exp() * (0.1 * t).sin()
            })
            .collect();
        let part = excerpt(&v);
        assert!(part.contains(&2500) && part.len() < 1000, "{part:?}");
        assert_eq!(excerpt(&v[..50]), 0..50);
    }
}

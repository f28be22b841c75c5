//! Sensors of a speed: the step of their digits, and the speed below which they read zero.

use crate::findings;
use proofmass_uncertainty::Finding;

/// Step of the digits in which a speed was logged, where all its changes are multiples of one.
///
/// Steps of a millionth of the largest speed are digits of a number, not of a sensor.
pub fn speed_increment(speeds: &[f64]) -> Option<f64> {
    let largest = speeds.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let steps = || {
        speeds
            .windows(2)
            .map(|w| (w[1] - w[0]).abs())
            .filter(|d| *d > 1e-12 * largest)
    };
    let holds = |step: f64| {
        let off =
            |d: f64| (d / step - (d / step).round()).abs() > 1e-3 * (d / step).max(1.0).sqrt();
        step.is_finite() && step > 1e-6 * largest && !steps().any(off)
    };
    let least = steps().fold(f64::INFINITY, f64::min);
    // A motion of few different speeds may have none that lie one step apart.
    let common = || steps().fold(least, common_step);
    Some(least)
        .filter(|s| holds(*s))
        .or_else(|| Some(common()).filter(|s| holds(*s)))
}

/// The largest step of which both are multiples, to a thousandth (Euclid).
fn common_step(a: f64, b: f64) -> f64 {
    let (mut a, mut b) = (a.max(b), a.min(b));
    while b > 1e-3 * a {
        (a, b) = (b, (a - (a / b).round() * b).abs());
    }
    a
}

/// Time around a stop in which readings of zero say little, s.
const AROUND: f64 = 1.5;
/// Increments by which the first reading stands off zero where there is a threshold.
const FIRST: f64 = 5.0;

/// Takes the zeros next to a motion away where the sensor reads zero below a speed: they say "slower than that", not zero.
///
/// There is such a speed where the smallest reading that is not zero is more than five increments. A stop keeps the zeros
/// that are 1.5 s and more away from the motion; zeros amid a fast motion are no stop and stay.
pub fn leave_out_threshold(time: &mut Vec<f64>, speed: &mut Vec<f64>) -> Option<Finding> {
    let n = speed.len();
    let increment = speed_increment(speed)?;
    let zero: Vec<usize> = (0..n).filter(|&i| speed[i] == 0.0).collect();
    let sizes = speed.iter().map(|v| v.abs()).filter(|v| *v > 0.0);
    let first = sizes.fold(f64::INFINITY, f64::min);
    if zero.is_empty() || time.len() != n || !first.is_finite() || first <= FIRST * increment {
        return None;
    }
    let mut keep = vec![true; n];
    for run in zero.chunk_by(|a, b| a + 1 == *b) {
        let before = run[0].checked_sub(1);
        let after = Some(run[run.len() - 1] + 1).filter(|i| *i < n);
        let fast = |i: Option<usize>| i.is_some_and(|i| speed[i].abs() > FIRST * first);
        if fast(before) || fast(after) {
            continue;
        }
        for &i in run {
            let near =
                |edge: Option<usize>| edge.is_some_and(|e| (time[i] - time[e]).abs() < AROUND);
            keep[i] = !(near(before) || near(after));
        }
    }
    let left = keep.iter().filter(|k| !**k).count();
    let kept = |values: &[f64]| -> Vec<f64> {
        let pairs = values.iter().zip(&keep).filter(|(_, keep)| **keep);
        pairs.map(|(v, _)| *v).collect()
    };
    (*time, *speed) = (kept(time), kept(speed));
    (left > 0).then(|| findings::speed_threshold(first, left, n, AROUND))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_step_of_digits_that_no_two_speeds_are_apart() {
        // 250 samples a period, read in hundredths of a km/h: neighbouring values differ by two and three steps and more.
        let speeds = |frequency: f64| -> Vec<f64> {
            let at = |k: i32| {
                10.0 + 6.0 * (std::f64::consts::TAU * frequency * 0.01 * f64::from(k)).sin()
            };
            (0..1000).map(|k| (at(k) * 360.0).round() / 360.0).collect()
        };
        for frequency in [0.4, 0.5, 0.25] {
            let found = speed_increment(&speeds(frequency)).unwrap();
            assert!(
                (found * 360.0 - 1.0).abs() < 1e-6,
                "{frequency} Hz: {found}"
            );
        }
        let mut noisy = speeds(0.4);
        for (k, v) in noisy.iter_mut().enumerate() {
            *v += 1e-4 * (k as f64 * 1.618).fract();
        }
        assert_eq!(speed_increment(&noisy), None);
    }

    /// Drives, brakes to a stop at 10 s, waits and drives on at 20 s.
    fn record(threshold: f64) -> (Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..3000).map(|k| 0.01 * f64::from(k)).collect();
        let speed = |t: &f64| (10.0 - t).max(t - 20.0).max(0.0);
        let read = |v: f64| {
            if v < threshold {
                0.0
            } else {
                (100.0 * v).round() / 100.0
            }
        };
        let speeds = time.iter().map(|t| read(speed(t))).collect();
        (time, speeds)
    }

    #[test]
    fn law_zeros_next_to_a_motion_are_left_out_where_there_is_a_threshold() {
        let (mut time, mut speed) = record(0.5);
        let finding = leave_out_threshold(&mut time, &mut speed).unwrap();
        assert!(finding.evidence_text().contains("0.5000"), "{finding:?}");
        // Zero from 9.505 s to 20.495 s; 1.5 s at either end are gone.
        let inside = |t: &&f64| (9.51..10.98).contains(*t) || (19.02..20.49).contains(*t);
        assert_eq!(time.iter().filter(inside).count(), 0);
        assert!((2698..2704).contains(&time.len()), "{}", time.len());
        assert_eq!(time.len(), speed.len());
        let (mut time, mut speed) = record(0.0);
        assert!(leave_out_threshold(&mut time, &mut speed).is_none());
        // A reading that drops out amid the motion is another matter.
        let (mut time, mut speed) = record(0.5);
        speed[100] = 0.0;
        leave_out_threshold(&mut time, &mut speed);
        assert_eq!((time[100], speed[100]), (1.0, 0.0));
    }

    #[test]
    fn law_the_step_of_logged_digits() {
        let wave: Vec<f64> = (0..500)
            .map(|k| 15.0 + 9.0 * (0.02 * f64::from(k)).sin())
            .collect();
        let logged =
            |step: f64| -> Vec<f64> { wave.iter().map(|v| (v / step).round() * step).collect() };
        for step in [0.01, 0.03125 / 3.6, 0.1 / 3.6] {
            let found = speed_increment(&logged(step)).unwrap();
            assert!((found / step - 1.0).abs() < 1e-6, "{found} {step}");
        }
        assert!(speed_increment(&wave).is_none());
    }
}

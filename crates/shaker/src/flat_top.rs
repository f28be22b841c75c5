//! Amplifiers that give out below the limit of the converter: a sine with a flat top.

use num_complex::Complex64;
use proofmass_signal::sine::ChannelSine;
use std::f64::consts::PI;

/// Third harmonic, over the fundamental, below which a flat top is no matter: 0.3 % takes 0.3 % of the fundamental.
const LEAST: f64 = 3e-3;
/// Departure of the third and the fifth harmonic from those of a flat top, over the third.
const ALIKE: f64 = 0.15;
/// Standard uncertainties by which the third harmonic must stand out of the noise.
const SEEN: f64 = 8.0;

/// First, third and fifth harmonic of a cosine of amplitude one that is cut off at ±ρ.
fn harmonics(level: f64) -> [f64; 3] {
    let end = level.clamp(0.0, 1.0).acos();
    [1.0, 3.0, 5.0].map(|n: f64| {
        // What is cut off, by Simpson's rule: smooth, and zero at the end.
        const STEPS: usize = 64;
        let cut = |i: usize| {
            let t = end * i as f64 / STEPS as f64;
            (t.cos() - level) * (n * t).cos()
        };
        let sum: f64 = (0..=STEPS)
            .map(|i| match i {
                0 | STEPS => cut(i),
                i if i % 2 == 1 => 4.0 * cut(i),
                i => 2.0 * cut(i),
            })
            .sum();
        f64::from(n == 1.0) - 4.0 / PI * sum * end / (3.0 * STEPS as f64)
    })
}

/// The part of its fundamental that an output has lost by a flat top, by the third and fifth harmonic in phase with it;
/// `None` where there is none, or where the excitation has such a harmonic itself.
pub(super) fn lost(output: &ChannelSine, reference: &ChannelSine, samples: usize) -> Option<f64> {
    let relative = |c: &ChannelSine, k: usize| -> Option<Complex64> {
        let first = c.amplitude;
        let turn = (first / first.norm()).powu(k as u32);
        Some(c.harmonics.get(k.checked_sub(2)?)? / turn / first.norm())
    };
    let (second, third, fifth) = (
        relative(output, 2)?,
        relative(output, 3)?,
        relative(output, 5)?,
    );
    let size = third.norm();
    let noise = output.residual_rms * (2.0 / samples as f64).sqrt() / output.modulus();
    let own = relative(reference, 3)?.norm();
    let plain = size > LEAST
        && size > SEEN * noise
        && third.re < 0.0
        && third.im.abs() < ALIKE * size
        && second.norm() < 0.5 * size
        && own < 0.2 * size;
    if !plain {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let level = 0.5 * (low + high);
        let [a, b, _] = harmonics(level);
        if -b / a > size {
            low = level;
        } else {
            high = level;
        }
    }
    let [first, _, expected] = harmonics(low);
    ((fifth - expected / first).norm() < ALIKE * size).then_some(1.0 - first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_signal::sine::SineApproximation;

    fn recorded(shape: impl Fn(f64) -> f64) -> ChannelSine {
        let x: Vec<f64> = (0..4096)
            .map(|i| shape(0.11 * f64::from(i) + 0.4))
            .collect();
        let fit = SineApproximation::new(0.11 / (2.0 * PI)).harmonics(5);
        fit.fit(1.0, &[&x]).unwrap().channels.remove(0)
    }

    #[test]
    fn known_harmonics_of_a_square_wave_and_of_a_clipped_cosine() {
        // ρ → 0: ρ times a square wave, 4/π (1, −1/3, 1/5).
        let [a, b, c] = harmonics(1e-6);
        assert!((b / a + 1.0 / 3.0).abs() < 1e-4 && (c / a - 0.2).abs() < 1e-4);
        assert!((harmonics(0.5)[0] - 0.608_998).abs() < 1e-6);
    }

    #[test]
    fn law_a_flat_top_is_told_from_other_distortion() {
        let clean = recorded(f64::cos);
        for level in [0.95, 0.8, 0.4] {
            let flat = recorded(|t| t.cos().clamp(-level, level));
            let found = lost(&flat, &clean, 4096).expect("flat");
            assert!(
                (found - (1.0 - harmonics(level)[0])).abs() < 2e-3,
                "{level}: {found}"
            );
        }
        // A cubic device, one that saturates in one direction, and an excitation that is flat itself.
        let cubic = recorded(|t| t.cos() - 0.05 * t.cos().powi(3));
        assert_eq!(lost(&cubic, &clean, 4096), None);
        let lopsided = recorded(|t| t.cos().min(0.8));
        assert_eq!(lost(&lopsided, &clean, 4096), None);
        let flat = recorded(|t| t.cos().clamp(-0.9, 0.9));
        assert_eq!(lost(&flat, &flat, 4096), None);
        assert_eq!(lost(&clean, &clean, 4096), None);
    }
}

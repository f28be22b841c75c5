//! Method 2 of ISO 16063-11: the amplitude of a vibration at a zero of the Bessel function J₁.

use std::f64::consts::PI;

/// Distance from a zero, rad, up to which J₁ tells the amplitude well.
const NEAR: f64 = 0.7;
/// Largest phase amplitude, rad, up to which a zero is not lost among many.
const LARGEST: f64 = 60.0;

/// Phase amplitude of a vibration near a zero of J₁ by the component of the interference at the drive, and its standard uncertainty.
///
/// The component of sin(φ̂ cos Ωt) at Ω is 2 J₁(φ̂): it vanishes at φ̂ = 3.8317, 7.0156 … wherever the amplifier stands, which is the
/// minimum point. `component` is that component with its sign and `u` its standard uncertainty; `about` tells at which zero. `None`
/// where no zero is within 0.7 rad, or `about` is above 60 rad.
///
/// **Source** `[ISO16063-11]` method 2.
///
/// ```
/// use proofmass_shaker::interferometer::minimum_point;
/// let (amplitude, u) = minimum_point(0.0, 1e-4, 3.9).unwrap();
/// assert!((amplitude - 3.831_705_970_2).abs() < 1e-9);
/// // J₀(3.8317) = −0.4028.
/// assert!((u - 1e-4 / (2.0 * 0.402_759_4)).abs() < 1e-10);
/// assert!(minimum_point(0.0, 1e-4, 5.3).is_none());
/// ```
pub fn minimum_point(component: f64, u: f64, about: f64) -> Option<(f64, f64)> {
    if !(1.0..=LARGEST).contains(&about) {
        return None;
    }
    // McMahon's first terms, then Newton's steps; J₁′ = J₀ at a zero.
    let order = ((about / PI) - 0.25).round().max(1.0);
    let beta = (order + 0.25) * PI;
    let mut zero = beta - 3.0 / (8.0 * beta);
    for _ in 0..6 {
        zero -= libm::j1(zero) / slope(zero);
    }
    if (about - zero).abs() > NEAR {
        return None;
    }
    let mut amplitude = zero;
    for _ in 0..50 {
        let step = (libm::j1(amplitude) - 0.5 * component) / slope(amplitude);
        amplitude -= step;
        if !((amplitude - zero).abs() < PI / 2.0) {
            return None;
        }
        if step.abs() < 1e-14 * amplitude {
            break;
        }
    }
    Some((amplitude, 0.5 * u / slope(amplitude).abs()))
}

/// J₁′(x) = J₀(x) − J₁(x)/x.
fn slope(x: f64) -> f64 {
    libm::j0(x) - libm::j1(x) / x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Zeros of J₁ [Abramowitz and Stegun, table 9.5].
    #[test]
    fn published_zeros_of_j1() {
        for zero in [3.831_705_97, 7.015_586_67, 10.173_468_14, 13.323_691_94] {
            let (amplitude, _) = minimum_point(0.0, 1e-6, zero + 0.3).unwrap();
            assert!((amplitude - zero).abs() < 5e-9, "{amplitude}");
            // Beside the zero the amplitude comes from J₁ itself.
            let beside = zero - 0.4;
            let (amplitude, _) = minimum_point(2.0 * libm::j1(beside), 1e-6, beside).unwrap();
            assert!((amplitude - beside).abs() < 1e-9);
        }
    }
}

//! Method 1 of ISO 16063-11: the amplitude of a vibration by the fringes in its periods.

use std::f64::consts::FRAC_1_SQRT_2;

/// Distance from the middle that a signal has to reach before the next crossing counts, relative to its amplitude: noise counts none.
const HYSTERESIS: f64 = 0.3;

/// Amplitude of a vibration in wavelengths by the number of its fringes, R/8 with R fringes in a period, and its standard
/// uncertainty; `None` for a record of less than one period or of less than eight fringes a period.
///
/// `cosine` is one of the two quadrature signals on a circle of radius one. A fringe begins anywhere, so that a half swing counts up to
/// one crossing too many or too few: u is that of the triangle, undiminished by the number of periods, for a motion that stands still
/// counts the same in each.
///
/// **Source** `[ISO16063-11]` method 1.
///
/// ```
/// use proofmass_shaker::interferometer::count_fringes;
/// // 40 wavelengths: φ = 4π · 40 cos.
/// let turn = std::f64::consts::TAU;
/// let signal: Vec<f64> = (0..200_000)
///     .map(|k| (2.0 * turn * 40.0 * (turn * f64::from(k) / 20_000.0).cos()).cos())
///     .collect();
/// let (amplitude, u) = count_fringes(&signal, 20_000.0).unwrap();
/// assert!((amplitude - 40.0).abs() < 2.0 * u && u < 0.06);
/// ```
pub fn count_fringes(cosine: &[f64], samples_per_period: f64) -> Option<(f64, f64)> {
    let periods = (cosine.len() as f64 / samples_per_period).floor();
    if !(periods >= 1.0) {
        return None;
    }
    let whole = (periods * samples_per_period) as usize;
    let (mut crossings, mut side) = (0usize, 0.0);
    for v in &cosine[..whole.min(cosine.len())] {
        if v.abs() > HYSTERESIS {
            if v * side < 0.0 {
                crossings += 1;
            }
            side = v.signum();
        }
    }
    let fringes = 0.5 * crossings as f64 / periods;
    // A half swing has a quarter of an eighth of the fringes: one crossing is an eighth of a wavelength in the amplitude.
    let u = 0.125 * FRAC_1_SQRT_2 / 3f64.sqrt();
    (fringes >= 8.0).then_some((fringes / 8.0, u))
}

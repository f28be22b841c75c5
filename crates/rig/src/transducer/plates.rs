//! Capacitance of plates.

/// ε₀, F/m. **Source** `[CODATA2018]`.
pub(super) const VACUUM: f64 = 8.854_187_812_8e-12;

/// Capacitance of parallel plates without their edges, F: ε₀ε_r A/d.
///
/// **Units** area in m², gap in m.
///
/// ```
/// use proofmass_rig::plate_capacitance;
/// assert!((plate_capacitance(1.0, 1e-6, 2e-6) / 4.427e-12 - 1.0).abs() < 1e-3);
/// ```
pub fn plate_capacitance(permittivity: f64, area: f64, gap: f64) -> f64 {
    VACUUM * permittivity * area / gap
}

/// Capacitance of a plate that turns as it comes nearer, over that at rest: with z = ux/(d − x), d/(d − x) · artanh(z)/z.
///
/// `tilt` is u: half the length of the plate by its rotation per displacement of its centre.
pub(super) fn tilting(x: f64, gap: f64, tilt: f64) -> f64 {
    let z = tilt * x / (gap - x);
    // artanh z/z by its series where the quotient loses digits.
    let form = match z.abs() < 1e-3 {
        true => 1.0 + z * z / 3.0 + z.powi(4) / 5.0,
        false => libm::atanh(z) / z,
    };
    gap / (gap - x) * form
}

//! A reference that was calibrated over frequency, as one number for a pulse.

use crate::trouble::{Result, Trouble};
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_uncertainty::{Finding, Severity};

/// A constant sensitivity over the band of a pulse, with what it leaves out.
pub(super) struct FlatStandard {
    /// V/(m/s²).
    pub(super) sensitivity: f64,
    /// Relative standard uncertainty: that of the calibration, and the spread of the modulus over the band.
    pub(super) relative_uncertainty: f64,
    /// A band that the calibration does not cover.
    pub(super) finding: Option<Finding>,
}

/// Frequencies at which the band is looked at.
const LOOKS: u32 = 200;

impl FlatStandard {
    /// Over the calibrated frequencies up to 2/τ, at which a half-sine of duration τ has a fifteenth of its spectrum at rest: the
    /// middle between the largest and the smallest modulus, half their distance as a rectangular uncertainty.
    pub(super) fn of(standard: &ReferenceTable, duration: f64) -> Result<Self> {
        let [first, last] = standard.range();
        let wanted = 2.0 / duration;
        let high = wanted.min(last);
        if high < first {
            return Err(Trouble::data(
                "the calibration of the reference begins above the band of the pulse",
            )
            .detail(format!(
                "it covers {first} Hz to {last} Hz; a pulse of {duration:.3e} s ends at {wanted:.0} Hz"
            ))
            .with_hint("have the reference calibrated at lower frequencies, or by shock"));
        }
        let (mut least, mut most, mut u) = (f64::INFINITY, 0.0f64, 0.0f64);
        for k in 0..=LOOKS {
            let f = first * (high / first).powf(f64::from(k) / f64::from(LOOKS));
            let point = standard.at(f.clamp(first, high))?;
            least = least.min(point.sensitivity);
            most = most.max(point.sensitivity);
            u = u.max(point.modulus_uncertainty);
        }
        let sensitivity = 0.5 * (least + most);
        let spread = 0.5 * (most - least) / sensitivity;
        // An integral looks at the lowest frequencies, a top at those about 1/τ.
        let missing = first > 0.1 / duration || last < wanted;
        let finding = missing.then(|| {
            Finding::new(
                Severity::Warning,
                "reference-out-of-range",
                "the calibration of the reference does not cover the band of the pulse",
            )
            .evidence(format!(
                "it covers {first:.1} Hz to {last:.1} Hz, the pulse reaches from rest to {wanted:.0} Hz; sensitivity {:.1} % apart within",
                200.0 * spread
            ))
            .advice("beyond its calibration the reference is taken as within; have it calibrated there, or by shock")
        });
        Ok(Self {
            sensitivity,
            relative_uncertainty: u.hypot(spread / 3f64.sqrt()),
            finding,
        })
    }
}

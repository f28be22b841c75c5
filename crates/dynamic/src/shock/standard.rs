//! A reference that was calibrated over frequency, as one number for a pulse.

use crate::reference_table::ReferenceTable;
use proofmass_core::Error;

/// A constant sensitivity over the band of a pulse, with what it leaves out.
#[non_exhaustive]
pub struct FlatStandard {
    /// V/(m/s²).
    pub sensitivity: f64,
    /// Relative standard uncertainty: that of the calibration, and the spread of the modulus over the band.
    pub relative_uncertainty: f64,
    /// Half the distance of the largest and the smallest modulus over the middle between them.
    pub spread: f64,
    /// Frequencies of the calibration, Hz.
    pub range: [f64; 2],
    /// Up to where the pulse reaches from rest, Hz.
    pub wanted: f64,
    /// Whether the calibration covers that; an integral looks at the lowest frequencies, a top at those about 1/τ.
    pub covered: bool,
}

/// Frequencies at which the band is looked at.
const LOOKS: u32 = 200;

impl FlatStandard {
    /// Over the calibrated frequencies up to 2/τ, at which a half-sine of duration τ has a fifteenth of its spectrum at rest: the
    /// middle between the largest and the smallest modulus, half their distance as a rectangular uncertainty.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a calibration that begins above the band.
    pub fn of(standard: &ReferenceTable, duration: f64) -> Result<Self, Error> {
        let [first, last] = standard.range();
        let wanted = 2.0 / duration;
        let high = wanted.min(last);
        if high < first {
            return Err(Error::OutOfRange {
                name: "upper end of the band of the pulse in Hz",
                value: wanted,
                min: first,
                max: last,
            });
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
        Ok(Self {
            sensitivity,
            relative_uncertainty: u.hypot(spread / 3f64.sqrt()),
            spread,
            range: [first, last],
            wanted,
            covered: !(first > 0.1 / duration || last < wanted),
        })
    }
}

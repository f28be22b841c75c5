//! The certificate of the reference standard: sensitivity against frequency, between and never beyond its points.

use crate::frequency_response::FrequencyResponse;
use crate::monotone_cubic::{MonotoneCubic, interval};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Influence,
};
use serde::{Deserialize, Serialize};

/// One line of the certificate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferencePoint {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Sensitivity modulus in V/(m/s²).
    pub sensitivity: f64,
    /// Phase in radians.
    pub phase: f64,
    /// Relative standard uncertainty of the modulus.
    pub modulus_uncertainty: f64,
    /// Standard uncertainty of the phase in radians.
    pub phase_uncertainty: f64,
}

/// A certificate, in ascending frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceTable {
    points: Vec<ReferencePoint>,
}

impl ReferenceTable {
    /// Points in any order; frequencies must differ.
    ///
    /// # Errors
    /// [`Error::TooFew`] without a point, [`Error::NotFinite`], [`Error::OutOfRange`] for a frequency or a
    /// sensitivity that is not positive, or a frequency given twice.
    pub fn new(mut points: Vec<ReferencePoint>) -> Result<Self, Error> {
        if points.is_empty() {
            return Err(Error::TooFew {
                name: "reference table",
                needed: 1,
                got: 0,
            });
        }
        for (index, p) in points.iter().enumerate() {
            let numbers = [
                p.frequency,
                p.sensitivity,
                p.phase,
                p.modulus_uncertainty,
                p.phase_uncertainty,
            ];
            if numbers.iter().any(|v| !v.is_finite()) {
                return Err(Error::NotFinite {
                    name: "reference table",
                    index,
                });
            }
            for (name, value) in [
                ("frequency of the reference table", p.frequency),
                ("sensitivity of the reference table", p.sensitivity),
            ] {
                if value <= 0.0 {
                    return Err(Error::OutOfRange {
                        name,
                        value,
                        min: f64::MIN_POSITIVE,
                        max: f64::MAX,
                    });
                }
            }
        }
        points.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        if let Some(pair) = points.windows(2).find(|p| p[0].frequency == p[1].frequency) {
            return Err(Error::OutOfRange {
                name: "frequency given twice in the reference table",
                value: pair[1].frequency,
                min: pair[0].frequency,
                max: f64::MAX,
            });
        }
        Ok(Self { points })
    }

    /// The points.
    pub fn points(&self) -> &[ReferencePoint] {
        &self.points
    }

    /// Sensitivity at a frequency: monotone cubic in log f for modulus and phase (Fritsch–Carlson), uncertainty
    /// as the weighted sum of those of the two neighbours.
    ///
    /// Points of one certificate share most of their causes, so their uncertainties are taken as fully
    /// correlated: an interpolated value is never better known than its neighbours.
    ///
    /// **Source** `[FritschCarlson1980]`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] beyond the first and the last point: a certificate says nothing there.
    pub fn at(&self, frequency: f64) -> Result<ReferencePoint, Error> {
        let (first, last) = (self.points[0], self.points[self.points.len() - 1]);
        // A generator set to the last point may be read back with rounding.
        let slack = 1e-9;
        if !(frequency >= first.frequency * (1.0 - slack)
            && frequency <= last.frequency * (1.0 + slack))
        {
            return Err(Error::OutOfRange {
                name: "frequency for the reference table",
                value: frequency,
                min: first.frequency,
                max: last.frequency,
            });
        }
        if self.points.len() == 1 {
            return Ok(ReferencePoint { frequency, ..first });
        }
        let x: Vec<f64> = self.points.iter().map(|p| p.frequency.ln()).collect();
        let (k, t) = interval(&x, frequency.ln());
        let (a, b) = (self.points[k], self.points[k + 1]);
        let curve = |value: fn(&ReferencePoint) -> f64| {
            let y: Vec<f64> = self.points.iter().map(value).collect();
            MonotoneCubic::new(&x, &y).at(k, t)
        };
        Ok(ReferencePoint {
            frequency,
            sensitivity: curve(|p| p.sensitivity),
            phase: curve(|p| p.phase),
            modulus_uncertainty: (1.0 - t) * a.modulus_uncertainty + t * b.modulus_uncertainty,
            phase_uncertainty: (1.0 - t) * a.phase_uncertainty + t * b.phase_uncertainty,
        })
    }

    /// Acceleration behind a voltage of the reference, m/s²: V over S e^{jφ}.
    ///
    /// # Errors
    /// As [`ReferenceTable::at`].
    pub fn acceleration(&self, voltage: Complex64, frequency: f64) -> Result<Complex64, Error> {
        let p = self.at(frequency)?;
        Ok(voltage / Complex64::from_polar(p.sensitivity, p.phase))
    }
}

/// A certificate says nothing of the correlation of its lines.
impl TryFrom<&ReferenceTable> for FrequencyResponse {
    type Error = Error;

    fn try_from(table: &ReferenceTable) -> Result<Self, Error> {
        let polar = |p: &ReferencePoint| {
            let u = [p.sensitivity * p.modulus_uncertainty, p.phase_uncertainty];
            let influence = Influence {
                key: "certificate".to_owned(),
                description: "uncertainty of the certificate".to_owned(),
                evaluation: Evaluation::B,
                distribution: "normal".to_owned(),
                dof: DegreesOfFreedom::INFINITE,
                effect: Effect::Joint {
                    covariance: Covariance::from_standard_uncertainties(&u)?,
                },
            };
            let components = vec![
                Component::new("modulus", "V/(m/s²)", p.sensitivity),
                Component::new("phase", "rad", p.phase),
            ];
            Ok((p.frequency, Estimate::new(components, vec![influence])?))
        };
        let points = table
            .points
            .iter()
            .map(polar)
            .collect::<Result<Vec<_>, Error>>()?;
        let points: Vec<(f64, &Estimate)> = points.iter().map(|(f, e)| (*f, e)).collect();
        Self::from_polar("axis", &points, None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> ReferenceTable {
        let points =
            include_str!("../../../../reference/inrim-pcb356a15/reference-accelerometer.csv")
                .lines()
                .skip(1)
                .map(|l| {
                    let v: Vec<f64> = l.split(',').map(|f| f.parse().unwrap()).collect();
                    ReferencePoint {
                        frequency: v[0],
                        sensitivity: 1e-3 * v[2],
                        phase: 0.0,
                        modulus_uncertainty: v[3] / 200.0,
                        phase_uncertainty: 0.0,
                    }
                })
                .collect();
        ReferenceTable::new(points).unwrap()
    }

    #[test]
    fn published_points_are_returned_and_the_curve_is_monotone_between() {
        let t = table();
        assert!((t.at(160.0).unwrap().sensitivity - 9.914e-3).abs() < 1e-15);
        assert!((t.at(160.0).unwrap().modulus_uncertainty - 0.002).abs() < 1e-15);
        let mut last = f64::INFINITY;
        for i in 0..=100 {
            let f = 160.0 * (315f64 / 160.0).powf(f64::from(i) / 100.0);
            let s = t.at(f).unwrap().sensitivity;
            assert!(s <= last && (9.879e-3 - 1e-12..=9.914e-3 + 1e-12).contains(&s));
            last = s;
        }
    }

    #[test]
    fn refuses_frequencies_the_table_does_not_reach() {
        // The published certificate starts at 10 Hz; the published plan at 5 Hz.
        assert!(matches!(
            table().at(5.0),
            Err(Error::OutOfRange { value: 5.0, .. })
        ));
        assert!(table().at(5000.0).is_ok() && table().at(5001.0).is_err());
    }
}

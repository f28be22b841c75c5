//! A check standard: a device of known sensitivity, measured with every campaign, that tells whether the bench is as it was.

use super::single_axis::SingleAxis;
use crate::findings;
use proofmass_core::Error;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_uncertainty::{Finding, normal_quantile};

/// Probability at which a campaign on a sound bench is told to be off.
pub const FALSE_ALARM_RATE: f64 = 0.01;

/// The check standard at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CheckPoint {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Sensitivity as it is known, output per m/s².
    pub known: f64,
    /// Sensitivity as measured.
    pub measured: f64,
    /// Departure of the modulus, relative.
    pub modulus: f64,
    /// Its standard uncertainty: known and measured together.
    pub modulus_uncertainty: f64,
    /// Departure of the phase, rad.
    pub phase: f64,
    /// Its standard uncertainty.
    pub phase_uncertainty: f64,
}

impl CheckPoint {
    /// E_n of modulus and phase with k = 2; `None` without any uncertainty.
    ///
    /// **Source** `[ISO13528]` 9.7.
    pub fn e_n(&self) -> [Option<f64>; 2] {
        let of = |d: f64, u: f64| (u > 0.0).then(|| d / (2.0 * u));
        [
            of(self.modulus, self.modulus_uncertainty),
            of(self.phase, self.phase_uncertainty),
        ]
    }
}

/// The measured check standard against what is known of it, at the frequencies that its calibration reaches, and whether one
/// departure is larger than chance makes the largest of all in one campaign of a hundred.
///
/// # Errors
/// [`Error::OutOfRange`] when the calibration reaches none of the frequencies.
pub fn against_known(
    measured: &[SingleAxis],
    known: &ReferenceTable,
) -> Result<(Vec<CheckPoint>, Vec<Finding>), Error> {
    let mut points = Vec::with_capacity(measured.len());
    let (mut missed, mut beyond) = (None, vec![]);
    for result in measured {
        let certificate = match known.at(result.frequency) {
            Ok(certificate) => certificate,
            Err(e) => {
                missed = Some(e);
                beyond.push(format!("{} Hz", result.frequency));
                continue;
            }
        };
        let (Some(m), Some(p)) = (result.estimate.get("modulus"), result.estimate.get("phase"))
        else {
            continue;
        };
        let turn = std::f64::consts::TAU;
        let apart = p.value - certificate.phase;
        points.push(CheckPoint {
            frequency: result.frequency,
            known: certificate.sensitivity,
            measured: m.value,
            modulus: m.value / certificate.sensitivity - 1.0,
            modulus_uncertainty: (m.standard_uncertainty / m.value)
                .hypot(certificate.modulus_uncertainty),
            phase: apart - turn * (apart / turn).round(),
            phase_uncertainty: p.standard_uncertainty.hypot(certificate.phase_uncertainty),
        });
    }
    if points.is_empty() {
        return Err(missed.unwrap_or(Error::TooFew {
            name: "runs of the check standard",
            needed: 1,
            got: 0,
        }));
    }
    let tests = 2.0 * points.len() as f64;
    let limit = normal_quantile(1.0 - 0.5 * FALSE_ALARM_RATE / tests);
    let size = |p: &CheckPoint| {
        let of = |d: f64, u: f64| if u > 0.0 { (d / u).abs() } else { 0.0 };
        of(p.modulus, p.modulus_uncertainty).max(of(p.phase, p.phase_uncertainty))
    };
    let worst = points.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
    let finding = worst.filter(|p| size(p) > limit).map(|p| {
        findings::not_as_calibrated(
            "the check standard",
            ", so the bench is in doubt for every device of this campaign",
            &format!(
                "{} Hz: {:+.3} % (u = {:.3} %), {:+.3}° (u = {:.3}°)",
                p.frequency,
                100.0 * p.modulus,
                100.0 * p.modulus_uncertainty,
                p.phase.to_degrees(),
                p.phase_uncertainty.to_degrees()
            ),
        )
    });
    let partial =
        (!beyond.is_empty()).then(|| findings::check_standard_partial(&beyond.join(", ")));
    Ok((points, finding.into_iter().chain(partial).collect()))
}

#[cfg(test)]
mod tests {
    use super::super::single_axis::{ComparisonBudget, ComparisonRow, combine, compare};
    use super::*;
    use num_complex::Complex64;
    use proofmass_dynamic::reference_table::ReferencePoint;
    use proofmass_uncertainty::DegreesOfFreedom;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn point(frequency: f64, sensitivity: f64, phase: f64) -> ReferencePoint {
        ReferencePoint {
            frequency,
            sensitivity,
            phase,
            modulus_uncertainty: 0.001,
            phase_uncertainty: 0.001,
        }
    }

    #[test]
    fn known_false_alarm_rate_and_power_of_a_check_standard() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let frequencies: Vec<f64> = (0..10).map(|k| 20.0 * 1.5f64.powi(k)).collect();
        let budget = ComparisonBudget {
            ratio: 0.001,
            phase: 0.001,
            dof: DegreesOfFreedom::INFINITE,
            transverse: None,
            front_end: 0.0,
            free_phase: false,
        };
        let mut told = [0; 2];
        let campaigns = 2000;
        for off in [0usize, 1] {
            for _ in 0..campaigns {
                let known: Vec<ReferencePoint> = frequencies
                    .iter()
                    .map(|f| point(*f, 0.01 * (1.0 + 0.001 * draw()), 0.001 * draw()))
                    .collect();
                let known = ReferenceTable::new(known).unwrap();
                let rows: Vec<ComparisonRow> = frequencies
                    .iter()
                    .map(|f| ComparisonRow {
                        run: f.to_string(),
                        frequency: *f,
                        reference: Complex64::new(10.0, 0.0),
                        output: Complex64::from_polar(
                            0.1 * (1.0 + 0.001 * draw() + 0.01 * off as f64),
                            0.001 * draw(),
                        ),
                        transverse: Some(0.0),
                        covariance: [[0.0; 3]; 2],
                    })
                    .collect();
                let (single, _) = compare(&rows, None, "V/(m/s²)", &budget).unwrap();
                let (means, _) = combine(&rows, &single, &budget).unwrap();
                let (points, findings) = against_known(&means, &known).unwrap();
                assert_eq!(points.len(), 10);
                told[off] += i32::from(!findings.is_empty());
            }
        }
        // 1 % of 2000, four standard deviations; 1 % off against u = 0.14 % is always told.
        assert!(told[0] <= 38, "{told:?}");
        assert_eq!(told[1], campaigns);
    }

    #[test]
    fn law_only_frequencies_that_are_known_are_checked() {
        let budget = ComparisonBudget {
            ratio: 0.001,
            phase: 0.001,
            dof: DegreesOfFreedom::INFINITE,
            transverse: None,
            front_end: 0.0,
            free_phase: false,
        };
        let row = |frequency: f64| ComparisonRow {
            run: "a".into(),
            frequency,
            reference: Complex64::new(10.0, 0.0),
            output: Complex64::from_polar(0.1, -3.0),
            transverse: None,
            covariance: [[0.0; 3]; 2],
        };
        let rows = [row(160.0), row(5000.0)];
        let (single, _) = compare(&rows, None, "V/(m/s²)", &budget).unwrap();
        // The phase is compared on the circle.
        let known =
            ReferenceTable::new(vec![point(160.0, 0.01, std::f64::consts::TAU - 3.0)]).unwrap();
        let (points, findings) = against_known(&single, &known).unwrap();
        assert_eq!(points.len(), 1);
        assert!(points[0].phase.abs() < 1e-9);
        // That 5 kHz was not checked is said.
        assert_eq!(findings.len(), 1);
        assert_eq!(findings[0].code(), "check-standard-partial");
        let elsewhere = ReferenceTable::new(vec![point(20.0, 0.01, 0.0)]).unwrap();
        assert!(against_known(&single, &elsewhere).is_err());
    }
}

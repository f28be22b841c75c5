//! Comparison of a single-axis accelerometer with a reference: the n = 1 case of the bench.

use super::reference::ReferenceTable;
use faer::c64;
use proofmass_core::Error;
use proofmass_uncertainty::{
    Component, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence, Severity,
};

/// One run of a comparison, phasors in volts.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonRow {
    /// Name of the run.
    pub run: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Output of the reference, V.
    pub reference: c64,
    /// Output of the device, V.
    pub output: c64,
    /// Transverse motion relative to the motion along the axis, where it was measured.
    pub transverse: Option<f64>,
}

/// Standard uncertainties of a comparison beside those of the certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComparisonBudget {
    /// Relative, of the ratio of the two outputs.
    pub ratio: f64,
    /// Of its phase, radians.
    pub phase: f64,
    /// Degrees of freedom of these two.
    pub dof: f64,
}

/// Sensitivity at one frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct SingleAxis {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Complex sensitivity, V/(m/s²).
    pub sensitivity: c64,
    /// Components `modulus` (V/(m/s²)) and `phase` (rad) with the influences `reference.calibration` and
    /// `reading`.
    pub estimate: Estimate,
}

/// Largest transverse motion the standard admits, relative: 10 % up to 1 kHz, 30 % above.
///
/// **Source** `[ISO16063-21]` 4.4.
pub fn transverse_limit(frequency: f64) -> f64 {
    if frequency <= 1000.0 { 0.10 } else { 0.30 }
}

/// S₂ = (X₂/X₁) S₁, φ₂ = φ₂,₁ + φ₁, run by run, with the limits of the standard checked.
///
/// **Source** `[ISO16063-21]` 3.
///
/// # Errors
/// [`Error::OutOfRange`] for a frequency the certificate does not reach or a reference without signal.
pub fn compare(
    rows: &[ComparisonRow],
    table: &ReferenceTable,
    budget: &ComparisonBudget,
) -> Result<(Vec<SingleAxis>, Vec<Finding>), Error> {
    let mut results = vec![];
    let mut findings = vec![];
    for (index, row) in rows.iter().enumerate() {
        let certificate = table.at(row.frequency)?;
        if !(row.reference.norm() > 0.0) {
            return Err(Error::NotFinite {
                name: "output over reference",
                index,
            });
        }
        let reference = c64::from_polar(certificate.sensitivity, certificate.phase);
        let sensitivity = row.output / row.reference * reference;
        let modulus = sensitivity.norm();
        let influence = |key: &str,
                         description: &str,
                         evaluation,
                         dof,
                         u: [f64; 2]|
         -> Result<Influence, Error> {
            Ok(Influence {
                key: key.to_owned(),
                description: description.to_owned(),
                evaluation,
                distribution: "normal".to_owned(),
                dof,
                effect: Effect::Joint {
                    covariance: proofmass_uncertainty::Covariance::from_standard_uncertainties(&u)?,
                },
            })
        };
        let estimate = Estimate::new(
            vec![
                Component::new("modulus", "V/(m/s²)", modulus),
                Component::new("phase", "rad", sensitivity.arg()),
            ],
            vec![
                influence(
                    "reference.calibration",
                    "calibration of the reference standard",
                    Evaluation::B,
                    DegreesOfFreedom::INFINITE,
                    [
                        modulus * certificate.modulus_uncertainty,
                        certificate.phase_uncertainty,
                    ],
                )?,
                influence(
                    "reading",
                    "ratio of the two outputs",
                    Evaluation::A,
                    DegreesOfFreedom::new(budget.dof).unwrap_or(DegreesOfFreedom::INFINITE),
                    [modulus * budget.ratio, budget.phase],
                )?,
            ],
        )?;
        let limit = transverse_limit(row.frequency);
        match row.transverse {
            Some(t) if t > limit => findings.push(
                Finding::new(
                    Severity::Warning,
                    "transverse-motion",
                    format!(
                        "run {}: the transverse motion exceeds the limit of ISO 16063-21",
                        row.run
                    ),
                )
                .evidence(format!(
                    "{:.1} % at {} Hz, {:.0} % admitted",
                    100.0 * t,
                    row.frequency,
                    100.0 * limit
                ))
                .advice("balance the load, change the fixture, or leave the frequency out"),
            ),
            Some(_) => {}
            None => findings.push(
                Finding::new(
                    Severity::Note,
                    "transverse-motion-unknown",
                    format!("run {}: the transverse motion was not measured", row.run),
                )
                .evidence(format!("{} Hz", row.frequency))
                .advice("ISO 16063-21 asks for it to be known"),
            ),
        }
        results.push(SingleAxis {
            frequency: row.frequency,
            sensitivity,
            estimate,
        });
    }
    Ok((results, findings))
}

#[cfg(test)]
mod tests {
    use super::super::reference::ReferencePoint;
    use super::*;

    #[test]
    fn law_modulus_and_phase_of_a_comparison() {
        let table = ReferenceTable::new(vec![ReferencePoint {
            frequency: 160.0,
            sensitivity: 0.01,
            phase: 0.02,
            modulus_uncertainty: 0.002,
            phase_uncertainty: 0.001,
        }])
        .unwrap();
        let row = ComparisonRow {
            run: "a".into(),
            frequency: 160.0,
            reference: c64::from_polar(0.1, 0.5),
            output: c64::from_polar(0.2, 0.8),
            transverse: Some(0.12),
        };
        let budget = ComparisonBudget {
            ratio: 0.0015,
            phase: 0.002,
            dof: 20.0,
        };
        let (results, findings) = compare(&[row], &table, &budget).unwrap();
        let e = &results[0].estimate;
        assert!((e.get("modulus").unwrap().value - 0.02).abs() < 1e-15);
        assert!((e.get("phase").unwrap().value - 0.32).abs() < 1e-12);
        // √(0.2² + 0.15²) % = 0.25 %.
        assert!((e.get("modulus").unwrap().standard_uncertainty / 0.02 - 0.0025).abs() < 1e-12);
        assert_eq!(findings[0].code(), "transverse-motion");
    }
}

//! Comparison of a single-axis accelerometer with a reference: the n = 1 case of the bench.

use crate::copied_readings::{Reading, copies};
use crate::departing::{DeclaredReading, doubts};
use crate::findings;
use crate::phase_units::phase_units;
use crate::repeated_runs::{MeanOfRuns, by_frequency, unrepeated};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_dynamic::reference_table::ReferenceTable;
use proofmass_signal::transfer::turned;
use proofmass_uncertainty::chi_squared_chance;
use proofmass_uncertainty::{
    Component, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
};
use serde::{Deserialize, Serialize};

/// One run of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonRow {
    /// Name of the run.
    pub run: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Output of the reference in volts, or the acceleration itself in m/s².
    pub reference: Complex64,
    /// Output of the device, in its own unit.
    pub output: Complex64,
    /// Transverse motion relative to the motion along the axis, where it was measured.
    pub transverse: Option<f64>,
    /// Covariance rr, ri, ii of the two phasors, reference first, by the noise of their recording or as a table states it; zero where
    /// nothing is known of it.
    pub covariance: [[f64; 3]; 2],
}

impl ComparisonRow {
    /// Standard uncertainties by that noise of the ratio of the two: relative of its modulus, and of its phase in radians.
    pub fn noise(&self) -> [f64; 2] {
        let of = |z: Complex64, v| match z.norm() > 0.0 {
            true => turned(v, z.inv()),
            false => [0.0; 3],
        };
        let [x, y] = [
            of(self.reference, self.covariance[0]),
            of(self.output, self.covariance[1]),
        ];
        [0, 2].map(|i| (x[i] + y[i]).max(0.0).sqrt())
    }
}

/// Standard uncertainties of a comparison beside those of the certificate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ComparisonBudget {
    /// Relative, of the ratio of the two outputs.
    pub ratio: f64,
    /// Of its phase, radians.
    pub phase: f64,
    /// Degrees of freedom of these two.
    pub dof: DegreesOfFreedom,
    /// The transverse sensitivity of the device and the transverse motion of the table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transverse: Option<TransverseMotion>,
    /// Standard uncertainty of the delay between the two channels of the front end, s.
    #[serde(default)]
    pub front_end: f64,
    /// Whether the device samples by a clock of its own: then nothing is known of the phase, and the modulus alone is
    /// stated.
    #[serde(default)]
    pub free_phase: bool,
}

/// What a motion of the table across its axis does to a device that is sensitive across its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TransverseMotion {
    /// Transverse sensitivity of the device relative to that along its axis.
    pub sensitivity: f64,
    /// Largest transverse motion relative to that along the axis, where a run does not tell its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest: Option<f64>,
}

impl TransverseMotion {
    /// Standard uncertainty of modulus (relative) and phase (rad) of a sensitivity: T q cos β with the angle β between the
    /// motion and the direction of the largest transverse sensitivity anywhere, which is T q/√2 for a motion q that was
    /// measured, and T q/√6 for one that is only known not to exceed q. The motion may be in phase or in quadrature, so that it
    /// stands in full for each. `None` where nothing is known of the motion.
    ///
    /// **Source** `[ISO16063-21]` annex A.
    pub fn uncertainty(&self, measured: Option<f64>) -> Option<f64> {
        match (measured, self.largest) {
            (Some(q), _) => Some(self.sensitivity * q * std::f64::consts::FRAC_1_SQRT_2),
            (None, Some(q)) => Some(self.sensitivity * q / 6f64.sqrt()),
            (None, None) => None,
        }
    }
}

/// Sensitivity at one frequency.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SingleAxis {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Complex sensitivity, output per m/s².
    pub sensitivity: Complex64,
    /// Components `modulus` (output per m/s²) and, where it is known, `phase` (rad) with the influences `reference.calibration`, `reference.interpolation` between
    /// two points of the certificate, `reading`, `noise` of a single run or `repeatability` of several, and, where it was stated, `transverse`.
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
/// Without a certificate the reference is an acceleration, and what it is worth is all in the reading. `unit` is that of the
/// sensitivity.
///
/// **Source** `[ISO16063-21]` 3.
///
/// # Errors
/// [`Error::OutOfRange`] for a frequency the certificate does not reach or a reference without signal.
pub fn compare(
    rows: &[ComparisonRow],
    table: Option<&ReferenceTable>,
    unit: &str,
    budget: &ComparisonBudget,
) -> Result<(Vec<SingleAxis>, Vec<Finding>), Error> {
    let mut results = vec![];
    let mut findings = vec![];
    let mut unknown = 0;
    for (index, row) in rows.iter().enumerate() {
        let certificate = table.map(|t| t.at(row.frequency)).transpose()?;
        if !(row.reference.norm() > 0.0) {
            return Err(Error::NotFinite {
                name: "output over reference",
                index,
            });
        }
        let reference = certificate.map_or(Complex64::ONE, |c| {
            Complex64::from_polar(c.sensitivity, c.phase)
        });
        let mut sensitivity = row.output / row.reference * reference;
        let modulus = sensitivity.norm();
        if budget.free_phase {
            sensitivity = Complex64::new(modulus, 0.0);
        }
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
        let mut influences = Vec::with_capacity(5);
        if let Some(c) = certificate {
            let between = table.map_or([0.0; 2], |t| t.interpolation_at(row.frequency));
            let [u, v] = [
                (c.modulus_uncertainty, between[0]),
                (c.phase_uncertainty, between[1]),
            ]
            .map(|(whole, between)| (whole * whole - between * between).max(0.0).sqrt());
            influences.push(influence(
                "reference.calibration",
                "calibration of the reference standard",
                Evaluation::B,
                DegreesOfFreedom::INFINITE,
                [modulus * u, v],
            )?);
            if between[0].max(between[1]) > 0.0 {
                influences.push(influence(
                    "reference.interpolation",
                    "curve of the reference between two points of its certificate",
                    Evaluation::B,
                    DegreesOfFreedom::INFINITE,
                    [modulus * between[0], between[1]],
                )?);
            }
        }
        influences.push(influence(
            "reading",
            "ratio of the two outputs",
            Evaluation::A,
            budget.dof,
            [modulus * budget.ratio, budget.phase],
        )?);
        let [ratio, phase] = row.noise();
        if ratio.max(phase) > 0.0 {
            influences.push(influence(
                NOISE,
                "noise of the recordings of the run",
                Evaluation::A,
                DegreesOfFreedom::INFINITE,
                [modulus * ratio, phase],
            )?);
        }
        if budget.front_end > 0.0 {
            influences.push(influence(
                "front_end.delay",
                "delay between the channels of the front end",
                Evaluation::B,
                DegreesOfFreedom::INFINITE,
                [
                    0.0,
                    std::f64::consts::TAU * row.frequency * budget.front_end,
                ],
            )?);
        }
        let across = budget
            .transverse
            .and_then(|t| t.uncertainty(row.transverse));
        if let Some(u) = across {
            influences.push(influence(
                "transverse",
                "transverse sensitivity of the device, with the transverse motion of the table",
                Evaluation::B,
                DegreesOfFreedom::INFINITE,
                [modulus * u, u],
            )?);
        }
        let estimate = Estimate::new(
            vec![
                Component::new("modulus", unit, modulus),
                Component::new("phase", "rad", sensitivity.arg()),
            ],
            influences,
        )?;
        let estimate = without_phase(estimate, budget)?;
        let limit = transverse_limit(row.frequency);
        match row.transverse {
            Some(t) if t > limit => findings.push(findings::transverse_motion(
                &row.run,
                100.0 * t,
                row.frequency,
                100.0 * limit,
            )),
            Some(_) => {}
            None if across.is_some() => {}
            None => unknown += 1,
        }
        results.push(SingleAxis {
            frequency: row.frequency,
            sensitivity,
            estimate,
        });
    }
    if !budget.free_phase {
        findings.extend(phase_units(rows));
    }
    if unknown > 0 {
        findings.push(findings::transverse_motion_unknown(unknown, rows.len()));
    }
    Ok((results, findings))
}

/// Key of the noise of one run.
const NOISE: &str = "noise";

/// The modulus alone, where the phase is that of another clock.
fn without_phase(estimate: Estimate, budget: &ComparisonBudget) -> Result<Estimate, Error> {
    if !budget.free_phase {
        return Ok(estimate);
    }
    let modulus = estimate.components()[..1].to_vec();
    estimate.propagate(modulus, &[1.0, 0.0])
}

/// Mean over the runs of each frequency, in ascending frequency; a frequency of one run stays as it is.
///
/// The mean is of the complex sensitivities. Certificate and reading are common to the repeats and stay; the
/// scatter adds the influences `repeatability` of the modulus and of the phase after [`Repeats::mean_of`](proofmass_uncertainty::Repeats::mean_of), whose declared noise is that of
/// the recordings.
///
/// Repeats that are copies are findings, a run that is no repeat of the others, and a scatter beyond the declared uncertainty of a reading and that noise (χ² with 2 (n − 1) degrees of freedom).
///
/// # Errors
/// As [`Estimate::new`].
pub fn combine(
    rows: &[ComparisonRow],
    results: &[SingleAxis],
    budget: &ComparisonBudget,
) -> Result<(Vec<SingleAxis>, Vec<Finding>), Error> {
    let mut means = vec![];
    let groups = by_frequency(results);
    let mut findings: Vec<Finding> = unrepeated(&groups).into_iter().collect();
    let frequencies = groups.len();
    for group in groups {
        let of_one: Vec<&SingleAxis> = group.iter().map(|&i| &results[i]).collect();
        if let [one] = of_one[..] {
            means.push(one.clone());
            continue;
        }
        let readings = group.iter().map(|&i| &rows[i]);
        let readings =
            readings.map(|r| Reading::new(&r.run, r.frequency, &[r.reference, r.output]));
        findings.extend(copies(&readings.collect::<Vec<_>>()));
        let n = group.len() as f64;
        // The noise of one run, root mean square: what the recordings say of it.
        let noise: [f64; 2] = std::array::from_fn(|p| {
            let squares = group.iter().map(|&i| rows[i].noise()[p].powi(2));
            (squares.sum::<f64>() / n).sqrt()
        });
        // Certificate and reading are relative.
        let mean = MeanOfRuns::of(&of_one, &[NOISE], (noise, DegreesOfFreedom::INFINITE))?;
        let turned = &mean.departures;
        let names: Vec<&str> = group.iter().map(|&i| rows[i].run.as_str()).collect();
        let values: Vec<Complex64> = of_one.iter().map(|r| r.sensitivity).collect();
        let declared = DeclaredReading {
            one: [budget.ratio.hypot(noise[0]), budget.phase.hypot(noise[1])],
            dof: budget.dof,
            free_phase: budget.free_phase,
        };
        let about = doubts(
            &names,
            mean.result.frequency,
            &values,
            &declared,
            frequencies,
        );
        let told = !about.is_empty();
        findings.extend(about);
        if !told && budget.ratio > 0.0 && budget.phase > 0.0 {
            let one = declared.one;
            let of = |d: &[f64; 2]| (d[0] / one[0]).powi(2) + (d[1] / one[1]).powi(2);
            let statistic = turned.iter().map(of).sum::<f64>();
            let parts = if budget.free_phase { 1.0 } else { 2.0 };
            let dof = parts * (n - 1.0);
            if chi_squared_chance(statistic, dof) < 1e-4 {
                let worst = (0..group.len())
                    .max_by(|&a, &b| of(&turned[a]).total_cmp(&of(&turned[b])))
                    .unwrap_or(0);
                findings.push(findings::scatter_exceeds_reading(
                    mean.result.frequency,
                    group.len(),
                    (statistic / dof).sqrt(),
                    &rows[group[worst]].run,
                    100.0 * turned[worst][0],
                    turned[worst][1].to_degrees(),
                ));
            }
        }
        means.push(mean.result);
    }
    Ok((means, findings))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_dynamic::reference_table::ReferencePoint;

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
            reference: Complex64::from_polar(0.1, 0.5),
            output: Complex64::from_polar(0.2, 0.8),
            transverse: Some(0.12),
            covariance: [[0.0; 3]; 2],
        };
        let budget = ComparisonBudget {
            ratio: 0.0015,
            phase: 0.002,
            dof: DegreesOfFreedom::new(20.0).unwrap(),
            transverse: None,
            front_end: 0.0,
            free_phase: false,
        };
        let (results, findings) = compare(&[row], Some(&table), "V/(m/s²)", &budget).unwrap();
        let e = &results[0].estimate;
        assert!((e.get("modulus").unwrap().value - 0.02).abs() < 1e-15);
        assert!((e.get("phase").unwrap().value - 0.32).abs() < 1e-12);
        // √(0.2² + 0.15²) % = 0.25 %.
        assert!((e.get("modulus").unwrap().standard_uncertainty / 0.02 - 0.0025).abs() < 1e-12);
        assert_eq!(findings[0].code(), "transverse-motion");
    }

    #[test]
    fn known_share_of_the_transverse_motion() {
        let row = |transverse: Option<f64>| ComparisonRow {
            run: "a".into(),
            frequency: 160.0,
            reference: Complex64::new(10.0, 0.0),
            output: Complex64::new(10.2, 0.0),
            transverse,
            covariance: [[0.0; 3]; 2],
        };
        let budget = ComparisonBudget {
            ratio: 0.003,
            phase: 0.003,
            dof: DegreesOfFreedom::INFINITE,
            transverse: Some(TransverseMotion {
                sensitivity: 0.05,
                largest: Some(0.1),
            }),
            front_end: 0.0,
            free_phase: false,
        };
        // An acceleration for reference, an acceleration from the device: no certificate, no volts.
        let u = |transverse| -> f64 {
            let (results, findings) =
                compare(&[row(transverse)], None, "(m/s²)/(m/s²)", &budget).unwrap();
            assert!(findings.is_empty());
            // Who says nothing of it at all is told so.
            let silent = ComparisonBudget {
                transverse: None,
                ..budget
            };
            let (_, findings) = compare(&[row(None)], None, "(m/s²)/(m/s²)", &silent).unwrap();
            assert_eq!(findings[0].code(), "transverse-motion-unknown");
            let q = results[0].estimate.get("modulus").unwrap();
            assert!((q.value - 1.02).abs() < 1e-15 && q.unit == "(m/s²)/(m/s²)");
            q.standard_uncertainty / q.value
        };
        // Measured, 8 %: 0.05 · 0.08/√2; not measured: 0.05 · 0.1/√6.
        assert!((u(Some(0.08)) - (9e-6 + 8e-6_f64).sqrt()).abs() < 1e-12);
        assert!((u(None) - (9e-6 + 25e-6 / 6.0_f64).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn law_the_mean_of_repeats_has_their_scatter() {
        let table = ReferenceTable::new(vec![ReferencePoint {
            frequency: 160.0,
            sensitivity: 0.01,
            phase: 0.0,
            modulus_uncertainty: 0.002,
            phase_uncertainty: 0.001,
        }])
        .unwrap();
        let row = |run: &str, modulus: f64, phase: f64| ComparisonRow {
            run: run.into(),
            frequency: 160.0,
            reference: Complex64::from_polar(0.1, 3.0),
            output: Complex64::from_polar(0.2 * modulus, 3.0 + phase),
            transverse: Some(0.01),
            covariance: [[0.0; 3]; 2],
        };
        let rows = [
            row("a", 0.999, 0.0),
            row("b", 1.0, 0.0),
            row("c", 1.001, 0.0),
        ];
        let budget = ComparisonBudget {
            ratio: 0.001,
            phase: 0.001,
            dof: DegreesOfFreedom::INFINITE,
            transverse: None,
            front_end: 0.0,
            free_phase: false,
        };
        let (results, _) = compare(&rows, Some(&table), "V/(m/s²)", &budget).unwrap();
        let (means, findings) = combine(&rows, &results, &budget).unwrap();
        assert!(means.len() == 1 && findings.is_empty());
        let q = means[0].estimate.get("modulus").unwrap();
        // s = 0.1 %, n = 3: √(0.2² + 0.1² + 0.1²/3) %.
        let u = (0.2f64.powi(2) + 0.01 + 0.01 / 3.0).sqrt() / 100.0;
        assert!((q.standard_uncertainty / q.value / u - 1.0).abs() < 1e-9);
        // A run that is turned by 2° is named.
        let rows = [
            row("a", 0.9999, 0.0),
            row("b", 1.0, 0.0),
            row("turned", 1.0, 0.035),
        ];
        let (results, _) = compare(&rows, Some(&table), "V/(m/s²)", &budget).unwrap();
        let (_, findings) = combine(&rows, &results, &budget).unwrap();
        assert_eq!(findings[0].code(), "scatter-exceeds-reading");
        assert!(findings[0].evidence_text().contains("run turned"));
    }

    /// Three runs at each of two frequencies, of which one was read with another gain or with the polarity reversed.
    #[test]
    fn known_run_that_is_no_repeat_is_named_with_its_factor() {
        let budget = ComparisonBudget {
            ratio: 0.001,
            phase: 0.001,
            dof: DegreesOfFreedom::INFINITE,
            transverse: None,
            front_end: 0.0,
            free_phase: false,
        };
        let told = |factor: f64, runs: usize, budget: &ComparisonBudget| {
            let mut rows = Vec::new();
            for (f, frequency) in [80.0, 160.0].into_iter().enumerate() {
                for k in 0..runs {
                    let off = 1.0 + 2e-4 * (k as f64 - 1.0);
                    rows.push(ComparisonRow {
                        run: format!("{f}{k}"),
                        frequency,
                        reference: Complex64::new(10.0, 0.0),
                        output: Complex64::from_polar(0.1 * off, 1e-4 * k as f64),
                        transverse: None,
                        covariance: [[0.0; 3]; 2],
                    });
                }
            }
            let last = rows.len() - 1;
            rows[last.min(runs + 1)].output *= factor;
            let (results, _) = compare(&rows, None, "V/(m/s²)", budget).unwrap();
            combine(&rows, &results, budget).unwrap().1
        };
        assert!(told(1.0, 3, &budget).is_empty());
        for (factor, words) in [
            (10.0, "10.0 times"),
            (0.1, "0.100 times"),
            (1.2, "1.200 times"),
            (-1.0, "turned by"),
        ] {
            let found = told(factor, 3, &budget);
            assert_eq!((found.len(), found[0].code()), (1, "no-repeat"));
            let what = found[0].what();
            assert!(
                what.starts_with("run 11 is no repeat") && what.contains(words),
                "{what}"
            );
        }
        let free = ComparisonBudget {
            free_phase: true,
            ..budget
        };
        assert_eq!(told(10.0, 3, &free)[0].code(), "no-repeat");
        assert_eq!(told(10.0, 2, &budget)[0].code(), "repeats-apart");
        assert_eq!(told(1.0, 1, &budget)[0].code(), "repeatability-unseen");
    }
}
